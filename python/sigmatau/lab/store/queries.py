"""Queries of a store: units, runs, coefficients and findings as rows."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from sqlalchemy import ColumnElement, Select, and_, case, func, select

from sigmatau.lab.store import tables
from sigmatau.lab.store.choosing import Chosen, conditions
from sigmatau.lab.store.tables import finding, model, run, unit


def units(chosen: Chosen | None) -> Select[Any]:
    """One row per unit."""

    def count(state: str) -> ColumnElement[int]:
        return func.sum(case((run.c.state == state, 1), else_=0)).label(state)

    return (
        select(
            unit.c.name.label("unit"), model.c.name.label("model"), func.count().label("runs"),
            *(count(state) for state in ("fitted", "not_fitted", "not_at_rest", "too_short_to_tell", "failed")),
            func.min(run.c.recorded).label("first"), func.max(run.c.recorded).label("last"),
        )
        .join_from(unit, run).outerjoin(model, unit.c.model_id == model.c.id)
        .where(*conditions(chosen)).group_by(unit.c.name, model.c.name).order_by(unit.c.name)
    )  # fmt: skip


def runs(chosen: Chosen | None) -> Select[Any]:
    """One row per run."""
    return (
        select(
            run.c.id, unit.c.name.label("unit"), model.c.name.label("model"), run.c.name.label("run"),
            run.c.recorded, run.c.temperature, run.c.supply, run.c.duration, run.c.state, run.c.revision,
            run.c.has_curves, run.c.version, run.c["message"],
        )
        .join_from(run, unit).outerjoin(model, unit.c.model_id == model.c.id)
        .where(*conditions(chosen)).order_by(unit.c.name, run.c.recorded, run.c.id)
    )  # fmt: skip


def in_order(chosen: Chosen | None) -> Select[Any]:
    """Key, unit and time of runs in the order of their records. A run without a time has the time at which it was added."""
    time = func.coalesce(run.c.recorded, run.c.added)
    return (
        select(run.c.id, unit.c.name, time).join_from(run, unit).outerjoin(model, unit.c.model_id == model.c.id)
        .where(*conditions(chosen)).order_by(time, run.c.id)
    )  # fmt: skip


def coefficients(chosen: Chosen | None, *, term: str | None, channels: Sequence[str]) -> Select[Any]:
    """One row per run, channel and term."""
    coefficient, label, channel = tables.coefficient.c, tables.label.c, tables.channel.c
    query = (
        select(
            unit.c.name.label("unit"), model.c.name.label("model"), run.c.name.label("run"), run.c.recorded,
            run.c.temperature, run.c.supply, label.channel, label.quantity, label.term, coefficient.observed,
            coefficient.value, coefficient.low, coefficient.high, coefficient.upper_limit, coefficient.level,
            label.unit.label("si"), label.rate_unit, channel.verdict, channel.trust,
        )
        .join_from(tables.coefficient, tables.label)
        .join(tables.channel, and_(channel.run_id == coefficient.run_id, channel.name == label.channel))
        .join(run, coefficient.run_id == run.c.id)
        .join(unit, run.c.unit_id == unit.c.id)
        .outerjoin(model, unit.c.model_id == model.c.id)
        .where(*conditions(chosen))
        .order_by(unit.c.name, run.c.recorded, run.c.id, label.channel, label.id)
    )  # fmt: skip
    if term is not None:
        query = query.where(label.term == term)
    return query.where(label.channel.in_(channels)) if channels else query


def findings(run_id: int) -> Select[Any]:
    """Severity and message of the findings of a run."""
    return select(finding.c.severity, finding.c["message"]).where(finding.c.run_id == run_id).order_by(finding.c.id)


def versions(options_key: str) -> Select[Any]:
    """Path and version of the file, for each log with a current result of these options."""
    return (
        select(run.c.path, run.c.file_version).where(run.c.current, run.c.options_key == options_key).order_by(run.c.id)
    )
