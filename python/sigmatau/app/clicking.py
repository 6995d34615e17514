"""A figure whose curves are clicked on the page: its picture, and the curves and coefficients of the clicked points."""

from __future__ import annotations

import contextlib
import json
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from sigmatau.app.calls import Progress
from sigmatau.app.clicks import TABLE, Clicks, Point, clicks_in
from sigmatau.app.log import LogFile
from sigmatau.arrays import Floats
from sigmatau.errors import DataError, OptionError
from sigmatau.estimators.allan import Curves, DeviationCurve
from sigmatau.estimators.figure import read_figure
from sigmatau.findings.reasons import TooFewTimes
from sigmatau.fitting.fit import fit
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.fitting.to_model import has_model, to_models
from sigmatau.io.read.curve_table import rate_unit
from sigmatau.io.read.figure import pdf_process
from sigmatau.io.read.figure.axis import Axis, stated_axis
from sigmatau.io.read.figure.picture import picture_size
from sigmatau.io.read.figure.select import check_directions, file_kind, open_figure
from sigmatau.model.noise_model import NoiseModel
from sigmatau.noise.terms import NOISE
from sigmatau.quality.beyond_class import beyond_class
from sigmatau.reporting.content import fitted_rows
from sigmatau.results import printable

Picture = tuple[bytes, str]
"""A picture and its media type."""

_OFF = 2.0  # distance from the model over the half width of the 95 % band: a chance of 1e-4 for each point


def picture(*, log: LogFile, page: int | None, progress: Progress) -> Picture:
    """The picture of a figure, as a browser shows it. A page of a PDF file is rendered."""
    path = Path(log.path)
    if file_kind(path) == "pdf":
        return pdf_process.render(path, page), "image/png"
    form = picture_size(path).form
    return path.read_bytes(), "image/svg+xml" if form == "svg" else f"image/{form}"


def figure_facts(*, log: LogFile, page: int | None, progress: Progress) -> str:
    """Form and size of a figure, and the number of its lines that are read without clicks, as JSON."""
    path = Path(log.path)
    kind = file_kind(path)
    size = None if kind == "pdf" else picture_size(path)
    lines = 0
    if kind in ("pdf", "svg"):
        with contextlib.suppress(DataError):  # its points can be clicked all the same
            lines = len(open_figure(path, page).candidates)
    content = {
        "form": "pdf" if size is None else size.form,
        "width": None if size is None else size.width,
        "height": None if size is None else size.height,
        "lines": lines,
    }
    return json.dumps(content)


def clicked_curves(*, clicks: Mapping[str, Any], progress: Progress) -> str:
    """Coefficients of clicked curves, their lines in the coordinates of the picture, table, command and model, as JSON."""
    stated = clicks_in(clicks)
    options = dict(stated.options)
    hours = options.pop("hours")
    with tempfile.TemporaryDirectory(prefix="sigmatau-clicks-") as folder:
        path = Path(folder) / TABLE
        path.write_text(stated.table, encoding="utf-8")
        try:
            axes = _axes(stated)
            curves = read_figure(
                path,
                x_axis=stated.x_axis,
                y_axis=stated.y_axis,
                columns=stated.columns,
                duration=None if hours is None else 3600 * hours,
                **options | {"content": options["content"] or "deviation"},
            )
            # The ramp is not fitted: its sign is lost in a deviation.
            fits = {name: fit(curve, terms=NOISE) for name, curve in curves.items()}
        except (DataError, OptionError) as error:
            error.source = TABLE if isinstance(error, DataError) else ""
            raise
    models = to_models(fits)
    content = {
        "channels": [
            {**_drawn(stated, axes, points, curves[name], fits[name]), "table": _table(fits[name])}
            for name, points in zip(curves, stated.curves.values(), strict=True)
        ],
        "text": "\n\n".join(map(repr, fits.values())),
        "csv": stated.table,
        "command": stated.command(has_model=bool(models)),
        "model": NoiseModel(channels=models).to_toml() if models else None,
        "length_s": _length(curves) if hours is None else None,
    }
    return json.dumps(content, allow_nan=False)


def _length(curves: Curves) -> float:
    """The length that is assumed for a record of unknown length. [s]"""
    return max(curve.n * curve.tau0 for curve in curves.values())


def _axes(stated: Clicks) -> dict[str, Axis]:
    linear, error = stated.options["linear"] or "", stated.options["point_error"] or 1.0
    axes = {
        way: stated_axis(points, f"{way}_axis", is_log=way not in linear, error=error)
        for way, points in (("x", stated.x_axis), ("y", stated.y_axis))
    }
    check_directions(axes)
    return axes


def _table(fitted: NoiseFit) -> dict[str, Any]:
    """The coefficients as the page shows those of a result."""
    reasons = [str(finding) for finding in beyond_class(fitted)]
    reasons += [fitted.reason] if fitted.reason and fitted.is_fitted else []
    if any(isinstance(reason, TooFewTimes) for reason in fitted.reasons):
        reasons = ["Click further points, below a third of the record. Points within a quarter of an octave count once"]
    return {
        "channel": printable(fitted.channel),
        "verdict": fitted.headline(),
        "trust": "",
        "rows": fitted_rows(fitted),
        "notes": list(map(printable, [*reasons, *fitted.notes()])),
    }


def _drawn(
    stated: Clicks, axes: Mapping[str, Axis], points: tuple[Point, ...], curve: DeviationCurve, fitted: NoiseFit
) -> dict[str, Any]:
    """The line of the fitted model and the band of the curve in coordinates, and the points that are off the model.

    The line is that of the clicked points if there is no model.
    """
    _, factor = rate_unit(str(stated.options["unit"]))
    power = 2 if stated.options["content"] == "variance" else 1

    def places(deviation: Floats) -> list[float]:
        return _rounded(axes["y"].place((deviation / factor) ** power))

    model = np.sqrt(fitted.avar(m=curve.m)) if has_model(fitted) else curve.adev
    low, high = (np.asarray(edge) for edge in curve.interval(noise=fitted.model or None))
    low = np.maximum(low, 1e-3 * curve.adev)
    x, y = (np.array(column) for column in zip(*points, strict=True))
    tau = np.log(axes["x"].read(x))
    deviation = np.log(axes["y"].read(y)) / power + np.log(factor)
    grid = np.log(curve.tau)
    distance = deviation - np.interp(tau, grid, np.log(model))
    half = np.where(
        distance > 0,
        np.interp(tau, grid, np.log(high / curve.adev)),
        np.interp(tau, grid, np.log(curve.adev / low)),
    )
    return {
        "name": curve.channel,
        "x": _rounded(axes["x"].place(curve.tau)),
        "y": places(model),
        "low": places(low),
        "high": places(high),
        "off": np.flatnonzero(np.abs(distance) > _OFF * half).tolist(),
    }


def _rounded(values: Floats) -> list[float]:
    return [round(value, 2) for value in values.tolist()]
