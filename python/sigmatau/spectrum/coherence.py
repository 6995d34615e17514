"""Probability distribution of a measured coherence.

For n independent pairs of Gaussian transforms with the coherence γ², the measured coherence, given the input's power, has a
non-central beta distribution whose non-centrality is gamma distributed. Without coherence it is Beta(1, n − 1).

References
----------
.. [1] N. R. Goodman, "Statistical analysis based on a certain multivariate complex Gaussian distribution," Ann. Math.
   Statist. 34(1), 1963, :doi:`10.1214/aoms/1177704250`.
.. [2] G. C. Carter, C. H. Knapp, A. H. Nuttall, "Estimation of the magnitude-squared coherence function," IEEE Trans. Audio
   Electroacoust. 21(4), 1973, :doi:`10.1109/TAU.1973.1162496`.
"""

from __future__ import annotations

import functools

import numpy as np
from numpy.typing import ArrayLike

from sigmatau._native.distributions import gamma_quantile
from sigmatau.arrays import Floats

_GAMMA_NODES = 30
_HALVINGS = 28
_LARGEST_ATANH = 12.0  # largest atanh γ: 1 − γ² = 1e-10
_MAX_AT_ONCE = 100


def significance(n: ArrayLike, *, level: float = 0.95) -> Floats:
    """Coherence that two independent series exceed with probability 1 − `level`: 1 − (1 − level)^(1/(n − 1)). `n` is
    the number of averaged pairs, half the degrees of freedom; the coherence of a single pair is always 1.
    """
    pairs = np.asarray(n, dtype=np.float64)
    free = np.maximum(pairs - 1, 1e-9)
    return np.asarray(np.where(pairs > 1, -np.expm1(np.log1p(-level) / free), 1.0))


def probability_below(measured: ArrayLike, true: ArrayLike, n: ArrayLike) -> Floats:
    """Probability that the measured coherence of `n` pairs is below `measured` if the true one is `true`; arrays
    broadcast.
    """
    from scipy.special import ncfdtr

    c, truth, pairs = np.broadcast_arrays(*(np.asarray(x, dtype=np.float64) for x in (measured, true, n)))
    nodes, weights = _rule()
    power = gamma_quantile(pairs[..., None], (nodes + 1) / 2)
    odds = (truth / np.maximum(1 - truth, 1e-300))[..., None]
    f = ((pairs - 1) * c / np.maximum(1 - c, 1e-300))[..., None]
    return np.asarray(ncfdtr(2.0, 2 * (pairs[..., None] - 1), 2 * power * odds, f) @ weights / 2)


@functools.cache
def _rule() -> tuple[Floats, Floats]:
    nodes, weights = np.polynomial.legendre.leggauss(_GAMMA_NODES)
    return nodes, weights


def interval(measured: Floats, n: Floats, *, level: float = 0.95) -> tuple[Floats, Floats]:
    """Confidence interval of the true coherence. `low` is 0 where the coherence may be due to chance."""
    low, high = np.zeros(len(measured)), np.ones(len(measured))
    rounded = np.round(n, 2)  # far from the ends of the band the number of pairs differs by less than 1e-5
    for pairs in np.unique(rounded):
        same = np.flatnonzero(rounded == pairs)
        if pairs <= 1:
            continue
        z = np.arctanh(np.sqrt(np.clip(measured[same], 0.0, np.tanh(_LARGEST_ATANH) ** 2)))
        # If many frequencies have the same number, the ends are interpolated on curves.
        grid = np.linspace(z.min(), z.max(), _MAX_AT_ONCE) if len(same) > _MAX_AT_ONCE else z
        ends = [_solve(np.tanh(grid) ** 2, float(pairs), p) for p in ((1 + level) / 2, (1 - level) / 2)]
        low[same], high[same] = (np.tanh(np.interp(z, grid, end) if grid is not z else end) ** 2 for end in ends)
        low[same] *= measured[same] > significance(pairs, level=(1 + level) / 2)
    return low, high


def _solve(measured: Floats, n: float, probability: float) -> Floats:
    """The atanh γ for which the measured coherence is the quantile of `probability`; 0 if it is below the quantile for
    γ = 0.
    """
    # The distribution at γ is about 1/√(2n) wide in atanh γ.
    centre, wide = np.arctanh(np.sqrt(np.minimum(measured, 1 - 1e-10))), 8 / np.sqrt(n) + 8 / n
    low, right = np.maximum(centre - wide, 0.0), np.minimum(centre + wide, _LARGEST_ATANH)
    for _ in range(_HALVINGS):
        middle = (low + right) / 2
        below = probability_below(measured, np.tanh(middle) ** 2, n)
        is_low = below > probability  # the probability falls as γ rises
        low, right = np.where(is_low, middle, low), np.where(is_low, right, middle)
    return np.asarray((low + right) / 2)
