"""The work of a worker process: calls by name, their errors as plain values, and a cached record."""

from __future__ import annotations

import importlib
import json
import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextvars import copy_context
from typing import Any, cast

from sigmatau.app.log import LogFile
from sigmatau.errors import DataError, OptionError
from sigmatau.hints import RATE, Face, Hint, as_options, hints_in, speaking, worded
from sigmatau.io.read.options import ReadOptions
from sigmatau.typed.config import arguments

Progress = Callable[[str], None]
Outcome = tuple[str, Any]
"""``("done", value)``, or ``("failed", content)`` of a `sigmatau.app.answers.CallError`."""

_LARGEST_CACHED = 1 << 29  # bytes of a record that a worker keeps between calls
_NO_MEMORY = "not enough memory for this record: analyse a part of it, or save it as .npy, which stays on disk"


class _Cache:
    """The last computed value, because a worker often uses one log repeatedly."""

    def __init__(self) -> None:
        self._key: object = None
        self._value: Any = None

    def get(self, key: object, make: Callable[[], Any], *, size: Callable[[Any], int]) -> Any:  # noqa: ANN401
        """The value of this key, made if it is not the last one."""
        if self._key != key or self._value is None:
            self._key = self._value = None  # before the next one is read
            value = make()
            if size(value) > _LARGEST_CACHED:
                return value
            self._key, self._value = key, value
        return self._value


_cache = _Cache()


def cached(
    what: str, log: LogFile, table: Mapping[str, Any], make: Callable[[], Any], *, size: Callable[[Any], int]
) -> Any:  # noqa: ANN401
    """The cached value for a log with these options of reading, or a new one."""
    try:
        key = (what, *log.key(), json.dumps(reading_options(table), sort_keys=True, default=str))
    except OSError:
        return make()  # reports the error
    return _cache.get(key, make, size=size)


def reading_options(table: Mapping[str, Any]) -> dict[str, Any]:
    """The options of reading among those of the page, as Python takes them."""
    return arguments(ReadOptions, table)


CALLS = {
    "about": "opening:about",
    "analyze": "analysing:analyse",
    "charts": "analysing:charts",
    "compare": "comparing:compared",
    "config": "opening:configured",
    "curve": "taking:curve_table",
    "envelope": "opening:envelopes",
    "export": "taking:exported",
    "figure": "taking:figure",
    "files": "listing:listed",
    "is_result": "opening:is_stored_result",
    "named": "listing:named",
    "open": "opening:open_log",
    "read_off": "analysing:read_off_at_tau",
    "read_result": "analysing:read_stored",
    "report": "taking:report_page",
}
"""Module and function of each call."""


def load(name: str) -> Callable[..., Any]:
    """The function of a call, imported when it is first needed."""
    module, _, function = CALLS[name].partition(":")
    return cast("Callable[..., Any]", getattr(importlib.import_module(f"sigmatau.app.{module}"), function))


def do(name: str, values: Mapping[str, Any], progress: Progress) -> Outcome:
    """Do a call; an error is an outcome too."""
    try:
        call = load(name)
        with speaking(as_options):
            value = copy_context().run(call, progress=progress, **values)
    except (OptionError, DataError) as error:
        return "failed", error_content(error, values.get("log"), face=as_choices if name == "open" else as_options)
    except ImportError as error:
        return "failed", {"message": str(error), "hint": None, "code": "data"}
    except MemoryError:
        return "failed", {"message": _NO_MEMORY, "hint": None, "code": "data"}
    except Exception as error:
        return "failed", {"message": f"internal error: {error!r}", "hint": None, "code": "failed"}
    return "done", value


def error_content(
    error: OptionError | DataError, log: LogFile | None = None, *, face: Face = as_options
) -> dict[str, Any]:
    """An error as the page shows it, with the name that the user knows in place of a temporary file."""
    text = worded(error.text if log is None else error.without(log.path, face), face)
    if log is not None:
        text = text.replace(log.path, log.name)
    is_option = isinstance(error, OptionError)
    return {
        "message": text,
        "hint": hints_content(error.text, face),
        "code": "option" if is_option else "data",
        "option": error.option if isinstance(error, OptionError) else None,
        "rows": error.rows if isinstance(error, OptionError) else "",
    }


def hints_content(text: str, face: Face = as_options) -> list[dict[str, Any]] | None:
    """The options that a message names, as the page offers them; None if it names none."""
    hints = [_hint_content(hint, face) for hint in hints_in(text)]
    return hints or None


def _hint_content(hint: Hint, face: Face) -> dict[str, Any]:
    return {"option": hint.option, "key": hint.key, "value": hint.value, "text": face([hint])}


def as_choices(hints: Sequence[Hint]) -> str:
    """Hints as answers to a question in a page, without the spelling of the command line.

    Examples
    --------
    >>> from sigmatau.hints import Hint
    >>> as_choices([Hint("channels", value={"accel": "1:3", "gyro": "4:6"})])
    'accel in columns 1 to 3, gyro in columns 4 to 6'
    >>> as_choices([Hint("unit", value={"gyro": "deg/s"}), Hint("rate", value="HZ")])
    'gyro in deg/s and the sampling rate'
    """
    return " and ".join(map(_choice, hints))


def _choice(hint: Hint) -> str:
    pairs = hint.pairs()
    if hint.option == "channels" and pairs is not None and not _has_placeholder(pairs.values()):
        return ", ".join(f"{channel} in {_columns_named(str(place))}" for channel, place in pairs.items())
    if hint.option == "unit" and pairs is not None and not _has_placeholder(pairs.values()):
        return ", ".join(f"{channel} in {unit}" for channel, unit in pairs.items())
    if hint == RATE:
        return "the sampling rate"
    return as_options([hint])


def _has_placeholder(values: Iterable[object]) -> bool:
    return any(re.fullmatch(r"[A-Z]+(:[A-Z]+)?|…", str(value)) for value in values)


def _columns_named(place: str) -> str:
    first, separator, last = place.partition(":")
    return f"columns {first} to {last}" if separator else f"column {first}"


def number(value: float | None, digits: int = 6) -> float | None:
    """A number with some digits; None for what is not finite."""
    return float(f"{value:.{digits}g}") if value is not None and math.isfinite(value) else None
