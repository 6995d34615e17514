"""``sigmatau lot``: judge a lot of units from logs or results. Every unit gets exactly one state."""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from sigmatau.analysis import Analysis, FailedAnalysis, analyze
from sigmatau.cli import batch
from sigmatau.cli.declared import Show
from sigmatau.cli.earlier import expect as expect_files
from sigmatau.cli.lot_places import expected_units, gather_units, may_be_a_unit, units_in_paths
from sigmatau.cli.lot_reports import (
    UnitReports,
    open_reports,
    protect,
    read_unit_certificate,
    refusal_lines,
    refuse_unit_files,
    unjudged_line,
)
from sigmatau.cli.options import (
    check_folder,
    check_output,
    command_line,
    json_text,
    matched,
    say,
    working,
    write_json,
)
from sigmatau.cli.reading import ReadingOptions, assign_readings, read_log
from sigmatau.errors import DataError, OptionError
from sigmatau.frozen import frozen
from sigmatau.io.written import is_result
from sigmatau.lab.datasheets.compare import check_options
from sigmatau.lab.datasheets.sheet import Datasheet
from sigmatau.lab.datasheets.sheet import datasheet as find_datasheet
from sigmatau.lab.lots.expected import match_expected
from sigmatau.lab.lots.lot import check_choices, examine, judge_lot
from sigmatau.lab.lots.lot_result import Lot
from sigmatau.lab.lots.lot_screen import screen
from sigmatau.lab.lots.lot_unit import UnitResult, without_result
from sigmatau.lab.lots.unit_pattern import FOLDER, check_unit_pattern
from sigmatau.lab.pages.lot_report import LOT_ENDINGS, lot_report
from sigmatau.noise.shown import set_shown
from sigmatau.noise.terms import check_shown
from sigmatau.results import printable

if TYPE_CHECKING:
    from sigmatau.cli.store import Choice

_MAX_JOBS = 4  # largest default number of processes; each holds a record in memory
_UNUSABLE = 1  # exit code if all units passed, but some have no certificate
_USAGE_ERRORS = 2  # number of first logs that are reported as one error if none can be read because of an option


