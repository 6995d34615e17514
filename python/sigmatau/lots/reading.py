"""Results to compare, from files: JSON and CSV of analyze, and tables of values that were typed."""

from __future__ import annotations

import csv
import json
import math
import os
import re
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from sigmatau.errors import DataError
from sigmatau.lots.runs import LIMITED, OBSERVED, SIGNED, WITHOUT_ERROR, Run, RunsBuilder, RunTable, error_of, joined
from sigmatau.noise.terms import TERMS, coefficient_unit
from sigmatau.units import find

_FEW = 200  # files that one process reads in less time than others take to start
_LEVEL = 0.95  # of the CSV of analyze, which does not state it
_CURVES = "-curves.csv"
_QUANTITIES = {"gyro": ("angular_rate", "rad/s"), "accel": ("acceleration", "m/s^2")}

# The curves of the form that analyze writes: most of the file, and not compared. A line break cannot be inside a JSON
# string, so that the first closing brace with this indentation ends the object.
_BULK = re.compile(rb'\n   "(?:curve|stability)": \{\n(?:    .*\n)*?   \},')
_CURVE_UNIT = re.compile(rb'\n    "unit": ("[^"\\\n]*")')


def gather(places: Sequence[Path]) -> list[Path]:
    """The files; those of a folder and its subfolders sorted by name. Raises `DataError` for a folder without results."""
    found: list[Path] = []
    for place in places:
        if not place.is_dir():
            found.append(place)
            continue
        inside = sorted(
            (file for file in place.rglob("*") if file.suffix.lower() == ".json" and file.is_file()), key=_natural
        )
        named = {file.with_suffix("") for file in inside}
        tables = (file for file in sorted(place.rglob("*.csv"), key=_natural) if not file.name.endswith(_CURVES))
        inside += [file for file in tables if file.with_suffix("") not in named and _header(file) is not None]
        if not inside:
            raise DataError(
                f"{place}: no result in this folder; sigmatau analyze LOGS --json {place} writes them"
            )
        found += inside
    return found


def _natural(file: Path) -> list[tuple[int, str]]:
    """So that day 10 follows day 9."""
    return [(int(part), "") if part.isdecimal() else (-1, part) for part in re.split(r"(\d+)", str(file))]


