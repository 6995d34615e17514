"""PX4 flight logs (ULog): each instance of a message is a table.

Compiled code follows the chain of messages and reports where it is truncated. This module interprets the messages.
https://docs.px4.io/main/en/dev_log/ulog_file_format.html
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau._native import logs
from sigmatau.errors import DataError
from sigmatau.findings.finding import Finding
from sigmatau.findings.reading import LoggerDropouts, Place, SkippedMessages
from sigmatau.findings.wording import sentence
from sigmatau.frozen import frozen
from sigmatau.io.read.formats.damage import broken, fault
from sigmatau.io.read.table import Column, Head, Loaded, Table, without_absurd

_TYPES = {
    "int8_t": "i1",
    "uint8_t": "u1",
    "int16_t": "<i2",
    "uint16_t": "<u2",
    "int32_t": "<i4",
    "uint32_t": "<u4",
    "int64_t": "<i8",
    "uint64_t": "<u8",
    "float": "<f4",
    "double": "<f8",
    "bool": "u1",
    "char": "S1",
}
_FIELD = re.compile(r"([A-Za-z_][\w/\-]*)(?:\[(\d{1,5})\])? +([A-Za-z_]\w*)")
_LONGEST_MESSAGE = 65535  # length of the longest message [bytes]

# A file does not define units, but PX4's message definitions do. Axes that are named by a letter get the name of their
# message. Increments get a name that is not recognised as a rate.
_STAMPS = {"timestamp": "timestamp [us]", "timestamp_sample": "timestamp_sample [us]"}
_AXES = {
    **{m: (m, "rad/s") for m in ("sensor_gyro", "sensor_gyro_fifo")},
    **{m: (m, "m/s^2") for m in ("sensor_accel", "sensor_accel_fifo")},
}
_INCREMENTS = {"vehicle_imu", "sensor_preflight_imu"}


@frozen(kw_only=False)
class _ULogField:
    name: str
    kind: str
    offset: int


def read(path: Path, head: Head) -> tuple[Table, ...]:
    """The messages of a log, by instance: ``sensor_combined``, ``sensor_gyro:0``, ``sensor_gyro:1`` … Times are
    microseconds since the flight computer started. Messages of the sensor's buffer (``sensor_gyro_fifo``) are split
    into samples, whose times are spread evenly over the time since the previous message.
    """
    try:
        scan = logs.scan_ulog(str(path))
    except ValueError as error:
        raise DataError(f"is a PX4 flight log that cannot be read: {error}; copy or record the file again") from None
    size = path.stat().st_size
    formats = _defined(scan["formats"])
    topics = [
        (number, instance, bytes(name).decode(), rows, width) for number, instance, name, rows, width in scan["topics"]
    ]
    # Topics without data are skipped and each definition is interpreted once: damage may declare 65535 topics.
    layouts = {name: _layout(name, formats) for name in {topic[2] for topic in topics if topic[3]}}
    unusable = {t[2]: why for t in topics if t[3] and (why := layouts[t[2]].misfit(t[4]))}
    findings = (
        *broken(scan, size),
        *(fault(what=f"definition of {name}", reason=why) for name, why in unusable.items()),
        *_skipped(scan),
        *_dropouts(scan["dropouts"]),
    )
    if all(not rows or name in unusable for _, _, name, rows, _ in topics):
        raise DataError(f"is a PX4 flight log without data{_error_text(findings)}")
    several = {name for _, instance, name, _, _ in topics if instance > 0}
    labels: set[str] = set()
    tables: list[Table] = []
    for number, instance, name, rows, width in topics:
        if not rows or name in unusable:
            continue
        # If PX4 has one instance per sensor, its number is always part of the name.
        numbered = name in several or name in _AXES or name == "vehicle_imu"
        label = f"{name}:{instance}" if numbered else name
        label = f"{label}#{number}" if label in labels else label
        labels.add(label)
        source = _Source(str(path), int(scan["end"]), number, rows, width, label)
        make = _fifo if name.endswith("_fifo") and name in _AXES else _plain
        tables.extend(make(source, name, layouts[name].fields, findings))
    if not tables:
        raise DataError(f"is a PX4 flight log without columns of numbers{_error_text(findings)}")
    return tuple(tables)


class _UnusableError(Exception):
    pass


@frozen(kw_only=False)
class _Source:
    """The messages of one topic."""

    path: str
    end: int
    number: int
    rows: int
    size: int
    label: str

    def arrays(self, fields: Sequence[_ULogField], lengths: Sequence[int] | None = None) -> list[NDArray[Any]]:
        """One array for each field, of shape (n, length) if a length is given that is not 1."""
        lengths = lengths or [1] * len(fields)
        spans = [(f.offset, np.dtype(f.kind).itemsize * n) for f, n in zip(fields, lengths, strict=True)]
        raw = logs.ulog_columns(
            self.path, end=self.end, number=self.number, rows=self.rows, size=self.size, fields=spans
        )
        return [
            a.view(f.kind) if n == 1 else a.view(f.kind).reshape(-1, n)
            for a, f, n in zip(raw, fields, lengths, strict=True)
        ]

    def where(self, row: int) -> str:
        return f"message {row + 1} of {self.label}"


def _plain(source: _Source, name: str, fields: Sequence[_ULogField], findings: tuple[Finding, ...]) -> Iterator[Table]:
    shown = [f for f in fields if f.kind != "S1"]
    columns = tuple(Column(name=_named(name, f.name)) for f in shown)

    def load(wanted: Sequence[int], exact: int | None) -> Loaded:
        arrays = source.arrays([shown[i] for i in wanted])
        return Loaded(columns=dict(zip(wanted, arrays, strict=True)))

    if shown:
        yield Table(
            format="ulog",
            columns=columns,
            notes=(),
            load=load,
            where=source.where,
            topic=source.label,
            rows=source.rows,
            findings=findings,
        )


def _fifo(source: _Source, name: str, fields: Sequence[_ULogField], findings: tuple[Finding, ...]) -> Iterator[Table]:
    """Samples of a sensor's buffer: up to 32 integers in a message, with one common scale."""
    places = {f.name: f for f in fields}
    depth = sum(f.name.startswith("x[") for f in fields)
    needed = ("timestamp_sample", "dt", "scale", "samples", "x[0]", "y[0]", "z[0]")
    if any(n not in places for n in needed) or any(
        f.kind != "<i2" for f in fields if f.name.startswith(("x[", "y[", "z["))
    ):
        yield from _plain(source, name, fields, findings)
        return
    stamp, dt, scale, samples, *axes = (places[n] for n in needed)
    counts = source.arrays([samples])[0].astype(np.int64)
    wrong = np.flatnonzero(counts > depth)
    good = int(wrong[0]) if len(wrong) else source.rows
    if len(wrong):
        reason = f"{counts[good]} samples where at most {depth} fit"
        rows = int(counts[:good].sum())
        place, topic = Place("message", good + 1), source.label
        findings = (*findings, fault(place=place, reason=reason, kept=rows, counted="samples", topic=topic))
    counts = counts[:good]
    columns = (Column(name=_STAMPS["timestamp_sample"]), *(Column(name=_named(name, axis)) for axis in "xyz"))
    first = np.concatenate(([0], np.cumsum(counts)))

    def load(wanted: Sequence[int], exact: int | None) -> Loaded:
        raw: dict[int, NDArray[Any]] = {}
        for index in wanted:
            if index == 0:
                times, step = (a[:good] for a in source.arrays([stamp, dt]))
                raw[0] = _spread(times.astype(np.int64), step.astype(np.float64), counts)
                continue
            counted, factor = source.arrays([axes[index - 1], scale], [depth, 1])
            used = np.arange(depth) < counts[:, None]
            raw[index] = counted.reshape(-1, depth)[:good][used] * np.repeat(
                without_absurd(factor[:good].astype(np.float64)), counts
            )
        return Loaded(columns=raw)

    def where(row: int) -> str:
        return source.where(int(np.searchsorted(first, row, side="right")) - 1)

    yield Table(
        format="ulog",
        columns=columns,
        notes=("samples of the sensor's buffer, their times spread over the time since the previous message",),
        load=load,
        where=where,
        topic=source.label,
        rows=int(first[-1]),
        findings=findings,
    )


