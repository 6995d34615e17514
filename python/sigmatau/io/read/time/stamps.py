"""Sampling rate and grid from time stamps, which may be coarse, bunched, in any unit, and wrong in places."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau import units
from sigmatau.errors import OptionError, StampError
from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.stamps import RateMismatch
from sigmatau.io.read.time import stamp_findings
from sigmatau.io.read.time.grid import fit_grid, resolution
from sigmatau.io.read.time.rows import Rows
from sigmatau.io.read.time.stamp_findings import EQUAL_RATES
from sigmatau.record.streams import PLAUSIBLE_RATES, InputKind

_PRESENT_TIMES = (6e8, 4e9)  # years 1989 to 2096, counted from 1970. [s]
_LARGEST_START = 1e8  # 3 years: stamps beyond it count from an epoch, whole seconds are subtracted. [s]

# Powers of (given / true rate) in the factors on coefficients of rates. All have the form coefficient² = avar·τ^(−2·slope),
# and a rate that is too high makes the averaging times too short by the ratio. Increments are divided by an interval that
# is too short as well, which adds 1.
_POWERS = {
    "quantization": -1.0,
    "random_walk": -0.5,
    "bias_instability": 0.0,
    "rate_random_walk": 0.5,
    "rate_ramp": 1.0,
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Timing:
    """Sampling times of a stream."""

    rate: float  # Sampling rate. [Hz]
    # Time of the first sample; without whole seconds if the stamps count from an epoch. [s]
    start: float = 0.0
    source: str = "given"  # How the rate was found, in words
    rows: NDArray[np.int64] | None = None  # Rows of the table in use, in order; None for all
    places: NDArray[np.int64] | None = None  # Places of the rows on the grid; None if no place is empty
    n: int | None = None  # Places; None without stamps
    jitter: float | None = None  # Standard deviation of the stamps about the grid. [s]
    step: float = 0.0  # Resolution of their clock; 0 if they show none. [s]
    on_grid: bool = False  # Whether the stamps lie on a grid, so that lost samples are visible
    notes: tuple[str, ...] = ()
    findings: tuple[Finding, ...] = ()

    def laid(self, column: NDArray[Any]) -> NDArray[Any]:
        """A column of the table on this grid, NaN in empty places; the array itself if nothing changes."""
        if self.rows is not None:
            column = column[self.rows]
        if self.places is None or self.n is None:
            return column
        grid = np.full(self.n, np.nan)
        grid[self.places] = column
        return grid


def fit(
    used: Rows, second: float | None, where: Callable[[int], str], name: str, *, rate: float | None = None
) -> Timing:
    """Grid and sampling rate by the stamps, see `sigmatau.io.read.time.grid`. `second`: one unit of the stamps; if
    None, it follows from `rate` [s]; `where`: place of a row in the file, for the messages; `name`: the column, as
    messages name it; `rate`: sampling rate given by the user [Hz].
    """
    stamps = used.stamps
    with np.errstate(over="ignore"):
        t = (stamps - stamps[0]).astype(np.float64, copy=False)
    if not np.isfinite(t[-1]):
        raise StampError(f"stamps in column {name} are too far apart: {stamps[0]} to {stamps[-1]}")
    # Consecutive rows as well: rows at a regular stride may hide a pattern.
    some = np.concatenate((np.diff(stamps[:2048]), np.diff(stamps[:: max(len(stamps) // 4096, 1)])))
    step = resolution(some, float(max(abs(stamps[0]), abs(stamps[-1]))))
    given = 1 / (rate * second) if rate and second else None
    found = fit_grid(t, used.intervals, step, given=given)
    if found.bound == math.inf and rate is None:
        single = " (the resolution of single precision)" if stamp_findings.is_single_precision(used, step) else ""
        raise StampError(
            f"stamps in column {name} have two values only, {stamps[0]} and {stamps[-1]}{single}, which give no upper limit"
            f" of the rate of {found.n} samples; give --rate HZ, or write the stamps with all their digits"
        )
    known = second is not None
    if second is None:
        second = 1 / (rate * found.interval) if rate else 1.0
    tau0 = found.interval * second
    if not 1e-200 < tau0 < 1e200:
        raise StampError(
            f"stamps in column {name} give an interval of {tau0:.3g} s, which is not usable; give --rate HZ"
        )

    def place(k: int) -> str:
        return where(k if used.rows is None else int(used.rows[k]))

    start, notes = _start(stamps[found.start], second)
    lost = found.n - (found.stop - found.start)
    source = f"time stamps in column {name}" + (f", {lost} lost samples left empty" if lost else "")
    rows = used.rows
    if found.start > 0 or found.stop < len(stamps):
        rows = (np.arange(len(stamps)) if rows is None else rows)[found.start : found.stop]
    return Timing(
        rate=1.0 / tau0,
        start=start,
        source=source,
        jitter=found.jitter * second,
        step=step * second,
        on_grid=found.kind == "grid" and found.pieces > 0,
        rows=rows,
        places=found.places,
        n=found.n,
        notes=notes,
        findings=(
            *used.findings,
            *(stamp_findings.implausible_rate(1.0 / tau0) if known else ()),
            *stamp_findings.pauses(found, used, second, place),
            *stamp_findings.gaps(found, second, place),
            *stamp_findings.resolution_or_host(found, used, second, step),
            *stamp_findings.rate_drift(found, tau0),
            *(stamp_findings.rate_not_nominal(1.0 / tau0, found) if known and rate is None else ()),
        ),
    )


def _start(stamp: Any, second: float) -> tuple[float, tuple[str, ...]]:  # noqa: ANN401
    first = int(stamp) if isinstance(stamp, np.integer) else float(stamp)
    start = first * second
    if abs(start) < _LARGEST_START:
        return start, ()
    ticks = round(1 / second) if second < 1 else 1
    whole, rest = divmod(first, ticks) if second <= 1 else (0, first)
    return float(rest) * second, (f"{int(whole)} s taken off the time stamps",)


def mismatch(given: float, other: float, kind: InputKind = "rate", *, stated: bool = False) -> tuple[Finding, ...]:
    """A finding if the rate that was given is not that of the stamps, or not that which the file states."""
    ratio = given / other
    if abs(1 / ratio - 1) <= EQUAL_RATES:
        return ()
    more = 0.0 if kind == "rate" else 1.0
    factors = tuple((term, ratio ** (power + more)) for term, power in _POWERS.items() if power + more)
    details = RateMismatch(used=given, other=other, stated=stated)
    return (Finding(details=details, severity="warning", size=ratio - 1, factors=factors),)


def without_unit(stamps: NDArray[Any], intervals: NDArray[np.float64], name: str) -> OptionError:
    """An error that asks for the unit of the stamps and lists the rate that each unit gives."""
    mean = float(intervals.sum()) / len(intervals)
    rates = [(symbol, 1 / (mean * units.find(symbol).factor)) for symbol in ("s", "ms", "us", "ns")]
    likely = [(symbol, rate) for symbol, rate in rates if PLAUSIBLE_RATES[0] <= rate <= PLAUSIBLE_RATES[1]] or rates
    offered = ", ".join(f"as {symbol} {float(f'{rate:.4g}'):g} Hz" for symbol, rate in likely)
    # A clock that counts from 1970 shows a present year in one unit only; otherwise a rate near 100 Hz is the most likely.
    first = float(stamps[0])
    example = min(
        likely,
        key=lambda row: (
            not _PRESENT_TIMES[0] <= first * units.find(row[0]).factor <= _PRESENT_TIMES[1],
            abs(math.log(row[1] / 100)),
        ),
    )
    return OptionError(
        f"the unit of the time stamps in column {name} is not stated ({stamps[0]}, {stamps[1]} …: {offered});"
        f" give e.g. --unit time={example[0]}, or --rate HZ",
        option="unit",
    )
