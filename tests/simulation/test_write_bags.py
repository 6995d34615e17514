"""Simulated logs of ROS: rosbags, which is another's program, and the package's reader read the same bits back."""

import numpy as np
import pytest

from known import seed_of
from sigmatau import DataError, Imperfections, NoiseModel, OptionError, read, simulate, simulate_to, write
from sigmatau.io.ros_messages import FIRST_STAMP, make_stamps
from sigmatau.io.write import RECORD_ENDINGS, TABLE_ENDINGS
from sigmatau.model.channel import ChannelModel
from sigmatau.simulation.imperfections import Outage, Temperature

ENDINGS = tuple(ending for ending in RECORD_ENDINGS if ending not in TABLE_ENDINGS)
AXES = [f"{sensor}_{axis}" for sensor in ("gyro", "accel") for axis in "xyz"]
MODEL = NoiseModel(channels={name: {"random_walk": 1e-3} for name in AXES})
OPTIONS = {"duration": 50.0, "rate": 100.0, "rng": seed_of("bags")}  # 5000 rows, two chunks
WARM = Imperfections(temperature=Temperature(start=20.0, end=30.0, time=30.0), level={"accel_z": 9.8})


def messages_of(path):
    """Stamps [ns] and numbers of the messages of each topic, by rosbags."""
    highlevel = pytest.importorskip("rosbags.highlevel", reason="rosbags reads what is written")
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC if path.suffix == ".bag" else Stores.ROS2_JAZZY)
    found = {}
    with highlevel.AnyReader([path], default_typestore=store) as reader:
        for connection, logged, raw in reader.messages():
            message = reader.deserialize(raw, connection.msgtype)
            stamp = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
            assert logged == stamp
            if connection.msgtype.endswith("Imu"):
                vectors = (message.angular_velocity, message.linear_acceleration)
                numbers = [getattr(vector, axis) for vector in vectors for axis in "xyz"]
                covariances = (message.angular_velocity_covariance, message.linear_acceleration_covariance)
                assert message.orientation_covariance[0] == -1.0
            else:
                numbers, covariances = [message.temperature], ()
            marks = tuple(covariance[0] for covariance in covariances)
            found.setdefault(connection.topic, []).append((stamp, numbers, marks))
        assert sum(connection.msgcount for connection in reader.connections) == reader.message_count
    return found


@pytest.mark.parametrize("ending", ENDINGS)
def test_another_program_reads_the_same_bits(tmp_path, ending):
    path = tmp_path / f"log{ending}"
    simulate_to(path, MODEL, imperfections=WARM, chunk=1777, **OPTIONS)
    expected = simulate(MODEL, imperfections=WARM, flicker="poles", **OPTIONS)
    found = messages_of(path)
    assert set(found) == {"/imu", "/imu/temperature"}
    rows = np.array([numbers for _, numbers, _ in found["/imu"]])
    np.testing.assert_array_equal(rows, np.stack([expected.stream_of(name).column(name) for name in AXES], axis=1))
    stamps = [stamp for stamp, *_ in found["/imu"]]
    assert stamps == [FIRST_STAMP * 10**9 + 10_000_000 * k for k in range(5000)]
    assert {marks for *_, marks in found["/imu"]} == {(0.0, 0.0)}
    warmth = [numbers[0] for _, numbers, _ in found["/imu/temperature"]]
    assert 20.0 <= min(warmth) < 21.0 < 28.0 < max(warmth) <= 30.0


@pytest.mark.parametrize("ending", ENDINGS)
def test_a_log_is_read_back(tmp_path, ending):
    given = Imperfections(lost=0.01, outages=(Outage(start=20.0, length=1.0),), jitter=2e-5)
    made = simulate_to(tmp_path / f"log{ending}", MODEL, imperfections=given, **OPTIONS)
    back, expected = read(tmp_path / f"log{ending}"), simulate(MODEL, imperfections=given, flicker="poles", **OPTIONS)
    assert [finding.code for finding in back.findings] == ["gaps"]
    assert back.provenance.rows == made.samples - made.lost
    for name in AXES:
        np.testing.assert_array_equal(back.stream_of(name).column(name), expected.stream_of(name).column(name))
    write(expected, tmp_path / f"again{ending}")  # Missing samples are NaN
    again = read(tmp_path / f"again{ending}")
    np.testing.assert_array_equal(again.stream_of("gyro_x").column("gyro_x"), back.stream_of("gyro_x").column("gyro_x"))


def test_stamps_that_are_dates_stay():
    # A double at 1.6e9 has steps of 2.4e-7.
    assert make_stamps(np.array([1.6e9, 1.6e9 + 0.01])).tolist() == [1_600_000_000 * 10**9, 1_600_000_000_009_999_990]
    assert make_stamps(np.array([-1e-5, 0.01])).tolist() == [FIRST_STAMP * 10**9 - 10**4, FIRST_STAMP * 10**9 + 10**7]


@pytest.mark.parametrize("ending", ENDINGS)
def test_a_sensor_that_is_not_there_is_marked(tmp_path, ending):
    path = tmp_path / f"log{ending}"
    simulate_to(path, MODEL.of(AXES[:3]), **{**OPTIONS, "duration": 1.0})
    found = messages_of(path)["/imu"]
    assert {marks for *_, marks in found} == {(0.0, -1.0)}
    assert {tuple(numbers[3:]) for _, numbers, _ in found} == {(0.0, 0.0, 0.0)}


@pytest.mark.parametrize("ending", ENDINGS)
def test_the_same_seed_gives_the_same_bytes_and_no_half_file_stays(tmp_path, ending):
    short = {**OPTIONS, "duration": 5.0}
    for name in "ab":
        simulate_to(tmp_path / f"{name}{ending}", MODEL, **short)
    first, second = ((tmp_path / f"{name}{ending}").read_bytes() for name in "ab")
    assert first == second

    def stop(_):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        simulate_to(tmp_path / f"a{ending}", MODEL, chunk=100, progress=stop, **short)
    assert sorted(path.name for path in tmp_path.iterdir()) == [f"a{ending}", f"b{ending}"]
    assert (tmp_path / f"a{ending}").read_bytes() == first


@pytest.mark.parametrize("ending", ENDINGS)
def test_what_has_no_place_is_refused(tmp_path, ending):
    volts = ChannelModel(terms={"random_walk": 1.0}, quantity="signal", unit="V")
    for model, given, why in (
        (MODEL.of(["gyro_x", "accel_x", "accel_y", "accel_z"]), None, "there is no gyro_y, gyro_z"),
        (NoiseModel(channels={**MODEL.channels, "pressure": volts}), None, "no field for pressure"),
        (NoiseModel(channels={"pressure": volts}), None, "no field for pressure"),
        (MODEL, Imperfections(output="increments"), "in rad/s, not in rad"),
    ):
        with pytest.raises(DataError, match=why):
            simulate_to(tmp_path / f"log{ending}", model, imperfections=given, **OPTIONS)
    with pytest.raises(OptionError, match=r"\.mcap"):
        simulate_to(tmp_path / "log.rosbag", MODEL, **OPTIONS)
    assert not list(tmp_path.iterdir())
