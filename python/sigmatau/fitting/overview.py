"""Overview of a result: the main coefficients of each axis and how far to trust them; in 80 columns for a terminal."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby
from typing import Literal

from sigmatau.digits import limit_text, round_to_error
from sigmatau.findings.finding import Finding
from sigmatau.fitting.fitted_noise import Trust
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.frozen import frozen
from sigmatau.noise.terms import TERMS, display_units
from sigmatau.results import aligned, duration_text

COLUMNS = ("random_walk", "bias_instability", "rate_random_walk")
"""Terms with a column: those that filters use."""

# meaning of the grades of trust, printed below the table
_MEANING = {"partial": "usable with the limits in the ! lines", "poor": "do not use"}
_SHORT_LABELS = ("random walk", "bias instab.", "rate walk")  # short labels of `COLUMNS`

Form = Literal["full", "short", "below"]
"""Form of the table: with the names of the terms, with short names, or also with the interval below each value."""

_FORMS: tuple[Form, ...] = ("full", "short", "below")
_LARGE = 1.5  # factor of error that makes a coefficient useless


@frozen
class MainCoefficient:
    """A coefficient with its interval, as text in the unit of its sensor.

    Attributes
    ----------
    kind : {"value", "limit", "unknown", "not_fitted"}
    value : str
        ``"0.97"``, ``"below 190"``, ``"unknown"`` or ``"not fitted"``.
    interval : str
        ``"± 0.10"`` or ``"[12.4, 15.7]"``; empty except for a value.
    """

    kind: Literal["value", "limit", "unknown", "not_fitted"]
    value: str
    interval: str = ""

    @property
    def text(self) -> str:
        """Value and interval in a line."""
        return f"{self.value} {self.interval}".rstrip()


@frozen
class AxisCoefficients:
    """The main coefficients of a channel.

    Attributes
    ----------
    channel : str
    coefficients : tuple of MainCoefficient
        In the order of the terms of the overview.
    trust : {"good", "partial", "poor"}
    """

    channel: str
    coefficients: tuple[MainCoefficient, ...]
    trust: Trust


@frozen
class SensorCoefficients:
    """The axes of a sensor, which share their units.

    Attributes
    ----------
    units : tuple of str
        In the order of the terms of the overview.
    length : str
        Length of the record, such as ``"3.3 min"``; ``"joint"`` for a joint fit of several runs.
    runs : int
        Number of the runs of a joint fit; otherwise 0.
    axes : tuple of AxisCoefficients
    """

    units: tuple[str, ...]
    length: str
    runs: int
    axes: tuple[AxisCoefficients, ...]


@frozen
class Overview:
    """The main coefficients of a result.

    Attributes
    ----------
    terms : tuple of str
    labels : tuple of str
        Names of the terms in words.
    level : float or None
        Confidence level of the intervals; None if the fits have several. [1]
    sensors : tuple of SensorCoefficients
    """

    terms: tuple[str, ...]
    labels: tuple[str, ...]
    level: float | None
    sensors: tuple[SensorCoefficients, ...]

    @property
    def grades(self) -> frozenset[Trust]:
        """The grades of trust that occur."""
        return frozenset(axis.trust for sensor in self.sensors for axis in sensor.axes)


def overview(
    fits: Mapping[str, NoiseFit], findings: Iterable[Finding] = (), *, width: int = 80, legend: bool = True
) -> str:
    """Random walk, bias instability and rate random walk of each channel in the units of the field, and `trust`.

    The confidence level of the intervals is in the corner.

    Parameters
    ----------
    fits : mapping of str to NoiseFit
        By channel.
    findings : iterable of Finding
        Findings of the record.
    width : int
        Width of the terminal. For a wider table the names of the terms are shortened, and then the intervals are put
        below the values.
    legend : bool
        Whether a line below the table explains the trust.

    Returns
    -------
    str
        A table of at most 70 columns for names of up to 8 characters.
    """
    coefficients = main_coefficients(fits, findings)
    text = ""
    for form in _FORMS:
        text = "\n".join(aligned(text_rows(coefficients, form=form)))
        if max(map(len, text.splitlines())) <= width:
            break
    meant = [f"{word}: {_MEANING[word]}" for word in _MEANING if legend and word in coefficients.grades]
    return "\n".join([text, *(["; ".join(meant)] if meant else [])])


def dominant_terms(fits: Mapping[str, NoiseFit]) -> tuple[str, ...]:
    """`COLUMNS`, then the terms that are the largest at the shortest or longest averaging time of a fitted curve."""
    dominant: set[str] = set()
    for fitted in fits.values():
        values = {name: term.value for name, term in fitted.items() if term.value is not None}
        for tau in (fitted.tau_min, fitted.tau_max):
            if values and tau is not None:
                dominant.add(max(values, key=lambda name: float(abs(values[name]) * TERMS[name].deviation([tau])[0])))
    return *COLUMNS, *(name for name in TERMS if name in dominant.difference(COLUMNS))


def main_coefficients(
    fits: Mapping[str, NoiseFit], findings: Iterable[Finding] = (), *, terms: Sequence[str] = COLUMNS
) -> Overview:
    """The coefficients of some terms by sensor and axis, each sensor in units that suit its values."""
    findings = tuple(findings)
    levels = {fitted.level for fitted in fits.values()}
    return Overview(
        terms=tuple(terms),
        labels=tuple(TERMS[term].label("signal") for term in terms),
        level=levels.pop() if len(levels) == 1 else None,
        sensors=tuple(
            _sensor(dict(group), findings, terms) for _, group in groupby(fits.items(), lambda item: _kind(item[1]))
        ),
    )


def _sensor(fits: Mapping[str, NoiseFit], findings: Sequence[Finding], terms: Sequence[str]) -> SensorCoefficients:
    first = next(iter(fits.values()))
    units = [
        display_units(
            term, first.quantity, first.rate_unit, [_printed_number(fitted, term) for fitted in fits.values()]
        )[-1]
        for term in terms
    ]
    return SensorCoefficients(
        units=tuple(text for text, _ in units),
        length="joint" if first.runs else duration_text(first.n * first.tau0),
        runs=len(first.runs),
        axes=tuple(
            AxisCoefficients(
                channel=channel,
                coefficients=tuple(
                    _coefficient(fitted, term, factor) for term, (_, factor) in zip(terms, units, strict=True)
                ),
                trust=trust(fitted, findings, channel),
            )
            for channel, fitted in fits.items()
        ),
    )


def text_rows(coefficients: Overview, *, form: Form = "full") -> list[tuple[str, ...]]:
    """The cells of `overview`: a head, a row of units for each sensor, and one row per channel, or two with intervals
    below.
    """
    labels = coefficients.labels if form == "full" else _SHORT_LABELS
    corner = "" if coefficients.level is None else f"{100 * coefficients.level:g} %"
    rows: list[tuple[str, ...]] = [(corner, *labels, "trust")]
    for sensor in coefficients.sensors:
        rows.append((f"[{sensor.length}]", *sensor.units, ""))
        for axis in sensor.axes:
            values = axis.coefficients
            if form == "below":
                rows.append((axis.channel, *(value.value for value in values), axis.trust))
                rows.append(("", *(value.interval for value in values), ""))
            else:
                rows.append((axis.channel, *(value.text for value in values), axis.trust))
    return rows


def trust(fitted: NoiseFit, findings: Iterable[Finding], channel: str) -> Trust:
    """How far to trust the coefficients of a channel: the rule in docs/numbers.md.

    Returns
    -------
    {"good", "partial", "poor"}
        ``"poor"``: the model has no intervals or p < 1e-6, or a warning states that a coefficient is wrong by half or
        more; ``"partial"``: the intervals are wider because the model does not fit exactly, or do not include the effect
        of a warning; ``"good"``: neither.
    """
    warnings = [finding for finding in findings if _lowers_trust(finding, fitted, channel)]
    if not fitted.quantified or fitted.is_misfit or any(_makes_useless(finding) for finding in warnings):
        return "poor"
    return "partial" if warnings or fitted.verdict == "widened" else "good"


def _lowers_trust(finding: Finding, fitted: NoiseFit, channel: str) -> bool:
    """Whether a finding is a warning whose effect the intervals of the channel do not include."""
    is_allowed = (finding.size or 0.0) < finding.details.allowed_share * fitted.n
    return finding.severity != "info" and (channel in finding.channels or not finding.channels) and not is_allowed


def _makes_useless(finding: Finding) -> bool:
    """Whether a finding states that a coefficient is wrong by half or more."""
    factors = [factor for term, factor in finding.factors if term in COLUMNS and factor > 0]
    return any(max(factor, 1 / factor) >= _LARGE for factor in factors)


def _kind(fitted: NoiseFit) -> tuple[str, str, int, float, int]:
    return fitted.quantity, fitted.rate_unit, fitted.n, fitted.tau0, len(fitted.runs)


def _printed_number(fitted: NoiseFit, name: str) -> float | None:
    """The value or the upper limit of a term; None if it has neither."""
    term = fitted.get(name)
    return None if term is None else term.upper_limit if term.value is None else term.value


def _coefficient(fitted: NoiseFit, name: str, factor: float) -> MainCoefficient:
    """A coefficient in a unit of the size `factor`."""
    term = fitted.get(name)
    unknown = MainCoefficient(kind="unknown", value="unknown")
    if not fitted.has_limits:
        return unknown
    if term is None:
        return MainCoefficient(kind="not_fitted", value="not fitted")
    if term.value is None:
        limit = term.upper_limit
        return unknown if limit is None else MainCoefficient(kind="limit", value=limit_text(limit / factor))
    if term.low is None or term.high is None:
        return unknown
    rounded = round_to_error(term.value, term.low, term.high, size=factor)
    return MainCoefficient(kind="value", value=rounded.value, interval=rounded.error_text)
