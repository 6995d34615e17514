"""``sigmatau inspect``: contents and faults of a log."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

from sigmatau.cli.declared import DeclaredOptions, InMain, MayBeMinus, Quiet, typed_options
from sigmatau.cli.messages import wrapped
from sigmatau.cli.options import (
    check_outputs,
    finding_lines,
    write_result,
)
from sigmatau.cli.reading import reading_shown
from sigmatau.findings.finding import damaged
from sigmatau.quality.inspection import inspect
from sigmatau.quality.options import InspectOptions
from sigmatau.results import lines_text


@typed_options(InspectOptions)
class InspectSettings(DeclaredOptions):
    """Options of reading, and of the checks that an analysis runs before the fit."""


def inspect_command(
    log: Path,
    /,
    *,
    settings: InspectSettings | None = None,
    json: Annotated[Path | None, MayBeMinus, InMain] = None,
    quiet: Quiet = False,
) -> int:
    """Show the contents of a log and its faults: topics, columns, rates, damage, motion, spikes, filters, lines, units.

    Parameters
    ----------
    log
        A log of any supported format.
    json
        Write JSON; - writes it to standard output instead of the list.
    quiet
        Print only errors on standard error.
    """
    check_outputs([log], json=json)
    with reading_shown(log, quiet=quiet):
        inspected = inspect(log, **(settings or InspectSettings()).arguments())
    messages = [*finding_lines(inspected.findings), *inspected.wants()]
    lines = [*inspected.contents(), *(wrapped(messages) if sys.stdout.isatty() else messages)]
    write_result(lines_text(lines), inspected.to_dict(), json)
    return damaged(inspected.findings)
