"""Simulated filters of an angle or a velocity and a bias, for the study of `tune`: several measurements, and motion."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Setting:
    """A true sensor with its aiding, in SI, and the length of a run in seconds."""

    noise: float
    walk: float
    deviation: float
    interval: float
    duration: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Aiding:
    """Measurements of a filter of the consumer gyro: their schedule, and their deviations over √R."""

    deviations: tuple[float, ...]
    kind: str  # "together", "in turn", "adaptive", "dropouts"


AIDINGS: Mapping[str, Aiding] = {
    "Two measurements at once": Aiding(deviations=(1.0, 2.0), kind="together"),
    "Two sensors at times of their own": Aiding(deviations=(1.0, 0.5), kind="in turn"),
    "R that the filter adapts": Aiding(deviations=(1.0,), kind="adaptive"),
    "Dropouts": Aiding(deviations=(1.0,), kind="dropouts"),
}
AIDED = Setting(noise=1e-4, walk=1e-5, deviation=1e-4, interval=0.2, duration=1200.0)


def schedule(aiding: Aiding, duration: float, rng: np.random.Generator) -> tuple[Floats, Floats]:
    """Times, and the deviation of each measurement, shape (n, n_measurements); NaN where it is absent."""
    n = round(duration * 10 / 9 / AIDED.interval)
    time = AIDED.interval * np.arange(n, dtype=np.float64)
    deviations = AIDED.deviation * np.tile(aiding.deviations, (n, 1))
    if aiding.kind == "in turn":  # the second sensor measures once a second, between two measurements of the first
        late = time[2::5] + 0.37 * AIDED.interval
        time = np.concatenate([time, late])
        order = np.argsort(time)
        first = (order < n)[:, None]
        deviations = np.tile(AIDED.deviation * np.array(aiding.deviations), (len(time), 1))
        deviations[np.hstack([~first, first])] = np.nan
        time = time[order]
    elif aiding.kind == "adaptive":  # slowly varying deviations, 1 to 4 times as large, and peaks of 3 times
        deviations = deviations * (2.5 + 1.5 * np.sin(2 * np.pi * time / 300.0))[:, None]
        deviations[(time % 47.0) < 5.0] *= 3
    elif aiding.kind == "dropouts":  # one of three measurements is lost, and all during 10 s in every 2 min
        received = (rng.uniform(size=n) > 1 / 3) & (time % 120.0 > 10.0)
        time, deviations = time[received], deviations[received]
    return time, deviations


def aided_innovations(
    aiding: Aiding, factors: Floats, runs: int, rng: np.random.Generator, *, duration: float = AIDED.duration
) -> tuple[Floats, Floats, Floats]:
    """Times, innovations (runs, n, n_measurements) and S of filters with each √R, N and K multiplied by factors."""
    time, true = schedule(aiding, duration, rng)
    assumed = true * factors[:-2]
    noise, walk = factors[-2] * AIDED.noise, factors[-1] * AIDED.walk
    n, m = true.shape
    covariance = np.diag([(10 * AIDED.deviation) ** 2, (100 * walk) ** 2])
    error = np.linalg.cholesky(covariance) @ rng.standard_normal((2, runs))
    values, stated = np.full((runs, n, m), np.nan), np.full((n, m, m), np.nan)
    for k in range(n):
        used = np.flatnonzero(np.isfinite(true[k]))
        rows = np.tile([1.0, 0.0], (len(used), 1))
        total = rows @ covariance @ rows.T + np.diag(assumed[k, used] ** 2)
        innovation = rows @ error + true[k, used][:, None] * rng.standard_normal((len(used), runs))
        values[:, k, used], stated[k][np.ix_(used, used)] = innovation.T, total
        gain = np.linalg.solve(total, rows @ covariance).T
        dt = time[k + 1] - time[k] if k + 1 < n else AIDED.interval
        transition = np.array([[1.0, dt], [0.0, 1.0]])
        shape = np.array([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]])
        error = transition @ (error - gain @ innovation)
        error += AIDED.walk * np.linalg.cholesky(shape) @ rng.standard_normal((2, runs))
        error[0] += AIDED.noise * math.sqrt(dt) * rng.standard_normal(runs)
        covariance = transition @ (covariance - gain @ rows @ covariance) @ transition.T
        covariance += np.diag([noise**2 * dt, 0.0]) + walk**2 * shape
    converged = time >= duration / 9
    return time[converged], values[:, converged], stated[converged]


MOTIONS: Mapping[
    str, tuple[float, float, bool]
] = {  # scale error, delay in s, and whether the rate is that of the sensor
    "nothing": (0.0, 0.0, False),
    "nothing, the sensor's own rate": (0.0, 0.0, True),
    "scale 0.2 %": (2e-3, 0.0, False),
    "scale -0.2 %": (-2e-3, 0.0, True),
    "delay 2 ms": (0.0, 2e-3, False),
    "delay -2 ms": (0.0, -2e-3, True),
    "scale 0.2 %, delay 2 ms": (2e-3, 2e-3, True),
}
TURNS = ((0.3, 7.3), (0.2, 19.0))  # amplitudes in rad/s and periods in s of the motion


def moving_innovations(
    scale: float,
    delay: float,
    factors: Floats,
    runs: int,
    rng: np.random.Generator,
    *,
    of_sensor: bool,
    duration: float = AIDED.duration,
) -> tuple[Floats, Floats, Floats, Floats]:
    """Times, innovations (runs, n), S, and the rate (runs, n) of a filter with √R, N and K multiplied by factors."""
    n, dt = round(duration * 10 / 9 / AIDED.interval), AIDED.interval
    time = dt * np.arange(n, dtype=np.float64)
    phases = rng.uniform(0, 2 * np.pi, (len(TURNS), runs))
    angle: Floats = np.zeros((n, runs))
    rate: Floats = np.zeros((n, runs))
    for (amplitude, period), phase in zip(TURNS, phases, strict=True):
        turn = 2 * np.pi * time[:, None] / period + phase
        angle -= amplitude * period / (2 * np.pi) * np.cos(turn)
        rate += amplitude * np.sin(turn)
    r, noise, walk = factors * np.array([AIDED.deviation, AIDED.noise, AIDED.walk])
    covariance = np.diag([(10 * r) ** 2, (100 * walk) ** 2])
    transition = np.array([[1.0, dt], [0.0, 1.0]])
    shape = np.array([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]])
    added = np.diag([noise**2 * dt, 0.0]) + walk**2 * shape
    root = AIDED.walk * np.linalg.cholesky(shape)
    error = np.linalg.cholesky(covariance) @ rng.standard_normal((2, runs))
    values, stated, measured = np.empty((n, runs)), np.empty(n), rate.copy()
    for k in range(n):
        total = covariance[0, 0] + r**2
        # A late measurement is the angle of an earlier time.
        innovation = error[0] + AIDED.deviation * rng.standard_normal(runs) - delay * rate[k]
        values[k], stated[k] = innovation, total
        gain = covariance[:, 0] / total
        error = transition @ (error - gain[:, None] * innovation) + root @ rng.standard_normal((2, runs))
        white = AIDED.noise * math.sqrt(dt) * rng.standard_normal(runs)
        error[0] += white
        if k + 1 < n:
            error[0] -= scale * (angle[k + 1] - angle[k])
            if of_sensor:  # its noise is in the error of the filter, with the other sign
                measured[k + 1] -= white / dt
        covariance = transition @ (covariance - np.outer(gain, covariance[0])) @ transition.T + added
    converged = time >= duration / 9
    return time[converged], values[converged].T, stated[converged], measured[converged].T
