"""Words of findings about slow changes: warm-up, temperature, noise that changes, selection of a window."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.drift import Drift, LateDrift, NonStationary, TemperatureDrift, WarmUp
from sigmatau.findings.wording.phrases import Words, clock, factor_text
from sigmatau.noise.terms import TERMS, display_units
from sigmatau.results import duration_text, seconds, two_digits

__all__ = ["WORDS"]


def _effect(finding: Finding, details: Drift) -> str:
    """The coefficient that the drift changes most."""
    if finding.factors:
        term, factor = max(finding.factors, key=lambda one: abs(math.log(one[1])) if one[1] > 0 else math.inf)
        text = factor_text(term, factor, quantity=details.quantity)
        if term in details.lower_bounds and factor > 1:
            label = TERMS[term].label(details.quantity)
            text = f"{label} at least {text.removeprefix(label).strip()}"
        return text
    if details.undetermined:
        return f"the whole {TERMS[details.undetermined[0]].label(details.quantity)} may be due to the drift"
    return "no coefficient changes by more than 5 %"


def _size(finding: Finding, details: WarmUp | LateDrift) -> str:
    unit, factor = display_units("bias_instability", details.quantity, finding.unit)[-1]
    return f"{two_digits((finding.size or 0.0) / factor)} ± {two_digits(details.error / factor)} {unit}"


def _exponential(finding: Finding, details: WarmUp | LateDrift, motion: str) -> str:
    return (
        f"{motion.format(_size(finding, details))}, time constant {duration_text(details.time_constant)};"
        f" {_effect(finding, details)}"
        f"{', steps included' if details.with_steps else ''}"
    )


def _warm_up(finding: Finding, details: WarmUp) -> Words:
    window = f"--window {_rounded_up(details.settled)}s:"
    again = f"Record again, starting {duration_text(details.settled)} after power-on"
    if details.settled > details.duration:
        action = f"{again}; the drift lasts for the whole record"
    elif details.settled > details.duration / 2:
        action = f"{again}; {window} keeps less than half of this record"
    else:
        action = f"Run with {window} to exclude the warm-up"
    return Words(_exponential(finding, details, "warm-up of {}"), action)


def _late_drift(finding: Finding, details: LateDrift) -> Words:
    begins = finding.spans[0][0]
    action = "Find the cause, then record again"
    if begins > details.duration / 2:
        action = f"Find the cause, or run with --window :{begins:.0f}s to exclude the drift"
    return Words(_exponential(finding, details, "drift of {} at the end"), action)


def _temperature(finding: Finding, details: TemperatureDrift) -> Words:
    unit, factor = display_units("bias_instability", details.quantity, details.rate_unit)[-1]
    value, low, high = ((one or 0.0) / factor for one in (finding.size, details.low, details.high))
    return Words(
        f"temperature drift of {value:.3g} [{low:.3g}, {high:.3g}] {unit}/K over"
        f" {two_digits(details.temperature_range)} K; {_effect(finding, details)}",
        "Compensate for temperature, record at constant temperature, or select a stable part with --window",
    )


def _non_stationary(finding: Finding, details: NonStationary) -> Words:
    texts = []
    one, change = details.segments, details.change
    if one is not None:
        texts.append(
            f"Allan deviations of segments differ by a factor of {one.ratio:.3g}"
            + ("" if change else f" at τ = {seconds(one.tau)} s, largest from {clock(one.largest_at)}")
        )
    if change is not None:
        texts.append(f"short-time noise changes by a factor of {change.ratio:.3g} at {clock(change.time)}")
    return Words(
        "; ".join(texts),
        "Find the cause (--stability MAP.png shows the change), or select a stationary part with --window",
    )


def _rounded_up(time: float) -> int:
    """Seconds, rounded up to two digits."""
    step: int = 10 ** max(math.floor(math.log10(time)) - 1, 0)
    return math.ceil(time / step) * step


WORDS: dict[type, Callable[[Finding, Any], Words]] = {
    WarmUp: _warm_up,
    LateDrift: _late_drift,
    TemperatureDrift: _temperature,
    NonStationary: _non_stationary,
}
