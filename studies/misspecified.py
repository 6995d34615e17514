"""Records with known coefficients that no model of the likelihood describes exactly."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from studies.samples import simulated

__all__ = ["CASES", "TAU0", "TRUTH", "Case", "N", "record"]

Floats = NDArray[np.float64]
N, TAU0 = 2**18, 0.01
TRUTH = {"random_walk": 0.005, "bias_instability": 0.0028, "rate_random_walk": 4e-4}

_DURATION = N * TAU0
_TIME = np.arange(N) * TAU0
_SIGMA = TRUTH["random_walk"] / math.sqrt(TAU0)
_SLOW = {name: value for name, value in TRUTH.items() if name != "random_walk"}
_SETTLING = 1800  # steps of 1 s before a slow modulation counts
_CORNER = 30.0  # corner of the analogue filter [Hz]
_STEP = 0.5  # step of a coarse log, over the standard deviation of white noise

Source = np.random.Generator


@dataclass(frozen=True)
class Case:
    """A truth: its record, the coefficients that are judged, and the true random walk over that of `TRUTH`."""

    make: Callable[[Source], Floats]
    judged: tuple[str, ...] = tuple(TRUTH)
    white: float = 1.0


def record(case: str, rng: Source) -> Floats:
    """The samples of one record."""
    return CASES[case].make(rng)


def _ideal(rng: Source, terms: dict[str, float] = TRUTH) -> Floats:
    return simulated(N, TAU0, terms, seed=int(rng.integers(1 << 62)))


def _white(rng: Source) -> Floats:
    return _SIGMA * rng.standard_normal(N)


def _slow(rng: Source, sd: float, time: float = 600.0) -> Floats:
    """A modulation with a correlation time, of exactly this standard deviation in the record."""
    from scipy.signal import lfilter

    steps = lfilter([1], [1, -math.exp(-1 / time)], rng.standard_normal(int(_DURATION) + 2 + _SETTLING))[_SETTLING:]
    return np.asarray(np.interp(_TIME, np.arange(len(steps)), steps / steps.std()) * sd)


def _telegraph(rng: Source, amplitude: float, time: float) -> Floats:
    """Two states of the same mean duration; `time`: correlation time."""
    jumps = np.sort(rng.uniform(0, _DURATION, rng.poisson(_DURATION / time * 0.5) + 2))
    return amplitude * np.where(np.searchsorted(jumps, _TIME) % 2, 1.0, -1.0)


def _coloured(rng: Source, density: Callable[[Floats], Floats]) -> Floats:
    """Noise with a density over that of white noise."""
    f = np.asarray(np.fft.rfftfreq(N, TAU0), dtype=np.float64)
    f[0] = f[1]
    return np.asarray(
        np.fft.irfft(np.fft.rfft(rng.standard_normal(N)) * np.sqrt(density(f) / TAU0), N), dtype=np.float64
    )


def _hump(rng: Source, frequency: float, power: float, shape: str = "bell") -> Floats:
    """A hump in the density, `power` times the other noise at its frequency."""
    usual = TRUTH["random_walk"] ** 2 + TRUTH["bias_instability"] ** 2 / (2 * math.pi * frequency)

    def bell(f: Floats, centre: float, width: float) -> Floats:
        return np.asarray(np.exp(-0.5 * (np.log(f / centre) / width) ** 2), dtype=np.float64)

    def density(f: Floats) -> Floats:
        if shape == "box":
            inside = ((f > frequency / 1.6) & (f < frequency * 1.6)).astype(float)
            return inside * usual * power
        if shape == "comb":
            teeth = (
                bell(f, frequency, 0.15) + 0.7 * bell(f, 2.7 * frequency, 0.1) + 0.5 * bell(f, frequency / 3.1, 0.12)
            )
            return np.asarray(teeth * usual * power)
        return bell(f, frequency, 0.35) * usual * power

    return _coloured(rng, density)


def _wandering(rng: Source, amplitude: float, frequency: float, spread: float, drift: float = 0.0) -> Floats:
    """A line whose frequency wanders and whose amplitude changes by 20 %."""
    place = frequency + spread * _slow(rng, 1.0, 100.0) + drift * (_TIME / _DURATION - 0.5)
    phase = 2 * np.pi * np.cumsum(place) * TAU0 + rng.uniform(0, 2 * np.pi)
    return np.asarray(amplitude * (1 + _slow(rng, 0.2, 200.0)) * np.sin(phase))


def _filtered(y: Floats, order: int, corner: float) -> Floats:
    """A digital Butterworth filter; `corner` over the sampling rate."""
    from scipy.signal import butter, lfilter

    return np.asarray(lfilter(*butter(order, 2 * corner), y))


def _smoothed(y: Floats, time: float) -> Floats:
    """Exponential smoothing with a time constant. [s]"""
    from scipy.signal import lfilter

    pole = math.exp(-TAU0 / time)
    return np.asarray(lfilter([1 - pole], [1, -pole], y))


def _folded(rng: Source) -> Floats:
    """White noise after an analogue filter of first order, sampled: an Ornstein-Uhlenbeck process."""
    from scipy.signal import lfilter

    variance = TRUTH["random_walk"] ** 2 * math.pi * _CORNER
    pole = math.exp(-2 * math.pi * _CORNER * TAU0)
    white = rng.standard_normal(N) * math.sqrt(variance * (1 - pole * pole))
    start = [pole * math.sqrt(variance) * rng.standard_normal()]
    return np.asarray(lfilter([1], [1, -pole], white, zi=start)[0]) + _ideal(rng, _SLOW)


def _modulated(rng: Source) -> Floats:
    level = np.exp(_slow(rng, 0.2))
    return np.asarray(_white(rng) * level / np.sqrt((level * level).mean())) + _ideal(rng, _SLOW)


def _rippled(rng: Source) -> Floats:
    """White noise with a ripple of 6 % in its density, which no part of a model describes."""
    phase = rng.uniform(0, 2 * np.pi)

    def density(f: Floats) -> Floats:
        ripple = 1 + 0.06 * np.sin(2 * np.pi * 1.3 * np.log10(f) + phase)
        return np.asarray(TRUTH["random_walk"] ** 2 * ripple)

    return _coloured(rng, density) + _ideal(rng, _SLOW)


def _heavy_tailed(rng: Source) -> Floats:
    return _SIGMA * math.sqrt(3 / 5) * rng.standard_t(5, N) + _ideal(rng, _SLOW)


def _everything(rng: Source) -> Floats:
    y = _filtered(_ideal(rng), 2, 0.2)
    return y + _wandering(rng, 0.01, 0.56, 0.01) + _hump(rng, 1 / 250, 1.0) + _telegraph(rng, 0.002, 10.0)


def _running_mean(rng: Source, length: int = 8) -> Floats:
    sums = np.cumsum(np.concatenate([np.zeros(1), _ideal(rng)]))
    start = np.maximum(np.arange(1, N + 1) - length, 0)
    return np.asarray((sums[1:] - sums[start]) / (np.arange(1, N + 1) - start))


def _harmonics(rng: Source) -> Floats:
    """Two vibrations with three harmonics each."""
    y: Floats = _ideal(rng)
    for frequency, amplitude in ((7.3, 0.02), (18.1, 0.01)):
        for k in (1, 2, 3, 4):
            y += amplitude / k * np.sin(2 * np.pi * k * frequency * _TIME + rng.uniform(0, 2 * np.pi))
    return y


def _temperature(rng: Source) -> Floats:
    """A sinusoidal drift, one and a half periods in the record."""
    drift: Floats = 0.004 * np.sin(2 * np.pi * 1.5 * _TIME / _DURATION + rng.uniform(0, 2 * np.pi))
    return _ideal(rng) + drift


def _steep(rng: Source) -> Floats:
    """White noise plus noise with a density proportional to 1/f^1.5, equal at 0.01 Hz."""
    return _white(rng) + _coloured(rng, lambda f: TRUTH["random_walk"] ** 2 * (0.01 / f) ** 1.5)


def _coarse(rng: Source) -> Floats:
    step = _STEP * _SIGMA
    return np.asarray(np.round(_ideal(rng) / step) * step)


def _cut_knock(rng: Source) -> Floats:
    """Two seconds replaced by a straight line, as after a knock was removed."""
    y = _ideal(rng)
    start = int(rng.integers(N // 8, N - N // 8))
    stop = start + 200
    ends = y[start - 50 : start].mean(), y[stop : stop + 50].mean()
    y[start:stop] = np.linspace(*ends, stop - start)
    return y


def _jumps(rng: Source) -> Floats:
    """Three steps of the bias."""
    y = _ideal(rng)
    for place in rng.integers(0, N, 3):
        y[place:] += 0.005 * rng.choice([-1.0, 1.0])
    return y


_FOLDING = math.sqrt(math.pi * _CORNER * TAU0 / math.tanh(math.pi * _CORNER * TAU0))
_ROUNDING = math.sqrt(1 + _STEP**2 / 12)

CASES: dict[str, Case] = {
    "ideal": Case(_ideal),
    "Butterworth filter, order 2, at 0.15 of the rate": Case(lambda r: _filtered(_ideal(r), 2, 0.15)),
    "Butterworth filter, order 4, at 0.1 of the rate": Case(lambda r: _filtered(_ideal(r), 4, 0.1)),
    "running mean of 8 samples": Case(_running_mean),
    "analogue filter of order 1 at 0.3 of the rate": Case(_folded, white=_FOLDING),
    "Butterworth filter, order 2, at 0.01 of the rate": Case(lambda r: _filtered(_ideal(r), 2, 0.01)),
    "running mean of 50 samples": Case(lambda r: _running_mean(r, 50)),
    "exponential smoothing, 0.3 s": Case(lambda r: _smoothed(_ideal(r), 0.3)),
    "line 2 mHz wide at 0.56 Hz": Case(lambda r: _ideal(r) + _wandering(r, 0.01, 0.56, 0.002)),
    "two lines that wander": Case(
        lambda r: _ideal(r) + _wandering(r, 0.01, 0.56, 0.03, 0.1) + 0.3 * _wandering(r, 0.01, 1.68, 0.09, 0.3)
    ),
    "two vibrations with harmonics": Case(_harmonics),
    "telegraph noise, 10 s": Case(lambda r: _ideal(r) + _telegraph(r, 0.004, 10.0)),
    "telegraph noise, 50 s": Case(lambda r: _ideal(r) + _telegraph(r, 0.003, 50.0)),
    "telegraph noise, 200 s": Case(lambda r: _ideal(r) + _telegraph(r, 0.003, 200.0)),
    "white level varies by 20 %": Case(_modulated),
    "hump at 100 s, 2.5 times the noise": Case(lambda r: _ideal(r) + _hump(r, 1 / 100, 2.5)),
    "hump at 100 s, 6 times": Case(lambda r: _ideal(r) + _hump(r, 1 / 100, 6.0)),
    "hump at 20 s, 0.6 times": Case(lambda r: _ideal(r) + _hump(r, 1 / 20, 0.6)),
    "hump at 20 s, twice": Case(lambda r: _ideal(r) + _hump(r, 1 / 20, 2.0)),
    "box at 20 s, 0.5 times": Case(lambda r: _ideal(r) + _hump(r, 1 / 20, 0.5, "box")),
    "three humps about 5 s, 0.3 times": Case(lambda r: _ideal(r) + _hump(r, 1 / 5, 0.3, "comb")),
    "three humps about 5 s, as large": Case(lambda r: _ideal(r) + _hump(r, 1 / 5, 1.0, "comb")),
    "ripple of 6 % in the white noise": Case(_rippled),
    "white noise with t5 tails": Case(_heavy_tailed),
    "filter, line, hump and telegraph noise": Case(_everything),
    "sinusoidal drift, 1.5 periods": Case(_temperature),
    "1/f^1.5 noise in place of B and K": Case(_steep, judged=("random_walk",)),
    "log with steps of half a standard deviation": Case(_coarse, white=_ROUNDING),
    "two seconds replaced by a line": Case(_cut_knock),
    "three steps of the bias": Case(_jumps),
}
