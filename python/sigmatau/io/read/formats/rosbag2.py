"""ROS 2 bags in SQLite databases (.db3): rows by the sqlite3 module, messages by compiled code."""

from __future__ import annotations

import re
import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import replace
from functools import partial
from pathlib import Path
from urllib.parse import quote

import numpy as np

from sigmatau._native import logs
from sigmatau.errors import DataError
from sigmatau.findings.finding import Finding
from sigmatau.frozen import frozen
from sigmatau.io.read.formats import damage, roslog, split
from sigmatau.io.read.formats.damage import largest_expansion, refuse_expansion
from sigmatau.io.read.formats.messages import MessageLayout
from sigmatau.io.read.table import Head, Loaded, Table
from sigmatau.io.ros_messages import IMU_ROS2

_ZSTD = b"\x28\xb5\x2f\xfd"
_BATCH = 1 << 14  # number of messages that are decoded together
_DEFINITIONS = {"sensor_msgs/msg/Imu": IMU_ROS2}


def read(path: Path, head: Head) -> tuple[Table, ...]:
    """Read a table for each topic. Columns are named by the path of a field; times are in nanoseconds."""
    try:
        with closing(_open(path)) as base:
            topics, definitions = _topics(base)
            compressed = {topic.id for topic in topics if _is_compressed(base, topic.id)}
    except (sqlite3.Error, UnicodeDecodeError, OverflowError) as error:
        raise DataError(
            f"is damaged or truncated, and no topic could be read ({error}); copy or record it again"
        ) from None
    if not topics:
        raise DataError("is a ROS 2 bag without topics")
    declared = _declared(path)
    tables = []
    for topic in topics:
        rows = declared.get(topic.name)
        definition = definitions.get(topic.type_name) or _DEFINITIONS.get(topic.type_name)
        if topic.encoding != "cdr" or definition is None:
            why = f"no definition of {topic.type_name} in the bag: convert it by `ros2 bag convert` to MCAP"
            why = why if topic.encoding == "cdr" else f"messages in {topic.encoding}"
            tables.append(roslog.refused_table("rosbag2", topic.name, why, rows))
            continue
        load = partial(_load, path, topic, rows, topic.id in compressed)
        tables.append(roslog.message_table("rosbag2", topic.name, topic.type_name, definition, load, rows))
    findings = _trailing_pages(path)
    return tuple(replace(table, findings=findings) for table in roslog.some_readable(tables))


@frozen
class _Topic:
    id: int
    name: str
    type_name: str
    encoding: str


def _open(path: Path) -> sqlite3.Connection:
    """Open the database for reading. No file is written beside it unless a journal exists."""
    has_journal = any(path.with_name(path.name + end).exists() for end in ("-wal", "-journal"))
    mode = "mode=ro" if has_journal else "mode=ro&immutable=1"
    base = sqlite3.connect(f"file:{quote(str(path.resolve()))}?{mode}", uri=True)
    # Otherwise SQLite refuses a file that is shorter than it declares.
    base.execute("PRAGMA writable_schema=ON")
    return base


def _topics(base: sqlite3.Connection) -> tuple[list[_Topic], dict[str, str]]:
    names = {name for (name,) in base.execute("SELECT name FROM sqlite_master WHERE type='table'")}
    if not {"topics", "messages"} <= names:
        raise DataError("is an SQLite database but not a ROS 2 bag: it has no tables `topics` and `messages`")
    rows = base.execute("SELECT id, name, type, serialization_format FROM topics ORDER BY id").fetchall()
    topics = [_Topic(id=i, name=n, type_name=t, encoding=e) for i, n, t, e in rows if _has_types(i, n, t, e)]
    definitions: dict[str, str] = {}
    if "message_definitions" in names:
        for name, encoding, text in base.execute(
            "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions"
        ):
            if encoding == "ros2msg" and isinstance(text, str) and text.strip():
                definitions[str(name)] = text
    return topics, definitions


def _cut(path: Path) -> bool:
    """Whether the file is shorter than its header declares."""
    with path.open("rb") as file:
        head = file.read(32)
    page = int.from_bytes(head[16:18], "big")
    return path.stat().st_size < (65536 if page == 1 else page) * int.from_bytes(head[28:32], "big")


def _trailing_pages(path: Path) -> tuple[Finding, ...]:
    """Findings of bytes after the pages that the header declares, if the header is up to date."""
    with path.open("rb") as file:
        head = file.read(100)
    page, pages = int.from_bytes(head[16:18], "big"), int.from_bytes(head[28:32], "big")
    if len(head) < 100 or pages == 0 or head[24:28] != head[92:96] or path.with_name(path.name + "-wal").exists():
        return ()
    return damage.trailing_bytes(path, pages * (65536 if page == 1 else page), "the database")


def _is_compressed(base: sqlite3.Connection, number: int) -> bool:
    """Whether the first message of a topic is compressed by zstd, by its signature."""
    try:
        first = base.execute("SELECT data FROM messages WHERE topic_id = ? LIMIT 1", (number,)).fetchone()
    except sqlite3.Error:
        return False
    return first is not None and isinstance(first[0], bytes) and first[0].startswith(_ZSTD)


