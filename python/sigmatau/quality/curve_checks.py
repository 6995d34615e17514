"""Findings about a curve or its fit alone."""

from __future__ import annotations

import sys
from collections.abc import Mapping

import numpy as np

from sigmatau.estimators.allan import DeviationCurve
from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.fit import (
    ConstantChannel,
    NoAdequateModel,
    OutOfRange,
    ShortTimesLeftOut,
    SinusoidFitted,
    Strided,
    TooFewSamples,
    TooShort,
)
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.record.streams import Stream

__all__ = [
    "LARGEST",
    "LEAST",
    "constant_channel",
    "constant_channels",
    "fit_findings",
    "out_of_range",
    "rounding",
    "strided",
    "too_few_samples",
]

LEAST, LARGEST = 1e-120, 1e120  # range of Allan variances that can be analysed: a fit squares them [rate_unit²]
_MANY_MISSING = 0.1  # share of missing samples from which on they are named as the cause of too few averaging times
_LONGER_START = 1.5  # times tau0: a fit that begins later leaves out short averaging times


def fit_findings(fitted: NoiseFit, *, missing: float = 0.0) -> list[Finding]:
    """Why a channel is not fitted, or not from its shortest averaging time on; `missing` is the share of missing samples."""
    channels = (fitted.channel,)
    if fitted.verdict == "too_short":
        size = missing if missing > _MANY_MISSING else None
        details = TooShort(reasons=fitted.reasons, missing=missing)
        return [Finding(details=details, severity="warning", channels=channels, size=size)]
    if fitted.verdict == "descriptive":
        return [Finding(details=NoAdequateModel(reasons=fitted.reasons), severity="warning", channels=channels)]
    found = [
        Finding(
            details=SinusoidFitted(frequency=line.frequency.value),
            severity="info",
            channels=channels,
            size=line.amplitude.value,
            unit=line.amplitude.unit,
        )
        for line in fitted.sinusoid[:1]
    ]
    if fitted.tau_min is not None and fitted.tau_min > _LONGER_START * fitted.tau0:
        left_out = ShortTimesLeftOut(tau_min=float(fitted.tau_min), reasons=fitted.reasons)
        found.append(Finding(details=left_out, severity="info", channels=channels))
    return found


def rounding(stream: Stream, channel: str) -> float:
    """Largest deviation that rounding alone can make of a channel that is constant, or a straight line."""
    k = stream.channels.index(channel)
    raw, t = stream.samples.raw[k], stream.samples.transforms[k]
    first, last = 0, -1
    if stream.mask is not None:
        first, last = np.flatnonzero(~stream.mask[:, k])[[0, -1]]
    largest = max(abs(float(raw[first])), abs(float(raw[last]))) * abs(t.scale * t.factor)
    if t.kind != "rate":
        largest /= stream.grid.tau0
    return 4 * sys.float_info.epsilon * largest


def out_of_range(curve: DeviationCurve) -> Finding:
    """The finding that the Allan variances of a channel overflow or vanish when they are squared."""
    details = OutOfRange(largest=float(curve.adev.max()), rate_unit=curve.unit)
    return Finding(details=details, severity="error", channels=(curve.channel,))


def constant_channel(stream: Stream, channel: str) -> Finding:
    """The finding that a channel never changes."""
    k = stream.channels.index(channel)
    first = 0 if stream.mask is None else int(np.flatnonzero(~stream.mask[:, k])[0])
    value = float(stream.samples.read(k, first, first + 1)[0])
    details = ConstantChannel(samples=stream.grid.n, value=value, rate_unit=stream.unit)
    return Finding(details=details, severity="error", channels=(channel,))


def too_few_samples(stream: Stream, channel: str) -> Finding:
    """The finding that so many samples of a channel are missing that it has no Allan variance."""
    missing = 0 if stream.mask is None else int(stream.mask[:, stream.channels.index(channel)].sum())
    details = TooFewSamples(missing=missing, samples=stream.grid.n)
    return Finding(details=details, severity="error", channels=(channel,))


def constant_channels(stream: Stream) -> list[Finding]:
    """Channels of a sensor that never change, or have no sample, found without their curves."""
    if stream.quantity == "temperature":
        return []
    found = []
    for channel in stream.channels:
        x = stream.column(channel)
        low, high = float(np.fmin.reduce(x)), float(np.fmax.reduce(x))
        if np.isnan(low):
            found.append(too_few_samples(stream, channel))
        elif high - low <= rounding(stream, channel):
            found.append(constant_channel(stream, channel))
    return found


def strided(
    curves: Mapping[str, DeviationCurve], stream: str | None = None, *, out_of_memory: bool = False
) -> list[Finding]:
    """From which averaging time on clusters of one stream (its name, its curves by channel) do not begin at every sample."""
    curve = next(iter(curves.values()))
    if curve.stride is None:
        return []
    first = float(curve.tau[curve.stride > 1][0])
    details = Strided(tau=first, samples=curve.n, out_of_memory=out_of_memory)
    return [Finding(details=details, severity="info", channels=() if stream is None else (stream,))]
