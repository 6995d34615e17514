"""Words of findings about files: damage, leftovers, columns, units."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds import reading as kinds
from sigmatau.findings.wording.phrases import Words

__all__ = ["WORDS"]

_AGAIN = "Copy or record the file again"
_LONGEST = 120  # of a message [characters]
_REASON = 60  # longest reason of a missing part [characters]
_SHOWN = 4  # columns listed


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


def _damage(verb: str, finding: Finding, it: kinds.Damage) -> Words:
    inside = ""
    if it.inside and (it.place is None or it.place.unit != it.inside):
        inside = f" inside its last {it.inside}" if it.place is None else f", inside a {it.inside}"
    share = ""
    if it.got is not None and it.expected is not None:
        fits = it.got <= it.expected
        share = (
            f"{it.got} of {it.expected} {it.measured}"
            if fits
            else f"{it.got} {it.measured} where at most {it.expected} fit"
        )
    complete = finding.severity == "warning" and it.declared in (None, it.kept)
    kept = _kept(it.kept, None if complete else it.declared, it.counted, it.topic, every=complete)
    subject = f"the {it.what} {verb}{_at(it.place)}{inside}"
    left = _LONGEST - sum(len(text) + 2 for text in (it.part, subject, share, kept))
    reason = "; ".join(filter(None, (_short(it.reason, max(left, 20)), share)))
    message = f"{subject}: {reason}" if reason else subject
    if complete:
        action = ""
    elif it.inside == "row":
        action = "Copy the whole file, or correct --layout"
    else:
        action = _AGAIN
    return Words("; ".join(filter(None, (message, kept))), action)


def _damaged(finding: Finding, it: kinds.Damaged) -> Words:
    return _damage("is damaged", finding, it)


def _broken_off(finding: Finding, it: kinds.BrokenOff) -> Words:
    return _damage("is truncated", finding, it)


def _no_end_mark(finding: Finding, it: kinds.NoEndMark) -> Words:
    return _damage("has no end mark, so batches may be missing", finding, it)


def _part_missing(finding: Finding, it: kinds.PartMissing) -> Words:
    why = f"cannot be read: {_short(it.reason)}" if it.reason else "is missing"
    return Words(f"part {it.number} of {it.of} {why}", _AGAIN)


def _part_of_several(finding: Finding, it: kinds.PartOfSeveral) -> Words:
    return Words(
        f"the file is part {it.number} of {it.of} of a recording",
        "Give the folder instead of the file to read all parts",
    )


def _broken_messages(finding: Finding, it: kinds.BrokenMessages) -> Words:
    where = f"{'the first ' if it.count > 1 else ''}at byte {it.places[0]}"
    return Words(
        f"{_number(it.count, 'messages')} with a wrong checksum skipped, {where}; {it.kept} read",
        "Copy the log again: rows are missing, and the times after a missing row are too early",
    )


def _bytes_between(finding: Finding, it: kinds.BytesBetween) -> Words:
    return Words(
        f"{_number(it.bytes, 'bytes')} in {_number(it.count, 'places')} are not part of a complete message, the first"
        f"{_at(it.place)}; {it.kept} messages read",
        "Copy the log again: messages may be missing there, and later times may be too early",
    )


def _broken_lines(finding: Finding, it: kinds.BrokenLines) -> Words:
    line, what = it.examples[0] if it.examples else (0, "")
    first = f" (line {line} {_short(what, 40)})" if it.examples else ""
    missing = (
        f"up to {it.inner} of {it.kept + it.inner} rows of ${it.topic} are missing"
        if it.inner
        else "no rows are missing"
    )
    return Words(
        f"{_number(it.count, 'damaged lines')} skipped{first}; {missing}",
        "Copy the log again: the times after a missing row are too early" if it.inner else "",
    )


def _other_sentences(finding: Finding, it: kinds.OtherSentences) -> Words:
    message = f"{it.count} sentences of other types, such as ${it.example}, not read"
    if it.line is None:
        return Words(message)
    return Words(
        f"{message}; {it.run} in a row from line {it.line}, without a ${it.topic} between them",
        f"Split the log where the sensor was switched: rows of ${it.topic} are missing there",
    )


def _bytes_not_read(finding: Finding, it: kinds.BytesNotRead) -> Words:
    where = f"after {it.after}{_at(it.place)}" if it.after else "before the data"
    return Words(f"{_number(it.bytes, 'bytes')} {where} not read", "Split the file there if another log was appended")


def _filler(finding: Finding, it: kinds.Filler) -> Words:
    return Words(f"{_number(it.bytes, 'bytes')} of {it.value:#04x} after {it.after}{_at(it.place)} are padding")


def _hidden_rows(finding: Finding, it: kinds.HiddenRows) -> Words:
    what = (
        f"line {it.line} is a comment that looks like a data row"
        if it.count == 1
        else f"{it.count} comment lines look like data rows, the first line {it.line}"
    )
    return Words(f"{what}; skipped", "Remove the comment marks if these lines are data; otherwise delete the lines")


def _comments(finding: Finding, it: kinds.Comments) -> Words:
    where = f"on line {it.line}" if it.count == 1 else f"the first on line {it.line}"
    return Words(f"{_number(it.count, 'comments')} between data rows skipped, {where}")


def _header_again(finding: Finding, it: kinds.HeaderAgain) -> Words:
    return Words(f"line {it.line} repeats the header; several logs were joined")


def _second_header(finding: Finding, it: kinds.SecondHeader) -> Words:
    return Words(
        f"line {it.line} is a header with other columns; {_number(it.kept, 'rows')} before it are read, rows after it"
        " are not",
        "Split the file there: it holds several logs",
    )


def _no_line_end(finding: Finding, it: kinds.NoLineEnd) -> Words:
    return Words("the last line has no line end, so its last number may be truncated; line skipped")


def _never_written(finding: Finding, it: kinds.NeverWritten) -> Words:
    what = f"{'time stamp' if it.is_time else 'column'} {it.column} is" if it.column else "all columns are"
    return Words(
        f"{what} exactly 0 in the last {it.zeros} of {it.rows} rows, which were never written; {it.kept} rows read",
        _AGAIN,
    )


def _listed(channels: Sequence[tuple[str, int]]) -> str:
    """``--channels`` for these, axes of a sensor as a range where their columns follow each other."""
    parts: list[str] = []
    left = list(channels)
    while left:
        name, first = left[0]
        stem = name.removesuffix("_x")
        if left[:3] == [(f"{stem}_{axis}", first + k) for k, axis in enumerate("xyz")]:
            parts.append(f"{stem}={first}:{first + 2}")
            left = left[3:]
        else:
            parts.append(f"{name}={first}")
            left = left[1:]
    return "--channels " + ",".join(parts)


def _columns_not_read(finding: Finding, it: kinds.ColumnsNotRead) -> Words:
    shown = ", ".join(_short(column, 20) for column in it.columns[:_SHOWN])
    more = f" and {len(it.columns) - _SHOWN} more" if len(it.columns) > _SHOWN else ""
    rate = "--input rate " if it.as_rates else ""
    topic = f" --topic {it.topic}" if it.topic else ""
    return Words(
        f"{'column' if len(it.columns) == 1 else 'columns'} {shown}{more} not read: not a gyro or accelerometer",
        f"Run with {rate}{_listed(it.channels)}{topic} to read {'it' if len(it.columns) == 1 else 'them'}",
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


def _unknown_messages(finding: Finding, it: kinds.UnknownMessages) -> Words:
    return Words(
        f"{_number(it.count, 'messages')} of unknown types skipped",
        "No action needed if a newer PX4 version wrote them; otherwise the file is damaged there",
    )


def _unfinished_message(finding: Finding, it: kinds.UnfinishedMessage) -> Words:
    return Words(
        f"{_number(it.bytes, 'bytes')}{_at(it.place)} are an incomplete message, followed by appended data",
        "No action needed if the logger crashed there: only this message is lost",
    )


def _deleted_messages(finding: Finding, it: kinds.DeletedMessages) -> Words:
    return Words(
        f"{_number(it.count, 'messages')} of all topics were deleted from the bag",
        f"Check the time stamps for gaps: messages of {it.topic} may be among the deleted ones",
    )


def _property_changed(finding: Finding, it: kinds.PropertyChanged) -> Words:
    old, new = (_short(repr(value), 20) for value in (it.old, it.new))
    return Words(
        f"{it.name} of {it.topic!r} changes from {old} to {new} after {_number(it.kept, 'rows')}; only these are read",
        "Save the remaining rows as a separate file",
    )


def _unequal_lengths(finding: Finding, it: kinds.UnequalLengths) -> Words:
    listed = ", ".join(f"{_short(name, 20)} {rows}" for name, rows in it.lengths)
    return Words(f"axes of one sensor differ in length: {listed}; only equal lengths are read together", _AGAIN)


def _missing_samples(finding: Finding, it: kinds.MissingSamples) -> Words:
    return Words(
        f"{_number(it.count, 'samples')} of {_short(it.column, 30)} have the fill value {it.fill:g}; treated as missing"
    )


def _dropouts(finding: Finding, it: kinds.LoggerDropouts) -> Words:
    return Words(
        f"the logger lost data {_number(it.count, 'times')}, {it.total:.3g} s in total, the longest loss {it.longest:.3g} s",
        "Log to a faster card, log fewer topics, or select a part without dropouts with --window",
    )


def _unit_overruled(finding: Finding, it: kinds.UnitOverruled) -> Words:
    stated = it.stated if it.known else f"{_short(it.stated, 20)!r}, which is not a unit of this quantity"
    return Words(
        f"the file states {stated}; the given unit {it.given} is used",
        "" if it.known or it.scaled else "Give --scale if the values are volts or counts",
    )


def _with_part(function: Callable[[Finding, Any], Words]) -> Callable[[Finding, Any], Words]:
    """The name of the file first, if the log is split into several."""

    def words(finding: Finding, it: kinds.InFile) -> Words:
        message, action = function(finding, it)
        return Words(f"{it.part}: {message}" if it.part else message, action)

    return words


WORDS: dict[type, Callable[[Finding, Any], Words]] = {
    kind: _with_part(function)
    for kind, function in (
        (kinds.BrokenLines, _broken_lines),
        (kinds.BrokenMessages, _broken_messages),
        (kinds.BrokenOff, _broken_off),
        (kinds.BytesBetween, _bytes_between),
        (kinds.BytesNotRead, _bytes_not_read),
        (kinds.ColumnsByGravity, _columns_by_gravity),
        (kinds.GravityOnGyro, _gravity_on_gyro),
        (kinds.ColumnsNotRead, _columns_not_read),
        (kinds.Comments, _comments),
        (kinds.Damaged, _damaged),
        (kinds.DeletedMessages, _deleted_messages),
        (kinds.Filler, _filler),
        (kinds.HeaderAgain, _header_again),
        (kinds.HiddenRows, _hidden_rows),
        (kinds.LoggerDropouts, _dropouts),
        (kinds.MissingSamples, _missing_samples),
        (kinds.NeverWritten, _never_written),
        (kinds.NoEndMark, _no_end_mark),
        (kinds.NoLineEnd, _no_line_end),
        (kinds.OtherSentences, _other_sentences),
        (kinds.PartMissing, _part_missing),
        (kinds.PartOfSeveral, _part_of_several),
        (kinds.PropertyChanged, _property_changed),
        (kinds.SecondHeader, _second_header),
        (kinds.UnequalLengths, _unequal_lengths),
        (kinds.UnfinishedMessage, _unfinished_message),
        (kinds.UnitOverruled, _unit_overruled),
        (kinds.UnknownMessages, _unknown_messages),
        (kinds.Unusable, _unusable),
    )
}
