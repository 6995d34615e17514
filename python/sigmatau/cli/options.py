"""Progress, and checks of output files, for several commands."""

from __future__ import annotations

import contextlib
import glob
import json as json_module
import os
import re
import shutil
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.cli.earlier import curves_path, expect
from sigmatau.cli.words import is_number
from sigmatau.errors import DataError, OptionError
from sigmatau.findings.finding import Finding, line
from sigmatau.io.atomic import atomic
from sigmatau.io.folders import skipped_lines
from sigmatau.results import csv_text, printable

if TYPE_CHECKING:
    from sigmatau.analysis import Analysis
    from sigmatau.estimators.allan import DeviationCurve

_FIGURES = ("plot", "overlay", "stability")  # options that need matplotlib
ENDINGS: Mapping[str, Sequence[str]] = {
    **dict.fromkeys(_FIGURES, (".png", ".svg", ".pdf")),
    "report": (".html", ".pdf"),
    "csv": (".csv",),
    "model": (".toml",),
}
"""Allowed endings of an output, by option; all if the option is missing."""
_REPORTS = ("report", "output")  # options that need typst for a PDF
_DATABASE = b"SQLite format 3\0"  # first bytes of a database file
_PASSWORD = re.compile(r"(://[^\s/:@]*:|[?&]password=)[^\s@&]+")  # in the address of a database
_MIN_PLOT_LINES, _MAX_PLOT_LINES, _MAX_PANELS = 8, 12, 2  # sizes of the curves on the screen


def matched(
    places: Sequence[Path], *, keep: Callable[[Path], bool] | None = None, quiet: bool = False
) -> tuple[Path, ...]:
    """Expand patterns such as ``shift/*.csv``, because not every shell does. `keep`: of a pattern, only these files; the
    others are named on standard error.
    """
    files_named: list[Path] = []
    for place in places:
        _check_place(place)
        if not glob.has_magic(str(place)) or os.path.exists(place):  # noqa: PTH110  False for a name that is too long
            files_named.append(place)
            continue
        files = sorted(glob.glob(str(place), recursive=True))  # noqa: PTH207  a pattern with any root
        if not files:
            raise DataError(f"{place}: no file matches this pattern")
        matching = list(map(Path, files))
        wanted = matching if keep is None else list(filter(keep, matching))
        for text in skipped_lines([file for file in matching if file not in wanted]):
            say(text, quiet=quiet)
        if not wanted:
            raise DataError(f"{place}: no file that matches this pattern is a log")
        files_named += wanted
    return tuple(files_named)


def _check_place(place: Path) -> None:
    """Raise `OptionError` for a word that is not a file, but a value separated from its option."""
    word = str(place)
    if os.path.lexists(place):
        return
    if "=" in word and "/" not in word.partition("=")[0]:
        raise OptionError(
            f"{word!r} is not a file. Write it directly behind its option, e.g. --unit {word}", option="log"
        )
    if word.lower() in ("hz", "khz"):
        raise OptionError(f"{word!r} is not a file. Write a rate in Hz without the unit, e.g. --rate 100", option="log")
    if is_number(word):
        raise OptionError(
            f"{word!r} is not a file. Write a rate directly behind --rate, e.g. --rate {word}", option="log"
        )


def check_output(path: Path | None, endings: Sequence[str], option: str) -> None:
    """Raise an error for an output that cannot be written, before a long computation.

    An `ImportError` is raised if the library for a figure or a PDF report is missing.
    """
    if path is None:
        return
    if endings and not path.name.endswith(tuple(endings)):
        raise OptionError(f"--{option} {path}: the name must end in {', '.join(endings)}", option=option)
    if path.is_dir():
        raise DataError(f"{path}: is a directory; give the name of a file")
    if path.exists() and not path.is_file():
        raise DataError(f"{path}: is not a regular file, and would be replaced; give the name of a file")
    if not path.parent.is_dir():
        raise DataError(f"{path}: there is no directory {path.parent}")
    if not os.access(path.parent, os.W_OK):
        raise DataError(f"{path}: the directory {path.parent} is read-only; give another place")
    if _is_database(path):
        raise OptionError(f"--{option} {path}: is a database, and would be replaced; name another file", option=option)
    _need_libraries(path, option)


