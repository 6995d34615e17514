"""Fits with more noise than the noisiest sensors: motion, another disturbance or another unit, whatever the spectrum."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from sigmatau.findings.finding import Finding
from sigmatau.findings.fit import BeyondClass
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.frozen import frozen
from sigmatau.noise import terms
from sigmatau.quality.sensor_class import SENSOR_CLASSES

_JUDGED = ("random_walk", "bias_instability", "rate_random_walk")
_OTHER_CAUSES = ("implausible_unit", "gravity", "not_static")  # codes of warnings that explain more noise


@frozen
class ClassThresholds:
    """Thresholds of `beyond_class`."""

    # Factor over the noisiest sensor: fits of 240 axes at its limits, of 20 s to 300 s, are within it.
    beyond: float = 1.25
    # Highest frequency at which densities are compared, below those of vibration and of the filters of most sensors.
    # [Hz]
    highest: float = 2.0
    cycles: float = 4.0  # least cycles in the record
    share_of_rate: float = 0.4  # highest frequency over the sampling rate
    frequencies: int = 12  # frequencies that are compared


THRESHOLDS = ClassThresholds()


def beyond_class(
    fitted: NoiseFit, *, beside: Sequence[Finding] = (), thresholds: ClassThresholds = THRESHOLDS
) -> list[Finding]:
    """Whether a fitted model has more noise below 2 Hz, or a steeper ramp, than the noisiest sensors: at most one finding.

    All terms, processes and resonances count together, because motion is divided among them in any way. Lines and warm-up
    do not count. None where a warning of `beside` doubts the unit, or names bursts or steps.
    """
    limits = SENSOR_CLASSES.get(fitted.quantity)
    if (
        limits is None
        or not fitted.quantified
        or any(
            finding.code in _OTHER_CAUSES and finding.severity == "warning" and fitted.channel in finding.channels
            for finding in beside
        )
    ):
        return []
    highest = min(thresholds.highest, thresholds.share_of_rate / fitted.tau0, fitted.highest or math.inf)
    lowest = min(thresholds.cycles / (fitted.n * fitted.tau0), highest)
    frequencies = np.geomspace(lowest, highest, thresholds.frequencies)
    density = fitted.psd(frequencies)
    allowed = sum(terms.psd(name, limits.noisiest[name], frequencies, tau0=fitted.tau0) for name in _JUDGED)
    ratios = np.sqrt(density / allowed)
    strongest = int(np.argmax(ratios))
    times, frequency, size = (
        float(ratios[strongest]),
        float(frequencies[strongest]),
        math.sqrt(float(density[strongest])),
    )
    ramp = abs(fitted.model.get("rate_ramp", 0.0))
    if (of_ramp := ramp / limits.noisiest["rate_ramp"]) > times:
        times, frequency, size = of_ramp, 0.0, ramp
    if not times > thresholds.beyond:
        return []
    factors = tuple(
        (name, fitted.observed[name] / limits.noisiest[name])
        for name in _JUDGED
        if fitted.observed.get(name, 0.0) > limits.noisiest[name]
    )
    details = BeyondClass(quantity=fitted.quantity, times=times, frequency=frequency or None)
    unit = fitted.rate_unit + ("/sqrt(Hz)" if frequency else "/s")
    return [
        Finding(details=details, severity="warning", channels=(fitted.channel,), size=size, unit=unit, factors=factors)
    ]
