"""The sampling rate and the grid, from time stamps that may be coarse, bunched, in any unit, and now and then wrong."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau import units
from sigmatau.errors import DataError, OptionError
from sigmatau.findings.finding import Finding
from sigmatau.io.read.time import stamp_findings
from sigmatau.io.read.time.grid import fit_grid, resolution
from sigmatau.io.read.time.rows import Rows
from sigmatau.record.streams import PLAUSIBLE_RATES, InputKind

__all__ = ["Fit", "fit", "mismatch", "without_unit"]

_AGREE = 1e-3  # relative difference of two rates that are the same
_OURS = (6e8, 4e9)  # 1989 to 2096, counted from 1970. [s]
_EPOCH = 1e8  # a clock beyond this counts from long ago. [s]

# Powers of (given / true rate) by which coefficients of rates grow: all are of the form (coefficient²) = avar·τ^(−2·slope),
# and the averaging times are too short by that factor. Increments are divided by an interval that is too short as well.
_POWERS = {
    "quantization": -1.0,
    "random_walk": -0.5,
    "bias_instability": 0.0,
    "rate_random_walk": 0.5,
    "rate_ramp": 1.0,
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Fit:
    """What the stamps say.

    Attributes
    ----------
    rate : float
        Sampling rate. [Hz]
    start : float
        First stamp that is used, whole seconds taken off if it counts from long ago. [s]
    source : str
        How the rate was found, in words.
    jitter : float
        Standard deviation of the stamps about their grid. [s]
    step : float
        Step of the clock; 0 if it is none that is seen. [s]
    on_grid : bool
        Whether the stamps sit on a grid, so that lost samples have been seen.
    rows : ndarray of int64, or None
        Rows of the table that are used, in order; None for all.
    places : ndarray of int64, or None
        Their places on the grid; None if no place is empty.
    n : int
        Places.
    notes : tuple of str
    findings : tuple of Finding
    """

    rate: float
    start: float
    source: str
    jitter: float
    step: float
    on_grid: bool
    rows: NDArray[np.int64] | None
    places: NDArray[np.int64] | None
    n: int
    notes: tuple[str, ...]
    findings: tuple[Finding, ...]


def fit(used: Rows, second: float | None, where: Callable[[int], str], name: str, *, rate: float | None = None) -> Fit:
    """The grid and the sampling rate that the stamps say, see `sigmatau.io.read.time.grid`.

    Parameters
    ----------
    used : Rows
        From `sigmatau.io.read.time.rows.in_order`.
    second : float or None
        One unit of the stamps. [s] None if it is not known: then `rate` says it.
    where : callable
        Place of a row in the file, for the messages.
    name : str
        The column, as messages name it.
    rate : float, optional
        Sampling rate that was given. [Hz]

    Raises
    ------
    DataError
        If the stamps span no time that can be counted.
    """
    stamps = used.stamps
    with np.errstate(over="ignore"):
        t = (stamps - stamps[0]).astype(np.float64, copy=False)
    if not np.isfinite(t[-1]):
        raise DataError(f"stamps in column {name} are too far apart: {stamps[0]} to {stamps[-1]}")
    # Neighbours as well: a pattern of rows may look even at every so many.
    some = np.concatenate((np.diff(stamps[:2048]), np.diff(stamps[:: max(len(stamps) // 4096, 1)])))
    step = resolution(some, float(max(abs(stamps[0]), abs(stamps[-1]))))
    given = 1 / (rate * second) if rate and second else None
    found = fit_grid(t, used.intervals, step, given=given)
    if found.bound == math.inf and rate is None:
        raise DataError(
            f"stamps in column {name} have two values only, {stamps[0]} and {stamps[-1]}: of the rate they say no more than"
            f" that {found.n} samples make one step{stamp_findings.of_single_precision(used, step)}; give --rate HZ, or"
            " write them with all their digits"
        )
    known = second is not None
    if second is None:
        second = 1 / (rate * found.interval) if rate else 1.0
    tau0 = found.interval * second
    if not 1e-200 < tau0 < 1e200:
        raise DataError(f"stamps in column {name} say an interval of {tau0:.3g} s, which is none; give --rate HZ")

    def place(k: int) -> str:
        return where(k if used.rows is None else int(used.rows[k]))

    start, notes = _start(stamps[found.start], second)
    lost = found.n - (found.stop - found.start)
    source = f"time stamps in column {name}" + (f", {lost} lost samples left empty" if lost else "")
    rows = used.rows
    if found.start > 0 or found.stop < len(stamps):
        rows = (np.arange(len(stamps)) if rows is None else rows)[found.start : found.stop]
    return Fit(
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
            *(stamp_findings.implausible(1.0 / tau0) if known else ()),
            *stamp_findings.pauses(found, used, second, place),
            *stamp_findings.gaps(found, second, place),
            *stamp_findings.host(found, used, second, step, place),
            *stamp_findings.drift(found, tau0),
            *(stamp_findings.not_round(1.0 / tau0, found) if known and rate is None else ()),
        ),
    )


def _start(stamp: Any, second: float) -> tuple[float, tuple[str, ...]]:  # noqa: ANN401
    first = int(stamp) if isinstance(stamp, np.integer) else float(stamp)
    start = first * second
    if abs(start) < _EPOCH:
        return start, ()
    ticks = round(1 / second) if second < 1 else 1
    whole, rest = divmod(first, ticks) if second <= 1 else (0, first)
    return float(rest) * second, (f"{int(whole)} s taken off the time stamps",)


def mismatch(given: float, found: Fit, kind: InputKind = "rate") -> tuple[Finding, ...]:
    """A finding if the rate that was given is not that of the stamps."""
    ratio = given / found.rate
    if abs(1 / ratio - 1) <= _AGREE:
        return ()
    more = 0.0 if kind == "rate" else 1.0
    changes = tuple((term, ratio ** (power + more)) for term, power in _POWERS.items() if power + more)
    return (
        Finding(
            code="rate_mismatch",
            severity="warning",
            message=f"the rate given is {given:.6g} Hz, the time stamps say {found.rate:.6g} Hz",
            size=ratio - 1,
            effect=(
                "the given rate is used; if that of the stamps is true, averaging times are too"
                f" {'short' if ratio > 1 else 'long'} by a factor of {max(ratio, 1 / ratio):.4g}, and one gets "
                + ", ".join(f"{term.replace('_', ' ')} × {factor:.4g}" for term, factor in changes)
            ),
            changes=changes,
            remedy="leave --rate out, unless it is known better than by the stamps",
        ),
    )


def without_unit(stamps: NDArray[Any], intervals: NDArray[np.float64], name: str) -> OptionError:
    """The question for the unit of the stamps, with the rate that each unit would make."""
    mean = float(intervals.sum()) / len(intervals)
    rates = [(symbol, 1 / (mean * units.find(symbol).factor)) for symbol in ("s", "ms", "us", "ns")]
    likely = [(symbol, rate) for symbol, rate in rates if PLAUSIBLE_RATES[0] <= rate <= PLAUSIBLE_RATES[1]] or rates
    offered = ", ".join(f"as {symbol} {float(f'{rate:.4g}'):g} Hz" for symbol, rate in likely)
    # A clock that counts from 1970 has one unit in which it shows a year of our time; else a rate near 100 Hz is likeliest.
    first = float(stamps[0])
    example = min(
        likely,
        key=lambda row: (not _OURS[0] <= first * units.find(row[0]).factor <= _OURS[1], abs(math.log(row[1] / 100))),
    )
    return OptionError(
        f"the unit of the time stamps in column {name} is not stated ({stamps[0]}, {stamps[1]} …: {offered});"
        f" say e.g. --unit time={example[0]}, or give --rate HZ",
        option="unit",
    )
