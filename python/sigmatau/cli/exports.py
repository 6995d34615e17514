"""``sigmatau analyze --export``: files for other programs, from the analysis itself."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from sigmatau.analysis import Analysis
from sigmatau.cli.choosing import Choosing
from sigmatau.cli.options import finding_lines, say
from sigmatau.errors import OptionError
from sigmatau.export import Choices, Numbers, check_choices, check_path, target

__all__ = ["Exports"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Exports:
    """Files by target, and what was chosen for them."""

    files: Mapping[str, Path]
    choices: Choices

    @classmethod
    def of(cls, given: Sequence[str], choosing: Choosing | None, *, rate: float | None, method: str) -> Exports:
        """Refuse, before a long log is read, what can be refused then; raises `OptionError`."""
        choosing = choosing or Choosing()
        option = choosing.given()
        if option and not given:
            raise OptionError(f"{option} is for --export, e.g. --export kalibr=imu.yaml", option="export")
        files: dict[str, Path] = {}
        for text in given:
            name, equals, path = text.partition("=")
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
        for name, file in files.items():
            check_choices(target(name), choices)
            check_path(target(name), file)
        return cls(files=files, choices=choices)

    def write(self, analysis: Analysis, *, result: Path | None, quiet: bool) -> None:
        """Write all that can be written; then raise `OptionError` or `DataError` of the first that cannot.

        `result` is the JSON that has been written, from which another try needs no second analysis.
        """
        again = "" if result is None else f"; sigmatau export {result} needs no second analysis"
        failed: ValueError | None = None
        if self.files:
            for line in finding_lines(Numbers(analysis.model, self.choices).not_used()):
                say(line, quiet=quiet)
        for name, path in self.files.items():
            try:
                analysis.export(to=name, path=path, choices=self.choices)
            except OptionError as error:
                failed = failed or OptionError(f"--export {name}: {error}{again}", option=error.option)
            except ValueError as error:
                failed = failed or error
            else:
                say(f"{path}: written for {name}", quiet=quiet)
        if failed is not None:
            raise failed
