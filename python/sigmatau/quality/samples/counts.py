"""Test for counts of an angle: whether the sum of the samples was rounded instead of each sample, from the growth of the
variance of sums.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from sigmatau.arrays import Floats

# Number of samples from the beginning of the record. [samples] Derived: with 10⁶ samples and noise of three steps,
# rounding of the sum is visible with six standard errors.
_EXAMINED = 1 << 20
# Smallest number of sums whose variance is compared. [1] Derived: its error is then √(3/256), 11 %.
_MIN_SUMS = 256
# Variance of sums above which longer sums are not compared. [steps²] Derived: the rounding is an eighth of it, and
# longer sums contain slow noise.
_MAX_VARIANCE = 2.0
# Shortest sums that are compared in any case. [samples] Derived: the rounding is then an eighth of that of a sample.
_SHORTEST = 8
# Difference in standard errors that is not chance. [1] Derived: ten sizes of sums, 3·10⁻⁶ each.
_ERRORS = 4.5
# Largest deviation from the variance of a rounded sum, over the variance of its rounding. [1] Judgement: allows for
# slow noise and a drifting rate; vibration or a peak of a filter differs more.
_MAX_DEVIATION = 0.12
# Variance of samples below which the positions of an angle within a step may not be uniform. [steps²] Judgement: such
# an angle passes so few steps that most counts come from a few passages.
_MIN_VARIANCE = 0.1
# Largest reduction of the variance of sums of separately rounded samples, over the variance of the rounding. [1]
# Measured: within 0.06 for white noise and for wandering noise.
_UNEXPLAINED = 0.3


_ROUNDING = 0.25  # variance of sums from the white rounding of their ends: 6/12/2 [steps²]
_NOISE = np.geomspace(1e-5, 30.0, 150)  # tested variances of a sample before rounding [steps²]
_HARMONICS = np.arange(1, 33)[:, None]  # harmonics of the rounding error (a sawtooth), with 99 % of its power


def rounding_by_sums(samples: Floats) -> Literal["of_sums", "of_samples"] | None:
    """Whether the sum of samples was rounded, rather than each sample; None if the record does not decide it.

    `samples`: in steps, with any offset. If each sample was rounded, the variance of the sum of m samples is at least m
    times that of one sample, and larger with slow noise or a filter. If the angle was rounded, only the two ends of a sum
    have rounding errors. The growth of the variance then follows from the mean rate and the noise before rounding; only
    the noise is unknown.
    """
    samples = samples[:_EXAMINED]
    sizes, variances, errors = [], [], []
    size = 1
    while len(samples) // size >= _MIN_SUMS:
        sums = samples if size == 1 else samples[: len(samples) // size * size].reshape(-1, size).sum(axis=1)
        variance, error = _variance(sums)
        sizes.append(size)
        variances.append(variance)
        errors.append(_ERRORS * error)
        if size >= _SHORTEST and variance > _MAX_VARIANCE:
            break
        size *= 2
    if len(sizes) < 2 or not variances[0] > 0:
        return None
    m, measured, chance = np.array(sizes), np.array(variances), np.array(errors)
    missing = measured[0] - measured / m
    expected = np.minimum(_ROUNDING, measured[0]) * (1 - 1 / m)
    unsure = np.hypot(chance[0], chance / m)
    if (missing[1:] > np.maximum(unsure, _UNEXPLAINED * expected)[1:]).any():
        allowed = chance + _MAX_DEVIATION * np.minimum(_ROUNDING, measured)
        predicted = _variances_if_rounded(m, steps_per_sample(samples))
        if measured[0] < _MIN_VARIANCE:
            predicted = predicted * (measured[0] / predicted[0])
        # In units of the allowed deviation, for each size and each tested noise.
        deviation = np.abs(predicted - measured[:, None]) / np.maximum(allowed, _ROUNDING * _MIN_VARIANCE)[:, None]
        return "of_sums" if deviation.max(axis=0).min() < 1 else None
    separately = measured[-1] > 1 and (np.abs(missing) + unsure)[-1] < _UNEXPLAINED * expected[-1]
    return "of_samples" if separately else None


def steps_per_sample(samples: Floats) -> float:
    """Mean rate modulo whole steps per sample: −0.5 to 0.5. An offset of the log does not matter."""
    present = samples[np.isfinite(samples)]
    return float(np.rint(present - present[0]).mean() + 0.5) % 1 - 0.5 if len(present) else 0.0


def _variances_if_rounded(m: Floats, rate: float) -> Floats:
    """Variances of sums of m samples of a rounded angle, shape (sizes, noises); `rate` in steps per sample.

    The rounding error of an angle that may be anywhere in a step has the covariance Σⱼ cos(2πj·k·rate)
    exp(−2π²j²k·σ²)/(2π²j²) after k samples, and no correlation with the noise.
    """

    def covariance(k: int) -> Floats:
        turning = np.cos(2 * np.pi * _HARMONICS * k * rate) / (2 * np.pi**2 * _HARMONICS**2)
        return np.asarray((turning * np.exp(-2 * (np.pi * _HARMONICS) ** 2 * k * _NOISE)).sum(axis=0))

    error = {k: covariance(k) for k in {*m.tolist(), *(2 * m).tolist()}}
    return np.stack([k * _NOISE + _ROUNDING - 4 * error[k] + error[2 * k] for k in m.tolist()])


def _variance(sums: Floats) -> tuple[float, float]:
    """Half the mean square of the changes, and its standard error."""
    squares = np.diff(sums)
    squares *= squares
    squares = squares[np.isfinite(squares)] / 2
    if len(squares) < 2:
        return 0.0, math.inf
    return float(squares.mean()), float(squares.std()) * math.sqrt(1.5 / len(squares))
