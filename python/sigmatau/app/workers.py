"""Worker processes. Each runs one call at a time and caches the record that it read last; to cancel a call, it is killed."""

from __future__ import annotations

import contextlib
import gc
import signal
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from sigmatau.app.answers import CallError
from sigmatau.process import end_with_parent, keep_freed, return_freed, uninterrupted

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

Progress = Callable[[str], None]
"""Called with the name of a stage when it begins."""

_ENDED = "the process that worked on this was killed, probably because memory ran out; choose a part of the record"

_TOO_LONG = "this took too long and was stopped; choose a smaller file, or a part of it"


class Worker:
    """A process that waits for calls.

    Parameters
    ----------
    preloaded : sequence of str
        Calls whose modules the process imports when it starts.

    Attributes
    ----------
    key : object
        Log or result of the last call; further calls about it are fastest here, because it is cached.
    used : float
        Time at which the last call ended.
    """

    def __init__(self, preloaded: Sequence[str] = ()) -> None:
        import multiprocessing

        context = multiprocessing.get_context("spawn")
        self._connection, remote = context.Pipe()
        self._process = context.Process(target=_work, args=(remote, preloaded), daemon=True)
        with uninterrupted():
            self._process.start()
        remote.close()
        self._has_ended = False
        self.key: object = None
        self.used: float = 0.0

    @property
    def alive(self) -> bool:
        """Whether the process can run a call."""
        return not self._has_ended and self._process.is_alive()

    def call(
        self, name: str, arguments: dict[str, Any], progress: Progress | None = None, *, patience: float | None = None
    ) -> Any:  # noqa: ANN401
        """Run a call of `sigmatau.app.calls` and return its value; raises `CallError`.

        The process is killed if it sends nothing for `patience` seconds.
        """
        try:
            self._connection.send((name, arguments))
            while True:
                if not self._connection.poll(patience):
                    self.end()
                    raise CallError({"message": _TOO_LONG, "hint": None, "code": "failed"})
                kind, value = self._connection.recv()
                if kind == "stage":
                    if progress is not None:
                        progress(value)
                elif kind == "done":
                    return value
                else:
                    raise CallError(value)
        except (EOFError, OSError):
            self.end()
            raise CallError({"message": _ENDED, "hint": None, "code": "failed"}) from None

    def end(self) -> None:
        """Kill the process."""
        self._has_ended = True
        self._process.kill()


class Workers:
    """A pool of up to `limit` workers, which are started when they are needed.

    Parameters
    ----------
    limit : int
    preloaded : sequence of str
        Calls whose modules a worker imports when it starts.
    """

    def __init__(self, limit: int, preloaded: Sequence[str] = ()) -> None:
        self._limit, self._preloaded = limit, tuple(preloaded)
        self._idle: list[Worker] = []
        self._busy: set[Worker] = set()
        self._free = threading.Condition()
        self._closed = False

    def warm(self) -> None:
        """Start a worker in advance, unless one is idle."""
        with self._free:
            if self._idle or self._closed or len(self._busy) >= self._limit:
                return
            self._idle.append(Worker(self._preloaded))

    @contextlib.contextmanager
    def take(
        self, key: object, took: Callable[[Worker], None] | None = None, *, sticky: bool = True
    ) -> Iterator[Worker]:
        """Take a worker for a call about `key`: the one that has read it, otherwise the one that is idle for longest.

        If `sticky`, wait for the worker that has read `key`, even if it is busy. `took` is called with the worker.
        """
        with self._returned_at_end(self._wait_for_worker(key, sticky=sticky)) as worker:
            if took is not None:
                took(worker)
            yield worker

    @contextlib.contextmanager
    def take_reader(self, key: object) -> Iterator[Worker | None]:
        """Take the worker that has read `key` if it is idle; otherwise None."""
        with self._free:
            worker = next((each for each in self._idle if each.key == key and each.alive), None)
            if worker is not None:
                self._idle.remove(worker)
                self._busy.add(worker)
        if worker is None:
            yield None
            return
        with self._returned_at_end(worker):
            yield worker

    @contextlib.contextmanager
    def _returned_at_end(self, worker: Worker) -> Iterator[Worker]:
        """Return a busy worker to the pool at the end."""
        try:
            yield worker
        finally:
            with self._free:
                self._busy.discard(worker)
                if worker.alive and not self._closed:
                    worker.used = time.monotonic()
                    self._idle.append(worker)
                else:
                    worker.end()
                self._free.notify_all()

    def _wait_for_worker(self, key: object, *, sticky: bool) -> Worker:
        with self._free:
            while True:
                worker = self._idle_or_new_worker(key, sticky=sticky)
                if worker is not None:
                    worker.key = key
                    self._busy.add(worker)
                    return worker
                self._free.wait()

    def _idle_or_new_worker(self, key: object, *, sticky: bool) -> Worker | None:
        self._idle = [worker for worker in self._idle if worker.alive]
        worker = next((worker for worker in self._idle if worker.key == key), None)
        if worker is None and not (sticky and any(busy.key == key for busy in self._busy)):
            if self._idle:
                worker = min(self._idle, key=lambda each: each.used)
            elif len(self._busy) < self._limit:
                return Worker(self._preloaded)
        if worker is not None:
            self._idle.remove(worker)
        return worker

    def close(self) -> None:
        """End all workers."""
        with self._free:
            self._closed = True
            for worker in (*self._idle, *self._busy):
                worker.end()
            self._idle = []


def _work(calls: Connection, preloaded: Sequence[str]) -> None:
    """Run calls until the connection is closed."""
    signal.signal(
        signal.SIGINT, signal.SIG_IGN
    )  # Ctrl-C reaches all processes of the terminal; the server ends this one
    keep_freed()  # before the first thread, so that all threads share one heap
    end_with_parent()
    from sigmatau.app.calls import load, run_call

    for first in preloaded:
        load(first)
    gc.freeze()
    while True:
        try:
            name, arguments = calls.recv()
        except (EOFError, OSError):
            return
        outcome = run_call(name, arguments, lambda stage: calls.send(("stage", stage)))
        try:
            calls.send(outcome)
        except OSError:
            return
        del outcome
        return_freed()
