"""`sigmatau.bandwidth` on simulated sensors: filters of four kinds, 2 to 6 logs at 10 Hz to 2 kHz, and single logs.

The logs are made in the time domain at a high rate, 64 times the bandwidth and 16 times the rate of the log or more: white
noise through the differential equation of the filter, or through its taps, then every k-th sample. Nothing of the fitted
spectra is used.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

import sigmatau as st

Floats = NDArray[np.float64]

SENSORS = 1000
PART = 50
"""Sensors of a cell."""

SINGLE = 200
"""Single logs that are too slow, and single fast ones."""

KINDS = ("one pole", "Butterworth", "two poles", "running mean", "FIR")
RATES = (10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0)
SAMPLES = (3000, 9000)
OVER_BANDWIDTH, OVER_RATE = 64.0, 16.0
STEPS = (1e-3, 1.0)
"""Of the values, over the standard deviation of their differences."""

LEVEL = 0.95
DENSITY = 1e-4
"""N of all sensors. [rad/√s]"""


class Sensor:
    """A filter with random numbers, as a difference equation at any high rate."""

    def __init__(self, kind: str, rng: np.random.Generator, *, lowest: float, highest: float) -> None:
        self.kind = kind
        self.corner = float(np.exp(rng.uniform(math.log(lowest), math.log(highest))))
        self.damping = math.sqrt(0.5) if kind == "Butterworth" else float(rng.uniform(0.45, 1.3))
        self.sharpness = float(rng.uniform(0.7, 3.0))
        self.slow_passes = bool(rng.integers(2))

    def taps(self, rate: float) -> tuple[Floats, Floats]:
        """Numerator and denominator at a high rate."""
        from scipy.signal import cont2discrete

        w = 2 * math.pi * self.corner
        if self.kind == "one pole":
            p = math.exp(-w / rate)
            return np.array([0.0, 1 - p]), np.array([1.0, -p])
        if self.kind in ("Butterworth", "two poles"):
            system = (np.array([w * w]), np.array([1.0, 2 * self.damping * w, w * w]))
            num, den, _ = cont2discrete(system, 1 / rate, method="zoh")
            return np.asarray(num).ravel(), np.asarray(den).ravel()
        if self.kind == "running mean":
            length = 0.4429 * rate / self.corner  # the ends have a part of the weight
            whole = math.floor(length / 2 - 0.5)
            end = 0.5 * (length - 2 * whole - 1)
            taps = np.concatenate(([end], np.ones(2 * whole + 1), [end]))
        else:
            duration = self.sharpness / self.corner
            half = math.floor(duration * rate / 2)
            t = np.arange(-half, half + 1) / rate
            taps = (0.54 + 0.46 * np.cos(2 * np.pi * t / duration)) * np.sinc(2 * self.corner * t)
        return taps / taps.sum(), np.ones(1)

    def samples(self, rate: float, n: int, rng: np.random.Generator) -> Floats:
        """White noise behind the filter, sampled without an anti-alias filter, with slow noise and rounding; shape (n,)."""
        from scipy.signal import lfilter, oaconvolve

        over = math.ceil(max(OVER_RATE, OVER_BANDWIDTH * self.corner / rate))
        fast = rate * over
        num, den = self.taps(fast)
        settle = max(len(num), round(8 * fast / self.corner)) if len(den) > 1 else len(num)
        white = DENSITY * math.sqrt(fast) * rng.standard_normal(n * over + settle)
        y = lfilter(num, den, white) if len(den) > 1 else oaconvolve(white, num, mode="valid")
        return _rounded(y[-n * over :: over] + self._slow(rate, n, rng), rng)

    def _slow(self, rate: float, n: int, rng: np.random.Generator) -> Floats:
        """Flicker and a random walk that cross the white noise far below the bandwidth and half the rate."""
        from scipy.signal import freqz

        long = 2 * n  # of which half is used, so that its ends do not meet
        f = np.fft.rfftfreq(long, 1 / rate)
        crossing = np.exp(rng.uniform(math.log(1e-3), math.log(0.03), 2)) * min(rate / 2, self.corner)
        density = np.zeros(len(f))
        density[1:] = DENSITY**2 * (crossing[0] / f[1:] + (crossing[1] / f[1:]) ** 2)
        if self.slow_passes:
            fast = OVER_BANDWIDTH * max(self.corner, rate)
            density *= np.abs(freqz(*self.taps(fast), worN=2 * math.pi * f / fast)[1]) ** 2
        parts = rng.standard_normal(len(f)) + 1j * rng.standard_normal(len(f))
        return np.asarray(np.fft.irfft(np.sqrt(density * rate * long / 2) * parts, long)[:n])

    def truth(self) -> float:
        """Frequency of −3 dB, from the difference equation at a very high rate. [Hz]"""
        from scipy.optimize import brentq
        from scipy.signal import freqz

        if self.kind in ("one pole", "Butterworth"):
            return self.corner
        fast = 1024 * self.corner
        num, den = self.taps(fast)

        def excess(f: float) -> float:
            return float(abs(freqz(num, den, worN=[2 * math.pi * f / fast])[1][0]) ** 2 - 0.5)

        return float(brentq(excess, 0.1 * self.corner, 1.8 * self.corner))


def _rounded(y: Floats, rng: np.random.Generator) -> Floats:
    """The values in steps of up to the standard deviation of their differences: the error of coarser ones is not white."""
    step = float(np.diff(y).std()) * float(np.exp(rng.uniform(*np.log(STEPS))))
    return np.asarray(np.round(y / step) * step)


def logs_of(sensor: Sensor, rates: Floats, rng: np.random.Generator) -> dict[str, st.Record]:
    """Independent logs of a sensor."""
    records = {}
    for k, rate in enumerate(rates.tolist()):
        n = int(rng.integers(*SAMPLES))
        y = sensor.samples(rate, n, rng)
        records[f"log {k}, {rate:g} Hz"] = st.Record.from_arrays(rate=rate, gyro_x=y)
    return records


def sensors(seed: int, kind: str, count: int) -> list[dict[str, Any]]:
    """Results of some sensors of a kind, with 2 to 6 logs each."""
    rng = np.random.default_rng(seed)
    rows = []
    for _ in range(count):
        logs = int(rng.integers(2, 7))
        rates = np.sort(rng.choice(RATES, size=logs, replace=False))
        # From a bandwidth that the fastest log resolves to one that no log does.
        sensor = Sensor(kind, rng, lowest=0.03 * rates[-1], highest=0.6 * rates[-1])
        rows.append(judged(sensor, logs_of(sensor, rates, rng)) | {"logs": logs})
    return rows


def single_logs(seed: int, fast: bool, count: int) -> list[dict[str, Any]]:  # noqa: FBT001  as a cell calls it
    """Results of one log alone: at 3 to 20 times the bandwidth, or at a tenth to a third of it."""
    rng = np.random.default_rng(seed)
    rows = []
    for _ in range(count):
        rate = float(rng.choice(RATES))
        over = np.exp(rng.uniform(*np.log((4.0, 20.0) if fast else (0.1, 0.33))))
        sensor = Sensor(str(rng.choice(KINDS)), rng, lowest=rate / over, highest=rate / over)
        rows.append(judged(sensor, logs_of(sensor, np.array([rate]), rng)) | {"logs": 1})
    return rows


def judged(sensor: Sensor, records: Mapping[str, st.Record]) -> dict[str, Any]:
    """Whether the intervals contain the truth."""
    try:
        result = st.bandwidth(records, level=LEVEL)["gyro_x"]
    except st.DataError as error:
        return {"kind": sensor.kind, "verdict": "refused", "why": str(error)}
    truth = {"bandwidth": sensor.truth(), "random_walk": DENSITY}
    row: dict[str, Any] = {"kind": sensor.kind, "verdict": result.verdict, "shape": result.shape}
    row["shapes"] = [result.shape, *result.alternatives]
    for name, value in truth.items():
        interval = getattr(result, name)
        low, high = interval.low or 0.0, math.inf if interval.high is None else interval.high
        row[name] = {
            "inside": low <= value <= high,
            "below": value < low,
            "half": None if math.isinf(high) or low == 0 else 0.5 * math.log(high / low),
            "error": math.log(interval.value / value),
        }
    return row
