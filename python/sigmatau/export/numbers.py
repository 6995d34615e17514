"""The numbers that a target asks for: of which axis, in which place of a missing one, inflated by how much.

A filter has one number for three axes, and seldom a place for flicker noise. What is chosen is chosen by the user, stands
in the file that is written, and is never a coefficient under another's name.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

from sigmatau.errors import DataError, OptionError
from sigmatau.export.horizon import matching_walk, sampled
from sigmatau.model import ChannelModel, NoiseModel
from sigmatau.model.processes import LARGEST, SMALLEST
from sigmatau.record import stream_name
from sigmatau.results import Finding, seconds, two_digits
from sigmatau.terms import TERMS, display_units

__all__ = ["Axes", "Choices", "Number", "Numbers"]

Axes = Literal["worst", "mean", "each"]

# Beyond these a number is a slip of the keyboard, and its squares and products leave the range of what is written.
_RANGES = {
    "horizon": (1e-9, 1e12, " s"),
    "noise_factor": (1e-6, 1e6, ""),
    "walk_factor": (1e-6, 1e6, ""),
    "rate": (1e-6, 1e9, " Hz"),
    "step": (1e-9, 1e6, " s"),
}
_SAME = 1e-3  # relative: below what is said of a time
_OPTIONS = {"random_walk": "random-walk", "rate_random_walk": "rate-random-walk"}
_KINDS = {"gyro": "gyros", "accel": "accelerometers"}


@dataclass(frozen=True, slots=True, kw_only=True)
class Choices:
    """What the user decides, because no record does.

    Attributes
    ----------
    axes : {"worst", "mean", "each"}
        Of three axes the largest number, the root of the mean of the squares, or each where a target has a place for it.
    walk : mapping of str to (str or float)
        By sensor, ``"gyro"`` and ``"accel"``, what to write where no rate random walk was observed: ``"upper-limit"``, or
        a value. [SI] ``"horizon"`` matches the model's Allan variance at `horizon`, observed or not. Default: what was
        observed, or an error that says what there is to choose from.
    noise : mapping of str to (str or float)
        By sensor, what to write where no random walk was observed, as where quantization covers it: ``"upper-limit"``, or a
        value. [SI]
    horizon : float or None
        Averaging time at which ``"horizon"`` matches. [s]
    noise_factor, walk_factor : float
        By which what is written is larger than what was found.
    rate : float or None
        Sampling rate of the sensor. [Hz]
    step : float or None
        Step of the filter, where it has one of its own. [s]
    names : mapping of str to str
        Names and constants that a target has beside the numbers, such as a topic.
    """

    axes: Axes = "worst"
    walk: Mapping[str, str | float] = field(default_factory=dict)
    noise: Mapping[str, str | float] = field(default_factory=dict)
    horizon: float | None = None
    noise_factor: float = 1.0
    walk_factor: float = 1.0
    rate: float | None = None
    step: float | None = None
    names: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.axes not in ("worst", "mean", "each"):
            raise OptionError(f"`axes` must be 'worst', 'mean' or 'each', not {self.axes!r}", option="axes")
        for name in ("horizon", "noise_factor", "walk_factor", "rate", "step"):
            value = getattr(self, name)
            low, high, unit = _RANGES[name]
            if value is not None and not low <= value <= high:
                raise OptionError(
                    f"`{name}` must be a positive number, from {low:g} to {high:g}{unit}, not {value!r}", option=name
                )
        _check("walk", self.walk, ("upper-limit", "horizon"))
        _check("noise", self.noise, ("upper-limit",))
        if "horizon" in self.walk.values() and self.horizon is None:
            raise OptionError("a walk that matches the Allan variance at a horizon needs `horizon`", option="horizon")


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
    """What a model holds for one target, with the user's choices."""

    def __init__(self, model: NoiseModel, choices: Choices) -> None:
        self.model = model
        self.choices = choices

    def has(self, sensor: str) -> bool:
        """Whether the model has any channel of ``"gyro"`` or ``"accel"``."""
        return any(stream_name(name) == sensor for name in self.model.channels)

    def channels(self, sensor: str) -> dict[str, ChannelModel]:
        """The channels of a sensor; raises `DataError` if there is none."""
        found = {name: channel for name, channel in self.model.channels.items() if stream_name(name) == sensor}
        if not found:
            raise DataError(f"the model has no {_KINDS[sensor]}, which this target needs")
        return found

    def rate(self) -> float:
        """Sampling rate; raises `OptionError` if it is not known. [Hz]"""
        if self.choices.rate is None:
            raise OptionError("the sampling rate of the sensor is needed: give `rate` in Hz", option="rate")
        return self.choices.rate

    def name(self, key: str, default: str) -> str:
        """A name or constant that the user gave, or the target's own."""
        return self.choices.names.get(key, default)

    def number(self, key: str, default: str) -> float:
        """A constant that the user gave as a name, such as gravity; raises `OptionError` if it is no positive number."""
        text = self.name(key, default)
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not (math.isfinite(value) and value > 0):
            raise OptionError(f"`name` {key}={text!r}: want a positive number, e.g. {key}={default}", option="name")
        return value

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
                said.append(f"Without place here, and left out of the {_KINDS[sensor]}: {', '.join(left)}{more}.")
        return said

    def not_used(self) -> tuple[Finding, ...]:
        """What was chosen in the place of a coefficient that was observed of every axis, or of a sensor there is none of."""
        found = []
        for term, chosen in (("random_walk", self.choices.noise), ("rate_random_walk", self.choices.walk)):
            for sensor, wanted in chosen.items():
                models = [model for name, model in self.model.channels.items() if stream_name(name) == sensor]
                if wanted == "horizon" or any(term not in model for model in models):
                    continue
                label = TERMS[term].label(models[0].quantity) if models else ""
                found.append(
                    Finding(
                        code="choice_not_used",
                        severity="warning",
                        message=f"--{_OPTIONS[term]} {sensor} was not used: "
                        + (f"the {label} of the {_KINDS[sensor]} was observed" if models else f"no {_KINDS[sensor]}"),
                        effect="what was observed is written" if models else "nothing is written in its place",
                        remedy="put another value into a model file, or inflate what was observed with a factor",
                    )
                )
        return tuple(found)

    def _chosen(self, sensor: str, term: str) -> str | float | None:
        return (self.choices.noise if term == "random_walk" else self.choices.walk).get(sensor)

    def _of_sensor(self, sensor: str, term: str) -> Number:
        """One number of a sensor. What was observed of some axes only is theirs, if nothing was chosen for the others."""
        names = list(self.channels(sensor))
        wanted = self._chosen(sensor, term)
        if wanted == "horizon":  # an axis without slow noise adds none to that of the others
            names = [name for name in names if self._matching(name) > 0] or names
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
            asked, time = self._horizon(), sampled(self._horizon(), self.choices.rate)
            at = f"{seconds(time)} s"
            if abs(time - asked) > _SAME * asked:
                at += f", whole samples in place of {seconds(asked)} s"
            words = f"{channel}: stands for all slow noise: with N it has the model's Allan variance at {at}"
            if model.sinusoid:
                words += ", its sinusoids left out"
            return _number(self._at_horizon(channel), words, factor)
        if term in model:
            not_used = "" if wanted is None else f"; --{_OPTIONS[term]} {sensor} not used: it was observed"
            found = _number(model[term], self._words(channel, term), factor)
            return replace(found, words=found.words + not_used)
        if wanted == "upper-limit":
            if term not in model.limits:
                label = TERMS[term].label(model.quantity)
                raise OptionError(
                    f"{sensor}: no upper limit of the {label} is known of {channel}; give a value", option=term
                )
            return _number(
                model.limits[term], f"{channel}: not observed; its upper limit ({100 * model.level:g} %)", factor
            )
        if wanted is not None:
            return _number(float(wanted), f"{channel}: not observed; a value that was given", factor)
        raise OptionError(self._what_to_choose(sensor, term), option=term)

    def _what_to_choose(self, sensor: str, term: str) -> str:
        channels = self.channels(sensor)
        model = next(iter(channels.values()))
        si = model.unit_of(term)
        limits = [m.limits[term] for m in channels.values() if term in m.limits]
        known = f" (it is below {two_digits(max(limits))} {si})" if len(limits) == len(channels) else ""
        limit = f"{sensor}=upper-limit, " if known else ""
        text = (
            f"the {_KINDS[sensor]} show no {TERMS[term].label(model.quantity)}{known}, and this target needs one: choose"
            f' --{term.replace("_", "-")} {limit}"{sensor}=VALUE" (with its unit, e.g. 1e-6 {si})'
        )
        if term == "random_walk":
            return text
        return f"{text}, or {sensor}=horizon with --horizon 10s, which matches the model's Allan variance there"

    def _horizon(self) -> float:
        assert self.choices.horizon is not None  # Choices has seen to it
        return self.choices.horizon

    def _at_horizon(self, channel: str) -> float:
        """K that stands for the slow noise of one channel."""
        walk = self._matching(channel)
        if not walk > 0:
            line = " but a sinusoid, which is no walk" if self.model.channels[channel].sinusoid else ""
            raise OptionError(
                f"{channel}: the model has no slow noise{line}, so that no walk matches it at a horizon; choose upper-limit"
                " or a value",
                option="rate_random_walk",
            )
        return walk

    def _matching(self, channel: str) -> float:
        return matching_walk(self.model.channels[channel], horizon=self._horizon(), rate=self.choices.rate)

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
        return words


