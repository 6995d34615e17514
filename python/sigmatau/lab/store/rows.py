"""Conversion of a result to rows of a store. It does not need the database, so that other processes can do it."""

from __future__ import annotations

import hashlib
import json
import math
import struct
from collections.abc import Iterator, Mapping
from datetime import UTC, datetime
from functools import lru_cache
from pathlib import PurePath
from typing import Any, Literal

from sigmatau import Analysis
from sigmatau._native.distributions import normal_quantile
from sigmatau.analysis import FailedAnalysis, stated_options
from sigmatau.errors import DataError
from sigmatau.fitting import QUANTIFIED
from sigmatau.frozen import frozen
from sigmatau.lab.lots.conditions import run_supply, run_temperature
from sigmatau.lab.lots.runs import LEVEL, MEAN
from sigmatau.lab.store.packing import NUMBERS, Packed, pack

_LONGEST_NAMES = {"unit": 400, "model": 200, "run": 400, "channel": 100}  # as in `tables` [characters]
_NUMBERS = struct.Struct("<ii5d")
assert _NUMBERS.size == NUMBERS.itemsize

State = Literal["fitted", "not_fitted", "not_at_rest", "too_short_to_tell", "failed"]


@frozen
class Entry:
    """A result with the known facts about its unit and its run.

    Attributes
    ----------
    result : Analysis or FailedAnalysis
    unit : str
        Serial number.
    model : str
        Sensor model; if it is empty, the stored model of the unit does not change.
    name : str
        Name of the run. Default: the name of its log.
    recorded : datetime or None
        Beginning of the record; without a time zone, UTC.
    temperature : float or None
        [degC] Default: the mean of the thermometer of the log.
    supply : float or None
        Supply voltage. [V] Default: of a channel of the log, or of its name.
    file_version : str
        Version of the log, such as its size and change time, which shows a change without reading the log.
    content : mapping or None
        JSON text from which the result was read; it is stored unchanged. Default: the JSON of `result`.
    """

    result: Analysis | FailedAnalysis
    unit: str
    model: str = ""
    name: str = ""
    recorded: datetime | None = None
    temperature: float | None = None
    supply: float | None = None
    file_version: str = ""
    content: Mapping[str, Any] | None = None


Label = tuple[str, str, str, str, str]
"""Channel, quantity, term, unit of the coefficient, unit of the channel."""

Term = tuple[bool | None, float | None, float | None, float | None, float | None, float | None]
"""Observed, value, low, high, upper limit, level."""


@frozen
class Rows:
    """A packed result, without the keys that the database assigns."""

    unit: str
    model: str
    identity: str
    run: Mapping[str, Any]
    channels: tuple[tuple[Any, ...], ...]
    labels: tuple[Label, ...]
    terms: tuple[Term, ...]  # one per label
    numbers: bytes  # like `NUMBERS`, with positions in `labels`
    findings: tuple[tuple[str, str, str, str], ...]
    packed: Packed
    measured: tuple[str, ...] = ()  # columns of `run` that come from the log, because nobody stated them


def options_key(options: Mapping[str, Any]) -> str:
    """Checksum of the options of a result, its key ``"options"``; if it has none, that of the default settings."""
    return hashlib.sha256(_canonical(options).encode()).hexdigest()


def _canonical(value: object) -> str:
    """JSON that is equal for equal options: 100 and 100.0 are equal, and the order of keys has no effect."""

    def plain(value: object) -> object:
        if isinstance(value, Mapping):
            return {str(key): plain(item) for key, item in value.items()}
        if isinstance(value, list | tuple):
            return [plain(item) for item in value]
        return float(value) if isinstance(value, int) and not isinstance(value, bool) else value

    return json.dumps(plain(value), sort_keys=True)


def make_rows(entry: Entry) -> Rows:
    """Build the rows of a result.

    Raises
    ------
    DataError
        If a name, a number or the JSON of the result cannot be stored.
    """
    try:
        return _rows(entry)
    except DataError:
        raise
    except (KeyError, TypeError, AttributeError, ValueError, ArithmeticError, RecursionError, struct.error) as error:
        what = f"{error} is missing" if isinstance(error, KeyError) else str(error)
        raise DataError(f"not a result of sigmatau analyze, or damaged: {what:.100}") from None


def _rows(entry: Entry) -> Rows:
    result = entry.result
    content = result.to_dict() if entry.content is None else entry.content
    unit, packed = _name(entry.unit, "unit"), pack(content)
    analysis = result if isinstance(result, Analysis) else None
    if analysis is not None and not analysis.curves:
        raise DataError("not a result of sigmatau analyze: it has no channels")
    labels = [] if analysis is None else [*_terms(analysis)]
    channels = () if analysis is None else tuple(_channels(analysis))
    fits = {} if analysis is None else analysis.fits
    quantified = {name for name, fit in fits.items() if fit.verdict in QUANTIFIED}
    numbers = [
        _NUMBERS.pack(k, label[0] in quantified, *[math.nan if x is None else x for x in row[1:]])
        for k, (label, row) in enumerate(labels)
    ]
    findings = () if analysis is None else analysis.findings
    run = _run(entry, channels) | {"digest": packed.digest, "has_curves": bool(packed.curves) or None}
    return Rows(
        unit=unit,
        model=_name(entry.model, "model", needed=False),
        identity=identity(unit, run),
        run=run,
        channels=channels,
        labels=_shared(tuple(label for label, _ in labels)),
        terms=tuple(row for _, row in labels),
        numbers=b"".join(numbers),
        findings=tuple(
            (_text(each.code)[:60], each.severity, _text(" ".join(each.channels)), _text(each.words_of_files().message))
            for each in findings
        ),
        packed=packed,
        measured=tuple(key for key in ("temperature", "supply") if getattr(entry, key) is None),
    )


