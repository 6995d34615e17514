"""Translations of texts that other programs write: their rows are changed so that they can be read as table, names or JSON.

A translation keeps the number of lines, so that messages name the lines of the file. The last or the first lines of the
head determine the translation, so that ordinary logs take no time.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from sigmatau.frozen import frozen
from sigmatau.io.read.formats.damage import read_contents
from sigmatau.io.read.registry import find_text_reader
from sigmatau.io.read.table import HEAD, Head, Table

_COPIES = 4  # copies of the file in memory
_FIRST = 4096  # length of the beginning of the head by which a translation is chosen [bytes]
_LAST = 8192  # length of the end of the head by which a translation is chosen [bytes]
_NUMBER = rb"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_COLOUR = re.compile(rb"\x1b\[[0-9;?]*[A-Za-z]")
_RULE = re.compile(rb"^[ \t]*[|+]?[ \t]*:?-{2,}[-+|:= \t]*\r?$", re.MULTILINE)
_BORDER = re.compile(rb"^[ \t]*\|[ \t]*|[ \t]*\|[ \t]*(?=\r?$)", re.MULTILINE)
_BARS = re.compile(rb"[ \t]*\|[ \t]*")
_ROW_COUNT = re.compile(rb"^(?:\(\d+ rows?\)|\d+ rows? in set.*)(?=\r?$)", re.MULTILINE)
_D_EXPONENT = re.compile(rb"(?<=[\d.])[dD](?=[-+]\d{2,3}(?!\w))")
_THOUSANDS = re.compile(rb"(?<![\d.,])[-+]?\d{1,3}(?:,\d{3})+(?![\d,])")
_ATTRIBUTE = re.compile(rb"^@attribute\s+('[^']*'|\"[^\"]*\"|\S+)", re.IGNORECASE)
_LIST = re.compile(
    rb"([\w)])[ \t]*[=:]?[ \t]*[\[(][ \t]*(" + _NUMBER + rb"(?:[ \t]*,[ \t]*" + _NUMBER + rb")+)[ \t]*[\])]"
)
_LIST_FIELD = re.compile(rb"(?<=;)\[(" + _NUMBER + rb"(?:, ?" + _NUMBER + rb")+)\](?=\r?$)", re.MULTILINE)
_VECTOR = re.compile(
    rb"(?P<name>\w+)\s*[=:]?\s*\w*(?P<open>[({])\s*(?P<axes>x\s*[=:]\s*"
    + _NUMBER
    + rb"(?:\s*,?\s*[yz]\s*[=:]\s*"
    + _NUMBER
    + rb")+)\s*[)}]"
)
_UNITS_OF_GAZEBO = {b"angular_velocity": b" [rad/s]", b"linear_acceleration": b" [m/s^2]"}
_BRACE = re.compile(rb"^[ \t]*(?:\w+ \{|\}|\w+\((?=\w+=))[ \t]*", re.MULTILINE)  # a brace that contains other fields
_STAMP = re.compile(rb"\bstamp\s*\{(?P<parts>[^{}]*)\}")
_PART = re.compile(rb"(\w+)\s*[=:]\s*(" + _NUMBER + rb")")
_MESSAGE = re.compile(
    rb"^(?:(?P<clock>\d[^\n]{6,30}?): )?(?P<kind>[A-Z][A-Z0-9_]{2,}) \{(?P<fields>\w+ : [^\n]*)\}(?=\r?$)", re.MULTILINE
)
_KEY = re.compile(rb"(?:^|, )(\w+) : ")


@frozen(kw_only=False)
class _Translation:
    note: str
    applies: Callable[[bytes, bytes], bool]  # tests the first and the last lines of the head
    apply: Callable[[bytes], bytes]


def read_translated(path: Path, head: Head) -> tuple[Table, ...]:
    """Read the tables of a text that needs a translation; empty for other files."""
    last = head.data[-_LAST:]
    last = last[last.find(b"\n") + 1 : last.rfind(b"\n") + 1] if not head.whole or len(head.data) > _LAST else last
    chosen = [each for each in _TRANSLATIONS if each.applies(head.data[:_FIRST], last)]
    if not chosen or b"\0" in head.data:
        return ()
    contents = read_contents(path, head, copies=_COPIES)
    data = contents.data
    for each in chosen:
        data = each.apply(data)
    plain = Head(data=data[:HEAD], whole=len(data) <= HEAD, gzip=False)
    reader = find_text_reader(plain, path)
    if reader is None:
        return ()
    notes = tuple(each.note for each in chosen)
    tables = reader.read_tables(data, plain, path.name.split(".")[0])
    return tuple(replace(t, notes=(*notes, *t.notes), findings=(*t.findings, *contents.findings)) for t in tables)


def _on_most_lines(pattern: re.Pattern[bytes]) -> Callable[[bytes, bytes], bool]:
    """Whether most of the last lines match a pattern."""

    def applies(first: bytes, last: bytes) -> bool:
        lines = [line for line in last.split(b"\n") if line.strip()]
        return len(lines) > 1 and 2 * sum(pattern.search(line) is not None for line in lines) > len(lines)

    return applies


def _blank(text: bytes) -> bytes:
    """Keep only the line ends of a text."""
    return b"\n" * text.count(b"\n")


def _has_rule(first: bytes, last: bytes) -> bool:
    return b"|" in first and b"|" in last and _RULE.search(first) is not None


def _without_rules(data: bytes) -> bytes:
    """Replace the bars between cells, as databases print them, by tabs."""
    data = _BORDER.sub(b"", _ROW_COUNT.sub(b"", _RULE.sub(b"", data)))
    return _BARS.sub(b"\t", data)


def _has_thousands(first: bytes, last: bytes) -> bool:
    """Whether cells in quotes or between tabs and semicolons have commas between thousands, and others a decimal point."""
    cells = (
        re.findall(rb'"[^"\n]*"', last) or re.split(rb"[\t;\r\n]", last)
        if b"\t" in last or b";" in last or b'"' in last
        else []
    )
    bare = [cell.strip(b'" ') for cell in cells if b"," in cell]
    return (
        len(bare) > 1
        and all(_THOUSANDS.fullmatch(cell.split(b".")[0]) for cell in bare)
        and any(re.fullmatch(_NUMBER, cell.strip(b'" ')) and b"." in cell for cell in cells)
    )


def _without_thousands(data: bytes) -> bytes:
    inside = rb'"[^"\n]*"' if b'"' in data[:_FIRST] else rb"[^\n]+"
    return re.sub(inside, lambda quoted: _THOUSANDS.sub(lambda cell: cell[0].replace(b",", b""), quoted[0]), data)


def _name_attributes(data: bytes) -> bytes:
    """Replace the head of an ARFF file by a line of names."""
    head, _, rows = re.split(rb"(?im)^(@data[^\n]*)", data, maxsplit=1)
    names = [match[1].strip(b"'\"") for line in head.split(b"\n") if (match := _ATTRIBUTE.match(line.strip()))]
    return _blank(head) + b",".join(names) + rows.replace(b"?", b"nan")


def _lacks_row_name(first: bytes, last: bytes) -> bool:
    """Whether the first line has one name fewer than the rows, because rows begin with their numbers, as in R."""
    names, *rows = (line.split() for line in first.split(b"\n")[:4])
    numbers = [row[0].strip(b'"') for row in rows if len(row) == len(names) + 1]
    return (
        len(names) > 1
        and b"," not in first[:80]
        and numbers == [b"1", b"2", b"3"]
        and not re.fullmatch(_NUMBER, names[0])
    )


def _has_station(first: bytes, last: bytes) -> bool:
    return first.startswith(b'"TOA5"')


def _without_station(data: bytes) -> bytes:
    """Remove the lines of the station and of the processing from TOA5, and keep names and units."""
    _, names, units, _, rows = (*data.split(b"\n", 4), b"", b"", b"", b"")[:5]
    return b"\n".join([b"", names, units, b"", rows])


def _flatten(data: bytes) -> bytes:
    """Write vectors in braces or brackets as a name with three numbers, and a stamp as seconds."""

    def write_stamp(match: re.Match[bytes]) -> bytes:
        parts = dict(_PART.findall(match["parts"]))
        return b"stamp_s: %d.%09d" % (int(parts.get(b"sec", 0)), int(parts.get(b"nsec", 0))) + _blank(match[0])

    def write_vector(match: re.Match[bytes]) -> bytes:
        axes = dict(_PART.findall(match["axes"]))
        unit = _UNITS_OF_GAZEBO.get(match["name"], b"") if match["open"] == b"{" else b""
        return (
            match["name"]
            + unit
            + b": "
            + b" ".join(axes.get(axis, b"0") for axis in (b"x", b"y", b"z"))
            + _blank(match[0])
        )

    return _BRACE.sub(b"", _VECTOR.sub(write_vector, _STAMP.sub(write_stamp, data)))


def _as_json(data: bytes) -> bytes:
    """Convert MAVLink messages to JSON."""

    def write_message(match: re.Match[bytes]) -> bytes:
        fields = _KEY.sub(rb', "\1": ', match["fields"]).removeprefix(b", ")
        return b'{"message": "' + match["kind"] + b'", ' + re.sub(rb"\bnan\b", b"NaN", fields) + b"}"

    return _MESSAGE.sub(write_message, data)


_TRANSLATIONS = (
    _Translation(
        "colours of a terminal removed", lambda first, last: b"\x1b[" in first, lambda data: _COLOUR.sub(b"", data)
    ),
    _Translation("rows between bars", _has_rule, _without_rules),
    _Translation("exponents with D", _on_most_lines(_D_EXPONENT), lambda data: _D_EXPONENT.sub(b"E", data)),
    _Translation("commas between thousands removed", _has_thousands, _without_thousands),
    _Translation("ARFF", lambda first, last: re.search(rb"(?im)^@relation\b", first) is not None, _name_attributes),
    _Translation("row names of R", _lacks_row_name, lambda data: b"row " + data),
    _Translation("TOA5", _has_station, _without_station),
    _Translation("lists within brackets", _on_most_lines(_LIST), lambda data: _LIST.sub(rb"\1: \2", data)),
    _Translation(
        "lists within brackets",
        _on_most_lines(_LIST_FIELD),
        lambda data: _LIST_FIELD.sub(lambda match: match[1].replace(b",", b";"), data),
    ),
    _Translation(
        "vectors within braces",
        lambda first, last: _VECTOR.search(last) is not None and not last.lstrip().startswith((b'{"', b"{'")),
        _flatten,
    ),
    _Translation("dictionaries of Python", _on_most_lines(re.compile(rb"^\{'")), lambda data: data.replace(b"'", b'"')),
    _Translation("messages of MAVLink", _on_most_lines(_MESSAGE), _as_json),
)
