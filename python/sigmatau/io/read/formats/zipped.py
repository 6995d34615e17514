"""Zip archives of text tables, as phyphox and Sensor Logger export them: one file for each sensor, at its own rate."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING

from sigmatau.errors import DataError
from sigmatau.io.read.formats import text
from sigmatau.io.read.formats.damage import archive_ends, damaged, library_faults, refuse_expansion
from sigmatau.io.read.registry import find_text_reader
from sigmatau.io.read.table import HEAD, Head, Loaded, Table, TextFormat
from sigmatau.record import memory

if TYPE_CHECKING:
    import zipfile

_MAX_MEMBERS = 1000


def read(path: Path, head: Head) -> tuple[Table, ...]:
    """The text tables of an archive: each member is a topic, and members without a table are named in a note."""
    import zipfile  # in the call, to keep the reading of text fast

    tables: list[Table] = []
    skipped: list[str] = []
    with library_faults(_damaged), zipfile.ZipFile(path) as archive:
        first = min((m.header_offset for m in archive.infolist()), default=0)
        members = [m for m in archive.infolist() if not m.is_dir() and not m.filename.startswith("__MACOSX/")]
        if any(m.filename == "[Content_Types].xml" for m in members):
            raise DataError("is a Word or PowerPoint file, or a damaged Excel workbook; save the table as CSV")
        if len(members) > _MAX_MEMBERS:
            raise DataError(f"is a zip archive of {len(members)} files; unpack it and give the file to read")
        for member in members:
            held = _tables(path, archive, member)
            if isinstance(held, str):
                skipped.append(f"{member.filename} ({held})")
            else:
                tables += held
    if not tables:
        why = f": {'; '.join(skipped[:3])}" if skipped else ""
        raise DataError(f"is a zip archive without text tables, .npy or .npz files{why}"[:400])
    ends = archive_ends(path, first)
    if skipped or ends:
        note = f"left out: {', '.join(skipped)}"[:300]
        tables = [
            replace(t, notes=(*t.notes, note) if skipped and t is tables[0] else t.notes, findings=(*t.findings, *ends))
            for t in tables
        ]
    return tuple(tables)


def _tables(path: Path, archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> list[Table] | str:
    """The tables of a member, or the reason why it has none."""
    if member.flag_bits & 1:
        return "encrypted: unpack it with its password"
    with archive.open(member) as stream:
        data = stream.read(HEAD)
    if not data:
        return "empty"
    if data.startswith(b"\x1f\x8b"):
        return "compressed by gzip: unpack the archive and give the file"
    head = Head(data=data, whole=member.file_size <= HEAD, gzip=False)
    reader = find_text_reader(head, path)
    if reader is None:
        return "binary: unpack the archive and give the file"
    name = PurePosixPath(member.filename).stem
    try:
        # The layout of a table is detected from the head, and the rows are unpacked on demand and not kept.
        beginning = head.whole or reader.read_tables is text.read_tables
        shown = reader.read_tables(data if beginning else _unpacked(path, member), head, name, member.filename)
    except DataError as error:
        return error.reason
    return [_on_demand(table, k, path, member, head, name, reader) for k, table in enumerate(shown)]


def _on_demand(
    shown: Table, number: int, path: Path, member: zipfile.ZipInfo, head: Head, name: str, reader: TextFormat
) -> Table:
    """A table of a member that is unpacked each time it is read."""

    def whole_table() -> Table:
        return reader.read_tables(_unpacked(path, member), head, name, member.filename)[number]

    def load(wanted: Sequence[int], exact: int | None) -> Loaded:
        try:
            return whole_table().load(wanted, exact)
        except DataError as error:
            raise error.at(member.filename) from None

    where = lambda row: f"{member.filename}, {whole_table().where(row)}"  # noqa: E731
    return replace(shown, notes=("zip", *shown.notes), load=load, where=where)


def _unpacked(path: Path, member: zipfile.ZipInfo) -> bytes:
    """Unpack a member and verify its checksum."""
    import zipfile

    refuse_expansion(path.stat().st_size, member.file_size, member.filename)
    free = memory.available()
    if free is not None and 2 * member.file_size > free:
        raise DataError(f"{member.file_size / 1e9:.3g} GB unpacked do not fit in memory; unpack it and give the file")
    with library_faults(_damaged), zipfile.ZipFile(path) as archive:
        return archive.read(member)


def _damaged(error: Exception) -> DataError:
    return damaged(error, "a damaged or truncated zip archive")
