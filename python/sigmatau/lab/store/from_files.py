"""Add JSON files of results to a store: several processes read and pack them, and this process writes."""

from __future__ import annotations

import gc
import multiprocessing
import signal
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from sigmatau.analysis import BriefResultForm, result_of_dict
from sigmatau.errors import DataError
from sigmatau.frozen import frozen
from sigmatau.hints import Hint, command, worded
from sigmatau.lab.store.ingest import BATCH, Added, add_rows
from sigmatau.lab.store.keeping import KeepCurves, with_chosen_curves
from sigmatau.lab.store.naming import Naming, UnknownUnitError
from sigmatau.lab.store.packing import loads
from sigmatau.lab.store.rows import Rows, make_rows
from sigmatau.process import end_with_parent, uninterrupted

if TYPE_CHECKING:
    from sqlalchemy import Engine

_FILES_OF_ONE_PROCESS = 400  # number of files that this process can read while another process would start
_AHEAD = 3  # number of batches per process that are read ahead of writing


@frozen
class Problem:
    """A file that was not added.

    Attributes
    ----------
    file : Path
    reason : str
        Reason why it was not added.
    unit_unknown : bool
        Whether the reason is an unknown unit.
    """

    file: Path
    reason: str
    unit_unknown: bool = False


@frozen
class FilesAdded:
    """Outcome of `add_files`.

    Attributes
    ----------
    added : Added
        Results that were added.
    problems : tuple of Problem
        Files that were not added.
    """

    added: Added = Added()
    problems: tuple[Problem, ...] = ()


def add_files(
    engine: Engine,
    files: Sequence[Path],
    naming: Naming,
    *,
    jobs: int = 1,
    keep_curves: KeepCurves = "all",
    done: Callable[[int], None] = lambda _: None,
) -> FilesAdded:
    """Add the results of files. A file that is not a result is reported, and the others are added.

    Parameters
    ----------
    engine : sqlalchemy.Engine
    files : sequence of Path
    naming : Naming
    jobs : int
        Processes that read files. This process writes.
    keep_curves : {"failed", "all", "none"}
        Results that keep their curves, see `sigmatau.lab.store.keeping`.
    done : callable
        Called with the number of files so far.
    """
    batches = [files[start : start + BATCH] for start in range(0, len(files), BATCH)]
    total, problems, count = Added(), [], 0
    read = partial(_read, naming=naming, keep_curves=keep_curves)
    results = _read_all(batches, read, jobs if len(files) > _FILES_OF_ONE_PROCESS else 1)
    with _without_garbage_collection():
        for batch, (rows, wrong) in zip(batches, results, strict=True):
            problems += [replace(problem, reason=worded(problem.reason)) for problem in wrong]
            if rows:
                total += add_rows(engine, rows)
            count += len(batch)
            done(count)
    return FilesAdded(added=total, problems=tuple(problems))


_Read = tuple[list[Rows], list[Problem]]


def _read_all(batches: Sequence[Sequence[Path]], read: Callable[[Sequence[Path]], _Read], jobs: int) -> Iterator[_Read]:
    """Yield the batches in order, and read some ahead."""
    if jobs < 2:
        yield from map(read, batches)
        return
    # Spawned, because forked processes would share the connections of the store.
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(min(jobs, len(batches)), mp_context=context, initializer=_prepare_process) as pool:
        waiting: deque[Future[_Read]] = deque()
        try:
            for batch in batches:
                with uninterrupted():  # the pool may start processes
                    waiting.append(pool.submit(read, batch))
                if len(waiting) > _AHEAD * jobs:
                    yield waiting.popleft().result()
            while waiting:
                yield waiting.popleft().result()
        except BrokenProcessPool:
            raise DataError(
                "a process that read files was killed, probably because memory ran out. Added results are stored; add the"
                f" others with {Hint('jobs', value=1)}"
            ) from None
        finally:
            pool.shutdown(wait=False, cancel_futures=True)


def _prepare_process() -> None:
    """Ignore Ctrl-C, which reaches all processes of the terminal: the first process stops this one. Disable garbage
    collection, because JSON has no cycles.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    end_with_parent()
    gc.disable()


@contextmanager
def _without_garbage_collection() -> Iterator[None]:
    """Disable garbage collection, which takes a tenth of the time: rows have no cycles."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


def _read(files: Sequence[Path], naming: Naming, keep_curves: KeepCurves) -> _Read:
    rows, problems = [], []
    for file in files:
        try:
            rows.append(with_chosen_curves(_read_file(file, naming), keep_curves))
        except DataError as error:
            unknown = isinstance(error, UnknownUnitError)
            problems.append(Problem(file=file, reason=error.text, unit_unknown=unknown))
    return rows, problems


def _read_file(file: Path, naming: Naming) -> Rows:
    try:
        data = file.read_bytes()
    except OSError as error:
        raise DataError(error.strerror or str(error)) from None
    data = data.removeprefix(b"\xef\xbb\xbf")
    try:
        content = loads(data)
    except (ValueError, RecursionError) as error:
        what = (
            f"not JSON, which {command('analyze', Hint('json'))} writes"
            if data.lstrip()[:1] != b"{"
            else f"not JSON: {error}"
        )
        raise DataError(what if data.strip() else "is empty") from None
    return make_rows(naming.entry(result_of_dict(content, as_form=BriefResultForm), file, content=content))
