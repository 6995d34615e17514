"""Bags of ROS 2 as SQLite databases (.db3): rows by Python's own library, messages by compiled code."""

from __future__ import annotations

import re
import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np
from numpy.typing import NDArray

from sigmatau import _kernels
from sigmatau.errors import DataError
from sigmatau.io.read import roslog
from sigmatau.io.read.messages import IMU_ROS2, Layout, layout_of
from sigmatau.io.read.table import Head, Loaded, Table
from sigmatau.results import Finding

__all__ = ["read", "sniff"]

_MAGIC = b"SQLite format 3\0"
_ZSTD = b"\x28\xb5\x2f\xfd"
_TOGETHER = 1 << 14  # messages that are decoded at a time
_KNOWN = {"sensor_msgs/msg/Imu": IMU_ROS2}


def sniff(head: bytes, path: Path) -> bool:
    """Whether the file is an SQLite database."""
    return head.startswith(_MAGIC)


def read(path: Path, head: Head) -> tuple[Table, ...]:
    """A table for each topic: the numbers of its messages by the paths of their fields, stamps in nanoseconds.

    Parameters
    ----------
    path : Path
    head : Head

    Raises
    ------
    DataError
        If it is no bag, or its tables cannot be read.
    """
    if head.gzip:
        raise DataError("is an SQLite database compressed by gzip; decompress it first")
    try:
        with closing(_open(path)) as base:
            topics, definitions = _topics(base)
    except (sqlite3.Error, UnicodeDecodeError, OverflowError) as error:
        raise DataError(f"is damaged or cut off, and no topic could be read ({error}); get or make it again") from None
    if not topics:
        raise DataError("is a ROS 2 bag without topics")
    declared = _declared(path)
    tables = []
    for topic in topics:
        rows = declared.get(topic.name)
        definition = definitions.get(topic.type_name) or _KNOWN.get(topic.type_name)
        if topic.encoding != "cdr":
            tables.append(roslog.refused_table("rosbag2", topic.name, f"messages in {topic.encoding}", rows))
            continue
        if definition is None:
            why = f"the bag does not hold the definition of {topic.type_name}: convert it by `ros2 bag convert` to MCAP"
            tables.append(roslog.refused_table("rosbag2", topic.name, why, rows))
            continue
        try:
            layout = layout_of(definition, topic.type_name, ros1=False)
        except DataError as error:
            tables.append(roslog.refused_table("rosbag2", topic.name, str(error), rows))
            continue
        reader = _Reader(path=path, topic=topic, layout=layout, declared=rows)
        tables.append(roslog.message_table("rosbag2", topic.name, topic.type_name, layout, rows, reader))
    return tuple(tables)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Topic:
    id: int
    name: str
    type_name: str
    encoding: str


def _open(path: Path) -> sqlite3.Connection:
    """The database, which is not written to, nor anything beside it unless a journal lies there already."""
    beside = any(path.with_name(path.name + end).exists() for end in ("-wal", "-journal"))
    mode = "mode=ro" if beside else "mode=ro&immutable=1"
    base = sqlite3.connect(f"file:{quote(str(path.resolve()))}?{mode}", uri=True)
    # Without this SQLite refuses all of a file that is shorter than it declares.
    base.execute("PRAGMA writable_schema=ON")
    return base


def _topics(base: sqlite3.Connection) -> tuple[list[_Topic], dict[str, str]]:
    names = {name for (name,) in base.execute("SELECT name FROM sqlite_master WHERE type='table'")}
    if not {"topics", "messages"} <= names:
        raise DataError("is an SQLite database, but no ROS 2 bag: it has no tables `topics` and `messages`")
    rows = base.execute("SELECT id, name, type, serialization_format FROM topics ORDER BY id").fetchall()
    topics = [_Topic(id=i, name=n, type_name=t, encoding=e) for i, n, t, e in rows if _are(i, n, t, e)]
    definitions: dict[str, str] = {}
    if "message_definitions" in names:
        for name, encoding, text in base.execute(
            "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions"
        ):
            if encoding == "ros2msg" and isinstance(text, str) and text.strip():
                definitions[str(name)] = text
    return topics, definitions


