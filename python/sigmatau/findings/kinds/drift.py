"""Kinds of findings about slow changes: warm-up, temperature, noise that changes, selection of a window."""

from __future__ import annotations

from sigmatau.findings.finding import Details
from sigmatau.frozen import frozen


@frozen
class WarmUp(Details, code="warm_up"):
    """The signal settles exponentially from the first sample on, which the fit allows for; the size is by how much."""

    quantity: str
    time_constant: float  # [s]
    low: float  # interval of the size
    high: float


@frozen
class TemperatureDrift(Details, code="temperature_drift"):
    """The signal follows the temperature, which the fit allows for; the size is the coefficient per kelvin."""

    quantity: str
    rate_unit: str  # unit of the signal
    low: float  # interval of the coefficient [rate_unit/K]
    high: float


@frozen
class SegmentSpread:
    """How much the Allan deviations of segments of the record differ, where the evidence is strongest."""

    ratio: float  # largest over smallest Allan deviation
    tau: float  # [s]
    # shortest and longest averaging time at which the segments differ significantly; both are `tau` if that is not so
    # at any time by itself [s]
    tau_min: float
    tau_max: float
    # beginnings of the segments with the largest and the smallest deviation, from the beginning of the record [s]
    largest_at: float
    smallest_at: float
    length: float  # length of a segment [s]


@frozen
class NoiseChange:
    """A change of the short-time noise, found by the cusum of squared first differences."""

    time: float  # from the beginning of the record [s]
    ratio: float  # root mean square of the first differences after the change over that before


@frozen
class NonStationary(Details, code="non_stationary"):
    """The noise changes during the record; at least one of the two tests found it."""

    segments: SegmentSpread | None = None
    change: NoiseChange | None = None
