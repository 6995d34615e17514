"""Findings about fits."""

from __future__ import annotations

import math

from sigmatau.digits import round_to_error, significant, two_digits
from sigmatau.findings.finding import Details, Finding, Words, axes_text
from sigmatau.findings.phrases import percent
from sigmatau.findings.reasons import IncompleteRecord, Reason, TooFewTimes, count_text, off_text
from sigmatau.frozen import frozen
from sigmatau.hints import Hint
from sigmatau.noise.terms import TERMS, display_units
from sigmatau.results import duration_text, seconds

_ORDERS = {1: "first", 2: "second", 3: "third", 4: "fourth", 5: "fifth", 6: "sixth"}
_MANY_LINES = 10  # smallest number of lines that are the most likely cause of a misfit


@frozen
class TooShort(Details, code="too_short"):
    """The channel is not fitted.

    Attributes
    ----------
    reasons : tuple of Reason
        Reason; see the kinds of reasons in `sigmatau.findings.reasons`.
    missing : float
        Share of the samples that is missing.
    """

    reasons: tuple[Reason, ...]
    missing: float = 0.0

    def words(self, finding: Finding) -> Words:
        text = f"not fitted: {self.reasons[0].text}"
        if finding.size is not None:
            return Words(
                f"{text}; {percent(self.missing)} of the samples are missing",
                "Find the cause of the loss; a longer record with the same losses helps little",
            )
        reason = self.reasons[0]
        if isinstance(reason, IncompleteRecord):
            allowed = f"Use {Hint('method', value='likelihood')}, which allows for missing samples"
            return Words(
                text, allowed if reason.suits_likelihood else "Record longer, or use a part without missing samples"
            )
        return Words(text, "Record longer" if isinstance(self.reasons[0], TooFewTimes) else "")


@frozen
class NoAdequateModel(Details, code="no_adequate_model", alters_all=True):
    """The coefficients describe the curve and have no intervals.

    Attributes
    ----------
    reasons : tuple of Reason
        Reason; see the kinds of reasons in `sigmatau.findings.reasons`.
    """

    reasons: tuple[Reason, ...]

    def words(self, finding: Finding) -> Words:
        action = "Look for a spectral line, a filter or a disturbance; the values have no intervals"
        return Words(f"no model fits: {self.reasons[0].text}", action)


@frozen
class Widened(Details, code="widened"):
    """The best model does not fit the spectrum exactly, and the intervals allow for it; the size is the relative error
    of the random walk.

    Attributes
    ----------
    frequency : float
        Frequency of the largest misfit. [Hz]
    ratio : float
        Measured density over that of the model at this frequency. [1]
    allowed : float
        Largest standard deviation of the logarithm of the density that the intervals allow for.
    lines : int
        Spectral lines of the model.
    crowded : float
        Share of the band that the lines cover, if it is large enough for them to be noise; otherwise 0. [1]
    only_walk : bool
        Whether the misfit has p < 1e-6: at most the random walk has an interval, and the other terms are unknown.
    """

    frequency: float
    ratio: float
    allowed: float
    lines: int = 0
    crowded: float = 0.0
    only_walk: bool = False

    def possible_factors(self, size: float | None) -> dict[str, float]:
        """The random walk may be wrong by the ratio of the upper end of its interval to its value."""
        return {} if size is None else {"random_walk": 1 + size}

    def words(self, finding: Finding) -> Words:
        off = f"the density near {self.frequency:.2g} Hz is {off_text(self.ratio)} the best model"
        crowded = f"{count_text(self.lines)} spectral lines cover {percent(self.crowded)} of the band and may be noise"
        without_lines = "Look for a vibration, or for noise that changes, and record again without it"
        if self.only_walk:
            action = without_lines if self.crowded else "Look for a cause near this frequency"
            text = f"{misfit_text(walk=finding.size is not None)}; {crowded if self.crowded else off}"
            return Words(text, f"{action}; the other terms are unknown")
        if self.crowded:
            return Words(f"{crowded}; the interval of the random walk covers both cases", without_lines)
        if self.lines >= _MANY_LINES:
            action = "Look for a vibration or a supply with these frequencies, and record again without it"
            return Words(f"{count_text(self.lines)} spectral lines, and {off}; intervals are wider", action)
        return Words(
            f"{off}; intervals are wider", "Look for a cause near this frequency, or accept the wider intervals"
        )


