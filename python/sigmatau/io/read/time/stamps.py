"""Sampling rate and grid from time stamps, which may be coarse, bunched, in any unit, and wrong in places."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau import units
from sigmatau.arrays import median
from sigmatau.errors import OptionError, StampError
from sigmatau.findings.finding import Finding
from sigmatau.findings.rates import RateChange, RateDrift, RateMismatch, RateNotNominal
from sigmatau.findings.spans import longest_spans
from sigmatau.findings.stamps import CoarseStamps, Gap, Gaps, HostStamps, IrregularStamps, LongPauses
from sigmatau.hints import RATE, Hint
from sigmatau.io.read.time.clock_line import GridFit, rate_change
from sigmatau.io.read.time.grid import fit_grid, resolution
from sigmatau.io.read.time.rows import Rows
from sigmatau.io.read.time.stated_rate import RateContradiction
from sigmatau.record.sampling import GIVEN, RateSource
from sigmatau.record.streams import PLAUSIBLE_RATES, InputKind

_FREQUENT = 100.0  # rate near which most logs are: the unit of what is closer to it is offered first [Hz]
_PRESENT_TIMES = (6e8, 4e9)  # years 1989 to 2096, counted from 1970. [s]
_LARGEST_START = 1e8  # 3 years: stamps beyond it count from an epoch, whole seconds are subtracted. [s]

# Relative difference up to which two rates are taken as equal: twice the resulting error of a random walk
_EQUAL_RATES = 1e-3
_NOMINAL_RATES = (1.0, 1.25, 2.0, 2.5, 4.0, 5.0, 8.0, 10.0)  # times a power of ten: rates that datasheets state. [Hz]
_NEAR_NOMINAL = (
    0.02  # relative difference up to which the nominal rate may have been meant: RC oscillators are within 2 %
)
# The range of ten equal rates is 3.1 ± 0.8 standard errors: more than 8 once in 1e7 records.
_DRIFT_ERRORS = 8.0
_DRIFT_INFO, _DRIFT_WARNING = 1e-4, 1e-3  # relative range of the rate; coefficients are off by up to half of it
_RATE_ERROR_WARNING = 1e-2  # relative error of the rate; a random walk is off by half of it
_LISTED_GAPS = 3
_FEW_LOST = 1e-3  # share of the samples, and of the record for the longest gap, up to which gaps are no warning

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
    measured: float | None = None  # By the time stamps, or stated by the file; None if neither has one. [Hz]
    second: float | None = None  # One unit of the stamps; None without stamps, or if their unit is not known. [s]
    # Time of the first sample; without whole seconds if the stamps count from an epoch. [s]
    start: float = 0.0
    source: RateSource = GIVEN
    rows: NDArray[np.int64] | None = None  # Rows of the table in use, in order; None for all
    places: NDArray[np.int64] | None = None  # Places of the rows on the grid; None if no place is empty
    n: int | None = None  # Places; None without stamps
    jitter: float | None = None  # Standard deviation of the stamps about the grid. [s]
    step: float = 0.0  # Resolution of their clock; 0 if they show none. [s]
    on_grid: bool = False  # Whether the stamps lie on a grid, so that lost samples are visible
    is_regular: bool = False  # Whether the stamps show a rate: they have steps, and no more pauses than can be cut out
    stride: int = 0  # From one stamp to the next, if they may be the numbers of the samples
    contradiction: RateContradiction | None = None  # The given rate against that of the log, if they contradict
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
    stated = 1 / (rate * second) if rate and second else None
    grid = fit_grid(t, used.intervals, step, given=stated)
    if grid.bound == math.inf and rate is None:
        single = " (the resolution of single precision)" if _is_single_precision(used, step) else ""
        raise StampError(
            f"stamps in column {name} have two values only, {stamps[0]} and {stamps[-1]}{single}, which give no upper limit"
            f" of the rate of {grid.n} samples; give {RATE}, or write the stamps with all their digits"
        )
    has_unit = second is not None
    if second is None:
        second = 1 / (rate * grid.interval) if rate else 1.0
    tau0 = grid.interval * second
    if not 1e-200 < tau0 < 1e200:
        raise StampError(f"stamps in column {name} give an interval of {tau0:.3g} s, which is not usable; give {RATE}")

    def place(k: int) -> str:
        return where(k if used.rows is None else int(used.rows[k]))

    start, notes = _start(stamps[grid.start], second)
    lost = grid.n - (grid.stop - grid.start)
    source = RateSource(kind="time stamps", place=name, lost=lost)
    rows = used.rows
    if grid.start > 0 or grid.stop < len(stamps):
        rows = (np.arange(len(stamps)) if rows is None else rows)[grid.start : grid.stop]
    return Timing(
        rate=1.0 / tau0,
        second=second if has_unit else None,
        start=start,
        source=source,
        jitter=grid.jitter * second,
        step=step * second,
        on_grid=grid.kind == "grid" and grid.pieces > 0,
        is_regular=grid.pieces > 0 and grid.bound < math.inf,
        rows=rows,
        places=grid.places,
        n=grid.n,
        notes=notes,
        findings=(
            *used.findings,
            *_pauses(grid, used, second, place),
            *_resolution_or_host(grid, used, second, step),
            *(_rate_change(grid, used, second, place) or (*_gaps(grid, second, place), *_rate_drift(grid, tau0))),
            *(_rate_not_nominal(1.0 / tau0, grid) if has_unit and rate is None else ()),
        ),
    )


def _start(stamp: Any, second: float) -> tuple[float, tuple[str, ...]]:  # noqa: ANN401
    first = int(stamp) if isinstance(stamp, np.integer) else float(stamp)
    start = first * second
    if abs(start) < _LARGEST_START:
        return start, ()
    if second > 1:
        return start % 1, (f"{start // 1:.0f} s taken off the time stamps",)
    ticks = round(1 / second)
    whole, rest = divmod(first, ticks)
    return float(rest) * second, (f"{int(whole)} s taken off the time stamps",)


def mismatch(given: float, other: float, kind: InputKind = "rate", *, stated: bool = False) -> tuple[Finding, ...]:
    """A finding if the rate that was given is not that of the stamps, or not that which the file states."""
    ratio = given / other
    if abs(1 / ratio - 1) <= _EQUAL_RATES:
        return ()
    power_of_kind = 0.0 if kind == "rate" else 1.0
    factors = tuple(
        (term, ratio ** (power + power_of_kind)) for term, power in _POWERS.items() if power + power_of_kind
    )
    details = RateMismatch(used=given, other=other, stated=stated)
    return (Finding(details=details, severity="warning", size=ratio - 1, factors=factors),)


def without_unit(stamps: NDArray[Any], intervals: NDArray[np.float64], name: str) -> OptionError:
    """An error that asks for the unit of the stamps and lists the rate that each unit gives."""
    mean = float(intervals.sum()) / len(intervals)
    offers = [
        [(symbol, 1 / (mean * units.find(symbol).factor)) for symbol in symbols]
        for symbols in (("s", "ms", "us", "ns"), ("min", "h", "d"))
    ]
    possible = [[row for row in rows if PLAUSIBLE_RATES[0] <= row[1] <= PLAUSIBLE_RATES[1]] for rows in offers]
    likely = possible[0] or possible[1] or offers[0]
    offered = ", ".join(f"as {symbol} {float(f'{rate:.4g}'):g} Hz" for symbol, rate in likely)
    # A clock that counts from 1970 shows a present year in one unit only.
    first = float(stamps[0])
    dated = [
        (unit, rate)
        for unit, rate in likely
        if rate >= 1 and _PRESENT_TIMES[0] <= first * units.find(unit).factor <= _PRESENT_TIMES[1]
    ]
    ordered = sorted(dated or likely, key=lambda row: abs(math.log(row[1] / _FREQUENT)))
    ways = [f"{Hint('unit', 'time', symbol)}" for symbol, _ in ordered]
    *others, last = [*ways, str(RATE)]
    return OptionError(
        f"the unit of the time stamps in column {name} is not stated ({stamps[0]}, {stamps[1]} …: {offered});"
        f" give {', '.join(others)} or {last}",
        option="unit",
    )


def _gaps(
    found: GridFit, second: float, place: Callable[[int], str], *, few_lost: float = _FEW_LOST
) -> tuple[Finding, ...]:
    """A finding about the empty places of the grid; a warning if more than the share `few_lost` is missing."""
    if found.places is None:
        return ()
    holes = np.diff(found.places) - 1
    places = np.flatnonzero(holes)
    lost = int(holes.sum())
    tau0 = found.interval * second
    longest = tuple(
        Gap(
            samples=int(holes[k]),
            start=float(found.places[k] + 1) * tau0,
            length=float(holes[k]) * tau0,
            place=place(found.start + int(k) + 1),
        )
        for k in places[np.argsort(-holes[places], kind="stable")][:_LISTED_GAPS]
    )
    starts = (found.places[places] + 1) * tau0
    spans, more_spans = longest_spans(starts, starts + holes[places] * tau0)
    even_rate = None
    if found.period:
        even_rate = found.period / (float(found.places[found.period] - found.places[0]) * tau0)
    details = Gaps(
        samples=found.n,
        gaps=len(places),
        longest=longest,
        rate=1 / tau0,
        estimated=found.kind == "host",
        period=found.period,
        even_rate=even_rate,
    )
    return (
        Finding(
            details=details,
            severity="info" if max(lost, longest[0].samples) <= few_lost * found.n else "warning",
            spans=spans,
            more_spans=more_spans,
            size=lost,
        ),
    )


def _pauses(found: GridFit, used: Rows, second: float, place: Callable[[int], str]) -> tuple[Finding, ...]:
    """A finding about pauses that are cut out, or about more pauses than can be cut out."""
    if found.pieces == 1:
        return ()
    row = int(np.argmax(used.intervals))
    longest = float(used.intervals[row]) * second
    behind = place(row + 1)
    if not found.pieces:
        irregular = IrregularStamps(interval=found.interval * second, longest=longest, place=behind)
        return (Finding(details=irregular, severity="warning", size=longest, unit="s"),)
    details = LongPauses(
        pauses=found.pieces - 1,
        longest=longest,
        place=behind,
        used=found.stop - found.start,
        total=len(used.stamps),
    )
    return (Finding(details=details, severity="warning", size=longest, unit="s"),)


def _resolution_or_host(found: GridFit, used: Rows, second: float, step: float) -> tuple[Finding, ...]:
    """A finding about a clock of low resolution, or about stamps that a host made in bunches."""
    rate = 1 / (found.interval * second)
    if found.kind == "grid" and found.places is None and found.period:
        lost = round(found.interval * found.period / step) - found.period
        details = CoarseStamps(step=step * second, rate=rate, period=found.period + lost, lost=lost)
        return (Finding(details=details, severity="info", size=step * second, unit="s"),)
    if found.kind == "grid" or not found.pieces:
        return ()
    if found.kind == "coarse":
        single = _is_single_precision(used, step)
        details = CoarseStamps(
            step=step * second,
            rate=rate,
            rate_error=None if found.bound == math.inf else found.bound,  # infinite only if the rate is given
            hidden=max(round(step / found.interval), 1) + 1,
            single_precision=single,
        )
        severe = found.bound > _RATE_ERROR_WARNING or single
        return (Finding(details=details, severity="warning" if severe else "info", size=step * second, unit="s"),)
    host = HostStamps(rate=rate, median_rate=1 / (found.median * second) if found.median > 0 else None)
    return (Finding(details=host, severity="warning", size=found.short),)


def _is_single_precision(used: Rows, step: float) -> bool:
    """Whether the step of the clock is the resolution of single-precision numbers as large as the stamps."""
    last = float(np.abs(used.stamps[-1]))
    return step >= 1 and last < float(np.finfo(np.float32).max) and float(np.spacing(np.float32(last))) == step


def _rate_change(found: GridFit, used: Rows, second: float, place: Callable[[int], str]) -> tuple[Finding, ...]:
    """A finding of an abrupt change of the rate, with those of the gaps if there are longer ones than it makes."""
    change = rate_change(used.intervals)
    if change is None or found.pieces != 1:
        return ()
    at, before, after = change
    told = rate_changed(
        at=float(used.stamps[at] - used.stamps[0]) * second,
        end=float(used.stamps[-1] - used.stamps[0]) * second,
        details=RateChange(
            before=1 / (before * second),
            after=1 / (after * second),
            grid=1 / (found.interval * second),
            place=place(at),
        ),
        empty=found.places is not None,
    )
    longest = 1 if found.places is None else int(np.diff(found.places).max())
    gaps = () if longest <= round(max(before, after) / found.interval) else _gaps(found, second, place)
    return (told, *gaps)


def rate_changed(*, at: float, end: float, details: RateChange, empty: bool) -> Finding:
    """A finding of a change of the rate at the time `at` of a log that ends at `end` [s]. Where places are left `empty`, the
    coefficients allow for it; else they are those of a mixture.
    """
    ratio = max(details.before, details.after) / min(details.before, details.after)
    factors = () if empty else (("random_walk", math.sqrt(ratio)),)
    return Finding(details=details, severity="warning", spans=((at, end),), size=ratio, factors=factors)


def later(finding: Finding, by: float) -> Finding:
    """A finding about stamps of a sensor that begins so many seconds after the whole record."""
    details = finding.details
    if by == 0:
        return finding
    if isinstance(details, Gaps):
        details = replace(details, longest=tuple(replace(gap, start=gap.start + by) for gap in details.longest))
    return replace(finding, details=details, spans=tuple((start + by, stop + by) for start, stop in finding.spans))


def _rate_drift(found: GridFit, tau0: float, *, least: float = _DRIFT_INFO) -> tuple[Finding, ...]:
    """A finding if the mean rates of ten equal parts differ significantly, and relatively by at least `least`."""
    change = found.drift
    if change is None or change.size < max(least, _DRIFT_ERRORS * change.error):
        return ()
    part = found.n * tau0 / len(change.rates)
    start = int(np.argmax(np.abs(change.rates - median(change.rates)))) * part
    return (
        Finding(
            details=RateDrift(
                lowest=float(1 + change.rates.min()) / tau0, highest=float(1 + change.rates.max()) / tau0
            ),
            severity="warning" if change.size > _DRIFT_WARNING else "info",
            spans=((start, start + part),),
            size=change.size,
        ),
    )


def _rate_not_nominal(rate: float, found: GridFit) -> tuple[Finding, ...]:
    """A finding if the rate is close to a nominal rate, and significantly different from it."""
    power = 10.0 ** math.floor(math.log10(rate))
    nominal = min((m * power for m in _NOMINAL_RATES), key=lambda stated: abs(rate / stated - 1))
    off = rate / nominal - 1
    if not max(_EQUAL_RATES, 5 * found.error / found.interval) < abs(off) < _NEAR_NOMINAL:
        return ()
    return (Finding(details=RateNotNominal(rate=rate, nominal=nominal), severity="info", size=off),)
