"""Parsers of typed ranges of averaging times."""

from __future__ import annotations

from collections.abc import Sequence

from sigmatau.errors import OptionError
from sigmatau.quality.selection.time_text import parse_time
from sigmatau.typed.pairs import key_values

_EXAMPLE = "random_walk=1s:10s"


def read_off_ranges(values: Sequence[str]) -> dict[str, tuple[float, float]]:
    """Parse ``--read-off-at``: ``["gyro_x.random_walk=1s:10s"]`` becomes ``{"gyro_x.random_walk": (1.0, 10.0)}``, in s."""
    return {
        key: parse_ends(text, f"{key}={text}", option="read_off_at", example=_EXAMPLE)
        for key, text in key_values(values, "read-off-at", _EXAMPLE).items()
    }


def parse_ends(text: str, typed: str, *, option: str, example: str) -> tuple[float, float]:
    """Parse the averaging times of ``"1s:10s"``, in s; `typed` is quoted in an error."""
    first, colon, last = text.partition(":")
    if not (first.strip() and colon and last.strip()):
        raise OptionError(
            f"--{option.replace('_', '-')} {typed}: give the shortest and the longest averaging time, e.g. {example}",
            option=option,
        )
    forms = f"e.g. {example} (ms, s, min, h, d)"
    shortest, longest = (parse_time(part, typed, option=option, forms=forms) for part in (first, last))
    return shortest, longest
