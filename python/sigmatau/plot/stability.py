"""Maps of a deviation over time and averaging time, from any object with a dynamic Allan deviation's attributes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Protocol, cast

import numpy as np
from numpy.typing import NDArray

from sigmatau.plot.curves import curve_unit, need_matplotlib
from sigmatau.results import duration_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["draw_all", "draw_dynamic"]


class MapLike(Protocol):
    """What is drawn: see `sigmatau.stability.DynamicAllan`."""

    @property
    def channel(self) -> str: ...
    @property
    def quantity(self) -> str: ...
    @property
    def unit(self) -> str: ...
    @property
    def times(self) -> NDArray[np.float64]: ...
    @property
    def tau(self) -> NDArray[np.float64]: ...
    @property
    def adev(self) -> NDArray[np.float64]: ...
    @property
    def step(self) -> float: ...
    @property
    def window(self) -> float: ...


def draw_all(maps: Mapping[str, MapLike]) -> Figure:
    """One map a channel, three in a row."""
    need_matplotlib()
    from matplotlib.figure import Figure

    across = min(len(maps), 3)
    down = -(-len(maps) // across)
    figure = Figure(figsize=(1.5 + 5.5 * across, 0.6 + 3.8 * down), layout="constrained")
    panels = figure.subplots(down, across, squeeze=False).ravel()
    for panel, dynamic in zip(panels, maps.values(), strict=False):
        draw_dynamic(dynamic, ax=panel)
    for panel in panels[len(maps) :]:
        panel.set_axis_off()
    return figure


def draw_dynamic(dynamic: MapLike, *, ax: Axes | None = None, unit: str | None = None) -> Axes:
    """A map of σ over time and τ, both the averaging time and the colours on logarithmic scales.

    Parameters
    ----------
    dynamic : DynamicAllan
    ax : matplotlib axes, optional
    unit : str, optional
        Default: deg/h for gyros, µg for accelerometers, its own for other signals.
    """
    if ax is None:
        need_matplotlib()
        from matplotlib.figure import Figure

        ax = Figure(figsize=(7.5, 4.6), layout="constrained").subplots()
    from matplotlib.colors import LogNorm

    factor, text = curve_unit(cast(Any, dynamic), unit)
    sigma = np.ma.masked_invalid(dynamic.adev.T / factor)
    sigma = np.ma.masked_where(sigma <= 0, sigma)
    time, size = _clock(dynamic.times)
    half = dynamic.step / 2
    across = np.concatenate([dynamic.times - half, [dynamic.times[-1] + half]]) / size
    ratio = np.sqrt(dynamic.tau[1:] / dynamic.tau[:-1]) if len(dynamic.tau) > 1 else np.array([2**0.25])
    middle = dynamic.tau[:-1] * ratio if len(dynamic.tau) > 1 else np.empty(0)
    up = np.concatenate([[dynamic.tau[0] / ratio[0]], middle, [dynamic.tau[-1] * ratio[-1]]])
    if sigma.count() and sigma.min() < sigma.max():
        norm = LogNorm(sigma.min(), sigma.max())
    else:  # one level, or nothing: a scale of its own
        level = float(sigma.min()) if sigma.count() else 1.0
        norm = LogNorm(level / 2, level * 2)
    mesh = ax.pcolormesh(across, up, sigma, norm=norm, cmap="cividis", rasterized=True)
    ax.set_yscale("log")
    ax.set_xlabel(f"time in the record, middle of the window [{time}]")
    ax.set_ylabel("averaging time τ [s]")
    ax.set_title(f"{dynamic.channel}, windows of {duration_text(dynamic.window)}")
    ax.figure.colorbar(mesh, ax=ax, label=f"Allan deviation σ(τ) [{text}]")
    return ax


def _clock(times: NDArray[np.float64]) -> tuple[str, float]:
    """Unit of the time axis and its size in seconds."""
    span = float(times[-1])
    if span > 3 * 3600:
        return "h", 3600.0
    if span > 600:
        return "min", 60.0
    return "s", 1.0
