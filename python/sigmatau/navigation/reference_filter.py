"""Consistency of a bias-estimating filter: a stationary filter applied to the complete noise model of a sensor.

The states of the filter are the integral of the sensor's rate (an angle; the velocity of an accelerometer) and a bias, which
is a random walk of coefficient K, a first-order Gauss-Markov process, or the sum of both. Measurements of the integral
at a constant interval aid the filter. Its stationary gain follows from the Riccati equation of the model that the
filter assumes. The actual covariance of its error follows from the joint system of truth and filter, where the truth
has all noise of the channel; flicker noise is a bank of Gauss-Markov processes, three per decade. Internally, time is
in intervals of aiding, and the integral in standard deviations of the measurement.

References
----------
A. Gelb (ed.), "Applied Optimal Estimation," 1974, section 7.2: covariance of a suboptimal filter.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Literal

import numpy as np

from sigmatau.arrays import Floats
from sigmatau.frozen import frozen
from sigmatau.model.processes import GaussMarkov, Resonance
from sigmatau.noise.terms import SLOW, refuse_without_system
from sigmatau.statespace.doubling import RepeatedStep
from sigmatau.statespace.riccati import stationary_covariance

Criterion = Literal["horizon", "bias"]

_POLES_PER_DECADE = 3  # poles of flicker noise; the error of its density is then 1 %
_SLOWEST_POLE = 3e5  # a bias that drifts more slowly is constant for a filter [s]
_FASTEST_PROCESS = 1e-3  # a process with a shorter correlation time is white noise for the filter [intervals of aiding]
_SETTLED = 2e4  # shortest time that the filter runs before its error is computed [s]
_TIME_CONSTANTS = 20.0  # number of time constants in which the error of the filter becomes stationary
_FLOOR = 0.01  # smallest K, in N/horizon: it adds 1 % to the stated variance at the horizon
_LARGEST_WALK = 1e20  # largest K, in the unit of `_FLOOR`
_FIRST_TIME = 10.0  # shortest time at which a filter with a third state is fitted [s]
_TOLERANCE = 1e-4  # relative error of K
RUN = 60.0
"""Number of horizons for which a filter with a Gauss-Markov bias runs before its error is judged, and the correlation time
of its process: an hour for 60 s. With a rate random walk alone the error after 60 s is then 7 % larger than the one stated
after 8 h.
"""
# largest ratio of the error of a step to that of a measurement, or its inverse; for sensors the ratio is 1e-4 to 10
_LARGEST_RATIO = 1e5


@frozen
class Aiding:
    """How the reference filter of a sensor is aided.

    Attributes
    ----------
    interval : float
        Time between two measurements. [s]
    deviation : float
        Standard deviation of a measurement of the angle or velocity. [rad or m/s]
    """

    interval: float
    deviation: float


AIDING = {"gyro": Aiding(interval=0.2, deviation=1e-4), "accel": Aiding(interval=0.2, deviation=0.01)}
"""An attitude with 20″ five times a second, like a camera; a velocity with 1 cm/s, like a GNSS receiver."""


@frozen(eq=False)
class TrueNoise:
    """All noise of a channel that accumulates in the integral: without quantization and sinusoids.

    Attributes
    ----------
    terms : mapping of str to float
        Coefficients by term, as in `sigmatau.noise.terms.TERMS`. [SI]
    gauss_markov : tuple of GaussMarkov
    resonance : tuple of Resonance
    """

    terms: Mapping[str, float]
    gauss_markov: tuple[GaussMarkov, ...] = ()
    resonance: tuple[Resonance, ...] = ()

    def __post_init__(self) -> None:
        refuse_without_system(self.terms)


@frozen
class FilterModel:
    """Noise of a sensor that a filter assumes.

    Attributes
    ----------
    noise : float
        N, the white noise. [rad/s/√Hz or m/s²/√Hz]
    walk : float
        K of the bias; 0 for none. [rad/s²/√Hz or m/s³/√Hz]
    process : GaussMarkov or None
        A second bias, which is a Gauss-Markov process.
    """

    noise: float
    walk: float = 0.0
    process: GaussMarkov | None = None


@frozen
class Coasting:
    """The error of the integral after some time without a measurement.

    Attributes
    ----------
    time : float
        [s]
    real, stated : float
        Actual standard deviation of the error, and the one stated by the filter. [rad or m/s]
    """

    time: float
    real: float
    stated: float

    @property
    def ratio(self) -> float:
        """Ratio of the actual to the stated error."""
        return self.real / self.stated


@frozen
class Consistency:
    """Consistency of the covariance of a filter.

    Attributes
    ----------
    nees : float
        Actual over stated variance of the bias, the normalised estimation error squared: 1 for a consistent filter.
    coasting : tuple of Coasting
        Errors without measurements.
    """

    nees: float
    coasting: tuple[Coasting, ...]


@frozen
class ConsistentWalk:
    """K for which a filter is consistent.

    Attributes
    ----------
    walk : float
        [rad/s²/√Hz or m/s³/√Hz]
    is_floor : bool
        Whether this is the smallest allowed K, with which the filter already overstates its error.
    """

    walk: float
    is_floor: bool = False


@frozen
class ConsistentProcess:
    """A Gauss-Markov bias for which a filter is consistent.

    Attributes
    ----------
    process : GaussMarkov
    is_floor : bool
        Whether this is the smallest allowed process, with which the filter already overstates its error.
    """

    process: GaussMarkov
    is_floor: bool = False


def judge_filter(
    truths: Sequence[TrueNoise],
    assumed: FilterModel,
    *,
    aiding: Aiding,
    times: Sequence[float],
    mean: bool = False,
    run: float | None = None,
) -> Consistency:
    """Consistency of a filter for axes with different noise, by the largest error or the mean square; after a run of
    some time [s], or in the stationary state.
    """
    units = _Units.build(aiding, assumed.noise)
    filter_ = _Filter.build(assumed, units)
    combine = np.mean if mean else np.max
    steps = None if run is None else units.steps(run)
    joints = [_Joint.build(_Truth.build(truth, units), filter_, steps) for truth in truths]
    stated = filter_.stated_bias()
    nees = float(combine([joint.bias() for joint in joints])) / stated
    coasting = []
    for time in times:
        real = math.sqrt(combine([joint.coasting(units.steps(time)) for joint in joints]))
        variance = filter_.stated_coasting(units.steps(time))
        coasting.append(Coasting(time=time, real=units.integral * real, stated=units.integral * math.sqrt(variance)))
    return Consistency(nees=nees, coasting=tuple(coasting))


def find_consistent_walk(
    truth: TrueNoise, *, noise: float, aiding: Aiding, horizon: float, criterion: Criterion = "horizon"
) -> ConsistentWalk:
    """Find K for which a filter with N = `noise` correctly states its error after the horizon, or that of its bias."""
    return _solve_walk(
        tuple(truth.terms.items()), truth.gauss_markov, truth.resonance, noise, aiding, horizon, criterion
    )


@functools.lru_cache(maxsize=1024)  # cached, because each target of a report needs the same walks
def _solve_walk(
    coefficients: tuple[tuple[str, float], ...],
    gauss_markov: tuple[GaussMarkov, ...],
    resonance: tuple[Resonance, ...],
    noise: float,
    aiding: Aiding,
    horizon: float,
    criterion: Criterion,
) -> ConsistentWalk:
    """Solve for the K of `find_consistent_walk`."""
    terms = dict(coefficients)
    truth = TrueNoise(terms=terms, gauss_markov=gauss_markov, resonance=resonance)
    slow = [term for term in SLOW if term in terms]
    if (
        slow == ["rate_random_walk"]
        and not (truth.gauss_markov or truth.resonance)
        and terms.get("random_walk") == noise
    ):
        return ConsistentWalk(walk=terms["rate_random_walk"])  # the truth is the filter's model
    units = _Units.build(aiding, noise)
    whole = _Truth.build(truth, units)

    def excess(log_walk: float) -> float:
        """Logarithm of the actual over the stated variance, which falls with K."""
        filter_ = _Filter.build(FilterModel(noise=noise, walk=math.exp(log_walk)), units)
        joint = _Joint.build(whole, filter_)
        if criterion == "bias":
            return math.log(joint.bias() / filter_.stated_bias())
        steps = units.steps(horizon)
        return math.log(joint.coasting(steps) / filter_.stated_coasting(steps))

    return _consistent_walk(excess, _FLOOR * noise / horizon)


def find_consistent_process(
    truth: TrueNoise, *, noise: float, aiding: Aiding, horizon: float, time: float
) -> ConsistentProcess:
    """Find a Gauss-Markov bias, with a given correlation time, for which a filter states its error after the horizon
    correctly.

    The stated error is correct after a run of `run_of_process`. A bias that drifts without bound finally exceeds any
    stationary process.
    """
    units = _Units.build(aiding, noise)
    whole, steps = _Truth.build(truth, units), units.steps(horizon)
    run = units.steps(run_of_process(horizon, time))

    def driven_process(walk: float) -> GaussMarkov:
        return GaussMarkov(sigma=walk * math.sqrt(time / 2), time=time)

    def excess(log_walk: float) -> float:
        filter_ = _Filter.build(FilterModel(noise=noise, process=driven_process(math.exp(log_walk))), units)
        return math.log(_Joint.build(whole, filter_, run).coasting(steps) / filter_.stated_coasting(steps))

    chosen = _consistent_walk(excess, _FLOOR * noise / horizon)
    return ConsistentProcess(process=driven_process(chosen.walk), is_floor=chosen.is_floor)


def run_of_process(horizon: float, time: float) -> float:
    """Time that a filter with a Gauss-Markov bias runs before its error is judged. [s]"""
    return max(RUN * horizon, time)


def _consistent_walk(excess: Callable[[float], float], floor: float) -> ConsistentWalk:
    """The walk at which the logarithm of the actual over the stated variance is 0, starting from the smallest walk that is
    used.
    """
    below = excess(math.log(floor))
    if below <= 0:
        return ConsistentWalk(walk=floor, is_floor=True)
    low = math.log(floor)
    return ConsistentWalk(walk=math.exp(_falling_root(excess, low, below, low + math.log(_LARGEST_WALK))))


def find_third_state(truth: TrueNoise, *, noise: float, aiding: Aiding, horizon: float) -> FilterModel:
    """Find a walk and a Gauss-Markov process for which a filter of three states is most consistent up to the horizon.

    Least squares of the logarithms of real over stated error of the bias and of the integral after several times from 10 s
    (a sixth of a shorter horizon) to the horizon. The filter then has N = `noise`, K, σ and T.
    """
    from scipy.optimize import least_squares

    units = _Units.build(aiding, noise)
    whole = _Truth.build(truth, units)
    first = min(_FIRST_TIME, horizon / 6)
    times = [units.steps(time) for time in (first, math.sqrt(first * horizon), horizon)]

    def filter_model(parameters: Floats) -> FilterModel:
        walk, density, time = np.exp(parameters).tolist()
        return FilterModel(noise=noise, walk=walk, process=GaussMarkov(sigma=density * math.sqrt(time / 2), time=time))

    def errors(parameters: Floats) -> Floats:
        filter_ = _Filter.build(filter_model(parameters), units)
        joint = _Joint.build(whole, filter_)
        ratios = [joint.bias() / filter_.stated_bias()]
        ratios += [joint.coasting(steps) / filter_.stated_coasting(steps) for steps in times]
        return np.log(ratios) / 2

    start = find_consistent_walk(truth, noise=noise, aiding=aiding, horizon=horizon).walk
    floor = math.log(_FLOOR * noise / horizon)
    guess = np.array([max(math.log(start / 2), floor), math.log(3 * start), math.log(horizon / 3)])
    # A correlation time of a few steps is white noise, one of many horizons a walk.
    low = np.array([floor, floor, math.log(10 * aiding.interval)])
    high = np.array([guess[0] + 5, guess[1] + 5, math.log(10 * horizon)])
    solved = least_squares(
        errors, np.clip(guess, low + 1e-6, high - 1e-6), bounds=(low, high), diff_step=[1e-3] * 3, xtol=1e-4
    )
    return filter_model(solved.x)


def _falling_root(function: Callable[[float], float], low: float, at_low: float, highest: float) -> float:
    """The root of a falling function above `low`, by steps of a factor 10 and the Illinois variant of regula falsi."""
    high = low
    at_high = at_low
    while at_high > 0 and high < highest:
        low, at_low = high, at_high
        high = min(high + math.log(10.0), highest)
        at_high = function(high)
    if at_high > 0:
        return high
    side = 0
    while high - low > _TOLERANCE:
        middle = (low * at_high - high * at_low) / (at_high - at_low)
        value = function(middle)
        if abs(value) < _TOLERANCE:
            return middle
        if value > 0:
            low, at_low = middle, value
            at_high /= 2 if side > 0 else 1
            side = 1
        else:
            high, at_high = middle, value
            at_low /= 2 if side < 0 else 1
            side = -1
    return (low + high) / 2


@frozen(kw_only=False)
class _Units:
    """Units in which the interval and the deviation of the aiding are 1."""

    time: float
    integral: float

    @classmethod
    def build(cls, aiding: Aiding, noise: float) -> _Units:
        """Units for a filter with N = `noise`. If the ratio of the noise of a step to the deviation is not realistic,
        the deviation is set from N.
        """
        step = noise * math.sqrt(aiding.interval)
        return cls(aiding.interval, min(max(aiding.deviation, step / _LARGEST_RATIO), step * _LARGEST_RATIO))

    def steps(self, time: float) -> int:
        return max(round(time / self.time), 1)

    def noise(self, density: float) -> float:
        """N in the units."""
        return density * math.sqrt(self.time) / self.integral

    def rate(self, value: float) -> float:
        """A rate in the units."""
        return value * self.time / self.integral

    def walk(self, density: float) -> float:
        """K in the units."""
        return density * self.time * math.sqrt(self.time) / self.integral

    def ramp(self, value: float) -> float:
        """R in the units."""
        return value * self.time**2 / self.integral


class _Continuous:
    """ẋ = A·x + w, where w has the density D; x₀ is the integral of the sum of the measured states."""

    def __init__(self, noise: float) -> None:
        self.a = np.zeros((1, 1))
        self.d = np.full((1, 1), noise**2)
        self.before = np.zeros((1, 1))

    def add(self, a: Floats, d: Floats, before: Floats) -> None:
        """Add a part whose first state is measured; `before`: its covariance at the start."""
        n, k = len(self.a), len(a)
        for name, block in (("a", a), ("d", d), ("before", before)):
            matrix = np.zeros((n + k, n + k))
            matrix[:n, :n], matrix[n:, n:] = getattr(self, name), block
            setattr(self, name, matrix)
        self.a[0, n] = 1.0

    def processes(self, variances: Floats, times: Floats) -> None:
        """Add Gauss-Markov processes."""
        self.add(np.diag(-1 / times), np.diag(2 * variances / times), np.diag(variances))
        self.a[0, -len(times) :] = 1.0

    def walk(self, k: float) -> None:
        """Add a random walk of the rate."""
        self.add(np.zeros((1, 1)), np.full((1, 1), k**2), np.zeros((1, 1)))

    def step(self) -> RepeatedStep:
        """Transition and noise of a step of length 1."""
        return RepeatedStep.of_continuous(self.a, self.d, 1.0)


@frozen(kw_only=False, eq=False)
class _Truth:
    """The noise of a channel in discrete time."""

    step: RepeatedStep
    before: Floats
    measured: Floats  # 1 for states that are part of the rate; shape (n_states,)

    @classmethod
    def build(cls, model: TrueNoise, units: _Units) -> _Truth:
        terms = model.terms
        white = units.noise(terms.get("random_walk", 0.0)) ** 2
        variances, times = [], []
        for process in model.gauss_markov:
            variance, time = units.rate(process.sigma) ** 2, process.time / units.time
            if time < _FASTEST_PROCESS:
                white += 2 * variance * time
            else:
                variances.append(variance)
                times.append(time)
        if "bias_instability" in terms:
            decades = math.log10(_SLOWEST_POLE / units.time)
            number = math.ceil(_POLES_PER_DECADE * decades) + 1
            spaced = np.logspace(0, decades, number)
            # The density B²/(2πf) is the integral of processes of the variance B²/π for each factor e of the time.
            share = units.rate(terms["bias_instability"]) ** 2 / math.pi * math.log(spaced[1] / spaced[0])
            variances += [share] * number
            times += spaced.tolist()
        parts = _Continuous(math.sqrt(white))
        if variances:
            parts.processes(np.array(variances), np.array(times))
        if "rate_random_walk" in terms:
            parts.walk(units.walk(terms["rate_random_walk"]))
        if "rate_ramp" in terms:
            slope = units.ramp(terms["rate_ramp"]) ** 2
            parts.add(np.array([[0.0, 1.0], [0.0, 0.0]]), np.zeros((2, 2)), np.diag([0.0, slope]))
        for band in model.resonance:
            turn = 2 * math.pi * band.frequency * units.time
            loss = 2 * band.width / band.frequency
            variance = units.rate(band.sigma) ** 2
            a = turn * np.array([[-loss, -1.0], [1.0, 0.0]])
            parts.add(a, turn * np.diag([2 * loss * variance, 0.0]), variance * np.eye(2))
        return cls(parts.step(), parts.before, parts.a[0])


@frozen(kw_only=False, eq=False)
class _Filter:
    """The stationary filter."""

    step: RepeatedStep
    gain: Floats  # shape (n_states,)
    updated: Floats  # stated covariance after a measurement
    settling: float  # time until the filter is stationary, in steps

    @classmethod
    def build(cls, assumed: FilterModel, units: _Units) -> _Filter:
        noise, walk = units.noise(assumed.noise), units.walk(assumed.walk)
        parts = _Continuous(noise)
        if walk:
            parts.walk(walk)
        if assumed.process is not None:
            sigma, time = units.rate(assumed.process.sigma), assumed.process.time / units.time
            parts.processes(np.array([sigma**2]), np.array([time]))
        step = parts.step()
        before = stationary_covariance(step.transition, step.noise, rows=np.eye(len(parts.a))[:1], variances=np.ones(1))
        gain = before[:, 0] / (before[0, 0] + 1)
        updated = before - np.outer(gain, before[0])
        slowest = max(noise / walk if walk else 0.0, assumed.process.time / units.time if assumed.process else 0.0)
        settling = max(_SETTLED / units.time, _TIME_CONSTANTS * max(slowest, 1 / noise if noise else 0.0))
        return cls(step, gain, (updated + updated.T) / 2, settling)

    def stated_bias(self) -> float:
        return float(self.updated[1:, 1:].sum())

    def stated_coasting(self, steps: int) -> float:
        return float(self.step.times(steps).covariance(self.updated)[0, 0])


@frozen(kw_only=False, eq=False)
class _Joint:
    """Joint system of truth and filter: the error of the integral, the parts of the truth, the biases estimated by the
    filter.
    """

    step: RepeatedStep  # step between two measurements
    covariance: Floats  # covariance after a measurement, in the stationary state
    error: Floats  # coefficients of the states in the error of the bias; shape (n_states,)

    @classmethod
    def build(cls, truth: _Truth, filter_: _Filter, steps: int | None = None) -> _Joint:
        n, k = len(truth.before), len(filter_.gain) - 1
        free, noise, before = (np.zeros((n + k, n + k)) for _ in range(3))
        free[:n, :n], noise[:n, :n], before[:n, :n] = truth.step.transition, truth.step.noise, truth.before
        free[0, n:], free[n:, n:] = -filter_.step.transition[0, 1:], filter_.step.transition[1:, 1:]
        # effect of the noise of a measurement
        entry = np.concatenate(([-filter_.gain[0]], np.zeros(n - 1), filter_.gain[1:]))
        update = np.eye(n + k)
        update[:, 0] += entry
        measured = RepeatedStep(update @ free, update @ noise @ update.T + np.outer(entry, entry))
        settled = measured.times(2 ** math.ceil(math.log2(filter_.settling)) if steps is None else steps)
        error = np.concatenate((truth.measured, -np.ones(k)))
        return cls(RepeatedStep(free, noise), settled.covariance(before), error)

    def bias(self) -> float:
        """Variance of the error of the bias."""
        return float(self.error @ self.covariance @ self.error)

    def coasting(self, steps: int) -> float:
        """Variance of the error of the integral after steps without a measurement."""
        return float(self.step.times(steps).covariance(self.covariance)[0, 0])
