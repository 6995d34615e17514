"""Words of findings about slow changes: warm-up, temperature, noise that changes, selection of a window."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.drift import NonStationary, TemperatureDrift, WarmUp
from sigmatau.findings.wording.phrases import Words, clock
from sigmatau.noise.terms import display_units
from sigmatau.results import duration_text, seconds, two_digits


def _warm_up(finding: Finding, details: WarmUp) -> Words:
    unit, factor = display_units("bias_instability", details.quantity, finding.unit)[-1]
    half = two_digits((details.high - details.low) / (2 * factor))
    size = f"{two_digits((finding.size or 0.0) / factor)} ± {half} {unit}"
    return Words(
        f"warm-up of {size}, time constant about {duration_text(details.time_constant)}",
        "No action needed: the fit allows for it",
    )


def _temperature(finding: Finding, details: TemperatureDrift) -> Words:
    unit, factor = display_units("bias_instability", details.quantity, details.rate_unit)[-1]
    value, low, high = ((one or 0.0) / factor for one in (finding.size, details.low, details.high))
    return Words(
        f"temperature drift of {value:.3g} [{low:.3g}, {high:.3g}] {unit}/K",
        "Compensate for temperature: the coefficients are those without the drift",
    )


def _non_stationary(finding: Finding, details: NonStationary) -> Words:
    texts = []
    one, change = details.segments, details.change
    if one is not None:
        texts.append(
            f"Allan deviations of segments differ by a factor of {one.ratio:.3g}"
            + ("" if change else f" at τ = {seconds(one.tau)} s, largest in the one from {clock(one.largest_at)}")
        )
    if change is not None:
        texts.append(f"short-time noise changes by a factor of {change.ratio:.3g} at {clock(change.time)}")
    return Words(
        "; ".join(texts),
        "Find the cause (--stability MAP.png shows the change), or select a stationary part with --window",
    )


WORDS: dict[type, Callable[[Finding, Any], Words]] = {
    WarmUp: _warm_up,
    TemperatureDrift: _temperature,
    NonStationary: _non_stationary,
}
