#!/usr/bin/env python3
"""Write the man pages into a folder: ``python scripts/manual.py target/man``; sigmatau.1, and one page for each command.

The source is that of ``--help``: names, types, descriptions, examples and exit codes, collected by a help formatter.
"""

from __future__ import annotations

import io
import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from cyclopts import App
from rich.console import Console

from sigmatau._version import __version__
from sigmatau.cli.app import EXAMPLES, app

if TYPE_CHECKING:
    from cyclopts.help import HelpEntry, HelpPanel
    from rich.console import ConsoleOptions

_WIDE = 100_000  # columns: nothing is wrapped


def plain(content: object) -> str:
    """Text that rich prints for some content, in one line."""
    if content is None:
        return ""
    console = Console(
        file=io.StringIO(), width=_WIDE, no_color=True, force_terminal=False, highlight=False, emoji=False
    )
    with console.capture() as capture:
        console.print(content, end="", markup=False, soft_wrap=True)
    return " ".join(capture.get().split())


def roff(text: str) -> str:
    """Escape characters that are commands in roff."""
    text = (
        text.replace("\\", "\\e").replace("-", "\\-").replace("'", "\\(aq").replace("`", "\\(ga").replace("^", "\\(ha")
    )
    return re.sub(r"^\.", r"\\&.", text.replace("~", "\\(ti"), flags=re.MULTILINE)


class Collector:
    """A help formatter that collects its input as roff."""

    def __init__(self) -> None:
        self.usage = ""
        self.description = ""
        self.panels: list[tuple[str, list[str]]] = []

    def render_usage(self, _console: Console, _options: ConsoleOptions, usage: object) -> None:
        self.usage = plain(usage).removeprefix("Usage: ")

    def render_description(self, _console: Console, _options: ConsoleOptions, description: object) -> None:
        self.description = plain(description)

    def __call__(self, _console: Console, _options: ConsoleOptions, panel: HelpPanel) -> None:
        if panel.entries:
            self.panels.append((plain(panel.title), [_entry(entry, panel.format) for entry in panel.entries]))


def _entry(entry: HelpEntry, kind: str) -> str:
    labels = entry.display_labels_with_metavar if kind == "parameter" else entry.display_labels
    notes = []
    if entry.choices:
        notes.append(f"Choices: {', '.join(entry.choices)}.")
    if entry.env_var:
        notes.append(f"Environment: {', '.join(entry.env_var)}.")
    if entry.default not in (None, "", "False"):
        notes.append(f"Default: {entry.default}.")
    if entry.required:
        notes.append("Required.")
    text = " ".join([plain(entry.description), *notes]).strip()
    return f".TP\n\\fB{roff(', '.join(labels))}\\fR\n{roff(text)}\n"


def commands(group: App = app, above: tuple[str, ...] = ()) -> list[tuple[str, ...]]:
    """All commands, as the words typed after ``sigmatau``."""
    names: list[tuple[str, ...]] = []
    for name, command in group.resolved_commands().items():
        if not name.startswith("-"):
            names += [(*above, name), *commands(command, (*above, name))]
    return names


def page(words: tuple[str, ...] = ()) -> str:
    """The man page of a command, or of the program."""
    collected = Collector()
    before = app.help_formatter
    app.help_formatter = cast("Any", collected)  # the protocol has two optional methods
    try:
        app.help_print(list(words), console=Console(file=io.StringIO(), width=_WIDE))
    finally:
        app.help_formatter = before
    name = "-".join(("sigmatau", *words))
    summary, _, rest = collected.description.partition(". ")
    out = [
        f'.TH "{roff(name.upper())}" 1 "" "sigmatau {__version__}" "sigmatau"\n.ad l\n.nh\n',
        f".SH NAME\n{roff(name)} \\- {roff(summary.rstrip('.'))}\n",
        f".SH SYNOPSIS\n.nf\n{roff(collected.usage)}\n.fi\n",
    ]
    if rest:
        out.append(f".SH DESCRIPTION\n{roff(rest)}\n")
    for title, entries in collected.panels:
        out.append(f".SH {roff({'Parameters': 'Options'}.get(title, title).upper())}\n{''.join(entries)}")
    if examples := EXAMPLES.get(" ".join(words)):
        out.append(f".SH EXAMPLES\n.nf\n{roff(examples)}\n.fi\n")
    exit_codes, _, streams = str(app.help_epilogue).partition(". ")
    codes = [code.split(" ", 1) for code in exit_codes.removeprefix("Exit codes: ").split(" · ")]
    out.append(".SH EXIT STATUS\n" + "".join(f".TP\n\\fB{code}\\fR\n{roff(meaning)}\n" for code, meaning in codes))
    out.append(f".SH OUTPUT\n{roff(streams)}\n")
    related = [("sigmatau", *words_) for words_ in commands() if words_[:-1] == words] if len(words) < 2 else []
    related = related or [("sigmatau", *words[:-1])] if words else related
    out.append(".SH SEE ALSO\n" + ",\n".join(f"\\fB{roff('-'.join(words_))}\\fR(1)" for words_ in related) + "\n")
    return "".join(out)


def main() -> int:
    """Write all pages into a folder."""
    if len(sys.argv) != 2:
        sys.exit("usage: manual.py FOLDER")
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    for words in [(), *commands()]:
        (folder / f"{'-'.join(('sigmatau', *words))}.1").write_text(page(words), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
