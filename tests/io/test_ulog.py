"""PX4 flight logs: bytes made from the published specification, read by pyulog too."""

import struct
import time

import numpy as np
import pytest
from readings import axes

from container_damage import outcomes
from known import seed_of
from sigmatau.errors import DataError, OptionError
from sigmatau.findings.reading import LoggerDropouts, Place
from sigmatau.io.read import read

HEADER = b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 10)
N = 400
RNG = np.random.default_rng(seed_of("ulog"))
VALUES = RNG.normal(size=(N, 6)).astype(np.float32)
STAMPS = 123_456_789 + 5000 * np.arange(N)


def message(kind, payload):
    return struct.pack("<H", len(payload)) + kind + payload


def definition(name, fields):
    return message(b"F", f"{name}:{fields}".encode())


def subscription(name, number, instance=0):
    return message(b"A", struct.pack("<BH", instance, number) + name.encode())


def data(number, payload):
    return message(b"D", struct.pack("<H", number) + payload)


COMBINED = definition(
    "sensor_combined",
    "uint64_t timestamp;float[3] gyro_rad;uint32_t gyro_integral_dt;int32_t accelerometer_timestamp_relative;"
    "float[3] accelerometer_m_s2;uint32_t accelerometer_integral_dt;uint8_t accelerometer_clipping;uint8_t[3] _padding0;",
)
FLAGS = message(b"B", bytes(40))
SYNC = message(b"S", bytes.fromhex("2f731320250cbb12"))


def combined(n=N, between=lambda k: b""):
    """A log as PX4 writes it: the padding at the end is not written."""
    rows = [
        between(k)
        + data(
            3,
            struct.pack(
                "<Q3fIi3fIB", STAMPS[k], *map(float, VALUES[k, :3]), 5000, 0, *map(float, VALUES[k, 3:]), 5000, 0
            ),
        )
        for k in range(n)
    ]
    return HEADER + FLAGS + COMBINED + subscription("sensor_combined", 3) + b"".join(rows)


def codes(record):
    return [f.code for f in record.findings]


@pytest.fixture
def file(tmp_path):
    return tmp_path / "log.bin"  # by content, not by name


def test_sensor_combined(file):
    file.write_bytes(combined(between=lambda k: SYNC if k % 100 == 50 else b""))
    record = read(file)
    np.testing.assert_array_equal(axes(record, "gyro"), VALUES[:, :3].astype(float))
    np.testing.assert_array_equal(axes(record, "accel"), VALUES[:, 3:].astype(float))
    assert record.streams[0].grid.rate == pytest.approx(200, rel=1e-12)
    assert record.findings == ()
    assert (record.provenance.format, record.provenance.topics, record.provenance.rows) == (
        "ulog",
        ("sensor_combined",),
        N,
    )


def test_against_pyulog(file):
    pyulog = pytest.importorskip("pyulog", reason="the oracle is not installed")
    file.write_bytes(combined())
    theirs = pyulog.ULog(str(file)).data_list[0].data
    ours = read(file)
    np.testing.assert_array_equal(axes(ours, "gyro")[:, 1], theirs["gyro_rad[1]"])
    np.testing.assert_array_equal(axes(ours, "accel")[:, 2], theirs["accelerometer_m_s2[2]"])
    np.testing.assert_array_equal(theirs["timestamp"], STAMPS)
    # And what pyulog writes is read.
    pyulog.ULog(str(file)).write_ulog(str(file) + ".again")
    np.testing.assert_array_equal(axes(read(str(file) + ".again"), "gyro"), axes(ours, "gyro"))