def _check(name: str, chosen: Mapping[str, str | float], words: tuple[str, ...]) -> None:
    option = "random_walk" if name == "noise" else "rate_random_walk"
    for sensor, wanted in chosen.items():
        if sensor not in _KINDS:
            raise OptionError(f"`{name}`: {sensor!r} is no sensor; there are gyro and accel", option=option)
        if isinstance(wanted, str) and wanted not in words:
            raise OptionError(
                f"`{name}` of {sensor}: {wanted!r} is neither {' nor '.join(words)} nor a value", option=option
            )
        if not isinstance(wanted, str) and not SMALLEST <= wanted <= LARGEST:
            raise OptionError(
                f"`{name}` of {sensor} must be positive, from {SMALLEST:g} to {LARGEST:g} in SI, not {wanted!r}",
                option=option,
            )


def _number(estimate: float, words: str, factor: float) -> Number:
    """With its factor, which the words keep apart from the estimate so that it can be undone."""
    low, high = _RANGES["walk_factor"][:2]
    if not SMALLEST * low <= factor * estimate <= LARGEST * high:  # as a limit can be, whose square would be 0
        raise DataError(f"{words}: {factor * estimate:.3g} in SI is out of range, from {SMALLEST:g} to {LARGEST:g}")
    return Number(value=factor * estimate, words=words if factor == 1 else f"{words} = {estimate!r}, times {factor:g}")
