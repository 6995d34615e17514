"""Values for x, y and z of a sensor."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TypeVar

from sigmatau.errors import OptionError
from sigmatau.exporting.values import Number, Numbers
from sigmatau.hints import Hint

T = TypeVar("T")


def three_axes(sensor: str, channels: Iterable[str]) -> list[str]:
    """Names of x, y and z of a sensor. Raises `OptionError` if a channel is missing."""
    names = [f"{sensor}_{axis}" for axis in "xyz"]
    missing = [name for name in names if name not in channels]
    if missing:
        raise OptionError(
            f"{Hint('axes', value='each')} needs three axes, and there is no {', '.join(missing)};"
            f" {Hint('axes', value='worst')} writes one value for all",
            option="axes",
        )
    return names


def by_axis(numbers: Numbers, sensor: str, evaluate: Callable[[Numbers], T]) -> tuple[T, T, T]:
    """Evaluate x, y and z of a sensor if ``axes="each"``, otherwise all axes together; return three values."""
    channels = numbers.channels(sensor)
    if numbers.choices.axes != "each":
        value = evaluate(numbers)
        return value, value, value
    names = three_axes(sensor, channels)
    x, y, z = (evaluate(numbers.select(name)) for name in names)
    return x, y, z


def noises(numbers: Numbers, sensor: str) -> tuple[Number, Number, Number]:
    """N of x, y and z."""
    return by_axis(numbers, sensor, lambda axis: axis.noise(sensor))
