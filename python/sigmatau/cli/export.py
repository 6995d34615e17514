"""``sigmatau export``: a model or a result in; the file that a filter reads out."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from sigmatau.cli.choosing import Choosing
from sigmatau.cli.options import check_output, finding_lines, refuse_same, say
from sigmatau.errors import OptionError
from sigmatau.export import NAMES, Numbers, check_path, export, target
from sigmatau.export.source import one_rate, read_source

__all__ = ["export_command"]


def export_command(
    source: Path | None = None,
    /,
    *,
    to: str | None = None,
    output: Annotated[Path | None, Parameter(name=["--output", "-o"])] = None,
    rate: float | None = None,
    choosing: Choosing | None = None,
    list_: Annotated[bool, Parameter(name="--list", negative=())] = False,
    quiet: Annotated[bool, Parameter(name=["--quiet", "-q"], negative=())] = False,
) -> int:
    """Write the noise parameters for another program, in its units, with each number's origin beside it.

    Parameters
    ----------
    source
        A model file (.toml), the JSON that analyze writes, or a YAML of Kalibr's kind or of imu_utils.
    to
        The target; --list names them.
    output
        The file to write. Default: standard output.
    rate
        Sampling rate in Hz; not needed with a result.
    list_
        The targets, one line each.
    quiet
        Nothing on standard error but errors.
    """
    if list_:
        width = max(map(len, NAMES))
        sys.stdout.write("".join(f"{name:<{width}}  {target(name).summary}\n" for name in NAMES))
        return 0
    if source is None:
        raise OptionError("name a model file or a result, or say --list", option="source")
    if to is None:
        raise OptionError(f"--to: say for which target: {', '.join(NAMES)}", option="to")
    wanted = target(to)
    check_output(output, (), "output")
    if output is not None:
        check_path(wanted, output)
    refuse_same(source, output=output)
    choosing = choosing or Choosing()
    choosing.choices(rate)  # refused, if it is, before a file is read
    found = read_source(source, rate=rate)
    for line in finding_lines(found.findings):
        say(line, quiet=quiet)
    used = one_rate(found.rates) if rate is None and wanted.needs_rate else rate
    choices = choosing.choices(used)
    content = export(found.model, to=to, path=output, choices=choices)
    for line in finding_lines(Numbers(found.model, choices).not_used()):
        say(line, quiet=quiet)
    if output is not None:
        say(f"{output}: written for {to}", quiet=quiet)
    elif isinstance(content, bytes):
        raise OptionError(f"--output: a file for {to} is binary; name one", option="output")
    else:
        sys.stdout.write(content)
    return 0
