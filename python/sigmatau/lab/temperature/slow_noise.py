"""Generalised least squares of block means with random walk, bias instability and rate random walk of unknown sizes.

The noise of a sensor is coloured: its means over minutes are correlated, and an ordinary fit of a polynomial would state
errors that are several times too small. The covariance of the block means is σ²·(R_N + b²·R_B + k²·R_K), with the exact
covariances R of the three terms. σ is known from the random walk of the samples, or is integrated out; b and k are averaged
over a grid with the restricted likelihood as weight. The result allows for slow noise that the record neither shows nor
excludes.

Noise is taken about its mean over the record, because flicker noise and a random walk have no expected mean: their mean
is part of the bias of the run. The constant of a fit is therefore the bias of this run.

References
----------
D. A. Harville, "Maximum likelihood approaches to variance component estimation and to related problems", J. Am. Stat.
Assoc. 72 (1977), :doi:`10.1080/01621459.1977.10480998`. A. Gelman, "Prior distributions for variance parameters in
hierarchical models", Bayesian Analysis 1 (2006), :doi:`10.1214/06-BA117A`.
"""

from __future__ import annotations

import functools

import numpy as np

from sigmatau import ChannelModel
from sigmatau.arrays import Floats, Ints
from sigmatau.frozen import frozen

_TERMS = ("random_walk", "bias_instability", "rate_random_walk")
# Standard deviations of flicker noise and of the rate random walk in the block means, over that of the random walk.
# [1] Judgement: from noise that no record shows to noise that hides the random walk.
_RATIOS = 10.0 ** np.linspace(-1.5, 2.0, 29)
_WALK_RATIOS = 10.0 ** np.linspace(-1.5, 2.0, 29)
# Power of k in the weights; 0 is a uniform prior of ln k. [1] Study: docs/study/temperature.md. A record can hide a small
# rate random walk: in 250 simulated sets with a small K, 88 % of the 95 % intervals contained the truth with a power of 0,
# and 94 % with 1.25.
_WALK_POWER = 1.25


@frozen(eq=False)
class SlowNoiseFit:
    """Coefficients of a linear model of block means.

    Attributes
    ----------
    coefficients : ndarray, shape (n_columns,)
        [unit of the means per unit of a column]
    covariance : ndarray, shape (n_columns, n_columns)
        Covariance of the coefficients; it includes the uncertainty of the noise.
    noise : ndarray, shape (n, n)
        Covariance of the noise of the block means about its mean over the record. [(unit of the means)²]
    residuals : ndarray, shape (n,)
        Means without the fitted model. [unit of the means]
    """

    coefficients: Floats
    covariance: Floats
    noise: Floats
    residuals: Floats


def fit_slow_noise(
    means: Floats, columns: Floats, positions: Ints, *, samples: int, white: float | None = None
) -> SlowNoiseFit:
    """Fit a linear model to the means of blocks of equal length.

    Parameters
    ----------
    means : ndarray, shape (n,)
        Means of the blocks that are present. [unit]
    columns : ndarray, shape (n, n_columns)
        Model; the first column is constant.
    positions : ndarray of int, shape (n,)
        Numbers of the blocks, which may skip some.
    samples : int
        Samples in a block.
    white : float, optional
        Variance of the block means by the random walk. Default: unknown. [(unit of the means)²]

    Returns
    -------
    SlowNoiseFit
    """
    n = len(means)
    ordinary = np.linalg.lstsq(columns, means, rcond=None)[0]
    rest = means - columns @ ordinary
    scale = float(np.std(rest)) or 1.0
    table = np.column_stack([columns, rest / scale])
    parts, roots = _whitened(tuple(int(k) for k in positions), samples)
    variance = None if white is None else white / scale**2 * (1 - 1 / n)
    posteriors = [_at_ratio(root, table, variance) for root in roots]
    logs = np.concatenate([each.logs for each in posteriors])
    estimates = np.concatenate([each.estimates for each in posteriors])
    covariances = np.concatenate([each.covariances for each in posteriors])
    variances = np.concatenate([each.variances for each in posteriors])
    weights = np.exp(logs - logs.max())
    weights /= weights.sum()
    mean = weights @ estimates
    spread = estimates - mean
    covariance = np.einsum("g,gij->ij", weights, covariances) + (weights * spread.T) @ spread
    flicker, walk = np.repeat(_RATIOS, len(_WALK_RATIOS)), np.tile(_WALK_RATIOS, len(_RATIOS))
    sizes = (weights * variances) @ np.column_stack([np.ones(len(walk)), flicker**2, walk**2])
    noise = np.einsum("q,qij->ij", sizes, np.array(parts))
    coefficients = ordinary + mean * scale
    return SlowNoiseFit(
        coefficients=coefficients,
        covariance=covariance * scale**2,
        noise=noise * scale**2,
        residuals=means - columns @ coefficients,
    )


