"""Ranges of averaging times on the command line."""

from __future__ import annotations

from collections.abc import Sequence

from sigmatau.cli.options import key_values
from sigmatau.errors import OptionError
from sigmatau.quality.selection.time_text import time_of

_EXAMPLE = "random_walk=1s:10s"


def read_off_ranges(values: Sequence[str]) -> dict[str, tuple[float, float]]:
    """The option ``--read-off-at``: ``["gyro_x.random_walk=1s:10s"]`` as ``{"gyro_x.random_walk": (1.0, 10.0)}``, in s."""
    found = {}
    for key, text in key_values(values, "read-off-at", _EXAMPLE).items():
        first, colon, last = text.partition(":")
        if not (first.strip() and colon and last.strip()):
            raise OptionError(
                f"--read-off-at {key}={text}: want the shortest and the longest averaging time, e.g. {_EXAMPLE}",
                option="read_off_at",
            )
        ends = [
            time_of(part, f"{key}={text}", option="read_off_at", forms=f"e.g. {_EXAMPLE} (ms, s, min, h, d)")
            for part in (first, last)
        ]
        found[key] = (ends[0], ends[1])
    return found
