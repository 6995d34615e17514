"""A run is told from others by its unit, its log and its options, not by the words in which its conversions were described

Versions of the program worded the conversions differently, so that the same log with the same options was two runs: these
become revisions of one.
"""

import hashlib
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"
branch_labels = None
depends_on = None

_BATCH = 10_000  # runs

_UNIT = sa.table("unit", sa.column("id", sa.Integer), sa.column("name", sa.String))
_RUN = sa.table(
    "run",
    *(sa.column(name, sa.Integer) for name in ("id", "unit_id", "revision")),
    *(sa.column(name, sa.String) for name in ("identity", "name", "path", "sha256", "digest", "options_key")),
    sa.column("recorded", sa.DateTime),
    sa.column("current", sa.Boolean),
)


def upgrade() -> None:
    connection = op.get_bind()
    revisions: Counter[str] = Counter()
    latest: dict[str, int] = {}
    replaced = []
    update = (
        sa.update(_RUN)
        .where(_RUN.c.id == sa.bindparam("key"))
        .values(identity=sa.bindparam("as_identity"), revision=sa.bindparam("as_revision"))
    )
    for runs in _batches(connection):
        changes = []
        for run in runs:
            identity = _identity(run)
            revisions[identity] += 1
            changes.append({"key": run["id"], "as_identity": identity, "as_revision": revisions[identity]})
            if run["current"]:
                if identity in latest:
                    replaced.append({"key": latest[identity]})
                latest[identity] = run["id"]
        connection.execute(update, changes)
    if replaced:
        connection.execute(sa.update(_RUN).where(_RUN.c.id == sa.bindparam("key")).values(current=False), replaced)


def _batches(connection: sa.Connection) -> Iterator[Sequence[Any]]:
    """The runs in the order in which they were added."""
    last = -1
    columns = sa.select(_RUN, _UNIT.c.name.label("unit")).join(_UNIT, _UNIT.c.id == _RUN.c.unit_id)
    while (
        rows := connection.execute(columns.where(_RUN.c.id > last).order_by(_RUN.c.id).limit(_BATCH)).mappings().all()
    ):
        last = rows[-1]["id"]
        yield rows


def _identity(run: Mapping[str, Any]) -> str:
    """As version 0003 of `sigmatau.lab.store.rows.identity` has it."""
    of_memory = f"{run['unit']}/{run['name']}/{run['recorded']}/{run['digest']}"
    log = run["sha256"] or (f"{run['unit']}/{run['path']}" if run["path"] else of_memory)
    text = f"{run['unit']}\n{log}\n{run['options_key']}"
    return hashlib.sha256(text.encode("utf-8", "backslashreplace")).hexdigest()
