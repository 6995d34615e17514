"""Findings about files and live lines: damage, and parts that are not read.

In all of them `kept` is the number of rows or messages that are read, `count` the number of items that the finding is about,
and `topic` the topic, sentence or group that is read. Lines count from 1, bytes from 0.
"""

from __future__ import annotations

from typing import Literal

from sigmatau.findings.finding import Details, Finding, Words
from sigmatau.findings.phrases import LONGEST, listed, plural, shortened
from sigmatau.frozen import frozen
from sigmatau.hints import Hint

_AGAIN = "Copy or record the file again"


@frozen(kw_only=False)
class Place:
    """A place in a file.

    Attributes
    ----------
    unit : str
        Unit that is counted: ``"byte"``, ``"line"``, ``"row"``, ``"message"``, ``"batch"``, ``"row group"`` or
        ``"segment"``. Bytes and rows count from 0, the others from 1.
    number : int
        Number of the unit.
    of : int or None
        Number of such units in the file.
    byte : int or None
        Offset of the unit. [bytes]
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
        Whether the file ends at the damage.
    what : str
        What is damaged: ``"file"``, ``"array"``, ``"variable acc"`` ….
    place : Place or None
        Place of the damage; None if it is not known.
    inside : str
        What contains the place: ``"message"``, ``"line"``, ``"row"``; empty if it is not known.
    reason : str
        The fault, as named by the decoder or a library; may be empty.
    kept : int or None
        Number of rows or messages that are read.
    declared : int or None
        Number that the file declares.
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

    def words(self, finding: Finding) -> Words:
        inside = ""
        if self.inside and (self.place is None or self.place.unit != self.inside):
            inside = f" inside its last {self.inside}" if self.place is None else f", inside a {self.inside}"
        complete = finding.severity == "warning" and self.declared in (None, self.kept)
        count = _count_text(self.kept, None if complete else self.declared, self.counted, self.topic, every=complete)
        subject = f"the {self.what} is {'truncated' if self.truncated else 'damaged'}{_place_text(self.place)}{inside}"
        room = LONGEST - sum(len(text) + 2 for text in (self.part, subject, count))
        reason = shortened(self.reason, max(room, 20))
        message = f"{subject}: {reason}" if reason else subject
        if complete:
            action = ""
        elif self.inside == "row":
            action = f"Copy the whole file, or correct {Hint('layout')}"
        else:
            action = _AGAIN
        return Words("; ".join(filter(None, (message, count))), action)


@frozen
class PartMissing(InFile, code="part_missing"):
    """A file of a split log that is missing or unreadable (`reason`), or the only file that is read.

    Attributes
    ----------
    number, of : int
        Number of the part, counted from 1.
    reason : str
        Reason why it cannot be read; empty if it is missing.
    alone : bool
        Whether it is the only part that is read.
    """

    number: int
    of: int
    reason: str = ""
    alone: bool = False

    def words(self, finding: Finding) -> Words:
        part = f"part {self.number} of {self.of}"
        if self.alone:
            return Words(f"the file is {part} of a recording", "Give the folder instead of the file to read all parts")
        return Words(f"{part} {f'cannot be read ({shortened(self.reason)})' if self.reason else 'is missing'}", _AGAIN)


@frozen
class SkippedMessages(InFile, code="skipped_messages"):
    """Messages or lines that are left out: damaged ones, or those of other types. An error if rows are missing because
    of it.

    Attributes
    ----------
    count : int
        How many.
    unit : {"lines", "messages"}
        What is counted.
    other : bool
        Whether they are intact messages of other types.
    place : Place or None
        Place of the first, or of the first that replaces rows.
    example : str
        Fault of one of them, or its type.
    kept : int or None
        Number of messages that are read; None if it is not known.
    """

    count: int
    unit: Literal["lines", "messages"] = "messages"
    other: bool = False
    place: Place | None = None
    example: str = ""
    kept: int | None = None

    def words(self, finding: Finding) -> Words:
        lost, example = finding.severity == "error", shortened(self.example, 40)
        where = f",{' the first' if self.count > 1 else ''}{_place_text(self.place)}" if self.place else ""
        rows_read = "" if self.kept is None else f"; {self.kept} read"
        if self.other:
            such = f", such as {example}," if example else ""
            action = "No action needed if a newer program wrote them; otherwise the file is damaged"
            if lost:
                action = "Split the log where the sensor was switched: rows are missing there"
            message = f"{plural(self.count, self.unit)} of other types{such} skipped{where}{rows_read}"
            return Words(message, "" if finding.severity == "info" else action)
        what = f" ({example})" if example else ""
        action = "Check the logger and its connection" if finding.severity == "warning" else ""
        return Words(
            f"{plural(self.count, f'damaged {self.unit}')} skipped{where}{what}{rows_read}",
            "Copy the log again: rows are missing, and the times after them may be too early" if lost else action,
        )


@frozen
class BytesNotRead(InFile, code="bytes_not_read"):
    """Bytes before or after the contents: padding, or possibly another log.

    Attributes
    ----------
    bytes : int
        How many. [bytes]
    place : Place
        Offset of the first byte.
    after : str
        Content that ends there: ``"the array"``; empty if the bytes precede the contents.
    padding : bool
        Whether all of them are 0 or all are 255.
    """

    bytes: int
    place: Place
    after: str = ""
    padding: bool = False

    def words(self, finding: Finding) -> Words:
        where = f"after {self.after}{_place_text(self.place)}" if self.after else "before the data"
        if self.padding:
            return Words(f"{plural(self.bytes, 'bytes')} {where} are padding")
        return Words(
            f"{plural(self.bytes, 'bytes')} {where} not read", "Split the file there if another log was appended"
        )


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
        First row of the first missing chunk.
    """

    array: str
    count: int
    of: int
    first: int

    def words(self, finding: Finding) -> Words:
        what = f"{plural(self.count, 'chunks')} of {self.of} of array {self.array} not stored"
        return Words(f"{what}, the first at row {self.first}; samples missing", _AGAIN)


