"""Bias polynomial and hysteresis of one channel from its block means."""

from __future__ import annotations

from typing import Any

import numpy as np

from sigmatau._native.distributions import normal_quantile
from sigmatau.arrays import Bools, Floats, Ints
from sigmatau.frozen import frozen
from sigmatau.lab.temperature.branches import Blocks
from sigmatau.lab.temperature.slow_noise import SlowNoiseFit, fit_slow_noise
from sigmatau.results import plain

MAX_DEGREE = 5
"""Largest degree of a polynomial."""

DEFAULT_DEGREE = 3
"""Largest degree that is chosen: what PX4 and ArduPilot evaluate."""

# Ratio of the highest coefficient to its standard error below which the degree is lowered. [1] Study:
# docs/study/temperature.md.
_LEAST_RATIO = 1.0
# Number of columns of the hysteresis: constant, linear, quadratic. [1] Judgement: a loop closes at its ends.
_HYSTERESIS = 3
# Number of temperatures at which the hysteresis is stated. [1]
_POINTS = 5
# Smallest number of blocks of each branch in the common range. [1] Judgement.
_LEAST_BLOCKS = 10


@frozen(eq=False)
class Hysteresis:
    """Difference of the falling from the rising branch at equal temperature.

    Attributes
    ----------
    temperature : ndarray, shape (n,)
        Temperatures that both branches passed. [°C]
    value, low, high : ndarray, shape (n,)
        Mean on the falling branch minus mean on the rising branch, with its interval. [unit]
    mean, mean_low, mean_high : float
        Average over the common range, with its interval. [unit]
    level : float
        Confidence level.
    unit : str
        SI.
    """

    temperature: Floats
    value: Floats
    low: Floats
    high: Floats
    mean: float
    mean_low: float
    mean_high: float
    level: float
    unit: str

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI."""
        return plain(
            self,
            "temperature_degc=temperature value low high mean mean_low mean_high level unit",
        )


@frozen(eq=False)
class BiasFit:
    """Fit of the block means of a channel: polynomial in (T - middle)/half range, then hysteresis.

    Attributes
    ----------
    degree : int
    fitted : SlowNoiseFit
    present : ndarray of bool, shape (n_blocks,)
        Blocks that were used.
    common : (float, float) or None
        Range of temperatures that both branches cover; None if the hysteresis is not observable. [°C]
    """

    degree: int
    fitted: SlowNoiseFit
    present: Bools
    common: tuple[float, float] | None

    def hysteresis(self, *, level: float, unit: str) -> Hysteresis | None:
        """The hysteresis with its intervals; None if it is not observable."""
        if self.common is None:
            return None
        begin = self.degree + 1
        coefficients = self.fitted.coefficients[begin:]
        covariance = self.fitted.covariance[begin:, begin:]
        temperature = np.linspace(*self.common, _POINTS)
        powers = _powers(temperature, self.common)
        z = float(normal_quantile((1 + level) / 2))
        value = powers @ coefficients
        half = z * np.sqrt(np.einsum("ij,jk,ik->i", powers, covariance, powers))
        # averages of the powers over -1 … 1
        average = np.array([1.0 / (k + 1) if k % 2 == 0 else 0.0 for k in range(_HYSTERESIS)])
        mean, mean_half = float(average @ coefficients), z * float(np.sqrt(average @ covariance @ average))
        return Hysteresis(
            temperature=temperature,
            value=value,
            low=value - half,
            high=value + half,
            mean=mean,
            mean_low=mean - mean_half,
            mean_high=mean + mean_half,
            level=level,
            unit=unit,
        )

    def columns(self, blocks: Blocks, temperature: Floats) -> dict[str, Floats]:
        """Columns of the model by name, at the temperatures of samples, without the constant; each of shape (n,).

        `temperature`: temperature at each sample of the stream. [°C]
        """
        middle, half = (blocks.low + blocks.high) / 2, (blocks.high - blocks.low) / 2
        u = (temperature - middle) / half
        table = {"temperature": u, **{f"temperature^{k}": u**k for k in range(2, self.degree + 1)}}
        if self.common is not None:
            direction = np.repeat(blocks.direction, blocks.samples)
            direction = np.pad(direction, (0, len(u) - len(direction)), mode="edge")
            for k, column in enumerate(_branch_columns(temperature, direction, self.common).T):
                table[f"hysteresis {k}"] = column
        return table


def fit_bias(
    blocks: Blocks, means: Floats, *, degree: int | None, white: float | None = None, least_ratio: float = _LEAST_RATIO
) -> BiasFit:
    """Fit polynomial and hysteresis to block means.

    Parameters
    ----------
    blocks : Blocks
    means : ndarray, shape (n_blocks,)
        NaN for missing blocks. [unit]
    degree : int, optional
        Default: 3, lowered while the highest coefficient is smaller than its standard error.
    white : float, optional
        Variance of the means by the random walk. Default: unknown. [unit²]
    least_ratio : float
        Smallest ratio of the highest coefficient to its standard error. [1]

    Returns
    -------
    BiasFit
    """
    present = np.isfinite(means) & np.isfinite(blocks.temperature)
    t, direction = blocks.temperature[present], blocks.direction[present]
    positions = np.flatnonzero(present)
    low, high = blocks.low, blocks.high
    common, branch_columns = _hysteresis_columns(t, direction)
    powers = np.vander((t - (low + high) / 2) / ((high - low) / 2), MAX_DEGREE + 1, increasing=True)

    def fitted(chosen: int) -> SlowNoiseFit:
        columns = np.column_stack([powers[:, : chosen + 1], branch_columns])
        return fit_slow_noise(means[present], columns, positions, samples=blocks.samples, white=white)

    chosen = DEFAULT_DEGREE if degree is None else degree
    result = fitted(chosen)
    while degree is None and chosen > 0:
        if abs(result.coefficients[chosen]) >= least_ratio * np.sqrt(result.covariance[chosen, chosen]):
            break
        chosen -= 1
        result = fitted(chosen)
    return BiasFit(degree=chosen, fitted=result, present=present, common=common)


def _hysteresis_columns(t: Floats, direction: Ints) -> tuple[tuple[float, float] | None, Floats]:
    """Range of temperatures that both branches cover, and the columns of the hysteresis in it."""
    rising, falling = t[direction > 0], t[direction < 0]
    if min(len(rising), len(falling)) < _LEAST_BLOCKS:
        return None, np.empty((len(t), 0))
    common = float(max(rising.min(), falling.min())), float(min(rising.max(), falling.max()))
    inside = (t >= common[0]) & (t <= common[1])
    if min(np.count_nonzero(inside & (direction == sign)) for sign in (1, -1)) < _LEAST_BLOCKS:
        return None, np.empty((len(t), 0))
    return common, _branch_columns(t, direction, common)


def _branch_columns(t: Floats, direction: Ints, common: tuple[float, float]) -> Floats:
    """Columns of the hysteresis: powers of the temperature times ½ on the falling branch, times -½ on the rising branch,
    and 0 outside the common range.
    """
    inside = (t >= common[0]) & (t <= common[1])
    return _powers(t, common) * np.where(inside, -0.5 * direction, 0.0)[:, None]


def _powers(temperature: Floats, common: tuple[float, float]) -> Floats:
    """Powers of the temperature, -1 … 1 over the common range; shape (n, 3)."""
    middle, half = (common[0] + common[1]) / 2, (common[1] - common[0]) / 2
    return np.vander((temperature - middle) / half, _HYSTERESIS, increasing=True)
