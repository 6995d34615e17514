"""Overview of a result: one row per axis with its main coefficients and how far to trust them, in 80 columns."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby
from typing import Literal

from sigmatau.digits import Rounded, limit_text, round_to_error
from sigmatau.findings.finding import Finding
from sigmatau.fitting.fitted_noise import Trust
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.noise.terms import TERMS, display_units
from sigmatau.results import aligned, duration_text

COLUMNS = ("random_walk", "bias_instability", "rate_random_walk")
"""Terms with a column: those that filters use."""

# meaning of the grades of trust, printed below the table
_MEANING = {"partial": "usable with the limits in the ! lines", "poor": "do not use"}
_SHORT_LABELS = ("random walk", "bias instab.", "rate walk")  # of `COLUMNS`

Form = Literal["full", "short", "below"]
"""Form of the table: with the names of the terms, with short names, or also with the interval below each value."""

_FORMS: tuple[Form, ...] = ("full", "short", "below")
_LARGE = 1.5  # a coefficient that is wrong by this factor is of little use


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
        Of the terminal. Where the table is wider, the names of the terms are shorter; where it is still wider, the
        intervals are below the values.
    legend : bool
        Whether a line below the table says what the trust means.

    Returns
    -------
    str
        At most 70 columns for names of up to 8 characters.
    """
    findings = tuple(findings)
    text = ""
    for form in _FORMS:
        rows = overview_rows(fits, findings, form=form)
        text = "\n".join(aligned(rows))
        if max(map(len, text.splitlines())) <= width:
            break
    meant = [f"{word}: {_MEANING[word]}" for word in _MEANING if legend and any(row[-1] == word for row in rows)]
    return "\n".join([text, *(["; ".join(meant)] if meant else [])])


def dominant_columns(fits: Mapping[str, NoiseFit]) -> tuple[str, ...]:
    """`COLUMNS`, then the terms that are the largest at the shortest or longest averaging time of a fitted curve."""
    dominant: set[str] = set()
    for fitted in fits.values():
        values = {name: term.value for name, term in fitted.items() if term.value is not None}
        for tau in (fitted.tau_min, fitted.tau_max):
            if values and tau is not None:
                dominant.add(max(values, key=lambda name: float(abs(values[name]) * TERMS[name].deviation([tau])[0])))
    return *COLUMNS, *(name for name in TERMS if name in dominant.difference(COLUMNS))


def overview_rows(
    fits: Mapping[str, NoiseFit],
    findings: Iterable[Finding] = (),
    *,
    columns: Sequence[str] = COLUMNS,
    form: Form = "full",
) -> list[tuple[str, ...]]:
    """The cells of `overview`: a head, a row of units for each sensor, and one row per channel, or two with intervals
    below.
    """
    findings = tuple(findings)
    labels = (TERMS[term].label("signal") for term in columns) if form == "full" else _SHORT_LABELS
    levels = {f"{100 * fitted.level:g} %" for fitted in fits.values()}
    rows: list[tuple[str, ...]] = [(levels.pop() if len(levels) == 1 else "", *labels, "trust")]
    for (quantity, unit, n, tau0, runs), group in groupby(fits.items(), lambda item: _kind(item[1])):
        members = list(group)
        units = {
            term: display_units(term, quantity, unit, [_printed_number(fitted, term) for _, fitted in members])[-1]
            for term in columns
        }
        texts = (text for text, _ in units.values())
        rows.append((f"[{'joint' if runs else duration_text(n * tau0)}]", *texts, ""))
        for channel, fitted in members:
            values = [_value(fitted, term, units[term][1]) for term in columns]
            grade = trust(fitted, findings, channel)
            if form == "below":
                rows.append((channel, *(value if isinstance(value, str) else value.value for value in values), grade))
                rows.append(("", *("" if isinstance(value, str) else value.error_text for value in values), ""))
            else:
                rows.append((channel, *(value if isinstance(value, str) else value.text for value in values), grade))
    return rows


def trust(fitted: NoiseFit, findings: Iterable[Finding], channel: str) -> Trust:
    """How far to trust the coefficients of a channel: the rule in docs/numbers.md.

    Returns
    -------
    {"good", "partial", "poor"}
        ``"poor"``: the model has no intervals or p < 1e-6, or a warning states that a coefficient is wrong by half or more;
        ``"partial"``: the intervals are wider because the model does not fit exactly, or a warning is about the channel that
        they do not allow for; ``"good"``: neither.
    """
    warnings = [finding for finding in findings if _lowers_trust(finding, fitted, channel)]
    if not fitted.quantified or fitted.is_misfit or any(_makes_useless(finding) for finding in warnings):
        return "poor"
    return "partial" if warnings or fitted.verdict == "widened" else "good"


def _lowers_trust(finding: Finding, fitted: NoiseFit, channel: str) -> bool:
    """Whether a finding is a warning about a channel that the intervals of its fit do not include."""
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


def _value(fitted: NoiseFit, name: str, factor: float) -> Rounded | str:
    """The value with its interval, or ``"below 190"``, ``"unknown"``, ``"not fitted"``."""
    term = fitted.get(name)
    if not fitted.has_limits:
        return "unknown"
    if term is None:
        return "not fitted"
    if term.value is None:
        return "unknown" if term.upper_limit is None else limit_text(term.upper_limit / factor)
    if term.low is None or term.high is None:
        return "unknown"
    return round_to_error(term.value, term.low, term.high, size=factor)
