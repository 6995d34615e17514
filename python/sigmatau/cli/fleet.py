"""``sigmatau fleet``: many logs, or very long ones, on several processes or hosts; the results go into a store."""

from __future__ import annotations

import os
import re
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from sigmatau.analysis.options import AnalysisOptions
from sigmatau.cli.declared import DeclaredOptions, Flag, InMain, InOutput, MayBeMinus, Quiet, typed_options
from sigmatau.cli.messages import print_error
from sigmatau.cli.options import say
from sigmatau.cli.reading import ReadingOptions
from sigmatau.cli.store import store_place
from sigmatau.errors import DataError, OptionError
from sigmatau.io.folders import skipped_lines
from sigmatau.lab.fleet.stored import DAMAGED, NOT_AT_REST
from sigmatau.lab.store.keeping import KeepCurves
from sigmatau.results import duration_text

if TYPE_CHECKING:
    from distributed import Client

    from sigmatau.lab.fleet.logs import Log
    from sigmatau.lab.fleet.stored import Stored
    from sigmatau.lab.fleet.tasks import FleetJob, FleetOutcome
    from sigmatau.lab.store.naming import Naming

_BATCH = 200  # number of results in a transaction
_BATCH_SECONDS = 5.0  # time after which a smaller number is committed too [s]
_LISTED = 10  # largest number of errors that are printed
_DIGITS = re.compile(r"\d+")
_REPORT = 30.0  # interval between lines of progress without a terminal [s]


@typed_options(AnalysisOptions, without=("threads",))
class FleetSettings(DeclaredOptions):
    """Options of the analyses of a fleet, whose workers have one thread each."""


