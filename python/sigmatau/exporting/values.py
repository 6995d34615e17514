"""The numbers that a target asks for: of which axis, in which place of a missing one, inflated by how much.

A filter has one number for three axes, and seldom a place for flicker noise. What is chosen is chosen by the user, stands
in the file that is written, and is never a coefficient under another's name.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from sigmatau.errors import DataError, OptionError
from sigmatau.exporting.choices import KINDS, RANGES, Choices, NotChosenError, given
from sigmatau.exporting.horizon import matching_walk, sampled
from sigmatau.exporting.source import Source, one_rate
from sigmatau.exporting.text import number
from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.exporting import ChoiceNotUsed
from sigmatau.model.channel import ChannelModel
from sigmatau.model.file import NOT_ADEQUATE
from sigmatau.model.noise_model import NoiseModel
from sigmatau.model.processes import LARGEST, SMALLEST
from sigmatau.noise.terms import TERMS, display_units
from sigmatau.record.record import stream_name
from sigmatau.results import seconds, two_digits

__all__ = ["Number", "Numbers"]

_SAME = 1e-3  # relative: below what is said of a time


@dataclass(frozen=True, slots=True, kw_only=True)
class Number:
    """One number, in SI, before a target's own conversion.

    Attributes
    ----------
    value : float
        With its factor.
    words : str
        Where it comes from, for a comment beside it; one line of plain ASCII but for units.
    """

    value: float
    words: str


class Numbers:
    """What a source holds for one target, with the user's choices.

    Attributes
    ----------
    source : Source
    choices : Choices
    whole : NoiseModel
        The model of all channels, of which `model` may be one.
    findings : list of Finding
        What should be known of what is written; targets add to it.
    """

    def __init__(self, source: Source | NoiseModel, choices: Choices) -> None:
        self.source = source if isinstance(source, Source) else Source.of_model(source)
        self.choices = choices
        self.whole = self.source.model
        self.findings: list[Finding] = []

    @property
    def model(self) -> NoiseModel:
        return self.source.model

    def of(self, channel: str) -> Numbers:
        """The same of one channel alone."""
        one = Numbers(self.source.of([channel]), self.choices)
        one.whole, one.findings = self.whole, self.findings
        return one

    def find(self, finding: Finding) -> None:
        """Note, once, what should be known of what is written."""
        if finding not in self.findings:
            self.findings.append(finding)

    def has(self, sensor: str) -> bool:
        """Whether the model has any channel of ``"gyro"`` or ``"accel"``."""
        return any(stream_name(name) == sensor for name in self.model.channels)

    def channels(self, sensor: str) -> dict[str, ChannelModel]:
        """The channels of a sensor; raises `DataError` if there is none."""
        found = {name: channel for name, channel in self.model.channels.items() if stream_name(name) == sensor}
        if not found:
            raise DataError(f"the model has no {KINDS[sensor]}, which this target needs")
        return found

    def rate(self) -> float:
        """Sampling rate, the user's or the record's; raises `OptionError` if it is not known, or there are several. [Hz]"""
        found = one_rate(self.source.rates) if self.choices.rate is None else self.choices.rate
        if found is None:
            raise OptionError(
                "the sampling rate of the sensor is needed, and a model file has none: give `rate` in Hz", option="rate"
            )
        return found

    def known_rate(self) -> float | None:
        """Sampling rate; None if it is not known, or there are several. [Hz]"""
        try:
            return self.rate()
        except OptionError:
            return None

    def name(self, key: str, default: str) -> str:
        """A name or constant that the user gave, or the source has, or the target's own."""
        return self.choices.names.get(key, self.source.names.get(key, default))

    def doubt(self, channel: str) -> str:
        """For the end of a comment: that the coefficients are of a fit that is not adequate; else nothing."""
        return "" if self.model.channels[channel].adequate else f"; {NOT_ADEQUATE}"

    def has_slow_noise(self, channel: str) -> bool:
        """Whether a walk can match anything of it at a horizon."""
        model = self.model.channels[channel]
        fast = ("quantization", "random_walk")
        return any(term not in fast for term in model) or bool(model.gauss_markov)  # a sinusoid is no walk

    def number(self, key: str, default: str) -> float:
        """A constant that the user gave as a name, such as gravity; raises `OptionError` if it is no positive number."""
        return number(self.name(key, default), key, least=1e-9)

    def noise(self, sensor: str) -> Number:
        """N, the random walk of a sensor, or what was chosen in its place: two-sided density. [rad/s/√Hz or m/s²/√Hz]"""
        return self._of_sensor(sensor, "random_walk")

    def noise_of(self, channel: str) -> Number:
        """N of one channel, or what was chosen in its place."""
        return self._of(channel, "random_walk")

    def walk(self, sensor: str) -> Number:
        """K, the rate random walk of a sensor, or what was chosen in its place. [rad/s²/√Hz or m/s³/√Hz]"""
        return self._of_sensor(sensor, "rate_random_walk")

    def walk_of(self, channel: str) -> Number:
        """K of one channel, or what was chosen in its place."""
        return self._of(channel, "rate_random_walk")

    def left_out(self) -> list[str]:
        """Sentences on what the model has beside the two walks, for a target that has places for these alone."""
        said = []
        for sensor in ("gyro", "accel"):
            found = [c for name, c in self.model.channels.items() if stream_name(name) == sensor]
            fast = ["quantization"] if any("quantization" in c for c in found) else []
            fast += ["bandwidth"] if any(c.bandwidth is not None for c in found) else []
            fast += ["sinusoids"] if any(c.sinusoid for c in found) else []
            slow = [t for t in ("bias_instability", "rate_ramp") if any(t in c for c in found)]
            slow = [TERMS[term].label(found[0].quantity) for term in slow]
            slow += ["Gauss-Markov processes"] if any(c.gauss_markov for c in found) else []
            covered = self.choices.walk.get(sensor) == "horizon"
            left = fast + ([] if covered else slow)
            if left:
                more = (
                    f"; --rate-random-walk {sensor}=horizon has a walk stand for slow noise"
                    if slow and not covered
                    else ""
                )
                said.append(f"Without place here, and left out of the {KINDS[sensor]}: {', '.join(left)}{more}.")
        return said

    def not_used(self) -> tuple[Finding, ...]:
        """What was chosen in the place of a coefficient that was observed of every axis, or of a sensor there is none of."""
        found = []
        for term, chosen in (("random_walk", self.choices.noise), ("rate_random_walk", self.choices.walk)):
            for sensor, wanted in chosen.items():
                models = [model for name, model in self.model.channels.items() if stream_name(name) == sensor]
                if wanted == "horizon" or any(term not in model for model in models):
                    continue
                details = ChoiceNotUsed(sensor=sensor, term=term, observed=bool(models))
                found.append(Finding(severity="warning", details=details))
        return tuple(found)

    def _chosen(self, sensor: str, term: str) -> str | float | None:
        return (self.choices.noise if term == "random_walk" else self.choices.walk).get(sensor)

    def _of_sensor(self, sensor: str, term: str) -> Number:
        """One number of a sensor. What was observed of some axes only is theirs, if nothing was chosen for the others."""
        names = list(self.channels(sensor))
        wanted = self._chosen(sensor, term)
        if wanted == "horizon":  # an axis without slow noise adds none to that of the others
            slow = [name for name in names if self.has_slow_noise(name)] or names
            number = self._one({name: self._of(name, term) for name in slow})
            quiet = [name for name in names if name not in slow]
            more = f"; no slow noise in the model of {', '.join(quiet)}" if quiet else ""
            return Number(value=number.value, words=number.words + more)
        if wanted is not None:
            return self._one({name: self._of(name, term) for name in names})
        observed = [name for name in names if term in self.model.channels[name]]
        number = self._one({name: self._of(name, term) for name in observed or names})
        missing = [name for name in names if name not in observed]
        more = f"; not observed of {', '.join(missing)}" if missing else ""
        return Number(value=number.value, words=number.words + more)

    def _of(self, channel: str, term: str) -> Number:
        """One number of a channel."""
        sensor, model = stream_name(channel), self.model.channels[channel]
        wanted = self._chosen(sensor, term)
        factor = self.choices.noise_factor if term == "random_walk" else self.choices.walk_factor
        if wanted == "horizon":
            asked, time = self._horizon(), sampled(self._horizon(), self.known_rate())
            at = f"{seconds(time)} s"
            if abs(time - asked) > _SAME * asked:
                at += f", whole samples in place of {seconds(asked)} s"
            words = f"{channel}: stands for all slow noise: with N it has the model's Allan variance at {at}"
            if model.sinusoid:
                words += ", its sinusoids left out"
            return _number(self._at_horizon(channel), words + self.doubt(channel), factor)
        if term in model:
            not_used = "" if wanted is None else f"; --{term.replace('_', '-')} {sensor} not used: it was observed"
            found = _number(model[term], self._words(channel, term), factor)
            return replace(found, words=found.words + not_used)
        if wanted == "upper-limit":
            if term not in model.limits:
                label = TERMS[term].label(model.quantity)
                raise OptionError(
                    f"{sensor}: no upper limit of the {label} is known of {channel}: choose"
                    f" {' or '.join(self._choices_of(sensor, term, limit=False))}",
                    option=term,
                )
            return _number(
                model.limits[term], f"{channel}: not observed; its upper limit ({100 * model.level:g} %)", factor
            )
        if wanted is not None:
            return _number(float(wanted), f"{channel}: not observed; a value that was given", factor)
        raise self._not_chosen(sensor, term)

    def _not_chosen(self, sensor: str, term: str) -> NotChosenError:
        """Of all axes at once that lack it: those that one number is of, or, where each has its own, all of the sensor."""
        every = {name: model for name, model in self.whole.channels.items() if stream_name(name) == sensor}
        lacking = {name: model for name, model in every.items() if term not in model}
        model = next(iter(lacking.values()))
        si = model.unit_of(term)
        limits = [m.limits[term] for m in lacking.values() if term in m.limits]
        known = f" (it is below {two_digits(max(limits))} {si})" if len(limits) == len(lacking) else ""
        some = len(lacking) < len(every)
        who = f"{', '.join(lacking)} show{'s' * (len(lacking) == 1)}" if some else f"the {KINDS[sensor]} show"
        more = self._choices_of(sensor, term, limit=bool(known))
        more += [f"{given('axes', 'worst')}, that of the others for all"] * some
        return NotChosenError(
            f"{who} no {TERMS[term].label(model.quantity)}{known}, and this target needs one: choose {' or '.join(more)}",
            sensor=sensor,
            choice="noise" if term == "random_walk" else "walk",
        )

    def _choices_of(self, sensor: str, term: str, *, limit: bool, horizon: bool = True) -> list[str]:
        """What will do in the place of a number that was not observed, and nothing else."""
        choice = "noise" if term == "random_walk" else "walk"
        channels = {name: model for name, model in self.whole.channels.items() if stream_name(name) == sensor}
        si = next(iter(channels.values())).unit_of(term)
        found = [given(choice, "upper-limit", sensor)] if limit else []
        found.append(f"{given(choice, f'1e-6 {si}', sensor)} (a value, with its unit)")
        whole = Numbers(self.whole, self.choices)
        if choice == "walk" and horizon and any(map(whole.has_slow_noise, channels)):
            found.append(
                f"{given('walk', 'horizon', sensor)} with {given('horizon', 10)}, which matches the model's Allan variance"
                " there"
            )
        return found

    def _horizon(self) -> float:
        assert self.choices.horizon is not None  # Choices has seen to it
        return self.choices.horizon

    def _at_horizon(self, channel: str) -> float:
        """K that stands for the slow noise of one channel."""
        walk = self._matching(channel)
        if not walk > 0:
            limit = all("rate_random_walk" in m.limits for m in self.channels(stream_name(channel)).values())
            more = self._choices_of(stream_name(channel), "rate_random_walk", limit=limit, horizon=False)
            if self.choices.axes == "each":
                more.append(f"{given('axes', 'worst')}, that of the other axes for all")
            line = " but a sinusoid, which is no walk" if self.model.channels[channel].sinusoid else ""
            raise OptionError(
                f"{channel}: the model has no slow noise{line}, so that no walk matches it at a horizon: choose"
                f" {' or '.join(more)}",
                option="rate_random_walk",
            )
        return walk

    def _matching(self, channel: str) -> float:
        return matching_walk(self.model.channels[channel], horizon=self._horizon(), rate=self.known_rate())

    def _one(self, by_axis: Mapping[str, Number]) -> Number:
        """One number for all axes of a sensor, by the user's choice."""
        if len(by_axis) == 1:
            return next(iter(by_axis.values()))
        if self.choices.axes == "mean":
            mean = math.sqrt(sum(number.value**2 for number in by_axis.values()) / len(by_axis))
            axes = "; ".join(number.words for number in by_axis.values())
            return Number(value=mean, words=f"root mean square of {len(by_axis)} axes ({axes})")
        worst = max(by_axis.values(), key=lambda number: number.value)
        return Number(value=worst.value, words=f"worst of {len(by_axis)} axes, {worst.words}")

    def _words(self, channel: str, term: str) -> str:
        model = self.model.channels[channel]
        text, size = display_units(term, model.quantity, model.unit)[0]
        words = f"{channel}: {TERMS[term].label(model.quantity)} {model[term] / size:.4g} {text}"
        if term in model.intervals:
            low, high = (value / size for value in model.intervals[term])
            words += f" [{low:.4g}, {high:.4g}]"
        return words + self.doubt(channel)


def _number(estimate: float, words: str, factor: float) -> Number:
    """With its factor, which the words keep apart from the estimate so that it can be undone."""
    low, high = RANGES["walk_factor"][:2]
    if not SMALLEST * low <= factor * estimate <= LARGEST * high:  # as a limit can be, whose square would be 0
        raise DataError(f"{words}: {factor * estimate:.3g} in SI is out of range, from {SMALLEST:g} to {LARGEST:g}")
    return Number(value=factor * estimate, words=words if factor == 1 else f"{words} = {estimate!r}, times {factor:g}")
