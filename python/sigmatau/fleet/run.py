"""`run_fleet`: tasks to workers, results into the store, whatever fails in between."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from sigmatau.errors import DataError
from sigmatau.fleet.logs import Log
from sigmatau.fleet.tasks import analyse
from sigmatau.frozen import frozen

if TYPE_CHECKING:
    from distributed import Client

_BATCH_BYTES = 32 << 20  # logs of one task, so that a task takes a second or more and its overhead of 3 ms is small
_BATCH_LOGS = 16
_AHEAD = 3  # tasks a thread of the workers has waiting
_TRIES = 3  # of a task whose worker ends


@frozen
class Done:
    """A log that is finished."""

    log: Log
    result: dict[str, Any]


@contextlib.contextmanager
def cluster(*, workers: int | None = None, scheduler: str | None = None, memory: str = "auto") -> Iterator[Client]:
    """A client of a running scheduler, or of processes of this host that end with it.

    Raises
    ------
    DataError
        If the scheduler does not answer.
    ImportError
        Without dask.distributed.
    """
    try:
        import dask
        from distributed import Client, LocalCluster
    except ImportError:
        raise ImportError("a fleet needs dask.distributed: pip install 'sigmatau[cluster]'") from None
    quiet = {"distributed.scheduler.allowed-failures": _TRIES - 1, "distributed.logging.distributed": "error"}
    with dask.config.set(quiet):
        if scheduler is None:
            with (
                LocalCluster(
                    n_workers=workers, threads_per_worker=1, dashboard_address=None, memory_limit=memory,
                    silence_logs="CRITICAL",
                ) as local,
                Client(local) as client,
            ):  # fmt: skip
                yield client
            return
        try:
            client = Client(scheduler, timeout=20)
        except (OSError, ValueError) as error:
            raise DataError(f"{scheduler}: no scheduler answers: {str(error).splitlines()[0]}") from None
        try:
            yield client
        finally:
            client.close()


def run_fleet(
    client: Client,
    logs: Sequence[Log],
    *,
    reading: Mapping[str, Any],
    settings: Mapping[str, Any],
    done: Callable[[Sequence[Done]], None],
) -> None:
    """Analyse logs; `done` gets the results of each task as soon as they are there, in any order.

    A task whose worker ends is tried again. If the workers of a task of several logs keep ending, each of its logs
    becomes a task; a log that ends its worker each time is a failed result.

    Raises
    ------
    DataError
        If the scheduler is lost. The results so far have been passed on.
    """
    from distributed import KilledWorker, as_completed

    waiting = list(reversed(_batches(logs)))
    running: dict[str, tuple[Log, ...]] = {}
    threads = max(sum(client.nthreads().values()), 1)
    order = as_completed()

    def start() -> None:
        while waiting and len(running) < _AHEAD * max(threads, 1):
            batch = waiting.pop()
            future = client.submit(analyse, batch, dict(reading), dict(settings), pure=False)
            running[future.key] = batch
            order.add(future)

    start()
    for future in order:
        batch = running.pop(future.key)
        error = future.exception() if future.status == "error" else None
        if future.status in ("cancelled", "lost"):
            raise DataError("the scheduler was lost; run the same command again to go on")
        if error is None:
            done([Done(log=log, result=result) for log, result in zip(batch, future.result(), strict=True)])
        elif isinstance(error, KilledWorker) and len(batch) > 1:
            waiting += [(log,) for log in reversed(batch)]
        else:
            done([Done(log=log, result=_failed(log, error)) for log in batch])
        future.release()
        start()


def _failed(log: Log, error: BaseException) -> dict[str, Any]:
    from distributed import KilledWorker

    from sigmatau.analysed import failed_result

    if isinstance(error, KilledWorker):
        why = f"its worker ended {_TRIES} times, which happens when memory is short"
    else:
        why = f"{type(error).__name__}: {error}"
    return failed_result(log.place, f"{log.place}: {why}", exit_code=1)


def _batches(logs: Sequence[Log]) -> list[tuple[Log, ...]]:
    """Tasks of one log, or of several small ones."""
    found: list[tuple[Log, ...]] = []
    batch: list[Log] = []
    held = 0
    for log in logs:
        size = _BATCH_BYTES if log.size is None else log.size
        if batch and (held + size > _BATCH_BYTES or len(batch) == _BATCH_LOGS):
            found.append(tuple(batch))
            batch, held = [], 0
        batch.append(log)
        held += size
    return [*found, tuple(batch)] if batch else found
