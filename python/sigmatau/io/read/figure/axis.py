"""An axis of a figure: values from coordinates, with the error of the calibration."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from sigmatau.arrays import Floats
from sigmatau.errors import OptionError
from sigmatau.frozen import frozen
from sigmatau.hints import Hint

LN10 = math.log(10)


@frozen(eq=False)
class Axis:
    """The calibration of an axis: value = offset + slope·coordinate, of its decimal logarithm on a logarithmic axis.

    Attributes
    ----------
    is_log : bool
    center : float
        Mean coordinate of the points of the calibration; `offset` is the value there.
    offset, slope : float
    covariance : ndarray, shape (2, 2)
        Covariance of the errors of `offset` and `slope`.
    residual : float
        Root mean square of the residuals. [coordinates]
    values : tuple of float
        Values of the points of the calibration.
    """

    is_log: bool
    center: float
    offset: float
    slope: float
    covariance: Floats
    residual: float
    values: tuple[float, ...]

    def read(self, coordinate: Floats) -> Floats:
        """The values at coordinates."""
        value = self.offset + self.slope * (coordinate - self.center)
        with np.errstate(over="ignore"):  # infinite values are refused where they matter
            return np.power(10.0, value) if self.is_log else value

    def place(self, value: Floats) -> Floats:
        """The coordinates of values."""
        return self.center + ((np.log10(value) if self.is_log else value) - self.offset) / self.slope

    def sensitivity(self, coordinate: Floats) -> Floats:
        """Derivative of the logarithm of the value with respect to the coordinate."""
        return np.full(len(coordinate), LN10 * self.slope) if self.is_log else self.slope / self.read(coordinate)

    def common_error(self, coordinate: Floats) -> Floats:
        """Covariance of the logarithms of the values that the error of the calibration causes, shape (n, n)."""
        gradient = np.stack([np.ones(len(coordinate)), coordinate - self.center], axis=1)
        gradient *= LN10 if self.is_log else 1 / self.read(coordinate)[:, None]
        return gradient @ self.covariance @ gradient.T


def calibrated(coordinates: Sequence[float], values: Sequence[float], *, is_log: bool, error: float) -> Axis:
    """The axis through points by least squares.

    `error`: smallest standard error of a coordinate of a point; that of three or more points is at least the scatter of
    the residuals.
    """
    place = np.array(coordinates, dtype=np.float64)
    value = np.log10(np.array(values)) if is_log else np.array(values, dtype=np.float64)
    center = float(place.mean())
    spread = place - center
    slope = float(spread @ value / (spread @ spread))
    offset = float(value.mean())
    squares = float(np.sum(((value - offset - slope * spread) / slope) ** 2)) if slope else math.inf
    count = len(place)
    scatter = math.sqrt(squares / (count - 2)) if count > 2 else 0.0
    variance = (slope * max(error, scatter)) ** 2
    return Axis(
        is_log=is_log,
        center=center,
        offset=offset,
        slope=slope,
        covariance=np.diag([variance / count, variance / float(spread @ spread)]),
        residual=math.sqrt(squares / count),
        values=tuple(float(v) for v in values),
    )


def stated_axis(points: Mapping[float, float], option: str, *, is_log: bool, error: float) -> Axis:
    """The axis of two or more stated points: values by coordinate."""
    places = sorted(points)
    values = [points[place] for place in places]
    if len(places) < 2 or not all(map(math.isfinite, [*places, *values])):
        raise OptionError("{option} needs two points, COORDINATE=VALUE. Give two at its ends", option=option)
    if is_log and min(values) <= 0:
        raise OptionError(
            f"{{option}}: a logarithmic axis has no value {min(values):g}. Correct it, or give {Hint('linear')}",
            option=option,
        )
    steps = np.diff(values)
    if not (np.all(steps > 0) or np.all(steps < 0)):
        raise OptionError("{option}: the values neither rise nor fall along the axis. Correct a point", option=option)
    return calibrated(places, values, is_log=is_log, error=error)
