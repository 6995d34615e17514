"""Means of a channel by octaves of averaging time, and their noise at rest."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from sigmatau.arrays import Bools, Floats, median
from sigmatau.findings.finding import Span
from sigmatau.findings.rest import Motion
from sigmatau.quality.samples.common import block_means, means_by_octave, present, row_means
from sigmatau.quality.samples.resolution import find_step
from sigmatau.quality.sensor_class import SENSOR_CLASSES
from sigmatau.record.streams import PLAUSIBLE_RATES, Stream

Counts = NDArray[np.int64]

NORMAL_MEDIAN = 0.6745  # median of absolute standard normal deviates

# noise of the noisiest sensors [SI unit/√Hz]
NOISIEST = {quantity: limits.noisiest["random_walk"] for quantity, limits in SENSOR_CLASSES.items()}


# Number of averaging times, each twice the previous one: 1/16 s to 4 s. [1] Derived: see `_SHORTEST`.
OCTAVES = 7
# Octave of the reference noise for motion, 1/4 s. [octaves] Judgement: slower than most filters of sensors.
FLOOR = 2
# Octave of 1 s. [octaves] Derived: 16 times the shortest.
SECOND = 4
# Number of averaging times, from one sample on, of a stream that is too slow for means of a second. [1] Judgement: the
# longest means contain 16 samples.
_SLOW_OCTAVES = 5
# Octave of such a stream that replaces 1 s: four samples. [octaves] Judgement: a shorter mean has the noise of single
# samples.
_SLOW_SECOND = 2
# Largest second difference caused by rounding, as the deviation of a mean. [steps] Derived: 2/√6 = 0.8 if each mean is
# shifted by half a step; the rest is a margin for uncertain steps.
STEPS = 3.0
# Smallest number of second differences for a level. [1] Judgement: their median tolerates two disturbed ones.
MIN_DIFFERENCES = 5
# Length of the blocks whose noise is compared. [s] Judgement: 40 means of 1/4 s, a standard error of 11 %.
_FLOOR_LENGTH = 10.0
# Share of the quietest blocks, which show the noise of the sensor. [1] Judgement: a sensor is at rest for at least a
# tenth of the record.
_FLOOR_SHARE = 0.1
# Smallest number of blocks for that share. [1] Derived: a tenth of ten is one block.
_MIN_FLOOR_BLOCKS = 10
# Correlation of neighbouring means of 1/4 s above which noise is not white. [1] Judgement: motion has more.
_CORRELATED = 0.3
# Such a correlation in standard errors, for a short record. [1] Derived: probability 1.3·10⁻³.
_CORRELATED_ERRORS = 3.0
# Number of means in the stretches for a correlation, 5 s. [means] Judgement: drifts over 5 s are small compared with
# the noise of means of 1/4 s.
_CORRELATED_MEANS = 20


class OctaveMeans:
    """Means of a channel by octaves of averaging time, and their noise at rest.

    For a stream below 1 Hz the octaves begin at single samples, and four samples replace the octave of a second.
    """

    def __init__(self, stream: Stream, channel: str, base: int, first: int) -> None:
        self.stream: Stream = stream
        self.channel: str = channel
        self.first: int = first
        self.quantity: str = stream.quantity
        self.shortest: float = base * stream.grid.tau0
        self.slow: bool = first > SECOND or not PLAUSIBLE_RATES[0] <= stream.grid.rate <= PLAUSIBLE_RATES[1]
        self.second_octave: int = first + _SLOW_SECOND if self.slow else SECOND
        octaves = range(first, first + _SLOW_OCTAVES if self.slow else OCTAVES)
        means = means_by_octave(block_means(stream, channel, base), len(octaves))
        self.by_octave: dict[int, Floats] = dict(zip(octaves, means, strict=True))
        self.step: float = find_step(stream, channel) or 0.0
        self.floor: float = self._floor()
        self.unit_is_sure: bool = False  # whether gravity confirms the unit

    @property
    def level(self) -> float:
        """Mean of the channel."""
        means = present(self.by_octave[self.second_octave])
        return float(means.mean()) if len(means) else 0.0

    def tau(self, octave: int) -> float:
        """Averaging time of an octave. [s]"""
        return self.shortest * 2.0 ** (octave - self.first)

    def differences(self, octave: int, start: float = 0.0, stop: float = math.inf) -> Floats:
        """Second differences in a stretch, scaled to the standard deviation of one mean."""
        tau = self.tau(octave)
        x = self.by_octave[octave]
        x = x[round(start / tau) : min(round(min(stop / tau, len(x))), len(x))]
        return np.asarray(np.abs(x[:-2] - 2 * x[1:-1] + x[2:]) / math.sqrt(6))

    def median_level(self, octave: int, start: float = 0.0, stop: float = math.inf) -> float:
        """√τ times the deviation of the means of a stretch, estimated from the median; NaN if there are too few means.
        [unit/√Hz]
        """
        d = present(self.differences(octave, start, stop))
        return median(d) / NORMAL_MEDIAN * math.sqrt(self.tau(octave)) if len(d) >= MIN_DIFFERENCES else math.nan

    def rounding_level(self, octave: int) -> float:
        """Median level below which rounding may explain the second differences. [unit/√Hz]"""
        return STEPS * self.step / NORMAL_MEDIAN * math.sqrt(self.tau(octave))

    def reach(self, limit: float, edges: Floats) -> Bools:
        """Whether the median between edges may reach a level at some averaging time, from counts of second differences."""
        start, stop = edges[:-1], edges[1:]
        reached = np.zeros(len(start), dtype=bool)
        for octave in self.by_octave:
            tau, d = self.tau(octave), self.differences(octave)
            number, above = _before(~np.isnan(d)), _before(d > NORMAL_MEDIAN * limit / math.sqrt(tau))
            n = len(number) + 1
            a = np.rint(start / tau).astype(int)
            b = np.minimum(np.rint(np.minimum(stop / tau, n)).astype(int), n) - 2
            some = np.flatnonzero(b > a)
            a, b = a[some], b[some]
            reached[some[2 * (above[b] - above[a]) >= number[b] - number[a]]] = True
        return reached

    def _floor(self) -> float:
        """√τ times the deviation of means in the quiet parts of the record, including rounding. [unit/√Hz]

        In a short record a tenth need not be quiet, but the median of the second differences ignores a short motion.
        """
        octave = max(FLOOR, self.first)
        d, tau = self.differences(octave), self.tau(octave)
        size = min(max(round(_FLOOR_LENGTH / tau), MIN_DIFFERENCES), max(len(d), 1))
        level = present(row_means((d * d)[: len(d) // size * size].reshape(-1, size)))
        quiet = 0.0
        if len(level):  # like NumPy's quantile, which imports masked arrays
            quiet = float(np.interp(_FLOOR_SHARE * (len(level) - 1), np.arange(len(level)), np.sort(level))) * tau
        if len(level) < _MIN_FLOOR_BLOCKS:
            usual = self.median_level(octave)
            quiet = min(quiet, usual * usual) if usual > self.rounding_level(octave) else quiet
        return math.sqrt(quiet + self.step**2 / 12 * self.stream.grid.tau0)

    def limit_floor(self) -> None:
        """Treat noise beyond that of any sensor as motion, unless it is white, which is a sign of a wrong unit."""
        noisiest = NOISIEST[self.quantity]
        if self.floor > noisiest and (self.quantity == "angular_rate" or self.unit_is_sure) and not self._is_white():
            self.floor = noisiest

    def _is_white(self) -> bool:
        """Whether neighbouring means of 1/4 s are uncorrelated, within stretches too short for drifts."""
        x = self.by_octave[max(FLOOR, self.first)]
        size = min(_CORRELATED_MEANS, len(x))
        if size < MIN_DIFFERENCES:
            return True
        rows = x[: len(x) // size * size].reshape(-1, size)
        rows = rows - row_means(rows, share=0.0)[:, None]
        power, pairs = present((rows * rows).ravel()), present((rows[:, 1:] * rows[:, :-1]).ravel())
        total = float(power.sum())
        correlation = float(pairs.sum()) / total if total > 0 else 0.0
        return correlation < max(_CORRELATED, _CORRELATED_ERRORS / math.sqrt(max(len(pairs), 1)))

    def span(self, start: float, stop: float) -> Span:
        """Convert a stretch, in seconds from the first sample, to times in the log."""
        lead, length = self.stream.grid.lead, self.stream.grid.duration
        return lead + max(start, 0.0), lead + min(stop, length)

    def leave_out(self, spans: Iterable[Span]) -> None:
        """Mark the means in some stretches of the log as missing."""
        lead = self.stream.grid.lead
        for octave, x in self.by_octave.items():
            tau = self.tau(octave)
            for start, stop in spans:
                x[max(math.floor((start - lead) / tau), 0) : max(math.ceil((stop - lead) / tau), 0)] = np.nan

    def motion(
        self, kind: Literal["varies", "turns", "tilts", "shakes"], size: float, times: float, tau: float
    ) -> Motion:
        """Build a motion of this channel."""
        return Motion(channel=self.channel, quantity=self.quantity, kind=kind, size=size, times=times, tau=tau)


def _before(flags: Bools) -> Counts:
    before = np.zeros(len(flags) + 1, dtype=np.int64)
    np.cumsum(flags, out=before[1:])
    return before
