"""`read_curves`: Allan deviations that another program computed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from os import PathLike
from typing import Literal

import numpy as np

from sigmatau.errors import OptionError
from sigmatau.estimators.allan import Curves, DeviationCurve
from sigmatau.io.read.curve_table import read_curve_table


def read_curves(
    path: str | PathLike[str],
    *,
    rate: float,
    duration: float,
    columns: Mapping[str, str] | None = None,
    unit: str | None = None,
    content: Literal["deviation", "variance"] | None = None,
) -> Curves:
    r"""Read overlapped Allan deviations or variances from a table that another program wrote.

    Parameters
    ----------
    path : path
        A table of any supported format: averaging times, and a column for each channel.
    rate : float
        Sampling rate of the record. [Hz]
    duration : float
        Length of the record; it determines the errors of the curve. [s]
    columns : mapping of str to str, optional
        Names, or numbers from 1, of the columns of the averaging times and of the channels:
        ``{"tau": "1", "gyro_x": "6"}``. Default: by their names; a single other column is a gyro or an accelerometer by its
        unit.
    unit : str, optional
        Unit of the rate, ``"deg/h"``. Default: that of the header.
    content : {"deviation", "variance"}, optional
        Default: as the header states.

    Returns
    -------
    Curves
        In SI. `DeviationCurve.ramp` is NaN, because a deviation has no sign: fit the curve without the term rate_ramp.

    Raises
    ------
    OptionError
        If columns, unit or content are not stated or contradict the header; for a rate or a duration that is not positive.
    DataError
        For a file that cannot be read, or values that a curve of this record cannot have.

    See Also
    --------
    fit : coefficients of a curve, with intervals.
    read_off : the coefficients by the slopes of the curve.

    Examples
    --------
    >>> import tempfile
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    >>> curve = st.allan(st.simulate(model, duration=600, rate=10, rng=1))["gyro_x"]
    >>> with tempfile.NamedTemporaryFile("w", suffix=".csv") as file:
    ...     rows = (f"{tau},{adev}\n" for tau, adev in zip(curve.tau, curve.adev))
    ...     _ = file.write("tau [s],gyro_x adev [rad/s]\n" + "".join(rows))
    ...     file.flush()
    ...     again = st.read_curves(file.name, rate=10, duration=600)["gyro_x"]
    >>> bool(abs(again.adev / curve.adev - 1).max() < 1e-12)
    True
    """
    for option, number in (("rate", rate), ("duration", duration)):
        if not (math.isfinite(number) and number > 0):
            raise OptionError(f"{{option}} must be a positive number, not {number!r}", option=option)
    samples = round(rate * duration)
    sizes, curves = read_curve_table(path, rate=rate, samples=samples, columns=columns, unit=unit, content=content)
    return Curves(
        {
            name: DeviationCurve(
                channel=name,
                quantity=curve.quantity,
                unit=curve.unit,
                m=sizes,
                tau=sizes / rate,
                avar=curve.avar,
                n_pairs=samples + 1 - 2 * sizes,
                ramp=np.full(len(sizes), math.nan),
                n=samples,
                tau0=1 / rate,
            )
            for name, curve in curves.items()
        }
    )
