"""Tables of the sensors whose rows take turns, as the option says."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from sigmatau.errors import DataError, OptionError
from sigmatau.io.read.interleaving import find_turns
from sigmatau.io.read.options import Options
from sigmatau.io.read.resolve import SI, resolve
from sigmatau.io.read.table import Loaded, Table
from sigmatau.record.record import stream_name


def separate_turns(tables: Sequence[Table], options: Options) -> Sequence[Table]:
    """The tables, with one for each sensor in place of each table whose rows take turns, if the option says so: the topics
    ``imu0``, ``imu1`` … Raises `DataError` if a row is lost, so that the sensors change turns.
    """
    count = options.interleaved
    if count is None or count == 1:
        return tables
    separate: list[Table] = []
    for table in tables:
        if len(tables) == 1 or any(table.topic and name.startswith(f"{table.topic}/imu") for name in options.topic):
            _check_turns(table, options, count)
            separate += [_of_turn(table, turn, count) for turn in range(count)]
        else:
            separate.append(table)
    return separate


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


def _of_turn(table: Table, turn: int, count: int) -> Table:
    """Every so many-th row of a table."""

    def load(wanted: Sequence[int], exact: int | None) -> Loaded:
        loaded = table.load(wanted, exact)
        columns = {k: np.asarray(column)[turn::count] for k, column in loaded.columns.items()}
        return replace(loaded, columns=columns)

    return replace(
        table,
        notes=(
            *table.notes,
            f"rows {turn + 1}, {turn + 1 + count}, {turn + 1 + 2 * count} … of {count} sensors in turn",
        ),
        load=load,
        where=lambda row: table.where(row * count + turn),
        topic=f"{table.topic}/imu{turn}" if table.topic else f"imu{turn}",
        rows=None if table.rows is None else len(range(turn, table.rows, count)),
        rate=None if table.rate is None else table.rate / count,
        words={},
    )
