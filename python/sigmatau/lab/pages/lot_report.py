"""`lot_report`: a lot as a page, a document to print, a workbook, a table, JSON, or JUnit XML."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from datetime import UTC, datetime
from pathlib import Path
from xml.etree import ElementTree as ET

from sigmatau import __version__
from sigmatau.errors import OptionError
from sigmatau.io.atomic import atomic
from sigmatau.lab.lots.lot_remark import Remark
from sigmatau.lab.lots.lot_result import JudgedUnit, Lot
from sigmatau.lab.lots.lot_words import STATE_WORDS
from sigmatau.results import csv_text, printable

LOT_ENDINGS = (".html", ".pdf", ".xlsx", ".csv", ".json", ".xml")
"""Extensions of the files of a lot."""

_NOT_XML = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def lot_report(
    lot: Lot,
    path: str | Path,
    *,
    title: str = "Lot",
    command: str | None = None,
    date: datetime | None = None,
    reports: Mapping[str, str] | None = None,
    decimal_comma: bool = False,
) -> None:
    """Write a lot to a file, by its extension.

    Parameters
    ----------
    lot : Lot
        Result of `sigmatau.judge_lot`.
    path : str or Path
        ``.html``: a page that opens offline, with charts. ``.pdf``: to print; needs ``pip install 'sigmatau[pdf]'``.
        ``.xlsx``: a row of numbers for each unit; needs ``pip install 'sigmatau[excel]'``.
        ``.csv``: one row per unit, channel and coefficient, in SI. ``.json``: all numbers, in SI. ``.xml``: JUnit, one test
        case per unit: a unit that failed is a failure, and one that is not judged, not read or missing is an error.
    title : str
        Title of the page.
    command : str, optional
        Command that made the report, to be printed in it.
    date : datetime, optional
        Date of the report. Default: now.
    reports : mapping of str to str, optional
        Addresses of reports by the name of the unit, relative to the page, to which the names of units link.
    decimal_comma : bool
        Whether a ``.csv`` has decimal commas, and semicolons between the columns.

    Raises
    ------
    OptionError
        For another extension.
    DataError
        If the file cannot be written.
    ImportError
        For a PDF without typst, or a workbook without XlsxWriter.

    See Also
    --------
    judge_lot : makes the lot.

    Examples
    --------
    >>> import tempfile
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    >>> lot = st.judge_lot([st.analyze(st.simulate(model, duration=600, rate=10, rng=k)) for k in range(3)])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     st.lot_report(lot, f"{folder}/lot.html")
    """
    file = Path(path)
    ending = file.suffix.lower()
    if ending not in LOT_ENDINGS:
        raise OptionError(f"{{option}} {file.name!r}: the name must end in {', '.join(LOT_ENDINGS)}", option="path")
    moment = datetime.now(tz=UTC) if date is None else date
    made: bytes
    if ending == ".json":
        made = (json.dumps(lot.to_dict(), indent=1, allow_nan=False, ensure_ascii=False) + "\n").encode()
    elif ending == ".csv":
        made = csv_text(lot.columns(), decimal_comma=decimal_comma).encode()
    elif ending == ".xml":
        made = junit(lot, moment).encode()
    elif ending == ".xlsx":
        from sigmatau.lab.pages.lot_xlsx import workbook

        made = workbook(lot, command=command, date=moment)
    elif ending == ".pdf":
        from sigmatau.lab.pages.lot_pdf import document

        made = document(lot, title=title, command=command, date=moment)
    else:
        from sigmatau.lab.pages.lot_html import page

        made = page(lot, title=title, command=command, date=moment, reports=reports or {}).encode()
    with atomic(file) as temporary:
        temporary.write_bytes(made)


def junit(lot: Lot, date: datetime) -> str:
    """The lot as JUnit XML."""
    counts = {
        "tests": len(lot.units),
        "failures": len(lot.of("failed")),
        "errors": sum(_is_error(u, lot) for u in lot.units),
    }
    head = {**{key: str(n) for key, n in counts.items()}, "time": "0", "timestamp": f"{date:%Y-%m-%dT%H:%M:%S}"}
    name = "no specification" if lot.spec is None else lot.spec.name
    suites = ET.Element("testsuites", {"name": f"sigmatau {__version__}", **head})
    suite = ET.SubElement(suites, "testsuite", {"name": _xml(printable(f"lot against {name}")), **head})
    for unit in lot.units:
        attributes = {"classname": "lot", "name": _xml(printable(unit.name)), "time": "0"}
        case = ET.SubElement(suite, "testcase", attributes)
        for tag, kind, message, remarks in _parts(unit, lot):
            described = {"type": kind, "message": _xml(printable(message))} if message else {}
            ET.SubElement(case, tag, described).text = _xml("\n".join(remark.text for remark in remarks))
    ET.indent(suites, " ")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{ET.tostring(suites, encoding="unicode")}\n'


def _is_error(unit: JudgedUnit, lot: Lot) -> bool:
    """Whether a unit is an error of the suite. Without a specification, a unit without remarks is not an error."""
    if unit.state in ("passed", "failed"):
        return False
    return not (lot.spec is None and all(remark.code == "no_specification" for remark in unit.reasons))


def _parts(unit: JudgedUnit, lot: Lot) -> Iterator[tuple[str, str, str, tuple[Remark, ...]]]:
    """Yield the elements of a test case: tag, type, message and remarks."""
    if unit.state == "failed":
        yield "failure", unit.reasons[0].code, unit.reason, unit.reasons
    elif _is_error(unit, lot):
        yield "error", unit.state, f"{STATE_WORDS[unit.state]}: {unit.reason}", unit.reasons
    if unit.notes:
        yield "system-out", "", "", unit.notes


def _xml(text: str) -> str:
    """Text without the characters that XML cannot hold."""
    return _NOT_XML.sub("\ufffd", text)
