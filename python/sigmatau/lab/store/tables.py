"""The tables of a store.

A change needs a new `VERSION`, and code in `migrating` that updates a store of the previous version when it is opened; a
test opens stores of both versions.
"""

from __future__ import annotations

try:
    from sqlalchemy import (
        BigInteger,
        Boolean,
        Column,
        DateTime,
        Float,
        ForeignKey,
        Index,
        Integer,
        LargeBinary,
        MetaData,
        String,
        Table,
        Text,
        UniqueConstraint,
    )
except ImportError:
    raise ImportError("a store needs SQLAlchemy and orjson: pip install 'sigmatau[store]'") from None

metadata: MetaData = MetaData(
    naming_convention={
        "ix": "ix_%(table_name)s_%(column_0_N_name)s",
        "uq": "uq_%(table_name)s_%(column_0_N_name)s",
        "fk": "fk_%(table_name)s_%(column_0_N_name)s_%(referred_table_name)s",
        "pk": "pk_%(table_name)s",
    }
)


VERSION = "0004"
"""Version of the tables below."""

version: Table = Table("alembic_version", metadata, Column("version_num", String(32), primary_key=True))


def _key() -> Column[int]:
    return Column("id", Integer, primary_key=True)


def _reference_to(table: str, *, nullable: bool = False) -> Column[int]:
    return Column(f"{table}_id", ForeignKey(f"{table}.id", ondelete="CASCADE"), nullable=nullable)


model: Table = Table("model", metadata, _key(), Column("name", String(200), nullable=False, unique=True))
"""Types of sensors."""

unit: Table = Table(
    "unit",
    metadata,
    _key(),
    Column("name", String(400), nullable=False, unique=True),  # serial number
    _reference_to("model", nullable=True),
)

run: Table = Table(
    "run",
    metadata,
    _key(),
    _reference_to("unit"),
    Column("name", String(400), nullable=False),  # name of the log
    Column("path", Text, nullable=False),  # log as it was given
    Column("identity", String(64), nullable=False),  # checksum of log and options, equal for the same run
    Column("revision", Integer, nullable=False),  # 1 for the first result of this identity
    Column("current", Boolean, nullable=False),  # whether no later result replaces it
    Column("sha256", String(64)),  # checksum of the log; NULL if it could not be read
    Column("recorded", DateTime),  # UTC; NULL if neither the log nor the user states it
    Column("temperature", Float),  # as stated by the user, or else by the thermometer of the log [degC]
    Column("duration", Float),  # length of the longest channel [s]
    Column("state", String(20), nullable=False),  # fitted, not_fitted, not_at_rest, too_short_to_tell, failed
    Column("message", Text, nullable=False),  # reason of a failure
    Column("version", String(40), nullable=False),  # version of sigmatau
    Column("added", DateTime, nullable=False),  # UTC
    Column("digest", String(64), nullable=False),  # checksum of the result without the version of the program
    Column("file_version", String(200), nullable=False),  # time of the log in the file system or object store, or empty
    Column(
        "options_key", String(64), nullable=False
    ),  # checksum of the options, see `sigmatau.lab.store.rows.options_key`
    Column("supply", Float),  # supply voltage, as stated by the user, a channel or the name of the log [V]
    Column("has_curves", Boolean),  # whether the points of the curves are stored; NULL without a curve
    UniqueConstraint("identity", "revision"),
    Index(None, "unit_id", "current"),
    Index(None, "recorded"),
    Index(None, "options_key"),
)

place: Table = Table(
    "place",
    metadata,
    Column("run_id", ForeignKey("run.id", ondelete="CASCADE"), primary_key=True, autoincrement=False),
    Column("path", Text, primary_key=True),  # of a copy of the log, or where the log was before
    Column("file_version", String(200), nullable=False),  # as in `run`
)
"""Further places of the logs of runs. A fleet does not analyse a copy again."""

result: Table = Table(
    "result",
    metadata,
    Column("run_id", ForeignKey("run.id", ondelete="CASCADE"), primary_key=True, autoincrement=False),
    Column("content", LargeBinary, nullable=False),  # the result without curves, JSON, compressed by zlib
    Column("curves", LargeBinary, nullable=False),  # see `sigmatau.lab.store.packing`
    Column("numbers", LargeBinary, nullable=False),  # the rows of `coefficient` as one array, see `packing.NUMBERS`
)
"""Whole results, separate from the tables that queries scan."""

channel: Table = Table(
    "channel",
    metadata,
    Column("run_id", ForeignKey("run.id", ondelete="CASCADE"), primary_key=True, autoincrement=False),
    Column("name", String(100), primary_key=True),
    Column("quantity", String(60), nullable=False),
    Column("unit", String(60), nullable=False),  # unit of the rate, SI
    Column("rate", Float, nullable=False),  # [Hz]
    Column("samples", BigInteger, nullable=False),
    Column("verdict", String(20), nullable=False),  # verdict of the fit; empty without a fit
    Column("trust", String(20), nullable=False),
    Column("p_value", Float),
    sqlite_with_rowid=False,
)

label: Table = Table(
    "label",
    metadata,
    _key(),
    Column("channel", String(100), nullable=False),
    Column("quantity", String(60), nullable=False),
    Column("term", String(40), nullable=False),  # key of `sigmatau.noise.terms.TERMS`, or mean
    Column("unit", String(60), nullable=False),  # unit of the coefficient, SI
    Column("rate_unit", String(60), nullable=False),  # unit of the channel, SI
    UniqueConstraint("channel", "quantity", "term", "unit", "rate_unit"),
)
"""Channel, term and units of a coefficient. A store has few labels, which the coefficients of all runs share."""

coefficient: Table = Table(
    "coefficient",
    metadata,
    Column("run_id", ForeignKey("run.id", ondelete="CASCADE"), primary_key=True, autoincrement=False),
    Column("label_id", ForeignKey("label.id"), primary_key=True, autoincrement=False),
    Column("observed", Boolean),  # NULL if it was not tested
    Column("value", Float),  # SI
    Column("low", Float),
    Column("high", Float),
    Column("upper_limit", Float),
    Column("level", Float),  # level of the interval or limit; NULL without them
    sqlite_with_rowid=False,
)

finding: Table = Table(
    "finding",
    metadata,
    _key(),
    Column("run_id", ForeignKey("run.id", ondelete="CASCADE"), nullable=False, index=True),
    Column("code", String(60), nullable=False, index=True),
    Column("severity", String(10), nullable=False),
    Column("channels", Text, nullable=False),  # separated by spaces; empty for the whole record
    Column("message", Text, nullable=False),
)
