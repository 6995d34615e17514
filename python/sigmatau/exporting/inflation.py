"""How much larger the noise of a sensor is beside running motors than at rest: the inflation that a filter needs."""

from __future__ import annotations

import math
from collections.abc import Mapping

from sigmatau.digits import limit_text, round_to_error, significant, two_digits
from sigmatau.errors import DataError
from sigmatau.exporting.source import Source
from sigmatau.frozen import frozen
from sigmatau.model.channel import ChannelModel
from sigmatau.noise.terms import TERMS, display_units
from sigmatau.results import Printed

_SMALLER = 0.9  # factor of a random walk that chance and temperature do not explain
_TERMS = ("random_walk", "bias_instability", "rate_random_walk")


@frozen
class Factor:
    """A coefficient in the second record over that in the first."""

    channel: str
    term: str  # Key of `sigmatau.noise.terms.TERMS`, or ``"sample"``: standard deviation of a sample, with all lines
    value: float | None  # None if neither record shows the coefficient
    low: float | None = None  # Interval; one end alone if one record shows an upper limit only
    high: float | None = None

    @property
    def text(self) -> str:
        """``"x 3.1 [2.9, 3.3]"``, ``"x 4 or more"``, ``"not observed"``."""
        if self.value is None:
            return "not observed"
        if (self.low is None) != (self.high is None):
            return f"x {significant(self.value, 2, zeros=True)} or {'less' if self.low is None else 'more'}"
        if self.low is None:
            return f"x {significant(self.value, 2, zeros=True)}"
        return f"x {round_to_error(self.value, self.low, self.high).text}"


@frozen(eq=False)
class Inflation(Printed):
    """Factors by channel and term, see `inflation`."""

    factors: tuple[Factor, ...]
    rest: Mapping[str, ChannelModel]
    running: Mapping[str, ChannelModel]

    def head(self) -> tuple[str, ...]:
        """Lines for the head of a file with the numbers of the running sensor."""
        by_channel: dict[str, list[str]] = {}
        for one in self.factors:
            if one.value is not None and one.term != "bias_instability":
                label = "sample" if one.term == "sample" else TERMS[one.term].label("signal")
                by_channel.setdefault(one.channel, []).append(f"{label} {one.text}")
        return tuple(f"{channel} over the record at rest: {', '.join(found)}" for channel, found in by_channel.items())

    def doubt(self) -> str:
        """A warning if the noise at short times is clearly smaller in the second record; else empty."""
        smaller = [
            one
            for one in self.factors
            if one.term == "random_walk" and one.value is not None and (one.high or one.value) < _SMALLER
        ]
        if not smaller:
            return ""
        least = min(smaller, key=lambda one: one.value or 1.0)
        times = two_digits(1 / (least.value or 1.0))
        return f"{least.channel}: N is {times} times smaller with motors on: are the files swapped?"

    def __repr__(self) -> str:
        rows: list[tuple[str, ...]] = [("", "", "at rest", "running", "", "factor")]
        shown = ""
        for one in self.factors:
            at_rest, running = self.rest[one.channel], self.running[one.channel]
            name = one.channel if one.channel != shown else ""
            shown = one.channel
            if one.term == "sample":
                rows.append((name, "one sample", "", "", "", one.text))
                continue
            unit, factor = display_units(one.term, at_rest.quantity, at_rest.unit)[-1]
            texts = (_text(model, one.term, factor) for model in (at_rest, running))
            rows.append((name, TERMS[one.term].label(at_rest.quantity), *texts, unit, one.text))
        widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
        return "\n".join("  ".join(map(str.ljust, row, widths)).rstrip() for row in rows)


def inflation(rest: Source, running: Source) -> Inflation:
    """Factors of the coefficients of a running sensor over those at rest, for the channels of both.

    Parameters
    ----------
    rest, running : Source
        Of results of `sigmatau.analyze`: a log with motors off, and one with motors on.

    Returns
    -------
    Inflation

    Raises
    ------
    DataError
        If they have no channel in common.
    """
    names = [name for name in rest.model.channels if name in running.model.channels]
    if not names:
        raise DataError(
            f"no channel is in both: {', '.join(rest.model.channels)} at rest, {', '.join(running.model.channels)} running"
        )
    factors = []
    for name in names:
        factors += [_factor(name, term, rest.model.channels[name], running.model.channels[name]) for term in _TERMS]
        if name in rest.samples and name in running.samples:
            ratio = math.sqrt(running.samples[name].variance / rest.samples[name].variance)
            factors.append(Factor(channel=name, term="sample", value=ratio))
    return Inflation(factors=tuple(factors), rest=rest.model.channels, running=running.model.channels)


def _factor(name: str, term: str, rest: ChannelModel, running: ChannelModel) -> Factor:
    first, second = (model.limits.get(term, model.get(term)) for model in (rest, running))
    if not first or not second or (term in rest.limits and term in running.limits):
        return Factor(channel=name, term=term, value=None)
    value = second / first
    if term in rest.limits:
        return Factor(channel=name, term=term, value=value, low=value)
    if term in running.limits:
        return Factor(channel=name, term=term, value=value, high=value)
    if not all(term in model.intervals and model.intervals[term][0] > 0 for model in (rest, running)):
        return Factor(channel=name, term=term, value=value)
    (low_1, high_1), (low_2, high_2) = (model.intervals[term] for model in (rest, running))
    below = math.hypot(math.log(high_1 / first), math.log(second / low_2))
    above = math.hypot(math.log(first / low_1), math.log(high_2 / second))
    return Factor(channel=name, term=term, value=value, low=value * math.exp(-below), high=value * math.exp(above))


def _text(model: ChannelModel, term: str, factor: float) -> str:
    if term in model.limits:
        return limit_text(model.limits[term] / factor)
    if term not in model:
        return "unknown"
    return round_to_error(model[term] / factor, *(end / factor for end in model.intervals.get(term, ()))).value
