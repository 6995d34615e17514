"""Noise models as linear systems: the matrices that a Kalman filter needs.

Equations of a channel, every `dt`:

    x' = F·x + G·w,  cov w = Qd;   y = H·x + v,  var v = R;   cov x₀ = P0.

Terms and their states:

- random walk: v, or the states of its filter if there is a bandwidth;
- rate random walk: ``bias``; the ramp is its slope;
- bias instability: a few Gauss-Markov states, see `sigmatau.statespace.flicker`;
- Gauss-Markov process: one state; resonance: speed and position of a damped oscillator; sinusoid: two states that rotate;
- quantization: the last two errors of the angle, whose difference over dt is part of the rate.

In the integrated form y is the angle (velocity), and quantization is v.
"""

from __future__ import annotations

import math
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from sigmatau._native.arguments import whole_sizes
from sigmatau.arrays import Floats, freeze
from sigmatau.errors import OptionError
from sigmatau.frozen import frozen
from sigmatau.model.channel import ChannelModel, alike_text
from sigmatau.model.noise_model import NoiseModel
from sigmatau.model.processes import LowPass, Resonance, check_sample_interval, real
from sigmatau.model.unobserved import Unobserved, find_unobserved, include_unobserved, unobserved_text
from sigmatau.noise.terms import refuse_without_system
from sigmatau.results import Printed, plain
from sigmatau.statespace.doubling import RepeatedStep
from sigmatau.statespace.flicker import LONGEST_BAND, FlickerPoles, flicker_poles

Output = Literal["rate", "increments", "integrated"]

_DEFAULT_TAU_MAX = 3600.0  # Default of `tau_max`; at least 1000 samples. [s]
_FILTER_MEMORY = 100.0  # time constants after which a filter has no memory: e^−100 of its state is below rounding


