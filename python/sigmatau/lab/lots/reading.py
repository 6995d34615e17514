"""Reads results to compare: JSON and CSV of analyze, and tables of typed values."""

from __future__ import annotations

import csv
import math
import os
import re
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from sigmatau.analysis import CoefficientsForm, read_result
from sigmatau.errors import DataError
from sigmatau.hints import Hint, command
from sigmatau.lab.lots.runs import (
    LEVEL,
    LIMITED,
    OBSERVED,
    SIGNED,
    WITHOUT_ERROR,
    ComparedRun,
    RunsBuilder,
    RunTable,
    joined,
    standard_error,
)
from sigmatau.noise.synonyms import unknown_term
from sigmatau.noise.terms import TERMS, coefficient_unit
from sigmatau.units import find, usual

_FILES_OF_ONE_PROCESS = 200  # number of files that one process reads before other processes would have started
_CURVES = "-curves.csv"
_QUANTITIES = {"gyro": ("angular_rate", "rad/s"), "accel": ("acceleration", "m/s^2")}


def gather(places: Sequence[Path], *, tables: bool = True) -> list[Path]:
    """Collect the files of results, those of each folder and its subfolders by name.

    With `tables`, tables of coefficients are included, unless the folder has a JSON of the same name.

    Raises `DataError` for a folder without results.
    """
    files: list[Path] = []
    for place in places:
        if not place.is_dir():
            files.append(place)
            continue
        # Hidden files are not results: a stopped run leaves unfinished files with such names.
        visible = (os.path.join(path, name) for path, _, names in os.walk(place) for name in names if name[0] != ".")  # noqa: PTH118  much faster
        inside = sorted(visible, key=natural_order)
        results = [file for file in inside if file[-5:].lower() == ".json" and Path(file).is_file()]
        stems = {file[:-5] for file in results}
        csv_files = (f for f in inside if tables and f[-4:].lower() == ".csv" and not f.endswith(_CURVES))
        results += [f for f in csv_files if f[:-4] not in stems and Path(f).is_file() and _header(Path(f)) is not None]
        if not results:
            raise DataError(
                f"{place}: no result in this folder; {command('analyze', 'LOGS', Hint('json', value=place))} writes them"
            )
        files += map(Path, results)
    return files


_DIGITS = re.compile(r"(\d+)")


def natural_order(file: str) -> list[tuple[int, str]]:
    """Sort key for natural order: day 10 follows day 9."""
    return [(int(part), "") if part.isdecimal() else (-1, part) for part in _DIGITS.split(file)]