def _need_libraries(path: Path, option: str) -> None:
    """Raise an ImportError with the installation command if a library for an output is missing."""
    if option in _FIGURES:
        from sigmatau.plot.style import need_matplotlib

        need_matplotlib()
    elif option in _REPORTS and path.name.endswith(".pdf"):
        from sigmatau.reporting.pdf import need_typst

        need_typst()


def _is_database(path: Path) -> bool:
    """Whether a file is a SQLite database, such as a store."""
    try:
        with path.open("rb") as file:
            return file.read(len(_DATABASE)) == _DATABASE
    except OSError:
        return False


def check_folder(path: Path | None, option: str) -> None:
    """Create the folder for several results. Raise an error if the place is not a folder."""
    if path is None:
        return
    if str(path) == "-" or path.suffix.lower() in (".json", ".csv", ".png", ".svg", ".pdf", ".html") or path.is_file():
        raise OptionError(f"--{option} {path}: there are several logs, so this must be a folder", option=option)
    _need_libraries(path, option)
    try:
        path.mkdir(exist_ok=True)
    except OSError as error:
        raise DataError(f"{path}: cannot be created: {error.strerror or error}") from None


def refuse_same(log: Path, /, **outputs: Path | None) -> None:
    """Raise an error if an output, by option, would replace the log or another output."""
    options: dict[Path, str] = {}
    for option, path in outputs.items():
        if path is None:
            continue
        if path.exists() and log.exists() and path.samefile(log):
            raise OptionError(f"--{option} {path} is the file that is read; name another file", option=option)
        if options.setdefault(path, option) != option:
            raise OptionError(f"--{options[path]} and --{option} both name {path}; name two files", option=option)


def command_line() -> str:
    """The command line of this process, in a form that can be typed again; the password of an address is replaced."""
    import shlex

    hidden = (_PASSWORD.sub(r"\1…", argument) for argument in sys.argv[1:])
    return shlex.join(["sigmatau", *hidden])


def check_outputs(inputs: Sequence[Path], /, **outputs: Path | None) -> None:
    """Check the outputs of a command, by option, before a long computation; ``-`` is standard output.

    If the command fails, results of an earlier run in these places are removed, see `expect`.
    """
    files = {option: path for option, path in outputs.items() if path is not None and str(path) != "-"}
    for option, path in files.items():
        check_output(path, ENDINGS.get(option, ()), option)
    for each in inputs or [Path()]:
        refuse_same(each, **files)
    expect(*files.values())


def json_text(content: object, *, ascii_only: bool = False) -> str:
    """JSON as commands write it."""
    return json_module.dumps(content, indent=1, allow_nan=False, ensure_ascii=ascii_only) + "\n"


def _in_unicode() -> bool:
    """Whether standard output can encode all characters."""
    return "utf" in (sys.stdout.encoding or "").lower()


def write_json(content: object, path: Path) -> None:
    """Write a JSON file; an error leaves no file."""
    text = json_text(content)
    with atomic(path) as temporary:
        # Bytes of a file name that are not UTF-8 are written as JSON escapes.
        temporary.write_text(text, encoding="utf-8", errors="backslashreplace")


def write_csv(analysis: Analysis, path: Path) -> None:
    """Write the coefficients, and the curves to a second file. After an error neither file is half written."""
    for table, file in ((analysis, path), (analysis.curves, curves_path(path))):
        with atomic(file) as temporary:
            temporary.write_text(csv_text(table.columns()), encoding="utf-8")


def write_figure(figure: Any, path: Path) -> None:  # noqa: ANN401  matplotlib is optional
    """Write a figure; an error leaves no file."""
    from sigmatau.plot.curves import save

    with atomic(path) as temporary:
        save(figure, str(temporary))


@contextlib.contextmanager
def drawing(path: Path, style: str, *, quiet: bool) -> Iterator[None]:
    """Draw a figure in a style, and show its name as progress."""
    from sigmatau.plot.style import styled

    with working(f"drawing {path}", quiet=quiet), styled(style):
        yield


