"""Bags of ROS 2 as folders: ``metadata.yaml`` names the files that one recording was split into, in their order."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError
from sigmatau.findings.finding import Finding
from sigmatau.io.read.table import REST_MISSING, Loaded, Table

__all__ = ["METADATA", "files_of", "joined", "part_of"]

METADATA = "metadata.yaml"
_FILES = re.compile(r"relative_file_paths:[ \t]*\n((?:[ \t]*-[^\n]*(?:\n|$))+)")


def files_of(folder: Path) -> tuple[Path, ...]:
    """The files of a bag in the order in which they were recorded; none if the folder is no bag."""
    try:
        text = (folder / METADATA).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        return ()
    found = _FILES.search(text)
    if found is None or "\0" in found[1]:
        return ()
    names = [line.strip().removeprefix("-").strip(" \t\"'") for line in found[1].splitlines()]
    # Older recorders put the name of the folder before that of the file; and nothing outside of the folder is read.
    return tuple(folder / Path(name).name for name in names if Path(name).name)


def part_of(file: Path) -> tuple[Finding, ...]:
    """That a file is one part of several of a recording, if the metadata beside it say so."""
    names = [part.name for part in files_of(file.parent)]
    if len(names) < 2 or file.name not in names:
        return ()
    message = f"this is part {names.index(file.name) + 1} of {len(names)} of a recording"
    remedy = "give the folder to read all of it"
    return (Finding(code="part_of_several", severity="info", message=message, effect=remedy, remedy=remedy),)


def joined(folder: Path, files: Sequence[Path], read: Callable[[Path], Sequence[Table]]) -> tuple[Table, ...]:
    """The tables of all parts of a bag, those of one topic and the same columns one behind the other.

    Parameters
    ----------
    folder : Path
    files : sequence of Path
        See `files_of`.
    read : callable
        The tables of one file; what it raises as `DataError` loses that part.

    Raises
    ------
    DataError
        If no part can be read.
    """
    lost: list[Finding] = []
    pieces: dict[tuple[str, tuple[str, ...]], list[tuple[str, Table]]] = {}
    for number, file in enumerate(files, 1):
        which = f"part {number} of {len(files)}, {file.name},"
        if not file.exists():
            lost.append(_lost(f"{which} is missing"))
            continue
        try:
            tables = read(file)
        except (DataError, OSError) as error:
            lost.append(_lost(f"{which} cannot be read: {error}"))
            continue
        for table in tables:
            pieces.setdefault((table.topic, tuple(c.name for c in table.columns)), []).append((file.name, table))
    if not pieces:
        raise DataError(f"no part of the bag can be read: {'; '.join(f.message for f in lost)}")
    return tuple(_table(held, tuple(lost), len(files)) for held in pieces.values())


def _lost(message: str) -> Finding:
    return Finding(code="part_missing", severity="error", message=message, effect=REST_MISSING)


def _table(held: Sequence[tuple[str, Table]], lost: tuple[Finding, ...], parts: int) -> Table:
    first = held[0][1]
    lengths: list[int] = []  # of the parts as they were loaded

    def load(wanted: Sequence[int], exact: int | None) -> Loaded:
        columns: dict[int, list[NDArray[Any]]] = {index: [] for index in wanted}
        findings: list[Finding] = []
        lengths.clear()
        for name, table in held:
            try:
                loaded = table.load(wanted, exact)
            except DataError as error:
                if type(error) is not DataError or len(held) == 1:
                    raise  # a number that is none is said as of any log
                findings.append(_lost(f"{name}: {str(error).removeprefix(', ')}"))
                lengths.append(0)
                continue
            findings += [replace(finding, message=f"{name}: {finding.message}") for finding in loaded.findings]
            lengths.append(len(loaded.columns[wanted[0]]))
            for index in wanted:
                columns[index].append(loaded.columns[index])
        if not any(lengths):
            raise DataError(findings[0].message if findings else f"holds no message of {first.topic}")
        return Loaded(columns={i: np.concatenate(c) for i, c in columns.items()}, findings=tuple(findings))

    def where(row: int) -> str:
        for (name, table), length in zip(held, lengths, strict=False):
            if row < length:
                return f"{name}, {table.where(row)}"
            row -= length
        return f"row {row}"

    counts = [table.rows for _, table in held]
    own = [replace(finding, message=f"{name}: {finding.message}") for name, table in held for finding in table.findings]
    return replace(
        first,
        notes=(f"bag of {parts} parts, joined in the order of {METADATA}", *first.notes),
        load=load,
        where=where,
        rows=sum(n for n in counts if n is not None) if None not in counts else None,
        findings=(*lost, *own),
    )
