"""Tables without names: gravity says which three columns are the accelerometers."""

import numpy as np
import pytest

from known import seed_of
from sigmatau import OptionError, inspect, read


def rows(size, *, gyro_mean=0.002, tilt=(0.1, 0.2, 1.0), n=400):
    rng = np.random.default_rng(seed_of(f"nameless {size} {gyro_mean}"))
    direction = np.array(tilt) / np.linalg.norm(tilt)
    gyro = gyro_mean + 0.01 * rng.standard_normal((n, 3))
    return np.arange(n) / 50, gyro, size * (direction + 0.004 * rng.standard_normal((n, 3)))


def write(path, *columns):
    np.savetxt(path, np.column_stack(columns), fmt="%.9g")
    return path


@pytest.mark.parametrize(
    ("first", "size", "unit"), [("gyro", 1.0, "g"), ("accel", 9.81, "m/s^2"), ("gyro", 1000.0, "mg")]
)
def test_gravity_tells(tmp_path, size, unit, first):
    t, gyro, accel = rows(size)
    log = write(tmp_path / "log.txt", t, *((gyro, accel) if first == "gyro" else (accel, gyro)))
    record = read(log, unit={"time": "s", "gyro": "rad/s", "accel": unit})
    assert record.stream_of("gyro_y").column("gyro_y") == pytest.approx(gyro[:, 1], abs=1e-8)
    assert record.streams[0].grid.rate == pytest.approx(50)
    (finding,) = (f for f in record.findings if f.code == "columns_by_gravity")
    found = finding.details
    assert (found.time, found.gyro, found.accel) == (1, *(((2, 4), (5, 7)) if first == "gyro" else ((5, 7), (2, 4))))
    assert found.gravity == pytest.approx(size, rel=0.05)


@pytest.mark.parametrize("unit", [{}, {"time": "s", "gyro": "rad/s", "accel": "g"}])
def test_inspect_shows_the_channels(tmp_path, unit):
    """Also while it asks for units."""
    t, gyro, accel = rows(1.0)
    found = inspect(write(tmp_path / "log.txt", t, accel, gyro), unit=unit)
    expected = ["time", *(f"{sensor}_{axis}" for sensor in ("accel", "gyro") for axis in "xyz")]
    assert [column.channel for column in found.tables[0].columns] == expected
    assert [finding.code for finding in found.tables[0].findings].count("columns_by_gravity") == 1
    assert bool(found.tables[0].wanting) == (not unit)


def test_without_time(tmp_path):
    _, gyro, accel = rows(9.8)
    record = read(write(tmp_path / "log.txt", gyro, accel), rate=50, unit={"gyro": "rad/s", "accel": "m/s^2"})
    assert record.channels == ("gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z")


@pytest.mark.parametrize("what", ["both", "none", "moving", "a gyro of 0.5", "time", "eight"])
def test_what_is_not_certain_is_asked_for(tmp_path, what):
    t, gyro, accel = rows(1.0)
    columns = [t, gyro, accel]
    if what == "both":
        columns[1] = accel
    elif what == "none":
        columns[2] = gyro
    elif what == "moving":
        columns[2] = accel * np.linspace(0.5, 1.5, len(t))[:, None]
    elif what == "a gyro of 0.5":
        columns[1] = gyro + 0.3
    elif what == "time":
        columns[0] = t[::-1]
    else:
        columns.append(t)
    log = write(tmp_path / "log.txt", *columns)
    with pytest.raises(OptionError, match="no column names"):
        read(log, unit={"gyro": "rad/s", "accel": "g"}, rate=50)


@pytest.mark.parametrize("first", ["gyro", "accel"])
def test_a_moving_sensor_is_asked_for_with_its_first_rows(tmp_path, first):
    """No values confirm which columns are which where the sensor is turned."""
    t, gyro, accel = rows(9.81)
    gyro[50:] += 2 * np.sin(t[50:, None])
    accel[50:] *= np.linspace(1.0, 1.5, len(t) - 50)[:, None]
    log = write(tmp_path / "log.txt", *((gyro, accel) if first == "gyro" else (accel, gyro)))
    with pytest.raises(OptionError, match="values do not show") as caught:
        read(log, rate=50)
    numbers, *lines = caught.value.rows.splitlines()
    assert numbers.split() == ["1", "2", "3", "4", "5", "6"]
    assert len(lines) == 3
    assert [float(text) for text in lines[0].split()] == pytest.approx(np.loadtxt(log)[0], rel=1e-5)


def test_field_log_without_a_header(field_data):
    """Rates in rad/s and g, a time in front, no header: with its units it opens."""
    log = field_data / "hfi" / "imu_data.txt.gz"
    record = read(log, unit={"time": "s", "gyro": "rad/s", "accel": "g"})
    assert record.streams[0].grid.rate == pytest.approx(9.8626, abs=1e-3)
    named = read(
        log,
        channels={"time": 1, "gyro": "2:4", "accel": "5:7"},
        unit={"time": "s", "gyro": "rad/s", "accel": "g"},
    )
    assert np.array_equal(record.stream_of("accel_z").column("accel_z"), named.stream_of("accel_z").column("accel_z"))
