"""Findings about time stamps: plausibility and drift of the rate, gaps, pauses, clock resolution, bunches."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.stamps import (
    CoarseStamps,
    Gap,
    Gaps,
    HostStamps,
    ImplausibleRate,
    IrregularStamps,
    LongPauses,
    RateDrift,
    RateNotNominal,
)
from sigmatau.io.read.time.clock_line import GridFit
from sigmatau.io.read.time.rows import Rows
from sigmatau.record.streams import PLAUSIBLE_RATES

# Relative difference up to which two rates are taken as equal: twice the resulting error of a random walk
EQUAL_RATES = 1e-3
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


def implausible_rate(rate: float) -> tuple[Finding, ...]:
    """A finding if no usual sensor has this rate."""
    if PLAUSIBLE_RATES[0] <= rate <= PLAUSIBLE_RATES[1]:
        return ()
    return (Finding(details=ImplausibleRate(rate=rate), severity="warning", size=rate, unit="Hz"),)


def gaps(
    found: GridFit, second: float, place: Callable[[int], str], *, few_lost: float = _FEW_LOST
) -> tuple[Finding, ...]:
    """A finding about the empty places of the grid; a warning if more than the share `few_lost` is missing."""
    if found.places is None:
        return ()
    holes = np.diff(found.places) - 1
    at = np.flatnonzero(holes)
    lost = int(holes.sum())
    tau0 = found.interval * second
    longest = tuple(
        Gap(
            samples=int(holes[k]),
            start=float(found.places[k] + 1) * tau0,
            length=float(holes[k]) * tau0,
            place=place(found.start + int(k) + 1),
        )
        for k in at[np.argsort(-holes[at], kind="stable")][:_LISTED_GAPS]
    )
    even_rate = None
    if found.period:
        even_rate = found.period / (float(found.places[found.period] - found.places[0]) * tau0)
    details = Gaps(
        samples=found.n,
        gaps=len(at),
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
            spans=tuple((gap.start, gap.start + gap.length) for gap in longest),
            size=lost,
        ),
    )


def pauses(found: GridFit, used: Rows, second: float, place: Callable[[int], str]) -> tuple[Finding, ...]:
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


def resolution_or_host(found: GridFit, used: Rows, second: float, step: float) -> tuple[Finding, ...]:
    """A finding about a clock of low resolution, or about stamps that a host made in bunches."""
    rate = 1 / (found.interval * second)
    if found.kind == "grid" and found.places is None and found.period:
        lost = round(found.interval * found.period / step) - found.period
        details = CoarseStamps(step=step * second, rate=rate, period=found.period + lost, lost=lost)
        return (Finding(details=details, severity="info", size=step * second, unit="s"),)
    if found.kind == "grid" or not found.pieces:
        return ()
    if found.kind == "coarse":
        single = is_single_precision(used, step)
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


def is_single_precision(used: Rows, step: float) -> bool:
    """Whether the step of the clock is the resolution of single-precision numbers as large as the stamps."""
    last = float(np.abs(used.stamps[-1]))
    return step >= 1 and last < float(np.finfo(np.float32).max) and float(np.spacing(np.float32(last))) == step


def rate_drift(found: GridFit, tau0: float, *, least: float = _DRIFT_INFO) -> tuple[Finding, ...]:
    """A finding if the mean rates of ten equal parts differ significantly, and relatively by at least `least`."""
    change = found.drift
    if change is None or change.size < max(least, _DRIFT_ERRORS * change.error):
        return ()
    part = found.n * tau0 / len(change.rates)
    start = int(np.argmax(np.abs(change.rates - np.median(change.rates)))) * part
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


def rate_not_nominal(rate: float, found: GridFit) -> tuple[Finding, ...]:
    """A finding if the rate is close to a nominal rate, and significantly different from it."""
    power = 10.0 ** math.floor(math.log10(rate))
    nominal = min((m * power for m in _NOMINAL_RATES), key=lambda stated: abs(rate / stated - 1))
    off = rate / nominal - 1
    if not max(EQUAL_RATES, 5 * found.error / found.interval) < abs(off) < _NEAR_NOMINAL:
        return ()
    return (Finding(details=RateNotNominal(rate=rate, nominal=nominal), severity="info", size=off),)
