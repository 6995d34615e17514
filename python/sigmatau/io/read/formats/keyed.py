"""Text whose values have names: ``ax:0.01 ay=0.02`` of sketches for Arduino, and the YAML of ``ros2 topic echo``.

A record is one line, or several that repeat. The marks between names and values are replaced by spaces, so that compiled
code reads the records as a table of words and numbers. A record stands on the line where it begins, and blank lines follow
it, so that lines keep their numbers.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError
from sigmatau.io.read.formats.layout import Layout, is_number
from sigmatau.io.read.formats.text import Text
from sigmatau.io.read.names import SPELLED, unit_of
from sigmatau.io.read.table import Column, Head, Loaded, Table
from sigmatau.record import memory

_MARKS = b":=,;|{}[]()\"'<>\t\r"
_SPACES = bytes.maketrans(_MARKS, b" " * len(_MARKS))
_NUMBER = rb"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_PAIR = re.compile(rb"([A-Za-z_\xb0-\xff][^:=,;|\t\r\n\"{}]{0,60}?)[ \t]*[:=][ \t]*(" + _NUMBER + rb")(?![\d:])")
_MORE = re.compile(rb"(?:[ \t]*[,; \t][ \t]*" + _NUMBER + rb"(?![\w.:=]))+")
_IN_BRACKETS = re.compile(r"[\[(]([^\])]{1,20})[\])]")
_CLOCK = re.compile(rb"[ \t]*(\d{1,2}):(\d\d):(\d\d(?:[.,]\d+)?)[ \t]*(?:->)?[ \t]*(?=[A-Za-z])")
_GLUED = re.compile(rb"(?<=[0-9.])(?=(?![eE][-+0-9])[A-Za-z\xb0\xc2\xb5])")
_ANY_NUMBER = re.compile(rb"(?<![A-Za-z_\d.])" + _NUMBER + rb"(?![\w.])")
_WORDS_FOR_NUMBERS = re.compile(rb"[eE]|nan|inf|null|none", re.IGNORECASE)
_ONE_DIGIT = b"0123456789+-. "
_LINES = 400  # of the head in which records are looked for
_COMMENTS = (b"#", b"%", b"//")  # marks of lines that are not records
_LEAST_RECORDS = 3  # that must be alike
_LONGEST_RECORD = 12  # lines of a record that is not YAML
_DOCUMENT = b"\n---"
_LOST = re.compile(rb"A message was lost!!!\n(?:[ \t]+[^\n]*\n)*")
_SECONDS, _NANOSECONDS = ("sec", "secs"), ("nanosec", "nsec", "nsecs")
_AXES = ("x", "y", "z")
_ROS_UNITS = {"angular_velocity": "rad/s", "linear_acceleration": "m/s^2"}
_NAMED = 0.5  # smallest share of the numbers of a record that have names: an address within a table is not a name
_COPIES = 5  # of the file in memory while it is read


@dataclass(frozen=True, slots=True, kw_only=True)
class _Value:
    """A column: the words of a record whose sum, each with its weight, is its value."""

    name: str
    unit: str | None = None
    words: tuple[int, ...]  # counted from 0
    weights: tuple[int, ...] = (1,)

    @property
    def is_stamp(self) -> bool:
        """Whether it is seconds and nanoseconds."""
        return self.weights == (1_000_000_000, 1)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Records:
    """How the records of a text are written."""

    first_line: int  # of the first record, counted from 1
    words: int  # of a record
    values: tuple[_Value, ...]
    lines: int = 1  # of a record, blank ones not counted
    yaml: bool = False
    glued: bool = False  # Whether units follow their numbers without a space
    firsts: Mapping[int, str] = field(default_factory=dict)  # Word of the first record by place

    def layout(self) -> Layout:
        """The records as a table of words, each a column: that of a value has its name and unit."""
        alone = {value.words[0]: value for value in self.values if len(value.words) == 1}
        columns = tuple(
            Column(name=alone[k].name, unit=alone[k].unit, first=self.firsts.get(k, ""))
            if k in alone
            else Column(name=f"word {k + 1}")
            for k in range(self.words)
        )
        return Layout(delimiter=None, skip_lines=self.first_line - 1, columns=columns, notes=())


def in_words(text: bytes) -> bytes:
    """The text with spaces for the marks between names and values."""
    return text.translate(_SPACES)


def sniff(head: bytes, path: Path) -> bool:
    """Whether the text has records with names in them."""
    return find_records(head) is not None


def read(path: Path, head: Head) -> tuple[Table]:
    """The records as a table."""
    records = find_records(head.data)
    if records is None:
        raise DataError("changed while it was read")
    columns = tuple(
        Column(name=v.name, unit=v.unit, first=records.firsts.get(v.words[0], "") if len(v.words) == 1 else "")
        for v in records.values
    )
    table = _Loader(path=path, records=records)
    what = "YAML of ROS messages" if records.yaml else "text of names and values"
    several = f", {records.lines} lines a record" if records.lines > 1 and not records.yaml else ""
    return (
        Table(
            format="yaml" if records.yaml else "keyed",
            columns=columns,
            notes=(f"{what}{several}, from line {records.first_line}",),
            load=table.load,
            where=lambda row: f"record {row} (counted from 0)",
        ),
    )


def find_records(head: bytes) -> _Records | None:
    """How the records in the head of a text are written; None if it has none."""
    if b"\n---" in head and (records := _yaml_records(head)) is not None:
        return records
    lines = head.split(b"\n")[:_LINES]
    lines = lines[:-1] if len(lines) > 1 else lines
    skeletons = [_ANY_NUMBER.sub(b"#", _GLUED.sub(b" ", line)).strip() for line in lines]
    filled = [k for k, line in enumerate(lines) if line.strip() and not line.lstrip().startswith(_COMMENTS)]
    paired = [k for k in filled if _PAIR.search(lines[k])]
    if len(paired) < _LEAST_RECORDS or 2 * len(paired) < len(filled):
        return None
    # The last of the lines show what repeats: text above the records does not.
    tail = [(skeletons[k], k) for k in filled]
    for count in range(1, _LONGEST_RECORD + 1):
        cycle = [skeleton for skeleton, _ in tail[-count:]]
        alike = 0
        while (alike + 1) * count <= len(tail) and [
            s for s, _ in tail[len(tail) - (alike + 1) * count : len(tail) - alike * count]
        ] == cycle:
            alike += 1
        if alike >= _LEAST_RECORDS and any(_PAIR.search(lines[k]) for _, k in tail[-count:]):
            texts = [skeleton for skeleton, _ in tail]
            # Records above other lines are records too: what is between is damage, not a text above them.
            start = next(k for k in range(len(tail)) if texts[k : k + count] == cycle)
            if count > 1:
                start = _start_of_record(lines, tail, start, count)
            first = [k for _, k in tail[start : start + count]]
            return _pair_records([lines[k] for k in first], first[0] + 1, count)
    return None


def _start_of_record(lines: list[bytes], tail: list[tuple[bytes, int]], start: int, count: int) -> int:
    """The first line of a record of several lines: the one after a blank line, if there are blank lines among them."""
    for at in range(max(start - count + 1, 0), start + count):
        record = [skeleton for skeleton, _ in tail[at : at + count]]
        after = [k for _, k in tail[at + count : at + count + 1]]
        apart = bool(after) and not lines[after[0] - 1].strip()
        between = any(not lines[k - 1].strip() for _, k in tail[at + 1 : at + count])
        if record == [skeleton for skeleton, _ in tail[at + count : at + 2 * count]] and (apart or not between):
            return at
    return start


def _pair_records(record: list[bytes], first_line: int, count: int) -> _Records | None:
    glued = any(_GLUED.search(line) for line in record)
    values: list[_Value] = []
    place = 0
    firsts: dict[int, str] = {}
    for line in record:
        line = _GLUED.sub(b" ", line) if glued else line
        words = line.translate(_SPACES).split()
        firsts |= {place + k: word.decode("latin-1") for k, word in enumerate(words)}
        clock = _CLOCK.match(line)
        if clock:
            values.append(_Value(name="time", unit="s", words=(place, place + 1, place + 2), weights=(3600, 60, 1)))
        values += _values_of(line[clock.end() if clock else 0 :], place + (len(words) - _word_count(line, clock)))
        place += len(words)
    numbers = sum(map(is_number, firsts.values()))
    if not any(value.name for value in values) or sum(len(v.words) for v in values) < _NAMED * numbers:
        return None
    return _Records(first_line=first_line, words=place, values=tuple(values), lines=count, glued=glued, firsts=firsts)


def _word_count(line: bytes, clock: re.Match[bytes] | None) -> int:
    return len((line[clock.end() :] if clock else line).translate(_SPACES).split())


def _values_of(line: bytes, place: int) -> list[_Value]:
    """The named numbers of a line whose first word has this place."""
    values: list[_Value] = []
    stem, begun = "", 0
    for match in _PAIR.finditer(line):
        between = line[begun : match.start(2)].decode("utf-8", "replace")
        unit, name = _unit_and_name(between, after_value=bool(values))
        if values and unit:
            values[-1] = replace(values[-1], unit=unit)
        last = name.rsplit(None, 1)[-1].lower() if name else ""
        if last in _AXES and " " in name.strip():
            stem = name.rsplit(None, 1)[0]
        elif last in _AXES and stem:
            name = f"{stem} {name}"
        word = place + len(line[: match.start(2)].translate(_SPACES).split())
        bare, in_brackets = _without_brackets(name)
        more = _MORE.match(line, match.end(2))
        count = 1 + (len(re.findall(_NUMBER, more[0])) if more else 0)
        names = [bare] if count == 1 else [f"{bare}[{k}]" for k in range(count)]
        values += [_Value(name=n, unit=in_brackets or None, words=(word + k,)) for k, n in enumerate(names)]
        begun = more.end() if more else match.end(2)
    rest = line[begun:].decode("utf-8", "replace").strip(" \t\r,;|)]}")
    if values and rest and _is_unit(rest):
        values[-1] = replace(values[-1], unit=rest)
    return _same_units(values)


def _without_brackets(name: str) -> tuple[str, str]:
    """A name without the unit in brackets, and that unit; the unit is empty if there is none."""
    match = _IN_BRACKETS.search(name)
    if match is None or not _is_unit(match[1]):
        return name, ""
    return f"{name[: match.start()].rstrip()}{name[match.end() :]}".strip(), match[1]


def _unit_and_name(between: str, *, after_value: bool) -> tuple[str, str]:
    """The unit of the value before, and the name of the next one, from the text between both."""
    text = between.rstrip(" \t:=").strip(" \t\r")
    parts = [part.strip(" \t{}\"'").lstrip("([)]").lstrip() for part in re.split(r"[,;|\t]|\s{2,}", text)]
    if len(parts) > 1:
        return (parts[0] if after_value and _is_unit(parts[0]) else ""), parts[-1]
    words = parts[0].split()
    if after_value and len(words) > 1 and _is_unit(words[0]):
        return words[0], " ".join(words[1:])
    return "", parts[0]


def _is_unit(text: str) -> bool:
    return unit_of(Column(name="x", unit=text))[1] is not None or text.lower() in SPELLED


def _same_units(values: list[_Value]) -> list[_Value]:
    """The values with the unit behind the last axis of a sensor for its other axes."""
    units = {_stem(value.name): value.unit for value in values if value.unit}
    return [replace(v, unit=v.unit or units.get(_stem(v.name))) if _stem(v.name) else v for v in values]


def _stem(name: str) -> str:
    name = re.sub(r"\[([012])\]$", lambda match: _AXES[int(match[1])], name)
    return name[:-1].strip(" _.:").lower() if name[-1:].lower() in _AXES else ""


def _yaml_records(head: bytes) -> _Records | None:
    """The documents of a YAML text that are all alike, by the first whole one."""
    documents = _LOST.sub(b"", head).replace(b"\r", b"").split(_DOCUMENT)
    whole = [d for d in documents[:-1] if d.strip()]
    if len(whole) < _LEAST_RECORDS:
        return None  # a line of dashes above a table
    first = next((d for d in whole if b":" in d and len(d.translate(_SPACES).split()) == _typical(whole)), None)
    if first is None:
        return None
    # Above the first document there may be messages of the program.
    lines = head.replace(b"\r", b"").split(b"\n")
    names = _yaml_names(first.decode("utf-8", "replace"))
    if not names:
        return None
    words = [word.decode("latin-1") for word in first.translate(_SPACES).split()]
    return _Records(
        first_line=lines.index(first.lstrip(b"\n").split(b"\n")[0]) + 1,
        words=len(words),
        values=_joined_stamps(names),
        lines=first.strip(b"\n").count(b"\n") + 1,
        yaml=True,
        firsts=dict(enumerate(words)),
    )


def _typical(documents: list[bytes]) -> int:
    counts = [len(d.translate(_SPACES).split()) for d in documents]
    return max(set(counts), key=counts.count)


def _yaml_names(document: str) -> list[_Value]:
    """The numbers of a document with their paths, and the places of their words."""
    values: list[_Value] = []
    path: list[tuple[int, str]] = []  # indentation and name
    place, item = 0, 0
    for line in document.splitlines():
        text = line.strip()
        indent = len(line) - len(line.lstrip())
        if text.startswith("- "):
            number = text[2:].strip()
            if is_number(number):
                values.append(_Value(name=f"{_path(path)}[{item}]", words=(place + 1,)))
            item += 1
        elif ":" in text:
            name, _, rest = text.partition(":")
            while path and path[-1][0] >= indent:
                path.pop()
            path.append((indent, name.strip()))
            item, at = 0, place + len(name.translate(_SPACES_TEXT).split())
            inner = [part for part in re.split(r"[\[\],\s]+", rest) if part]
            for k, part in enumerate(inner):
                if is_number(part):
                    index = f"[{k}]" if "[" in rest else ""
                    values.append(_Value(name=f"{_path(path)}{index}", words=(at + k,)))
        place += len(text.translate(_SPACES_TEXT).split())
    return [replace(v, unit=_ROS_UNITS.get(v.name.split(".")[-2] if "." in v.name else "")) for v in values]


_SPACES_TEXT = str.maketrans(_MARKS.decode(), " " * len(_MARKS))


def _path(path: Sequence[tuple[int, str]]) -> str:
    return ".".join(name for _, name in path)


def _joined_stamps(values: list[_Value]) -> tuple[_Value, ...]:
    """The values with each pair of seconds and nanoseconds as one time in nanoseconds."""
    joined: list[_Value] = []
    for value in values:
        stem, _, name = value.name.rpartition(".")
        before = joined[-1] if joined else None
        if name in _NANOSECONDS and before and before.name in {f"{stem}.{s}" for s in _SECONDS}:
            joined[-1] = _Value(
                name=stem or "stamp", unit="ns", words=(before.words[0], value.words[0]), weights=(1_000_000_000, 1)
            )
        else:
            joined.append(value)
    return tuple(joined)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Loader:
    """The reading of the records of a file."""

    path: Path
    records: _Records

    def load(self, wanted: Sequence[int], exact: int | None) -> Loaded:
        """Columns of the records, each the sum of its words."""
        values = self.records.values
        words = sorted({word for k in wanted for word in values[k].words})
        text = self._text()
        alone = exact is not None and len(values[exact].words) == 1
        loaded = text.load(tuple(words), values[exact].words[0] if exact is not None and alone else None)
        rows = len(next(iter(loaded.columns.values())))
        if not self.records.yaml:
            self._refuse_other_names(text.source, rows)
        return replace(loaded, columns={k: _sum(values[k], loaded.columns) for k in wanted})

    def _text(self) -> Text:
        free = memory.available()
        if free is not None and _COPIES * self.path.stat().st_size > free:
            raise DataError("does not fit in memory; cut it, or record less")
        data = self.path.read_bytes()
        lines = self._yaml_lines(data) if self.records.yaml else self._pair_lines(data)
        return Text(source=lines, layout=self.records.layout(), encoding="ascii", gzip=False, dates={})

    def _pair_lines(self, data: bytes) -> bytes:
        """The text with spaces for marks, and each record on its first line."""
        if self.records.glued:
            data = _GLUED.sub(b" ", data)
        data = data.translate(_SPACES)
        count = self.records.lines
        if count == 1:
            return data
        lines = data.split(b"\n")
        at = [k for k in range(self.records.first_line - 1, len(lines)) if lines[k].strip()]
        for begin in range(0, len(at), count):
            own = at[begin : begin + count]
            lines[own[0]] = b" ".join(lines[k] for k in own)
            for k in own[1:]:
                lines[k] = b""
        return b"\n".join(lines)

    def _yaml_lines(self, data: bytes) -> bytes:
        if b"A message was lost!!!" in data:
            data = _LOST.sub(lambda match: b"\n" * match[0].count(b"\n"), data)
        above = self.records.first_line - 1
        data = b"\n" * above + b"\n".join(data.split(b"\n", above)[above:])
        documents = data.translate(_SPACES).split(_DOCUMENT)
        pieces = []
        for document in documents:
            body = document.lstrip(b" \n")
            lead = document[: len(document) - len(body)].count(b"\n")
            pieces.append(b"\n" * lead + body.replace(b"\n", b" ") + b"\n" * body.count(b"\n"))
        whole = b"\n".join(pieces[:-1])
        # Without the mark that follows it, the last document may be cut in its last number.
        return whole + b"\n" + pieces[-1].rstrip() if pieces[-1].strip() else whole + b"\n"

    def _refuse_other_names(self, source: Path | bytes, rows: int) -> None:
        """Raise `DataError` if a record has other names than the first."""
        if not isinstance(source, bytes):
            return
        lines = source.translate(None, _ONE_DIGIT).split(b"\n")[self.records.first_line - 1 :]
        filled = [line for line in lines if line][:rows]
        first = _WORDS_FOR_NUMBERS.sub(b"", filled[0])
        odd = {line for line in set(filled) if _WORDS_FOR_NUMBERS.sub(b"", line) != first}
        if odd:
            at = next(k for k, line in enumerate(lines) if line in odd)
            raise DataError(
                f", line {at + self.records.first_line}: other names than on line {self.records.first_line}"
                f" ({lines[at][:40].decode('latin-1')!r}); correct or delete the line"
            )


def _sum(value: _Value, columns: Mapping[int, NDArray[Any]]) -> NDArray[Any]:
    parts = [columns[word] for word in value.words]
    if len(parts) == 1:
        return parts[0]
    if not value.is_stamp:
        total = np.zeros(len(parts[0]))
        for part, weight in zip(parts, value.weights, strict=True):
            total += np.asarray(part, dtype=np.float64) * weight
        return total
    missing = np.isnan(parts[0]) | np.isnan(parts[1])
    seconds, nanoseconds = (np.where(missing, 0, part).astype(np.int64) for part in parts)
    return np.where(missing, np.iinfo(np.int64).min, seconds * value.weights[0] + nanoseconds)