def identity(unit: str, run: Mapping[str, Any]) -> str:
    """Checksum of the unit, log and options of a run, from the columns of its row; it identifies the run.

    If a record has no file, every different result is a separate run.
    """
    log = run["sha256"] or (
        f"{unit}/{run['path']}" if run["path"] else f"{unit}/{run['name']}/{run['recorded']}/{run['digest']}"
    )
    return hashlib.sha256(_utf8(f"{unit}\n{log}\n{run['options_key']}")).hexdigest()


@lru_cache(1000)
def _shared(labels: tuple[Label, ...]) -> tuple[Label, ...]:
    """Return the same object for equal labels: a batch that is sent between processes then contains it only once."""
    return labels


def _channels(analysis: Analysis) -> Iterator[tuple[Any, ...]]:
    """Build the rows of the channels."""
    for name, curve in analysis.curves.items():
        fit = analysis.fits.get(name)
        verdict, trust, p_value = ("", "", None) if fit is None else (fit.verdict, fit.trust or "", fit.p_value)
        names = _name(name, "channel"), _common(curve.quantity, 60), _common(curve.unit, 60)
        yield (*names, 1 / curve.tau0, curve.n, verdict, trust, p_value)


def _terms(analysis: Analysis) -> Iterator[tuple[Label, Term]]:
    """Collect the coefficients and means of the channels."""
    for name, curve in analysis.curves.items():
        fit, mean = analysis.fits.get(name), analysis.means.get(name)
        for term in () if fit is None else fit.terms.values():
            label = (name, curve.quantity, term.term, _common(term.unit, 60), curve.unit)
            yield label, (term.observed, term.value, term.low, term.high, term.upper_limit, term.level)
        if mean is not None:
            half = None if mean.error is None else _QUANTILE * mean.error
            ends = (None, None, None) if half is None else (mean.value - half, mean.value + half, LEVEL)
            label = (name, curve.quantity, MEAN, _common(mean.unit, 60), curve.unit)
            yield label, (None, mean.value, *ends[:2], None, ends[2])


_QUANTILE = float(normal_quantile((1 + LEVEL) / 2))


def _run(entry: Entry, channels: tuple[tuple[Any, ...], ...]) -> dict[str, Any]:
    result = entry.result
    if isinstance(result, FailedAnalysis):
        state, path, sha256, message, options = "failed", result.path, None, result.message, result.options or {}
        measured: tuple[float | None, float | None] = None, None
    else:
        state, path, sha256, message = _state(result), result.source.path or "", result.source.sha256, ""
        options = stated_options(result)
        measured = run_temperature(result), run_supply(result)
    path = _text(path)
    return {
        "name": _name(entry.name or PurePath(path).name or entry.unit, "run"),
        "path": path,
        "sha256": _word(sha256, 64) if sha256 else None,
        "recorded": None if entry.recorded is None else in_utc(entry.recorded),
        "temperature": _number(measured[0] if entry.temperature is None else entry.temperature),
        "supply": _number(measured[1] if entry.supply is None else entry.supply),
        "duration": max((samples / rate for *_, rate, samples, _, _, _ in channels), default=None),
        "state": state,
        "message": _text(message),
        "version": _text(result.version)[:40],
        "file_version": _text(entry.file_version)[:200],
        "options_key": options_key(options),
    }


def in_utc(time: datetime) -> datetime:
    """Convert a time to the form of the store: UTC, without a time zone. A time without a zone is UTC.

    Raises
    ------
    DataError
        For a time that is not in the years 1 to 9999 of UTC.
    """
    try:
        return time if time.tzinfo is None else time.astimezone(UTC).replace(tzinfo=None)
    except OverflowError:
        raise DataError(f"the time {time.isoformat()} is not in the years 1 to 9999 in UTC") from None


def _word(value: object, longest: int) -> str:
    """Check a text of a column; raises `TypeError` or `ValueError`."""
    if not isinstance(value, str):
        raise TypeError(f"a text is {value!r:.30}")
    if len(value) > longest:
        raise ValueError(f"a text has {len(value)} characters, more than {longest}: {value:.30}…")
    return _text(value)


_common = lru_cache(1000)(_word)  # cached, because thousands of rows have the same few texts


def _number(value: Any) -> float | None:  # noqa: ANN401  anything that JSON has
    if value is None:
        return None
    number = float(value)
    if not math.isfinite(number):
        raise ValueError(f"{number} is not a finite number")
    return number


def _state(analysis: Analysis) -> State:
    if any(fit.verdict != "too_short" for fit in analysis.fits.values()):
        return "fitted"
    verdict = "" if analysis.rest is None else analysis.rest.verdict
    return verdict if not analysis.fits and verdict in ("not_at_rest", "too_short_to_tell") else "not_fitted"


def _name(text: str, kind: str, *, needed: bool = True) -> str:
    """Check a name and strip its spaces; raises `DataError` if it is empty or too long."""
    name = _text(text).strip()
    if needed and not name:
        raise DataError(f"the name of the {kind} is empty")
    if len(name) > _LONGEST_NAMES[kind]:
        raise DataError(
            f"the name of the {kind} has {len(name)} characters, more than {_LONGEST_NAMES[kind]}: {name:.30}…"
        )
    return name


def _text(value: object) -> str:
    """Remove characters that databases refuse: null characters, and bytes of file names that are not UTF-8."""
    text = str(value)
    return text if text.isascii() and "\0" not in text else _utf8(text.replace("\0", "\\0")).decode()


def _utf8(text: str) -> bytes:
    return text.encode("utf-8", "backslashreplace")
