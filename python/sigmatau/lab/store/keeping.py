"""Curves of a result in a store: which results keep the points of their Allan deviations."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from sqlalchemy import ColumnElement

    from sigmatau.lab.store.rows import Rows

KeepCurves = Literal["failed", "all", "none"]
"""Results that keep their curves: all, none, or those that need a look, see `needs_look`."""


def with_chosen_curves(rows: Rows, keep: KeepCurves) -> Rows:
    """Remove the points of the curves, unless this result keeps them. Its checksum remains that of the whole result."""
    if keep == "all" or not rows.packed.curves or (keep == "failed" and needs_look(rows)):
        return rows
    return replace(rows, run={**rows.run, "has_curves": False}, packed=replace(rows.packed, curves=b""))


def needs_look(rows: Rows) -> bool:
    """Whether a result has no fit, a finding that is an error, or a fit whose trust is not good."""
    return (
        rows.run["state"] != "fitted"
        or any(severity == "error" for _, severity, *_ in rows.findings)
        or any(verdict and trust != "good" for *_, verdict, trust, _ in rows.channels)
    )


def lacks_curves(keep: KeepCurves) -> ColumnElement[bool]:
    """Condition in SQL: a run is stored without the curves that it keeps now. `needs_look` is the same for a result."""
    from sqlalchemy import and_, exists, false, or_

    from sigmatau.lab.store.tables import channel, finding, run

    if keep == "none":
        return false()
    without = run.c.has_curves.is_(False)
    if keep == "all":
        return without
    error = exists().where(finding.c.run_id == run.c.id, finding.c.severity == "error")
    doubtful = exists().where(channel.c.run_id == run.c.id, channel.c.verdict != "", channel.c.trust != "good")
    return and_(without, or_(run.c.state != "fitted", error, doubtful))
