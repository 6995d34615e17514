"""JSON: an object for each row, line by line or in an array; or one object of arrays. Nested fields are columns."""

from __future__ import annotations

import contextlib
import json
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError
from sigmatau.findings.finding import Finding
from sigmatau.findings.reading import Damaged, Place
from sigmatau.frozen import frozen
from sigmatau.io.read.formats import truncation
from sigmatau.io.read.formats.damage import fault, read_contents
from sigmatau.io.read.table import Column, Head, Loaded, Table
from sigmatau.io.read.time.dates import NO_STAMP, is_date, parse_stamps

_BOM = b"\xef\xbb\xbf"
_BLANK = re.compile(r"[\s,]*")
_OBJECT_LINE = re.compile(rb"^[ \t]*\{[ \t]*(?:\"|\})", re.MULTILINE)
_FIRST_ROWS = 100  # rows whose fields become the columns
# copies of the file in memory: a number of 8 characters becomes an object of 24 bytes and its place in a list
_COPIES = 12
_CHUNK = 1 << 16  # largest number of rows held as objects
_DEEPEST = 8  # largest depth of nested fields
_LONGEST_ARRAY = 64  # longest array in a field whose numbers become columns
_RESULT = b'"sigmatau":'

_Path = tuple[str | int, ...]


def sniff(head: bytes, path: Path) -> bool:
    """Whether the file contains JSON rows or one object of arrays, and is not a result of this package."""
    start = head.removeprefix(_BOM).lstrip()
    if _RESULT in start[:200] or truncation.BREAK.search(head[:200]):
        return False
    if start.startswith((b"{", b"[")):
        return re.match(rb"[{\[]\s*(?:[\"{\[}]|-?\d)", start) is not None
    return len(_OBJECT_LINE.findall(head)) >= 2


def read(path: Path, head: Head) -> tuple[Table]:
    """The rows as a table, whose columns are the fields of the first rows."""
    return read_tables(path, head, path.stem)


def read_tables(source: Path | bytes, head: Head, name: str, topic: str = "") -> tuple[Table]:
    """The rows of a file, or of text in memory, as a table of this topic."""
    contents = read_contents(source, head, copies=_COPIES)
    text = contents.data.removeprefix(_BOM).decode("utf-8", errors="replace")
    whole = _whole(text)
    findings: tuple[Finding, ...] = ()
    if isinstance(whole, Mapping) and (arrays := dict(_columns_of_arrays(whole))):
        columns, form = arrays, "an object of arrays"
    else:
        form = "an array of rows" if text.lstrip().startswith("[") else "an object for each row"
        columns, findings = _find_columns(text) if whole is None else (_collect_fields(_find_rows(whole)), findings)
    if not columns:
        raise DataError("is JSON without rows of numbers: an object for each row, or an object of arrays, is needed")
    fields = list(columns.values())

    def load(wanted: Sequence[int], exact: int | None) -> Loaded:
        columns = {k: fields[k].numbers(exact=k == exact) for k in wanted}
        return Loaded(columns=columns, findings=(*findings, *contents.findings))

    return (
        Table(
            format="json",
            columns=tuple(field.column() for field in fields),
            notes=(*(("gzip",) if head.gzip else ()), f"JSON, {form}"),
            load=load,
            rows=len(fields[0].values),
            topic=topic,
            words={field.name: field.words for field in fields if field.has_words()},
        ),
    )


@frozen(kw_only=False)
class _JsonField:
    """The values of one field in all rows."""

    name: str
    values: NDArray[Any]  # float64 or int64 if all are numbers; else objects: None, numbers and words

    def column(self) -> Column:
        """The column, with its first value."""
        first = str(self.values[0])[:40] if len(self.values) and self.values[0] is not None else ""
        return Column(name=self.name, unit="ns" if is_date(first) else None, first=first)

    def has_words(self) -> bool:
        """Whether its first values are words, rather than dates or quoted numbers."""
        words = [value for value in self.values[:_FIRST_ROWS] if isinstance(value, str)]
        return bool(words) and not any(is_date(word) or _is_number(word) for word in words)

    def words(self) -> NDArray[Any]:
        """Its values as words; a blank where a row has none."""
        return np.array([value if isinstance(value, str) else " " for value in self.values])

    def numbers(self, *, exact: bool) -> NDArray[Any]:
        """Its values as numbers, NaN where a row has none; dates as nanoseconds since 1970."""
        if self.values.dtype.kind == "i":
            return self.values if exact else self.values.astype(np.float64)
        if self.values.dtype.kind == "f":
            return self.values
        if isinstance(self.values[0], str) and is_date(self.values[0]):
            times = parse_stamps(self.name, self.values.tolist())
            return times if exact else np.where(times == NO_STAMP, np.nan, times.astype(np.float64))
        try:
            return np.array([np.nan if value is None else value for value in self.values], dtype=np.float64)
        except (ValueError, TypeError, OverflowError):
            row = next(k for k, value in enumerate(self.values) if not _is_number(value))
            raise DataError(
                f"field {self.name} has {str(self.values[row])[:40]!r}, which is not a"
                " number; correct or delete the row",
                place=f"row {row} (counted from 0)",
            ) from None


