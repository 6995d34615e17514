"""Parsers of typed options of the form KEY=VALUE, averaging times and bandwidths."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from fractions import Fraction
from typing import get_args

from sigmatau.errors import OptionError
from sigmatau.estimators.deviation_kinds import TauGrid
from sigmatau.quality.selection.time_text import parse_seconds


def key_values(values: Sequence[str], option: str, example: str) -> dict[str, str]:
    """Convert ``["gyro=deg/s", "accel=g,time=s"]`` to a dictionary."""
    result: dict[str, str] = {}
    for text in values:
        for part in text.split(","):
            key, equals, value = part.partition("=")
            key, value = key.strip(), value.strip()
            if part != text and part.strip().isdigit():
                raise OptionError(
                    f"--{option} {text!r}: a comma separates pairs. Write a decimal number with a point, e.g. gyro=0.01",
                    option=option,
                )
            if not (key and equals and value):
                what = "" if part == text else f" {part!r}"
                raise OptionError(
                    f"--{option} {text!r}:{what} must be NAME=VALUE, e.g. --{option} {example}", option=option
                )
            if _is_swapped(key, value, option):
                raise OptionError(
                    f"--{option} {part.strip()}: the name comes first. Give --{option} {value}={key}", option=option
                )
            if result.setdefault(key, value) != value:
                raise OptionError(f"--{option}: {key!r} is given twice, {result[key]!r} and {value!r}", option=option)
    return result


_SENSOR = re.compile(r"(gyro|accel)(_[xyz])?|time")
_NUMBERS_OF_COLUMNS = re.compile(r"\d+(:\d+)?")


def _is_swapped(key: str, value: str, option: str) -> bool:
    """Whether a pair has the name of a channel or sensor after its value."""
    may_be_value = option != "channels" or _NUMBERS_OF_COLUMNS.fullmatch(key) is not None
    return may_be_value and _SENSOR.fullmatch(value) is not None and _SENSOR.fullmatch(key) is None


def key_numbers(values: Sequence[str], option: str, example: str) -> dict[str, float]:
    """Convert ``["gyro=0.01", "accel=1/16384"]`` to a dictionary of finite numbers."""
    result = {}
    for key, value in key_values(values, option, example).items():
        try:
            number = _parse_number(value)
        except (ValueError, ZeroDivisionError, OverflowError):
            number = math.nan
        if not math.isfinite(number):
            raise OptionError(f"--{option} {key}={value}: {value!r} is not a number; e.g. {example}", option=option)
        result[key] = number
    return result


def factors(typed: str | float, option: str, example: str) -> float | dict[str, float]:
    """Convert ``"3"`` to a number, and ``"gyro=3,accel=10"`` to a dictionary of numbers."""
    if not isinstance(typed, str):
        return typed
    if "=" in typed:
        return key_numbers([typed], option, example)
    try:
        return float(typed)
    except ValueError:
        raise OptionError(
            f"--{option} {typed!r} is not a number. Give a factor, --{option} 2, or factors by sensor, --{option} {example}",
            option=option,
        ) from None


def _parse_number(text: str) -> float:
    """Parse a number or a quotient of two, ``1/16.4``. Raises `ValueError` or `ZeroDivisionError` for other texts."""
    if "/" not in text:
        return float(text)
    numerator, denominator = text.split("/")
    return float(Fraction(numerator) / Fraction(denominator))


def averaging_times(text: str) -> str | list[float]:
    """Parse the option ``--taus``: the name of a grid, or times, in seconds if they have no unit."""
    grids = get_args(TauGrid)
    if text in grids:
        return text
    try:
        return [parse_seconds(part, option="taus") for part in text.split(",")]
    except OptionError:
        raise OptionError(
            f"--taus {text!r}: must be {', '.join(grids)}, or times in s, or with units, e.g. 0.1,1,10min",
            option="taus",
        ) from None


_BANDWIDTH = re.compile(r"([0-9.eE+-]+) *(?:Hz)?(?: */ *([1-8]))?")


def bandwidths(values: Sequence[str]) -> dict[str, tuple[float, int | None]]:
    """Parse the option ``--bandwidth``: ``["gyro=30Hz/2"]`` becomes ``{"gyro": (30.0, 2)}``."""
    result: dict[str, tuple[float, int | None]] = {}
    for name, text in key_values(values, "bandwidth", "gyro=30Hz").items():
        match = _BANDWIDTH.fullmatch(text)
        try:
            hertz = float(match[1]) if match else math.nan
        except ValueError:
            hertz = math.nan
        if match is None or not (0 < hertz < 1e6):
            raise OptionError(
                f"--bandwidth {name}={text}: must be a frequency, and the order of the filter if known, e.g. gyro=30Hz or"
                " gyro=30Hz/2",
                option="bandwidth",
            )
        result[name] = (hertz, int(match[2]) if match[2] else None)
    return result
