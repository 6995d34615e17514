"""Kinds of findings about files: damage, leftovers, columns, units.

In all of them `kept` is the number of rows or messages that are read, `count` is the number of what was found, and `topic`
is the topic, sentence or group that is read. Lines and columns count from 1, bytes from 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from sigmatau.findings.finding import Details

__all__ = [
    "BrokenLines",
    "BrokenMessages",
    "BrokenOff",
    "BytesBetween",
    "BytesNotRead",
    "ColumnsByGravity",
    "ColumnsNotRead",
    "Comments",
    "Damage",
    "Damaged",
    "DeletedMessages",
    "Filler",
    "HeaderAgain",
    "HiddenRows",
    "InFile",
    "LoggerDropouts",
    "MissingSamples",
    "NeverWritten",
    "NoEndMark",
    "NoLineEnd",
    "OtherSentences",
    "PartMissing",
    "PartOfSeveral",
    "Place",
    "PropertyChanged",
    "SecondHeader",
    "UnequalLengths",
    "UnfinishedMessage",
    "UnitOverruled",
    "UnknownMessages",
    "Unusable",
]


@dataclass(frozen=True, slots=True)
class Place:
    """A place in a file.

    Attributes
    ----------
    unit : str
        What is counted: ``"byte"``, ``"line"``, ``"row"``, ``"message"``, ``"batch"``, ``"row group"`` or ``"segment"``.
        Bytes and rows count from 0, the others from 1.
    number : int
    of : int or None
        How many of them the file has.
    byte : int or None
        Where the unit begins. [bytes]
    """

    unit: str
    number: int
    of: int | None = None
    byte: int | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class InFile(Details):
    """Base of findings about a file.

    Attributes
    ----------
    part : str
        Name of the file, if the log is split into several.
    """

    part: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Damage(InFile):
    """Base of findings about damage after which the file is not read further.

    Attributes
    ----------
    what : str
        What is damaged: ``"file"``, ``"array"``, ``"variable acc"`` …
    place : Place or None
    inside : str
        What the place lies in: ``"message"``, ``"line"``, ``"row"``, ``"number"``; empty if that is not known.
    reason : str
        The fault, as the decoder or a library calls it; may be empty.
    got, expected : int or None
        How many of the bytes, rows or samples are there, and how many should be.
    measured : str
        What `got` and `expected` count.
    kept : int or None
        How many rows or messages are read.
    declared : int or None
        How many the file declares.
    counted : str
        What `kept` and `declared` count.
    topic : str
    """

    what: str = "file"
    place: Place | None = None
    inside: str = ""
    reason: str = ""
    got: int | None = None
    expected: int | None = None
    measured: str = "bytes"
    kept: int | None = None
    declared: int | None = None
    counted: str = "rows"
    topic: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Damaged(Damage):
    """A file that is damaged at a place, and is read up to it."""

    code: ClassVar[str] = "damaged"


@dataclass(frozen=True, slots=True, kw_only=True)
class BrokenOff(Damage):
    """A file that ends too early."""

    code: ClassVar[str] = "broken_off"


@dataclass(frozen=True, slots=True, kw_only=True)
class NoEndMark(Damage):
    """A stream that ends between two batches, without its end mark."""

    code: ClassVar[str] = "no_end_mark"


@dataclass(frozen=True, slots=True, kw_only=True)
class PartMissing(InFile):
    """A file of a split log that is missing, or cannot be read for a `reason`; `number` counts from 1."""

    code: ClassVar[str] = "part_missing"
    number: int
    of: int
    reason: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class PartOfSeveral(InFile):
    """A file that is one part of a split log; `number` counts from 1."""

    code: ClassVar[str] = "part_of_several"
    number: int
    of: int


@dataclass(frozen=True, slots=True, kw_only=True)
class BrokenMessages(InFile):
    """Messages with a wrong checksum, which are left out; `places` are the offsets of the first of them. [bytes]"""

    code: ClassVar[str] = "broken_messages"
    count: int
    places: tuple[int, ...]
    kept: int


@dataclass(frozen=True, slots=True, kw_only=True)
class BytesBetween(InFile):
    """Bytes that belong to no whole message: their number, in `count` places, the first at `place`."""

    code: ClassVar[str] = "bytes_between"
    bytes: int
    count: int
    place: Place
    kept: int


@dataclass(frozen=True, slots=True, kw_only=True)
class BrokenLines(InFile):
    """Lines with a wrong checksum or form, which are left out.

    Attributes
    ----------
    inner : int
        Number of them that stand between two rows.
    examples : tuple of (int, str)
        The first lines, and what is wrong with each.
    """

    code: ClassVar[str] = "broken_lines"
    count: int
    inner: int
    examples: tuple[tuple[int, str], ...]
    kept: int
    topic: str


@dataclass(frozen=True, slots=True, kw_only=True)
class OtherSentences(InFile):
    """Sentences of other names, which are not read.

    Attributes
    ----------
    example : str
        One of the names.
    line, run : int or None
        First line and length of the longest run of other sentences, if the sensor was switched to them.
    """

    code: ClassVar[str] = "other_sentences"
    count: int
    example: str
    topic: str
    line: int | None = None
    run: int | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class _Leftover(InFile):
    """Bytes outside of what is read: their number, and where they begin.

    Attributes
    ----------
    after : str
        What ends there: ``"the array"``; empty if they precede what is read.
    """

    bytes: int
    place: Place
    after: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class BytesNotRead(_Leftover):
    """Bytes before or after the contents, possibly of another log."""

    code: ClassVar[str] = "bytes_not_read"


@dataclass(frozen=True, slots=True, kw_only=True)
class Filler(_Leftover):
    """Bytes of one `value`, 0 or 255, after the contents."""

    code: ClassVar[str] = "filler"
    value: int


@dataclass(frozen=True, slots=True, kw_only=True)
class _LinesBetween(InFile):
    """Lines among the rows of a text table; `line` is the first of them."""

    line: int
    count: int = 1


@dataclass(frozen=True, slots=True, kw_only=True)
class HiddenRows(_LinesBetween):
    """Rows behind a comment mark, which are left out."""

    code: ClassVar[str] = "hidden_rows"


@dataclass(frozen=True, slots=True, kw_only=True)
class Comments(_LinesBetween):
    """Comments, which are skipped."""

    code: ClassVar[str] = "comments"


@dataclass(frozen=True, slots=True, kw_only=True)
class HeaderAgain(_LinesBetween):
    """The header once more."""

    code: ClassVar[str] = "header_again"


@dataclass(frozen=True, slots=True, kw_only=True)
class SecondHeader(_LinesBetween):
    """A header that names other columns; only the rows before it are read."""

    code: ClassVar[str] = "second_header"
    kept: int


@dataclass(frozen=True, slots=True, kw_only=True)
class NoLineEnd(InFile):
    """A last line without a line end, which is left out."""

    code: ClassVar[str] = "no_line_end"


@dataclass(frozen=True, slots=True, kw_only=True)
class NeverWritten(InFile):
    """Zeros at the end of a preallocated file.

    Attributes
    ----------
    rows, zeros : int
        Number of all rows, and of the rows at the end that are zero. The row before them is left out too.
    column : str
        The column that is zero; empty for all columns.
    is_time : bool
        Whether that is the time column.
    """

    code: ClassVar[str] = "never_written"
    rows: int
    zeros: int
    kept: int
    column: str = ""
    is_time: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class ColumnsNotRead(InFile):
    """Columns of a log in this package's own form that are not the sensors'.

    Attributes
    ----------
    columns : tuple of str
    channels : tuple of (str, int)
        Channels and their columns that would read the first of them too.
    as_rates : bool
        Whether ``--input rate`` is needed with them.
    """

    code: ClassVar[str] = "columns_not_read"
    columns: tuple[str, ...]
    channels: tuple[tuple[str, int], ...]
    as_rates: bool = False
    topic: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class ColumnsByGravity(InFile):
    """Columns without names, whose accelerometers are detected by gravity.

    Attributes
    ----------
    gyro, accel : tuple of (int, int)
        First and last column.
    time : int or None
        The time column.
    gravity, other : float
        Size of the mean of the accelerometer's and of the gyro's columns, in the units of the file.
    """

    code: ClassVar[str] = "columns_by_gravity"
    gyro: tuple[int, int]
    accel: tuple[int, int]
    time: int | None
    gravity: float
    other: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Unusable(InFile):
    """A table that cannot be read; `reason` is the text of the error."""

    code: ClassVar[str] = "unusable"
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class UnknownMessages(InFile):
    """Messages of unknown kinds, which are skipped."""

    code: ClassVar[str] = "unknown_messages"
    count: int


@dataclass(frozen=True, slots=True, kw_only=True)
class UnfinishedMessage(InFile):
    """A message of some bytes that was not finished before data were appended."""

    code: ClassVar[str] = "unfinished_message"
    place: Place
    bytes: int


@dataclass(frozen=True, slots=True, kw_only=True)
class DeletedMessages(InFile):
    """Messages of all topics that were deleted from an intact database."""

    code: ClassVar[str] = "deleted_messages"
    count: int
    topic: str


@dataclass(frozen=True, slots=True, kw_only=True)
class PropertyChanged(InFile):
    """A property of channels that changes from `old` to `new`; only the rows before are read."""

    code: ClassVar[str] = "property_changed"
    topic: str
    name: str
    old: str | float
    new: str | float
    kept: int


@dataclass(frozen=True, slots=True, kw_only=True)
class UnequalLengths(InFile):
    """Axes of one sensor with unequal numbers of samples; `lengths` are pairs of array and number."""

    code: ClassVar[str] = "unequal_lengths"
    lengths: tuple[tuple[str, int], ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class MissingSamples(InFile):
    """Samples that have the value `fill`, by which the file marks missing ones."""

    code: ClassVar[str] = "missing_samples"
    column: str
    count: int
    fill: float


@dataclass(frozen=True, slots=True, kw_only=True)
class LoggerDropouts(InFile):
    """Times when the logger lost data, as it reports: number, total duration and longest one. [s]"""

    code: ClassVar[str] = "dropouts"
    count: int
    total: float
    longest: float


@dataclass(frozen=True, slots=True, kw_only=True)
class UnitOverruled(InFile):
    """A unit given by the user that differs from the one that the file states.

    Attributes
    ----------
    given, stated : str
    known : bool
        Whether the unit stated is a known unit of the quantity.
    scaled : bool
        Whether a scale is given.
    """

    code: ClassVar[str] = "unit_overruled"
    given: str
    stated: str
    known: bool = True
    scaled: bool = False