def instances():
    fields = "uint64_t timestamp;uint64_t timestamp_sample;uint32_t device_id;float x;float y;float z;"
    parts = [HEADER, FLAGS, definition("sensor_gyro", fields), definition("sensor_accel", fields)]
    parts += [subscription("sensor_gyro", 0, 0), subscription("sensor_gyro", 1, 1), subscription("sensor_accel", 2, 0)]
    for k in range(N):
        for number, columns in ((0, VALUES[k, :3]), (1, -VALUES[k, :3]), (2, VALUES[k, 3:])):
            if number == 2 and k % 2:
                continue
            arrival = STAMPS[k] + (1700 if k % 3 else 0)
            parts.append(data(number, struct.pack("<QQI3f", arrival, STAMPS[k], 7, *map(float, columns))))
    return b"".join(parts)


def test_instances_are_topics(file):
    file.write_bytes(instances())
    with pytest.raises(OptionError, match=r"several sensors: sensor_gyro:0 \(gyro, 400 rows\), sensor_gyro:1"):
        read(file)
    record = read(file, topic=["sensor_gyro:1", "sensor_accel:0"])
    np.testing.assert_array_equal(axes(record, "gyro"), -VALUES[:, :3].astype(float))
    np.testing.assert_array_equal(axes(record, "accel"), VALUES[::2, 3:].astype(float))
    assert [round(s.grid.rate, 6) for s in record.streams] == [200, 100]  # from timestamp_sample, not from arrival
    assert record.findings == ()


def fifo(times, counts, dt=125.0, scale=0.5):
    fields = "uint64_t timestamp;uint64_t timestamp_sample;uint32_t device_id;float dt;float scale;uint8_t samples;"
    parts = [HEADER, FLAGS, definition("sensor_gyro_fifo", fields + "int16_t[32] x;int16_t[32] y;int16_t[32] z;")]
    parts.append(subscription("sensor_gyro_fifo", 5))
    k = 0
    for stamp, count in zip(times, counts, strict=True):
        axes = [[100 * (k + i) % 30000 + axis if i < count else 32767 for i in range(32)] for axis in range(3)]
        k += count
        head = struct.pack("<QQIffB", stamp + 9, stamp, 7, dt, scale, count)
        parts.append(data(5, head + struct.pack("<96h", *[v for a in axes for v in a])))
    return b"".join(parts)


def test_samples_of_the_buffer(file):
    counts = [8, 8, 6, 10, 8, 8]
    true = 120.0  # faster than the nominal 125 µs
    times = [round(1e6 + true * n) for n in np.cumsum(counts)]
    file.write_bytes(fifo(times, counts))
    record = read(file)
    k = np.arange(sum(counts))
    for axis in range(3):
        np.testing.assert_array_equal(axes(record, "gyro")[:, axis], (100 * k % 30000 + axis) * 0.5)
    # The first message has none before it and is spread by the nominal interval: 7 of 47 intervals are 4 % too long.
    assert record.streams[0].grid.rate == pytest.approx(1e6 / true, rel=0.3 * 0.04)
    assert [f.code for f in record.findings if f.severity != "info"] == []
    file.write_bytes(fifo(times, [8, 8, 6, 10, 33, 8]))
    record = read(file)
    assert record.provenance.rows == 32
    details = record.findings[0].details
    assert (details.place, details.topic) == (Place("message", 5), "sensor_gyro_fifo:0")
    assert (details.reason, details.kept) == ("33 samples where at most 32 fit", 32)


def test_increments_are_not_mistaken(file):
    fields = "uint64_t timestamp;uint64_t timestamp_sample;float[3] delta_angle;float[3] delta_velocity;"
    log = combined() + definition("vehicle_imu", fields) + subscription("vehicle_imu", 8)
    log += b"".join(data(8, struct.pack("<QQ6f", 5, t, *[1.0] * 6)) for t in STAMPS)
    file.write_bytes(log)
    assert read(file).provenance.topics == ("sensor_combined",)
    with pytest.raises(OptionError, match=r"vehicle_imu.delta_angle\[0\]"):
        read(file, topic="vehicle_imu:0")


def test_dropouts(file):
    file.write_bytes(combined(between=lambda k: message(b"O", struct.pack("<H", k)) if k in (50, 120) else b""))
    (finding,) = read(file).findings
    assert (finding.code, finding.severity) == ("dropouts", "warning")
    assert finding.details == LoggerDropouts(count=2, total=0.17, longest=0.12)


