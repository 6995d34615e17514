"""What a forest plot of a comparison draws: values in the unit of the axis."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from sigmatau._native.distributions import normal_quantile
from sigmatau.errors import DataError, OptionError
from sigmatau.lab.lots.comparison_text import COMPARED, display_unit, in_order, term_name
from sigmatau.lab.lots.forest import ForestPanel
from sigmatau.lab.lots.runs import MEAN, SIGNED
from sigmatau.noise.terms import TERMS
from sigmatau.record import stream_name

if TYPE_CHECKING:
    from sigmatau.lab.lots.comparison import RunComparison


def forest_panels(comparison: RunComparison, channels: Sequence[str]) -> list[ForestPanel]:
    """A panel for each channel and term of the first group that at least two runs show; terms of a channel side by side."""
    known_channels = dict.fromkeys(label.channel for label in comparison.table.labels)
    if unknown := [name for name in channels if name not in known_channels]:
        raise OptionError(f"no channel {unknown[0]!r}; channels: {', '.join(known_channels)}", option="channels")
    in_first_group = comparison.cells.group == 0
    rows = in_order(comparison, np.flatnonzero(in_first_group & (comparison.cells.valued > 1)).tolist())
    if channels:
        rows = [row for row in rows if comparison.key(row)[1].channel in channels]
    if not rows:
        what = {"unit": "two runs of a unit", "run": "two units in one run", "axis": "two results of an axis"}
        raise DataError(f"nothing to draw: no term is observed in {what[comparison.by]}")
    # Panels beside each other are the axes of a sensor.
    rows.sort(key=lambda row: _place(comparison, row))
    return [_panel(comparison, row) for row in rows]


def _place(comparison: RunComparison, row: int) -> tuple[bool, str, int]:
    label = comparison.key(row)[1]
    sensor = stream_name(label.channel)
    return sensor != "gyro", sensor, [*TERMS, MEAN].index(label.term)


def _panel(comparison: RunComparison, row: int) -> ForestPanel:
    _, label = comparison.key(row)
    effects = comparison.row(row)
    unit, size = display_unit(label, [effects.mean])
    listed = comparison.values(row)
    value = np.array([number for _, number, _ in listed])
    error = np.array([number for *_, number in listed])
    half = float(normal_quantile((1 + comparison.level) / 2)) * error
    signed = label.term in SIGNED
    low, high = (value - half, value + half) if signed else (value * np.exp(-half), value * np.exp(half))
    outlier = comparison.outliers().get(row)
    names = [run.serial if comparison.by == "run" and run.serial else run.name for run, _, _ in listed]

    def scaled(x: float | None) -> float | None:
        return None if x is None else x / size

    return ForestPanel(
        title=f"{label.channel} {term_name(label)}",
        unit=unit,
        names=names,
        value=value / size,
        low=low / size,
        high=high / size,
        odd=None if outlier is None else next(k for k, (run, _, _) in enumerate(listed) if run is outlier),
        mean=effects.mean / size,
        mean_low=scaled(effects.low),
        mean_high=scaled(effects.high),
        next_low=scaled(effects.next_low),
        next_high=scaled(effects.next_high),
        level=comparison.level,
        compared=COMPARED[comparison.by],
        row=f"{stream_name(label.channel)} {label.term}",
    )