def fleet_command(
    action: Literal["analyze"],
    /,
    *logs: str,
    store: Annotated[str | None, InMain] = None,
    workers: Annotated[int | None, InMain] = None,
    scheduler: Annotated[str | None, InOutput] = None,
    memory: Annotated[float | None, InOutput] = None,
    dashboard: Annotated[int | None, InOutput] = None,
    unit_from: Annotated[str | None, InMain] = None,
    model: Annotated[str, InMain] = "",
    date: Annotated[str | None, InMain] = None,
    temperature: Annotated[str | None, MayBeMinus, InMain] = None,
    supply: Annotated[str | None, InMain] = None,
    keep_curves: Annotated[KeepCurves, InMain] = "all",
    retry_failed: Annotated[bool, Flag, InMain] = False,
    reading: ReadingOptions | None = None,
    settings: FleetSettings | None = None,
    quiet: Quiet = False,
) -> int:
    """Analyse many logs, or very long ones, on several processes or hosts, and add the results to a store.

    Logs that are already in the store, unchanged and with the same options, are not analysed again, so that an interrupted
    command can be repeated. A log that cannot be used becomes a row in the store that states why.

    Parameters
    ----------
    action
        analyze.
    logs
        Logs, folders, patterns in quotes ('logs/**/*.csv') and URLs (s3://bucket/logs). A Zarr store too large for a worker
        is summed in stretches by several.
    store
        SQLite file, or postgresql://USER@HOST/NAME. Default: $SIGMATAU_STORE.
    workers
        Number of processes of this host (default: one for each core).
    scheduler
        Address of a running Dask scheduler, tcp://host:8786; its workers then do the work.
        Default: processes of this host.
    memory
        Memory of each process of this host in GB (default: its share of the host's). Larger records are divided.
    dashboard
        Port number of a page of Dask with tasks, workers and memory: 8787 for http://127.0.0.1:8787/status, on this host
        only, until the command ends. Default: no page.
    unit_from
        Source of the unit's name: folder, for the folder of its log; or a regular expression for the path of the log, whose
        first group is the unit, '(SN[0-9]+)'. Default: folder.
    model
        Sensor model of the units. Default: not stated.
    date
        Beginning of the records, 2026-05-01T12:00 (UTC), or name: the first date in the path of a log.
        Default: not stated.
    temperature
        Temperature of the records, 85degC or 298K. Default: that of the thermometer of each log.
    supply
        Supply voltage of the records, 3.3V or 3300mV. Default: that of a channel (vdd) or the name of each log.
    keep_curves
        Logs whose Allan deviations stay in the store: all; none; or failed, those without a fit, with an error, or with an
        axis whose trust is not good. Coefficients and findings are always stored. A log of six axes takes 20 kB with
        curves, 12 kB without.
    retry_failed
        Analyse logs that failed before again.
    quiet
        Print only errors and the last line.
    """
    place = store_place(store)
    if workers is not None and workers < 1:
        raise OptionError(f"--workers {workers}: must be a number of processes, at least 1", option="workers")
    if scheduler is not None and (workers is not None or memory is not None):
        raise OptionError(
            "--scheduler has its own workers: leave out --workers and --memory, or --scheduler", option="scheduler"
        )
    if dashboard is not None and not (1 <= dashboard <= 65535 and scheduler is None):
        what = "a running scheduler has its own" if scheduler else "must be a port, 1 to 65535"
        raise OptionError(f"--dashboard {dashboard}: {what}", option="dashboard")
    if memory is not None and not 0.1 <= memory <= 1e5:
        raise OptionError(f"--memory {memory:g}: must be a number of GB, at least 0.1", option="memory")

    from sigmatau.lab.fleet.logs import find
    from sigmatau.lab.fleet.run import cluster
    from sigmatau.lab.fleet.stored import Stored
    from sigmatau.lab.fleet.tasks import FleetJob
    from sigmatau.lab.store.connect import open_engine
    from sigmatau.lab.store.naming import Naming, stated_supply, stated_temperature

    how, chosen = (reading or ReadingOptions()).arguments(), (settings or FleetSettings()).arguments()
    degrees, voltage = stated_temperature(temperature), stated_supply(supply)
    naming = Naming(unit_from=unit_from, folders=True, model=model, date=date, temperature=degrees, supply=voltage)
    job = FleetJob(reading=how, settings=chosen, naming=naming, keep_curves=keep_curves)
    options = job.options  # wrong options are refused before they are sent to the workers
    naming.check()
    # Workers run in other folders, and logs/a.csv in two folders are two logs.
    logs = tuple(log if "://" in log else os.path.abspath(log) for log in logs)  # noqa: PTH100  of patterns
    skipped: list[str] = []
    named = [log for log in find(logs, skip=skipped.append) if not _is_store_file(log.place, place)]
    for line in skipped_lines([Path(log) for log in skipped if not _is_store_file(log, place)]):
        say(line, quiet=quiet)
    runs, unnamed = _all_stated(naming, named)
    named = [log for log in named if log.place in runs]
    with closing(Stored(open_engine(place), options, keep_curves=keep_curves)) as stored:
        wanted = [log for log in named if not stored.has(log, failures=not retry_failed)]
        stored_places = {log.place for log in named} - {log.place for log in wanted}
        if renamed := stored.describe(
            {log_place: values for log_place, values in runs.items() if values and log_place in stored_places}
        ):
            say(f"time, temperature or supply of {renamed} runs in the store changed", quiet=quiet)
        failures = {} if retry_failed else stored.failures(named)
        with_result = stored_places - failures.keys()
        codes = Counter(stored.code(log) for log in named if log.place in with_result)
        codes[1] = len(failures)
        before = _before(len(stored_places), codes)
        if lacking := sum(map(stored.lacks_curves, wanted)):
            say(f"analysed again: {_count(lacking)} in the store without the curves that are kept now", quiet=quiet)
        if before and wanted:
            say(f"of {len(named)} logs {before}", quiet=quiet)
        tally = _Tally(stored, len(wanted), tried=bool(stored_places))
        if wanted:
            gigabyte = None if memory is None else memory * 1e9
            with cluster(workers=workers, scheduler=scheduler, memory=gigabyte, dashboard=dashboard) as client:
                if dashboard is not None:
                    say(f"dashboard: http://127.0.0.1:{dashboard}/status", quiet=quiet)
                _run(client, wanted, job, tally, quiet=quiet)
    tally.codes_before = codes
    return _report(tally, before, unnamed, [f"{log}: {reason}" for log, reason in failures.items()])


