"""``sigmatau analyze``: noise coefficients, figure and JSON of a log."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from threading import Thread
from typing import TYPE_CHECKING, Annotated, Any, Literal, cast

from cyclopts import Parameter

from sigmatau.analysis import Analysis, FailedAnalysis, analyze
from sigmatau.cli import batch
from sigmatau.cli.attempts import Attempts
from sigmatau.cli.choosing import Choosing, Exports, targets_for_shell
from sigmatau.cli.declared import Flag, InMain, InMethod, InOutput, MayBeMinus, Quiet, Show, Texts, Verbose
from sigmatau.cli.earlier import expect
from sigmatau.cli.messages import print_error, wrapped
from sigmatau.cli.options import (
    ENDINGS,
    check_folder,
    check_output,
    check_style,
    drawing,
    finding_lines,
    matched,
    refuse_same,
    say,
    screen,
    working,
    write_figure,
    write_json,
    write_result,
)
from sigmatau.cli.outputs import NOT_AT_REST, Outputs, worst_code
from sigmatau.cli.ranges import lines_by_hand, refused_by_hand, slope_range, slopes
from sigmatau.cli.reading import ReadingOptions, assign_readings, read_log
from sigmatau.cli.settings import AnalysisSettings
from sigmatau.cli.words import configured_logs
from sigmatau.errors import DataError, OptionError
from sigmatau.estimators.allan import Curves
from sigmatau.findings.finding import Finding, exit_code
from sigmatau.findings.wording import causes
from sigmatau.io.folders import gather, is_log, skipped_lines
from sigmatau.io.read.formats.split import bag_files
from sigmatau.noise.shown import set_shown
from sigmatau.noise.terms import check_shown
from sigmatau.record.record import channel_quantities, stream_name
from sigmatau.typed.config import parse_notes

if TYPE_CHECKING:
    from sigmatau.reporting.certificate_file import CertificateFile

# largest number of lines of findings, which fill a screen of 24 lines with the table of six axes, the hints and a prompt
_MAX_LINES = 10


def analyze_command(
    *logs: Path,
    reading: ReadingOptions | None = None,
    settings: AnalysisSettings | None = None,
    report: Annotated[Path | None, InMain] = None,
    certificate: Annotated[Path | None, InOutput] = None,
    config: Annotated[Path | None, InMain] = None,
    note: Annotated[list[str] | None, Texts, InOutput] = None,
    plot: Annotated[Path | None, InMain] = None,
    overlay: Annotated[Path | None, InOutput] = None,
    stability: Annotated[Path | None, InOutput] = None,
    style: Annotated[Literal["screen", "paper"], InOutput] = "screen",
    json: Annotated[Path | None, MayBeMinus, InMain] = None,
    csv: Annotated[Path | None, InOutput] = None,
    export: Annotated[list[str] | None, Texts, InMain, Parameter(completer=targets_for_shell)] = None,
    choosing: Choosing | None = None,
    joint: Annotated[bool, Flag, InMethod] = False,
    joint_axes: Annotated[bool, Flag, InMethod] = False,
    common: Annotated[str | None, InMethod] = None,
    jobs: Annotated[int | None, InOutput] = None,
    slope: Annotated[str | None, InMethod] = None,
    show: Show = None,
    verbose: Verbose = False,
    quiet: Quiet = False,
) -> int:
    """Analyse a log of a sensor at rest: Allan deviation and noise coefficients of every axis.

    Parameters
    ----------
    logs
        One log; or several logs or folders of logs, which are analysed separately and summarised.
    report
        Write a report with curves, coefficients, findings and processing steps: .html opens offline, .pdf is for
        printing; for several logs, a folder for one .html each.
    certificate
        Facts for page 1 of the report of one log, which a laboratory signs by ISO/IEC 17025: laboratory, customer,
        instrument, method, decision rule, from a TOML file. Default: no such page.
    config
        Options from a TOML file, such as sigmatau app saves: rate = 100, window = "0s:2h"; and log = "static.csv" if no log
        is named here. Options that are typed replace those of the file. Default: none.
    note
        Information about the record for the report and the JSON, "serial number=A123"; may be repeated. sigmatau
        compare groups results by serial number and run.
    plot
        Draw all axes: .png, .svg or .pdf; for several logs, a folder for one .png each.
    overlay
        Draw the curves of several logs in one figure, a panel per axis: .png, .svg or .pdf.
    stability
        Draw the deviations over the record (dynamic Allan deviation): .png, .svg or .pdf; for several logs, a folder for one
        .png each. The JSON contains them too.
    style
        Style of figures: screen, or paper, for the width of a column or a page of a paper.
    json
        Write the result as JSON; - writes it to standard output instead of the table; for several logs, a folder. If the
        analysis fails, the JSON says why.
    csv
        Write the coefficients as CSV in SI units, NAME.csv, and the curves as NAME-curves.csv; for several logs, a folder.
    export
        Write the parameters of one log for another program, kalibr=imu.yaml; sigmatau export --list shows the targets.
    joint
        Fit one model to all logs, which are runs of one sensor: one table, one result. The logs may differ in length.
    joint_axes
        Fit one model to all axes of each sensor too.
    common
        Terms that are the same in all runs of --joint. Default: bias_instability,rate_random_walk; none for none. The other
        terms differ from run to run, and their value is the mean over runs.
    jobs
        Number of logs to analyse in parallel (default 1).
    slope
        Print the slope of each curve of one log between two averaging times, 1s:10s, and which noise terms have it.
        Default: none.
    verbose
        Print all coefficients and findings, not only the main ones.
    quiet
        Print only errors on standard error.
    """
    if not logs and config is not None:
        logs = configured_logs(config)
    if not logs:
        raise OptionError("name a log, several logs, or a folder of logs", option="log")
    logs = matched(logs, keep=is_log, quiet=quiet)
    set_shown(show)
    chosen: dict[str, Any] = {
        **(settings or AnalysisSettings()).arguments(),
        "stability": stability is not None,
        "notes": _notes(note or [], report, json),
    }
    exports = Exports.parse(export or [], choosing, method=chosen["method"])
    check_style(style, plot or overlay, stability)
    check_output(overlay, ENDINGS["overlay"], "overlay")
    outputs = Outputs(
        report=report,
        notes=chosen["notes"],
        plot=plot,
        stability=stability,
        json=json,
        csv=csv,
        style=style,
        certificate=None if certificate is None else _certificate(certificate, report, several=joint or joint_axes),
    )
    if common is not None and not (joint or joint_axes):
        raise OptionError("--common needs --joint", option="common")
    if slope is not None and (joint or joint_axes or str(json) == "-"):
        raise OptionError("--slope needs the curves of one log: leave out --joint and --json -", option="slope")
    if joint or joint_axes:
        from sigmatau.cli.joint import joint_command, parse_common, refuse

        refuse(outputs, chosen["method"], jobs=jobs, overlay=overlay, read_off_at=chosen["read_off_at"])
        return joint_command(
            logs,
            reading,
            chosen,
            outputs,
            exports,
            over="axes" if joint_axes else "runs",
            common=parse_common(common),
            verbose=verbose,
            quiet=quiet,
        )
    # A shell pattern may match only one log.
    folders = [place for place in (*logs, report, plot, stability, json, csv) if place is not None and place.is_dir()]
    meant_as_several = jobs is not None or any(
        not bag_files(place) for place in folders
    )  # a ROS 2 bag is a folder and one log
    if len(logs) == 1 and not meant_as_several:
        if overlay is not None:
            raise OptionError("--overlay takes several logs; for one log: --plot", option="overlay")
        reading = assign_readings(reading, logs, logs)[logs[0]]
        exports.check_reading(reading)
        span = None if slope is None else slope_range(slope)
        return _analyze_log(logs[0], reading, chosen, outputs, exports, span, verbose=verbose, quiet=quiet)
    if certificate is not None:
        raise OptionError("--certificate is for one log; run the command once for each", option="certificate")
    if slope is not None:
        raise OptionError("--slope takes one log; run the command once for each", option="slope")
    if exports.files:
        raise OptionError(
            "--export takes one log; for several, write the results with --json FOLDER and run sigmatau export on each",
            option="export",
        )
    return _analyze_logs(
        logs, reading, chosen, outputs, overlay=overlay, jobs=jobs, show=show, verbose=verbose, quiet=quiet
    )


def _certificate(file: Path, report: Path | None, *, several: bool) -> CertificateFile:
    """Read the facts of a certificate, before a long analysis."""
    if report is None:
        raise OptionError("--certificate needs --report r.pdf or --report r.html", option="certificate")
    if several:
        raise OptionError("--certificate is for one log, without --joint and --joint-axes", option="certificate")
    from sigmatau.lab.pages.certify import check_certificate
    from sigmatau.reporting.certificate_file import read_certificate

    facts = read_certificate(file)
    check_certificate(facts)
    return facts


def _notes(texts: Sequence[str], report: Path | None, json: Path | None) -> dict[str, str]:
    """Parse ``["serial number=A123"]`` to a dictionary. Raises `OptionError` for another form, or if there is no file to
    write it to.
    """
    if texts and report is None and json is None:
        raise OptionError("--note needs --report r.html or --json r.json", option="note")
    return parse_notes(texts)


def _analyze_log(
    log: Path,
    reading: ReadingOptions | None,
    settings: dict[str, Any],
    outputs: Outputs,
    exports: Exports,
    span: tuple[float, float] | None,
    *,
    verbose: bool,
    quiet: bool,
) -> int:
    outputs.check([log], exports)
    with _failures_written(log, outputs.json, outputs.notes):
        record = read_log(log, reading, quiet=quiet)
        check_shown(channel_quantities(record))
        exports.check_record(record)
        outputs.check_record(record)
        checksum = Thread(target=lambda: record.provenance.sha256, daemon=True)
        if outputs.json is not None or outputs.report is not None:
            with suppress(RuntimeError):  # if no thread can start, the checksum is computed when it is written
                checksum.start()
        with working("computing Allan variances, fitting", quiet=quiet):
            analysis = analyze(record, **settings)
        if checksum.ident is not None:
            checksum.join()
    attempts = Attempts()
    with attempts.attempt():
        _print_result(analysis, outputs, verbose=verbose, quiet=quiet)
        if span is not None:
            _table("\n".join(slopes(analysis, span)))
    outputs.write(attempts, analysis, analysis.to_dict, record=record, quiet=quiet)
    code = exit_code(analysis.findings)
    if code == NOT_AT_REST and exports.files and analysis.rest is not None:
        say(f"nothing to export: {analysis.rest.reason}", quiet=quiet)
    else:
        exports.write(attempts, analysis, result=outputs.files.get("json"), quiet=quiet)
    if not (verbose or attempts.errors):
        for line in wrapped([_output_hints(outputs, exports, analysis)]):
            say(line, quiet=quiet)
    return attempts.finish(code)


def _print_result(analysis: Analysis, outputs: Outputs, *, verbose: bool, quiet: bool) -> None:
    """Print the coefficients, or the JSON, and the findings."""
    with_table = str(outputs.json) != "-"
    if not with_table:
        write_result("", analysis.to_dict(), outputs.json)
    if verbose:
        _by_sensor(analysis, with_table=with_table, quiet=quiet)
        _say_refused(analysis, with_table=with_table, quiet=quiet)
        return
    messages = wrapped(causes(analysis.findings, rest="--verbose", room=_MAX_LINES))
    if with_table:
        _table(screen(analysis, below=len(messages) + 1, legend=not quiet))
        by_hand = lines_by_hand(analysis)
        if by_hand:
            _table("\n".join(by_hand))
    _say_refused(analysis, with_table=with_table, quiet=quiet)
    for line in messages:
        say(line, quiet=quiet)


def _say_refused(analysis: Analysis, *, with_table: bool, quiet: bool) -> None:
    """Print the refused lines of given ranges."""
    for line in refused_by_hand(analysis, in_table=with_table and not analysis.fits):
        say(line, quiet=quiet)


def _table(text: str) -> None:
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()  # flushed before the findings on standard error


def _by_sensor(analysis: Analysis, *, with_table: bool, quiet: bool) -> None:
    """Print the coefficients and the findings by sensor, after the findings about several sensors or none."""
    sections = {"": analysis.headline(), **analysis.sections()}
    findings: dict[str, list[Finding]] = {sensor: [] for sensor in sections}
    for finding in analysis.findings:
        sensors = {stream_name(channel) for channel in finding.channels} & set(sections)
        findings[sensors.pop() if len(sensors) == 1 else ""].append(finding)
    for sensor, text in sections.items():
        if with_table:
            _table(f"\n{text}" if sensor else text)
        for line in wrapped(finding_lines(findings[sensor])):
            say(line, quiet=quiet)
    if with_table:
        _table(f"\n{analysis.legend()}")


def _analyze_logs(
    places: Sequence[Path],
    reading: ReadingOptions | None,
    settings: dict[str, Any],
    outputs: Outputs,
    *,
    overlay: Path | None,
    jobs: int | None,
    show: str | None,
    verbose: bool,
    quiet: bool,
) -> int:
    if jobs is not None and jobs < 1:
        raise OptionError(f"--jobs {jobs}: must be a number of processes, at least 1", option="jobs")
    logs, skipped = gather(places)
    readings = assign_readings(reading, logs, places)
    for option, folder in reversed(outputs.paths.items()):  # check the figure libraries before a folder is created
        check_folder(folder, option)
    for line in skipped_lines(skipped):
        say(line, quiet=quiet)
    if jobs is not None and jobs > 1 and settings["threads"] is None:
        settings = settings | {"threads": max((os.cpu_count() or 1) // jobs, 1)}
    names = dict(zip(logs, batch.names(logs), strict=True))
    if overlay is not None:
        for log in logs:
            refuse_same(log, overlay=overlay)
        expect(overlay)
    for name in names.values():
        files = outputs.inside(name).files
        expect(*(path for option, path in files.items() if option not in ("json", "csv")), csv=files.get("csv"))
    work = partial(
        _in_a_process, names=names, readings=readings, settings=settings,
        outputs=outputs, show=show,
    )  # fmt: skip
    outcomes: dict[Path, batch.LogOutcome] = {}
    with working(f"analysing {len(logs)} logs", quiet=quiet) as done:
        for outcome in batch.run(logs, work, jobs=jobs or 1, keep=None if overlay is None else _curves):
            outcomes[outcome.log] = outcome
            if outcome.error and outputs.json is not None:
                file = outputs.json / f"{names[outcome.log]}.json"
                write_json(FailedAnalysis.of(outcome.error, str(outcome.log), notes=outputs.notes).to_dict(), file)
            done(len(outcomes) / len(logs))
    for log in logs:
        for finding in outcomes[log].findings:
            say(f"{log}: {finding}", quiet=quiet or (finding.severity == "info" and not verbose))
        if error := outcomes[log].error:
            print_error(error.for_command_line())
    attempts = Attempts()
    drawn = {names[log]: cast(Curves, outcomes[log].extract) for log in logs if outcomes[log].extract}
    if overlay is not None and drawn:
        from sigmatau.plot.overlay import plot_overlay

        with attempts.attempt(), drawing(overlay, outputs.style, quiet=quiet):
            write_figure(plot_overlay(drawn, style=outputs.style), overlay)
    from sigmatau.quality.clocks import compare_clocks

    for name, finding in compare_clocks({str(log): outcomes[log].marks for log in logs}).items():
        say(f"{name}: {finding}", quiet=quiet)
    sys.stdout.write(f"{batch.summary([outcomes[log] for log in logs])}\n")
    codes = {outcome.code for outcome in outcomes.values()}
    return attempts.finish(worst_code(codes))


def _curves(log: Path, analysis: Analysis) -> Curves:
    return analysis.curves


def _in_a_process(
    log: Path,
    *,
    names: dict[Path, str],
    readings: Mapping[Path, ReadingOptions],
    settings: dict[str, Any],
    outputs: Outputs,
    show: str | None,
) -> Analysis:
    set_shown(show)  # this process also prints rows of the table
    record = read_log(log, readings[log], quiet=True)
    check_shown(channel_quantities(record))
    analysis = analyze(record, **settings)

    attempts = Attempts()
    outputs.inside(names[log]).write(attempts, analysis, analysis.to_dict, record=record, quiet=True)
    attempts.raise_first()
    return analysis


def _output_hints(outputs: Outputs, exports: Exports, analysis: Analysis) -> str:
    """Hints on options that were not given."""
    offers = ["-v"]
    offers += ["report: --report r.html"] if outputs.report is None else []
    example = (
        "kalibr=imu.yaml" if {"gyro", "accel"} <= set(map(stream_name, analysis.fits)) else "state-space=model.json"
    )
    offers += [f"filter: --export {example}"] if analysis.fits and not exports.files else []
    return f"More: {' · '.join(offers)}"


@contextmanager
def _failures_written(log: Path, json: Path | None, notes: Mapping[str, str]) -> Iterator[None]:
    """Write a JSON that states why there is no result, so that the result of an earlier run is not mistaken for it."""
    try:
        yield
    except (OptionError, DataError, ImportError) as error:
        if json is not None:
            write_result("", FailedAnalysis.of(error, str(log), notes=notes).to_dict(), json)
        raise
