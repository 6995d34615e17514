"""A lot as an Excel workbook: a row of numbers for each unit, and the distributions."""

from __future__ import annotations

import io
from datetime import datetime
from typing import Any

from sigmatau import __version__
from sigmatau.lab.lots.lot_result import Lot
from sigmatau.lab.lots.lot_words import STATE_WORDS, what_text, what_unit
from sigmatau.lab.pages.lot_content import (
    DISTRIBUTION_HEADS,
    claim_rows,
    distribution_rows,
    done_rows,
    moment_text,
    worst_share,
)
from sigmatau.results import printable

_LONGEST_CELL = 32_767  # largest length of a cell in Excel [characters]
_WIDTHS = (18, 12, 50, 13)  # widths of the columns unit, state, reason and share of the maximum [characters]


def workbook(lot: Lot, *, command: str | None, date: datetime) -> bytes:
    """The lot as a workbook with the sheets Units, Distribution and What was done.

    Names and reasons are text, even if they begin with ``=``. The heading of a coefficient has its unit. If a record does
    not show a coefficient, its value is empty and its upper limit is stated.
    """
    try:
        import xlsxwriter
    except ImportError:
        raise ImportError("writing .xlsx needs XlsxWriter: pip install 'sigmatau[excel]'; or write .csv") from None
    content = io.BytesIO()
    # `strings_to_…`: a name is never a formula, a link or a number
    options = {"in_memory": True, "strings_to_formulas": False, "strings_to_urls": False, "strings_to_numbers": False}
    with xlsxwriter.Workbook(content, options) as book:
        book.set_properties(
            {"title": "Lot", "comments": f"sigmatau {__version__}", "created": date.replace(tzinfo=None)}
        )
        _units(book, lot)
        _texts(book, "Distribution", [DISTRIBUTION_HEADS, *distribution_rows(lot)] if lot.distributions else [])
        claims = [("Sensor", "Value", "Maximum", "Typical", "Convention"), *claim_rows(lot)] if lot.spec else []
        _texts(book, "What was done", [*done_rows(lot, command, moment_text(date)), *claims])
    return content.getvalue()


def _units(book: Any, lot: Lot) -> None:  # noqa: ANN401  XlsxWriter has no types
    sheet = book.add_worksheet("Units")
    columns = []
    for distribution in lot.distributions:
        quantity, rate_unit = lot.quantity_of(distribution.channel)
        shown = what_unit(distribution.what, quantity, rate_unit, [distribution.median])
        columns.append((distribution.channel, distribution.what, *shown))
    heads = ["Unit", "State", "Reason", "% of maximum"]
    for channel, what, text, _ in columns:
        label = f"{printable(channel)} {what_text(what, lot.quantity_of(channel)[0])}"
        heads += [f"{label} [{text}]", "95 % low", "95 % high", "upper limit"]
    head = book.add_format({"bold": True, "text_wrap": True, "valign": "top", "bottom": 1})
    sheet.write_row(0, 0, heads, head)
    sheet.freeze_panes(1, 1)
    for column, width in enumerate(_WIDTHS):
        sheet.set_column(column, column, width)
    sheet.set_column(len(_WIDTHS), len(heads), 11)
    sheet.autofilter(0, 0, max(len(lot.units), 1), len(heads) - 1)
    number = book.add_format({"num_format": "0.000E+00"})
    plain = book.add_format({"num_format": "0.###"})
    for row, unit in enumerate(lot.units, 1):
        for column, text in enumerate((unit.name, STATE_WORDS[unit.state], unit.reason)):
            sheet.write_string(row, column, printable(text)[:_LONGEST_CELL])
        share = worst_share(unit)
        if share is not None:
            sheet.write_number(row, 3, 100 * share, plain)
        for k, (channel, what, _, factor) in enumerate(columns):
            part = unit.result.channels.get(channel)
            coefficient = None if part is None else part.coefficients.get(what)
            if coefficient is None:
                continue
            values = (coefficient.value, coefficient.low, coefficient.high, coefficient.limit)
            for offset, value in enumerate(values):
                if value is not None:
                    sheet.write_number(row, len(_WIDTHS) + 4 * k + offset, value / factor, number)


def _texts(book: Any, title: str, rows: list[Any]) -> None:  # noqa: ANN401
    sheet = book.add_worksheet(title)
    for row, cells in enumerate(rows):
        for column, cell in enumerate(cells):
            sheet.write_string(row, column, cell[:_LONGEST_CELL])
    sheet.set_column(0, 12, 20)
