"""Facts that the lines above a text table state: the sampling rate, and the clock of MT Manager."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sigmatau.record.sampling import RateSource

_RATE = (  # re.IGNORECASE
    r"\b(?P<name>(?:update|output|sampl(?:e|ing)|data|logging)[ _]?(?:rate|frequency|freq))\b"
    r"[ \t]*(?:\((?P<before>hz)\)|\[hz\])?[\"' \t:=,;]{0,9}(?P<rate>\d+(?:\.\d+)?)[ \t\"',;]{0,3}(?P<behind>hz\b)?"
)
SAMPLE_TIME = "sampletimefine"
_WRAP = 1 << 32  # counts of SampleTimeFine, an unsigned 32-bit counter (Xsens, MT Low Level Communication Protocol)
# Counts in a second: 10 kHz in the MT series (the same source), 1 MHz in Movella DOT (its BLE services specification).
_COUNTS_PER_SECOND = (10_000, 1_000_000)
_RATE_TOLERANCE = 0.01  # of the counts between two rows, which are rounded to whole counts
_ROWS = 20  # rows whose counts are compared with the stated rate; fewer cannot show a regular interval


# Units of MT Manager's exports, which do not state them: Xsens, MT Manager User Manual, table of exported data.
_MT_MANAGER_UNITS = {"acc_": "m/s^2", "gyr_": "rad/s"}


@dataclass(frozen=True, slots=True, kw_only=True)
class StatedRate:
    """A sampling rate that a line above the table states with its unit."""

    rate: float  # [Hz]
    source: RateSource


def find_rate(lines: Sequence[tuple[int, str]]) -> StatedRate | None:
    """The sampling rate in Hz that the numbered lines state; None if no line does, or if they contradict each other."""
    stated: dict[float, StatedRate] = {}
    for number, text in lines:
        match = re.search(_RATE, text, re.IGNORECASE) if "hz" in text.lower() else None
        if match is None or not (match["before"] or match["behind"] or "[hz]" in match[0].lower()):
            continue
        rate = float(match["rate"])
        if rate > 0:
            source = RateSource(kind="file", place=match["name"], line=number)
            stated.setdefault(rate, StatedRate(rate=rate, source=source))
    return next(iter(stated.values())) if len(stated) == 1 else None


def units_of_mt_manager(
    lines: Sequence[tuple[int, str]], names: Sequence[str], units: Sequence[str | None]
) -> tuple[str | None, ...]:
    """The units of the columns, with those of MT Manager's manual if a numbered line names that program."""
    if not any("MT Manager" in text for _, text in lines):
        return tuple(units)
    return tuple(unit or _MT_MANAGER_UNITS.get(name.lower()[:4]) for name, unit in zip(names, units, strict=True))


def counts_per_second(counts: Sequence[float], rate: float) -> int | None:
    """How many counts of SampleTimeFine are a second, by the counts of the first rows and the stated rate; None if the
    counts are not regular, or fit neither of the two clocks.
    """
    values = np.asarray(counts, dtype=np.float64)
    if len(values) < _ROWS or not np.isfinite(values).all():
        return None
    interval = float(np.median(np.mod(np.diff(values), _WRAP)))
    return next((c for c in _COUNTS_PER_SECOND if abs(interval * rate / c - 1) < _RATE_TOLERANCE), None)


def unwrapped(counts: NDArray[np.int64], per_second: int) -> NDArray[np.int64]:
    """Nanoseconds from the counts of a 32-bit counter that starts again from 0; missing counts, the smallest 64-bit
    integer, stay missing.
    """
    missing = counts == np.iinfo(np.int64).min
    present = counts[~missing]
    turns = np.cumsum(np.diff(present, prepend=present[:1]) < -(_WRAP // 2))
    times = np.full(len(counts), np.iinfo(np.int64).min)
    times[~missing] = (present + turns * _WRAP) * (1_000_000_000 // per_second)
    return times
