"""Dates and times of day in text columns: their form, the day beside a time, and times that continue after midnight."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sigmatau._native import formats
from sigmatau._native.formats import DayOrder
from sigmatau.errors import OptionError
from sigmatau.frozen import frozen
from sigmatau.hints import WITHOUT_STAMPS
from sigmatau.io.read.table import Column

ORDERS: tuple[DayOrder, DayOrder] = ("day_first", "month_first")
NO_STAMP = np.iinfo(np.int64).min  # a missing stamp, as NumPy's NaT
_DAY = 86_400_000_000_000  # [ns]
_PERIODS = {"clock": _DAY, "minutes": _DAY // 24}  # times after which a clock without a day begins again [ns]
# longest step of a log that runs over midnight: with day and month exchanged, a step is at least 27 days
_LONGEST_STEP = 1.5 * _DAY


@frozen
class DateColumn:
    """A column of dates or of times of day."""

    day: int | None = None  # The column of the day, if this column has only the time
    period: int = 0  # The time after which its stamps begin again; 0 for dates. [ns]


def is_date(text: str) -> bool:
    """Whether a field is a time of day, with or without a date. Times are read to the nanosecond."""
    stamp = _stamp(text)
    return stamp is not None and stamp.form != "day"


def is_ordered(text: str) -> bool:
    """Whether a field is a date whose day and month another program may exchange: ``07/08/2026``."""
    stamp = _stamp(text)
    return stamp is not None and stamp.ordered


def date_columns(columns: Sequence[Column]) -> tuple[tuple[Column, ...], Mapping[int, DateColumn]]:
    """Convert the columns of dates and times to nanoseconds; return how each is read, by its number."""
    stamps = [_stamp(column.first) for column in columns]
    days = [index for index, stamp in enumerate(stamps) if stamp is not None and stamp.form == "day"]
    dates: dict[int, DateColumn] = {}
    for index, stamp in enumerate(stamps):
        if stamp is not None and stamp.form == "date":
            dates[index] = DateColumn()
        elif stamp is not None and stamp.form != "day":
            adjacent = [k for k in days if abs(k - index) == 1]
            day = adjacent[0] if adjacent else days[0] if len(days) == 1 else None
            dates[index] = DateColumn(day=day, period=_PERIODS[stamp.form])
    return tuple(replace(column, unit="ns") if k in dates else column for k, column in enumerate(columns)), dates


def _stamp(text: str) -> formats.Stamp | None:
    if not text[:1].isdigit() or text.isdigit():
        return None
    return formats.parse_stamp(text, ORDERS[0]) or formats.parse_stamp(text, ORDERS[1])


def unwrap_clock(stamps: NDArray[np.int64], period: int) -> NDArray[np.int64]:
    """Unwrap a clock that begins again after a period: 00:00:00 after 23:59:59 is the next day.

    A step back by more than half the period begins the next period. A step ahead by as much returns to the previous
    period, if any: it is a row that is logged late around midnight.
    """
    present = stamps[stamps != NO_STAMP]
    steps = np.diff(present)
    turns = np.flatnonzero(np.abs(steps) > period // 2)
    if not len(turns):
        return stamps
    counts = [0]
    for step in steps[turns].tolist():
        counts.append(max(counts[-1] + (1 if step < 0 else -1), 0))
    result = stamps.copy()
    result[stamps != NO_STAMP] = (
        present + np.repeat(counts, np.diff(turns, prepend=-1, append=len(present) - 1)) * period
    )
    return result


def parse_stamps(name: str, texts: Sequence[object]) -> NDArray[np.int64]:
    """Convert dates or times of day to nanoseconds, unwrapped at midnight; the smallest integer for any other text.

    Raises `OptionError` as `find_order` does.
    """
    first = next((text for text in texts if isinstance(text, str) and is_date(text)), "")
    orders = ORDERS if is_ordered(first) else ORDERS[:1]
    parsed = {
        order: [formats.parse_stamp(text, order) if isinstance(text, str) else None for text in texts]
        for order in orders
    }
    stamps = {
        order: np.array([NO_STAMP if stamp is None else stamp.nanoseconds for stamp in times], dtype=np.int64)
        for order, times in parsed.items()
    }
    fewest = min(int(np.count_nonzero(values == NO_STAMP)) for values in stamps.values())
    stamps = {order: values for order, values in stamps.items() if np.count_nonzero(values == NO_STAMP) == fewest}
    chosen = stamps[find_order(repr(name), first, stamps)]
    form = _stamp(first)
    return unwrap_clock(chosen, _PERIODS[form.form]) if form is not None and form.form in _PERIODS else chosen


def find_order(name: str, first: str, stamps: Mapping[DayOrder, NDArray[np.int64]]) -> DayOrder:
    """Find the order of day and month in a column that can be read in both orders. The order does not matter if it does not
    change the intervals.

    Raises `OptionError` if the values do not show it.
    """
    if len(stamps) == 1:
        return next(iter(stamps))
    steps = {order: np.diff(values[values != NO_STAMP]) for order, values in stamps.items()}
    if np.array_equal(steps[ORDERS[0]], steps[ORDERS[1]]):
        return ORDERS[0]
    smooth = [order for order in ORDERS if np.abs(steps[order]).max() <= _LONGEST_STEP]
    if len(smooth) == 1:
        return smooth[0]
    raise OptionError(
        f"the order of day and month in column {name} ({first}) is not stated; write the dates as year-month-day, or ignore"
        f" them by {WITHOUT_STAMPS}",
        option="channels",
    )
