"""Logs of ROS: MCAP files and bags, written by others or by the published specifications."""

import contextlib
import itertools
import sqlite3
import struct

import numpy as np
import pytest
import roslogs
from readings import six
from roslogs import IMU, KINDS, N, imu, imu_cdr, imu_mcap, imu_ros1, rosbags_log

from sigmatau.errors import DataError, OptionError
from sigmatau.findings.reading import Damaged
from sigmatau.io.read import read
from sigmatau.io.read.inspection import inspect
from sigmatau.io.read.options import ReadOptions
from sigmatau.io.ros_messages import IMU_ROS2

pytest.importorskip("lz4", reason="lz4 packs what these tests read")
pytest.importorskip("backports.zstd", reason="backports.zstd packs what these tests read")


@pytest.mark.parametrize("kind", KINDS)
def test_as_rosbags_writes_it(tmp_path, kind):
    path, _, values = rosbags_log(kind, tmp_path)
    record = read(path)
    np.testing.assert_array_equal(six(record), values)
    assert record.findings == ()
    assert record.streams[0].grid.rate == 200.0
    assert record.provenance.topics == ("/imu",)
    assert record.provenance.rows == N
    assert "orientation.w" in record.provenance.ignored
    # The stamp of the message, not that of the recorder, and exactly.
    by_hand = read(path, channels={"w": "orientation.w", "time": "log_time"}, unit={"w": "1"})
    assert by_hand.streams[0].grid.start - record.streams[0].grid.start == pytest.approx(1e-6, abs=3e-7)


@pytest.mark.parametrize("summary", [True, False])
@pytest.mark.parametrize("crc", [True, False])
@pytest.mark.parametrize("compression", ["", "zstd", "lz4"])
def test_mcap_by_its_specification(tmp_path, compression, crc, summary):
    data, _, values = imu_mcap(N, 70, compression, crc=crc, summary=summary)
    (tmp_path / "a").write_bytes(data)
    record = read(tmp_path / "a")
    np.testing.assert_array_equal(six(record), values)
    assert record.findings == ()


def test_mcap_without_chunks(tmp_path):
    stamps, values = imu(N)
    head = [roslogs.schema(1, IMU, IMU_ROS2), roslogs.channel(3, "/imu")]
    body = [roslogs.message(3, s, imu_cdr(s, v)) for s, v in zip(stamps, values, strict=True)]
    (tmp_path / "a.mcap").write_bytes(roslogs.mcap([*head, *body]))
    np.testing.assert_array_equal(six(read(tmp_path / "a.mcap")), values)


@pytest.mark.parametrize("frame", [b"\0", b"a\0", b"ab\0", b"abc\0", b"abcdefgh\0"])
@pytest.mark.parametrize("order", ["<", ">"])
def test_order_and_alignment(tmp_path, order, frame):
    stamps, values = imu(20)
    body = [roslogs.message(3, s, imu_cdr(s, v, order=order, frame=frame)) for s, v in zip(stamps, values, strict=True)]
    head = [roslogs.schema(1, IMU, IMU_ROS2), roslogs.channel(3, "/imu")]
    (tmp_path / "a.mcap").write_bytes(roslogs.mcap([*head, *body]))
    record = read(tmp_path / "a.mcap")
    np.testing.assert_array_equal(six(record), values)
    assert record.streams[0].grid.rate == 200.0


def test_a_sensor_without_data_is_left_out(tmp_path):
    """sensor_msgs/Imu: the first number of a covariance is -1 if the message has no data of this vector."""
    stamps, values = imu(20)
    values[:, 3:] = 0.0
    head = [roslogs.schema(1, IMU, IMU_ROS2), roslogs.channel(3, "/imu")]
    for first, sensors in ((0.0, ("gyro", "accel")), (-1.0, ("gyro",))):
        body = []
        for s, v in zip(stamps, values, strict=True):
            data = imu_cdr(s, v)
            body.append(roslogs.message(3, s, data[:-72] + struct.pack("<d", first) + data[-64:]))
        (tmp_path / "a.mcap").write_bytes(roslogs.mcap([*head, *body]))
        for record in (read(tmp_path / "a.mcap"), inspect(tmp_path / "a.mcap", ReadOptions()).record):
            assert tuple(stream.name for stream in record.streams) == sensors
        told = any("accel is left out" in text for text in record.provenance.conversions)
        assert told == (first == -1.0)
    named = {"accel_x": "linear_acceleration.x"}
    assert [stream.name for stream in read(tmp_path / "a.mcap", channels=named).streams] == ["accel"]


