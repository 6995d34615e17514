"""Allan deviation of normalised innovations, and of the white noise that they are in a consistent filter."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Protocol

import numpy as np

from sigmatau.arrays import Floats
from sigmatau.plot.curves import COLOURS, MARKERS
from sigmatau.plot.style import check_panels, legend, new_figure, parent_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


class WhitenessLike(Protocol):
    """Attributes of `sigmatau.exporting.tuning.result.Whiteness` that are drawn."""

    @property
    def m(self) -> Floats: ...
    @property
    def tau(self) -> Floats: ...
    @property
    def ratio(self) -> Floats: ...
    @property
    def low(self) -> Floats: ...
    @property
    def high(self) -> Floats: ...


class TuningLike(Protocol):
    """Attributes of `sigmatau.exporting.tuning.result.Tuning` that are drawn."""

    @property
    def whiteness(self) -> WhitenessLike: ...
    @property
    def level(self) -> float: ...


def draw_whiteness(tunings: Mapping[str, TuningLike], *, ax: Axes | None = None) -> Figure:
    """Draw the curve of each channel with its interval, and 1/√m with the band in which white noise is."""
    (panel,) = check_panels(ax, 1) or [new_figure(6.4, 4.6).subplots()]
    widest = max((tuning.whiteness for tuning in tunings.values()), key=lambda curve: float(curve.m[-1]))
    level = next(iter(tunings.values())).level
    white = 1 / np.sqrt(widest.m)
    # Of white noise the deviation lies between these multiples of its expectation.
    band = (white * widest.ratio / widest.high, white * widest.ratio / widest.low)
    panel.fill_between(
        widest.tau, *band, color="0.5", alpha=0.2, linewidth=0, label=f"consistent filter, {100 * level:g} %"
    )
    panel.plot(widest.tau, white, color="0.4", linestyle="--", linewidth=1.0, label="consistent filter: 1/√m")
    for k, (name, tuning) in enumerate(tunings.items()):
        curve = tuning.whiteness
        expected = 1 / np.sqrt(curve.m)
        colour = COLOURS[k % len(COLOURS)]
        panel.plot(
            curve.tau, expected * curve.ratio, color=colour, marker=MARKERS[k % len(MARKERS)], markersize=4, linewidth=1.2,
            label=name,
        )  # fmt: skip
    panel.set_xscale("log")
    panel.set_yscale("log")
    panel.set_xlabel("averaging time τ [s]")
    panel.set_ylabel("Allan deviation of normalised innovations [1]")
    panel.grid(visible=True, which="major", linewidth=0.5, alpha=0.5)
    legend(panel)
    return parent_figure(panel)
