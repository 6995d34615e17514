"""Lines of the read-off: the averaging times and the height of each line.

The lines of a curve are fitted together: in the range of each line the sum of all lines equals the curve, on average. A
single line therefore follows the curve, and one of several lines follows the remainder after the others.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.arrays import distinct
from sigmatau.errors import OptionError
from sigmatau.estimators.allan import DeviationCurve
from sigmatau.noise.terms import avar

PER_OCTAVE = 8
"""Largest number of averaging times per octave: neighbours on a dense grid add no information."""

MIN_SHARE = 0.02
"""Smallest mean share of a line in the variance over its range; with less its height is not determined."""

HIDDEN = "the lines of the other terms reach the curve there"
"""Reason to refuse a line if there is no remainder after the other lines."""

_MAX_STEPS = 100  # largest number of steps of the joint fit of all lines
_CONVERGED = 1e-10  # step of the logarithms of the variances below which the joint fit ends
_LARGEST_STEP = 1.0  # largest step of the logarithm of a variance

Span = tuple[float, float]


def as_span(value: object) -> Span:
    """Check a range of averaging times in s; raise `OptionError` unless it is two positive times in order."""
    pair: Any = value
    try:
        first, last = (math.nan if isinstance(part, str | bool) else float(part) for part in pair)
    except (TypeError, ValueError):
        first = last = math.nan
    if not 0 < first <= last < math.inf:
        raise OptionError(f"{{option}}: must be two averaging times in s, the shorter one first, not {_shown(value)}")
    return first, last


def _shown(value: object) -> str:
    if isinstance(value, tuple | list):
        return f"({', '.join(f'{x:g}' if isinstance(x, int | float | np.number) else repr(x) for x in value)})"
    return repr(value)


def thinned(curve: DeviationCurve, usable: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Indices of the usable averaging times of a curve, at most `PER_OCTAVE` per octave."""
    points = np.flatnonzero(usable & (curve.avar > 0))
    bins = np.floor(np.log2(curve.tau[points]) * PER_OCTAVE)
    return points[np.concatenate(([True], np.diff(bins) > 0))[: len(points)]]


def points_between(curve: DeviationCurve, span: Span) -> NDArray[np.intp]:
    """Indices of the averaging times of a curve in a range; none if there are none."""
    return thinned(curve, (curve.tau >= span[0] * (1 - 1e-6)) & (curve.tau <= span[1] * (1 + 1e-6)))


def points_in(curve: DeviationCurve, span: Span) -> NDArray[np.intp]:
    """Indices of the averaging times of a curve in a range.

    Raises
    ------
    OptionError
        If there are none.
    """
    first, last = span
    inside = points_between(curve, span)
    if len(inside):
        return inside
    tau = curve.tau[curve.avar > 0]
    available = f"{len(tau)} from {tau[0]:g} s to {tau[-1]:g} s" if len(tau) else "none that is not 0"
    raise OptionError(
        f"{{option}}: the curve of {curve.channel} has no averaging time from {first:g} s to {last:g} s; it has {available}"
    )


def lay(
    curve: DeviationCurve, ranges: Mapping[str, NDArray[np.intp]], *, held: Mapping[str, float] = MappingProxyType({})
) -> tuple[dict[str, float], dict[str, str]]:
    """Fit a line of each term to its range of a curve.

    The heights c² of the lines solve Σ wᵢ·sᵢ·ln(σ²ᵢ/Σc²) = 0, the sum over the points i of the range of each line, with
    wᵢ = 1/δᵢ² by eq. (26) and the line's share sᵢ of the sum of the lines there. The line of a term is its expected
    variance, straight except for the first samples of flicker noise and of a rate random walk.

    Parameters
    ----------
    curve : DeviationCurve
    ranges : mapping of str to ndarray
        Indices of the points of the line, by term.
    held : mapping of str to float
        Coefficients of the lines that exist already, by term; they do not change. [SI]

    Returns
    -------
    dict of str to float
        Coefficients. [SI]
    dict of str to str
        Reasons by term that has no line.
    """
    remaining = dict(ranges)
    hidden: dict[str, str] = {}
    while remaining:
        heights, shares = _solved(curve, remaining, held)
        names = list(remaining)
        lowest = int(np.argmin(shares.diagonal()))
        if shares[lowest, lowest] >= MIN_SHARE:
            return {name: math.exp(value / 2) for name, value in zip(names, heights, strict=True)}, hidden
        hidden[names[lowest]] = HIDDEN
        del remaining[names[lowest]]
    return {}, hidden


def _solved(
    curve: DeviationCurve, ranges: Mapping[str, NDArray[np.intp]], held: Mapping[str, float]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Logarithms of the squared coefficients, and the mean share of each line (columns) in the range of each (rows)."""
    used = distinct(np.concatenate(list(ranges.values())))
    shape = np.log([avar(name, 1.0, m=curve.m[used], tau0=curve.tau0) for name in ranges])
    weight = np.array([np.isin(used, points) for points in ranges.values()]) / curve.error[used] ** 2
    weight /= weight.sum(axis=1, keepdims=True)
    with np.errstate(divide="ignore"):  # there are no fixed lines
        log_held = np.log(sum_of_lines(curve, held, used))
    measured = np.log(curve.avar[used])
    height = (weight * (measured - shape)).sum(axis=1)
    for _ in range(_MAX_STEPS):
        log_part = height[:, None] + shape
        total = np.logaddexp(np.logaddexp.reduce(log_part, axis=0), log_held)
        share = np.exp(log_part - total)
        responsibility = weight * share
        responsibility /= np.maximum(responsibility.sum(axis=1, keepdims=True), 1e-300)
        slope = responsibility @ share.T + 1e-12 * np.eye(len(height))
        step = np.clip(np.linalg.solve(slope, responsibility @ (measured - total)), -_LARGEST_STEP, _LARGEST_STEP)
        height += step
        if np.abs(step).max() < _CONVERGED or share.max(axis=1).min() < 1e-30:
            break
    return height, weight @ share.T


def sum_of_lines(curve: DeviationCurve, lines: Mapping[str, float], points: NDArray[np.intp]) -> NDArray[np.float64]:
    """Variance of lines at some points of a curve."""
    parts = (avar(name, value, m=curve.m[points], tau0=curve.tau0) for name, value in lines.items())
    return sum(parts, np.zeros(len(points)))