def _spread(times: NDArray[np.int64], dt: NDArray[np.float64], counts: NDArray[np.int64]) -> NDArray[np.int64]:
    """Times of the samples in whole microseconds; the time stamp of a message is that of its last sample. The declared
    interval `dt` is nominal. With a faster sensor it would make time go backwards between messages, so it is used only
    if the previous message is missing or too far away.
    """
    nominal = np.clip(np.nan_to_num(dt), 0.0, 1e6) * counts
    since = np.diff(times, prepend=times[:1] - 1).astype(np.float64)
    follows = (since > 0) & (since < 1.5 * nominal)
    follows[:1] = False
    span = np.where(follows, since, nominal)
    until_last = (
        np.repeat(np.cumsum(counts), counts) - 1 - np.arange(int(counts.sum()))
    )  # samples up to the last of the message
    step = np.repeat(span / np.maximum(counts, 1), counts)
    return np.repeat(times, counts) - np.rint(until_last * step).astype(np.int64)


def _named(message: str, field: str) -> str:
    if field in _STAMPS:
        return _STAMPS[field]
    if message in _AXES and field in ("x", "y", "z"):
        return f"{_AXES[message][0]}.{field} [{_AXES[message][1]}]"
    return f"{message}.{field}" if message in _INCREMENTS else field


