"""Time stamps that are split into two columns: whole seconds, and the part of a second as an integer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.io.read.names import key_of, unit_of
from sigmatau.io.read.table import Column
from sigmatau.io.read.time.dates import NO_STAMP

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
_NANOSECONDS = 10**9  # per second
_MAX_OUTSIDE = 0.01  # share of the rows whose part may be a second or more: damaged ones
_LARGEST = 1 << 62  # of joined stamps [ns]


@dataclass(frozen=True, slots=True, kw_only=True)
class SplitStamp:
    """Two columns that hold a time stamp together."""

    seconds: int
    part: int  # The column of the part of a second
    per_second: int  # Its unit: 10⁹, 10⁶ or 10³ in a second


def find_split_stamps(columns: Sequence[Column]) -> list[SplitStamp]:
    """Pairs of columns whose names are the halves of one time stamp: ``stamp.sec`` and ``stamp.nanosec``."""
    keys = [_key(column).rpartition("_") for column in columns]
    pairs: list[SplitStamp] = []
    for index, (stem, _, word) in enumerate(keys):
        if word not in _SECONDS:
            continue
        parts = [
            SplitStamp(seconds=index, part=k, per_second=per_second)
            for per_second, words in _PARTS.items()
            for k, half in enumerate(keys)
            if half[2] in words and half[0] == stem
        ]
        if len(parts) == 1:
            pairs += parts
    return pairs


def _key(column: Column) -> str:
    """The name of a column with its unit as the last word, in the form that is compared."""
    name, unit = unit_of(column)
    return key_of(f"{name}_{unit}") if unit else key_of(name)


def join(split: SplitStamp, seconds: NDArray[Any], part: NDArray[Any]) -> NDArray[np.int64] | None:
    """The stamps in nanoseconds, the smallest integer for a missing one; None if the second column is not the part of a
    second, but a clock of its own.
    """
    missing = _is_missing(seconds) | _is_missing(part)
    whole = [np.where(missing, 0, array) for array in (seconds, part)]
    if any(array.dtype.kind == "f" and not np.all(array == np.rint(array)) for array in whole):
        return None
    outside = np.count_nonzero((whole[1] < 0) | (whole[1] >= split.per_second))
    if outside > _MAX_OUTSIDE * len(whole[1]):
        return None
    sizes = [float(_NANOSECONDS), _NANOSECONDS / split.per_second]
    if any(np.abs(array).max(initial=0) * size > _LARGEST for array, size in zip(whole, sizes, strict=True)):
        return None
    stamps = whole[0].astype(np.int64) * _NANOSECONDS + whole[1].astype(np.int64) * (_NANOSECONDS // split.per_second)
    return np.where(missing, NO_STAMP, stamps)


def _is_missing(array: NDArray[Any]) -> NDArray[np.bool_]:
    missing: NDArray[np.bool_] = np.isnan(array) if array.dtype.kind == "f" else array == NO_STAMP
    return missing
