"""Units at several temperatures: a matrix of coefficients."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from sigmatau import Analysis
from sigmatau.digits import limit_text, round_to_error, significant
from sigmatau.errors import DataError
from sigmatau.frozen import frozen
from sigmatau.lab.lots.comparison_text import usual_unit
from sigmatau.lab.lots.conditions import TEMPERATURE
from sigmatau.lab.lots.reading import natural_order
from sigmatau.lab.temperature.result import TERMS
from sigmatau.record import stream_name
from sigmatau.results import Tabular, aligned, lines_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from sigmatau.plot.style import Panels

MEAN = "mean"


@frozen
class MatrixCell:
    """A coefficient of a channel of a unit at a temperature.

    Attributes
    ----------
    unit : str
        Serial number.
    temperature : float
        Middle of the group of temperatures to which the run belongs. [°C]
    channel, quantity, rate_unit : str
    term : str
        Coefficient, or ``"mean"``.
    value, low, high, limit : float or None
        Value with its interval, or upper limit. [SI]
    """

    unit: str
    temperature: float
    channel: str
    quantity: str
    rate_unit: str
    term: str
    value: float | None
    low: float | None
    high: float | None
    limit: float | None


@frozen
class MatrixTable:
    """A coefficient of a sensor by unit and temperature: the largest value of its axes.

    Attributes
    ----------
    sensor, term, unit : str
        Sensor, coefficient, and unit of the cells.
    rows : tuple of (str, tuple of str)
        Name of a unit, and a cell for each temperature.
    values : ndarray, shape (n_units, n_temperatures)
        NaN without a value. [unit]
    """

    sensor: str
    term: str
    unit: str
    rows: tuple[tuple[str, tuple[str, ...]], ...]
    values: Any

    @property
    def title(self) -> str:
        """Sensor and coefficient in words."""
        words = "mean" if self.term == MEAN else self.term.replace("_", " ")
        return f"{self.sensor} {words}"


@frozen(eq=False)
class TemperatureMatrix(Tabular):
    """Coefficients by unit and temperature.

    Attributes
    ----------
    cells : tuple of MatrixCell
    units : tuple of str
        Names of the units in natural order.
    temperatures : tuple of float
        Temperatures in ascending order. [°C]

    See Also
    --------
    temperature_matrix : makes it.

    Examples
    --------
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    >>> logs = [("SN1", t, st.simulate(model, duration=600, rate=10, rng=int(t))) for t in (0.0, 25.0)]
    >>> table = next(st.temperature_matrix([(name, t, st.analyze(log)) for name, t, log in logs]).tables())
    >>> table.title, table.unit
    ('gyro random walk', 'deg/√h')
    """

    cells: tuple[MatrixCell, ...]
    units: tuple[str, ...]
    temperatures: tuple[float, ...]

    def tables(self) -> Iterator[MatrixTable]:
        """A table for each sensor and coefficient that has a value."""
        kinds = dict.fromkeys((stream_name(cell.channel), cell.term) for cell in self.cells)
        for sensor, term in sorted(kinds, key=lambda kind: (kind[0] != "gyro", kind[0], (*TERMS, MEAN).index(kind[1]))):
            cells = [cell for cell in self.cells if stream_name(cell.channel) == sensor and cell.term == term]
            sizes = [abs(cell.value) for cell in cells if cell.value is not None]
            if not sizes:
                continue
            kind = "bias_instability" if term == MEAN else term
            unit, size = usual_unit(kind, cells[0].quantity, cells[0].rate_unit, sizes)
            rows, values = [], np.full((len(self.units), len(self.temperatures)), np.nan)
            for i, name in enumerate(self.units):
                texts = []
                for j, temperature in enumerate(self.temperatures):
                    axis_cells = [cell for cell in cells if cell.unit == name and cell.temperature == temperature]
                    text, values[i, j] = _largest(axis_cells, size)
                    texts.append(text)
                rows.append((name, tuple(texts)))
            yield MatrixTable(sensor=sensor, term=term, unit=unit, rows=tuple(rows), values=values)

    def plot(self, ax: Panels = None) -> Figure:
        """Draw each coefficient against temperature: a line for each unit, and a thick line for the median.

        Parameters
        ----------
        ax : sequence of matplotlib axes, optional
            One for each table. Default: a new figure.

        Returns
        -------
        matplotlib figure
        """
        from sigmatau.lab.temperature.matrix_figures import draw_matrix

        return draw_matrix(self, ax=ax)

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI."""
        return {"units": list(self.units), "temperatures_degc": list(self.temperatures), "cells": self.columns()}

    def columns(self) -> dict[str, list[Any]]:
        """One row for each unit, temperature, channel and coefficient in SI, see `Tabular.columns`."""
        names = {"unit": "unit", "temperature_degc": "temperature", "channel": "channel", "term": "term"}
        names |= {"value": "value", "low": "low", "high": "high", "upper_limit": "limit"}
        return {key: [getattr(cell, name) for cell in self.cells] for key, name in names.items()}

    def __repr__(self) -> str:
        units = f"{len(self.units)} unit{'s' if len(self.units) > 1 else ''}"
        lines = [f"{units} at {', '.join(f'{t:.3g}' for t in self.temperatures)} °C, the largest of the axes"]
        for table in self.tables():
            heads = [f"{table.title} [{table.unit}]", *(f"{t:.3g} °C" for t in self.temperatures)]
            lines += ["", *aligned([heads, *([name, *texts] for name, texts in table.rows)])]
        return lines_text(lines)


