"""Kinds of findings about disturbances (motion, shocks, steps of the mean, spikes, start transients) and excluded parts."""

from __future__ import annotations

import math
from typing import Literal

from sigmatau.findings.finding import Details, Span
from sigmatau.frozen import frozen


@frozen
class MotionBurst:
    """A stretch in which one or more axes move.

    Attributes
    ----------
    start, stop : float
        From the beginning of the record. [s]
    channels : tuple of str
        Axes that move.
    ratio : float
        Root mean square of the changes from sample to sample over the usual one; where `departure` is not 0, departure
        over its usual standard deviation. [1]
    departure : float
        How far the mean moves before it returns; 0 if the changes from sample to sample show the motion. [unit of
        stream]
    shock : bool
        Whether the motion lasts no more than a few windows, see `sigmatau.quality.samples.shocks_and_steps`.
    """

    start: float
    stop: float
    channels: tuple[str, ...]
    ratio: float
    departure: float
    shock: bool


@frozen
class LevelStep:
    """A lasting change of the mean.

    Attributes
    ----------
    time : float
        From the beginning of the record. [s]
    uncertainty : float
        Half width of the interval that contains the step. [s]
    size : float
        New mean less old mean. [unit of the stream]
    ratio : float
        Size over the standard deviation of the usual difference of means. [1]
    window : float
        Length of the means that show the step best. [s]
    gradual : bool
        Whether a line fits better than two constant parts.
    """

    time: float
    uncertainty: float
    size: float
    ratio: float
    window: float
    gradual: bool


@frozen
class NotStatic(Details, code="not_static"):
    """Motion of a sensor that should be at rest: bursts, or steps of the mean.

    Attributes
    ----------
    quantity, unit : str
        Of the stream.
    bursts : tuple of MotionBurst
        In order of time.
    steps : tuple of LevelStep
        In order of time.
    beside_drift : bool
        Whether the steps were found beside a drift that would hide them.
    added_walk : float
        Rate random walk that the steps add. [unit/√s]
    leave_out : tuple of (float, float)
        Stretches to leave out, from the beginning of the log. [s]
    keep : (float or None, float or None) or None
        The longest part without a step, from the beginning of the log; None for an end of the record. [s]
    """

    quantity: str
    unit: str
    bursts: tuple[MotionBurst, ...] = ()
    steps: tuple[LevelStep, ...] = ()
    beside_drift: bool = False
    added_walk: float = 0.0
    leave_out: tuple[Span, ...] = ()
    keep: tuple[float | None, float | None] | None = None

    def possible_factors(self, size: float | None) -> dict[str, float]:
        """Steps of the mean may be all of the rate random walk."""
        return {"rate_random_walk": math.inf} if self.added_walk > 0 else {}


@frozen
class Spikes(Details, code="spikes"):
    """Single samples far from their neighbours.

    Attributes
    ----------
    unit : str
        Of the stream.
    count, samples : int
        Spikes, and samples in the record.
    share : float
        Number of spikes divided by the number of samples that are not missing. [1]
    height : float
        The largest, with its sign, from the median of its neighbours. [unit of the stream]
    time : float
        Of the largest, from the beginning of the record. [s]
    more_below : bool
        Whether there are more large samples below the threshold than the noise can explain.
    """

    unit: str
    count: int
    samples: int
    share: float
    height: float
    time: float
    more_below: bool


@frozen
class StartTransient(Details, code="start_transient"):
    """A record that begins near zero and settles at its mean, like the output of a filter that starts from zero.

    Attributes
    ----------
    settled : float
        From the first sample on. [s]
    """

    settled: float


@frozen
class LeftOutOfStream:
    """Samples of a stream that were left out.

    Attributes
    ----------
    stream : str
        Name of the stream.
    count : int
        Samples that were left out.
    samples : int
        Samples of the stream.
    duration : float
        Length of what was left out. [s]
    """

    stream: str
    count: int
    samples: int
    duration: float


@frozen
class LeftOut(Details, code="left_out"):
    """Stretches that were left out as requested.

    Attributes
    ----------
    streams : tuple of LeftOutOfStream
        Streams from which samples were left out.
    """

    streams: tuple[LeftOutOfStream, ...]


@frozen
class ChosenWindow:
    """The most stable window of a stream.

    Attributes
    ----------
    stream : str
        Name of the stream.
    start : float
        From the beginning of the record. [s]
    criterion : {"temperature", "other", "own"}
        Least range of a temperature, least scatter of the other kind of sensor, or of the stream itself.
    by : str
        The stream that was looked at.
    block : float
        Length of the means that were compared. [s]
    relative : float
        The range or scatter over the median of all windows. [1]
    """

    stream: str
    start: float
    criterion: Literal["temperature", "other", "own"]
    by: str
    block: float
    relative: float


@frozen
class WindowChosen(Details, code="window_chosen"):
    """The most stable windows of a given length, which were analysed as requested.

    Attributes
    ----------
    length : float
        Length of a window. [s]
    windows : tuple of ChosenWindow
        By stream.
    """

    length: float
    windows: tuple[ChosenWindow, ...]
