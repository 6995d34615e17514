"""Kinds of findings about files: damage, leftovers, columns, units."""

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
    """A file of a split log that is missing or cannot be read; `part` is its name.

    Attributes
    ----------
    number, of : int
        Which part it is, counted from 1, and how many there are.
    reason : str
        Why it cannot be read; empty if the file is not there.
    """

    code: ClassVar[str] = "part_missing"
    number: int
    of: int
    reason: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class PartOfSeveral(InFile):
    """A file that is one part of a split log, see `PartMissing`."""

    code: ClassVar[str] = "part_of_several"
    number: int
    of: int


@dataclass(frozen=True, slots=True, kw_only=True)
class BrokenMessages(InFile):
    """Messages with a wrong checksum, which are left out.

    Attributes
    ----------
    count : int
    places : tuple of int
        Where the first of them begin. [bytes]
    kept : int
        Messages that are read.
    """

    code: ClassVar[str] = "broken_messages"
    count: int
    places: tuple[int, ...]
    kept: int


@dataclass(frozen=True, slots=True, kw_only=True)
class BytesBetween(InFile):
    """Bytes that belong to no whole message.

    Attributes
    ----------
    bytes : int
    count : int
        Number of places.
    place : Place
        The first of them.
    kept : int
        Messages that are read.
    """

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
    count : int
    inner : int
        How many stand between two rows.
    examples : tuple of (int, str)
        The first lines, counted from 1, and what is wrong with each.
    kept : int
        Rows that are read.
    topic : str
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
    count : int
    example : str
        The name of one.
    topic : str
        The sentence that is read.
    line, run : int or None
        Where the longest run of other sentences begins, and its length, if the sensor was switched to them.
    """

    code: ClassVar[str] = "other_sentences"
    count: int
    example: str
    topic: str
    line: int | None = None
    run: int | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class _Leftover(InFile):
    """Bytes outside of what is read.

    Attributes
    ----------
    bytes : int
        How many.
    place : Place
        Where they begin.
    after : str
        What ends there: ``"the array"``; empty if they stand before what is read.
    """

    bytes: int
    place: Place
    after: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class BytesNotRead(_Leftover):
    """Bytes in front of or behind the contents, of another log perhaps."""

    code: ClassVar[str] = "bytes_not_read"


@dataclass(frozen=True, slots=True, kw_only=True)
class Filler(_Leftover):
    """Bytes of one value behind the contents.

    Attributes
    ----------
    value : int
        0 or 255.
    """

    code: ClassVar[str] = "filler"
    value: int


@dataclass(frozen=True, slots=True, kw_only=True)
class _LinesBetween(InFile):
    """Lines among the rows of a text table.

    Attributes
    ----------
    line : int
        The first of them, counted from 1.
    count : int
    """

    line: int
    count: int = 1


@dataclass(frozen=True, slots=True, kw_only=True)
class HiddenRows(_LinesBetween):
    """Rows behind a comment mark."""

    code: ClassVar[str] = "hidden_rows"


@dataclass(frozen=True, slots=True, kw_only=True)
class Comments(_LinesBetween):
    """Comments."""

    code: ClassVar[str] = "comments"


@dataclass(frozen=True, slots=True, kw_only=True)
class HeaderAgain(_LinesBetween):
    """The header once more."""

    code: ClassVar[str] = "header_again"


@dataclass(frozen=True, slots=True, kw_only=True)
class SecondHeader(_LinesBetween):
    """A header that names other columns.

    Attributes
    ----------
    kept : int
        Rows that are read: those before it.
    """

    code: ClassVar[str] = "second_header"
    kept: int


@dataclass(frozen=True, slots=True, kw_only=True)
class NoLineEnd(InFile):
    """A last line without a line end, which is left out."""

    code: ClassVar[str] = "no_line_end"


@dataclass(frozen=True, slots=True, kw_only=True)
class NeverWritten(InFile):
    """Zeros at the end of a file that was laid out in advance.

    Attributes
    ----------
    rows : int
        Rows of the file.
    zeros : int
        How many of them, at the end, are zero.
    kept : int
        Rows that are read; the row before the zeros may be half written and is left out.
    column : str
        The column that is zero; empty for all of them.
    is_time : bool
        Whether that is the column of the time stamps.
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
        Channels and their columns, counted from 1, that would read the first of them too.
    as_rates : bool
        Whether ``--input rate`` must be given with them.
    topic : str
    """

    code: ClassVar[str] = "columns_not_read"
    columns: tuple[str, ...]
    channels: tuple[tuple[str, int], ...]
    as_rates: bool = False
    topic: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class ColumnsByGravity(InFile):
    """Columns without names, of which gravity tells the accelerometers.

    Attributes
    ----------
    gyro, accel : tuple of (int, int)
        First and last column, counted from 1.
    time : int or None
        The column of the time stamps.
    gravity : float
        Size of the mean of the accelerometer's columns, in the unit of the file.
    other : float
        The same of the gyro's columns.
    """

    code: ClassVar[str] = "columns_by_gravity"
    gyro: tuple[int, int]
    accel: tuple[int, int]
    time: int | None
    gravity: float
    other: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Unusable(InFile):
    """A table that cannot be read.

    Attributes
    ----------
    reason : str
        The text of the error.
    """

    code: ClassVar[str] = "unusable"
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class UnknownMessages(InFile):
    """Messages of unknown kinds, which are skipped.

    Attributes
    ----------
    count : int
    """

    code: ClassVar[str] = "unknown_messages"
    count: int


@dataclass(frozen=True, slots=True, kw_only=True)
class UnfinishedMessage(InFile):
    """A message that was not finished before data were appended.

    Attributes
    ----------
    place : Place
    bytes : int
    """

    code: ClassVar[str] = "unfinished_message"
    place: Place
    bytes: int


@dataclass(frozen=True, slots=True, kw_only=True)
class DeletedMessages(InFile):
    """Messages of any topic that were deleted from a sound database.

    Attributes
    ----------
    count : int
    topic : str
        The topic that is read.
    """

    code: ClassVar[str] = "deleted_messages"
    count: int
    topic: str


@dataclass(frozen=True, slots=True, kw_only=True)
class PropertyChanged(InFile):
    """A property of channels that changes within the file, which is read up to there.

    Attributes
    ----------
    topic : str
        The group of the channels.
    name : str
    old, new : str or float
    kept : int
        Rows that are read.
    """

    code: ClassVar[str] = "property_changed"
    topic: str
    name: str
    old: str | float
    new: str | float
    kept: int


@dataclass(frozen=True, slots=True, kw_only=True)
class UnequalLengths(InFile):
    """Axes of one sensor with unequal numbers of samples.

    Attributes
    ----------
    lengths : tuple of (str, int)
        Array and number of samples.
    """

    code: ClassVar[str] = "unequal_lengths"
    lengths: tuple[tuple[str, int], ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class MissingSamples(InFile):
    """Samples that have the value by which the file marks missing ones.

    Attributes
    ----------
    column : str
    count : int
    fill : float
        That value, as stored.
    """

    code: ClassVar[str] = "missing_samples"
    column: str
    count: int
    fill: float


@dataclass(frozen=True, slots=True, kw_only=True)
class LoggerDropouts(InFile):
    """Times when the logger lost data, by its own account.

    Attributes
    ----------
    count : int
    total, longest : float
        Duration of all and of the longest. [s]
    """

    code: ClassVar[str] = "dropouts"
    count: int
    total: float
    longest: float


@dataclass(frozen=True, slots=True, kw_only=True)
class UnitOverruled(InFile):
    """A unit given by the user that is not the one the file states.

    Attributes
    ----------
    given, stated : str
    known : bool
        Whether the unit stated is one of this quantity.
    scaled : bool
        Whether a scale is given.
    """

    code: ClassVar[str] = "unit_overruled"
    given: str
    stated: str
    known: bool = True
    scaled: bool = False
