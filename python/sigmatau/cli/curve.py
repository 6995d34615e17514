"""``sigmatau curve``: coefficients and noise model of Allan deviations that another program computed or a figure shows."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter

from sigmatau._version import __version__
from sigmatau.cli.declared import Flag, InFigure, InMain, InMethod, InOutput, MayBeMinus, Quiet, Show, Texts
from sigmatau.cli.figure import FigureOptions, curves_of_figure, has_figure, listed_lines
from sigmatau.cli.options import (
    ENDINGS,
    check_output,
    check_outputs,
    check_style,
    drawing,
    say,
    write_figure,
    write_result,
)
from sigmatau.errors import DataError, OptionError
from sigmatau.estimators.curve_table import read_curves
from sigmatau.fitting.fit import fit
from sigmatau.fitting.read_off import read_off
from sigmatau.fitting.to_model import to_models
from sigmatau.model.noise_model import NoiseModel
from sigmatau.noise.shown import set_shown
from sigmatau.noise.terms import NOISE, check_shown
from sigmatau.quality.beyond_class import beyond_class
from sigmatau.typed.pairs import key_values


def curve_command(
    table: Path,
    /,
    *,
    rate: Annotated[float | None, InMain] = None,
    hours: Annotated[float | None, InMain] = None,
    columns: Annotated[list[str] | None, Texts, InMain] = None,
    unit: Annotated[str | None, InMain] = None,
    content: Annotated[Literal["deviation", "variance"] | None, InMain] = None,
    list_: Annotated[bool, Parameter(name="--list"), Flag, InFigure] = False,
    line: Annotated[str | None, InFigure] = None,
    page: Annotated[int | None, InFigure] = None,
    x_axis: Annotated[list[str] | None, Texts, InFigure] = None,
    y_axis: Annotated[list[str] | None, Texts, InFigure] = None,
    linear: Annotated[Literal["x", "y", "xy"] | None, InFigure] = None,
    point_error: Annotated[float | None, InFigure] = None,
    read_off_: Annotated[bool, Parameter(name="--read-off"), Flag, InMethod] = False,
    output: Annotated[Path | None, Parameter(name=["--output", "-o"]), InMain] = None,
    plot: Annotated[Path | None, InOutput] = None,
    style: Annotated[Literal["screen", "paper"], InOutput] = "screen",
    json: Annotated[Path | None, MayBeMinus, InMain] = None,
    show: Show = None,
    quiet: Quiet = False,
) -> int:
    """Fit the noise terms to Allan deviations that another program computed, or that a figure shows.

    Rest, disturbances and rate are not checked, because the record was not seen. If you have the log, use analyze.

    Parameters
    ----------
    table
        Table of averaging times and overlapped Allan deviations, such as CSV with a header:
        tau [s],gyro_x adev [deg/h],gyro_y adev [deg/h]. Or a figure, SVG or PDF, or a table of clicked points.
    rate
        Sampling rate of the record in Hz. Required for a table; default for a figure: one over its shortest averaging time.
    hours
        Length of the record in hours, which determines the errors of the curve. Required for a table; default for a
        figure: the shortest possible one, twice its longest averaging time.
    columns
        The columns by name or number: tau=1,gyro_x=6, of clicked points x=1,gyro_x=2. Default: by their names.
    unit
        Unit of the rate: deg/h, rad/s, m/s^2, ug. Default: that of the header; required for a figure.
    content
        Whether the columns have deviations or variances. Default: as the header states; deviations for a figure.
    list_
        List the lines of a figure that can be curves, with colour and number of points, and do nothing else.
    line
        Line of the figure by number or colour, 2 or #ff0000, or several: gyro_x=1,gyro_y=2. Default: the only one.
    page
        Number of the page of a PDF file, from 1. Default: its only page.
    x_axis
        Averaging times in seconds at two or more coordinates of the figure: 80=0.01,480=100. Default: by the tick labels.
    y_axis
        Deviations in --unit at two or more coordinates of the figure: 310=1,30=1000. Default: by the tick labels.
    linear
        Axes of --x-axis and --y-axis that are linear. Default: both are logarithmic.
    point_error
        Standard error of a point in coordinates of the figure, for points without axes as a ratio. Default: a quarter of
        the width of the line; 1 for clicked points.
    read_off_
        Read the coefficients off the slopes, as the paper does, in place of the fit.
    output
        Write the model file (.toml) for export, simulate, plan and predict.
    plot
        Draw the curves: .png, .svg or .pdf.
    style
        Style of the figure: screen, or paper, for the width of a column or a page of a paper.
    json
        Write the result as JSON, in SI; - writes it to standard output instead of the table.
    quiet
        Print only errors on standard error.
    """
    set_shown(show)
    check_output(output, ENDINGS["model"], "output")
    check_outputs([table], output=output, plot=plot, json=json)
    check_style(style, plot)
    if read_off_ and output is not None:
        raise OptionError("--output needs the fit, without --read-off: a model has intervals", option="output")
    for option, number in (("hours", hours), ("rate", rate)):
        if number is not None and not 0 < number < float("inf"):
            raise OptionError(f"--{option} {number:g}: must be a positive number", option=option)
    if list_:
        sys.stdout.write(listed_lines(table, page) + "\n")
        return 0
    chosen = key_values(columns or [], "columns", "tau=1") or None
    figure = FigureOptions(line, page, x_axis, y_axis, linear, point_error)
    if has_figure(table, figure):
        curves = curves_of_figure(
            table, figure, rate=rate, hours=hours, columns=chosen, unit=unit, content=content, quiet=quiet
        )
    elif rate is None or hours is None:
        option = "rate" if rate is None else "hours"
        raise OptionError(f"a table needs the rate and the length of the record. Give --{option} too", option=option)
    else:
        curves = read_curves(table, rate=rate, duration=3600 * hours, columns=chosen, unit=unit, content=content)
    check_shown({name: (curve.quantity, curve.unit) for name, curve in curves.items()})
    results: dict[str, Any] = {}
    try:
        for name, curve in curves.items():
            # The ramp is not fitted: its sign is lost in a deviation.
            results[name] = read_off(curve) if read_off_ else fit(curve, terms=NOISE)
    except DataError as error:
        raise error.about(str(table)) from None
    if output is not None:
        NoiseModel(channels=to_models(results)).write(output)
    if plot is not None:
        with drawing(plot, style, quiet=quiet):
            write_figure(curves.plot(style=style), plot)
    findings = [] if read_off_ else [finding for fitted in results.values() for finding in beyond_class(fitted)]
    for finding in findings:
        say(str(finding), quiet=quiet)
    say("info: the record was not seen: rest and disturbances are not checked, and a ramp is not fitted", quiet=quiet)
    text = "\n\n".join(repr(result) for result in results.values())
    channels = {
        name: {"curve": curve.to_dict(), "read_off" if read_off_ else "fit": results[name].to_dict()}
        for name, curve in curves.items()
    }
    printed = {"sigmatau": __version__, "channels": channels, "findings": [finding.to_dict() for finding in findings]}
    write_result(text, printed, json)
    return 0
