"""Records in YAML, as ``ros2 topic echo`` writes them: one document each."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

from sigmatau.io.read.formats.keyed_records import LEAST_RECORDS, MARKS, SPACES, Records, Value
from sigmatau.io.read.formats.text_lines import is_number

DOCUMENT = b"\n---"
LOST = re.compile(rb"A message was lost!!!\n(?:[ \t]+[^\n]*\n)*")
_SECONDS, _NANOSECONDS = ("sec", "secs"), ("nanosec", "nsec", "nsecs")
_ROS_UNITS = {"angular_velocity": "rad/s", "linear_acceleration": "m/s^2"}
_SPACES_TEXT = str.maketrans(MARKS.decode(), " " * len(MARKS))


def yaml_records(head: bytes) -> Records | None:
    """The documents of a YAML text that are all alike, by the first whole one."""
    documents = LOST.sub(b"", head).replace(b"\r", b"").split(DOCUMENT)
    whole = [d for d in documents[:-1] if d.strip()]
    if len(whole) < LEAST_RECORDS:
        return None  # a line of dashes above a table
    first = next((d for d in whole if b":" in d and len(d.translate(SPACES).split()) == _typical(whole)), None)
    if first is None:
        return None
    # Above the first document there may be messages of the program.
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
    """The numbers of a document with their paths, and the places of their words."""
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
    """The values with each pair of seconds and nanoseconds as one time in nanoseconds."""
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