@frozen
class ChangingLevel(Details, code="changing_level"):
    """The random walk differs between eighths of the record by more than chance, and its interval allows for it; the
    size is the largest over the smallest.

    Attributes
    ----------
    quantity, rate_unit : str
        Quantity and unit of the channel.
    lowest, highest : float
        Random walk in the eighths. [SI]
    next_lowest, next_highest : float
        Interval of the random walk in the next record of this length. [SI]
    p_value : float
        P-value of equal random walks in all eighths. [1]
    """

    quantity: str
    rate_unit: str
    lowest: float
    highest: float
    next_lowest: float
    next_highest: float
    p_value: float

    def words(self, finding: Finding) -> Words:
        unit, factor = display_units("random_walk", self.quantity, self.rate_unit, [self.highest])[-1]
        label = TERMS["random_walk"].label(self.quantity)
        return Words(
            f"{label} from {_range(self.lowest / factor, self.highest / factor)} {unit} in eighths of the record;"
            f" {_range(self.next_lowest / factor, self.next_highest / factor)} in the next such record",
            "No action needed: the interval allows for it",
        )


def _range(low: float, high: float) -> str:
    """Format two ends with the same decimals, so that their difference has two digits: ``"0.193 to 0.227"``."""
    distance = max(high - low, 1e-12 * high)
    decimals = max(1 - math.floor(math.log10(distance)), 0)
    return f"{low:.{decimals}f} to {high:.{decimals}f}" if decimals <= 12 else f"{low:.4g} to {high:.4g}"


@frozen
class Disturbed(Details, code="disturbed"):
    """Vibration has most of the power of the record, so that the coefficients are upper limits.

    Attributes
    ----------
    quantity, rate_unit : str
        Quantity and unit of the channel.
    lines, resonances : int
        Number of each in the model.
    share : float
        Share of the power of all lines and resonances; random walk and quantization noise have the rest. Otherwise the
        share of intermittent motion.
    start, stop : float
        The quietest part of the record; both 0 for several runs. [s]
    quietest : float or None
        Upper limit of the random walk in that part, if it is smaller than that of the whole record. [SI]
    """

    quantity: str
    rate_unit: str
    lines: int
    resonances: int
    share: float
    start: float
    stop: float
    quietest: float | None

    def words(self, finding: Finding) -> Words:
        text = f"vibration has {percent(self.share)} of the power; the coefficients are upper limits"
        part = f"{self.start:.4g}s:{self.stop:.4g}s"
        if self.start == self.stop:
            return Words(text, "Record again without the vibration")
        if self.quietest is None:
            return Words(f"{text}, smallest from {self.start:.4g} to {self.stop:.4g} s", "Record again without it")
        unit, factor = display_units("random_walk", self.quantity, self.rate_unit, [self.quietest])[-1]
        limit = f"{two_digits(self.quietest / factor)} {unit}"
        return Words(
            f"{text}, {limit} in the quietest part", f"Record again without it, or try {Hint('window', value=part)}"
        )


@frozen
class OtherAxesDisturbed(Details, code="other_axes_disturbed"):
    """Vibration hides the noise of some axes of a sensor, and may be part of the noise of its other axes.

    Attributes
    ----------
    disturbed : tuple of str
        Channels with the finding `disturbed`.
    """

    disturbed: tuple[str, ...]

    def words(self, finding: Finding) -> Words:
        axes = ", ".join(self.disturbed)
        return Words(
            f"vibration hides the noise of {axes}, and may be in that of this sensor's other axes",
            "Record again without the vibration",
        )


