"""Mean temperature of the blocks of a sensor, after removal of the resolution steps and the noise of the thermometer.

Errors of the thermometer make the coefficient per kelvin too small, and temperature changes that it does not show look
like a rate random walk of the sensor (errors in variables). The temperature of a coarse thermometer is therefore
evaluated at its changes, where it is halfway between two values. Noise is removed by least squares with a penalty on
curvature, chosen by generalised cross-validation.

References
----------
D. Garcia, "Robust smoothing of gridded data in one and higher dimensions with missing values", Comput. Stat. Data Anal. 54
(2010), :doi:`10.1016/j.csda.2009.09.020`.
"""

from __future__ import annotations

import numpy as np

from sigmatau.arrays import Floats
from sigmatau.record.streams import Stream

_OVERSAMPLED = 4  # points of interpolation in a block
_MAX_CHANGES = 0.25  # largest share of samples that change; above it, noise averages the steps out
_REVERSAL_SHARE = 0.01  # changes back and forth within this share of the record count as one change
_MAX_LEVELS = 256  # largest number of distinct values of a coarse thermometer
_SMOOTHED_BLOCKS = 2.0 ** np.arange(0, 9.01, 0.5)  # lengths of smoothing that are tried [blocks]


def mean_temperatures(edges: Floats, thermometer: Stream) -> Floats:
    """Mean temperature of each block; NaN outside the times of the thermometer."""
    columns = [thermometer.column(channel) for channel in thermometer.channels]
    columns = [column for column in columns if np.isfinite(column).sum() > 1]
    if not columns:
        return np.full(len(edges) - 1, np.nan)
    column = max(columns, key=lambda values: float(np.nanmax(values) - np.nanmin(values)))
    finite = np.isfinite(column)
    tau0 = thermometer.grid.tau0
    middle = thermometer.grid.start + (np.arange(thermometer.grid.n) + 0.5) * tau0
    time = np.asarray(middle[finite], dtype=np.float64)
    values = between_steps(time, np.asarray(column[finite], dtype=np.float64))
    step = float(edges[1] - edges[0])
    # One missing sample would make all later values of the integral missing.
    if step > 2 * tau0 and finite.all():
        integral = np.concatenate([[0.0], np.cumsum(values)]) * tau0
        borders = np.concatenate([time - tau0 / 2, [time[-1] + tau0 / 2]])
        means = np.diff(np.interp(edges, borders, integral)) / step
    else:
        means = _interpolated(edges, time, values)
    reach = max(tau0, step)
    outside = (edges[1:] > time[-1] + reach) | (edges[:-1] < time[0] - reach)
    inside = ~outside
    if step >= tau0 and inside.sum() > 2:  # a slower thermometer has one sample for several blocks
        means[inside] = smoothed(means[inside])
    return np.asarray(np.where(outside, np.nan, means))


def between_steps(time: Floats, values: Floats) -> Floats:
    """Interpolate the temperatures of a coarse thermometer between its changes of value, at the same times [s]; shape (n,).

    Returns the values unchanged if the steps are small, or if noise averages them out.
    """
    changes = np.flatnonzero(np.diff(values))
    if len(changes) < 2 or len(changes) > _MAX_CHANGES * len(values) or len(np.unique(values)) > _MAX_LEVELS:
        return values
    steps = (time[changes] + time[changes + 1]) / 2
    mid = (values[changes] + values[changes + 1]) / 2
    # Noise makes the value change back and forth several times. They count as one change at their mean time.
    begins = np.flatnonzero(np.diff(steps, prepend=-np.inf) > (time[-1] - time[0]) * _REVERSAL_SHARE)
    begins = np.union1d(begins, np.flatnonzero(np.diff(mid, prepend=np.inf)))
    counts = np.diff(np.append(begins, len(steps)))
    odd = counts % 2 == 1  # an even number of changes restores the value: noise only
    steps, mid = (np.add.reduceat(steps, begins) / counts)[odd], mid[begins][odd]
    after = values[changes[begins + counts - 1] + 1][odd]
    if len(steps) < 2:
        return values
    slope = np.diff(mid) / np.diff(steps)
    # Before the first change and after the last, the temperature is extrapolated within half a step.
    half = np.abs(np.diff(values))[changes[[0, -1]]] / 2
    first = values[0] + np.clip(mid[0] - slope[0] * (steps[0] - time[0]) - values[0], -half[0], half[0])
    last = values[-1] + np.clip(mid[-1] + slope[-1] * (time[-1] - steps[-1]) - values[-1], -half[1], half[1])
    # At an extremum the same change occurs twice. It is interpolated by a parabola with the slope of the previous interval.
    turns = np.flatnonzero((slope == 0) & (np.diff(steps) > 0))
    turns = turns[turns > 0]
    length = steps[turns + 1] - steps[turns]
    height = slope[turns - 1] * length / 4
    largest = 2 * np.abs(after[turns] - mid[turns])
    height = np.clip(height, -largest, largest)
    parts = np.array([0.25, 0.5, 0.75])
    added = (steps[turns][:, None] + length[:, None] * parts).ravel()
    parabola = (mid[turns][:, None] + height[:, None] * (4 * parts * (1 - parts))).ravel()
    points = np.concatenate(([time[0]], steps, added, [time[-1]]))
    levels = np.concatenate(([first], mid, parabola, [last]))
    order = np.argsort(points, kind="stable")
    return np.asarray(np.interp(time, points[order], levels[order]))


def smoothed(levels: Floats) -> Floats:
    """Block means smoothed as much as generalised cross-validation allows; shape (n_blocks,)."""
    from scipy.fft import dct, idct

    n = len(levels)
    k = np.arange(n)
    # remove the line, because the cosines have no slope at the ends
    line = levels[0] + (levels[-1] - levels[0]) * k / (n - 1)
    modes = dct(levels - line, norm="ortho")
    penalty = (2 - 2 * np.cos(np.pi * k / n)) ** 2
    best, lowest = levels, np.inf
    for length in (0.1, *_SMOOTHED_BLOCKS):
        gain = 1 / (1 + length**4 * penalty)
        removed = 1 - gain
        score = float(np.sum((removed * modes) ** 2)) / float(removed.mean()) ** 2
        if score < lowest:
            best, lowest = np.asarray(line + idct(gain * modes, norm="ortho")), score
    return best


def _interpolated(edges: Floats, time: Floats, values: Floats) -> Floats:
    inside = (np.arange(_OVERSAMPLED) + 0.5) / _OVERSAMPLED
    points = edges[:-1, None] + np.diff(edges)[:, None] * inside
    return np.asarray(np.interp(points, time, values).mean(axis=1))
