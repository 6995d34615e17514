"""Tables whose rows are those of several sensors in turn: separated if an option states it, refused otherwise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from numpy.typing import NDArray

from sigmatau.errors import DataError, OptionError
from sigmatau.hints import Hint
from sigmatau.io.read.columns import ColumnChoice
from sigmatau.io.read.interleaving import find_interleaving, find_turns
from sigmatau.io.read.options import Options
from sigmatau.io.read.resolve import SI, resolve
from sigmatau.io.read.table import Table, load_stamped
from sigmatau.io.read.time.rows import shares_times
from sigmatau.record.record import stream_name


def separate_turns(tables: Sequence[Table], options: Options) -> Sequence[Table]:
    """Replace each table whose rows take turns by one table for each sensor, if the option states their number: topics
    ``imu0``, ``imu1`` …

    Raises `DataError` if a row is lost, because the sensors then change turns.
    """
    count = options.interleaved
    if count is None or count == 1:
        return tables
    separate: list[Table] = []
    for table in tables:
        if len(tables) == 1 or any(table.topic and name.startswith(f"{table.topic}/imu") for name in options.topic):
            _check_turns(table, options, count)
            separate += [_take_turn(table, turn, count) for turn in range(count)]
        else:
            separate.append(table)
    return separate


def refuse_interleaved(table: Table, choice: ColumnChoice, raw: Mapping[int, NDArray[Any]], count: int | None) -> None:
    """Raise `OptionError` if the rows are, or may be, those of several sensors in turn. `count` is the number in the
    option.
    """
    axes = {channel: raw[index] for channel, index in choice.channels.items() if stream_name(channel) in SI}
    interleaving = find_interleaving(axes, None if choice.time is None else raw[choice.time])
    if interleaving is None:
        return
    label = table.label(choice.channels[interleaving.channel])
    raise (
        interleaving.error(label, table.topic)
        if count is None
        else interleaving.error_of_count(label, table.topic, count)
    )


def refuse_shared_times(table: Table, column: int) -> None:
    """Raise `OptionError` if blocks of rows have the same times in a column of stamps that is ignored."""
    try:
        stamps = load_stamped(table, [column], column).columns[column]
    except (DataError, OptionError):  # the failure may be the reason why the column is ignored
        return
    if shares_times(stamps):
        single = Hint("interleaved", value=1)
        raise OptionError(
            f"blocks of rows have the same times in column {table.label(column)}, as those of several sensors do. Save each"
            f" sensor to its own file, or state {single} if it is a single one",
            option="interleaved",
        )


def _check_turns(table: Table, options: Options, count: int) -> None:
    """Raise `OptionError` for a wrong number of sensors, and `DataError` if the sensors do not keep their turns."""
    try:
        choice = resolve(table, options)[0]
    except OptionError:
        return  # raised again when the table is read
    axes = {channel: index for channel, index in choice.channels.items() if stream_name(channel) in SI}
    if not axes:
        return
    loaded = table.load(sorted(set(axes.values())), None)
    turns = find_turns({channel: loaded.columns[index] for channel, index in axes.items()}, count)
    if turns is None:
        return
    if turns.period < count:
        raise OptionError(f"{{option}} {count}: the means repeat after {turns.period} rows", option="interleaved")
    if turns.lost is not None:
        first, last = turns.lost
        raise DataError(
            f"has a lost or added row between {table.where(first)} and {table.where(last)}, where the sensors change turns."
            " Cut the log there, or log the number of the sensor in a column"
        )
    if turns.slow_turn is not None:
        raise DataError(
            f"has two sensors of different rates: one has {count - 1} of {count} rows. Save each sensor to its own file, or"
            " log the number of the sensor in a column"
        )


def _take_turn(table: Table, turn: int, count: int) -> Table:
    """Take every `count`-th row, beginning with row `turn`: the rows of one sensor."""
    note = f"rows {turn + 1}, {turn + 1 + count}, {turn + 1 + 2 * count} … of {count} sensors in turn"
    part = table.take_rows(slice(turn, None, count), f"imu{turn}", note)
    return replace(part, rate=None if table.rate is None else table.rate / count, words={})
