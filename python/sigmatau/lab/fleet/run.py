"""`run_fleet`: sends tasks to workers, collects the outcomes, and repeats tasks whose workers ended."""

from __future__ import annotations

import contextlib
import copy
import logging
import math
import pkgutil
import queue
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Literal

from sigmatau import __version__
from sigmatau.analysis.stretches import Division, merge_sums, sum_stretch
from sigmatau.errors import DataError
from sigmatau.frozen import frozen
from sigmatau.lab.fleet.logs import Log
from sigmatau.lab.fleet.tasks import FleetJob, FleetOutcome, analyse, combined, divided, failed
from sigmatau.process import uninterrupted

if TYPE_CHECKING:
    from distributed import Client, Future

_TASK_SECONDS = 2.0  # duration of a task with several logs; its overhead is about 5 ms [s]
_BATCH_LOGS = 64  # largest number of logs of a task
_RECOUNT = 3.0  # interval between counts of the workers [s]
_TRIES = 3  # largest number of attempts for a stretch
_ANSWER = 20.0  # time within which a scheduler answers [s]
_AHEAD = 2  # number of submitted tasks per worker thread
_PATIENCE = 0.5  # interval between checks of the clock and the scheduler [s]
_LARGE = 1 << 26  # size of a log above which a worker tests whether it must be divided [bytes]
_UNLIMITED = 4 << 30  # assumed memory of a worker that states no limit [bytes]

_Kind = Literal["batch", "single", "alone", "divide", "stretch"]


@contextlib.contextmanager
def cluster(
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    memory: float | None = None,
    dashboard: int | None = None,
) -> Iterator[Client]:
    """Open a client of a running scheduler, or of processes of this host that stop with the client.

    Parameters
    ----------
    workers : int, optional
        Number of processes of this host. Default: one per core.
    scheduler : str, optional
        Address, ``tcp://host:8786``.
    memory : float, optional
        Memory of a process of this host. [bytes] Default: its share of the memory of the host.
    dashboard : int, optional
        Port of the loopback for the dashboard of Dask about the processes of this host. Default: no dashboard.

    Raises
    ------
    DataError
        If the scheduler does not answer, or the port of the dashboard is in use.
    ImportError
        Without dask.distributed, or without bokeh for a dashboard.
    """
    try:
        import dask
        from distributed import Client, LocalCluster
    except ImportError:
        raise ImportError("a fleet needs dask.distributed: pip install 'sigmatau[cluster]'") from None
    settings = {
        # this module restarts a task whose worker ended, with fewer logs
        "distributed.scheduler.allowed-failures": 0,
        # Monitoring of the workers took 5 % of their time.
        "distributed.worker.profile.enabled": False,
        "distributed.admin.tick.interval": "500ms",
        "distributed.admin.system-monitor.interval": "10s",
        "distributed.scheduler.worker-saturation": 1.0,  # a log that crashes its worker then affects no others
    }
    # Messages of the workers are converted to one-line errors or failed logs.
    for name in ("distributed", "distributed.client", "asyncio"):
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    with dask.config.set(settings):
        if scheduler is None:
            # Without an address Dask would serve figures about itself on all interfaces.
            address = "127.0.0.1:0" if dashboard is None else _dashboard_address(dashboard)
            with contextlib.ExitStack() as stack:
                with uninterrupted():
                    local = stack.enter_context(LocalCluster(
                        n_workers=workers, threads_per_worker=1, dashboard_address=address,
                        scheduler_kwargs={"dashboard": dashboard is not None},
                        memory_limit="auto" if memory is None else int(memory), silence_logs=60,
                        preload="sigmatau.lab.fleet.worker", preload_nanny=[],
                    ))  # fmt: skip
                yield stack.enter_context(Client(local))
            return
        try:
            _require_scheduler(scheduler)
            client = Client(scheduler, timeout=_ANSWER)
        except TypeError:  # from the settings of TLS
            raise DataError(
                f"{scheduler}: this process has no certificate; set distributed.comm.tls in ~/.config/dask/tls.yaml"
            ) from None
        except (OSError, ValueError, RuntimeError) as error:
            why = (str(error) or f"nothing was received in {_ANSWER:g} s").splitlines()[0]
            raise DataError(f"{scheduler}: no scheduler answers: {why}") from None
        try:
            yield client
        finally:
            client.close(timeout=2)


def _dashboard_address(port: int) -> str:
    """Address of a dashboard on the loopback. Dask itself would take another port, or show no dashboard without bokeh."""
    import socket
    from importlib.util import find_spec

    if find_spec("bokeh") is None:
        raise ImportError("the dashboard needs bokeh: pip install 'sigmatau[cluster]'")
    try:
        with socket.socket() as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            probe.bind(("127.0.0.1", port))
    except OSError as error:
        raise DataError(f"port {port} of the dashboard: {error.strerror or error}; choose another port") from None
    return f"127.0.0.1:{port}"


