"""Headerless layouts: the columns that are suggested are right, or the question is asked; never wrong."""

import contextlib

import numpy as np
import pytest

from known import seed_of
from sigmatau import OptionError, read

N = 3000
DEG = np.pi / 180
ASKED = None


def rng_of(name):
    return np.random.default_rng(seed_of(f"layout {name}"))


def time(step=0.01, start=0.0):
    return start + step * np.arange(N)


def gyro(rng, unit=1.0, *, bias=(0.012, -0.007, 0.004), noise=8.7e-4):
    """A gyro at rest; 0.3 deg/√h at 100 Hz. [rad/s / unit]"""
    return (np.array(bias) + noise * rng.standard_normal((N, 3))) / unit


def accel(rng, unit=1.0, *, tilt=(0.3, -0.5, 9.78), noise=0.01):
    """An accelerometer at rest; 0.06 m/s/√h at 100 Hz. [m/s^2 / unit]"""
    return (np.array(tilt) + noise * rng.standard_normal((N, 3))) / unit


def field(rng, scale=1.0, noise=0.4):
    """A magnetometer at rest. [uT·scale]"""
    return scale * (np.array([21.0, -4.0, 43.0]) + noise * rng.standard_normal((N, 3)))


def temperature(rng):
    return 31.0 + 0.4 * np.linspace(0, 1, N) + 0.02 * rng.standard_normal(N)


def quaternion(rng):
    angles = np.cumsum(1e-5 * rng.standard_normal((N, 3)), axis=0) + np.array([0.02, -0.01, 0.7])
    q = np.column_stack([np.ones(N), *(angles / 2).T])
    return np.round(q / np.linalg.norm(q, axis=1)[:, None], 6)


def euler(rng):
    return np.array([0.2, 3.1, 9.1]) + np.cumsum(1e-3 * rng.standard_normal((N, 3)), axis=0)


