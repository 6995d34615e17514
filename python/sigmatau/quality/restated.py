"""Effects of faults on the printed fit: bad samples, filters, interpolation.

The fit without bad samples takes them for missing and begins at the same averaging time. The fit without a filter begins at
the averaging time from which the curve is right.
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
from sigmatau.quality.effects import Change, compared, in_fit, severity
from sigmatau.quality.facts import stream_fact
from sigmatau.quality.samples.common import without_dust
from sigmatau.quality.samples.lost_rows import lost_rows
from sigmatau.quality.samples.masking import masked
from sigmatau.quality.samples.spikes import find_spikes, more_below, without_spikes
from sigmatau.quality.samples.stuck_samples import without_runs
from sigmatau.quality.spectrum.low_pass import low_passes
from sigmatau.quality.spectrum.upsampling import resampled
from sigmatau.record.record import Record
from sigmatau.record.streams import Stream

__all__ = ["bad_samples_in_fits", "filters_in_fits", "past_filter", "without_faults"]

NEGLIGIBLE = 1.001
"""Factor on the random walk below which spikes are not refitted. The smallest that changed a coefficient by 5 % in a real
record of a VN-100 had 1.009."""

_BAD = ("dropout", "stuck_samples", "spikes")
_FILTERS = ("low_pass_filter", "interpolated")
_OVER = 75.0
"""Averaging time over the correlation time from which a Gauss-Markov process is a random walk to 1 % in σ: its variance is
short by 1.5·T/τ."""


def bad_samples_in_fits(stream: Stream, fits: Mapping[str, NoiseFit], found: Sequence[Finding]) -> list[Finding]:
    """Findings of dropouts, stuck samples and spikes with their effect on the printed fits.

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
        `factors` of the first finding of a channel holds the factor by which each printed coefficient is larger than without
        all bad samples of the channel; other such findings have none. Of several channels, the one that changes most counts.
    """
    told: dict[str, Finding] = {}
    result, good = [], None
    for finding in found:
        channels = [c for c in finding.channels if c in stream.channels and c in fits and fits[c].tau_min is not None]
        if finding.code not in _BAD or not channels:
            result.append(finding)
        elif finding.code == "spikes" and max((factor for _, factor in finding.factors), default=1.0) < NEGLIGIBLE:
            result.append(replace(finding, factors=()))
        elif told.keys() >= set(channels):
            first = told[channels[0]]
            assert first.fit_effect is not None
            effect = replace(first.fit_effect, hidden=(), at_least=(), counted_in=first.code)
            result.append(replace(finding, factors=(), fit_effect=effect))
        else:
            good = _without_bad(stream) if good is None else good
            beside = {f.code for f in found if set(f.channels) & set(channels)}
            without = tuple(code for code in _BAD if code in beside)
            result.append(_refitted(good, [fits[channel] for channel in channels], finding, without))
            told |= dict.fromkeys(channels, result[-1])
    return result


def filters_in_fits(stream: Stream, fits: Mapping[str, NoiseFit], found: Sequence[Finding]) -> list[Finding]:
    """Findings of filters and interpolation with their effect on the printed fits, which is often none.

    Parameters
    ----------
    stream, fits, found
        See `bad_samples_in_fits`.

    Returns
    -------
    list of Finding
        `factors` is empty if the fit begins where the curve is right, or agrees with one that does; otherwise it holds the
        printed coefficients over those of such a fit.
    """
    filtered = [f for f in found if f.code in _FILTERS and f.factors and f.channel in stream.channels]
    if not filtered:
        return list(found)
    clean = without_faults(stream)
    return [_beyond(stream, clean, fits[f.channels[0]], f) if f in filtered and f.channel in fits else f for f in found]


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


@stream_fact
def without_faults(stream: Stream) -> Stream:
    """The stream for spectra: without runs of equal samples, and with nearby samples in place of spikes."""
    return without_spikes(without_runs(stream))


def _without_bad(stream: Stream) -> Stream:
    """The stream with all bad samples missing."""
    bad = without_runs(without_dust(lost_rows(stream)[1]))
    masks = []
    for channel in stream.channels:
        x = np.where(np.isnan(bad.column(channel)), np.nan, stream.column(channel))
        masks.append(np.isnan(x) | find_spikes(x))
    return masked(stream, np.stack(masks, axis=1))


def _refitted(good: Stream, fits: Sequence[NoiseFit], finding: Finding, without: tuple[str, ...]) -> Finding:
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
        return replace(finding, fit_effect=in_fit([], fits[0], None, without=without)["fit_effect"])
    _, changes, fitted, after = best
    told = in_fit(
        changes,
        fitted,
        after,
        without=without,
        hidden=tuple(term for term in after.observed if fitted.observed and term not in fitted.observed),
        lower_bound=finding.code == "spikes" and more_below(good.column(fitted.channel)),
    )
    return replace(finding, severity="warning" if finding.severity == "warning" else severity(changes), **told)


def _beyond(stream: Stream, clean: Stream, fitted: NoiseFit, finding: Finding) -> Finding:
    reach = _reach(clean.only(fitted.channel), fitted.channel, finding.code)
    if reach is None or fitted.tau_min is None:
        return finding
    after: NoiseFit | None = fitted
    changes = list[Change]()
    hidden: tuple[str, ...] = ()
    if fitted.tau_min < reach * (1 - 1e-9):
        try:
            curve = channel_curve(Record(streams=(stream.only(fitted.channel),)), fitted.channel, taus="half")
            after = fit(curve, tau_min=reach)
        except (DataError, OptionError):  # too few averaging times are left
            after = None
        else:
            changes = [change for change in compared(fitted, after) if _surely(change, fitted, after)]
            hidden = tuple(t for t in after if t in fitted and _false_limit(fitted[t].upper_limit, after[t].low))
    compared_from = max(reach, fitted.tau_min)
    told = in_fit(changes, fitted, after, without=(finding.code,), compared_from=compared_from, hidden=hidden)
    return replace(finding, **told)


def _false_limit(limit: float | None, low: float | None) -> bool:
    return limit is not None and low is not None and limit < low


def _surely(change: Change, before: NoiseFit, after: NoiseFit) -> bool:
    """Whether a fit to fewer averaging times finds another value, beyond its own error."""
    value, there = before[change.term].value, after[change.term]
    if value is None or change.at_least or there.low is None or there.high is None:
        return False
    return not there.low <= value <= there.high


def _reach(one: Stream, channel: str, code: str) -> float | None:
    """Averaging time from which the curve is right; None if the fault is not found again."""
    if code == "low_pass_filter":
        found = low_passes(one).get(channel)
        return None if found is None else found.right_from
    what = resampled(one, channel)
    return None if what is None else what.right_from
