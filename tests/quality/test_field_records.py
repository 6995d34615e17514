"""What is said of real records, and that it is true of them. Skipped, saying so, where the data are absent."""

import pytest
from clean_records import check_samples as check

from sigmatau import analyze, read
from sigmatau.fitting.channel import fit_channel
from sigmatau.quality.samples.resolution import resolution

HFI = {"time": 1, "gyro": "2:4", "accel": "5:7"}


def said(record):
    found = {}
    for stream in (s for s in record.streams if s.quantity != "temperature"):
        for finding in check(stream):
            found.setdefault((finding.code, finding.severity), []).append(finding)
    return found


def test_adis16405(field_data):
    """Its data sheet: 0.05 deg/s and 3.33 mg a step; the accelerometers' noise is about one of these."""
    record = read(field_data / "adis16405_static.csv.gz", rate=100)
    steps = {c: resolution(record.stream_of(c), c) for c in record.channels}
    for channel, found in steps.items():
        si = 0.05 * 3.141592653589793 / 180 if channel.startswith("gyro") else 0.00333 * 9.80665
        assert found.step == pytest.approx(si, rel=1e-6)
        assert (6 < found.ratio < 8) if channel.startswith("gyro") else (0.8 < found.ratio < 1.2)
    found = said(record)
    coarse = [f for key in found if key[0] == "coarse_resolution" for f in found[key]]
    assert sorted(f.channel for f in coarse) == ["accel_x", "accel_y", "accel_z"]
    for finding in coarse:
        assert 1.02 < dict(finding.factors)["random_walk"] < 1.08
    assert set(found) == {
        ("coarse_resolution", "info"),
        ("coarse_resolution", "warning"),
        ("gravity", "info"),  # 9.965 m/s²: 16 mg of bias, data sheet 50 mg
        ("spikes", "warning"),
    }
    assert sum(f.details.count for f in found["spikes", "warning"]) <= 10


@pytest.mark.parametrize(("unit", "codes"), [("m/s^2", ("implausible_unit", "warning")), ("g", ("gravity", "info"))])
def test_hfi_is_in_g_whatever_its_header_says(field_data, unit, codes):
    """Its gyro has 0.061 deg/s a step, two thirds of the noise."""
    log = field_data / "hfi" / "imu_data.txt.gz"
    found = said(read(log, channels=HFI, unit={"gyro": "rad/s", "time": "s", "accel": unit}))
    assert set(found) == {codes, ("coarse_resolution", "info")}
    if unit == "m/s^2":
        (finding,) = found["implausible_unit", "warning"]
        assert (finding.details.likely, finding.details.stated) == ("g", "m/s^2")
        assert dict(finding.factors)["random_walk"] == pytest.approx(1 / 9.80665)


def test_mpu6050(field_data):
    """1/131 deg/s and 1/4096 g a step, a twelfth of the noise or less; 37 mg of bias, data sheet 80 mg."""
    record = read(field_data / "mpu6050_10min.npz", unit={"time": "s"})
    channels = [c for c in record.channels if c != "temperature"]
    steps = [resolution(record.stream_of(c), c).step for c in channels]
    assert steps == pytest.approx([3.141592653589793 / 180 / 131] * 3 + [9.80665 / 4096] * 3, rel=1e-5)
    assert set(said(record)) == {("gravity", "info")}


def test_vn100_is_touched_at_its_end(field_data):
    """Twelve seconds before the record ends all axes move: it was stopped by hand."""
    record = read(field_data / "vn100" / "live_capture.txt.gz", rate=40)
    found = said(record)
    warned = [f for key in found if key[1] == "warning" for f in found[key]]
    assert {f.code for f in warned} <= {"not_static", "spikes"}
    for finding in (f for f in warned if f.code == "not_static"):
        assert 735 <= finding.spans[0][0] <= 750
    assert set(found) <= {("not_static", "warning"), ("gravity", "info"), ("spikes", "warning")}


def test_bumps_in_a_room_with_people_are_left_out(field_data):
    """Near 227 s. After 500 s of calm, gyro z has 0.32 deg/√h and accel z 0.188 m/s/√h."""
    log = field_data / "field" / "vn100_stationary.mat"
    units = {"time": "us", "gyro": "rad/s", "accel": "m/s^2"}
    found = analyze(read(log, channels={"time": 1, "gyro": "11:13", "accel": "8:10"}, unit=units))
    bumps = [f for f in found.findings if f.code == "not_static" and f.left_out]
    assert [f.channels[0] for f in bumps] == ["gyro_x", "accel_x"]
    for finding in bumps:
        assert any(start - 1 <= 227 <= stop + 1 for start, stop in finding.spans)
        assert finding.left_out < 0.02 * found.curves["gyro_z"].n
    walk = found.fits["gyro_z"]["random_walk"]
    assert walk.to("deg/sqrt(h)") == pytest.approx(0.32, rel=0.04)
    assert found.fits["gyro_z"].terms["bias_instability"].value is None
    walk = found.fits["accel_z"]["random_walk"]
    assert walk.low <= 0.188 / 60 <= walk.high


def test_a_first_row_of_zeros_is_left_out(field_data):
    """It made 0.29 mm/s of quantization noise on accel z, and the fit was called adequate."""
    units = {"gyro": "deg/s", "accel": "m/s^2", "time": "s"}
    found = analyze(read(field_data / "field" / "xdot_2.csv.gz", unit=units))
    zeros = [f for f in found.findings if f.code == "dropout"]
    assert [(f.channels[0], f.left_out, f.spans[0][0]) for f in zeros] == [("gyro_x", 1, 0.0), ("accel_x", 1, 0.0)]
    one = found.fits["accel_z"].terms["quantization"]
    assert not one.observed
    assert (one.upper_limit or 0.0) < 8e-6


def test_slow_lines_beside_each_other(field_data):
    """Seven narrow ones from 0.189 Hz on; they were told as one of 34 Hz, 26 Hz wide, and the gyros were refused."""
    record = read(field_data / "field" / "ch104.mat", rate=100, unit={"gyro": "deg/s", "accel": "g"})
    assert max(record.stream_of("accel_z").column("accel_z")) == pytest.approx(9.8, rel=0.05)  # not on a gyro
    fitted = fit_channel(record, "gyro_x")
    lines = [line.frequency.value for line in fitted.sinusoid]
    for frequency in (0.189, 1.33, 1.70, 2.85, 3.23, 4.33, 4.71):
        assert min(abs(line - frequency) for line in lines) < 0.01
    assert fitted["random_walk"].low > 0
