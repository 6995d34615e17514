"""Ratio of the noise of a sensor with running motors to that at rest: the inflation that a filter needs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Literal

from sigmatau.digits import limit_text, round_to_error, significant, two_digits
from sigmatau.errors import DataError
from sigmatau.exporting.source import Source
from sigmatau.frozen import frozen
from sigmatau.model.channel import ChannelModel
from sigmatau.noise.terms import TERMS, display_units
from sigmatau.record.record import stream_name
from sigmatau.results import Printed, plain, wrapped

Cause = Literal["white vibration", "lines", "slow noise", "smaller", "not shown"]

_SMALLER = 0.9  # factor below which chance and temperature do not explain a smaller random walk
_LARGER = 1.1  # largest factor that is too small to matter to a filter; as `AGREEMENT` of `exporting.tuning.filters`
_TERMS = ("random_walk", "bias_instability", "rate_random_walk")
_LINES = 1.5  # ratio of the factor of a sample to the factor of N above which lines dominate the noise of a sample


@frozen
class Factor:
    """Ratio of a coefficient in the second record to that in the first."""

    channel: str
    term: str  # Key of `sigmatau.noise.terms.TERMS`, or ``"sample"``: standard deviation of a sample, with all lines
    value: float | None  # None if neither record shows the coefficient
    low: float | None = None  # Interval; only one end if one record has only an upper limit
    high: float | None = None

    @property
    def is_larger(self) -> bool:
        """Whether the coefficient is significantly larger in the second record, and by enough to matter to a filter."""
        if self.value is None or (self.low is None and self.high is not None):
            return False
        return self.value > _LARGER and (self.low is None or self.low > 1)

    @property
    def is_smaller(self) -> bool:
        """Whether the coefficient is significantly smaller in the second record."""
        return self.value is not None and (self.high or self.value) < _SMALLER

    def to_dict(self) -> dict[str, Any]:
        """Plain values."""
        return plain(self, "channel term value low high")

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


@frozen
class ChannelCause:
    """Cause of the additional noise of a channel with running motors, with its factor.

    Attributes
    ----------
    channel : str
    cause : {"white vibration", "lines", "slow noise", "smaller", "not shown"}
        Kind of the cause: N is larger; the noise of a sample is larger than N explains; bias instability or K is larger;
        N is smaller; a record does not show N.
    factor : Factor
        Factor of that coefficient.
    frequency : float or None
        Frequency of the largest line that only the second record has, or that is larger there. [Hz]
    """

    channel: str
    cause: Cause
    factor: Factor
    frequency: float | None = None

    def to_dict(self) -> dict[str, Any]:
        """Plain values."""
        return plain(self, "channel cause factor frequency_hz=frequency")

    @property
    def text(self) -> str:
        """The cause and the action."""
        times = self.factor.text.removeprefix("x ")
        if self.cause == "white vibration":
            return f"{self.channel}: vibration is white noise for a filter; multiply N by {times}"
        if self.cause == "lines":
            place = "" if self.frequency is None else f", the largest at {self.frequency:.3g} Hz"
            return (
                f"{self.channel}: the noise of a sample is {times} times as large by vibration that is not white{place};"
                " use a notch filter or dampers, no factor on N"
            )
        if self.cause == "slow noise":
            term = TERMS[self.factor.term].label("signal")
            return f"{self.channel}: the {term} is larger, for example because of heat; multiply K by {times}"
        if self.cause == "smaller":
            return (
                f"{self.channel}: N is {two_digits(1 / (self.factor.value or 1.0))} times smaller with motors on:"
                " are the files swapped?"
            )
        return f"{self.channel}: a record does not show N; record for longer, or with a finer resolution"


@frozen(eq=False)
class Inflation(Printed):
    """Factors by channel and term, see `inflation`."""

    factors: tuple[Factor, ...]
    rest: Mapping[str, ChannelModel]
    running: Mapping[str, ChannelModel]

    @property
    def causes(self) -> tuple[ChannelCause, ...]:
        """Causes of larger coefficients with running motors, by channel. Channels with unchanged noise are omitted."""
        by_term = {(factor.channel, factor.term): factor for factor in self.factors}
        causes: list[ChannelCause] = []
        for channel in dict.fromkeys(factor.channel for factor in self.factors):
            noise, sample = by_term[channel, "random_walk"], by_term.get((channel, "sample"))
            if noise.value is None:
                causes.append(ChannelCause(channel=channel, cause="not shown", factor=noise))
            elif noise.is_larger or noise.is_smaller:
                cause: Cause = "white vibration" if noise.is_larger else "smaller"
                causes.append(ChannelCause(channel=channel, cause=cause, factor=noise))
            if sample is not None and sample.value is not None and sample.value > _LINES * max(noise.value or 1.0, 1.0):
                frequency = self._new_line(channel)
                causes.append(ChannelCause(channel=channel, cause="lines", factor=sample, frequency=frequency))
            slow = [by_term[channel, term] for term in ("rate_random_walk", "bias_instability")]
            larger = next((factor for factor in slow if factor.is_larger), None)
            if larger is not None:
                causes.append(ChannelCause(channel=channel, cause="slow noise", factor=larger))
        return tuple(causes)

    def _new_line(self, channel: str) -> float | None:
        """Frequency of the largest line that is not in the record at rest, or is larger than there."""
        at_rest = {line.frequency: line.amplitude for line in self.rest[channel].sinusoid}
        lines = [
            line
            for line in self.running[channel].sinusoid
            if all(abs(line.frequency - f) > 0.01 * f or line.amplitude > _LARGER * a for f, a in at_rest.items())
        ]
        return max(lines, key=lambda line: line.amplitude).frequency if lines else None

    def largest_by_sensor(self, cause: Cause) -> dict[str, float]:
        """The largest factor of a cause by sensor."""
        largest: dict[str, float] = {}
        for each in self.causes:
            if each.cause == cause and each.factor.value is not None:
                sensor = stream_name(each.channel)
                largest[sensor] = max(largest.get(sensor, 0.0), each.factor.value)
        return largest

    def statements(self) -> tuple[str, ...]:
        """Sentences on the causes of larger coefficients with actions, and one on the channels where none is larger."""
        causes = self.causes
        loud = {cause.channel for cause in causes}
        quiet = [name for name in dict.fromkeys(factor.channel for factor in self.factors) if name not in loud]
        texts = [cause.text for cause in causes]
        if quiet:
            texts.append(
                f"{', '.join(quiet)}: the noise is that at rest, so that vibration is not a reason to inflate."
                " If the filter is wrong, judge its innovations"
            )
        return tuple(texts)

    def to_dict(self) -> dict[str, Any]:
        """Plain values, for JSON."""
        return plain(self, "factors causes")

    def head(self) -> tuple[str, ...]:
        """Lines for the head of a file with the numbers for running motors."""
        by_channel: dict[str, list[str]] = {}
        for factor in self.factors:
            if factor.value is not None and factor.term != "bias_instability":
                label = "sample" if factor.term == "sample" else TERMS[factor.term].label("signal")
                by_channel.setdefault(factor.channel, []).append(f"{label} {factor.text}")
        return tuple(f"{channel} over the record at rest: {', '.join(texts)}" for channel, texts in by_channel.items())

    def doubt(self) -> str:
        """Warning if the noise at short times is significantly smaller in the second record; otherwise empty."""
        smaller = [cause for cause in self.causes if cause.cause == "smaller"]
        return min(smaller, key=lambda cause: cause.factor.value or 1.0).text if smaller else ""

    def __repr__(self) -> str:
        level = next(iter(self.rest.values())).level
        rows: list[tuple[str, ...]] = [("", "", "at rest", "running", "", f"factor, {100 * level:g} %")]
        shown = ""
        for factor in self.factors:
            at_rest, running = self.rest[factor.channel], self.running[factor.channel]
            name = factor.channel if factor.channel != shown else ""
            shown = factor.channel
            if factor.term == "sample":
                rows.append((name, "one sample", "", "", "", factor.text))
                continue
            unit, size = display_units(factor.term, at_rest.quantity, at_rest.unit)[-1]
            texts = (_text(model, factor.term, size) for model in (at_rest, running))
            rows.append((name, TERMS[factor.term].label(at_rest.quantity), *texts, unit, factor.text))
        widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
        table = ["  ".join(map(str.ljust, row, widths)).rstrip() for row in rows]
        return "\n".join(
            [*table, *wrapped(f"  {text}." if text[-1] != "?" else f"  {text}" for text in self.statements())]
        )


def inflation(rest: Source, running: Source) -> Inflation:
    """Compute the ratios of the coefficients with running motors to those at rest, for the channels of both records.

    Parameters
    ----------
    rest, running : Source
        Sources from results of `sigmatau.analyze`: a log with motors off, and a log with motors on.

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


