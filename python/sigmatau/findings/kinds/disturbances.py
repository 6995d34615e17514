"""Kinds of findings about disturbances (motion, shocks, steps of the mean, spikes, start transients) and excluded parts."""

from __future__ import annotations

from typing import Literal

from sigmatau.findings.finding import Details, Span
from sigmatau.frozen import frozen


@frozen
class MotionBurst:
    """A stretch in which one or more axes move."""

    start: float  # from the beginning of the record [s]
    stop: float
    channels: tuple[str, ...]
    # root mean square of the changes from sample to sample over the usual one; where `departure` is not 0, departure
    # over its usual standard deviation
    ratio: float
    # how far the mean moves before it returns; 0 if the changes from sample to sample show the motion [unit of stream]
    departure: float
    shock: bool  # whether the motion lasts no more than a few windows, see `sigmatau.quality.samples.shocks_and_steps`


@frozen
class LevelStep:
    """A lasting change of the mean."""

    time: float  # from the beginning of the record [s]
    uncertainty: float  # half width of the interval that contains the step [s]
    size: float  # new mean less old mean [unit of the stream]
    ratio: float  # size over the standard deviation of the usual difference of means
    window: float  # length of the means that show the step best [s]
    gradual: bool  # whether a line fits better than two constant parts


@frozen
class NotStatic(Details, code="not_static"):
    """Motion of a sensor that should rest: bursts, or steps of the mean."""

    quantity: str  # of the stream
    unit: str
    bursts: tuple[MotionBurst, ...] = ()  # in order of time
    steps: tuple[LevelStep, ...] = ()  # in order of time
    beside_drift: bool = False  # whether the steps were found beside a drift that would hide them
    added_walk: float = 0.0  # rate random walk that the steps add [unit/√s]
    leave_out: tuple[Span, ...] = ()  # stretches to leave out, from the beginning of the log [s]
    # the longest part without a step, from the beginning of the log; None for an end of the record [s]
    keep: tuple[float | None, float | None] | None = None


@frozen
class Spikes(Details, code="spikes"):
    """Single samples far from their neighbours."""

    unit: str  # of the stream
    count: int  # spikes, and samples in the record
    samples: int
    share: float  # spikes over samples that are not missing
    height: float  # the largest, with its sign, from the median of its neighbours [unit of the stream]
    time: float  # of the largest, from the beginning of the record [s]
    more_below: bool  # whether more samples below the threshold are far out than noise makes


@frozen
class StartTransient(Details, code="start_transient"):
    """A record that begins near zero and settles at its mean, as a filter does that starts from zero."""

    settled: float  # from the first sample on [s]


@frozen
class LeftOutOfStream:
    """Samples of a stream that were left out. `duration` in seconds."""

    stream: str
    count: int
    samples: int
    duration: float


@frozen
class LeftOut(Details, code="left_out"):
    """Stretches that were left out, as asked."""

    streams: tuple[LeftOutOfStream, ...]  # those of which samples were left out


@frozen
class ChosenWindow:
    """The most stable window of a stream."""

    stream: str
    start: float  # from the beginning of the record [s]
    # least range of a temperature, least scatter of the other kind of sensor, or of the stream itself
    criterion: Literal["temperature", "other", "own"]
    by: str  # the stream that was looked at
    block: float  # length of the means that were compared [s]
    relative: float  # the range or scatter over the median of all windows


@frozen
class WindowChosen(Details, code="window_chosen"):
    """The most stable windows of a length that were analysed, as asked. `length` in seconds."""

    length: float
    windows: tuple[ChosenWindow, ...]
