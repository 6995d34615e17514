"""Folders that are one log: Zarr stores, and ROS 2 bags, whose ``metadata.yaml`` lists the files of a recording in order."""

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
from sigmatau.findings.reading import InFile, PartMissing
from sigmatau.findings.wording import sentence
from sigmatau.io.read.table import Loaded, Table

METADATA = "metadata.yaml"
_ZARR = ("zarr.json", ".zgroup", ".zarray", ".zmetadata")
_FILES = re.compile(r"relative_file_paths:[ \t]*\n((?:[ \t]*-[^\n]*(?:\n|$))+)")


def zarr_head(folder: Path) -> Path | None:
    """The file that describes a Zarr store; None if the folder is not one."""
    return next((folder / mark for mark in _ZARR if (folder / mark).is_file()), None)


def bag_files(folder: Path) -> tuple[Path, ...]:
    """The files of a bag in the order of recording, or the file that describes a Zarr store; empty if the folder is not one
    log.
    """
    if (head := zarr_head(folder)) is not None:
        return (head,)
    try:
        text = (folder / METADATA).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        return ()
    numbered = _FILES.search(text)
    if numbered is None or "\0" in numbered[1]:
        return ()
    names = [line.strip().removeprefix("-").strip(" \t\"'") for line in numbered[1].splitlines()]
    # Older recorders put the name of the folder first. Files outside of the folder are never read.
    return tuple(folder / Path(name).name for name in names if Path(name).name)


def missing_parts(file: Path) -> tuple[Finding, ...]:
    """A finding if the metadata in the same folder list the file as one of several parts."""
    names = [part.name for part in bag_files(file.parent)]
    if len(names) < 2 or file.name not in names:
        return ()
    details = PartMissing(number=names.index(file.name) + 1, of=len(names), alone=True)
    return (Finding(details=details, severity="info"),)


def joined(folder: Path, files: Sequence[Path], read: Callable[[Path], Sequence[Table]]) -> tuple[Table, ...]:
    """The tables of a bag: the parts of one topic with the same columns are joined. `read`: returns the tables of one
    file. If it raises `DataError`, that part is left out, with a finding.
    """
    lost: list[Finding] = []
    pieces: dict[tuple[str, tuple[str, ...]], list[tuple[PartMissing, Table]]] = {}
    for number, file in enumerate(files, 1):
        missing = PartMissing(part=file.name, number=number, of=len(files))
        if not file.exists():
            lost.append(Finding(details=missing, severity="error"))
            continue
        try:
            tables = read(file)
        except (DataError, OSError) as error:
            lost.append(Finding(details=replace(missing, reason=str(error)), severity="error"))
            continue
        for table in tables:
            pieces.setdefault((table.topic, tuple(c.name for c in table.columns)), []).append((missing, table))
    if not pieces:
        raise DataError(f"no part of the bag can be read: {'; '.join(map(sentence, lost))}")
    return tuple(_table(held, tuple(lost), len(files)) for held in pieces.values())


def _in_part(name: str, findings: Sequence[Finding]) -> list[Finding]:
    """Add the name of the part to its findings."""
    return [
        replace(finding, details=replace(finding.details, part=name))
        for finding in findings
        if isinstance(finding.details, InFile)
    ]


def _table(held: Sequence[tuple[PartMissing, Table]], lost: tuple[Finding, ...], parts: int) -> Table:
    """Join the parts of one topic in a table. Each part is passed with the finding that would report its loss."""
    first = held[0][1]
    lengths: list[int] = []  # number of rows of each loaded part

    def load(wanted: Sequence[int], exact: int | None) -> Loaded:
        columns: dict[int, list[NDArray[Any]]] = {index: [] for index in wanted}
        findings: list[Finding] = []
        lengths.clear()
        for missing, table in held:
            try:
                loaded = table.load(wanted, exact)
            except DataError as error:
                if type(error) is not DataError or len(held) == 1:
                    raise  # an infinite value is an error in any log
                details = replace(missing, reason=error.reason)
                findings.append(Finding(details=details, severity="error"))
                lengths.append(0)
                continue
            findings += _in_part(missing.part, loaded.findings)
            lengths.append(len(loaded.columns[wanted[0]]))
            for index in wanted:
                columns[index].append(loaded.columns[index])
        if not any(lengths):
            raise DataError(sentence(findings[0]) if findings else f"holds no message of {first.topic}")
        return Loaded(columns={i: np.concatenate(c) for i, c in columns.items()}, findings=tuple(findings))

    def where(row: int) -> str:
        for (missing, table), length in zip(held, lengths, strict=False):
            if row < length:
                return f"{missing.part}, {table.where(row)}"
            row -= length
        return f"row {row}"

    counts = [table.rows for _, table in held]
    part_findings = [finding for missing, table in held for finding in _in_part(missing.part, table.findings)]
    return replace(
        first,
        notes=(f"bag of {parts} parts, joined in the order of {METADATA}", *first.notes),
        load=load,
        where=where,
        rows=sum(n for n in counts if n is not None) if None not in counts else None,
        findings=(*lost, *part_findings),
    )
