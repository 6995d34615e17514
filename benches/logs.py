"""One log in every format, written by libraries or from the published layout, independently of our readers.

Samples are doubles that a float32 holds, so that every format can hold them exactly; stamps are nanoseconds since 1970.
"""

from __future__ import annotations

import gzip
import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benches import texts
from benches.texts import CHANNELS as CHANNELS

START = 1_700_000_000_000_000_000
STEP = 5_000_000  # 200 Hz

Values = NDArray[np.float64]
Stamps = NDArray[np.int64]

_SI: dict[str, Any] = {"unit": {"gyro": "rad/s", "accel": "m/s^2", "time": "s"}}


@dataclass(frozen=True)
class Kind:
    """A format.

    `make(folder, stamps, values)` writes a log and returns its path; `options`: options that `sigmatau.read` needs;
    `streams`: whether it is read without holding the file in memory; `checked`: whether a checksum or the text shows
    damage.
    """

    make: Callable[[Path, Stamps, Values], Path]
    options: Mapping[str, Any] = field(default_factory=dict)
    streams: bool = True
    checked: bool = False
    longest: int | None = None  # rows of the longest measured log, if the format is not intended for longer logs


def made(n: int, seed: int = 1) -> tuple[Stamps, Values]:
    """Stamps, shape (n,), and values, shape (n, 6)."""
    values = np.random.default_rng(seed).normal(size=(n, 6)).astype(np.float32).astype(np.float64)
    return START + STEP * np.arange(n, dtype=np.int64), values


def _text(stamps: Stamps, values: Values, delimiter: str = ",") -> str:
    units = ["rad/s"] * 3 + ["m/s^2"] * 3
    head = delimiter.join(["time [ns]", *(f"{c} [{u}]" for c, u in zip(CHANNELS, units, strict=True))])
    rows = zip(stamps.tolist(), *(values[:, k].tolist() for k in range(6)), strict=True)
    body = "\n".join(delimiter.join(map(repr, row)) for row in rows)
    return f"{head}\n{body}\n"


def _csv(folder: Path, stamps: Stamps, values: Values) -> Path:
    path = folder / "log.csv"
    path.write_text(_text(stamps, values))
    return path


def _csv_gz(folder: Path, stamps: Stamps, values: Values) -> Path:
    path = folder / "log.csv.gz"
    path.write_bytes(gzip.compress(_text(stamps, values).encode(), 1))
    return path


def _decimal_comma(folder: Path, stamps: Stamps, values: Values) -> Path:
    path = folder / "comma.csv"
    path.write_text(_text(stamps, values, ";").replace(".", ","))
    return path


def _utf16(folder: Path, stamps: Stamps, values: Values) -> Path:
    path = folder / "utf16.csv"
    path.write_text(_text(stamps, values, "\t"), encoding="utf-16")
    return path


def _vectornav(folder: Path, stamps: Stamps, values: Values) -> Path:
    def sentence(row: list[float]) -> str:
        # Magnetic field, acceleration, angular rate, temperature, pressure.
        numbers = ",".join(map(repr, [0.1, 0.2, 0.3, *row[3:], *row[:3], 25.5, 101.3]))
        body = f"VNIMU,{numbers}"
        check = int(np.bitwise_xor.reduce(np.frombuffer(body.encode(), dtype=np.uint8)))
        return f"${body}*{check:02X}\r\n"

    path = folder / "vn.txt"
    path.write_text("".join(map(sentence, values.tolist())), newline="")
    return path


def _npy(folder: Path, stamps: Stamps, values: Values) -> Path:
    path = folder / "log.npy"
    np.save(path, np.column_stack([(stamps - START) * 1e-9, values]))
    return path


def _npz(folder: Path, stamps: Stamps, values: Values) -> Path:
    path = folder / "log.npz"
    np.savez(path, time_ns=stamps, gyro_rad_s=values[:, :3], accel_m_s2=values[:, 3:])
    return path


def _raw(folder: Path, stamps: Stamps, values: Values) -> Path:
    rows = np.empty(len(stamps), dtype=[("t", "<u8"), ("v", "<f4", 6)])
    rows["t"], rows["v"] = stamps, values
    path = folder / "log.raw"
    path.write_bytes(rows.tobytes())
    return path