def test_several_imus_are_asked_about(tmp_path):
    stamps, values = imu(20)
    head = [roslogs.schema(1, IMU, IMU_ROS2), roslogs.channel(3, "/a/imu"), roslogs.channel(4, "/b/imu")]
    body = []
    for s, v in zip(stamps, values, strict=True):
        body += [roslogs.message(3, s, imu_cdr(s, v)), roslogs.message(4, s, imu_cdr(s, -v))]
    (tmp_path / "a.mcap").write_bytes(roslogs.mcap([*head, *body]))
    with pytest.raises(OptionError, match=r"several sensors: /a/imu \(gyro and accel, 20 rows\), /b/imu .*--topic"):
        read(tmp_path / "a.mcap")
    np.testing.assert_array_equal(six(read(tmp_path / "a.mcap", topic="/b/imu")), -values)


TEMPERATURE = (
    "std_msgs/Header header\nfloat64 temperature\nfloat64 variance\n"
    "====================\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n"
)


def warm_mcap(place, topics, *, value=25.0, every=20):
    """An IMU, and thermometers that send every so many of its messages, 5 °C further each topic."""
    stamps, values = imu(400)
    head = [roslogs.schema(1, IMU, IMU_ROS2), roslogs.schema(2, "sensor_msgs/msg/Temperature", TEMPERATURE)]
    head += [roslogs.channel(3, "/imu/data")] + [roslogs.channel(4 + k, t, 2) for k, t in enumerate(topics)]
    body = []
    for n, (s, v) in enumerate(zip(stamps, values, strict=True)):
        body.append(roslogs.message(3, s, imu_cdr(s, v)))
        for k in range(len(topics)) if n % every == every // 2 else ():
            warm = imu_cdr(s, v, frame=b"\0")[:20] + struct.pack("<2d", value + 5 * k + 1e-3 * n, 0.0)
            body.append(roslogs.message(4 + k, s, warm))
    place.write_bytes(roslogs.mcap([*head, *body]))
    return values


@pytest.mark.parametrize("topics", [["/thermometer"], ["/imu/temperature"], ["/imu/temperature", "/motor/temperature"]])
def test_a_topic_of_a_temperature_is_a_channel(tmp_path, topics):
    """At its own rate and start; that of the device if there are several."""
    values = warm_mcap(tmp_path / "a.mcap", topics)
    for record in (read(tmp_path / "a.mcap"), inspect(tmp_path / "a.mcap", ReadOptions()).record):
        np.testing.assert_array_equal(six(record), values)
        stream = record.stream_of("temperature")
        assert (stream.quantity, stream.unit) == ("temperature", "degC")
        assert stream.grid.rate == pytest.approx(10.0)
        assert stream.column("temperature") == pytest.approx(25 + 1e-3 * np.arange(10, 400, 20), rel=1e-12)
        assert stream.grid.start - record.streams[0].grid.start == pytest.approx(0.05, abs=1e-6)
        assert record.provenance.topics == ("/imu/data", topics[0])


@pytest.mark.parametrize(
    ("topics", "more"), [(["/a/temperature", "/b/temperature"], {}), (["/imu/temperature"], {"value": 900.0})]
)
def test_a_thermometer_of_another_device_is_not_read(tmp_path, topics, more):
    values = warm_mcap(tmp_path / "a.mcap", topics, **more)
    record = read(tmp_path / "a.mcap")
    np.testing.assert_array_equal(six(record), values)
    assert record.provenance.topics == ("/imu/data",)
    if len(topics) == 2:
        chosen = read(tmp_path / "a.mcap", topic=["/imu/data", "/b/temperature"], rate=200.0)
        assert chosen.stream_of("temperature").column("temperature")[0] == pytest.approx(30.01)


def test_an_empty_topic_beside_the_imu_is_no_fault(tmp_path):
    stamps, values = imu(20)
    head = [roslogs.schema(1, IMU, IMU_ROS2), roslogs.channel(3, "/a/imu"), roslogs.channel(4, "/b/imu")]
    body = [roslogs.message(3, s, imu_cdr(s, v)) for s, v in zip(stamps, values, strict=True)]
    (tmp_path / "a.mcap").write_bytes(roslogs.mcap([*head, *body], {3: 20}, b"".join(head)))
    found = inspect(tmp_path / "a.mcap", ReadOptions())
    assert {table.topic: table.rows for table in found.tables} == {"/a/imu": 20, "/b/imu": 0}
    assert not any(table.findings for table in found.tables)
    with pytest.raises(DataError, match="0 rows of data in /b/imu; at least 4"):
        read(tmp_path / "a.mcap", topic="/b/imu")


