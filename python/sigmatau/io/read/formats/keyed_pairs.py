"""Records of names and numbers, ``ax:0.01 ay=0.02``: their names, units and clocks."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

from sigmatau.io.read.formats.keyed_records import MARKS, MIN_RECORDS, SPACES, Records, Value
from sigmatau.io.read.formats.text_lines import is_number
from sigmatau.io.read.names import SPELLED, split_unit
from sigmatau.io.read.table import Column

NUMBER = rb"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
PAIR = re.compile(rb"([A-Za-z_\xb0-\xff][^:=,;|\t\r\n\"{}]{0,60}?)[ \t]*[:=][ \t]*(" + NUMBER + rb")(?![\d:])")
_FURTHER = re.compile(rb"(?:[ \t]*[,; \t][ \t]*" + NUMBER + rb"(?![\w.:=]))+")
_IN_BRACKETS = re.compile(r"[\[(]([^\])]{1,20})[\])]")
_CLOCK = re.compile(rb"[ \t]*(\d{1,2}):(\d\d):(\d\d(?:[.,]\d+)?)[ \t]*(?:->)?[ \t]*(?=[A-Za-z])")
GLUED = re.compile(rb"(?<=[0-9.])(?=(?![eE][-+0-9])[A-Za-z\xb0\xc2\xb5])")
_AXES = ("x", "y", "z")
_NAMED = 0.5  # smallest share of the numbers of a record that have names: an address in a table is not a name


def find_start(lines: list[bytes], tail: list[tuple[bytes, int]], start: int, count: int) -> int:
    """Find the first line of a record of several lines: the line after a blank one, if blank lines separate the records."""
    for begin in range(max(start - count + 1, 0), start + count):
        record = [skeleton for skeleton, _ in tail[begin : begin + count]]
        after = [k for _, k in tail[begin + count : begin + count + 1]]
        apart = bool(after) and not lines[after[0] - 1].strip()
        between = any(not lines[k - 1].strip() for _, k in tail[begin + 1 : begin + count])
        if record == [skeleton for skeleton, _ in tail[begin + count : begin + 2 * count]] and (apart or not between):
            return begin
    return start


def pair_records(record: list[bytes], first_line: int, count: int) -> Records | None:
    """Find the layout of records whose first one has these lines; None if too few of its numbers have names."""
    glued = any(GLUED.search(line) for line in record)
    values: list[Value] = []
    place = 0
    firsts: dict[int, str] = {}
    for line in record:
        line = GLUED.sub(b" ", line) if glued else line
        words = line.translate(SPACES).split()
        firsts |= {place + k: word.decode("latin-1") for k, word in enumerate(words)}
        clock = _CLOCK.match(line)
        if clock:
            values.append(Value(name="time", unit="s", words=(place, place + 1, place + 2), weights=(3600, 60, 1)))
        values += _find_values(line[clock.end() if clock else 0 :], place + (len(words) - _word_count(line, clock)))
        place += len(words)
    numbers = sum(map(is_number, firsts.values()))
    if not any(value.name for value in values) or sum(len(v.words) for v in values) < _NAMED * numbers:
        return None
    return Records(first_line=first_line, words=place, values=tuple(values), lines=count, glued=glued, firsts=firsts)


def _word_count(line: bytes, clock: re.Match[bytes] | None) -> int:
    return len((line[clock.end() :] if clock else line).translate(SPACES).split())


def _find_values(line: bytes, place: int) -> list[Value]:
    """The named numbers of a line. `place` is that of its first word."""
    values: list[Value] = []
    stem, begun = "", 0
    for match in PAIR.finditer(line):
        between = line[begun : match.start(2)].decode("utf-8", "replace")
        unit, name = _unit_and_name(between, after_value=bool(values))
        if values and unit:
            values[-1] = replace(values[-1], unit=unit)
        last = name.rsplit(None, 1)[-1].lower() if name else ""
        if last in _AXES and " " in name.strip():
            stem = name.rsplit(None, 1)[0]
        elif last in _AXES and stem:
            name = f"{stem} {name}"
        word = place + len(line[: match.start(2)].translate(SPACES).split())
        bare, in_brackets = _without_brackets(name)
        further = _FURTHER.match(line, match.end(2))
        count = 1 + (len(re.findall(NUMBER, further[0])) if further else 0)
        names = [bare] if count == 1 else [f"{bare}[{k}]" for k in range(count)]
        values += [Value(name=n, unit=in_brackets or None, words=(word + k,)) for k, n in enumerate(names)]
        begun = further.end() if further else match.end(2)
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
    """Split the text between two values into the unit of the first and the name of the second."""
    text = between.rstrip(" \t:=").strip(" \t\r")
    parts = [part.strip(" \t{}\"'").lstrip("([)]").lstrip() for part in re.split(r"[,;|\t]|\s{2,}", text)]
    if len(parts) > 1:
        return (parts[0] if after_value and _is_unit(parts[0]) else ""), parts[-1]
    words = parts[0].split()
    if after_value and len(words) > 1 and _is_unit(words[0]):
        return words[0], " ".join(words[1:])
    return "", parts[0]


def _is_unit(text: str) -> bool:
    return split_unit(Column(name="x", unit=text))[1] is not None or text.lower() in SPELLED


def _same_units(values: list[Value]) -> list[Value]:
    """Copy the unit after the last axis of a sensor to its other axes."""
    units = {_stem(value.name): value.unit for value in values if value.unit}
    return [replace(v, unit=v.unit or units.get(_stem(v.name))) if _stem(v.name) else v for v in values]


def _stem(name: str) -> str:
    name = re.sub(r"\[([012])\]$", lambda match: _AXES[int(match[1])], name)
    return name[:-1].strip(" _.:").lower() if name[-1:].lower() in _AXES else ""


DOCUMENT = b"\n---"
LOST = re.compile(rb"A message was lost!!!\n(?:[ \t]+[^\n]*\n)*")
_SECONDS, _NANOSECONDS = ("sec", "secs"), ("nanosec", "nsec", "nsecs")
_ROS_UNITS = {"angular_velocity": "rad/s", "linear_acceleration": "m/s^2"}
_SPACES_TEXT = str.maketrans(MARKS.decode(), " " * len(MARKS))


def yaml_records(head: bytes) -> Records | None:
    """Find the layout of YAML documents that all have the names of the first complete one."""
    documents = LOST.sub(b"", head).replace(b"\r", b"").split(DOCUMENT)
    whole = [d for d in documents[:-1] if d.strip()]
    if len(whole) < MIN_RECORDS:
        return None  # a line of dashes above a table
    first = next((d for d in whole if b":" in d and len(d.translate(SPACES).split()) == _typical(whole)), None)
    if first is None:
        return None
    # Messages of the program may precede the first document.
    lines = head.replace(b"\r", b"").split(b"\n")
    names = _yaml_names(first.decode("utf-8", "replace"))
    if not names:
        return None
    words = [word.decode("latin-1") for word in first.translate(SPACES).split()]
    return Records(
        first_line=lines.index(first.lstrip(b"\n").split(b"\n")[0]) + 1,
        words=len(words),
        values=_joined_stamps(names),
        lines=first.strip(b"\n").count(b"\n") + 1,
        yaml=True,
        firsts=dict(enumerate(words)),
    )


def _typical(documents: list[bytes]) -> int:
    counts = [len(d.translate(SPACES).split()) for d in documents]
    return max(set(counts), key=counts.count)


def _yaml_names(document: str) -> list[Value]:
    """Paths of the numbers of a document, and the places of their words."""
    values: list[Value] = []
    path: list[tuple[int, str]] = []  # indentation and name
    place, item = 0, 0
    for line in document.splitlines():
        text = line.strip()
        indent = len(line) - len(line.lstrip())
        if text.startswith("- "):
            number = text[2:].strip()
            if is_number(number):
                values.append(Value(name=f"{_path(path)}[{item}]", words=(place + 1,)))
            item += 1
        elif ":" in text:
            name, _, rest = text.partition(":")
            while path and path[-1][0] >= indent:
                path.pop()
            path.append((indent, name.strip()))
            item, begin = 0, place + len(name.translate(_SPACES_TEXT).split())
            inner = [part for part in re.split(r"[\[\],\s]+", rest) if part]
            for k, part in enumerate(inner):
                if is_number(part):
                    index = f"[{k}]" if "[" in rest else ""
                    values.append(Value(name=f"{_path(path)}{index}", words=(begin + k,)))
        place += len(text.translate(_SPACES_TEXT).split())
    return [replace(v, unit=_ROS_UNITS.get(v.name.split(".")[-2] if "." in v.name else "")) for v in values]


def _path(path: Sequence[tuple[int, str]]) -> str:
    return ".".join(name for _, name in path)


def _joined_stamps(values: list[Value]) -> tuple[Value, ...]:
    """Join each pair of seconds and nanoseconds into one time in nanoseconds."""
    joined: list[Value] = []
    for value in values:
        stem, _, name = value.name.rpartition(".")
        before = joined[-1] if joined else None
        if name in _NANOSECONDS and before and before.name in {f"{stem}.{s}" for s in _SECONDS}:
            joined[-1] = Value(
                name=stem or "stamp", unit="ns", words=(before.words[0], value.words[0]), weights=(1_000_000_000, 1)
            )
        else:
            joined.append(value)
    return tuple(joined)
