"""A result as rows of a store: all that can be computed without the database, in another process too."""

from __future__ import annotations

import hashlib
import json
import math
import struct
from collections.abc import Mapping
from datetime import UTC, datetime
from functools import lru_cache
from pathlib import PurePath
from typing import Any, Literal

from sigmatau._native.distributions import normal_quantile
from sigmatau.analysis.forms import BriefResultForm, ChannelForm, ResultForm, SourceForm, TermForm
from sigmatau.analysis.reading import form_of_dict
from sigmatau.errors import DataError
from sigmatau.fitting.fitted_noise import QUANTIFIED
from sigmatau.frozen import frozen
from sigmatau.noise.terms import TERMS, coefficient_unit
from sigmatau.store.packing import NUMBERS, Packed, pack

_MEAN = "mean"
_LEVEL = 0.95  # of the interval of a mean
_MOST_SAMPLES = 2**63 - 1
_MOST_LETTERS = {"unit": 400, "model": 200, "run": 400, "channel": 100}
_NUMBERS = struct.Struct("<ii5d")
assert _NUMBERS.size == NUMBERS.itemsize

State = Literal["fitted", "not_fitted", "not_at_rest", "too_short_to_tell", "failed"]


@frozen
class Entry:
    """A result with what is known of its unit and its run.

    Attributes
    ----------
    result : mapping
        `Analysis.to_dict()`, or the content of the JSON of ``sigmatau analyze``.
    unit : str
        Serial number.
    model : str
        Sensor model, or empty: then the one that the unit has stays.
    name : str
        Name of the run. Default: the name of its log.
    recorded : datetime or None
        Beginning of the record; without a time zone, UTC.
    temperature : float or None
        [degC]
    file_version : str
        Version of the log, such as its size and change time: tells whether it changed without reading it.
    """

    result: Mapping[str, Any]
    unit: str
    model: str = ""
    name: str = ""
    recorded: datetime | None = None
    temperature: float | None = None
    file_version: str = ""


Label = tuple[str, str, str, str, str]
"""Channel, quantity, term, unit of the coefficient, unit of the channel."""

Term = tuple[bool | None, float | None, float | None, float | None, float | None, float | None]
"""Observed, value, low, high, upper limit, level."""


@frozen
class Rows:
    """A result in its stored form, without the keys that the database gives."""

    unit: str
    model: str
    identity: str
    run: Mapping[str, Any]
    channels: tuple[tuple[Any, ...], ...]
    labels: tuple[Label, ...]
    terms: tuple[Term, ...]  # one a label
    numbers: bytes  # the same as `NUMBERS`, with positions in `labels`
    findings: tuple[tuple[str, str, str, str], ...]
    packed: Packed


def options_key(options: Mapping[str, Any]) -> str:
    """Checksum of the options that made a result, its key ``"options"``; without any, that of the default settings."""
    return hashlib.sha256(_canonical(options).encode()).hexdigest()


def _canonical(value: object) -> str:
    """JSON that is the same for the same options: 100 and 100.0, whatever the order of keys."""

    def plain(one: object) -> object:
        if isinstance(one, Mapping):
            return {str(key): plain(of) for key, of in one.items()}
        if isinstance(one, list | tuple):
            return [plain(of) for of in one]
        return float(one) if isinstance(one, int) and not isinstance(one, bool) else one

    return json.dumps(plain(value), sort_keys=True)


def rows_of(entry: Entry) -> Rows:
    """The rows of a result.

    Raises
    ------
    DataError
        If the result is none, or is damaged.
    """
    form = form_of_dict(entry.result, BriefResultForm)
    if form.source is None:
        raise DataError("not a result of sigmatau analyze: it has no source")
    try:
        return _rows(entry, form, form.source)
    except DataError:
        raise
    except (KeyError, TypeError, AttributeError, ValueError, ArithmeticError, RecursionError, struct.error) as error:
        what = f"{error} is missing" if isinstance(error, KeyError) else str(error)
        raise DataError(f"not a result of sigmatau analyze, or damaged: {what:.100}") from None


def _rows(entry: Entry, form: ResultForm, source: SourceForm) -> Rows:
    options = entry.result.get("options", {})
    unit = _name(entry.unit, "unit")
    packed = pack(entry.result)
    made_with = _canonical([options, source.conversions])
    # Of a record without a file, each result that differs is a run of its own.
    log = source.sha256 or (
        f"{unit}/{source.path}" if source.path else f"{unit}/{entry.name}/{entry.recorded}/{packed.digest}"
    )
    channels: list[tuple[Any, ...]] = []
    labels: list[Label] = []
    terms, numbers = [], []
    for name, channel in form.channels.items():
        if channel.curve is None:
            raise ValueError(f"{name} has no curve")
        fit, quantity, of = channel.fit, channel.quantity, channel.curve.unit
        verdict, p_value = ("", None) if fit is None else (fit.verdict, fit.p_value)
        channels.append((
            _name(name, "channel"), _common(quantity, 60), _common(of, 60), *_size(channel),
            verdict, channel.trust or "", p_value,
        ))  # fmt: skip
        for term, row, si in _terms(channel):
            numbers.append(
                _NUMBERS.pack(len(labels), verdict in QUANTIFIED, *[math.nan if x is None else x for x in row[1:]])
            )
            labels.append((name, quantity, term, _common(si, 60), of))
            terms.append(row)
    findings = [
        (_text(one.code)[:60], one.severity, _text(" ".join(one.channels)), _text(one.stated_text))
        for one in form.findings
    ]
    run = _run(entry, form, source, channels) | {"digest": packed.digest, "options_key": options_key(options)}
    return Rows(
        unit=unit,
        model=_name(entry.model, "model", needed=False),
        identity=hashlib.sha256(_utf8(f"{unit}\n{log}\n{made_with}")).hexdigest(),
        run=run,
        channels=tuple(channels),
        labels=_shared(tuple(labels)),
        terms=tuple(terms),
        numbers=b"".join(numbers),
        findings=tuple(findings),
        packed=packed,
    )


