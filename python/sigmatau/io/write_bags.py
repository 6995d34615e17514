"""Writers of logs of ROS: bags of ROS 1, MCAP files, and bags of ROS 2 in SQLite, piece by piece.

Sources: https://wiki.ros.org/Bags/Format/2.0, https://mcap.dev/spec, and the tables of rosbag2_storage_sqlite3.
"""

from __future__ import annotations

import contextlib
import struct
import zlib
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.frozen import frozen
from sigmatau.io.ros_messages import Topic, make_messages, make_stamps, make_topics

Piece = Sequence[NDArray[np.float64]]  # A piece of every column, each of shape (n,)
Put = Callable[[Piece], None]  # Takes the next piece

_ROWS = 1 << 12  # rows of a chunk: 1.5 MB
_LENGTH_OF_HEADER = 4096  # bytes of the first record of a bag of ROS 1
_NANO = 10**9


@frozen(eq=False)
class _Chunk:
    """Place of a chunk, and its contents by number of the topic."""

    start: int  # byte in the file
    length: int  # bytes of its record
    size: int  # bytes of its messages
    first: int  # [ns]
    last: int  # [ns]
    counts: dict[int, int]
    indices: dict[int, int]  # byte of the index of a topic
    index_length: int


def _parts(piece: Piece) -> Iterator[list[NDArray[np.float64]]]:
    for start in range(0, len(piece[0]), _ROWS):
        yield [column[start : start + _ROWS] for column in piece]


def _put_chunks(chunks: list[_Chunk], write: Callable[[Piece, int], _Chunk]) -> Put:
    """A function that divides pieces into chunks and calls `write` with each chunk and the number of rows before it."""
    rows = 0

    def put(piece: Piece) -> None:
        nonlocal rows
        for part in _parts(piece):
            chunks.append(write(part, rows))
            rows += len(part[0])

    return put


def _records(fields: list[tuple[str, Any]], messages: NDArray[Any], values: dict[str, Any]) -> NDArray[Any]:
    """Records of equal length around messages, as a structured array."""
    records = np.zeros(len(messages), dtype=np.dtype([*fields, ("data", messages.dtype)]))
    for name, value in values.items():
        records[name] = value
    records["data"] = messages
    return records


# MCAP


def _string(text: str) -> bytes:
    data = text.encode()
    return struct.pack("<I", len(data)) + data


def _record(kind: int, body: bytes) -> bytes:
    return struct.pack("<BQ", kind, len(body)) + body


_MAGIC = b"\x89MCAP0\r\n"


@contextlib.contextmanager
def mcap(path: Path, columns: Sequence[tuple[str, str]]) -> Iterator[Put]:
    """Chunks without compression, each with an index and a checksum, and a summary."""
    topics = make_topics(columns)
    schemas = b"".join(
        _record(3, struct.pack("<H", k) + _string(t.type_2) + _string("ros2msg") + _string(t.definition))
        for k, t in enumerate(topics, 1)
    )
    channels = b"".join(
        _record(4, struct.pack("<HH", k, k) + _string(t.name) + _string("cdr") + _string(""))
        for k, t in enumerate(topics, 1)
    )
    chunks: list[_Chunk] = []
    with path.open("wb") as stream:
        stream.write(_MAGIC + _record(1, _string("ros2") + _string("sigmatau")) + schemas + channels)
        yield _put_chunks(chunks, partial(_put_mcap_chunk, stream, topics))
        stream.write(_record(15, struct.pack("<I", 0)))
        start = stream.tell()
        stream.write(schemas + channels + b"".join(map(_chunk_index, chunks)) + _statistics(chunks, len(topics)))
        stream.write(_record(2, struct.pack("<QQI", start, 0, 0)) + _MAGIC)


