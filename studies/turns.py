"""Simulated rows of alternating sensors, and of single sensors that resemble them.

Samples are in units of the standard deviation of the white noise. Every axis has white noise, a bias and a slow wander:
three Gauss–Markov processes, which form a flicker floor, and a random walk.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

Floats = NDArray[np.float64]
Generator = np.random.Generator

STAMPS = ("even", "pairs", "equal pairs", "none")
_FLOOR = 0.664  # floor of the flicker noise, over the bias instability


def wander(rng: Generator, n: int, corner: float) -> Floats:
    """Slow noise whose Allan deviation equals that of unit white noise at `corner`. [samples]"""
    size = _FLOOR / math.sqrt(corner)
    x = np.cumsum(rng.standard_normal(n)) * size / math.sqrt(corner * rng.uniform(10, 1000))
    for time in corner * np.array([0.3, 3.0, 30.0]):
        a = math.exp(-1 / time)
        x += lfilter([size * math.sqrt(1 - a * a)], [1, -a], rng.standard_normal(n))
    return np.asarray(x)


def sensor(rng: Generator, n: int, rate: float, axes: int, *, bias: float = 1.0) -> Floats:
    """Samples of one sensor at rest, shape (n, axes): biases of 3 to 60 times the noise, and a floor that begins at 3 to
    300 s.
    """
    corner = rate * 10 ** rng.uniform(0.5, 2.5)
    spread = 10 ** rng.uniform(0.5, 1.8)
    offsets = bias * spread * rng.standard_normal(axes)
    return rng.standard_normal((n, axes)) + offsets + np.stack([wander(rng, n, corner) for _ in range(axes)], axis=1)


def _in_turn(sensors: list[Floats]) -> Floats:
    return np.stack(sensors, axis=1).reshape(-1, sensors[0].shape[1])


def _same_model(rng: Generator, n: int, rate: float, axes: int, count: int = 2, bias: float = 1.0) -> Floats:
    """Units of one model: equal noise and equal spread of biases."""
    corner, spread = rate * 10 ** rng.uniform(0.5, 2.5), 10 ** rng.uniform(0.5, 1.8)
    units = [
        rng.uniform(0.95, 1.05)
        * (
            rng.standard_normal((n // count, axes))
            + np.stack([wander(rng, n // count, corner / count) for _ in range(axes)], axis=1)
        )
        + bias * spread * rng.standard_normal(axes)
        for _ in range(count)
    ]
    return _in_turn(units)


def _two_models(rng: Generator, n: int, rate: float, axes: int, bias: float = 1.0) -> Floats:
    first = sensor(rng, n // 2, rate / 2, axes, bias=bias)
    second = rng.uniform(1.5, 5) * sensor(rng, n // 2, rate / 2, axes, bias=bias)
    if rng.random() < 0.5:  # the coarser unit is also rounded
        step = rng.uniform(0.5, 3)
        second = step * np.round(second / step)
    return _in_turn([first, second])


def _two_rates(rng: Generator, n: int, rate: float, axes: int) -> Floats:
    each = int(rng.integers(2, 4))
    count = n // (each + 1)
    fast = sensor(rng, count * each, rate, axes).reshape(count, each, axes)
    slow = sensor(rng, count, rate / each, axes).reshape(count, 1, axes)
    return np.concatenate((fast, slow), axis=1).reshape(-1, axes)


def _filtered(x: Floats, rng: Generator) -> Floats:
    """The samples after a low-pass filter of first order."""
    a = rng.uniform(0.2, 0.8)
    return np.asarray(lfilter([1 - a], [1, -a], x - x[0], axis=0) + x[0])


SEVERAL: dict[str, Callable[[Generator, int, float, int], Floats]] = {
    "two units of a model": _same_model,
    "three units of a model": lambda rng, n, rate, axes: _same_model(rng, n, rate, axes, 3),
    "two filtered units": lambda rng, n, rate, axes: _in_turn(
        [_filtered(sensor(rng, n // 2, rate / 2, axes), rng) for _ in range(2)]
    ),
    "two models": _two_models,
    "two rates, 2:1 or 3:1": _two_rates,
    "two units of equal bias": lambda rng, n, rate, axes: _same_model(rng, n, rate, axes, bias=0.0),
    "two models of equal bias": lambda rng, n, rate, axes: _two_models(rng, n, rate, axes, 0.0),
}
"""Alternating sensors: functions of a generator, the number of rows, their rate [Hz] and the number of axes, for samples
of shape (n, axes).
"""


def _line(rng: Generator, n: int, rate: float, axes: int, offset: float, *, equal: bool, drift: float = 0.0) -> Floats:
    """A line at half the rate plus `offset` (over the rate), 1 to 30 times the noise, on several axes."""
    size = 10 ** rng.uniform(0, 1.5) * (np.ones(axes) if equal else rng.uniform(0.1, 1, axes))
    wave = np.cos(2 * np.pi * (0.5 + offset) * np.arange(n) + rng.uniform(0, 1))
    amplitude = 1 + drift * wander(rng, n, rate * 10) * math.sqrt(rate * 10)
    return sensor(rng, n, rate, axes) + np.outer(amplitude * wave, size)


def _resonant(rng: Generator, n: int, rate: float, axes: int) -> Floats:
    radius, angle = 1 - 10 ** rng.uniform(-3, -1), np.pi * rng.uniform(0.8, 1)
    shaken = lfilter(
        [1 - radius], [1, -2 * radius * math.cos(angle), radius**2], rng.standard_normal((n, axes)), axis=0
    )
    return np.asarray(sensor(rng, n, rate, axes) + 10 ** rng.uniform(0, 1.5) * shaken / shaken.std(axis=0))


def _dithered(rng: Generator, n: int, rate: float, axes: int) -> Floats:
    """Counts of a converter that alternately adds and subtracts a quarter of its step."""
    steps = 10 ** rng.uniform(-1, 0)
    return np.asarray(np.round(sensor(rng, n, rate, axes) * steps + 0.25 * (-1.0) ** np.arange(n)[:, None]) / steps)


def _held(x: Floats, n: int) -> Floats:
    return np.repeat(x, 2, axis=0)[:n]


def _slow_accelerometer(rng: Generator, n: int, rate: float, axes: int) -> Floats:
    first, second = sensor(rng, n, rate, axes), _held(sensor(rng, n // 2 + 1, rate / 2, axes), n)
    return np.hstack((first[:, : (axes + 1) // 2], second[:, : axes // 2]))


SINGLE: dict[str, Callable[[Generator, int, float, int], Floats]] = {
    "clean": sensor,
    "filtered": lambda rng, n, rate, axes: _filtered(sensor(rng, n, rate, axes), rng),
    "rounded to whole numbers": lambda rng, n, rate, axes: np.round(
        sensor(rng, n, rate, axes) * 10 ** rng.uniform(-1, 0.5)
    ),
    "resonance close to half the rate": _resonant,
    "line within 1 % of half the rate": lambda rng, n, rate, axes: _line(
        rng, n, rate, axes, rng.uniform(-5e-3, 5e-3), equal=False
    ),
    "line at half the rate, of one size": lambda rng, n, rate, axes: _line(rng, n, rate, axes, 0, equal=True),
    "line at half the rate": lambda rng, n, rate, axes: _line(rng, n, rate, axes, 0, equal=False),
    "line at half the rate, of wandering size": lambda rng, n, rate, axes: _line(
        rng, n, rate, axes, 0, equal=False, drift=rng.uniform(0.02, 0.3)
    ),
    "dither of a converter": _dithered,
    "converter with two phases": lambda rng, n, rate, axes: (
        sensor(rng, n, rate, axes) + np.outer((-1.0) ** np.arange(n), rng.uniform(-1, 1, axes))
    ),
    "each sample twice": lambda rng, n, rate, axes: _held(sensor(rng, (n + 1) // 2, rate / 2, axes), n),
    "accelerometer of half the rate": _slow_accelerometer,
}
"""Single sensors, in the same form as `SEVERAL`."""


def stamps(rng: Generator, n: int, rate: float, kind: str, period: int = 2) -> Floats | None:
    """Stamps of rows: even, close to each other in groups of a period, equal in these groups, or none. [s]"""
    if kind == "none":
        return None
    k = np.arange(n)
    even = k / rate
    if kind != "even":
        even = (k // period) * period / rate
    jitter = np.repeat(rng.normal(0, 0.01 / rate, n // period + 1), period)[:n]
    return even + (k % period) * 0.02 / rate * (kind == "pairs") + jitter