@lru_cache(1000)
def _shared(labels: tuple[Label, ...]) -> tuple[Label, ...]:
    """The same object for the same labels: a batch of results is sent from process to process, each object once."""
    return labels


def _terms(channel: ChannelForm) -> list[tuple[str, Term, str]]:
    """Term, row and unit of what a channel has."""
    rows: list[tuple[str, Term, str]] = []
    unit = "" if channel.curve is None else channel.curve.unit
    for name in TERMS:
        term: TermForm | None = None if channel.fit is None else getattr(channel.fit.terms, name)
        if term is not None:
            row = (term.observed, term.value, term.low, term.high, term.upper_limit, term.level)
            rows.append((name, row, term.unit or coefficient_unit(name, channel.quantity, unit)))
    if channel.mean is not None:
        value, error = channel.mean.value, channel.mean.error
        half = None if error is None else _QUANTILE * error
        interval = (None, None, None) if half is None else (value - half, value + half, _LEVEL)
        rows.append((_MEAN, (None, value, interval[0], interval[1], None, interval[2]), channel.mean.unit))
    return rows


_QUANTILE = float(normal_quantile((1 + _LEVEL) / 2))


def _run(entry: Entry, form: ResultForm, source: SourceForm, channels: list[tuple[Any, ...]]) -> dict[str, Any]:
    path = _text(source.path or "")
    return {
        "name": _name(entry.name or PurePath(path).name or entry.unit, "run"),
        "path": path,
        "sha256": _word(source.sha256, 64) if source.sha256 else None,
        "recorded": None if entry.recorded is None else in_utc(entry.recorded),
        "temperature": _number(entry.temperature),
        "duration": max((samples / rate for *_, rate, samples, _, _, _ in channels), default=None),
        "state": _state(form),
        "message": "" if form.error is None else _text(form.error.stated_text),
        "version": _text(form.sigmatau)[:40],
        "file_version": _text(entry.file_version)[:200],
    }


def in_utc(time: datetime) -> datetime:
    """A time as a store keeps it: UTC, without a time zone. One without a zone is UTC.

    Raises
    ------
    DataError
        For a time that is not in the years 1 to 9999 of UTC.
    """
    try:
        return time if time.tzinfo is None else time.astimezone(UTC).replace(tzinfo=None)
    except OverflowError:
        raise DataError(f"the time {time.isoformat()} is not in the years 1 to 9999 in UTC") from None


def _size(channel: ChannelForm) -> tuple[float, int]:
    """Rate and number of samples."""
    rate, samples = channel.sample_rate_hz or 0.0, channel.samples
    if not (0 < rate < math.inf and 0 <= samples <= _MOST_SAMPLES):
        raise ValueError(f"{float(samples):.3g} samples at {rate:g} Hz")
    return float(rate), samples


def _word(value: object, most: int) -> str:
    """A text of a column."""
    if not isinstance(value, str):
        raise TypeError(f"a text is {value!r:.30}")
    if len(value) > most:
        raise ValueError(f"a text has {len(value)} characters, more than {most}: {value:.30}…")
    return _text(value)


_common = lru_cache(1000)(_word)  # few words, each in thousands of rows


def _number(value: Any) -> float | None:  # noqa: ANN401  anything that JSON has
    if value is None:
        return None
    found = float(value)
    if not math.isfinite(found):
        raise ValueError(f"{found} in place of a number")
    return found


def _state(form: ResultForm) -> State:
    if form.error is not None:
        return "failed"
    fits = [channel.fit for channel in form.channels.values() if channel.fit is not None]
    if any(fit.verdict != "too_short" for fit in fits):
        return "fitted"
    verdict = "" if form.rest is None else form.rest.verdict
    return verdict if not fits and verdict in ("not_at_rest", "too_short_to_tell") else "not_fitted"


def _name(text: str, of: str, *, needed: bool = True) -> str:
    """A name as the database takes it; raises `DataError` if it is empty or too long."""
    found = _text(text).strip()
    if needed and not found:
        raise DataError(f"the name of the {of} is empty")
    if len(found) > _MOST_LETTERS[of]:
        raise DataError(
            f"the name of the {of} has {len(found)} characters, more than {_MOST_LETTERS[of]}: {found:.30}…"
        )
    return found


def _text(value: object) -> str:
    """Text without what databases refuse: null characters, and bytes of file names that are not UTF-8."""
    text = str(value)
    return text if text.isascii() and "\0" not in text else _utf8(text.replace("\0", "\\0")).decode()


def _utf8(text: str) -> bytes:
    return text.encode("utf-8", "backslashreplace")
