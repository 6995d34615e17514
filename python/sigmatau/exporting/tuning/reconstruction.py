"""Reconstruction of the run of a filter from its innovations: with constant matrices if S is constant, otherwise step by
step.
"""

from __future__ import annotations

from typing import cast

import numpy as np

from sigmatau.arrays import Ints
from sigmatau.errors import OptionError
from sigmatau.exporting.tuning.filters import AGREEMENT, SLOW, WHITE, BiasFilter, Filter, FilterMatrices
from sigmatau.exporting.tuning.innovations import Innovations
from sigmatau.exporting.tuning.run import FilterRun, Steps, constant_run, varying_run

_VARIATION = 1.1  # largest ratio of the quantiles of S, or of the intervals, for a constant gain of the filter
_TAILS = (0.01, 0.99)  # quantiles of the intervals, which ignore rare gaps
_JITTER = 0.25  # largest deviation of a time from a multiple of the interval [intervals]


def reconstruct_run(filter_: Filter, data: Innovations) -> FilterRun:
    """Reconstruct the run of a filter, with the contribution of each noise to its innovations.

    Parameters
    ----------
    filter_ : BiasFilter or FilterMatrices
        Filter with the matrices of these innovations.
    data : Innovations

    Returns
    -------
    FilterRun

    Raises
    ------
    OptionError
        If the S of the filter differs from the stated S, or the matrices are from another run.
    DataError
        If simultaneous measurements have correlated noise.
    """
    count = data.columns.shape[1]
    if isinstance(filter_, BiasFilter):
        if count == 1 and _is_stationary(data):
            matrices = filter_.matrices(interval=data.interval, stated=data.stated)
            return constant_run(matrices.steps, matrices.covariance, np.atleast_1d(cast(float, matrices.R)))
        matrices = _matrices_by_step(filter_, data)
    else:
        matrices = filter_
        if matrices.steps.rows.shape[1] != count:
            raise OptionError(
                f"`H` has {matrices.steps.rows.shape[1]} measurements, and the innovations have {count}."
                " Give a row for each of them",
                option="filters",
            )
        if matrices.is_constant and _is_stationary(data):
            matched = matrices.matrices(interval=data.interval, stated=data.stated)
            return constant_run(matched.steps, matched.covariance, np.atleast_1d(cast(float, matched.R)))
    run = varying_run(_steps_of_run(matrices, data), data)
    if matrices.R is not None:
        used = np.where(run.measured > 0, run.measured, np.nan)
        ratio = np.nanmedian(used, axis=0) / np.atleast_1d(matrices.R)
        if not ((ratio > 1 / AGREEMENT) & (ratio < AGREEMENT)).all():
            worst = float(ratio[np.argmax(np.abs(np.log(ratio)))])
            raise OptionError(
                f"the stated S requires an R of {worst:.3g} times that of the filter."
                " Give the matrices of the filter that made these innovations, or leave out R",
                option="filters",
            )
    return run


def _matrices_by_step(filter_: BiasFilter, data: Innovations) -> FilterMatrices:
    """Build the matrices of an integrated rate and its bias over each interval."""
    steps = np.append(np.diff(data.time), data.interval)
    zero = np.zeros_like(steps)
    count = data.columns.shape[1]
    return FilterMatrices(
        F=np.moveaxis(np.array([[zero + 1, steps], [zero, zero + 1]]), -1, 0),
        H=np.repeat([[1.0, 0.0]], count, axis=0),
        Q={
            WHITE: filter_.noise**2 * np.moveaxis(np.array([[steps, zero], [zero, zero]]), -1, 0),
            SLOW: filter_.walk**2 * np.moveaxis(np.array([[steps**3 / 3, steps**2 / 2], [steps**2 / 2, steps]]), -1, 0),
        },
        R=None if filter_.deviation is None else np.full(count, filter_.deviation**2),
    )


def _is_stationary(data: Innovations) -> bool:
    """Whether S and the interval are constant, and no measurement is absent."""
    if not data.is_present.all():
        return False
    variances = np.diagonal(data.covariance, axis1=1, axis2=2)
    for values in (*variances.T, np.diff(data.time)):
        low, high = np.quantile(values, _TAILS)
        if high > _VARIATION * low:
            return False
    return True


def _steps_of_run(matrices: FilterMatrices, data: Innovations) -> Steps:
    """Build the matrices of each step, repeated over gaps if they are constant."""
    steps, n = matrices.steps, len(data.time)
    lengths = {len(values) for values in (steps.transition, steps.rows, *steps.process.values())} - {1}
    if lengths - {n}:
        raise OptionError(
            f"the matrices are of {max(lengths)} steps, and the innovations are {n}. Give matrices of each innovation",
            option="filters",
        )
    if len(steps.transition) > 1:
        return steps
    numbers = np.diff(data.time) / data.interval
    whole = np.rint(numbers)
    if (np.abs(numbers - whole) > _JITTER).mean() > 1 - _TAILS[1] or (whole < 1).any():
        raise OptionError(
            "F and Q are of one interval, and the times are not whole numbers of it. Give F and Q of each innovation",
            option="filters",
        )
    return _repeat_over_gaps(steps, np.append(whole, 1.0).astype(np.int64))


def _repeat_over_gaps(steps: Steps, numbers: Ints) -> Steps:
    """Compute transition and noise over the intervals between two measurements."""
    (transition,), n = steps.transition, len(numbers)
    whole = np.empty((n, *transition.shape))
    process = {name: np.broadcast_to(noise, whole.shape).copy() for name, noise in steps.process.items()}
    for number in np.unique(numbers):
        rows = numbers == number
        whole[rows] = np.linalg.matrix_power(transition, int(number))
        for noise in process.values():
            added = noise[rows]
            total = added.copy()
            for _ in range(int(number) - 1):
                total = transition @ total @ transition.T + added
            noise[rows] = total
    return Steps(transition=whole, rows=steps.rows, process=process)