def lot_command(
    *units: Path,
    reading: ReadingOptions | None = None,
    spec: str | None = None,
    expect: str | None = None,
    unit_from: str | None = None,
    output: Annotated[list[Path] | None, Parameter(name=["--output", "-o"], negative=())] = None,
    results: Path | None = None,
    reports: Path | None = None,
    certificate: Path | None = None,
    decimal_comma: Annotated[bool, Parameter(negative=())] = False,
    level: float = 0.95,
    factor: float | None = None,
    sided: Literal["one", "two"] | None = None,
    bias: Literal["minimum", "coefficient"] | None = None,
    undecided: Literal["not-judged", "pass", "fail"] = "not-judged",
    fail_on: Literal["warning"] | None = None,
    accept: Annotated[list[str] | None, Parameter(negative=())] = None,
    jobs: int | None = None,
    store: str | None = None,
    serial: Annotated[list[str] | None, Parameter(negative=())] = None,
    temperature: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    supply: str | None = None,
    show: Show = None,
    json: Annotated[bool, Parameter(negative=())] = False,
    verbose: Annotated[bool, Parameter(name=["--verbose", "-v"], negative=())] = False,
    quiet: Annotated[bool, Parameter(name=["--quiet", "-q"], negative=())] = False,
) -> int:
    """Judge a lot of units: each is passed, failed, not judged, failed to read, or missing.

    Exit code 0 if all units passed, 3 if one failed, 4 if not all were present, read and judged. Without --spec, the units
    are described and compared with each other, and none is judged.

    Parameters
    ----------
    units
        Logs, or JSON results of analyze, one for each unit, in the order of production; or folders of them. If a folder
        has logs, only the logs are used, not the results of an earlier run.
    spec
        Specification: your file (.toml), or a name of "sigmatau datasheet list".
    expect
        Number of units, or a file with their names, one per line: units without a log are reported as missing. A name also
        matches a serial number inside a file name, SN7 in SN7_2026-05-04.csv. Default: not checked.
    unit_from
        Source of the unit's name: folder, for the folder of its log; or a regular expression for the path of the log, whose
        first group is the unit, '(SN[0-9]+)'. Default: the file name.
    output
        Write the lot: .html (a page that opens offline), .pdf, .xlsx, .csv, .json, .xml (JUnit). May be repeated.
    results
        Folder for the result of each unit, as analyze --json writes it.
    reports
        Folder for the report of each log, as analyze --report writes it; the page of the lot links to them.
    certificate
        Facts for page 1 of the report of each unit, which a laboratory signs by ISO/IEC 17025, from a TOML file as of
        analyze --certificate, without the serial number. --reports then has a .pdf for each unit. Default: no such page.
    decimal_comma
        Write .csv with decimal commas, and semicolons between the columns.
    level
        Confidence level of "above" and "below" a maximum: a unit with a value exactly at its maximum fails with a
        probability of at most 1 - LEVEL, and passes with a probability of at most 1 - LEVEL.
    factor
        Where the specification states no maximum, use FACTOR times the typical or 1 σ value. Default: such a value is not
        judged, and no unit passes.
    sided
        Convention of noise densities if the specification does not state it (default: try both).
    bias
        Convention of bias instabilities if not stated: minimum of the Allan deviation, or coefficient B (default: try both).
    undecided
        State of a unit whose interval contains a maximum, or that lacks an axis or a model (default: not judged).
    fail_on
        warning: a warning about the record, such as spikes or a wrong unit, fails a unit. Default: the unit is not judged.
    accept
        Codes of findings and remarks that do not keep a unit from passing: spectral_line,short_record.
        Default: none.
    jobs
        Number of logs to analyse in parallel (default: the number of cores, at most 4).
    store
        Judge the latest result of each unit of this store in place of logs: a SQLite file or postgresql://USER@HOST/NAME,
        see sigmatau store.
    serial
        With --store, serial number; A* selects all serial numbers that begin with A. May be repeated.
    temperature
        With --store, only runs at this temperature to 0.5 °C, 85degC, or in a range, 20:30. Required if there are several.
    supply
        With --store, only runs at this supply voltage to 1.5 %, 3.3V, or in a range, 3:3.6. Required if there are several.
    json
        Print the lot as JSON.
    verbose
        Print every unit; for a single unit, print its full comparison.
    quiet
        Print only errors on standard error.
    """
    set_shown(show)
    if store is not None and units:
        raise OptionError("give logs or results, or --store, not both", option="store")
    if serial and store is None:
        raise OptionError("--serial needs --store; units are chosen by their files", option="serial")
    for condition, text in (("temperature", temperature), ("supply", supply)):
        if text is not None and store is None:
            raise OptionError(f"--{condition} needs --store; units are chosen by their files", option=condition)
    if store is not None and unit_from is not None:
        raise OptionError("--unit-from names the units of logs; those of a store have names", option="unit_from")
    check_unit_pattern(unit_from, words=(FOLDER,))
    if store is not None and results is not None:
        raise OptionError("--results keeps the results of logs; the store has its own", option="results")
    if store is not None and reports is not None:
        raise OptionError("--reports needs logs; a store has only results", option="reports")
    if store is not None and certificate is not None:
        raise OptionError("--certificate needs logs; a store has only results", option="certificate")
    if not units and store is None:
        raise OptionError("name the logs or results of the units, or a folder of them", option="units")
    if jobs is not None and jobs < 1:
        raise OptionError(f"--jobs {jobs}: must be a number of processes, at least 1", option="jobs")
    accepted = [code.strip() for text in accept or [] for code in text.split(",") if code.strip()]
    check_choices(undecided, fail_on, accepted)
    check_options(level=level, factor=factor, sided=sided, bias=bias)
    sheet = None if spec is None else find_datasheet(spec)
    expected = None if expect is None else expected_units(expect)
    options: dict[str, Any] = {"level": level, "factor": factor, "sided": sided, "bias": bias}
    facts = read_unit_certificate(certificate, reports=reports, unit_from=unit_from, sheet=sheet)
    outputs = _outputs(output or [])
    pages: UnitReports | None = None
    refusals: dict[str, str] = {}
    logs: list[Path] = []
    files: list[Path] = []
    if store is not None:
        expect_files(*outputs)
        from sigmatau.cli.store import Choice

        choice = Choice(unit=serial, temperature=temperature, supply=supply)
        units_examined = _stored(store, choice, sheet, options)
        order = [*units_examined]
    else:
        places = matched(units, keep=may_be_a_unit, quiet=quiet)
        logs, files = gather_units(places, expecting=expected is not None, quiet=quiet)
        names = dict(zip([*logs, *files], batch.names([*logs, *files]), strict=True))
        names |= {file: names[file].removesuffix(".json") for file in files}
        if len({*names.values()}) < len(names):
            names = dict(zip([*logs, *files], batch.names([*logs, *files]), strict=True))
        if unit_from is not None:
            names = units_in_paths([*logs, *files], unit_from)
        listed = [] if expect is None or isinstance(expected, int) else [Path(expect)]
        protect(outputs, *logs, *files, *listed, *(() if facts is None else facts.files))
        pages = open_reports(reports, facts, results=files)
        unit_pages = [] if pages is None else [pages.place(names[log]) for log in logs]
        unit_results = [] if results is None else [results / f"{names[log]}.json" for log in logs]
        refuse_unit_files(outputs, [*unit_pages, *unit_results])
        expect_files(*outputs, *unit_pages)
        if results is not None:
            _prepare(results, {names[log] for log in logs}, quiet=quiet)
        readings = assign_readings(reading, logs, [place for place in places if place in logs])
        units_examined, refusals = _analysed(
            logs, names, readings, sheet, options, results, pages, jobs=jobs, quiet=quiet
        )
        for file in files:
            units_examined[names[file]] = examine(file, sheet, name=names[file], **options)
        order = [names[place] for place in (*logs, *files)]
    lot = judge_lot(
        {name: units_examined[name] for name in order},
        sheet,
        expect=expected,
        undecided=undecided,
        fail_on=fail_on,
        accept=accepted,
        **options,
    )
    if expected is not None and match_expected([*units_examined], expected).inside:
        say(
            "units are matched by serial numbers inside file names; name them by --unit-from, e.g. '(SN[0-9]+)'",
            quiet=quiet,
        )
    if lot.bands:
        check_shown({band.channel: (band.quantity, band.unit) for band in lot.bands})
    # A page of an earlier run is not that of a log that failed now.
    written = {names[log] for log in logs if not units_examined[names[log]].error} - {*refusals}
    for path in outputs:
        with working(f"writing {path}", quiet=quiet):
            links = {} if pages is None else pages.links(written, path)
            lot_report(lot, path, command=command_line(), reports=links, decimal_comma=decimal_comma)
    sys.stdout.write(json_text(lot.to_dict()) if json else f"{_text(lot, verbose=verbose)}\n")
    if facts is not None:
        for line in (*refusal_lines(refusals), *unjudged_line(lot, refusals)):
            say(line, quiet=quiet)
    return lot.exit_code or (_UNUSABLE if refusals else 0)