def _require_scheduler(scheduler: str) -> None:
    """Raise `OSError` for an address where something other than a scheduler listens, because a `Client` would wait for
    it.
    """
    import asyncio
    from concurrent.futures import ThreadPoolExecutor

    from distributed import Security
    from distributed.comm import connect

    async def shake_hands() -> None:
        arguments = Security().get_connection_args("client")
        comm = await asyncio.wait_for(connect(scheduler, timeout=_ANSWER, **arguments), _ANSWER + 1)
        await comm.close()

    with ThreadPoolExecutor(1) as thread:  # this thread may already run a loop, as in a notebook
        thread.submit(lambda: asyncio.run(shake_hands())).result()


def run_fleet(
    client: Client,
    logs: Sequence[Log],
    job: FleetJob,
    *,
    done: Callable[[Sequence[FleetOutcome]], None],
    tell: Callable[[str], None] = lambda _: None,
) -> None:
    """Analyse logs.

    `done` is called with the outcomes of each task as soon as they are available, in any order, and about twice a second
    with an empty list. `tell` is called with remarks for the user, such as that there are no workers.

    If the worker of a task with several logs ends unexpectedly, each of its logs becomes a task. If the worker of such a
    task ends too, its log is analysed while no other task runs; if the worker ends again, the log has failed. A stretch is
    tried three times. A task whose result is lost with its worker is started again.

    Raises
    ------
    DataError
        If the scheduler is lost, or a worker lacks sigmatau or has another version. Earlier outcomes were passed to `done`.
    """
    _Run(client, job, done, tell).all(logs)


@frozen(kw_only=False)
class _Task:
    kind: _Kind
    logs: tuple[Log, ...]
    part: int = 0  # number of the stretch in a record
    tries: int = 1


@dataclass(slots=True)
class _Divided:
    """A record that is summed in stretches."""

    division: Division
    sums: dict[str, Any] | None = None  # sums of the first `merged` stretches
    merged: int = 0
    waiting: dict[int, dict[str, Any]] = field(default_factory=dict)  # sums of later stretches


