"""Text whose values have names: ``ax:0.01 ay=0.02`` of sketches for Arduino, and the YAML of ``ros2 topic echo``.

A record is one line, or a repeated group of lines. The marks between names and values are replaced by spaces, so that
compiled code reads the records as a table of words and numbers. A record is joined on its first line and followed by
blank lines, so that line numbers do not change.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError
from sigmatau.frozen import frozen
from sigmatau.io.read.formats.damage import read_contents
from sigmatau.io.read.formats.keyed_pairs import (
    DOCUMENT,
    GLUED,
    LOST,
    NUMBER,
    PAIR,
    find_start,
    pair_records,
    yaml_records,
)
from sigmatau.io.read.formats.keyed_records import MIN_RECORDS, SPACES, Records, Value
from sigmatau.io.read.formats.text_rows import Text
from sigmatau.io.read.table import Column, Head, Loaded, Table

_ANY_NUMBER = re.compile(rb"(?<![A-Za-z_\d.])" + NUMBER + rb"(?![\w.])")
_WORDS_FOR_NUMBERS = re.compile(rb"[eE]|nan|inf|null|none", re.IGNORECASE)
_ONE_DIGIT = b"0123456789+-. "
_LINES = 400  # lines of the head in which records are looked for
_COMMENTS = (b"#", b"%", b"//")  # marks of lines that are not records
_LONGEST_RECORD = 12  # lines of a record that is not YAML
_COPIES = 5  # copies of the file in memory while it is read


def sniff(head: bytes, path: Path) -> bool:
    """Whether the text has records with names in them."""
    return find_records(head) is not None


def read(path: Path, head: Head) -> tuple[Table, ...]:
    """The records as a table."""
    return read_tables(path, head, path.stem)


def read_tables(source: Path | bytes, head: Head, name: str, topic: str = "") -> tuple[Table, ...]:
    """The records of a file, or of text in memory, as a table of this topic."""
    records = find_records(head.data)
    if records is None:
        raise DataError("changed while it was read")
    columns = tuple(
        Column(name=v.name, unit=v.unit, first=records.firsts.get(v.words[0], "") if len(v.words) == 1 else "")
        for v in records.values
    )
    table = _Loader(source=source, head=head, records=records)
    what = "YAML of ROS messages" if records.yaml else "text of names and values"
    several = f", {records.lines} lines per record" if records.lines > 1 and not records.yaml else ""
    return (
        Table(
            format="yaml" if records.yaml else "keyed",
            columns=columns,
            notes=(*(("gzip",) if head.gzip else ()), f"{what}{several}, from line {records.first_line}"),
            load=table.load,
            where=lambda row: f"record {row} (counted from 0)",
            topic=topic,
        ),
    )


def find_records(head: bytes) -> Records | None:
    """Detect how the records in the head of a text are written; None if it has no records."""
    if b"\n---" in head and (records := yaml_records(head)) is not None:
        return records
    lines = head.split(b"\n")[:_LINES]
    lines = lines[:-1] if len(lines) > 1 else lines
    skeletons = [_ANY_NUMBER.sub(b"#", GLUED.sub(b" ", line)).strip() for line in lines]
    filled = [k for k, line in enumerate(lines) if line.strip() and not line.lstrip().startswith(_COMMENTS)]
    paired = [k for k in filled if PAIR.search(lines[k])]
    if len(paired) < MIN_RECORDS or 2 * len(paired) < len(filled):
        return None
    # The last lines show what repeats; text above the records does not.
    tail = [(skeletons[k], k) for k in filled]
    for count in range(1, _LONGEST_RECORD + 1):
        cycle = [skeleton for skeleton, _ in tail[-count:]]
        alike = 0
        while (alike + 1) * count <= len(tail) and [
            s for s, _ in tail[len(tail) - (alike + 1) * count : len(tail) - alike * count]
        ] == cycle:
            alike += 1
        if alike >= MIN_RECORDS and any(PAIR.search(lines[k]) for _, k in tail[-count:]):
            texts = [skeleton for skeleton, _ in tail]
            # Matching lines above these are records too. Other lines between records are damage, not text above the
            # table.
            start = next(k for k in range(len(tail)) if texts[k : k + count] == cycle)
            if count > 1:
                start = find_start(lines, tail, start, count)
            first = [k for _, k in tail[start : start + count]]
            return pair_records([lines[k] for k in first], first[0] + 1, count)
    return None


@frozen
class _Loader:
    """Reads the records of a file."""

    source: Path | bytes
    head: Head
    records: Records

    def load(self, wanted: Sequence[int], exact: int | None) -> Loaded:
        """Columns of the records. A value is the weighted sum of its words."""
        values = self.records.values
        words = sorted({word for k in wanted for word in values[k].words})
        contents = read_contents(self.source, self.head, copies=_COPIES)
        text = self._text(contents.data)
        alone = exact is not None and len(values[exact].words) == 1
        loaded = text.load(words, values[exact].words[0] if exact is not None and alone else None)
        rows = len(next(iter(loaded.columns.values())))
        if not self.records.yaml:
            self._refuse_other_names(text.source, rows)
        sums = {k: _sum(values[k], loaded.columns) for k in wanted}
        return replace(loaded, columns=sums, findings=(*loaded.findings, *contents.findings))

    def _text(self, data: bytes) -> Text:
        lines = self._yaml_lines(data) if self.records.yaml else self._pair_lines(data)
        return Text(source=lines, layout=self.records.layout(), encoding="ascii", gzip=False, dates={})

    def _pair_lines(self, data: bytes) -> bytes:
        """Replace the marks by spaces, and join each record on its first line."""
        if self.records.glued:
            data = GLUED.sub(b" ", data)
        data = data.translate(SPACES)
        count = self.records.lines
        if count == 1:
            return data
        lines = data.split(b"\n")
        filled = [k for k in range(self.records.first_line - 1, len(lines)) if lines[k].strip()]
        for begin in range(0, len(filled), count):
            record = filled[begin : begin + count]
            lines[record[0]] = b" ".join(lines[k] for k in record)
            for k in record[1:]:
                lines[k] = b""
        return b"\n".join(lines)

    def _yaml_lines(self, data: bytes) -> bytes:
        if b"A message was lost!!!" in data:
            data = LOST.sub(lambda match: b"\n" * match[0].count(b"\n"), data)
        above = self.records.first_line - 1
        data = b"\n" * above + b"\n".join(data.split(b"\n", above)[above:])
        documents = data.translate(SPACES).split(DOCUMENT)
        pieces = []
        for document in documents:
            body = document.lstrip(b" \n")
            lead = document[: len(document) - len(body)].count(b"\n")
            pieces.append(b"\n" * lead + body.replace(b"\n", b" ") + b"\n" * body.count(b"\n"))
        whole = b"\n".join(pieces[:-1])
        # The last document has no end mark, so its last number may be truncated.
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
            place = next(k for k, line in enumerate(lines) if line in odd)
            raise DataError(
                f"other names than on line {self.records.first_line}"
                f" ({lines[place][:40].decode('latin-1')!r}); correct or delete the line",
                place=f"line {place + self.records.first_line}",
            )


def _sum(value: Value, columns: Mapping[int, NDArray[Any]]) -> NDArray[Any]:
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
