"""The records of a text whose values have names: where a record begins, and which of its words are values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from sigmatau.io.read.formats.layout import Layout
from sigmatau.io.read.table import Column

MARKS = b":=,;|{}[]()\"'<>\t\r"
SPACES = bytes.maketrans(MARKS, b" " * len(MARKS))
LEAST_RECORDS = 3  # that must be alike


@dataclass(frozen=True, slots=True, kw_only=True)
class Value:
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
class Records:
    """How the records of a text are written."""

    first_line: int  # of the first record, counted from 1
    words: int  # of a record
    values: tuple[Value, ...]
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
    return text.translate(SPACES)
