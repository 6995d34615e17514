"""Whole results in a table of their own, coefficients by label, and what tells a log and its options without reading it

Queries scanned the curves and contents of all runs, because they were columns of the tables of channels and runs.
"""

import hashlib
import json
import math
import struct
import zlib
from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"
branch_labels = None
depends_on = None

_BATCH = 500  # runs
_QUANTIFIED = ("adequate", "adequate_with", "widened")
_ROW = struct.Struct("<ii5d")  # label, fits, value, low, high, limit, level


def upgrade() -> None:
    _new_tables()
    op.execute("CREATE TABLE channel_1 AS SELECT * FROM channel")
    op.execute("CREATE TABLE coefficient_1 AS SELECT * FROM coefficient")
    op.execute("CREATE INDEX ix_channel_1 ON channel_1 (run_id, name)")
    op.drop_table("coefficient")
    op.drop_table("channel")
    _tables_anew()
    columns = "run_id, name, quantity, unit, rate, samples, verdict, trust, p_value"
    op.execute(f"INSERT INTO channel ({columns}) SELECT {columns} FROM channel_1")
    _coefficients()
    _results()
    op.drop_table("coefficient_1")
    op.drop_table("channel_1")
    op.drop_column("run", "content")


def _new_tables() -> None:
    op.create_table(
        "label",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("channel", sa.String(length=100), nullable=False),
        sa.Column("quantity", sa.String(length=60), nullable=False),
        sa.Column("term", sa.String(length=40), nullable=False),
        sa.Column("unit", sa.String(length=60), nullable=False),
        sa.Column("rate_unit", sa.String(length=60), nullable=False),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_label")),
        sa.UniqueConstraint(
            "channel",
            "quantity",
            "term",
            "unit",
            "rate_unit",
            name=op.f("uq_label_channel_quantity_term_unit_rate_unit"),
        ),
    )
    op.create_table(
        "result",
        sa.Column("run_id", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("content", sa.LargeBinary(), nullable=False),
        sa.Column("curves", sa.LargeBinary(), nullable=False),
        sa.Column("numbers", sa.LargeBinary(), nullable=False),
        sa.ForeignKeyConstraint(["run_id"], ["run.id"], name=op.f("fk_result_run_id_run"), ondelete="CASCADE"),
        sa.PrimaryKeyConstraint("run_id", name=op.f("pk_result")),
    )
    op.add_column("run", sa.Column("file_version", sa.String(length=200), nullable=False, server_default=""))
    op.add_column("run", sa.Column("options_key", sa.String(length=64), nullable=False, server_default=""))
    op.create_index(op.f("ix_run_options_key"), "run", ["options_key"])


def _tables_anew() -> None:
    op.create_table(
        "channel",
        sa.Column("run_id", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("name", sa.String(length=100), nullable=False),
        sa.Column("quantity", sa.String(length=60), nullable=False),
        sa.Column("unit", sa.String(length=60), nullable=False),
        sa.Column("rate", sa.Float(), nullable=False),
        sa.Column("samples", sa.BigInteger(), nullable=False),
        sa.Column("verdict", sa.String(length=20), nullable=False),
        sa.Column("trust", sa.String(length=20), nullable=False),
        sa.Column("p_value", sa.Float(), nullable=True),
        sa.ForeignKeyConstraint(["run_id"], ["run.id"], name=op.f("fk_channel_run_id_run"), ondelete="CASCADE"),
        sa.PrimaryKeyConstraint("run_id", "name", name=op.f("pk_channel")),
        sqlite_with_rowid=False,
    )
    op.create_table(
        "coefficient",
        sa.Column("run_id", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("label_id", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("observed", sa.Boolean(), nullable=True),
        sa.Column("value", sa.Float(), nullable=True),
        sa.Column("low", sa.Float(), nullable=True),
        sa.Column("high", sa.Float(), nullable=True),
        sa.Column("upper_limit", sa.Float(), nullable=True),
        sa.Column("level", sa.Float(), nullable=True),
        sa.ForeignKeyConstraint(["run_id"], ["run.id"], name=op.f("fk_coefficient_run_id_run"), ondelete="CASCADE"),
        sa.ForeignKeyConstraint(["label_id"], ["label.id"], name=op.f("fk_coefficient_label_id_label")),
        sa.PrimaryKeyConstraint("run_id", "label_id", name=op.f("pk_coefficient")),
        sqlite_with_rowid=False,
    )


def _coefficients() -> None:
    op.execute("""
        INSERT INTO label (channel, quantity, term, unit, rate_unit)
        SELECT DISTINCT c.channel, h.quantity, c.term, c.unit, h.unit
        FROM coefficient_1 c JOIN channel_1 h ON h.run_id = c.run_id AND h.name = c.channel
        UNION SELECT DISTINCT name, quantity, 'mean', unit, unit FROM channel_1 WHERE mean IS NOT NULL
    """)
    op.execute("""
        INSERT INTO coefficient (run_id, label_id, observed, value, low, high, upper_limit, level)
        SELECT c.run_id, l.id, c.observed, c.value, c.low, c.high, c.upper_limit, c.level
        FROM coefficient_1 c JOIN channel_1 h ON h.run_id = c.run_id AND h.name = c.channel
        JOIN label l ON l.channel = c.channel AND l.quantity = h.quantity AND l.term = c.term AND l.unit = c.unit
            AND l.rate_unit = h.unit
    """)
    op.execute("""
        INSERT INTO coefficient (run_id, label_id, value)
        SELECT h.run_id, l.id, h.mean FROM channel_1 h
        JOIN label l ON l.channel = h.name AND l.quantity = h.quantity AND l.term = 'mean' AND l.rate_unit = h.unit
        WHERE h.mean IS NOT NULL
    """)


def _results() -> None:
    connection = op.get_bind()
    last = -1
    while True:
        runs = connection.execute(
            sa.text("SELECT id, content FROM run WHERE id > :last ORDER BY id LIMIT :count"),
            {"last": last, "count": _BATCH},
        ).all()
        if not runs:
            return
        span = {"first": runs[0].id, "last": runs[-1].id}
        last = runs[-1].id
        curves = {}
        for run_id, name, raw in connection.execute(
            sa.text("SELECT run_id, name, curve FROM channel_1 WHERE run_id BETWEEN :first AND :last"), span
        ):
            curves[run_id, name] = bytes(raw)
        numbers: dict[int, list[bytes]] = {}
        for run_id, *row in connection.execute(_ROWS, span):
            numbers.setdefault(run_id, []).append(_number_row(*row))
        rows, keys = [], []
        for run_id, content in runs:
            told = _told(content)
            rows.append(
                {
                    "run_id": run_id,
                    "content": bytes(content),
                    "curves": b"".join(curves.get((run_id, name), b"") for name in told["channels"]),
                    "numbers": b"".join(numbers.get(run_id, ())),
                }
            )
            options = json.dumps(_with_floats(told.get("options", {})), sort_keys=True)
            keys.append({"run_id": run_id, "options": hashlib.sha256(options.encode()).hexdigest()})
        connection.execute(_INSERT, rows)
        connection.execute(sa.text("UPDATE run SET options_key = :options WHERE id = :run_id"), keys)


def _with_floats(options: object) -> object:
    """Options whose numbers are floats: 100 and 100.0 are the same."""
    if isinstance(options, dict):
        return {key: _with_floats(value) for key, value in options.items()}
    if isinstance(options, list):
        return [_with_floats(value) for value in options]
    return float(options) if isinstance(options, int) and not isinstance(options, bool) else options


def _told(content: bytes) -> dict[str, Any]:
    """What a result says; a damaged one stays as it is, and is reported when it is read."""
    try:
        told = json.loads(zlib.decompress(content))
    except (zlib.error, ValueError):
        told = {}
    return told if isinstance(told, dict) and isinstance(told.get("channels"), dict) else {"channels": {}}


_INSERT = sa.text("INSERT INTO result (run_id, content, curves, numbers) VALUES (:run_id, :content, :curves, :numbers)")
_ROWS = sa.text("""
    SELECT c.run_id, c.label_id, h.verdict, c.value, c.low, c.high, c.upper_limit, c.level
    FROM coefficient c JOIN label l ON l.id = c.label_id JOIN channel h ON h.run_id = c.run_id AND h.name = l.channel
    WHERE c.run_id BETWEEN :first AND :last ORDER BY c.run_id, c.label_id
""")


def _number_row(label: int, verdict: str, *values: float | None) -> bytes:
    return _ROW.pack(label, verdict in _QUANTIFIED, *(math.nan if x is None else x for x in values))
