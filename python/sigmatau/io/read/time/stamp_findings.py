"""What time stamps say about a log, in words: gaps, pauses, bunches, drift."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from sigmatau.findings.finding import Finding
from sigmatau.io.read.time.clock_line import GridFit
from sigmatau.io.read.time.rows import Rows
from sigmatau.record.streams import PLAUSIBLE_RATES
from sigmatau.results import seconds, two_digits

__all__ = ["drift", "gaps", "host", "implausible", "not_round", "of_single_precision", "pauses"]

_AGREE = 1e-3  # relative difference of two rates that are the same
_ROUND = (1.0, 1.25, 2.0, 2.5, 4.0, 5.0, 8.0)  # times a power of ten: rates as data sheets state them. [Hz]
_NEAR = 0.02  # relative distance from such a rate within which it may have been meant
# The largest of ten equal rates less the smallest is 3.1 ± 0.8 standard errors: beyond 8 once in 1e7 records.
_DRIFT_ERRORS = 8.0
_DRIFT = (1e-4, 1e-3)  # relative change of the rate that is said, and that is a warning
_UNSURE = 1e-2  # of the rate: then a random walk may be off by half a percent
_ON_END = 64  # holes of one size
_LISTED = 3
_FEW_LOST = 1e-3  # share of the samples, and of the record for the longest gap, up to which gaps are no warning


def implausible(rate: float) -> tuple[Finding, ...]:
    """A rate that no sensor has."""
    if PLAUSIBLE_RATES[0] <= rate <= PLAUSIBLE_RATES[1]:
        return ()
    return (
        Finding(
            code="implausible_rate",
            severity="warning",
            message=f"the time stamps say {rate:.6g} Hz",
            size=rate,
            unit="Hz",
            effect="no usual rate of a sensor: every time and every random walk would be wrong with it",
            remedy="check the unit of the stamps, --unit time=s|ms|us|ns, or give --rate HZ",
        ),
    )


def gaps(found: GridFit, second: float, place: Callable[[int], str]) -> tuple[Finding, ...]:
    """Places that are empty."""
    if found.places is None:
        return ()
    holes = np.diff(found.places) - 1
    at = np.flatnonzero(holes)
    longest = int(at[np.argmax(holes[at])])
    lost = int(holes.sum())
    tau0 = found.interval * second
    count, size = len(at), int(holes[longest])
    begins = float(found.places[longest] + 1) * tau0
    few = max(lost, size) <= _FEW_LOST * found.n
    even, remedy = "", "none is needed if they are few; look for lost packets or a full buffer if not"
    if found.period:
        rate = found.period / (float(found.places[found.period] - found.places[0]) * tau0)
        even = (
            f"; the pattern repeats every {found.period} rows without fail: a clock in steps of {tau0:.3g} s would show"
            f" even samples at {rate:.6g} Hz so too, if it runs exactly with the sensor's"
        )
        remedy = f"give --rate {rate:.6g} if that is the rate of the sensor, --rate {1 / tau0:.6g} if this one is"
    elif (slower := _slower(holes)) is not None:
        first, last = slower
        each = int(holes[first]) + 1
        since, until = (seconds(float(found.places[k]) * tau0) for k in (first, last))
        nth = {2: "second", 3: "third"}.get(each, f"{each}th")
        even = (
            f"; from t = {since} s to {until} s only every {nth} sample is there, without fail: the log or the sensor ran at"
            f" {1 / (each * tau0):.6g} Hz, elsewhere mostly at {1 / tau0:.6g} Hz"
        )
        remedy = (
            f"if the sensor itself was slower there, analyse that part and the rest by themselves, --window"
            f" {since}s:{until}s; if samples were thinned out, none is needed"
        )
    about = "about " if found.kind == "host" else ""
    listed = [
        f"{int(holes[k])} sample{'s' if holes[k] > 1 else ''} ({seconds(float(holes[k]) * tau0)} s) from"
        f" t = {seconds(float(found.places[k] + 1) * tau0)} s on, before {place(found.start + int(k) + 1)}"
        for k in at[np.argsort(-holes[at], kind="stable")][:_LISTED]
    ]
    longest_text = listed[0] if count == 1 else f"the longest, {'; '.join(listed)}"
    return (
        Finding(
            code="gaps",
            severity="info" if few else "warning",
            message=(
                f"{about}{lost} of {found.n} samples ({100 * lost / found.n:.2g} %) are missing in {count}"
                f" gap{'s' if count > 1 else ''} of the time stamps: {longest_text}{even}"
            ),
            where=f"t = {seconds(begins)} s",
            size=lost,
            effect=(
                "they are left empty on the grid of the stamps, never filled in: put together without them, the record would"
                " bend the curve at long times; interpolated, at all times"
            ),
            remedy=remedy,
        ),
    )


def _slower(holes: NDArray[np.int64]) -> tuple[int, int] | None:
    """First and last row of the longest stretch with one number of samples missing from row to row, if it has most of all.

    Samples lost at random with probability p leave holes of one size so many times on end with a chance of 4⁻⁶⁴ a row at
    most: that of a hole of one, p(1 - p), is largest.
    """
    edges = np.flatnonzero(np.diff(holes)) + 1
    starts, stops = np.concatenate(([0], edges)), np.append(edges, len(holes))
    missing = (stops - starts) * holes[starts]
    k = int(np.argmax(missing))
    if stops[k] - starts[k] < _ON_END or 2 * missing[k] < holes.sum():
        return None
    return int(starts[k]), int(stops[k])


def pauses(found: GridFit, used: Rows, second: float, place: Callable[[int], str]) -> tuple[Finding, ...]:
    """Pauses that are cut out, or so many that nothing would be left."""
    if found.pieces == 1:
        return ()
    row = int(np.argmax(used.intervals))
    longest = float(used.intervals[row]) * second
    if not found.pieces:
        return (
            Finding(
                code="irregular_stamps",
                severity="warning",
                message=(
                    f"the time stamps leave more places empty than there are samples, in no few pauses; the longest,"
                    f" {seconds(longest)} s, ends on {place(row + 1)}"
                ),
                where=place(row + 1),
                size=longest,
                unit="s",
                effect=(
                    f"samples are analysed as if evenly spaced by {found.interval * second:.6g} s; if they were not, the"
                    " curve is bent, and every time in it is wrong"
                ),
                remedy="if the sensor went on all the time, give its rate by --rate HZ; else cut out a piece without pauses",
            ),
        )
    total = len(used.stamps)
    kept = found.stop - found.start
    return (
        Finding(
            code="long_pauses",
            severity="warning",
            message=(
                f"{found.pieces - 1} pause{'s' if found.pieces > 2 else ''} or step{'s' if found.pieces > 2 else ''} of the"
                f" clock, longer than what is recorded, the longest {seconds(longest)} s before {place(row + 1)}: the"
                f" longest piece is analysed, {kept} of {total} samples from {place(found.start)} on, and the other"
                f" {total - kept} are left out"
            ),
            where=place(row + 1),
            size=longest,
            unit="s",
            effect="terms at long times are less sure than the whole log could make them",
            remedy="analyse the pieces one by one; if only the clock was set, cut the time column out and give --rate HZ",
        ),
    )


def host(found: GridFit, used: Rows, second: float, step: float, place: Callable[[int], str]) -> tuple[Finding, ...]:
    """Stamps that are not of the samples."""
    rate = 1 / (found.interval * second)
    if found.kind == "grid" and found.places is None and found.period:
        lost = round(found.interval * found.period / step) - found.period
        return (
            Finding(
                code="coarse_stamps",
                severity="info",
                message=(
                    f"the clock of the time stamps goes in steps of {step * second:.3g} s; evenly spaced samples at"
                    f" {rate:.6g} Hz fit all of them, and so would {1 / (step * second):.6g} Hz with {lost} of every"
                    f" {found.period + lost} samples lost"
                ),
                size=step * second,
                unit="s",
                effect=f"the samples are taken as even; if not, all times are {100 * lost / found.period:.2g} % too long",
                remedy=f"if the sensor gives {1 / (step * second):.6g} Hz, say so by --rate, and the lost are left empty",
            ),
        )
    if found.kind == "grid" or not found.pieces:
        return ()
    if found.kind == "coarse":
        sure = found.bound <= _AGREE
        open_ended = found.bound == math.inf  # only a rate that is given has come so far
        share = f"{two_digits(100 * found.bound)} %"
        others = "any faster ones" if open_ended else f"others up to {share} off"
        right = "" if sure or open_ended else f"; times are right to {share} only, a random walk to half of that"
        single = of_single_precision(used, step)
        return (
            Finding(
                code="coarse_stamps",
                severity="warning" if found.bound > _UNSURE or single else "info",
                message=(
                    f"the clock of the time stamps goes in steps of {step * second:.3g} s{single}, longer than the sample"
                    f" interval, {found.interval * second:.3g} s; evenly spaced samples at {rate:.6g} Hz fit all of them"
                    + ("" if sure else f", and so would {others}")
                ),
                size=step * second,
                unit="s",
                effect=f"fewer than {max(round(step / found.interval), 1) + 1} lost samples in a row would not be seen"
                + right,
                remedy="write the stamps with all their digits, or give --rate HZ" if single or not sure else "",
            ),
        )
    median = f"{1 / (found.median * second):.3g} Hz" if found.median > 0 else "no rate at all"
    row = int(np.argmax(used.intervals))
    longest = float(used.intervals[row])
    return (
        Finding(
            code="host_stamps",
            severity="warning",
            message=(
                f"{two_digits(100 * found.short)} % of the intervals between time stamps are shorter than half the sample"
                f" interval, the longest is {seconds(longest * second)} s (before {place(row + 1)}): the stamps say when a"
                f" host took the samples, not when the sensor made them; their median interval would say {median}"
            ),
            where=place(row + 1),
            size=found.short,
            effect=(
                f"samples are taken as evenly spaced at {rate:.6g} Hz, by the line through all stamps; samples that were"
                " lost cannot be seen, and each would make the rate lower by its share"
            ),
            remedy="if the rate of the sensor is known, compare it with this; log the sensor's own stamps or counter",
        ),
    )


def of_single_precision(used: Rows, step: float) -> str:
    """Words for a step that is that of a number of 32 bits as large as the stamps."""
    last = float(np.abs(used.stamps[-1]))
    single = step >= 1 and last < float(np.finfo(np.float32).max) and float(np.spacing(np.float32(last))) == step
    return ", which is that of single precision for numbers so large" if single else ""


def drift(found: GridFit, tau0: float) -> tuple[Finding, ...]:
    """A rate that changes."""
    change = found.drift
    if change is None or change.size < max(_DRIFT[0], _DRIFT_ERRORS * change.error):
        return ()
    low, high = (1 + change.rates.min()) / tau0, (1 + change.rates.max()) / tau0
    share = f"{two_digits(100 * change.size)} %"
    at = int(np.argmax(np.abs(change.rates - np.median(change.rates))))
    begins = at / len(change.rates) * found.n * tau0
    return (
        Finding(
            code="rate_drift",
            severity="warning" if change.size > _DRIFT[1] else "info",
            message=(
                f"the sampling rate changes over the record: {low:.6g} to {high:.6g} Hz by tenths, {share};"
                f" it is farthest from the others from t = {seconds(begins)} s on"
            ),
            where=f"t = {seconds(begins)} s",
            size=change.size,
            effect=(
                f"times are right to {share}, a random walk and a rate random walk to half of that; samples"
                " lost behind the stamps would look the same"
            ),
            remedy="none is needed for a steady drift; if the rate jumps, look for lost samples",
        ),
    )


def not_round(rate: float, found: GridFit) -> tuple[Finding, ...]:
    """A rate near one that data sheets state, and surely not that."""
    power = 10.0 ** math.floor(math.log10(rate))
    stated = min((m * power for m in (*_ROUND, 10.0)), key=lambda nominal: abs(rate / nominal - 1))
    off = rate / stated - 1
    if not max(_AGREE, 5 * found.error / found.interval) < abs(off) < _NEAR:
        return ()
    share = f"{100 * abs(off):.2g} %"
    return (
        Finding(
            code="rate_not_nominal",
            severity="info",
            message=f"the time stamps say {rate:.6g} Hz, {share} {'less' if off < 0 else 'more'} than {stated:g} Hz",
            size=off,
            effect=(
                f"the rate of the stamps is used; with {stated:g} Hz times would be off by {share}, a random walk by"
                f" {50 * abs(off):.2g} %"
            ),
            remedy=f"give --rate {stated:g} only if the sensor's clock is known to be better than that of the stamps",
        ),
    )
