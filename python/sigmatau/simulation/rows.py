"""Rows of a simulated log, piece by piece: channels, time stamps and lost rows."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from sigmatau._native import generators
from sigmatau._native.distributions import normal_quantile
from sigmatau.arrays import Floats
from sigmatau.errors import OptionError
from sigmatau.frozen import frozen
from sigmatau.model.channel import ChannelModel
from sigmatau.model.noise_model import NoiseModel
from sigmatau.model.processes import check_sampling_rate, real
from sigmatau.model.unobserved import Unobserved, check_policy, include_in_all
from sigmatau.noise.terms import NOISE, TERMS
from sigmatau.record.record import MIN_SAMPLES, QUANTITIES, stream_name
from sigmatau.simulation.imperfections import Imperfections, rounded
from sigmatau.statespace.state_space import state_space
from sigmatau.units import integral

T = TypeVar("T")

_MAX_N = {"exact": 1 << 30, "poles": 1 << 40}  # largest number of samples
# random streams of the losses and the jitter, above the 32 bits of the channels' numbers
_LOSSES, _JITTER = 1 << 32, 2 << 32
_MAX_JITTER_SIGMAS = 4.5  # largest jitter in standard deviations


@frozen
class SimulationJob:
    """Checked arguments of a simulation."""

    model: NoiseModel
    n: int  # Samples
    rate: float  # [Hz]
    seed: int
    imperfections: Imperfections
    flicker: Flicker

    @property
    def tau0(self) -> float:
        """Sample interval. [s]"""
        return 1 / self.rate

    @property
    def first(self) -> int:
        """Number of rows before the first sample: 1 for the initial 0 of a running sum, else 0."""
        return int(self.imperfections.output == "accumulated")

    @property
    def rows(self) -> int:
        """Number of rows of the log, including lost ones."""
        return self.n + self.first

    def unit(self, channel: str) -> str:
        """SI unit of the values of a channel in the log."""
        unit = self.model.channels[channel].unit
        return unit if self.imperfections.output == "rate" else integral(unit)

    def times(self, start: int, stop: int) -> Floats:
        """Times of some rows. [s]"""
        return np.arange(start, stop) / self.rate


def job(
    model: NoiseModel,
    *,
    duration: float,
    rate: float,
    rng: int | np.random.Generator,
    imperfections: Imperfections | None,
    flicker: Flicker,
    unobserved: Unobserved,
) -> SimulationJob:
    """Check the arguments of `sigmatau.simulate`; raises `OptionError`."""
    if not isinstance(model, NoiseModel):
        raise OptionError(
            f"{{option}} must be a NoiseModel, NoiseModel(channels={{…}}), not {model!r:.80}", option="model"
        )
    model = include_in_all(model, check_policy(unobserved))
    if not (imperfections is None or isinstance(imperfections, Imperfections)):
        raise OptionError(
            f"{{option}} must be an Imperfections, Imperfections(lost=0.01), not {imperfections!r:.80}",
            option="imperfections",
        )
    check_sampling_rate(rate)
    if not (math.isfinite(real(duration)) and duration > 0):
        raise OptionError(f"the duration must be a positive number, not {duration!r} s", option="hours")
    if flicker not in _MAX_N:
        raise OptionError(f"{{option}} must be 'exact' or 'poles', not {flicker!r}", option="flicker")
    samples = float(duration) * float(rate)
    if samples > _MAX_N[flicker]:
        where = "in memory; write them to a file, with flicker noise by poles" if flicker == "exact" else "at once"
        raise OptionError(
            f"{duration:g} s at {rate:g} Hz are {samples:.10g} samples; at most {_MAX_N[flicker]} can be simulated {where}"
        )
    n = round(samples)
    if n < MIN_SAMPLES:
        raise OptionError(f"{duration:g} s at {rate:g} Hz are {n} samples; at least {MIN_SAMPLES} are needed")
    if isinstance(rng, np.random.Generator):
        seed = int(rng.integers(1 << 63))
    elif isinstance(rng, int | np.integer) and not isinstance(rng, bool) and 0 <= rng < 1 << 64:
        seed = int(rng)
    else:
        raise OptionError(f"the seed must be an integer from 0 to 2^64 - 1, not {rng!r}", option="seed")
    imperfect = imperfections or Imperfections()
    imperfect.check(model.channels, 1 / rate, duration)
    if imperfect.output != "rate":
        for name, channel in model.channels.items():
            if channel.unit not in QUANTITIES.values():
                raise OptionError(
                    f"{name} is a signal in {channel.unit}: its log holds rates, not {imperfect.output}; leave it out of the"
                    " model, NoiseModel.of, or simulate rates",
                    option="input",
                )
    return SimulationJob(model=model, n=n, rate=rate, seed=seed, imperfections=imperfect, flicker=flicker)


class Channel:
    """Values of one channel of the log."""

    def __init__(self, job: SimulationJob, name: str) -> None:
        imperfections = job.imperfections
        self._job = job
        self._noise = make_noise(job.model, name, n=job.n, tau0=job.tau0, seed=job.seed, flicker=job.flicker)
        self._level = _channel_value(imperfections.level, name, 0.0)
        self._warm_up = _channel_value(imperfections.warm_up, name, None)
        self._sensitivity = (
            0.0
            if imperfections.temperature is None
            else _channel_value(imperfections.temperature.sensitivity, name, 0.0)
        )
        self._saturation = _channel_value(imperfections.saturation, name, 0.0)
        self._lsb = _channel_value(imperfections.lsb, name, 0.0)
        # A sum of many terms keeps its digits in the longest float that the machine has.
        self._sum = np.longdouble(0)
        self._made = 0

    def next(self, n: int) -> Floats:
        """The rows of the next `n` samples; the first piece of accumulated output has one row more."""
        rate = np.empty(n)
        self._noise.fill(rate)
        start, self._made = self._made, self._made + n
        self._drift(rate, start)
        if self._saturation:
            np.clip(rate, -self._saturation, self._saturation, out=rate)
        output = self._job.imperfections.output
        if output == "rate":
            return rounded(rate, self._lsb)
        if output == "increments" and not self._lsb:
            return np.asarray(rate * self._job.tau0)
        sums = np.empty(n + 1, dtype=np.longdouble)
        sums[0] = self._sum
        np.multiply(rate, self._job.tau0, out=sums[1:])
        np.cumsum(sums, out=sums)
        self._sum = sums[-1]
        if output == "accumulated":
            return rounded(np.asarray(sums[int(start > 0) :], dtype=np.float64), self._lsb)
        # The differences are of whole steps, so that they lose no digits.
        steps = np.diff(np.rint(np.asarray(sums, dtype=np.float64) / self._lsb))
        return np.asarray(steps * self._lsb + 0.0)  # no -0

    def _drift(self, rate: Floats, start: int) -> None:
        """Add level, warm-up and the effect of temperature."""
        if self._level:
            rate += self._level
        if self._warm_up is None and not self._sensitivity:
            return
        t = self._job.times(start, start + len(rate))
        if self._warm_up is not None:
            rate += self._warm_up.at(t)
        temperature = self._job.imperfections.temperature
        if temperature is not None and self._sensitivity:
            rate += self._sensitivity * (temperature.at(t) - temperature.start)


class Stamps:
    """Time stamps of the rows, and which rows are lost."""

    def __init__(self, job: SimulationJob) -> None:
        imperfections = job.imperfections
        self._job = job
        self._losses = normal(job.rows, seed=job.seed, channel=_LOSSES) if imperfections.lost else None
        self._lost_below = float(normal_quantile(imperfections.lost))
        self._jitter = normal(job.rows, seed=job.seed, channel=_JITTER) if imperfections.jitter else None
        self._made = 0

    def next(self, n: int) -> tuple[Floats, NDArray[np.bool_] | None]:
        """Stamps of the next `n` rows, and a mask of the rows that are not lost; None if none is lost."""
        job, imperfections = self._job, self._job.imperfections
        start, self._made = self._made, self._made + n
        t = job.times(start, start + n)
        present: NDArray[np.bool_] | None = None
        if self._losses is not None or imperfections.outages:
            present = np.ones(n, dtype=bool)
            if self._losses is not None:
                drawn = np.empty(n)
                self._losses.fill(drawn)
                present = drawn >= self._lost_below
            for outage in imperfections.outages:
                present &= (t < outage.start) | (t >= outage.start + outage.length)
            if start == 0:
                present[0] = True
            if start + n == job.rows:
                present[-1] = True
        if self._jitter is not None:
            drawn = np.empty(n)
            self._jitter.fill(drawn)
            t = t + imperfections.jitter * np.clip(drawn, -_MAX_JITTER_SIGMAS, _MAX_JITTER_SIGMAS)
        return t, present


def _channel_value(values: Mapping[str, T], channel: str, default: T) -> T:
    """Value stated for a channel, or for its sensor."""
    return values.get(channel, values.get(stream_name(channel), default))


Flicker = Literal["exact", "poles"]

# the ramp first: a sum of floats depends on the order of its terms
_ORDER = tuple(sorted(TERMS, key=NOISE.__contains__))
_NO_PIVOT = 1e-8  # remainder on the diagonal below which it counts as 0: correlations have fewer digits


def make_noise(
    model: NoiseModel, channel: str, *, n: int, tau0: float, seed: int, flicker: Flicker
) -> generators.Generator:
    """The generator of `n` samples of a channel's noise, in SI. Noise that is correlated between channels is Σ Lᵢⱼ·uⱼ,
    where L·Lᵀ is the correlation matrix and uⱼ the noise that channel j would have alone.
    """
    noise = model.channels[channel]
    made = generators.Generator(n, tau0, seed=seed)
    for term in _ORDER:
        value = noise.terms.get(term)
        if value is None:
            continue
        for number, weight in _shares(model, term, channel):
            if term == "random_walk" and noise.bandwidth is not None:
                low_pass = ChannelModel(terms={"random_walk": 1.0}, bandwidth=noise.bandwidth)
                _add_system(made, weight * value, low_pass, tau0, channel=number)
            else:
                made.add_term(term, weight * value, channel=number, poles=flicker == "poles")
    number = stream_number(channel)
    for k, process in enumerate(noise.gauss_markov):
        made.add_gauss_markov(process.sigma, process.time, index=k, channel=number)
    for k, matern in enumerate(noise.matern):
        for j, part in enumerate(matern.gauss_markov(tau0)):
            made.add_gauss_markov(part.sigma, part.time, index=j, channel=stream_number(f"{channel} matern {k}"))
    for k, resonance in enumerate(noise.resonance):
        alone = ChannelModel(resonance=(replace(resonance, sigma=1.0),))
        _add_system(made, resonance.sigma, alone, tau0, channel=stream_number(f"{channel} resonance {k}"))
    for k, line in enumerate(noise.sinusoid):
        made.add_sinusoid(line.amplitude, line.frequency, index=k, channel=number)
    return made


def normal(n: int, *, seed: int, channel: int) -> generators.Generator:
    """A generator of `n` independent standard normal deviates."""
    made = generators.Generator(n, 1.0, seed=seed)
    made.add_term("random_walk", 1.0, channel=channel)
    return made


def stream_number(channel: str) -> int:
    """FNV-1a hash of the name, so that a channel's noise depends on no other channel."""
    value = 0x811C9DC5
    for byte in channel.encode():
        value = ((value ^ byte) * 0x01000193) & 0xFFFFFFFF
    return value


