"""Output files of an analysis of one log, or output folders for several logs."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from sigmatau.analysis import Analysis
from sigmatau.cli.attempts import Attempts
from sigmatau.cli.choosing import Exports
from sigmatau.cli.earlier import curves_path
from sigmatau.cli.options import check_outputs, command_line, drawing, working, write_csv, write_figure, write_json
from sigmatau.frozen import frozen
from sigmatau.record.record import Record

if TYPE_CHECKING:
    from sigmatau.reporting.certificate import Certificate
    from sigmatau.reporting.certificate_file import CertificateFile

NOT_AT_REST = 5
"""Exit code if the sensor is not at rest, or the record is too short to tell."""

_ENDINGS = {"csv": ".csv", "json": ".json", "report": ".html", "plot": ".png", "stability": ".png"}
"""Endings of the files in the folders of several logs."""


@frozen
class Outputs:
    """Output files, or output folders for several logs."""

    report: Path | None
    notes: Mapping[str, str]
    plot: Path | None
    stability: Path | None
    json: Path | None
    csv: Path | None
    style: Literal["screen", "paper"]
    certificate: CertificateFile | None = None

    @property
    def paths(self) -> dict[str, Path]:
        """The requested outputs, by option."""
        return {option: getattr(self, option) for option in _ENDINGS if getattr(self, option) is not None}

    @property
    def files(self) -> dict[str, Path]:
        """Requested output files, by option, without standard output."""
        return {option: path for option, path in self.paths.items() if str(path) != "-"}

    def check(self, logs: Sequence[Path], exports: Exports) -> None:
        """Check all files of a command, before a log is read."""
        named = {f"export {name}": path for name, path in exports.files.items()}
        curves = {} if self.csv is None else {"csv curves": curves_path(self.csv)}
        read = () if self.certificate is None else self.certificate.files
        check_outputs([*logs, *read], **self.files, **named, **curves)

    def check_record(self, record: Record) -> None:
        """Raise the errors of the certificate, before the analysis."""
        if self.certificate is not None:
            from sigmatau.lab.pages.certify import check_certificate

            check_certificate(self.certificate, record)

    def inside(self, name: str) -> Outputs:
        """Output files of one log in the folders for several logs."""
        files: dict[str, Any] = {option: folder / f"{name}{_ENDINGS[option]}" for option, folder in self.paths.items()}
        return replace(self, **files)

    def write(
        self,
        attempts: Attempts,
        analysis: Analysis,
        content: Callable[[], Mapping[str, Any]],
        *,
        record: Record | None = None,
        quiet: bool,
    ) -> None:
        """Write the files, the numbers first. `content`: returns the JSON; `record`: the record for the report."""
        files = self.files
        if "csv" in files:
            with attempts.attempt():
                write_csv(analysis, files["csv"])
        if "json" in files:
            with attempts.attempt():
                write_json(content(), files["json"])
        if "report" in files:
            from sigmatau.reporting.report import report as write_report

            with attempts.attempt(), working(f"writing {self.report}", quiet=quiet):
                write_report(
                    analysis,
                    files["report"],
                    record=record,
                    notes=self.notes,
                    command=command_line(),
                    certificate=self._page(analysis),
                )
        if "plot" in files:
            with attempts.attempt(), drawing(files["plot"], self.style, quiet=quiet):
                write_figure(analysis.plot(style=self.style), files["plot"])
        if "stability" in files and analysis.stability:
            with attempts.attempt(), drawing(files["stability"], self.style, quiet=quiet):
                write_figure(analysis.plot_stability(), files["stability"])

    def _page(self, analysis: Analysis) -> Certificate | None:
        """Page 1 of the report, if there is a certificate."""
        if self.certificate is None:
            return None
        from sigmatau.lab.pages.certify import certify

        return certify(analysis, self.certificate)


def worst_code(codes: Collection[int]) -> int:
    """Exit code for several logs: the worst of their codes."""
    return next((code for code in (2, 1, NOT_AT_REST, 4) if code in codes), 0)