def _defined(definitions: Sequence[bytes]) -> dict[str, str]:
    formats: dict[str, str] = {}
    for definition in definitions:
        name, _, body = definition.decode("utf-8", errors="replace").partition(":")
        formats.setdefault(name, body)
    return formats


@frozen(kw_only=False)
class _Layout:
    """The fields of a message without padding, and its smallest and largest size [bytes]; or the reason why it cannot
    be read.
    """

    fields: Sequence[_ULogField] = ()
    smallest: int = 0
    largest: int = 0
    wrong: str = ""

    def misfit(self, size: int) -> str:
        """Why messages of this size cannot be read; empty if they can be read."""
        if self.wrong or self.smallest <= size <= self.largest:
            return self.wrong
        return f"it gives {self.largest} bytes, but the messages have {size}"


def _layout(message: str, formats: Mapping[str, str]) -> _Layout:
    try:
        fields, largest = _order_fields(message, formats, depth=0)
    except _UnusableError as error:
        return _Layout(wrong=str(error))
    while fields and fields[-1].name.startswith("_padding"):
        fields.pop()  # a last field that the file does not contain
    smallest = max((f.offset + np.dtype(f.kind).itemsize for f in fields), default=0)
    return _Layout([f for f in fields if "_padding" not in f.name], smallest, largest)


def _order_fields(message: str, formats: Mapping[str, str], *, depth: int) -> tuple[list[_ULogField], int]:
    """The fields with their offsets, and their total length. [bytes]"""
    if message not in formats:
        raise _UnusableError(f"{message!r} is not defined")
    if depth > 8:
        raise _UnusableError("it is nested more than 8 deep")
    fields: list[_ULogField] = []
    offset = 0
    for text in filter(None, formats[message].split(";")):
        match = _FIELD.fullmatch(text.strip())
        if match is None:
            raise _UnusableError(f"{text[:40]!r} is not a field")
        kind, count, name = match[1], match[2], match[3]
        inner: list[_ULogField] = [_ULogField("", _TYPES[kind], 0)] if kind in _TYPES else []
        if inner:
            length = np.dtype(_TYPES[kind]).itemsize
        else:
            inner, length = _order_fields(kind, formats, depth=depth + 1)
        times = 1 if count is None else int(count)
        if offset + length * times > _LONGEST_MESSAGE or not length:
            raise _UnusableError(f"with {name!r} it is longer than {_LONGEST_MESSAGE} bytes, or the field is empty")
        for k in range(times):
            base = name if count is None else f"{name}[{k}]"
            fields += [_ULogField(f"{base}.{f.name}" if f.name else base, f.kind, offset + f.offset) for f in inner]
            offset += length
    return fields, offset


def _skipped(scan: Mapping[str, Any]) -> list[Finding]:
    skipped = [SkippedMessages(count=scan["unknown"], other=True)] if scan["unknown"] else []
    if scan["unfinished"]:  # chain that is incomplete before the appended data
        skipped.append(SkippedMessages(count=len(scan["unfinished"]), place=Place("byte", scan["unfinished"][0][0])))
    return [Finding(details=details, severity="warning") for details in skipped]


def _dropouts(durations: Sequence[int]) -> list[Finding]:
    if not durations:
        return []
    details = LoggerDropouts(count=len(durations), total=sum(durations) / 1000, longest=max(durations) / 1000)
    return [Finding(details=details, severity="warning")]


def _error_text(findings: Sequence[Finding]) -> str:
    errors = [finding for finding in findings if finding.severity == "error"]
    return f": {sentence(errors[0])}" if errors else ""
