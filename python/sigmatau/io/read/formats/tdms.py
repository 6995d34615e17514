"""LabVIEW TDMS by npTDMS: a group of channels is a topic, and its waveform properties give the rate."""

from __future__ import annotations

import contextlib
import io
import logging
import struct
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError
from sigmatau.findings.finding import Finding
from sigmatau.findings.reading import Place
from sigmatau.findings.wording import sentence
from sigmatau.io.read.formats.arrays import Leaf, gather
from sigmatau.io.read.formats.damage import fault, library_faults
from sigmatau.io.read.table import Head, Table, need

_MARK = b"TDSm"  # first bytes of a segment
_LEAD = 28  # length of the lead-in of a segment [bytes]
_UNKNOWN = (1 << 64) - 1  # length of a segment whose writer was interrupted
_BIG_ENDIAN = 1 << 6  # flag of the lead-in
_INCREMENT = "wf_increment"  # Property of a channel: its sample interval [s]
_LOGGERS = ("tdms", "reader", "types", "tdms_segment", "base_segment", "channel_data", "daqmx", "scaling", "utils")


def read(path: Path, head: Head) -> tuple[Table, ...]:
    """The tables of a file: the channels of a group with one length are a table."""
    need("nptdms", "tdms", "a LabVIEW TDMS file")
    end, findings = _segments(path)
    leaves: list[Leaf] = []
    skipped: list[str] = []
    with _opened(path, end) as file:
        cut: dict[str, int] = {}
        if findings and file.file_status.channel_statuses:
            states = file.file_status.channel_statuses
            cut = {name: max(0, s.expected_length - s.read_length) for name, s in states.items()}
        for group in file.groups():
            channels = [c for c in group.channels() if len(c)]
            for channel in channels:
                if len(channel) > end:
                    raise DataError(
                        f"channel {channel.path} declares {len(channel)} values in {end} bytes; it is damaged"
                    )
                if channel.dtype.kind not in "iufM":
                    skipped.append(f"{group.name}/{channel.name}")
                    continue
                # Where the file is truncated some channels are shorter: all are cut to the same length.
                whole = len(channel) + cut.get(channel.path, 0)
                rows = min(len(c) for c in channels if len(c) + cut.get(c.path, 0) == whole)
                stamps = channel.dtype.kind == "M"
                unit = channel.properties.get("unit_string")
                leaves.append(
                    Leaf(
                        group=(group.name,),
                        name=channel.name,
                        shape=(rows,),
                        load=_loader(path, end, group.name, channel.name, rows, len(channel)),
                        unit="us" if stamps else unit if isinstance(unit, str) else None,
                        rate=_rate(channel.properties),
                        rate_key=_INCREMENT,
                    )
                )
    notes = ["TDMS, without checksums: damaged numbers are not detected"]
    if skipped:
        notes.append(f"channels of other types: {', '.join(skipped[:12])}")
    if not leaves:
        lost = "".join(f"; {sentence(finding)}" for finding in findings)
        raise DataError(f"has no channel of numbers{lost}")
    return gather(
        leaves,
        kind="tdms",
        root="",
        separator="/",
        notes=tuple(notes),
        findings=findings,
    )


def _segments(path: Path) -> tuple[int, tuple[Finding, ...]]:
    """The end of the last readable segment, and a finding of the damage after it, which npTDMS does not report. [bytes]"""
    size = path.stat().st_size
    position, number = 0, 0
    with path.open("rb") as stream:
        while position < size:
            number += 1
            place = Place("segment", number, byte=position)
            stream.seek(position)
            lead = stream.read(_LEAD)
            if not _MARK.startswith(lead[:4]):
                return position, (fault(place=place, reason="it does not begin with its mark"),)
            if len(lead) < _LEAD:
                return position, (fault(truncated=True, place=place, reason=f"{size - position} of {_LEAD} bytes"),)
            order = ">" if lead[4] & _BIG_ENDIAN else "<"
            following, data = struct.unpack(f"{order}QQ", lead[12:28])
            if following == _UNKNOWN:
                return size, (fault(truncated=True, place=place, reason="its writer did not close it"),)
            have = size - position - _LEAD
            if following > have:
                end = size if data <= have else position  # data without their description cannot be read
                return end, (fault(truncated=True, place=place, reason=f"{have} of {following} bytes"),)
            if data > following:
                return position, (fault(place=place, reason="its data begin after its end"),)
            position += _LEAD + following
    return size, ()


class _FilePart(io.RawIOBase):
    """A file up to a byte: npTDMS refuses a whole file if one segment is damaged."""

    def __init__(self, stream: io.BufferedReader, end: int) -> None:
        self._stream, self._end = stream, end

    def readable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def tell(self) -> int:
        return self._stream.tell()

    def seek(self, offset: int, whence: int = 0, /) -> int:
        return self._stream.seek(offset + self._end if whence == 2 else offset, 0 if whence == 2 else whence)

    def read(self, size: int = -1, /) -> bytes:
        rest = max(0, self._end - self._stream.tell())
        return self._stream.read(rest if size is None or size < 0 else min(size, rest))

    def readinto(self, buffer: Any, /) -> int:  # noqa: ANN401
        data = self.read(memoryview(buffer).nbytes)
        memoryview(buffer).cast("B")[: len(data)] = data
        return len(data)


@contextlib.contextmanager
def _opened(path: Path, end: int) -> Iterator[Any]:
    """The file by npTDMS, without its name, so that npTDMS does not use an outdated index file."""
    import nptdms

    with _quiet(), path.open("rb") as stream, nptdms.TdmsFile.open(_FilePart(stream, end)) as file:
        yield file


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Turn errors of npTDMS into `DataError`, and suppress its log, because its warnings are findings here."""
    loggers = [logging.getLogger(f"nptdms.{name}") for name in _LOGGERS]  # each module has its own
    enabled = [log.disabled for log in loggers]
    for log in loggers:
        log.disabled = True
    try:
        with library_faults(), np.errstate(all="ignore"):
            yield
    finally:
        for log, was in zip(loggers, enabled, strict=True):
            log.disabled = was


def _loader(path: Path, end: int, group: str, name: str, rows: int, declared: int) -> Callable[[], NDArray[Any]]:
    def load() -> NDArray[Any]:
        with _opened(path, end) as file:
            values = np.asarray(file[group][name].read_data())
        if len(values) != declared:
            raise DataError(f"channel {group}/{name} has {len(values)} of {declared} values; it is damaged")
        if values.dtype.kind == "M":
            if np.isnat(values).any():
                raise DataError(f"channel {group}/{name} has no time at row {int(np.flatnonzero(np.isnat(values))[0])}")
            values = values.astype("datetime64[us]").astype(np.int64)
        return values[:rows]

    return load


def _rate(properties: Any) -> float | None:  # noqa: ANN401
    step = properties.get(_INCREMENT)
    if isinstance(step, int | float | np.number) and 1e-9 < float(step) < 1e6:
        return 1.0 / float(step)
    return None
