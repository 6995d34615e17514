"""Records made by others."""

import numpy as np
import pytest

from sigmatau.errors import DataError, OptionError
from sigmatau.io import read

IMU = {"channels": {"time": 1, "gyro": "2:4", "accel": "5:7"}, "unit": {"gyro": "rad/s", "accel": "g", "time": "s"}}


def test_hfi_rate_is_that_of_its_stamps(field_data):
    record = read(field_data / "hfi" / "imu_data.txt.gz", **IMU)
    assert [round(s.grid.rate, 2) for s in record.streams] == [9.86, 9.86]
    assert [s.grid.n for s in record.streams] == [27_963, 27_963]
    assert record.stream_of("gyro_x").column("gyro_x")[0] == 0.0021184
    assert record.findings == ()


def test_hfi_told_another_rate(field_data):
    record = read(field_data / "hfi" / "imu_data.txt.gz", rate=10, **IMU)
    assert [f.code for f in record.findings] == ["rate_mismatch"]
    assert "9.86199 Hz" in record.findings[0].message


def test_hfi_has_no_names(field_data):
    with pytest.raises(OptionError, match=r"1 \(1459\.63 …\).*--channels time=1,gyro=2:4,accel=5:7"):
        read(field_data / "hfi" / "imu_data.txt.gz")


def test_mpu6050_in_bursts(field_data):
    path = field_data / "mpu6050_10min.npz"
    with pytest.raises(OptionError, match=r"'t_host'.*as s 99\.32 Hz.*--unit time=s"):
        read(path)
    record = read(path, unit={"time": "s"})
    assert [round(s.grid.rate, 2) for s in record.streams] == [99.32, 99.32]
    assert [f.code for f in record.findings] == ["irregular_stamps"]
    assert record.provenance.ignored == ("temp_c",)
    raw = np.load(path)
    np.testing.assert_array_equal(record.stream_of("accel_z").column("accel_z"), raw["accel_g"][:, 2] * 9.80665)


def test_adis16405(field_data):
    path = field_data / "adis16405_static.csv.gz"
    with pytest.raises(OptionError, match="no time column"):
        read(path)
    record = read(path, rate=100)
    assert [s.grid.n for s in record.streams] == [1_000_000, 1_000_000]
    assert record.stream_of("gyro_y").column("gyro_y")[1] == -0.30 * (np.pi / 180)
    assert record.stream_of("accel_z").column("accel_z")[0] == -1.01565 * 9.80665


def test_phase_of_stable32(field_data):
    path = field_data / "phasedat" / "PHASE.DAT"
    record = read(path, rate=1, channels={"phase": 1}, unit={"phase": "s"}, input="accumulated")
    assert record.streams[0].grid.n == 1000
    assert record.streams[0].column("phase")[0] == 8.511601033439709e-02


def test_vn100_is_not_read_yet(field_data):
    with pytest.raises(DataError, match=r"line 1: sentences like \$VNYMR .* not read yet"):
        read(field_data / "vn100" / "live_capture.txt.gz")