def _stored(place: str, choice: Choice, sheet: Datasheet | None, options: Mapping[str, Any]) -> dict[str, UnitResult]:
    """Read the units of a store, in the order of production."""
    from sigmatau.cli.store import opened
    from sigmatau.lab.lots.conditions import SUPPLY, TEMPERATURE

    chosen = choice.chosen()
    with opened(place) as store:
        runs = store.runs(chosen).columns()
        for factor in (TEMPERATURE, SUPPLY):
            groups = sorted({*factor.groups(runs[factor.name])})
            if len(groups) > 1:
                raise OptionError(
                    f"the store has runs {', '.join(groups)}; a lot has one {factor.name}, give --{factor.name}",
                    option=factor.name,
                )
        latest = store.units_latest(chosen)
    if not latest:
        raise DataError(f"{place}: the store has no unit of this kind")
    return {name: examine(result, sheet, name=name, **options) for name, result in latest.items()}


def _text(lot: Lot, *, verbose: bool) -> str:
    width = shutil.get_terminal_size().columns if sys.stdout.isatty() or "COLUMNS" in os.environ else 80
    text = screen(lot, max_units=len(lot.units) if verbose else 10, width=max(width, 40) if not verbose else 10_000)
    if len(lot.units) == 1 and lot.units[0].verdict is not None:
        return f"{text}\n\n{lot.units[0].verdict!r}"
    return text


def _outputs(paths: Sequence[Path]) -> list[Path]:
    for path in paths:
        check_output(path, LOT_ENDINGS, "output")
    if len({path.resolve() for path in paths}) < len(paths):
        raise OptionError("--output names a file twice", option="output")
    return list(paths)


