"""Records made by others, and what others computed from them. Skipped, saying so, where the data are absent."""

import csv
import gzip
import itertools
import json

import numpy as np
import pytest

from sigmatau import Record, allan, analyze, read
from sigmatau.cli import main


@pytest.fixture(scope="module")
def adis(field_data):
    return read(field_data / "adis16405_static.csv.gz", rate=100)


def test_adis_equals_the_r_package(adis, field_data):
    """18 averaging times, six axes, by the R package avar; 1e-5 is the agreement asked for."""
    with (field_data / "adis16405_imu1_reference_avar.csv").open() as file:
        rows = list(csv.DictReader(file))
    si = {"Gyro": np.deg2rad(1.0), "Accel": 9.80665}
    taus = sorted({float(row["tau_s"]) for row in rows})
    curves = allan(adis, taus=taus)
    assert len(rows) == 6 * len(taus)
    for row in rows:
        sensor, axis = row["axis"].replace(".", "").split()
        curve = curves[f"{sensor.lower()}_{axis.lower()}"]
        k = int(np.argmin(np.abs(curve.tau - float(row["tau_s"]))))
        assert curve.avar[k] == pytest.approx(float(row["avar"]) * si[sensor] ** 2, rel=1e-5)


@pytest.fixture(scope="module")
def adis_analysis(adis):
    return analyze(adis)


def test_adis_random_walk(adis_analysis):
    """Datasheet 0.05 (deg/s)/√Hz one-sided, about 2 deg/√h; 2.3 … 2.8 by others' fits. z is filtered at its short end."""
    read_axes = 0
    for channel in ("gyro_x", "gyro_y", "gyro_z"):
        found = adis_analysis.read_off[channel]
        if "random_walk" in found:
            value = found["random_walk"].value / (np.deg2rad(1.0) / 60)
            assert 2.2 <= value <= 2.8, channel
            read_axes += 1
    assert read_axes >= 2
    z = adis_analysis.read_off["gyro_z"].get("random_walk")
    assert z is None or z.tau_min >= 0.04


class TestAdisFitted:
    """Honest about a real unit: filtered gyros, accelerometers with a line at 0.53 … 0.57 Hz that is not quite steady."""

    @pytest.mark.parametrize("channel", ["gyro_x", "gyro_y", "gyro_z"])
    def test_gyros(self, adis_analysis, channel):
        """Others fit N = 2.30 … 2.77 deg/√h and B = 24 … 41 deg/h to such units; datasheet 2 deg/√h, 25 deg/h."""
        fitted = adis_analysis.fits[channel]
        assert fitted.verdict == "adequate_with"
        assert fitted.response is not None
        walk = fitted["random_walk"]
        assert 2.2 <= walk.to("deg/sqrt(h)") <= 2.8
        assert walk.high / walk.low < 1.04
        flicker = fitted["bias_instability"]
        if flicker.observed:
            assert 20 <= flicker.to("deg/h") <= 45
        else:
            # Of the x axis two processes are as good, and so are flicker noises of other exponents: the limit holds
            # what others fit, and at most twice that.
            assert fitted.second
            assert 25 <= flicker.upper_limit / np.deg2rad(1 / 3600) <= 80

    @pytest.mark.parametrize("channel", ["accel_x", "accel_y", "accel_z"])
    def test_accelerometers_are_adequate_beside_their_lines(self, adis_analysis, channel):
        fitted = adis_analysis.fits[channel]
        assert fitted.verdict == "adequate_with"
        assert any(0.5 <= line.frequency.value <= 0.6 for line in fitted.sinusoid)
        walk = fitted["random_walk"]
        # The level changes along the record by some percent, and the noise of the coarse rounding is below it.
        assert "changing_level" in {one.cause for one in fitted.adjustments}
        assert walk.high / walk.value < 1.15
        assert walk.value / walk.low < 1.2


def test_adis_checks(adis_analysis):
    """What the set is known for."""
    found = adis_analysis.findings
    assert {"gyro_x", "gyro_y", "gyro_z"} <= {f.channel for f in found if f.code == "low_pass_filter"}
    lines = {finding.channel: finding for finding in found if finding.code == "spectral_line"}
    for channel in ("accel_x", "accel_y", "accel_z"):
        (line,) = (one for one in lines[channel].details.lines if 0.53 <= one.frequency <= 0.57)
        assert any(one.frequency == pytest.approx(1.69, abs=0.005) for one in line.harmonics)
    coarse = {finding.channel for finding in found if finding.code == "coarse_resolution"}
    assert coarse >= {"accel_x", "accel_y", "accel_z"}


