"""Findings about sample values: held, repeated, lost, saturated, interpolated, coarse."""

from __future__ import annotations

import math
from typing import Literal

from sigmatau.digits import significant, two_digits
from sigmatau.findings.finding import Details, Finding, Words
from sigmatau.findings.phrases import clock, largest_factor_text, percent
from sigmatau.frozen import frozen
from sigmatau.hints import Hint
from sigmatau.results import duration_text, seconds


@frozen
class HeldRuns(Details):
    """Runs of samples that do not come from the sensor: base of `Dropout` and `StuckSamples`. Numbers refer to the
    channel with the largest number of such samples.

    Attributes
    ----------
    samples : int
        Number of samples in these runs.
    share : float
        Part of all samples. [1]
    runs : int
        Number of runs.
    start, longest : float
        Beginning of the longest run, from the beginning of the record, and its length. [s]
    """

    samples: int
    share: float
    runs: int
    start: float
    longest: float


@frozen
class Dropout(HeldRuns, code="dropout"):
    """The log contains the number 0 in place of lost samples."""

    def words(self, finding: Finding) -> Words:
        return _held(self, "zeros")


@frozen
class StuckSamples(HeldRuns, code="stuck_samples"):
    """Runs of equal samples longer than the noise can explain."""

    def words(self, finding: Finding) -> Words:
        return _held(self, "equal samples")


@frozen
class Saturation(Details, code="saturation"):
    """Samples at an end of the measuring range.

    Attributes
    ----------
    strongest : str
        The channel with the largest effect, to which all numbers refer.
    samples : int
        Samples at an end of the range.
    share : float
        Part of all samples. [1]
    low, high : float or None
        The ends that are reached. [unit]
    unit : str
        Unit of the stream; SI.
    start : float
        Time of the first of these samples, from the beginning of the record. [s]
    longest : float
        Longest run of one value; 0 if no run is longer than the noise can explain. [s]
    spread : bool
        Whether these samples are spread over the whole record, so that their effect on white noise is known.
    """

    strongest: str
    samples: int
    share: float
    low: float | None
    high: float | None
    unit: str
    start: float
    longest: float
    spread: bool

    @property
    def biases_walk(self) -> bool:
        """True: a saturated sample is closer to the mean, which affects every fit."""
        return self.spread

    def words(self, finding: Finding) -> Words:
        ends = " and ".join(f"{end:.3g}" for end in (self.low, self.high) if end is not None)
        fact = f"{percent(self.share)} of the samples at {'a limit' if None in (self.low, self.high) else 'the limits'}"
        fact += f" of the range, {ends} {self.unit}"
        if not self.spread:
            return Words(_joined(fact, f"the first at {clock(self.start)}"))
        effect = largest_factor_text(finding.factors, channel=_on(finding, self.strongest))
        return Words(
            _joined(fact, effect), f"Record again with a larger range, or select another part with {Hint('window')}"
        )


@frozen
class CopiedStretch(Details, code="copied_stretch"):
    """A stretch of rows that equals another stretch of the record on all axes; the size is its length.

    Attributes
    ----------
    start, copy : float
        First rows of the stretch and of its copy. [s]
    duration : float
        [s]
    rows : int
        Number of equal rows.
    """

    start: float
    copy: float
    duration: float
    rows: int

    def words(self, finding: Finding) -> Words:
        return Words(
            f"the {self.rows} rows from {clock(self.copy)} on equal those from {clock(self.start)} on,"
            f" {seconds(self.duration)} s long",
            f"Check how the log was written; leave the copy out with {Hint('leave_out')}",
        )