def read_runs(files: Sequence[Path], *, jobs: int | None = None) -> RunTable:
    """The rows of all files; a file that cannot be used is a run with a problem."""
    workers = min(jobs or os.cpu_count() or 1, -(-len(files) // _FEW))
    if workers < 2:
        return _read(files)
    size = -(-len(files) // (4 * workers))
    parts = [files[at : at + size] for at in range(0, len(files), size)]
    with ProcessPoolExecutor(workers) as pool:
        return joined(list(pool.map(_read, parts)))


def _read(files: Sequence[Path]) -> RunTable:
    builder, tables = RunsBuilder(), []
    for file in files:
        try:
            if file.suffix.lower() == ".csv":
                own = RunsBuilder()
                _add_csv(own, file)
                tables.append(own.table())
            else:
                builder.add_result(_content(file), name=file.stem, place=str(file))
        except DataError as error:
            message = str(error)
            builder.add_run(
                Run(name=file.stem, serial="", place=str(file), problem=message.removeprefix(f"{file}: "))
            )
    return joined([builder.table(), *tables])


def _content(file: Path) -> dict[str, object]:
    try:
        data = file.read_bytes()
    except OSError as error:
        raise DataError(f"{file}: {error.strerror or error}") from None
    for text in (_without_bulk(data), data):
        try:
            content = json.loads(text.decode("utf-8-sig"))
        except (ValueError, RecursionError) as error:
            if text is data:
                raise DataError(f"{file}: not JSON: {error}") from None
            continue
        if isinstance(content, dict):
            return content
        raise DataError(f"{file}: not a result of sigmatau analyze: no channels")
    raise AssertionError


def _without_bulk(data: bytes) -> bytes:
    """The file without the points of its curves; of each curve its unit stays."""

    def kept(match: re.Match[bytes]) -> bytes:
        unit = _CURVE_UNIT.search(match[0])
        return b"" if unit is None or b'"curve"' not in match[0][:20] else b'\n   "curve": {"unit": ' + unit[1] + b"},"

    return _BULK.sub(kept, data)


def _header(file: Path) -> list[str] | None:
    """The columns of a table of coefficients; None for any other file."""
    try:
        with file.open(encoding="utf-8-sig", newline="") as stream:
            columns = [name.strip().lower() for name in next(csv.reader([stream.readline()]), [])]
    except (OSError, UnicodeDecodeError, csv.Error):
        return None
    return columns if {"channel", "term", "value"} <= set(columns) else None


def _add_csv(builder: RunsBuilder, file: Path) -> None:
    """A table of coefficients: of one run, as analyze writes it, or of several that a column names."""
    columns = _header(file)
    if columns is None:
        if not file.exists():
            raise DataError(f"{file}: No such file or directory")
        raise DataError(f"{file}: not a table of coefficients: columns channel, term and value are needed")
    run_column = next((name for name in ("run", "day", "test") if name in columns), None)
    serial_column = next((name for name in ("serial", "serial number", "device") if name in columns), None)
    runs: dict[tuple[str, str], int] = {}
    try:
        with file.open(encoding="utf-8-sig", newline="") as stream:
            rows = csv.reader(line for line in stream if line.strip() and not line.startswith("#"))
            next(rows)
            for number, cells in enumerate(rows, 2):
                row = {name: cell.strip() for name, cell in zip(columns, cells, strict=False)}
                name = row.get(run_column, "") if run_column else file.stem
                serial = row.get(serial_column, "") if serial_column else ""
                if (serial, name) not in runs:
                    runs[serial, name] = builder.add_run(Run(name=name, serial=serial, place=str(file), typed=run_column is not None))
                try:
                    _add_row(builder, runs[serial, name], row)
                except (DataError, ValueError, KeyError) as error:
                    what = f"{error} is missing" if isinstance(error, KeyError) else str(error)
                    raise DataError(f"{file}, row {number}: {what}") from None
    except OSError as error:
        raise DataError(f"{file}: {error.strerror or error}") from None
    except (UnicodeDecodeError, csv.Error) as error:
        raise DataError(f"{file}: not a table of coefficients: {error}") from None


_UNITS: dict[str, tuple[str, float]] = {}


def _unit(text: str) -> tuple[str, float]:
    """SI unit and factor of a unit; of one outside the table, itself."""
    if text not in _UNITS:
        try:
            unit = find(text)
            _UNITS[text] = unit.si, unit.factor
        except ValueError:
            _UNITS[text] = text, 1.0
    return _UNITS[text]


def _number(row: dict[str, str], name: str) -> float:
    text = row.get(name, "")
    if not text:
        return math.nan
    try:
        value = float(text)
    except ValueError:
        raise DataError(f"{name} {text!r} is not a number") from None
    if not math.isfinite(value):
        raise DataError(f"{name} {text!r} is not a finite number")
    return value


def _add_row(builder: RunsBuilder, run: int, row: dict[str, str]) -> None:
    term, channel = row["term"], row["channel"]
    if term not in TERMS:
        raise DataError(f"unknown term {term!r}; known: {', '.join(TERMS)}")
    quantity, rate_unit = _QUANTITIES.get(channel.partition("_")[0], ("signal", ""))
    si, factor = _unit(row["unit"])
    if quantity != "signal" and si != coefficient_unit(term, quantity, rate_unit):
        known = coefficient_unit(term, quantity, rate_unit)
        raise DataError(f"{row['unit']!r} is not a unit of {term} of {channel}; e.g. {known}")
    label = (channel, quantity, term, si, rate_unit)
    value, limit = _number(row, "value"), _number(row, "upper_limit")
    if math.isnan(value):
        if not math.isnan(limit):
            builder.add_row(run, label, LIMITED, limit=limit * factor)
        return
    signed = term in SIGNED
    if value <= 0 and not signed:
        raise DataError(f"value {value:g} must be positive")
    low, high, error, percent = (_number(row, name) for name in ("low", "high", "error", "error_percent"))
    delta = _number(row, "plus_minus")
    if not math.isnan(percent):
        error = abs(value) * percent / 100
    if not math.isnan(error):
        if error <= 0:
            raise DataError(f"error {error:g} must be positive; leave it empty if it is not known")
        found = error if not signed else error * factor
        found = found if signed else error / value
    elif not math.isnan(low) and not math.isnan(high):
        found = error_of(term, value, low, high, level=_LEVEL)
        found = found * factor if signed else found
    else:
        found = math.nan
    if row.get("verdict", "adequate") in ("descriptive", "too_short"):
        return
    status = WITHOUT_ERROR if math.isnan(found) else OBSERVED
    builder.add_row(run, label, status, value=value * factor, error=found, delta=delta * factor)