@frozen
class BeyondClass(Details, code="beyond_class"):
    """More noise than the noisiest existing sensors, or a steeper ramp; the size is the density, or the ramp.

    Attributes
    ----------
    quantity : str
        Quantity of the channel.
    times : float
        Size over that of the noisiest sensor. [1]
    frequency : float or None
        Frequency of the density with the largest ratio; None for a ramp. [Hz]
    """

    quantity: str
    times: float
    frequency: float | None

    def words(self, finding: Finding) -> Words:
        unit, factor = ("deg/s", math.degrees(1.0)) if self.quantity == "angular_rate" else ("m/s^2", 1.0)
        size = significant(factor * (finding.size or 0.0))
        sensors = "gyros" if self.quantity == "angular_rate" else "accelerometers"
        if self.frequency is None:
            fact = f"the mean changes by {size} {unit} per second"
        else:
            fact = f"noise of {size} ({unit})/√Hz at {significant(self.frequency)} Hz"
        return Words(
            f"{fact}, {two_digits(self.times)} times that of the noisiest {sensors}",
            "Record the sensor at rest, and check the unit",
        )


@frozen
class FewDegreesOfFreedom(Details, code="few_degrees_of_freedom"):
    """The random walk of the fit has few degrees of freedom; the size is their number.

    Attributes
    ----------
    freedom : float
        Degrees of freedom of its square, from its standard error. [1]
    duration : float
        Duration of the record. [s]
    """

    freedom: float
    duration: float

    def words(self, finding: Finding) -> Words:
        return Words(
            f"the random walk has {self.freedom:.2g} degrees of freedom in {duration_text(self.duration)}",
            "Record longer",
        )


@frozen
class SecondExplanation(Details, code="second_explanation"):
    """Another model explains the record as well as the fit; the curve and predictions hold both.

    Attributes
    ----------
    quantity, rate_unit : str
        Quantity and unit of the channel.
    terms, other_terms : tuple of (str, float)
        Names and coefficients of terms that only the fit has, and of those that only the other model has or that differ
        much in it. [SI]
    processes, other_processes : tuple of (float, float)
        Standard deviation and correlation time of the Gauss-Markov processes of the fit, if the other model lacks them,
        and of those of the other model. [rate unit, s]
    other_warm_up : float or None
        Time constant of a warm-up in the other model. [s]
    other_exponent : float or None
        Exponent α of the bias instability of the other model, whose density is f^−α. [1]
    other_filter : float or None
        Corner of a first-order filter that limits the random walk of the other model. [Hz]
    """

    quantity: str
    rate_unit: str
    terms: tuple[tuple[str, float], ...]
    processes: tuple[tuple[float, float], ...]
    other_terms: tuple[tuple[str, float], ...]
    other_processes: tuple[tuple[float, float], ...]
    other_warm_up: float | None = None
    other_exponent: float | None = None
    other_filter: float | None = None

    def words(self, finding: Finding) -> Words:
        fitted = self._text(self.terms, self.processes) or "the model shown"
        second = self._text(self.other_terms, self.other_processes)
        if self.other_warm_up is not None:
            second = f"a warm-up with a time constant of about {duration_text(self.other_warm_up)}"
        elif self.other_exponent is not None:
            second = f"a bias instability with the density f^-{self.other_exponent:.2f}"
        if self.other_filter is not None:
            second += f" after a filter of {two_digits(self.other_filter)} Hz"
        return Words(f"{fitted}, or {second}", "A longer record distinguishes them; curve and predictions include both")

    def _text(self, terms: tuple[tuple[str, float], ...], processes: tuple[tuple[float, float], ...]) -> str:
        parts = []
        for name, value in terms:
            unit, factor = display_units(name, self.quantity, self.rate_unit, [value])[-1]
            label = TERMS[name].label(self.quantity)
            article = "an" if label[0] in "aeiou" else "a"
            parts.append(f"{article} {label} of {two_digits(value / factor)} {unit}")
        sigmas = [sigma for sigma, _ in processes]
        unit, factor = display_units("bias_instability", self.quantity, self.rate_unit, sigmas)[-1]
        for sigma, time in processes:
            size = f"{two_digits(sigma / factor)} {unit}"
            parts.append(f"a Gauss-Markov process of {size} over {duration_text(time)}")
        return " and ".join(parts)