CUSTOM = """\
# a comment
uint8 KIND=3
string NAME="a # no comment"
Part[2] parts  # nested
Part[] more
string[] words
uint16[<=7] some
string<=5 label
bool ok
int8[3] small
float32 temperature 20.5
float64[9] matrix
builtin_interfaces/Time stamp
my_msgs/Empty nothing
uint64 count
Part last
================================================================================
MSG: my_msgs/Part
int8 tag
float64 value
string name
================================================================================
MSG: my_msgs/Empty
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""


def test_any_message_by_the_path_of_a_field(tmp_path):
    pytest.importorskip("rosbags", reason="rosbags writes what this test reads")
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    store.register(get_types_from_msg(CUSTOM, "my_msgs/msg/Custom"))
    kinds = store.types
    part, clock = kinds["my_msgs/msg/Part"], kinds["builtin_interfaces/msg/Time"]
    rng = np.random.default_rng(3)
    head = [roslogs.schema(1, "my_msgs/msg/Custom", CUSTOM), roslogs.channel(1, "/custom")]
    rows, body = [], []
    for k in range(40):

        def some(k=k):
            return part(tag=k, value=rng.normal(), name="x" * int(rng.integers(9)))

        made = kinds["my_msgs/msg/Custom"](
            parts=[some(), some()],
            more=[some() for _ in range(k % 4)],
            words=["w" * int(rng.integers(6)) for _ in range(k % 3)],
            some=rng.integers(0, 9, k % 7).astype(np.uint16),
            label="abc"[: k % 4],
            ok=True,
            small=np.array([k, -k, 1], dtype=np.int8),
            temperature=float(np.float32(rng.normal())),
            matrix=rng.normal(size=9),
            stamp=clock(sec=1_700_000_000, nanosec=k * 10_000_001),
            nothing=kinds["my_msgs/msg/Empty"](),
            count=2**53 + 2 * k,
            last=some(),
        )
        body.append(roslogs.message(1, 10 * k, bytes(store.serialize_cdr(made, "my_msgs/msg/Custom"))))
        rows.append([made.parts[1].value, made.small[1], made.temperature, made.matrix[8], made.count, made.last.value])
    (tmp_path / "a.mcap").write_bytes(roslogs.mcap([*head, *body]))
    names = ["parts[1].value", "small[1]", "temperature", "matrix[8]", "count", "last.value"]
    record = read(
        tmp_path / "a.mcap",
        channels={f"s{k}": name for k, name in enumerate(names)},
        unit={f"s{k}": "1" for k in range(len(names))},
    )
    got = np.stack([record.stream_of(f"s{k}").column(f"s{k}") for k in range(len(names))], axis=1)
    np.testing.assert_array_equal(got, np.array(rows, dtype=float))
    assert 1 / record.streams[0].grid.rate == pytest.approx(0.010000001, rel=1e-12)
    assert not any(c.startswith(("more", "words", "some", "label")) for c in record.provenance.ignored)


def test_px4_sensor_combined(tmp_path):
    definition = (
        "uint64 timestamp # time since system start (microseconds)\nint32 RELATIVE_TIMESTAMP_INVALID = 2147483647\n"
        "float32[3] gyro_rad\nuint32 gyro_integral_dt\nint32 accelerometer_timestamp_relative\n"
        "float32[3] accelerometer_m_s2\nuint32 accelerometer_integral_dt\nuint8 accelerometer_clipping\n"
    )
    import struct

    values = np.random.default_rng(2).normal(size=(50, 6)).astype(np.float32)
    head = [
        roslogs.schema(1, "px4_msgs/msg/SensorCombined", definition),
        roslogs.channel(1, "/fmu/out/sensor_combined"),
    ]
    body = [
        roslogs.message(1, k, b"\0\1\0\0" + struct.pack("<Q3fIi3fIB", k * 4000, *v[:3], 4000, 0, *v[3:], 4000, 0))
        for k, v in enumerate(values.tolist())
    ]
    (tmp_path / "a.mcap").write_bytes(roslogs.mcap([*head, *body]))
    record = read(tmp_path / "a.mcap")
    np.testing.assert_array_equal(six(record), values.astype(float))
    assert record.streams[0].grid.rate == 250.0


def test_ros1_messages_in_mcap(tmp_path):
    definition = IMU_ROS2.replace("builtin_interfaces/Time stamp", "uint32 seq\ntime stamp")
    stamps, values = imu(30)
    head = [roslogs.schema(1, "sensor_msgs/Imu", definition, "ros1msg"), roslogs.channel(3, "/imu", encoding="ros1")]
    body = [roslogs.message(3, s, imu_ros1(s, v)) for s, v in zip(stamps, values, strict=True)]
    (tmp_path / "a.mcap").write_bytes(roslogs.mcap([*head, *body]))
    np.testing.assert_array_equal(six(read(tmp_path / "a.mcap")), values)


@pytest.mark.parametrize(
    ("head", "words"),
    [
        ([roslogs.schema(1, "x.Imu", b"\1\2", "protobuf"), roslogs.channel(1, "/p", encoding="protobuf")], "protobuf"),
        ([roslogs.schema(1, IMU, "float64 x\nFoo y\n"), roslogs.channel(1, "/p")], "sensor_msgs/Foo is missing"),
        ([roslogs.schema(1, IMU, "float64\n"), roslogs.channel(1, "/p")], "has an invalid line"),
        ([roslogs.schema(1, "a/A", "A a\n"), roslogs.channel(1, "/p")], "too deep"),
        ([roslogs.schema(1, "a/A", "wstring w\nfloat64 x\n"), roslogs.channel(1, "/p")], "log_time"),
        ([], "has no topics"),
    ],
)  # fmt: skip
def test_what_is_not_read_says_why(tmp_path, head, words):
    (tmp_path / "a.mcap").write_bytes(roslogs.mcap(head))
    with pytest.raises((DataError, OptionError), match=words):
        read(tmp_path / "a.mcap")


def test_a_message_unlike_its_definition(tmp_path):
    stamps, values = imu(30)
    head = [roslogs.schema(1, IMU, IMU_ROS2), roslogs.channel(3, "/imu")]
    body = [roslogs.message(3, s, imu_cdr(s, v)) for s, v in zip(stamps, values, strict=True)]
    for checked, wrong in itertools.product(
        [True, False], (imu_cdr(stamps[0], values[0])[:-8], imu_cdr(stamps[0], values[0]) + bytes(8), b"", b"\0\7\0\0")
    ):
        records = [*head, *body[:20], roslogs.message(3, 1, wrong), *body[20:]]
        (tmp_path / "a.mcap").write_bytes(roslogs.mcap([roslogs.chunk(b"".join(records))] if checked else records))
        # Without a checksum the message before is not trusted either.
        rows = 20 if checked else 19
        record = read(tmp_path / "a.mcap")
        np.testing.assert_array_equal(six(record), values[:rows])
        (finding,) = record.findings
        assert (finding.code, finding.severity) == ("damaged", "error")
        assert (finding.details.kept, finding.details.topic) == (rows, "/imu")


def test_counts_that_do_not_agree(tmp_path):
    stamps, values = imu(30)
    head = roslogs.schema(1, IMU, IMU_ROS2) + roslogs.channel(3, "/imu")
    body = [roslogs.message(3, s, imu_cdr(s, v)) for s, v in zip(stamps, values, strict=True)]
    (tmp_path / "a.mcap").write_bytes(roslogs.mcap([head, *body], {3: 31}, head))
    (finding,) = read(tmp_path / "a.mcap").findings
    assert (finding.code, finding.severity) == ("damaged", "error")
    assert finding.details == Damaged(kept=30, declared=31, counted="messages", topic="/imu")


def test_bags_without_definitions(tmp_path):
    path, _, values = rosbags_log("db3", tmp_path)
    with contextlib.closing(sqlite3.connect(path)) as base, base:
        base.execute("DROP TABLE message_definitions")
    np.testing.assert_array_equal(six(read(path)), values)
    with pytest.raises(OptionError, match="no definition of std_msgs/msg/Str"):
        read(path, topic="/note")


def test_a_bag_beside_which_metadata_declare_more(tmp_path):
    path, _, _ = rosbags_log("db3", tmp_path)
    with contextlib.closing(sqlite3.connect(path)) as base, base:
        base.execute("DELETE FROM messages WHERE id > 500")
    (finding,) = read(path).findings
    assert finding.details == Damaged(kept=500, declared=600, counted="messages", topic="/imu")
    # As the recorder of ROS itself writes it.
    (path.parent / "metadata.yaml").write_text(
        "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: sqlite3\n  relative_file_paths:\n    - db3.db3\n"
        "  message_count: 801\n  topics_with_message_count:\n    - topic_metadata:\n        name: /note\n"
        "        type: std_msgs/msg/String\n      message_count: 1\n    - topic_metadata:\n        name: /imu\n"
        '        offered_qos_profiles: "- history: 3\\n  depth: 0"\n      message_count: 800\n  compression_format: ""\n'
    )
    (finding,) = read(path).findings
    assert finding.details.declared == 800


def test_a_database_that_is_no_bag(tmp_path):
    with contextlib.closing(sqlite3.connect(tmp_path / "a.db3")) as base, base:
        base.execute("CREATE TABLE t (x)")
    with pytest.raises(DataError, match="not a ROS 2 bag"):
        read(tmp_path / "a.db3")
