"""A walk that stands for all slow noise of a model at one averaging time, for targets that have nothing but a walk."""

from __future__ import annotations

import math

from sigmatau.model.channel import ChannelModel

__all__ = ["matching_walk", "sampled", "slow_avar"]

_SLOW = ("bias_instability", "rate_random_walk", "rate_ramp", "gauss_markov")
_FINE = 10**6  # samples of a horizon where no rate is known: flicker noise is then exact to 4e-12


def matching_walk(model: ChannelModel, *, horizon: float, rate: float | None) -> float:
    """K of the walk whose Allan variance is that of the model's slow noise at a horizon; 0 if it has none.

    Slow noise is bias instability, rate random walk, ramp and Gauss-Markov processes: K² = 3·σ²(T)/T of these. Random walk
    and quantization are no part of it, and neither are sinusoids: a line is no walk, its Allan variance at T hangs on its
    phase there, and no filter's bias follows it.

    Parameters
    ----------
    model : ChannelModel
    horizon : float
        Averaging time; taken to whole samples, see `sampled`. [s]
    rate : float or None
        Sampling rate; without one the horizon is as it was given. [Hz]

    Returns
    -------
    float
        [rad/s²/√Hz or m/s³/√Hz]
    """
    return math.sqrt(3 * slow_avar(model, tau=horizon, rate=rate) / sampled(horizon, rate))


def slow_avar(model: ChannelModel, *, tau: float, rate: float | None) -> float:
    """Allan variance of the model's slow noise at an averaging time, as `matching_walk` takes both. [(rate unit)²]"""
    m, tau0 = _samples(tau, rate)
    parts = model.avar_of_parts(m=[m], tau0=tau0)
    return sum(float(parts[term][0]) for term in _SLOW if term in parts)


def sampled(horizon: float, rate: float | None) -> float:
    """The horizon in whole samples, at least one: the averaging time that is matched. [s]"""
    m, tau0 = _samples(horizon, rate)
    return m * tau0


def _samples(horizon: float, rate: float | None) -> tuple[int, float]:
    if rate is None:
        return _FINE, horizon / _FINE
    return max(round(horizon * rate), 1), 1 / rate
