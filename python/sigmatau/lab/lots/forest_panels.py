"""What a forest plot of a comparison draws: values in the unit of the axis."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from sigmatau._native.distributions import normal_quantile
from sigmatau.errors import DataError, OptionError
from sigmatau.lab.lots.comparison_text import OTHERS, in_order, term_name, unit_of
from sigmatau.lab.lots.forest import ForestPanel
from sigmatau.lab.lots.runs import MEAN, SIGNED
from sigmatau.noise.terms import TERMS
from sigmatau.record import stream_name

if TYPE_CHECKING:
    from sigmatau.lab.lots.comparison import RunComparison


def forest_panels(comparison: RunComparison, channels: Sequence[str]) -> list[ForestPanel]:
    """A panel for each channel and term of the first group that at least two runs show; terms of a channel side by side."""
    known = dict.fromkeys(label.channel for label in comparison.table.labels)
    if unknown := [name for name in channels if name not in known]:
        raise OptionError(f"no channel {unknown[0]!r}; channels: {', '.join(known)}", option="channels")
    own = comparison.cells.group == 0
    rows = in_order(comparison, np.flatnonzero(own & (comparison.cells.seen > 1)).tolist())
    if channels:
        rows = [at for at in rows if comparison.key(at)[1].channel in channels]
    if not rows:
        what = {"unit": "two runs of a unit", "run": "two units in one run", "axis": "two results of an axis"}
        raise DataError(f"nothing to draw: no term is observed in {what[comparison.by]}")
    # Panels beside each other are the axes of a sensor.
    rows.sort(key=lambda at: _place(comparison, at))
    return [_panel(comparison, at) for at in rows]


def _place(comparison: RunComparison, at: int) -> tuple[bool, str, int]:
    label = comparison.key(at)[1]
    sensor = stream_name(label.channel)
    return sensor != "gyro", sensor, [*TERMS, MEAN].index(label.term)


def _panel(comparison: RunComparison, at: int) -> ForestPanel:
    _, label = comparison.key(at)
    found = comparison.row(at)
    unit, size = unit_of(label, [found.mean])
    listed = comparison.values(at)
    value = np.array([one for _, one, _ in listed])
    error = np.array([one for *_, one in listed])
    half = float(normal_quantile((1 + comparison.level) / 2)) * error
    signed = label.term in SIGNED
    low, high = (value - half, value + half) if signed else (value * np.exp(-half), value * np.exp(half))
    outlier = comparison.outliers().get(at)
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
        mean=found.mean / size,
        mean_low=scaled(found.low),
        mean_high=scaled(found.high),
        next_low=scaled(found.next_low),
        next_high=scaled(found.next_high),
        level=comparison.level,
        compared=OTHERS[comparison.by],
        row=f"{stream_name(label.channel)} {label.term}",
    )
