"""Findings about a unit of a lot: against a specification, and in comparison with the other units."""

from __future__ import annotations

from typing import Literal

from sigmatau import Finding
from sigmatau.digits import round_to_error, two_digits
from sigmatau.findings.finding import Details, Words
from sigmatau.frozen import frozen
from sigmatau.hints import Hint
from sigmatau.lab.lots.axis_changes import AxisChange
from sigmatau.lab.lots.conditions import FactorName
from sigmatau.results import duration_text

FACTOR_WORDS: dict[FactorName, str] = {"temperature": "recorded", "supply": "supplied", "rate": "sampled"}
"""Verb before the value of a condition: "recorded at 85 °C"."""

_AS_LOTS = "none compared with another; judge each group as a lot"
_MOST_GROUPS = 3  # largest number of groups that are named
_FACTOR_FROM = 3.0  # smallest ratio that is printed as a factor, "57 times", and not in per cent


def difference(ratio: float) -> str:
    """A ratio in words, to be followed by the reference: ``"12 % above"``, ``"57 times"``, ``"1/57 of"``.

    Examples
    --------
    >>> difference(1.123), difference(0.5), difference(57.3), difference(1 / 57.3)
    ('12 % above', '50 % below', '57 times', '1/57 of')
    """
    if ratio >= _FACTOR_FROM:
        return f"{two_digits(ratio)} times"
    if ratio <= 1 / _FACTOR_FROM:
        return f"1/{two_digits(1 / ratio)} of" if ratio > 0 else "far below"
    percent = 100 * abs(ratio - 1)
    return f"{two_digits(percent)} % {'above' if ratio >= 1 else 'below'}"


@frozen
class OfLot(Details):
    """Base of the findings of this module."""


@frozen
class ComparedValue(OfLot):
    """Base of findings that compare a value with a reference.

    Attributes
    ----------
    what : str
        Name of the claim or of the coefficient.
    value, limit : float or None
        Measured value, and the maximum. [`factor` of `unit`]
    ratio : float or None
        Value over the maximum, over the median of the lot, or over the value in the specification. [1]
    unit : str
        Unit in which value and limit are printed.
    factor : float
        Factor from this unit to that of value and limit.
    low, high : float or None
        Interval of the value. [`factor` of `unit`]
    """

    what: str
    value: float | None = None
    limit: float | None = None
    ratio: float | None = None
    unit: str = ""
    factor: float = 1.0
    low: float | None = None
    high: float | None = None

    @property
    def measured(self) -> str:
        """The value with its interval."""
        if self.value is None or self.low is None or self.high is None:
            return self._amount(self.value)
        return round_to_error(*(number / self.factor for number in (self.value, self.low, self.high))).with_unit(
            self.unit
        )

    def _amount(self, value: float | None) -> str:
        return "unknown" if value is None else f"{value / self.factor:.3g} {self.unit}".rstrip()


@frozen
class AboveMaximum(ComparedValue, code="above_maximum"):
    """A value is above its maximum."""

    def words(self, finding: Finding) -> Words:
        maximum = f"the maximum {self._amount(self.limit)}"
        if self.value is None or self.ratio is None:
            return Words(f"{self.what} is above {maximum}")
        return Words(f"{self.what} {self.measured} is {difference(self.ratio)} {maximum}")


@frozen
class Undecided(ComparedValue, code="undecided"):
    """The interval contains the maximum.

    Attributes
    ----------
    convention : {"sided", "bias"} or None
        What the specification leaves open, if the decision depends on it.
    """

    convention: Literal["sided", "bias"] | None = None

    def words(self, finding: Finding) -> Words:
        if self.convention is not None:
            first, second = ("one", "two") if self.convention == "sided" else ("minimum", "coefficient")
            choice = f"{Hint(self.convention, value=first)} or {second}"
            return Words(f"{self.what}: the datasheet does not state the convention; give {choice}")
        measured = "is not observed" if self.value is None else self.measured
        return Words(
            f"{self.what} {measured}: the interval contains the maximum {self._amount(self.limit)}; record longer"
        )


@frozen
class ImplausibleValue(ComparedValue, code="implausible_value"):
    """A value is far from that in the specification: a wrong unit, or another sensor.

    Attributes
    ----------
    stated : str
        Kind of the value in the specification: ``"typical"``, ``"maximum"`` …
    """

    stated: str

    def words(self, finding: Finding) -> Words:
        off = f"{difference(self.ratio or 1.0)} the {self.stated} value of the specification"
        return Words(f"implausible: {self.what} is {off}; check unit and sensor")


