"""What a curve, or its fit, says of itself."""

from __future__ import annotations

import sys
from collections.abc import Mapping

import numpy as np

from sigmatau.estimators.allan import DeviationCurve
from sigmatau.findings.finding import Finding
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.record.streams import Stream
from sigmatau.results import seconds

__all__ = ["LARGEST", "LEAST", "beyond", "constant", "lifeless", "of_fit", "rounding", "strided"]

LEAST, LARGEST = 1e-120, 1e120
"""A fit squares variances."""


_MANY = 0.1  # share of missing samples that may be the reason why there are too few


def of_fit(fitted: NoiseFit, *, missing: float = 0.0) -> list[Finding]:
    """Why a channel was not fitted, or not from its shortest time on; `missing` is the share of its samples that is."""
    if fitted.verdict == "too_short":
        lost = missing > _MANY
        return [
            Finding(
                code="too_short",
                severity="warning",
                channel=fitted.channel,
                message=f"not fitted: {fitted.reason}"
                + (f"; {100 * missing:.3g} % of the samples are missing, which leaves too few to fit" if lost else ""),
                size=missing if lost else None,
                remedy="look for the cause of the loss: a longer record with as many losses helps little"
                if lost
                else "",
            )
        ]
    if fitted.verdict == "descriptive":
        message = f"no adequate model: {fitted.reason}"
        effect = "coefficients without intervals"
        return [
            Finding(
                code="no_adequate_model", severity="warning", channel=fitted.channel, message=message, effect=effect
            )
        ]
    sixth = []
    if fitted.sinusoid:
        line = fitted.sinusoid[0]
        sixth.append(
            Finding(
                code="sinusoid_fitted",
                severity="info",
                channel=fitted.channel,
                message=(
                    f"the five terms alone do not make this curve: a sinusoid of {line.amplitude.value:.3g}"
                    f" {line.amplitude.unit} at {line.frequency.value:.4g} Hz was fitted with them"
                ),
                size=line.amplitude.value,
                unit=line.amplitude.unit,
                effect="the coefficients are those of the noise beside it",
                remedy="look for what swings so slowly or shakes there: temperature control, vibration",
            )
        )
    if fitted.tau_min is not None and fitted.tau_min > 1.5 * fitted.tau0:
        return [
            *sixth,
            Finding(
                code="short_times_left_out",
                severity="info",
                channel=fitted.channel,
                message=f"the model holds from τ = {seconds(fitted.tau_min)} s on: {fitted.reason}",
            ),
        ]
    return sixth


def rounding(stream: Stream, channel: str) -> float:
    """A deviation that rounding alone may leave of a channel that never changes, or only grows evenly."""
    k = stream.channels.index(channel)
    raw, t = stream.samples.raw[k], stream.samples.transforms[k]
    first, last = 0, -1
    if stream.mask is not None:
        first, last = np.flatnonzero(~stream.mask[:, k])[[0, -1]]
    largest = max(abs(float(raw[first])), abs(float(raw[last]))) * abs(t.scale * t.factor)
    if t.kind != "rate":
        largest /= stream.grid.tau0
    return 4 * sys.float_info.epsilon * largest


def beyond(curve: DeviationCurve) -> Finding:
    """Deviations whose squares cannot be squared again."""
    largest = curve.adev.max()
    return Finding(
        code="out_of_range",
        severity="error",
        channel=curve.channel,
        message=f"deviations up to {largest:.3g} {curve.unit} are too {'large' if largest > 1 else 'small'}",
        effect="not analysed; check unit and scale",
    )


def constant(stream: Stream, channel: str) -> Finding:
    """A channel that never changes."""
    k = stream.channels.index(channel)
    first = 0 if stream.mask is None else int(np.flatnonzero(~stream.mask[:, k])[0])
    value = stream.samples.read(k, first, first + 1)[0]
    return Finding(
        code="constant_channel",
        severity="error",
        channel=channel,
        message=f"{stream.grid.n} samples of {value:.6g} {stream.unit} differ by no more than rounding",
        effect="not analysed; check the wiring, the resolution or the column",
    )


def lifeless(stream: Stream) -> list[Finding]:
    """Channels of a sensor that never change, or have no sample at all, without their curves."""
    if stream.quantity == "temperature":
        return []
    said = []
    for channel in stream.channels:
        x = stream.column(channel)
        low, high = float(np.fmin.reduce(x)), float(np.fmax.reduce(x))
        if low != low:
            message = f"none of {stream.grid.n} samples is there"
            said.append(Finding(code="too_few_samples", severity="error", channel=channel, message=message))
        elif high - low <= rounding(stream, channel):
            said.append(constant(stream, channel))
    return said


def strided(curves: Mapping[str, DeviationCurve], name: str | None, why: str = "") -> list[Finding]:
    """From which averaging time on clusters do not begin at every sample."""
    curve = next(iter(curves.values()))
    if curve.stride is None:
        return []
    first = seconds(float(curve.tau[curve.stride > 1][0]))
    return [
        Finding(
            code="strided",
            severity="info",
            channel=name,
            message=f"{why}from τ = {first} s on, clusters begin at every 64th sample or less often",
            effect="spread grows by less than 0.1 % for white noise and slower, by a multiple for quantization noise",
        )
    ]