def check_style(style: str, *figures: Path | None) -> None:
    """Raise an error if a style is given without a figure."""
    if style != "screen" and not any(figures):
        raise OptionError(f"--style {style} needs a figure, e.g. --plot p.pdf", option="style")


def write_result(table: str, content: object, json: Path | None) -> None:
    """Print a table and write the JSON to its file, or print the JSON alone."""
    if json is not None and str(json) == "-":
        text = json_text(content)
        sys.stdout.write(text if text.isascii() or _in_unicode() else json_text(content, ascii_only=True))
        return
    if json is not None:
        write_json(content, json)
    if table:
        sys.stdout.write(table + "\n")


def finding_lines(findings: Sequence[Finding]) -> list[str]:
    """Format findings for a terminal, grouped by kind. An action that several findings of a kind share is printed once."""
    lines: list[str] = []
    kinds: dict[tuple[str, str], list[Finding]] = {}
    for finding in findings:
        kinds.setdefault((finding.severity, finding.code), []).append(finding)
    for alike in kinds.values():
        lines += dict.fromkeys(line(finding) for finding in alike)  # two tables of one logger may have the same gap
        lines += [f"  -> {action}" for action in dict.fromkeys(finding.action for finding in alike if finding.action)]
    return lines


def with_noise(values: Mapping[str, NDArray[np.float64]], what: str, *, quiet: bool) -> list[str]:
    """Select the channels whose values can be printed and drawn, and warn of the other channels. Raises `DataError` if
    none remains.

    A channel that never changes has no noise, and squares of numbers outside 1e−150 … 1e150 are 0 or not finite.
    """
    good = [name for name, numbers in values.items() if np.isfinite(numbers).all() and numbers.max(initial=0.0) > 0]
    unusable = [name for name in values if name not in good]
    why = f"never changes, or its numbers are too small or too large for a {what}"
    if not good:
        raise DataError(f"no channel is left: {', '.join(unusable)} {why}")
    for name in unusable:
        say(f"warning: {name}: it {why}; left out", quiet=quiet)
    return good


def screen(analysis: Analysis, *, below: int, legend: bool = True) -> str:
    """Overview for the width of the terminal, with the curves drawn in dots if the terminal supports them and is high
    enough.

    `below`: number of lines that follow. `legend`: see `Analysis.overview`.
    """
    size = shutil.get_terminal_size()
    if not sys.stdout.isatty():
        return analysis.overview(legend=legend)
    text = analysis.overview(width=size.columns, legend=legend)
    panels: dict[str, dict[str, DeviationCurve]] = {}
    for channel, curve in analysis.curves.items():
        panels.setdefault(f"{curve.quantity} {curve.unit}", {})[channel] = curve
    height = min(size.lines - len(text.splitlines()) - below - 2, _MAX_PLOT_LINES)
    if height < _MIN_PLOT_LINES or not _in_unicode() or len(panels) > _MAX_PANELS:
        return text
    from sigmatau.plot.terminal import text_plot

    width = (size.columns - 1) // len(panels) - 1
    drawn = [text_plot(panel, width=width, height=height) for panel in panels.values()]
    rows = zip(*(lines for lines in drawn if lines), strict=True)
    return "\n".join([text, *("  ".join(line.ljust(width) for line in row).rstrip() for row in rows)])


def say(message: str, *, quiet: bool = False) -> None:
    """Print a message on standard error."""
    if not quiet:
        sys.stderr.write(printable(message) + "\n")


@contextlib.contextmanager
def working(what: str, *, quiet: bool = False) -> Iterator[Callable[[float], None]]:
    """Show an activity and its duration on a terminal. Yields a function that takes the completed share, 0 to 1, and
    shows a bar.
    """
    if quiet or not sys.stderr.isatty():
        yield lambda _: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    with Progress(
        SpinnerColumn("dots" if _in_unicode() else "line"),
        TextColumn("{task.description}"),
        TimeElapsedColumn(),
        console=Console(stderr=True),
        transient=True,
    ) as progress:
        task = progress.add_task(what, total=None)

        def done(part: float) -> None:
            if progress.tasks[0].total is None:
                progress.columns = (*progress.columns, BarColumn())
            progress.update(task, total=1.0, completed=part)

        yield done
