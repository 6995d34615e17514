"""``sigmatau compare``: check whether units meet their datasheet; the exit code states the outcome."""

from __future__ import annotations

import json as json_module
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter

from sigmatau.cli.options import say
from sigmatau.datasheets.compare import compare_with
from sigmatau.datasheets.sheet import datasheet as find_datasheet
from sigmatau.datasheets.verdict import Verdict
from sigmatau.errors import DataError, OptionError
from sigmatau.model.file import NOT_ADEQUATE
from sigmatau.model.noise_model import NoiseModel
from sigmatau.quality.clocks import Mark, clocks, marks_of
from sigmatau.results import printable

_OUT = 3
_UNUSABLE = 1  # one of the files; precedes _OUT, because the batch is incomplete


def compare_command(
    *results: Path,
    datasheet: str,
    level: float = 0.95,
    factor: float | None = None,
    sided: Literal["one", "two"] | None = None,
    bias: Literal["minimum", "coefficient"] | None = None,
    undecided: Literal["pass", "fail"] = "pass",
    json: Annotated[bool, Parameter(negative=())] = False,
    quiet: Annotated[bool, Parameter(name=["--quiet", "-q"], negative=())] = False,
) -> int:
    """Test whether units meet their datasheet, by noise term and in sigmas; exit code 3 if a unit does not.

    Several results print one line each; a result whose lines and filters are all at other frequencies than those of the
    others is named: its clock is off. A file that cannot be used is named on standard error, the others are compared, and
    the exit code is 1.

    Parameters
    ----------
    results
        JSON files of analyze, or a folder of them; or model files (.toml), which have no intervals.
    datasheet
        A name of "sigmatau datasheet list", or your file (.toml).
    level
        Confidence level of the status "out": a unit exactly at its limit gets it with a probability of at most 1 - LEVEL.
    factor
        If the datasheet states no maximum, use FACTOR times the typical value. Default: a typical value cannot fail a unit.
    sided
        Convention of noise densities if the datasheet does not state it (default: try both).
    bias
        Convention of bias instabilities if not stated: minimum of the Allan deviation, or coefficient B (default: try both).
    undecided
        Result for a unit if the data cannot decide whether it meets a maximum (default: pass).
    json
        Print JSON.
    quiet
        Print only errors on standard error.
    """
    if not results:
        raise OptionError("no results; give JSON files of sigmatau analyze", option="results")
    sheet = find_datasheet(datasheet)
    paths = _files(results)
    verdicts, errors, marks = [], {}, {}
    for path in paths:
        try:
            result = _result(path)
            verdict = compare_with(result, sheet, unit=str(path), level=level, factor=factor, sided=sided, bias=bias)
        except DataError as error:
            if len(paths) == 1:
                raise DataError(_named(path, error)) from None
            errors[path] = _named(path, error)
        else:
            verdicts.append(verdict)
            marks[str(path)] = _marks(result)
    for message in errors.values():
        sys.stderr.write(f"sigmatau: {printable(' '.join(message.split()))}\n")
    if not verdicts:
        return _UNUSABLE
    if not any(verdict.judged for verdict in verdicts):
        raise DataError(f"{sheet.name}: the datasheet has no noise specification for the measured channels")
    failed = sum(verdict.fails(undecided) for verdict in verdicts)
    off = clocks(marks)
    for name, finding in off.items():
        say(f"{name}: {finding}", quiet=quiet)
    if json:
        content = {
            "datasheet": sheet.to_dict(),
            "failed": failed,
            "units": [{**verdict.to_dict(), "fails": verdict.fails(undecided)} for verdict in verdicts],
            "clocks_off": {name: finding.to_dict() for name, finding in off.items()},
            "not_compared": [{"unit": str(path), "error": message} for path, message in errors.items()],
        }
        text = json_module.dumps(content, indent=1, allow_nan=False, ensure_ascii=False)
    else:
        text = repr(verdicts[0]) if len(paths) == 1 else _summary(verdicts, sheet.name, undecided, len(errors))
    sys.stdout.write(text + "\n")
    open_ = [verdict for verdict in verdicts if verdict.fails("fail") and not verdict.fails(undecided)]
    if open_:
        doubtful = [verdict for verdict in open_ if any(one.reason == NOT_ADEQUATE for one in verdict.judged)]
        why = f" ({len(doubtful)} because no model fits)" if doubtful else ""
        say(
            f"warning: {len(open_)} of {len(verdicts)} passed undecided{why} and may be out; --undecided fail fails them",
            quiet=quiet,
        )
    return _UNUSABLE if errors else _OUT if failed else 0


def _files(places: Sequence[Path]) -> list[Path]:
    """The results; those of a folder sorted by name."""
    found: list[Path] = []
    for place in places:
        inside = sorted(place.glob("*.json")) if place.is_dir() else [place]
        if not inside:
            raise DataError(f"{place}: no .json in this folder; sigmatau analyze LOGS --json {place} writes them")
        found += inside
    return found


def _named(path: Path, error: DataError) -> str:
    """The message of an error, beginning with the file."""
    message = str(error)
    return message if message.startswith(f"{path}:") else f"{path}: {message}"


def _result(path: Path) -> NoiseModel | dict[str, Any]:
    if path.suffix.lower() != ".json":
        return NoiseModel.read(path)
    try:
        content = json_module.loads(path.read_text(encoding="utf-8-sig"))
    except OSError as error:
        raise DataError(f"{path}: {error.strerror or error}") from None
    except (ValueError, RecursionError) as error:
        raise DataError(f"{path}: not JSON: {error}") from None
    if not isinstance(content, dict):
        raise DataError(f"{path}: not a result of sigmatau analyze: no channels")
    return content


def _marks(result: NoiseModel | dict[str, Any]) -> tuple[Mark, ...]:
    """The frequencies that a result has in common with others of its unit; none of what was written by hand."""
    if isinstance(result, NoiseModel):
        return ()
    try:
        return marks_of({name: channel.get("fit") or {} for name, channel in result["channels"].items()})
    except (AttributeError, KeyError, TypeError, ValueError):
        return ()


def _summary(verdicts: Sequence[Verdict], name: str, undecided: Literal["pass", "fail"], unusable: int) -> str:
    counts = Counter(verdict.status for verdict in verdicts)
    parts = [f"{counts[s]} {s}" for s in ("within", "above typical", "undecided", "out") if counts[s]]
    failed = sum(verdict.fails(undecided) for verdict in verdicts)
    lines = [verdict.line() for verdict in verdicts]
    lines.append(f"{len(verdicts)} {'unit' if len(verdicts) == 1 else 'units'} against {name}: {', '.join(parts)}")
    lines.append(f"passed: {len(verdicts) - failed}, failed: {failed}" + f", not compared: {unusable}" * bool(unusable))
    return "\n".join(lines)
