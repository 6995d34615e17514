"""Several logs, in sequence or in parallel. Parallel analyses run in other processes, so that a crash does not stop the
others.
"""

from __future__ import annotations

import gc
import os
import signal
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from sigmatau.analysis import Analysis
from sigmatau.errors import DataError, OptionError
from sigmatau.findings.finding import Finding, damaged, exit_code
from sigmatau.frozen import frozen
from sigmatau.process import keep_freed
from sigmatau.results import aligned, duration_text

if TYPE_CHECKING:
    from multiprocessing.connection import Connection
    from multiprocessing.context import SpawnContext
    from multiprocessing.process import BaseProcess

    from sigmatau.quality.clocks import Mark


@frozen
class LogOutcome:
    """Outcome of one log."""

    log: Path
    error: OptionError | DataError | None = None  # Reason why there is no result
    findings: tuple[Finding, ...] = ()
    marks: tuple[Mark, ...] = ()  # Frequencies for the comparison with other records of the unit
    rows: tuple[tuple[str, ...], ...] = ()  # Rows of the table: channel, length, rate, coefficients, trust
    extract: object = None  # What the `keep` of `run` returned for the analysis

    @property
    def code(self) -> int:
        """Exit code for this log alone."""
        if self.error is None:
            return exit_code(self.findings)
        return 2 if isinstance(self.error, OptionError) else 1


def run(
    logs: Sequence[Path],
    work: Callable[[Path], Analysis],
    *,
    jobs: int,
    keep: Callable[[Path, Analysis], object] | None = None,
) -> Iterator[LogOutcome]:
    """Yield the outcomes of logs in the order of completion, with `jobs` analyses in parallel.

    `work` analyses one log and writes its outputs; `keep` selects the part of an analysis that is returned. Both are sent
    to other processes, so each must be a function of a module or a `functools.partial` of one.
    """
    import multiprocessing
    import multiprocessing.connection

    context = multiprocessing.get_context("spawn")  # a forked process would lack the threads of this one
    waiting = list(logs)
    workers: dict[Connection, BaseProcess] = {}
    busy: dict[Connection, Path] = {}
    try:
        while waiting or busy:
            while waiting and len(busy) < jobs:
                idle = next((worker for worker in workers if worker not in busy), None) or _started(
                    context, work, keep, workers
                )
                try:
                    idle.send(waiting[0])
                except OSError:  # the process ended before it got a log
                    _join(idle, workers)
                    continue
                busy[idle] = waiting.pop(0)
            for ready in multiprocessing.connection.wait(list(busy)):
                assert isinstance(ready, multiprocessing.connection.Connection)
                log = busy.pop(ready)
                try:
                    outcome = ready.recv()
                except (EOFError, OSError):
                    outcome = LogOutcome(log=log, error=DataError(_why_ended(_join(ready, workers))).about(str(log)))
                yield outcome
    finally:
        for process in workers.values():
            process.terminate()


def _started(
    context: SpawnContext,
    work: Callable[[Path], Analysis],
    keep: Callable[[Path, Analysis], object] | None,
    workers: dict[Connection, BaseProcess],
) -> Connection:
    """Start a process that waits for logs."""
    our_end, their_end = context.Pipe()
    process = context.Process(target=_work, args=(work, keep, their_end), daemon=True)
    process.start()
    their_end.close()
    workers[our_end] = process
    return our_end


def _join(connection: Connection, workers: dict[Connection, BaseProcess]) -> int | None:
    """Remove a process that has ended from `workers`, and return its exit code."""
    process = workers.pop(connection)
    connection.close()
    process.join()
    return process.exitcode


def _work(work: Callable[[Path], Analysis], keep: Callable[[Path, Analysis], object] | None, logs: Connection) -> None:
    """Analyse logs until there are no more. A process imports most modules once for all its logs."""
    # Ctrl-C reaches all processes of the terminal; the parent stops the others.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    keep_freed()
    gc.freeze()
    while True:
        try:
            log = logs.recv()
        except EOFError:
            return
        logs.send(_outcome(log, work, keep))
        gc.collect()  # the samples of two logs must not be in memory at the same time