@frozen
class SkippedLines(InFile, code="skipped_lines"):
    """Lines of a text table that are left out: rows after a comment mark, a last line without a line end, or all lines
    after a header that names other columns.

    Attributes
    ----------
    what : {"comments", "last", "header"}
        Which of these kinds they are.
    line : int or None
        Number of the first line.
    count : int
        Number of lines.
    kept : int or None
        Number of rows that are read.
    """

    what: Literal["comments", "last", "header"]
    line: int | None = None
    count: int = 1
    kept: int | None = None

    def words(self, finding: Finding) -> Words:
        if self.what == "last":
            return Words("the last line has no line end, so its last number may be truncated; line skipped")
        if self.what == "header":
            return Words(
                f"line {self.line} is a header with other columns; {plural(self.kept or 0, 'rows')} before it are read,"
                " rows after it are not",
                "Split the file there: it contains several logs",
            )
        what = f"line {self.line} is a comment that looks like a data row"
        if self.count > 1:
            what = f"{self.count} comment lines look like data rows, the first line {self.line}"
        return Words(f"{what}; skipped", "Remove the comment marks if these lines are data; otherwise delete the lines")


@frozen
class NeverWritten(InFile, code="never_written"):
    """Zeros at the end of a preallocated file.

    Attributes
    ----------
    rows, zeros, kept : int
        Number of all rows, of the zero rows at the end, and of the rows that are read. The row before the zeros is left out
        too.
    column : str
        The column that is zero; empty for all columns.
    """

    rows: int
    zeros: int
    kept: int
    column: str = ""

    def words(self, finding: Finding) -> Words:
        what = f"column {self.column} is" if self.column else "all columns are"
        return Words(
            f"{what} exactly 0 in the last {self.zeros} of {self.rows} rows, which were never written;"
            f" {self.kept} rows read",
            _AGAIN,
        )


@frozen
class Unusable(InFile, code="unusable"):
    """A table that cannot be read.

    Attributes
    ----------
    reason : str
        Text of the error.
    """

    reason: str

    def words(self, finding: Finding) -> Words:
        return Words(self.reason)


@frozen
class LoggerDropouts(InFile, code="dropouts"):
    """Times at which the logger reports lost data.

    Attributes
    ----------
    count : int
        Number of dropouts.
    total : float
        Sum of their durations. [s]
    longest : float
        Duration of the longest. [s]
    """

    count: int
    total: float
    longest: float

    def words(self, finding: Finding) -> Words:
        return Words(
            f"the logger lost data {plural(self.count, 'times')}, {self.total:.3g} s in total, the longest loss"
            f" {self.longest:.3g} s",
            f"Log to a faster card, log fewer topics, or select a part without dropouts with {Hint('window')}",
        )


@frozen
class UnreadArrays(InFile, code="unread_arrays"):
    """Members of an archive whose names are not those of arrays. They may be damaged.

    Attributes
    ----------
    names : tuple of str
        As the archive spells them.
    """

    names: tuple[str, ...]

    def words(self, finding: Finding) -> Words:
        what = f"{plural(len(self.names), 'members')} of the archive not read, because the name is not that of an array"
        return Words(f"{what}: {listed(self.names)}", _AGAIN)


def _place_text(place: Place | None) -> str:
    if place is None:
        return ""
    total = "" if place.of is None else f" of {place.of}"
    byte = "" if place.byte is None else f" (byte {place.byte})"
    return f" {'at' if place.unit == 'byte' else 'in'} {place.unit} {place.number}{total}{byte}"


def _count_text(count: int | None, declared: int | None, noun: str, topic: str, *, every: bool = False) -> str:
    if count is None:
        return ""
    number = plural(count, noun) if declared is None else f"{count} of {declared} {noun}"
    return f"{'all ' if every else ''}{number}{f' of {topic}' if topic else ''} read"
