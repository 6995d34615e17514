"""Records made by others."""

import gzip

import numpy as np
import pytest

from known import seed_of
from sigmatau.errors import OptionError
from sigmatau.io.read import read

IMU = {"channels": {"time": 1, "gyro": "2:4", "accel": "5:7"}, "unit": {"gyro": "rad/s", "accel": "g", "time": "s"}}


def test_hfi_rate_is_that_of_its_stamps(field_data):
    record = read(field_data / "hfi" / "imu_data.txt.gz", **IMU)
    assert [round(s.grid.rate, 2) for s in record.streams] == [9.86, 9.86]
    assert [s.grid.n for s in record.streams] == [27_963, 27_963]
    assert record.stream_of("gyro_x").column("gyro_x")[0] == 0.0021184
    assert [(f.code, f.severity) for f in record.findings] == [
        ("rate_drift", "warning"),
        ("rate_not_nominal", "info"),
        ("jitter", "info"),
    ]
    assert record.findings[1].size == pytest.approx(-0.014, abs=5e-4)
    assert record.findings[1].details.nominal == 10


def test_hfi_told_another_rate(field_data):
    record = read(field_data / "hfi" / "imu_data.txt.gz", rate=10, **IMU)
    assert [f.code for f in record.findings] == ["rate_mismatch", "rate_drift", "jitter"]
    assert record.findings[0].details.other == pytest.approx(9.8626, abs=5e-5)


def test_hfi_has_no_names(field_data):
    """Gravity tells its columns apart; units are asked for."""
    with pytest.raises(OptionError, match=r"does not state the unit of gyro_x.*--unit time=s"):
        read(field_data / "hfi" / "imu_data.txt.gz")


def test_mpu6050_in_bursts(field_data):
    path = field_data / "mpu6050_10min.npz"
    with pytest.raises(OptionError, match=r"'t_host'.*as s 99\.32 Hz.*--unit time=s"):
        read(path)
    record = read(path, unit={"time": "s"})
    # 99.32 Hz from the span; the last burst counts less in a line, which says 99.30.
    assert [round(s.grid.rate, 1) for s in record.streams] == [99.3, 99.3, 99.3]
    codes = {f.code: f for f in record.findings}
    assert set(codes) == {"host_stamps", "rate_drift", "rate_not_nominal"}
    assert codes["host_stamps"].severity == "warning"
    assert codes["host_stamps"].size == pytest.approx(0.75, abs=0.005)
    assert codes["host_stamps"].details.median_rate == pytest.approx(491, abs=0.5)
    assert codes["rate_not_nominal"].size == pytest.approx(-0.007, abs=5e-4)
    assert codes["rate_not_nominal"].details.nominal == 100
    temperature = record.stream_of("temperature")
    assert (temperature.quantity, temperature.unit) == ("temperature", "degC")
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


def test_vn100(field_data):
    record = read(field_data / "vn100" / "live_capture.txt.gz", rate=40)
    assert [s.grid.n for s in record.streams] == [30_178, 30_178]
    assert record.stream_of("gyro_x").column("gyro_x")[0] == -0.000063
    assert record.stream_of("accel_z").column("accel_z")[-1] == -9.984
    assert record.findings == ()


def test_vn100_with_planted_broken_lines(field_data, tmp_path):
    lines = gzip.decompress((field_data / "vn100" / "live_capture.txt.gz").read_bytes()).split(b"\n")[:-1]
    rng = np.random.default_rng(seed_of("vn100"))
    planted = np.sort(rng.choice(np.arange(1, len(lines) - 1), 50, replace=False))
    for k, at in enumerate(planted):
        line = bytearray(lines[at])
        where = int(rng.integers(1, len(line) - 3))
        match k % 5:
            case 0:
                line[where] ^= 1 << int(rng.integers(7))
            case 1:
                del line[where:]
            case 2:
                del line[where]
            case 3:
                line[:where] = b""
            case _:
                line[where:where] = b"\xff"
        lines[at] = bytes(line).replace(b"\n", b"?")
    path = tmp_path / "log.txt"
    path.write_bytes(b"\n".join(lines) + b"\n")
    record = read(path, rate=40)
    assert [s.grid.n for s in record.streams] == [30_128, 30_128]
    (finding,) = record.findings
    assert (finding.code, finding.severity) == ("skipped_messages", "error")
    assert (finding.details.count, finding.details.place.number) == (50, planted[0] + 1)
    whole = np.array([float(line.split(b",")[10]) for line in np.delete(np.array(lines, dtype=object), planted)])
    np.testing.assert_array_equal(record.stream_of("gyro_x").column("gyro_x"), whole)
