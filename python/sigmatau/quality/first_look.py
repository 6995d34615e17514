"""The means of a record before an analysis: gravity and offsets, which show a wrong unit or column."""

from __future__ import annotations

import math
from typing import Literal

from sigmatau.findings.units import Gravity, ImplausibleUnit
from sigmatau.frozen import frozen
from sigmatau.quality.facts import keep_facts
from sigmatau.quality.samples import units
from sigmatau.record.record import Record
from sigmatau.record.streams import Stream
from sigmatau.results import Plain
from sigmatau.units import STANDARD_GRAVITY

MeanVerdict = Literal["gravity", "gravity_removed", "not_gravity", "offset", "large_offset", "other_unit"]

_QUANTITIES = ("angular_rate", "acceleration")


@frozen
class SensorMean(Plain):
    """Mean vector of a triad, and whether it is that of a sensor at rest.

    Attributes
    ----------
    sensor : str
        Name of the stream.
    quantity : {"angular_rate", "acceleration"}
    length : float
        Length of the mean vector. [unit]
    expected : float
        Gravity for an accelerometer; largest offset of usual gyroscopes at rest. [unit]
    unit : str
        SI.
    verdict : {"gravity", "gravity_removed", "not_gravity", "offset", "large_offset", "other_unit"}
        What the mean is.
    likely : str
        Unit of the samples, if it is probably another one than stated; otherwise empty.
    """

    sensor: str
    quantity: str
    length: float
    expected: float
    unit: str
    verdict: MeanVerdict
    likely: str = ""


@keep_facts()
def first_look(record: Record) -> tuple[SensorMean, ...]:
    """Compare the means of triads with gravity and usual offsets.

    Noise is not checked: a first look must hold for a moving sensor too.
    """
    triads = (s for s in record.streams if len(s.channels) == units.AXES and units.has_plausible_values(s))
    means = (
        _acceleration(s) if s.quantity == "acceleration" else _rate(s) for s in triads if s.quantity in _QUANTITIES
    )
    return tuple(mean for mean in means if math.isfinite(mean.length))


def _acceleration(stream: Stream) -> SensorMean:
    length = units.mean_vector(stream)
    likely = _likely_unit(stream)
    verdict: MeanVerdict = "other_unit" if likely else "gravity" if units.is_gravity(length) else "not_gravity"
    causes = (finding.details.cause for finding in units.gravity(stream) if isinstance(finding.details, Gravity))
    if verdict == "not_gravity" and "removed" in causes:
        verdict = "gravity_removed"
    return _mean(stream, length, STANDARD_GRAVITY, verdict, likely)


def _rate(stream: Stream) -> SensorMean:
    length = units.mean_vector(stream)
    likely = _likely_unit(stream)
    verdict: MeanVerdict = "other_unit" if likely else "offset" if length <= units.USUAL_OFFSET else "large_offset"
    return _mean(stream, length, units.USUAL_OFFSET, verdict, likely)


def _likely_unit(stream: Stream) -> str:
    """The unit that gravity or the resolution of the sensor shows, if it is another one than stated."""
    check = units.unit_by_gravity if stream.quantity == "acceleration" else units.unit_by_step
    return next((f.details.likely for f in check(stream) if isinstance(f.details, ImplausibleUnit)), "")


def _mean(stream: Stream, length: float, expected: float, verdict: MeanVerdict, likely: str) -> SensorMean:
    return SensorMean(
        sensor=stream.name,
        quantity=stream.quantity,
        length=length,
        expected=expected,
        unit=stream.unit,
        verdict=verdict,
        likely=likely,
    )
