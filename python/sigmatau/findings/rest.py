"""Findings about a sensor that is not at rest, or only for a part of the record."""

from __future__ import annotations

import math
from typing import Literal

from sigmatau.decoding import key
from sigmatau.digits import significant, two_digits
from sigmatau.findings.finding import Details, Finding, Span, Words
from sigmatau.findings.phrases import LONGEST, clock, percent, while_short, window_hint
from sigmatau.frozen import frozen
from sigmatau.hints import Hint
from sigmatau.results import duration_text

_UNITS = {"angular_rate": ("deg/s", math.degrees(1.0))}


@frozen
class Motion:
    """The strongest sign that a sensor moves.

    Attributes
    ----------
    channel : str
        The sensor that shows it.
    quantity : str
        Quantity of the channel.
    kind : {"varies", "turns", "tilts", "shakes", "loud"}
        In this order: the mean varies; the mean rate exceeds any bias; the direction of gravity changes; a hand
        trembles; the noise exceeds that of any sensor and may be aliased motion.
    size : float
        Change of the mean from one averaging time to the next, mean rate, or root mean square of the tremor [SI unit]; angle
        between the directions of gravity [rad]; density of loud noise [SI unit/√Hz].
    times : float
        Size over that of the noise at rest, over the largest bias, or over the largest change that a bias can cause. [1]
    tau : float
        Averaging time, or half the period of the tremor. [s]
    """

    channel: str
    quantity: str
    kind: Literal["varies", "turns", "tilts", "shakes", "loud"]
    size: float
    times: float = key("ratio to the noise at rest, or to the largest bias", null=True)
    tau: float


@frozen
class NotAtRest(Details, code="not_at_rest", alters_all=True):
    """The sensor moves: no coefficients are given.

    Attributes
    ----------
    motion : Motion
        The strongest motion.
    duration : float
        Duration of the record. [s]
    still : tuple of (float, float)
        Longest stretches at rest, the longest first, from the beginning of the log. [s]
    """

    motion: Motion
    duration: float
    still: tuple[Span, ...] = ()

    def words(self, finding: Finding) -> Words:
        in_doubt = self.motion.kind in ("turns", "loud")
        unit = " or the unit is wrong" if in_doubt else ""
        message = f"not at rest{unit}: {_motion(self.motion)}; no coefficients are given"
        if not self.still:
            remedy = "Record the sensor at rest, check the unit," if in_doubt else "Record the sensor at rest,"
            return Words(message, f"{remedy} or run with {Hint('at_rest', value=True)} to analyse the motion as noise")
        options = [f"{window_hint(span)} ({duration_text(span[1] - span[0])} at rest)" for span in self.still]
        return Words(message, while_short(f"Run with {options[0]}", options[1:], between=" or ", longest=LONGEST))


@frozen
class TooShortToTell(Details, code="too_short_to_tell"):
    """The record does not show motion, and is too short to show rest.

    No coefficients are given, unless rest was assumed as requested; the finding is then an info.

    Attributes
    ----------
    duration : float
        Total duration of the samples that are present. [s]
    shortest : float
        Shortest record that the test of rest can judge. [s]
    """

    duration: float
    shortest: float

    def words(self, finding: Finding) -> Words:
        got, need = duration_text(self.duration), duration_text(self.shortest)
        if finding.severity == "info":
            return Words(
                f"{got} are too short to tell rest from motion ({need} needed); analysed as at rest, as requested"
            )
        message = f"too short to tell rest from motion: {got}, {need} needed; no coefficients are given"
        return Words(message, f"Record for longer, or run with {Hint('at_rest', value=True)} if the sensor was at rest")


@frozen
class KeptOfStream:
    """Part of a stream that is analysed, from the beginning of the log.

    Attributes
    ----------
    stream : str
        Name of the stream.
    start : float
        Beginning. [s]
    stop : float
        End. [s]
    left_out : float
        Length of the stretches within this part that are left out. [s]
    share : float
        Share of the record that is analysed. [1]
    """

    stream: str
    start: float
    stop: float
    left_out: float
    share: float


@frozen
class PartlyAtRest(Details, code="partly_at_rest"):
    """The sensor moves during a part of the record; this part is left out.

    Attributes
    ----------
    motion : Motion
        The strongest motion.
    moved : tuple of (float, float)
        Start and end of each motion in order of time, from the beginning of the log. [s]
    kept : tuple of KeptOfStream
        By stream.
    """

    motion: Motion
    moved: tuple[Span, ...]
    kept: tuple[KeptOfStream, ...]

    def words(self, finding: Finding) -> Words:
        with_holes = [stream for stream in self.kept if stream.left_out > 0]
        cut = [stream for stream in self.kept if stream not in with_holes]
        parts = []
        if with_holes:
            parts.append(f"{_motion_times(self.moved)} left out{'' if not cut else f' of {_names(with_holes)}'}")
        if cut:
            name = f"{_names(cut)} " if with_holes else "partly at rest: "
            span, share = f"{clock(cut[0].start)} to {clock(cut[0].stop)}", percent(cut[0].share)
            parts.append(f"{name}analysed from {span}, {share} of the record")
        return Words("; ".join(parts))


@frozen
class AssumedAtRest(Details, code="assumed_at_rest"):
    """The sensor moves, and the motion is analysed as noise, as requested.

    Attributes
    ----------
    motion : Motion
        The strongest motion.
    """

    motion: Motion

    def words(self, finding: Finding) -> Words:
        return Words(f"not at rest: {_motion(self.motion)}; analysed as noise, as requested")


def _motion(motion: Motion) -> str:
    unit, factor = _UNITS.get(motion.quantity, ("m/s^2", 1.0))
    size = f"{significant(factor * motion.size)} {unit}"
    if motion.kind == "turns":
        return f"{motion.channel} turns at {size}"
    if motion.kind == "loud":
        sensor = "gyro" if motion.quantity == "angular_rate" else "accelerometer"
        return f"{motion.channel} has noise of {size}/√Hz, more than any {sensor}"
    if motion.kind == "tilts":
        angle = significant(math.degrees(motion.size))
        return f"gravity changes direction by {angle} deg in {two_digits(motion.tau)} s"
    if motion.kind == "shakes":
        return f"tremor of {size} at {significant(0.5 / motion.tau)} Hz on all gyros"
    return f"{motion.channel} changes by {size} in {two_digits(motion.tau)} s"


def _motion_times(spans: tuple[Span, ...]) -> str:
    total = duration_text(sum(stop - start for start, stop in spans))
    if len(spans) == 1:
        return f"motion at {clock(spans[0][0])} for {total}"
    return f"{len(spans)} periods of motion, {total} in total,"


def _names(streams: list[KeptOfStream]) -> str:
    return " and ".join(stream.stream for stream in streams)
