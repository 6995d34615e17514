"""What a worker does: logs in, results out. A log that cannot be used is a result that says why."""

from __future__ import annotations

import contextlib
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from sigmatau.fleet.logs import Log

_STARTED_BY = "threads"  # the setting of `analyze` that a worker sets itself


def analyse(logs: Sequence[Log], reading: Mapping[str, Any], settings: Mapping[str, Any]) -> list[dict[str, Any]]:
    """The results of logs, in their order, as plain values.

    Parameters
    ----------
    logs : sequence of Log
    reading : mapping
        Options of `sigmatau.read`.
    settings : mapping
        Options of `sigmatau.analyze`.
    """
    return [_result(log, reading, settings) for log in logs]


def _result(log: Log, reading: Mapping[str, Any], settings: Mapping[str, Any]) -> dict[str, Any]:
    from sigmatau.analysed import failed_result
    from sigmatau.analysis import analyze
    from sigmatau.errors import DataError, OptionError
    from sigmatau.io.read import read

    try:
        with _near(log.place) as path:
            result = analyze(read(path, **reading), **{**settings, _STARTED_BY: 1}).to_dict()
            result["source"]["path"] = log.place
            return result
    except OptionError as error:
        return failed_result(log.place, error.for_command_line(), exit_code=2)
    except (DataError, ImportError) as error:
        return failed_result(log.place, str(error), exit_code=1)
    except MemoryError:
        return failed_result(log.place, f"{log.place}: not enough memory for this record", exit_code=1)
    except Exception as error:
        return failed_result(log.place, f"{log.place}: {type(error).__name__}: {error}", exit_code=1)


@contextlib.contextmanager
def _near(place: str) -> Iterator[Path]:
    """A file for the reader: an object is copied to this host."""
    if "://" not in place:
        yield Path(place)
        return
    import fsspec

    from sigmatau.errors import DataError

    with tempfile.TemporaryDirectory(prefix="sigmatau-") as folder:
        system, path = fsspec.core.url_to_fs(place)
        near = Path(folder) / Path(path).name
        try:
            system.get(path, str(near), recursive=near.suffix == ".zarr")
        except OSError as error:
            raise DataError(f"{place}: {error}") from None
        yield near
