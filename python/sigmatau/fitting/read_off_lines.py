"""The lines of the read-off: which averaging times each uses, and how high it lies.

The lines of a curve are laid together: in the range of each line the sum of all lines lies on the curve, on average. A line
that is alone therefore goes through the curve, and one beside others through what the others leave of it.
"""

from __future__ import annotations

import math
from collections.abc import Container, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.arrays import distinct
from sigmatau.errors import OptionError
from sigmatau.estimators.allan import DeviationCurve
from sigmatau.noise.terms import avar

PER_OCTAVE = 8
"""Averaging times that are used, at most: neighbours on a dense grid add no information."""

LEAST_SHARE = 0.02
"""Least mean share of the variance in its range that a line has; one with less has no definite height."""

_HIDDEN = "the lines of the other terms reach the curve there"
_GIVES_WAY = "it leaves nothing for the line of a given range"
_MOST_STEPS = 100
_CONVERGED = 1e-10
_LARGEST_STEP = 1.0  # of the logarithm of a variance

Span = tuple[float, float]


def span_of(given: object) -> Span:
    """A range of averaging times in s; raises `OptionError` for anything but two positive times in order."""
    pair: Any = given
    try:
        first, last = (math.nan if isinstance(part, str | bool) else float(part) for part in pair)
    except (TypeError, ValueError):
        first = last = math.nan
    if not 0 < first <= last < math.inf:
        raise OptionError(f"{{option}}: must be two averaging times in s, the shorter one first, not {_shown(given)}")
    return first, last


def _shown(given: object) -> str:
    if isinstance(given, tuple | list):
        return f"({', '.join(f'{x:g}' if isinstance(x, int | float | np.number) else repr(x) for x in given)})"
    return repr(given)


def thinned(curve: DeviationCurve, usable: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Indices of the usable averaging times of a curve, at most `PER_OCTAVE` in an octave."""
    at = np.flatnonzero(usable & (curve.avar > 0))
    bins = np.floor(np.log2(curve.tau[at]) * PER_OCTAVE)
    return at[np.concatenate(([True], np.diff(bins) > 0))[: len(at)]]


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
    found = points_between(curve, span)
    if len(found):
        return found
    there = curve.tau[curve.avar > 0]
    known = f"{len(there)} from {there[0]:g} s to {there[-1]:g} s" if len(there) else "none that is not 0"
    raise OptionError(
        f"{{option}}: the curve of {curve.channel} has no averaging time from {first:g} s to {last:g} s; it has {known}"
    )


def lay(
    curve: DeviationCurve, ranges: Mapping[str, NDArray[np.intp]], *, given: Container[str] = ()
) -> tuple[dict[str, float], dict[str, str]]:
    """Lay a line of each term through its range of a curve.

    The heights c² of the lines solve Σ wᵢ·sᵢ·ln(σ²ᵢ/Σc²) = 0, the sum over the points i of the range of each line, with
    wᵢ = 1/δᵢ² by eq. (26) and the line's share sᵢ of the sum of the lines there. The line of a term is its expected
    variance, straight but for the first samples of flicker noise and a random walk of the rate.

    Parameters
    ----------
    curve : DeviationCurve
    ranges : mapping of str to ndarray
        By term, the indices of the points through which its line goes.
    given : container of str
        Terms whose ranges were given. If nothing is left for such a line, the strongest of the other lines is not laid.

    Returns
    -------
    dict of str to float
        Coefficients. [SI]
    dict of str to str
        Terms without a line, and why.
    """
    kept = dict(ranges)
    gone: dict[str, str] = {}
    while kept:
        heights, shares = _solved(curve, kept)
        names = list(kept)
        lost = int(np.argmin(shares.diagonal()))
        if shares[lost, lost] >= LEAST_SHARE:
            return {name: math.exp(value / 2) for name, value in zip(names, heights, strict=True)}, gone
        others = [k for k, name in enumerate(names) if name not in given]
        if names[lost] in given and others:
            lost, reason = max(others, key=lambda k: float(shares[lost, k])), _GIVES_WAY
        else:
            reason = _HIDDEN
        gone[names[lost]] = reason
        del kept[names[lost]]
    return {}, gone


def _solved(
    curve: DeviationCurve, ranges: Mapping[str, NDArray[np.intp]]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Logarithms of the squared coefficients, and the mean share of each line (columns) in the range of each (rows)."""
    used = distinct(np.concatenate(list(ranges.values())))
    shape = np.log([avar(name, 1.0, m=curve.m[used], tau0=curve.tau0) for name in ranges])
    weight = np.array([np.isin(used, at) / curve.error[used] ** 2 for at in ranges.values()])
    weight /= weight.sum(axis=1, keepdims=True)
    measured = np.log(curve.avar[used])
    height = (weight * (measured - shape)).sum(axis=1)
    for _ in range(_MOST_STEPS):
        log_part = height[:, None] + shape
        total = np.logaddexp.reduce(log_part, axis=0)
        share = np.exp(log_part - total)
        of_line = weight * share
        of_line /= of_line.sum(axis=1, keepdims=True)
        slope = of_line @ share.T + 1e-12 * np.eye(len(height))
        step = np.clip(np.linalg.solve(slope, of_line @ (measured - total)), -_LARGEST_STEP, _LARGEST_STEP)
        height += step
        if np.abs(step).max() < _CONVERGED or share.max(axis=1).min() < 1e-30:
            break
    return height, weight @ share.T
