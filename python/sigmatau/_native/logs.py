"""Compiled readers of binary logs: ROS and MCAP messages, PX4 ULog, ArduPilot DataFlash."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from sigmatau import _core
from sigmatau.frozen import frozen

LogKind = Literal["mcap", "rosbag1"]


@frozen(kw_only=False)
class LogChannel:
    """A channel of a log: its topic, number of messages, message type and encoding."""

    topic: str
    id: int
    type_name: str
    definition_encoding: str
    definition: bytes
    message_encoding: str
    messages: int


@frozen(kw_only=False)
class LogEnd:
    """End of the pass through a log, as a code, an offset in bytes, and words.

    The code is ``""``, ``"broken_off"``, ``"no_end"``, ``"damaged"``, ``"expanded"`` if it unpacks to more than is allowed,
    or ``"behind"`` or ``"filler"`` if bytes follow.
    """

    kind: str
    offset: int
    what: str


@frozen(kw_only=False)
class LogContents:
    """Channels of a log, and whether their numbers of messages are declared or counted."""

    channels: tuple[LogChannel, ...]
    declared: bool
    end: LogEnd


@frozen(kw_only=False)
class Decoded:
    """Columns of messages, each of shape (rows,)."""

    columns: Mapping[int, NDArray[Any]]
    rows: int


def log_contents(path: str, kind: LogKind, *, max_bytes: int) -> LogContents:
    """Contents of a log, from its summary or by reading it; its chunks may unpack to `max_bytes`. Raises
    OSError.
    """
    channels, declared, end = _core.log_contents(path, kind == "rosbag1", max_bytes)
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
    max_bytes: int,
) -> tuple[Decoded, LogEnd]:
    """Columns of the messages of some channels, up to the first fault of the file; raises OSError.

    Parameters
    ----------
    path : str
    kind : {"mcap", "rosbag1"}
    channels : sequence of int
        Numbers of the channels.
    steps : sequence of (str, int, int)
        The definition of the messages, see `sigmatau.io.read.formats.messages`.
    cdr : bool
        Whether messages are serialised as in ROS 2; otherwise as in ROS 1.
    wanted : sequence of int
        Columns to return, counted from 0.
    exact : int or None
        Column of 64-bit integers to return as such, if it has them.
    max_bytes : int
        Total size to which the chunks of the file may unpack. [bytes]
    """
    decoded, end = _core.log_messages(
        path, kind == "rosbag1", list(channels), list(steps), cdr, list(wanted), exact, max_bytes
    )
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
    """Columns of the messages concatenated in `data`, which end at `ends`, up to the first wrong message."""
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


def scan_dataflash(path: str) -> Mapping[str, Any]:
    """Contents of an ArduPilot DataFlash file, up to the first fault.

    Returns
    -------
    mapping
        ``kinds``: for each, number, name, fields (name, letter of the type, offset), bytes per message, offset of the
        instance or None, and messages by instance; ``definitions``: messages that define units, each as index of its
        kind and bytes; ``messages``, ``end`` and ``broken`` as in `scan_ulog`; ``filler``: the byte of which the rest
        consists, or None.

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
    """Bytes of fields of all messages of a kind and an instance, one array per field.

    Parameters
    ----------
    path : str
    end, kind, rows, size : int
        Numbers from `scan_dataflash`.
    instance : (int, int) or None
        Offset of the instance number in a message, and the number.
    fields : sequence of (int, int)
        Offset in a message and length. [bytes]

    Raises
    ------
    OSError
        Also if the file is no longer the one that was scanned.
    """
    return _core.dataflash_columns(path, end, kind, instance, rows, size, list(fields))


def scan_ulog(path: str) -> Mapping[str, Any]:
    """Contents of a ULog file, up to the first fault.

    Returns
    -------
    mapping
        ``formats``: definitions as bytes; ``topics``: for each, number, instance, name as bytes, rows and bytes per
        row; ``dropouts`` in milliseconds; ``unknown``: number of messages of unknown kinds; ``unfinished``: start and
        end of skipped parts; ``messages``: number of messages read; ``end``: offset where reading ended; ``broken``:
        None, or offset and fault, the latter None if the file ends within a message.

    Raises
    ------
    ValueError
        If the file is not a ULog file, or uses a newer feature that readers must know.
    OSError
    """
    return _core.scan_ulog(path)


def ulog_columns(
    path: str, *, end: int, number: int, rows: int, size: int, fields: Sequence[tuple[int, int]]
) -> list[NDArray[np.uint8]]:
    """Bytes of fields of all messages of a topic of a ULog file, one array per field.

    Parameters
    ----------
    path : str
    end, number, rows, size : int
        Numbers from `scan_ulog`.
    fields : sequence of (int, int)
        Offset in a message and length. [bytes]

    Raises
    ------
    OSError
        Also if the file is no longer the one that was scanned.
    """
    return _core.ulog_columns(path, end, number, rows, size, list(fields))


def unpacked(data: bytes) -> bytes | None:
    """A message decompressed by zstd; None if it is damaged or larger than 64 MiB."""
    return _core.unpacked(data)
