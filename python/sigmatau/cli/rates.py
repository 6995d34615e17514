"""The option ``--rate`` for several logs: assignment of rates to logs."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from sigmatau.errors import OptionError
from sigmatau.typed.rates import parse_rate

_WITH_COMMA = re.compile(r"(\d+),(\d+)")


def assign_rates(words: Sequence[str], logs: Sequence[Path], places: Sequence[Path]) -> dict[Path, list[str]]:
    """Assign to each log its part of ``--rate``: a number by name or by order, or the number for all logs.

    `places`: the words of the command line that selected the logs. Rates by order require that each word is a log.
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


def _find_log(key: str, logs: Sequence[Path]) -> Path | None:
    """Find a log by its name, as typed or without its folder. Raises `OptionError` if several logs match."""
    same = [log for log in logs if str(log) == key] or [log for log in logs if log.name == key]
    if len(same) > 1:
        raise OptionError(f"--rate {key}=…: {len(same)} logs have this name. Give the folder too", option="rate")
    return same[0] if same else None
