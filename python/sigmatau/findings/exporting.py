"""Findings about exported files and files read back."""

from __future__ import annotations

import math

from sigmatau.digits import two_digits
from sigmatau.findings.finding import Details, Finding, Words, axes_text
from sigmatau.frozen import frozen
from sigmatau.hints import Hint, command
from sigmatau.noise.terms import TERMS
from sigmatau.results import duration_text, printable, seconds

_MAX_KEYS = 3  # largest number of keys of a file that are named; the others are counted
_LONGEST_KEY = 24  # longest name of a key [characters]
_RIGHT = 1.05  # factor up to which a stated error or covariance is called correct
_HONEST = 1.25  # factor of an error or a covariance up to which no action is needed
_QUANTITIES = {"gyro": "angular_rate", "accel": "acceleration"}


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

    def words(self, finding: Finding) -> Words:
        option = f"{_option(self.option)} {printable(self.key[:_LONGEST_KEY])}".rstrip()
        return Words(f"{self.target} has no field for {option}; ignored for this target")


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
        Whether the coefficient was observed; otherwise the model does not have the sensor.
    """

    sensor: str
    term: str
    observed: bool

    def words(self, finding: Finding) -> Words:
        option = f"{_option(self.term)} for {self.sensor}"
        if not self.observed:
            return Words(f"{option} not used: the model has no such sensor", "Remove the option")
        factor = Hint("noise_factor" if self.term == "random_walk" else "walk_factor")
        return Words(
            f"{option} not used: the coefficient was observed, so the observed value is written",
            f"Set another value in a model file, or scale the observed one with {factor}",
        )


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
        Allan deviation of all slow noise of the model over that of the process; None if a random walk was chosen. [1]
    tau : float or None
        Averaging time of the ratio. [s]
    omitted : tuple of OmittedTerm
        Terms that the chosen random walk replaces.
    """

    sensor: str
    ratio: float | None = None
    tau: float | None = None
    omitted: tuple[OmittedTerm, ...] = ()

    def words(self, finding: Finding) -> Words:
        action = (
            f"Use {Hint('walk', self.sensor, 'horizon')} {Hint('horizon', value=10)} to approximate all slow noise by"
            " a random walk"
        )
        if self.ratio is not None and self.tau is not None:
            return Words(
                f"the Allan deviation of all slow noise is {self.ratio:.3g} times that of the written bias process at"
                f" τ = {seconds(self.tau)} s",
                action,
            )
        unique = dict.fromkeys(term.term for term in self.omitted)
        quantity = _QUANTITIES[self.sensor]
        terms = [TERMS[term].label(quantity) if term in TERMS else "Gauss-Markov noise" for term in unique]
        return Words(f"{axes_text(terms)} omitted: the chosen random walk is written instead", action)


@frozen
class LimitWritten(Details, code="limit_written"):
    """A coefficient was not observed, and its upper limit is in the file.

    Attributes
    ----------
    term : str
        A key of `sigmatau.noise.terms.TERMS`.
    """

    term: str

    def words(self, finding: Finding) -> Words:
        label = TERMS[self.term].label("signal")
        return Words(
            f"{label} not observed; its upper limit is written",
            f"{_option(self.term)} sets another value, {Hint('strict', value=True)} refuses",
        )


@frozen
class StatedError:
    """Error that a filter states after some time without measurements.

    Attributes
    ----------
    time : float
        [s]
    share : float
        Stated over actual error: 1 is correct, less is overconfident. [1]
    """

    time: float
    share: float


