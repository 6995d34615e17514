"""Kinds of findings about exported files and files read back."""

from __future__ import annotations

from sigmatau.findings.finding import Details
from sigmatau.frozen import frozen


@frozen
class ChoiceWithoutPlace(Details, code="choice_without_place"):
    """A choice was made for several targets, and one of them has no field for it."""

    target: str
    option: str  # name of the option, with underscores: ``"noise_factor"``
    key: str = ""  # for option ``"name"``, the name; else empty


@frozen
class ChoiceNotUsed(Details, code="choice_not_used"):
    """A value was chosen for a coefficient that was observed, or for a sensor that the model does not have."""

    sensor: str  # "gyro" or "accel"
    term: str  # "random_walk" or "rate_random_walk"
    observed: bool  # whether the coefficient was observed; else the model does not have the sensor


@frozen
class OmittedTerm:
    """A coefficient of the model that is not in the file."""

    channel: str
    term: str  # a key of `sigmatau.noise.terms.TERMS`, ``"gauss_markov"`` or ``"resonance"``
    value: float  # coefficient, or standard deviation of the process [SI]


@frozen
class SlowNoiseLeftOut(Details, code="slow_noise_left_out"):
    """The bias process in the file has less slow noise than the model."""

    sensor: str  # "gyro" or "accel"
    # Allan deviation of all slow noise of the model, in units of that of the process; None if a random walk was chosen
    ratio: float | None = None
    tau: float | None = None  # averaging time of the ratio [s]
    omitted: tuple[OmittedTerm, ...] = ()  # terms that the chosen random walk replaces


@frozen
class LimitWritten(Details, code="limit_written"):
    """A coefficient was not observed, and its upper limit is in the file."""

    term: str  # a key of `sigmatau.noise.terms.TERMS`


@frozen
class NotAdequate(Details, code="not_adequate"):
    """Coefficients in the file are from a fit that does not describe its curve."""


@frozen
class PoorTrust(Details, code="poor_trust"):
    """Coefficients in the file are wrong by half or more, as a finding of the analysis says."""


@frozen
class OtherRate(Details, code="other_rate"):
    """The file is for another sampling rate than that of the record."""

    rate: float  # of the file and of the record [Hz]
    record_rate: float


@frozen
class CorrelatedSamples(Details, code="correlated_samples"):
    """Samples of a channel are correlated, so that their variance is not N²·rate."""

    # measured variance of a sample, in units of N²·rate; None if it was not measured and N²·rate is in the file
    ratio: float | None
    independent_variance: float  # N²·rate [(rate unit)²]
    corner: float | None  # corner of the low-pass filter that the analysis found [Hz]


@frozen
class KeysNotRead(Details, code="keys_not_read"):
    """Keys of another program's file that were not read."""

    keys: tuple[str, ...]


@frozen
class ImportedWithoutIntervals(Details, code="imported_without_intervals"):
    """A file with one value for all axes and no intervals was read."""


@frozen
class DeviationAsDensity(Details, code="deviation_as_density"):
    """imu_utils calls the standard deviation of a sample a density."""

    rate: float  # sampling rate by whose root they were divided [Hz]


@frozen
class MinimumAsWalk(Details, code="minimum_as_walk"):
    """imu_utils calls the minimum of the Allan deviation a random walk."""

    keys: tuple[str, ...]  # ``("gyr_w", "acc_w")``; not read
