"""Kinds of findings about slow changes: warm-up, temperature, noise that changes, selection of a window."""

from __future__ import annotations

from dataclasses import dataclass

from sigmatau.findings.finding import Details


@dataclass(frozen=True, slots=True, kw_only=True)
class Drift(Details):
    """Base of the drifts with a cause, and what is known of their effect beside the factors of the finding."""

    quantity: str  # quantity of the channel, such as ``"angular_rate"``
    # terms whose factor is a lower bound, because the fit without the drift does not show them
    lower_bounds: tuple[str, ...] = ()
    # terms that the fit states and that the fit without the drift does not show, although the values are below its
    # limits: the drift may be all of them
    undetermined: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class WarmUp(Drift, code="warm_up"):
    """The signal settles exponentially from the beginning of the record on; the size of the finding is by how much."""

    error: float  # standard error of the size, in the unit of the finding
    time_constant: float  # [s]
    settled: float  # time from the beginning after which 0.7 % of the drift is left; may exceed the record [s]
    duration: float  # length of the record [s]
    # whether the factors are those of the drift and of the steps of the level that were found beside it
    with_steps: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class LateDrift(Drift, code="late_drift"):
    """The signal moves away exponentially towards the end of the record; the size of the finding is by how much."""

    error: float  # standard error of the size, in the unit of the finding
    time_constant: float  # [s]
    duration: float  # length of the record [s]
    # whether the factors are those of the drift and of the steps of the level that were found beside it
    with_steps: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class TemperatureDrift(Drift, code="temperature_drift"):
    """The signal follows the temperature; the size of the finding is the coefficient per kelvin."""

    rate_unit: str  # unit of the signal
    low: float  # 95 % interval of the coefficient [rate_unit/K]
    high: float
    temperature_range: float  # largest less smallest temperature [K]
    share: float  # share of the Allan variance at `tau` that the temperature explains
    tau: float  # [s]


@dataclass(frozen=True, slots=True, kw_only=True)
class SegmentSpread:
    """How much the Allan deviations of segments of the record differ, where the evidence is strongest."""

    ratio: float  # largest over smallest Allan deviation
    tau: float  # [s]
    # shortest and longest averaging time at which the segments differ significantly; both are `tau` if that is not so
    # at any time by itself [s]
    tau_min: float
    tau_max: float
    largest_at: float  # beginnings of the segments with the largest and the smallest deviation [s]
    smallest_at: float
    length: float  # length of a segment [s]


@dataclass(frozen=True, slots=True, kw_only=True)
class NoiseChange:
    """A change of the short-time noise, found by the cusum of squared first differences."""

    time: float  # [s]
    ratio: float  # root mean square of the first differences after the change over that before


@dataclass(frozen=True, slots=True, kw_only=True)
class NonStationary(Details, code="non_stationary"):
    """The noise changes during the record; at least one of the two tests found it."""

    segments: SegmentSpread | None = None
    change: NoiseChange | None = None
