"""Time that goes backwards because a log is damaged: then it is read up to there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from sigmatau.errors import DataError
from sigmatau.findings.finding import Finding
from sigmatau.io.read.columns import Choice
from sigmatau.io.read.table import REST_MISSING, Loaded, Table

__all__ = ["cut", "of_damaged"]


def cut(loaded: Loaded, choice: Choice, table: Table, error: DataError, *, least: int) -> Loaded:
    """The rows before time goes backwards, of a log with known damage; else `error`, with the damage that may be its cause.

    The last of those rows is left out as well: that or the next one has a stamp that is wrong.
    """
    known = (*table.findings, *loaded.findings)
    if choice.time is None or not any(finding.severity == "error" for finding in known):
        raise of_damaged(error, table, loaded.findings) from None
    stamps = loaded.columns[choice.time]
    back = np.flatnonzero(stamps[1:] < stamps[:-1])
    rows = len(stamps)
    kept = int(back[0]) if len(back) else rows
    if not least <= kept < rows:
        raise of_damaged(error, table, loaded.findings) from None
    finding = Finding(
        code="damaged",
        severity="error",
        message=f"time goes backwards after row {kept} (counted from 0) in a log that is damaged: {kept} of the {rows}"
        " rows that were found are used",
        effect=REST_MISSING,
    )
    columns = {index: array[:kept] for index, array in loaded.columns.items()}
    return replace(loaded, columns=columns, findings=(*loaded.findings, finding))


def of_damaged(error: DataError, table: Table, findings: Sequence[Finding]) -> DataError:
    """An error about stamps with the damage that may be its cause: what is known of it, or that nothing would show it."""
    if "time goes backwards" not in str(error) and "stamps" not in str(error):
        return error
    lost = [finding.message for finding in (*table.findings, *findings) if finding.severity == "error"]
    if lost:
        error.args = (f"{error}. The log is damaged: {lost[0]}",)
    elif any("without checksum" in note for note in table.notes):
        error.args = (f"{error}. Or the log is damaged there, which it has no checksums to show",)
    return error
