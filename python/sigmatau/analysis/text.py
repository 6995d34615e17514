"""Text of an analysis, for its printed form and the command line; functions with `self` are methods of `Analysis`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from sigmatau.findings.wording import causes
from sigmatau.fitting.overview import main_coefficients, text_rows
from sigmatau.fitting.overview import overview as fit_overview
from sigmatau.fitting.tables import fit_legend, fit_table, read_off_legend, read_off_table
from sigmatau.record.record import stream_name
from sigmatau.record.sampling import sampling_text
from sigmatau.results import duration_text, html_table, printable, wrapped

if TYPE_CHECKING:
    from sigmatau.analysis.result import Analysis

_RESTING = {
    "at_rest": "at rest",
    "partly_at_rest": "at rest in part",
    "not_at_rest": "not at rest",
    "too_short_to_tell": "too short to tell whether at rest",
    "assumed": "taken as at rest",
}


def headline(self: Analysis, *, name: bool = True, rest: bool = True) -> str:
    """The record in a line.

    Parameters
    ----------
    name : bool
        Whether the line begins with the name of the file.
    rest : bool
        Whether it states that the sensor is at rest, or not.

    Returns
    -------
    str
        Axes, rate with its source, and length.
    """
    curves = list(self.curves.values())
    rates = dict.fromkeys(f"{1 / curve.tau0:.5g}" for curve in curves)
    source = next((f" ({sampling.source.short})" for sampling in self.grids.values()), "")
    words = [
        f"{len(curves)} {'axis' if len(curves) == 1 else 'axes'} at {' and '.join(rates)} Hz{source}",
        duration_text(max(curve.n * curve.tau0 for curve in curves)),
    ]
    if rest and self.rest is not None:
        words.append(_RESTING["assumed" if is_moving(self) and self.fits else self.rest.verdict])
    file = "" if self.source.path is None or not name else f"{Path(self.source.path).name}: "
    return printable(file + ", ".join(words))


def is_moving(analysis: Analysis) -> bool:
    """Whether the sensor was not at rest."""
    return analysis.rest is not None and not analysis.rest.is_usable


def _without_coefficients(analysis: Analysis) -> str:
    return f"{'not at rest' if analysis.rest is None else analysis.rest.reason or 'not at rest'}: no coefficients"


def overview(self: Analysis, *, width: int = 80, legend: bool = True) -> str:
    """One line on the record, and one row of main coefficients for each axis, as the command line prints them.

    Parameters
    ----------
    width : int
        Columns of the terminal.
    legend : bool
        Whether a line explains the marks of trust.

    Returns
    -------
    str
    """
    if self.read_off and not self.fits:
        return summary(self)
    table = [fit_overview(self.fits, self.findings, width=width, legend=legend)] if self.fits else []
    return "\n".join([headline(self), *table])


def summary(self: Analysis) -> str:
    """Line on the record, grid and all coefficients of each sensor, and their legend, as the command line prints them
    with ``--verbose``.
    """
    return "\n\n".join(filter(None, [headline(self), *sections(self).values(), legend(self)]))


def sections(self: Analysis) -> dict[str, str]:
    """Grid and table of coefficients by sensor."""
    sensors = dict.fromkeys([*self.grids, *map(stream_name, self.curves)])
    parts = {}
    for sensor in sensors:
        channels = [channel for channel in self.curves if stream_name(channel) == sensor]
        grid = wrapped([f"{sensor}: {sampling_text(self.grids[sensor])}"] if sensor in self.grids else [])
        parts[sensor] = "\n".join(filter(None, [*grid, _table(self, channels)]))
    return {sensor: text for sensor, text in parts.items() if text}


def _table(analysis: Analysis, channels: Sequence[str]) -> str:
    fits = {channel: analysis.fits[channel] for channel in channels if channel in analysis.fits}
    if fits:
        return fit_table(fits, analysis.read_off, analysis.mean_stability)
    return read_off_table({channel: analysis.read_off[channel] for channel in channels if channel in analysis.read_off})


def legend(self: Analysis) -> str:
    """Explanation of the numbers of `sections`, or the reason why there are none."""
    if not self.fits and not self.read_off:
        return _without_coefficients(self)
    return fit_legend(self.fits, means=self.mean_stability) if self.fits else read_off_legend(self.read_off)


def coefficients(self: Analysis) -> str:
    """Table of all coefficients without the legend, or the reason why there are none."""
    return _table(self, [*self.curves]) or _without_coefficients(self)


def html(self: Analysis) -> str:
    """Overview as a table for a notebook, with a small picture of each curve."""
    from html import escape

    items = "".join(f"<li>{escape(line)}</li>" for line in causes(self.findings, rest="analysis.findings"))
    if not self.fits:
        return f"<p>{escape(headline(self))}</p><pre>{escape(coefficients(self))}</pre><ul>{items}</ul>"
    from sigmatau.plot.terminal import sparkline

    head, *rows = text_rows(main_coefficients(self.fits, self.findings))
    shown = [(*head, "σ(τ)")]
    for row in rows:
        curve = self.curves.get(row[0])
        shown.append((*row, "" if curve is None else sparkline(curve.tau, curve.adev)))
    return f"<p>{escape(headline(self))}</p>{html_table(shown, ready={len(head)})}<ul>{items}</ul>"


def printed(self: Analysis) -> str:
    """Overview with the relevant findings."""
    return "\n".join([overview(self), *causes(self.findings, rest="analysis.findings")])
