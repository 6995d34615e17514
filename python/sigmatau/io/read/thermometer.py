"""Detection of the temperature column of a table by its name and unit."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from sigmatau.io.read.table import Column
from sigmatau.record.thermometers import NAMES

__all__ = ["Thermometer", "degrees_of", "find_thermometer"]

_LONGEST = 40  # longest end of a name that is searched for a unit [characters]

_ONLY_WITH_UNIT = re.compile("t")  # ArduPilot
_SPELLED = {
    **dict.fromkeys(("degc", "°c", "℃", "c", "celsius", "deg c", "° c", "deg_c", "degrees celsius"), "degC"),
    **dict.fromkeys(("k", "kelvin", "degk", "°k"), "K"),
    **dict.fromkeys(("degf", "°f", "℉", "f", "fahrenheit", "deg f", "deg_f"), "degF"),
}
_SUFFIX = re.compile(r"^(?P<stem>.+?)_(?P<unit>degc|c|celsius|deg_c|k|kelvin|degf|f|fahrenheit|deg_f)$")


@dataclass(frozen=True, slots=True, kw_only=True)
class Thermometer:
    """The column of a temperature."""

    index: int
    unit: str | None  # None if the log does not state it


def degrees_of(column: Column) -> str | None:
    """The unit of temperature that a column states; "" for any other unit, None if it states none."""
    in_brackets = re.search(r"[\[({]([^\[\](){}]*)[\])}]\s*$", column.name[-_LONGEST:])
    stated = column.unit or (in_brackets[1] if in_brackets else None)
    return _SPELLED.get(stated.strip().lower(), "") if stated else None


def find_thermometer(columns: Sequence[Column], keys: Sequence[str], taken: set[int]) -> Thermometer | None:
    """The column that is a temperature by its name and unit; None if there is none or more than one.

    `keys`: their names as `sigmatau.io.read.names.key_of` returns them; `taken`: columns that are recognised as
    something else.
    """
    found: dict[int, list[Thermometer]] = {}
    for index, (column, key) in enumerate(zip(columns, keys, strict=True)):
        if index in taken:
            continue
        unit, stem = degrees_of(column), key
        if unit is None and (match := _SUFFIX.match(key)):
            stem, unit = match["stem"], _SPELLED[match["unit"]]
        if unit == "":
            continue
        for rank, names in enumerate(NAMES):
            if re.fullmatch(names, stem):
                found.setdefault(rank, []).append(Thermometer(index=index, unit=unit))
        if unit and _ONLY_WITH_UNIT.fullmatch(stem):
            found.setdefault(0, []).append(Thermometer(index=index, unit=unit))
    if not found:
        return None
    best = found[min(found)]
    return best[0] if len(best) == 1 else None
