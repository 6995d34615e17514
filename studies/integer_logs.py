"""Simulated logs of integers: pulses of ring laser and fibre-optic gyros, increments of accelerometers, MEMS counts.

The step is 0.2 to 30 times the standard deviation of the noise in a sample, so that most samples of many logs are zero.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

import sigmatau as st
from studies import parked

Floats = NDArray[np.float64]

KINDS = (
    "pulses",
    "vibrated pulses",
    "split pulses",
    "split vibrated pulses",
    "printed increments",
    "increments with gravity",
    "rounded rates",
    "MEMS counts",
)
RATES = (10.0, 50.0, 100.0, 200.0, 400.0, 1000.0)
COUNT = 4.848e-7  # a tenth of an arcsecond [rad], or the same number of m/s
_FAULTS = 3  # stretches of a faulty log
STUCK, FILLED = 150, 60
"""Lengths of the stretches in `faulty`. [samples]"""


def _noise(rng: np.random.Generator, n: int, rate: float, *, vibrated: bool) -> Floats:
    """Unit noise with a slow walk; in some cases after a filter, with a line, or with vibration."""
    w = rng.standard_normal(n) + np.cumsum(rng.standard_normal(n)) * 10 ** rng.uniform(-5, -3)
    if rng.random() < 0.3:
        f = np.fft.rfftfreq(n)
        w = np.fft.irfft(np.fft.rfft(w) / np.sqrt(1 + (f / rng.uniform(0.05, 0.3)) ** 4), n)
    if rng.random() < 0.3:
        w = w + rng.uniform(0.1, 1) * np.sin(2 * np.pi * rng.uniform(0.5, 0.45 * rate) * np.arange(n) / rate)
    if vibrated:
        shaken = parked.KINDS[list(parked.KINDS)[int(rng.integers(4))]](rng, n, max(rate, 50.0))
        w = w + 10 ** rng.uniform(-0.5, 1.5) * shaken / shaken.std()
    return np.asarray(w)


def _split(rng: np.random.Generator, angle: Floats) -> Floats:
    """Increments of pulses of 2 to 16 counts, each divided between two samples according to its time."""
    pulse, fine = int(rng.integers(2, 17)), 16
    inside = np.floor(np.interp(np.arange(0, len(angle), 1 / fine), np.arange(len(angle)), angle))
    return np.diff(np.round(pulse * np.convolve(inside, np.ones(fine) / fine, "same")[::fine]))


def integer_log(seed: int, kind: str) -> tuple[Floats, float]:
    """Samples in counts, and their rate. [Hz]"""
    rng = np.random.default_rng(seed)
    rate, n = float(rng.choice(RATES)), int(rng.integers(3000, 60000))
    step = math.exp(rng.uniform(math.log(0.2), math.log(30)))
    w = _noise(rng, n, rate, vibrated="vibrated" in kind)
    if kind == "rounded rates":
        return np.round(w / step + rng.normal(0, 2)), rate
    if kind == "MEMS counts":
        walk = np.cumsum(rng.standard_normal(n)) * 0.1 * rng.random() / math.sqrt(n)
        return np.round((w + walk) / step + rng.normal(0, 30)), rate
    if kind == "increments with gravity":
        gravity = rng.choice([-1, 1]) * 10 ** rng.uniform(1.3, 4)
        mean = gravity + rng.normal(0, 5) * np.linspace(0, 1, n) ** rng.choice([1, 0.5])
    else:
        mean = np.full(n, rng.normal(0, 0.3) * rng.choice([0, 1]))
    angle = np.cumsum(w / step + mean) + rng.uniform()
    return _split(rng, angle) if kind.startswith("split") else np.diff(np.floor(angle)), rate


def faulty(seed: int, counts: Floats, fault: str) -> Floats:
    """The log with a fault: a range that ends at its 97 % quantile, or stretches that are stuck or on straight lines."""
    rng, x = np.random.default_rng(seed), counts.copy()
    if fault == "saturation":
        return np.minimum(x, math.floor(np.quantile(x, 0.97)))
    length = STUCK if fault == "stuck" else FILLED
    for start in rng.choice(len(x) - 2 * length, _FAULTS, replace=False):
        end = start + length
        x[start:end] = x[start] if fault == "stuck" else np.linspace(x[start], x[end], length)
    return x


def as_record(counts: Floats, rate: float, kind: str) -> st.Record:
    """The record of a log, as read by a user."""
    name = "accel" if "gravity" in kind else "gyro"
    rates = kind in ("rounded rates", "MEMS counts")
    unit = {"accel": "m/s", "gyro": "rad/s" if rates else "rad"}[name]
    values = counts * COUNT
    if kind == "printed increments":
        values = np.array([float(f"{value:.9e}") for value in values])
    return st.Record.from_arrays(
        rate=rate, input="rate" if rates else "increments", unit={name: unit}, **{f"{name}_x": values}
    )