def _run(client: Client, wanted: Sequence[Log], job: FleetJob, tally: _Tally, *, quiet: bool) -> None:
    """Analyse logs, with progress. Finished results are in the store even if the run fails."""
    from sigmatau.lab.fleet.run import run_fleet

    try:
        with _progress(len(wanted), quiet=quiet) as show:

            def done(outcomes: Sequence[FleetOutcome]) -> None:
                tally.take(outcomes)
                show(tally.finished)

            try:
                run_fleet(client, wanted, job, done=done, tell=lambda text: say(text, quiet=quiet))
            finally:
                tally.write()
    except DataError as error:
        if not tally.finished:
            raise
        raise DataError(
            f"{error}; {tally.written} of {len(wanted)} logs are in the store, and the same command continues"
        ) from None


def _report(tally: _Tally, before: str, unnamed: Sequence[str], failures: Sequence[str]) -> int:
    """Print errors, of an earlier run too, and the summary; returns the exit code."""
    lines = _grouped([*unnamed, *tally.errors, *failures])
    for line in lines[:_LISTED]:
        print_error(line)
    if unnamed:
        say(f"not analysed: {_count(len(unnamed))} without a unit or a date")
    if tally.held:
        say(f"nothing is stored: an option is wrong or missing for {tally.codes[2]} logs, and no log was analysed")
    elif len(lines) > _LISTED:
        count = len(tally.errors) + len(failures)
        say(f"… {count} failed in all; sigmatau store list lists them with --state failed")
    sys.stdout.write(f"{tally.summary(before)}\n")
    if tally.codes[2] and tally.finished == len(tally.errors):
        return 2  # otherwise the options are correct, and some of the files are of another kind
    if unnamed or failures:
        return 1
    codes = tally.codes + tally.codes_before
    return next((code for code, outcome in ((1, 2), (1, 1), (5, NOT_AT_REST), (4, DAMAGED)) if codes[outcome]), 0)


def _grouped(lines: Sequence[str]) -> list[str]:
    """Errors of logs, ``PLACE: REASON``; those whose reasons differ only in numbers are one line."""
    groups: dict[str, list[str]] = {}
    for line in lines:
        reason = line.partition(": ")[2] or line
        groups.setdefault(_DIGITS.sub("#", reason), []).append(line)
    return [
        group[0]
        if len(group) == 1
        else f"{group[0]}; the same for {len(group) - 1} more log{'s' if len(group) > 2 else ''}"
        for group in groups.values()
    ]


def _all_stated(naming: Naming, logs: Sequence[Log]) -> tuple[dict[str, dict[str, Any]], list[str]]:
    """Collect the stated facts about each run, and the reasons why logs lack a unit or a date. Raises `DataError` if all
    logs do.
    """
    stated: dict[str, dict[str, Any]] = {}
    unnamed: list[str] = []
    for log in logs:
        try:
            stated[log.place] = _stated(naming, log.place)
        except DataError as error:
            unnamed.append(str(error if error.source else error.about(log.place)))
    if unnamed and not stated:
        suffix = f"; the same for {len(unnamed) - 1} more logs" if len(unnamed) > 1 else ""
        raise DataError(f"{unnamed[0]}{suffix}")
    return stated, unnamed


def _stated(naming: Naming, place: str) -> dict[str, Any]:
    """The stated facts about the run of a log."""
    from sigmatau.analysis.failed import FailedAnalysis
    from sigmatau.lab.store.rows import in_utc

    without_result = FailedAnalysis(path=place, message="", exit_code=1)
    entry = naming.entry(without_result, Path(place))
    values = {
        "recorded": entry.recorded and in_utc(entry.recorded),
        "temperature": entry.temperature,
        "supply": entry.supply,
    }
    return {key: value for key, value in values.items() if value is not None}


def _is_store_file(log: str, store: str) -> bool:
    """Whether a file is the store, or an auxiliary file of SQLite next to it."""
    names = {store, *(f"{store}{end}" for end in ("-wal", "-shm", "-journal"))}
    return "://" not in log and os.path.abspath(log) in {os.path.abspath(name) for name in names}  # noqa: PTH100


