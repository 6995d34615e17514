"""What is said of real records, and that it is true of them. Skipped, saying so, where the data are absent."""

import pytest
from clean_records import check_samples as check

from sigmatau import read
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
        ("spikes", "info"),
    }
    assert sum(f.details.count for f in found["spikes", "info"]) <= 10


@pytest.mark.parametrize(
    ("unit", "codes"), [("m/s^2", {("implausible_unit", "warning")}), ("g", {("gravity", "info")})]
)
def test_hfi_is_in_g_whatever_its_header_says(field_data, unit, codes):
    log = field_data / "hfi" / "imu_data.txt.gz"
    found = said(read(log, channels=HFI, unit={"gyro": "rad/s", "time": "s", "accel": unit}))
    assert set(found) == codes
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
    assert {f.code for f in warned} == {"not_static"}
    for finding in warned:
        assert 735 <= finding.spans[0][0] <= 750
    assert set(found) <= {("not_static", "warning"), ("gravity", "info"), ("spikes", "info")}
