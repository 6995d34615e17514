"""Parser of the option ``rate`` of one log: the sampling rate of all sensors, or of each sensor."""

from __future__ import annotations

import re
from collections.abc import Sequence

from sigmatau.errors import OptionError

_IN_HERTZ = re.compile(r"([0-9.]+) ?hz", re.IGNORECASE)


def parse_rate(words: Sequence[str]) -> float | dict[str, float] | None:
    """Parse the rate of one log: ``["100"]`` becomes 100.0, ``["gyro=400,accel=200"]`` a dictionary. Raises
    `OptionError`. [Hz]
    """
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


def _parts(words: Sequence[str]) -> list[tuple[str, float]]:
    """Split into keys, empty for a number alone, and rates."""
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