def read_runs(files: Sequence[Path], *, jobs: int | None = None) -> RunTable:
    """Read the rows of all files. A file that cannot be used becomes a run with a problem."""
    workers = min(jobs or os.cpu_count() or 1, -(-len(files) // _FILES_OF_ONE_PROCESS))
    if workers < 2:
        return _read(files)
    size = -(-len(files) // (4 * workers))
    parts = [files[start : start + size] for start in range(0, len(files), size)]
    with ProcessPoolExecutor(workers) as pool:
        return joined(list(pool.map(_read, parts)))


def _read(files: Sequence[Path]) -> RunTable:
    builder = RunsBuilder()
    for file in files:
        try:
            if file.suffix.lower() == ".csv":
                with builder.whole():
                    _add_csv(builder, file)
            else:
                builder.add_result(read_result(file, as_form=CoefficientsForm), name=file.stem, place=str(file))
        except DataError as error:
            builder.add_run(ComparedRun(name=file.stem, serial="", place=str(file), problem=error.reason))
    return builder.table()


def _header(file: Path) -> list[str] | None:
    """The columns of a table of coefficients; None for any other file."""
    try:
        with file.open(encoding="utf-8-sig", newline="") as stream:
            first = stream.readline()
            columns = [name.strip().lower() for name in next(csv.reader([first], delimiter=_separator(first)), [])]
    except (OSError, UnicodeDecodeError, csv.Error):
        return None
    return columns if {"channel", "term", "value"} <= set(columns) else None


def _separator(line: str) -> str:
    """The separator of a table: a semicolon if decimals have a comma."""
    return ";" if ";" in line and "," not in line else ","


def _add_csv(builder: RunsBuilder, file: Path) -> None:
    """Read a table of coefficients: of one run, as analyze writes it, or of several runs that a column names."""
    columns = _header(file)
    if columns is None:
        if not file.exists():
            raise DataError("No such file or directory")
        raise DataError(
            f"not a table of coefficients: columns channel, term and value are needed;"
            f" a log must first be analysed: {command('analyze', 'LOG', Hint('json', value='RESULT.json'))}"
        )
    if "unit" not in columns:
        raise DataError("the column 'unit' is missing: the unit of each value")
    run_column = next((columns.index(name) for name in _RUN_COLUMNS if name in columns), None)
    serial_column = next((columns.index(name) for name in _SERIAL_COLUMNS if name in columns), None)
    runs: dict[tuple[str, str], int] = {}
    try:
        with file.open(encoding="utf-8-sig", newline="") as stream:
            separator = _separator(stream.readline())
            rows = csv.reader(stream, delimiter=separator)
            reader = _Rows(columns, decimal="," if separator == ";" else ".")
            for cells in rows:
                if not any(cells) or cells[0].startswith("#"):
                    continue
                cells += [""] * (len(columns) - len(cells))
                name = file.stem if run_column is None else cells[run_column].strip()
                serial = "" if serial_column is None else cells[serial_column].strip()
                if (serial, name) not in runs:
                    run = ComparedRun(name=name, serial=serial, place=str(file), typed=run_column is not None)
                    runs[serial, name] = builder.add_run(run)
                try:
                    reader.add(builder, runs[serial, name], name, cells)
                except DataError as error:
                    raise error.at(f"row {rows.line_num + 1}") from None
    except OSError as error:
        raise DataError(error.strerror or str(error)) from None
    except (UnicodeDecodeError, csv.Error) as error:
        raise DataError(f"not a table of coefficients: {error}") from None
    if not runs:
        raise DataError("has no rows below its header")


_RUN_COLUMNS = ("run", "day", "test")
_SERIAL_COLUMNS = ("serial", "serial number", "device")
_NUMBERS = ("value", "low", "high", "error", "error_percent", "upper_limit", "plus_minus")


class _Rows:
    """Reads the rows of a table with given columns."""

    def __init__(self, columns: Sequence[str], decimal: str) -> None:
        self._decimal = decimal
        self._key = tuple(columns.index(name) for name in ("channel", "term", "unit"))
        self._verdict = columns.index("verdict") if "verdict" in columns else None
        self._numbers = [columns.index(name) if name in columns else None for name in _NUMBERS]
        self._labels: dict[tuple[str, str, str], tuple[tuple[str, str, str, str, str], float]] = {}
        self._read_rows: set[tuple[int, str, str]] = set()

    def add(self, builder: RunsBuilder, run: int, name: str, cells: Sequence[str]) -> None:
        """Add a row of a run; raises `DataError`, also for a second row of the same run, channel and term."""
        key = (cells[self._key[0]].strip(), cells[self._key[1]].strip(), cells[self._key[2]].strip())
        if key not in self._labels:
            self._labels[key] = _label(*key)
        if (run, *key[:2]) in self._read_rows:
            raise DataError(f"a second row of {key[1]} of {key[0]} in the run {name!r}; name each run differently")
        self._read_rows.add((run, *key[:2]))
        label, factor = self._labels[key]
        value, low, high, error, percent, limit, delta = (
            math.nan
            if column is None or not cells[column]
            else _number(cells[column].replace(self._decimal, "."), name)
            for column, name in zip(self._numbers, _NUMBERS, strict=True)
        )
        if math.isnan(value):
            if not math.isnan(limit):
                builder.add_row(run, label, LIMITED, limit=limit * factor)
            return
        signed = label[2] in SIGNED
        if value <= 0 and not signed:
            raise DataError(f"value {value:g} must be positive")
        if self._verdict is not None and cells[self._verdict] in ("disturbed", "descriptive", "too_short"):
            return
        if not math.isnan(percent):
            error = abs(value) * percent / 100
        if not math.isnan(error):
            if error <= 0:
                raise DataError(f"error {error:g} must be positive; leave it empty if it is not known")
            spread = error if signed else error / value
        elif not math.isnan(low) and not math.isnan(high):
            spread = standard_error(label[2], value, low, high, level=LEVEL)
        else:
            spread = math.nan
        status = WITHOUT_ERROR if math.isnan(spread) else OBSERVED
        error = spread * factor if signed else spread
        builder.add_row(run, label, status, value=value * factor, error=error, delta=delta * factor)


def _label(channel: str, term: str, unit: str) -> tuple[tuple[str, str, str, str, str], float]:
    """Label of the rows of a channel and term, and the size of their unit in SI."""
    if term not in TERMS:
        raise DataError(unknown_term(term))
    quantity, rate_unit = _QUANTITIES.get(channel.partition("_")[0], ("signal", ""))
    try:
        known_unit = find(unit)
        si, factor = known_unit.si, known_unit.factor
    except ValueError:  # the unit of another signal
        si, factor = unit, 1.0
    if quantity != "signal" and si != coefficient_unit(term, quantity, rate_unit):
        raise DataError(
            f"{unit!r} is not a unit of {term} of {channel}; e.g. {usual(coefficient_unit(term, quantity, rate_unit))}"
        )
    return (channel, quantity, term, si, rate_unit), factor


def _number(text: str, name: str) -> float:
    try:
        value = float(text)
    except ValueError:
        if not text.strip():
            return math.nan
        raise DataError(f"{name} {text!r} is not a number") from None
    if not math.isfinite(value):
        raise DataError(f"{name} {text!r} is not a finite number")
    return value
