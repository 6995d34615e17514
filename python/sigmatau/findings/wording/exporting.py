"""Words of findings about exported files and files read back."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds import exporting as kinds
from sigmatau.findings.wording.phrases import Words, axes_text
from sigmatau.noise.terms import TERMS
from sigmatau.results import printable, seconds

_MOST_KEYS = 3  # keys of a file that are named; the others are counted
_LONGEST_KEY = 24  # characters
_QUANTITIES = {"gyro": "angular_rate", "accel": "acceleration"}


def _option(name: str) -> str:
    return f"--{name.replace('_', '-')}"


def _choice_without_place(_: Finding, of: kinds.ChoiceWithoutPlace) -> Words:
    option = f"{_option(of.option)} {printable(of.key[:_LONGEST_KEY])}".rstrip()
    return Words(f"{of.target} has no field for {option}; ignored for this target")


def _choice_not_used(_: Finding, of: kinds.ChoiceNotUsed) -> Words:
    option = f"{_option(of.term)} for {of.sensor}"
    if not of.observed:
        return Words(f"{option} not used: the model has no such sensor", "Remove the option")
    factor = "--noise-factor" if of.term == "random_walk" else "--walk-factor"
    return Words(
        f"{option} not used: the coefficient was observed, so the observed value is written",
        f"Set another value in a model file, or scale the observed one with {factor}",
    )


def _slow_noise_left_out(_: Finding, of: kinds.SlowNoiseLeftOut) -> Words:
    action = f"Use --rate-random-walk {of.sensor}=horizon --horizon 10s to approximate all slow noise by a random walk"
    if of.ratio is not None and of.tau is not None:
        return Words(
            f"the Allan deviation of all slow noise is {of.ratio:.3g} times that of the written bias process at"
            f" τ = {seconds(of.tau)} s",
            action,
        )
    unique = dict.fromkeys(one.term for one in of.omitted)
    quantity = _QUANTITIES[of.sensor]
    terms = [TERMS[term].label(quantity) if term in TERMS else "Gauss-Markov noise" for term in unique]
    return Words(f"{axes_text(terms)} omitted: the chosen random walk is written instead", action)


def _limit_written(_: Finding, of: kinds.LimitWritten) -> Words:
    label = TERMS[of.term].label("signal")
    return Words(
        f"{label} not observed; its upper limit is written", f"{_option(of.term)} sets another value, --strict refuses"
    )


def _not_adequate(_: Finding, __: kinds.NotAdequate) -> Words:
    return Words(
        "no model fits these axes, so the error of their coefficients is unknown",
        "Inspect the curve (sigmatau analyze --plot), use another part of the record (--window), or omit the channel",
    )


def _only_limits(_: Finding, __: kinds.OnlyLimits) -> Words:
    return Words(
        "vibration or rounding hides the noise of these axes, and the file has upper limits in place of their coefficients",
        "Record again without it, or omit the channel",
    )


def _poor_trust(_: Finding, __: kinds.PoorTrust) -> Words:
    return Words("trust poor: do not use the numbers of these axes", "See the warnings in the head of the file")


def _other_rate(_: Finding, of: kinds.OtherRate) -> Words:
    return Words(f"written for {of.rate:.4g} Hz; the sampling rate of the record is {of.record_rate:.4g} Hz")


def _fastest_rate(_: Finding, it: kinds.FastestRate) -> Words:
    listed = ", ".join(f"{sensor} {rate:.4g} Hz" for sensor, rate in it.rates)
    return Words(
        f"the written rate of the filter is {it.rate:.4g} Hz, the highest of the sensors ({listed})",
        "Give --filter-rate HZ if the filter takes samples at another rate; the densities do not depend on it",
    )


def _correlated_samples(_: Finding, of: kinds.CorrelatedSamples) -> Words:
    filtered = f" (low-pass filter at {of.corner:.3g} Hz)" if of.corner is not None else ""
    if of.ratio is None:
        return Words(
            f"samples are correlated{filtered}; the written N^2*rate is the variance without the filter",
            "Set the bandwidth of the channel in a model file to write the variance of the samples",
        )
    return Words(
        f"samples are correlated{filtered}: their variance is {of.ratio:.3g} times N^2*rate",
        f"Use N^2*rate = {of.independent_variance:.4g} in a filter that assumes independent samples",
    )


def _keys_not_read(_: Finding, of: kinds.KeysNotRead) -> Words:
    named = ", ".join(printable(key[:_LONGEST_KEY]) for key in of.keys[:_MOST_KEYS])
    more = f" and {len(of.keys) - _MOST_KEYS} more" if len(of.keys) > _MOST_KEYS else ""
    return Words(f"keys not read: {named}{more}")


def _imported_without_intervals(_: Finding, __: kinds.ImportedWithoutIntervals) -> Words:
    return Words("one value for all axes, without an interval; such files often contain inflated values")


def _deviation_as_density(finding: Finding, of: kinds.DeviationAsDensity) -> Words:
    return Words(
        f"gyr_n and acc_n are standard deviations of a sample; they are divided by sqrt({of.rate:.4g} Hz)",
        f"Do not use them as densities: they are {finding.size:.3g} times too large",
    )


def _minimum_as_walk(_: Finding, of: kinds.MinimumAsWalk) -> Words:
    return Words(
        f"{axes_text(of.keys)} not read: a minimum of the Allan deviation is not a random walk",
        "Analyse the record itself, or choose a value with --rate-random-walk",
    )


WORDS: dict[type, Callable[[Finding, Any], Words]] = {
    kinds.ChoiceNotUsed: _choice_not_used,
    kinds.ChoiceWithoutPlace: _choice_without_place,
    kinds.CorrelatedSamples: _correlated_samples,
    kinds.DeviationAsDensity: _deviation_as_density,
    kinds.ImportedWithoutIntervals: _imported_without_intervals,
    kinds.KeysNotRead: _keys_not_read,
    kinds.MinimumAsWalk: _minimum_as_walk,
    kinds.LimitWritten: _limit_written,
    kinds.NotAdequate: _not_adequate,
    kinds.OnlyLimits: _only_limits,
    kinds.PoorTrust: _poor_trust,
    kinds.FastestRate: _fastest_rate,
    kinds.OtherRate: _other_rate,
    kinds.SlowNoiseLeftOut: _slow_noise_left_out,
}
