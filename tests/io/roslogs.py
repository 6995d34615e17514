"""Logs of ROS for tests: by the independent package rosbags, and MCAP by its published specification."""

import bz2
import contextlib
import sqlite3
import struct
import zlib

import numpy as np
import pytest

IMU = "sensor_msgs/msg/Imu"
START = 1_700_000_000_123_456_789


def imu(n, seed=1):
    """Stamps [ns], shape (n,), and six channels, shape (n, 6), as doubles without a short decimal form."""
    stamps = START + np.arange(n, dtype=np.int64) * 5_000_000
    return stamps, np.random.default_rng(seed).normal(size=(n, 6))


def imu_cdr(stamp, values, *, order="<", frame=b"imu_link\0"):
    """A message by OMG DDS-RTPS 2.2, section 10: little-endian or not, aligned to the size of each number."""
    body = struct.pack(f"{order}iII", int(stamp) // 10**9, int(stamp) % 10**9, len(frame)) + frame
    body += bytes(-len(body) % 8)
    numbers = [0.0, 0.0, 0.0, 1.0, *[-1.0] * 9, *values[:3], *[0.0] * 9, *values[3:], *[0.0] * 9]
    return (b"\0\1\0\0" if order == "<" else b"\0\0\0\0") + body + struct.pack(f"{order}37d", *numbers)


def imu_ros1(stamp, values, seq=0, frame=b"imu_link"):
    """The message in the form of ROS 1: without alignment and header."""
    numbers = [0.0, 0.0, 0.0, 1.0, *[-1.0] * 9, *values[:3], *[0.0] * 9, *values[3:], *[0.0] * 9]
    head = struct.pack("<IIII", seq, int(stamp) // 10**9, int(stamp) % 10**9, len(frame)) + frame
    return head + struct.pack("<37d", *numbers)


def text(word):
    data = word if isinstance(word, bytes) else word.encode()
    return struct.pack("<I", len(data)) + data


def record(opcode, body):
    return struct.pack("<BQ", opcode, len(body)) + body


def schema(number, name, definition, encoding="ros2msg"):
    return record(3, struct.pack("<H", number) + text(name) + text(encoding) + text(definition))


def channel(number, topic, schema_number=1, encoding="cdr"):
    return record(4, struct.pack("<HH", number, schema_number) + text(topic) + text(encoding) + text(b""))


def message(number, time, data):
    return record(5, struct.pack("<HIQQ", number, 0, int(time), int(time)) + data)


def chunk(records, compression="", *, crc=True):
    import lz4.frame
    from backports import zstd

    pack = {"": bytes, "zstd": zstd.compress, "lz4": lz4.frame.compress, "bz2": bz2.compress}[compression]
    packed = pack(records)
    head = struct.pack("<QQQI", 0, 0, len(records), zlib.crc32(records) if crc else 0)
    return record(6, head + text(compression) + struct.pack("<Q", len(packed)) + packed)


def mcap(parts, counts=None, repeated=b"", *, crc=True):
    """A file from records; with `counts`, messages by channel, it has a summary that repeats schemas and channels."""
    data = b"\x89MCAP0\r\n" + record(1, text("") + text("test")) + b"".join(parts)
    data += record(15, struct.pack("<I", zlib.crc32(data) if crc else 0))
    start = len(data) if counts is not None else 0
    summary = b""
    if counts is not None:
        pairs = b"".join(struct.pack("<HQ", number, n) for number, n in counts.items())
        statistics = struct.pack("<QHIIIIQQ", sum(counts.values()), 1, len(counts), 0, 0, 1, 0, 0) + text(pairs)
        summary = repeated + record(11, statistics)
    footer = summary + struct.pack("<BQQQ", 2, 20, start, 0)
    return data + footer + struct.pack("<I", zlib.crc32(footer) if crc else 0) + b"\x89MCAP0\r\n"


def imu_mcap(n, per_chunk, compression="zstd", *, crc=True, summary=True, topic="/imu", extra=b""):
    """An MCAP file of Imu messages in chunks, and the numbers in it."""
    from sigmatau.io.ros_messages import IMU_ROS2

    stamps, values = imu(n)
    head = schema(1, IMU, IMU_ROS2) + channel(7, topic)
    messages = [message(7, s + 1000, imu_cdr(s, v)) for s, v in zip(stamps, values, strict=True)]
    parts = [
        chunk((head if k == 0 else b"") + b"".join(messages[k : k + per_chunk]), compression, crc=crc)
        for k in range(0, n, per_chunk)
    ]
    return mcap([extra, *parts], {7: n} if summary else None, head, crc=crc), stamps, values


def imu_db3(path, messages, numbers=None):
    """A bag of SQLite with these stamps and serialized messages."""
    numbers = range(1, len(messages) + 1) if numbers is None else numbers
    with contextlib.closing(sqlite3.connect(path)) as base, base:
        base.execute("CREATE TABLE topics (id INTEGER PRIMARY KEY, name, type, serialization_format)")
        base.execute("CREATE TABLE messages (id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB)")
        base.execute("INSERT INTO topics VALUES (1, '/imu', ?, 'cdr')", (IMU,))
        rows = [(number, int(stamp), data) for number, (stamp, data) in zip(numbers, messages, strict=True)]
        base.executemany("INSERT INTO messages VALUES (?, 1, ?, ?)", rows)


N = 600


def rosbags_log(kind, folder, n=N):
    """A log by rosbags, and the numbers in it."""
    pytest.importorskip("rosbags", reason="rosbags writes what these tests read")
    from rosbags import rosbag1, rosbag2
    from rosbags.typesys import Stores, get_typestore

    stamps, values = imu(n)
    ros1 = kind.startswith("bag")
    if ros1:
        path = folder / "log.bag"
        writer = rosbag1.Writer(path)
        if kind != "bag":
            writer.set_compression(rosbag1.Writer.CompressionFormat[kind.removeprefix("bag-").upper()])
    else:
        path = folder / kind / f"{kind}.{kind.split('-')[0]}"
        plugin = rosbag2.StoragePlugin.MCAP if kind.startswith("mcap") else rosbag2.StoragePlugin.SQLITE3
        writer = rosbag2.Writer(folder / kind, version=9, storage_plugin=plugin)
        if kind == "mcap-zstd":
            writer.set_compression(rosbag2.CompressionMode.STORAGE, rosbag2.CompressionFormat.ZSTD)
    store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_HUMBLE)
    with writer:
        connection = writer.add_connection("/imu", IMU, typestore=store)
        note = writer.add_connection("/note", "std_msgs/msg/String", typestore=store)
        for stamp, row in zip(stamps.tolist(), values.tolist(), strict=True):
            writer.write(connection, stamp + 1000, imu_ros1(stamp, row) if ros1 else imu_cdr(stamp, row))
        writer.write(note, stamp, text("hello") if ros1 else b"\0\1\0\0" + text(b"hello\0"))
    return path, stamps, values


KINDS = ["mcap", "mcap-zstd", "db3", "bag", "bag-lz4", "bag-bz2"]
