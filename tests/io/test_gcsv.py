"""Logs of Gyroflow: counts with their scales in the head."""

import math

import numpy as np
import pytest

from known import seed_of
from sigmatau import OptionError, read

TITLES = {"gyroflow": "GYROFLOW IMU LOG", "older": "CAMERA IMU LOG"}
N = 400
GSCALE, ASCALE = 0.00122173047, 0.00048828125  # rad/s and g per count


def write(path, title="GYROFLOW IMU LOG", tscale="0.001", scales=("gscale", "ascale"), *, accel=True):
    rng = np.random.default_rng(seed_of("gyroflow log"))
    counts = np.rint(rng.normal(3, 2, (N, 6)) + np.array([0, 0, 0, 5, 9, 2048])).astype(int)
    sizes = {"gscale": GSCALE, "ascale": ASCALE}
    head = [title, "version,1.3", "orientation,YxZ", f"tscale,{tscale}", *(f"{s},{sizes[s]}" for s in scales)]
    rows = [f"{2 * k}," + ",".join(map(str, row[: 6 if accel else 3])) for k, row in enumerate(counts.tolist())]
    path.write_text("\n".join([*head, "t,gx,gy,gz" + ",ax,ay,az" * accel, *rows]) + "\n")
    return counts


@pytest.mark.parametrize("title", TITLES.values(), ids=TITLES)
@pytest.mark.parametrize("accel", [True, False], ids=["both sensors", "gyro alone"])
def test_counts_times_the_scales_of_the_head(tmp_path, title, accel):
    path = tmp_path / "a.gcsv"
    counts = write(path, title, accel=accel)
    record = read(path)
    gyro = record.stream_of("gyro_y")
    assert gyro.grid.rate == pytest.approx(500.0)
    np.testing.assert_allclose(gyro.column("gyro_y"), counts[:, 1] * GSCALE, rtol=1e-12)
    if accel:
        force = record.stream_of("accel_z").column("accel_z")
        np.testing.assert_allclose(force, counts[:, 5] * ASCALE * 9.80665, rtol=1e-12)
    assert record.findings == ()


def test_a_scale_that_the_head_lacks_is_asked_for(tmp_path):
    path = tmp_path / "a.gcsv"
    counts = write(path, scales=("ascale",))
    with pytest.raises(OptionError, match="does not state the unit of gyro_x, gyro_y, gyro_z; give"):
        read(path)
    record = read(path, unit={"gyro": "deg/s"}, scale={"gyro": 0.07})
    gyro = record.stream_of("gyro_x").column("gyro_x")
    np.testing.assert_allclose(gyro, np.radians(0.07 * counts[:, 0]), rtol=1e-12)


def test_another_unit_than_that_of_the_head_is_refused(tmp_path):
    path = tmp_path / "a.gcsv"
    write(path)
    assert math.isclose(read(path, unit={"gyro": "rad/s", "time": "s"}).stream_of("gyro_x").grid.rate, 500.0)
    with pytest.raises(OptionError, match=r"gyro=deg/s: the head of the file states that column 'gx' counts in rad/s"):
        read(path, unit={"gyro": "deg/s"})


def test_the_same_table_without_the_title_is_in_counts(tmp_path):
    path = tmp_path / "a.csv"
    write(path, "SOME LOG")
    with pytest.raises(OptionError, match="does not state the unit of gyro_x"):
        read(path)