@frozen
class Outlier(ComparedValue, code="outlier"):
    """A value is an outlier among those of the other units."""

    def words(self, finding: Finding) -> Words:
        return Words(
            f"outlier: {self.what} {self._amount(self.value)} is {difference(self.ratio or 1.0)} the lot's median"
        )


@frozen
class SlowNoise(OfLot, code="slow_noise"):
    """The Allan deviation at a long averaging time is an outlier among those of the other units.

    Attributes
    ----------
    tau : float
        Averaging time. [s]
    ratio : float
        Ratio to the median of the lot. [1]
    what : str
        Slow coefficient that the unit shows and the lot does not; empty if there is none.
    value : float or None
        Its value. [`factor` of `unit`]
    unit : str
        Unit in which it is printed.
    factor : float
        Factor from this unit to that of the value.
    """

    tau: float
    ratio: float
    what: str = ""
    value: float | None = None
    unit: str = ""
    factor: float = 1.0

    def words(self, finding: Finding) -> Words:
        off = f"Allan deviation at {self.tau:.3g} s is {difference(self.ratio)} the lot's median"
        if self.value is None:
            return Words(f"slow noise: {off}")
        return Words(f"outlier: {self.what} {self.value / self.factor:.3g} {self.unit}; the {off}")


@frozen
class OtherScale(OfLot, code="other_scale"):
    """The curves of a sensor, or its gravity, are not those of the lot: a wrong unit, a wrong scale, or a bad unit.

    Attributes
    ----------
    ratio : float
        Ratio of the curves to the median of the lot; 1 if only gravity differs. [1]
    likely : (str, str) or None
        Unit of the sensor and the unit that it was probably read as; None if no mistake explains the ratio.
    gravity : float or None
        Ratio of the mean acceleration to that of the lot; None if it does not differ. [1]
    """

    ratio: float
    likely: tuple[str, str] | None = None
    gravity: float | None = None

    def words(self, finding: Finding) -> Words:
        if self.gravity is not None and self.ratio == 1.0:
            return Words(f"scale or bias? Gravity is {difference(self.gravity)} the lot's median")
        if self.gravity is not None:
            sizes = f"gravity is {difference(self.gravity)} the lot's median, the noise {difference(self.ratio)} it"
            return Words(f"wrong scale: {sizes}")
        off = f"curves are {difference(self.ratio)} the lot's median"
        if self.likely is None:
            return Words(f"all {off}")
        return Words(f"wrong unit, {self.likely[0]} read as {self.likely[1]}? All {off}")


@frozen
class Orientation(OfLot, code="orientation"):
    """The axes of a unit differ from those of the lot: they are exchanged or reversed, or the unit is mounted differently.

    Attributes
    ----------
    changes : tuple of AxisChange
        Changes of the axes that explain its means, the most plausible one first.
    vertical : int or None
        Axis of gravity in the lot: 0, 1 or 2; None if only gyros differ.
    along, along_lot : str
        Direction of gravity in the unit and in the lot, ``"+z"``; empty if only gyros differ.
    """

    changes: tuple[AxisChange, ...]
    vertical: int | None = None
    along: str = ""
    along_lot: str = ""

    def words(self, finding: Finding) -> Words:
        ways = ", or ".join(change.words(self.vertical) for change in self.changes)
        if not self.along:
            return Words(f"{ways}: the means are those of other axes of the lot")
        return Words(f"{ways}: gravity is along {self.along}, in the lot along {self.along_lot}")


@frozen
class OtherMean(OfLot, code="other_mean"):
    """The mean of a channel is an outlier among those of the other units.

    Attributes
    ----------
    value, median, spread : float
        Mean of the unit; median and robust standard deviation of those of the lot. [`factor` of `unit`]
    unit : str
        Unit in which they are printed.
    factor : float
        Factor from this unit to that of the values.
    """

    value: float
    median: float
    spread: float
    unit: str
    factor: float = 1.0

    def words(self, finding: Finding) -> Words:
        error = (self.spread or abs(self.value - self.median)) / self.factor
        value, median = (round_to_error(number / self.factor, error=error) for number in (self.value, self.median))
        return Words(f"outlier: mean {value.value} {self.unit}; the lot has {median.with_unit(self.unit)}")


@frozen
class NoMaximum(OfLot, code="no_maximum"):
    """The specification has no maximum of a value.

    Attributes
    ----------
    what : str
        Names of the claims.
    """

    what: str

    def words(self, finding: Finding) -> Words:
        return Words(f"no maximum in the specification; state one, or give {Hint('factor', value=1.5)}: {self.what}")