def inflated(running: Source, rest: Source, *, name: str) -> tuple[Source, str]:
    """The source of a sensor with running motors, with the factors relative to rest in its head; and a doubt, or "".

    `name`: the name of the result at rest.
    """
    factors = inflation(rest, running)
    head = (*running.head, f"inflated: the sensor of {name} with running motors", *factors.head())
    return replace(running, head=head), factors.doubt()


def _factor(name: str, term: str, rest: ChannelModel, running: ChannelModel) -> Factor:
    first, second = (model.limits.get(term, model.get(term)) for model in (rest, running))
    if not first or not second or (term in rest.limits and term in running.limits):
        return Factor(channel=name, term=term, value=None)
    value = second / first
    if term in rest.limits:
        return Factor(channel=name, term=term, value=value, low=value)
    if term in running.limits:
        return Factor(channel=name, term=term, value=value, high=value)
    models = (rest, running)
    if not any(term in model.intervals for model in models) or not all(
        term in model.intervals or not model.duration for model in models
    ):
        return Factor(channel=name, term=term, value=value)
    (low_1, high_1), (low_2, high_2) = (
        model.intervals.get(term, (exact, exact)) for model, exact in ((rest, first), (running, second))
    )
    if min(low_1, low_2) <= 0:
        return Factor(channel=name, term=term, value=value)
    below = math.hypot(math.log(high_1 / first), math.log(second / low_2))
    above = math.hypot(math.log(first / low_1), math.log(high_2 / second))
    return Factor(channel=name, term=term, value=value, low=value * math.exp(-below), high=value * math.exp(above))


def _text(model: ChannelModel, term: str, factor: float) -> str:
    if term in model.limits:
        return limit_text(model.limits[term] / factor)
    if term not in model:
        return "unknown"
    return round_to_error(model[term] / factor, *(end / factor for end in model.intervals.get(term, ()))).value
