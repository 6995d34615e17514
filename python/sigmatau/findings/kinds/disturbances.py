"""Kinds of findings about disturbances (motion, shocks, steps of the mean, spikes, start transients) and excluded parts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

from sigmatau.findings.finding import Details, Span

__all__ = [
    "AddedWalk",
    "ChosenWindow",
    "HiddenWalk",
    "LeftOut",
    "LeftOutOfStream",
    "LevelStep",
    "MotionBurst",
    "NotStatic",
    "Rotation",
    "SelectionBias",
    "Spikes",
    "SpikesMasked",
    "StartTransient",
    "WindowChosen",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class MotionBurst:
    """A stretch in which one or more axes move.

    Attributes
    ----------
    start, stop : float
        From the beginning of the record. [s]
    channels : tuple of str
    ratio : float
        Root mean square of the changes from sample to sample over the usual one; where `departure` is not 0, departure
        over its usual standard deviation.
    departure : float
        How far the mean moves before it returns; 0 if the changes from sample to sample show the motion. [unit of stream]
    shock : bool
        Whether the motion lasts no more than a few windows, see `sigmatau.quality.samples.shocks_and_steps`.
    """

    start: float
    stop: float
    channels: tuple[str, ...]
    ratio: float
    departure: float
    shock: bool


@dataclass(frozen=True, slots=True, kw_only=True)
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
        Size over the standard deviation of the usual difference of means.
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


@dataclass(frozen=True, slots=True, kw_only=True)
class Rotation:
    """A mean rate beyond any bias. `rate` in rad/s."""

    rate: float
    stream: str


@dataclass(frozen=True, slots=True, kw_only=True)
class AddedWalk:
    """Rate random walk that levels other than the sensor's own add.

    Attributes
    ----------
    channel, quantity, unit : str
        The channel, what it measures, and its unit.
    coefficient : float
        K that the levels add at averaging times up to their length. [unit/√s]
    factor : float or None
        K with these levels over the sensor's own; None if the sensor's own is 0.
    resolved : bool
        Whether the record shows the sensor's own K; if not, `factor` is a lower limit.
    """

    channel: str
    quantity: str
    unit: str
    coefficient: float
    factor: float | None
    resolved: bool

    @property
    def factors(self) -> tuple[tuple[str, float], ...]:
        """The factor as those of a finding: none if it is only a limit."""
        return (("rate_random_walk", self.factor),) if self.resolved and self.factor is not None else ()


@dataclass(frozen=True, slots=True, kw_only=True)
class NotStatic(Details):
    """Motion of a sensor that should rest: bursts, steps of the mean, or rotation.

    Attributes
    ----------
    quantity, unit : str
        Of the stream.
    rotation : Rotation or None
    bursts : tuple of MotionBurst
        In order of time.
    steps : tuple of LevelStep
        In order of time.
    beside_drift : bool
        Whether the steps were found beside a drift that would hide them.
    strongest : str
        The channel whose random walk the bursts change most; empty without bursts.
    random_walk : float
        Factor by which bursts change the random walk of that channel; 1 without bursts.
    tau : float or None
        Averaging time at which that factor is largest; None without bursts. [s]
    walk : AddedWalk or None
        What the steps add.
    leave_out : tuple of (float, float)
        Stretches to leave out, from the beginning of the log. [s]
    keep : (float or None, float or None) or None
        The longest part without a step, from the beginning of the log; None for an end of the record. [s]
    """

    code: ClassVar[str] = "not_static"

    quantity: str
    unit: str
    rotation: Rotation | None = None
    bursts: tuple[MotionBurst, ...] = ()
    steps: tuple[LevelStep, ...] = ()
    beside_drift: bool = False
    strongest: str = ""
    random_walk: float = 1.0
    tau: float | None = None
    walk: AddedWalk | None = None
    leave_out: tuple[Span, ...] = ()
    keep: tuple[float | None, float | None] | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Spikes(Details):
    """Single samples far from their neighbours.

    Attributes
    ----------
    unit : str
        Of the stream.
    count, samples : int
        Spikes, and samples in the record.
    share : float
        Spikes over samples that are not missing.
    height : float
        The largest, with its sign, from the median of its neighbours. [unit of the stream]
    time : float
        Of the largest, from the beginning of the record. [s]
    added_white : float
        Random walk that the spikes alone make. [unit of the stream·√s]
    more_below : bool
        Whether more samples below the threshold are far out than noise makes: the effect is a lower bound then.
    """

    code: ClassVar[str] = "spikes"

    unit: str
    count: int
    samples: int
    share: float
    height: float
    time: float
    added_white: float
    more_below: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class SpikesMasked(Details):
    """Spikes that were taken for missing samples, as asked."""

    code: ClassVar[str] = "spikes_masked"

    count: int
    samples: int


@dataclass(frozen=True, slots=True, kw_only=True)
class StartTransient(Details):
    """A record that begins near zero and settles at its mean, as a filter does that starts from zero.

    Attributes
    ----------
    settled : float
        From the beginning of the record. [s]
    strongest : str
        The channel whose random walk the transient changes most.
    random_walk, tau : float
        Factor on its random walk, and the averaging time. [-, s]
    keep : (float, None)
        The rest, from the beginning of the log. [s]
    """

    code: ClassVar[str] = "start_transient"

    settled: float
    strongest: str
    random_walk: float
    tau: float
    keep: tuple[float, None]


@dataclass(frozen=True, slots=True, kw_only=True)
class LeftOutOfStream:
    """Samples of a stream that were left out: of the channel with the most. `duration` in seconds."""

    stream: str
    count: int
    samples: int
    duration: float


@dataclass(frozen=True, slots=True, kw_only=True)
class LeftOut(Details):
    """Stretches that were left out, as asked.

    Attributes
    ----------
    faults : tuple of str
        Faults that were left out by name, ``"dropouts"``, ``"stuck"``, ``"copies"``.
    streams : tuple of LeftOutOfStream
        Those of which samples were left out.
    """

    code: ClassVar[str] = "left_out"

    faults: tuple[str, ...]
    streams: tuple[LeftOutOfStream, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class ChosenWindow:
    """The most stable window of a stream.

    Attributes
    ----------
    stream : str
    start : float
        From the first sample of the stream. [s]
    criterion : {"temperature", "other", "own"}
        Least range of a temperature, least scatter of the other kind of sensor, or of the stream itself.
    by : str
        The stream that was looked at.
    block : float
        Length of the means that were compared. [s]
    relative : float
        The range or scatter over the median of all windows.
    """

    stream: str
    start: float
    criterion: Literal["temperature", "other", "own"]
    by: str
    block: float
    relative: float


@dataclass(frozen=True, slots=True, kw_only=True)
class WindowChosen(Details):
    """The most stable windows of a length that were analysed, as asked. `length` in seconds."""

    code: ClassVar[str] = "window_chosen"

    length: float
    windows: tuple[ChosenWindow, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class HiddenWalk:
    """A rate random walk that a window chosen by its own noise does not show.

    Attributes
    ----------
    limit : float
        Upper limit that the window shows. [unit of the stream/√s]
    factor : float
        The limit over that of a window that was not chosen, on average.
    """

    limit: float
    factor: float


@dataclass(frozen=True, slots=True, kw_only=True)
class SelectionBias(Details):
    """Noise that is too small because its window was chosen by its own scatter.

    Attributes
    ----------
    quantity : str
        Of the channel.
    record, window : float
        Lengths. [s]
    ratios : tuple of (float, float)
        Averaging times [s], and the mean Allan variance of chosen windows over that of the noise.
    draws : int
        Simulated choices.
    hidden_walk : HiddenWalk or None
    """

    code: ClassVar[str] = "selection_bias"

    quantity: str
    record: float
    window: float
    ratios: tuple[tuple[float, float], ...]
    draws: int
    hidden_walk: HiddenWalk | None
