"""Updates a store of the previous version of the tables when it is opened."""

from __future__ import annotations

import zlib
from typing import TYPE_CHECKING, Any

from sigmatau.analysis import BriefResultForm, FailedAnalysis, result_of_dict
from sigmatau.errors import DataError
from sigmatau.lab.lots.conditions import run_supply, run_temperature
from sigmatau.lab.store.packing import READ, loads

if TYPE_CHECKING:
    from sqlalchemy.engine import Connection

PREVIOUS = "0003"
"""Version of the tables that `update_tables` updates."""

_COLUMNS = {"supply": "FLOAT", "has_curves": "BOOLEAN"}  # of `run`, that version 0004 added


def update_tables(connection: Connection) -> None:
    """Add the table and the columns of version 0004, filled from the results, in the transaction of the connection."""
    from sqlalchemy import func, insert, select, update

    from sigmatau.lab.store.tables import VERSION, place, result, run, version

    place.create(connection)
    for name, kind in _COLUMNS.items():
        connection.exec_driver_sql(f"ALTER TABLE run ADD COLUMN {name} {kind}")
    keys = list(connection.scalars(select(run.c.id).order_by(run.c.id)))
    for start in range(0, len(keys), READ):
        chosen = result.c.run_id.in_(keys[start : start + READ])
        query = select(run.c.id, run.c.temperature, result.c.content, func.length(result.c.curves))
        for key, temperature, content, size in connection.execute(query.join(result).where(chosen)).all():
            degrees, supply = _conditions(content)
            values = {"supply": supply, "has_curves": True if size else None}
            if temperature is None:
                values["temperature"] = degrees
            connection.execute(update(run).where(run.c.id == key).values(values))
    connection.execute(version.delete())
    connection.execute(insert(version).values(version_num=VERSION))


def _conditions(content: bytes) -> tuple[float | None, float | None]:
    """Temperature and supply voltage of a result; None if it is damaged, has failed, or does not show them."""
    try:
        form: dict[str, Any] = loads(zlib.decompress(content))
        for channel in form["channels"].values():
            channel["curve"] = channel["curve"]["rest"]
        analysis = result_of_dict(form, as_form=BriefResultForm)
    except (DataError, zlib.error, ValueError, KeyError, TypeError, AttributeError):
        return None, None
    return (None, None) if isinstance(analysis, FailedAnalysis) else (run_temperature(analysis), run_supply(analysis))
