"""Kinds of findings about files: damage, leftovers, columns, units.

In all of them `kept` is the number of rows or messages that are read, `count` is the number of what was found, and `topic`
is the topic, sentence or group that is read. Lines and columns count from 1, bytes from 0.
"""

from __future__ import annotations

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
class Damage(InFile):
    """Base of findings about damage after which the file is not read further."""

    what: str = "file"  # what is damaged: ``"file"``, ``"array"``, ``"variable acc"`` …
    place: Place | None = None
    # what the place lies in: ``"message"``, ``"line"``, ``"row"``, ``"number"``; empty if that is not known
    inside: str = ""
    reason: str = ""  # the fault, as the decoder or a library calls it; may be empty
    got: int | None = None  # how many of the bytes, rows or samples are there, and how many should be
    expected: int | None = None
    measured: str = "bytes"  # what `got` and `expected` count
    kept: int | None = None  # how many rows or messages are read
    declared: int | None = None  # how many the file declares
    counted: str = "rows"  # what `kept` and `declared` count
    topic: str = ""


@frozen
class Damaged(Damage, code="damaged"):
    """A file that is damaged at a place, and is read up to it."""


@frozen
class BrokenOff(Damage, code="broken_off"):
    """A file that ends too early."""


@frozen
class NoEndMark(Damage, code="no_end_mark"):
    """A stream that ends between two batches, without its end mark."""


@frozen
class PartMissing(InFile, code="part_missing"):
    """A file of a split log that is missing, or cannot be read for a `reason`; `number` counts from 1."""

    number: int
    of: int
    reason: str = ""


@frozen
class PartOfSeveral(InFile, code="part_of_several"):
    """A file that is one part of a split log; `number` counts from 1."""

    number: int
    of: int


@frozen
class BrokenMessages(InFile, code="broken_messages"):
    """Messages with a wrong checksum, which are left out; `places` are the offsets of the first of them. [bytes]"""

    count: int
    places: tuple[int, ...]
    kept: int


@frozen
class BytesBetween(InFile, code="bytes_between"):
    """Bytes that belong to no whole message: their number, in `count` places, the first at `place`."""

    bytes: int
    count: int
    place: Place
    kept: int


@frozen
class BrokenLines(InFile, code="broken_lines"):
    """Lines with a wrong checksum or form, which are left out."""

    count: int
    inner: int  # number of them that stand between two rows
    examples: tuple[tuple[int, str], ...]  # the first lines, and what is wrong with each
    kept: int
    topic: str


@frozen
class OtherSentences(InFile, code="other_sentences"):
    """Sentences of other names, which are not read."""

    count: int
    example: str  # one of the names
    topic: str
    # first line and length of the longest run of other sentences, if the sensor was switched to them
    line: int | None = None
    run: int | None = None


@frozen
class _Leftover(InFile):
    """Bytes outside of what is read: their number, and where they begin."""

    bytes: int
    place: Place
    after: str = ""  # what ends there: ``"the array"``; empty if they precede what is read


@frozen
class BytesNotRead(_Leftover, code="bytes_not_read"):
    """Bytes before or after the contents, possibly of another log."""


@frozen
class Filler(_Leftover, code="filler"):
    """Bytes of one `value`, 0 or 255, after the contents."""

    value: int


@frozen
class _LinesBetween(InFile):
    """Lines among the rows of a text table; `line` is the first of them."""

    line: int
    count: int = 1


@frozen
class HiddenRows(_LinesBetween, code="hidden_rows"):
    """Rows behind a comment mark, which are left out."""


@frozen
class Comments(_LinesBetween, code="comments"):
    """Comments, which are skipped."""


@frozen
class HeaderAgain(_LinesBetween, code="header_again"):
    """The header once more."""


@frozen
class SecondHeader(_LinesBetween, code="second_header"):
    """A header that names other columns; only the rows before it are read."""

    kept: int


@frozen
class NoLineEnd(InFile, code="no_line_end"):
    """A last line without a line end, which is left out."""


@frozen
class NeverWritten(InFile, code="never_written"):
    """Zeros at the end of a preallocated file."""

    rows: int  # number of all rows, and of the rows at the end that are zero. The row before them is left out too
    zeros: int
    kept: int
    column: str = ""  # the column that is zero; empty for all columns
    is_time: bool = False  # whether that is the time column


@frozen
class ColumnsNotRead(InFile, code="columns_not_read"):
    """Columns of a log in this package's own form that are not the sensors'."""

    columns: tuple[str, ...]
    channels: tuple[tuple[str, int], ...]  # channels and their columns that would read the first of them too
    as_rates: bool = False  # whether ``--input rate`` is needed with them
    topic: str = ""


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
class UnknownMessages(InFile, code="unknown_messages"):
    """Messages of unknown kinds, which are skipped."""

    count: int


@frozen
class UnfinishedMessage(InFile, code="unfinished_message"):
    """A message of some bytes that was not finished before data were appended."""

    place: Place
    bytes: int


@frozen
class DeletedMessages(InFile, code="deleted_messages"):
    """Messages of all topics that were deleted from an intact database."""

    count: int
    topic: str


@frozen
class PropertyChanged(InFile, code="property_changed"):
    """A property of channels that changes from `old` to `new`; only the rows before are read."""

    topic: str
    name: str
    old: str | float
    new: str | float
    kept: int


@frozen
class UnequalLengths(InFile, code="unequal_lengths"):
    """Axes of one sensor with unequal numbers of samples; `lengths` are pairs of array and number."""

    lengths: tuple[tuple[str, int], ...]


@frozen
class MissingSamples(InFile, code="missing_samples"):
    """Samples that have the value `fill`, by which the file marks missing ones."""

    column: str
    count: int
    fill: float


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
