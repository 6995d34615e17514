"""Figures of a printed report as SVG, from plain numbers, with lengths in millimetres and no text from files.

matplotlib is not used, because it takes seconds to import and to draw the figures of six axes, while the rest of a report
takes 0.3 s. Names and units of channels may come from a file; the report writes them around the figures.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from sigmatau.arrays import Floats, runs
from sigmatau.frozen import frozen
from sigmatau.plot.curves import COLOURS
from sigmatau.plot.stability import beyond_chance, clock, relative
from sigmatau.plot.svg import Axes, Drawing

Columns = Mapping[str, Floats]
Span = tuple[float, float]

LEFT_MARGIN, _RIGHT, _TOP, _BOTTOM = 10.0, 0.5, 0.5, 7.0  # margins of axes
PITCH = 13.5  # distance between the strips of neighbouring channels
_STRIP = 9.0  # height of a strip; the rest is for the name of the channel
_CLIP_RATIO = 10.0  # largest ratio to the value up to which the edges of an interval are drawn
MARKERS = "os^Dv+"  # by channel, as their colours
MAX_BANDS = 3  # largest number of densities whose intervals are drawn; more would hide each other
_DASHED, _DOTTED = (3.0, 1.5), (0.6, 1.2)  # [points]
_GREY = "#c8cdd3"
# RdBu of ColorBrewer (C. Brewer, Penn State), 9 classes, blue first.
_BLUES, _REDS = ("#2166ac", "#4393c3", "#92c5de", "#d1e5f0"), ("#fddbc7", "#f4a582", "#d6604d", "#b2182b")
MAP_COLOURS = (*_BLUES, "#f7f7f7", *_REDS)
"""Classes of ratios, at even steps of the logarithm."""


@frozen
class Map:
    """The dynamic Allan deviation of a channel."""

    times: Floats  # middles of the windows [s]
    tau: Floats  # [s]
    window: float  # [s]
    adev: Floats  # shape (n_times, n_tau)

    @property
    def ratio(self) -> Floats:
        """Ratio of the deviations to their medians over time."""
        return relative(self.adev)[0]

    @property
    def beyond(self) -> NDArray[np.bool_]:
        """Mask of the ratios that chance does not explain."""
        return beyond_chance(self.ratio, self)

    @property
    def missing(self) -> NDArray[np.bool_]:
        """Windows with too few samples."""
        return np.asarray(~np.isfinite(self.adev).any(axis=1))


def deviations(curves: Sequence[Columns], spans: Sequence[Span], *, width: float, height: float) -> str:
    """Allan deviations with their intervals and models, and the terms of a model if there is one curve.

    Parameters
    ----------
    curves : sequence of mapping
        By channel ``tau``, ``adev``, ``low``, ``high``, perhaps ``model``, and more columns: the parts of the model.
    spans : sequence of tuple
        By channel, the averaging times between which the model was fitted.
    width, height : float
    """
    drawing, ax = _figure(width, height)
    _log_limits(ax, [curve["tau"] for curve in curves], [curve["adev"] for curve in curves], decades=1.0)
    if len(curves) == 1:
        _terms(ax, curves[0])
    _bands(ax, curves, "tau", "adev")
    for curve, span, colour, marker in zip(curves, spans, COLOURS, MARKERS, strict=False):
        x = np.log10(curve["tau"])
        ax.line(x, np.log10(curve["adev"]), colour, 0.6)
        ax.markers(x, np.log10(curve["adev"]), marker, colour)
        if "model" in curve:
            _model(ax, x, curve["model"], _inside(curve["tau"], span), colour)
    ax.frame("averaging time τ [s]")
    return drawing.svg()


def densities(
    curves: Sequence[Columns], highest: Sequence[float], lines: Sequence[Floats], *, width: float, height: float
) -> str:
    """Densities with their models, triangles at the frequencies of lines, and intervals unless there are too many.

    Parameters
    ----------
    curves : sequence of mapping
        By channel ``frequency``, ``density``, ``low``, ``high``, perhaps ``model``.
    highest : sequence of float
        By channel, highest frequency to which the model was fitted.
    lines : sequence of ndarray
        By channel, frequencies.
    width, height : float
    """
    drawing, ax = _figure(width, height)
    _log_limits(ax, [curve["frequency"] for curve in curves], [curve["density"] for curve in curves], decades=1.0)
    if len(curves) <= MAX_BANDS:
        _bands(ax, curves, "frequency", "density")
    for curve, last, colour in zip(curves, highest, COLOURS, strict=False):
        x = np.log10(curve["frequency"])
        ax.line(x, np.log10(curve["density"]), colour, 0.5)
        if "model" in curve:
            _model(ax, x, curve["model"], curve["frequency"] <= last, colour)
    bottom, top = ax.y
    for k, (frequencies, colour) in enumerate(zip(lines, COLOURS, strict=False)):
        heights = np.full(len(frequencies), top - (0.03 + 0.04 * k) * (top - bottom))
        ax.markers(np.log10(frequencies), heights, "v", colour)
    ax.frame("frequency [Hz]")
    return drawing.svg()


def ratios(curves: Sequence[Columns], spans: Sequence[Span], *, width: float, height: float) -> str:
    """Measured deviations over those of their models, where these were fitted; see `deviations`."""
    drawing, ax = _figure(width, height)
    inside = [_inside(curve["tau"], span) for curve, span in zip(curves, spans, strict=True)]
    shown = [
        {"tau": curve["tau"][part]}
        | {name: curve[name][part] / curve["model"][part] for name in ("adev", "low", "high")}
        for curve, part in zip(curves, inside, strict=True)
    ]
    _log_limits(ax, [curve["tau"] for curve in curves], [curve["adev"] for curve in shown], decades=0.1)
    reach = max(map(abs, ax.y))
    ax.log_y(-reach, reach)
    ax.line(np.array(ax.x), np.zeros(2), "#555", 0.5)
    _bands(ax, shown, "tau", "adev")
    for curve, colour, marker in zip(shown, COLOURS, MARKERS, strict=False):
        x, y = np.log10(curve["tau"]), np.log10(curve["adev"])
        ax.line(x, y, colour, 0.6)
        ax.markers(x, y, marker, colour)
    ax.frame("averaging time τ [s]")
    return drawing.svg()


def series(
    envelopes: Sequence[tuple[Floats, Floats]],
    outside: Sequence[Sequence[Sequence[float]]],
    times: Sequence[tuple[float, float]],
    *,
    width: float,
) -> str:
    """The smallest and the largest sample of each stretch of a record, channel by channel; grey if not analysed.

    `times`: begin and end of each channel, from the beginning of the record. [s]
    """
    last = max(end for _, end in times)
    unit, size = clock(last)
    drawing, axes = _strips(len(envelopes), width)
    for ax, (low, high), spans, (begin, end), colour in zip(axes, envelopes, outside, times, COLOURS, strict=False):
        ax.linear_x(0.0, last / size)
        finite = np.isfinite(low)
        bottom, top = (float(low[finite].min()), float(high[finite].max())) if finite.any() else (0.0, 0.0)
        spare = 0.08 * (top - bottom) or max(abs(top), 1.0) * 0.1
        ax.linear_y(bottom - spare, top + spare)
        for start, stop in spans:
            ax.rectangle(start / size, stop / size, *ax.y, _GREY, smallest=0.4)
        edges = np.linspace(begin / size, end / size, len(low) + 1)
        ax.steps(edges, low, high, colour)
        ax.frame(f"time in the record [{unit}]" if ax is axes[-1] else None)
    return drawing.svg()


def maps(shown: Sequence[Map], limit: float, *, width: float) -> str:
    """Dynamic Allan deviations over their medians, where chance does not explain the ratio, channel by channel.

    `limit`: ratio at the end of the colour scale. Windows with too few samples are grey.
    """
    duration = max(float(channel.times[-1]) + channel.window / 2 for channel in shown)
    unit, size = clock(duration)
    drawing, axes = _strips(len(shown), width)
    for ax, channel in zip(axes, shown, strict=True):
        half = (channel.times[1] - channel.times[0]) / 2 if len(channel.times) > 1 else channel.window / 2
        across = np.append(channel.times - half, channel.times[-1] + half) / size
        logarithm = np.log10(channel.tau)
        middle = (logarithm[1:] + logarithm[:-1]) / 2 if len(logarithm) > 1 else logarithm + 0.15
        up = np.concatenate([[2 * logarithm[0] - middle[0]], middle, [2 * logarithm[-1] - middle[-1]]])
        ax.linear_x(0.0, duration / size)
        ax.log_y(float(up[0]), float(up[-1]), count=3)
        for start, stop in runs(channel.missing):
            ax.rectangle(across[start], across[stop], *ax.y, _GREY)
        _coloured(ax, across, up, channel, limit)
        ax.frame(f"time in the record, middle of the window [{unit}]" if ax is axes[-1] else None, grid=False)
    return drawing.svg()


def _coloured(ax: Axes, across: Floats, up: Floats, channel: Map, limit: float) -> None:
    """The cells beyond chance, those of one colour joined along the time axis to rectangles."""
    last = len(MAP_COLOURS) - 1
    place = np.nan_to_num((np.log(channel.ratio) / math.log(limit) + 1) / 2 * last)
    classes = np.where(channel.beyond, np.clip(np.round(place), 0, last), -1).astype(int)
    for k in range(len(channel.tau)):
        column = classes[:, k]
        edges = np.flatnonzero(np.diff(column, prepend=-2, append=-2))
        for start, stop in pairwise(edges.tolist()):
            if column[start] >= 0:
                ax.rectangle(across[start], across[stop], up[k], up[k + 1], MAP_COLOURS[column[start]])


def strips_height(count: int) -> float:
    """Height of a figure of stacked channels."""
    return count * PITCH + _BOTTOM


def _figure(width: float, height: float) -> tuple[Drawing, Axes]:
    drawing = Drawing(width, height)
    return drawing, drawing.axes(LEFT_MARGIN, _TOP, width - LEFT_MARGIN - _RIGHT, height - _TOP - _BOTTOM)


def _strips(count: int, width: float) -> tuple[Drawing, list[Axes]]:
    drawing = Drawing(width, strips_height(count))
    tops = (k * PITCH + PITCH - _STRIP for k in range(count))
    return drawing, [drawing.axes(LEFT_MARGIN, top, width - LEFT_MARGIN - _RIGHT, _STRIP) for top in tops]


def _inside(tau: Floats, span: Span) -> NDArray[np.bool_]:
    return np.asarray((tau >= span[0] * (1 - 1e-9)) & (tau <= span[1] * (1 + 1e-9)))


def _log_limits(ax: Axes, x: Sequence[Floats], y: Sequence[Floats], *, decades: float) -> None:
    """Limits around positive numbers, with a smallest height in decades."""
    ends = []
    for parts in (x, y):
        values = np.log10(np.concatenate(list(parts)))
        values = values[np.isfinite(values)]
        ends.append((float(values.min()), float(values.max())) if len(values) else (0.0, 1.0))
    (begin, end), (bottom, top) = ends
    margin = 0.02 * max(end - begin, 1.0)
    spare = max(0.06 * (top - bottom), (decades - (top - bottom)) / 2)
    ax.log_x(begin - margin, end + margin)
    ax.log_y(bottom - spare, top + spare)


def _bands(ax: Axes, curves: Sequence[Columns], across: str, up: str) -> None:
    """Draw the intervals of all curves, below the curves."""
    for curve, colour in zip(curves, COLOURS, strict=False):
        low, high = np.fmax(curve["low"], curve[up] / _CLIP_RATIO), np.fmin(curve["high"], curve[up] * _CLIP_RATIO)
        ax.area(np.log10(curve[across]), np.log10(low), np.log10(high), colour)


def _model(ax: Axes, x: Floats, model: Floats, used: NDArray[np.bool_], colour: str) -> None:
    """Draw a model, dashed where it was fitted and dotted elsewhere; the pieces share their ends."""
    y = np.log10(model)
    ax.line(x, np.where(used, y, np.nan), colour, 0.7, _DASHED)
    unused = ~used
    unused[:-1] |= ~used[1:]
    unused[1:] |= ~used[:-1]
    ax.line(x, np.where(unused, y, np.nan), colour, 0.7, _DOTTED)


def _terms(ax: Axes, curve: Columns) -> None:
    """Draw the terms of a model, each with its symbol where its share of the sum is largest."""
    x, margin = np.log10(curve["tau"]), 0.06 * (ax.x[1] - ax.x[0])
    for label, part in curve.items():
        if label in ("tau", "adev", "low", "high", "model"):
            continue
        with np.errstate(divide="ignore"):
            y = np.log10(part)
        ax.line(x, y, "#777", 0.5)
        within = (x > ax.x[0] + margin) & (x < ax.x[1] - margin) & (y > ax.y[0]) & (y < ax.y[1])
        share = np.where(within, part / curve["model"], 0.0)
        if not share.max() > 0:
            continue
        place = int(np.argmax(share))
        *_, symbol = label.split(" ")
        falls = y[place] < y[max(place - 1, 0)]  # the side away from the curve
        ax.text(float(x[place]), float(y[place]), symbol if len(symbol) == 1 else label, end=bool(falls))