@frozen(eq=False)
class StateSpace(Printed):
    """A channel's noise as a linear system: x′ = F·x + G·w, y = H·x + v.

    w has the covariance Qd, v the variance R, and x at the start the covariance P0.

    Attributes
    ----------
    F : ndarray, shape (n_states, n_states)
        Transition matrix of one step. [SI units of the states]
    G : ndarray, shape (n_states, n_inputs)
        Input matrix. [SI units of the states]
    H : ndarray, shape (1, n_states)
        Measurement matrix. [SI units of the states]
    Qd : ndarray, shape (n_inputs, n_inputs)
        Covariance of the noise of one step. [SI units of the states, squared]
    R : ndarray, shape (1, 1)
        Variance of one measurement. [SI unit of y, squared]
    P0 : ndarray, shape (n_states, n_states)
        Covariance at the start: the stationary covariance of processes, the turn-on variance of a bias. [SI units of
        the states, squared]
    states, inputs : tuple of str
        Names of the states and of the noise inputs.
    dt : float
        Step. [s]
    output : {"rate", "increments", "integrated"}
        Meaning of y: the mean rate of a step, its integral over the step, or its integral since the start.
    unit : str
        Quantity and unit of the rate; SI.
    flicker_error : float
        Largest relative error of the Allan deviation of the flicker noise from `dt` to `tau_max`; 0 without flicker
        noise.
    tau_max : float or None
        Longest averaging time for which the flicker noise is accurate. [s]
    alike_from : float or None
        A Gauss-Markov process with at least this correlation time explains the record of the model as well as its rate
        random walk does. [s]
    not_observed : tuple of str
        Terms of the model that only have an upper limit.
    unobserved : {"absent", "mean", "upper-limit"}
        How the system includes these terms.

    See Also
    --------
    sigmatau.state_space : makes it.
    """

    F: Floats
    G: Floats
    H: Floats
    Qd: Floats
    R: Floats
    P0: Floats
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    dt: float
    output: Output = "rate"
    unit: str = "rad/s"
    flicker_error: float = 0.0
    tau_max: float | None = None
    alike_from: float | None = None
    not_observed: tuple[str, ...] = ()
    unobserved: Unobserved = "absent"

    def __post_init__(self) -> None:
        freeze(self, "F", "G", "H", "Qd", "R", "P0", dtype=np.float64, copy=True)

    def integrated(self) -> tuple[RepeatedStep, Floats, Floats, float]:
        """One step of the system with the integral of y as its last state.

        Returns
        -------
        step : RepeatedStep
            Transition and noise of one step.
        before : ndarray, shape (n_states + 1, n_states + 1)
            Covariance at the start, the integral being 0. [SI]
        row : ndarray, shape (n_states + 1,)
            Measurement matrix of the integral. [1]
        noise : float
            Variance of that measurement. [SI]
        """
        n = len(self.states)
        if self.output == "integrated":
            return (
                RepeatedStep(self.F, self.G @ self.Qd @ self.G.T),
                np.array(self.P0),
                self.H[0].copy(),
                float(self.R[0, 0]),
            )
        size = self.dt if self.output == "rate" else 1.0
        transition, noise, before = np.zeros((n + 1, n + 1)), np.zeros((n + 1, n + 1)), np.zeros((n + 1, n + 1))
        transition[:n, :n], transition[n, :n], transition[n, n] = self.F, size * self.H[0], 1.0
        noise[:n, :n], noise[n, n] = self.G @ self.Qd @ self.G.T, size**2 * float(self.R[0, 0])
        before[:n, :n] = self.P0
        return RepeatedStep(transition, noise), before, np.append(np.zeros(n), 1.0), 0.0

    def avar(self, m: ArrayLike) -> Floats:
        """Allan variance of the system's output, exact, for any linear model.

        Parameters
        ----------
        m : array_like of int, shape (n_tau,)
            Cluster sizes in steps.

        Returns
        -------
        ndarray, shape (n_tau,)
            [(unit of the rate)²]

        Raises
        ------
        OptionError
            For sizes that are not whole numbers from 1.

        Notes
        -----
        The rounding of exp(−dt/T), 1e-16, changes the correlation time T of a Gauss-Markov process by 1e-16·T/dt,
        relative: for dt = 0.01 s and T = 10⁴ s the error of the variance is 1e-11.

        The second difference of the integral is (H·F²ᵐ − 2H·Fᵐ + H)·x₀ + (H·Fᵐ − 2H)·w₁ + H·w₂ plus the noise of three
        measurements; random walks cancel in the first part. Steps are repeated by doubling, see
        `sigmatau.statespace.doubling`.
        """
        sizes = whole_sizes(m, counted="steps")
        if sizes.size and sizes.min() < 1:
            raise OptionError(f"{{option}} must be at least 1 step, got {sizes.min()}", option="m")
        step, before, row, noise = self.integrated()
        result = []
        for size in sizes.tolist():
            block = step.times(int(size))
            shifted = row @ block.transition
            start = shifted @ block.transition - 2 * shifted + row
            first = shifted - 2 * row
            power = start @ before @ start + first @ block.noise @ first + row @ block.noise @ row + 6 * noise
            result.append(power / (2 * (size * self.dt) ** 2))
        return np.array(result)

    def to_dict(self) -> dict[str, Any]:
        """The matrices as lists, with the names of the states."""
        return plain(
            self,
            "F G H Qd R P0 states inputs dt_s=dt output unit flicker_error tau_max_s=tau_max alike_from_s=alike_from"
            " not_observed unobserved",
        )

    def __repr__(self) -> str:
        lines = [f"{len(self.states)} states every {self.dt:g} s, measured as {self.output}: {', '.join(self.states)}"]
        if self.tau_max is not None:
            lines.append(
                f"flicker noise: Allan deviation within {100 * self.flicker_error:.2g} % up to {self.tau_max:.4g} s"
            )
        if self.alike_from is not None:
            lines.append(alike_text(self.alike_from))
        if self.not_observed:
            lines.append(unobserved_text(self.not_observed, self.unobserved))
        for name in ("F", "G", "H", "Qd", "R", "P0"):
            rows = np.array2string(getattr(self, name), precision=6, max_line_width=120).splitlines()
            lines.append(f"{name} = " + f"\n{' ' * (len(name) + 3)}".join(rows))
        return "\n".join(lines)