def _prepare(folder: Path, names: set[str], *, quiet: bool) -> None:
    """Create the folder for the results. Results of other units in the folder are reported, because they do not belong to
    this run.
    """
    check_folder(folder, "results")
    expect_files(*(folder / f"{name}.json" for name in names))
    earlier = [
        file for file in folder.glob("*.json") if file.name.removesuffix(".json") not in names and is_result(file)
    ]
    if earlier:
        say(f"warning: {folder} has results of {len(earlier)} other units, which are not of this run", quiet=quiet)


def _analysed(
    logs: Sequence[Path],
    names: Mapping[Path, str],
    readings: Mapping[Path, ReadingOptions],
    sheet: Datasheet | None,
    options: Mapping[str, Any],
    results: Path | None,
    pages: UnitReports | None,
    *,
    jobs: int | None,
    quiet: bool,
) -> tuple[dict[str, UnitResult], dict[str, str]]:
    """Analyse the logs, and compare each with the specification; and why units have no certificate.

    Raises `OptionError` if the first logs cannot be read because of an option.
    """
    if not logs:
        return {}, {}
    parallel = min(jobs or min(os.cpu_count() or 1, _MAX_JOBS), len(logs))
    threads = max((os.cpu_count() or 1) // parallel, 1)
    work = partial(_work, readings=readings, names=dict(names), pages=pages, threads=threads)
    keep = partial(_keep, names=dict(names), sheet=sheet, options=dict(options), results=results, pages=pages)
    outcomes: dict[Path, batch.LogOutcome] = {}
    with working(f"analysing {len(logs)} units", quiet=quiet) as done:
        for outcome in batch.run(logs, work, jobs=parallel, keep=keep):
            outcomes[outcome.log] = outcome
            _refuse_missing_option(logs, outcomes)
            if pages is not None:
                pages.refuse_file(
                    [each.extract.refusal for each in outcomes.values() if isinstance(each.extract, _KeptPart)]
                )
            if outcome.error and results is not None:
                file = results / f"{names[outcome.log]}.json"
                write_json(FailedAnalysis.of(outcome.error, str(outcome.log)).to_dict(), file)
            done(len(outcomes) / len(logs))
    extracts = {names[log]: outcomes[log].extract for log in logs}
    refusals = {unit: part.refusal for unit, part in extracts.items() if isinstance(part, _KeptPart) and part.refusal}
    return {names[log]: _examined(outcomes[log]) for log in logs}, refusals


def _refuse_missing_option(logs: Sequence[Path], outcomes: Mapping[Path, batch.LogOutcome]) -> None:
    """If no log could be read because of an option, raise the error of the first log."""
    if any(not outcome.error for outcome in outcomes.values()):
        return
    first = next((k for k, log in enumerate(logs) if log not in outcomes), len(logs))
    errors = [outcomes[log].error for log in logs[:first]]
    wrong = [error for error in errors if isinstance(error, OptionError)]
    if wrong and (len(wrong) >= _USAGE_ERRORS or first == len(logs)):
        raise wrong[0]


def _examined(outcome: batch.LogOutcome) -> UnitResult:
    if outcome.error:
        path = str(outcome.log)
        return without_result(outcome.error.without(path), path=path, absent=not outcome.log.exists())
    assert isinstance(outcome.extract, _KeptPart)
    return outcome.extract.unit


def _work(
    log: Path,
    *,
    readings: Mapping[Path, ReadingOptions],
    names: Mapping[Path, str],
    pages: UnitReports | None,
    threads: int,
) -> Analysis:
    record = read_log(log, readings[log], quiet=True)
    analysis = analyze(record, threads=threads)
    if pages is not None:
        pages.write(names[log], analysis, record)
    return analysis


@frozen
class _KeptPart:
    """The part of an analysis that is returned to this process."""

    unit: UnitResult
    refusal: str  # why the unit has no certificate; empty if it has one


def _keep(
    log: Path,
    analysis: Analysis,
    *,
    names: Mapping[Path, str],
    sheet: Datasheet | None,
    options: Mapping[str, Any],
    results: Path | None,
    pages: UnitReports | None,
) -> _KeptPart:
    if results is not None:
        write_json(analysis.to_dict(), results / f"{names[log]}.json")
    unit = examine(analysis, sheet, name=printable(names[log]), **options)
    return _KeptPart(unit=unit, refusal="" if pages is None else pages.refusal(names[log], analysis))
