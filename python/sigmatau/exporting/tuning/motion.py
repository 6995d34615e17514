"""Delay and scale error of a filter, from the regression of its innovations on the motion.

A measurement that is late by δ lags the motion by δ·rate. A sensor with a scale error ε leads the motion by ε times the
integral of the rate. The filter treats both as errors of the measurement, and its gain turns them into innovations. Their
sizes are estimated by least squares, weighted at each frequency by the density of the innovations.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from sigmatau._native.distributions import normal_quantile
from sigmatau.arrays import Floats
from sigmatau.digits import round_to_error, two_digits
from sigmatau.exporting.tuning.innovations import Innovations
from sigmatau.exporting.tuning.likelihood import Matrices, Periodogram, invert
from sigmatau.exporting.tuning.run import FilterRun
from sigmatau.frozen import frozen
from sigmatau.results import Printed, plain

_CHANCE = 0.002  # probability of a false effect
_NAMES = {"scale": "scale error", "delay": "delay"}
_GOALS = {"scale": 1e-3, "delay": 1e-3}  # sizes that a calibration can correct, 0.1 % and 1 ms [1, s]
# An effect is not determined below this ratio of its information if the other effects are unknown to that if known.
_DEGENERATE = 1e-10
# largest share of an effect that may come from sensor noise in the rate; above it, the rate contains no motion
_LARGEST_SHIFT = 0.5
_LONG_GAP = 5.0  # longest gap in the rate over which it is interpolated [intervals]
_MAX_GAPS = 30  # number of longer gaps that are modelled, the longest first
_TINY = 1e-300


@frozen
class MotionEffect(Printed):
    """Delay of a measurement, or scale error of the sensor relative to the measurement.

    Attributes
    ----------
    effect : {"scale", "delay"}
        Relative excess of the sensor's rate over the motion, or the delay of the measurement.
    measurement : str
        Name of one of several measurements; empty for one.
    value, low, high : float
        Value and interval, which includes the noise of the sensor in the rate. NaN and ±∞ if the motion does not determine
        it. [1 or s]
    has_error : bool
        Whether it differs from 0, with probability 0.998.
    motion : float
        Standard deviation of the rate. [unit of the innovation per second]
    """

    effect: Literal["scale", "delay"]
    measurement: str
    value: float
    low: float
    high: float
    has_error: bool
    motion: float

    @property
    def resolution(self) -> float:
        """Half width of the interval. [1 or s]"""
        return (self.high - self.low) / 2

    @property
    def is_shown(self) -> bool:
        """Whether the motion determines the effect to within the error that a calibration can correct: 0.1 %, or 1 ms."""
        return self.resolution <= _GOALS[self.effect]

    @property
    def needed(self) -> float:
        """Factor by which the motion must be stronger to determine the effect to 0.1 % or 1 ms. [1]"""
        return self.resolution / _GOALS[self.effect]

    @property
    def name(self) -> str:
        """Name of the effect in tables and sentences."""
        place = f" of {self.measurement}" if self.measurement else ""
        return f"{_NAMES[self.effect]}{place}"

    @property
    def text(self) -> str:
        """Value and interval, with its unit."""
        if not math.isfinite(self.value):
            return "not shown"
        factor, unit = self._unit
        ends = sorted(factor * end for end in (self.low, self.high))
        return f"{round_to_error(factor * self.value, *ends).text} {unit}"

    @property
    def limit(self) -> str:
        """Half width of the interval, with its unit."""
        factor, unit = self._unit
        return f"{two_digits(factor * self.resolution)} {unit}"

    @property
    def _unit(self) -> tuple[float, str]:
        if self.effect == "delay":
            return 1e3, "ms"
        return (1e2, "%") if max(abs(self.low), abs(self.high)) > 2e-3 else (1e6, "ppm")

    def to_dict(self) -> dict[str, object]:
        """Plain values in SI; None for a number that is not shown."""
        return plain(self, "effect measurement value low high has_error motion")


@frozen(eq=False)
class MotionResponses:
    """Whitened innovations due to motion, and to its unknown parts.

    Attributes
    ----------
    effects : ndarray, shape (n, n_measurements, 2·n_measurements)
        Responses to a scale error of 1 and a delay of 1 s of the first measurement, then of the next one. [1, 1/s]
    unknown : ndarray, shape (n, n_measurements, n_unknown)
        Responses to the state at the beginning and to the motion in a gap; orthonormal.
    """

    effects: Floats
    unknown: Floats


def respond_to_motion(data: Innovations, run: FilterRun) -> MotionResponses:
    """Compute the innovations due to a scale error and a delay of each measurement.

    Parameters
    ----------
    data : Innovations
        Innovations with the rate of motion.
    run : FilterRun

    Returns
    -------
    MotionResponses
    """
    rate = np.asarray(data.rate).reshape(len(data.time), -1)
    n, m = rate.shape
    steps = np.diff(data.time)
    travelled = _integrate(data.time, rate)
    slope = travelled[-1] / (data.time[-1] - data.time[0])
    errors = np.zeros((n, m, 2 * m))
    for j in range(m):
        # A constant rate causes a ramp and an offset of the measurement, which the bias absorbs.
        errors[:, j, 2 * j] = -(travelled[:, j] - slope[j] * (data.time - data.time[0]))
        errors[:, j, 2 * j + 1] = -(rate[:, j] - slope[j])
    gaps = np.flatnonzero(steps > _LONG_GAP * data.interval) + 1
    gaps = np.sort(gaps[np.argsort(-steps[gaps - 1])[:_MAX_GAPS]])
    jumps = np.zeros((n, m, m * len(gaps)))
    for k, gap in enumerate(gaps):
        for j in range(m):
            jumps[gap:, j, k * m + j] = 1.0
    states = run.closed.shape[1]
    free = run.respond(np.zeros((n, m, states)), np.eye(states))
    unknown = data.whitened(np.concatenate([free, run.respond(jumps)], axis=2)).reshape(n * m, -1)
    vectors, sizes, _ = np.linalg.svd(unknown / np.maximum(np.abs(unknown).max(axis=0), _TINY), full_matrices=False)
    return MotionResponses(
        effects=data.whitened(run.respond(errors)),
        unknown=vectors[:, sizes > _DEGENERATE * sizes[0]].reshape(n, m, -1),
    )


def _integrate(time: Floats, rate: Floats) -> Floats:
    """Integrate the rate by trapezoids with the first correction of Euler and Maclaurin, to the fourth order."""
    moments, first, places = np.unique(time, return_index=True, return_inverse=True)
    values, steps = rate[first], np.diff(moments)[:, None]
    slopes = np.gradient(values, moments, axis=0)
    turned = steps * (values[1:] + values[:-1]) / 2 - steps**2 * np.diff(slopes, axis=0) / 12
    return np.asarray(np.vstack([np.zeros(values.shape[1]), np.cumsum(turned, axis=0)])[places])


def fit_motion(
    data: Innovations,
    responses: MotionResponses,
    series: Floats,
    periodogram: Periodogram,
    density: Matrices,
    process: Matrices,
    level: float,
) -> tuple[tuple[MotionEffect, ...], Floats]:
    """Estimate scale and delay of each measurement.

    Parameters
    ----------
    data : Innovations
    responses : MotionResponses
    series : ndarray, shape (n, n_measurements)
        Whitened innovations.
    periodogram : Periodogram
        Periodogram with the bins of the densities.
    density : ndarray, shape (n_bins, n_measurements, n_measurements)
        Density of the whitened innovations without the motion.
    process : ndarray, of the same shape
        Part of the density that is noise of the sensor, which the rate may also contain.
    level : float

    Returns
    -------
    effects : tuple of MotionEffect
    explained : ndarray, shape (n, n_measurements)
        Whitened innovations due to the effects.
    """
    columns = np.concatenate([responses.effects, responses.unknown], axis=2)
    n, count = len(series), responses.effects.shape[2]
    last = int(periodogram.number.sum())
    lines = np.fft.rfft(columns, axis=0)[1 : last + 1]
    measured = np.fft.rfft(series, axis=0)[1 : last + 1]
    used = periodogram.is_used[:, :, None] & periodogram.is_used[:, None]
    inverse = np.repeat(np.where(used, invert(density)[0], 0.0), periodogram.number.astype(int), axis=0)
    weighted = lines.conj().swapaxes(1, 2) @ inverse
    information = np.einsum("fjm,fmk->jk", weighted, lines).real
    size = np.sqrt(np.maximum(np.diag(information), _TINY))
    scaled = information / np.outer(size, size)
    shared = scaled[:count, count:]
    beside_unknown = shared @ np.linalg.pinv(scaled[count:, count:], rcond=_DEGENERATE) @ shared.T
    is_shown = float(np.linalg.eigvalsh(scaled[:count, :count] - beside_unknown)[0]) > _DEGENERATE
    values, errors, shifts = np.zeros(len(size)), np.full(count, math.inf), np.zeros(count)
    if is_shown:
        inverted = np.linalg.pinv(scaled, rcond=_DEGENERATE, hermitian=True) / np.outer(size, size)
        values = inverted @ np.einsum("fjm,fm->j", weighted, measured).real
        errors = np.sqrt(n * np.diag(inverted)[:count] / 2)
        shifts = n * inverted[:count, :count] @ _noise_in_rate(data, density, process, periodogram)
        if float(np.abs(shifts[::2]).max()) > _LARGEST_SHIFT:  # the rate contains only noise of the sensor, no motion
            is_shown, values, errors, shifts = False, np.zeros(len(size)), np.full(count, math.inf), np.zeros(count)
    usual, wide = (float(normal_quantile(chance)) for chance in ((1 + level) / 2, 1 - _CHANCE / 2))
    low = values[:count] - np.maximum(shifts, 0.0)
    high = values[:count] - np.minimum(shifts, 0.0)
    deviations = np.asarray(data.rate).reshape(n, -1).std(axis=0)
    kinds: tuple[Literal["scale"], Literal["delay"]] = ("scale", "delay")
    effects = tuple(
        MotionEffect(
            effect=kinds[k % 2],
            measurement=data.measurements[k // 2] if data.measurements else "",
            value=float(values[k]) if is_shown else math.nan,
            low=float(low[k] - usual * errors[k]),
            high=float(high[k] + usual * errors[k]),
            has_error=bool(
                (low[k] - wide * errors[k] > 0 or high[k] + wide * errors[k] < 0)
                and abs(shifts[k]) < _LARGEST_SHIFT * abs(values[k])
            ),
            motion=float(deviations[k // 2]),
        )
        for k in range(count)
    )
    return effects, np.asarray(columns @ values)


def _noise_in_rate(data: Innovations, density: Matrices, process: Matrices, periodogram: Periodogram) -> Floats:
    """Product of response and innovations due to sensor noise in the rate, by effect."""
    m = density.shape[-1]
    inverse, _ = invert(density)
    before = np.exp(-2j * np.pi * periodogram.frequency)
    result = np.empty(2 * m)
    # Weights of the rates at the ends of an interval and next to them, in the integral over the interval.
    integral = (13 + 13 * before - before.conj() - before**2) / 24
    for j in range(m):
        part = (inverse @ process)[:, j, j]
        # The rate is a difference of angles.
        result[2 * j] = float(np.sum(periodogram.number * (integral.conj() * part).real))
        result[2 * j + 1] = float(np.sum(periodogram.number * ((1 - before).conj() * part).real)) / data.interval
    return result