@frozen
class RepeatedSamples(Details, code="repeated_samples"):
    """Samples that equal the previous sample more often than by chance.

    Attributes
    ----------
    pattern : {"held", "irregular", "rows"}
        Cause: a sensor with a lower rate than its log, copies at irregular places, or single rows that occur twice.
    copies : int
        Samples that equal the one before.
    share : float
        Part of all samples. [1]
    times : float
        Mean number of times that a sample occurs. [1]
    shortest, longest : int
        Range of this number, without the rarest 2.5 % at either end.
    log_rate : float
        Rate of the rows. [Hz]
    sensor_rate : float
        Rate of distinct samples. [Hz]
    rate_given : bool
        Whether the user gave the rate, so that it may be the sensor's and not that of the rows.
    sigma_one_sample : float
        σ at one sample over that of white noise with the same σ at long averaging times. [1]
    right_from : int
        Number of samples from which σ is correct.
    walk_at_log_rate, walk_at_sensor_rate : float
        Ratio of the random walk to that of the sensor, if its rate is that of the log or that of distinct samples. [1]
    """

    pattern: Literal["held", "irregular", "rows"]
    copies: int
    share: float
    times: float
    shortest: int
    longest: int
    log_rate: float
    sensor_rate: float
    rate_given: bool
    sigma_one_sample: float
    right_from: int
    walk_at_log_rate: float
    walk_at_sensor_rate: float

    @property
    def biases_walk(self) -> bool:
        """True: a repeated sample has more weight at all averaging times."""
        return True

    def words(self, finding: Finding) -> Words:
        effect = largest_factor_text([pair for pair in finding.factors if pair[0] == "random_walk"])
        if self.pattern == "rows":
            fact = f"{self.copies} rows ({percent(self.share)}) equal the previous row"
            return Words(fact)
        if self.pattern == "irregular":
            fact = f"{percent(self.share)} of the samples equal the previous sample, at irregular intervals"
            return Words(
                _joined(fact, effect), "Omit lost samples from the log instead of repeating the previous sample"
            )
        rates = f"the sensor gives {self.sensor_rate:.4g} Hz, the log has {self.log_rate:.4g} Hz"
        effect = effect or f"σ at one sample {significant(1 / self.sigma_one_sample)} times too small"
        if self.shortest == self.longest > 1:
            rate = Hint("rate", value=f"{self.sensor_rate:.4g}")
            return Words(
                f"each sample occurs {self.shortest} times: {rates}; {effect}",
                f"Keep one of each group of equal samples and give {rate}",
            )
        return Words(
            f"samples occur {self.times:.3g} times on average: {rates}; {effect}",
            "Log at the sensor's rate, triggered by its data-ready signal, or use only long averaging times",
        )


@frozen
class Upsampled:
    """Interpolation of all samples from a lower rate.

    Attributes
    ----------
    sensor_rate, log_rate : float
        Rate of the samples before, and of the log. [Hz]
    aligned : bool
        Whether the sensor's samples are among those of the log.
    sigma_one_sample : float
        σ at one sample over that of the sensor's white noise. [1]
    right_from : float
        Averaging time from which σ is correct. [s]
    """

    sensor_rate: float
    log_rate: float
    aligned: bool
    sigma_one_sample: float
    right_from: float


@frozen
class FilledOutages:
    """Long stretches that were filled in with straight lines.

    Attributes
    ----------
    count : int
        Number of stretches.
    start, longest : float
        Beginning of the longest, from the beginning of the record, and its length. [s]
    """

    count: int
    start: float
    longest: float


@frozen
class FilledSamples:
    """Single lost samples that were filled in with straight lines.

    Attributes
    ----------
    random_walk : float
        Random walk over that of the sensor, at all averaging times of more than a few samples. [1]
    sigma_one_sample : float
        σ at one sample over that of the sensor. [1]
    """

    random_walk: float
    sigma_one_sample: float


@frozen
class Interpolated(Details, code="interpolated"):
    """Samples on the straight line through their neighbours: resampled from a lower rate, or lost samples filled in.

    Attributes
    ----------
    strongest : str
        The channel to which all numbers refer.
    share : float
        Share of filled-in samples: of single samples if there are `singles`, otherwise of all. [1]
    upsampled : Upsampled or None
        Details if all samples were interpolated from a lower rate.
    outages : FilledOutages or None
        Details if long stretches were filled in.
    singles : FilledSamples or None
        Details if single samples were filled in.
    """

    strongest: str
    share: float
    upsampled: Upsampled | None = None
    outages: FilledOutages | None = None
    singles: FilledSamples | None = None

    @property
    def biases_walk(self) -> bool:
        """Whether single samples were filled in, which changes the random walk; a lower rate only changes σ at short
        times.
        """
        return self.singles is not None

    def words(self, finding: Finding) -> Words:
        if self.upsampled is not None:
            made = self.upsampled
            fact = f"interpolated from {made.sensor_rate:.4g} to {made.log_rate:.4g} Hz"
            times, right_from = significant(1 / made.sigma_one_sample), seconds(made.right_from)
            effect = f"σ at one sample {times} times too small, correct from τ = {right_from} s"
            return Words(_joined(fact, effect), "Log the samples of the sensor with their time stamps")
        outages, fact = self.outages, ""
        if outages is not None:
            longest = duration_text(outages.longest)
            fact = f"a gap of {longest} at {clock(outages.start)} was filled with a straight line"
            if outages.count > 1:
                fact = (
                    f"{outages.count} gaps were filled with straight lines, the longest {longest}"
                    f" at {clock(outages.start)}"
                )
            return Words(fact)
        if self.singles is not None:
            fact = f"{percent(self.share)} of the samples are linear interpolations of lost samples"
        effect = largest_factor_text(finding.factors, channel=_on(finding, self.strongest))
        return Words(_joined(fact, effect), "Leave lost samples empty in the log, or omit their rows")