@frozen
class PairConsistency(Details, code="pair_consistency"):
    """Errors stated by a bias-estimating filter with the written N and K.

    Attributes
    ----------
    sensor : str
        "gyro" or "accel".
    walk : float
        The written rate random walk; 0 with a Gauss-Markov bias in its place. [SI]
    horizon : float
        Time of use without measurements. [s]
    nees : float
        Actual over stated variance of the bias: 1 is correct, more is overconfident. [1]
    stated : tuple of StatedError
        Error of the angle (velocity) after a part of the horizon, after the horizon, and after a longer time.
    """

    sensor: str
    walk: float
    horizon: float
    nees: float
    stated: tuple[StatedError, ...]

    def text(self, assumed: str = "") -> str:
        """``gyro N and K: a filter states … of its error after 60 s, … after 10 min; bias covariance …``."""
        *_, at_horizon, later = self.stated
        numbers = assumed or ("N and K" if self.walk else "Gauss-Markov bias")
        return (
            f"{self.sensor} {numbers}: a filter states {at_horizon.share:.2f} of its error after"
            f" {duration_text(at_horizon.time)}, {later.share:.2f} after {duration_text(later.time)}; bias covariance"
            f" {self._bias_text()}"
        )

    def is_honest(self) -> bool:
        """Whether all statements of the filter are correct to 5 %."""
        ratios = (math.sqrt(self.nees), *(stated.share for stated in self.stated))
        return all(1 / _RIGHT <= ratio <= _RIGHT for ratio in ratios)

    def is_overconfident(self) -> bool:
        """Whether a filter clearly understates its error at the horizon."""
        return self.stated[-2].share < 1 / _HONEST

    def _bias_text(self) -> str:
        if 1 / _RIGHT <= self.nees <= _RIGHT:
            return "right"
        times, size = (self.nees, "small") if self.nees > 1 else (1 / self.nees, "large")
        return f"{two_digits(times)} times too {size}"

    def words(self, finding: Finding) -> Words:
        if 1 / _HONEST <= self.nees <= _HONEST:
            return Words(self.text())
        horizon = f"{Hint('horizon')} sets another time of use"
        bias = f"; {Hint('consistent', value='bias')} makes the bias covariance correct instead"
        return Words(self.text(), f"{horizon}{bias if self.walk else ''}")


@frozen
class QuantizationInSamples(Details, code="quantization_in_samples"):
    """Quantization makes the noise of a sample larger than N does, and the file has no field for it.

    Attributes
    ----------
    ratio : float
        Standard deviation of a sample by quantization, over N·√rate. [1]
    """

    ratio: float

    def words(self, finding: Finding) -> Words:
        return Words(
            f"quantization makes the noise of a sample {two_digits(self.ratio)} times N*sqrt(rate); the file has no field"
            " for quantization",
            "A filter that integrates the samples needs N; one that tests single samples needs the larger noise",
        )


@frozen
class WideTurnOn(Details, code="wide_turn_on"):
    """The turn-on bias in the file is based on so few power-ups that it may be much larger.

    Attributes
    ----------
    power_ups : int
        Number of power-ups that were compared.
    ratio : float or None
        Upper end of the interval over the value. None if no spread was observed; the upper end is then in the file. [1]
    """

    power_ups: int
    ratio: float | None = None

    def words(self, finding: Finding) -> Words:
        ends = (
            "no spread was observed, so the upper end of its interval is written"
            if self.ratio is None
            else f"up to {two_digits(self.ratio)} times"
        )
        return Words(
            f"turn-on bias from {self.power_ups} power-ups, may be larger: {ends}",
            f"Compare more power-ups, or set {Hint('names', f'{_first_sensor(finding)}_turn_on_bias', 'VALUE')}",
        )


def _first_sensor(finding: Finding) -> str:
    """The sensor of the first channel of a finding."""
    return finding.channels[0].partition("_")[0] if finding.channels else "gyro"


@frozen
class NotAdequate(Details, code="not_adequate"):
    """Coefficients in the file come from a fit that does not describe its curve."""

    def words(self, finding: Finding) -> Words:
        return Words(
            "no model fits these axes, so the error of their coefficients is unknown",
            f"Inspect the curve ({command('analyze', Hint('plot'))}), use another part of the record, or omit the channel",
        )


@frozen
class OnlyLimits(Details, code="only_limits"):
    """Coefficients in the file are upper limits: vibration or rounding hides the noise of these axes."""

    def words(self, finding: Finding) -> Words:
        return Words(
            "vibration or rounding hides the noise of these axes, and the file has upper limits in place of"
            " their coefficients",
            "Record again without it, or omit the channel",
        )


@frozen
class PoorTrust(Details, code="poor_trust"):
    """Coefficients in the file are wrong by half or more, according to a finding of the analysis."""

    def words(self, finding: Finding) -> Words:
        return Words("trust poor: do not use the numbers of these axes", "See the warnings in the head of the file")


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

    def words(self, finding: Finding) -> Words:
        listed = ", ".join(f"{sensor} {rate:.4g} Hz" for sensor, rate in self.rates)
        return Words(
            f"the written rate of the filter is {self.rate:.4g} Hz, the highest of the sensors ({listed})",
            f"Give {Hint('filter_rate', value='HZ')} if the filter takes samples at another rate;"
            " the densities do not depend on it",
        )