def state_space(
    model: ChannelModel,
    *,
    dt: float,
    output: Output = "rate",
    tau_max: float | None = None,
    flicker_error: float = 0.01,
    turn_on: float = 0.0,
    unobserved: Unobserved = "absent",
) -> StateSpace:
    """The noise of a channel as a linear system, for a filter of step `dt`.

    Parameters
    ----------
    model : ChannelModel
        Noise of one channel.
    dt : float
        Step of the filter, the sample interval. [s]
    output : {"rate", "increments", "integrated"}
        Measured quantity: the mean rate over a step, the increment of the angle (velocity), or the angle itself, on
        which quantization is white noise.
    tau_max : float, optional
        Longest averaging time for which flicker noise is accurate. [s] Default: an hour, but 1000 to 10¹² steps.
    flicker_error : float
        Largest relative error of the Allan deviation of flicker noise; it determines the number of states.
    turn_on : float
        Standard deviation of the constant bias at the start, which the Allan variance does not show; it adds a state
        unless it is 0. [unit of the rate]
    unobserved : {"absent", "mean", "upper-limit"}
        How the system includes terms that were not observed: not at all, so that it drifts too little if they exist;
        with the mean of their variance if every coefficient up to the upper limit is equally probable; or at the limit.

    Returns
    -------
    StateSpace

    Raises
    ------
    OptionError
        For a model of several channels, a step or time that is not positive, an unknown output, or a flicker error that
        cannot be reached.

    See Also
    --------
    arma : the same noise as an ARIMA process.
    verify : compares the linear system with a record.

    Notes
    -----
    The rate random walk is sampled, b' = b + K·√dt·w; a ramp is a slope of variance R². All terms except flicker noise are
    exact at `dt`, but a Matérn process is a sum of Gauss-Markov processes, see `ChannelModel.expand_matern`.

    References
    ----------
    docs/theory/state-space.md has the matrices of each term.

    Examples
    --------
    >>> import sigmatau as st
    >>> model = st.ChannelModel(terms={"random_walk": 1e-4, "rate_random_walk": 1e-6})
    >>> system = st.state_space(model, dt=0.01)
    >>> system.states, system.R.round(9).tolist()
    (('bias',), [[1e-06]])
    """
    check_channel_model(model, function="state_space")
    refuse_without_system(model.terms)
    not_observed = find_unobserved(model)
    model = include_unobserved(model, unobserved)
    model = model.expand_matern(rate=1 / check_sample_interval("dt", dt))
    if output not in ("rate", "increments", "integrated"):
        raise OptionError(f"{{option}} must be 'rate', 'increments' or 'integrated', not {output!r}", option="output")
    if not (math.isfinite(real(turn_on)) and turn_on >= 0):
        raise OptionError(f"{{option}} must be 0 or a positive number, not {turn_on!r}", option="turn_on")
    system = _System(dt)
    terms = model.terms
    white = 0.0
    if "random_walk" in terms:
        if model.bandwidth is None:
            white = terms["random_walk"] ** 2 / dt
        else:
            system.low_pass(model.bandwidth.before_sampling(terms["random_walk"]), model.bandwidth)
    if "rate_random_walk" in terms or "rate_ramp" in terms or turn_on:
        system.walk(terms.get("rate_random_walk", 0.0), terms.get("rate_ramp", 0.0), turn_on)
    poles = find_flicker_poles(model, dt=dt, tau_max=tau_max, error=flicker_error)
    if poles is not None:
        for k, (time, variance) in enumerate(zip(poles.times, poles.variances, strict=True), 1):
            system.gauss_markov(f"flicker_{k}", terms["bias_instability"] ** 2 * variance, time)
    for k, process in enumerate(model.gauss_markov, 1):
        system.gauss_markov(f"gauss_markov_{k}", process.sigma**2, process.time)
    for k, resonance in enumerate(model.resonance, 1):
        system.resonance(k, resonance)
    for k, line in enumerate(model.sinusoid, 1):
        system.sinusoid(k, line.amplitude, line.frequency)
    quantization = terms.get("quantization", 0.0)
    if output == "integrated":
        system.integrate(white)
        variance = quantization**2
    else:
        if quantization:
            system.quantization(quantization)
        variance = white if output == "rate" else white * dt**2
    scale = dt if output == "increments" else 1.0
    return StateSpace(
        F=system.F,
        G=system.G,
        H=scale * system.H[None, :],
        Qd=system.Qd,
        R=np.array([[variance]]),
        P0=system.P0,
        states=tuple(system.states),
        inputs=tuple(system.inputs),
        dt=dt,
        output=output,
        unit=model.unit,
        flicker_error=poles.error if poles else 0.0,
        tau_max=poles.tau_max if poles else None,
        alike_from=None if model.alike_from is None else model.alike_from.time,
        not_observed=not_observed,
        unobserved=unobserved,
    )