def _intact(path: Path) -> bool:
    """Whether SQLite finds the database intact; this reads the whole file."""
    try:
        with closing(_open(path)) as base:
            return base.execute("PRAGMA quick_check(1)").fetchone() == ("ok",) and not _cut(path)
    except (sqlite3.Error, UnicodeDecodeError):
        return False


def _has_types(number: object, *words: object) -> bool:
    return isinstance(number, int) and all(isinstance(word, str) for word in words)


def _declared(path: Path) -> dict[str, int]:
    """Number of messages by topic, as metadata.yaml declares it if this file is its only one."""
    if split.bag_files(path.parent) != (path,):
        return {}
    text = (path.parent / split.METADATA).read_text(encoding="utf-8")
    declared = {}
    for item in re.split(r"\n\s*- (?=topic_metadata:|message_count:)", text.partition("topics_with_message_count:")[2]):
        name = re.search(r"\bname:\s*[\"']?([^\s\"']+)", item)
        count = re.search(r"\bmessage_count:\s*(\d{1,15})\b", item)
        if name and count:
            declared[name[1]] = int(count[1])
    return declared


def _load(
    path: Path,
    topic: _Topic,
    declared: int | None,
    compressed: bool,  # noqa: FBT001  bound before the others: each message by zstd
    layout: MessageLayout,
    wanted: Sequence[int],
    exact: int | None,
) -> Loaded:
    """Load columns of a topic, up to the fault if there is one."""
    parts: list[logs.Decoded] = []
    rows, doubt, fault = 0, 0, ""
    try:
        for blobs, times, fault, doubt in _messages(path, topic.id, compressed=compressed):
            ends = np.cumsum(np.fromiter(map(len, blobs), dtype=np.int64, count=len(blobs)), dtype=np.int64)
            stamps = np.array(times, dtype=np.int64)
            data = b"".join(blobs)
            part = logs.decode_messages(data, ends, stamps, steps=layout.steps, cdr=True, wanted=wanted, exact=exact)
            parts.append(part)
            rows += part.rows
            if part.rows != len(blobs):
                fault, doubt = "a message does not match its definition", 0
                break
    except (sqlite3.Error, UnicodeDecodeError) as error:
        fault = f"the database cannot be read ({error})"
    rows = max(0, rows - doubt)
    if not rows and fault:
        raise DataError(f"{fault}: no message of {topic.name} could be read; copy or record the file again")
    joined = {i: np.concatenate([part.columns[i] for part in parts])[:rows] for i in wanted}
    if not fault and declared in (None, rows):
        return Loaded(columns=joined)
    share = {"kept": rows, "declared": declared, "counted": "messages", "topic": topic.name}
    return Loaded(columns=joined, findings=(damage.fault(truncated=bool(fault) and _cut(path), reason=fault, **share),))


def _messages(path: Path, topic: int, *, compressed: bool) -> Iterator[tuple[list[bytes], list[int], str, int]]:
    """Batches of messages and their stamps in the order of recording. The last batch names the fault, if any, and the
    number of messages before it that may be damaged.
    """
    with closing(_open(path)) as base:
        (page,) = base.execute("PRAGMA page_size").fetchone()
        cursor = base.execute(
            "SELECT id, CASE WHEN topic_id = ? THEN data ELSE 0 END, timestamp FROM messages NOT INDEXED", (topic,)
        )
        fault, last, intact = "", None, None
        shortest = page
        stored, unpacked = path.stat().st_size, 0
        while not fault:
            blobs: list[bytes] = []
            times: list[int] = []
            count = 0
            try:
                for number, blob, stamp in cursor:
                    # Numbers run over all topics. SQLite skips pages that it cannot read. In an intact database
                    # missing messages were deleted, for example by a filter.
                    if last is not None and number != last + 1:
                        if isinstance(number, int) and number > last and intact is None:
                            intact = _intact(path)
                        if not intact or number <= last:
                            fault = f"message {number!r} follows message {last} of all topics"
                            break
                    last = number
                    count += 1
                    if blob != 0:
                        if compressed and isinstance(blob, bytes):
                            blob = logs.unpacked(blob)
                            unpacked += len(blob or b"")
                            if unpacked > largest_expansion(stored):
                                refuse_expansion(stored, None)
                        if not (isinstance(blob, bytes) and isinstance(stamp, int) and abs(stamp) < 1 << 63):
                            fault = f"message {number} of all topics is not valid"
                            break
                        blobs.append(blob)
                        times.append(stamp)
                    if count == _BATCH:
                        break
            except (sqlite3.Error, UnicodeDecodeError, OverflowError, TypeError) as error:
                fault = f"the database cannot be read further ({error})"
            if (
                not count and not fault and _cut(path)
            ):  # SQLite reads an incomplete page as if it were filled with zeros
                fault = "the last page of the database is incomplete"
            shortest = min(map(len, blobs), default=shortest)
            # The messages before the fault may come from an incomplete page.
            yield blobs, times, fault, 1 + page // max(1, shortest) if fault else 0
            if not count and not fault:
                return
