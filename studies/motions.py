"""Simulated moving sensors: car, walk, drone, hand, turntable, ship at anchor; and sensors that are picked up.

Angles, speeds and positions are smooth functions of time. Body rates and specific forces follow from them by rigid-body
kinematics with gravity; the noise of the sensor is added. Sizes are random, as in everyday life.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

import sigmatau as st

__all__ = ["GRADES", "KINDS", "SMALL_KINDS", "handled", "held", "moving", "sensed"]

Floats = NDArray[np.float64]
Generator = np.random.Generator

GRAVITY = 9.80665
DEGREE = np.pi / 180
EARTH, LATITUDE = 7.292115e-5, 50 * DEGREE  # [rad/s, rad]

# Terms of the gyros and of the accelerometers, by grade.
GRADES: dict[str, tuple[dict[str, str], dict[str, str]]] = {
    "MEMS": (
        {"random_walk": "0.3 deg/sqrt(h)", "bias_instability": "10 deg/h", "rate_random_walk": "20 deg/h/sqrt(h)"},
        {"random_walk": "0.06 m/s/sqrt(h)", "bias_instability": "0.04 mg"},
    ),
    "tactical": (
        {"random_walk": "0.05 deg/sqrt(h)", "bias_instability": "0.5 deg/h", "rate_random_walk": "1 deg/h/sqrt(h)"},
        {"random_walk": "0.02 m/s/sqrt(h)", "bias_instability": "0.02 mg"},
    ),
}


def band(rng: Generator, n: int, rate: float, low: float, high: float) -> Floats:
    """Gaussian noise of unit variance in a band, with the skirts of a second-order filter. [Hz]"""
    f = np.fft.rfftfreq(n, 1 / rate)
    gain = 1 / np.sqrt(1 + (f / high) ** 8)
    gain *= np.where(f > 0, 1 / np.sqrt(1 + (low / np.maximum(f, 1e-9)) ** 8), 0.0) if low > 0 else 1.0
    x = np.fft.irfft(np.fft.rfft(rng.standard_normal(n)) * gain, n)
    return np.asarray(x / x.std())


def _smooth_steps(t: Floats, edges: Floats, values: Floats, ramp: float) -> Floats:
    """Levels that change within `ramp` seconds after each edge, with a continuous first derivative."""
    x = np.full(len(t), values[0])
    for edge, before, after in zip(edges, values[:-1], values[1:], strict=True):
        u = np.clip((t - edge) / ramp, 0, 1)
        x += (after - before) * (3 * u**2 - 2 * u**3)
    return x


def kinematics(angles: Floats, acceleration: Floats, rate: float) -> tuple[Floats, Floats]:
    """Body rates and specific force of roll, pitch, yaw and an acceleration in level axes; shapes (3, n)."""
    roll, pitch, _ = angles
    dr, dp, dy = np.gradient(angles, 1 / rate, axis=1)
    sr, cr, sp, cp = np.sin(roll), np.cos(roll), np.sin(pitch), np.cos(pitch)
    rates = np.stack([dr - dy * sp, dp * cr + dy * sr * cp, -dp * sr + dy * cr * cp])
    # Level axes (forwards, left, up) turn with the heading, so that yaw has no effect.
    ax, ay, az = acceleration[0], acceleration[1], acceleration[2] + GRAVITY
    force = np.stack([cp * ax - sp * az, sr * sp * ax + cr * ay + sr * cp * az, cr * sp * ax - sr * ay + cr * cp * az])
    return rates, force


def _car(rng: Generator, n: int, rate: float) -> tuple[Floats, Floats]:
    t = np.arange(n) / rate
    legs = rng.uniform(8, 40, size=int(t[-1] / 8) + 2)
    speeds = rng.uniform(5, 25, size=len(legs) + 1)
    stops = np.flatnonzero(rng.random(len(speeds) - 2) < 0.3)[::2] + 1  # never two consecutive stops
    speeds[stops], legs[stops] = 0.0, rng.uniform(10, 22, size=len(stops))
    legs = np.cumsum(legs)
    speed = _smooth_steps(t, legs, speeds, 7.0)
    turns = np.cumsum(rng.uniform(6, 30, size=int(t[-1] / 6) + 2))
    heading = _smooth_steps(t, turns, np.cumsum(rng.normal(0, 50 * DEGREE, size=len(turns) + 1)), 5.0)
    heading = np.cumsum(np.gradient(heading) * np.minimum(speed / 5, 1))
    rough = rng.uniform(0.2, 1.0) * np.minimum(speed / 10, 1.5)
    lift = rough * (0.8 * band(rng, n, rate, 0.8, 3) + 0.8 * band(rng, n, rate, 6, 15))
    engine = rng.uniform(0.02, 0.2) * band(rng, n, rate, 0.2 * rate, 0.4 * rate)
    roll = (0.6 * DEGREE) * rough * band(rng, n, rate, 0.1, 2) + 1 * DEGREE * band(rng, n, rate, 0, 0.02)
    pitch = (0.5 * DEGREE) * rough * band(rng, n, rate, 0.1, 2) + 1.5 * DEGREE * band(rng, n, rate, 0, 0.02)
    along = np.gradient(speed, 1 / rate)
    across = speed * np.gradient(heading, 1 / rate)
    return np.stack([roll, pitch, heading]), np.stack([along + engine, across + engine, lift + engine])


def _walk(rng: Generator, n: int, rate: float) -> tuple[Floats, Floats]:
    t = np.arange(n) / rate
    gait = rng.uniform(0.8, 1.1)  # strides
    phase = 2 * np.pi * np.cumsum(gait * (1 + 0.03 * band(rng, n, rate, 0, 0.3))) / rate
    size = rng.uniform(0.4, 1.2) * (1 + 0.1 * band(rng, n, rate, 0, 0.5))
    sway = size * 6 * DEGREE
    angles = np.stack(
        [
            sway * np.sin(phase) + 2 * DEGREE * band(rng, n, rate, 0, 1),
            0.7 * sway * np.sin(2 * phase + 1) + 2 * DEGREE * band(rng, n, rate, 0, 1),
            0.8 * sway * np.sin(phase + 2) + 40 * DEGREE * band(rng, n, rate, 0, 0.05),
        ]
    )
    up = size * (2.5 * np.sin(2 * phase) + 0.8 * np.sin(4 * phase + 1) + 0.5 * band(rng, n, rate, 5, 15))
    along = size * (1.2 * np.sin(2 * phase + 1.5) + 0.3 * band(rng, n, rate, 5, 15))
    across = size * 0.8 * np.sin(phase + 0.4)
    return angles, np.stack([along, across, up]) + 0 * t


def _drone(rng: Generator, n: int, rate: float) -> tuple[Floats, Floats]:
    size = 10 ** rng.uniform(-0.3, 1.0) * DEGREE
    angles = np.stack([*(size * band(rng, n, rate, 0.05, 2) for _ in "xy"), 2 * size * band(rng, n, rate, 0.01, 0.3)])
    shaken = rng.uniform(0.3, 5) * np.stack([band(rng, n, rate, 0.25 * rate, 0.45 * rate) for _ in "xyz"])
    # Thrust is along the body axis: horizontal accelerations come from the tilt.
    level = np.stack([GRAVITY * np.tan(angles[1]), -GRAVITY * np.tan(angles[0]), 0.3 * band(rng, n, rate, 0.05, 1)])
    return angles, level + shaken


def _hand(rng: Generator, n: int, rate: float) -> tuple[Floats, Floats]:
    size = 10 ** rng.uniform(-0.3, 1.5) * DEGREE  # from a hand kept still to a waving hand
    tremor = rng.uniform(0.02, 0.1) * DEGREE
    angles = np.stack(
        [size * band(rng, n, rate, 0, rng.uniform(0.3, 1.5)) + tremor * band(rng, n, rate, 6, 11) for _ in "xyz"]
    )
    moved = np.stack(
        [0.03 * size / DEGREE * band(rng, n, rate, 0.1, 2) + 0.05 * band(rng, n, rate, 6, 11) for _ in "xyz"]
    )
    return angles, moved


def _turntable(rng: Generator, n: int, rate: float) -> tuple[Floats, Floats]:
    t = np.arange(n) / rate
    kind = rng.choice(["constant", "steps", "sine"])
    if kind == "constant":
        turned = np.full(n, rng.choice([-1, 1]) * 10 ** rng.uniform(1.35, 2.3) * DEGREE)
    elif kind == "steps":
        edges = np.cumsum(rng.uniform(8, 15, size=int(t[-1] / 8) + 2))
        turned = _smooth_steps(t, edges, rng.uniform(-100, 100, size=len(edges) + 1) * DEGREE, 1.0)
    else:
        f = 10 ** rng.uniform(-1.3, 0.3)
        turned = rng.uniform(3, 60) * DEGREE * 2 * np.pi * f * np.cos(2 * np.pi * f * t)
    heading = np.cumsum(turned * (1 + 1e-4 * band(rng, n, rate, 0.5, 10))) / rate
    tilt = rng.uniform(0.02, 0.5) * DEGREE
    angles = np.stack([tilt * np.sin(heading), tilt * np.cos(heading), heading])
    arm = rng.uniform(0.01, 0.3)
    return angles, np.stack([-arm * turned**2, arm * np.gradient(turned, 1 / rate), np.zeros(n)])


def _ship(rng: Generator, n: int, rate: float) -> tuple[Floats, Floats]:
    size = 10 ** rng.uniform(-0.7, 0.7) * DEGREE
    period = rng.uniform(5, 14)
    roll = size * band(rng, n, rate, 0.85 / period, 1.15 / period)
    pitch = 0.4 * size * band(rng, n, rate, 1.2 / period, 1.8 / period)
    yaw = size * band(rng, n, rate, 0, 0.02)
    heave = 0.05 * size / DEGREE * band(rng, n, rate, 0.07, 0.25)
    engine = rng.uniform(0.0, 0.03) * band(rng, n, rate, 0.2 * rate, 0.4 * rate)
    arm = rng.uniform(0, 5) * np.gradient(np.gradient(roll, 1 / rate), 1 / rate)
    return np.stack([roll, pitch, yaw]), np.stack([engine, arm + engine, heave + engine])


def _tilted(rng: Generator, n: int, rate: float) -> tuple[Floats, Floats]:
    """A steady tilt of 0.3 to 1 deg/s about both level axes."""
    t = np.arange(n) / rate
    angles = np.zeros((3, n))
    for axis in range(2):
        angles[axis] = rng.choice([-1, 1]) * rng.uniform(0.3, 1.0) * DEGREE * t + rng.uniform(-20, 20) * DEGREE
    return angles, np.zeros((3, n))


def _springs(rng: Generator, n: int, rate: float) -> tuple[Floats, Floats]:
    """A car on its springs, 0.1 to 4 Hz, and its wheels, 8 to 15 Hz: 0.4 m/s² peak to peak (six standard deviations)."""
    low, high = rng.uniform(0.1, 0.8), min(rng.uniform(1.5, 4.0), 0.4 * rate)
    wheels = min(8.0, 0.3 * rate), min(15.0, 0.45 * rate)
    moved = np.stack(
        [
            rng.uniform(0.4, 1) * (band(rng, n, rate, low, high) + rng.uniform(0, 1) * band(rng, n, rate, *wheels))
            for _ in "xyz"
        ]
    )
    return np.zeros((3, n)), moved * (0.4 / 6) / moved.std(axis=1).max()


def _vibrated(rng: Generator, n: int, rate: float) -> tuple[Floats, Floats]:
    """Vibration of 10 to 50 Hz alone, 0.1 to 0.4 m/s² peak to peak."""
    size = rng.uniform(0.1, 0.4) / 6
    return np.zeros((3, n)), size * np.stack([band(rng, n, rate, 10, min(50.0, 0.45 * rate)) for _ in "xyz"])


KINDS: dict[str, Callable[[Generator, int, float], tuple[Floats, Floats]]] = {
    "car": _car,
    "walk": _walk,
    "drone": _drone,
    "hand": _hand,
    "turntable": _turntable,
    "ship": _ship,
}

SMALL_KINDS = {"tilt": _tilted, "springs": _springs, "vibration": _vibrated}
"""Motions that accelerometers alone or one axis must show."""


def mounted(rng: Generator, rates: Floats, force: Floats, largest: float) -> tuple[Floats, Floats]:
    """Rates and forces for a misaligned sensor, turned by up to `largest`. [rad]"""
    roll, pitch, yaw = rng.uniform(-largest, largest, size=3)
    cr, sr, cp, sp, cy, sy = np.cos(roll), np.sin(roll), np.cos(pitch), np.sin(pitch), np.cos(yaw), np.sin(yaw)
    turn = (
        np.array([[1, 0, 0], [0, cr, sr], [0, -sr, cr]])
        @ np.array([[cp, 0, -sp], [0, 1, 0], [sp, 0, cp]])
        @ np.array([[cy, sy, 0], [-sy, cy, 0], [0, 0, 1]])
    )
    return turn @ rates, turn @ force


def sensed(
    rng: Generator, rates: Floats, force: Floats, rate: float, grade: str, *, sensors: str = "both"
) -> st.Record:
    """Record these rates and forces with sensors of a grade; `sensors`: both, gyro or accel."""
    n = rates.shape[1]
    gyro, accel = GRADES[grade]
    channels = {f"gyro_{axis}": gyro for axis in "xyz"} | {f"accel_{axis}": accel for axis in "xyz"}
    noise = st.simulate(st.NoiseModel.from_dict({"channels": channels}), duration=n / rate, rate=rate, rng=rng)
    bias = {
        "gyro": rng.normal(0, 0.3 if grade == "MEMS" else 0.01, size=3) * DEGREE,
        "accel": rng.normal(0, 0.05, size=3),
    }
    true = {"gyro": rates, "accel": force}
    columns = {
        f"{name}_{axis}": true[name][k] + bias[name][k] + noise.stream_of(f"{name}_{axis}").column(f"{name}_{axis}")[:n]
        for name in ("gyro", "accel")
        if sensors in (name, "both")
        for k, axis in enumerate("xyz")
    }
    return st.Record.from_arrays(rate=rate, **columns)


def moving(
    seed: int,
    kind: str,
    *,
    sensors: str = "both",
    rate: float | None = None,
    minutes: float | None = None,
    grade: str | None = None,
) -> st.Record:
    """A record of a sensor of either grade that moves all the time: by default 1 to 10 min at 50 to 200 Hz."""
    rng = np.random.default_rng(seed)
    drawn = float(rng.choice([50.0, 100.0, 200.0])), rng.uniform(1, 10)
    rate, minutes = drawn[0] if rate is None else rate, drawn[1] if minutes is None else minutes
    n = round(60 * minutes * rate)
    rates, force = mounted(rng, *kinematics(*(KINDS | SMALL_KINDS)[kind](rng, n, rate), rate), 10 * DEGREE)
    drawn_grade = str(rng.choice(list(GRADES)))
    return sensed(rng, rates, force, rate, grade or drawn_grade, sensors=sensors)


def held(seed: int, *, rate: float = 100.0, seconds: float = 60.0, sensors: str = "both") -> st.Record:
    """A phone in a still hand: a tremor of 8 to 12 Hz plus a wander of 7 to 16 deg/√h, on all axes."""
    rng = np.random.default_rng(seed)
    n = round(seconds * rate)
    density = rng.uniform(7, 16, size=(3, 1)) * DEGREE / 60  # two-sided [rad/s/√Hz]
    top = min(15.0, 0.45 * rate)
    wander = density * np.sqrt(2 * top) * np.stack([band(rng, n, rate, 0.3, top) for _ in "xyz"])
    tremor = rng.uniform(1.5, 4) * density * np.sqrt(2 * 4.0) * np.stack([band(rng, n, rate, 8, 12) for _ in "xyz"])
    tilt = np.cumsum(wander, axis=1) / rate
    tilt -= np.linspace(0, 1, n) * tilt[:, -1:]  # the hand returns
    shaken = np.stack([rng.uniform(0.02, 0.1) * band(rng, n, rate, 8, 12) for _ in "xyz"])
    force = np.stack([-GRAVITY * tilt[1], GRAVITY * tilt[0], np.full(n, GRAVITY)]) + shaken
    return sensed(rng, wander + tremor, force, rate, "MEMS", sensors=sensors)


def handled(
    seed: int, grade: str, *, minutes: float = 30.0, lasting: float = 10.0
) -> tuple[st.Record, tuple[float, float]]:
    """A record at 50 Hz of a sensor at rest that is picked up for a few seconds and put down again, and the times of
    this. [s] In half of the cases its position changes: tilted by a few tenths of a degree, with another heading.

    Gyros measure the rotation of the Earth.
    """
    rng = np.random.default_rng(seed)
    rate = 50.0
    n = round(60 * minutes * rate)
    t = np.arange(n) / rate
    start = rng.uniform(0.1, 0.9) * t[-1]
    inside = slice(round(start * rate), round((start + lasting) * rate))
    window = np.zeros(n)
    u = np.linspace(0, 1, inside.stop - inside.start)
    window[inside] = np.clip(np.minimum(u, 1 - u) / 0.15, 0, 1) ** 2
    size = 10 ** rng.uniform(0.5, 1.5) * DEGREE
    angles = np.stack([window * size * band(rng, n, rate, 0, 0.7) for _ in "xyz"])
    if rng.random() < 0.5:
        put = np.clip((t - start) / lasting, 0, 1)
        angles += (rng.standard_normal((3, 1)) * np.array([[0.3], [0.3], [20.0]])) * DEGREE * (3 * put**2 - 2 * put**3)
    moved = np.stack([window * 0.5 * band(rng, n, rate, 0.2, 3) for _ in "xyz"])
    rates, force = kinematics(angles, moved, rate)
    heading = angles[2]
    earth = EARTH * np.stack(
        [np.cos(LATITUDE) * np.cos(heading), -np.cos(LATITUDE) * np.sin(heading), np.full(n, np.sin(LATITUDE))]
    )
    rates, force = mounted(rng, rates + earth, force, 3 * DEGREE)
    return sensed(rng, rates, force, rate, grade), (start, start + lasting)