def test_adis_by_the_command_line(field_data, tmp_path, capsys):
    figure, result, log = tmp_path / "adis.svg", tmp_path / "adis.json", tmp_path / "adis.csv.gz"
    with gzip.open(field_data / "adis16405_static.csv.gz", "rt") as whole, gzip.open(log, "wt") as part:
        part.writelines(itertools.islice(whole, 36_001))
    # Read off, because the tests above have the fits.
    options = ["--rate", "100", "--method", "read-off", "--plot", str(figure), "--json", str(result)]
    assert main(["analyze", str(log), *options]) == 0
    out = capsys.readouterr().out
    assert "gyro: 3 channels, 36000 samples at 100 Hz (given), 360 s" in out
    assert list(json.loads(result.read_text())["channels"]) == [f"{s}_{a}" for s in ("gyro", "accel") for a in "xyz"]
    assert b"Gyroscopes" in figure.read_bytes() or figure.stat().st_size > 20_000


def test_hfi_equals_the_ros_tool(field_data):
    """Non-overlapped, at the 10 Hz that tool assumed, gyro in deg/s; where n divides the record it loses a cluster."""
    record = read(
        field_data / "hfi" / "imu_data.txt.gz",
        rate=10,
        channels={"gyro": "2:4", "accel": "5:7"},
        unit={"gyro": "rad/s", "accel": "g"},
    )
    with gzip.open(field_data / "hfi" / "allan_variance.csv.gz", "rt") as file:
        table = np.loadtxt(file)
    n = record.streams[0].grid.n
    sizes = np.rint(table[:, 0] * 10).astype(int)
    usable = (n % sizes != 0) & (sizes <= n // 2)
    assert usable.sum() > 9900
    curves = allan(record, taus=sizes[usable] / 10, overlap="none")
    units = {"gyro": np.deg2rad(1.0), "accel": 9.80665}
    for column, channel in enumerate(["accel_x", "accel_y", "accel_z", "gyro_x", "gyro_y", "gyro_z"], 1):
        curve = curves[channel]
        assert curve.m.tolist() == sizes[usable].tolist()
        assert curve.adev / units[channel[:-2]] == pytest.approx(table[usable, column], rel=1e-4)


def test_hfi_rate(field_data):
    """9.86 Hz by its own stamps, whatever its configuration files say."""
    record = read(
        field_data / "hfi" / "imu_data.txt.gz",
        channels={"time": 1, "gyro": "2:4"},
        unit={"gyro": "rad/s", "time": "s"},
    )
    assert record.streams[0].grid.rate == pytest.approx(9.86, abs=0.005)


@pytest.mark.parametrize("axis", "xyz")
def test_vn100_equals_its_reference(field_data, axis):
    """Overlapped, 14,994 averaging times in samples, gyro samples [187:30177]; 1e-9."""
    with gzip.open(field_data / "vn100" / "live_capture.txt.gz", "rt") as file:
        lines = [line.split("*")[0].split(",") for line in file if line.startswith("$VNYMR")]
    y = np.array([float(fields[10 + "xyz".index(axis)]) for fields in lines])[187:30177]
    with gzip.open(field_data / "vn100" / f"oadev_{axis}.csv.gz", "rt") as file:
        table = np.loadtxt(file, delimiter=",", skiprows=1)
    curve = allan(Record.from_arrays(rate=1, gyro_x=y), taus=table[:, 0])["gyro_x"]
    assert len(curve.m) == len(table) == 14994
    assert curve.adev == pytest.approx(table[:, 1], rel=1e-9)


def test_mpu6050_rate(field_data):
    """99.32 Hz over the span; bursts make the median interval say 491 Hz."""
    record = read(field_data / "mpu6050_10min.npz", unit={"time": "s"})
    assert record.streams[0].grid.rate == pytest.approx(99.32, abs=0.05)
    assert set(record.channels) == {*(f"{s}_{a}" for s in ("gyro", "accel") for a in "xyz"), "temperature"}
