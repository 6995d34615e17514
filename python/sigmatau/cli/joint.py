"""``sigmatau analyze --joint``: one model for several logs of a sensor."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from sigmatau.analysis import analyze
from sigmatau.analysis.joint import AnalysedRun, analysed_run, fit_analysed
from sigmatau.cli import batch
from sigmatau.cli.attempts import Attempts
from sigmatau.cli.choosing import Exports
from sigmatau.cli.messages import print_error, wrapped
from sigmatau.cli.options import finding_lines, say, working
from sigmatau.cli.outputs import NOT_AT_REST, Outputs, worst_code
from sigmatau.cli.reading import ReadingOptions, assign_readings, read_log
from sigmatau.errors import DataError, OptionError
from sigmatau.findings.finding import exit_code
from sigmatau.fitting.joint import COMMON, Over, check_same_sensor, common_terms
from sigmatau.io.folders import gather, skipped_lines
from sigmatau.noise.terms import check_shown
from sigmatau.record.record import Record, channel_quantities
from sigmatau.record.streams import Stream

_SEVERAL = 2


def parse_common(text: str | None) -> tuple[str, ...]:
    """Parse the terms of ``--common``. Raises `OptionError`."""
    if text is None:
        return COMMON
    return common_terms([name.strip() for name in text.split(",") if name.strip() and name.strip() != "none"])


def refuse(
    outputs: Outputs, method: str, *, jobs: int | None, overlay: Path | None, read_off_at: Mapping[str, Any]
) -> None:
    """Raise `OptionError` for an option that a joint fit does not support."""
    if method != "likelihood":
        raise OptionError(f"--joint needs --method likelihood, not {method}", option="joint")
    single = {
        "report": outputs.report,
        "stability": outputs.stability,
        "overlay": overlay,
        "read-off-at": read_off_at or None,
        "jobs": jobs,
    }
    for option, value in single.items():
        if value is not None:
            raise OptionError(
                f"--{option} applies to single logs, and --joint makes one result of all; run it without --joint",
                option=option,
            )


def joint_command(
    places: Sequence[Path],
    reading: ReadingOptions | None,
    settings: dict[str, Any],
    outputs: Outputs,
    exports: Exports,
    *,
    over: Over,
    common: Sequence[str],
    verbose: bool,
    quiet: bool,
) -> int:
    """Analyse logs individually, fit them jointly, and write one result."""
    logs, skipped = gather(places)
    readings = assign_readings(reading, logs, places)
    if len(logs) < _SEVERAL and over == "runs":
        raise OptionError("--joint needs two or more logs. For the axes of one log, use --joint-axes", option="joint")
    for log in logs:
        exports.check_reading(readings[log])
    outputs.check(logs, exports)
    for line in skipped_lines(skipped):
        say(line, quiet=quiet)
    records, codes = _analysed(logs, readings, settings, exports, over=over, verbose=verbose, quiet=quiet)
    if not records or (len(records) < _SEVERAL and over == "runs"):
        raise DataError(
            f"--joint needs two or more logs that can be used: {len(records)} of {len(logs)} can; correct or add logs"
        )
    with working(f"fitting {len(records)} logs jointly", quiet=quiet):
        fitted = fit_analysed(records, over=over, common=common, terms=settings["terms"])
    attempts = Attempts()
    with_table = str(outputs.json) != "-"
    if with_table:
        width = shutil.get_terminal_size().columns if sys.stdout.isatty() else 80
        text = repr(fitted.joint) if verbose else fitted.overview(width=width, legend=not quiet)
        sys.stdout.write(f"{text}\n")
        sys.stdout.flush()
    for line in wrapped(finding_lines(fitted.analysis.findings)):
        say(line, quiet=quiet)
    outputs.write(attempts, fitted.analysis, fitted.to_dict, quiet=quiet)
    exports.write(attempts, fitted.analysis, result=outputs.files.get("json"), quiet=quiet)
    return attempts.finish(worst_code(codes))


def _analysed(
    logs: Sequence[Path],
    readings: Mapping[Path, ReadingOptions],
    settings: dict[str, Any],
    exports: Exports,
    *,
    over: Over,
    verbose: bool,
    quiet: bool,
) -> tuple[list[AnalysedRun], set[int]]:
    """Contributions of the logs to the fit, and their exit codes. A log that cannot be used is reported."""
    records: list[AnalysedRun] = []
    codes: set[int] = set()
    names = dict(zip(logs, batch.names(logs), strict=True))
    with working(f"analysing {len(logs)} logs", quiet=quiet) as done:
        finding_texts = []
        firsts: dict[str, tuple[Stream, str]] = {}
        for k, log in enumerate(logs, 1):
            code = 1  # exit code of an error
            try:
                record = read_log(log, readings[log], quiet=True)
                check_shown(channel_quantities(record))
                exports.check_record(record)
                _check_same_sensor(record, names[log], firsts, over)
                analysis = analyze(record, **settings)
                code = exit_code(analysis.findings) or 1
                codes.add(exit_code(analysis.findings))
                finding_texts += [
                    f"{log}: {finding}" for finding in analysis.findings if finding.severity != "info" or verbose
                ]
                records.append(analysed_run(record, analysis, name=names[log]))
            except (OptionError, _OtherSensorError):
                raise  # an option error concerns all logs
            except (DataError, ImportError) as error:
                codes.add(code if code == NOT_AT_REST else 1)
                print_error(str(error))
            done(k / len(logs))
    for line in finding_texts:
        say(line, quiet=quiet)
    return records, codes


class _OtherSensorError(DataError):
    """The rate or unit of a log differs from that of the first log."""


def _check_same_sensor(record: Record, name: str, firsts: dict[str, tuple[Stream, str]], over: Over) -> None:
    """Raise an error for a log of another sensor before its analysis. `firsts`: first stream and its log, by pool."""
    for stream in record.streams:
        for channel in () if stream.quantity == "temperature" else stream.channels:
            pool = channel if over == "runs" else stream.name
            first, first_name = firsts.setdefault(pool, (stream, name))
            try:
                check_same_sensor(stream, first, channel=channel, names=(name, first_name))
            except DataError as error:
                raise _OtherSensorError(str(error)) from None
