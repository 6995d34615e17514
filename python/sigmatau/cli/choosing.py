"""Options of an export, shared by ``sigmatau export`` and ``sigmatau analyze --export``. The export modules are imported
when they are used.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from sigmatau.cli.declared import DeclaredOptions, typed_options
from sigmatau.cli.options import finding_lines, say
from sigmatau.cli.reading import ReadingOptions
from sigmatau.errors import DataError, OptionError
from sigmatau.exporting.choices import Choices
from sigmatau.findings.finding import Finding
from sigmatau.frozen import frozen
from sigmatau.record.record import stream_name
from sigmatau.typed.forms import spelled

if TYPE_CHECKING:
    from cyclopts.completion import CompletionContext

    from sigmatau.analysis import Analysis
    from sigmatau.cli.attempts import Attempts
    from sigmatau.record.record import Record


@typed_options(Choices)
class Choosing(DeclaredOptions):
    """Options of an export."""

    def choices(self) -> Choices:
        """The `Choices` of these options; raises `OptionError`."""
        return Choices(**self.arguments())

    def first_option(self) -> str | None:
        """First option that was given, as typed on the command line; None without options."""
        for field in fields(cast("Any", self)):
            if getattr(self, field.name) != field.default:
                return f"--{spelled(field.name)}"
        return None


def targets_for_shell(context: CompletionContext) -> list[str]:
    """Names of the targets for completion of ``--to``; for ``--export``, each is followed by ``=``."""
    from sigmatau.exporting.targets import NAMES

    return [f"{name}=" if context.argument.name == "--export" else name for name in NAMES]


@contextmanager
def _name_export(after: str = "", name: str = "") -> Iterator[None]:
    """Add the target and the option before the error of an export, and the alternatives after it."""
    try:
        yield
    except (OptionError, DataError) as error:
        wrong = error.about(name) if name else error
        if isinstance(wrong, DataError):
            raise wrong from None
        raise OptionError(f"--export {wrong.text}{after}", option=wrong.option) from None


def print_findings(findings: Iterable[Finding], *, quiet: bool) -> None:
    """Print findings of an export, each once."""
    for line in finding_lines(list(dict.fromkeys(findings))):
        say(line, quiet=quiet)


_ANY_RATE = 100.0  # placeholder for the rate that a log states [Hz]


def _axes(sensor: str, channels: Sequence[str]) -> list[str]:
    """Channels of a sensor that an option selects: three axes if it names the sensor or is empty."""
    named = [name for name in channels if name.startswith(f"{sensor}_")]
    return named or [f"{sensor}_{axis}" for axis in "xyz"]


@frozen
class Exports:
    """Files by target, and the options for them."""

    files: Mapping[str, Path]
    choices: Choices | None = None  # None without files

    @classmethod
    def parse(cls, exports: Sequence[str], choosing: Choosing | None, *, method: str) -> Exports:
        """Check the options before a long log is read; raises `OptionError`."""
        choosing = choosing or Choosing()
        option = choosing.first_option()
        if option and not exports:
            raise OptionError(f"{option} needs --export, e.g. --export kalibr=imu.yaml", option="export")
        if not exports:
            return cls(files={})
        from sigmatau.exporting.export import check_all, check_path
        from sigmatau.exporting.targets import target

        files: dict[str, Path] = {}
        for text in exports:
            name, equals, path = text.partition("=")
            name = name.lower()
            if not (name and equals and path):
                raise OptionError(
                    f"--export {text!r}: want TARGET=FILE, e.g. --export kalibr=imu.yaml", option="export"
                )
            if name in files:
                raise OptionError(f"--export: {name} is given twice", option="export")
            files[name] = Path(path)
        if method == "read-off":
            raise OptionError("--export needs a fit: --method likelihood", option="method")
        choices = choosing.choices()
        for name, file in files.items():
            check_path(target(name), file)
        check_all(files, choices)
        return cls(files=files, choices=choices)

    def check_reading(self, reading: ReadingOptions | None) -> None:
        """Raise an error, before a log is read, if the reading options exclude a sensor or a common rate that the targets
        need.
        """
        how = (reading or ReadingOptions()).arguments() if self.files else {}
        channels = [name for name in how.get("channels") or {} if name != "time"]
        rates = how.get("rate")
        stated: dict[str, float] = rates if isinstance(rates, dict) else {}
        if channels:
            sensors = dict.fromkeys(map(stream_name, channels))
        elif {"gyro", "accel"} <= set(stated):
            sensors = dict.fromkeys(("gyro", "accel"))
        else:
            return
        # The rate of one sensor does not show whether the rates differ.
        known_rates = stated if all(sensor in stated for sensor in sensors) else dict.fromkeys(sensors, _ANY_RATE)
        self._check({name: dict.fromkeys(_axes(name, channels), known_rates[name]) for name in sensors})

    def check_record(self, record: Record) -> None:
        """Raise an error, before the analysis, if the record lacks data that the targets need."""
        self._check({stream.name: dict.fromkeys(stream.channels, stream.grid.rate) for stream in record.streams})

    def _check(self, rates: Mapping[str, Mapping[str, float]]) -> None:
        """Raise an error if these channels lack data that the targets need. `rates`: by sensor, rates by channel. [Hz]"""
        if not self.files or self.choices is None:
            return
        from sigmatau.exporting.choices import KINDS
        from sigmatau.exporting.export import check_record

        with _name_export():
            check_record(
                self.files, self.choices, {name: by_channel for name, by_channel in rates.items() if name in KINDS}
            )

    def write(self, attempts: Attempts, analysis: Analysis, *, result: Path | None, quiet: bool) -> None:
        """Write each file that can be written.

        `result`: the written JSON, from which a failed export can be repeated without an analysis.
        """
        if not self.files or self.choices is None:
            return
        from sigmatau.exporting.export import Prepared, place_choices, prepare_placed

        again = "" if result is None else f"; sigmatau export {result} needs no second analysis"
        made: list[Prepared] = []
        with attempts.attempt(), _name_export(again):
            source = analysis.to_source()
            placed = place_choices(source, self.files, self.choices)
            for name, path in self.files.items():
                with attempts.attempt(), _name_export(again, name):
                    made.append(prepare_placed(source, to=name, path=path, placed=placed[name]))
        print_findings((finding for file in made for finding in file.findings), quiet=quiet)
        for file in made:
            with attempts.attempt():
                file.write()
                say(f"{file.path}: written for {file.to}", quiet=quiet)
