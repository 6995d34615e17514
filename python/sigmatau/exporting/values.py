"""`Numbers`: random walk and rate random walk of a sensor after the choices of the user, with their origin in words.

A filter has one number for three axes and often no field for flicker noise. The user chooses the replacement; the file
states it, and no coefficient is written under the name of another.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import cached_property

from sigmatau.digits import limit_text, round_to_error
from sigmatau.errors import DataError, OptionError
from sigmatau.exporting.choices import KINDS, RANGES, Choices
from sigmatau.exporting.consistent import HORIZON, AssumedNoise, assume_noise, consistent_walk
from sigmatau.exporting.matching import matching_walk, round_to_samples
from sigmatau.exporting.rates import filter_rate, known_filter_rate
from sigmatau.exporting.source import Source
from sigmatau.exporting.text import digits, measured, number
from sigmatau.findings.exporting import ChoiceNotUsed, LimitWritten
from sigmatau.findings.finding import Finding
from sigmatau.frozen import frozen
from sigmatau.hints import Hint
from sigmatau.model.channel import ChannelModel, alike_text
from sigmatau.model.file import doubt_text
from sigmatau.model.noise_model import NoiseModel
from sigmatau.model.processes import LARGEST, SMALLEST
from sigmatau.noise.terms import SLOW, TERMS, display_units
from sigmatau.record.record import stream_name
from sigmatau.results import duration_text, seconds

_CHOICES = {"random_walk": "noise", "rate_random_walk": "walk"}  # attribute of `Choices` by term
_SAME_TIME = 1e-3  # largest relative difference of two times that are printed alike


@frozen
class Number:
    """Number in SI, before the conversion of a target."""

    value: float  # Estimate times factor
    words: str  # Origin, as one line for a comment
    limits: tuple[str, ...] = ()  # Channels whose upper limit was used without a request


class Numbers:
    """Numbers from a source for one target, after the choices of the user."""

    def __init__(self, source: Source | NoiseModel, choices: Choices, *, pair: bool = False) -> None:
        self.pair = pair  # whether the numbers are N and K of a filter without other slow noise
        self.source: Source = source if isinstance(source, Source) else Source.of_model(source)
        self.choices = choices
        self.whole: NoiseModel = self.source.model  # model with all channels; `model` may have only one
        self.findings: list[Finding] = []  # findings about the written file; targets add theirs
        # channels whose upper limit is written without a request, by term
        self.limits: dict[str, dict[str, None]] = {}
        self.missing: dict[tuple[str, str], str] = {}  # reason why a coefficient must be chosen, by sensor and term
        self._truths: dict[str, AssumedNoise] = {}  # assumed noise by channel
        self._consistent: dict[str, Number] = {}  # K by channel
        self._sensor = {name: stream_name(name) for name in self.model.channels}
        self.sensors: dict[str, dict[str, ChannelModel]] = {  # channels of the model by sensor
            sensor: {name: channel for name, channel in self.model.channels.items() if self._sensor[name] == sensor}
            for sensor in dict.fromkeys(self._sensor.values())
        }

    @property
    def model(self) -> NoiseModel:
        return self.source.model

    def select(self, channel: str) -> Numbers:
        """Restrict the numbers to one channel."""
        numbers = Numbers(self.source.of([channel]), self.choices, pair=self.pair)
        numbers.whole, numbers.findings, numbers.limits, numbers.missing = (
            self.whole,
            self.findings,
            self.limits,
            self.missing,
        )
        numbers._truths, numbers._consistent = self._truths, self._consistent
        return numbers

    def add_finding(self, finding: Finding) -> None:
        """Add a finding about the written file, once."""
        if finding not in self.findings:
            self.findings.append(finding)

    def has(self, sensor: str) -> bool:
        """Whether the model has any channel of ``"gyro"`` or ``"accel"``."""
        return sensor in self.sensors

    def channels(self, sensor: str) -> dict[str, ChannelModel]:
        """Channels of a sensor. Raises `DataError` if there are none."""
        if sensor not in self.sensors:
            raise DataError(f"the model has no {KINDS[sensor]}, which this target requires")
        return dict(self.sensors[sensor])

    def rate(self) -> float:
        """Rate of the filter, given by the user or that of the record. Raises `OptionError` if it is unknown or ambiguous.
        [Hz]
        """
        rate = self._known_rate
        return filter_rate(self.source.rates, self.choices) if rate is None else rate

    def known_rate(self) -> float | None:
        """Sampling rate; None if unknown or ambiguous. [Hz]"""
        return self._known_rate

    @cached_property
    def _known_rate(self) -> float | None:
        return known_filter_rate(self.source.rates, self.choices)

    @cached_property
    def _doubts(self) -> dict[str, str]:
        return {name: doubt_text(model) for name, model in self.model.channels.items() if not model.adequate}

    def rate_text(self) -> str:
        """Sampling rate for a file: as given, or that of the record with four digits."""
        return digits(self.rate()) if self.choices.filter_rate is not None else measured(self.rate())

    def name(self, key: str, default: str) -> str:
        """Name or constant from the user, the source or the default, in this order."""
        return self.choices.names.get(key, self.source.names.get(key, default))

    def factor(self, term: str, sensor: str) -> float:
        """Factor on the random walk, or on all slow noise, of a sensor; 1 for a sensor that a mapping does not name."""
        chosen = self.choices.noise_factor if term == "random_walk" else self.choices.walk_factor
        return chosen if isinstance(chosen, int | float) else chosen.get(sensor, 1.0)

    def doubt(self, channel: str) -> str:
        """End of a comment for a channel whose fit is not adequate; otherwise empty."""
        doubt = self._doubts.get(channel)
        return f"; {doubt}" if doubt else ""

    def has_slow_noise(self, channel: str) -> bool:
        """Whether the model has noise that a random walk can match at a horizon."""
        model = self.model.channels[channel]
        return any(term in SLOW for term in model) or bool(
            model.gauss_markov or model.resonance
        )  # sinusoids do not count

    def number(self, key: str, default: str) -> float:
        """A constant that the user gave as a name, such as gravity; raises `OptionError` unless it is positive."""
        return number(self.name(key, default), key, low=1e-9)

    def noise(self, sensor: str) -> Number:
        """N, the random walk of a sensor, or its replacement: two-sided density. [rad/s/√Hz or m/s²/√Hz]"""
        return self._noted(self._sensor_number(sensor, "random_walk"), "random_walk")

    def channel_noise(self, channel: str) -> Number:
        """N of one channel, or its replacement."""
        return self._noted(self._channel_number(channel, "random_walk"), "random_walk")

    def walk(self, sensor: str) -> Number:
        """K, the rate random walk of a sensor, or its replacement. [rad/s²/√Hz or m/s³/√Hz]"""
        return self._noted(self._sensor_number(sensor, "rate_random_walk"), "rate_random_walk")

    def channel_walk(self, channel: str) -> Number:
        """K of one channel, or its replacement."""
        return self._noted(self._channel_number(channel, "rate_random_walk"), "rate_random_walk")

    def _noted(self, number: Number, term: str) -> Number:
        """Record the upper limits from which a number was computed."""
        if number.limits:
            self.limits.setdefault(term, {}).update(dict.fromkeys(number.limits))
        return number

    def limits_written(self) -> tuple[Finding, ...]:
        """Report each term whose upper limits are written without a request."""
        return tuple(
            Finding(severity="info", channels=self._in_order(channels), details=LimitWritten(term=term))
            for term, channels in self.limits.items()
        )

    def _in_order(self, channels: Iterable[str]) -> tuple[str, ...]:
        """Sort channels as in the model, so that findings do not depend on the order in a file."""
        return tuple(sorted(channels, key=list(self.whole.channels).index))

    def not_used(self) -> tuple[Finding, ...]:
        """Report choices for a coefficient that was observed on every axis, or for a sensor that the model does not have."""
        findings = []
        for term, chosen in (("random_walk", self.choices.noise), ("rate_random_walk", self.choices.walk)):
            for sensor, wanted in chosen.items():
                models = list(self.sensors.get(sensor, {}).values())
                if wanted in ("horizon", "consistent", "observed") or any(term not in model for model in models):
                    continue
                details = ChoiceNotUsed(sensor=sensor, term=term, observed=bool(models))
                findings.append(Finding(severity="warning", details=details))
        return tuple(findings)

    def _chosen(self, sensor: str, term: str) -> str | float | None:
        return (self.choices.noise if term == "random_walk" else self.choices.walk).get(sensor)

    def _sensor_number(self, sensor: str, term: str) -> Number:
        """One number for a sensor.

        Without a choice, it is computed from the axes with the coefficient or an upper limit. Axes with neither are
        ignored, unless `strict` raises an error.
        """
        names = list(self.channels(sensor))
        wanted = self._chosen(sensor, term)
        if term == "rate_random_walk" and self._is_consistent(sensor):
            wanted = "consistent"
        if wanted in ("horizon", "consistent"):  # axes without slow noise are ignored
            has_slow = self.has_slow_noise if wanted == "horizon" else self._may_have_slow_noise
            slow = [name for name in names if has_slow(name)] or names
            number = self._combine({name: self._channel_number(name, term) for name in slow})
            quiet = [name for name in names if name not in slow]
            remark = f"; no slow noise in the model of {', '.join(quiet)}" if quiet else ""
            return Number(value=number.value, words=number.words + remark)
        if wanted is not None:
            return self._combine({name: self._channel_number(name, term) for name in names})
        usable = [
            name for name in names if term in self.model.channels[name].terms or self._limit(name, term) is not None
        ]
        missing = [name for name in names if name not in usable]
        if missing and self.choices.strict:
            return self._missing(sensor, term)
        number = self._combine({name: self._channel_number(name, term) for name in usable or names})
        remark = f"; not observed for {', '.join(missing)}" if missing else ""
        return replace(number, words=number.words + remark)

    def _limit(self, channel: str, term: str) -> float | None:
        """Upper limit that is written without a request; None if there is none, or if this is not allowed."""
        return None if self.choices.strict else self.model.channels[channel].limits.get(term)

    def _channel_number(self, channel: str, term: str) -> Number:
        """Number of one channel and term."""
        sensor, model = self._sensor[channel], self.model.channels[channel]
        wanted = self._chosen(sensor, term)
        factor = self.factor("random_walk" if term == "random_walk" else "rate_random_walk", sensor)
        if term == "rate_random_walk" and self._is_consistent(sensor):
            return self._consistent_number(channel)
        if wanted == "horizon":
            asked, time = self._horizon(), round_to_samples(self._horizon(), self.known_rate())
            time_words = f"{seconds(time)} s"
            if abs(time - asked) > _SAME_TIME * asked:
                time_words += f", whole samples instead of {seconds(asked)} s"
            words = (
                f"{channel}: approximates all slow noise: with N it has the Allan variance of the model at {time_words}"
            )
            if model.sinusoid:
                words += ", without its sinusoids"
            return _number(self._walk_at_horizon(channel), words + self.doubt(channel), factor)
        unasked = wanted is None and self._limit(channel, term) is not None
        if term in model.terms and not unasked:
            not_used = (
                "" if wanted in (None, "observed") else f"; {Hint(_CHOICES[term])} {sensor} not used: it was observed"
            )
            number = _number(model.terms[term], self._words(channel, term), factor)
            return replace(number, words=number.words + not_used)
        if wanted == "observed":
            return self._missing(sensor, term)
        if wanted == "upper-limit" or unasked:
            if term not in model.limits:
                label = TERMS[term].label(model.quantity)
                raise OptionError(
                    f"{sensor}: no upper limit of the {label} is known for {channel}: choose"
                    f" {' or '.join(self._valid_choices(sensor, term, limit=False))}",
                    option=term,
                )
            when = f" in {duration_text(model.duration)}" if model.duration else ""
            words = f"{channel}: not observed{when}; its upper limit ({100 * model.level:g} %)"
            return replace(_number(model.limits[term], words, factor), limits=(channel,) * unasked)
        if wanted is not None:
            return _number(float(wanted), f"{channel}: not observed; chosen value", factor)
        return self._missing(sensor, term)

    def _is_consistent(self, sensor: str) -> bool:
        """Whether K is that of a consistent filter: chosen, or the default with known slow noise."""
        wanted = self.choices.walk.get(sensor)
        if wanted is None and self.pair and not self.choices.strict:
            return any(map(self._may_have_slow_noise, self.channels(sensor)))
        return wanted == "consistent"

    def _may_have_slow_noise(self, channel: str) -> bool:
        return self._truth(channel).slow

    def truths(self, channels: Iterable[str]) -> list[AssumedNoise]:
        """Noise of channels in use."""
        return [self._truth(name) for name in channels]

    def _truth(self, channel: str) -> AssumedNoise:
        """Noise of a channel, including terms that were not observed by the policy `Choices.unobserved`."""
        if channel not in self._truths:
            self._truths[channel] = assume_noise(self.model.channels[channel], self.choices.unobserved)
        return self._truths[channel]

    def _consistent_number(self, channel: str) -> Number:
        """K of one channel with which a filter is consistent."""
        if channel in self._consistent:
            return self._consistent[channel]
        sensor, model = self._sensor[channel], self.model.channels[channel]
        if not self._may_have_slow_noise(channel):
            return self._missing(sensor, "rate_random_walk")
        horizon = self.choices.horizon or HORIZON
        noise = model.terms.get("random_walk")
        if noise is None:
            noise = self._sensor_number(sensor, "random_walk").value / self.factor("random_walk", sensor)
        chosen = consistent_walk(
            self._truth(channel), sensor=sensor, noise=noise, horizon=horizon, criterion=self.choices.consistent
        )
        if chosen.walk == model.terms.get("rate_random_walk"):
            words = self._words(channel, "rate_random_walk")
        elif chosen.is_floor:
            words = f"{channel}: the smallest K used, 0.01*N/horizon: N alone states {self._correct_error}"
            words += self.doubt(channel)
        else:
            words = (
                f"{channel}: consistent: a filter with it states {self._correct_error} correctly{self.doubt(channel)}"
            )
        self._consistent[channel] = _number(chosen.walk, words, self.factor("rate_random_walk", sensor))
        return self._consistent[channel]

    @cached_property
    def _correct_error(self) -> str:
        """Words for the error that a filter with the consistent walk states correctly."""
        if self.choices.consistent == "bias":
            return "its bias"
        return f"its error after {duration_text(self.choices.horizon or HORIZON)}"

    def _missing(self, sensor: str, term: str) -> Number:
        """Record that a coefficient must be chosen for all axes of a sensor that lack it; return a placeholder."""
        every = {name: model for name, model in self.whole.channels.items() if stream_name(name) == sensor}
        lacking = {name: model for name, model in every.items() if term not in model}
        model = next(iter(lacking.values()))
        si = model.unit_of(term)
        limits = [m.limits[term] for m in lacking.values() if term in m.limits]
        limit_words = f" ({limit_text(max(limits))} {si})" if len(limits) == len(lacking) else ""
        some = len(lacking) < len(every)
        who = ", ".join(lacking) if some else KINDS[sensor]
        choices = self._valid_choices(sensor, term, limit=bool(limit_words))
        choices += [f"{Hint('axes', value='worst')} (the value of the others for all)"] * (
            some and not self.choices.strict
        )
        why = (
            f"{who}: no {TERMS[term].label(model.quantity)} observed{limit_words}, this target needs one: choose"
            f" {' or '.join(choices)}"
        )
        self.missing.setdefault((sensor, term), why)
        return Number(value=1.0, words="")

    def _valid_choices(self, sensor: str, term: str, *, limit: bool, horizon: bool = True) -> list[str]:
        """Valid choices for a coefficient that was not observed."""
        choice = _CHOICES[term]
        channels = {name: model for name, model in self.whole.channels.items() if stream_name(name) == sensor}
        si = next(iter(channels.values())).unit_of(term)
        hints = [str(Hint(choice, sensor, "upper-limit"))] if limit else []
        hints.append(f"{Hint(choice, sensor, f'1e-6 {si}')} (a value with unit)")
        whole = Numbers(self.whole, self.choices)
        if choice == "walk" and horizon and any(map(whole.has_slow_noise, channels)):
            hints.append(
                f"{Hint('walk', sensor, 'horizon')} with {Hint('horizon', value=10)} (matches the Allan variance of the"
                " model there)"
            )
        return hints

    def _horizon(self) -> float:
        assert self.choices.horizon is not None  # ensured by Choices
        return self.choices.horizon

    def _walk_at_horizon(self, channel: str) -> float:
        """K that approximates the slow noise of one channel."""
        walk = matching_walk(self.model.channels[channel], horizon=self._horizon(), rate=self.known_rate())
        if not walk > 0:
            limit = all("rate_random_walk" in m.limits for m in self.channels(stream_name(channel)).values())
            choices = self._valid_choices(stream_name(channel), "rate_random_walk", limit=limit, horizon=False)
            if self.choices.axes == "each":
                choices.append(f"{Hint('axes', value='worst')} (the value of the other axes for all)")
            line = (
                " except a sinusoid, which a random walk does not match"
                if self.model.channels[channel].sinusoid
                else ""
            )
            raise OptionError(
                f"{channel}: the model has no slow noise{line}: choose {' or '.join(choices)}",
                option="rate_random_walk",
            )
        return walk

    def _combine(self, by_axis: Mapping[str, Number]) -> Number:
        """One number for all axes of a sensor, by `Choices.axes`."""
        if len(by_axis) == 1:
            return next(iter(by_axis.values()))
        if self.choices.axes == "mean":
            mean = math.sqrt(sum(number.value**2 for number in by_axis.values()) / len(by_axis))
            axes = "; ".join(number.words for number in by_axis.values())
            limits = tuple(name for number in by_axis.values() for name in number.limits)
            return Number(value=mean, words=f"root mean square of {len(by_axis)} axes ({axes})", limits=limits)
        worst = max(by_axis.values(), key=lambda number: number.value)
        return replace(worst, words=f"worst of {len(by_axis)} axes, {worst.words}")

    def _words(self, channel: str, term: str) -> str:
        model = self.model.channels[channel]
        text, size = display_units(term, model.quantity, model.unit)[0]
        value = model.terms[term] / size
        ends = model.intervals.get(term)
        number_text = f"{value:.4g}" if ends is None else round_to_error(value, ends[0] / size, ends[1] / size).text
        words = f"{channel}: {TERMS[term].label(model.quantity)} {number_text} {text}"
        if term == "rate_random_walk" and model.alike_from is not None:
            words += f"; {alike_text(model.alike_from.time)}"
        return words + self.doubt(channel)


def _number(estimate: float, words: str, factor: float) -> Number:
    """Multiply an estimate by its factor; the words state both separately."""
    low, high = RANGES["walk_factor"][:2]
    if not SMALLEST * low <= factor * estimate <= LARGEST * high:  # an upper limit can be so small that its square is 0
        raise DataError(f"{words}: {factor * estimate:.3g} in SI is out of range, from {SMALLEST:g} to {LARGEST:g}")
    return Number(
        value=factor * estimate, words=words if factor == 1 else f"{words} = {measured(estimate)}, times {factor:g}"
    )
