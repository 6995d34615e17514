"""Allan deviations of several records in one figure: one panel per channel, one line per record."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from sigmatau.errors import OptionError
from sigmatau.plot.curves import COLOURS, MARKERS, CurveLike, curve_unit, draw_line, require_points
from sigmatau.plot.style import legend, make_panels, parent_figure, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from sigmatau.plot.style import Panels, Style

_ACROSS = 3  # number of panels side by side
_FADED = 12  # number of records from which lines have no markers


def plot_overlay(
    curves: Mapping[str, Mapping[str, CurveLike]],
    *,
    ax: Panels = None,
    unit: str | None = None,
    style: Style = "screen",
) -> Figure:
    """Draw the Allan deviations of several records in one figure.

    Parameters
    ----------
    curves : mapping of str to Curves
        By the name of the record in the legend, such as a sampling rate, a day or a serial number.
    ax : matplotlib axes, or one axes per channel, optional
        Default: a new figure.
    unit : str, optional
        Default: deg/h for gyros, µg for accelerometers, the unit of any other signal.
    style : {"screen", "paper"}

    Returns
    -------
    Figure
        One panel for each channel of any of the records; without intervals, which would hide each other.

    Raises
    ------
    DataError
        For a curve without points, which a store did not keep.
    OptionError
        If there are no curves, if a channel has different units in two records, or if `ax` has another number of axes.

    See Also
    --------
    Analysis.plot : the channels of one record in one panel, with intervals and models.

    Examples
    --------
    >>> import numpy as np
    >>> import sigmatau as st
    >>> whole = np.random.default_rng(1).standard_normal(100_000)
    >>> logs = {f"{100 / k:g} Hz": st.Record.from_arrays(rate=100 / k, gyro_x=whole[::k]) for k in (1, 10)}
    >>> figure = st.plot_overlay({name: st.allan(record) for name, record in logs.items()})
    >>> [line.get_label() for line in figure.axes[0].lines]
    ['100 Hz', '10 Hz']
    """
    kinds: dict[str, tuple[str, str]] = {}
    for name, record in curves.items():
        for channel, curve in record.items():
            require_points(curve)
            if kinds.setdefault(channel, (curve.quantity, curve.unit)) != (curve.quantity, curve.unit):
                raise OptionError(
                    f"`curves`: {channel} is in {curve.unit} in {name}, and in {kinds[channel][1]} in another record; "
                    "give the curves of one kind of sensor",
                    option="curves",
                )
    if not kinds:
        raise OptionError("`curves` has no curve to draw", option="curves")
    with styled(style):
        width, height = (7.2, 5.2) if len(kinds) == 1 else (4.8, 4.0)
        axes = make_panels(ax, len(kinds), columns=_ACROSS, width=width, height=height)
        for panel, channel in zip(axes, kinds, strict=True):
            present = {name: record[channel] for name, record in curves.items() if channel in record}
            for k, (name, curve) in enumerate(present.items()):
                factor, text = curve_unit(curve, unit)
                marker = MARKERS[k % len(MARKERS)] if len(present) < _FADED else ""
                draw_line(panel, name, curve.tau, curve.adev / factor, COLOURS[k % len(COLOURS)], marker)
            panel.set_ylabel(f"Allan deviation σ(τ) [{text}]")
            panel.set_title(channel)
        if len(curves) < _FADED:
            legend(axes[0])
        return parent_figure(axes[0])