def check_channel_model(model: object, *, function: str) -> None:
    """Raise `OptionError` unless the model is that of one channel."""
    if isinstance(model, ChannelModel):
        return
    if isinstance(model, NoiseModel):
        raise OptionError(
            f"`model` has {len(model)} channel{'s' * (len(model) > 1)}, and {function} takes a single one:"
            f" {function}(model[{next(iter(model))!r}], …)",
            option="model",
        )
    raise OptionError(
        f"{{option}} must be a ChannelModel, not {type(model).__name__}; an analysis has one for each channel:"
        ' analysis.model["gyro_x"]',
        option="model",
    )


def find_flicker_poles(model: ChannelModel, *, dt: float, tau_max: float | None, error: float) -> FlickerPoles | None:
    """Processes for the bias instability of a model, up to an hour by default; None without bias instability."""
    if "bias_instability" not in model.terms:
        return None
    longest = min(max(_DEFAULT_TAU_MAX, 1000 * dt), LONGEST_BAND * dt) if tau_max is None else tau_max
    return flicker_poles(dt=dt, tau_max=longest, error=error)


class _System:
    """Matrices of a system to which terms are added one by one; y is the mean rate of a step."""

    def __init__(self, dt: float) -> None:
        self.dt = dt
        self.states: list[str] = []
        self.inputs: list[str] = []
        self.F = self.P0 = self.Qd = np.zeros((0, 0))
        self.G = np.zeros((0, 0))
        self.H = np.zeros(0)

    def _add(
        self, states: list[str], f: Floats, g: Floats, h: Floats, q: Floats, p0: Floats, inputs: list[str]
    ) -> None:
        self.F, self.P0, self.Qd = _block_diagonal(self.F, f), _block_diagonal(self.P0, p0), _block_diagonal(self.Qd, q)
        self.G = _block_diagonal(self.G, g)
        self.H = np.concatenate((self.H, h))
        self.states += states
        self.inputs += inputs

    def gauss_markov(self, name: str, variance: float, time: float) -> None:
        decay = math.exp(-self.dt / time)
        lost = -math.expm1(-2 * self.dt / time)
        unity = np.ones((1, 1))
        self._add([name], decay * unity, unity, np.ones(1), variance * lost * unity, variance * unity, [name])

    def walk(self, k: float, ramp: float, turn_on: float) -> None:
        if ramp:
            f = np.array([[1.0, self.dt], [0.0, 1.0]])
            p0 = np.diag([turn_on**2, ramp**2])
            states, h = ["bias", "ramp"], np.array([1.0, 0.0])
        else:
            f, p0, states, h = np.ones((1, 1)), np.array([[turn_on**2]]), ["bias"], np.ones(1)
        inputs = ["rate_random_walk"] if k else []
        g = np.eye(len(f), len(inputs))
        self._add(states, f, g, h, np.full((len(inputs), len(inputs)), k**2 * self.dt), p0, inputs)

    def sinusoid(self, number: int, amplitude: float, frequency: float) -> None:
        turn = 2 * math.pi * math.fmod(frequency * self.dt, 1.0)
        f = np.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]])
        names = [f"sinusoid_{number}", f"sinusoid_{number}_quadrature"]
        p0 = amplitude**2 / 2 * np.eye(2)
        self._add(names, f, np.zeros((2, 0)), np.array([1.0, 0.0]), np.zeros((0, 0)), p0, [])

    def quantization(self, q: float) -> None:
        f = np.array([[0.0, 0.0], [1.0, 0.0]])
        h = np.array([1.0, -1.0]) / self.dt
        names = ["angle_error", "angle_error_before"]
        self._add(names, f, np.array([[1.0], [0.0]]), h, np.array([[q**2]]), q**2 * np.eye(2), ["quantization"])

    def low_pass(self, n: float, bandwidth: LowPass) -> None:
        """Add a Butterworth filter at the sample times, driven by the exact covariance of continuous white noise."""
        from scipy.linalg import solve_continuous_lyapunov
        from scipy.signal import butter

        corner, order = 2 * math.pi * bandwidth.corner, bandwidth.order
        # In units of the corner, in controllable form, all states have the same magnitude.
        _, denominator = butter(order, 1.0, analog=True)
        a = np.zeros((order, order))
        a[:-1, 1:] = np.eye(order - 1)
        a[-1] = -denominator[:0:-1]
        density = np.zeros((order, order))
        density[-1, -1] = n**2 * corner
        p0 = np.asarray(solve_continuous_lyapunov(a, -density), dtype=np.float64)
        slowest = math.sin(math.pi / (2 * order))
        self._sampled("filter_{}", "random_walk_{}", a, density, p0, time=corner * self.dt, slowest=slowest)

    def resonance(self, number: int, process: Resonance) -> None:
        """Add a damped oscillator, its velocity first; scaled by its frequency so that both states have the same
        variance.
        """
        loss = 2 * process.width / process.frequency
        a = np.array([[-loss, -1.0], [1.0, 0.0]])
        density = np.diag([2 * loss * process.sigma**2, 0.0])
        time = 2 * math.pi * process.frequency * self.dt
        name = f"resonance_{number}"
        p0 = np.diag([process.sigma**2, process.sigma**2])
        self._sampled(f"{name}_{{}}", f"{name}_{{}}", a, density, p0, time=time, slowest=loss / 2)

    def _sampled(
        self, state: str, noise: str, a: Floats, density: Floats, p0: Floats, *, time: float, slowest: float
    ) -> None:
        """Add ẋ = a·x + white noise of this density at sample times with the interval `time`; its first state is
        measured. `slowest` is the smallest decay rate of a pole.
        """
        order = len(a)
        if time * slowest > _FILTER_MEMORY:
            # beyond the memory of the slowest pole, products of this size lose digits
            f, q = np.zeros((order, order)), p0
        else:
            step = RepeatedStep.of_continuous(a, density, time)
            f, q = step.transition, step.noise
        numbers = range(1, order + 1)
        self._add(
            [state.format(k) for k in numbers],
            f,
            np.eye(order),
            np.eye(1, order)[0],
            (q + q.T) / 2,
            (p0 + p0.T) / 2,
            [noise.format(k) for k in numbers],
        )

    def integrate(self, white: float) -> None:
        """Make the integral of y the first state and the measurement."""
        n, k = len(self.states), len(self.inputs)
        f, p0 = np.zeros((n + 1, n + 1)), np.zeros((n + 1, n + 1))
        f[0, 0], f[0, 1:], f[1:, 1:] = 1.0, self.dt * self.H, self.F
        p0[1:, 1:] = self.P0
        g, q = np.zeros((n + 1, k)), self.Qd
        g[1:] = self.G.reshape(n, k)
        if white:
            g = np.concatenate((np.eye(n + 1, 1), g), axis=1)
            q = _block_diagonal(np.array([[white * self.dt**2]]), q)
            self.inputs = ["random_walk", *self.inputs]
        self.F, self.G, self.Qd, self.P0 = f, g, q, p0
        self.H = np.eye(1, n + 1)[0]
        self.states = ["integral", *self.states]


def _block_diagonal(a: Floats, b: Floats) -> Floats:
    """Block diagonal matrix of two matrices."""
    result = np.zeros((a.shape[0] + b.shape[0], a.shape[1] + b.shape[1]))
    result[: a.shape[0], : a.shape[1]] = a
    result[a.shape[0] :, a.shape[1] :] = b
    return result
