"""Bias as one first-order Gauss-Markov process, for targets without other slow noise.

The process is that of the model, or it approximates flicker noise near one averaging time, or a rate random walk up to
one averaging time. The comment on the number states which, and the error at other times.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from sigmatau._native import kernels
from sigmatau.digits import limit_text, round_to_error, two_digits
from sigmatau.errors import OptionError
from sigmatau.exporting.axes import by_axis, noises
from sigmatau.exporting.choices import KINDS
from sigmatau.exporting.matching import slow_avar
from sigmatau.exporting.statements import omitted_noise
from sigmatau.exporting.target import Unused
from sigmatau.exporting.values import Number, Numbers
from sigmatau.findings.exporting import OmittedTerm, SlowNoiseLeftOut
from sigmatau.findings.finding import Finding
from sigmatau.frozen import frozen
from sigmatau.hints import Hint
from sigmatau.model.channel import ChannelModel
from sigmatau.model.processes import GaussMarkov
from sigmatau.noise.terms import SLOW, TERMS, display_units
from sigmatau.record.record import stream_name
from sigmatau.results import seconds

# Averaging time of the largest Allan variance of a Gauss-Markov process, in correlation times (IEEE Std 952)
PEAK_TIME = 1.8926178329250187668

# Standard deviation of the process whose maximum Allan deviation is the plateau of flicker noise with B = 1
SIGMA_OF_FLICKER = 1.0759975729152142369
WALK_TIME = 10.0
"""Correlation time of a process that approximates a walk, in horizons: its Allan deviation at the horizon is 3.6 % too
low.
"""


_HALF_DECADE = math.sqrt(10)  # ratio of averaging times at which comments state the error of a process
_MAX_SLOW_NOISE = 1.1  # largest ratio of the Allan deviation of all slow noise to that of the process; more is reported


@frozen
class Process:
    """First-order Gauss-Markov process in SI, before the conversion of a target."""

    sigma: float  # Standard deviation, including the factor. [rad/s or m/s²]
    time: float  # Correlation time. [s]
    origin: str  # Approximated noise, for a comment
    fit: str  # Averaging time at which the process is exact, and errors at other times, for a comment
    place: str  # Name of this averaging time
    omitted: str = ""  # Omitted noise, for a comment
    walk: bool = False  # Whether it approximates a random walk, up to a tenth of its correlation time
    is_modelled: bool = False  # Whether it is a process of the model, which does not depend on a horizon

    @property
    def words(self) -> str:
        """Text of the comment."""
        return self.origin + self.fit + self.omitted

    @property
    def density(self) -> float:
        """Root of the density of the driving white noise, σ·√(2/time). [rad/s²/√Hz or m/s³/√Hz]"""
        return self.sigma * math.sqrt(2 / self.time)

    @property
    def match(self) -> float:
        """Averaging time at which the Allan deviation must be exact. [s]"""
        return self.time / WALK_TIME if self.walk else PEAK_TIME * self.time

    def approximated(self, tau: float) -> float:
        """Allan deviation at `tau` of the approximated noise: a random walk, a process of the model, or a flicker
        plateau.
        """
        if self.walk:
            return self.density * math.sqrt(tau / 3)
        return self.sigma * math.sqrt(relative_avar((tau if self.is_modelled else self.match) / self.time))

    def with_time(self, time: float) -> Process:
        """Change the correlation time, and σ so that the Allan deviation at `match` remains."""
        if math.isclose(time, self.time, rel_tol=1e-9):
            return replace(self, time=time)
        sigma = self.approximated(self.match) / math.sqrt(relative_avar(self.match / time))

        def error(tau: float) -> str:
            ratio = sigma * math.sqrt(relative_avar(tau / time)) / self.approximated(tau)
            return f"{two_digits(100 * abs(ratio - 1))} % {'low' if ratio < 1 else 'high'} at {seconds(tau)} s"

        fit = (
            f", with {seconds(time)} s instead of its own correlation time {seconds(self.time)} s: exact at {self.place},"
            f" {seconds(self.match)} s, {error(self.match / _HALF_DECADE)}, {error(self.match * _HALF_DECADE)}"
        )
        return replace(self, sigma=sigma, time=time, fit=fit)


def relative_avar(x: float) -> float:
    """Allan variance of a Gauss-Markov process of σ = 1 at x correlation times, (2x − 3 + 4e⁻ˣ − e⁻²ˣ)/x² (IEEE Std 952)."""
    return float(kernels.gauss_markov_avar(1.0, 1.0, 1, x, averaged=True)[0])


def process(numbers: Numbers, sensor: str) -> Process:
    """One process for all axes of a sensor: that with the largest σ, or the root mean square of the axes with the
    geometric mean of the times.
    """
    channels = numbers.channels(sensor)
    if sensor in numbers.choices.walk:
        return _walk_process(numbers, sensor)
    processes = {name: _channel_process(numbers.select(name), sensor, name) for name in channels}
    if len(processes) == 1:
        return _with_excess(numbers, sensor, next(iter(processes.values())))
    if numbers.choices.axes == "mean":
        return _with_excess(numbers, sensor, _mean(processes))
    worst = max(processes.values(), key=lambda p: p.sigma)
    return _with_excess(numbers, sensor, replace(worst, origin=f"worst of {len(processes)} axes, {worst.origin}"))


def _with_excess(numbers: Numbers, sensor: str, written: Process) -> Process:
    """Add a remark and a finding if the slow noise of the model exceeds that of the process at `match`."""
    tau, rate = written.match, numbers.known_rate()
    slow = {name: slow_avar(model, tau=tau, rate=rate) for name, model in numbers.channels(sensor).items()}
    strongest = max(slow, key=lambda name: slow[name])
    slow_variance = sum(slow.values()) / len(slow) if numbers.choices.axes == "mean" else slow[strongest]
    ratio = numbers.factor("rate_random_walk", sensor) * math.sqrt(slow_variance) / written.approximated(tau)
    if ratio <= _MAX_SLOW_NOISE:
        return written
    channels = tuple(slow) if numbers.choices.axes == "mean" else (strongest,)
    details = SlowNoiseLeftOut(sensor=sensor, ratio=ratio, tau=tau)
    numbers.add_finding(Finding(severity="warning", channels=channels, details=details))
    mean = " in the mean" if len(channels) > 1 else ""
    words = (
        f"all slow noise of {', '.join(channels)}{mean} has {ratio:.3g} times its Allan deviation at {seconds(tau)} s"
    )
    return replace(written, omitted=f"{written.omitted}; {words}")


def _mean(processes: Mapping[str, Process]) -> Process:
    """Root mean square of processes, with the geometric mean of their times."""
    every = list(processes.values())
    first, same = every[0], len({(p.walk, p.is_modelled) for p in every}) == 1
    time = math.exp(sum(math.log(p.time) for p in every) / len(every))
    if not same:  # give all the same time, without changing their Allan deviations at `match`
        every = [p.with_time(time) for p in every]
    sigma = math.sqrt(sum(p.sigma**2 for p in every) / len(every))
    origin = (
        f"root mean square of {', '.join(processes)} ({' | '.join(p.origin + p.omitted for p in processes.values())})"
    )
    first = replace(first, omitted="")
    if same and all(math.isclose(p.time, time, rel_tol=1e-9) for p in every):
        return replace(first, sigma=sigma, time=time, origin=origin)
    shortest, longest = (seconds(end(p.time for p in processes.values())) for end in (min, max))
    fit = f", with {seconds(time)} s, the geometric mean of correlation times from {shortest} to {longest} s"
    place = "a time between those of the axes"
    is_modelled = all(p.is_modelled for p in every)
    return replace(
        first,
        sigma=sigma,
        time=time,
        origin=origin,
        fit=fit,
        place=place,
        is_modelled=is_modelled,
        walk=first.walk and same,
    )


def noises_and_processes(
    numbers: Numbers,
) -> dict[str, tuple[tuple[Number, Number, Number], tuple[Process, Process, Process]]]:
    """N and process of x, y and z, by sensor."""
    return {s: (noises(numbers, s), by_axis(numbers, s, partial(process, sensor=s))) for s in ("gyro", "accel")}


def _are_own_processes(numbers: Numbers) -> bool:
    """Whether all processes are those of the model, so that a horizon affects no number."""
    if "horizon" in numbers.choices.walk.values():
        return False
    axes = (by_axis(numbers, s, partial(process, sensor=s)) for s in ("gyro", "accel"))
    return all(axis.is_modelled for three in axes for axis in three)


OWN_PROCESSES = Unused(
    choices=("horizon",), why="it writes the Gauss-Markov processes of the model itself", when=_are_own_processes
)


def minimum_time(model: Mapping[str, float]) -> float | None:
    """Averaging time of the minimum Allan deviation of all terms except flicker noise; None without a minimum. [s] 3Q²/τ²
    + N²/τ falls and K²τ/3 + R²τ²/2 rises with τ, so the derivative has one positive root.
    """
    powers = np.zeros(1 + max(term.interval_power for term in TERMS.values()))  # derivative times τ³, by power of τ
    for name, term in TERMS.items():
        powers[term.interval_power] += 2 * term.slope * float(term.deviation(1.0)) ** 2 * model.get(name, 0.0) ** 2
    if not (powers < 0).any() or not (powers > 0).any():
        return None
    roots = np.roots(powers[::-1])
    positive = [root.real for root in roots if root.real > 0 and abs(root.imag) <= 1e-9 * abs(root)]
    return float(max(positive))


def _channel_process(numbers: Numbers, sensor: str, name: str) -> Process:
    model = numbers.model.channels[name]
    factor = numbers.factor("rate_random_walk", sensor)
    text, size = display_units("bias_instability", model.quantity, model.unit)[-1]
    times = "" if factor == 1 else f", times {factor:g}"
    if model.gauss_markov:
        strongest = max(model.gauss_markov, key=lambda g: g.sigma)
        origin = f"{name}: {_gauss_markov_text(model, strongest)}"
        if len(model.gauss_markov) > 1:
            origin += f", the largest of {len(model.gauss_markov)}"
        omitted = _omitted_text(model, *SLOW)
        return Process(
            sigma=factor * strongest.sigma,
            time=strongest.time,
            origin=origin + times,
            fit="",
            omitted=omitted + numbers.doubt(name),
            place="the peak of its Allan deviation",
            is_modelled=True,
        )
    if "bias_instability" in model:
        time, where = find_exact_time(numbers, name)
        b = model["bias_instability"]
        if time is None:
            raise OptionError(
                f"{name}: one Gauss-Markov process can match the flicker noise (bias instability {b / size:.3g} {text}) at"
                " one averaging time only, and the Allan deviation of the model has no lowest point: give"
                f" {Hint('horizon', value=10)} or the time over which the filter relies on the bias",
                option="horizon",
            )
        omitted = _omitted_text(model, *(term for term in SLOW if term != "bias_instability"))
        return Process(
            sigma=factor * SIGMA_OF_FLICKER * b,
            time=time / PEAK_TIME,
            origin=f"{name}: bias instability {_value_text(model, b / size, size)} {text} as one process{times}",
            fit=f", exact at {where}, {seconds(time)} s, about 18 % low half a decade away",
            place=where,
            omitted=omitted + numbers.doubt(name),
        )
    has_walk = "rate_random_walk" in model or (not numbers.choices.strict and "rate_random_walk" in model.limits)
    if has_walk and _walk_horizon(numbers, sensor) is not None:
        return _walk_process(numbers, sensor)
    raise OptionError(_what_to_choose(numbers, name, model, sensor), option="horizon")


def _walk_process(numbers: Numbers, sensor: str) -> Process:
    k, horizon = numbers.walk(sensor), _walk_horizon(numbers, sensor)
    if horizon is None:
        raise OptionError(
            f"{sensor}: a rate random walk as a Gauss-Markov process needs {{option}}, e.g."
            f" {Hint('horizon', value=10)}, in s;"
            f" the correlation time is {WALK_TIME:g} times the horizon",
            option="horizon",
        )
    time = WALK_TIME * horizon
    return Process(
        sigma=k.value * math.sqrt(time / 2),
        time=time,
        origin=f"a rate random walk as a process, {k.words}",
        fit=f"; correlation time 10 times the {'horizon' if numbers.choices.horizon else 'length of the record'}: 3.6 % low"
        f" at {seconds(horizon)} s",
        place="the horizon",
        walk=True,
    )


def _walk_horizon(numbers: Numbers, sensor: str) -> float | None:
    """Averaging time up to which a process approximates a walk: the horizon, or by default the length of the record. [s]"""
    length = 0.0 if numbers.choices.strict else max(m.duration for m in numbers.channels(sensor).values())
    return numbers.choices.horizon or length or None


def find_exact_time(numbers: Numbers, name: str) -> tuple[float | None, str]:
    """Averaging time at which a process is exact for flicker noise [s], and its name."""
    model = numbers.model.channels[name]
    if numbers.choices.horizon:
        return numbers.choices.horizon, "the horizon"
    if (time := minimum_time(model)) is not None:
        return time, "the minimum of the curve"
    if numbers.choices.strict:
        return None, ""
    limits = {term: limit for term, limit in model.limits.items() if term == "rate_random_walk"}
    time = minimum_time({**model.terms, **limits})
    return time, "the minimum of the curve with its largest rate random walk"


def replaced_noise(numbers: Numbers) -> list[str]:
    """Build one remark per sensor on observed slow noise that a chosen random walk replaces, and add a finding for each.
    A walk that matches the Allan variance at a horizon approximates all slow noise and replaces none.
    """
    sentences = []
    for sensor, wanted in numbers.choices.walk.items():
        if wanted == "horizon" or not numbers.has(sensor):
            continue
        parts, omitted = [], []
        for name, model in numbers.channels(sensor).items():
            terms = [term for term in SLOW if term in model and term != "rate_random_walk"]
            slow = _values(model, *terms) + [_gauss_markov_text(model, g) for g in model.gauss_markov]
            slow += _resonances(model)
            if slow:
                parts.append(f"{name} {', '.join(slow)}")
            omitted += [OmittedTerm(channel=name, term=term, value=model[term]) for term in terms]
            omitted += [OmittedTerm(channel=name, term="gauss_markov", value=g.sigma) for g in model.gauss_markov]
            omitted += [OmittedTerm(channel=name, term="resonance", value=r.sigma) for r in model.resonance]
        if parts:
            sentences.append(
                f"Observed, and omitted for the chosen random walk: {'; '.join(parts)}."
                f" {Hint('walk', sensor, 'horizon')} approximates all slow noise."
            )
            channels = tuple(dict.fromkeys(noise.channel for noise in omitted))
            details = SlowNoiseLeftOut(sensor=sensor, omitted=tuple(omitted))
            numbers.add_finding(Finding(severity="warning", channels=channels, details=details))
    return sentences


def omitted_by_process(numbers: Numbers, *, has_turn_on: bool = False) -> list[str]:
    """Build remarks on noise, except slow noise, that a format with N and a Gauss-Markov bias has no field for."""
    return [
        sentence
        for sensor in KINDS
        for sentence in omitted_noise(numbers, sensor, written=("random_walk", *SLOW), has_turn_on=has_turn_on)
    ]


def _gauss_markov_text(model: ChannelModel, process: GaussMarkov) -> str:
    """Standard deviation and correlation time of a process of the model."""
    text, size = display_units("bias_instability", model.quantity, model.unit)[-1]
    return f"Gauss-Markov {process.sigma / size:.4g} {text} over {seconds(process.time)} s"


def _resonances(model: ChannelModel) -> list[str]:
    """Standard deviation and centre of each resonance of the model."""
    text, size = display_units("bias_instability", model.quantity, model.unit)[-1]
    return [
        f"resonance {resonance.sigma / size:.4g} {text} at {resonance.frequency:.3g} Hz"
        for resonance in model.resonance
    ]


def _values(model: ChannelModel, *terms: str) -> list[str]:
    """Names and coefficients of the terms of a channel."""
    texts = []
    for term in terms:
        if term in model:
            text, size = display_units(term, model.quantity, model.unit)[0]
            texts.append(f"{TERMS[term].label(model.quantity)} {model[term] / size:.4g} {text}")
    return texts


def _value_text(model: ChannelModel, value: float, size: float) -> str:
    """Bias instability in a unit, with its interval if the model has one."""
    if "bias_instability" not in model.intervals:
        return f"{value:.4g}"
    return round_to_error(value, *(end / size for end in model.intervals["bias_instability"])).text


def _omitted_text(model: ChannelModel, *terms: str) -> str:
    omitted = _values(model, *terms) + _resonances(model)
    return f"; no field here for its {' and '.join(omitted)}" if omitted else ""


def _what_to_choose(numbers: Numbers, name: str, model: ChannelModel, sensor: str) -> str:
    si = model.unit_of("rate_random_walk")
    if "rate_random_walk" in model:
        return (
            f"{name}: the model has a rate random walk and no bias instability; this target has a Gauss-Markov bias: give"
            f" {Hint('horizon', value=10)}, the time in s up to which the process follows the walk, or add"
            " gauss_markov to the channel in the model file"
        )
    limit_words = ""
    if "bias_instability" in model.limits:
        text, size = display_units("bias_instability", model.quantity, model.unit)[-1]
        limit_words = f" (its bias instability is {limit_text(model.limits['bias_instability'] / size)} {text})"
    # One number applies to all axes of a sensor, so all axes need a limit.
    models = [m for n, m in numbers.whole.channels.items() if stream_name(n) == sensor]
    known_limits = all("rate_random_walk" in m.limits or "rate_random_walk" in m for m in models)
    limit = f"{Hint('walk', sensor, 'upper-limit')} or " if known_limits else ""
    return (
        f"{name}: the model has no slow noise{limit_words}; this target needs a Gauss-Markov bias: choose"
        f" {limit}{Hint('walk', sensor, f'1e-6 {si}')} (a value with unit) with"
        f" {Hint('horizon', value=10)}, or add gauss_markov to the channel in the model file"
    )
