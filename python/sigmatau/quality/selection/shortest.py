"""The shortest record that the test of rest can judge, by rate and sensors; studied in studies/rest.py."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from sigmatau.frozen import frozen
from sigmatau.quality.sensor_class import SENSOR_CLASSES, ByQuantity
from sigmatau.record.streams import Stream


@frozen
class LengthThresholds:
    """Thresholds of `shortest_record` and `is_too_short`."""

    shortest: ByQuantity = ByQuantity(angular_rate=10.0, acceleration=20.0)
    """Length of the shortest record. [s] Study: docs/study/rest.md has the shares of moving records that shorter
    ones hide."""

    least_samples: int = 150
    """The same in samples. [samples] Study: docs/study/rest.md."""

    rounding: float = 0.99
    """Part of that length from which on a record is long enough. [1] Judgement: a record of 10 s may lack its last
    samples."""


THRESHOLDS = LengthThresholds()


def shortest_record(streams: Sequence[Stream]) -> float:
    """The length from which a record without motion is at rest: that of the sensor that shows it sooner. [s]

    0 without a gyro or an accelerometer: no other quantity is judged.
    """
    return min(
        (shortest_length([stream.quantity], stream.grid.tau0) for stream in streams if _is_judged(stream)), default=0.0
    )


def shortest_length(quantities: Iterable[str], tau0: float) -> float:
    """The same for quantities that share a sample interval. [s]"""
    lengths = [THRESHOLDS.shortest[quantity] for quantity in quantities if quantity in SENSOR_CLASSES]
    return max(min(lengths), THRESHOLDS.least_samples * tau0) if lengths else 0.0


def judged_length(streams: Sequence[Stream]) -> float:
    """The length of the samples that are present, of the stream with the most. [s]"""
    return max(map(_present_length, filter(_is_judged, streams)), default=0.0)


def is_too_short(duration: float, shortest: float) -> bool:
    """Whether a record is shorter than the shortest that can be judged, by more than samples at its ends."""
    return duration < THRESHOLDS.rounding * shortest


def _is_judged(stream: Stream) -> bool:
    return stream.quantity in SENSOR_CLASSES


def _present_length(stream: Stream) -> float:
    missing = 0.0 if stream.mask is None else float(stream.mask.mean(axis=0).min())
    return stream.grid.duration * (1 - missing)
