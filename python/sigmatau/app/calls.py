"""Calls that a worker process runs, by name; it returns their errors as plain values, and caches the last record."""

from __future__ import annotations

import importlib
import json
import math
from collections.abc import Callable, Mapping
from contextvars import copy_context
from typing import Any, cast

from sigmatau.app.faces import as_controls, hints_content
from sigmatau.app.log import LogFile
from sigmatau.errors import DataError, OptionError
from sigmatau.hints import as_options, speaking, worded
from sigmatau.io.read.options import ReadOptions
from sigmatau.record.record import Record
from sigmatau.record.streams import rates_size
from sigmatau.typed.config import arguments

Progress = Callable[[str], None]
Outcome = tuple[str, Any]
"""``("done", value)``, or ``("failed", content)`` of a `sigmatau.app.answers.CallError`."""

_LARGEST_CACHED = 1 << 29  # largest record that a worker caches [bytes]
_NO_MEMORY = "not enough memory for this record: analyse a part of it, or save it as .npy, which stays on disk"


class _Cache:
    """Holds the last computed value, because consecutive calls of a worker often use the same log."""

    def __init__(self) -> None:
        self._key: object = None
        self._value: Any = None

    def get(self, key: object, make: Callable[[], Any], *, size: Callable[[Any], int]) -> Any:  # noqa: ANN401
        """The value of a key, which is made unless it is the cached one."""
        if self._key != key or self._value is None:
            self._key = self._value = None  # release the memory before the next record is read
            value = make()
            if size(value) > _LARGEST_CACHED:
                return value
            self._key, self._value = key, value
        return self._value

    def find(self, key: object) -> Any:  # noqa: ANN401
        """The value of a key; None if it is not the cached one."""
        return self._value if self._key == key else None

    def clear(self) -> None:
        """Release the value."""
        self._key = self._value = None


_cache = _Cache()


def cached(
    what: str, log: LogFile, table: Mapping[str, Any], make: Callable[[], Any], *, size: Callable[[Any], int]
) -> Any:  # noqa: ANN401
    """The value for a log and its reading options, from the cache or made anew."""
    try:
        key = _key(what, log, table)
    except OSError:
        return make()  # reports the error
    return _cache.get(key, make, size=size)


def _key(what: str, log: LogFile, table: Mapping[str, Any]) -> tuple[object, ...]:
    return (what, *log.key(), json.dumps(reading_options(table), sort_keys=True, default=str))


def reading_options(table: Mapping[str, Any]) -> dict[str, Any]:
    """Select the reading options among those of the page, as arguments of `read`."""
    return arguments(ReadOptions, table)


def cached_record(log: LogFile, table: Mapping[str, Any]) -> Record | None:
    """The cached record, if it is of this log and these reading options; otherwise None."""
    try:
        return _cache.find(_key("record", log, table))  # type: ignore[no-any-return]
    except OSError:
        return None


def forget(*, progress: Progress) -> None:
    """Release the cached record, because another process will analyse this log with a record of its own."""
    _cache.clear()


CALLS = {
    "about": "opening:about",
    "analyze": "analysing:analyse",
    "charts": "analysing:charts",
    "clicked_curves": "clicking:clicked_curves",
    "compare": "comparing:compared",
    "config": "opening:configured",
    "curve": "downloads:curve_table",
    "datasheets": "specifying:listed_datasheets",
    "envelope": "opening:envelopes",
    "export": "downloads:exported",
    "figure": "downloads:figure",
    "figure_facts": "clicking:figure_facts",
    "forget": "calls:forget",
    "files": "listing:list_folder",
    "live_source": "watching:check_source",
    "kind": "opening:kind_of_file",
    "named": "listing:list_arguments",
    "open": "opening:open_log",
    "picture": "clicking:picture",
    "ports": "watching:listed_ports",
    "read_off": "analysing:read_off_at_tau",
    "read_result": "analysing:read_stored",
    "report": "downloads:report",
    "runs": "stored:listed_runs",
    "session": "opening:opened_session",
    "specification": "specifying:specification",
    "stored_run": "stored:stored_run",
}
"""Module and function of each call."""


def load(name: str) -> Callable[..., Any]:
    """The function of a call, imported when it is first needed."""
    module, _, function = CALLS[name].partition(":")
    return cast("Callable[..., Any]", getattr(importlib.import_module(f"sigmatau.app.{module}"), function))


def run_call(name: str, values: Mapping[str, Any], progress: Progress) -> Outcome:
    """Run a call and return its outcome: a value, or the content of an error."""
    try:
        call = load(name)
        with speaking(as_options):
            value = copy_context().run(call, progress=progress, **values)
    except (OptionError, DataError) as error:
        return "failed", error_content(error, values.get("log"))
    except ImportError as error:
        return "failed", {"message": str(error), "hint": None, "code": "data"}
    except MemoryError:
        return "failed", {"message": _NO_MEMORY, "hint": None, "code": "data"}
    except Exception as error:
        return "failed", {"message": f"internal error: {error!r}", "hint": None, "code": "failed"}
    return "done", value


def error_content(error: OptionError | DataError, log: LogFile | None = None) -> dict[str, Any]:
    """An error as the page shows it; the path of a temporary file is replaced by the name of the uploaded file."""
    text = worded(error.text if log is None else error.without(log.path, as_controls), as_controls)
    if log is not None:
        text = text.replace(log.path, log.name)
    is_option = isinstance(error, OptionError)
    question = error.question if isinstance(error, OptionError) else ""
    return {
        "message": text,
        "question": worded(question, as_controls) or None,
        "hint": hints_content(error.text),
        "code": "option" if is_option else "data",
        "option": error.option if isinstance(error, OptionError) else None,
        "rows": error.rows if isinstance(error, OptionError) else "",
    }


def record_size(record: Record | None) -> int:
    """Size of the samples of a record. [bytes]"""
    return 0 if record is None else rates_size(record.streams)


def number(value: float | None, digits: int = 6) -> float | None:
    """A number rounded to some digits; None if it is not finite."""
    return float(f"{value:.{digits}g}") if value is not None and math.isfinite(value) else None