@frozen
class CountedAngle(Details, code="counted_angle"):
    """Quantization noise expected from the step of a counted angle (or velocity), and quantization noise of the fit.

    Attributes
    ----------
    quantity, rate_unit : str
        Quantity and unit of the channel.
    step : float
        Step of the angle. [rate unit·s]
    by_step : float
        Quantization noise by the step, step/√12. [rate unit·s]
    value, low, high : float or None
        Quantization noise of the fit with its interval; None if it was not observed. [rate unit·s]
    limit : float or None
        Its upper limit, if it was not observed. [rate unit·s]
    """

    quantity: str
    rate_unit: str
    step: float
    by_step: float
    value: float | None = None
    low: float | None = None
    high: float | None = None
    limit: float | None = None

    def words(self, finding: Finding) -> Words:
        sizes = (self.step, self.by_step, self.value)
        unit, factor = display_units("quantization", self.quantity, self.rate_unit, sizes)[0]
        makes = (
            f"counts of {self.step / factor:.3g} {unit} make a quantization noise of {self.by_step / factor:.3g} {unit}"
        )
        if self.value is None:
            limit = "none" if self.limit is None else f"less than {self.limit / factor:.3g} {unit}"
            return Words(f"{makes}; the fit shows {limit}")
        if self.low is None or self.high is None:
            return Words(f"{makes}; the fit shows {self.value / factor:.3g} {unit}")
        value = round_to_error(self.value, self.low, self.high, size=factor)
        fitted = f"{makes}; the fit shows {value.with_unit(unit)}"
        if self.low > self.by_step:
            return Words(fitted, "Look for a further cause of the difference")
        return Words(fitted, "" if self.high >= self.by_step else "Use the value that follows from the counts")


@frozen
class ShortTimesLeftOut(Details, code="short_times_left_out"):
    """The fit begins beyond the shortest averaging time; the reasons are empty if this was requested.

    Attributes
    ----------
    tau_min : float
        [s]
    reasons : tuple of Reason
        Reasons; see the kinds in `sigmatau.findings.reasons`.
    """

    tau_min: float
    reasons: tuple[Reason, ...] = ()

    def words(self, finding: Finding) -> Words:
        why = f": {self.reasons[0].text}" if self.reasons else ""
        return Words(f"the fit starts at τ = {seconds(self.tau_min)} s{why}")


def filter_text(shape: str, order: int | None) -> str:
    """A filter in words: ``"second-order Butterworth filter"``."""
    if shape == "butterworth" and order is not None:
        return "first-order filter" if order == 1 else f"{_ORDERS[order]}-order Butterworth filter"
    return {
        "smoothing": "exponential smoothing",
        "running_mean": f"running mean of {order} samples",
        "running_means": "running mean" if order == 1 else f"{order} running means one after the other",
        "two_poles": "filter with two poles",
        "low_pass": "low-pass filter",
    }.get(shape, "uneven spectrum")


def added_parts_text(*, response: bool, lines: int, processes: int, resonances: int, warm_up: bool) -> str:
    """Parts of a model that are not terms: ``" with a filter and 5 lines"``; empty for nothing."""
    counts = (
        ("a filter", int(response)),
        ("a line", lines),
        ("a Gauss-Markov process", processes),
        ("a resonance", resonances),
        ("a warm-up", int(warm_up)),
    )
    named = [
        name if many == 1 else f"{count_text(many)} {name[2:]}{'es' if name.endswith('s') else 's'}"
        for name, many in counts
        if many
    ]
    return f" with {axes_text(named)}" if named else ""


def misfit_text(*, walk: bool) -> str:
    """The verdict on a fit with p < 1e-6. `walk`: whether the random walk has an interval."""
    return f"no model fits: {'only the random walk has an interval' if walk else 'all terms are unknown'}"


def verdict_text(verdict: str, parts: str = "") -> str:
    """The verdict on a fit: ``"the model fits with 5 lines"``, ``"the model fits roughly: wider intervals"``."""
    if verdict == "too_short":
        return "too short for a fit"
    if verdict == "descriptive":
        return "no model fits: values without intervals"
    if verdict == "disturbed":
        return f"disturbed{parts}: upper limits only"
    return f"the model fits{' roughly' if verdict == 'widened' else ''}{parts}" + (
        ": wider intervals" if verdict == "widened" else ""
    )