def _shares(model: NoiseModel, term: str, channel: str) -> list[tuple[int, float]]:
    """Channels whose random numbers are combined for a channel's noise, with the share of each."""
    if not model.correlation.get(term):
        return [(stream_number(channel), 1.0)]
    names = list(model.channels)
    row = correlation_root(model.correlation_matrix(term))[names.index(channel)]
    return [(stream_number(name), float(weight)) for name, weight in zip(names, row, strict=True) if weight]


def correlation_root(matrix: Floats) -> Floats:
    """Lower triangular L with L·Lᵀ = `matrix`, a correlation matrix that may be singular; both have shape (n, n). A
    channel that is independent of the earlier ones has the row of the unit matrix.
    """
    size = len(matrix)
    root = np.zeros((size, size))
    for j in range(size):
        remainder = matrix[j:, j] - root[j:, :j] @ root[j, :j]
        if remainder[0] > _NO_PIVOT:
            root[j:, j] = remainder / math.sqrt(remainder[0])
        else:  # this channel is a combination of those before it
            root[j] /= math.sqrt(root[j] @ root[j])
    return root


def _add_system(made: generators.Generator, scale: float, alone: ChannelModel, tau0: float, *, channel: int) -> None:
    """Add noise of a model whose state space has its output as the first state."""
    system = state_space(alone, dt=tau0)
    made.add_filtered(scale, np.array(system.F), _root(system.Qd), _root(system.P0), channel=channel)


def _root(covariance: Floats) -> Floats:
    """A square root of a matrix by eigenvalues. Eigenvalues that rounding makes negative count as 0."""
    values, vectors = np.linalg.eigh(covariance)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))
