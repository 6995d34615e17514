"""`read_figure`: Allan deviations of a figure, with the errors of reading it."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from os import PathLike
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from sigmatau.arrays import Floats
from sigmatau.errors import DataError, OptionError
from sigmatau.estimators.allan import Curves, DeviationCurve
from sigmatau.hints import Hint
from sigmatau.io.read.curve_table import named_channel, rate_unit
from sigmatau.io.read.figure.lines import FigureLine
from sigmatau.io.read.figure.select import Linear, read_lines

_PER_OCTAVE = 4  # largest number of averaging times; errors of closer points of a line are not independent
_MIN_TIMES = 8  # as of `sigmatau.fitting.components.MIN_TIMES`
_SLOPE_OCTAVES = 1.0  # distance to each side from which the slope of the curve is determined
_SHORTEST = 0.7  # shortest averaging time. [samples]
_READING = 3.0  # largest error of an averaging time at an end of the curve. [standard errors]
_MAX_SAMPLES = 1e15  # of a record. More are a wrong axis, rate or length


def read_figure(
    path: str | PathLike[str],
    *,
    unit: str,
    line: str | int | Mapping[str, str | int] | None = None,
    page: int | None = None,
    x_axis: Mapping[float, float] | None = None,
    y_axis: Mapping[float, float] | None = None,
    linear: Linear | None = None,
    point_error: float | None = None,
    columns: Mapping[str, str] | None = None,
    content: Literal["deviation", "variance"] = "deviation",
    rate: float | None = None,
    duration: float | None = None,
) -> Curves:
    r"""Read Allan deviations from a vector figure (SVG, PDF) or from points that were clicked along a curve.

    Parameters
    ----------
    path : path
        An SVG or PDF file with the curve as a line, or a table of points with two columns, x and y.
    unit : str
        Unit of the rate on the y axis, ``"deg/h"``.
    line : str, int or mapping of str to str or int, optional
        Number from 1 or colour of the line of the figure, or several by channel: ``{"gyro_x": 1, "gyro_y": "#ff0000"}``.
        Default: the only line that can be a curve.
    page : int, optional
        Page of a PDF file from 1. Default: its only page.
    x_axis, y_axis : mapping of float to float, optional
        Values at two or more coordinates of an axis, ``{50: 0.01, 450: 1000}``, with the averaging time in s. The
        coordinates of PDF files are points from the top left. Default: by the tick labels of a vector figure; points
        without axes are values. [coordinate to s, and to `unit`]
    linear : {"x", "y", "xy"}, optional
        Stated axes that are linear. Default: logarithmic.
    point_error : float, optional
        Standard error of a coordinate of a point, also of stated points of the axes. Default: a quarter of the width of
        the line and the resolution of the file; 1 for clicked points. For points that are values it is relative.
    columns : mapping of str to str, optional
        Names, or numbers from 1, of the columns of points: ``{"x": "1", "gyro_x": "2"}``. Default: the only two. In a
        table of more columns a cell may be empty.
    content : {"deviation", "variance"}
        Content of the y axis.
    rate : float, optional
        Sampling rate of the record. Default: one over the shortest averaging time. [Hz]
    duration : float, optional
        Length of the record. Default: the shortest possible one, twice the longest averaging time, so that the errors are
        not too small. [s]

    Returns
    -------
    Curves
        In SI, with `DeviationCurve.digitising`, at up to 4 averaging times per octave. `DeviationCurve.ramp` is NaN: fit
        the curve without the term rate_ramp.

    Raises
    ------
    OptionError
        If the line, the page or an axis is not clear; for an unknown unit, and for numbers out of range.
    DataError
        For a file that cannot be read, that has no curve, or whose curve does not agree with rate and duration.
    ImportError
        If pypdfium2 is needed for a PDF file and is not installed.

    See Also
    --------
    read_curves : the curve of a table.
    fit : coefficients of a curve, with intervals that include the errors of reading.

    Notes
    -----
    The errors of the points are independent. The error of the calibration is common to all points: that of stated points
    is `point_error`, that of tick labels at least the scatter of the ticks about the axis.

    Examples
    --------
    >>> import tempfile
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    >>> curve = st.allan(st.simulate(model, duration=600, rate=10, rng=1))["gyro_x"]
    >>> with tempfile.NamedTemporaryFile("w", suffix=".csv") as file:
    ...     file.writelines(f"{tau},{adev}\n" for tau, adev in zip(curve.tau, curve.adev))
    ...     file.flush()
    ...     read = st.read_figure(file.name, unit="rad/s", point_error=0.02, rate=10, duration=600)["gyro"]
    >>> walk = st.fit(read, terms=["random_walk"])["random_walk"]
    >>> walk.low < 1e-4 < walk.high
    True
    """
    for option, number in (("rate", rate), ("duration", duration), ("point_error", point_error)):
        if number is not None and not (math.isfinite(number) and number > 0):
            raise OptionError(f"{{option}} must be a positive number, not {number!r}", option=option)
    si, factor = rate_unit(unit)
    try:
        lines = read_lines(
            path,
            unit=unit,
            is_variance=content == "variance",
            line=line,
            page=page,
            x_axis=x_axis,
            y_axis=y_axis,
            linear=linear,
            point_error=point_error,
            columns=columns,
        )
        hint = Hint("columns", value={"x": "1", "signal": "2"}) if columns else Hint("line", value={"signal": 1})
        curves = {}
        for each in lines:
            name, quantity = named_channel(each.name, si, hint)
            is_variance = content == "variance"
            curves[name] = _curve(
                each, name, quantity, si, factor, is_variance=is_variance, rate=rate, duration=duration
            )
    except (DataError, OptionError) as error:
        if not error.source:
            error.about(os.fsdecode(path))
        raise
    return Curves(curves)


def _curve(
    line: FigureLine,
    name: str,
    quantity: str,
    unit: str,
    factor: float,
    *,
    is_variance: bool,
    rate: float | None,
    duration: float | None,
) -> DeviationCurve:
    """The curve of a line at whole multiples of the sample interval."""
    tau, value = line.values
    if not (np.all(np.isfinite(tau) & np.isfinite(value)) and tau.min() > 0 and value.min() > 0):
        raise DataError("has a curve with values that are not positive or too large. Check the axes and the line")
    if np.any(np.diff(tau) <= 0):
        raise DataError("has a curve whose averaging times do not rise. Check the x axis")
    log_tau, log_value = np.log(tau), np.log(value)
    # The ends of segments are the values that were drawn; a smooth line with few of them is followed in between.
    ends = np.flatnonzero(line.is_end)
    rate = rate or 1 / float(tau[0])
    longest = rate * max(2 * float(tau[-1]), duration or 0.0)
    if longest > _MAX_SAMPLES:
        raise DataError(f"has a record of {longest:.3g} samples. Correct the x axis, the rate or the length")
    # An averaging time is read with an error: that of one sample may be below it, and that of half the record above it.
    first, last = np.exp(_READING * line.time_errors)
    shortest = min(_SHORTEST, 1 / first)
    sizes = _sizes(tau[ends], rate, shortest)
    if len(sizes) < _MIN_TIMES:
        sizes = _sizes(tau, rate, shortest)
    if duration is not None:
        if 2 * sizes[-1] > last * rate * duration:
            raise DataError(
                f"shows an averaging time of {sizes[-1] / rate:.3g} s, above half of the record. Correct its length"
            )
        sizes = np.unique(np.minimum(sizes, max(round(rate * duration) // 2, 1)))
    if len(sizes) < _MIN_TIMES:
        raise DataError(f"has a curve at {len(sizes)} averaging times. {_MIN_TIMES} or more are needed")
    samples = 2 * int(sizes[-1]) if duration is None else round(rate * duration)
    log_times = np.log(sizes / rate)
    values = _interpolated(log_times, log_tau, log_value)
    slope = _slopes(log_times, log_tau, log_value)
    coordinates = np.stack([_interpolated(log_times, log_tau, column) for column in line.points.T], axis=1)
    if not line.y.is_log:
        # The relative error of a point depends on its value there. Points that are read too high get no more weight.
        coordinates[:, 1] = line.y.place(np.exp(_smoothed(log_times, values)))
    share = 0.5 if is_variance else 1.0  # of the logarithm of the deviation in that of the value
    return DeviationCurve(
        channel=name,
        quantity=quantity,
        unit=unit,
        m=sizes,
        tau=sizes / rate,
        avar=np.exp(2 * share * values) * factor**2,
        n_pairs=samples + 1 - 2 * sizes,
        ramp=np.full(len(sizes), math.nan),
        n=samples,
        tau0=1 / rate,
        digitising=share**2 * line.covariance(coordinates, slope),
    )


def _sizes(tau: Floats, rate: float, shortest: float) -> NDArray[np.int64]:
    """Cluster sizes nearest to averaging times, at most 4 per octave. Raises `DataError` if the rate is too low.

    `shortest`: shortest averaging time. [samples]
    """
    if tau[0] * rate < shortest:
        raise DataError(
            f"shows an averaging time of {tau[0]:.3g} s, below the sample interval {1 / rate:.3g} s. Correct the rate"
        )
    sizes = []
    smallest = 0.0
    for size in np.maximum(np.round(tau * rate), 1.0).tolist():
        if size >= smallest:
            sizes.append(int(size))
            smallest = max(size * 2 ** (0.9 / _PER_OCTAVE), size + 1)
    return np.array(sizes, dtype=np.int64)


def _interpolated(places: Floats, x: Floats, y: Floats) -> Floats:
    """Linear interpolation; beyond the ends, which rounding to whole samples may exceed, the first and last lines go on."""
    k = np.clip(np.searchsorted(x, places), 1, len(x) - 1)
    share = (places - x[k - 1]) / (x[k] - x[k - 1])
    result: Floats = y[k - 1] + share * (y[k] - y[k - 1])
    return result


def _smoothed(places: Floats, y: Floats) -> Floats:
    """Mean of the values up to an octave to each side, the same distance to both."""
    reach = np.minimum(_SLOPE_OCTAVES * math.log(2), np.minimum(places - places[0], places[-1] - places))
    is_close = np.abs(places[:, None] - places) <= reach[:, None] + 1e-9
    result: Floats = is_close @ y / is_close.sum(axis=1)
    return result


def _slopes(places: Floats, x: Floats, y: Floats) -> Floats:
    """Slope of the curve at each place, over an octave to each side."""
    width = _SLOPE_OCTAVES * math.log(2)
    low, high = np.maximum(places - width, x[0]), np.minimum(places + width, x[-1])
    result: Floats = (_interpolated(high, x, y) - _interpolated(low, x, y)) / (high - low)
    return result
