"""Small logs of ROS that unpack to gigabytes end in an error that names the limit, in seconds and within little memory."""

import bz2
import struct

import numpy as np
import pytest
import roslogs

from sigmatau.errors import DataError
from sigmatau.io.read import read
from sigmatau.io.ros_messages import IMU_ROS2
from test_hostile import command

pytest.importorskip("lz4", reason="lz4 packs what these tests read")
zstd = pytest.importorskip("backports.zstd", reason="backports.zstd packs what these tests read")

IMU_ROS1 = IMU_ROS2.replace("builtin_interfaces/Time stamp", "uint32 seq\ntime stamp")
EACH = 30_000  # messages in a chunk, 11 MB
ZEROS = np.zeros(6)


def mcap(number, compression, *, summary):
    one = roslogs.message(7, 5, roslogs.imu_cdr(5, ZEROS))
    packed = roslogs.chunk(one * EACH, compression, crc=False)
    head = roslogs.schema(1, roslogs.IMU, IMU_ROS2) + roslogs.channel(7, "/imu")
    return roslogs.mcap([head, *[packed] * number], {7: number * EACH} if summary else None, head, crc=False)


def bag_record(body, **fields):
    head = b"".join(roslogs.text(key.encode() + b"=" + value) for key, value in fields.items())
    return struct.pack("<I", len(head)) + head + struct.pack("<I", len(body)) + body


def bag(number):
    """A ROS 1 bag without an index, with chunks by bzip2."""
    said = {"topic": b"/imu", "type": b"sensor_msgs/Imu", "md5sum": b"*", "message_definition": IMU_ROS1.encode()}
    head = b"".join(roslogs.text(key.encode() + b"=" + value) for key, value in said.items())
    connection = bag_record(head, op=b"\7", conn=bytes(4), topic=b"/imu")
    message = bag_record(roslogs.imu_ros1(5, ZEROS), op=b"\2", conn=bytes(4), time=bytes(8))
    records = message * EACH
    sizes = struct.pack("<I", len(records))
    chunk = bag_record(bz2.compress(records), op=b"\5", compression=b"bz2", size=sizes)
    first = bag_record(b"", op=b"\3", index_pos=bytes(8), conn_count=bytes(4), chunk_count=bytes(4))
    return b"#ROSBAG V2.0\n" + first + connection + chunk * number


def database(path, number):
    """A ROS 2 bag of messages that are compressed by themselves, each with a name of 32 MB."""
    packed = zstd.compress(roslogs.imu_cdr(5, ZEROS, frame=b"a" * (32 << 20) + b"\0"))
    roslogs.imu_db3(path, [(k * 10**7, packed) for k in range(number)])


def write(kind, path, number):
    """So many messages of 32 MB, or three times as many chunks."""
    if kind == "db3":
        database(path, number)
    elif kind == "bag":
        path.write_bytes(bag(3 * number))
    else:
        name, _, compression = kind.partition(" ")
        path.write_bytes(mcap(3 * number, compression, summary=name == "indexed"))


@pytest.mark.parametrize("kind", ["indexed bz2", "plain lz4", "bag", "db3"])
def test_what_unpacks_to_gigabytes(tmp_path, kind):
    path = tmp_path / "log"
    write(kind, path, 60)
    assert path.stat().st_size < 10e6
    code, said, memory, seconds = command("analyze", path, "--rate", 100)
    assert (code, "--max-expansion" in said) == (1, True), said
    assert memory < 1 << 30
    assert seconds < 10


@pytest.mark.parametrize("kind", ["indexed zstd", "db3"])
def test_what_is_allowed_is_read(tmp_path, kind):
    path = tmp_path / "log"
    write(kind, path, 5)
    options = {"rate": 100, "channels": {"time": "none"}}
    with pytest.raises(DataError, match=r"expands from .* to more than 67\.1 MB"):
        read(path, **options)
    assert read(path, **options, max_expansion=1e5).provenance.rows == (5 if kind == "db3" else 15 * EACH)
