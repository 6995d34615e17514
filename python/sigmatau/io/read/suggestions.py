"""Columns whose names do not identify them: read if gravity does, suggested if their values do, otherwise asked in a
question.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

from numpy.typing import NDArray

from sigmatau.errors import DataError, OptionError
from sigmatau.findings.columns import ColumnsByGravity
from sigmatau.findings.finding import Finding
from sigmatau.frozen import frozen
from sigmatau.hints import Hint
from sigmatau.io.read.column_values import Identified, Triple, identify, load_columns
from sigmatau.io.read.columns import channels_hint, find_time
from sigmatau.io.read.gravity import GYRO_MEAN
from sigmatau.io.read.name_tables import INERTIAL, NOT_A_SENSOR
from sigmatau.io.read.names import bare_name, name_key, names_sensor, recognise, signal_name, stated_unit
from sigmatau.io.read.table import Column, Table, listing
from sigmatau.io.read.time.dates import is_date

_EXAMPLE_SIGNALS = 4  # largest number of signals that an example names
_ROWS_SHOWN = 3
_COLUMNS_SHOWN = 16
_WIDTH = 80  # width of a terminal line [characters]
_DIGITS_SHOWN = 6
_WHOLE_SHOWN = 1e19  # integers below this size are shown with all digits
_WORD_SHOWN = 12  # largest number of characters of a text that is shown


def by_gravity(table: Table) -> tuple[dict[str, str | int], Finding] | None:
    """Channels of a table of six or seven unnamed columns, as the option of `read`; None if they are not certain."""
    count = len(table.columns)
    if count not in (6, 7) or any(column.name for column in table.columns):
        return None
    try:
        loaded = table.load(list(range(count)), None).columns
    except DataError:  # raised again when the record is read
        return None
    identified = identify(loaded, time=None, excluded=frozenset())
    if identified is None or identified.gyro is None or identified.accel is None or identified.counts_per_g is not None:
        return None
    first = count - 6
    if (identified.time == 0) != (count == 7) or min(identified.gyro[0], identified.accel[0]) != first:
        return None
    if identified.gyro_mean > GYRO_MEAN * identified.gravity:
        return None
    details = ColumnsByGravity(
        gyro=(identified.gyro[0] + 1, identified.gyro[-1] + 1),
        accel=(identified.accel[0] + 1, identified.accel[-1] + 1),
        time=1 if count == 7 else None,
        gravity=identified.gravity,
        other=identified.gyro_mean,
    )
    channels: dict[str, str | int] = {} if identified.time is None else {"time": 1}
    channels |= {name: f"{first + 1}:{last}" for name, (first, *_, last) in _places(identified).items()}
    return channels, Finding(details=details, severity="info")


def _places(identified: Identified) -> dict[str, tuple[int, int, int]]:
    """First, second and last column of each sensor; the last one is counted from 1, as in an option."""
    sensors = {"gyro": identified.gyro, "accel": identified.accel}
    return {name: (axes[0], axes[1], axes[2] + 1) for name, axes in sensors.items() if axes is not None}


def ask_for_columns(table: Table) -> OptionError:
    """The question for the columns of a table in which no sensor is recognised.

    It shows the columns that values confirm, or else the first rows.
    """
    what = (
        "has no column names" if not any(column.name for column in table.columns) else "has no column with a known name"
    )
    if signals := _signals(table.columns):
        text = f"{what} (columns: {listing(table.columns)}); name them, e.g. by {Hint('channels', value=signals)}"
        return OptionError(text, option="channels", question=f"{what}. Columns: {listing(table.columns)}")
    loaded = load_columns(table)
    suggestion = _suggest(table, loaded)
    if suggestion is not None:
        text = f"{what}; {suggestion.evidence}: run with {suggestion.options}"
        return OptionError(text, option="channels", question=f"{what}. The values: {suggestion.evidence}")
    unnamed = not any(column.name for column in table.columns)
    listed = "" if loaded and unnamed else f" (columns: {listing(table.columns)})"
    text = (
        f"{what}{listed}, and the values do not show which columns belong to which sensor; name the columns by {_FORM}"
    )
    return OptionError(
        text,
        option="channels",
        rows=_first_rows(table, loaded) if loaded else "",
        question=f"{what}{listed}. The values do not show which columns belong to which sensor",
    )


_FORM = Hint("channels", value={"time": "N", "gyro": "N:N", "accel": "N:N"})


@frozen
class _Suggestion:
    options: str  # Hints for channels, and for the scale of counts
    evidence: str  # evidence of the values


def _suggest(table: Table, loaded: Mapping[int, NDArray[Any]]) -> _Suggestion | None:
    """Suggest the columns that the values confirm and the names do not contradict."""
    matches = recognise(table.columns)
    excluded = {
        index
        for index, (column, match) in enumerate(zip(table.columns, matches, strict=True))
        if match is not None or re.search(NOT_A_SENSOR, column.name)
    }
    time = find_time(table.columns, matches, taken=set(), strict=False).time
    identified = identify(loaded, time=time, excluded=frozenset(excluded))
    if identified is None:
        return None
    if identified.accel is None and any(INERTIAL.search(table.columns[index].name) for index in excluded):
        return None  # with a command for the gyro alone, another inertial quantity would not be read
    channels: dict[str, int] = {}
    for sensor, axes in (("gyro", identified.gyro), ("accel", identified.accel)):
        if axes is None:
            continue
        named = _axes_by_name(table.columns, axes, sensor)
        if named is None:
            return None
        channels |= {f"{sensor}_{axis}": index for axis, index in named.items()}
    if identified.time is not None:
        channels["time"] = identified.time
    first = {
        channel: min(channels.get(f"{channel[:-1]}{axis}", index) for axis in "xyz")
        for channel, index in channels.items()
    }
    options = str(channels_hint(dict(sorted(channels.items(), key=lambda item: (first[item[0]], item[0])))))
    if identified.accel is None:
        evidence = "columns have the mean and the noise of a gyro, and none has gravity"
    else:
        evidence = (
            f"gravity ({identified.gravity:.4g}) is in columns {identified.accel[0] + 1} to {identified.accel[-1] + 1}"
        )
    if identified.counts_per_g is not None:
        evidence += f", {identified.counts_per_g} counts per g"
        options += f" {Hint('unit', 'accel', 'g')} {Hint('scale', 'accel', f'{1 / identified.counts_per_g:.6g}')}"
    return _Suggestion(options=options, evidence=evidence)


def _axes_by_name(columns: Sequence[Column], axes: Triple, sensor: str) -> dict[str, int] | None:
    """The order of the axes of three columns, from the letters in their names; without names, x, y, z.

    None if the names contradict each other.
    """
    names = [columns[index].name.strip() for index in axes]
    if not any(names):
        return dict(zip("xyz", axes, strict=True))
    keys = [name_key(bare_name(columns[index])) for index in axes]
    opposite = {"gyro": "acc", "accel": "gyr"}[sensor]
    letters = [key[-1:] for key in keys]
    stems = {key[:-1] for key in keys}
    if sorted(letters) != list("xyz") or len(stems) != 1:
        letters, stems = [key[:1] for key in keys], {key[1:] for key in keys}
    if sorted(letters) != list("xyz") or len(stems) != 1 or any(opposite in key for key in keys):
        return None
    return dict(sorted(zip(letters, axes, strict=True)))


def _signals(columns: Sequence[Column]) -> dict[str, int]:
    """Numbers of the columns that have a name and a unit but no sensor; empty if there are many."""
    matches = recognise(columns)
    if any(names_sensor(column) for column in columns):
        return {}  # with an option for the signals alone, the sensor would not be read
    signals: dict[str, int] = {}
    for index, column in enumerate(columns):
        if matches[index] is None and column.name.strip() and stated_unit(column) and not is_date(column.first):
            signals[signal_name(column, taken=signals)] = index
    return {name: index + 1 for name, index in signals.items()} if len(signals) <= _EXAMPLE_SIGNALS else {}


def _first_rows(table: Table, loaded: Mapping[int, NDArray[Any]]) -> str:
    """The first rows as a small table below the numbers of the columns; one line per column if they are too wide."""
    shown = range(min(len(table.columns), _COLUMNS_SHOWN))
    rows = [[str(index + 1) for index in shown]]
    rows += [[_cell(table.columns[index], loaded.get(index), row) for index in shown] for row in range(_ROWS_SHOWN)]
    rest = f"  … {len(table.columns)} columns" if len(table.columns) > len(shown) else ""
    lines = _aligned(rows)
    if len(lines[0] + rest) > _WIDTH:
        return "\n".join([*_aligned([list(column) for column in zip(*rows, strict=True)]), *([rest] if rest else [])])
    return "\n".join([lines[0] + rest, *lines[1:]])


def _aligned(rows: Sequence[Sequence[str]]) -> list[str]:
    """Lines of cells in columns of one width."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return ["  " + "  ".join(text.rjust(width) for text, width in zip(row, widths, strict=True)) for row in rows]


def _cell(column: Column, values: NDArray[Any] | None, row: int) -> str:
    """Text of a number in the first rows, integers with all digits. Other text is shown in the first row only."""
    if values is None:
        return column.first[:_WORD_SHOWN] if row == 0 and column.first else "text"
    if row >= len(values):
        return ""
    value = float(values[row])
    return f"{value:.0f}" if value.is_integer() and abs(value) < _WHOLE_SHOWN else f"{value:.{_DIGITS_SHOWN}g}"