def _put_mcap_chunk(stream: IO[bytes], topics: Sequence[Topic], part: Piece, rows: int) -> _Chunk:
    stamps = make_stamps(part[0])
    head = [("kind", "u1"), ("length", "<u8"), ("channel", "<u2"), ("sequence", "<u4"), ("log", "<u8"), ("sent", "<u8")]
    blocks, indices, size = [], {}, 0
    for number, topic in enumerate(topics, 1):
        messages = make_messages(topic, part, stamps)
        values = {
            "kind": 5,
            "length": 22 + messages.dtype.itemsize,
            "channel": number,
            "sequence": np.arange(rows, rows + len(stamps)) % 2**32,
            "log": stamps,
            "sent": stamps,
        }
        records = _records([*head], messages, values)
        pairs = np.empty((len(stamps), 2), dtype="<u8")
        pairs[:, 0] = stamps
        pairs[:, 1] = size + records.dtype.itemsize * np.arange(len(stamps))
        indices[number] = _record(7, struct.pack("<HI", number, pairs.nbytes) + pairs.tobytes())
        blocks.append(records.tobytes())
        size += len(blocks[-1])
    data = b"".join(blocks)
    first, last, start = int(stamps.min()), int(stamps.max()), stream.tell()
    body = struct.pack("<QQQI", first, last, size, zlib.crc32(data)) + _string("") + struct.pack("<Q", size)
    stream.write(struct.pack("<BQ", 6, len(body) + size) + body)
    stream.write(data)
    length, places = stream.tell() - start, {}
    for number, index in indices.items():
        places[number] = stream.tell()
        stream.write(index)
    return _Chunk(
        start=start,
        length=length,
        size=size,
        first=first,
        last=last,
        counts=dict.fromkeys(indices, len(stamps)),
        indices=places,
        index_length=sum(map(len, indices.values())),
    )


def _chunk_index(chunk: _Chunk) -> bytes:
    places = b"".join(struct.pack("<HQ", *pair) for pair in chunk.indices.items())
    body = struct.pack("<QQQQI", chunk.first, chunk.last, chunk.start, chunk.length, len(places)) + places
    return _record(
        8, body + struct.pack("<Q", chunk.index_length) + _string("") + struct.pack("<QQ", chunk.size, chunk.size)
    )


def _statistics(chunks: Sequence[_Chunk], topics: int) -> bytes:
    totals = {number: sum(chunk.counts[number] for chunk in chunks) for number in range(1, topics + 1)}
    counts = b"".join(struct.pack("<HQ", *pair) for pair in totals.items())
    first, last = min((c.first for c in chunks), default=0), max((c.last for c in chunks), default=0)
    numbers = (sum(totals.values()), topics, topics, 0, 0, len(chunks), first, last, len(counts))
    return _record(11, struct.pack("<QHIIIIQQI", *numbers) + counts)


# ROS 1


def _fields(fields: dict[str, bytes]) -> bytes:
    """The header of a record: its fields, each with its length."""
    return b"".join(
        struct.pack("<I", len(name) + 1 + len(value)) + name.encode() + b"=" + value for name, value in fields.items()
    )


def _bag_record(fields: dict[str, bytes], data: bytes) -> bytes:
    head = _fields(fields)
    return struct.pack("<I", len(head)) + head + struct.pack("<I", len(data)) + data


