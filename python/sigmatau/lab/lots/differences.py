"""Differences of the coefficients of two results of a sensor, with intervals that show whether it has changed.

References
----------
.. [1] G. Y. Zou, A. Donner, "Construction of confidence limits about effect measures: a general approach," Statistics in
   Medicine, vol. 27, no. 10, 2008, :doi:`10.1002/sim.3095`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, Literal

from sigmatau import Analysis
from sigmatau.digits import round_to_error
from sigmatau.errors import OptionError
from sigmatau.fitting import FittedTerm
from sigmatau.frozen import frozen
from sigmatau.noise.terms import display_units
from sigmatau.results import plain

Verdict = Literal["same", "differs", "unknown"]


@frozen
class TermDifference:
    """Difference of a coefficient between two results.

    Attributes
    ----------
    channel : str
    term : str
        Key of `sigmatau.noise.terms.TERMS`.
    unit : str
        SI.
    first, second : float or None
        The coefficient in each result; None if it was not observed. [unit]
    value, low, high : float or None
        Second minus first, with its confidence interval; None unless both were observed. [unit]
    level : float
        Confidence level of the interval.
    verdict : {"same", "differs", "unknown"}
        ``"same"`` if the interval contains 0. If one result has an upper limit: ``"differs"`` if the limit is below the
        interval of the other, otherwise ``"unknown"``.
    text : str
        The difference in the usual unit of the coefficient.
    """

    channel: str
    term: str
    unit: str
    first: float | None
    second: float | None
    value: float | None
    low: float | None
    high: float | None
    level: float
    verdict: Verdict
    text: str

    def to_dict(self) -> dict[str, Any]:
        """Plain values, for JSON."""
        return plain(self, "channel term unit first second value low high level verdict text")


def term_differences(first: Analysis, second: Analysis) -> tuple[TermDifference, ...]:
    """The differences of all coefficients that two results have in common.

    The interval of a difference is computed from those of the coefficients, which may be asymmetric, by the method of [1]_.
    If they are symmetric, its half width is the root of the sum of their squares. The records must be independent.

    Parameters
    ----------
    first, second : Analysis

    Returns
    -------
    tuple of TermDifference
        By channel and term. On average, one of 20 intervals of 95 % does not contain the true difference.

    Raises
    ------
    OptionError
        If a channel measures another quantity in the second result.
    """
    return tuple(_differences(first, second))


def _differences(first: Analysis, second: Analysis) -> Iterator[TermDifference]:
    for channel, fitted in first.fits.items():
        if channel not in second.fits:
            continue
        fitted_again = second.fits[channel]
        if (fitted.quantity, fitted.rate_unit) != (fitted_again.quantity, fitted_again.rate_unit):
            raise OptionError(f"{channel} has another quantity in {{option}}", option="second")
        for term, before in fitted.items():
            after = fitted_again.get(term)
            if after is None or (_is_unknown(before) and _is_unknown(after)):
                continue
            yield _difference(channel, before, after, fitted.quantity, fitted.rate_unit)


def _is_unknown(term: FittedTerm) -> bool:
    return term.value is None or term.low is None or term.high is None


def _difference(channel: str, before: FittedTerm, after: FittedTerm, quantity: str, rate_unit: str) -> TermDifference:
    value = low = high = None
    text, verdict = "", _limit_verdict(before, after)
    if not (_is_unknown(before) or _is_unknown(after)):
        value, low, high = _interval(before, after)
        verdict = "same" if low <= 0 <= high else "differs"
        unit, factor = display_units(before.term, quantity, rate_unit, [float(before.value or 0.0)])[-1]
        number = round_to_error(value / factor, error=(high - low) / 2 / factor, sign="+")
        text = f"{number.text} {unit}"
    return TermDifference(
        channel=channel, term=before.term, unit=before.unit, first=before.value, second=after.value, value=value, low=low,
        high=high, level=before.level, verdict=verdict, text=text,
    )  # fmt: skip


def _interval(before: FittedTerm, after: FittedTerm) -> tuple[float, float, float]:
    """The difference and its interval. [SI]"""
    a, a_low, a_high = _numbers(before)
    b, b_low, b_high = _numbers(after)
    difference = b - a
    return difference, difference - math.hypot(b - b_low, a_high - a), difference + math.hypot(b_high - b, a - a_low)


def _numbers(term: FittedTerm) -> tuple[float, float, float]:
    """Value and interval of an observed term. [SI]"""
    return float(term.value or 0.0), float(term.low or 0.0), float(term.high or 0.0)


def _limit_verdict(before: FittedTerm, after: FittedTerm) -> Verdict:
    """Verdict if only one result observes the coefficient and the other has an upper limit."""
    for observed, limited in ((before, after), (after, before)):
        if not _is_unknown(observed) and limited.upper_limit is not None:
            return "differs" if abs(float(observed.low or 0.0)) > limited.upper_limit else "unknown"
    return "unknown"
