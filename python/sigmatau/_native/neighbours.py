"""Medians and scatter of the neighbours of samples; missing samples are NaN."""

from __future__ import annotations

import math
from statistics import NormalDist

import numpy as np

from sigmatau import _core
from sigmatau.arrays import Floats, Ints


def outliers(x: Floats, *, threshold: float, multiple: float, smallest: float, side: int, part: float) -> Ints:
    """Indices of the samples whose `residuals` are beyond a threshold and a multiple of the `scatter` + `smallest`."""
    return _core.outliers(np.ascontiguousarray(x), [threshold, multiple, smallest], side, _quantile(part))


def residuals(x: Floats, indices: Ints, side: int) -> Floats:
    """Distance of samples from the medians of both sides: the smaller one, or 0 between the two medians.

    A side with fewer than two samples is ignored; NaN if both are.
    """
    return _core.from_sides(np.ascontiguousarray(x), np.ascontiguousarray(indices), side)


def scatter(x: Floats, indices: Ints, part: float) -> Floats:
    """Standard deviation of the 31 samples before or after a spike and its neighbour, from a quantile `part` of their
    changes; 0 if unknown.

    The larger of both sides is used, because a shock has a first sample. If half may be spikes, a quarter replaces the
    median.
    """
    return _core.neighbour_scatter(np.ascontiguousarray(x), np.ascontiguousarray(indices), _quantile(part))


def neighbour_medians(x: Floats, side: int, fewest: int) -> Floats:
    """Median of the samples on both sides of each sample; NaN for fewer than `fewest` of them."""
    return _core.neighbour_medians(np.ascontiguousarray(x), side, fewest)


def _quantile(part: float) -> list[float]:
    """A quantile of the sizes of changes, and that of normal noise."""
    return [part, math.sqrt(2) * NormalDist().inv_cdf((1 + part) / 2)]
