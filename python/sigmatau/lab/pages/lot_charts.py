"""The numbers that the charts of a lot draw: plain values for JSON, short enough for hundreds of units.

Curves are thousandths of a decade from the median of the lot; values have four digits.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from sigmatau.arrays import Floats
from sigmatau.lab.lots.lot_result import Lot, Pooled, pooled
from sigmatau.lab.lots.lot_statistics import Band

_DIGITS = 4
_STEP = 1000  # of a decade


def chart_data(lot: Lot) -> dict[str, Any]:
    """Names of the units, panels of curves by channel, and panels of values over the order of the units by coefficient."""
    names = [unit.name for unit in lot.units]
    number = {name: k for k, name in enumerate(names)}
    return {
        "units": names,
        "curves": [_curves(lot, band, number) for band in lot.bands if len(band.tau)],
        "values": [_values(row, number) for row in pooled(lot)],
    }


def _curves(lot: Lot, band: Band, number: Mapping[str, int]) -> dict[str, Any]:
    panel = lot.curves_of(band)
    rows = {}
    for name, curve in panel.units.items():
        with np.errstate(divide="ignore", invalid="ignore"):
            steps = _STEP * (np.log10(curve) - np.log10(panel.median))
        rows[number[name]] = [None if not math.isfinite(step) else round(step) for step in steps.tolist()]
    return {
        "channel": panel.title,
        "unit": panel.unit,
        "tau": _short(panel.tau),
        "median": _short(panel.median),
        "low": _short(panel.low),
        "high": _short(panel.high),
        "rows": list(rows.values()),
        "of": list(rows),
        "marked": [number[name] for name in lot.marked(band.channel) if name in number],
        "limits": [{"text": f"maximum of {label}", "adev": _short(line)} for label, line in panel.limits],
    }


def _values(row: Pooled, number: Mapping[str, int]) -> dict[str, Any]:
    return {
        "title": row.title,
        "unit": row.unit,
        "limits": _short(row.limits),
        "channels": [
            {
                "name": distribution.channel,
                "at": [number[name] for name in distribution.units],
                "values": _short(distribution.values / row.factor),
                "median": _short([distribution.median / row.factor])[0],
                "outliers": [number[name] for name in distribution.outliers],
                "drift": None if distribution.drift is None else _short([distribution.drift])[0],
            }
            for distribution in row.distributions
        ],
    }


def _short(values: Floats | Sequence[float]) -> list[float]:
    return [float(f"{value:.{_DIGITS}g}") for value in np.asarray(values, dtype=np.float64).tolist()]