@frozen
class NotMeasured(OfLot, code="not_measured"):
    """A value or an axis of the specification is not in the result.

    Attributes
    ----------
    what : str
        Name of the claim; empty for an axis.
    """

    what: str = ""

    def words(self, finding: Finding) -> Words:
        return Words(f"{self.what or 'in the specification'}: not in the result")


@frozen
class NoModel(OfLot, code="no_model"):
    """No model fits a channel, so that its errors are unknown."""

    def words(self, finding: Finding) -> Words:
        return Words("no model fits, so that the errors are unknown")


@frozen
class NoSpecification(OfLot, code="no_specification"):
    """There is no specification."""

    def words(self, finding: Finding) -> Words:
        return Words(f"no specification; give {Hint('spec', value='SPEC.toml')}")


@frozen
class ShortRecord(OfLot, code="short_record"):
    """The record is shorter than those of the lot.

    Attributes
    ----------
    ratio : float
        Its length over the median of the lot. [1]
    length : float
        [s]
    """

    ratio: float
    length: float

    def words(self, finding: Finding) -> Words:
        usual = duration_text(self.length / self.ratio)
        return Words(f"truncated? The record has {duration_text(self.length)}, the lot {usual}")


@frozen
class OtherCondition(OfLot, code="other_condition"):
    """The unit was recorded under another condition than the lot, and is not compared with it.

    Attributes
    ----------
    factor : {"temperature", "supply", "rate"}
    value, value_of_lot : str
        In words, ``"at 85 °C"``.
    """

    factor: FactorName
    value: str
    value_of_lot: str

    def words(self, finding: Finding) -> Words:
        return Words(f"{FACTOR_WORDS[self.factor]} {self.value}, the lot {self.value_of_lot}; not compared with it")


@frozen
class MixedLot(OfLot, code="mixed_lot"):
    """The lot has groups under several conditions, none of which has two thirds of the units; no unit is compared.

    Attributes
    ----------
    factor : {"temperature", "supply", "rate", "orientation"}
    groups : tuple of (str, int)
        Conditions in words, and their numbers of units.
    """

    factor: FactorName | Literal["orientation"]
    groups: tuple[tuple[str, int], ...]

    def words(self, finding: Finding) -> Words:
        listed = ", ".join(f"{count} {value}" for value, count in self.groups[:_MOST_GROUPS])
        rest = len(self.groups) - _MOST_GROUPS
        listed += f" and {rest} more" if rest > 0 else ""
        if self.factor == "orientation":
            return Words(f"the lot has {len(self.groups)} orientations: {listed}; mount all alike")
        return Words(f"the lot has units {listed}, {_AS_LOTS}")


@frozen
class OtherAxes(OfLot, code="other_axes"):
    """The channels differ from those of the lot.

    Attributes
    ----------
    lacking, extra : tuple of str
        Channels of the lot that the unit lacks, and its channels that the lot lacks.
    """

    lacking: tuple[str, ...]
    extra: tuple[str, ...]

    def words(self, finding: Finding) -> Words:
        parts = [f"{word} {', '.join(names)}" for word, names in (("no", self.lacking), ("also", self.extra)) if names]
        return Words(f"channels differ from the lot: {'; '.join(parts)}")


@frozen
class SameData(OfLot, code="same_data"):
    """The data are the same as those of another unit.

    Attributes
    ----------
    unit : str
        Its name.
    """

    unit: str

    def words(self, finding: Finding) -> Words:
        return Words(f"the data are those of {self.unit}; log this unit again")


@frozen
class NotExpected(OfLot, code="not_expected"):
    """The unit is not on the list of expected units."""

    def words(self, finding: Finding) -> Words:
        return Words("not on the list of expected units")


@frozen
class Unreadable(OfLot, code="unreadable"):
    """The log or the result cannot be read.

    Attributes
    ----------
    reason : str
        Text of the error.
    """

    reason: str

    def words(self, finding: Finding) -> Words:
        return Words(self.reason)


@frozen
class Missing(OfLot, code="missing"):
    """The unit is expected, but there is no file."""

    def words(self, finding: Finding) -> Words:
        return Words("expected, but there is no file")


CODES = frozenset(
    kind.code for kind in vars().copy().values() if isinstance(kind, type) and issubclass(kind, OfLot)
) - {""}
"""Codes of the findings about a lot; findings of the analysis have other codes."""
