"""What the scatter of time stamps about their grid says about the samples."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from sigmatau.findings.finding import Finding
from sigmatau.io.read.time.timing import Timing
from sigmatau.record.streams import Stream
from sigmatau.results import two_digits

__all__ = ["scattered"]

_SAID = 0.03  # of the interval: scatter that is worth a word
_PRINTED = 1.3  # times what the step of the clock makes: more than that is no rounding
_MATTERS = 0.2  # share of the quantization noise that is seen, from which on the stamps may have made it
_STRETCHES, _LONG = 64, 4096  # stretches of samples that are looked at, evenly spread, and their length


def scattered(streams: Sequence[Stream], times: Sequence[Timing]) -> tuple[Finding, ...]:
    """Findings about jitter: none where it is what the step of the clock makes, or too small to matter.

    An integrating sensor whose intervals scatter shows its mean times the scatter as noise of its angle or velocity: σ_j |m|
    is quantization noise. A rate that is sampled at another instant is the same rate.
    """
    said: list[Finding] = []
    for timing in times:
        if not _worth_saying(timing):
            continue
        jitter = timing.jitter or 0.0
        own = [s for s in streams if s.grid.jitter == timing.jitter]
        integrating = [s for s in own if s.samples.transforms[0].kind != "rate"]
        if integrating:
            said += [f for s in integrating for channel in s.channels if (f := _of_channel(s, channel, jitter))]
            continue
        largest = max(
            ((abs(_mean(s, c)), c, s.unit) for s in own for c in s.channels if s.quantity != "signal"), default=None
        )
        example = ""
        if largest is not None and largest[0] * jitter > 0:
            level, channel, unit = largest
            integral = {"m/s^2": "m/s", "rad/s": "rad"}.get(unit, f"{unit} s")
            example = f", {channel} {level * jitter:.2g} {integral} of it"
        said.append(
            Finding(
                code="jitter",
                severity="info",
                message=(
                    f"time stamps scatter by {_time(jitter)} (standard deviation) about even times,"
                    f" {two_digits(100 * jitter * timing.rate)} % of the sample interval"
                ),
                size=jitter,
                unit="s",
                effect=f"none on rates of a sensor at rest; increments would show it as quantization noise{example}",
            )
        )
    return tuple(said)


def _worth_saying(timing: Timing) -> bool:
    if timing.jitter is None or not timing.counted:
        return False
    return timing.jitter * timing.rate > _SAID and timing.jitter > _PRINTED * timing.step / math.sqrt(12)


def _of_channel(stream: Stream, channel: str, jitter: float) -> Finding | None:
    """What the scatter would make of a channel that integrates, and whether that is seen in it."""
    tau0 = stream.grid.tau0
    level = abs(_mean(stream, channel))
    made = level * jitter
    seen = (
        math.sqrt(max(-_covariance(stream, channel), 0.0)) * tau0
    )  # quantization Q makes -Q²/τ0² of it, and others none
    unit = {"m/s^2": "m/s", "rad/s": "rad"}.get(stream.unit, f"{stream.unit} s")
    share = (made / seen) ** 2 if seen > 0 else math.inf
    if share < _MATTERS:
        return None
    text = (
        f"time stamps scatter by {_time(jitter)}; times the mean, {level:.3g} {stream.unit}, that is {made:.2g} {unit}"
    )
    if share > 1.5:
        return Finding(
            code="jitter",
            severity="info",
            channel=channel,
            message=f"{text} of quantization noise, and the samples hold at most {seen:.2g} {unit}",
            size=jitter,
            unit="s",
            effect="none: the stamps scatter, the instants of sampling do not",
        )
    own = 1 - share
    return Finding(
        code="jitter",
        severity="warning",
        channel=channel,
        message=f"{text} of the {seen:.2g} {unit} of quantization noise in the samples",
        size=made,
        unit=unit,
        effect=f"{two_digits(min(100 * share, 100))} % of its square is of the instants of sampling, not of the sensor",
        changes=(("quantization", 1 / math.sqrt(own)),) if own > 0.05 else (),
        remedy="let the sensor's own clock trigger the sampling, or take the coefficient as of both together",
    )


def _stretches(stream: Stream) -> list[tuple[int, int]]:
    n = stream.grid.n
    if n <= _STRETCHES * _LONG:
        return [(0, n)]
    return [(int(a), int(a) + _LONG) for a in np.linspace(0, n - _LONG, _STRETCHES)]


def _mean(stream: Stream, channel: str) -> float:
    k = stream.channels.index(channel)
    parts = [stream.samples.read(k, a, b) for a, b in _stretches(stream)]
    total = sum(float(np.nansum(part)) for part in parts)
    return total / max(sum(int(np.count_nonzero(~np.isnan(part))) for part in parts), 1)


def _covariance(stream: Stream, channel: str) -> float:
    """Of samples one interval apart, less that of samples two apart: what changes slowly drops out.

    With d the differences, E[d²] = 2(γ0 − γ1) and E[d_k d_k+1] = 2γ1 − γ0 − γ2, so that γ1 − γ2 = E[d²]/2 + E[d_k d_k+1].
    """
    k = stream.channels.index(channel)
    squares, products = [], []
    for a, b in _stretches(stream):
        d = np.diff(stream.samples.read(k, a, b))
        squares.append(d * d)
        products.append(d[1:] * d[:-1])
    square, product = (
        float(np.nanmean(np.concatenate(parts))) if sum(map(len, parts)) else 0.0 for parts in (squares, products)
    )
    return square / 2 + product


def _time(value: float) -> str:
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)):
        if value >= size:
            return f"{value / size:.3g} {unit}"
    return f"{value / 1e-9:.3g} ns"
