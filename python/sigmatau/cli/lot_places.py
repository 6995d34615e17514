"""Files of the units of a lot, their names, and the expected units."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from pathlib import Path

from sigmatau.cli.options import say
from sigmatau.errors import DataError, OptionError
from sigmatau.io.folders import gather, is_empty, is_log, skipped_lines
from sigmatau.lab.lots.reading import natural_order
from sigmatau.lab.lots.unit_pattern import FOLDER, unit_in_path

_LARGEST_LIST = 1 << 20  # largest size of a list of units [bytes]


def units_in_paths(places: Sequence[Path], expression: str) -> dict[Path, str]:
    """The units of ``--unit-from`` by log; each has one log."""
    names: dict[Path, str] = {}
    for place in places:
        path = place.absolute()
        name = path.parent.name if expression == FOLDER else unit_in_path(expression, str(path))
        if not name:
            raise OptionError(f"{place}: --unit-from {expression!r} finds no unit in the path", option="unit_from")
        if os.sep in name:
            raise OptionError(
                f"{place}: --unit-from {expression!r} finds {name!r:.60}; a unit is a name without {os.sep}",
                option="unit_from",
            )
        earlier = next((log for log, unit in names.items() if unit == name), None)
        if earlier is not None:
            raise OptionError(
                f"{place}: unit {name} also has the log {earlier}; give one log of each unit", option="unit_from"
            )
        names[place] = name
    return names


def expected_units(text: str) -> int | list[str]:
    """Parse the option ``--expect``: a number, or the names in a file."""
    if re.fullmatch(r"[+-]?\d+", text):
        return int(text)
    path = Path(text)
    try:
        with path.open("rb") as file:
            raw = file.read(_LARGEST_LIST + 1)
        if len(raw) > _LARGEST_LIST:
            raise DataError(f"{path}: not a list of units: more than {_LARGEST_LIST >> 20} MiB")
        lines = [line.strip() for line in raw.decode("utf-8-sig").splitlines()]
    except FileNotFoundError:
        raise OptionError(
            f"--expect {text}: must be a number of units, or the name of a file with one unit in each line",
            option="expect",
        ) from None
    except OSError as error:
        raise DataError(f"{path}: {error.strerror or error}") from None
    except UnicodeDecodeError:
        raise DataError(f"{path}: not a list of units: not text in UTF-8") from None
    names = [line for line in lines if line and not line.startswith("#")]
    if not names:
        raise DataError(f"{path}: names no unit; write one in each line")
    return names


def gather_units(places: Sequence[Path], *, expecting: bool, quiet: bool) -> tuple[list[Path], list[Path]]:
    """Collect logs and results. A folder with logs contributes its logs; a folder without logs, its results."""
    logs: list[Path] = []
    files: list[Path] = []
    for place in places:
        if place.suffix.lower() == ".json" and not place.is_dir():
            files.append(place)
            continue
        try:
            folder_logs, skipped = gather([place])
        except DataError:
            inside = _results(place)
            if not inside and not (expecting and place.is_dir() and os.access(place, os.R_OK)):
                raise
            files += inside
            continue
        logs += sorted(folder_logs, key=_by_number)
        if place.is_dir() and all(map(is_empty, folder_logs)):  # the records are missing; results may be there
            files += _results(place)
        for line in skipped_lines([file for file in skipped if file not in files]):
            say(line, quiet=quiet)
    for kind in (logs, files):
        twice = next((place for place in kind if kind.count(place) > 1), None)
        if twice is not None:
            raise OptionError(f"{twice} is given twice", option="units")
    return logs, files


def _results(folder: Path) -> list[Path]:
    """Results of units in a folder, in natural order."""
    inside = sorted(folder.glob("*.json"), key=_by_number) if folder.is_dir() else []
    return [file for file in inside if file.is_file() and not file.name.startswith(".") and _is_unit(file)]


def may_be_a_unit(file: Path) -> bool:
    """Whether a file of a pattern is a log or a result."""
    return file.suffix.lower() == ".json" or is_log(file)


def _is_unit(file: Path) -> bool:
    """Whether a JSON file is the result of a unit, not of a lot."""
    try:
        with file.open("rb") as stream:
            return re.match(rb'\s*\{\s*"lot":', stream.read(64)) is None
    except OSError:
        return True


def _by_number(path: Path) -> list[tuple[int, str]]:
    """Sort key by which unit 2 comes before unit 10."""
    return natural_order(str(path))
