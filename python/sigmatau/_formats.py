"""The one door to the compiled readers and the writer of tables: casts, and the words of their errors.

With `sigmatau._kernels` alone it imports ``sigmatau._core`` (ruff's TID251 holds it).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from sigmatau import _core

__all__ = [
    "Decoded",
    "LogChannel",
    "LogContents",
    "LogEnd",
    "LogKind",
    "Sentences",
    "TextColumns",
    "TextReadError",
    "bytes_read",
    "dataflash_columns",
    "decode_messages",
    "format_text",
    "log_contents",
    "log_messages",
    "read_sentences",
    "read_text",
    "scan_dataflash",
    "scan_ulog",
    "ulog_columns",
    "unpacked",
    "write_text",
]


class TextReadError(Exception):
    """A text table that cannot be read: where, and what was there.

    Attributes
    ----------
    kind : str
        ``"ragged"``, ``"not_a_number"``, ``"non_finite"``, ``"too_long"``, ``"truncated"``, ``"damaged"``, ``"io"``
        or ``"empty"``.
    line : int
        Line of the file, counted from 1; 0 if unknown.
    row : int
        Row of data, counted from 0.
    column : int
        Column, counted from 0.
    text : str
        What stood there, or the system's words.
    got, expected : int
        Fields found and expected.
    """

    def __init__(self, kind: str, line: int, row: int, column: int, text: str, got: int, expected: int) -> None:
        super().__init__(f"{kind} at line {line}: {text}")
        self.kind = kind
        self.line = line
        self.row = row
        self.column = column
        self.text = text
        self.got = got
        self.expected = expected


@dataclass(frozen=True, slots=True, kw_only=True)
class TextColumns:
    """Columns of a text table, and what was passed over between its rows. Lines count from 1.

    Attributes
    ----------
    columns : list of ndarray, shape (n,)
    integers : ndarray of int64 or None
        The exact column, if all its values are integers, or dates.
    hidden, first_hidden : int
        Lines that begin with a comment mark and else look like rows; the first of them.
    remarks, first_remark : int
        Other lines that begin so.
    headers : list of (int, str)
        Line and text of those that have as many fields as a row and no number in them; the first 16.
    open_end : bool
        Whether the last line has no line end; not looked at in large files that are not compressed.
    """

    columns: list[NDArray[np.float64]]
    integers: NDArray[np.int64] | None
    hidden: int
    first_hidden: int
    remarks: int
    first_remark: int
    headers: list[tuple[int, str]]
    open_end: bool


def read_text(
    source: str | bytes,
    *,
    delimiter: str | None,
    comment: tuple[str, ...],
    columns: int,
    wanted: tuple[int, ...],
    exact: int | None = None,
    skip_lines: int = 0,
    encoding: str = "ascii",
    decimal_comma: bool = False,
    lines: int | None = None,
    dates: bool = False,
) -> TextColumns:
    """Columns of a text table.

    Parameters
    ----------
    source : str or bytes
        Path of a file, of which a gzip file is recognised by its first bytes; or the text itself.
    delimiter : str or None
        One ASCII character; None for runs of white space.
    comment : tuple of str
        Lines that begin so are passed over.
    columns : int
        Fields in every row.
    wanted : tuple of int
        Columns to return, counted from 0.
    exact : int or None
        A column to return as integers too, if all its values are integers that fit 64 bits.
    skip_lines : int
        Lines before the data.
    encoding : {"ascii", "utf-16-le", "utf-16-be"}
        The first for all in which ASCII is ASCII.
    decimal_comma : bool
        Whether 0,5 is one half; then 0.5 is no number.
    lines : int or None
        Lines of the source after which it is taken to end.
    dates : bool
        Whether the exact column holds dates; they come as nanoseconds since 1970.

    Raises
    ------
    TextReadError
    """
    writing = (encoding, decimal_comma, lines, dates)
    how = (delimiter, list(comment), skip_lines, columns, list(wanted), exact, writing)
    try:
        found = _core.parse_text(source, *how) if isinstance(source, bytes) else _core.read_text(source, *how)
    except _core.TextError as error:
        raise TextReadError(*error.args) from None
    floats, integers, (hidden, first_hidden, remarks, first_remark, headers), open_end = found
    return TextColumns(
        columns=floats,
        integers=integers,
        hidden=hidden,
        first_hidden=first_hidden,
        remarks=remarks,
        first_remark=first_remark,
        headers=headers,
        open_end=open_end,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Sentences:
    """The sentences of one name in a log.

    Attributes
    ----------
    columns : list of ndarray, shape (n,)
    broken, inner : int
        Lines that are no whole sentence; those of them after the first row.
    examples : list of (int, str)
        Line, counted from 1, and what is wrong with it, for the first of them.
    others : int
        Whole sentences of other names.
    gap : (int, int)
        The most of them, after the first row, without a row between; and the line of the first of those.
    other : str
        Name of the first of them.
    cut : bool
        Whether the last line is broken and has no line end.
    """

    columns: list[NDArray[np.float64]]
    broken: int
    inner: int
    examples: list[tuple[int, str]]
    others: int
    gap: tuple[int, int]
    other: str
    cut: bool


def read_sentences(path: str, *, name: str, fields: int, wanted: tuple[int, ...]) -> Sentences:
    """The wanted fields (counted from 0) of VectorNav sentences of a name without ``$``; raises `TextReadError`."""
    try:
        columns, broken, inner, examples, others, cut = _core.read_sentences(path, name, fields, list(wanted))
    except _core.TextError as error:
        raise TextReadError(*error.args) from None
    count, gap, other = others
    return Sentences(
        columns=columns, broken=broken, inner=inner, examples=examples, others=count, gap=gap, other=other, cut=cut
    )


LogKind = Literal["mcap", "rosbag1"]


@dataclass(frozen=True, slots=True)
class LogChannel:
    """A series of messages of a log: its topic, its number, the type of its messages and how they are written."""

    topic: str
    id: int
    type_name: str
    definition_encoding: str
    definition: bytes
    message_encoding: str
    messages: int


@dataclass(frozen=True, slots=True)
class LogEnd:
    """How the way through a log ended: ``""``, ``"broken_off"``, ``"no_end"``, ``"damaged"``, or ``"behind"`` or
    ``"filler"`` if bytes follow; at which byte, in words.
    """

    kind: str
    offset: int
    what: str


@dataclass(frozen=True, slots=True)
class LogContents:
    """The channels of a log, and whether their numbers of messages are declared by it or were counted."""

    channels: tuple[LogChannel, ...]
    declared: bool
    end: LogEnd


@dataclass(frozen=True, slots=True)
class Decoded:
    """Columns out of messages, each of shape (rows,)."""

    columns: Mapping[int, NDArray[Any]]
    rows: int


def log_contents(path: str, kind: LogKind) -> LogContents:
    """What a log holds, by its own summary or by going through it; raises OSError."""
    channels, declared, end = _core.log_contents(path, kind == "rosbag1")
    return LogContents(tuple(LogChannel(*fields) for fields in channels), declared, LogEnd(*end))


def log_messages(
    path: str,
    kind: LogKind,
    channels: Sequence[int],
    *,
    steps: Sequence[tuple[str, int, int]],
    cdr: bool,
    wanted: Sequence[int],
    exact: int | None,
) -> tuple[Decoded, LogEnd]:
    """Columns of the messages of some channels, up to the first fault of the file; raises OSError.

    Parameters
    ----------
    path : str
    kind : {"mcap", "rosbag1"}
    channels : sequence of int
        Their numbers.
    steps : sequence of (str, int, int)
        The definition of the messages, see `sigmatau.io.read.formats.messages`.
    cdr : bool
        Serialised as in ROS 2, or else as in ROS 1.
    wanted : sequence of int
        Columns to return, counted from 0.
    exact : int or None
        One of them to return as 64-bit integers, if it holds such.
    """
    decoded, end = _core.log_messages(path, kind == "rosbag1", list(channels), list(steps), cdr, list(wanted), exact)
    return _decoded(decoded, wanted, exact), LogEnd(*end)


def decode_messages(
    data: bytes,
    ends: NDArray[np.int64],
    log_times: NDArray[np.int64],
    *,
    steps: Sequence[tuple[str, int, int]],
    cdr: bool,
    wanted: Sequence[int],
    exact: int | None,
) -> Decoded:
    """The same from messages in memory, one after the other, each up to its end in `data`; up to the first wrong one."""
    return _decoded(_core.decode_messages(data, ends, log_times, list(steps), cdr, list(wanted), exact), wanted, exact)


def _decoded(
    fields: tuple[list[NDArray[np.float64]], NDArray[np.int64] | None, int], wanted: Sequence[int], exact: int | None
) -> Decoded:
    floats, integers, rows = fields
    named = [index for index in wanted if integers is None or index != exact]
    columns: dict[int, NDArray[Any]] = dict(zip(named, floats, strict=True))
    if integers is not None and exact is not None:
        columns[exact] = integers
    return Decoded(columns, rows)


def bytes_read() -> int:
    """Bytes of files that the compiled readers of this process have taken so far, to show how far one has come."""
    return _core.bytes_read()


def write_text(path: str, header: str | None, delimiter: str, columns: Sequence[NDArray[Any]], *, gzip: bool) -> None:
    """Write columns as text, each number with as few digits as read back to the same bits; raises OSError."""
    _core.write_text(path, header, delimiter, [np.ascontiguousarray(c, dtype=np.float64) for c in columns], gzip)


def format_text(header: str | None, delimiter: str, columns: Sequence[NDArray[Any]]) -> bytes:
    """The lines that `write_text` writes."""
    return _core.format_text(header, delimiter, [np.ascontiguousarray(c, dtype=np.float64) for c in columns])


def scan_dataflash(path: str) -> Mapping[str, Any]:
    """What an ArduPilot DataFlash file holds, up to the place where it breaks off if it does.

    Returns
    -------
    mapping
        ``kinds``, each number, name, fields (name, letter of the type, offset), bytes a message, offset of the instance or
        None, and messages by instance; ``definitions``, messages that define units, each the place of its kind and bytes;
        ``messages``, ``end`` and ``broken`` as in `scan_ulog`; ``filler``, the one byte that the rest consists of, or None.

    Raises
    ------
    OSError
    """
    return _core.scan_dataflash(path)


def dataflash_columns(
    path: str,
    *,
    end: int,
    kind: int,
    instance: tuple[int, int] | None,
    rows: int,
    size: int,
    fields: Sequence[tuple[int, int]],
) -> list[NDArray[np.uint8]]:
    """Bytes of fields of all messages of a kind and an instance, one array a field.

    Parameters
    ----------
    path : str
    end, kind, rows, size : int
        From `scan_dataflash`.
    instance : (int, int) or None
        Its offset in a message, and which.
    fields : sequence of (int, int)
        Offset in a message and length. [bytes]

    Raises
    ------
    OSError
        Also if the file is no longer the one that was scanned.
    """
    return _core.dataflash_columns(path, end, kind, instance, rows, size, list(fields))


def scan_ulog(path: str) -> Mapping[str, Any]:
    """What a ULog file holds, up to the place where it breaks off if it does.

    Returns
    -------
    mapping
        ``formats``, definitions as bytes; ``topics``, each number, instance, name as bytes, rows and bytes a row;
        ``dropouts`` in milliseconds; ``unknown``, messages of kinds not known; ``unfinished``, parts passed over, from and
        to; ``messages``, how many were read; ``end``, where reading ended; ``broken``, None or where and what is wrong, the
        latter None if the file just ends there.

    Raises
    ------
    ValueError
        If it is none, or one that must not be read without knowing more of the format.
    OSError
    """
    return _core.scan_ulog(path)


def ulog_columns(
    path: str, *, end: int, number: int, rows: int, size: int, fields: Sequence[tuple[int, int]]
) -> list[NDArray[np.uint8]]:
    """Bytes of fields of all messages of a topic of a ULog file, one array a field.

    Parameters
    ----------
    path : str
    end, number, rows, size : int
        From `scan_ulog`.
    fields : sequence of (int, int)
        Offset in a message and length. [bytes]

    Raises
    ------
    OSError
        Also if the file is no longer the one that was scanned.
    """
    return _core.ulog_columns(path, end, number, rows, size, list(fields))


def unpacked(data: bytes) -> bytes | None:
    """A message that is compressed by zstd; None if it is damaged or holds more than 64 MiB."""
    return _core.unpacked(data)
