"""Minimum of the Allan deviation of a model in continuous time, as stated in datasheets."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from sigmatau._native import kernels
from sigmatau.arrays import Floats
from sigmatau.model.channel import ChannelModel
from sigmatau.model.covariance import exponential_remainder
from sigmatau.noise.terms import TERMS

_RATE = 1e6  # sampling rate at which a Matérn process is a sum of processes [Hz]
_TAU = (-6.0, 12.0)  # search range for a minimum; a random walk alone has none [log10 s]


def min_adev(
    coefficients: Mapping[str, float], model: ChannelModel | None = None, *, cancelled: bool = False
) -> tuple[float, float]:
    """Minimum of the Allan deviation of terms, and its averaging time [s]; relative error below 1e-6.

    `model` adds its processes, see `processes_avar`.
    """
    low, high = _TAU
    for points in (721, 201):  # the second grid is around the minimum of the first
        log_tau = np.linspace(low, high, points)
        tau = 10.0**log_tau
        avar = sum(value**2 * TERMS[term].deviation(tau) ** 2 for term, value in coefficients.items())
        avar = avar if model is None else avar + processes_avar(model, tau, cancelled=cancelled)
        k = int(np.argmin(avar))
        step = float(log_tau[1] - log_tau[0])
        low, high = float(log_tau[k]) - step, float(log_tau[k]) + step
    return math.sqrt(float(np.asarray(avar)[k])), 10.0 ** float(log_tau[k])


def processes_avar(model: ChannelModel, tau: Floats, *, cancelled: bool = False) -> Floats:
    """σ²(τ) of Gauss-Markov processes and sinusoids (IEEE Std 952-2020, annex C) and resonances. Sinusoids are at the
    maxima of their ripple, or at the minima if they are `cancelled`: a sinusoid averages out over whole periods.
    """
    total = np.zeros_like(tau)
    for process in model.expand_matern(rate=_RATE).gauss_markov:
        at_each = (kernels.gauss_markov_avar(process.sigma, process.time, 1, t, averaged=True)[0] for t in tau.flat)
        total += np.fromiter(at_each, dtype=np.float64).reshape(tau.shape)
    for resonance in model.resonance:
        x = np.asarray((resonance.damping - 1j * resonance.turning) * tau, dtype=np.complex128)
        # variance of a mean, minus the covariance with the next one
        means = 2 * exponential_remainder(x) / x**2 - (np.expm1(-x) / x) ** 2
        total += resonance.sigma**2 * ((1 + 1j * resonance.damping / resonance.turning) * means).real
    for line in model.sinusoid:
        periods = line.frequency * tau
        ripple = np.sin(math.pi * np.minimum(periods, 1.0)) ** 4
        share = np.where(periods >= 1, 0.0, ripple) if cancelled else np.where(periods >= 0.5, 1.0, ripple)
        total += line.amplitude**2 * share / (math.pi * periods) ** 2
    return total
