"""Check for fits with more noise than the noisiest sensors: a sign of motion, another disturbance or a wrong unit."""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence

import numpy as np

from sigmatau.arrays import Floats
from sigmatau.findings.finding import Finding
from sigmatau.findings.fit import BeyondClass
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.noise import terms
from sigmatau.quality.sensor_class import SENSOR_CLASSES

_JUDGED = ("random_walk", "bias_instability", "rate_random_walk")
_OTHER_CAUSES = ("implausible_unit", "gravity", "not_static")  # codes of warnings that explain more noise


# Smallest reported ratio to the noisiest sensor. [1] Measured: fits of 240 simulated axes with its noise, of 20 s to
# 300 s, stay below it.
_MIN_EXCESS = 1.25
# Highest frequency at which densities are compared. [Hz] Study: docs/study/rest.md; below vibration and the filters of
# most sensors.
_HIGHEST = 2.0
# Cycles of the lowest compared frequency in the record. [1] Judgement: the record determines the density of a model there.
_CYCLES = 4.0
# Largest ratio of a compared frequency to the sampling rate. [1] Judgement: below the edge of the band.
_SHARE_OF_RATE = 0.4
# Number of frequencies that are compared. [1] Judgement: three per decade of a long record.
_FREQUENCIES = 12


@functools.lru_cache(maxsize=8)
def _noisiest_density(quantity: str, lowest: float, highest: float, tau0: float) -> Floats:
    """Density of the noisiest sensor; cached, because it is the same for the axes of a sensor."""
    frequencies = np.geomspace(lowest, highest, _FREQUENCIES)
    noisiest = SENSOR_CLASSES[quantity].noisiest
    return np.asarray(np.sum([terms.psd(name, noisiest[name], frequencies, tau0=tau0) for name in _JUDGED], axis=0))


def beyond_class(fitted: NoiseFit, *, findings: Sequence[Finding] = ()) -> list[Finding]:
    """Report a fitted model with more noise below 2 Hz, or a steeper ramp, than the noisiest sensors: at most one finding.

    All terms, processes and resonances are added, because a fit may attribute motion to any of them. Lines and warm-up
    are not included. No finding if a warning in `findings` doubts the unit, or reports bursts or steps.
    """
    limits = SENSOR_CLASSES.get(fitted.quantity)
    if (
        limits is None
        or not fitted.quantified
        or any(
            finding.code in _OTHER_CAUSES and finding.severity == "warning" and fitted.channel in finding.channels
            for finding in findings
        )
    ):
        return []
    highest = min(_HIGHEST, _SHARE_OF_RATE / fitted.tau0, fitted.highest or math.inf)
    lowest = min(_CYCLES / (fitted.n * fitted.tau0), highest)
    frequencies = np.geomspace(lowest, highest, _FREQUENCIES)
    density = fitted.psd(frequencies)
    ratios = np.sqrt(density / _noisiest_density(fitted.quantity, lowest, highest, fitted.tau0))
    strongest = int(np.argmax(ratios))
    times, frequency, size = (
        float(ratios[strongest]),
        float(frequencies[strongest]),
        math.sqrt(float(density[strongest])),
    )
    ramp = abs(fitted.model.get("rate_ramp", 0.0))
    if (ramp_ratio := ramp / limits.noisiest["rate_ramp"]) > times:
        times, frequency, size = ramp_ratio, 0.0, ramp
    if not times > _MIN_EXCESS:
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
