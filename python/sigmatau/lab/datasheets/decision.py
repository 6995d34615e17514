"""Decisions whether a measured value meets a maximum, by a named rule, with the risks of the consumer and the producer.

The likelihood of the logarithm of a value is that of a normal distribution, because a coefficient is a scale parameter; its
standard uncertainty differs on the two sides of the interval. With a flat prior, the probability that the true
value is above the maximum is the specific consumer's risk of acceptance, and its complement the specific producer's risk of
rejection (JCGM 106:2012, sections 7 and 9.3).
"""

from __future__ import annotations

import math
from statistics import NormalDist
from typing import Literal, get_args

from sigmatau.errors import OptionError
from sigmatau.frozen import frozen
from sigmatau.lab.datasheets.measured import Measured
from sigmatau.lab.datasheets.verdict import Verdict

Rule = Literal["simple acceptance", "guard band"]
"""Simple acceptance: the value is compared with the maximum (JCGM 106, 8.2). Guard band: a value conforms if its whole 95 %
interval is below the maximum, the guard band w is the expanded uncertainty U (ISO 14253-1)."""

Outcome = Literal["conforms", "does not conform", "not decided"]

RULE_WORDS: dict[Rule, str] = {
    "simple acceptance": "Simple acceptance (JCGM 106:2012, 8.2): a value conforms if it is at most the maximum. The"
    " uncertainty is not subtracted.",
    "guard band": "Guard band w = U (ISO 14253-1, JCGM 106:2012, 8.3.2): a value conforms if it is below the maximum by its"
    " expanded uncertainty U or more, and does not conform if it is above by U or more; otherwise there is no decision.",
}
"""The statement of each rule for a certificate."""

_NORMAL = NormalDist()


@frozen
class LimitDecision:
    """Decision about one maximum of a specification.

    Attributes
    ----------
    channel : str
    what : str
        Name of the specified value, with the convention in which it was read.
    value : float or None
        None if it was not observed. [unit]
    low, high : float or None
        95 % interval of the value; if it was not observed, `high` is its upper limit. [unit]
    maximum : float
        [unit]
    unit : str
    outcome : {"conforms", "does not conform", "not decided"}
    consumer_risk : float or None
        Probability that the true value is above the maximum, the risk of accepting. Its complement is the producer's risk of
        rejecting. None without an interval.
    at_most : bool
        Whether `consumer_risk` is only an upper bound, because the value was not observed.
    """

    channel: str
    what: str
    value: float | None
    low: float | None
    high: float | None
    maximum: float
    unit: str
    outcome: Outcome
    consumer_risk: float | None
    at_most: bool = False


def risk_above(value: float, low: float, high: float, maximum: float, *, level: float = 0.95) -> float:
    """Probability that the true value is above a maximum, given a measured value and its interval.

    Parameters
    ----------
    value, low, high : float
        Positive value and its interval; `low` may be 0.
    maximum : float
    level : float
        Level of the interval.

    Returns
    -------
    float

    Examples
    --------
    >>> f"{risk_above(1.0, 0.9, 1.1, 1.1):.3f}"  # the maximum is at the upper end of a 95 % interval
    '0.025'
    """
    reach = _NORMAL.inv_cdf((1 + level) / 2)
    above = maximum >= value
    end = high if above else low
    if end <= 0 or maximum <= 0:  # linear, for an interval that begins at 0
        distance, width = maximum - value, abs(value - end)
    else:
        distance, width = math.log(maximum / value), abs(math.log(end / value))
    if width == 0:
        return 0.5 if distance == 0 else float(distance < 0)
    return 1 - _NORMAL.cdf(reach * distance / width)


def decide(measured: Measured, maximum: float, rule: Rule) -> tuple[Outcome, float | None, bool]:
    """The outcome for a measured value, the consumer's risk of acceptance, and whether the risk is an upper bound.

    Raises `OptionError` for an unknown rule.
    """
    if rule not in get_args(Rule):
        raise OptionError(f"{{option}} must be {' or '.join(get_args(Rule))}, not {rule!r}", option="rule")
    value, low, high = measured.value, measured.low, measured.high
    if value is None:
        limit = measured.upper_limit
        if limit is not None and limit <= maximum and measured.level < 1:
            return "conforms", 1 - measured.level, True
        floor = measured.lower_limit
        return ("does not conform" if floor is not None and floor > maximum else "not decided"), None, False
    if low is None or high is None:
        return "not decided", None, False
    risk = risk_above(value, low, high, maximum, level=measured.level)
    if rule == "simple acceptance":
        return ("conforms" if value <= maximum else "does not conform"), risk, False
    # The guard band is U at 95 %, whatever the level of the interval: the limit of the risk is 2.5 % on each side.
    outcome: Outcome = "conforms" if risk <= _TAIL else "does not conform" if risk >= 1 - _TAIL else "not decided"
    return outcome, risk, False


_TAIL = 0.025 + 1e-9  # probability beyond an end of a 95 % interval, plus rounding errors


def decisions(verdict: Verdict, rule: Rule) -> list[LimitDecision]:
    """Decide on all maxima of a comparison with a specification: one decision for each meaning of a claim."""
    results = []
    for judged in verdict.judged:
        text, unit = judged.claim.display()
        for reading in judged.readings:
            if reading.maximum is None:
                continue
            measured, size = reading.measured, unit * reading.meaning.factor
            outcome, risk, at_most = decide(measured, reading.maximum.limit, rule)
            if judged.doubt is not None and judged.doubt.kind in ("not_adequate", "only_limits"):
                outcome, risk = "not decided", None  # no model fits, so that the uncertainty is unknown
            high = measured.high if measured.value is not None else measured.upper_limit
            numbers = (measured.value, measured.low, high)
            value, low, high = (None if number is None else number / size for number in numbers)
            words = f", {reading.meaning.words}" if reading.meaning.words else ""
            results.append(
                LimitDecision(
                    channel=judged.channel,
                    what=f"{judged.claim.label}{words}",
                    value=value,
                    low=low,
                    high=high,
                    maximum=reading.maximum.limit / size,
                    unit=text,
                    outcome=outcome,
                    consumer_risk=risk,
                    at_most=at_most,
                )
            )
    return results
