"""Simulated gyros at rest in a parked vehicle or a building with ventilation, and quiet ones on a bench.

Rates and integer increments of grades from ring laser to consumer MEMS. The angle of the disturbances does not depend on
the grade: dozens of lines of a ring laser gyro may be invisible with a MEMS gyro.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

import sigmatau as st
from sigmatau.units import to_si
from studies.motions import band

Floats = NDArray[np.float64]
Generator = np.random.Generator

ARCSECOND = math.pi / 180 / 3600


@dataclass(frozen=True, kw_only=True)
class Grade:
    """A grade of gyros: coefficients in the units of the field, and the step of the increments if it counts pulses."""

    random_walk: float  # [deg/√h]
    bias_instability: float  # [deg/h]
    step: float | None = None  # [arcsec]


GRADES = {
    "ring laser": Grade(random_walk=0.002, bias_instability=0.003, step=0.1),
    "coarse ring laser": Grade(random_walk=0.003, bias_instability=0.005, step=0.8),
    "fibre-optic": Grade(random_walk=0.02, bias_instability=0.05, step=0.05),
    "tactical": Grade(random_walk=0.1, bias_instability=0.5),
    "MEMS": Grade(random_walk=0.3, bias_instability=5.0),
}
RATES = (50.0, 100.0, 200.0)


def truth_of(grade: Grade) -> float:
    """The random walk of a grade. [rad/√s]"""
    return to_si(grade.random_walk, "deg/sqrt(h)")


def _modes(rng: Generator, n: int, rate: float, excited: Floats, low: float, high: float) -> Floats:
    """Narrow-band resonances of a structure, excited by noise of a changing size."""
    total = np.zeros(n)
    for _ in range(int(rng.integers(2, 6))):
        f = math.exp(rng.uniform(math.log(low), math.log(min(high, 0.45 * rate))))
        radius = math.exp(-math.pi * f * rng.uniform(0.01, 0.06) / rate)
        ringing = lfilter(
            [1.0], [1, -2 * radius * math.cos(2 * math.pi * f / rate), radius**2], excited * rng.standard_normal(n)
        )
        total += rng.uniform(0.2, 1.0) * ringing / ringing.std()
    return total


def _people(rng: Generator, n: int, rate: float) -> Floats:
    """People who move intermittently: bursts of a few seconds that excite resonances of 1 to 40 Hz."""
    envelope = np.exp(rng.uniform(0.5, 1.5) * band(rng, n, rate, 0, 1 / rng.uniform(2, 20)))
    return _modes(rng, n, rate, envelope, 1.0, 40.0)


def _engine(rng: Generator, n: int, rate: float) -> Floats:
    """Half orders of an idle engine of 600 to 900 rpm that varies by one per cent, with the resonances of the body."""
    speed = rng.uniform(10, 15) * (1 + rng.uniform(0.002, 0.015) * band(rng, n, rate, 0, 1 / rng.uniform(5, 30)))
    turned = 2 * np.pi * np.cumsum(speed) / rate
    total = 0.5 * _people(rng, n, rate)
    for half in range(1, 9):
        if half / 2 * 15 < 0.45 * rate:
            size = rng.uniform(0.05, 1.0) * (1 + 0.3 * band(rng, n, rate, 0, 0.2))
            total += size * np.sin(half / 2 * turned + rng.uniform(0, 6))
    return total


def _knocks(rng: Generator, n: int, rate: float) -> Floats:
    """Doors and footsteps near the vehicle: ringing that decays within seconds."""
    hits = np.zeros(n)
    places = rng.choice(n, int(rng.integers(4, 40)), replace=False)
    hits[places] = rng.standard_normal(len(places)) * 30
    return _modes(rng, n, rate, hits + 0.1, 2.0, 30.0)


def _ventilation(rng: Generator, n: int, rate: float) -> Floats:
    """A fan and its harmonics, steady to a thousandth, with the resonances of a building that it excites."""
    fan = rng.uniform(8, 30) * (1 + rng.uniform(1e-4, 1e-3) * band(rng, n, rate, 0, 0.05))
    turned = 2 * np.pi * np.cumsum(fan) / rate
    total = 0.5 * _modes(rng, n, rate, np.ones(n), 3.0, 12.0)
    for order in (1, 2, 3):
        if order * 31 < 0.45 * rate:
            total += rng.uniform(0.2, 1.0) * np.sin(order * turned + rng.uniform(0, 6))
    return total


KINDS = {"people": _people, "engine": _engine, "knocks": _knocks, "ventilation": _ventilation}


def quiet(rng: Generator, grade: Grade, duration: float, rate: float) -> Floats:
    """Rates of the sensor alone, with up to seven weak lines, and a filter before the sampler in a third of the cases."""
    n = round(duration * rate)
    terms = {
        "random_walk": f"{grade.random_walk} deg/sqrt(h)",
        "bias_instability": f"{grade.bias_instability} deg/h",
    }
    model = st.NoiseModel.from_dict({"channels": {"gyro_x": terms}})
    record = st.simulate(model, duration=n / rate, rate=rate, rng=rng)
    x: Floats = np.array(record.stream_of("gyro_x").column("gyro_x"), dtype=float)
    if rng.random() < 1 / 3:
        f = np.fft.rfftfreq(n, 1 / rate)
        x = np.asarray(np.fft.irfft(np.fft.rfft(x) / np.sqrt(1 + (f / (rng.uniform(0.1, 0.4) * rate)) ** 4), n))
    t = np.arange(n) / rate
    sigma = truth_of(grade) * math.sqrt(rate)
    for _ in range(int(rng.integers(0, 8))):
        line = 10 ** rng.uniform(-1, math.log10(0.45 * rate))
        x = x + sigma * rng.uniform(0.02, 0.3) * np.sin(2 * np.pi * line * t + rng.uniform(0, 6))
    return np.asarray(x)


def logged(rng: Generator, rates: Floats, grade: Grade, rate: float) -> st.Record:
    """The record of a log: rates, or integer pulses of the angle if the gyro counts them."""
    bias = rng.normal(0, 10 * to_si(grade.bias_instability, "deg/h"))
    if grade.step is None:
        return st.Record.from_arrays(rate=rate, gyro_x=rates + bias)
    step = grade.step * ARCSECOND
    angle = np.cumsum(rates + bias) / rate / step + rng.uniform()
    counts = np.diff(np.floor(angle), prepend=math.floor(angle[0]))
    return st.Record.from_arrays(rate=rate, input="increments", unit={"gyro": "rad"}, gyro_x=counts * step)


def bench(seed: int, name: str, *, duration: tuple[float, float] = (60.0, 1800.0)) -> st.Record:
    """A quiet sensor on a bench."""
    rng = np.random.default_rng(seed)
    rate = float(rng.choice(RATES))
    span = math.exp(rng.uniform(math.log(duration[0]), math.log(duration[1])))
    return logged(rng, quiet(rng, GRADES[name], span, rate), GRADES[name], rate)


def parked(seed: int, name: str, kind: str, *, duration: tuple[float, float] = (60.0, 900.0)) -> st.Record:
    """A sensor that is disturbed by motion of 2 µrad/s to 2 mrad/s."""
    rng = np.random.default_rng(seed)
    rate = float(rng.choice(RATES))
    span = math.exp(rng.uniform(math.log(duration[0]), math.log(duration[1])))
    x = quiet(rng, GRADES[name], span, rate)
    shaken = np.gradient(KINDS[kind](rng, len(x), rate))  # a bounded angle: its rate has no white noise
    return logged(rng, x + 10 ** rng.uniform(-5.7, -2.7) * shaken / shaken.std(), GRADES[name], rate)
