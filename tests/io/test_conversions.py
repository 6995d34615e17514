"""Counts, volts, increments and accumulated values end as rates in SI."""

import numpy as np
import pytest

from sigmatau.io.read import read
from sigmatau.io.write import write
from sigmatau.record.record import Record

RATE = 50.0
VALUES = np.array([3.0, -1.0, 4.0, 1.0, -5.0, 9.0])


def log(tmp_path, values, header="x"):
    path = tmp_path / "log.csv"
    path.write_text(f"{header}\n" + "".join(f"{v!r}\n" for v in values.tolist()))
    return path


def test_counts(tmp_path):
    path = log(tmp_path, VALUES)
    given = {"rate": RATE, "channels": {"gyro_z": 1}, "unit": {"gyro": "deg/s"}}
    record = read(path, scale={"gyro": 0.01}, offset={"gyro_z": 2.5}, **given)
    # three roundings on each side
    np.testing.assert_allclose(record.streams[0].column("gyro_z"), (VALUES - 2.5) * 0.01 * np.pi / 180, rtol=1e-15)
    assert "gyro_z: (raw - 2.5) * 0.01 deg/s" in record.provenance.conversions


def test_increments(tmp_path):
    path = log(tmp_path, VALUES)
    record = read(path, rate=RATE, channels={"accel_x": 1}, unit={"accel": "m/s"}, input="increments")
    np.testing.assert_allclose(record.streams[0].column("accel_x"), VALUES * RATE, rtol=1e-15)
    assert record.streams[0].unit == "m/s^2"


def test_accumulated_has_one_rate_less(tmp_path):
    path = log(tmp_path, VALUES)
    record = read(path, rate=RATE, channels={"gyro_x": 1}, unit={"gyro": "rad"}, input="accumulated")
    np.testing.assert_allclose(record.streams[0].column("gyro_x"), np.diff(VALUES) * RATE, rtol=1e-15)
    assert record.streams[0].grid.n == len(VALUES) - 1
    with pytest.raises(ValueError, match="4 rows of data; at least 5"):
        read(log(tmp_path, VALUES[:4]), rate=1, channels={"gyro_x": 1}, unit={"gyro": "rad"}, input="accumulated")


def test_phase_of_a_clock(tmp_path):
    path = log(tmp_path, VALUES)
    record = read(path, rate=1, channels={"phase": 1}, unit={"phase": "s"}, input="accumulated")
    (stream,) = record.streams
    assert (stream.name, stream.quantity, stream.unit) == ("phase", "signal", "1")
    np.testing.assert_array_equal(stream.column("phase"), np.diff(VALUES))


def test_a_signal_keeps_its_unit(tmp_path):
    path = log(tmp_path, VALUES, header="temp [°C]")
    record = read(path, rate=1, channels={"temp": "temp"}, unit={"temp": "degC"})
    assert record.streams[0].unit == "degC"
    np.testing.assert_array_equal(record.streams[0].column("temp"), VALUES)


def test_a_channel_is_asked_before_its_sensor(saved):
    path = saved("wx,wy\n" + "1,1\n" * 5)
    record = read(path, rate=1, unit={"gyro": "deg/s", "gyro_y": "rad/s"})
    assert record.stream_of("gyro_x").column("gyro_x")[0] == pytest.approx(np.pi / 180, rel=1e-15)
    assert record.stream_of("gyro_y").column("gyro_y")[0] == 1.0


@pytest.mark.parametrize("name", ["log.csv", "log.csv.gz", "log.npz"])
def test_a_record_that_is_written_is_read_again(tmp_path, name):
    record = Record.from_arrays(
        rate=200, gyro=np.random.default_rng(5).normal(size=(100, 3)), accel_z=np.arange(100) / 7
    )
    write(record, tmp_path / name)
    again = read(tmp_path / name)
    assert again.channels == record.channels
    assert again.findings == ()
    for stream in again.streams:
        assert stream.grid.rate == pytest.approx(200, rel=1e-13)
        for channel in stream.channels:
            np.testing.assert_array_equal(stream.column(channel), record.stream_of(channel).column(channel))