def _largest(cells: Sequence[MatrixCell], size: float) -> tuple[str, float]:
    """The largest value of the axes with its interval, or the largest limit, as text and number."""
    valued = [cell for cell in cells if cell.value is not None]
    if valued:
        cell = max(valued, key=lambda cell: abs(cell.value or 0.0))
        value = cell.value or 0.0
        if cell.low is None or cell.high is None:
            return significant(value / size, zeros=True), value / size
        return round_to_error(value, cell.low, cell.high, size=size).text, value / size
    limits = [cell.limit for cell in cells if cell.limit is not None]
    return (limit_text(max(limits) / size), float("nan")) if limits else ("–", float("nan"))


def temperature_matrix(results: Sequence[tuple[str, float, Analysis]]) -> TemperatureMatrix:
    """Coefficients of several units at several temperatures.

    Parameters
    ----------
    results : sequence of (str, float, Analysis)
        Serial number, temperature [°C], and result of each run. If a unit has several runs at a temperature, the last one
        is used.

    Returns
    -------
    TemperatureMatrix

    Raises
    ------
    DataError
        If no result has a fit.

    See Also
    --------
    calibrate_over_runs : fits the polynomial of one unit.

    Examples
    --------
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    >>> logs = [(f"SN{k}", t, st.simulate(model, duration=600, rate=10, rng=k)) for k in (1, 2) for t in (-40.0, 25.0)]
    >>> matrix = st.temperature_matrix([(name, t, st.analyze(log)) for name, t, log in logs])
    >>> matrix.units, matrix.temperatures
    (('SN1', 'SN2'), (-40.0, 25.0))
    """
    groups = TEMPERATURE.middles([temperature for _, temperature, _ in results])
    latest: dict[tuple[str, float], Analysis] = {}
    for (unit, _, result), group in zip(results, groups, strict=True):
        latest[unit, group] = result
    cells: list[MatrixCell] = []
    for (unit, group), result in latest.items():
        for channel, fitted in result.fits.items():
            keys: Mapping[str, Any] = {
                "unit": unit,
                "temperature": group,
                "channel": channel,
                "quantity": fitted.quantity,
                "rate_unit": fitted.rate_unit,
            }
            for name in TERMS:
                if name in fitted:
                    term = fitted[name]
                    cells.append(
                        MatrixCell(
                            **keys, term=name, value=term.value, low=term.low, high=term.high, limit=term.upper_limit
                        )
                    )
            if channel in result.means:
                mean = result.means[channel].value
                cells.append(MatrixCell(**keys, term=MEAN, value=mean, low=None, high=None, limit=None))
    if not cells:
        raise DataError("no result has a fit. Analyse logs of sensors at rest")
    return TemperatureMatrix(
        cells=tuple(cells),
        units=tuple(sorted({unit for unit, _ in latest}, key=natural_order)),
        temperatures=tuple(sorted({group for _, group in latest})),
    )
