"""Findings about disturbances (motion, shocks, steps of the mean, spikes, start transients) and excluded parts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

from sigmatau.digits import significant
from sigmatau.findings.finding import Details, Finding, Span, Words, axes_text
from sigmatau.findings.phrases import LONGEST, clock, leave_out_hint, percent, while_short, window_hint
from sigmatau.frozen import frozen
from sigmatau.hints import Hint
from sigmatau.noise.terms import TERMS, display_units
from sigmatau.results import duration_text, seconds

_GRAVITY = 9.80665  # m/s²
_WALK = "rate_random_walk"


@frozen
class MotionBurst:
    """A stretch in which one or more axes move.

    Attributes
    ----------
    start, stop : float
        Start and end, from the beginning of the record. [s]
    channels : tuple of str
        Axes that move.
    ratio : float
        Root mean square of the changes from sample to sample, over its usual value; where `departure` is not 0, the
        departure over its usual standard deviation. [1]
    departure : float
        Distance that the mean moves before it returns; 0 if the changes from sample to sample show the motion. [unit of
        the stream]
    shock : bool
        Whether the motion lasts no more than a few windows, see `sigmatau.quality.motion.shocks_and_steps`.
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
        Time from the beginning of the record. [s]
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
        Quantity and unit of the stream.
    bursts : tuple of MotionBurst
        Bursts in order of time.
    steps : tuple of LevelStep
        Steps in order of time.
    beside_drift : bool
        Whether the steps were found after the removal of a drift that would hide them.
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
        """A rate random walk of the fit may consist only of steps of the mean."""
        return {"rate_random_walk": math.inf} if self.added_walk > 0 else {}

    def words(self, finding: Finding) -> Words:
        effects = [_walk_text(self), _tilt(self)] if self.steps else []
        parts = [_bursts(self.bursts), _steps(self)]
        message = " and ".join(filter(None, parts)) + (", in addition to a drift" if self.beside_drift else "")
        return Words(while_short(message, effects), _selection_text(self))


@frozen
class Spikes(Details, code="spikes"):
    """Single samples far from their neighbours.

    Attributes
    ----------
    unit : str
        Unit of the stream.
    count, samples : int
        Number of spikes, and number of samples in the record.
    share : float
        Number of spikes divided by the number of samples that are not missing. [1]
    height : float
        Largest spike, relative to the median of its neighbours, with its sign. [unit of the stream]
    time : float
        Time of the largest spike, from the beginning of the record. [s]
    more_below : bool
        Whether there are more large samples below the threshold than the noise can explain.
    tail_factor : float
        Ratio of the random walk with the spikes to that without them, if they are a tail of the noise; otherwise
        1. [1]
    tail_error : float
        Relative standard error of the random walk with the spikes. [1]
    small_factor : float
        Ratio of the random walk without the spikes to that without small spikes too; 1 without small spikes. [1]
    """

    unit: str
    count: int
    samples: int
    share: float
    height: float
    time: float
    more_below: bool
    tail_factor: float = 1.0
    tail_error: float = 0.0
    small_factor: float = 1.0

    @property
    def biases_walk(self) -> bool:
        return True

    def words(self, finding: Finding) -> Words:
        height = f"{significant(self.height, sign='+')} {self.unit}"
        fact = f"1 spike of {height} at {clock(self.time)}"
        if self.count > 1:
            share = percent(self.share)
            fact = f"{self.count} spikes ({share}), the largest {height} at {clock(self.time)}"
        if self.small_factor > 1 and finding.left_out:
            smaller = f"{100 * (1 - 1 / self.small_factor):.2g} %"
            return Words(
                f"{fact}, and smaller ones in the noise",
                f"Use the interval of the random walk: it contains the value without small spikes, {smaller} less",
            )
        if not self.more_below:
            return Words(fact)
        if self.tail_factor > 1:
            larger = f"{100 * (self.tail_factor - 1):.2g} %"
            return Words(
                f"{fact}, in a continuous tail of the noise",
                f"Use the interval of the random walk: it contains the value with spikes, {larger} more"
                if finding.left_out
                else "",
            )
        return Words(
            f"{fact}, and smaller ones in the noise",
            f"Run again with {Hint('keep', value='spikes')}: the random walk is between the two results"
            if finding.left_out
            else "",
        )


