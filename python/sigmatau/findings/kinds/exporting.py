"""Kinds of findings about exported files and files read back."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from sigmatau.findings.finding import Details

__all__ = [
    "ChoiceNotUsed",
    "ChoiceWithoutPlace",
    "CorrelatedSamples",
    "DeviationAsDensity",
    "ImportedWithoutIntervals",
    "KeysNotRead",
    "MinimumAsWalk",
    "NotAdequate",
    "OmittedTerm",
    "OtherRate",
    "SlowNoiseLeftOut",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class ChoiceWithoutPlace(Details):
    """A choice was made for several targets, and one of them has no field for it.

    Attributes
    ----------
    target : str
    option : str
        Name of the option, with underscores: ``"noise_factor"``.
    key : str
        For option ``"name"``, the name; else empty.
    """

    code: ClassVar[str] = "choice_without_place"
    target: str
    option: str
    key: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class ChoiceNotUsed(Details):
    """A value was chosen for a coefficient that was observed, or for a sensor that the model does not have.

    Attributes
    ----------
    sensor : {"gyro", "accel"}
    term : {"random_walk", "rate_random_walk"}
    observed : bool
        Whether the coefficient was observed; else the model does not have the sensor.
    """

    code: ClassVar[str] = "choice_not_used"
    sensor: str
    term: str
    observed: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class OmittedTerm:
    """A coefficient of the model that is not in the file.

    Attributes
    ----------
    channel : str
    term : str
        A key of `sigmatau.noise.terms.TERMS`, or ``"gauss_markov"``.
    value : float
        Coefficient, or standard deviation of the process. [SI]
    """

    channel: str
    term: str
    value: float


@dataclass(frozen=True, slots=True, kw_only=True)
class SlowNoiseLeftOut(Details):
    """The bias process in the file has less slow noise than the model.

    Attributes
    ----------
    sensor : {"gyro", "accel"}
    ratio : float or None
        Allan deviation of all slow noise of the model, in units of that of the process; None if a random walk was chosen.
    tau : float or None
        Averaging time of the ratio. [s]
    omitted : tuple of OmittedTerm
        Terms that the chosen random walk replaces.
    """

    code: ClassVar[str] = "slow_noise_left_out"
    sensor: str
    ratio: float | None = None
    tau: float | None = None
    omitted: tuple[OmittedTerm, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class NotAdequate(Details):
    """Coefficients in the file are from a fit that does not describe its curve."""

    code: ClassVar[str] = "not_adequate"


@dataclass(frozen=True, slots=True, kw_only=True)
class OtherRate(Details):
    """The file is for another sampling rate than that of the record.

    Attributes
    ----------
    rate, record_rate : float
        Of the file and of the record. [Hz]
    """

    code: ClassVar[str] = "other_rate"
    rate: float
    record_rate: float


@dataclass(frozen=True, slots=True, kw_only=True)
class CorrelatedSamples(Details):
    """Samples of a channel are correlated, so that their variance is not N²·rate.

    Attributes
    ----------
    ratio : float or None
        Measured variance of a sample, in units of N²·rate; None if it was not measured and N²·rate is in the file.
    independent_variance : float
        N²·rate. [(rate unit)²]
    corner : float or None
        Corner of the low-pass filter that the analysis found. [Hz]
    """

    code: ClassVar[str] = "correlated_samples"
    ratio: float | None
    independent_variance: float
    corner: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class KeysNotRead(Details):
    """Keys of another program's file that were not read.

    Attributes
    ----------
    keys : tuple of str
    """

    code: ClassVar[str] = "keys_not_read"
    keys: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class ImportedWithoutIntervals(Details):
    """A file with one value for all axes and no intervals was read."""

    code: ClassVar[str] = "imported_without_intervals"


@dataclass(frozen=True, slots=True, kw_only=True)
class DeviationAsDensity(Details):
    """imu_utils calls the standard deviation of a sample a density.

    Attributes
    ----------
    rate : float
        Sampling rate by whose root they were divided. [Hz]
    """

    code: ClassVar[str] = "deviation_as_density"
    rate: float


@dataclass(frozen=True, slots=True, kw_only=True)
class MinimumAsWalk(Details):
    """imu_utils calls the minimum of the Allan deviation a random walk.

    Attributes
    ----------
    keys : tuple of str
        ``("gyr_w", "acc_w")``; not read.
    """

    code: ClassVar[str] = "minimum_as_walk"
    keys: tuple[str, ...]
