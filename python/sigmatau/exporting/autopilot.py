"""Parameters of autopilots: numbers for one step of a filter, within documented ranges."""

from __future__ import annotations

import math
from collections.abc import Sequence

from sigmatau.errors import OptionError
from sigmatau.exporting.text import comment
from sigmatau.exporting.values import Numbers
from sigmatau.frozen import frozen
from sigmatau.hints import Hint

STEP = Hint("step")
_LONGEST_STEP = 1.0  # longest step: filters of vehicles predict at least this often [s]


@frozen
class AutopilotParameter:
    """A parameter of an autopilot."""

    name: str
    sensor: str
    kind: str
    unit: str
    low: float  # Documented range, which ground stations may enforce
    high: float
    cut: float = 1.0  # Largest value that the filter uses


def parameter_rows(
    numbers: Numbers, parameters: Sequence[AutopilotParameter], step: float
) -> list[tuple[str, float, str]]:
    """Name, value and comment of each parameter; N/√dt and K/√dt."""
    result = []
    for parameter in parameters:
        number = numbers.noise(parameter.sensor) if parameter.kind == "noise" else numbers.walk(parameter.sensor)
        value = number.value / math.sqrt(step)
        letter = "N" if parameter.kind == "noise" else "K"
        words = f"{parameter.name} [{parameter.unit}] = {letter}/sqrt(dt), dt = {step:g} s; {number.words}"
        if value > parameter.cut:
            words += f"; the filter limits it to {parameter.cut:g}"
        elif not parameter.low <= value <= parameter.high:
            documented = f"{parameter.low:g} to {parameter.high:g}"
            words += f"; outside the documented range, {documented}: a ground station may reject it"
        result.append((parameter.name, value, comment(words)))
    return result


def choose_step(numbers: Numbers, default: float) -> float:
    """Choose the step of the filter; raise `OptionError` for milliseconds given as seconds. [s]"""
    step = numbers.choices.step or default
    if step > _LONGEST_STEP:
        raise OptionError(
            f"{{option}} {step:g} is too long for an autopilot; the unit is s: {step:g} ms is"
            f" {Hint('step', value=step / 1000)}",
            option="step",
        )
    return step
