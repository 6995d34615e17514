"""Medians and scatter of the neighbours of samples; missing samples are NaN."""

from __future__ import annotations

import math
from statistics import NormalDist

import numpy as np

from sigmatau import _core
from sigmatau.arrays import Floats, Ints


def outliers(x: Floats, *, threshold: float, multiple: float, smallest: float, side: int, part: float) -> Ints:
    """Indices of the samples whose `residuals` exceed both `threshold` and `multiple` × (`scatter` + `smallest`)."""
    return _core.outliers(np.ascontiguousarray(x), [threshold, multiple, smallest], side, _quantile(part))


def residuals(x: Floats, indices: Ints, side: int) -> Floats:
    """Distance of each sample from the nearer of the medians of its two sides; 0 if it lies between them.

    A side with fewer than two samples is ignored; NaN if both are.
    """
    return _core.from_sides(np.ascontiguousarray(x), np.ascontiguousarray(indices), side)


def scatter(x: Floats, indices: Ints, part: float) -> Floats:
    """Standard deviation of the noise in 31 samples before or after each index, without the adjacent one; 0 if unknown.

    It is estimated from the quantile `part` of the sample-to-sample differences: 0.5, or 0.25 where half of the
    samples may be spikes. The larger of the two sides is used, so that the first sample of a shock is compared with the
    shock.
    """
    return _core.neighbour_scatter(np.ascontiguousarray(x), np.ascontiguousarray(indices), _quantile(part))


def neighbour_medians(x: Floats, side: int, fewest: int) -> Floats:
    """Median of the samples on both sides of each sample; NaN if there are fewer than `fewest`."""
    return _core.neighbour_medians(np.ascontiguousarray(x), side, fewest)


def _quantile(part: float) -> list[float]:
    """The share of the differences below a quantile, and the value of that quantile for standard normal noise."""
    return [part, math.sqrt(2) * NormalDist().inv_cdf((1 + part) / 2)]
