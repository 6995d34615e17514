"""Random effects of many groups of values at once: arrays of shape (groups, runs), NaN where a group has no value.

The value of a run is the mean of its group, plus a deviation of the run with standard deviation τ, plus an error of known
standard deviation s. Cochran's statistic Q(τ²) = Σ (c − c̄)²/(τ² + s²), with c̄ weighted in the same way, is χ² with k − 1
degrees of freedom at the true τ. Homogeneity is tested by Q(0); τ² solves Q(τ²) = k − 1 [1]_, and its interval Q(τ²) = χ²
[2]_.

References
----------
.. [1] R. C. Paule, J. Mandel, "Consensus values and weighting factors," J. Res. NBS, vol. 87, no. 5, 1982,
   :doi:`10.6028/jres.087.022`.
.. [2] W. Viechtbauer, "Confidence intervals for the amount of heterogeneity in meta-analysis," Statistics in Medicine,
   vol. 26, no. 1, 2007, :doi:`10.1002/sim.2514`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau._native.distributions import (
    chi2_above,
    chi2_below,
    chi2_quantile_above,
    normal_quantile,
    student_below,
    student_quantile,
)
from sigmatau.arrays import Floats, Ints
from sigmatau.frozen import frozen

LEAST_RUNS_OF_OUTLIER = 3
"""Smallest number of runs for an outlier: if two differ, nothing shows which is wrong."""

_CANDIDATES = (
    3  # number of runs, farthest from the mean, that are tested as outliers; p-values are corrected for all runs
)
_MOST_STEPS = 100  # largest number of steps of the search for τ²; 5 to 10 are usual
_PRECISION = 1e-12  # relative precision of τ²
_CHUNK = 1 << 16  # number of values that are processed at a time, so that they stay in the processor's cache


@frozen(eq=False)
class GroupEffects:
    """Estimates by group, of logarithms or plain values; arrays of shape (groups,), NaN where values are too few."""

    k: Ints  # Number of values
    mean: Floats
    mean_error: Floats  # Half of the interval of the mean
    std: Floats  # Standard deviation of the values, ddof = 1
    q: Floats  # Cochran's Q; NaN without errors
    p_value: Floats  # Probability of Q or a larger value if the runs do not differ
    p_low: Floats  # Probability of a smaller value than Q
    tau: Floats  # Standard deviation between runs
    tau_low: Floats
    tau_high: Floats
    error: Floats  # Root mean square of the errors, which the next run is assumed to have
    next_error: Floats  # Half of the prediction interval of one more run
    outlier: Ints  # Position of the run that differs most; -1 if there are too few
    outlier_p: Floats  # Its p-value, corrected for the number of runs


def group_effects(values: Floats, errors: Floats | None, *, level: float) -> GroupEffects:
    """Random effects of each group.

    Parameters
    ----------
    values : ndarray, shape (groups, runs)
        NaN where there is none.
    errors : ndarray, shape (groups, runs), optional
        Positive standard errors of the values. Without them, homogeneity is not tested, and the spread between runs is that
        of the values.
    level : float
        Confidence level of the intervals.
    """
    groups, runs = values.shape
    size = max(1, _CHUNK // max(runs, 1))
    parts = [
        _chunk(values[start : start + size], None if errors is None else errors[start : start + size], level)
        for start in range(0, max(groups, 1), size)
    ]
    return GroupEffects(**{name: np.concatenate([part[name] for part in parts]) for name in parts[0]})


def _chunk(values: Floats, errors: Floats | None, level: float) -> dict[str, NDArray[Any]]:
    valid = np.isfinite(values)
    k = valid.sum(axis=1)
    first = values[np.arange(len(values)), valid.argmax(axis=1)] if values.shape[1] else np.full(len(values), np.nan)
    origin = np.where(k > 0, first, 0.0)
    c = np.where(valid, values - origin[:, None], 0.0)
    spread = np.sqrt(_sum(np.where(valid, c, 0.0) ** 2) / np.maximum(k, 1))
    if errors is None:
        scale = np.where(spread > 0, spread, 1.0)
        v = np.zeros_like(c)
    else:
        scale = np.sqrt(_sum(np.where(valid, errors, 0.0) ** 2) / np.maximum(k, 1))
        scale = np.where(k > 0, scale, 1.0)
        v = np.where(valid, errors / scale[:, None], 1.0) ** 2
    c = c / scale[:, None]
    estimates: dict[str, NDArray[Any]] = {**_scaled_effects(c, v, valid, level, with_errors=errors is not None)}
    for name in ("mean", "mean_error", "std", "tau", "tau_low", "tau_high", "error", "next_error"):
        estimates[name] = estimates[name] * scale
    estimates["mean"] = estimates["mean"] + origin
    return estimates


def _scaled_effects(
    c: Floats, v: Floats, valid: NDArray[np.bool_], level: float, *, with_errors: bool
) -> dict[str, Floats | Ints]:
    k = valid.sum(axis=1)
    has_several = k > 1
    freedom = np.maximum(k - 1, 1)
    plain_mean = _sum(c) / np.maximum(k, 1)
    squares = _sum(np.where(valid, c - plain_mean[:, None], 0.0) ** 2)
    std = np.sqrt(squares / freedom)
    t_mean = by_number(freedom, lambda f: student_quantile(f, (1 + level) / 2))
    tail = (1 - level) / 2
    chi_high = by_number(freedom, lambda f: chi2_quantile_above(f, tail))
    chi_low = by_number(freedom, lambda f: chi2_quantile_above(f, 1 - tail))
    unknown = np.full(len(c), np.nan)
    if with_errors:
        q, _ = _cochran(np.zeros(len(c)), c, v, valid)
        p_value, p_low = chi2_above(freedom, q), chi2_below(freedom, q)
        tau2, low2, high2 = (_solve_tau2(target, c, v, valid, squares) for target in (1.0 * freedom, chi_high, chi_low))
        error2 = _sum(np.where(valid, v, 0.0)) / np.maximum(k, 1)
    else:
        q = p_value = p_low = unknown
        tau2, low2, high2 = squares / freedom, squares / chi_high, squares / chi_low
        error2 = np.zeros(len(c))
    mean, se2 = _mean(tau2, c, v, valid, unit_weights=not with_errors)
    is_single = k == 1  # the error of the value is the only information
    if with_errors:
        mean_error = np.where(is_single, normal_quantile((1 + level) / 2), t_mean) * np.sqrt(se2)
    else:
        mean_error = np.where(has_several, t_mean * np.sqrt(se2), np.nan)
    outlier, outlier_p = _outliers(c, v, valid, tau2, mean, with_errors=with_errors)

    def if_several(x: Floats) -> Floats:
        return np.where(has_several, x, np.nan)

    return {
        "k": k,
        "mean": np.where(k > 0, mean, np.nan),
        "mean_error": np.where(k > 0, mean_error, np.nan),
        "std": if_several(std),
        "q": if_several(q),
        "p_value": if_several(p_value),
        "p_low": if_several(p_low),
        "tau": if_several(np.sqrt(tau2)),
        "tau_low": if_several(np.sqrt(low2)),
        "tau_high": if_several(np.sqrt(high2)),
        "error": np.where(k > 0, np.sqrt(error2), np.nan) if with_errors else unknown,
        "next_error": if_several(t_mean * np.sqrt(tau2 + se2 + error2)),
        "outlier": outlier,
        "outlier_p": outlier_p,
    }


def _sum(x: Floats) -> Floats:
    return np.asarray(np.einsum("ij->i", x))


def by_number(numbers: Ints, function: Callable[[Floats], Floats]) -> Floats:
    """Apply a function to many integers, computing it once for each distinct one."""
    unique, inverse = np.unique(numbers, return_inverse=True)
    return np.asarray(function(unique.astype(np.float64)))[inverse]


def _cochran(tau2: Floats, c: Floats, v: Floats, valid: NDArray[np.bool_]) -> tuple[Floats, Floats]:
    """Q(τ²), and the negative of its derivative."""
    w = valid / (v + tau2[:, None])
    total = np.maximum(_sum(w), 1e-300)
    mean = np.einsum("ij,ij->i", w, c) / total
    terms = w * (c - mean[:, None]) ** 2
    return _sum(terms), np.asarray(np.einsum("ij,ij->i", w, terms))


def _solve_tau2(target: Floats, c: Floats, v: Floats, valid: NDArray[np.bool_], squares: Floats) -> Floats:
    """Solve Q(τ²) = `target` for τ²; 0 if Q(0) is smaller.

    Newton's method is applied to 1/Q, which is linear if all errors are equal, within bounds: Q(τ²) is at most the sum of
    squares divided by τ².
    """
    tau2 = np.zeros(len(c))
    open_rows = np.flatnonzero(_cochran(tau2, c, v, valid)[0] > target)
    low, high = np.zeros(len(open_rows)), squares[open_rows] / target[open_rows]
    t = np.zeros(len(open_rows))
    c, v, valid, target = c[open_rows], v[open_rows], valid[open_rows], target[open_rows]
    for _ in range(_MOST_STEPS):
        if not len(open_rows):
            break
        q, slope = _cochran(t, c, v, valid)
        low, high = np.where(q > target, t, low), np.where(q > target, high, t)
        new = t + q * (q / target - 1) / slope
        new = np.where((new > low) & (new < high), new, 0.5 * (low + high))
        settled = (np.abs(new - t) <= _PRECISION * new) | (high - low <= _PRECISION * high)
        tau2[open_rows] = new
        unsettled = ~settled
        open_rows, t, low, high, target = (
            open_rows[unsettled],
            new[unsettled],
            low[unsettled],
            high[unsettled],
            target[unsettled],
        )
        c, v, valid = c[unsettled], v[unsettled], valid[unsettled]
    return tau2


def _mean(tau2: Floats, c: Floats, v: Floats, valid: NDArray[np.bool_], *, unit_weights: bool) -> tuple[Floats, Floats]:
    """The weighted mean and its variance."""
    if unit_weights:
        k = np.maximum(valid.sum(axis=1), 1)
        return _sum(c) / k, tau2 / k
    w = valid / (v + tau2[:, None])
    total = np.maximum(_sum(w), 1e-300)
    return np.einsum("ij,ij->i", w, c) / total, 1 / total


def _outliers(
    c: Floats, v: Floats, valid: NDArray[np.bool_], tau2: Floats, mean: Floats, *, with_errors: bool
) -> tuple[Ints, Floats]:
    """Find the run that differs most from the others, and its p-value.

    Its deviation from the mean of the others, divided by the standard error of this deviation, has Student's t distribution
    with k − 2 degrees of freedom. The p-value is corrected for the number of runs (Bonferroni).
    """
    k = valid.sum(axis=1)
    worst, p_worst = np.full(len(c), -1, dtype=np.int64), np.full(len(c), np.nan)
    enough = np.flatnonzero(k >= LEAST_RUNS_OF_OUTLIER)
    if not len(enough):
        return worst, p_worst
    c, v, valid, tau2, mean, k = c[enough], v[enough], valid[enough], tau2[enough], mean[enough], k[enough]
    w = 1 / np.maximum(v + tau2[:, None], 1e-300)
    total = _sum(np.where(valid, w, 0.0))
    distance = np.where(
        valid, np.abs(c - mean[:, None]) / np.sqrt(np.maximum(1 / w - 1 / total[:, None], 1e-300)), -1.0
    )
    order = np.argsort(-distance, axis=1, kind="stable")[:, :_CANDIDATES]
    rows = np.arange(len(c))
    freedom = (k - 2).astype(np.float64)
    best, best_p = np.full(len(c), -1, dtype=np.int64), np.full(len(c), np.inf)
    for candidate in order.T:
        rest = valid.copy()
        rest[rows, candidate] = False
        others_values = np.where(rest, c, 0.0)
        middle = _sum(others_values) / (k - 1)
        squares = _sum(np.where(rest, c - middle[:, None], 0.0) ** 2)
        between = _solve_tau2(freedom, others_values, v, rest, squares) if with_errors else squares / freedom
        center, se2 = _mean(between, others_values, v, rest, unit_weights=not with_errors)
        error = np.sqrt(between + se2 + (v[rows, candidate] if with_errors else 0.0))
        deviation = np.abs(c[rows, candidate] - center)
        with np.errstate(divide="ignore", invalid="ignore"):
            t = np.where(deviation > 0, deviation / error, 0.0)
        p = np.minimum(2 * k * student_below(freedom, -np.minimum(t, 1e12)), 1.0)
        better = p < best_p
        best, best_p = np.where(better, candidate, best), np.where(better, p, best_p)
    worst[enough], p_worst[enough] = best, best_p
    return worst, p_worst
