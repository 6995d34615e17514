"""``sigmatau analyze --export``: files for other programs from the analysis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from sigmatau.analysis import Analysis
from sigmatau.cli.export_options import Choosing, as_typed, print_findings
from sigmatau.cli.options import say
from sigmatau.errors import OptionError
from sigmatau.exporting.choices import Choices
from sigmatau.exporting.prepare import check_all, check_path, prepare_all
from sigmatau.exporting.targets import target

__all__ = ["Exports"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Exports:
    """Files by target, and the options for them."""

    files: Mapping[str, Path]
    choices: Choices

    @classmethod
    def of(cls, given: Sequence[str], choosing: Choosing | None, *, rate: float | None, method: str) -> Exports:
        """Check the options before a long log is read; raises `OptionError`."""
        choosing = choosing or Choosing()
        option = choosing.given()
        if option and not given:
            raise OptionError(f"{option} needs --export, e.g. --export kalibr=imu.yaml", option="export")
        files: dict[str, Path] = {}
        for text in given:
            name, equals, path = text.partition("=")
            name = name.lower()
            if not (name and equals and path):
                raise OptionError(
                    f"--export {text!r}: want TARGET=FILE, e.g. --export kalibr=imu.yaml", option="export"
                )
            if name in files:
                raise OptionError(f"--export: {name} is given twice", option="export")
            files[name] = Path(path)
        if files and method != "gls":
            raise OptionError("--export needs the fit: --method gls", option="method")
        choices = choosing.choices(rate)
        with as_typed():
            for name, file in files.items():
                check_path(target(name), file)
            check_all(files, choices)
        return cls(files=files, choices=choices)

    def write(self, analysis: Analysis, *, result: Path | None, quiet: bool) -> None:
        """Write all files, or none if one fails; raises `OptionError` or `DataError`.

        `result` is the written JSON, which allows another attempt without a second analysis.
        """
        if not self.files:
            return
        again = "" if result is None else f"; sigmatau export {result} needs no second analysis"
        with as_typed("--export ", again):
            files = prepare_all(analysis, self.files, choices=self.choices, named=True)
        print_findings((finding for file in files for finding in file.findings), quiet=quiet)
        for file in files:
            file.write()
            say(f"{file.path}: written for {file.to}", quiet=quiet)
