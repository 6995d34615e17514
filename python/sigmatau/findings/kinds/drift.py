"""Kinds of findings about slow changes: warm-up, temperature, noise that changes, selection of a window."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from sigmatau.findings.finding import Details

__all__ = ["Drift", "LateDrift", "NoiseChange", "NonStationary", "SegmentSpread", "TemperatureDrift", "WarmUp"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Drift(Details):
    """Base of the drifts with a cause, and what is known of their effect beside the factors of the finding.

    Attributes
    ----------
    quantity : str
        Quantity of the channel, such as ``"angular_rate"``.
    lower_bounds : tuple of str
        Terms whose factor is a lower bound, because the fit without the drift does not show them.
    undetermined : tuple of str
        Terms that the fit states and that the fit without the drift does not show, although the values are below its
        limits: the drift may be all of them.
    """

    quantity: str
    lower_bounds: tuple[str, ...] = ()
    undetermined: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class WarmUp(Drift):
    """The signal settles exponentially from the beginning of the record on; the size of the finding is by how much.

    Attributes
    ----------
    error : float
        Standard error of the size, in the unit of the finding.
    time_constant : float
        [s]
    settled : float
        Time from the beginning after which 0.7 % of the drift is left; may exceed the record. [s]
    duration : float
        Length of the record. [s]
    with_steps : bool
        Whether the factors are those of the drift and of the steps of the level that were found beside it.
    """

    code: ClassVar[str] = "warm_up"

    error: float
    time_constant: float
    settled: float
    duration: float
    with_steps: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class LateDrift(Drift):
    """The signal moves away exponentially towards the end of the record; the size of the finding is by how much.

    Attributes
    ----------
    error : float
        Standard error of the size, in the unit of the finding.
    time_constant : float
        [s]
    duration : float
        Length of the record. [s]
    with_steps : bool
        Whether the factors are those of the drift and of the steps of the level that were found beside it.
    """

    code: ClassVar[str] = "late_drift"

    error: float
    time_constant: float
    duration: float
    with_steps: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class TemperatureDrift(Drift):
    """The signal follows the temperature; the size of the finding is the coefficient per kelvin.

    Attributes
    ----------
    rate_unit : str
        Unit of the signal.
    low, high : float
        95 % interval of the coefficient. [rate_unit/K]
    temperature_range : float
        Largest less smallest temperature. [K]
    share : float
        Share of the Allan variance at `tau` that the temperature explains.
    tau : float
        [s]
    """

    code: ClassVar[str] = "temperature_drift"

    rate_unit: str
    low: float
    high: float
    temperature_range: float
    share: float
    tau: float


@dataclass(frozen=True, slots=True, kw_only=True)
class SegmentSpread:
    """How much the Allan deviations of segments of the record differ, where the evidence is strongest.

    Attributes
    ----------
    ratio : float
        Largest over smallest Allan deviation.
    tau : float
        [s]
    tau_min, tau_max : float
        Shortest and longest averaging time at which the segments differ significantly; both are `tau` if that is not
        so at any time by itself. [s]
    largest_at, smallest_at : float
        Beginnings of the segments with the largest and the smallest deviation. [s]
    length : float
        Length of a segment. [s]
    """

    ratio: float
    tau: float
    tau_min: float
    tau_max: float
    largest_at: float
    smallest_at: float
    length: float


@dataclass(frozen=True, slots=True, kw_only=True)
class NoiseChange:
    """A change of the short-time noise, found by the cusum of squared first differences.

    Attributes
    ----------
    time : float
        [s]
    ratio : float
        Root mean square of the first differences after the change over that before.
    """

    time: float
    ratio: float


@dataclass(frozen=True, slots=True, kw_only=True)
class NonStationary(Details):
    """The noise changes during the record; at least one of the two tests found it."""

    code: ClassVar[str] = "non_stationary"

    segments: SegmentSpread | None = None
    change: NoiseChange | None = None
