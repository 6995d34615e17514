"""Sensors whose noise does not have one of the five slopes: simulation of their records, and true values."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Source = np.random.Generator
Density = Callable[[Floats], Floats]

RATE, SAMPLES = 50.0, 180_000
TAU0 = 1 / RATE
N, B, K = 1e-4, 5e-5, 5e-6
"""Coefficients of the kinds, in SI, with the unit rad/s."""
STEP = 3 * N * math.sqrt(TAU0)
"""Step of an angle that is logged as increments. [rad]"""

_SIGMA = N / math.sqrt(TAU0)
_TIME = np.arange(SAMPLES) * TAU0
_CIRCLE = 8  # period of a synthesis, in lengths of the record


@dataclass(frozen=True)
class Kind:
    """A kind of sensor.

    Attributes
    ----------
    make : callable
        One axis.
    density : callable
        Two-sided density of the noise, up to half the rate. [(rad/s)²/Hz]
    terms : mapping
        True values by letter; 0 for an absent term.
    lines : tuple of (float, float)
        Amplitude and frequency of components that a model may state as lines. [rad/s, Hz]
    """

    make: Callable[[Source], Floats]
    density: Density
    terms: Mapping[str, float] = field(default_factory=dict)
    lines: tuple[tuple[float, float], ...] = ()

    def avar(self, m: Floats, *, lines: bool) -> Floats:
        """Allan variance of the noise, and of the lines if the model has some. (El-Sheimy et al. 2008, eq. 11)"""
        tau = m * TAU0
        f = np.concatenate([np.geomspace(1e-7, 1e-3, 20_000), np.linspace(1e-3, 0.5 * RATE, 120_000)[1:]])
        density = self.density(f)
        variance_of_noise = [
            4 * np.trapezoid(density * np.sin(np.pi * f * t) ** 4 / (t / TAU0 * np.sin(np.pi * f * TAU0)) ** 2, f)
            for t in tau
        ]
        variance_of_lines = sum(
            (a * np.sin(np.pi * f0 * tau) ** 2 / (np.pi * f0 * tau)) ** 2 for a, f0 in (self.lines if lines else ())
        )
        return np.asarray(np.array(variance_of_noise) + variance_of_lines)


def _white(rng: Source, samples: int = SAMPLES) -> Floats:
    return _SIGMA * rng.standard_normal(samples)


def _coloured(rng: Source, density: Density) -> Floats:
    count = _CIRCLE * SAMPLES
    f = np.asarray(np.fft.rfftfreq(count, TAU0))
    f[0] = f[1]
    sizes = np.sqrt(density(f) * count / TAU0 / 2)
    sizes[0] = 0.0
    waves = sizes * (rng.standard_normal(len(f)) + 1j * rng.standard_normal(len(f)))
    return np.asarray(np.fft.irfft(waves, count)[:SAMPLES])


def _flicker_density(f: Floats) -> Floats:
    return np.asarray(B * B * TAU0 / (2 * np.sin(np.pi * f * TAU0)))


def _flicker(rng: Source) -> Floats:
    return _coloured(rng, _flicker_density)


def _walk(rng: Source) -> Floats:
    return np.asarray(np.cumsum(rng.standard_normal(SAMPLES)) * K * math.sqrt(TAU0))


def _walk_density(f: Floats) -> Floats:
    return np.asarray((K * TAU0 / (2 * np.sin(np.pi * f * TAU0))) ** 2)


def _flat(f: Floats) -> Floats:
    return np.full_like(f, N * N)


def _sum(*densities: Density) -> Density:
    return lambda f: np.asarray(sum(density(f) for density in densities))


def _process_density(time: float, ratio: float) -> Density:
    """A Gauss-Markov process whose density at f = 0 is `ratio` times that of the white noise."""
    q = math.exp(-TAU0 / time)
    variance = ratio * N * N / (2 * time)
    return lambda f: np.asarray(variance * TAU0 * (1 - q * q) / (1 - 2 * q * np.cos(2 * np.pi * f * TAU0) + q * q))


def _process(rng: Source, time: float, ratio: float) -> Floats:
    from scipy.signal import lfilter

    q, sigma = math.exp(-TAU0 / time), N * math.sqrt(ratio / (2 * time))
    steps = rng.standard_normal(SAMPLES) * sigma * math.sqrt(1 - q * q)
    steps[0] = sigma * rng.standard_normal()
    return np.asarray(lfilter([1], [1, -q], steps))


def _telegraph(rng: Source, time: float, ratio: float, high: float = 0.5) -> Floats:
    """Telegraph signal; `high`: share of the time on the upper level. Its density is that of a Gauss-Markov process."""
    sigma = N * math.sqrt(ratio / (2 * time))
    dwell = time / (1 - high), time / high  # 1/T is the sum of both rates
    count = int(3 * SAMPLES * TAU0 / min(dwell)) + 50
    first = int(rng.random() > high)
    durations = rng.exponential([dwell[(first + k) % 2] for k in range(count)])
    state = (first + np.searchsorted(np.cumsum(durations), _TIME)) % 2
    return np.asarray(np.where(state == 0, 1 - high, -high) * sigma / math.sqrt(high * (1 - high)))


def _power_law(exponent: float) -> Density:
    """Noise with a density f^−α, equal to that of B at 0.01 Hz."""
    return lambda f: np.asarray(B * B / (0.02 * np.pi) * (f / 0.01) ** -exponent)


def _filter(taps: Floats, poles: tuple[float, ...] = ()) -> tuple[Callable[[Source], Floats], Density]:
    """White noise after a filter of the samples, with a gain of 1 at f = 0; and its density."""
    from scipy.signal import freqz, lfilter

    below = np.poly(poles) if poles else np.array([1.0])
    above = np.asarray(taps) * below.sum() / np.sum(taps)
    settled = 4000

    def make(rng: Source) -> Floats:
        return np.asarray(lfilter(above, below, _white(rng, SAMPLES + settled))[settled:])

    def density(f: Floats) -> Floats:
        return np.asarray(N * N * np.abs(freqz(above, below, f, fs=RATE)[1]) ** 2)

    return make, density


def _filtered(taps: Floats, poles: tuple[float, ...] = (), *, flicker: bool = True) -> Kind:
    make, density = _filter(taps, poles)
    if not flicker:
        return Kind(make, density, {"N": N})
    return Kind(lambda rng: make(rng) + _flicker(rng), _sum(density, _flicker_density), {"N": N, "B": B})


def _nothing(rng: Source) -> Floats:
    return np.zeros(SAMPLES)


def _white_with(extra: Callable[[Source], Floats], density: Density | None = None, **terms: float) -> Kind:
    """White noise, the given terms B and K, and a further noise with its density."""
    parts = {"B": (_flicker, _flicker_density), "K": (_walk, _walk_density)}
    used = [parts[letter] for letter in terms if letter in parts]

    def make(rng: Source) -> Floats:
        return np.asarray(_white(rng) + sum((part(rng) for part, _ in used), np.zeros(SAMPLES)) + extra(rng))

    densities = [_flat, *(shape for _, shape in used), *([] if density is None else [density])]
    return Kind(make, _sum(*densities), {"N": N, **terms})


def _sine(rng: Source, amplitude: float, period: float) -> Floats:
    return np.asarray(amplitude * np.sin(2 * np.pi * _TIME / period + rng.uniform(0, 2 * np.pi)))


def _square(rng: Source, amplitude: float, period: float) -> Floats:
    """An air conditioner: on and off, rounded by a time constant of a tenth of the period."""
    from scipy.signal import lfilter

    q = math.exp(-TAU0 / (0.1 * period))
    phase = _TIME / period + rng.random() + 2
    waves = np.where(np.concatenate([phase[: round(2 * period * RATE)] - 2, phase]) % 1 < 0.4, 1.0, -1.0)
    return np.asarray(amplitude * lfilter([1 - q], [1, -q], waves)[-SAMPLES:])


def _lines_of_square(amplitude: float, period: float) -> tuple[tuple[float, float], ...]:
    """The first five harmonics, after the time constant."""
    order = np.arange(1, 6)
    sizes = 4 * amplitude / (np.pi * order) * np.abs(np.sin(0.4 * np.pi * order))
    sizes /= np.sqrt(1 + (0.2 * np.pi * order) ** 2)
    return tuple((float(size), float(k / period)) for k, size in zip(order, sizes, strict=True))


def _warm_up(rng: Source, amplitude: float, time: float) -> Floats:
    return np.asarray(rng.choice([-1, 1]) * amplitude * np.exp(-_TIME / time))


def _drifting_level() -> Kind:
    level = 1 + 0.15 * (2 * _TIME / _TIME[-1] - 1)
    mean = float(np.sqrt(np.mean(level**2)))
    return Kind(
        lambda rng: _white(rng) * level + _flicker(rng),
        _sum(lambda f: np.full_like(f, (mean * N) ** 2), _flicker_density),
        {"N": mean * N, "B": B},
    )


def _heavy(degrees: float) -> Kind:
    scale = math.sqrt((degrees - 2) / degrees)
    return Kind(
        lambda rng: _SIGMA * scale * rng.standard_t(degrees, SAMPLES) + _flicker(rng),
        _sum(_flat, _flicker_density),
        {"N": N, "B": B},
    )


def _counts() -> Kind:
    def make(rng: Source) -> Floats:
        angle = np.concatenate([[0.0], np.cumsum(_white(rng) + _flicker(rng))]) * TAU0 + STEP * rng.random()
        return np.asarray(np.diff(np.round(angle / STEP)) * STEP / TAU0)

    q = STEP / math.sqrt(12)
    density: Density = lambda f: np.asarray(4 * q * q * np.sin(np.pi * f * TAU0) ** 2 / TAU0)  # noqa: E731
    return Kind(make, _sum(_flat, _flicker_density, density), {"N": N, "B": B, "Q": q})


_MEAN_OF_8 = np.ones(8) / 8

KINDS: dict[str, Kind] = {
    "N": _white_with(_nothing),
    "N + B": _white_with(_nothing, B=B),
    "N + K": _white_with(_nothing, K=K),
    "N + B + K": _white_with(_nothing, B=B, K=K),
    "process of 3 s, 3 N²": _white_with(lambda rng: _process(rng, 3, 3), _process_density(3, 3)),
    "process of 20 s, 2 N²": _white_with(lambda rng: _process(rng, 20, 2), _process_density(20, 2)),
    "process of 60 s, 10 N²": _white_with(lambda rng: _process(rng, 60, 10), _process_density(60, 10)),
    "processes of 2 s and 80 s": _white_with(
        lambda rng: _process(rng, 2, 5) + _process(rng, 80, 60), _sum(_process_density(2, 5), _process_density(80, 60))
    ),
    "telegraph noise of 15 s, upper level for 20 %": _white_with(
        lambda rng: _telegraph(rng, 15, 4, 0.2), _process_density(15, 4)
    ),
    "K, telegraph noise of 30 s": _white_with(lambda rng: _telegraph(rng, 30, 8), _process_density(30, 8), K=K),
    "f^-0.9": _white_with(lambda rng: _coloured(rng, _power_law(0.9)), _power_law(0.9)),
    "f^-1.3": _white_with(lambda rng: _coloured(rng, _power_law(1.3)), _power_law(1.3)),
    "B, smoothing with a = 0.1": _filtered(np.array([1.0]), (0.9,)),
    "smoothing with a = 0.04": _filtered(np.array([1.0]), (0.96,), flicker=False),
    "B, running mean of 40": _filtered(np.ones(40)),
    "B, two running means of 8": _filtered(np.convolve(_MEAN_OF_8, _MEAN_OF_8)),
    "line of 220 s": Kind(lambda rng: _white(rng) + _sine(rng, 2.5e-5, 220), _flat, {"N": N}, ((2.5e-5, 1 / 220),)),
    "B, line of 90 s": Kind(
        lambda rng: _white(rng) + _flicker(rng) + _sine(rng, 4e-5, 90),
        _sum(_flat, _flicker_density),
        {"N": N, "B": B},
        ((4e-5, 1 / 90),),
    ),
    "B, air conditioner of 400 s": Kind(
        lambda rng: _white(rng) + _flicker(rng) + _square(rng, 4e-5, 400),
        _sum(_flat, _flicker_density),
        {"N": N, "B": B},
        _lines_of_square(4e-5, 400),
    ),
    "B, warm-up of 600 s": _white_with(lambda rng: _warm_up(rng, 2e-4, 600), B=B),
    "B, level of N from 0.85 to 1.15": _drifting_level(),
    "B, Student's t with 3.5 degrees of freedom": _heavy(3.5),
    "B, increments of an angle in counts": _counts(),
}
