"""Findings about slow changes: warm-up, temperature, noise that changes, selection of a window."""

from __future__ import annotations

from sigmatau.digits import round_to_error
from sigmatau.findings.finding import Details, Finding, Words
from sigmatau.findings.phrases import clock
from sigmatau.frozen import frozen
from sigmatau.hints import Hint, command
from sigmatau.noise.terms import display_units
from sigmatau.results import duration_text, seconds


@frozen
class WarmUpDrift(Details, code="warm_up"):
    """The signal settles exponentially from the first sample on, and the fit allows for it; the size is the
    amplitude.

    Attributes
    ----------
    quantity : str
        ``"angular_rate"``, ``"acceleration"`` or ``"signal"``.
    time_constant : float
        [s]
    low, high : float
        Interval of the size. [unit of the finding]
    """

    quantity: str
    time_constant: float
    low: float
    high: float

    def words(self, finding: Finding) -> Words:
        unit, factor = display_units("bias_instability", self.quantity, finding.unit, [finding.size])[-1]
        size = round_to_error(finding.size or 0.0, self.low, self.high, size=factor).with_unit(unit)
        return Words(
            f"warm-up of {size}, time constant about {duration_text(self.time_constant)}",
            "No action needed: the fit allows for it",
        )


@frozen
class TemperatureDrift(Details, code="temperature_drift"):
    """The signal follows the temperature, and the fit allows for it; the size is the coefficient per kelvin.

    Attributes
    ----------
    quantity : str
        ``"angular_rate"``, ``"acceleration"`` or ``"signal"``.
    rate_unit : str
        Unit of the signal.
    low, high : float
        Interval of the coefficient. [rate_unit/K]
    """

    quantity: str
    rate_unit: str
    low: float
    high: float

    def words(self, finding: Finding) -> Words:
        unit, factor = display_units("bias_instability", self.quantity, self.rate_unit, [finding.size])[-1]
        size = round_to_error(finding.size or 0.0, self.low, self.high, size=factor).with_unit(unit)
        return Words(
            f"temperature drift of {size}/K",
            "Compensate for temperature: the coefficients are those without the drift",
        )


@frozen
class SegmentSpread:
    """Difference between the Allan deviations of segments of the record, at the averaging time with the strongest evidence.

    Attributes
    ----------
    ratio : float
        Largest over smallest Allan deviation. [1]
    tau : float
        [s]
    tau_min, tau_max : float
        Shortest and longest averaging time at which the segments differ significantly; both are `tau` if no time is
        significant alone. [s]
    largest_at, smallest_at : float
        Beginnings of the segments with the largest and the smallest deviation, from the beginning of the record. [s]
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


@frozen
class NoiseChange:
    """A change of the short-time noise, found by the cusum of squared first differences.

    Attributes
    ----------
    time : float
        Time from the beginning of the record. [s]
    ratio : float
        Ratio of the root mean square of the first differences after the change to that before it. [1]
    """

    time: float
    ratio: float


@frozen
class NonStationary(Details, code="non_stationary"):
    """The noise changes during the record; at least one of the two tests found it.

    Attributes
    ----------
    segments : SegmentSpread or None
        Difference between segments; None if it is not significant.
    change : NoiseChange or None
        Change of the short-time noise; None if it is not significant.
    """

    segments: SegmentSpread | None = None
    change: NoiseChange | None = None

    def possible_factors(self, size: float | None) -> dict[str, float]:
        """The random walk of a part of the record may exceed that of another part by this factor."""
        return {} if size is None else {"random_walk": size}

    def words(self, finding: Finding) -> Words:
        texts, segments, change = [], self.segments, self.change
        if segments is not None:
            place = f" at τ = {seconds(segments.tau)} s, largest in the one from {clock(segments.largest_at)}"
            texts.append(
                f"Allan deviations of segments differ by a factor of {segments.ratio:.3g}{'' if change else place}"
            )
        if change is not None:
            texts.append(f"short-time noise changes by a factor of {change.ratio:.3g} at {clock(change.time)}")
        return Words(
            "; ".join(texts),
            f"Find the cause ({command('analyze', Hint('stability', value='MAP.png'))} shows the change),"
            f" or select a stationary part with {Hint('window')}",
        )
