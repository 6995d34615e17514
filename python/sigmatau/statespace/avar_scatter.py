"""Covariance of the Allan variances of a record if a model is true, and whether noise dominates it."""

from __future__ import annotations

import functools
import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sigmatau._native import kernels
from sigmatau.errors import DataError
from sigmatau.estimators.allan import DeviationCurve
from sigmatau.model import covariance as covariances
from sigmatau.model.channel import ChannelModel
from sigmatau.model.processes import GaussMarkov, LowPass, Sinusoid
from sigmatau.statespace.bandlimited import filtered_covariance

__all__ = ["check_noise", "check_phases", "covariance_of_model"]

Floats = NDArray[np.float64]

_LINEAR = ("quantization", "random_walk", "bias_instability", "rate_random_walk")

_SMALLEST_SINE = 1e-9
"""Sine of the phase step per sample below which a sinusoid is sampled as a constant, or always at its zeros."""

_MOST_PHASE_SHARE = 0.1
"""Of a standard error of a variance, what may be wrong with it because the share x that a sinusoid's phase moves it by is
not small: the law of the variances is followed to x, and the next order is x²/2."""


def covariance_of_model(
    model: ChannelModel, *, n: int, m: NDArray[np.int64], tau0: float, together: NDArray[np.bool_] | None = None
) -> Floats:
    """Covariance of the Allan variances if the model is true; shape (n_tau, n_tau). Only variances unless `together`."""
    times = [process.time for process in model.gauss_markov]
    noise, ramp = kernels.covariance_tensors(n, m, tau0, correlation_times=times)
    theta = np.array(
        [model.terms.get(term, 0.0) ** 2 for term in _LINEAR] + [process.sigma**2 for process in model.gauss_markov]
    )
    if model.bandwidth is not None:
        theta[_LINEAR.index("random_walk")] = 0.0
    total = np.einsum("p,q,pqij->ij", theta, theta, noise)
    total += model.terms.get("rate_ramp", 0.0) ** 2 * np.einsum("p,pij->ij", theta, ramp)
    if model.bandwidth is not None:
        both = np.ones(len(m), dtype=np.bool_) if together is None else together
        total += _filtered(
            tuple(model.terms.items()),
            model.gauss_markov,
            model.bandwidth,
            n,
            tuple(m.tolist()),
            tau0,
            tuple(both.tolist()),
        )
    if model.sinusoid:
        quiet = replace(model, sinusoid=())
        for line, column, phase in _lines(model, n=n, m=m, tau0=tau0):
            # The squared amplitude that a record shows has the variance 8A²S/(n·tau0).
            density = float(quiet.psd(_folded(line.frequency, tau0), tau0=tau0)[0])
            total += 8 * density / (n * tau0 * line.amplitude**2) * np.outer(column, column)
            total += np.outer(column * phase, column * phase) / 2
    return np.asarray(total)


@functools.lru_cache(maxsize=8)
def _filtered(
    terms: tuple[tuple[str, float], ...],
    processes: tuple[GaussMarkov, ...],
    bandwidth: LowPass,
    n: int,
    m: tuple[int, ...],
    tau0: float,
    together: tuple[bool, ...],
) -> Floats:
    """`filtered_covariance`, cached: it is the same for all records of one length."""
    coefficients = dict(terms)

    def beside(lags: Floats) -> Floats:
        total = np.zeros(lags.shape)
        for term in _LINEAR:
            if term != "random_walk" and term in coefficients:
                total += covariances.phase_of_term(term, coefficients[term], lags, tau0)
        for process in processes:
            total += covariances.phase_of_gauss_markov(process.sigma, process.time, lags, tau0)
        return total

    found = filtered_covariance(
        n=n,
        m=np.array(m, dtype=np.int64),
        tau0=tau0,
        random_walk=coefficients["random_walk"],
        bandwidth=bandwidth,
        beside=beside,
        ramp=coefficients.get("rate_ramp", 0.0),
        together=np.array(together),
    )
    found.setflags(write=False)
    return found


def _lines(model: ChannelModel, *, n: int, m: NDArray[np.int64], tau0: float) -> list[tuple[Sinusoid, Floats, Floats]]:
    """Variances of each sinusoid, and the share of them by which its unknown phase may change those of a record.

    Of a phase φ at the middle of the record, a mean over M second differences has 1 + cos(2φ)·sin(Mω)/(M·sin ω) times the
    variance.
    """
    found = []
    for line in model.sinusoid:
        turn = 2 * math.pi * _folded(line.frequency, tau0) * tau0
        terms = n - 2 * m + 1.0
        share = np.sin(terms * turn) / (terms * math.sin(turn)) if math.sin(turn) > _SMALLEST_SINE else np.ones(len(m))
        found.append((line, kernels.sinusoid_avar(line.amplitude, line.frequency, m, tau0), share))
    return found


def check_noise(model: ChannelModel, curve: DeviationCurve) -> None:
    """Raise `DataError` for a model without noise."""
    if not (set(model.terms) & set(_LINEAR) or model.gauss_markov):
        raise DataError(
            f"the model of {curve.channel} has no noise: nothing in its variances is by chance, and no misfit is more or"
            " less likely; verify a model with noise"
        )


def check_phases(model: ChannelModel, curve: DeviationCurve, m: NDArray[np.int64], variance: Floats) -> None:
    """Raise `DataError` for a model whose variances depend more on the phase of a sinusoid than on noise."""
    expected = model.avar(m=m, tau0=curve.tau0)
    for line, column, share in _lines(model, n=curve.n, m=m, tau0=curve.tau0):
        moved = column * share / expected
        noise = np.sqrt(np.maximum(variance / expected**2 - moved**2 / 2, 0.0))
        # The shares go into V, where they are taken as small; what is wrong with that is a half of their square.
        wrong = np.divide(moved**2 / 2, noise, out=np.full(len(m), np.inf), where=noise > 0)
        if wrong[moved != 0].max(initial=0.0) > _MOST_PHASE_SHARE:
            turns = _folded(line.frequency, curve.tau0) * curve.n * curve.tau0
            raise DataError(
                f"the model of {curve.channel} has a sinusoid at {line.frequency:.4g} Hz, of {turns:.3g} turns in the"
                f" record as it is sampled: its phase alone changes a variance by up to"
                f" {100 * np.abs(moved).max():.2g} %, which hides the noise; verify a longer record, or the model and the"
                " record without it"
            )


def _folded(frequency: float, tau0: float) -> float:
    """Frequency at which a sinusoid appears in samples."""
    turns = frequency * tau0 % 1.0
    return max(min(turns, 1 - turns), 1e-12) / tau0
