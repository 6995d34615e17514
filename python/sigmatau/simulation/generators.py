"""Generators of the channels of a noise model."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from sigmatau._native import generators
from sigmatau.model.channel import ChannelModel
from sigmatau.model.noise_model import NoiseModel
from sigmatau.model.processes import LowPass
from sigmatau.statespace.state_space import state_space

Floats = NDArray[np.float64]

Flicker = Literal["exact", "poles"]

_ORDER = ("rate_ramp", "quantization", "random_walk", "bias_instability", "rate_random_walk")
_NO_PIVOT = 1e-8  # correlations are known to fewer digits


def noise_of(
    model: NoiseModel, channel: str, *, n: int, tau0: float, seed: int, flicker: Flicker
) -> generators.Generator:
    """The generator of `n` samples of a channel's noise, in SI.

    Noise that is correlated between channels is Σ Lᵢⱼ·uⱼ, with L·Lᵀ the correlation matrix and uⱼ the noise that channel j
    would have alone.
    """
    noise = model.channels[channel]
    made = generators.Generator(n, tau0, seed=seed)
    for term in _ORDER:
        value = noise.terms.get(term)
        if value is None:
            continue
        for number, weight in _shares(model, term, channel):
            if term == "random_walk" and noise.bandwidth is not None:
                transition, root, start = _low_pass(noise.bandwidth, tau0)
                made.add_filtered(weight * value, transition, root, start, channel=number)
            else:
                made.add_term(term, weight * value, channel=number, poles=flicker == "poles")
    own = stream_number(channel)
    for k, process in enumerate(noise.gauss_markov):
        made.add_gauss_markov(process.sigma, process.time, index=k, channel=own)
    for k, line in enumerate(noise.sinusoid):
        made.add_sinusoid(line.amplitude, line.frequency, index=k, channel=own)
    return made


def normal(n: int, *, seed: int, channel: int) -> generators.Generator:
    """A generator of `n` independent normal deviates of variance 1."""
    made = generators.Generator(n, 1.0, seed=seed)
    made.add_term("random_walk", 1.0, channel=channel)
    return made


def stream_number(channel: str) -> int:
    """FNV-1a hash of the name, so that a channel's noise depends on its own name alone."""
    value = 0x811C9DC5
    for byte in channel.encode():
        value = ((value ^ byte) * 0x01000193) & 0xFFFFFFFF
    return value


def _shares(model: NoiseModel, term: str, channel: str) -> list[tuple[int, float]]:
    """Channels whose random numbers make a channel's noise, and the share of each."""
    if not model.correlation.get(term):
        return [(stream_number(channel), 1.0)]
    names = list(model.channels)
    row = correlation_root(model.correlation_matrix(term))[names.index(channel)]
    return [(stream_number(name), float(weight)) for name, weight in zip(names, row, strict=True) if weight]


def correlation_root(matrix: Floats) -> Floats:
    """L, lower triangular, with L·Lᵀ the correlation `matrix`, which may be singular; both of shape (n, n).

    Rows of channels that are independent of those before them are those of the unit matrix.
    """
    size = len(matrix)
    root = np.zeros((size, size))
    for j in range(size):
        left = matrix[j:, j] - root[j:, :j] @ root[j, :j]
        if left[0] > _NO_PIVOT:
            root[j:, j] = left / math.sqrt(left[0])
        else:  # all of this channel is in those before it
            root[j] /= math.sqrt(root[j] @ root[j])
    return root


def _low_pass(bandwidth: LowPass, tau0: float) -> tuple[Floats, Floats, Floats]:
    """Transition, root of the added covariance and of that at the start, for white noise of density 1 behind a filter."""
    system = state_space(ChannelModel(terms={"random_walk": 1.0}, bandwidth=bandwidth), dt=tau0)
    return np.array(system.F), _root(system.Qd), _root(system.P0)


def _root(covariance: Floats) -> Floats:
    """A square root of a matrix by eigenvalues. Eigenvalues that rounding makes negative count as 0."""
    values, vectors = np.linalg.eigh(covariance)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))
