"""Kinds of findings about exported files and files read back."""

from __future__ import annotations

from sigmatau.findings.finding import Details
from sigmatau.frozen import frozen


@frozen
class ChoiceWithoutPlace(Details, code="choice_without_place"):
    """A choice was made for several targets, and one of them has no field for it.

    Attributes
    ----------
    target : str
        Name of the target.
    option : str
        Name of the option, with underscores: ``"noise_factor"``.
    key : str
        For option ``"name"``, the name; else empty.
    """

    target: str
    option: str
    key: str = ""


@frozen
class ChoiceNotUsed(Details, code="choice_not_used"):
    """A value was chosen for a coefficient that was observed, or for a sensor that the model does not have.

    Attributes
    ----------
    sensor : str
        "gyro" or "accel".
    term : str
        "random_walk" or "rate_random_walk".
    observed : bool
        Whether the coefficient was observed; else the model does not have the sensor.
    """

    sensor: str
    term: str
    observed: bool


@frozen
class OmittedTerm:
    """A coefficient of the model that is not in the file.

    Attributes
    ----------
    channel : str
        Name of the channel.
    term : str
        A key of `sigmatau.noise.terms.TERMS`, ``"gauss_markov"`` or ``"resonance"``.
    value : float
        Coefficient, or standard deviation of the process. [SI]
    """

    channel: str
    term: str
    value: float


@frozen
class SlowNoiseLeftOut(Details, code="slow_noise_left_out"):
    """The bias process in the file has less slow noise than the model.

    Attributes
    ----------
    sensor : str
        "gyro" or "accel".
    ratio : float or None
        Allan deviation of all slow noise of the model, in units of that of the process; None if a random walk was
        chosen. [1]
    tau : float or None
        Averaging time of the ratio. [s]
    omitted : tuple of OmittedTerm
        Terms that the chosen random walk replaces.
    """

    sensor: str
    ratio: float | None = None
    tau: float | None = None
    omitted: tuple[OmittedTerm, ...] = ()


@frozen
class LimitWritten(Details, code="limit_written"):
    """A coefficient was not observed, and its upper limit is in the file.

    Attributes
    ----------
    term : str
        A key of `sigmatau.noise.terms.TERMS`.
    """

    term: str


@frozen
class NotAdequate(Details, code="not_adequate"):
    """Coefficients in the file are from a fit that does not describe its curve."""


@frozen
class OnlyLimits(Details, code="only_limits"):
    """Coefficients in the file are upper limits: vibration or rounding hides the noise of these axes."""


@frozen
class PoorTrust(Details, code="poor_trust"):
    """Coefficients in the file are wrong by half or more, as a finding of the analysis says."""


@frozen
class FastestRate(Details, code="fastest_rate"):
    """The sensors have different sampling rates, and the file has a field for one: the highest is written.

    Attributes
    ----------
    rate : float
        The written rate. [Hz]
    rates : tuple of (str, float)
        Sensors, and their sampling rates in the record. [Hz]
    """

    rate: float
    rates: tuple[tuple[str, float], ...]


@frozen
class OtherRate(Details, code="other_rate"):
    """The file is for another sampling rate than that of the record.

    Attributes
    ----------
    rate, record_rate : float
        Of the file and of the record. [Hz]
    """

    rate: float
    record_rate: float


@frozen
class CorrelatedSamples(Details, code="correlated_samples"):
    """Samples of a channel are correlated, so that their variance is not N²·rate.

    Attributes
    ----------
    ratio : float or None
        Measured variance of a sample, in units of N²·rate; None if it was not measured and N²·rate is in the file. [1]
    independent_variance : float
        N²·rate. [(rate unit)²]
    corner : float or None
        Corner of the low-pass filter that the analysis found. [Hz]
    """

    ratio: float | None
    independent_variance: float
    corner: float | None


@frozen
class KeysNotRead(Details, code="keys_not_read"):
    """Keys of another program's file that were not read.

    Attributes
    ----------
    keys : tuple of str
        Names of the keys.
    """

    keys: tuple[str, ...]


@frozen
class ImportedWithoutIntervals(Details, code="imported_without_intervals"):
    """A file with one value for all axes and no intervals was read."""


@frozen
class DeviationAsDensity(Details, code="deviation_as_density"):
    """imu_utils calls the standard deviation of a sample a density.

    Attributes
    ----------
    rate : float
        Sampling rate by whose root they were divided. [Hz]
    """

    rate: float


@frozen
class MinimumAsWalk(Details, code="minimum_as_walk"):
    """imu_utils calls the minimum of the Allan deviation a random walk.

    Attributes
    ----------
    keys : tuple of str
        ``("gyr_w", "acc_w")``; not read.
    """

    keys: tuple[str, ...]