@frozen
class CoarseResolution(Details, code="coarse_resolution"):
    """A resolution that is coarse relative to the noise.

    Attributes
    ----------
    step, noise : float
        Step of the numbers and standard deviation of the white part of a sample. [unit]
    unit : str
        Unit of the stream; SI.
    rounding : {"quantization", "white", "unknown"}
        Kind of noise that rounding adds: quantization noise if an angle (or velocity) was rounded, in a log of increments or
        of rates; white noise if the rates were rounded; unknown below half a step of noise.
    added : float or None
        Coefficient of the added noise: Q [unit·s] as an upper limit, or N [unit·√s]; None if unknown.
    summed : int or None
        Samples that must be summed for white rounding of the angle; None if no sum in the record is long enough.
    needed : float or None
        Shortest record that shows the random walk in such sums, if this one does not. [s]
    passing : float or None
        Frequency at which the mean rate crosses steps of a rounded angle, folded at half the sampling rate. A steady
        rate causes lines at multiples of this frequency. [Hz]
    """

    step: float
    noise: float
    unit: str
    rounding: Literal["quantization", "white", "unknown"]
    added: float | None
    summed: int | None = 1
    needed: float | None = None
    passing: float | None = None

    @property
    def biases_walk(self) -> bool:
        """Whether the rounding is white, which is then part of the random walk of each fit."""
        return self.rounding == "white"

    def words(self, finding: Finding) -> Words:
        noise = two_digits(self.noise / self.step)
        times = "equal to" if noise == "1" else f"{noise} times"
        stated = f"the noise is {times} the resolution of {self.step:.3g} {self.unit}"
        finer = "Record again with a smaller range or more bits"
        if self.rounding == "quantization" and self.added is not None:
            angle = "a velocity" if self.unit == "m/s^2" else "an angle"
            counts = f"counts of {angle}, {self.added * math.sqrt(12):.3g} {_integrated(self.unit)} each"
            stated = f"{counts}; the noise is {noise} counts"
            if self.passing and (self.summed is None or self.needed is not None):
                stated = f"{counts}, with lines every {self.passing:.3g} Hz"
        if self.rounding == "unknown":
            return Words(_joined(stated, "the noise of rounding is unknown, and intervals allow for it"), finer)
        if self.summed is None or self.needed is not None:
            long = "Record longer" if self.needed is None else f"Record {duration_text(self.needed)} or more"
            return Words(
                _joined(stated, "the rounding is not white and hides the random walk"), f"{long}, or more finely"
            )
        if self.rounding == "quantization" and self.summed > 1:
            return Words(_joined(stated, f"white rounding only in sums of {self.summed} samples"))
        if self.rounding == "quantization":
            added = f"{self.added:.3g} {_integrated(self.unit)}"
            return Words(_joined(stated, f"adds up to {added} of quantization noise"))
        return Words(
            _joined(stated, largest_factor_text(finding.factors)), finer if finding.severity == "warning" else ""
        )


def _on(finding: Finding, strongest: str) -> str:
    """The channel to which numbers refer, if the finding has several."""
    return strongest if len(finding.channels) > 1 else ""


def _joined(*parts: str) -> str:
    return "; ".join(part for part in parts if part)


def _held(details: HeldRuns, what: str) -> Words:
    share = percent(details.share)
    if details.samples == details.runs:
        if details.runs == 1:
            return Words(f"1 {what.removesuffix('s')} at {clock(details.start)} ({share})")
        return Words(f"{details.samples} single {what} ({share}), the first at {clock(details.start)}")
    longest = duration_text(details.longest)
    if details.runs == 1:
        return Words(f"a run of {what} at {clock(details.start)}, {longest} long ({share})")
    return Words(f"{details.runs} runs of {what} ({share}), the longest {longest} at {clock(details.start)}")


def _integrated(unit: str) -> str:
    """Unit of the angle or velocity."""
    return {"rad/s": "rad", "m/s^2": "m/s"}.get(unit, f"{unit}·s")
