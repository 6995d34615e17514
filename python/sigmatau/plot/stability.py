"""Maps of a deviation over time and averaging time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Protocol, cast

import numpy as np
from numpy.typing import NDArray

from sigmatau._native.distributions import chi2_quantile_above
from sigmatau.arrays import runs
from sigmatau.plot.curves import ChannelLike, curve_unit
from sigmatau.plot.style import across, make_panels, new_figure, parent_figure
from sigmatau.results import duration_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from sigmatau.plot.style import Panels

_COLOUR_LIMITS = (1.5, 4.0)
_MEDIAN_LABELS = 5
_MIN_FREEDOM = 2 / 3  # degrees of freedom of white noise at one sample, over those of eq. (26), n/m − 1
_CHANCE = 0.05  # share of maps of stationary noise with a coloured window, for each averaging time


class WindowLike(Protocol):
    """A sliding window."""

    @property
    def tau(self) -> NDArray[np.float64]: ...
    @property
    def window(self) -> float: ...


class MapLike(ChannelLike, WindowLike, Protocol):
    """Attributes of `sigmatau.estimators.stability.DynamicAllan` that are drawn."""

    @property
    def times(self) -> NDArray[np.float64]: ...
    @property
    def adev(self) -> NDArray[np.float64]: ...
    @property
    def step(self) -> float: ...


def draw_all(maps: Mapping[str, MapLike], *, ax: Panels = None) -> Figure:
    """Draw one map per channel, three in a row, or in the given axes."""
    panels = make_panels(ax, len(maps), columns=across(), width=6.8, height=4.1)
    for panel, dynamic in zip(panels, maps.values(), strict=True):
        draw_dynamic(dynamic, ax=panel)
    return parent_figure(panels[0])


def draw_dynamic(dynamic: MapLike, *, ax: Axes | None = None, unit: str | None = None) -> Axes:
    """Draw a map of σ over time and τ, relative to the median of all windows at the same τ.

    Colour shows deviations that chance does not explain: the map of stationary noise is white, for any slope of its curve.
    Windows without a deviation are hatched. The axis at the right shows the medians.

    Parameters
    ----------
    dynamic : DynamicAllan
    ax : matplotlib axes, optional
    unit : str, optional
        Unit of the medians. Default: deg/h for gyros, µg for accelerometers, the unit of any other signal.
    """
    ax = new_figure(8.0, 4.6).subplots() if ax is None else ax
    from matplotlib.colors import LogNorm
    from matplotlib.ticker import FixedLocator, FuncFormatter, NullFormatter

    factor, text = curve_unit(cast(Any, dynamic), unit)
    ratio, medians = relative(dynamic.adev)
    time, size = clock(float(dynamic.times[-1]))
    half = dynamic.step / 2
    time_edges = np.concatenate([dynamic.times - half, [dynamic.times[-1] + half]]) / size
    steps = np.sqrt(dynamic.tau[1:] / dynamic.tau[:-1]) if len(dynamic.tau) > 1 else np.array([2**0.25])
    middle = dynamic.tau[:-1] * steps if len(dynamic.tau) > 1 else np.empty(0)
    tau_edges = np.concatenate([[dynamic.tau[0] / steps[0]], middle, [dynamic.tau[-1] * steps[-1]]])
    limit = colour_limit(ratio)
    coloured = np.ma.masked_where(~beyond_chance(ratio, dynamic).T, ratio.T)
    mesh = ax.pcolormesh(
        time_edges, tau_edges, coloured, norm=LogNorm(1 / limit, limit), cmap="RdBu_r", rasterized=True
    )
    empty = np.asarray(~np.isfinite(ratio).any(axis=1), dtype=np.bool_)
    for start, stop in runs(empty):
        ax.axvspan(time_edges[start], time_edges[stop], facecolor="0.85", edgecolor="0.5", hatch="///", linewidth=0)
    hatched = "; hatched: a tenth of the window or more is missing" if empty.any() else ""
    ax.set_xlabel(f"time in the record, middle of the window [{time}]\nwhite: no more than chance{hatched}")
    ax.set_yscale("log")
    ax.set_ylabel("averaging time τ [s]")
    ax.set_title(f"{dynamic.channel}, windows of {duration_text(dynamic.window)}")
    ticks = [limit ** (k / 2) for k in range(-2, 3)]
    bar = ax.figure.colorbar(mesh, ax=ax, extend="both")
    bar.set_label("σ(τ) over its median at that τ")
    bar.ax.yaxis.set_major_locator(FixedLocator(ticks))
    bar.ax.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.2g} ×"))
    bar.ax.yaxis.set_minor_formatter(NullFormatter())
    bar.ax.minorticks_off()
    usable = np.flatnonzero(np.isfinite(medians) & (medians > 0))
    chosen = (
        usable[np.unique(np.round(np.linspace(0, len(usable) - 1, _MEDIAN_LABELS)).astype(int))]
        if len(usable)
        else usable
    )
    right_axis = ax.secondary_yaxis("right")
    right_axis.yaxis.set_major_locator(FixedLocator(dynamic.tau[chosen].tolist()))
    right_axis.yaxis.set_major_formatter(_label_values(dynamic.tau[chosen], medians[chosen] / factor))
    right_axis.yaxis.set_minor_formatter(NullFormatter())
    right_axis.minorticks_off()
    right_axis.set_ylabel(f"median σ(τ) [{text}]")
    return ax


def beyond_chance(ratio: NDArray[np.float64], dynamic: WindowLike) -> NDArray[np.bool_]:
    """Mask of ratios to the median of all windows that are too large or too small for chance, at each τ."""
    low, high = chance_limits(len(ratio), dynamic)
    return np.asarray(np.isfinite(ratio) & ((ratio > high) | (ratio < low)))


def chance_limits(windows: int, dynamic: WindowLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Smallest and largest ratio to the median that chance can cause among this number of windows, at each averaging time.

    From χ² with 2/3·(n/m − 1) degrees of freedom, fewer than for any noise term, at a level of 95 % for all windows.
    """
    freedom = np.maximum(_MIN_FREEDOM * (dynamic.window / dynamic.tau - 1), 1.0)
    tail = _CHANCE / 2 / max(windows, 1)
    high, low = (np.sqrt(chi2_quantile_above(freedom, p) / freedom) for p in (tail, 1 - tail))
    return low, high