@frozen(eq=False)
class _Posterior:
    """Results for one b and every k: logarithms of the weights, estimates, covariances, variances of the random walk."""

    logs: Floats
    estimates: Floats
    covariances: Floats
    variances: Floats


def _at_ratio(root: _Root, table: Floats, white: float | None) -> _Posterior:
    """Generalised least squares for one ratio of flicker noise and each ratio of the rate random walk.

    `white`: variance of the random walk; None if it is not known.
    """
    n, p = len(table), table.shape[1] - 1
    turned = root.vectors.T @ table
    spectra = 1 + _WALK_RATIOS[:, None] ** 2 * root.values
    products = (turned[:, :, None] * turned[:, None, :]).reshape(n, -1)
    moments = (1 / spectra @ products).reshape(-1, p + 1, p + 1)
    information, projected = moments[:, :p, :p], moments[:, :p, p]
    inverse = np.linalg.inv(information)
    estimates = np.einsum("kij,kj->ki", inverse, projected)
    rest = np.maximum(moments[:, p, p] - np.einsum("ki,ki->k", estimates, projected), np.finfo(float).tiny)
    determinants = root.determinant + np.log(spectra).sum(axis=1) + np.linalg.slogdet(information)[1]
    misfit = (n - p) * np.log(rest) if white is None else rest / white
    inverse[:, 0, 0] -= 1.0 / n  # removes the constant that `_whitened` added
    variances = rest / (n - p - 2) if white is None else np.full(len(rest), white)
    return _Posterior(
        logs=_WALK_POWER * np.log(_WALK_RATIOS) - 0.5 * (determinants + misfit),
        estimates=estimates,
        covariances=variances[:, None, None] * inverse,
        variances=variances,
    )


@frozen(eq=False)
class _Root:
    """Vectors V and values λ with VᵀAV = 1 and VᵀR_K V = diag(λ), where A = R_N + b²·R_B + a constant."""

    vectors: Floats
    values: Floats
    determinant: float  # logarithm of the determinant of A


@functools.lru_cache(maxsize=4)
def _whitened(positions: tuple[int, ...], samples: int) -> tuple[tuple[Floats, ...], tuple[_Root, ...]]:
    """Covariances of the terms, and for each ratio of flicker noise the basis that whitens the noise for any random walk."""
    from scipy.linalg import eigh

    parts, n = _centred(positions, samples), len(positions)
    roots = []
    for b in _RATIOS:
        # A constant of variance 1/n makes the covariance regular. `_at_ratio` subtracts it from the first coefficient.
        covariance = parts[0] + b * b * parts[1] + 1.0 / n
        values, vectors = eigh(parts[2], covariance, check_finite=False)
        determinant = float(np.linalg.slogdet(covariance)[1])
        roots.append(_Root(vectors=vectors, values=np.maximum(values, 0.0), determinant=determinant))
    return parts, tuple(roots)


def _centred(positions: tuple[int, ...], samples: int) -> tuple[Floats, Floats, Floats]:
    """Covariance of the block means about their mean over all blocks, for each term, scaled to a mean variance of 1."""
    place = np.array(positions)
    apart = np.abs(np.subtract.outer(place, place))
    lags = np.arange(int(apart.max()) + 2)
    parts = []
    for term in _TERMS:
        model = ChannelModel(quantity="angular_rate", terms={term: 1.0})
        phase = model.phase_autocovariance(lags * samples, tau0=1.0 / samples)
        before = np.concatenate([phase[1:2], phase[:-2]])
        covariance = (2 * phase[:-1] - phase[1:] - before)[apart]
        rows = covariance.mean(axis=0)
        covariance = covariance - rows - rows[:, None] + rows.mean()
        parts.append(covariance / float(np.trace(covariance)) * len(place))
    return parts[0], parts[1], parts[2]
