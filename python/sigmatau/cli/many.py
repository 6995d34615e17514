"""Several logs, one after the other or side by side: each in a process of its own, so that none can end the others."""

from __future__ import annotations

import multiprocessing
import multiprocessing.connection
import os
import signal
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sigmatau.analysis import Analysis
from sigmatau.errors import DataError, OptionError
from sigmatau.io.read.split import files_of
from sigmatau.results import Finding, damaged

__all__ = ["Outcome", "gather", "names", "run", "summary"]

# What lies beside logs in a folder and is none.
_BESIDE = (".json", ".toml", ".yaml", ".yml", ".md", ".png", ".svg", ".pdf", ".html")


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """What became of one log.

    Attributes
    ----------
    log : Path
    error : str
        Why there is no result; empty if there is one.
    findings : tuple of Finding
    rows : tuple of tuple of str
        Of the table: channel, coefficients, verdict.
    usage : bool
        Whether the error is about an option.
    """

    log: Path
    error: str = ""
    findings: tuple[Finding, ...] = ()
    rows: tuple[tuple[str, ...], ...] = ()
    usage: bool = False

    @property
    def code(self) -> int:
        """Exit code that this log by itself would have had."""
        return (2 if self.usage else 1) if self.error else damaged(self.findings)


def gather(places: Sequence[Path]) -> tuple[list[Path], list[Path]]:
    """Logs, those of folders among them in the order of their names; and what is left out of folders, which is no log.

    Raises
    ------
    DataError
        If a folder holds no log.
    OptionError
        If a log is given twice.
    """
    logs: list[Path] = []
    left_out: list[Path] = []
    for place in places:
        if not place.is_dir() or files_of(place):
            logs.append(place)
            continue
        inside = sorted(f for f in place.iterdir() if not f.name.startswith("."))
        files = [f for f in inside if f.is_file() or (f.is_dir() and files_of(f))]  # bags of ROS 2 are folders
        found = [f for f in files if f.suffix.lower() not in _BESIDE]
        if not found:
            raise DataError(f"{place}: there is no log in this folder")
        logs += found
        left_out += [f for f in files if f not in found]
    twice = next((log for i, log in enumerate(logs) if log in logs[:i]), None)
    if twice is not None:
        raise OptionError(f"{twice} is given twice", option="log")
    return logs, left_out


def run(logs: Sequence[Path], work: Callable[[Path], Analysis], *, jobs: int) -> Iterator[Outcome]:
    """What becomes of each log, in the order in which they end; `jobs` of them at a time.

    Parameters
    ----------
    logs : sequence of Path
    work : callable
        Analyses one log and writes what is to be written. It is sent to another process: a function of a module, or a
        `functools.partial` of one.
    jobs : int
    """
    context = multiprocessing.get_context("spawn")  # threads of this process would be missing in a forked one
    waiting = list(logs)
    running: dict[multiprocessing.connection.Connection, tuple[Path, Any]] = {}
    try:
        while waiting or running:
            while waiting and len(running) < jobs:
                log = waiting.pop(0)
                receive, send = context.Pipe(duplex=False)
                process = context.Process(target=_one, args=(log, work, send), daemon=True)
                process.start()
                send.close()
                running[receive] = (log, process)
            for ready in multiprocessing.connection.wait(list(running)):
                assert isinstance(ready, multiprocessing.connection.Connection)
                log, process = running.pop(ready)
                try:
                    outcome = ready.recv()
                except EOFError:
                    process.join()
                    outcome = Outcome(log=log, error=f"{log}: {_ended(process.exitcode)}")
                ready.close()
                process.join()
                yield outcome
    finally:
        for _, process in running.values():
            process.terminate()


def _one(log: Path, work: Callable[[Path], Analysis], send: multiprocessing.connection.Connection) -> None:
    # Ctrl-C reaches all processes of the terminal; the first one ends the others.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        analysis = work(log)
        outcome = Outcome(log=log, findings=analysis.findings, rows=tuple(_rows(analysis)))
    except OptionError as error:
        outcome = Outcome(log=log, error=str(error), usage=True)
    except (DataError, ImportError) as error:
        outcome = Outcome(log=log, error=str(error))
    except MemoryError:
        outcome = Outcome(log=log, error=f"{log}: not enough memory for this record")
    send.send(outcome)


def _ended(code: int | None) -> str:
    if code is not None and code < 0:
        name = signal.Signals(-code).name if -code in set(signal.Signals) else str(-code)
        why = " (the system does that when memory is short: fewer --jobs)" if name == "SIGKILL" else ""
        return f"its process was ended by {name}{why}"
    return f"its process ended with exit code {code}"


_TERMS = ("random_walk", "bias_instability", "rate_random_walk")


def _rows(analysis: Analysis) -> Iterator[tuple[str, ...]]:
    for channel, read in analysis.read_off.items():
        fit = analysis.fits.get(channel)
        texts = []
        for term in _TERMS:
            if fit is not None:
                value, _, unit = fit.texts(term)[0] if term in fit else ("", "", "")
            else:
                value, unit = read.texts(term)[0] if term in read else ("", "")
            texts.append(f"{value} {unit}" if value else "")
        yield channel, *texts, "read off" if fit is None else fit.verdict.replace("_", " ")


def summary(outcomes: Sequence[Outcome]) -> str:
    """The table of all logs, in the order in which they were given."""
    head = ("log", "channel", *(t.replace("_", " ") for t in _TERMS), "verdict")
    short = _short([outcome.log for outcome in outcomes])
    rows = [
        (name if first else "", *row)
        for name, outcome in zip(short, outcomes, strict=True)
        for first, row in ((i == 0, row) for i, row in enumerate(outcome.rows or [("", "", "", "", "failed")]))
    ]
    widths = [max(len(row[i]) for row in [head, *rows]) for i in range(len(head))]
    lines = [
        "  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip() for row in [head, *rows]
    ]
    good = sum(not outcome.error for outcome in outcomes)
    return "\n".join([*lines, "", f"{good} of {len(outcomes)} logs analysed"])


def names(logs: Sequence[Path]) -> list[str]:
    """A name for the result of each."""
    found = [name.replace(os.sep, "_") for name in _short(logs)]
    return [name if found.count(name) == 1 else f"{name}-{k}" for k, name in enumerate(found, 1)]


def _short(logs: Sequence[Path]) -> list[str]:
    """Names as short as they can be told apart."""
    if len({log.name for log in logs}) == len(logs):
        return [log.name for log in logs]
    base = os.path.commonpath([log.absolute().parent for log in logs])
    return [str(log.absolute().relative_to(base)) for log in logs]
