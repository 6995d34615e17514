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
    """A place in a file.

    Attributes
    ----------
    unit : str
        What is counted: ``"byte"``, ``"line"``, ``"row"``, ``"message"``, ``"batch"``, ``"row group"`` or
        ``"segment"``. Bytes and rows count from 0, the others from 1.
    number : int
        Which one.
    of : int or None
        How many of them the file has.
    byte : int or None
        Where the unit begins. [bytes]
    """

    unit: str
    number: int
    of: int | None = None
    byte: int | None = None


@frozen
class InFile(Details):
    """Base of findings about a file.

    Attributes
    ----------
    part : str
        Name of the file, if the log is split into several.
    """

    part: str = ""


@frozen
class Damaged(InFile, code="damaged"):
    """A damaged or truncated file. It is read up to the damage.

    Attributes
    ----------
    truncated : bool
        Whether the file ends there.
    what : str
        What is damaged: ``"file"``, ``"array"``, ``"variable acc"`` ….
    place : Place or None
        Where; None if that is not known.
    inside : str
        What the place lies in: ``"message"``, ``"line"``, ``"row"``; empty if that is not known.
    reason : str
        The fault, as the decoder or a library calls it; may be empty.
    kept : int or None
        How many rows or messages are read.
    declared : int or None
        How many the file declares.
    counted, topic : str
        What `kept` and `declared` count.
    """

    truncated: bool = False
    what: str = "file"
    place: Place | None = None
    inside: str = ""
    reason: str = ""
    kept: int | None = None
    declared: int | None = None
    counted: str = "rows"
    topic: str = ""


@frozen
class PartMissing(InFile, code="part_missing"):
    """A file of a split log that is missing or unreadable (`reason`), or the only file that is read.

    Attributes
    ----------
    number, of : int
        Of the file, counted from 1.
    reason : str
        Reason why it cannot be read; empty if it is missing.
    alone : bool
        Whether it is the only part that is read.
    """

    number: int
    of: int
    reason: str = ""
    alone: bool = False


@frozen
class SkippedMessages(InFile, code="skipped_messages"):
    """Messages or lines that are left out: damaged ones, or those of other types. An error if rows are missing for it.

    Attributes
    ----------
    count : int
        How many.
    unit : {"lines", "messages"}
        What is counted.
    other : bool
        Whether they are intact messages of other types.
    place : Place or None
        Of the first, or of the first of those that stand in place of rows.
    example : str
        Fault of one of them, or its type.
    kept : int or None
        How many are read; None if that is not known.
    """

    count: int
    unit: Literal["lines", "messages"] = "messages"
    other: bool = False
    place: Place | None = None
    example: str = ""
    kept: int | None = None


@frozen
class BytesNotRead(InFile, code="bytes_not_read"):
    """Bytes before or after the contents: padding, or possibly another log.

    Attributes
    ----------
    bytes : int
        How many. [bytes]
    place : Place
        Where they begin.
    after : str
        What ends there: ``"the array"``; empty if they precede what is read.
    padding : bool
        Whether all of them are 0 or 255.
    """

    bytes: int
    place: Place
    after: str = ""
    padding: bool = False


@frozen
class MissingChunks(InFile, code="missing_chunks"):
    """Chunks of an array that are not stored. Their samples are missing.

    Attributes
    ----------
    array : str
        Name of the array.
    count : int
        Chunks that are not stored.
    of : int
        Chunks of the array.
    first : int
        First row of the first of them.
    """

    array: str
    count: int
    of: int
    first: int


@frozen
class SkippedLines(InFile, code="skipped_lines"):
    """Lines of a text table that are left out: rows behind a comment mark, a last line without a line end, or all
    lines from a header on that names other columns.

    Attributes
    ----------
    what : {"comments", "last", "header"}
        Which of these they are.
    line : int or None
        The first of them.
    count : int
        How many lines.
    kept : int or None
        How many rows are read.
    """

    what: Literal["comments", "last", "header"]
    line: int | None = None
    count: int = 1
    kept: int | None = None


@frozen
class NeverWritten(InFile, code="never_written"):
    """Zeros at the end of a preallocated file.

    Attributes
    ----------
    rows, zeros, kept : int
        Number of all rows, of the rows at the end that are zero, and of those that are read. The row before the zeros
        is left out too.
    column : str
        The column that is zero; empty for all columns.
    """

    rows: int
    zeros: int
    kept: int
    column: str = ""


@frozen
class ColumnsByGravity(InFile, code="columns_by_gravity"):
    """Columns without names, whose accelerometers are detected by gravity.

    Attributes
    ----------
    gyro, accel : (int, int)
        First and last column.
    time : int or None
        The time column.
    gravity, other : float
        Size of the mean of the accelerometer's and of the gyro's columns, [units of the file]
    """

    gyro: tuple[int, int]
    accel: tuple[int, int]
    time: int | None
    gravity: float
    other: float


@frozen
class GravityOnGyro(InFile, code="gravity_on_gyro", alters_all=True):
    """Gravity is in the columns that are read as the gyro, and not in those of the accelerometer.

    Attributes
    ----------
    gyro, accel : float
        Size of the mean of each, [unit of the file]
    """

    gyro: float
    accel: float


@frozen
class Unusable(InFile, code="unusable"):
    """A table that cannot be read.

    Attributes
    ----------
    reason : str
        Text of the error.
    """

    reason: str


@frozen
class LoggerDropouts(InFile, code="dropouts"):
    """Times when the logger lost data, as it reports.

    Attributes
    ----------
    count : int
        How many.
    total : float
        Their duration together. [s]
    longest : float
        Duration of the longest. [s]
    """

    count: int
    total: float
    longest: float


@frozen
class UnitOverruled(InFile, code="unit_overruled"):
    """A unit given by the user that differs from the unit that the file states.

    Attributes
    ----------
    given, stated : str
        Unit by the user, and by the file.
    known : bool
        Whether the unit stated is a known unit of the quantity.
    scaled : bool
        Whether a scale is given.
    """

    given: str
    stated: str
    known: bool = True
    scaled: bool = False


@frozen
class IncompleteSensor(InFile, code="incomplete_sensor"):
    """A sensor of which two axes are recognised, and the third is not.

    Attributes
    ----------
    missing : str
        Channel without a column.
    column : str
        The column that is not used and has the most similar name; empty if there is none.
    number : int or None
        Its number, counted from 1.
    """

    missing: str
    column: str = ""
    number: int | None = None


@frozen
class UnusedColumns(InFile, code="unused_columns"):
    """Columns of numbers that are not read, because no name tells what they are.

    Attributes
    ----------
    columns : tuple of str
        Their names.
    """

    columns: tuple[str, ...]


@frozen
class UnreadSensor(InFile, code="unread_sensor"):
    """A sensor that the names or units of some columns show, none of which is read.

    Attributes
    ----------
    sensor : str
        ``"gyro"`` or ``"accel"``.
    columns : tuple of str
        Names of its columns.
    numbers : tuple of int
        Their numbers, counted from 1.
    """

    sensor: str
    columns: tuple[str, ...]
    numbers: tuple[int, ...]


@frozen
class MixedUnits(InFile, code="mixed_units"):
    """Axes of one sensor whose units the file states differently.

    Attributes
    ----------
    units : tuple of (str, str)
        Column and unit of each axis.
    """

    units: tuple[tuple[str, str], ...]


@frozen
class UnreadArrays(InFile, code="unread_arrays"):
    """Members of an archive that are not arrays by their names, which may be damaged.

    Attributes
    ----------
    names : tuple of str
        As the archive spells them.
    """

    names: tuple[str, ...]
