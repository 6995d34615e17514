"""Findings about the sampling rate and the clock."""

from __future__ import annotations

from sigmatau.digits import round_to_error, two_digits
from sigmatau.findings.finding import Details, Finding, Words
from sigmatau.findings.phrases import clock, factor_text
from sigmatau.frozen import frozen
from sigmatau.hints import WITHOUT_STAMPS, Hint

_CLOCK_ERROR = 0.05  # relative difference of rates that no clock error explains: RC oscillators are within 2 %


@frozen
class ImplausibleRate(Details, code="implausible_rate"):
    """The time stamps of a gyro or accelerometer give less than 1 Hz: a log of averages, or a wrong unit of time.

    Attributes
    ----------
    rate, other_rate : float
        Rate by the stamps in use, and in the other unit. [Hz]
    unit, other_unit : str
        The units of time.
    stride : int
        Step from one stamp to the next, if stamps may be sample numbers; 0 if not.
    """

    rate: float
    unit: str
    other_rate: float
    other_unit: str
    stride: int = 0

    def words(self, finding: Finding) -> Words:
        numbers = ", and may be numbers of samples" if self.stride else ""
        return Words(
            f"the time stamps give {self.rate:.4g} Hz if they are in {self.unit}, {self.other_rate:.4g} Hz if they are in"
            f" {self.other_unit}{numbers}; {self.unit} is used",
            f"Give {Hint('unit', 'time', self.other_unit)} if the sensor's rate is {self.other_rate:.4g} Hz"
            + (f", or {WITHOUT_STAMPS} for numbers" if self.stride else ""),
        )


@frozen
class RateNotNominal(Details, code="rate_not_nominal"):
    """The rate by the stamps is close to a nominal rate, but differs from it significantly.

    Attributes
    ----------
    rate, nominal : float
        Rate by the stamps, and the nearest nominal rate of datasheets. [Hz]
    """

    rate: float
    nominal: float

    def words(self, finding: Finding) -> Words:
        off = self.rate / self.nominal - 1
        nominal = Hint("rate", value=f"{self.nominal:g}")
        return Words(
            f"the time stamps give {self.rate:.6g} Hz, {100 * abs(off):.2g} % {'less' if off < 0 else 'more'} than"
            f" {self.nominal:g} Hz; the rate of the time stamps is used",
            f"Give {nominal} only if the sensor's clock is more accurate than the time stamps",
        )


@frozen
class RateMismatch(Details, code="rate_mismatch"):
    """The rate in use differs from the rate by the stamps, or from the rate that the file states.

    Attributes
    ----------
    used, other : float
        [Hz]
    stated : bool
        Whether the file states the other rate.
    """

    used: float
    other: float
    stated: bool = False

    def words(self, finding: Finding) -> Words:
        if self.stated:
            return Words(f"the file states {self.other:g} Hz; the given rate of {self.used:g} Hz is used")
        message = f"{self.used:.6g} Hz is used, but the time stamps give {self.other:.6g} Hz"
        factor = dict(finding.factors).get("random_walk")
        if factor is None:
            return Words(f"{message}; all times and coefficients are affected")
        action = f"Omit {Hint('rate')} unless it is more accurate than the time stamps"
        if abs(self.used / self.other - 1) > _CLOCK_ERROR:
            used = Hint("rate", value=f"{self.used:.6g}")
            action = f"Omit {Hint('rate')}; if the time stamps are wrong, use {Hint('channels', 'time', 'none')} {used}"
        return Words(f"{message}: {factor_text('random_walk', factor)} if the time stamps are right", action)


@frozen
class RateDrift(Details, code="rate_drift"):
    """The sampling rate changes over the record, according to the mean rates of ten equal parts.

    Attributes
    ----------
    lowest, highest : float
        Standard error of each of the ten rates. [Hz]
    """

    lowest: float
    highest: float

    def words(self, finding: Finding) -> Words:
        return Words(
            f"the sampling rate varies by {two_digits(100 * (finding.size or 0.0))} %, from {self.lowest:.6g} to"
            f" {self.highest:.6g} Hz; largest deviation from t = {clock(finding.spans[0][0])}",
            "Look for lost samples if the rate changes abruptly",
        )


@frozen
class RateChange(Details, code="rate_change"):
    """The sampling rate changes abruptly, once.

    Attributes
    ----------
    before, after : float
        [Hz]
    grid : float
        Rate in use. [Hz]
    place : str
        The row after the change, as numbered in the file; empty in a live log.
    """

    before: float
    after: float
    grid: float
    place: str = ""

    def words(self, finding: Finding) -> Words:
        return Words(
            f"the sampling rate changes from {self.before:.4g} to {self.after:.4g} Hz at t ="
            f" {clock(finding.spans[0][0])}{self.place and f' ({self.place})'}; all of it is analysed at {self.grid:.6g} Hz",
            "Split the log there, and analyse the parts separately",
        )


@frozen
class ClockOff(Details, code="clock_off"):
    """Lines and filter corners differ from those of other records of the unit by a common factor; the size is the
    factor.

    Attributes
    ----------
    factor, low, high : float
        Factor of the frequencies, with its interval. [1]
    marks : int
        Number of lines, resonances and corners with this factor instead of 1.
    others : int
        Records that agree with each other.
    """

    factor: float
    low: float
    high: float
    marks: int
    others: int

    def words(self, finding: Finding) -> Words:
        factor = round_to_error(self.factor, self.low, self.high).text
        return Words(
            f"its clock is off: {self.marks} lines and corners are at {factor} times their frequency in"
            f" {self.others} other records",
            f"Check its clock and its rate; {1 / self.factor:.4g} times this rate agrees with the other records",
        )
