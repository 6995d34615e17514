"""Reports of the units of a lot, with a certificate as page 1 if a laboratory signs them."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from sigmatau.analysis import Analysis
from sigmatau.cli.options import check_folder, command_line, refuse_same
from sigmatau.errors import DataError, OptionError
from sigmatau.frozen import frozen
from sigmatau.lab.datasheets.sheet import Datasheet
from sigmatau.reporting.report import report
from sigmatau.results import printable

if TYPE_CHECKING:
    from sigmatau.lab.lots.lot_result import Lot
    from sigmatau.record.record import Record
    from sigmatau.reporting.certificate import Certificate
    from sigmatau.reporting.certificate_file import CertificateFile

_FIRST_UNITS = 2  # units without a certificate for one reason of its file, after which a lot is ended


@frozen
class UnitReports:
    """The folder of the reports, and the facts of their certificates; it is sent to other processes."""

    folder: Path
    command: str
    certificate: CertificateFile | None = None

    def place(self, unit: str) -> Path:
        """The report of a unit: a PDF to sign, or a page."""
        return self.folder / f"{unit}{'.html' if self.certificate is None else '.pdf'}"

    def write(self, unit: str, analysis: Analysis, record: Record) -> None:
        """Write the report of a unit. A unit that cannot have a certificate gets none, see `refusal`."""
        page = self._page(unit, analysis)
        if not isinstance(page, DataError):
            report(analysis, self.place(unit), record=record, command=self.command, certificate=page)

    def refusal(self, unit: str, analysis: Analysis) -> str:
        """Why a unit has no certificate; empty if it has one, or if none was asked for."""
        page = self._page(unit, analysis)
        return str(page) if isinstance(page, DataError) else ""

    def refuse_file(self, refusals: Sequence[str]) -> None:
        """Raise an error if the file of the facts keeps the first units from having a certificate, all for one reason."""
        if self.certificate is None or len(refusals) != _FIRST_UNITS or len({*refusals}) > 1:
            return
        path = str(self.certificate.path)
        if refusals[0].startswith(f"{path}: "):
            raise DataError(refusals[0].removeprefix(f"{path}: ")).about(path)

    def links(self, units: Iterable[str], page: Path) -> dict[str, str]:
        """Addresses of the reports of units, relative to the folder of the page of the lot; those that exist."""
        places = {unit: self.place(unit) for unit in units}
        return {
            unit: Path(os.path.relpath(place, page.parent)).as_posix()
            for unit, place in places.items()
            if place.is_file()
        }

    def _page(self, unit: str, analysis: Analysis) -> Certificate | DataError | None:
        if self.certificate is None:
            return None
        from sigmatau.lab.pages.certify import certify

        try:
            return certify(analysis, self.certificate.of_unit(unit))
        except DataError as error:
            return error


def read_unit_certificate(
    file: Path | None, *, reports: Path | None, unit_from: str | None, sheet: Datasheet | None
) -> CertificateFile | None:
    """Read the facts of ``--certificate`` before the logs. Raises `OptionError` if it lacks another option."""
    if file is None:
        return None
    if reports is None:
        raise OptionError("--certificate needs --reports FOLDER, for one PDF of each unit", option="certificate")
    if unit_from is None:
        raise OptionError(
            "--certificate needs --unit-from, e.g. '(SN[0-9]+)': a unit's name is its serial number",
            option="unit_from",
        )
    from sigmatau.lab.pages.certify import check_certificate, read_decision
    from sigmatau.reporting.certificate_file import read_certificate
    from sigmatau.reporting.pdf import need_typst

    need_typst()
    facts = read_certificate(file, each_unit=True)
    check_certificate(facts)
    basis = read_decision(facts)
    if sheet is not None and basis is not None and basis[1].to_dict() != sheet.to_dict():
        raise OptionError(f"--spec is not decision.specification of {file}; a lot has one specification", option="spec")
    return facts


def open_reports(
    folder: Path | None, certificate: CertificateFile | None, *, results: Sequence[Path]
) -> UnitReports | None:
    """Create the folder of the reports; None without one. `results`: units without a log, which have no report."""
    if folder is None:
        return None
    if certificate is not None and results:
        raise DataError(f"{results[0]}: is a result. A certificate needs the log; give the logs")
    check_folder(folder, "reports")
    return UnitReports(folder=folder, command=command_line(), certificate=certificate)


def protect(outputs: Iterable[Path], *inputs: Path) -> None:
    """Raise an error if an output of the lot would replace a file that is read."""
    for output in outputs:
        for place in inputs:
            refuse_same(place, output=output)


def refuse_unit_files(outputs: Iterable[Path], unit_files: Iterable[Path]) -> None:
    """Raise an error if a file of the lot has the place of a report or a result of a unit."""
    taken = {file.resolve() for file in unit_files}
    for output in outputs:
        if output.resolve() in taken:
            raise OptionError(f"--output {output} is also a file of a unit; name another file", option="output")


def refusal_lines(refusals: Mapping[str, str]) -> list[str]:
    """Units without a certificate by reason, each reason once."""
    units: dict[str, list[str]] = {}
    for unit, reason in refusals.items():
        units.setdefault(reason, []).append(printable(unit))
    return [f"no certificate: {', '.join(names)}: {reason}" for reason, names in units.items()]


def unjudged_line(lot: Lot, refusals: Mapping[str, str]) -> list[str]:
    """Name the units with a certificate that the lot does not judge, because the reasons are not on the certificates."""
    units = [unit.name for unit in lot.units if unit.state == "not_judged" and unit.name not in refusals]
    if not units:
        return []
    return [f"certificates of units that are not judged: {', '.join(units)}. Read their reasons before you sign"]