def _ulog(folder: Path, stamps: Stamps, values: Values) -> Path:
    def message(kind: bytes, payload: bytes) -> bytes:
        return struct.pack("<H", len(payload)) + kind + payload

    fields = "uint64_t timestamp;float[3] gyro_rad;float[3] accelerometer_m_s2;"
    head = b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 10) + message(b"B", bytes(40))
    head += message(b"F", f"sensor_combined:{fields}".encode())
    head += message(b"A", struct.pack("<BH", 0, 3) + b"sensor_combined")
    rows = np.empty(len(stamps), dtype=[("size", "<u2"), ("kind", "S1"), ("id", "<u2"), ("t", "<u8"), ("v", "<f4", 6)])
    rows["size"], rows["kind"], rows["id"], rows["t"], rows["v"] = 34, b"D", 3, stamps // 1000, values
    path = folder / "log.ulg"
    path.write_bytes(head + rows.tobytes())
    return path


def _dataflash(folder: Path, stamps: Stamps, values: Values) -> Path:
    def form(number: int, length: int, name: str, letters: str, columns: str) -> bytes:
        words = struct.pack("<4s16s64s", name.encode(), letters.encode(), columns.encode())
        return b"\xa3\x95\x80" + bytes([number, length]) + words

    head = form(128, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns")
    head += form(82, 36, "IMU", "QBffffff", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ")
    rows = np.empty(len(stamps), dtype=[("mark", "<u2"), ("id", "u1"), ("t", "<u8"), ("i", "u1"), ("v", "<f4", 6)])
    rows["mark"], rows["id"], rows["i"], rows["t"], rows["v"] = 0x95A3, 82, 0, (stamps - START) // 1000, values
    path = folder / "log.bin"
    path.write_bytes(head + rows.tobytes())
    return path


_IMU = "sensor_msgs/msg/Imu"


def _imu(stamps: Stamps, values: Values, head: bytes) -> NDArray[Any]:
    """Messages in the form of ROS, with `head` before the stamp; shape (n,) of rows of bytes."""
    ros2 = len(head) == 4
    frame = b"imu\0" if ros2 else b"imu"
    pad = -(12 + len(frame)) % 8 if ros2 else 0
    parts = [
        ("head", f"S{len(head)}"),
        ("t", "<u4", 2),
        ("length", "<u4"),
        ("frame", f"S{len(frame)}"),
        ("pad", "u1", pad),
    ]
    rows = np.zeros(len(stamps), dtype=[*parts, ("numbers", "<f8", 37)])
    rows["head"], rows["length"], rows["frame"] = head, len(frame), frame
    rows["t"] = np.column_stack(np.divmod(stamps, 10**9))
    rows["numbers"][:, 3] = 1.0
    rows["numbers"][:, 13:16], rows["numbers"][:, 25:28] = values[:, :3], values[:, 3:]
    return rows


def _messages(stamps: Stamps, rows: NDArray[Any]) -> Any:
    data, size = rows.tobytes(), rows.dtype.itemsize
    return ((stamp, data[k * size : (k + 1) * size]) for k, stamp in enumerate(stamps.tolist()))


def _ros2(folder: Path, stamps: Stamps, values: Values, plugin: str) -> Path:
    from rosbags import rosbag2
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    writer = rosbag2.Writer(folder / plugin, version=9, storage_plugin=rosbag2.StoragePlugin[plugin])
    if plugin == "MCAP":
        writer.set_compression(rosbag2.CompressionMode.STORAGE, rosbag2.CompressionFormat.ZSTD)
    with writer:
        connection = writer.add_connection("/imu", _IMU, typestore=store)
        for stamp, data in _messages(stamps, _imu(stamps, values, b"\0\1\0\0")):
            writer.write(connection, stamp, data)
    return next(path for path in (folder / plugin).iterdir() if path.suffix in (".mcap", ".db3"))


def _mcap(folder: Path, stamps: Stamps, values: Values) -> Path:
    return _ros2(folder, stamps, values, "MCAP")


def _db3(folder: Path, stamps: Stamps, values: Values) -> Path:
    return _ros2(folder, stamps, values, "SQLITE3")


def _bag(folder: Path, stamps: Stamps, values: Values) -> Path:
    from rosbags import rosbag1
    from rosbags.typesys import Stores, get_typestore

    path = folder / "log.bag"
    writer = rosbag1.Writer(path)
    writer.set_compression(rosbag1.Writer.CompressionFormat.LZ4)
    with writer:
        connection = writer.add_connection("/imu", _IMU, typestore=get_typestore(Stores.ROS1_NOETIC))
        for stamp, data in _messages(stamps, _imu(stamps, values, b"\0\0\0\1")[["t", "length", "frame", "numbers"]]):
            writer.write(connection, stamp, data)
    return path


def _named(stamps: Stamps, values: Values) -> dict[str, NDArray[Any]]:
    return {"time": (stamps - START) * 1e-9} | {c: values[:, k] for k, c in enumerate(CHANNELS)}


def _matlab5(folder: Path, stamps: Stamps, values: Values) -> Path:
    from scipy.io import savemat

    path = folder / "log5.mat"
    savemat(path, _named(stamps, values))
    return path


def _matlab7(folder: Path, stamps: Stamps, values: Values) -> Path:
    from scipy.io import savemat

    path = folder / "log7.mat"
    savemat(path, _named(stamps, values), do_compression=True)
    return path


def _hdf5(folder: Path, stamps: Stamps, values: Values) -> Path:
    import h5py

    path = folder / "log.h5"
    with h5py.File(path, "w") as file:
        for name, column in _named(stamps, values).items():
            data = file.create_dataset(
                f"imu/{name}", data=column, chunks=(min(4096, len(column)),), fletcher32=True, compression=1
            )
            data.attrs["units"] = {"t": "s", "g": "rad/s", "a": "m/s^2"}[name[0]]
    return path


def _arrow_table(stamps: Stamps, values: Values) -> Any:
    import pyarrow as pa

    units = {"t": "s", "g": "rad/s", "a": "m/s^2"}
    return pa.table({f"{name} [{units[name[0]]}]": column for name, column in _named(stamps, values).items()})


def _parquet(folder: Path, stamps: Stamps, values: Values) -> Path:
    import pyarrow.parquet as pq

    path = folder / "log.parquet"
    pq.write_table(_arrow_table(stamps, values), path, write_page_checksum=True, row_group_size=1 << 17)
    return path


def _arrow(folder: Path, stamps: Stamps, values: Values) -> Path:
    import pyarrow as pa

    path = folder / "log.arrow"
    table = _arrow_table(stamps, values)
    with pa.OSFile(str(path), "wb") as sink, pa.ipc.new_file(sink, table.schema) as writer:
        writer.write_table(table, max_chunksize=1 << 12)
    return path


def _tdms(folder: Path, stamps: Stamps, values: Values) -> Path:
    import nptdms

    path = folder / "log.tdms"
    units = ["rad/s"] * 3 + ["m/s^2"] * 3
    with nptdms.TdmsWriter(path) as writer:
        for part in np.array_split(np.arange(len(stamps)), 10):
            writer.write_segment(
                [
                    nptdms.ChannelObject(
                        "imu", c, values[part, k], {"unit_string": units[k], "wf_increment": STEP * 1e-9}
                    )
                    for k, c in enumerate(CHANNELS)
                ]
            )
    return path


KINDS: dict[str, Kind] = {
    "CSV": Kind(_csv, checked=True),
    "CSV, gzip": Kind(_csv_gz, checked=True),
    "CSV, decimal comma": Kind(_decimal_comma, checked=True),
    "CSV, UTF-16": Kind(_utf16, checked=True),
    "LVM of LabVIEW": Kind(texts.lvm, streams=False, checked=True),
    "names with values": Kind(texts.keyed, {"unit": {"gyro": "rad/s", "accel": "m/s^2"}}, streams=False, checked=True),
    "JSON lines": Kind(texts.json_lines, {"unit": {"gyro": "rad/s", "accel": "m/s^2"}}, streams=False, checked=True),
    "ros2 topic echo, YAML": Kind(texts.echo, streams=False, checked=True, longest=72_000),
    "ros2 topic echo, CSV": Kind(texts.csv_echo, checked=True),
    "Excel": Kind(texts.xlsx, streams=False, checked=True, longest=720_000),
    "VectorNav ASCII": Kind(_vectornav, {"rate": 200}, checked=True),
    "MCAP, zstd": Kind(_mcap),
    "ROS 2 db3": Kind(_db3),
    "ROS 1 bag, lz4": Kind(_bag),
    "PX4 ULog": Kind(_ulog),
    "ArduPilot DataFlash": Kind(_dataflash),
    "MATLAB 5": Kind(_matlab5, _SI),
    "MATLAB 7, compressed": Kind(_matlab7, _SI, streams=False, checked=True),
    "HDF5, fletcher32": Kind(_hdf5, checked=True),
    "Parquet, page checksums": Kind(_parquet, checked=True),
    "Arrow file": Kind(_arrow),
    "LabVIEW TDMS": Kind(_tdms),
    "NumPy .npy": Kind(_npy, _SI | {"channels": {"time": 1, "gyro": "2:4", "accel": "5:7"}}),
    "NumPy .npz": Kind(_npz, streams=False, checked=True),
    "raw binary": Kind(_raw, {"layout": "<u8 time[ns],3f4 gyro[rad/s],3f4 accel[m/s^2]"}),
}
