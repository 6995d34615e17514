"""Remarks in a file with N and K only: the omitted noise, and the errors that a filter with these numbers states."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

from sigmatau.exporting.choices import KINDS
from sigmatau.exporting.consistent import HORIZON, AssumedNoise, judge_pair
from sigmatau.exporting.values import Numbers
from sigmatau.findings.exporting import PairConsistency, QuantizationInSamples
from sigmatau.findings.finding import Finding, Severity
from sigmatau.model.channel import ChannelModel
from sigmatau.model.process_curves import scaled
from sigmatau.noise.terms import SLOW, TERMS
from sigmatau.results import duration_text

_DOMINATED = 2.0  # ratio of quantization to N*sqrt(rate) in a sample above which there is a finding
SHARE_OF_UNOBSERVED = {"mean": "at 1/sqrt(3) of their upper limits", "upper-limit": "at their upper limits"}
"""Phrase that describes the included share of terms that were not observed, by policy."""


def pair_remarks(numbers: Numbers, *, has_turn_on: bool = False) -> list[str]:
    """Remarks for a target with fields for N and K only: the omitted terms, and the errors that its filter states.

    `has_turn_on`: whether the target has a field for the turn-on bias.
    """
    remarks = []
    for sensor in KINDS:
        channels = numbers.sensors.get(sensor, {})
        if not channels:
            continue
        remarks += omitted_noise(numbers, sensor, written=("random_walk", *SLOW), has_turn_on=has_turn_on)
        if any("quantization" in model.terms for model in channels.values()):
            _add_quantization(numbers, channels)
        remarks += _states(numbers, sensor, list(channels))
    return remarks


def omitted_noise(numbers: Numbers, sensor: str, *, written: Collection[str], has_turn_on: bool = False) -> list[str]:
    """Remark on noise of a sensor without a field in a format: terms that are not `written`, bandwidth, sinusoids,
    turn-on bias. Empty if no noise is omitted.

    `has_turn_on`: whether the format has a field for the turn-on bias.
    """
    models = numbers.sensors.get(sensor, {}).values()
    stated = {name for model in models for name in model.terms}.difference(written)
    omitted = [TERMS[name].label(next(iter(models)).quantity) for name in TERMS if name in stated]
    omitted += ["bandwidth"] if any(model.bandwidth is not None for model in models) else []
    omitted += ["sinusoids"] if any(model.sinusoid for model in models) else []
    omitted += ["turn-on bias"] if not has_turn_on and any(model.turn_on for model in models) else []
    if not omitted:
        return []
    listed = f"{', '.join(omitted[:-1])} and {omitted[-1]}" if len(omitted) > 1 else omitted[0]
    return [f"This format has no field for {listed} of the {KINDS[sensor]}; omitted."]


def _states(numbers: Numbers, sensor: str, names: list[str]) -> list[str]:
    """Remark on the errors that a filter with the numbers of a sensor states; also added as a finding."""
    truths = numbers.truths(names)
    if numbers.choices.axes == "each":
        pairs = [
            ([truth], numbers.channel_noise(name).value, numbers.channel_walk(name).value)
            for name, truth in zip(names, truths, strict=True)
        ]
    else:
        pairs = [(truths, numbers.noise(sensor).value, numbers.walk(sensor).value)]
    if numbers.missing or not any(truth.slow for truth in truths):
        return []
    judged = [_judged(numbers, sensor, *pair) for pair in pairs]
    worst = worst_of_axes(numbers, judged)
    every = f" (the worst of {len(judged)} axes)" if len(judged) > 1 else ""
    assumed = any(truth.assumed for truth in truths)
    share = SHARE_OF_UNOBSERVED.get(numbers.choices.unobserved, "")
    text = worst.text()
    remark = factors_remark(numbers, sensor)
    if remark:
        larger = [
            _judged(numbers, sensor, [_with_factors(numbers, sensor, truth) for truth in truths_of_pair], *pair)
            for truths_of_pair, *pair in pairs
        ]
        at_horizon = min((pair.stated[1] for pair in larger), key=lambda stated: stated.share)
        time = duration_text(at_horizon.time)
        remark += (
            f" With noise as large as the factors say, it states {at_horizon.share:.2f} of its error after {time}."
        )
    return [
        f"{text[0].upper()}{text[1:]}{every}." + f" Terms that were not observed count {share}." * assumed + remark,
    ]


def _with_factors(numbers: Numbers, sensor: str, truth: AssumedNoise) -> AssumedNoise:
    """Multiply N and all slow noise by the factors measured with running motors."""
    fast, slow = (numbers.factor(term, sensor) for term in ("random_walk", "rate_random_walk"))
    noise = truth.noise
    terms = {name: value * (fast if name == "random_walk" else slow) for name, value in noise.terms.items()}
    processes = tuple(scaled(process, slow) for process in noise.gauss_markov)
    return replace(truth, noise=replace(noise, terms=terms, gauss_markov=processes))


def worst_of_axes(numbers: Numbers, judged: Sequence[PairConsistency]) -> PairConsistency:
    """Select the axis whose filter states the smallest part of its error at the horizon, and add a finding if that is
    wrong.
    """
    worst = min(judged, key=lambda pair: pair.stated[1].share)
    if not worst.is_honest():
        severity: Severity = "warning" if worst.is_overconfident() else "info"
        numbers.add_finding(Finding(severity=severity, details=worst))
    return worst


def factors_remark(numbers: Numbers, sensor: str) -> str:
    """Sentence on the noise in use, if the file has factors on the numbers of a sensor."""
    has_factors = any(numbers.factor(term, sensor) != 1 for term in ("random_walk", "rate_random_walk"))
    return " This is for the noise of the sensor without the factors of the file." * has_factors


def _judged(
    numbers: Numbers, sensor: str, truths: Sequence[AssumedNoise], noise: float, walk: float
) -> PairConsistency:
    return judge_pair(
        truths,
        sensor=sensor,
        noise=noise,
        walk=walk,
        horizon=numbers.choices.horizon or HORIZON,
        mean=numbers.choices.axes == "mean",
    )


def _add_quantization(numbers: Numbers, channels: Mapping[str, ChannelModel]) -> None:
    """Add a finding if quantization makes the noise of a sample much larger than N."""
    rate = numbers.known_rate()
    ratios: dict[str, float] = {}
    for name, model in channels.items():
        terms = model.terms
        # with a limit it is the smallest possible ratio
        noise = terms.get("random_walk", model.limits.get("random_walk"))
        if rate is not None and noise and "quantization" in terms:
            ratios[name] = math.sqrt(2 * rate) * terms["quantization"] / noise
    dominated = {name: ratio for name, ratio in ratios.items() if ratio > _DOMINATED}
    if dominated:
        details = QuantizationInSamples(ratio=max(dominated.values()))
        numbers.add_finding(Finding(severity="warning", channels=tuple(dominated), details=details))
