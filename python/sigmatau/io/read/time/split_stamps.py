"""Time stamps in several columns: whole seconds, fractions of a second, and perhaps minutes and hours."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.frozen import frozen
from sigmatau.io.read.names import name_key, split_unit
from sigmatau.io.read.table import Column
from sigmatau.io.read.time.dates import NO_STAMP, unwrap_clock

# The last word of a name, or its unit in brackets.
_SECONDS = frozenset(("s", "sec", "secs", "second", "seconds"))
_PARTS = {
    10**9: frozenset(("ns", "nsec", "nsecs", "nano", "nanos", "nanosec", "nanosecs", "nanosecond", "nanoseconds")),
    10**6: frozenset(
        ("us", "usec", "usecs", "micro", "micros", "microsec", "microsecs", "microsecond", "microseconds")
    ),
    10**3: frozenset(
        ("ms", "msec", "msecs", "milli", "millis", "millisec", "millisecs", "millisecond", "milliseconds")
    ),
}
_LARGER = {
    60: frozenset(("m", "min", "mins", "minute", "minutes")),
    3600: frozenset(("h", "hr", "hour", "hours")),
}  # seconds of the units above
_NANOSECONDS = 10**9  # per second
_MAX_OUTSIDE = 0.01  # largest share of damaged rows, in which the fraction is a second or more
_LARGEST = 1 << 62  # largest joined stamp [ns]


@frozen
class SplitStamp:
    """Columns that together contain a time stamp."""

    seconds: int
    part: int  # The column of the fraction of a second
    per_second: int  # Number of its units in a second: 10⁹, 10⁶ or 10³
    larger: tuple[tuple[int, int], ...] = ()  # Columns of minutes and hours, each with its length in seconds

    @property
    def columns(self) -> tuple[int, ...]:
        """All columns of the time stamp."""
        return (self.seconds, self.part, *(column for column, _ in self.larger))


def find_split_stamps(columns: Sequence[Column]) -> list[SplitStamp]:
    """Find pairs of columns whose names are the halves of one time stamp: ``stamp.sec`` and ``stamp.nanosec``."""
    keys = [_key(column).rpartition("_") for column in columns]
    pairs: list[SplitStamp] = []
    for index, (stem, _, word) in enumerate(keys):
        if word not in _SECONDS:
            continue
        larger = [
            (k, size) for size, words in _LARGER.items() for k, half in enumerate(keys) if _fits(half, stem, words)
        ]
        is_clock = [size for _, size in larger] in ([60], [60, 3600])
        parts = [
            SplitStamp(seconds=index, part=k, per_second=per_second, larger=tuple(larger) if is_clock else ())
            for per_second, words in _PARTS.items()
            for k, half in enumerate(keys)
            if _fits(half, stem, words)
        ]
        if len(parts) == 1:
            pairs += parts
    return pairs


def _fits(key: tuple[str, str, str], stem: str, words: frozenset[str]) -> bool:
    return key[2] in words and key[0] == stem


def _key(column: Column) -> str:
    """The name of a column with its unit as the last word, in the form that is compared."""
    name, unit = split_unit(column)
    return name_key(f"{name}_{unit}") if unit else name_key(name)


def join(split: SplitStamp, columns: Mapping[int, NDArray[Any]]) -> NDArray[np.int64] | None:
    """Join the stamps in nanoseconds, unwrapped after an hour or midnight; the smallest integer for a missing one.

    None if the second column is a separate clock and not the fraction of a second.
    """
    arrays = [columns[k] for k in split.columns]
    missing = np.logical_or.reduce([_is_missing(array) for array in arrays])
    whole = [np.where(missing, 0, array) for array in arrays]
    if any(array.dtype.kind == "f" and not np.all(array == np.rint(array)) for array in whole):
        return None
    outside = np.count_nonzero((whole[1] < 0) | (whole[1] >= split.per_second))
    if outside > _MAX_OUTSIDE * len(whole[1]):
        return None
    sizes = [
        float(_NANOSECONDS),
        _NANOSECONDS / split.per_second,
        *(float(_NANOSECONDS * size) for _, size in split.larger),
    ]
    if any(np.abs(array).max(initial=0) * size > _LARGEST for array, size in zip(whole, sizes, strict=True)):
        return None
    counts = [array.astype(np.int64) for array in whole]
    stamps = counts[0] * _NANOSECONDS + counts[1] * (_NANOSECONDS // split.per_second)
    for count, (_, size) in zip(counts[2:], split.larger, strict=True):
        stamps += count * size * _NANOSECONDS
    stamps = np.where(missing, NO_STAMP, stamps)
    period = split.larger[-1][1] * (24 if len(split.larger) > 1 else 60) if split.larger else 0
    return unwrap_clock(stamps, period * _NANOSECONDS) if period else stamps


def _is_missing(array: NDArray[Any]) -> NDArray[np.bool_]:
    missing: NDArray[np.bool_] = np.isnan(array) if array.dtype.kind == "f" else array == NO_STAMP
    return missing
