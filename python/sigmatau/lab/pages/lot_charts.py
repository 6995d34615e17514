"""The numbers that the charts of a lot draw: plain values for JSON, short enough for hundreds of units.

Curves are thousandths of a decade from the median of the lot; values have four digits.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.lab.lots.lot_result import Lot
from sigmatau.lab.lots.lot_statistics import Band, Distribution
from sigmatau.lab.lots.lot_words import what_text, what_unit
from sigmatau.noise.terms import display_units
from sigmatau.record import stream_name

Floats = NDArray[np.float64]

_DIGITS = 4
_STEP = 1000  # of a decade


def chart_data(lot: Lot) -> dict[str, Any]:
    """Names of the units, panels of curves by channel, and panels of values over the order of the units by coefficient."""
    names = [unit.name for unit in lot.units]
    number = {name: k for k, name in enumerate(names)}
    return {
        "units": names,
        "curves": [_curves(lot, band, number) for band in lot.bands if len(band.tau)],
        "values": _values(lot, number),
    }


def _curves(lot: Lot, band: Band, number: Mapping[str, int]) -> dict[str, Any]:
    text, factor = display_units("bias_instability", band.quantity, band.unit, band.median.tolist())[-1]
    middle = np.log10(band.median)
    rows = {}
    for name, curve in band.curves.items():
        with np.errstate(divide="ignore", invalid="ignore"):
            steps = _STEP * (np.log10(curve) - middle)
        rows[number[name]] = [None if not math.isfinite(step) else round(step) for step in steps.tolist()]
    return {
        "channel": band.channel,
        "unit": text,
        "tau": _short(band.tau),
        "median": _short(band.median / factor),
        "low": _short(band.low / factor),
        "high": _short(band.high / factor),
        "rows": list(rows.values()),
        "of": list(rows),
        "marked": [number[name] for name in lot.marked(band.channel) if name in number],
        "limits": [
            {"text": f"maximum of {label}", "adev": _short(line / factor)}
            for label, line in lot.limit_lines(band.channel, band.tau)
        ],
    }


def _values(lot: Lot, number: Mapping[str, int]) -> list[dict[str, Any]]:
    groups: dict[tuple[str, str], list[Distribution]] = {}
    for distribution in lot.distributions:
        groups.setdefault((stream_name(distribution.channel), distribution.what), []).append(distribution)
    panels = []
    for (sensor, what), those in groups.items():
        quantity, unit = lot.quantity_of(those[0].channel)
        text, factor = what_unit(what, quantity, unit, [group.median for group in those])
        limits = sorted({limit / factor for distribution in those for limit in lot.limits(distribution.channel, what)})
        panels.append(
            {
                "title": f"{sensor}: {what_text(what, quantity)}",
                "unit": text,
                "limits": _short(limits),
                "channels": [
                    {
                        "name": distribution.channel,
                        "at": [number[name] for name in distribution.units],
                        "values": _short(distribution.values / factor),
                        "median": _short([distribution.median / factor])[0],
                        "outliers": [number[name] for name in distribution.outliers],
                        "drift": None if distribution.drift is None else _short([distribution.drift])[0],
                    }
                    for distribution in those
                ],
            }
        )
    return panels


def _short(values: Floats | Sequence[float]) -> list[float]:
    return [float(f"{value:.{_DIGITS}g}") for value in np.asarray(values, dtype=np.float64).tolist()]
