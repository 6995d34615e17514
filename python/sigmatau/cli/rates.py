"""The option ``--rate``: the sampling rate of all sensors, of each sensor, or of each log."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from sigmatau.errors import OptionError

_WITH_COMMA = re.compile(r"(\d+),(\d+)")
_IN_HERTZ = re.compile(r"([0-9.]+) ?hz", re.IGNORECASE)


def parse_rate(words: Sequence[str]) -> float | dict[str, float] | None:
    """The rate of one log: ``["100"]`` as 100.0, ``["gyro=400,accel=200"]`` as a dictionary; raises `OptionError`. [Hz]"""
    parts = _parts(words)
    numbers = [value for key, value in parts if not key]
    rates: dict[str, float] = {}
    for key, value in parts:
        if key and rates.setdefault(key, value) != value:
            raise OptionError(f"--rate: {key!r} is given twice, {rates[key]:g} and {value:g}", option="rate")
    if len(numbers) > 1:
        raise OptionError(
            f"--rate {' '.join(words)}: {len(numbers)} rates for one log, as {words[-1]!r} is not a file."
            " Give one rate, or --rate gyro=HZ,accel=HZ",
            option="rate",
        )
    if numbers and rates:
        raise OptionError(f"--rate {' '.join(words)}: give one rate, or one for each sensor, not both", option="rate")
    return numbers[0] if numbers else rates or None


def assign_rates(words: Sequence[str], logs: Sequence[Path], places: Sequence[Path]) -> dict[Path, list[str]]:
    """What each log has of ``--rate``: its own number, by name or by order, or else what holds for all.

    `places`: the words of the command line from which the logs were found. Rates by order need each log among them.
    """
    rates = dict[Path, list[str]]()
    common: list[str] = []
    numbers: list[str] = []
    for word in words:
        if len(logs) == 1 and (decimal := _WITH_COMMA.fullmatch(word)):
            raise OptionError(
                f"--rate {word}: two rates for one log. Give one rate, a decimal one with a point: --rate"
                f" {decimal[1]}.{decimal[2]}",
                option="rate",
            )
        key, equals, value = word.rpartition("=")
        if equals and (log := _find_log(key.strip(), logs)) is not None:
            if log in rates and rates[log] != [value]:
                raise OptionError(f"--rate: {log} is given twice, {rates[log][0]} and {value}", option="rate")
            rates[log] = [value]
            continue
        for part in word.split(","):
            key, equals, value = part.partition("=")
            log = _find_log(key.strip(), logs) if equals else None
            if log is not None:
                rates[log] = [value]
            elif equals:
                common.append(part)
            else:
                numbers.append(part)
    if len(numbers) > 1 and len(logs) > 1:
        if rates or common or len(numbers) != len(logs):
            raise OptionError(
                f"--rate has {len(numbers)} numbers for {len(logs)} logs. Give one for all, one for each log in their order,"
                f" or {logs[0].name}=HZ",
                option="rate",
            )
        if {*logs} != {*places}:
            raise OptionError(
                f"--rate has one number for each log, but a folder does not show their order. Give {logs[0].name}=HZ …",
                option="rate",
            )
        return {log: [number] for log, number in zip(logs, numbers, strict=True)}
    assigned = {log: rates.get(log, [*numbers, *common]) for log in logs}
    for texts in assigned.values():
        parse_rate(texts)
    return assigned


def _parts(words: Sequence[str]) -> list[tuple[str, float]]:
    """Keys, empty for a number alone, and rates."""
    parts = []
    for word in words:
        for part in word.split(","):
            key, equals, text = part.rpartition("=")
            key = key.strip()
            try:
                value = float(text)
            except ValueError:
                in_hertz = _IN_HERTZ.fullmatch(text.strip())
                example = "--rate 100 or --rate gyro=400,accel=200"
                if in_hertz:
                    example = f"--rate {f'{key}=' if equals else ''}{in_hertz[1]}"
                raise OptionError(
                    f"--rate {word!r}: must be a number without a unit, in Hz, e.g. {example}", option="rate"
                ) from None
            if equals and (not key or "/" in key or "." in key):
                raise OptionError(f"--rate {part}: no log of this command has the name {key!r}", option="rate")
            parts.append((key, value))
    return parts


def _find_log(key: str, logs: Sequence[Path]) -> Path | None:
    """The log of a name, as it was typed or without its folder; raises `OptionError` if several have it."""
    same = [log for log in logs if str(log) == key] or [log for log in logs if log.name == key]
    if len(same) > 1:
        raise OptionError(f"--rate {key}=…: {len(same)} logs have this name. Give the folder too", option="rate")
    return same[0] if same else None
