"""Layout of the records of a text with named values: where a record begins, and which of its words are values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field

from sigmatau.frozen import frozen
from sigmatau.io.read.formats.layout import Layout
from sigmatau.io.read.table import Column

MARKS = b":=,;|{}[]()\"'<>\t\r"
SPACES = bytes.maketrans(MARKS, b" " * len(MARKS))
MIN_RECORDS = 3  # smallest number of records that must be alike


@frozen
class Value:
    """A column. Its value is the weighted sum of some words of a record."""

    name: str
    unit: str | None = None
    words: tuple[int, ...]  # positions of the words, counted from 0
    weights: tuple[int, ...] = (1,)

    @property
    def is_stamp(self) -> bool:
        """Whether the value is a time of seconds and nanoseconds."""
        return self.weights == (1_000_000_000, 1)


@frozen
class Records:
    """How the records of a text are written."""

    first_line: int  # first line of the first record, counted from 1
    words: int  # number of words of a record
    values: tuple[Value, ...]
    lines: int = 1  # number of lines of a record that are not blank
    yaml: bool = False
    glued: bool = False  # Whether units follow their numbers without a space
    # words of the first record by place, to recognise the beginning of records
    firsts: Mapping[int, str] = field(default_factory=dict)

    def layout(self) -> Layout:
        """Describe the records as a table of words. The column of a value has its name and unit."""
        alone = {value.words[0]: value for value in self.values if len(value.words) == 1}
        columns = tuple(
            Column(name=alone[k].name, unit=alone[k].unit, first=self.firsts.get(k, ""))
            if k in alone
            else Column(name=f"word {k + 1}")
            for k in range(self.words)
        )
        return Layout(delimiter=None, skip_lines=self.first_line - 1, columns=columns, notes=())


def in_words(text: bytes) -> bytes:
    """Replace the marks between names and values by spaces."""
    return text.translate(SPACES)
