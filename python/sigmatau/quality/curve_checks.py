"""Findings about a curve alone."""

from __future__ import annotations

import sys
from collections.abc import Mapping

import numpy as np

from sigmatau.estimators.allan import DeviationCurve
from sigmatau.findings.curves import ConstantChannel, OutOfRange, Strided, TooFewSamples
from sigmatau.findings.finding import Finding
from sigmatau.frozen import frozen
from sigmatau.record.streams import Stream


@frozen
class CurveThresholds:
    """Thresholds of the findings about a curve."""

    smallest: float = 1e-120
    """Allan variance that can be analysed, at least. [rate_unit²] Derived: a fit squares it, within the range of
    double precision."""

    largest: float = 1e120
    """Allan variance that can be analysed, at most. [rate_unit²] Derived: see `smallest`."""

    rounding: float = 4
    """Deviation that rounding can make of a constant channel, in units of the rounding of its largest value. [1]
    Judgement: three differences and a unit conversion are rounded."""


THRESHOLDS = CurveThresholds()


def rounding(stream: Stream, channel: str, *, thresholds: CurveThresholds = THRESHOLDS) -> float:
    """Largest deviation that rounding alone can make of a channel that is constant, or a straight line."""
    k = stream.channels.index(channel)
    raw, t = stream.samples.raw[k], stream.samples.transforms[k]
    first, last = 0, -1
    if stream.mask is not None:
        first, last = np.flatnonzero(~stream.mask[:, k])[[0, -1]]
    largest = max(abs(float(raw[first])), abs(float(raw[last]))) * abs(t.scale * t.factor)
    if t.kind != "rate":
        largest /= stream.grid.tau0
    return thresholds.rounding * sys.float_info.epsilon * largest


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


def constant_channels(stream: Stream, *, thresholds: CurveThresholds = THRESHOLDS) -> list[Finding]:
    """Channels of a sensor that never change, or have no sample, found without their curves."""
    if stream.quantity == "temperature":
        return []
    found = []
    for channel in stream.channels:
        x = stream.column(channel)
        low, high = float(np.fmin.reduce(x)), float(np.fmax.reduce(x))
        if np.isnan(low):
            found.append(too_few_samples(stream, channel))
        elif high - low <= rounding(stream, channel, thresholds=thresholds):
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
