"""Words of findings about files and live lines: damage, leftovers, columns, units."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds import reading as kinds
from sigmatau.findings.wording.phrases import Words
from sigmatau.units import needs_scale

_AGAIN = "Copy or record the file again"
_LONGEST = 120  # of a message [characters]
_REASON = 60  # longest reason of a missing part [characters]


def _short(text: str, longest: int = _REASON) -> str:
    return text if len(text) <= longest else f"{text[: longest - 1]}…"


def _number(count: int, noun: str) -> str:
    return f"{count} {noun if count != 1 else noun.removesuffix('s')}"


def _at(place: kinds.Place | None) -> str:
    if place is None:
        return ""
    of = "" if place.of is None else f" of {place.of}"
    byte = "" if place.byte is None else f" (byte {place.byte})"
    return f" {'at' if place.unit == 'byte' else 'in'} {place.unit} {place.number}{of}{byte}"


def _kept(kept: int | None, declared: int | None, counted: str, topic: str, *, every: bool = False) -> str:
    if kept is None:
        return ""
    number = _number(kept, counted) if declared is None else f"{kept} of {declared} {counted}"
    return f"{'all ' if every else ''}{number}{f' of {topic}' if topic else ''} read"


def _damaged(finding: Finding, it: kinds.Damaged) -> Words:
    inside = ""
    if it.inside and (it.place is None or it.place.unit != it.inside):
        inside = f" inside its last {it.inside}" if it.place is None else f", inside a {it.inside}"
    complete = finding.severity == "warning" and it.declared in (None, it.kept)
    kept = _kept(it.kept, None if complete else it.declared, it.counted, it.topic, every=complete)
    subject = f"the {it.what} is {'truncated' if it.truncated else 'damaged'}{_at(it.place)}{inside}"
    left = _LONGEST - sum(len(text) + 2 for text in (it.part, subject, kept))
    reason = _short(it.reason, max(left, 20))
    message = f"{subject}: {reason}" if reason else subject
    if complete:
        action = ""
    elif it.inside == "row":
        action = "Copy the whole file, or correct --layout"
    else:
        action = _AGAIN
    return Words("; ".join(filter(None, (message, kept))), action)


def _part_missing(finding: Finding, it: kinds.PartMissing) -> Words:
    part = f"part {it.number} of {it.of}"
    if it.alone:
        return Words(f"the file is {part} of a recording", "Give the folder instead of the file to read all parts")
    return Words(f"{part} {f'cannot be read ({_short(it.reason)})' if it.reason else 'is missing'}", _AGAIN)


def _skipped_messages(finding: Finding, it: kinds.SkippedMessages) -> Words:
    lost, example = finding.severity == "error", _short(it.example, 40)
    where = f",{' the first' if it.count > 1 else ''}{_at(it.place)}" if it.place else ""
    kept = "" if it.kept is None else f"; {it.kept} read"
    if it.other:
        such = f", such as {example}," if example else ""
        action = "No action needed if a newer program wrote them; otherwise the file is damaged"
        if lost:
            action = "Split the log where the sensor was switched: rows are missing there"
        message = f"{_number(it.count, it.unit)} of other types{such} skipped{where}{kept}"
        return Words(message, "" if finding.severity == "info" else action)
    what = f" ({example})" if example else ""
    action = "Check the logger and its connection" if finding.severity == "warning" else ""
    return Words(
        f"{_number(it.count, f'damaged {it.unit}')} skipped{where}{what}{kept}",
        "Copy the log again: rows are missing, and the times after them may be too early" if lost else action,
    )


def _bytes_not_read(finding: Finding, it: kinds.BytesNotRead) -> Words:
    where = f"after {it.after}{_at(it.place)}" if it.after else "before the data"
    if it.padding:
        return Words(f"{_number(it.bytes, 'bytes')} {where} are padding")
    return Words(f"{_number(it.bytes, 'bytes')} {where} not read", "Split the file there if another log was appended")


def _missing_chunks(finding: Finding, it: kinds.MissingChunks) -> Words:
    what = f"{_number(it.count, 'chunks')} of {it.of} of array {it.array} not stored"
    return Words(f"{what}, the first at row {it.first}; samples missing", _AGAIN)


def _skipped_lines(finding: Finding, it: kinds.SkippedLines) -> Words:
    if it.what == "last":
        return Words("the last line has no line end, so its last number may be truncated; line skipped")
    if it.what == "header":
        return Words(
            f"line {it.line} is a header with other columns; {_number(it.kept or 0, 'rows')} before it are read, rows after"
            " it are not",
            "Split the file there: it holds several logs",
        )
    what = f"line {it.line} is a comment that looks like a data row"
    if it.count > 1:
        what = f"{it.count} comment lines look like data rows, the first line {it.line}"
    return Words(f"{what}; skipped", "Remove the comment marks if these lines are data; otherwise delete the lines")


def _never_written(finding: Finding, it: kinds.NeverWritten) -> Words:
    what = f"column {it.column} is" if it.column else "all columns are"
    return Words(
        f"{what} exactly 0 in the last {it.zeros} of {it.rows} rows, which were never written; {it.kept} rows read",
        _AGAIN,
    )


def _columns_by_gravity(finding: Finding, it: kinds.ColumnsByGravity) -> Words:
    time = "" if it.time is None else f"time={it.time},"
    gyro, accel = f"{it.gyro[0]}:{it.gyro[1]}", f"{it.accel[0]}:{it.accel[1]}"
    return Words(
        f"columns have no names: {accel} read as accel (mean {it.gravity:.3g}, gravity), {gyro} as gyro"
        f" (mean {it.other:.2g})",
        f"Run with --channels {time}gyro={gyro},accel={accel} to confirm, or name other columns",
    )


def _gravity_on_gyro(finding: Finding, it: kinds.GravityOnGyro) -> Words:
    return Words(
        f"gravity is on the columns of the gyro (mean {it.gyro:.3g}), not on those of the accelerometer ({it.accel:.2g})",
        "Exchange the sensors in --channels",
    )


def _unusable(finding: Finding, it: kinds.Unusable) -> Words:
    return Words(it.reason)


def _dropouts(finding: Finding, it: kinds.LoggerDropouts) -> Words:
    return Words(
        f"the logger lost data {_number(it.count, 'times')}, {it.total:.3g} s in total, the longest loss {it.longest:.3g} s",
        "Log to a faster card, log fewer topics, or select a part without dropouts with --window",
    )


def _unit_overruled(finding: Finding, it: kinds.UnitOverruled) -> Words:
    stated = it.stated if it.known else f"{_short(it.stated, 20)!r}, which is not a unit of this quantity"
    advice = "Give --scale: volts and counts have no size" if needs_scale(it.stated) else "Check the unit of the file"
    return Words(
        f"the file states {stated}; the given unit {it.given} is used", "" if it.known or it.scaled else advice
    )


_NAMES_LISTED = 6
_NAME = 24  # longest name in a list [characters]


def _listed(names: tuple[str, ...]) -> str:
    shown = ", ".join(_short(name, _NAME) for name in names[:_NAMES_LISTED])
    while len(shown) > _LONGEST - 40 and "," in shown:
        shown = shown.rpartition(", ")[0]
    rest = len(names) - shown.count(", ") - 1
    return f"{shown} and {rest} more" if rest > 0 else shown


def _incomplete_sensor(finding: Finding, it: kinds.IncompleteSensor) -> Words:
    if not it.column:
        return Words(f"{it.missing} is missing; no other column has a similar name", "Check the names of the columns")
    column = _short(it.column, _NAME)
    return Words(
        f"{it.missing} is missing; column {it.number} {column!r} has a similar name and is not used",
        f"Correct the name of the column, or name all columns: --channels {it.missing}={it.number},…",
    )


def _unused_columns(finding: Finding, it: kinds.UnusedColumns) -> Words:
    return Words(f"{_number(len(it.columns), 'columns')} not used: {_listed(it.columns)}")


def _unread_sensor(finding: Finding, it: kinds.UnreadSensor) -> Words:
    what = {"gyro": "a gyro", "accel": "an accelerometer"}[it.sensor]
    first, last = it.numbers[0], it.numbers[-1]
    places = f"{first}:{last}" if it.numbers == (first, first + 1, first + 2) else "N:N"
    return Words(
        f"columns of {what} are not read, their names are not known: {_listed(it.columns)}",
        f"Give --channels {it.sensor}={places} and the other channels",
    )


def _mixed_units(finding: Finding, it: kinds.MixedUnits) -> Words:
    units = ", ".join(f"{_short(name, _NAME)} {_short(unit, 12)}" for name, unit in it.units)
    return Words(
        f"axes of one sensor have different units: {units}", "Correct the header, or give one unit with --unit"
    )


def _unread_arrays(finding: Finding, it: kinds.UnreadArrays) -> Words:
    what = f"{_number(len(it.names), 'members')} of the archive not read, because the name is not that of an array"
    return Words(f"{what}: {_listed(it.names)}", _AGAIN)


def _with_part(function: Callable[[Finding, Any], Words]) -> Callable[[Finding, Any], Words]:
    """The name of the file first, if the log is split into several."""

    def words(finding: Finding, it: kinds.InFile) -> Words:
        message, action = function(finding, it)
        return Words(f"{it.part}: {message}" if it.part else message, action)

    return words


WORDS: dict[type, Callable[[Finding, Any], Words]] = {
    kind: _with_part(function)
    for kind, function in (
        (kinds.BytesNotRead, _bytes_not_read),
        (kinds.ColumnsByGravity, _columns_by_gravity),
        (kinds.Damaged, _damaged),
        (kinds.GravityOnGyro, _gravity_on_gyro),
        (kinds.IncompleteSensor, _incomplete_sensor),
        (kinds.LoggerDropouts, _dropouts),
        (kinds.MixedUnits, _mixed_units),
        (kinds.MissingChunks, _missing_chunks),
        (kinds.NeverWritten, _never_written),
        (kinds.PartMissing, _part_missing),
        (kinds.SkippedLines, _skipped_lines),
        (kinds.SkippedMessages, _skipped_messages),
        (kinds.UnitOverruled, _unit_overruled),
        (kinds.UnreadArrays, _unread_arrays),
        (kinds.UnreadSensor, _unread_sensor),
        (kinds.Unusable, _unusable),
        (kinds.UnusedColumns, _unused_columns),
    )
}
