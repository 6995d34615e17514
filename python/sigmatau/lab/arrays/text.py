"""Printed form of the analysis of an array."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from sigmatau.digits import limit_text, round_to_error, two_digits
from sigmatau.lab.arrays.intervals import Correlation, Estimate
from sigmatau.lab.arrays.result import ArrayAnalysis
from sigmatau.lab.arrays.virtual_sensor import PredictedDeviation, VirtualSensor
from sigmatau.noise.terms import TERMS, display_units
from sigmatau.results import aligned, duration_text, lines_text, seconds, wrapped

_SENSORS = {"angular_rate": "gyros", "acceleration": "accelerometers"}
# largest number of pairs that are printed for a component, and of pairs with a significant correlation
_MOST_PAIRS, _MOST_CORRELATED = 6, 15


def array_text(array: ArrayAnalysis) -> str:
    """Coefficients, correlations, weights, virtual sensor and checks."""
    blocks = [_head(array), _coefficients(array), _correlations(array), _weights(array)]
    return lines_text(line for block in blocks if block for line in [*block, ""])[:-1]


def _head(array: ArrayAnalysis) -> list[str]:
    length = duration_text(array.samples * array.tau0)
    sensors = _SENSORS.get(array.quantity, "sensors")
    lines = [f"{len(array.names)} {sensors} at {1 / array.tau0:.5g} Hz, {length}"]
    if array.common:
        lines[0] += ", common disturbance eliminated (N-cornered hat)"
    lines += [f"{name}: {source}" for name, source in zip(array.names, array.sources, strict=False)]
    if array.filled:
        lines.append(f"{array.filled} rows without a usable sample of each sensor were filled")
    if array.goodness.is_misfit:
        worst = array.goodness.worst
        lines += wrapped(
            [
                f"! the model does not fit, p = {array.goodness.p_value:.1g}, worst from {worst.low:.3g} to"
                f" {worst.high:.3g} Hz. Intervals are {array.goodness.widening:.2g} times wider."
            ]
        )
    return lines


def _unit(array: ArrayAnalysis, name: str, values: list[float | None]) -> tuple[str, float]:
    time = next(component.time for component in array.components if component.name == name)
    return display_units(name if time is None else "bias_instability", array.quantity, array.unit, values)[0]


def _coefficients(array: ArrayAnalysis) -> list[str]:
    columns = [["95 %" if array.level == 0.95 else f"{100 * array.level:g} %", "", *array.names]]
    virtual = array.virtual
    if virtual is not None:
        columns[0].append(virtual.channel)
    for component in array.components:
        estimates = [*array.coefficients[component.name].values()]
        if virtual is not None:
            estimates.append(virtual.coefficients[component.name])
        unit, factor = _unit(array, component.name, [each.value for each in estimates])
        cells = [_cell(each, factor) for each in estimates]
        columns.append([component.label(array.quantity), unit, *cells])
    return aligned(list(zip(*columns, strict=True)))


def _cell(each: Estimate, factor: float = 1.0, sign: str = "") -> str:
    if each.value is None:
        return "" if each.upper_limit is None else limit_text(each.upper_limit / factor)
    return round_to_error(each.value, each.low, each.high, size=factor, sign=sign).text


def _correlations(array: ArrayAnalysis) -> list[str]:
    lines = []
    for component in array.components:
        pairs = array.correlations.get(component.name)
        if not pairs:
            continue
        label = component.label(array.quantity)
        observed = {pair: each for pair, each in pairs.items() if each.value is not None}
        if not observed:
            lines.append(f"correlation of {label}: not observable, the term is too weak")
            continue
        lines.append(f"correlation of {label}{_not_observable(len(pairs) - len(observed))}")
        lines += _pair_lines(observed)
    return lines


def _not_observable(count: int) -> str:
    return f" ({count} pairs not observable: the term is too weak)" if count else ""


def _pair_lines(pairs: Mapping[tuple[str, str], Correlation]) -> list[str]:
    """The significant correlations and the largest of the others."""
    ordered = sorted(pairs.items(), key=lambda item: (not item[1].correlated, -abs(item[1].value or 0.0)))
    significant = sum(each.correlated for each in pairs.values())
    shown = ordered[: min(max(_MOST_PAIRS, significant), _MOST_CORRELATED)]
    rows = [[f"  {a}", b, _cell(each, sign="+"), "correlated" if each.correlated else ""] for (a, b), each in shown]
    rest = len(ordered) - len(shown)
    return aligned(rows) + ([f"  and {rest} weaker pairs"] if rest > 0 else [])


def _weights(array: ArrayAnalysis) -> list[str]:
    virtual = array.virtual
    if virtual is None:
        return wrapped([f"no virtual sensor: {array.no_weights}"])
    label = TERMS[virtual.target].label(array.quantity) if virtual.target in TERMS else virtual.target
    rows = [[f"  {name}", _cell(each)] for name, each in zip(array.names, virtual.weights.values, strict=True)]
    return [
        f"{virtual.channel}: weights for the least {label}",
        *aligned(rows),
        *wrapped(_statements(array, virtual, label)),
    ]


def _statements(array: ArrayAnalysis, virtual: VirtualSensor, label: str) -> list[str]:
    weights = virtual.weights
    lines = [f"{label}: {_cell(weights.gain)} times better than the best sensor, {array.names[weights.best]}."]
    if weights.differ:
        lines.append(f"Equal weights: these weights are {_cell(weights.gain_over_equal)} times better.")
    else:
        lines.append(
            f"Equal weights: these weights gain nothing within their error (p = {two_digits(weights.p_equal)})."
            " Use the mean."
        )
    if array.common:
        lines.append("The fused log contains the common disturbance, so that it cannot check the prediction.")
        return lines
    lines.append(f"Fused log: {_check(virtual.curve)}")
    if virtual.second_half is not None:
        lines.append(f"Second half, predicted from the first half: {_check(virtual.second_half)}")
    return lines


def _check(curve: PredictedDeviation) -> str:
    number, inside = len(curve.tau), int(np.count_nonzero(curve.inside))
    if curve.agrees:
        return f"its deviation is within the predicted band at all {number} averaging times."
    outside = ", ".join(f"{seconds(float(tau))} s" for tau in curve.tau[~curve.inside][:4])
    return f"its deviation is within the predicted band at {inside} of {number} averaging times, not at {outside}."
