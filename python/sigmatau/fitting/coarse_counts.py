"""Fit of angle counts whose rounding is not white from sample to sample: a fit of sums of samples, or upper limits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from sigmatau.findings.reasons import CoarseCounts
from sigmatau.fitting.adjust import adjusted
from sigmatau.fitting.adjustment import Adjustment, Change, Part
from sigmatau.fitting.channel import by_likelihood, fit_channel
from sigmatau.fitting.disturbance import limits_alone
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.fitting.pass_over import usable
from sigmatau.model.parameters import Parameter
from sigmatau.record.record import Record
from sigmatau.record.streams import Columns, Stream, Transform


def fit_sums(
    record: Record,
    channel: str,
    *,
    summed: int | None,
    smallest: int,
    quantization: float,
    terms: Sequence[str] | None = None,
) -> NoiseFit:
    """Fit coarse counts by the likelihood of their sums, in which the rounding is quantization noise.

    Parameters
    ----------
    record : Record
    channel : str
    summed : int or None
        Number of samples in a sum whose rounding is white; None if no sum has white rounding.
    smallest : int
        Smallest number of sums. With fewer, all terms are upper limits.
    quantization : float
        Quantization noise of the step of the angle: the smallest upper limit of that term. [rate unit·s]
    terms : sequence of str, optional
        See `sigmatau.fit_channel`.
    """
    stream = record.stream_of(channel)
    sums = None if summed is None else _summed(stream, channel, summed)
    if summed is None or sums is None or not usable(sums, channel, needed=smallest):
        fitted = fit_channel(record, channel, terms=terms)
        if not fitted.terms:
            return fitted
        # Lines and resonances of such counts are artefacts of the rounding.
        without: tuple[Part, ...] = ("sinusoid", "resonance", "highest", "reasons")
        return adjusted(
            fitted, partial(_hidden, stream=stream, summed=summed, quantization=quantization, without=without)
        )
    streams = tuple(sums if each is stream else each for each in record.streams)
    fitted = by_likelihood(replace(record, streams=streams), channel, terms=terms)
    fitted = replace(fitted, n=stream.grid.n, tau0=stream.grid.tau0)
    if fitted.verdict == "disturbed":
        return adjusted(fitted, partial(_hidden, stream=stream, summed=summed, quantization=quantization))
    return adjusted(fitted, partial(_adjusted_sums, summed=summed, tau_min=sums.grid.tau0))


def _hidden(
    fitted: NoiseFit, *, stream: Stream, summed: int | None, quantization: float, without: tuple[Part, ...] = ()
) -> Adjustment:
    """Replace all terms by upper limits, because the rounding hides all other noise."""
    reason = CoarseCounts(summed=summed, hidden=True)
    limits = limits_alone(fitted, stream, cause="coarse_counts", reason=reason, without=without)
    return replace(limits, changes=tuple(_raised(change, quantization) for change in limits.changes))


def _raised(change: Change, quantization: float) -> Change:
    """Raise the limit of quantization noise to that of the step."""
    limit = change.after.upper_limit
    if change.parameter != Parameter("quantization") or limit is None or limit >= quantization:
        return change
    return replace(change, after=replace(change.after, upper_limit=quantization))


def _adjusted_sums(fitted: NoiseFit, *, summed: int, tau_min: float) -> Adjustment:
    """Adjust a fit of sums: remove its lines, resonances and filter, which the sums fold at half their rate."""
    has_process = bool(fitted.gauss_markov) or fitted.warm_up is not None
    return Adjustment(
        cause="coarse_counts",
        findings=("coarse_resolution",),
        verdict="adequate" if fitted.verdict == "adequate_with" and not has_process else None,
        without=("sinusoid", "resonance", "response", "highest"),
        tau_min=max(fitted.tau_min or 0.0, tau_min),
        reason=CoarseCounts(summed=summed, hidden=False),
    )


def _summed(stream: Stream, channel: str, size: int) -> Stream:
    """The mean rates over sums of increments; a sum with a missing increment is missing."""
    whole = stream.grid.n // size * size
    rates = stream.column(channel)[:whole].reshape(-1, size).mean(axis=1)
    missing = np.isnan(rates)
    grid = replace(stream.grid, n=len(rates), tau0=size * stream.grid.tau0)
    return replace(
        stream.only(channel),
        grid=grid,
        samples=Columns((rates,), (Transform(),), grid.tau0),
        mask=missing[:, None] if missing.any() else None,
    )