class _Run:
    """The tasks of a fleet, waiting or running."""

    def __init__(
        self, client: Client, job: FleetJob, done: Callable[[Sequence[FleetOutcome]], None], tell: Callable[[str], None]
    ) -> None:
        self._client, self._job, self._done, self._tell = client, job, done, tell
        self._checked: set[str] = set()  # workers whose version was checked
        self._waits = False  # whether the run waits for workers
        self._logs: deque[Log] = deque()
        self._waiting: deque[_Task] = deque()
        self._alone: deque[_Task] = deque()
        self._running: dict[str, tuple[_Task, Future]] = {}
        self._ready: queue.SimpleQueue[str] = queue.SimpleQueue()
        self._records: dict[str, _Divided] = {}
        self._threads, self._counted = 1, -math.inf  # threads of the workers, and when they were counted
        self._seconds, self._finished = 0.0, 0  # total time of the finished logs, and their number

    def all(self, logs: Sequence[Log]) -> None:
        memory = _memory(self._client)
        large = {log.place for log in logs if (log.size or 0) > min(_LARGE, memory // 20)}
        self._memory = memory
        self._waiting += [_Task("divide", (log,)) for log in logs if log.place in large]
        self._logs += [log for log in logs if log.place not in large]
        try:
            while self._started():
                try:
                    key = self._ready.get(timeout=_PATIENCE)
                except queue.Empty:
                    if self._client.status not in ("running", "connecting"):
                        raise _lost() from None
                    self._done(())
                    continue
                if key in self._running:
                    self._finish(*self._running.pop(key))
        finally:
            # Tasks cannot be cancelled without the scheduler.
            with contextlib.suppress(Exception):
                self._client.cancel([future for _, future in self._running.values()], force=True)

    def _started(self) -> bool:
        """Call `_start`; raises `DataError` if the scheduler does not answer."""
        try:
            return self._start()
        except OSError:
            raise _lost() from None

    def _start(self) -> bool:
        """Start as many tasks as the workers need; return whether any is running."""
        if time.monotonic() > self._counted + _RECOUNT:  # the number of workers may change
            threads: Mapping[str, int] = self._client.nthreads()
            self._threads = max(sum(threads.values()), 1)
            self._counted = time.monotonic()
            if self._client.cluster is None:
                self._check(threads)
        while len(self._running) < _AHEAD * self._threads and (task := self._next()) is not None:
            future = self._submit(task)
            self._running[future.key] = task, future
            future.add_done_callback(lambda done_future: self._ready.put(done_future.key))
        if not self._running and self._alone:
            task = self._alone.popleft()
            future = self._submit(task)
            self._running[future.key] = task, future
            future.add_done_callback(lambda done_future: self._ready.put(done_future.key))
        return bool(self._running)

    def _check(self, workers: Iterable[str]) -> None:
        """Raise `DataError` for a worker with another version of sigmatau, which would crash with each log."""
        addresses = {*workers}
        if not addresses and not self._waits:
            self._tell("the scheduler has no workers; waiting for them")
        self._waits = not addresses
        if new := addresses - self._checked:
            # A function of the standard library is sent, so that it runs on every worker.
            asked = self._client.run(
                pkgutil.resolve_name, "sigmatau._version:__version__", workers=[*new], on_error="return"
            )
            for worker, version in asked.items():
                if isinstance(version, ImportError | AttributeError):
                    raise DataError(
                        f"worker {worker} has no sigmatau: {version}; install sigmatau[cluster] {__version__} there"
                    )
                if isinstance(version, str) and version != __version__:
                    raise DataError(
                        f"worker {worker} has sigmatau {version}, and this process {__version__}; install the same version"
                    )
            self._checked = addresses

    def _next(self) -> _Task | None:
        if any(task.kind == "alone" for task, _ in self._running.values()):
            return None
        if self._waiting:
            return self._waiting.popleft()
        if not self._logs:
            return None
        # The first tasks have one log each; their mean time then determines the number of logs per task.
        mean = self._seconds / self._finished if self._finished else _TASK_SECONDS
        logs_of_thread = -(-len(self._logs) // self._threads)
        count = min(max(round(_TASK_SECONDS / max(mean, 1e-3)), 1), _BATCH_LOGS, max(logs_of_thread, 1))
        return _Task("batch", tuple(self._logs.popleft() for _ in range(min(count, len(self._logs)))))

    def _submit(self, task: _Task) -> Future:
        log = task.logs[0]
        if task.kind == "divide":
            return self._client.submit(divided, log, self._job, self._memory, pure=False)
        if task.kind == "stretch":
            bounds = self._records[log.place].division.stretches[task.part]
            return self._client.submit(sum_stretch, log.place, dict(self._job.reading), *bounds, pure=False)
        return self._client.submit(analyse, task.logs, self._job, pure=False)

    def _finish(self, task: _Task, future: Future) -> None:
        from distributed import KilledWorker
        from distributed.client import FutureCancelledError

        error, outcome, has_outcome = None, None, True
        try:
            if future.status == "error":
                error = future.exception()
            elif future.status == "finished":
                outcome = future.result()
            else:  # lost or cancelled
                has_outcome = False
        except (OSError, FutureCancelledError):  # an error of the connection, not of the task
            has_outcome = False
        finally:
            future.release()
        if not has_outcome:
            self._retry(task)
        elif isinstance(error, KilledWorker):
            self._isolate(task)
        elif error is not None:
            self._fail(task, error)
        else:
            self._accept(task, outcome)

    def _retry(self, task: _Task) -> None:
        """Handle a task without an outcome: its worker ended before the result was fetched, or the scheduler is lost."""
        if self._client.status != "running":
            raise _lost()
        if task.tries >= _TRIES:
            self._isolate(task)
        else:
            tasks = self._alone if task.kind == "alone" else self._waiting
            tasks.append(replace(task, tries=task.tries + 1))

    def _accept(self, task: _Task, outcome: Any) -> None:  # noqa: ANN401  by kind of task
        log = task.logs[0]
        if task.kind == "divide":
            if outcome is None:
                self._waiting.append(_Task("single", task.logs))
                return
            self._records[log.place] = _Divided(division=outcome)
            self._waiting += [_Task("stretch", task.logs, part) for part in range(len(outcome.stretches))]
        elif task.kind == "stretch":
            record = self._records.get(log.place)
            if record is None:  # another stretch of this record failed
                return
            record.waiting[task.part] = outcome
            while (part := record.waiting.pop(record.merged, None)) is not None:
                if record.sums is None:
                    record.sums = part
                else:
                    merge_sums(record.sums, part)
                record.merged += 1
            if record.merged == len(record.division.stretches):
                assert record.sums is not None
                del self._records[log.place]
                self._done([combined(log, record.division, record.sums, self._job)])
            else:
                self._done(())
        else:
            outcomes, seconds = outcome
            self._seconds += seconds
            self._finished += len(outcomes)
            self._done(outcomes)

    def _isolate(self, task: _Task) -> None:
        if task.kind == "batch" and len(task.logs) > 1:
            self._waiting += [_Task("single", (log,)) for log in task.logs]
        elif task.kind in ("batch", "single"):
            self._alone.append(_Task("alone", task.logs))
        elif task.kind in ("divide", "stretch") and task.tries < _TRIES:
            self._waiting.append(replace(task, tries=task.tries + 1))
        else:
            why = "its worker was killed at each attempt, probably because memory ran out"
            self._fail(task, DataError(why))

    def _fail(self, task: _Task, error: BaseException) -> None:
        for log in task.logs:
            if task.kind == "stretch" and self._records.pop(log.place, None) is None:
                continue  # another stretch of this record failed before
            self._done([failed(log, self._job, copy.copy(error))])


def _memory(client: Client) -> int:
    """Memory of a thread of the smallest worker. [bytes]"""
    workers: Mapping[str, Mapping[str, Any]] = client.scheduler_info(n_workers=-1)["workers"]
    limits = [worker["memory_limit"] // worker["nthreads"] for worker in workers.values() if worker.get("memory_limit")]
    return min(limits, default=_UNLIMITED)


def _lost() -> DataError:
    return DataError("the scheduler was lost")
