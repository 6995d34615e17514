"""What faults do to the fit that is printed: samples that are none of the sensor's, filters, interpolation.

Bad samples are taken for missing and the rest is fitted from the same averaging time on. What a filter leaves of the short
times shows against a fit from where the curve is right again.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from sigmatau.errors import DataError, OptionError
from sigmatau.estimators.allan import channel_curve
from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.fit import FilterTakenForProcess
from sigmatau.fitting.fit import fit
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.noise.terms import TERMS
from sigmatau.quality.effects import Change, compared, severity, words
from sigmatau.quality.samples.common import without_dust
from sigmatau.quality.samples.lost_rows import lost_rows
from sigmatau.quality.samples.masking import masked
from sigmatau.quality.samples.spikes import AT_LEAST, find_spikes, more_below, without_spikes
from sigmatau.quality.samples.stuck_samples import without_runs
from sigmatau.quality.spectrum.low_pass import low_passes
from sigmatau.quality.spectrum.upsampling import resampled
from sigmatau.record.record import Record
from sigmatau.record.streams import Stream
from sigmatau.results import seconds
from sigmatau.spectrum.estimate import welch

__all__ = ["bad_samples_in_fits", "filters_in_fits", "past_filter", "without_faults"]

_BAD = ("dropout", "stuck_samples", "spikes")
_FILTERS = ("low_pass_filter", "interpolated")
_OVER = 75.0
"""Times its correlation time a Gauss-Markov process is a random walk to 1 % in σ: its variance is short by 1.5·T/τ."""

_NONE = ("is no adequate model", "none either")
_NAMES = {"dropout": "dropouts", "stuck_samples": "stuck samples", "spikes": "spikes"}


def bad_samples_in_fits(stream: Stream, fits: Mapping[str, NoiseFit], found: Sequence[Finding]) -> list[Finding]:
    """Findings of dropouts, stuck samples and spikes once more, with what they do to the fits that are printed.

    Parameters
    ----------
    stream : Stream
        All that was fitted.
    fits : mapping of str to NoiseFit
        By channel.
    found : sequence of Finding
        Of any kind; all others are returned as they are.

    Returns
    -------
    list of Finding
        `changes` of the first finding of a channel holds by which factor each printed coefficient is larger than without all
        its bad samples; other findings of such samples have none. A finding of several channels tells of the one that is
        changed most.
    """
    told: set[str] = set()
    result, good = [], None
    for finding in found:
        channels = _channels(finding, stream, fits) if finding.code in _BAD else []
        if not channels:
            result.append(finding)
        elif told.issuperset(channels):
            result.append(replace(finding, changes=(), effect="counted with the other bad samples of the channel"))
        else:
            good = _without_bad(stream) if good is None else good
            result.append(_refitted(good, [fits[channel] for channel in channels], finding, _beside(found, channels)))
            told.update(channels)
    return result


def filters_in_fits(stream: Stream, fits: Mapping[str, NoiseFit], found: Sequence[Finding]) -> list[Finding]:
    """Findings of filters and interpolation once more, with what these do to the fits that are printed: often nothing.

    Parameters
    ----------
    stream, fits, found
        See `bad_samples_in_fits`.

    Returns
    -------
    list of Finding
        `changes` is empty where the fit begins where the curve is right again, or is as good as one that does; otherwise it
        holds the printed coefficients over those of such a fit.
    """
    if not any(f.code in _FILTERS and f.changes and f.channel in stream.channels for f in found):
        return list(found)
    clean = without_faults(stream)
    return [
        _beyond(stream, clean, fits[finding.channel], finding)
        if finding.code in _FILTERS
        and finding.changes
        and finding.channel in stream.channels
        and finding.channel in fits
        else finding
        for finding in found
    ]


def past_filter(
    stream: Stream, fitted: NoiseFit, found: Sequence[Finding], again: Callable[[float], NoiseFit]
) -> NoiseFit:
    """The fit of a channel, made anew from beyond its filter if it took that for a Gauss-Markov process.

    White noise behind a first-order filter is such a process: the fit is good, and its random walk, which is all that the
    noise is at long times, is not seen, with a limit far below the truth.

    Parameters
    ----------
    stream : Stream
        Of the channel.
    fitted : NoiseFit
    found : sequence of Finding
        Of which ``low_pass_filter`` counts.
    again : callable
        The fit from another averaging time on. [s]

    Returns
    -------
    NoiseFit
        Without intervals or limits if there are too few averaging times beyond the filter.
    """
    corner = next((f.size for f in found if f.code == "low_pass_filter" and f.channel == fitted.channel), None)
    if corner is None or not fitted.gauss_markov or fitted.tau_min is None or "random_walk" in fitted.observed:
        return fitted
    time = fitted.gauss_markov[0].time.value
    reach = _reach(without_faults(stream).only(fitted.channel), fitted.channel, "low_pass_filter")
    # With no other white noise to be filtered, a process that is over before the filter is can be nothing else.
    if reach is None or not fitted.tau_min < time * _OVER or time > reach:
        return fitted
    reach = max(reach, time * _OVER)
    why = FilterTakenForProcess(corner=corner, correlation_time=time, tau_min=fitted.tau_min)
    try:
        after = again(reach)
    except OptionError:
        return fitted.doubted(why)
    return replace(after, reasons=(*after.reasons, why))


def without_faults(stream: Stream) -> Stream:
    """The stream as its spectrum is looked at: without runs of equal samples, and with others in place of spikes."""
    return without_spikes(without_runs(stream))


def _channels(finding: Finding, stream: Stream, fits: Mapping[str, NoiseFit]) -> list[str]:
    """Those that a finding is about and that were fitted; of several axes it names them first."""
    if finding.channel is not None:
        named = [finding.channel]
    else:
        head = finding.message.split(";")[0].replace(",", " ").split()
        named = [channel for channel in stream.channels if channel in head]
    return [c for c in named if c in stream.channels and c in fits and fits[c].tau_min is not None]


def _beside(found: Sequence[Finding], channels: Sequence[str]) -> str:
    """All that is left out, in words."""
    codes = [c for c in _BAD if any(f.code == c and (f.channel is None or f.channel in channels) for f in found)]
    return " and ".join(_NAMES[code] for code in codes)


def _without_bad(stream: Stream) -> Stream:
    """The stream with all bad samples taken for missing."""
    bad = without_runs(without_dust(lost_rows(stream)[1]))
    masks = []
    for channel in stream.channels:
        x = np.where(np.isnan(bad.column(channel)), np.nan, stream.column(channel))
        masks.append(np.isnan(x) | find_spikes(x))
    return masked(stream, np.stack(masks, axis=1))


def _refitted(good: Stream, fits: Sequence[NoiseFit], finding: Finding, what: str) -> Finding:
    best: tuple[float, list[Change], NoiseFit, NoiseFit] | None = None
    for fitted in fits:
        try:
            curve = channel_curve(Record(streams=(good.only(fitted.channel),)), fitted.channel, taus="half")
            after = fit(curve, tau_min=fitted.tau_min)
        except (DataError, OptionError):  # too little is left
            continue
        changes = compared(fitted, after)
        most = max((max(c.factor, 1 / c.factor) for c in changes), default=1.0)
        if best is None or most > best[0]:
            best = most, changes, fitted, after
    if best is None:
        return replace(finding, effect=f"{finding.effect}; too little is left to fit without it")
    _, changes, fitted, after = best
    on = f" on {fitted.channel}" if finding.channel is None else ""
    texts = words(changes, fitted.quantity)
    said = " and ".join(texts) if texts else "no coefficient changed by more than 5 %"
    if finding.code == "spikes" and more_below(good.column(fitted.channel)):
        said += f", {AT_LEAST}"
    hidden = [TERMS[t].label(fitted.quantity) for t in after.observed if t not in fitted.observed and fitted.observed]
    if hidden:
        said += f", and hides the {' and '.join(hidden)} that shows without them"
    return replace(
        finding,
        severity="warning" if finding.severity == "warning" else severity(changes),
        effect=f"the fit{on}, from τ = {seconds(fitted.tau_min or fitted.tau0)} s on, against one without the {what}:"
        f" {said}; read off: {finding.effect.removesuffix(f'; {AT_LEAST}')}",
        changes=tuple((change.term, change.factor) for change in changes),
    )


def _beyond(stream: Stream, clean: Stream, fitted: NoiseFit, finding: Finding) -> Finding:
    reach = _reach(clean.only(fitted.channel), fitted.channel, finding.code)
    if reach is None or fitted.tau_min is None:
        return finding
    said, changes = "is not changed by it", list[Change]()
    if fitted.tau_min < reach * (1 - 1e-9):
        try:
            curve = channel_curve(Record(streams=(stream.only(fitted.channel),)), fitted.channel, taus="half")
            after = fit(curve, tau_min=reach)
        except (DataError, OptionError):
            said = (
                f"begins before, and too few averaging times are left from τ = {seconds(reach)} s on to fit without it"
            )
        else:
            changes = [change for change in compared(fitted, after) if _surely(change, fitted, after)]
            said = _against(fitted, after, changes)
    return replace(
        finding,
        effect=f"{finding.effect}; the fit, from τ = {seconds(fitted.tau_min)} s on, {said}",
        changes=tuple((change.term, change.factor) for change in changes),
    )


def _against(before: NoiseFit, after: NoiseFit, changes: Sequence[Change]) -> str:
    """What is sure of a fit against one from where the curve is right; nothing is, where that one is not adequate."""
    if after.verdict != "adequate":
        itself, too = ("begins before", "no adequate model") if before.verdict == "adequate" else _NONE
        there = f"from τ = {seconds(after.tau_min or after.tau0)} s on there is {too}"
        return f"{itself}, and {there}: what it does to the fit cannot be told{_both(before, after)}"
    texts = words(changes, before.quantity)
    hidden = [
        f"{TERMS[t].label(before.quantity)} of {value} {unit} {interval}".rstrip() + ", above the limit that is stated"
        for t, term in after.items()
        if t in before and _false_limit(before[t].upper_limit, term.low)
        for value, interval, unit in after.texts(t)[:1]
    ]
    said = " and ".join(
        filter(None, [f"finds {' and '.join(texts)}" if texts else "", *(f"hides a {h}" for h in hidden)])
    )
    if before.verdict == "adequate":
        return said or "is not changed by it"
    against = f", against which it {said}" if said else ""
    return f"is no adequate model; one from τ = {seconds(after.tau_min or after.tau0)} s on is{against}"


def _both(before: NoiseFit, after: NoiseFit) -> str:
    """The random walks of two fits, where both have one."""
    if "random_walk" not in before or "random_walk" not in after:
        return ""
    if before["random_walk"].value is None or after["random_walk"].value is None:
        return ""
    (one, _, _), (other, _, unit) = before.texts("random_walk")[0], after.texts("random_walk")[0]
    return f" ({TERMS['random_walk'].label(before.quantity)} {one} and {other} {unit})"


def _false_limit(limit: float | None, low: float | None) -> bool:
    return limit is not None and low is not None and limit < low


def _surely(change: Change, before: NoiseFit, after: NoiseFit) -> bool:
    """Whether what a fit to fewer times finds is another value, and not the same with more scatter."""
    value, there = before[change.term].value, after[change.term]
    if value is None or change.at_least or there.low is None or there.high is None:
        return False
    return not there.low <= value <= there.high


def _reach(one: Stream, channel: str, code: str) -> float | None:
    """From which averaging time the curve is right; None if the fault is not found once more."""
    if code == "low_pass_filter":
        found = low_passes(one).get(channel)
        return None if found is None else found.right_from
    y = np.ascontiguousarray(one.column(channel))
    try:
        what = resampled(y, welch(y, one, channel))
    except DataError:
        return None
    return None if what is None else what.right_from
