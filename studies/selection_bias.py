"""Bias of the result if the window is chosen by the least scatter of its own noise.

Stationary noise has quiet stretches, and the window whose means scatter least contains less slow noise than any other:
the two most stable of four hours of a rate random walk show half of its Allan variance at τ = 30 min. The choice is
simulated: means over 60 s of records with the given noise (their differences are a stationary Gaussian series of known
covariance, drawn by circulant embedding), the most stable window of each, and its Allan variance over the expected one.

References
----------
R. B. Davies, D. S. Harte, "Tests for Hurst effect", Biometrika 74 (1987), :doi:`10.1093/biomet/74.1.95`, for the generator.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from sigmatau._native.distributions import digamma
from sigmatau._native.gls import Components, Gls
from sigmatau.arrays import Floats, Ints
from sigmatau.fitting.components import power_of_interval
from sigmatau.noise.terms import NOISE, TERMS, avar
from sigmatau.quality.selection.window import block_length, scatter

__all__ = ["SelectionBias", "autocovariance", "selection_bias"]

Models = Mapping[str, Mapping[str, float]]

SEED = 952  # default seed of the simulated records
DRAWS = 1000  # default number of simulated records
_WINDOW_PER_TAU = 3  # averaging times up to a third of the window, as in a fit


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class SelectionBias:
    """Mean effect of choosing the most stable window on one channel."""

    channel: str
    tau: Floats  # averaging times [s]
    ratio: Floats  # Allan variance of the chosen window over that of the noise
    error: Floats  # standard error of the ratio from the number of draws
    factors: Mapping[str, float]  # coefficient of the chosen window over that of the noise
    record: float  # lengths [s]
    window: float
    draws: int

    def at(self, tau: float) -> float:
        """Ratio at an averaging time, interpolated linearly in the logarithm of τ."""
        return float(np.interp(math.log(tau), np.log(self.tau), self.ratio))


def selection_bias(
    models: Models,
    *,
    n: int,
    window: int,
    tau0: float,
    block: int | None = None,
    draws: int = DRAWS,
    rng: int | np.random.Generator = SEED,
) -> dict[str, SelectionBias]:
    """Effect of choosing the most stable window of stationary noise on the Allan variance and the coefficients, by channel.

    Parameters
    ----------
    models : mapping of str to mapping of str to float
        Coefficients of the noise by channel, terms as in `sigmatau.noise.terms.TERMS`; the window is chosen by all channels
        together, as `sigmatau.quality.selection.window.most_stable` does. [SI]
    n, window, block : int
        Samples in the record, in the window, and in the blocks whose means are compared, see `block_length`.
    tau0 : float
        Sample interval. [s]
    draws : int
        Simulated records.
    rng : int or numpy.random.Generator

    Raises
    ------
    ValueError
        For a window that is longer than the record, or shorter than ten blocks; for an unknown term, or without noise.
    """
    block = block_length(window * tau0, tau0) if block is None else block
    blocks, size = n // block, window // block
    if not (block >= 1 and size >= 10 and window <= n):
        raise ValueError(
            f"a window of {window} samples of {n} in blocks of {block}: want 10 blocks, and no more than {n}"
        )
    if not models:
        raise ValueError("no channel was given")
    generator = rng if isinstance(rng, np.random.Generator) else np.random.default_rng(rng)
    means = np.stack([_draw(model, blocks, block, tau0, draws, generator) for model in models.values()], axis=1)
    start = np.argmin(scatter(means, size), axis=-1)
    index = start[:, None] + np.arange(size)
    sizes = _sizes(size)
    result = {}
    for k, (channel, model) in enumerate(models.items()):
        chosen = np.take_along_axis(means[:, k], index, axis=1)
        expected = sum((avar(term, value, m=sizes * block, tau0=tau0) for term, value in model.items()), np.zeros(1))
        ratio, error = _ratios(chosen, means[:, k], sizes, expected)
        result[channel] = SelectionBias(
            channel=channel,
            tau=np.asarray(sizes * (block * tau0), dtype=np.float64),
            ratio=ratio,
            error=error,
            factors=_factors(model, window, tau0, sizes * block, ratio),
            record=n * tau0,
            window=window * tau0,
            draws=draws,
        )
    return result


def _draw(
    model: Mapping[str, float], blocks: int, block: int, tau0: float, draws: int, generator: np.random.Generator
) -> Floats:
    """Block means of records with the given noise, relative to the first; shape (draws, blocks)."""
    unknown = set(model) - set(TERMS)
    if unknown:
        raise ValueError(f"unknown term {min(unknown)!r}; terms: {', '.join(TERMS)}")
    count = blocks - 1
    covariance = np.zeros(count + 1)
    for term in NOISE:
        if model.get(term):
            theta = model[term] ** 2 * tau0 ** (power_of_interval(term) - 2)
            covariance += theta * autocovariance(term, count + 1, block)
    if not covariance[0] > 0:
        raise ValueError("the model has no noise")
    # The eigenvalues of the circulant are the transform of its first row; they are negative only by rounding.
    power = np.maximum(np.fft.rfft(np.concatenate([covariance, covariance[-2:0:-1]])).real, 0.0)
    white = np.fft.rfft(generator.standard_normal((draws, 2 * count)), axis=1)
    differences = np.fft.irfft(white * np.sqrt(power), n=2 * count, axis=1)[:, :count]
    differences += model.get("rate_ramp", 0.0) * block * tau0
    return np.concatenate([np.zeros((draws, 1)), np.cumsum(differences, axis=1)], axis=1)


def _sizes(size: int) -> Ints:
    """Averaging times in whole blocks: about four per octave, up to a third of the window."""
    steps = np.unique(np.round(2.0 ** np.arange(0, math.log2(size / _WINDOW_PER_TAU) + 0.01, 0.25)))
    return np.union1d(steps, [size // 4]).astype(np.int64)


def _variances(means: Floats, sizes: Sequence[int]) -> Floats:
    """Overlapped Allan variances of rows of block means; shape (draws, n_tau)."""
    total = np.concatenate(
        [np.zeros((len(means), 1)), np.cumsum(means - means.mean(axis=1, keepdims=True), axis=1)], axis=1
    )
    columns = []
    for m in sizes:
        z = total[:, 2 * m :] - 2 * total[:, m:-m] + total[:, : -2 * m]
        columns.append((z * z).mean(axis=1) / (2 * m * m))
    return np.stack(columns, axis=1)


def _ratios(chosen: Floats, whole: Floats, sizes: Ints, expected: Floats) -> tuple[Floats, Floats]:
    """Mean Allan variance of the chosen windows over the expected one, with that of the whole records as control variate."""
    chosen_ratios = _variances(chosen, sizes.tolist()) / expected
    control = _variances(whole, sizes.tolist()) / expected - 1
    spread = control.std(axis=0)
    both = ((chosen_ratios - chosen_ratios.mean(axis=0)) * (control - control.mean(axis=0))).mean(axis=0)
    slope = np.divide(both, spread**2, out=np.zeros_like(both), where=spread > 0)
    remainder = chosen_ratios - slope * control
    return np.asarray(remainder.mean(axis=0)), np.asarray(remainder.std(axis=0, ddof=1) / math.sqrt(len(remainder)))


def _factors(model: Mapping[str, float], window: int, tau0: float, m: Ints, ratio: Floats) -> dict[str, float]:
    """Ratio of the coefficients fitted to the mean Allan variances of the chosen windows to the true ones."""
    half = [1 << j for j in range(int(math.log2(window)) + 1)]
    sizes = sorted({size for m_ in half for size in (m_, m_ + m_ // 2) if 1 <= size <= window // _WINDOW_PER_TAU})
    parts = Components(window, tuple(sizes))
    theta = np.array([model.get(term, 0.0) ** 2 * tau0 ** (power_of_interval(term) - 2) for term in NOISE])
    # Below a block the choice has less effect at shorter times, because it reduces slow noise.
    lowered = np.interp(np.log(sizes), np.log(m), ratio)
    short = np.array(sizes) < m[0]
    lowered[short] = 1 - (1 - ratio[0]) * np.array(sizes)[short] / m[0]
    terms = [p for p in range(len(NOISE)) if theta[p] > 0]
    scale = float(np.median(parts.design @ theta))
    try:
        fitted = Gls(parts, parts.design @ theta / scale * lowered, terms).fit(start=theta / scale) * scale
    except FloatingPointError:
        return {}
    return {NOISE[p]: math.sqrt(fitted[p] / theta[p]) for p in terms}


def autocovariance(term: str, lags: int, length: int) -> Floats:
    """Covariance of differences of neighbouring block means at lags 0 … `lags` − 1, for a squared coefficient of 1.

    The fourth difference, at strides of a block of `length` samples, of the phase autocovariance s(l) of the term (one of
    `sigmatau.noise.terms.NOISE`), over length²; the sample interval is 1. Shape (lags,).
    """
    closed_forms = {
        "quantization": [6.0, -4.0, 1.0],
        "random_walk": [2.0 * length, -1.0 * length],
        # (|l|³ − |l|)/12 at strides of a block.
        "rate_random_walk": [(4 * length**3 + 2 * length) / 6, (length**3 - length) / 6],
    }.get(term)
    if closed_forms is None:
        return _flicker(lags, length)
    return np.array([*closed_forms, *[0.0] * lags][:lags]) / length**2


def _flicker(lags: int, length: int) -> Floats:
    """Fourth differences of −J(l)/2π, with J from the closed form of the Allan variance of flicker noise.

    J grows as l² ln l, whose fourth differences lose digits: beyond 64 blocks two terms of the fourth derivative's series
    are used.
    """
    exact = min(lags, 64)
    stride = np.abs(np.arange(-2, exact + 2, dtype=float)) * length
    h = np.where(stride >= 1, (digamma(np.maximum(stride, 1) - 0.5) + np.euler_gamma + 2 * math.log(2)) / 2, 0.0)
    j = -(4 * stride**2 - 1) / 2 * h + 2 * stride * (stride - 1) - (stride - 1) ** 2 / 2
    j[stride < 1] = 0.0
    s = -j / (2 * math.pi)
    result = np.empty(lags)
    result[:exact] = (s[4:] - 4 * s[3:-1] + 6 * s[2:-2] - 4 * s[1:-3] + s[:-4]) / length**2
    distant = np.arange(exact, lags, dtype=float)
    result[exact:] = -(1 + 1 / distant**2) / (math.pi * distant**2)
    return result