def _packed(values: list[Any]) -> NDArray[Any]:
    """Values of a field as an array of integers, of floats, or of objects."""
    kinds = set(map(type, values))
    if kinds == {int} and max(map(abs, values)) < 1 << 62:
        return np.array(values, dtype=np.int64)
    if kinds <= {int, float}:
        with contextlib.suppress(OverflowError):
            return np.array(values, dtype=np.float64)
    packed = np.empty(len(values), dtype=object)
    packed[:] = values
    return packed


def _collect_fields(rows: Sequence[Any]) -> dict[_Path, _JsonField]:
    """The fields of rows."""
    return _joined([_parts(rows, _paths(rows))])


def _paths(rows: Sequence[Any]) -> list[_Path]:
    """The paths of the fields, in order: those of the first rows, and of the first row of each kind with other names."""
    later = {tuple(row): row for row in reversed(rows[_FIRST_ROWS:]) if isinstance(row, Mapping)}
    return list(
        dict.fromkeys(path for row in (*rows[:_FIRST_ROWS], *reversed(later.values())) for path, _ in _fields(row))
    )


def _parts(rows: Sequence[Any], paths: Sequence[_Path]) -> dict[_Path, NDArray[Any]]:
    return {path: _packed([_value(row, path) for row in rows]) for path in paths}


def _joined(parts: Sequence[Mapping[_Path, NDArray[Any]]]) -> dict[_Path, _JsonField]:
    """Join the parts of the fields, as integers only if all parts are integers; NaN for a part without the field."""
    fields = {}
    for path in dict.fromkeys(path for part in parts for path in part):
        arrays = [
            part[path] if path in part else np.full(len(next(iter(part.values()))), np.nan) for part in parts if part
        ]
        kinds = {array.dtype.kind for array in arrays}
        common = object if "O" in kinds else np.float64 if "f" in kinds else np.int64
        fields[path] = _JsonField(_name(path), np.concatenate([array.astype(common) for array in arrays]))
    return fields


def _fields(row: object, path: _Path = ()) -> Iterator[tuple[_Path, Any]]:
    """Walk the numbers and words of a row, with the path of names of each."""
    if isinstance(row, Mapping) and len(path) < _DEEPEST:
        for name, value in row.items():
            yield from _fields(value, (*path, name))
    elif isinstance(row, list) and len(path) < _DEEPEST:
        if len(row) <= _LONGEST_ARRAY:
            for index, value in enumerate(row):
                yield from _fields(value, (*path, index))
    elif row is None or isinstance(row, int | float | str):
        yield path, row


def _name(path: _Path) -> str:
    """Column name of a path: ``imu.gyro.x``. `sigmatau.io.read.names` reads ``[0]`` of an array of three as x."""
    return "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in path).removeprefix(".")


def _whole(text: str) -> Any:  # noqa: ANN401
    """Parse a text that is one object or array; None if it has several, or is truncated."""
    start = _BLANK.match(text)
    first = text[start.end() if start else 0 :][:1]
    end = text.rstrip()[-1:]
    if first not in "{[" or not first or end != {"{": "}", "[": "]"}[first]:
        return None
    if first == "{" and re.search(r"\}\s*\{", text[: 1 << 16]):
        return None  # an object for each row
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        return None


def _find_rows(whole: object) -> list[Any]:
    """The rows in an array, or in the only array of objects within an object."""
    if isinstance(whole, list):
        return whole
    nested = [v for v in whole.values() if _has_objects(v)] if isinstance(whole, Mapping) else []
    return nested[0] if len(nested) == 1 else []


def _has_objects(value: object) -> bool:
    return isinstance(value, list) and bool(value) and isinstance(value[0], Mapping)


