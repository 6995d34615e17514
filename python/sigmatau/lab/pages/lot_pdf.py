"""A lot as a PDF, typeset by typst. All texts are passed to typst as data, so that a file name is never interpreted as
markup.
"""

from __future__ import annotations

from dataclasses import replace
from datetime import datetime
from typing import Any

import numpy as np

from sigmatau import __version__
from sigmatau.lab.lots.lot_plot import curves_svg, values_svg
from sigmatau.lab.lots.lot_remark import STATES
from sigmatau.lab.lots.lot_result import Lot
from sigmatau.lab.lots.lot_screen import drift_lines, listed_units
from sigmatau.lab.lots.lot_words import STATE_WORDS, count_text
from sigmatau.lab.lots.pooling import pooled
from sigmatau.lab.pages.lot_content import (
    DISTRIBUTION_HEADS,
    MARKS,
    claim_rows,
    distribution_rows,
    done_rows,
    moment_text,
    number_columns,
    unit_values,
)
from sigmatau.lab.pages.sheet import cut_text, sheet
from sigmatau.plot.curves import COLOURS
from sigmatau.reporting.pdf import typeset

_WIDTH, _HEIGHT = 86.0, 48.0  # size of a figure [mm]
_MOST_DOUBTS = 200  # largest number of units that are listed with their reason; the other files list all
_LONGEST_NAME, _LONGEST_TEXT = 60, 300  # largest length of a name, and of a reason or a setting [characters]
_MOST_CURVES = 150  # largest number of units whose curves are drawn; among more units, every n-th is drawn


def document(lot: Lot, *, title: str, command: str | None, date: datetime) -> bytes:
    """The lot as a PDF. The same lot and date give the same bytes."""
    values = _values(lot, title, command, date)
    return bytes(typeset(sheet("lot.typ"), values, format="pdf", timestamp=date.replace(microsecond=0)))


def _values(lot: Lot, title: str, command: str | None, date: datetime) -> dict[str, Any]:
    spec = "" if lot.spec is None else lot.spec.name
    shown = listed_units(lot)
    order = {state: k for k, state in enumerate(STATES)}
    columns = number_columns(lot)
    return {
        "title": cut_text(f"{title}: {spec}" if spec else title, 2 * _LONGEST_NAME),
        "date": moment_text(date),
        "made_by": f"sigmatau {__version__}",
        "chips": [[f"{n} {STATE_WORDS[state]}", MARKS[state]] for state, n in lot.counts.items() if n],  # type: ignore[index]
        "words": count_text(lot.counts, spec=spec) + ".",  # type: ignore[arg-type]
        "drifts": drift_lines(lot, width=None),
        "claims": claim_rows(lot),
        "doubts": [
            [
                cut_text(unit.name, _LONGEST_NAME),
                STATE_WORDS[unit.state],
                MARKS[unit.state],
                cut_text(unit.brief, _LONGEST_TEXT),
            ]
            for unit in shown[:_MOST_DOUBTS]
        ],
        "heads": list(DISTRIBUTION_HEADS),
        "distributions": [[cut_text(cell, _LONGEST_TEXT) for cell in row] for row in distribution_rows(lot)],
        "width": _WIDTH,
        "values": _value_figures(lot),
        "curves": _curve_figures(lot),
        "columns": [head for _, _, head, _ in columns],
        "units": [
            [
                cut_text(unit.name, _LONGEST_NAME),
                STATE_WORDS[unit.state],
                MARKS[unit.state],
                *unit_values(unit, columns),
            ]
            for unit in sorted(lot.units, key=lambda unit: order[unit.state])
        ],
        "done": [[key, cut_text(text, _LONGEST_TEXT)] for key, text in done_rows(lot, command, moment_text(date))],
    }


def _curve_figures(lot: Lot) -> list[dict[str, Any]]:
    figures = []
    for band in lot.bands:
        if not len(band.tau):
            continue
        panel, marked = lot.curves_of(band), lot.marked(band.channel)
        unmarked = [name for name in panel.units if name not in marked]
        drawn = {*marked, *(unmarked[:: -(-len(unmarked) // _MOST_CURVES) or 1])}
        shown = {name: curve for name, curve in panel.units.items() if name in drawn}
        svg = curves_svg(replace(panel, units=shown), marked, width=_WIDTH, height=_HEIGHT)
        legend = [[cut_text(name, 20), colour] for name, colour in zip(marked, COLOURS[1:], strict=False)]
        figures.append(
            {"title": cut_text(band.channel, _LONGEST_NAME), "unit": panel.unit, "svg": svg, "legend": legend}
        )
    return figures


def _value_figures(lot: Lot) -> list[dict[str, Any]]:
    figures = []
    number = {unit.name: k for k, unit in enumerate(lot.units, 1)}
    for row in pooled(lot):
        shown = row.distributions[: len(COLOURS)]
        series = [(np.array([number[name] for name in d.units], dtype=float), d.values / row.factor) for d in shown]
        svg = values_svg(series, row.limits, last=len(lot.units), width=_WIDTH, height=_HEIGHT)
        legend = [[cut_text(d.channel, 20), colour] for d, colour in zip(shown, COLOURS, strict=False)]
        figures.append({"title": cut_text(row.title, _LONGEST_NAME), "unit": row.unit, "svg": svg, "legend": legend})
    return figures
