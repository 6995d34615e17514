"""Logs of ROS made for tests: by rosbags, which is another's, and MCAP by its published specification."""

import bz2
import struct
import zlib

import numpy as np

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
    """The same as ROS 1 writes it: without alignment and header."""
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
    from sigmatau.io.read.formats.messages import IMU_ROS2

    stamps, values = imu(n)
    head = schema(1, IMU, IMU_ROS2) + channel(7, topic)
    messages = [message(7, s + 1000, imu_cdr(s, v)) for s, v in zip(stamps, values, strict=True)]
    parts = [
        chunk((head if k == 0 else b"") + b"".join(messages[k : k + per_chunk]), compression, crc=crc)
        for k in range(0, n, per_chunk)
    ]
    return mcap([extra, *parts], {7: n} if summary else None, head, crc=crc), stamps, values
