"""``sigmatau compare``: repeatability of runs of a unit, from results of analyze or from tables of values."""

from __future__ import annotations

import sys
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from sigmatau.cli.declared import DeclaredOptions, Show, typed_options
from sigmatau.cli.options import (
    check_output,
    check_outputs,
    check_style,
    command_line,
    drawing,
    matched,
    say,
    working,
    write_figure,
    write_result,
)
from sigmatau.cli.store import Choice, opened
from sigmatau.cli.turn_on import write_model
from sigmatau.errors import DataError, OptionError
from sigmatau.io.atomic import atomic
from sigmatau.lab.lots.comparison import RunComparison, compare_runs
from sigmatau.lab.lots.comparison_text import overview, tables, unused_lines
from sigmatau.lab.lots.options import CompareOptions
from sigmatau.noise.shown import set_shown
from sigmatau.noise.terms import check_shown
from sigmatau.results import csv_text

_MAX_UNUSED = 10  # largest number of unused results that are listed on the screen

_UNUSABLE = 1


@typed_options(CompareOptions)
class Comparing(DeclaredOptions):
    """Options of a comparison of runs."""


def compare_command(
    *results: Path,
    comparing: Comparing | None = None,
    table: Annotated[bool, Parameter(name=["--table", "--verbose", "-v"], negative=())] = False,
    report: Path | None = None,
    plot: Path | None = None,
    style: Literal["screen", "paper"] = "screen",
    json: Annotated[Path | None, Parameter(allow_leading_hyphen=True)] = None,
    csv: Path | None = None,
    decimal_comma: Annotated[bool, Parameter(negative=())] = False,
    model: Path | None = None,
    store: str | None = None,
    unit: Annotated[list[str] | None, Parameter(negative=())] = None,
    temperature: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    supply: str | None = None,
    show: Show = None,
    quiet: Annotated[bool, Parameter(name=["--quiet", "-q"], negative=())] = False,
) -> int:
    """Compare runs of a unit: repeatability, spread between runs with its interval, outlying runs.

    Units are distinguished by the note "serial number" of analyze, or by folder. A result that cannot be used is named on
    standard error, the others are compared, and the exit code is 1.

    Parameters
    ----------
    results
        JSON or CSV files of analyze, or folders of them; or a table of values, a CSV with the columns run, channel, term,
        value, unit and error (1 sigma) or error_percent.
    table
        Print all values: one table for each sensor and term, runs as rows and axes as columns, as in the paper.
    report
        Write a page that opens offline (.html): charts of the values of all runs with their intervals, and the tables.
    plot
        Draw the values of the first group with their intervals: .png, .svg or .pdf.
    style
        Style of the figure: screen, or paper, for the width of a column or a page of a paper.
    json
        Write the comparison as JSON; - writes it to standard output instead of the table.
    csv
        Write one row for each group, channel and term as CSV in SI units.
    decimal_comma
        Write the CSV with decimal commas, and semicolons between the columns.
    model
        Write a model file (.toml): the noise of the longest record, and the turn-on bias of each channel, which is the
        spread of its means over the runs, with its interval. Each run has to follow a power-up.
    store
        Compare the runs of this store in place of results: a SQLite file or postgresql://USER@HOST/NAME, see sigmatau
        store. Lines and filters (the clocks) are not compared.
    unit
        With --store, serial number; A* selects all serial numbers that begin with A. May be repeated.
    temperature
        With --store, only runs at this temperature to 0.5 °C, 85degC, or in a range, 20:30.
    supply
        With --store, only runs at this supply voltage to 1.5 %, 3.3V, or in a range, 3:3.6.
    quiet
        Print only errors on standard error.
    """
    set_shown(show)
    if store is not None and results:
        raise OptionError("give results, or --store, not both", option="store")
    if unit and store is None:
        raise OptionError("--unit needs --store; results are chosen by name", option="unit")
    for condition, text in (("temperature", temperature), ("supply", supply)):
        if text is not None and store is None:
            raise OptionError(f"--{condition} needs --store; results are chosen by name", option=condition)
    if not results and store is None:
        raise OptionError("no results; give JSON files of sigmatau analyze, or a folder of them", option="results")
    options = CompareOptions(**(comparing or Comparing()).arguments())
    if options.jobs is not None and options.jobs < 1:
        raise OptionError(f"--jobs {options.jobs}: must be a number of processes, at least 1", option="jobs")
    results = matched(results)
    check_style(style, plot)
    if model is not None and store is not None:
        raise OptionError("--model needs results as files, not --store", option="model")
    _refuse_inside(results, None if str(json) == "-" else json, csv, model)
    check_output(report, (".html",), "report")
    check_outputs(results, report=report, plot=plot, json=json, csv=csv, model=model)
    with working("reading results", quiet=quiet):
        comparison = (
            compare_runs(results, by=options.by, level=options.level, jobs=options.jobs)
            if store is None
            else _compare_stored(store, Choice(unit=unit, temperature=temperature, supply=supply), options)
        )
    check_shown({label.channel: (label.quantity, label.rate_unit) for label in comparison.table.labels})
    if csv is not None:
        with atomic(csv) as temporary:
            temporary.write_text(csv_text(comparison.columns(), decimal_comma=decimal_comma), encoding="utf-8")
    if report is not None:
        from sigmatau.lab.pages.comparison_html import comparison_page

        with working(f"writing {report}", quiet=quiet), atomic(report) as temporary:
            content = comparison_page(comparison, command=command_line(), date=datetime.now(tz=UTC))
            temporary.write_text(content, encoding="utf-8")
    if plot is not None:
        with drawing(plot, style, quiet=quiet):
            write_figure(comparison.plot(), plot)
    text = f"{overview(comparison)}\n\n{tables(comparison)}" if table else overview(comparison)
    write_result(text, comparison.to_dict() if json is not None else None, json)
    if model is not None:
        for line in write_model(comparison, model):
            say(line, quiet=quiet)
    used = [run for run in comparison.runs if not run.problem]
    if options.by == "unit" and len(used) > 1 and not any(run.serial or run.typed for run in used):
        say(
            'one unit is assumed; name units by analyze --note "serial number=A123", or put them in folders',
            quiet=quiet,
        )
    return _print_unused(comparison, quiet=quiet)


def _compare_stored(place: str, choice: Choice, options: CompareOptions) -> RunComparison:
    with opened(place) as store:
        return store.compare(choice.chosen(), by=options.by, level=options.level)


def _refuse_inside(results: tuple[Path, ...], *outputs: Path | None) -> None:
    """Raise an error for an output in a folder that is read, because the next run would read it as a result."""
    folders = [place.resolve() for place in results if place.is_dir()]
    for output in outputs:
        if output is not None and any(folder in output.resolve().parents for folder in folders):
            raise DataError(f"{output}: is inside a folder of results; write it to another folder")


def _print_unused(comparison: RunComparison, *, quiet: bool) -> int:
    """List the results that were not compared; return the exit code."""
    lines = unused_lines(comparison)
    for line in lines[:_MAX_UNUSED]:
        if line.startswith("not used: "):
            sys.stderr.write("sigmatau: ")
            say(line)
        else:
            say(line, quiet=quiet)
    if len(lines) > _MAX_UNUSED:
        say(f"and {len(lines) - _MAX_UNUSED} more: --json lists them")
    return _UNUSABLE if comparison.unused else 0
