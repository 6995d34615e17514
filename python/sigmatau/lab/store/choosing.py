"""Selection of runs in a store, and tables of rows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import datetime
from typing import TYPE_CHECKING, Any

from sigmatau.frozen import frozen
from sigmatau.lab.store.rows import in_utc
from sigmatau.lab.store.text import cell
from sigmatau.results import Tabular, aligned, lines_text

if TYPE_CHECKING:
    from sqlalchemy import ColumnElement


@frozen
class Chosen:
    """Selection of current runs by unit, sensor model, state, time, temperature or supply voltage.

    Attributes
    ----------
    units : tuple of str
        Names of units; a ``*`` in a name matches any text. Default: all units.
    model : str or None
        Sensor model.
    states : tuple of {"fitted", "not_fitted", "not_at_rest", "too_short_to_tell", "failed"}
        Default: all states.
    since, until : datetime or None
        Range of the beginning of the record, UTC; `until` is excluded.
    temperature : tuple of float or None
        Lowest and highest temperature. [degC] Runs without a temperature are then excluded.
    supply : tuple of float or None
        Lowest and highest supply voltage. [V] Runs without one are then excluded.
    pattern : bool
        Whether ``*`` in the name of a unit matches any text.
    history : bool
        Whether replaced results are included too.

    See Also
    --------
    sigmatau.Store : its methods have it as an argument.
    """

    units: tuple[str, ...] = ()
    model: str | None = None
    states: tuple[str, ...] = ()
    since: datetime | None = None
    until: datetime | None = None
    temperature: tuple[float, float] | None = None
    supply: tuple[float, float] | None = None
    pattern: bool = True
    history: bool = False


@frozen(kw_only=False)
class StoreTable(Tabular):
    """Rows of a store.

    Attributes
    ----------
    content : mapping of str to list
        Values by column.
    """

    content: Mapping[str, list[Any]]

    def columns(self) -> dict[str, list[Any]]:
        """The table by column; see `Tabular.columns`."""
        return dict(self.content)

    def __len__(self) -> int:
        return len(next(iter(self.content.values()), ()))

    def to_dict(self) -> dict[str, Any]:
        """Values by column; times as ISO 8601 in UTC."""
        return {
            key: [f"{x.isoformat()}Z" if isinstance(x, datetime) else x for x in column]
            for key, column in self.content.items()
        }

    def shown(self, names: Sequence[str]) -> StoreTable:
        """Select columns.

        Parameters
        ----------
        names : sequence of str
            Names of the columns, in the order to show.

        Returns
        -------
        StoreTable
        """
        return StoreTable({name: self.content[name] for name in names})

    def __repr__(self) -> str:
        rows = zip(*self.content.values(), strict=True)
        return lines_text(aligned([tuple(self.content), *(tuple(map(cell, row)) for row in rows)]))


def conditions(chosen: Chosen | None) -> list[ColumnElement[bool]]:
    """Build the selection in SQL, for a query of runs with their units and sensor models."""
    from sqlalchemy import or_

    from sigmatau.lab.store.tables import model, run, unit

    choice = chosen or Chosen()
    clauses: list[ColumnElement[bool]] = [] if choice.history else [run.c.current]
    if choice.units:
        units = [choice.units] if isinstance(choice.units, str) else choice.units
        exact = [name for name in units if "*" not in name or not choice.pattern]
        patterns = (unit.c.name.like(_like(name), escape="\\") for name in units if name not in exact)
        clauses.append(or_(unit.c.name.in_(exact), *patterns))
    if choice.model is not None:
        clauses.append(model.c.name == choice.model)
    if choice.states:
        clauses.append(run.c.state.in_(choice.states))
    if choice.since is not None:
        clauses.append(run.c.recorded >= in_utc(choice.since))
    if choice.until is not None:
        clauses.append(run.c.recorded < in_utc(choice.until))
    if choice.temperature is not None:
        clauses.append(run.c.temperature.between(*choice.temperature))
    if choice.supply is not None:
        clauses.append(run.c.supply.between(*choice.supply))
    return clauses


def _like(name: str) -> str:
    for special in ("\\", "%", "_"):
        name = name.replace(special, "\\" + special)
    return name.replace("*", "%")
