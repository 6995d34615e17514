"""``sigmatau store``: add results to a database; list, show and export them, and follow coefficients over time."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from sigmatau.cli.declared import DeclaredOptions, Show, typed_options
from sigmatau.cli.messages import print_error
from sigmatau.cli.options import (
    check_output,
    check_outputs,
    command_line,
    json_text,
    matched,
    say,
    working,
    write_result,
)
from sigmatau.errors import DataError, OptionError
from sigmatau.io.atomic import atomic
from sigmatau.lab.lots.options import CompareOptions
from sigmatau.lab.store.keeping import KeepCurves
from sigmatau.noise.shown import set_shown
from sigmatau.noise.terms import TERMS, check_shown
from sigmatau.results import csv_text

if TYPE_CHECKING:
    from sigmatau.lab.store.choosing import Chosen, StoreTable
    from sigmatau.lab.store.store import Store

VARIABLE = "SIGMATAU_STORE"
"""Environment variable with the default of --store."""

_MAX_PROBLEMS = 10  # largest number of files that are listed on the screen
_STATES = ("fitted", "not_fitted", "not_at_rest", "too_short_to_tell", "failed")
_SHOWN = {
    "units": (
        "unit",
        "model",
        "runs",
        "fitted",
        "not_fitted",
        "not_at_rest",
        "too_short_to_tell",
        "failed",
        "first",
        "last",
    ),
    "runs": ("unit", "run", "recorded", "temperature", "supply", "duration", "state", "revision", "message"),
}

_TIMES = ("recorded", "first", "last")
_KINDS = {  # types of the columns of Parquet; the others are text
    "int64": ("id", "runs", "fitted", "not_fitted", "not_at_rest", "too_short_to_tell", "failed", "revision"),
    "double": ("temperature", "supply", "duration", "value", "low", "high", "upper_limit", "level"),
    "bool": ("observed", "has_curves"),
}

_ROUNDED = 0.5  # rounding of a stated temperature: 298 K is 25 degC [K]
_ROUNDED_SUPPLY = 0.015  # relative rounding of a stated supply voltage, half of the difference of two groups [1]

Place = Annotated[str | None, Parameter(name="--store")]
Temperature = Annotated[str | None, Parameter(allow_leading_hyphen=True)]
Json = Annotated[Path | None, Parameter(name="--json", allow_leading_hyphen=True)]
Quiet = Annotated[bool, Parameter(name=["--quiet", "-q"], negative=())]


@typed_options(CompareOptions, only=("level",))
class LevelSettings(DeclaredOptions):
    """The confidence level of a trend, as in a comparison."""


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class Choice:
    """Selection of runs of a store.

    Parameters
    ----------
    unit
        Only units with this serial number; A* selects all serial numbers that begin with A. May be repeated.
    model
        Only units of this sensor model.
    since
        Only records from this time on, 2026-05-01 or 2026-05-01T12:00 (UTC).
    until
        Only records before this time.
    state
        Only runs in this state: fitted, not_fitted, not_at_rest, too_short_to_tell, failed. May be repeated.
    temperature
        Only runs at this temperature to 0.5 °C, 85degC, or in a range, 20:30.
    supply
        Only runs at this supply voltage to 1.5 %, 3.3V, or in a range, 3:3.6.
    """

    unit: Annotated[list[str] | None, Parameter(negative=())] = None
    model: str | None = None
    since: str | None = None
    until: str | None = None
    state: Annotated[
        list[Literal["fitted", "not_fitted", "not_at_rest", "too_short_to_tell", "failed"]] | None,
        Parameter(negative=()),
    ] = None
    temperature: Temperature = None
    supply: str | None = None

    def chosen(self, *, history: bool = False) -> Chosen:
        """Convert the selection for a `Store`."""
        from sigmatau.lab.store.choosing import Chosen

        return Chosen(
            units=tuple(self.unit or ()),
            model=self.model,
            states=tuple(self.state or ()),
            since=_time(self.since, "since"),
            until=_time(self.until, "until"),
            temperature=temperatures(self.temperature),
            supply=supplies(self.supply),
            history=history,
        )


def store_place(store: str | None) -> str:
    """The file or URL of ``--store``, or of the environment."""
    if place := store or os.environ.get(VARIABLE):
        return place
    raise OptionError(
        f"--store is missing: a SQLite file, or postgresql://USER@HOST/NAME; or set ${VARIABLE}", option="store"
    )


def opened(store: str | None, *, create: bool = False) -> Store:
    """The store of ``--store``, or of the environment."""
    place = store_place(store)
    from sigmatau.lab.store.store import Store

    return Store(place, create=create)


def temperatures(text: str | None) -> tuple[float, float] | None:
    """Parse the range of ``--temperature``: a single temperature includes all temperatures that round to it. [degC]"""
    from sigmatau.lab.lots.conditions import celsius
    from sigmatau.lab.store.naming import check_range

    if text is None:
        return None
    low, high, exact = _range(
        text, "temperature", celsius, check_range, "must be a temperature, 85degC, or a range, 20:30"
    )
    return (low, high) if exact else (low - _ROUNDED, high + _ROUNDED)


def supplies(text: str | None) -> tuple[float, float] | None:
    """Parse the range of ``--supply``: a single voltage includes all voltages within 1.5 %. [V]"""
    from sigmatau.lab.lots.conditions import volts
    from sigmatau.lab.store.naming import check_supply

    if text is None:
        return None
    low, high, exact = _range(text, "supply", volts, check_supply, "must be a voltage, 3.3V, or a range, 3:3.6")
    return (low, high) if exact else (low * (1 - _ROUNDED_SUPPLY), high * (1 + _ROUNDED_SUPPLY))


def _range(
    text: str,
    option: str,
    parse: Callable[[str], float | None],
    check: Callable[[float], None],
    form: str,
) -> tuple[float, float, bool]:
    """Parse a value or a range; returns its ends, and whether it is a range."""
    ends = [parse(part) for part in text.split(":")]
    low, high = (ends[0], ends[-1]) if len(ends) <= 2 else (None, None)
    if low is None or high is None:
        raise OptionError(f"--{option} {text:.40}: {form}", option=option)
    check(low)
    check(high)
    if low > high:
        raise OptionError(
            f"--{option} {text:.40}: the range ends below its beginning; give the lower {option} first", option=option
        )
    return low, high, len(ends) == 2


def _time(text: str | None, option: str) -> datetime | None:
    if text is None:
        return None
    try:
        return datetime.fromisoformat(text.strip())
    except ValueError:
        raise OptionError(
            f"--{option} {text}: must be a date like 2026-05-01 or 2026-05-01T12:00", option=option
        ) from None


def add_command(
    *results: Path,
    store: Place = None,
    unit: str | None = None,
    unit_from: str | None = None,
    model: str | None = None,
    date: str | None = None,
    temperature: Temperature = None,
    supply: str | None = None,
    keep_curves: KeepCurves = "all",
    jobs: int | None = None,
    quiet: Quiet = False,
) -> int:
    """Add results of analyze to a store.

    The same log with the same options is added once; a different result of it becomes a new revision.

    A file that is not a result is named on standard error, the others are added, and the exit code is 1.

    Parameters
    ----------
    results
        JSON files of analyze, or folders of them.
    store
        SQLite file, which is created if it does not exist, or postgresql://USER@HOST/NAME. Default: $SIGMATAU_STORE.
    unit
        Serial number for all results. Default: the note "serial number" of analyze, or the folder if there are several.
    unit_from
        Where the serial number is: folder (of the JSON), log-folder (of the log), or a regular expression for the path of
        the log, whose group is the serial number: 'SN([0-9]+)'. Default: as for --unit.
    model
        Sensor model. Default: the note "model".
    date
        Beginning of the records, 2026-05-01T12:00 (UTC, or with a time zone); or name: the date in the name of each log.
        Default: the note "date".
    temperature
        Temperature of the records, 85degC or 298K. Default: the note "temperature", or else the thermometer of each log.
    supply
        Supply voltage of the records, 3.3V or 3300mV. Default: the note "supply", or else a channel (vdd) or the name of
        each log.
    keep_curves
        Results whose Allan deviations stay in the store: all; none; or failed, those without a fit, with an error, or with
        an axis whose trust is not good. Coefficients and findings are always stored.
    jobs
        Number of processes that read many files (default: all cores).
    quiet
        Print only errors on standard error.
    """
    if not results:
        raise OptionError("no results; give JSON files of sigmatau analyze, or a folder of them", option="results")
    if jobs is not None and jobs < 1:
        raise OptionError(f"--jobs {jobs}: must be a number of processes, at least 1", option="jobs")
    from sigmatau.lab.lots.reading import gather
    from sigmatau.lab.store.naming import Naming, stated_supply, stated_temperature

    naming = Naming(
        unit=unit,
        unit_from=unit_from,
        model=model or "",
        date=date,
        temperature=stated_temperature(temperature),
        supply=stated_supply(supply),
    )
    naming.check()
    files = list(dict.fromkeys(gather(matched(results), tables=False)))
    if not any(file.exists() for file in files):  # before a store is created
        raise DataError(f"{files[0]}: No such file or directory")
    if len({file.absolute().parent for file in files}) > 1 and unit is None and unit_from is None:
        naming = replace(naming, folders=True)
    with opened(store, create=True) as opened_store, working("adding results", quiet=quiet) as done:
        outcome = opened_store.add_files(
            files,
            naming,
            jobs=jobs or os.cpu_count() or 1,
            keep_curves=keep_curves,
            done=lambda count: done(count / len(files)),
        )
    unnamed = [problem for problem in outcome.problems if problem.unit_unknown]
    for problem in outcome.problems[:_MAX_PROBLEMS]:
        print_error(f"{problem.file}: {problem.reason}")
    if len(outcome.problems) > _MAX_PROBLEMS:
        say(f"{len(outcome.problems) - _MAX_PROBLEMS} more files were not added")
    added = outcome.added
    counts = [
        (added.new, "new"),
        (added.revised, "revised"),
        (added.updated, "updated"),
        (added.known, "already there"),
    ]
    text = ", ".join(f"{count} {what}" for count, what in counts if count or what == "new")
    say(f"{text}{f', {len(outcome.problems)} not added' if outcome.problems else ''}", quiet=quiet)
    return 2 if unnamed and len(unnamed) == len(outcome.problems) else 1 if outcome.problems else 0


def list_command(
    what: Literal["units", "runs"] = "units",
    /,
    *,
    store: Place = None,
    choice: Choice | None = None,
    history: Annotated[bool, Parameter(negative=())] = False,
    json: Annotated[bool, Parameter(negative=())] = False,
) -> int:
    """List the units or the runs of a store.

    Parameters
    ----------
    what
        units (default) or runs.
    store
        SQLite file or URL. Default: $SIGMATAU_STORE.
    history
        Also list results that were replaced by later results of the same log and options.
    json
        Print JSON.
    """
    chosen = (choice or Choice()).chosen(history=history)
    with opened(store) as opened_store:
        table = opened_store.units(chosen) if what == "units" else opened_store.runs(chosen)
    if json:
        sys.stdout.write(json_text(table.to_dict()))
    elif not len(table):
        empty = chosen == Choice().chosen(history=history)
        say(
            f"no {what} in the store; sigmatau store add adds results"
            if empty
            else f"no {what} of this kind in the store"
        )
    else:
        sys.stdout.write(f"{table.shown(_SHOWN[what])!r}\n")
    return 0


def show_command(
    unit: str,
    /,
    *,
    store: Place = None,
    run: str | None = None,
    json: Json = None,
    show: Show = None,
) -> int:
    """Show the latest result of a unit: all coefficients with intervals, and findings.

    Parameters
    ----------
    unit
        Serial number.
    store
        SQLite file or URL. Default: $SIGMATAU_STORE.
    run
        Name of the run. Default: the latest with coefficients, otherwise the latest.
    json
        Write the result as JSON, as analyze wrote it; - writes it to standard output.
    """
    set_shown(show)
    check_output(None if str(json) == "-" else json, (), "json")
    with opened(store) as opened_store:
        row, result = opened_store.latest(unit, run=run)
        findings = opened_store.findings(row["id"])
        content = opened_store.content(row["id"]) if json is not None else None
    from sigmatau.analysis.failed import FailedAnalysis
    from sigmatau.lab.store.text import result_text

    if not isinstance(result, FailedAnalysis):
        check_shown({name: (fitted.quantity, fitted.rate_unit) for name, fitted in result.fits.items()})
    write_result(result_text(row, result), content, json)
    for severity, message in findings:
        say(f"{severity}: {message}")
    return 0


def trend_command(
    *,
    store: Place = None,
    term: str = "random_walk",
    channel: Annotated[list[str] | None, Parameter(negative=())] = None,
    by: Literal["day", "week", "month", "quarter", "year"] = "month",
    settings: LevelSettings | None = None,
    choice: Choice | None = None,
    report: Path | None = None,
    json: Json = None,
    show: Show = None,
) -> int:
    """Follow a coefficient over time: median and spread by period, drift from unit to unit and within units.

    Parameters
    ----------
    store
        SQLite file or URL. Default: $SIGMATAU_STORE.
    term
        quantization, random_walk, bias_instability, rate_random_walk, rate_ramp, or mean.
    channel
        Channel, gyro_x; may be repeated. Default: all.
    by
        Length of a period.
    report
        Write a page that opens offline (.html): charts of the medians with their intervals, drifts, and the tables.
    json
        Write the trend as JSON; - writes it to standard output.
    """
    set_shown(show)
    check_output(report, (".html",), "report")
    check_outputs([], report=report, json=json)
    chosen = (choice or Choice()).chosen()
    level = (settings or LevelSettings()).arguments()
    with opened(store) as opened_store:
        trend = opened_store.trend(term, channels=tuple(channel or ()), by=by, chosen=chosen, **level)
    check_shown(
        {name: (each.quantity, each.rate_unit) for name, each in trend.channels.items()},
        [term if term in TERMS else "bias_instability"],
    )
    if report is not None:
        from sigmatau.lab.pages.trend_html import trend_page
        from sigmatau.lab.store.connect import shown_place

        with atomic(report) as temporary:
            content = trend_page(
                trend, store=shown_place(store_place(store)), command=command_line(), date=datetime.now(tz=UTC)
            )
            temporary.write_text(content, encoding="utf-8")
    write_result(repr(trend), trend.to_dict() if json is not None else None, json)
    return 0


def export_command(
    *,
    output: Annotated[Path, Parameter(name=["--output", "-o"])],
    store: Place = None,
    what: Literal["coefficients", "runs", "units"] = "coefficients",
    term: str | None = None,
    choice: Choice | None = None,
    history: Annotated[bool, Parameter(negative=())] = False,
    decimal_comma: Annotated[bool, Parameter(negative=())] = False,
) -> int:
    """Export a table of a store to Parquet or CSV, in SI units.

    Parameters
    ----------
    output
        File to write: .parquet or .csv.
    store
        SQLite file or URL. Default: $SIGMATAU_STORE.
    what
        coefficients (a row for each run, channel and term), runs or units.
    term
        Only this term.
    history
        Also export results that later ones of the same log and options have replaced.
    decimal_comma
        Write .csv with decimal commas, and semicolons between the columns.
    """
    check_output(output, (".parquet", ".csv"), "output")
    chosen = (choice or Choice()).chosen(history=history)
    if term is not None and what != "coefficients":
        raise OptionError("--term selects coefficients; leave it out, or give --what coefficients", option="term")
    with opened(store) as opened_store:
        if what == "coefficients":
            table = opened_store.coefficients(chosen, term=term)
        else:
            table = opened_store.units(chosen) if what == "units" else opened_store.runs(chosen)
    if not len(table):
        raise DataError(f"the store has no {what} of this kind; nothing is written")
    _write(table, output, decimal_comma=decimal_comma)
    say(f"written: {output} ({len(table)} rows)")
    return 0


def _write(table: StoreTable, output: Path, *, decimal_comma: bool) -> None:
    if output.suffix == ".csv":
        with atomic(output) as temporary:
            temporary.write_text(csv_text(table.to_dict(), decimal_comma=decimal_comma), encoding="utf-8")
        return
    try:
        import pyarrow as pa
        import pyarrow.parquet as parquet
    except ImportError:
        raise ImportError("writing .parquet needs pyarrow: pip install 'sigmatau[parquet]'; or write .csv") from None
    columns = table.columns()
    # An empty column has the same type as one with values, so that the files of several months have one schema.
    kinds = {key: kind for kind, keys in _KINDS.items() for key in keys}
    arrays = {}
    for key, values in columns.items():
        if key in _TIMES:
            arrays[key] = pa.array(
                [None if x is None else x.replace(tzinfo=UTC) for x in values], pa.timestamp("us", "UTC")
            )
        else:
            arrays[key] = pa.array(values, kinds.get(key, "string"))
    with atomic(output) as temporary:
        parquet.write_table(pa.table(arrays), temporary)
