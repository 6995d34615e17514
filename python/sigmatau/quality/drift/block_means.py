"""Block means of a channel, and their covariance for each noise term.

Differences of neighbouring block means are stationary for every term. Their covariance at lag l is the fourth difference of
the phase autocovariance s at strides of a block.
"""

from __future__ import annotations

import math

import numpy as np

from sigmatau._native.distributions import digamma
from sigmatau.arrays import Floats
from sigmatau.quality.samples.common import row_means
from sigmatau.record.streams import Stream

__all__ = ["autocovariance", "block_means"]

_LEAST_SHARE = 0.5  # smallest share of its samples that a block must have for its mean to be used


def block_means(stream: Stream, channel: str, *, length: int) -> Floats:
    """Means of a channel over blocks of `length` samples, NaN if half of one is missing; shape (n_blocks,)."""
    count = stream.grid.n // length
    return row_means(stream.column(channel)[: count * length].reshape(count, length), least=_LEAST_SHARE)


def autocovariance(term: str, lags: int, length: int) -> Floats:
    """Covariance of differences of neighbouring block means at lags 0 … `lags` − 1, for a squared coefficient of 1.

    The fourth difference, at strides of a block of `length` samples, of the phase autocovariance s(l) of the term (one of
    `sigmatau.fitting.components.LINEAR`), over length²; the sample interval is 1. Shape (lags,).
    """
    known = {
        "quantization": [6.0, -4.0, 1.0],
        "random_walk": [2.0 * length, -1.0 * length],
        # (|l|³ − |l|)/12 at strides of a block.
        "rate_random_walk": [(4 * length**3 + 2 * length) / 6, (length**3 - length) / 6],
    }.get(term)
    if known is None:
        return _flicker(lags, length)
    return np.array([*known, *[0.0] * lags][:lags]) / length**2


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
    far = np.arange(exact, lags, dtype=float)
    result[exact:] = -(1 + 1 / far**2) / (math.pi * far**2)
    return result