def _arrays(whole: Mapping[str, Any], path: _Path = ()) -> Iterator[tuple[_Path, list[Any]]]:
    for name, value in whole.items():
        if isinstance(value, list):
            yield (*path, name), value
        elif isinstance(value, Mapping) and len(path) < _DEEPEST:
            yield from _arrays(value, (*path, name))


def _columns_of_arrays(whole: Mapping[str, Any]) -> Iterator[tuple[_Path, _JsonField]]:
    """The fields of an object of arrays of one length. In rows of numbers each position is a field."""
    arrays = dict(_arrays(whole))
    lengths = [len(array) for array in arrays.values() if not _has_objects(array)]
    rows = _find_rows(whole)
    if rows and len(rows) >= max(lengths, default=0):
        yield from _collect_fields(rows).items()
        return
    if not lengths:
        return
    count = max(set(lengths), key=lambda length: (lengths.count(length), length))
    for path, array in arrays.items():
        if len(array) != count or _has_objects(array):
            continue
        if isinstance(array[0], list):
            width = min(len(array[0]), _LONGEST_ARRAY)
            for k in range(width):
                yield (*path, k), _JsonField(_name((*path, k)), _packed([_value(row, (k,)) for row in array]))
        else:
            yield path, _JsonField(_name(path), _packed(array))


def _first_object(text: str) -> int:
    """Offset of the first row, after the bracket of an array or after lines of text."""
    match = re.search(r"^[ \t]*\[?\s*(?=[\[{])|^[ \t]*(?=\{)", text, re.MULTILINE)
    return match.end() if match else len(text)


def _find_columns(text: str) -> tuple[dict[_Path, _JsonField], tuple[Finding, ...]]:
    """Read the fields of rows up to the end or up to damage. Damage is a finding if it ends the file or is not text."""
    rows: list[Any] = []
    parts: list[dict[_Path, NDArray[Any]]] = []
    begin = _first_object(text)
    decode, blank = json.JSONDecoder().raw_decode, _BLANK.match
    size, count = len(text), 0
    findings: tuple[Finding, ...] = ()
    garbled = text.find("�")  # bytes that are not text may stand within a name
    try:
        while begin < size:
            row, end = decode(text, begin)
            if count and begin <= garbled < end:
                raise ValueError
            rows.append(row)
            count += 1
            if len(rows) == _CHUNK:
                parts.append(_parts(rows, _paths(rows)))
                rows = []
            gap = blank(text, end)
            begin = gap.end() if gap else end
            if text[begin : begin + 1] == "]":
                findings = _trailing(text, begin + 1, count)
                break
    except (ValueError, RecursionError):
        line = text.count("\n", 0, begin) + 1
        after = text.find("\n", begin)
        last = after < 0 or not text[after:].strip()
        damaged = (
            "�" in text[begin : begin + 4096]
            or truncation.BREAK.search(text[begin : begin + 4096].encode()) is not None
        )
        if not count:
            raise DataError("is not JSON; correct or delete the line", place=f"line {line}") from None
        if not last and not damaged and not _is_cut(text, begin):
            raise DataError(
                f"{text[begin : begin + 40].strip()!r} is not JSON; correct or delete the line",
                place=f"line {line}",
            ) from None
        reason = "bytes that are not text" if damaged else ""
        place = Place("line", line)
        details = Damaged(truncated=not damaged, place=place, reason=reason, kept=count)
        findings = (Finding(details=details, severity="error"),)
    if rows:
        parts.append(_parts(rows, _paths(rows)))
    return _joined(parts), findings


def _is_cut(text: str, begin: int) -> bool:
    """Whether the object that begins here is incomplete, and no later line begins another one."""
    return re.search(r"\n[ \t]*\{", text[begin + 1 :]) is None


def _trailing(text: str, begin: int, rows: int) -> tuple[Finding, ...]:
    """A finding about text after the end of an array."""
    if not text[begin:].strip(" \t\r\n\0"):
        return ()
    return (
        fault(place=Place("line", text.count("\n", 0, begin) + 1), reason="text after the end of the array", kept=rows),
    )


def _value(row: object, path: _Path) -> Any:  # noqa: ANN401
    value: Any = row
    try:
        for part in path:
            value = value[part]
    except (KeyError, IndexError, TypeError):
        return None
    return value


def _is_number(value: object) -> bool:
    if value is None:
        return True
    try:
        float(value)  # type: ignore[arg-type]
    except (ValueError, TypeError, OverflowError):
        return False
    return True
