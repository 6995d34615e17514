"""`report`: the page of an analysis that can be passed on."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

from sigmatau.errors import OptionError
from sigmatau.io.atomic import atomic

if TYPE_CHECKING:
    from sigmatau.analysis import Analysis
    from sigmatau.record.record import Record
    from sigmatau.reporting.certificate import Certificate

ENDINGS = (".html", ".pdf")
"""Extensions of a report."""


def report(
    analysis: Analysis,
    path: str | Path,
    *,
    record: Record | None = None,
    notes: Mapping[str, str] | None = None,
    command: str | None = None,
    date: datetime | None = None,
    certificate: Certificate | None = None,
) -> None:
    """Write the report of an analysis: one file that opens offline and can be printed.

    It has the coefficients with their intervals, the findings, Allan deviations with the model, power spectral densities,
    residuals, the time series with what was left out, the dynamic Allan deviation, values for filters, and what was done.

    Parameters
    ----------
    analysis : Analysis
        Result of `sigmatau.analyze`.
    path : str or Path
        ``.html``: with charts to zoom and read, and buttons that save them. ``.pdf``: to print; needs
        ``pip install 'sigmatau[pdf]'``.
    record : Record, optional
        The record that was given to `analyze`. Without it the report has no densities, no time series and no dynamic
        Allan deviation.
    notes : mapping of str to str, optional
        Information about the record for the head of the report: ``{"serial number": "A123", "operator": "N. N."}``.
    command : str, optional
        Command that made the report, to be printed in it.
    date : datetime, optional
        Date of the analysis. Default: now.
    certificate : Certificate, optional
        Page 1 for the signature of a laboratory, see `sigmatau.certify`. Default: none.

    Raises
    ------
    OptionError
        For another extension, or a record that is not that of the analysis.
    DataError
        If the file cannot be written.
    ImportError
        For a PDF without typst.

    See Also
    --------
    Analysis.plot : a figure alone.
    Analysis.to_dict : the numbers for programs.

    Examples
    --------
    >>> import tempfile
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    >>> record = st.simulate(model, duration=600, rate=100, rng=1)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     st.report(st.analyze(record), f"{folder}/report.html", record=record)
    """
    file = Path(path)
    if file.suffix.lower() not in ENDINGS:
        raise OptionError(f"{{option}} {file.name!r}: the name must end in {' or '.join(ENDINGS)}", option="path")
    from sigmatau.reporting.content import collect_content

    content = collect_content(analysis, record, notes=notes, command=command, date=date, certificate=certificate)
    if file.suffix.lower() == ".html":
        from sigmatau.reporting.html import page

        made = page(content).encode()
    else:
        from sigmatau.reporting.pdf import document

        made = document(content)
    with atomic(file) as temporary:
        temporary.write_bytes(made)