def _count(logs: int) -> str:
    return f"{logs} log{'' if logs == 1 else 's'}"


def _before(stored_logs: int, codes: Counter[int]) -> str:
    """Describe the logs that are not analysed again, with their numbers by exit code; empty if there are none."""
    if not stored_logs:
        return ""
    parts = ", ".join(_outcomes(codes))
    return f"{stored_logs} were in the store{f' (of them {parts})' if parts else ''}"


def _outcomes(codes: Counter[int]) -> list[str]:
    """Numbers of logs by outcome, without those of exit code 0."""
    texts = {NOT_AT_REST: "not at rest or too short to tell", DAMAGED: "damaged and read in part", 1: "failed"}
    return [f"{codes[code]} {text}" for code, text in texts.items() if codes[code]]


class _Tally:
    """Outcomes that are waiting to be written to the store.

    Failures because of an option are held back until another log shows that the options are correct; otherwise `lot`
    would use them as the latest result of every unit. `tried`: the store has logs with the same options.
    """

    def __init__(self, stored: Stored, total: int, *, tried: bool) -> None:
        self._stored, self.total, self._tried = stored, total, tried
        self._waiting: list[FleetOutcome] = []
        self._since = time.monotonic()
        self.finished = 0
        self.written = 0
        self.codes: Counter[int] = Counter()
        self.codes_before: Counter[int] = Counter()  # of the logs that were in the store
        self.errors: list[str] = []

    def take(self, outcomes: Sequence[FleetOutcome]) -> None:
        """Add outcomes, and write all waiting ones if there are many or if they are old."""
        if not self._waiting:
            self._since = time.monotonic()
        self._waiting += outcomes
        self.finished += len(outcomes)
        for outcome in outcomes:
            self.codes[outcome.code] += 1
            if outcome.error:
                self.errors.append(outcome.error.for_command_line())
        if len(self._waiting) >= _BATCH or (self._waiting and time.monotonic() - self._since > _BATCH_SECONDS):
            self.write()

    def write(self) -> None:
        """Write the waiting outcomes in one transaction. Written outcomes remain after a later failure."""
        if self._waiting and not self.held:
            waiting, self._waiting = self._waiting, []
            self._stored.add([outcome.rows for outcome in waiting], [outcome.log for outcome in waiting])
            self.written += len(waiting)

    @property
    def held(self) -> bool:
        """Whether every log so far has failed because of an option."""
        return not self._tried and self.codes[2] > 0 and self.finished == len(self.errors)

    def summary(self, before: str) -> str:
        """Number of logs by outcome, in one line."""
        failed = len(self.errors)
        texts = [
            f"{self.finished - failed} of {self.total} logs analysed",
            *_outcomes(Counter({**self.codes, 1: failed})),
        ]
        return ", ".join([*texts, before] if before else texts)


@contextmanager
def _progress(total: int, *, quiet: bool) -> Iterator[Callable[[int], None]]:
    """Show the number of finished logs, the rate and the remaining time: a bar on a terminal, otherwise a line at
    intervals.
    """
    begun = time.monotonic()
    if quiet:
        yield lambda _: None
        return
    if not sys.stderr.isatty():
        last = begun

        def tell(done: int) -> None:
            nonlocal last
            now = time.monotonic()
            if now - last > _REPORT:
                last = now
                say(", ".join(filter(None, [f"{done} of {total} logs", _rate(done, total, now - begun)])))

        yield tell
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn(), TextColumn("{task.fields[rate]}"))
    with Progress(*columns, console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task(f"{total} logs", total=total, rate="")

        def draw(done: int) -> None:
            progress.update(
                task,
                completed=done,
                description=f"{done} of {total} logs",
                rate=_rate(done, total, time.monotonic() - begun),
            )

        yield draw


def _rate(done: int, total: int, seconds: float) -> str:
    if not done or seconds <= 0:
        return ""
    return f"{done / seconds:.3g} logs/s, {duration_text((total - done) * seconds / done)} left"
