"""Random walk with the Allan variance of slow noise at a horizon."""

from __future__ import annotations

import math

from sigmatau.model.channel import ChannelModel
from sigmatau.noise.terms import SLOW

_SLOW = (*SLOW, "gauss_markov", "resonance")
_SAMPLES_WITHOUT_RATE = 10**6  # samples per horizon if the rate is unknown: flicker noise is then exact to 4e-12


def matching_walk(model: ChannelModel, *, horizon: float, rate: float | None) -> float:
    """K of the random walk that has the Allan variance of the slow noise at a horizon; 0 without slow noise.

    Slow noise is bias instability, rate random walk, ramp, Gauss-Markov processes and resonances: K² = 3·σ²(T)/T with
    their Allan variance σ²(T). Random walk, quantization and sinusoids are excluded: the Allan variance of a sinusoid at
    T depends on its phase there, and the bias state of a filter does not follow it.

    `horizon`: averaging time; rounded to whole samples, see `round_to_samples` [s]; `rate`: sampling rate; without one
    the horizon is not rounded [Hz]; the result is in rad/s²/√Hz or m/s³/√Hz.
    """
    return math.sqrt(3 * slow_avar(model, tau=horizon, rate=rate) / round_to_samples(horizon, rate))


def slow_avar(model: ChannelModel, *, tau: float, rate: float | None) -> float:
    """Allan variance of the slow noise of the model at an averaging time; see `matching_walk`. [(rate unit)²]"""
    m, tau0 = _samples(tau, rate)
    parts = model.avar_of_parts(m=[m], tau0=tau0)
    return sum(float(parts[term][0]) for term in _SLOW if term in parts)


def round_to_samples(horizon: float, rate: float | None) -> float:
    """Averaging time that is matched: the horizon rounded to whole samples, at least one. [s]"""
    m, tau0 = _samples(horizon, rate)
    return m * tau0


def _samples(horizon: float, rate: float | None) -> tuple[int, float]:
    if rate is None:
        return _SAMPLES_WITHOUT_RATE, horizon / _SAMPLES_WITHOUT_RATE
    return max(round(horizon * rate), 1), 1 / rate
