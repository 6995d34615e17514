"""Lines of a figure in the values of its axes: averaging times, deviations, and the errors of reading them."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from sigmatau.arrays import Floats
from sigmatau.errors import OptionError
from sigmatau.frozen import frozen
from sigmatau.io.read.figure.axis import LN10, Axis, calibrated
from sigmatau.io.read.figure.candidates import Candidate

_WIDTH_ERROR = 0.25  # standard error of a point over the width of the line: 95 % of the points are within the line
# Largest standard error of the logarithm of a value by the stated points of its axis. Measured: beyond, 95 % intervals
# contain the true value in 85 % or less, with points of an axis 10 pixels apart in 3 to 75 %.
_MAX_CALIBRATION = 0.3


@frozen(eq=False)
class FigureLine:
    """A curve of a figure.

    Attributes
    ----------
    name : str
        Stated name of the channel, or empty.
    x, y : Axis
    points : ndarray, shape (n, 2)
        Coordinates, with increasing x.
    is_end : ndarray of bool, shape (n,)
        Whether a point is the end of a segment.
    error : float
        Standard error of a coordinate of a point.
    """

    name: str
    x: Axis
    y: Axis
    points: Floats
    is_end: NDArray[np.bool_]
    error: float

    @property
    def values(self) -> tuple[Floats, Floats]:
        """Values of the points on the two axes."""
        return self.x.read(self.points[:, 0]), self.y.read(self.points[:, 1])

    @property
    def time_errors(self) -> Floats:
        """Standard errors of the logarithms of the first and the last averaging time."""
        ends = self.points[[0, -1], 0]
        single = (self.error * self.x.sensitivity(ends)) ** 2
        return np.sqrt(single + np.diag(self.x.common_error(ends)))

    def covariance(self, coordinates: Floats, slope: Floats) -> Floats:
        """Covariance of the logarithms of the values on the y axis at coordinates of shape (n, 2).

        An error along x counts by the slope of the curve on double logarithmic axes. The errors of the points are
        independent; those of the calibration are common to all points.
        """
        x, y = coordinates.T
        single = (self.error * self.y.sensitivity(y)) ** 2 + (slope * self.error * self.x.sensitivity(x)) ** 2
        common_x, common_y = self.x.common_error(x), self.y.common_error(y)
        result: Floats = np.diag(single) + common_y + slope[:, None] * common_x * slope
        return result


def check_calibration(way: str, axis: Axis, coordinates: Floats, option: str) -> None:
    """Raise `OptionError` if stated points of an axis are too close for the values of a curve at coordinates."""
    ends = np.array([coordinates.min(), coordinates.max()])
    error = math.sqrt(float(np.diag(axis.common_error(ends)).max()))
    if error > _MAX_CALIBRATION:
        raise OptionError(
            f"the points of the {way} axis are too close, or a value is wrong: the curve is read to {100 * error:.2g} %."
            " Give two at the ends of the axis",
            option=option,
        )


def standard_error(candidate: Candidate) -> float:
    """Standard error of a coordinate of a point: a quarter of the width of the line, and the resolution of the file."""
    return math.hypot(_WIDTH_ERROR * candidate.width, candidate.quantum / math.sqrt(12))


def line_of_values(name: str, points: Floats, error: float) -> FigureLine:
    """The line of points that are values already, with a relative standard error.

    The axes were calibrated by points with the same error at the ends of the curve.
    """
    coordinates = np.log10(points)
    axes = []
    for values in coordinates.T:
        ends = [float(values.min()), float(values.max())]
        if ends[0] == ends[1]:
            ends[1] += 1.0
        axes.append(calibrated(ends, [10.0**end for end in ends], is_log=True, error=error / LN10))
    return FigureLine(
        name=name,
        x=axes[0],
        y=axes[1],
        points=coordinates,
        is_end=np.ones(len(points), dtype=np.bool_),
        error=error / LN10,
    )