@frozen
class StartTransient(Details, code="start_transient"):
    """A record that begins near zero and settles at its mean, like the output of a filter that starts from zero.

    Attributes
    ----------
    settled : float
        Time from the first sample until the signal has settled. [s]
    """

    settled: float

    def words(self, finding: Finding) -> Words:
        return Words(f"the record starts near zero and settles within {duration_text(self.settled)}")


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
        Total length of the left-out samples. [s]
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

    def words(self, finding: Finding) -> Words:
        streams = self.streams
        if not streams:
            return Words("no samples excluded: the option matches no samples")
        first = streams[0]
        if len({(stream.count, stream.samples) for stream in streams}) == 1:
            lasting = f"{percent(first.count / first.samples)}, {duration_text(first.duration)}"
            names = axes_text([stream.stream for stream in streams])
            return Words(f"{first.count} of {first.samples} samples of {names} excluded as requested ({lasting})")
        parts = [f"{stream.count} samples of {stream.stream} ({duration_text(stream.duration)})" for stream in streams]
        return Words(while_short(f"excluded as requested: {parts[0]}", parts[1:], between=", "))


@frozen
class ChosenWindow:
    """The most stable window of a stream.

    Attributes
    ----------
    stream : str
        Name of the stream.
    start : float
        Start, from the beginning of the record. [s]
    criterion : {"temperature", "other", "own"}
        Smallest range of a temperature, smallest scatter of the other kind of sensor, or smallest scatter of the stream
        itself.
    by : str
        The stream whose values were used.
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

    def words(self, finding: Finding) -> Words:
        parts = [_window(stream) for stream in self.windows]
        message = while_short(
            f"most stable window of {duration_text(self.length)}: {parts[0]}", parts[1:], between=", "
        )
        if not any(stream.criterion == "own" for stream in self.windows):
            return Words(message)
        return Words(
            message, "Analyse the whole record: a window chosen by its noise underestimates the noise of the sensor"
        )


def _selection_text(details: NotStatic) -> str:
    if details.leave_out:
        return f"Run with {leave_out_hint(details.leave_out, longest=LONGEST - len('Run with '))}"
    if details.keep is not None:
        return f"Run with {window_hint(details.keep)} to keep the longest part without a step"
    return ""


def _bursts(bursts: Sequence[MotionBurst]) -> str:
    if not bursts:
        return ""
    strongest = max(bursts, key=lambda burst: burst.ratio)
    shocks = all(burst.shock for burst in bursts)
    if len(bursts) == 1:
        lasting = duration_text(strongest.stop - strongest.start)
        return f"{'shock' if shocks else 'motion'} at {clock(strongest.start)} for {lasting}"
    total = duration_text(sum(burst.stop - burst.start for burst in bursts))
    what = f"{len(bursts)} shocks" if shocks else f"{len(bursts)} periods of motion"
    return f"{what}, {total} in total, the strongest at {clock(strongest.start)}"


def _steps(details: NotStatic) -> str:
    if not details.steps:
        return ""
    steps, largest = details.steps, max(details.steps, key=lambda step: abs(step.size))
    size = f"{significant(largest.size, sign='+')} {details.unit}"
    if len(steps) > 1:
        return f"{len(steps)} steps of the mean, the largest {size} {_about(largest)}"
    return f"{'drift' if largest.gradual else 'step'} of the mean by {size} {_about(largest)}"


def _tilt(details: NotStatic) -> str:
    if details.quantity != "acceleration" or details.bursts:
        return ""
    angle = math.degrees(max(abs(step.size) for step in details.steps) / _GRAVITY)
    return f"a tilt of {significant(angle)} deg if the sensor is level"


def _about(step: LevelStep) -> str:
    return f"{'around' if step.gradual else 'at'} {clock(step.time)}"


def _walk_text(details: NotStatic) -> str:
    text, scale = display_units(_WALK, details.quantity, details.unit, [details.added_walk])[0]
    return f"adds {significant(details.added_walk / scale)} {text} of {TERMS[_WALK].label(details.quantity)}"


def _window(window: ChosenWindow) -> str:
    by = "its scatter" if window.criterion == "own" else window.by
    return f"{window.stream} from {seconds(window.start)} s (chosen by {by})"
