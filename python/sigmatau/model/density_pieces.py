"""The integral of eq. (11) over a sampled density: a power law or a straight line between neighbouring points.

Each interval is divided so that the density is smooth in every piece: the frequencies of its ends differ by at most a factor
of 2, and the densities by e⁴. A piece in which sin⁴ changes little is integrated by the Gauss-Legendre rule with 20 points.
In other pieces, sin⁴ = 3/8 − cos(2x)/2 + cos(4x)/8, and the integrals of the cosines times the Legendre series of the other
factors are spherical Bessel functions: exact for any number of turns.

References
----------
.. [1] N. S. Bakhvalov, L. G. Vasil'eva, "Evaluation of the integrals of oscillating functions by interpolation at nodes of
   Gaussian quadratures," USSR Comput. Math. Math. Phys. 8 (1968).
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from sigmatau.arrays import Floats

Between = Literal["power law", "linear"]

_POINTS = 20
"""Number of points of the rule in a piece. The Legendre coefficients fall as 5.8^−k where the frequency doubles, to 10⁻¹⁵ at
the last."""

_LARGEST_STEP = 4.0  # largest step of ln S in a piece
_LITTLE = 6.0  # range of 4x about the middle of a piece that the rule integrates [rad]
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(_POINTS)


class Pieces:
    """A sampled density on the nodes of its pieces.

    Parameters
    ----------
    frequency : ndarray, shape (n_f,)
        Rising. [Hz]
    density : ndarray, shape (n_f, ...)
        Two-sided. The diagonal of matrices is positive unless `between` is linear. [unit²/Hz]
    between : {"power law", "linear"}
        Law between neighbouring points. A power law with a 0 at an end is a straight line.
    """

    def __init__(self, frequency: Floats, density: Floats, between: Between) -> None:
        power = _diagonal(density)
        law = (power[:-1] > 0) & (power[1:] > 0) & (between == "power law")
        with np.errstate(divide="ignore", invalid="ignore"):
            rise = np.abs(np.where(law, np.diff(np.log(power), axis=0), 0.0))  # the ratio may overflow
        steps = np.log2(frequency[1:] / frequency[:-1])
        counts = np.maximum(np.ceil(np.maximum(steps, rise.max(axis=-1) / _LARGEST_STEP) - 1e-9), 1).astype(int)
        interval = np.repeat(np.arange(len(counts)), counts)
        share = (np.arange(len(interval)) - np.repeat(np.cumsum(counts) - counts, counts)) / counts[interval]
        ratio = frequency[interval + 1] / frequency[interval]
        self.low: Floats = frequency[interval] * ratio**share
        high = frequency[interval] * ratio ** (share + 1 / counts[interval])
        self.half: Floats = (high - self.low) / 2
        self.nodes: Floats = gauss_nodes(self.low, self.half)
        self.density: Floats = _interpolated(frequency, density, law, interval, self.nodes)

    def integral(self, time: float, tau0: float | None) -> Floats:
        """4 ∫ S·sin⁴(πfT)/(πfT)² df over the pieces; for samples, with n²·sin²(πfτ₀) as the denominator; shape of a
        density. [unit²]
        """
        below = math.pi * time * self.nodes if tau0 is None else time / tau0 * np.sin(math.pi * tau0 * self.nodes)
        smooth = self.density / below.reshape(below.shape + (1,) * (self.density.ndim - 2)) ** 2
        return np.asarray(4 * integrals_under_sine(smooth, self.low, self.half, time).sum(axis=0))


def gauss_nodes(low: Floats, half: Floats) -> Floats:
    """Points of the rule in pieces that begin at `low` and are twice `half` long; shape (n_pieces, n_points)."""
    return (low + half)[:, None] + half[:, None] * _NODES


def integrals_under_sine(smooth: Floats, low: Floats, half: Floats, time: float) -> Floats:
    """The integrals ∫ smooth·sin⁴(πfT) df over pieces, from values at their `gauss_nodes`; shape (n_pieces, ...)."""
    turning = 4 * math.pi * time * half > _LITTLE
    result = np.empty((len(low), *smooth.shape[2:]))
    nodes = gauss_nodes(low[~turning], half[~turning])
    kernel = np.sin(math.pi * time * nodes) ** 4 * _WEIGHTS * half[~turning, None]
    result[~turning] = np.einsum("ij,ij...->i...", kernel, smooth[~turning])
    if turning.any():
        result[turning] = _oscillating(smooth[turning], low[turning], half[turning], time)
    return result


def _oscillating(smooth: Floats, low: Floats, half: Floats, time: float) -> Floats:
    """The integrals over pieces in which sin⁴ oscillates often, by the Legendre series of the other factors."""
    from scipy.special import spherical_jn

    order = np.arange(_POINTS)
    legendre = np.polynomial.legendre.legvander(_NODES, _POINTS - 1)
    series = np.einsum("jk,ij...->ik...", legendre * _WEIGHTS[:, None] * (order + 0.5), smooth)
    weights = np.zeros((len(half), _POINTS))
    weights[:, 0] = 0.375 * 2
    for turn, height in ((2.0, -0.5), (4.0, 0.125)):
        # ∫ P_k(t)·exp(jωt) dt = 2·j^k·j_k(ω)
        phase = np.exp(1j * turn * math.pi * time * (low + half))[:, None]
        bessel = spherical_jn(order, (turn * math.pi * time * half)[:, None])
        weights += height * 2 * (phase * 1j**order * bessel).real
    return np.asarray(np.einsum("ik,ik...->i...", weights * half[:, None], series))


def _diagonal(density: Floats) -> Floats:
    """Densities of the channels, shape (n_f, channels)."""
    return density[:, None] if density.ndim == 1 else np.einsum("ijj->ij", density)


def _interpolated(
    frequency: Floats, density: Floats, law: NDArray[np.bool_], interval: NDArray[np.intp], nodes: Floats
) -> Floats:
    """The density at the nodes of pieces, from the ends of their intervals.

    The coherences of matrices change linearly with the interpolated coordinate of the law, so that all matrices are
    positive semidefinite.
    """
    lower, upper = frequency[interval, None], frequency[interval + 1, None]
    linear = (nodes - lower) / (upper - lower)
    logarithmic = np.log(nodes / lower) / np.log(upper / lower)
    power = _diagonal(density)
    level = np.empty((*nodes.shape, power.shape[1]))
    for channel in range(power.shape[1]):
        first, last = power[interval, None, channel], power[interval + 1, None, channel]
        by_law = law[interval, channel][:, None]
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            curved = first * (last / first) ** logarithmic
        level[..., channel] = np.where(by_law, curved, first + (last - first) * linear)
    if density.ndim == 1:
        return np.asarray(level[..., 0])
    if not law.any():
        share = linear[..., None, None]
        return np.asarray(density[interval][:, None] * (1 - share) + density[interval + 1][:, None] * share)
    root = np.sqrt(power)
    scale = root[:, :, None] * root[:, None, :]
    coherence = np.divide(density, scale, out=np.zeros_like(density), where=scale > 0)
    share = logarithmic[..., None, None]
    moved = coherence[interval][:, None] * (1 - share) + coherence[interval + 1][:, None] * share
    moved[..., range(power.shape[1]), range(power.shape[1])] = 1.0
    levels = np.sqrt(level)
    return np.asarray(moved * levels[..., :, None] * levels[..., None, :])