@frozen
class MaternAsProcesses(Details, code="matern_as_processes"):
    """The file has a sum of Gauss-Markov processes in place of a Matérn process, which has no finite number of states.

    Attributes
    ----------
    rate : float
        Sampling rate of the sum. [Hz]
    """

    rate: float

    def words(self, finding: Finding) -> Words:
        return Words(
            f"a Matérn process is a sum of Gauss-Markov processes at {self.rate:.4g} Hz, to 0.01 % of its density",
            f"Give {Hint('filter_rate', value='HZ')} if the filter takes samples at another rate",
        )


@frozen
class WrittenForOtherRate(Details, code="other_rate"):
    """The file is for another sampling rate than that of the record.

    Attributes
    ----------
    rate, record_rate : float
        Rate of the file, and rate of the record. [Hz]
    """

    rate: float
    record_rate: float

    def words(self, finding: Finding) -> Words:
        return Words(f"written for {self.rate:.4g} Hz; the sampling rate of the record is {self.record_rate:.4g} Hz")


@frozen
class CorrelatedSamples(Details, code="correlated_samples"):
    """Samples of a channel are correlated, so that their variance is not N²·rate.

    Attributes
    ----------
    ratio : float or None
        Measured variance of a sample over N²·rate; None if it was not measured and N²·rate is in the file. [1]
    independent_variance : float
        N²·rate. [(rate unit)²]
    corner : float or None
        Corner of the low-pass filter that the analysis found. [Hz]
    """

    ratio: float | None
    independent_variance: float
    corner: float | None

    def words(self, finding: Finding) -> Words:
        filtered = f" (low-pass filter at {self.corner:.3g} Hz)" if self.corner is not None else ""
        if self.ratio is None:
            return Words(
                f"samples are correlated{filtered}; the written N^2*rate is the variance without the filter",
                "Set the bandwidth of the channel in a model file to write the variance of the samples",
            )
        return Words(
            f"samples are correlated{filtered}: their variance is {self.ratio:.3g} times N^2*rate",
            f"Use N^2*rate = {self.independent_variance:.4g} in a filter that assumes independent samples",
        )


@frozen
class KeysNotRead(Details, code="keys_not_read"):
    """Keys of another program's file that were not read.

    Attributes
    ----------
    keys : tuple of str
        Names of the keys.
    """

    keys: tuple[str, ...]

    def words(self, finding: Finding) -> Words:
        named = ", ".join(printable(key[:_LONGEST_KEY]) for key in self.keys[:_MAX_KEYS])
        uncounted = f" and {len(self.keys) - _MAX_KEYS} more" if len(self.keys) > _MAX_KEYS else ""
        return Words(f"keys not read: {named}{uncounted}")


@frozen
class ImportedWithoutIntervals(Details, code="imported_without_intervals"):
    """A file with one value for all axes and no intervals was read."""

    def words(self, finding: Finding) -> Words:
        return Words("one value for all axes, without an interval; such files often contain inflated values")


@frozen
class DeviationAsDensity(Details, code="deviation_as_density"):
    """A file of imu_utils, which calls the standard deviation of a sample a density.

    Attributes
    ----------
    rate : float
        Sampling rate; the values were divided by its square root. [Hz]
    """

    rate: float

    def words(self, finding: Finding) -> Words:
        return Words(
            f"gyr_n and acc_n are standard deviations of a sample; they are divided by sqrt({self.rate:.4g} Hz)",
            f"Do not use them as densities: they are {finding.size:.3g} times too large",
        )


@frozen
class MinimumAsWalk(Details, code="minimum_as_walk"):
    """A file of imu_utils, which calls the minimum of the Allan deviation a random walk.

    Attributes
    ----------
    keys : tuple of str
        ``("gyr_w", "acc_w")``; not read.
    """

    keys: tuple[str, ...]

    def words(self, finding: Finding) -> Words:
        return Words(
            f"{axes_text(self.keys)} not read: a minimum of the Allan deviation is not a random walk",
            f"Analyse the record itself, or choose a value with {Hint('walk')}",
        )


def _option(term: str) -> Hint:
    return Hint({"random_walk": "noise", "rate_random_walk": "walk"}.get(term, term))
