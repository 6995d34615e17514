"""Functions that workers run: they analyse logs and return rows for the store. A log that cannot be used has a row too."""

from __future__ import annotations

import contextlib
import functools
import gc
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sigmatau.frozen import frozen
from sigmatau.lab.fleet.logs import Log

if TYPE_CHECKING:
    from sigmatau import Analysis
    from sigmatau.analysis import FailedAnalysis
    from sigmatau.analysis.stretches import Division
    from sigmatau.errors import DataError, OptionError
    from sigmatau.lab.store.keeping import KeepCurves
    from sigmatau.lab.store.naming import Naming
    from sigmatau.lab.store.rows import Rows

_THREADS = "threads"  # option of `analyze` that is 1 in a worker, which has one core


@frozen
class FleetJob:
    """Options that all logs of a fleet share.

    Attributes
    ----------
    reading, settings : mapping
        Options of `sigmatau.read` and `sigmatau.analyze`.
    naming : Naming
        Names of the results in the store.
    keep_curves : {"failed", "all", "none"}
        Results that keep their curves in the store, see `sigmatau.lab.store.keeping`.
    """

    reading: Mapping[str, Any]
    settings: Mapping[str, Any]
    naming: Naming
    keep_curves: KeepCurves = "all"

    @property
    def options(self) -> dict[str, Any]:
        """Options that differ from the defaults, in the form of results. Raises `OptionError` for a wrong option."""
        from sigmatau.analysis import AnalysisOptions
        from sigmatau.io import ReadOptions
        from sigmatau.options import stated

        reading = ReadOptions(**self.reading)
        reading.checked()
        by_part = {"reading": stated(reading), "analysis": stated(AnalysisOptions(**self.settings))}
        return {part: options for part, options in by_part.items() if options}


@frozen
class FleetOutcome:
    """Outcome of a finished log."""

    log: Log
    code: int  # exit code for this log alone
    rows: Rows
    error: OptionError | DataError | None = None  # reason why there is no result


def analyse(logs: Sequence[Log], job: FleetJob) -> tuple[list[FleetOutcome], float]:
    """Analyse logs; return their outcomes in order, and the total time. [s]"""
    prepare_process()
    begun = time.perf_counter()
    outcomes = [_analysed(log, job) for log in logs]
    gc.collect()  # free the samples before the next task
    return outcomes, time.perf_counter() - begun


def divided(log: Log, job: FleetJob, memory: int) -> Division | None:
    """Divide a record that is too large for this memory; None if it is analysed as a whole.

    Raises
    ------
    DataError, OptionError
        For a log that is too large and cannot be divided.
    """
    from sigmatau.analysis import stretches

    prepare_process()
    if not stretches.too_large(log.place, job.reading, memory):
        return None
    return stretches.divide(log.place, job.reading, job.settings)


def combined(log: Log, division: Division, sums: Mapping[str, Any], job: FleetJob) -> FleetOutcome:
    """Build the outcome of a record that was summed in stretches."""
    from sigmatau.analysis import stretches
    from sigmatau.findings.finding import damaged

    def result() -> tuple[Analysis, int]:
        analysis = stretches.analyze_sums(division, sums, method=job.settings.get("method", "likelihood"))
        return analysis, damaged(analysis.findings)

    return _outcome(log, job, result)


def failed(log: Log, job: FleetJob, error: BaseException) -> FleetOutcome:
    """Build the outcome of a log without a result, because of an error."""
    from sigmatau.analysis import FailedAnalysis
    from sigmatau.errors import DataError, OptionError

    if isinstance(error, MemoryError):
        error = DataError("not enough memory for this record")
    elif not isinstance(error, OptionError | DataError):
        error = DataError(str(error) if isinstance(error, ImportError) else f"{type(error).__name__}: {error}")
    reason = error if error.source else error.about(log.place)
    failure = FailedAnalysis.of(reason, log.place, options=job.options)
    return replace(_outcome_of(log, job, failure, failure.exit_code), error=reason)


def _analysed(log: Log, job: FleetJob) -> FleetOutcome:
    def result() -> tuple[Analysis, int]:
        from sigmatau import analyze, read
        from sigmatau.errors import DataError, OptionError
        from sigmatau.findings.finding import exit_code

        with local_copy(log.place) as path:
            try:
                analysis = analyze(read(path, **job.reading), **{**job.settings, _THREADS: 1})
            except (DataError, OptionError) as error:
                if error.source == str(path):  # the path of the copy
                    error.source = log.place
                raise
            source = replace(analysis.source, checksum=analysis.source.sha256)  # computed here, while the copy exists
            return replace(analysis, source=source), exit_code(analysis.findings)

    return _outcome(log, job, result)


def _outcome(log: Log, job: FleetJob, result: Callable[[], tuple[Analysis, int]]) -> FleetOutcome:
    """Build the outcome from a function that returns a result and its exit code, or raises an error."""
    from sigmatau.analysis import parse_options

    try:
        analysis, code = result()
        source = replace(analysis.source, path=log.place, options=job.options.get("reading", {}))
        analysis = replace(analysis, source=source, options=parse_options(job.options.get("analysis", {})))
        return _outcome_of(log, job, analysis, code)
    except Exception as error:  # a defect of the program must not stop the other logs
        return failed(log, job, error)


def _outcome_of(log: Log, job: FleetJob, result: Analysis | FailedAnalysis, code: int) -> FleetOutcome:
    from sigmatau.lab.store.keeping import with_chosen_curves
    from sigmatau.lab.store.rows import make_rows

    entry = replace(job.naming.entry(result, Path(log.place)), file_version=log.version)
    return FleetOutcome(log=log, code=code, rows=with_chosen_curves(make_rows(entry), job.keep_curves))


@functools.cache
def prepare_process() -> None:
    """Set up a process that analyses many logs; further calls have no effect."""
    from sigmatau.process import keep_freed

    keep_freed()
    gc.freeze()


@contextlib.contextmanager
def local_copy(place: str) -> Iterator[str | Path]:
    """Provide a path for the reader: an object is copied to this host; a file or a Zarr store is read where it is."""
    if "://" not in place or place.rstrip("/").endswith(".zarr"):
        yield place
        return
    import fsspec

    from sigmatau.errors import DataError

    with tempfile.TemporaryDirectory(prefix="sigmatau-") as folder:
        system, path = fsspec.core.url_to_fs(place)
        copy = Path(folder) / Path(path).name
        try:
            system.get(path, str(copy))
        except OSError as error:
            raise DataError(f"cannot be copied: {error}").about(place) from None
        yield copy