def _are(number: object, *words: object) -> bool:
    return isinstance(number, int) and all(isinstance(word, str) for word in words)


def _declared(path: Path) -> dict[str, int]:
    """Messages by topic as metadata.yaml beside the bag declares them, if it speaks of this file alone."""
    try:
        text = (path.parent / "metadata.yaml").read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        return {}
    files = re.search(r"relative_file_paths:\s*\n((?:\s*-[^\n]*\n)+)", text)
    if files is None or [line.strip(" -\"'") for line in files[1].splitlines()] != [path.name]:
        return {}
    # The counts by file repeat those of the whole.
    whole = text.split("\n  files:")[0]
    found = re.findall(
        r"topic_metadata:(?:(?!topic_metadata:)[\s\S])*?\bname:\s*[\"']?([^\s\"']+)(?:(?!topic_metadata:)[\s\S])*?message_count:\s*(\d{1,15})\b",
        whole,
    )
    return {name: int(count) for name, count in found}


@dataclass(frozen=True, slots=True, kw_only=True)
class _Reader:
    """Loads columns of a topic."""

    path: Path
    topic: _Topic
    layout: Layout
    declared: int | None

    def __call__(self, wanted: Sequence[int], exact: int | None) -> Loaded:
        parts: list[_kernels.Decoded] = []
        rows, fault = 0, ""
        messages = self._messages()
        while not fault:
            try:
                batch = next(messages, None)
            except (sqlite3.Error, UnicodeDecodeError, OverflowError, TypeError) as error:
                fault = f"the database cannot be read further ({error})"
                break
            if batch is None:
                break
            data, ends, times = batch
            part = _kernels.decode_messages(
                data, ends, times, steps=self.layout.steps, cdr=True, wanted=wanted, exact=exact
            )
            parts.append(part)
            rows += part.rows
            if part.rows != len(ends):
                if not rows and data.startswith(_ZSTD):
                    raise DataError(
                        f"the messages of {self.topic.name} are compressed one by one: convert the bag by `ros2 bag convert`"
                    )
                fault = "a message does not hold what its definition says"
        if not rows and fault:
            raise DataError(f"{fault}: no message of {self.topic.name} could be read; get or make the file again")
        joined = {i: np.concatenate([p.columns[i] for p in parts]) if parts else np.empty(0) for i in wanted}
        decoded = _kernels.Decoded(joined, rows)
        return Loaded(
            columns=roslog.checked(decoded, self.layout, self.topic.name), findings=self._findings(rows, fault)
        )

    def _messages(self) -> Iterator[tuple[bytes, NDArray[np.int64], NDArray[np.int64]]]:
        """Messages in the order in which they were recorded, some thousand at a time, up to the first fault."""
        with closing(_open(self.path)) as base:
            cursor = base.execute(
                "SELECT data, timestamp FROM messages NOT INDEXED WHERE topic_id = ?", (self.topic.id,)
            )
            fault: Exception | None = None
            while fault is None:
                rows: list[Any] = []
                try:
                    for row in cursor:
                        rows.append(row)
                        if len(rows) == _TOGETHER:
                            break
                except (sqlite3.Error, UnicodeDecodeError, OverflowError) as error:
                    fault = error
                if rows:
                    blobs = [blob for blob, _ in rows]
                    if not all(isinstance(b, bytes) and isinstance(t, int) for b, t in rows):
                        raise TypeError("a message is no bytes")
                    ends = np.cumsum(np.fromiter(map(len, blobs), dtype=np.int64, count=len(blobs)), dtype=np.int64)
                    times = np.fromiter((t for _, t in rows), dtype=np.int64, count=len(rows))
                    yield b"".join(blobs), ends, times
                elif fault is None:
                    return
            raise fault

    def _findings(self, rows: int, fault: str) -> tuple[Finding, ...]:
        of = "" if self.declared is None else f" of {self.declared}"
        if fault:
            message = f"{fault}; {rows}{of} messages of {self.topic.name} were read up to there"
        elif self.declared is not None and self.declared != rows:
            message = (
                f"the bag holds {rows} messages of {self.topic.name} where its metadata.yaml declares {self.declared}"
            )
        else:
            return ()
        return (Finding(code="damaged", severity="error", message=message, effect=roslog.REST_MISSING),)
