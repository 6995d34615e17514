"""Sampling rate and grid of time stamps, which may be coarse, bunched, in any unit, and partly wrong."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.arrays import median
from sigmatau.errors import StampError
from sigmatau.findings.finding import Finding
from sigmatau.findings.rates import RateChange, RateDrift, RateMismatch, RateNotNominal
from sigmatau.findings.spans import longest_spans
from sigmatau.findings.stamps import CoarseStamps, Gap, Gaps, HostStamps, IrregularStamps, LongPauses
from sigmatau.frozen import frozen
from sigmatau.hints import RATE
from sigmatau.io.read.time.clock_line import GridFit, rate_change
from sigmatau.io.read.time.grid import fit_grid, resolution
from sigmatau.io.read.time.plausible import RateContradiction
from sigmatau.io.read.time.rows import OrderedRows
from sigmatau.noise.terms import TERMS
from sigmatau.record.sampling import GIVEN_RATE, RateSource
from sigmatau.record.streams import InputKind

_LARGEST_START = 1e8  # stamps beyond 3 years count from an epoch; whole seconds are subtracted [s]

# Range of stamps that count from 1970: July 2017 to 2096. Seconds of GPS, which count from 1980, are below until 2027. [s]
_EPOCH_FROM, _EPOCH_TO = 1.5e9, 4e9

# relative difference up to which two rates count as equal: twice the resulting error of a random walk
_EQUAL_RATES = 1e-3
_NOMINAL_RATES = (1.0, 1.25, 2.0, 2.5, 4.0, 5.0, 8.0, 10.0)  # rates that datasheets state, times a power of ten [Hz]
# relative difference up to which the nominal rate may have been meant: RC oscillators are within 2 %
_NEAR_NOMINAL = 0.02
# The range of ten equal rates is 3.1 ± 0.8 standard errors: more than 8 once in 1e7 records.
_DRIFT_ERRORS = 8.0
# Relative range of the rate from which a finding reports it; coefficients are wrong by up to half of it.
_DRIFT_INFO = 1e-4
_DRIFT_WARNING = 1e-3
_RATE_ERROR_WARNING = 1e-2  # relative error of the rate; a random walk is wrong by half of it
_LISTED_GAPS = 3
_FEW_LOST = 1e-3  # share of missing samples, and of the record in the longest gap, up to which gaps are not a warning

# Exponents of (given / true rate) in the factors on coefficients of rates. All have the form coefficient² =
# avar·τ^(−2·slope), and a rate that is too high shortens the averaging times by the ratio. Increments are also divided
# by too short an interval, which adds 1.
_POWERS = {name: term.slope for name, term in TERMS.items()}


@frozen
class Timing:
    """Sampling times of a stream."""

    rate: float  # Sampling rate. [Hz]
    measured: float | None = None  # Rate from the time stamps, or stated by the file; None if neither exists. [Hz]
    second: float | None = None  # One unit of the stamps; None without stamps, or if their unit is not known. [s]
    # Time of the first sample; without whole seconds if the stamps count from an epoch. [s]
    start: float = 0.0
    epoch: float = 0.0  # Whole seconds that were subtracted. [s]
    source: RateSource = GIVEN_RATE
    rows: NDArray[np.int64] | None = None  # Rows of the table in use, in order; None for all
    places: NDArray[np.int64] | None = None  # Places of the rows on the grid; None if no place is empty
    n: int | None = None  # Places; None without stamps
    jitter: float | None = None  # Standard deviation of the stamps about the grid. [s]
    step: float = 0.0  # Resolution of the clock of the stamps; 0 if they show none. [s]
    on_grid: bool = False  # Whether the stamps lie on a grid, so that lost samples are visible
    # whether the stamps show a rate: they increase, and have few enough pauses to cut out
    is_regular: bool = False
    stride: int = 0  # Step from one stamp to the next, if the stamps may be sample numbers
    contradiction: RateContradiction | None = None  # The given rate and that of the log, if they contradict each other
    notes: tuple[str, ...] = ()
    findings: tuple[Finding, ...] = ()
    begun: float | None = None  # Time of the first sample from 1970; None if the stamps do not count from it. [s]

    def put_on_grid(self, column: NDArray[Any]) -> NDArray[Any]:
        """Put a column of the table on this grid, with NaN in empty places. An unchanged array is returned as it is."""
        if self.rows is not None:
            column = column[self.rows]
        if self.places is None or self.n is None:
            return column
        grid = np.full(self.n, np.nan)
        grid[self.places] = column
        return grid


def fit(
    used: OrderedRows, second: float | None, where: Callable[[int], str], name: str, *, rate: float | None = None
) -> Timing:
    """Fit grid and sampling rate to the stamps, see `sigmatau.io.read.time.grid`.

    `second`: one unit of the stamps; if None, it follows from `rate` [s]; `where`: place of a row in the file, for the
    messages; `name`: the column, as messages name it; `rate`: sampling rate given by the user [Hz].
    """
    stamps = used.stamps
    with np.errstate(over="ignore"):
        t = (stamps - stamps[0]).astype(np.float64, copy=False)
    if not np.isfinite(t[-1]):
        raise StampError(f"stamps in column {name} are too far apart: {stamps[0]} to {stamps[-1]}")
    # Consecutive rows are used too: rows at a regular stride may hide a pattern.
    some = np.concatenate((np.diff(stamps[:2048]), np.diff(stamps[:: max(len(stamps) // 4096, 1)])))
    step = resolution(some, float(max(abs(stamps[0]), abs(stamps[-1]))))
    stated = 1 / (rate * second) if rate and second else None
    grid = fit_grid(t, used.intervals, step, stated_interval=stated)
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

    start, epoch, notes = _start(stamps[grid.start], second)
    lost = grid.n - (grid.stop - grid.start)
    source = RateSource(kind="time stamps", place=name, lost=lost)
    rows = used.rows
    if grid.start > 0 or grid.stop < len(stamps):
        rows = (np.arange(len(stamps)) if rows is None else rows)[grid.start : grid.stop]
    absolute = float(stamps[grid.start]) * second
    return Timing(
        begun=absolute if has_unit and _EPOCH_FROM < absolute < _EPOCH_TO else None,
        rate=1.0 / tau0,
        second=second if has_unit else None,
        start=start,
        epoch=epoch,
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


def _start(stamp: Any, second: float) -> tuple[float, float, tuple[str, ...]]:  # noqa: ANN401
    first = int(stamp) if isinstance(stamp, np.integer) else float(stamp)
    start = first * second
    if abs(start) < _LARGEST_START:
        return start, 0.0, ()
    if second > 1:
        return start % 1, start // 1, (f"{start // 1:.0f} s subtracted from the time stamps",)
    ticks = round(1 / second)
    whole, rest = divmod(first, ticks)
    return float(rest) * second, float(whole), (f"{int(whole)} s subtracted from the time stamps",)


def mismatch(rate: float, reference: float, kind: InputKind = "rate", *, stated: bool = False) -> tuple[Finding, ...]:
    """A finding if the given rate differs from that of the stamps or from that stated by the file."""
    ratio = rate / reference
    if abs(1 / ratio - 1) <= _EQUAL_RATES:
        return ()
    power_of_kind = 0.0 if kind == "rate" else 1.0
    factors = tuple(
        (term, ratio ** (power + power_of_kind)) for term, power in _POWERS.items() if power + power_of_kind
    )
    details = RateMismatch(used=rate, other=reference, stated=stated)
    return (Finding(details=details, severity="warning", size=ratio - 1, factors=factors),)


def _gaps(
    grid: GridFit,
    second: float,
    place: Callable[[int], str],
) -> tuple[Finding, ...]:
    """A finding about the empty places of the grid; a warning if more than 0.1 % of the samples are missing."""
    if grid.places is None:
        return ()
    holes = np.diff(grid.places) - 1
    places = np.flatnonzero(holes)
    lost = int(holes.sum())
    tau0 = grid.interval * second
    longest = tuple(
        Gap(
            samples=int(holes[k]),
            start=float(grid.places[k] + 1) * tau0,
            length=float(holes[k]) * tau0,
            place=place(grid.start + int(k) + 1),
        )
        for k in places[np.argsort(-holes[places], kind="stable")][:_LISTED_GAPS]
    )
    starts = (grid.places[places] + 1) * tau0
    spans, more_spans = longest_spans(starts, starts + holes[places] * tau0)
    even_rate = None
    if grid.period:
        even_rate = grid.period / (float(grid.places[grid.period] - grid.places[0]) * tau0)
    details = Gaps(
        samples=grid.n,
        gaps=len(places),
        longest=longest,
        rate=1 / tau0,
        estimated=grid.kind == "host",
        period=grid.period,
        even_rate=even_rate,
    )
    return (
        Finding(
            details=details,
            severity="info" if max(lost, longest[0].samples) <= _FEW_LOST * grid.n else "warning",
            spans=spans,
            more_spans=more_spans,
            size=lost,
        ),
    )


def _pauses(grid: GridFit, used: OrderedRows, second: float, place: Callable[[int], str]) -> tuple[Finding, ...]:
    """A finding about pauses that are cut out, or about too many pauses to cut out."""
    if grid.pieces == 1:
        return ()
    row = int(np.argmax(used.intervals))
    longest = float(used.intervals[row]) * second
    behind = place(row + 1)
    if not grid.pieces:
        irregular = IrregularStamps(interval=grid.interval * second, longest=longest, place=behind)
        return (Finding(details=irregular, severity="warning", size=longest, unit="s"),)
    details = LongPauses(
        pauses=grid.pieces - 1,
        longest=longest,
        place=behind,
        used=grid.stop - grid.start,
        total=len(used.stamps),
    )
    return (Finding(details=details, severity="warning", size=longest, unit="s"),)


def _resolution_or_host(grid: GridFit, used: OrderedRows, second: float, step: float) -> tuple[Finding, ...]:
    """A finding about a clock of low resolution, or about stamps that a host made in bunches."""
    rate = 1 / (grid.interval * second)
    if grid.kind == "grid" and grid.places is None and grid.period:
        lost = round(grid.interval * grid.period / step) - grid.period
        details = CoarseStamps(step=step * second, rate=rate, period=grid.period + lost, lost=lost)
        return (Finding(details=details, severity="info", size=step * second, unit="s"),)
    if grid.kind == "grid" or not grid.pieces:
        return ()
    if grid.kind == "coarse":
        single = _is_single_precision(used, step)
        details = CoarseStamps(
            step=step * second,
            rate=rate,
            rate_error=None if grid.bound == math.inf else grid.bound,  # infinite only if the rate is given
            hidden=max(round(step / grid.interval), 1) + 1,
            single_precision=single,
        )
        severe = grid.bound > _RATE_ERROR_WARNING or single
        return (Finding(details=details, severity="warning" if severe else "info", size=step * second, unit="s"),)
    host = HostStamps(rate=rate, median_rate=1 / (grid.median * second) if grid.median > 0 else None)
    return (Finding(details=host, severity="warning", size=grid.short),)


def _is_single_precision(used: OrderedRows, step: float) -> bool:
    """Whether the step of the clock is the resolution of single-precision numbers as large as the stamps."""
    last = float(np.abs(used.stamps[-1]))
    return step >= 1 and last < float(np.finfo(np.float32).max) and float(np.spacing(np.float32(last))) == step


def _rate_change(grid: GridFit, used: OrderedRows, second: float, place: Callable[[int], str]) -> tuple[Finding, ...]:
    """A finding about an abrupt change of the rate. The gaps are included if some are too long to result from the
    change.
    """
    change = rate_change(used.intervals)
    if change is None or grid.pieces != 1:
        return ()
    row, before, after = change
    finding = rate_changed(
        time=float(used.stamps[row] - used.stamps[0]) * second,
        end=float(used.stamps[-1] - used.stamps[0]) * second,
        details=RateChange(
            before=1 / (before * second),
            after=1 / (after * second),
            grid=1 / (grid.interval * second),
            place=place(row),
        ),
        empty=grid.places is not None,
    )
    longest = 1 if grid.places is None else int(np.diff(grid.places).max())
    gaps = () if longest <= round(max(before, after) / grid.interval) else _gaps(grid, second, place)
    return (finding, *gaps)


def rate_changed(*, time: float, end: float, details: RateChange, empty: bool) -> Finding:
    """A finding about a change of the rate at `time` in a log that ends at `end` [s].

    If places are left `empty`, the coefficients allow for the change; else they belong to a mixture.
    """
    ratio = max(details.before, details.after) / min(details.before, details.after)
    factors = () if empty else (("random_walk", math.sqrt(ratio)),)
    return Finding(details=details, severity="warning", spans=((time, end),), size=ratio, factors=factors)


def later(finding: Finding, by: float) -> Finding:
    """A finding about a sensor whose stamps begin later than the whole record."""
    details = finding.details
    if by == 0:
        return finding
    if isinstance(details, Gaps):
        details = replace(details, longest=tuple(replace(gap, start=gap.start + by) for gap in details.longest))
    return replace(finding, details=details, spans=tuple((start + by, stop + by) for start, stop in finding.spans))


def _rate_drift(grid: GridFit, tau0: float) -> tuple[Finding, ...]:
    """A finding if the mean rates of ten equal parts differ significantly, and relatively by at least 1e-4."""
    change = grid.drift
    if change is None or change.size < max(_DRIFT_INFO, _DRIFT_ERRORS * change.error):
        return ()
    part = grid.n * tau0 / len(change.rates)
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


def _rate_not_nominal(rate: float, grid: GridFit) -> tuple[Finding, ...]:
    """A finding if the rate is close to a nominal rate, and significantly different from it."""
    power = 10.0 ** math.floor(math.log10(rate))
    nominal = min((m * power for m in _NOMINAL_RATES), key=lambda stated: abs(rate / stated - 1))
    off = rate / nominal - 1
    if not max(_EQUAL_RATES, 5 * grid.error / grid.interval) < abs(off) < _NEAR_NOMINAL:
        return ()
    return (Finding(details=RateNotNominal(rate=rate, nominal=nominal), severity="info", size=off),)
