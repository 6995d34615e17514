"""``sigmatau compare``: results and a datasheet in; whether each unit keeps to it out, and as exit code."""

from __future__ import annotations

import contextlib
import json as json_module
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter

from sigmatau.cli.options import say
from sigmatau.datasheet import Verdict, compare_with
from sigmatau.datasheet import datasheet as find_datasheet
from sigmatau.errors import DataError, OptionError
from sigmatau.model import NoiseModel

__all__ = ["compare_command"]

_OUT = 3


def compare_command(
    *results: Path,
    datasheet: str,
    level: float = 0.95,
    factor: float | None = None,
    sided: Literal["one", "two"] | None = None,
    bias: Literal["minimum", "coefficient"] | None = None,
    undecided: Literal["pass", "fail"] = "pass",
    json: bool = False,
    quiet: Annotated[bool, Parameter(name=["--quiet", "-q"], negative=())] = False,
) -> int:
    """Whether units keep to their datasheet, term by term and by how many sigmas; exit code 3 if one does not.

    Parameters
    ----------
    results
        JSON that analyze writes, or model files (.toml), which have no intervals. Of several, one line each.
    datasheet
        A name of "sigmatau datasheet list", or a file of your own (.toml).
    level
        One-sided confidence: a unit exactly at its limit is called out in at most a share of 1 - level.
    factor
        Where the sheet has no maximum, FACTOR times typical is one. Default: typical values fail nobody.
    sided
        What noise densities are of which the sheet does not say it. Default: both are tried.
    bias
        What bias instabilities are of which the sheet does not say it: minimum of the Allan deviation, or coefficient.
    undecided
        Whether a unit of which the record cannot tell passes.
    json
        Print JSON in place of text.
    quiet
        Nothing on standard error but errors.
    """
    if not results:
        raise OptionError("no result; give the JSON that sigmatau analyze writes", option="results")
    sheet = find_datasheet(datasheet)
    verdicts = []
    for path in results:
        with _naming(path):
            verdict = compare_with(
                _result(path), sheet, unit=str(path), level=level, factor=factor, sided=sided, bias=bias
            )
        verdicts.append(verdict)
    if not any(verdict.judged for verdict in verdicts):
        raise DataError(f"{sheet.name}: the datasheet states nothing of the noise of what was measured")
    failing = {"out"} | ({"undecided"} if undecided == "fail" else set())
    failed = sum(verdict.status in failing for verdict in verdicts)
    if json:
        content = {"datasheet": sheet.to_dict(), "failed": failed, "units": [verdict.to_dict() for verdict in verdicts]}
        text = json_module.dumps(content, indent=1, allow_nan=False, ensure_ascii=False)
    else:
        text = repr(verdicts[0]) if len(verdicts) == 1 else _summary(verdicts, sheet.name, failed)
    sys.stdout.write(text + "\n")
    open_ = sum(verdict.status == "undecided" for verdict in verdicts)
    if open_ and undecided == "pass":
        say(f"warning: {open_} of {len(verdicts)} undecided, and passed; --undecided fail does not pass", quiet=quiet)
    return _OUT if failed else 0


@contextlib.contextmanager
def _naming(path: Path) -> Iterator[None]:
    """Errors of the data name the file."""
    try:
        yield
    except DataError as error:
        message = str(error)
        raise DataError(message if message.startswith(f"{path}:") else f"{path}: {message}") from None


def _result(path: Path) -> NoiseModel | dict[str, Any]:
    if path.suffix.lower() != ".json":
        return NoiseModel.read(path)
    try:
        content = json_module.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise DataError(f"{path}: {error.strerror or error}") from None
    except (ValueError, RecursionError) as error:
        raise DataError(f"{path}: no JSON: {error}") from None
    if not isinstance(content, dict):
        raise DataError(f"{path}: this is no result of sigmatau analyze: it has no channels")
    return content


def _summary(verdicts: Sequence[Verdict], name: str, failed: int) -> str:
    counts = Counter(verdict.status for verdict in verdicts)
    parts = [f"{counts[s]} {s}" for s in ("within", "above typical", "undecided", "out") if counts[s]]
    units = "unit" if len(verdicts) == 1 else "units"
    tail = f"{len(verdicts)} {units} against {name}: {', '.join(parts)}; {failed} failed"
    return "\n".join([*(verdict.line() for verdict in verdicts), tail])