def _outcome(
    log: Path, work: Callable[[Path], Analysis], keep: Callable[[Path, Analysis], object] | None = None
) -> LogOutcome:
    from sigmatau.quality.clocks import collect_marks

    try:
        analysis = work(log)
        marks = collect_marks(analysis.fits)
        extract = None if keep is None else keep(log, analysis)
        return LogOutcome(
            log=log, findings=analysis.findings, marks=marks, rows=tuple(_rows(analysis)), extract=extract
        )
    except (OptionError, DataError) as error:
        return LogOutcome(log=log, error=error)
    except ImportError as error:
        return LogOutcome(log=log, error=DataError(str(error)))
    except MemoryError:
        return LogOutcome(log=log, error=DataError("not enough memory for this record").about(str(log)))


def _why_ended(code: int | None) -> str:
    if code is not None and code < 0:
        name = signal.Signals(-code).name if -code in set(signal.Signals) else str(-code)
        why = " (the system does that when memory is short: use fewer --jobs)" if name == "SIGKILL" else ""
        return f"its process was ended by {name}{why}"
    return f"its process ended with exit code {code}"


_TERMS = ("random_walk", "bias_instability", "rate_random_walk")


def _rows(analysis: Analysis) -> Iterator[tuple[str, ...]]:
    for channel, curve in analysis.curves.items():
        fit, read = analysis.fits.get(channel), analysis.read_off.get(channel)
        length, rate = duration_text(curve.n * curve.tau0), f"{1 / curve.tau0:.6g} Hz"
        texts = []
        for term in _TERMS:
            if fit is not None:
                value, interval, unit = fit.texts(term)[-1] if term in fit else ("", "", "")
                # A value that is consistent with zero is printed with its interval.
                if value and fit[term].low == 0:
                    value = f"{value} {interval}"
            else:
                value, unit = read.texts(term)[-1] if read is not None and term in read else ("", "")
            texts.append(f"{value} {unit}" if value else "")
        without_fit = analysis.rest.reason if read is None and analysis.rest else "read off"
        trust = without_fit if fit is None else str(fit.trust)
        yield channel, length, rate, *texts, trust + (", DAMAGED" if damaged(analysis.findings) else "")


_LIMITS = "below: 95 % upper limit; the intervals are in the results, --json FOLDER"


def summary(outcomes: Sequence[LogOutcome]) -> str:
    """Table of all logs, in the order in which they were given."""
    head = ("log", "channel", "length", "rate", *(t.replace("_", " ") for t in _TERMS), "trust")
    short = _short([outcome.log for outcome in outcomes])
    rows = [
        (name if first else "", *row)
        for name, outcome in zip(short, outcomes, strict=True)
        for first, row in ((i == 0, row) for i, row in enumerate(outcome.rows or [("", "", "", "", "", "", "failed")]))
    ]
    good = sum(not outcome.error for outcome in outcomes)
    limits = [_LIMITS] if any(cell.startswith("below ") for row in rows for cell in row) else []
    return "\n".join([*aligned([head, *rows]), *limits, "", f"{good} of {len(outcomes)} logs analysed"])


def names(logs: Sequence[Path]) -> list[str]:
    """A unique name for the result of each log."""
    short = [name.replace(os.sep, "_") for name in _short(logs)]
    unique: list[str] = []
    for k, name in enumerate(short):
        number = short[:k].count(name) + 1
        numbered = name if short.count(name) == 1 else f"{name}-{number}"
        while numbered in unique or (numbered != name and numbered in short):
            number += 1
            numbered = f"{name}-{number}"
        unique.append(numbered)
    return unique


def _short(logs: Sequence[Path]) -> list[str]:
    """File names, or relative paths where file names repeat."""
    if len({log.name for log in logs}) == len(logs):
        return [log.name for log in logs]
    base = os.path.commonpath([log.absolute().parent for log in logs])
    return [str(log.absolute().relative_to(base)) for log in logs]
