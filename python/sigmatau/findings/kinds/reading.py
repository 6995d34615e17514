"""Kinds of findings about files, and about lines that are read while they are logged: damage, leftovers, columns, units.

In all of them `kept` is the number of rows or messages that are read, `count` is the number of what was found, and `topic`
is the topic, sentence or group that is read. Lines and columns count from 1, bytes from 0.
"""

from __future__ import annotations

from typing import Literal

from sigmatau.findings.finding import Details
from sigmatau.frozen import frozen


@frozen(kw_only=False)
class Place:
    """A place in a file."""

    # what is counted: ``"byte"``, ``"line"``, ``"row"``, ``"message"``, ``"batch"``, ``"row group"`` or ``"segment"``.
    # Bytes and rows count from 0, the others from 1
    unit: str
    number: int
    of: int | None = None  # how many of them the file has
    byte: int | None = None  # where the unit begins [bytes]


@frozen
class InFile(Details):
    """Base of findings about a file."""

    part: str = ""  # name of the file, if the log is split into several


@frozen
class Damaged(InFile, code="damaged"):
    """A file that is damaged at a place, or truncated there. It is read up to it."""

    truncated: bool = False
    what: str = "file"  # what is damaged: ``"file"``, ``"array"``, ``"variable acc"`` …
    place: Place | None = None
    # what the place lies in: ``"message"``, ``"line"``, ``"row"``; empty if that is not known
    inside: str = ""
    reason: str = ""  # the fault, as the decoder or a library calls it; may be empty
    kept: int | None = None  # how many rows or messages are read
    declared: int | None = None  # how many the file declares
    counted: str = "rows"  # what `kept` and `declared` count
    topic: str = ""


@frozen
class PartMissing(InFile, code="part_missing"):
    """A file of a split log that is missing, or cannot be read for a `reason`; or the only one that is read."""

    number: int  # of the file, counted from 1
    of: int
    reason: str = ""
    alone: bool = False  # whether it is the only part that is read


@frozen
class SkippedMessages(InFile, code="skipped_messages"):
    """Messages or lines that are left out: damaged ones, or those of other types. An error if rows are missing for it."""

    count: int
    unit: Literal["lines", "messages"] = "messages"
    other: bool = False  # whether they are of other types, and whole
    place: Place | None = None  # of the first, or of the first of those that stand in place of rows
    example: str = ""  # what is wrong with one of them, or its type
    kept: int | None = None


@frozen
class BytesNotRead(InFile, code="bytes_not_read"):
    """Bytes before or after the contents: padding, or possibly another log."""

    bytes: int
    place: Place
    after: str = ""  # what ends there: ``"the array"``; empty if they precede what is read
    padding: bool = False  # whether all of them are 0 or 255


@frozen
class MissingChunks(InFile, code="missing_chunks"):
    """Chunks of an array that are not stored. Their samples are missing."""

    array: str
    count: int
    of: int
    first: int  # first row of the first of them


@frozen
class SkippedLines(InFile, code="skipped_lines"):
    """Lines of a text table that are left out: rows behind a comment mark, a last line without a line end, or all
    lines from a header on that names other columns.
    """

    what: Literal["comments", "last", "header"]
    line: int | None = None  # the first of them
    count: int = 1
    kept: int | None = None


@frozen
class NeverWritten(InFile, code="never_written"):
    """Zeros at the end of a preallocated file."""

    rows: int  # number of all rows, and of the rows at the end that are zero. The row before them is left out too
    zeros: int
    kept: int
    column: str = ""  # the column that is zero; empty for all columns


@frozen
class ColumnsByGravity(InFile, code="columns_by_gravity"):
    """Columns without names, whose accelerometers are detected by gravity."""

    gyro: tuple[int, int]  # first and last column
    accel: tuple[int, int]
    time: int | None  # the time column
    gravity: float  # size of the mean of the accelerometer's and of the gyro's columns, in the units of the file
    other: float


@frozen
class GravityOnGyro(InFile, code="gravity_on_gyro"):
    """The columns that are read as the gyro have the mean of gravity, and those of the accelerometer have not."""

    gyro: float  # size of the mean of each, in the unit of the file
    accel: float


@frozen
class Unusable(InFile, code="unusable"):
    """A table that cannot be read; `reason` is the text of the error."""

    reason: str


@frozen
class LoggerDropouts(InFile, code="dropouts"):
    """Times when the logger lost data, as it reports: number, total duration and longest one. [s]"""

    count: int
    total: float
    longest: float


@frozen
class UnitOverruled(InFile, code="unit_overruled"):
    """A unit given by the user that differs from the one that the file states."""

    given: str
    stated: str
    known: bool = True  # whether the unit stated is a known unit of the quantity
    scaled: bool = False  # whether a scale is given
