"""Sensors in hands that are as quiet as a sensor's noise, and accelerometers that tilt steadily: not at rest."""

import numpy as np
import pytest
from studies.motions import band
from studies.rest_windows import verdict

import sigmatau as st
from known import seed_of

GRAVITY = 9.80665


def record(name, *, rate=100.0, seconds=20.0, gyro=0.0, accel=0.0, corner=None, sensors="both", noise=0.36):
    """White noise of a MEMS, 0.36 deg/√h and 0.06 m/s/√h, behind a low-pass filter if a corner is stated [Hz]."""
    rng = np.random.default_rng(seed_of(name))
    n = round(rate * seconds)
    random_walk = noise / 60
    columns = {
        "gyro": np.radians(random_walk) * np.sqrt(rate) * rng.standard_normal((n, 3)) + gyro,
        "accel": random_walk / 6 * np.sqrt(rate) * rng.standard_normal((n, 3)) + accel,
    }
    if corner is not None:
        f = np.fft.rfftfreq(n, 1 / rate)[:, None]
        for sensor, x in columns.items():
            columns[sensor] = np.fft.irfft(np.fft.rfft(x, axis=0) / np.sqrt(1 + (f / corner) ** 4), n, axis=0)
    columns["accel"] = columns["accel"] + [0.0, 0.0, GRAVITY]
    return st.Record.from_arrays(rate=rate, **{k: x for k, x in columns.items() if sensors in ("both", k)})


def shaking(name, rate, seconds, size, slow):
    """Tremor of 8 to 12 Hz of a size [deg/s], and motion of 0.3 to 4 Hz of a part of it, on an axis."""
    rng = np.random.default_rng(seed_of(name))
    n = round(rate * seconds)
    fast, slower = (np.stack([band(rng, n, rate, *edges) for _ in "xyz"], axis=1) for edges in ((8, 12), (0.3, 4)))
    return size * (fast + slow * slower)


@pytest.mark.parametrize("sensors", ["both", "gyro"])
@pytest.mark.parametrize("slow", [0.0, 0.35, 0.6])
@pytest.mark.parametrize(("rate", "seconds", "size"), [(50, 60, 0.4), (100, 12, 0.3), (100, 40, 0.12), (400, 20, 0.8)])
def test_a_hand_is_recognised_whatever_the_length(rate, seconds, size, slow, sensors):
    name = f"hand {rate} {seconds} {size} {slow}"
    gyro = np.radians(shaking(name + " gyro", rate, seconds, size, slow))
    accel = shaking(name + " accel", rate, seconds, size / 9, slow)
    found = verdict(record(name, rate=rate, seconds=seconds, gyro=gyro, accel=accel, sensors=sensors))
    assert (found.verdict, found.motion.kind) == ("not_at_rest", "shakes")
    assert np.degrees(found.motion.size) == pytest.approx(size, rel=0.5)


@pytest.mark.parametrize("name", ["once", "again"])
@pytest.mark.parametrize(("rate", "seconds", "size"), [(50, 60, 0.4), (100, 12, 0.3), (100, 40, 0.12), (400, 20, 0.8)])
def test_a_hand_whose_slow_motion_is_as_large_as_its_tremor(rate, seconds, size, name):
    """The tremor stands out from the valley between the two."""
    name = f"slow hand {rate} {seconds} {size} {name}"
    gyro = np.radians(shaking(name + " gyro", rate, seconds, size, 1.0))
    accel = shaking(name + " accel", rate, seconds, size / 9, 1.0)
    assert verdict(record(name, rate=rate, seconds=seconds, gyro=gyro, accel=accel)).verdict == "not_at_rest"


@pytest.mark.parametrize("noise", [0.36, 3.0])
@pytest.mark.parametrize("corner", [5.0, 10.0, 20.0])
def test_a_low_pass_filter_is_not_a_hand(corner, noise):
    assert verdict(record(f"low pass {corner} {noise}", corner=corner, seconds=60, noise=noise)).verdict == "at_rest"


@pytest.mark.parametrize("noise", [0.36, 3.0])
@pytest.mark.parametrize("length", [4, 8, 12, 15, 16, 18, 20, 25, 32])
def test_a_moving_average_is_not_a_hand(length, noise):
    """Its lobes stand out on all axes."""
    x = record(f"moving average {length} {noise}", seconds=60, noise=noise)
    kernel = np.ones(length) / length
    columns = {c: np.convolve(x.stream_of(c).column(c), kernel, mode="valid") for c in x.channels}
    assert verdict(st.Record.from_arrays(rate=100, **columns)).verdict == "at_rest"


def test_vibration_at_the_frequency_of_a_hand_is_not_a_hand():
    """Lines of a motor, on all axes; and a resonance of the accelerometers alone."""
    t = np.arange(6000) / 100
    line = np.sin(2 * np.pi * 10.3 * t)[:, None] * np.array([1.0, 0.7, 0.5])
    lines = record("lines", seconds=60, gyro=np.radians(0.3) * line, accel=0.03 * line)
    assert verdict(lines).verdict == "at_rest"
    rings = record("rings", seconds=60, accel=shaking("rings accel", 100, 60, 0.03, 0.0))
    assert verdict(rings).verdict == "at_rest"


def tilted(angle):
    return GRAVITY * np.column_stack([np.sin(angle), 0 * angle, np.cos(angle) - 1])


@pytest.mark.parametrize(
    ("degrees", "seconds"), [(4, 20), (8, 120), (10, 300), (7, 600), (25, 300), (40, 600), (10, 7200)]
)
def test_a_steady_tilt_is_motion(degrees, seconds):
    """Of accelerometers alone: neither the rate nor the length matters."""
    rate = 100.0 if seconds < 1000 else 20.0
    angle = np.radians(np.linspace(0, degrees, round(seconds * rate)))
    name = f"tilt {degrees} {seconds}"
    found = verdict(record(name, rate=rate, seconds=seconds, accel=tilted(angle), sensors="accel"))
    assert found.verdict == "not_at_rest"


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("time", [20.0, 100.0, 400.0])
@pytest.mark.parametrize("seconds", [60, 1800])
def test_a_warm_up_of_accelerometers_is_not_a_tilt(time, seconds, sign):
    """50 mg on an axis, at the steepest 50 mg in 100 s."""
    t = np.arange(round(20.0 * seconds)) / 20.0
    size = sign * 0.05 * GRAVITY * min(time / 100, 1)
    warm = np.column_stack([size * np.exp(-t / time), -0.5 * size * np.exp(-t / time), 0 * t])
    log = record(f"warm {time} {seconds}", rate=20.0, seconds=seconds, accel=warm, sensors="accel")
    assert verdict(log).verdict == "at_rest"
