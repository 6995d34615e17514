"""Damaged logs in which time goes backwards: they are read up to that row."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from sigmatau.errors import DataError, StampError
from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.reading import Damaged, Place
from sigmatau.findings.wording import sentence
from sigmatau.io.read.columns import Choice
from sigmatau.io.read.table import Loaded, Table

__all__ = ["cut", "with_damage"]


def cut(loaded: Loaded, choice: Choice, table: Table, error: DataError, *, least: int) -> Loaded:
    """The rows of a damaged log before time goes backwards; raises `error`, with known damage, for other logs.

    The last of these rows is left out as well: either it or the next row has a wrong stamp.
    """
    known = (*table.findings, *loaded.findings)
    if choice.time is None or not any(finding.severity == "error" for finding in known):
        raise with_damage(error, table, loaded.findings) from None
    stamps = loaded.columns[choice.time]
    back = np.flatnonzero(stamps[1:] < stamps[:-1])
    rows = len(stamps)
    kept = int(back[0]) if len(back) else rows
    if not least <= kept < rows:
        raise with_damage(error, table, loaded.findings) from None
    damaged = Damaged(place=Place("row", kept), reason="time goes backwards", kept=kept, declared=rows)
    finding = Finding(details=damaged, severity="error")
    columns = {index: array[:kept] for index, array in loaded.columns.items()}
    return replace(loaded, columns=columns, findings=(*loaded.findings, finding))


def with_damage(error: DataError, table: Table, findings: Sequence[Finding]) -> DataError:
    """An error about stamps with the damage that may have caused it, or that the log has no checksums to show damage."""
    if not isinstance(error, StampError):
        return error
    damage = [sentence(finding) for finding in (*table.findings, *findings) if finding.severity == "error"]
    if damage:
        return StampError(f"{error}. The log is damaged: {damage[0]}")
    if any("without checksum" in note for note in table.notes):
        return StampError(f"{error}. Or the log is damaged there; it has no checksums that would show it")
    return error
