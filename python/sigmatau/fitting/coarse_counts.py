"""Fit of increments of an angle whose rounding is not white from one to the next: by sums of them, or upper limits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from sigmatau.findings.reasons import BandLeftOut, CoarseCounts
from sigmatau.fitting.channel import by_likelihood, fit_channel
from sigmatau.fitting.disturbance import with_limits
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.fitting.pass_over import usable
from sigmatau.record.record import Record
from sigmatau.record.streams import Columns, Stream, Transform


def fit_sums(
    record: Record, channel: str, *, summed: int | None, least: int, terms: Sequence[str] | None = None
) -> NoiseFit:
    """Fit coarse increments by the likelihood of their sums, in which the rounding is quantization noise.

    Parameters
    ----------
    record : Record
    channel : str
    summed : int or None
        Increments of a sum whose rounding is white; None if there is none.
    least : int
        Sums that are needed. With fewer all terms are upper limits.
    terms : sequence of str, optional
        See `sigmatau.fit_channel`.
    """
    stream = record.stream_of(channel)
    sums = None if summed is None else _sums_of(stream, channel, summed)
    if summed is None or sums is None or not usable(sums, channel, least=least):
        fitted = fit_channel(record, channel, terms=terms)
        if not fitted.terms:
            return fitted
        # Lines and resonances of such counts are those of the rounding.
        bare = replace(fitted, sinusoid=(), resonance=(), highest=None, reasons=())
        return with_limits(bare, stream, CoarseCounts(summed=summed, hidden=True))
    streams = tuple(sums if each is stream else each for each in record.streams)
    fitted = by_likelihood(replace(record, streams=streams), channel, terms=terms)
    if fitted.verdict == "disturbed":
        fitted = replace(fitted, n=stream.grid.n, tau0=stream.grid.tau0)
        return with_limits(fitted, stream, CoarseCounts(summed=summed, hidden=True))
    # What the sums show of lines, resonances and a filter is folded at half their rate.
    has_process = bool(fitted.gauss_markov) or fitted.warm_up is not None
    reasons = tuple(reason for reason in fitted.reasons if not isinstance(reason, BandLeftOut))
    return replace(
        fitted,
        n=stream.grid.n,
        tau0=stream.grid.tau0,
        tau_min=max(fitted.tau_min or 0.0, sums.grid.tau0),
        verdict="adequate" if fitted.verdict == "adequate_with" and not has_process else fitted.verdict,
        reasons=(CoarseCounts(summed=summed, hidden=False), *reasons),
        sinusoid=(),
        resonance=(),
        response=None,
        highest=None,
        covariance=fitted.covariance.select(lambda each: None if each.part == "resonance" else each),
    )


def _sums_of(stream: Stream, channel: str, size: int) -> Stream:
    """The mean rates of sums of increments; missing where an increment is."""
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
