"""Picture of the last minutes of live samples: the smallest and the largest sample of each interval, in bounded memory."""

from __future__ import annotations

import math

import numpy as np

from sigmatau.arrays import Floats
from sigmatau.frozen import frozen

_SPAN = 300.0  # time that the picture covers [s]
_BINS = 600  # smallest number of intervals, if there are as many samples


@frozen
class RecentChannel:
    """The picture of a channel.

    Attributes
    ----------
    quantity, unit : str
    low, high : ndarray
        Smallest and largest sample of each interval. [unit]
    start, duration : float
        Beginning of the first interval after the first sample, and length of all intervals. [s]
    """

    quantity: str
    unit: str
    low: Floats
    high: Floats
    start: float
    duration: float


class RecentSamples:
    """Intervals of the samples of all channels. They double in width until they cover the time of the picture.

    Parameters
    ----------
    count : int
        Number of channels.
    rate : float
        [Hz]
    """

    def __init__(self, count: int, rate: float) -> None:
        self.rate = rate
        self.width: int = 1  # number of samples in an interval
        self.first: int = 0  # number of samples before the first interval
        self.low: Floats = np.empty((0, count))
        self.high: Floats = np.empty((0, count))
        self._pending: Floats = np.empty((0, count))
        self._widest = max(1, math.ceil(rate * _SPAN / (2 * _BINS)))

    def push(self, samples: Floats) -> None:
        """Add the next samples, shape (n, n_channels)."""
        x = np.concatenate([self._pending, samples])
        complete = len(x) // self.width
        blocks = x[: complete * self.width].reshape(complete, self.width, x.shape[1])
        self._pending = x[complete * self.width :]
        self.low = np.concatenate([self.low, blocks.min(axis=1)])
        self.high = np.concatenate([self.high, blocks.max(axis=1)])
        while len(self.low) > 2 * _BINS and self.width < self._widest:
            self._double()
        kept_bins = math.ceil(_SPAN * self.rate / self.width)
        if (surplus := len(self.low) - max(kept_bins, _BINS)) > 0:
            self.low, self.high = self.low[surplus:], self.high[surplus:]
            self.first += surplus * self.width

    def _double(self) -> None:
        """Join pairs of intervals. A last interval without a partner is converted back to samples."""
        pairs = len(self.low) // 2
        left_low, left_high = self.low[2 * pairs :], self.high[2 * pairs :]
        shape = (pairs, 2, self.low.shape[1])
        self.low = self.low[: 2 * pairs].reshape(shape).min(axis=1)
        self.high = self.high[: 2 * pairs].reshape(shape).max(axis=1)
        if len(left_low):
            ends = np.resize(np.concatenate([left_low, left_high]), (self.width, left_low.shape[1]))
            self._pending = np.concatenate([ends, self._pending])
        self.width *= 2
