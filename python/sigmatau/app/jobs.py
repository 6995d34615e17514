"""Running analyses, and results in memory. Identifiers are random, so that a page cannot guess those of another page."""

from __future__ import annotations

import secrets
import threading
import time
from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from sigmatau.app.answers import CallError, missing
from sigmatau.app.workers import Worker, Workers

JobState = Literal["waiting", "running", "done", "failed", "cancelled"]

_MOST_RESULTS = 64  # largest number of results in memory
_MOST_BYTES = 1 << 28  # largest size of all results together [bytes]
_MOST_JOBS = 256  # largest number of analyses, running or ended, that can be asked for
_MOST_WAITING = 32  # largest number of analyses that have not ended


@dataclass(kw_only=True)
class Result:
    """The result of an analysis, in memory.

    Attributes
    ----------
    analysis : bytes
        The `Analysis`, for the calls of workers.
    result, shown : str
        JSON of the result, and of the text that the page shows with it.
    log : LogFile or None
        The log; None for a result that was read from a file.
    name : str
        Name of the log or of the file, as the user knows it.
    table : dict
        Options as typed in the page.
    content : bytes or None
        Content of the report; None until the charts are made.
    charts : str
        The charts as JSON; empty until they are made.
    lock : Lock
        Held by the thread that makes the charts.
    """

    analysis: bytes
    result: str
    shown: str
    name: str
    log: Any = None
    table: dict[str, Any] = field(default_factory=dict)
    content: bytes | None = None
    charts: str = ""
    lock: threading.Lock = field(default_factory=threading.Lock)

    @property
    def size(self) -> int:
        """Approximate size. [bytes]"""
        return len(self.analysis) + len(self.result) + len(self.shown) + len(self.content or b"") + len(self.charts)


class Results:
    """Results by identifier; above the limits, the least recently used ones are removed."""

    def __init__(self) -> None:
        self._results: OrderedDict[str, Result] = OrderedDict()
        self._lock = threading.Lock()

    def add(self, result: Result) -> str:
        """Add a result and return its identifier."""
        id_ = secrets.token_urlsafe(12)
        with self._lock:
            self._results[id_] = result
            while len(self._results) > 1 and (
                len(self._results) > _MOST_RESULTS or sum(each.size for each in self._results.values()) > _MOST_BYTES
            ):
                self._results.popitem(last=False)
        return id_

    def find(self, id_: object) -> Result:
        """The result of an identifier; raises `CallError` for an unknown one."""
        with self._lock:
            if not isinstance(id_, str) or id_ not in self._results:
                raise missing("there is no such result, or it was removed to make room; analyse the log again")
            self._results.move_to_end(id_)
            return self._results[id_]


class Job:
    """An analysis that runs in a worker.

    Parameters
    ----------
    log : LogFile
    table : mapping
        Options.
    """

    def __init__(self, log: Any, table: Mapping[str, Any]) -> None:  # noqa: ANN401  a LogFile, which is imported in the workers
        self.id: str = secrets.token_urlsafe(12)
        self.log: Any = log
        self.table: dict[str, Any] = dict(table)
        self.state: JobState = "waiting"
        self.error: dict[str, Any] | None = None
        self.result: str | None = None
        self._stages: list[tuple[str, float]] = []
        self._created, self._ended = time.monotonic(), 0.0
        self._worker: Worker | None = None
        self._lock = threading.Lock()

    @property
    def over(self) -> bool:
        """Whether the analysis has ended."""
        return self.state not in ("waiting", "running")

    def run(self, workers: Workers, results: Results) -> None:
        """Run the analysis; `state` shows how it ended."""
        try:
            with workers.take(self.log.path, self._begin, sticky=False) as worker:
                parts = worker.call("analyze", {"log": self.log, "table": self.table}, self._stage)
            result = Result(**parts, name=self.log.name, log=self.log, table=self.table)
            self._end("done", result=results.add(result))
        except CallError as error:
            self._end("failed", error=error.content)
        finally:
            self._worker = None
            if not self.over:
                self._end(
                    "failed", error={"message": "the analysis ended unexpectedly", "hint": None, "code": "failed"}
                )

    def cancel(self) -> None:
        """Cancel the analysis and kill its process; no effect after its end."""
        with self._lock:
            if self.over:
                return
            self.state, self._ended = "cancelled", time.monotonic()
            if self._worker is not None:
                self._worker.end()

    def content(self) -> dict[str, Any]:
        """Content of the job for the page."""
        now = self._ended if self.over else time.monotonic()
        ends = [*(began for _, began in self._stages[1:]), now][: len(self._stages)]
        stages = [
            {"name": name, "done": self.state == "done" or k + 1 < len(self._stages), "seconds": round(end - began, 3)}
            for k, ((name, began), end) in enumerate(zip(self._stages, ends, strict=True))
        ]
        return {
            "job": self.id,
            "state": self.state,
            "stages": stages,
            "elapsed_s": round(now - self._created, 3),
            "error": self.error,
            "result": self.result,
        }

    def _begin(self, worker: Worker) -> None:
        with self._lock:
            if self.state == "cancelled":
                raise CallError({"message": "cancelled", "hint": None, "code": "conflict"})
            self._worker, self.state = worker, "running"

    def _stage(self, name: str) -> None:
        self._stages.append((name, time.monotonic()))

    def _end(self, state: JobState, *, result: str | None = None, error: dict[str, Any] | None = None) -> None:
        with self._lock:
            if self.state == "cancelled":
                return
            self.result, self.error = result, error
            self._ended, self.state = time.monotonic(), state


class Jobs:
    """Analyses by identifier.

    Parameters
    ----------
    workers : Workers
    results : Results
    """

    def __init__(self, workers: Workers, results: Results) -> None:
        self._workers, self._results = workers, results
        self._jobs: OrderedDict[str, Job] = OrderedDict()
        self._lock = threading.Lock()

    def start(self, log: Any, table: Mapping[str, Any]) -> Job:  # noqa: ANN401  a LogFile
        """Start an analysis; raises `CallError` if too many have not ended."""
        job = Job(log, table)
        with self._lock:
            if sum(not each.over for each in self._jobs.values()) >= _MOST_WAITING:
                message = f"{_MOST_WAITING} analyses wait already; cancel some"
                raise CallError({"message": message, "hint": None, "code": "conflict"})
            self._jobs[job.id] = job
            for id_ in [id_ for id_, each in self._jobs.items() if each.over][: max(len(self._jobs) - _MOST_JOBS, 0)]:
                del self._jobs[id_]
        threading.Thread(target=job.run, args=(self._workers, self._results), daemon=True).start()
        return job

    def find(self, id_: str) -> Job:
        """The analysis of an identifier; raises `CallError` for an unknown one."""
        with self._lock:
            if id_ not in self._jobs:
                raise missing("there is no such analysis")
            return self._jobs[id_]