def position(rng):
    held = np.repeat(rng.standard_normal((N // 100, 3)), 100, axis=0)
    return np.array([48.137, 11.575, 519.0]) + held * np.array([1e-6, 1e-6, 0.4])


def velocity(rng):
    return np.repeat(0.02 * rng.standard_normal((N // 10, 3)), 10, axis=0)


def counts(values, per_unit):
    return np.rint(values * per_unit)


def with_nan(values, every):
    sparse = np.full_like(values, np.nan)
    sparse[::every] = values[::every]
    return sparse


def turned(rng):
    t = np.linspace(0, 20, N)
    rates = np.column_stack([0.8 * np.sin(t), 0.5 * np.cos(1.3 * t), 0.3 * np.sin(0.7 * t)]) + gyro(rng)
    tilted = 9.8 * np.column_stack([np.sin(0.5 * t), np.zeros(N), np.cos(0.5 * t)]) + 0.01 * rng.standard_normal((N, 3))
    return rates, tilted


# The columns of each layout, and the right options; ASKED where the values do not tell.
LAYOUTS = {
    "accel first, m/s^2": (lambda r: (time(), accel(r), gyro(r)), "time=1,accel=2:4,gyro=5:7"),
    "gyro first, temperature last": (
        lambda r: (time(), gyro(r), accel(r), temperature(r)),
        "time=1,gyro=2:4,accel=5:7",
    ),
    "us, g and deg/s with a bias": (
        lambda r: (time(1e4), accel(r, 9.81), gyro(r, DEG, bias=(0.02, -0.03, 0.01))),
        "time=1,accel=2:4,gyro=5:7",
    ),
    "epoch in s": (lambda r: (time(0.01, 1.7e9), gyro(r), accel(r), np.zeros(N)), "time=1,gyro=2:4,accel=5:7"),
    "counter and time": (
        lambda r: (np.arange(N), time(1e4, 5e6), gyro(r), accel(r)),
        "time=2,gyro=3:5,accel=6:8",
    ),
    "counter that wraps": (
        lambda r: (time(), np.arange(N) % 256, gyro(r), accel(r)),
        "time=1,gyro=3:5,accel=6:8",
    ),
    "temperature between, MPU order": (
        lambda r: (time(10), accel(r), temperature(r), gyro(r)),
        "time=1,accel=2:4,gyro=6:8",
    ),
    "quaternion, gyro, accel": (
        lambda r: (time(), quaternion(r), gyro(r), accel(r)),
        "time=1,gyro=6:8,accel=9:11",
    ),
    "accel, gyro, mag in uT": (
        lambda r: (time(), accel(r), gyro(r), field(r)),
        "time=1,accel=2:4,gyro=5:7",
    ),
    "mag in gauss between": (
        lambda r: (time(), gyro(r), field(r, 0.01), accel(r)),
        "time=1,gyro=2:4,accel=8:10",
    ),
    "euler angles behind": (
        lambda r: (time(), gyro(r), accel(r), euler(r)),
        "time=1,gyro=2:4,accel=5:7",
    ),
    "position of GPS in front": (
        lambda r: (time(), position(r), gyro(r), accel(r)),
        "time=1,gyro=5:7,accel=8:10",
    ),
    "mg": (lambda r: (time(), accel(r, 9.80665e-3), gyro(r)), "time=1,accel=2:4,gyro=5:7"),
    "counts, 4096 per g": (
        lambda r: (time(10), counts(accel(r, 9.81), 4096), counts(gyro(r, DEG, noise=2e-3), 16.4), np.ones(N)),
        "time=1,accel=2:4,gyro=5:7 --unit accel=g --scale accel=0.000244141",
    ),
    "columns of NaN": (
        lambda r: (time(), np.full(N, np.nan), with_nan(field(r), 10), gyro(r), accel(r)),
        "time=1,gyro=6:8,accel=9:11",
    ),
    "accelerometer alone": (lambda r: (time(), accel(r)), "time=1,accel=2:4"),
    "gyro alone": (lambda r: (time(), gyro(r)), "time=1,gyro=2:4"),
    "no time, a status": (lambda r: (np.ones(N), gyro(r), accel(r)), "gyro=2:4,accel=5:7"),
    "two IMUs side by side": (lambda r: (time(), gyro(r), accel(r), gyro(r), accel(r)), ASKED),
    "two gyros and an accelerometer": (lambda r: (time(), gyro(r), gyro(r), accel(r)), ASKED),
    "one axis": (lambda r: (time(), gyro(r)[:, :1]), ASKED),
    "velocity beside": (lambda r: (time(), velocity(r), gyro(r), accel(r)), ASKED),
    "turned by hand": (lambda r: (time(), *turned(r)), ASKED),
    "turned by hand, gyro": (lambda r: (time(), turned(r)[0]), ASKED),
    "magnetometer alone": (lambda r: (time(), field(r)), ASKED),
    "magnetometer of norm 1 alone": (lambda r: (time(), field(r, 1 / 48.0)), ASKED),
    "acceleration without gravity": (lambda r: (time(), accel(r, tilt=(0.02, 0.01, -0.03))), ASKED),
    "quaternion alone": (lambda r: (time(), quaternion(r)), ASKED),
    "euler angles alone": (lambda r: (time(), euler(r)), ASKED),
    "position and velocity": (lambda r: (time(), position(r), velocity(r)), ASKED),
    "gyro of 1 deg/s alone": (lambda r: (time(), gyro(r, DEG, bias=(0.0174, 0.001, 0.002), noise=1e-4)), ASKED),
    "two of three axes": (lambda r: (time(), gyro(r)[:, :2], accel(r)), ASKED),
}


@pytest.mark.parametrize("name", LAYOUTS)
def test_layouts(name, tmp_path):
    columns, right = LAYOUTS[name]
    log = tmp_path / "log.csv"
    np.savetxt(log, np.column_stack(columns(rng_of(name))), delimiter=",", fmt="%.15g")
    record = None
    with contextlib.suppress(OptionError):  # six columns with gravity and a time are read without a question
        record = read(log, unit={"time": "s", "gyro": "rad/s", "accel": "m/s^2"})
    if record is None:
        with pytest.raises(OptionError) as caught:
            read(log)
        assert str(caught.value).partition("run with --channels ")[2] == (right or "")
        assert bool(caught.value.rows) == (right is ASKED)
        return
    (finding,) = (f for f in record.findings if f.code == "columns_by_gravity")
    places = {"gyro": finding.details.gyro, "accel": finding.details.accel}
    read_as = {"time=1", *(f"{sensor}={first}:{last}" for sensor, (first, last) in places.items())}
    assert read_as == set(right.split(","))


@pytest.mark.parametrize("names", ["z,y,x", "Z,Y,X", "rate_z,rate_y,rate_x"])
def test_axes_in_the_order_of_their_names(names, tmp_path):
    rng = rng_of(names)
    log = tmp_path / "log.csv"
    np.savetxt(
        log, np.column_stack([time(), gyro(rng)]), delimiter=",", header=f"time,{names}", comments="", fmt="%.9g"
    )
    with pytest.raises(OptionError, match=r"--channels time=1,gyro_x=4,gyro_y=3,gyro_z=2$"):
        read(log)


def test_names_that_contradict_the_values_are_asked_about(tmp_path):
    rng = rng_of("contradiction")
    log = tmp_path / "log.csv"
    header = "time,gyrate.x,gyrate.y,gyrate.z"
    np.savetxt(log, np.column_stack([time(), accel(rng)]), delimiter=",", header=header, comments="", fmt="%.9g")
    with pytest.raises(OptionError, match="values do not show"):
        read(log)


SHARED = {
    "suggest_t_xyz.csv": "time=1,gyro=2:4",
    "suggest_zyx_epoch.csv": "time=2,gyro_x=5,gyro_y=4,gyro_z=3",
    "suggest_quat.csv": "time=1,gyro=6:8,accel=9:11",
    "suggest_mag_between.csv": "time=1,accel=2:4,gyro=8:10",
    "mpu_accel_first.txt": "time=1,accel=2:4,gyro=5:7 --unit accel=g --scale accel=6.10352e-05",
}


@pytest.mark.parametrize("name", SHARED)
def test_shared_layouts(name, field_data):
    with pytest.raises(OptionError) as caught:
        read(field_data / "cases" / name)
    assert str(caught.value).endswith(f"run with --channels {SHARED[name]}")


@pytest.mark.parametrize("columns", [6, 13, 40])
def test_the_first_rows_fit_a_terminal(columns, tmp_path):
    values = np.random.default_rng(seed_of(f"rows {columns}")).standard_normal((200, columns)) * 1e5
    path = tmp_path / "log.txt"
    np.savetxt(path, values, fmt="%.6f")
    with pytest.raises(OptionError) as asked:
        read(path)
    lines = asked.value.rows.split("\n")
    assert max(map(len, lines)) <= 80
    assert f"{values[2, 5]:.6g}" in asked.value.rows
    assert ("40 columns" in asked.value.rows) == (columns == 40)
    assert len(lines) == {6: 4, 13: 13, 40: 17}[columns]
