"""Numbers by axis, and choices that a target does not support."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from sigmatau.errors import DataError
from sigmatau.exporting.choices import Choices, NoPlaceError, given
from sigmatau.exporting.values import Number, Numbers

__all__ = ["by_axis", "noises", "of_channel", "refuse"]

T = TypeVar("T")


def of_channel(numbers: Numbers, channel: str) -> Numbers:
    """The same choices for one channel alone."""
    return numbers.of(channel)


def by_axis(numbers: Numbers, sensor: str, of: Callable[[Numbers], T]) -> tuple[T, T, T]:
    """`of` applied to x, y and z of a sensor, or three times its result for all axes unless ``axes="each"``."""
    channels = numbers.channels(sensor)
    if numbers.choices.axes != "each":
        one = of(numbers)
        return one, one, one
    names = [f"{sensor}_{axis}" for axis in "xyz"]
    missing = [name for name in names if name not in channels]
    if missing:
        raise DataError(
            f"`axes` is each, and the model has no {', '.join(missing)}; {given('axes', 'worst')} writes one value for all"
        )
    x, y, z = (of(of_channel(numbers, name)) for name in names)
    return x, y, z


def noises(numbers: Numbers, sensor: str) -> tuple[Number, Number, Number]:
    """N of x, y and z."""
    return by_axis(numbers, sensor, lambda one: one.noise(sensor))


def refuse(numbers: Numbers, target: str, why: str, *choices: str) -> None:
    """Raise `NoPlaceError` for a choice that differs from the default and does not apply to a target."""
    default = Choices()
    for name in choices:
        if getattr(numbers.choices, name) != getattr(default, name):
            raise NoPlaceError(f"{{@{name}}} does not apply to {target}: {why}", choice=name)
