"""Covariance of the errors of free inertial navigation at rest, caused by the noise of the sensors.

Axes x and y are level, z is up. Equations of the errors of velocity v_x and position p_x, and of the tilt ψ_y since t =
0 from the perpendicular gyro:

    ψ_y' = ω_y − v_x/R,   v_x' = a_x + g·ψ_y,   p_x' = v_x,

and likewise ψ_x' = ω_x + v_y/R, v_y' = a_y − g·ψ_x. The feedback v/R is Schuler's. Gravity decreases with height, v_z' = a_z
+ 2g/R·p_z. On a flat Earth R is infinite. The rates are constant during a step, and the equations are solved exactly.
Sources of noise are independent, so the effect of each is computed separately, for many steps at once.

References
----------
D. H. Titterton, J. L. Weston, "Strapdown Inertial Navigation Technology," 2nd ed., 2004, chapter 12.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

import numpy as np

from sigmatau.arrays import Floats
from sigmatau.frozen import frozen
from sigmatau.model.channel import ChannelModel
from sigmatau.statespace.doubling import RepeatedStep
from sigmatau.statespace.state_space import state_space
from sigmatau.units import STANDARD_GRAVITY

Earth = Literal["round", "flat"]

EARTH_RADIUS = 6371008.8
"""Mean radius of the Earth, WGS 84. [m]"""

# Gyro perpendicular to an accelerometer, and the sign of the acceleration by tilt.
_ACROSS = {"accel_x": ("gyro_y", 1.0), "accel_y": ("gyro_x", -1.0)}
_ANGLES = {"gyro_x": "roll", "gyro_y": "pitch", "gyro_z": "heading"}


@frozen(eq=False)
class Mechanisation:
    """Equations of some errors: n' = A·n + B·(rates of the sensors).

    Attributes
    ----------
    rows : mapping of str to int
        State of each error, by name.
    inputs : tuple of str
        Channels.
    without : str
        The missing gyro perpendicular to the accelerometer, whose tilt is omitted; empty if the model has it.
    A : ndarray, shape (n_states, n_states)
        [1/s]
    B : ndarray, shape (n_states, n_inputs)
    """

    rows: Mapping[str, int]
    inputs: tuple[str, ...]
    A: Floats
    B: Floats
    without: str = ""

    def step(self, dt: float) -> tuple[Floats, Floats]:
        """Transition and input of one step with constant rates."""
        from scipy.linalg import expm

        n, k = self.B.shape
        whole = np.zeros((n + k, n + k))
        whole[:n, :n], whole[:n, n:] = self.A, self.B
        solved = expm(whole * dt)
        return solved[:n, :n], solved[:n, n:]


@frozen(eq=False)
class NoiseSource:
    """One independent source of noise as a linear system of step dt: y = H·x + v.

    Attributes
    ----------
    F, noise, before : ndarray, shape (n_states, n_states)
        Transition, covariance of the noise that a step adds, covariance at the start.
    H : ndarray, shape (n_states,)
    R : float
        Variance of v. [SI units, squared]
    mean : ndarray, shape (n_states,)
        Mean of the state at the start.
    flicker_error : float
    """

    F: Floats
    noise: Floats
    before: Floats
    H: Floats
    R: float
    mean: Floats
    flicker_error: float = 0.0

    @classmethod
    def constant(cls, sigma: float) -> NoiseSource:
        """A constant with standard deviation `sigma`."""
        return cls(
            F=np.eye(1), noise=np.zeros((1, 1)), before=np.array([[sigma**2]]), H=np.ones(1), R=0.0, mean=np.zeros(1)
        )

    def errors(
        self, mechanisation: Mechanisation, gains: Floats, *, dt: float, calibration: int, steps: Floats
    ) -> tuple[Floats, Floats]:
        """Mean and variance of the mechanisation's states.

        Parameters
        ----------
        mechanisation : Mechanisation
        gains : ndarray, shape (n_inputs,)
            Gain from the source to the rate of each channel.
        dt : float
            [s]
        calibration : int
            Number of steps before the start whose mean rate is subtracted afterwards; 0 for none.
        steps : ndarray of int, shape (n_times,)
            Steps from the start, increasing.

        Returns
        -------
        mean, variance : ndarray, shape (n_times, n_states)
        """
        transition, entry = mechanisation.step(dt)
        into = entry @ gains
        s, n = len(self.F), len(transition)
        size = s + 1 + n  # the source, the mean that is subtracted, the errors
        free = np.zeros((size, size))
        free[:s, :s], free[s, s], free[s + 1 :, s + 1 :] = self.F, 1.0, transition
        free[s + 1 :, :s], free[s + 1 :, s] = np.outer(into, self.H), -into
        white = np.concatenate((np.zeros(s + 1), into))
        navigating = RepeatedStep(free, _widen(self.noise, size) + self.R * np.outer(white, white))
        covariance = _widen(self.before, size)
        mean = np.concatenate((self.mean, np.zeros(size - s)))
        if calibration:
            still = np.eye(size)
            still[:s, :s], still[s, :s] = self.F, self.H / calibration
            noise = _widen(self.noise, size)
            noise[s, s] = self.R / calibration**2
            averaging = RepeatedStep(still, noise).times(calibration)
            covariance, mean = averaging.covariance(covariance), averaging.transition @ mean
        means, variances = [], []
        done = 0
        for upto in steps.tolist():
            block = navigating.times(int(upto) - done)
            covariance, mean, done = block.covariance(covariance), block.transition @ mean, int(upto)
            means.append(mean[s + 1 :])
            variances.append(np.diag(covariance)[s + 1 :])
        # Rounding may make a sum of squares negative.
        return np.array(means), np.maximum(np.array(variances), 0.0)


def source(part: ChannelModel, *, dt: float, tau_max: float, flicker_error: float, calibrated: bool) -> NoiseSource:
    """Source of one part of a channel's noise, see `ChannelModel.parts`.

    Without a calibration, the random walk of the rate and the flicker noise begin at 0; a Gauss-Markov process and a
    sinusoid are stationary. A ramp is a mean, not noise, and begins at 0.
    """
    system = state_space(part, dt=dt, tau_max=max(tau_max, dt), flicker_error=flicker_error)
    before = np.array(system.P0)
    mean = np.zeros(len(before))
    if "bias_instability" in part.terms and not calibrated:
        before = np.zeros_like(before)
    if "rate_ramp" in part.terms:
        # The mean of a ramp over the first step.
        before, mean = np.zeros_like(before), np.array([dt / 2, 1.0]) * part.terms["rate_ramp"]
    return NoiseSource(
        F=system.F,
        noise=system.G @ system.Qd @ system.G.T,
        before=before,
        H=system.H[0],
        R=float(system.R[0, 0]),
        mean=mean,
        flicker_error=system.flicker_error,
    )


def mechanisations(channels: tuple[str, ...], *, earth: Earth) -> list[Mechanisation]:
    """Errors by kind of channel: angles for gyros, velocity and position for accelerometers.

    A gyro perpendicular to a level accelerometer is combined with it. Channels whose names do not end in an axis are
    separate.
    """
    curvature = 1 / EARTH_RADIUS if earth == "round" else 0.0
    chosen, used = [], set()
    for accel in (name for name in channels if name.startswith("accel_")):
        axis = accel.removeprefix("accel_")
        gyro, sign = _ACROSS.get(accel, ("", 0.0))
        velocity, position = f"velocity_{axis}", f"position_{axis}"
        if gyro in channels:
            used.add(gyro)
            a = np.array([[0.0, -sign * curvature, 0.0], [sign * STANDARD_GRAVITY, 0.0, 0.0], [0.0, 1.0, 0.0]])
            chosen.append(
                Mechanisation(
                    rows={_ANGLES[gyro]: 0, velocity: 1, position: 2}, inputs=(gyro, accel), A=a, B=np.eye(3, 2)
                )
            )
        else:
            a = np.array([[0.0, 2 * STANDARD_GRAVITY * curvature if axis == "z" else 0.0], [1.0, 0.0]])
            chosen.append(
                Mechanisation(rows={velocity: 0, position: 1}, inputs=(accel,), A=a, B=np.eye(2, 1), without=gyro)
            )
    for gyro in (name for name in channels if name.startswith("gyro_") and name not in used):
        angle = _ANGLES.get(gyro, "angle_" + gyro.removeprefix("gyro_"))
        chosen.append(Mechanisation(rows={angle: 0}, inputs=(gyro,), A=np.zeros((1, 1)), B=np.eye(1)))
    return chosen


def _widen(matrix: Floats, size: int) -> Floats:
    """Extend a matrix by zeros to the right and below."""
    result = np.zeros((size, size))
    result[: len(matrix), : len(matrix)] = matrix
    return result
