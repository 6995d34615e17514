"""A temperature report as a PDF, typeset by typst. All texts are passed to typst as data."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime
from typing import Any

from sigmatau import __version__
from sigmatau.errors import DataError
from sigmatau.lab.pages.lot_content import moment_text
from sigmatau.lab.pages.sheet import cut_text, sheet
from sigmatau.lab.temperature.figures import bias_svg, deviations_svg
from sigmatau.lab.temperature.firmware import AUTOPILOTS, parameter_file
from sigmatau.lab.temperature.matrix import TemperatureMatrix
from sigmatau.lab.temperature.matrix_figures import table_svg
from sigmatau.lab.temperature.result import ChannelCalibration, TemperatureCalibration
from sigmatau.lab.temperature.text import heads, mean_unit, rows, summary_lines
from sigmatau.reporting.pdf import typeset

_WIDTH, _HEIGHT = 86.0, 52.0  # of a figure [mm]
_MOST_NAME, _MOST_TEXT = 60, 400  # characters


def document(
    calibration: TemperatureCalibration | None,
    matrices: Sequence[TemperatureMatrix],
    *,
    title: str,
    headline: str,
    legend: str,
    done: Sequence[tuple[str, str]],
    date: datetime,
) -> bytes:
    """The report as a PDF. The same results and date give the same bytes."""
    values = {
        "title": cut_text(title, 2 * _MOST_NAME),
        "headline": cut_text(headline, _MOST_TEXT),
        "legend": legend,
        "date": moment_text(date),
        "made_by": f"sigmatau {__version__}",
        "width": _WIDTH,
        "channels": [] if calibration is None else [_channel(channel) for channel in calibration.values()],
        "remarks": [] if calibration is None else [f"{text[0].upper()}{text[1:]}." for text in calibration.remarks],
        "tables": [part for matrix in matrices for part in _tables(matrix)],
        "files": [] if calibration is None else autopilot_files(calibration),
        "done": [[key, cut_text(text, _MOST_TEXT)] for key, text in done],
    }
    return bytes(typeset(sheet("temperature.typ"), values, format="pdf", timestamp=date.replace(microsecond=0)))


def autopilot_files(calibration: TemperatureCalibration) -> list[tuple[str, str, bool]]:
    """Name and content of the file of each autopilot; or the reason why there is none, and False."""
    files = []
    for target in AUTOPILOTS:
        try:
            files.append((target, parameter_file(calibration, target=target), True))
        except DataError as error:
            files.append((target, f"{error.reason}.", False))
    return files


def _channel(channel: ChannelCalibration) -> dict[str, Any]:
    unit, _ = mean_unit(channel)
    bias = bias_svg(channel, width=_WIDTH, height=_HEIGHT)
    figures = [{"caption": f"Mean [{unit}]. Line: polynomial with its interval. ▲ rising, ▼ falling", "svg": bias}]
    if drawn := deviations_svg(channel, width=_WIDTH, height=_HEIGHT):
        caption = f"Allan deviation [{unit}]. Orange: as recorded. Blue: compensated"
        figures.append({"caption": caption, "svg": drawn})
    return {
        "name": cut_text(channel.channel, _MOST_NAME),
        "lines": [f"{line[0].upper()}{line[1:]}." for line in summary_lines(channel)],
        "figures": figures,
        "heads": heads(channel),
        "rows": [[cut_text(cell, _MOST_NAME) for cell in row] for row in rows(channel)],
    }


def _tables(matrix: TemperatureMatrix) -> list[dict[str, Any]]:
    return [
        {
            "title": f"{table.title.capitalize()} [{table.unit}]",
            "caption": f"{table.title} [{table.unit}]",
            "svg": table_svg(matrix, table, width=_WIDTH, height=_HEIGHT),
            "heads": ["Unit", *(f"{t:.3g} °C" for t in matrix.temperatures)],
            "rows": [[cut_text(unit, _MOST_NAME), *cells] for unit, cells in table.rows],
        }
        for table in matrix.tables()
    ]