def relative(adev: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Deviations relative to the median of all windows at the same averaging time, and these medians.

    Parameters
    ----------
    adev : ndarray, shape (n_times, n_tau)
        NaN where a window has no deviation.

    Returns
    -------
    ndarray, shape (n_times, n_tau); ndarray, shape (n_tau,)
        NaN where no window has a deviation, or the median is 0.
    """
    medians = np.full(adev.shape[1], np.nan)
    finite = np.isfinite(adev)
    some = finite.any(axis=0)
    medians[some] = np.nanmedian(adev[:, some], axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where((medians > 0) & (adev > 0), adev / medians, np.nan)
    return np.asarray(ratio), medians


def colour_limit(ratio: NDArray[np.float64]) -> float:
    """End of the colour scale: the ratio that 90 % of the windows do not exceed, at least 1.5 and at most 4."""
    off = np.abs(np.log(ratio[np.isfinite(ratio)]))
    return float(np.clip(np.exp(np.quantile(off, 0.9)), *_COLOUR_LIMITS)) if len(off) else _COLOUR_LIMITS[0]


def _label_values(tau: NDArray[np.float64], values: NDArray[np.float64]) -> Any:  # noqa: ANN401  matplotlib has no types for it
    """Label an axis at the averaging times `tau` with the values there."""
    from matplotlib.ticker import FuncFormatter

    def label(place: float, _: int | None = None) -> str:
        text = f"{values[int(np.argmin(np.abs(np.log(tau / place))))]:.3g}"
        return f"{float(text):.0f}" if "e+" in text else text

    return FuncFormatter(label)


def clock(span: float) -> tuple[str, float]:
    """Unit of a time axis up to `span` seconds, and its size in seconds."""
    if span > 3 * 3600:
        return "h", 3600.0
    if span > 600:
        return "min", 60.0
    return "s", 1.0
