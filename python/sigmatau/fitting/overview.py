"""The result at a glance: a row an axis with its main coefficients and how far to trust them, in 80 columns."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby

from sigmatau.findings.finding import Finding
from sigmatau.fitting.fitted_noise import Trust
from sigmatau.fitting.fitted_values import FittedTerm
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.noise.terms import TERMS, display_units
from sigmatau.results import duration_text, two_digits, value_error_text, value_error_texts

COLUMNS = ("random_walk", "bias_instability", "rate_random_walk")
"""The terms that have a column: those that filters take."""

_MEANING = {"partial": "usable with the limits in the ! lines", "poor": "do not use"}  # of trust, below the table
_LARGE = 1.5  # a coefficient that is wrong by this factor is of little use
_EVEN = 2.0  # sides of an interval that differ by less are one ±, the larger one, if the value stays clear of 0


def overview(
    fits: Mapping[str, NoiseFit], findings: Iterable[Finding] = (), *, width: int = 80, legend: bool = True
) -> str:
    """Random walk, bias instability and rate random walk of each channel in the field's units, and `trust`.

    Parameters
    ----------
    fits : mapping of str to NoiseFit
        By channel.
    findings : iterable of Finding
        Findings of the record.
    width : int
        Of the terminal. Where the table is wider, its numbers are shorter: at most 60 columns for names of 7 characters.
    legend : bool
        Whether a line below the table says what the trust means.

    Returns
    -------
    str
        At most 80 columns for names of up to 16 characters.
    """
    findings = tuple(findings)
    rows = overview_rows(fits, findings)
    text = _aligned(rows)
    if max(map(len, text.splitlines())) > width:
        text = _aligned(overview_rows(fits, findings, short=True))
    meant = [f"{word}: {_MEANING[word]}" for word in _MEANING if legend and any(row[-1] == word for row in rows)]
    return "\n".join([text, *(["; ".join(meant)] if meant else [])])


def _aligned(rows: Sequence[Sequence[str]]) -> str:
    widths = [max(len(row[k]) for row in rows) for k in range(len(COLUMNS) + 2)]
    return "\n".join("  ".join(map(str.ljust, row, widths)).rstrip() for row in rows)


def overview_rows(
    fits: Mapping[str, NoiseFit], findings: Iterable[Finding] = (), *, short: bool = False
) -> list[tuple[str, ...]]:
    """The cells of `overview`: a head, and for each sensor a row of units and a row a channel."""
    findings = tuple(findings)
    labels = (TERMS[term].symbols[0] if short else TERMS[term].label("signal") for term in COLUMNS)
    rows: list[tuple[str, ...]] = [("", *labels, "trust")]
    for (quantity, unit, n, tau0, runs), group in groupby(fits.items(), lambda item: _kind(item[1])):
        units = (display_units(term, quantity, unit)[-1][0] for term in COLUMNS)
        rows.append((f"[{'joint' if runs else duration_text(n * tau0)}]", *units, ""))
        for channel, fitted in group:
            values = (_text(fitted, term, short=short) for term in COLUMNS)
            rows.append((channel, *values, trust(fitted, findings, channel)))
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
    """Whether a finding is a warning about a channel that the intervals of its fit do not allow for."""
    is_allowed = (finding.size or 0.0) < finding.details.allowed_share * fitted.n
    return finding.severity != "info" and (channel in finding.channels or not finding.channels) and not is_allowed


def _makes_useless(finding: Finding) -> bool:
    """Whether a finding states that a coefficient is wrong by half or more."""
    factors = [factor for term, factor in finding.factors if term in COLUMNS and factor > 0]
    return any(max(factor, 1 / factor) >= _LARGE for factor in factors)


def _kind(fitted: NoiseFit) -> tuple[str, str, int, float, int]:
    return fitted.quantity, fitted.rate_unit, fitted.n, fitted.tau0, len(fitted.runs)


def _text(fitted: NoiseFit, name: str, *, short: bool) -> str:
    """``2.429 ± 0.011``, ``25 -15 +32``, ``below 190``, or ``unknown``."""
    term = fitted.get(name)
    factor = display_units(name, fitted.quantity, fitted.rate_unit)[-1][1]
    if not fitted.has_limits:
        return "unknown"
    if term is None:
        return "not fitted"
    if term.value is None:
        below = "<" if short else "below "
        return "unknown" if term.upper_limit is None else f"{below}{two_digits(term.upper_limit / factor)}"
    return _with_sides(term, factor, short=short)


def _with_sides(term: FittedTerm, factor: float, *, short: bool) -> str:
    if term.value is None or term.low is None or term.high is None:
        return "unknown"
    value, low, high = term.value / factor, term.low / factor, term.high / factor
    below, above = value - low, high - value
    if short:
        return value_error_text(value, max(below, above)).replace(" ", "")
    if max(below, above) <= min(_EVEN * min(below, above), 0.95 * abs(value)):
        rounded = value_error_texts(value, max(below, above))
        if rounded[0] != rounded[1]:  # not 10 ± 10 of 10.4 ± 9.7
            return " ± ".join(rounded)
    decimals = 1 - math.floor(math.log10(max(below, above)))
    digits = max(decimals, 0)
    texts = [f"{round(number, decimals):.{digits}f}" for number in (value, below, above)]
    return f"{texts[0]} -{texts[1]} +{texts[2]}"
