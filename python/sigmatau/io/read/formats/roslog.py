"""MCAP files and ROS 1 bags. Each file contains the definitions of its messages; compiled code decodes them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from sigmatau._native import logs
from sigmatau.errors import DataError
from sigmatau.findings.finding import Finding
from sigmatau.findings.reading import Damaged, Place
from sigmatau.io.read.formats.damage import largest_expansion, refuse_expansion, trailing_bytes
from sigmatau.io.read.formats.messages import MessageLayout, find_columns
from sigmatau.io.read.table import Column, Head, Loaded, Table

_IS_ROS1 = {("cdr", "ros2msg"): False, ("cdr", "ros1msg"): False, ("ros1", "ros1msg"): True}

_NOT_READ = "not read: "


def read(path: Path, head: Head) -> tuple[Table, ...]:
    """Read a table for each topic, and for each message type if a topic has several. Columns are named by the path of a
    field; times are in nanoseconds.
    """
    kind: logs.LogKind = "mcap" if head.data.startswith(b"\x89MCAP") else "rosbag1"
    contents = logs.log_contents(str(path), kind, max_bytes=largest_expansion(path.stat().st_size))
    end = _refuse_expanded(path, contents.end)
    where = f"{end.what} (byte {end.offset})"
    if not contents.channels:
        if end.kind:
            raise DataError(f"{where}: no topic could be read; copy or record the file again")
        raise DataError("has no topics")
    groups: dict[tuple[str, str, str, str, bytes], list[logs.LogChannel]] = {}
    for channel in contents.channels:
        key = (
            channel.topic,
            channel.type_name,
            channel.message_encoding,
            channel.definition_encoding,
            channel.definition,
        )
        groups.setdefault(key, []).append(channel)
    tables = []
    for (topic, type_name, encoding, written, definition), channels in groups.items():
        several = sum(each[0] == topic for each in groups) > 1
        name = f"{topic} ({type_name})" if several else topic
        rows = sum(channel.messages for channel in channels)
        if (encoding, written) not in _IS_ROS1:
            why = f"{type_name or 'messages'} in {encoding or 'an unnamed encoding'}" + (
                f" defined by {written}" if written else " without a definition"
            )
            tables.append(refused_table(kind, name, f"{why}, which are not read", rows))
            continue
        text, ros1 = definition.decode(errors="replace"), _IS_ROS1[encoding, written]
        declared, ids = rows if contents.declared else None, [c.id for c in channels]
        load = partial(_load, path, kind, name, ids, not ros1, declared)
        tables.append(message_table(kind, name, type_name, text, load, rows, ros1=ros1))
    return some_readable(tables)


def some_readable(tables: Sequence[Table]) -> tuple[Table, ...]:
    """Return the tables. Raises a `DataError` with the reasons if none of them can be read."""
    if all(table.columns[0].name.startswith(_NOT_READ) for table in tables):
        listed = "; ".join(f"{t.topic} ({t.columns[0].name.removeprefix(_NOT_READ)})" for t in tables[:3])
        raise DataError(f"has no topic that can be read: {listed}{' …' if len(tables) > 3 else ''}")
    return tuple(tables)


def message_table(
    kind: str,
    topic: str,
    type_name: str,
    definition: str,
    load: Callable[[MessageLayout, Sequence[int], int | None], Loaded],
    rows: int | None,
    *,
    ros1: bool = False,
) -> Table:
    """Build the table of a topic from the definition of its messages."""
    try:
        layout = find_columns(definition, type_name, ros1=ros1)
    except DataError as error:
        return refused_table(kind, topic, str(error), rows)
    return Table(
        format=kind,
        columns=layout.columns,
        notes=(f"messages {type_name} of {topic}",),
        load=partial(load, layout),
        where=lambda row: f"message {row} (counted from 0) of {topic}",
        topic=topic,
        rows=rows,
    )


def refused_table(kind: str, topic: str, why: str, rows: int | None) -> Table:
    """Build a table for a topic that cannot be read. The name of its only column states the reason."""

    def load(wanted: Sequence[int], exact: int | None) -> Loaded:
        raise DataError(f"topic {topic} cannot be read: {why}")

    return Table(
        format=kind, columns=(Column(name=f"{_NOT_READ}{why}"),), notes=(), load=load, where=str, topic=topic, rows=rows
    )


def end_findings(path: Path, end: logs.LogEnd, topic: str, rows: int, declared: int | None) -> tuple[Finding, ...]:
    """Findings about how a file ends, and about missing messages."""
    if end.kind in ("filler", "behind"):
        return trailing_bytes(path, end.offset, "the log")
    if not end.kind and declared in (None, rows):
        return ()
    details = Damaged(
        truncated=end.kind in ("broken_off", "no_end"),
        place=Place("byte", end.offset) if end.kind else None,
        reason=end.what,
        kept=rows,
        declared=declared,
        counted="messages",
        topic=topic,
    )
    return (Finding(details=details, severity="warning" if end.kind == "no_end" else "error"),)


def _refuse_expanded(path: Path, end: logs.LogEnd) -> logs.LogEnd:
    """Return the end. Raises `DataError` if unpacking the chunks would exceed the allowed size."""
    if end.kind == "expanded":
        refuse_expansion(path.stat().st_size, None)
    return end


def _load(
    path: Path,
    kind: logs.LogKind,
    topic: str,
    ids: Sequence[int],
    cdr: bool,  # noqa: FBT001  bound before the others
    declared: int | None,
    layout: MessageLayout,
    wanted: Sequence[int],
    exact: int | None,
) -> Loaded:
    """Load the columns of a topic."""
    largest = largest_expansion(path.stat().st_size)
    decoded, end = logs.log_messages(
        str(path), kind, ids, steps=layout.steps, cdr=cdr, wanted=wanted, exact=exact, max_bytes=largest
    )
    _refuse_expanded(path, end)
    if not decoded.rows and end.kind:
        raise DataError(
            f"{end.what} (byte {end.offset}): no message of {topic} could be read; copy or record the file again"
        )
    return Loaded(columns=dict(decoded.columns), findings=end_findings(path, end, topic, decoded.rows, declared))