def _bag_time(stamp: int) -> bytes:
    return struct.pack("<II", stamp // _NANO, stamp % _NANO)


def _bag_header(*, index: int, topics: int, chunks: int) -> bytes:
    """The first record, filled with blanks to its length."""
    head = _fields(
        {
            "op": b"\x03",
            "index_pos": struct.pack("<Q", index),
            "conn_count": struct.pack("<I", topics),
            "chunk_count": struct.pack("<I", chunks),
        }
    )
    blank = _LENGTH_OF_HEADER - 8 - len(head)
    return struct.pack("<I", len(head)) + head + struct.pack("<I", blank) + b" " * blank


@contextlib.contextmanager
def bag(path: Path, columns: Sequence[tuple[str, str]]) -> Iterator[Put]:
    """A bag of ROS 1, version 2.0, chunks without compression."""
    topics = make_topics(columns)
    connections = b"".join(_connection(number, topic) for number, topic in enumerate(topics))
    chunks: list[_Chunk] = []
    with path.open("wb") as stream:
        stream.write(b"#ROSBAG V2.0\n" + _bag_header(index=0, topics=0, chunks=0))
        yield _put_chunks(chunks, partial(_put_bag_chunk, stream, topics, connections))
        index = stream.tell()
        stream.write(connections + b"".join(map(_chunk_info, chunks)))
        stream.seek(len(b"#ROSBAG V2.0\n"))
        stream.write(_bag_header(index=index, topics=len(topics), chunks=len(chunks)))


def _connection(number: int, topic: Topic) -> bytes:
    name = topic.name.encode()
    data = _fields(
        {
            "topic": name,
            "type": topic.type.encode(),
            "md5sum": topic.md5.encode(),
            "message_definition": topic.definition_1.encode(),
        }
    )
    return _bag_record({"op": b"\x07", "conn": struct.pack("<I", number), "topic": name}, data)


def _put_bag_chunk(stream: IO[bytes], topics: Sequence[Topic], connections: bytes, part: Piece, rows: int) -> _Chunk:
    stamps = make_stamps(part[0])
    blocks, indices, size = [connections], [], len(connections)
    for number, topic in enumerate(topics):
        messages = make_messages(topic, part, stamps, ros1=True, first=rows)
        head = _fields({"op": b"\x02", "conn": struct.pack("<I", number), "time": bytes(8)})
        before, after = head[:-8], 8  # The time is the last field
        fields = [
            ("head_length", "<u4"),
            ("head", f"V{len(before)}"),
            ("sec", "<u4"),
            ("nanosec", "<u4"),
            ("length", "<u4"),
        ]
        values = {
            "head_length": len(before) + after,
            "head": np.void(before),
            "sec": stamps // _NANO,
            "nanosec": stamps % _NANO,
            "length": messages.dtype.itemsize,
        }
        records = _records([*fields], messages, values)
        index = np.empty((len(stamps), 3), dtype="<u4")
        index[:, 0], index[:, 1] = stamps // _NANO, stamps % _NANO
        index[:, 2] = size + records.dtype.itemsize * np.arange(len(stamps))
        count = struct.pack("<I", len(stamps))
        index_fields = {"op": b"\x04", "ver": struct.pack("<I", 1), "conn": struct.pack("<I", number), "count": count}
        indices.append(_bag_record(index_fields, index.tobytes()))
        blocks.append(records.tobytes())
        size += len(blocks[-1])
    start = stream.tell()
    stream.write(
        _bag_record({"op": b"\x05", "compression": b"none", "size": struct.pack("<I", size)}, b"".join(blocks))
    )
    length = stream.tell() - start
    stream.write(b"".join(indices))
    return _Chunk(
        start=start,
        length=length,
        size=size,
        first=int(stamps.min()),
        last=int(stamps.max()),
        counts=dict.fromkeys(range(len(topics)), len(stamps)),
        indices={},
        index_length=sum(map(len, indices)),
    )


def _chunk_info(chunk: _Chunk) -> bytes:
    fields = {
        "op": b"\x06",
        "ver": struct.pack("<I", 1),
        "chunk_pos": struct.pack("<Q", chunk.start),
        "start_time": _bag_time(chunk.first),
        "end_time": _bag_time(chunk.last),
        "count": struct.pack("<I", len(chunk.counts)),
    }
    return _bag_record(fields, b"".join(struct.pack("<II", *pair) for pair in chunk.counts.items()))


# ROS 2, SQLite

_TABLES = """
CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);
CREATE TABLE metadata(id INTEGER PRIMARY KEY, metadata_version INTEGER NOT NULL, metadata TEXT NOT NULL);
CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, serialization_format TEXT NOT NULL,
  offered_qos_profiles TEXT NOT NULL, type_description_hash TEXT NOT NULL);
CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT NOT NULL, encoding TEXT NOT NULL,
  encoded_message_definition TEXT NOT NULL, type_description_hash TEXT NOT NULL);
CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB NOT NULL);
CREATE INDEX timestamp_idx ON messages (timestamp ASC);
INSERT INTO schema VALUES (4, 'jazzy');
"""


@contextlib.contextmanager
def _sqlite_errors_of_a_file() -> Iterator[None]:
    """Turn the SQLite error of a full disk into `OSError`, as for other formats."""
    import sqlite3

    try:
        yield
    except sqlite3.OperationalError as error:
        raise OSError(str(error)) from None


@contextlib.contextmanager
def db3(path: Path, columns: Sequence[tuple[str, str]]) -> Iterator[Put]:
    """A bag of ROS 2 in one file, without metadata.yaml: ``ros2 bag`` takes the file itself."""
    import sqlite3

    topics = make_topics(columns)
    with _sqlite_errors_of_a_file(), contextlib.closing(sqlite3.connect(path, isolation_level=None)) as base:
        base.execute("PRAGMA journal_mode = OFF")
        base.execute("PRAGMA synchronous = OFF")
        base.executescript(_TABLES)
        for number, topic in enumerate(topics, 1):
            base.execute("INSERT INTO topics VALUES (?, ?, ?, 'cdr', '', '')", (number, topic.name, topic.type_2))
            definition = (number, topic.type_2, "ros2msg", topic.definition, "")
            base.execute("INSERT INTO message_definitions VALUES (?, ?, ?, ?, ?)", definition)

        def put(piece: Piece) -> None:
            for part in _parts(piece):
                stamps = make_stamps(part[0])
                for number, topic in enumerate(topics, 1):
                    messages = make_messages(topic, part, stamps)
                    data, size = messages.tobytes(), messages.dtype.itemsize
                    rows = ((number, stamp, data[k * size : (k + 1) * size]) for k, stamp in enumerate(stamps.tolist()))
                    base.executemany("INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)", rows)

        base.execute("BEGIN")
        yield put
        base.execute("COMMIT")