def test_not_a_number(file):
    log = bytearray(combined())
    row = len(log) - 10 * (5 + 45)
    log[row + 5 + 8 : row + 5 + 12] = struct.pack("<f", np.inf)
    file.write_bytes(log)
    (finding,) = read(file).findings
    assert (finding.code, finding.details.place) == ("missing_values", "message 391 of sensor_combined")


@pytest.mark.parametrize("part", [0.1, 0.5, 0.99])
def test_cut(file, part):
    whole = combined()
    first = len(whole) - 50 * N
    length = int(part * len(whole))
    assert (length - first) % 50
    file.write_bytes(whole[:length])
    record = read(file)
    rows = (length - first) // 50
    assert record.provenance.rows == rows
    np.testing.assert_array_equal(axes(record, "gyro"), VALUES[:rows, :3].astype(float))
    (finding,) = record.findings
    assert (finding.code, finding.severity) == ("damaged", "error")
    assert finding.details.place == Place("byte", first + 50 * rows, of=length)


def test_a_flipped_page(file):
    whole = bytearray(combined())
    first = len(whole) - 50 * N
    whole[8192:12288] = bytes(b ^ 0xFF for b in whole[8192:12288])
    file.write_bytes(whole)
    record = read(file)
    rows = (8192 - first) // 50  # without the message that reaches into the page
    assert record.provenance.rows == rows
    np.testing.assert_array_equal(axes(record, "accel"), VALUES[:rows, 3:].astype(float))
    (finding,) = record.findings
    assert (finding.code, finding.severity) == ("damaged", "error")


@pytest.mark.parametrize(
    ("log", "words"),
    [
        (HEADER, "without data"),
        (HEADER[:12], "header is not that of a ULog"),
        (b"ULog\0\0\0\0" + bytes(20), "header is not that of a ULog"),
        (HEADER + FLAGS + COMBINED[:40], "is truncated at byte 59 of 99, inside a message"),
        (HEADER + message(b"B", bytes(8) + b"\x02" + bytes(31)), "incompatible flags 0x2"),
        (HEADER + subscription("imu", 0) + data(0, b"12345678") * 9, "'imu' is not defined"),
        (HEADER + definition("imu", "imu a;") + subscription("imu", 0) + data(0, b"12") * 9, "nested"),
        (HEADER + definition("imu", "float[3] a;") + subscription("imu", 0) + data(0, b"12") * 9, "gives 12 bytes"),
        (
            HEADER + definition("imu", "float[99999] a;") + subscription("imu", 0) + data(0, b"12") * 9,
            "longer than 65535",
        ),
    ],
)
def test_refused(file, log, words):
    file.write_bytes(log)
    with pytest.raises(DataError, match=words):
        read(file)


def test_mutations(file):
    """No other error than ours, and no end of reading, whatever bytes are changed."""
    rng = np.random.default_rng(seed_of("ulog mutations"))
    logs = [combined(20), instances()[:3000], fifo([10**6 + 1000 * k for k in range(12)], [8] * 12)]
    topics = [None, ["sensor_gyro:1"], None]
    assert outcomes(rng, logs, file, topics) >= {"read", "told", "DataError"}


def test_much_work_from_few_bytes(file):
    """Nested definitions that double, and topics by the thousand, must not take time or memory beyond the file's size."""
    log = (
        HEADER
        + b"".join(definition(f"a{k}", f"a{k + 1} x;a{k + 1} y;") for k in range(40))
        + definition("a40", "float z;")
    )
    log += definition("wide", "uint8_t[60000] x;")
    log += b"".join(subscription("a0" if k % 2 else "wide", k) for k in range(20000))
    file.write_bytes(log + data(0, b"1234") * 10)
    begin = time.monotonic()
    with pytest.raises(DataError, match="without data"):
        read(file)
    assert time.monotonic() - begin < 60  # seconds; below 1 is usual
