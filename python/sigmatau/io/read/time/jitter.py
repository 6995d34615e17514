"""Findings about the scatter of time stamps about their grid."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.stamps import Jitter
from sigmatau.io.read.time.timing import Timing
from sigmatau.record.streams import Stream

__all__ = ["jitter_findings"]

_LEAST_JITTER = 0.03  # share of the sample interval from which on jitter is a finding
_ROUNDING_FACTOR = 1.3  # times the scatter that the resolution of the clock makes: up to it, jitter is rounding
_LEAST_SHARE = 0.2  # of the squared quantization noise: less changes the coefficient by less than 12 %
_MOST_SHARE = 1.5  # the samples cannot have less noise than their jitter makes: above, only the stamps scatter
_LEAST_OWN = 0.05  # share of the sensor's own noise from which on the factor on it is known
_SEGMENTS, _SEGMENT_LENGTH = 64, 4096  # evenly spread segments from which mean and covariance are computed
_INTEGRALS = {"m/s^2": "m/s", "rad/s": "rad"}


def jitter_findings(
    streams: Sequence[Stream], times: Sequence[Timing], *, least: float = _LEAST_JITTER
) -> tuple[Finding, ...]:
    """Findings about jitter of more than the share `least` of the interval that the resolution does not explain.

    An integrating sensor whose intervals scatter shows its mean times the scatter as noise of its angle or velocity: σ_j |m|
    is quantization noise. The mean of a rate does not depend on the instant of sampling.
    """
    found: list[Finding] = []
    for timing in times:
        jitter = timing.jitter or 0.0
        rounding = timing.step / math.sqrt(12)
        if not timing.counted or jitter * timing.rate <= least or jitter <= _ROUNDING_FACTOR * rounding:
            continue
        own = [s for s in streams if s.grid.jitter == timing.jitter]
        integrating = [s for s in own if s.samples.transforms[0].kind != "rate"]
        if integrating:
            found += [f for s in integrating for channel in s.channels if (f := _of_channel(s, channel, jitter))]
            continue
        details = Jitter(sigma=jitter, interval=1 / timing.rate)
        levels = [(abs(_mean(s, c)), c, s.unit) for s in own for c in s.channels if s.quantity != "signal"]
        if levels:
            mean, channel, unit = max(levels)
            details = Jitter(sigma=jitter, interval=1 / timing.rate, mean=mean, strongest=channel, unit=_integral(unit))
        found.append(Finding(details=details, severity="info", size=jitter, unit="s"))
    return tuple(found)


def _integral(unit: str) -> str:
    return _INTEGRALS.get(unit, f"{unit} s")


def _of_channel(stream: Stream, channel: str, jitter: float) -> Finding | None:
    """A finding if the scatter would make a considerable part of the quantization noise of an integrating channel."""
    tau0 = stream.grid.tau0
    mean = abs(_mean(stream, channel))
    made = mean * jitter
    # Quantization noise Q contributes -Q²/τ0² to the covariance, other terms nothing.
    seen = math.sqrt(max(-_covariance(stream, channel), 0.0)) * tau0
    unit = _integral(stream.unit)
    share = (made / seen) ** 2 if seen > 0 else math.inf
    if share < _LEAST_SHARE:
        return None
    details = Jitter(sigma=jitter, interval=tau0, mean=mean, strongest=channel, unit=unit, seen=seen, share=share)
    if share > _MOST_SHARE:
        return Finding(details=details, severity="info", channels=(channel,), size=jitter, unit="s")
    own = 1 - share
    factors = (("quantization", 1 / math.sqrt(own)),) if own > _LEAST_OWN else ()
    return Finding(details=details, severity="warning", channels=(channel,), size=made, unit=unit, factors=factors)


def _segments(stream: Stream) -> list[tuple[int, int]]:
    n = stream.grid.n
    if n <= _SEGMENTS * _SEGMENT_LENGTH:
        return [(0, n)]
    return [(int(a), int(a) + _SEGMENT_LENGTH) for a in np.linspace(0, n - _SEGMENT_LENGTH, _SEGMENTS)]


def _mean(stream: Stream, channel: str) -> float:
    k = stream.channels.index(channel)
    parts = [stream.samples.read(k, a, b) for a, b in _segments(stream)]
    total = sum(float(np.nansum(part)) for part in parts)
    return total / max(sum(int(np.count_nonzero(~np.isnan(part))) for part in parts), 1)


def _covariance(stream: Stream, channel: str) -> float:
    """Covariance of samples one interval apart, less that of samples two intervals apart: slow changes cancel.

    With d the differences, E[d²] = 2(γ0 − γ1) and E[d_k d_k+1] = 2γ1 − γ0 − γ2, so that γ1 − γ2 = E[d²]/2 + E[d_k d_k+1].
    """
    k = stream.channels.index(channel)
    squares, products = [], []
    for a, b in _segments(stream):
        d = np.diff(stream.samples.read(k, a, b))
        squares.append(d * d)
        products.append(d[1:] * d[:-1])
    square, product = (
        float(np.nanmean(np.concatenate(parts))) if sum(map(len, parts)) else 0.0 for parts in (squares, products)
    )
    return square / 2 + product
