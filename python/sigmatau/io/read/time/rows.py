"""Rows of a log in time order: rows without a stamp and duplicates are left out, late rows are moved to their place.

Each change is a finding. A fault that only a guess could correct is an error.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from sigmatau.arrays import distinct, median, median_and_spread
from sigmatau.errors import DataError, NonFiniteError, StampError
from sigmatau.findings.finding import Finding
from sigmatau.findings.reading import Place
from sigmatau.findings.stamps import BadStamps
from sigmatau.findings.wording import sentence
from sigmatau.frozen import frozen
from sigmatau.hints import TIME_COLUMN, WITHOUT_STAMPS, Hint
from sigmatau.io.read.columns import ColumnChoice
from sigmatau.io.read.formats.damage import fault
from sigmatau.io.read.table import Loaded, Table
from sigmatau.io.read.time.dates import NO_STAMP
from sigmatau.io.read.time.overflows import continue_overflows

_LARGEST_STAMP = 1e100  # largest stamp, in any unit
_MAX_OUT_OF_ORDER = 0.01  # share of rows that may be out of order: a delayed packet, not a log with mixed clocks
_MIN_DISTANCE = 0.5  # smallest distance of a moved row from its new neighbours [intervals]
_MAX_DISTANCE = 3.0  # largest distance of a moved row from its new neighbours, in a hole of 1 to 3 rows [intervals]
_MAX_REPEATED = 0.01  # share of repeated stamps above which the clock counts as coarse
_MIN_COPIES = 0.9  # share of repeated stamps with equal samples from which the rows are copies
_JITTER_SIGMAS = 6.0  # standard deviations of the intervals within which a step back is jitter: exceeded once in 1e9
_SWAP_ROUNDS = 8
_MAX_SWAPPED = 0.05  # share of rows that jitter may swap
_MIN_STAMPS = 64  # fewer stamps do not show their scatter
_REGULAR_SPREAD = 0.25  # largest relative standard deviation of the distances between repeats from a slow clock


@frozen
class OrderedRows:
    """Rows in use."""

    stamps: NDArray[Any]  # shape (n,); in order
    intervals: NDArray[np.float64]  # shape (n - 1,)
    rows: NDArray[np.int64] | None  # shape (n,); their indices in the table; None for all rows in their order
    findings: tuple[Finding, ...]


def in_order(
    stamps: NDArray[Any],
    samples: Sequence[NDArray[Any]],
    where: Callable[[int], str],
    name: str,
    rows: NDArray[np.int64] | None = None,
) -> OrderedRows:
    """Put rows in time order. `stamps`: NaN, or the smallest integer, where a stamp is missing; `samples`: the
    channels; they distinguish a row that was written twice from two rows with one stamp; `where`: place of a row in the
    file, for the messages; `name`: the column of the stamps, as messages name it; `rows`: indices of these rows in the
    table, if they are not all.
    """
    findings: list[Finding] = []
    smallest = stamps.min() if len(stamps) else 0  # NaN if there is one
    if (smallest != smallest) if stamps.dtype.kind == "f" else (smallest == NO_STAMP and stamps.dtype == np.int64):
        missing = np.isnan(stamps) if stamps.dtype.kind == "f" else stamps == NO_STAMP
        rows, without = _with_stamp(missing, where, name, rows)
        findings.append(without)
        stamps = stamps[~missing]
        samples = [channel[~missing] for channel in samples]
        smallest = stamps.min() if len(stamps) else 0
    largest = stamps.max() if len(stamps) else 0
    if stamps.dtype.kind in "iu" and int(largest) - int(smallest) >= 1 << 62:
        stamps = stamps.astype(np.float64)
    if stamps.dtype.kind == "f" and not max(abs(smallest), abs(largest)) < _LARGEST_STAMP:
        worst = int(np.argmax(np.abs(stamps)))
        raise DataError(f"column {name} has {stamps[worst]}, which is not a time", place=where(_row(rows, worst)))
    if len(stamps) and smallest == largest:
        raise StampError(
            f"all stamps in column {name} are {stamps[0]}, so they give no rate; name another column with {TIME_COLUMN}"
            f" (in a bag or MCAP {Hint('channels', 'time', 'log_time')}), or ignore the stamps with {WITHOUT_STAMPS}"
        )
    intervals = np.diff(stamps)
    signed = (
        stamps.dtype.kind == "f" or stamps.dtype == np.int64
    )  # in unsigned integers a step back is a large step forward
    shortest = intervals.min() if len(intervals) else 1
    if len(intervals) and (not signed or shortest < 0):
        unwrapped = continue_overflows(stamps, lambda k: where(_row(rows, k)), name)
        if unwrapped is not None:
            stamps = unwrapped[0]
            findings.append(unwrapped[1])
        stamps = _unswapped(stamps)
        back = np.flatnonzero(stamps[1:] < stamps[:-1])
        intervals = np.diff(stamps)
        shortest = intervals.min()
        if len(back):
            order, moved = _sorted(stamps, back, where, name, rows)
            findings.append(moved)
            stamps, samples = stamps[order], [channel[order] for channel in samples]
            rows = order if rows is None else rows[order]
            intervals = np.diff(stamps)
            shortest = intervals.min()
    if shortest == 0:
        single, repeats = _mask_of_single(stamps, intervals, samples, where, rows)
        if repeats is not None:
            findings.append(repeats)
            stamps = stamps[single]
            rows = np.flatnonzero(single) if rows is None else rows[single]
            intervals = np.diff(stamps)
    return OrderedRows(
        stamps=stamps, intervals=intervals.astype(np.float64, copy=False), rows=rows, findings=tuple(findings)
    )


_MIN_RUN = 100.0  # shortest run that ends in a restart; after a shorter one the rows are out of order [intervals]
_MIN_BLOCKS = 3  # smallest number of steps back by several sensors in turn
# largest time span of rows of several sensors, over the usual interval times the number of rows: it is 0.91 with a
# second sensor at a tenth of the rate
_LARGEST_SHARE = 0.9
_BEGINNINGS = 0.5  # share of the steps back that return to the first stamp, for a clock that starts again
_RESTART = 10.0  # distance from the first stamp up to which a log has begun again [intervals]


def _row(rows: NDArray[np.int64] | None, k: int) -> int:
    return k if rows is None else int(rows[k])


def _with_stamp(
    missing: NDArray[np.bool_], where: Callable[[int], str], name: str, rows: NDArray[np.int64] | None
) -> tuple[NDArray[np.int64], Finding]:
    count, first = int(np.count_nonzero(missing)), int(np.argmax(missing))
    place = where(_row(rows, first))
    if 2 * count > len(missing):
        raise NonFiniteError(
            f"column {name} has no time stamp in {count} of {len(missing)} rows; name another column with"
            f" {TIME_COLUMN}, or ignore the stamps with {WITHOUT_STAMPS}",
            place=place,
            channel=name,
            index=_row(rows, first),
        )
    remaining = np.flatnonzero(~missing) if rows is None else rows[~missing]
    return remaining, _finding("missing", count, len(missing), place)


def _finding(what: Literal["missing", "wrong", "repeated", "late"], count: int, rows: int, place: str) -> Finding:
    return Finding(details=BadStamps(what=what, rows=rows, place=place), severity="warning", size=count)


def _sorted(
    stamps: NDArray[Any], back: NDArray[np.intp], where: Callable[[int], str], name: str, rows: NDArray[np.int64] | None
) -> tuple[NDArray[np.int64], Finding]:
    """Rows in time order, if few rows are out of order and each of them fits into a hole between others; else an error."""
    row = int(back[0]) + 1
    place = where(_row(rows, row))
    if len(back) <= _MAX_OUT_OF_ORDER * len(stamps):
        if (moved := _moved(stamps)) is not None:
            return moved[0], _finding("late", moved[1], len(stamps), place)
        if (wrong := _wrong(stamps, back)) is not None:
            first_wrong = where(_row(rows, int(wrong[0])))
            remaining = np.delete(np.arange(len(stamps)), wrong)
            return remaining, _finding("wrong", len(wrong), len(stamps), first_wrong)
    times = "" if len(back) == 1 else f", and {len(back) - 1} times more after it"
    usual, back_to = _usual(stamps), float(stamps[row]) - float(stamps[0])
    if abs(back_to) <= _RESTART * usual and float(stamps[row - 1]) - float(stamps[row]) >= _MIN_RUN * usual:
        raise StampError(
            f"time begins again in column {name}, from {stamps[row - 1]} to {stamps[row]}{times}; the rows are of"
            " several runs or sensors, cut the file there",
            place=place,
        )
    if _repeats_in_blocks(stamps, back, usual):
        raise StampError(
            f"time goes backwards in column {name}, from {stamps[row - 1]} to {stamps[row]}{times}:"
            " blocks of rows have the same times, as those of several sensors do. Sort the rows by time, or save each sensor"
            " to its own file",
            place=place,
        )
    raise StampError(
        f"time goes backwards in column {name}, from {stamps[row - 1]} to {stamps[row]}{times};"
        f" sort the rows, cut the file there{_wrapped(stamps, row)}, or ignore the stamps with"
        f" {WITHOUT_STAMPS}",
        place=place,
    )


def _repeats_in_blocks(stamps: NDArray[Any], back: NDArray[np.intp], usual: float) -> bool:
    """Whether blocks of rows share their times: there are more rows than one sensor with such intervals has."""
    length = float(stamps.max()) - float(stamps.min())
    return len(back) >= _MIN_BLOCKS and length < _LARGEST_SHARE * usual * (len(stamps) - 1)


def shares_times(stamps: NDArray[Any]) -> bool:
    """Whether blocks of rows share their times although the clock does not start again."""
    finite = stamps[np.isfinite(stamps)] if stamps.dtype.kind == "f" else stamps
    back = np.flatnonzero(finite[1:] < finite[:-1])
    if not len(back):
        return False
    usual = _usual(finite)
    begins_again = np.abs(finite[back + 1].astype(np.float64) - float(finite[0])) <= _RESTART * usual
    return _repeats_in_blocks(finite, back, usual) and bool(np.mean(begins_again) < _BEGINNINGS)


def _wrapped(stamps: NDArray[Any], row: int) -> str:
    """Advice for a step back that is the range of a counter."""
    back = float(stamps[row - 1]) - float(stamps[row])
    bits = next((bits for bits in (16, 32) if 0.95 * 2**bits < back <= 2**bits), None)
    return "" if bits is None else f", add 2^{bits} to the rest if it is a {bits}-bit counter that overflowed"


def _unswapped(stamps: NDArray[Any]) -> NDArray[Any]:
    """Swap neighbouring stamps whose steps back are within the jitter: their rows are in order. A late row would leave
    a hole, and a step of two intervals on either side of it. A wrong stamp is far outside the scatter of the others.
    """
    count = int(np.count_nonzero(stamps[1:] < stamps[:-1]))
    if len(stamps) < _MIN_STAMPS or count > _MAX_SWAPPED * len(stamps):
        return stamps
    intervals = np.diff((stamps - stamps.min()).astype(np.float64))
    usual, spread = median_and_spread(intervals)
    limit = _JITTER_SIGMAS * spread
    if not limit > usual:
        return stamps
    stamps = stamps.copy()
    for _ in range(_SWAP_ROUNDS):  # a stamp may be later than several following ones
        back = np.flatnonzero(stamps[1:] < stamps[:-1])
        size = (stamps[back] - stamps[back + 1]).astype(np.float64)
        mild = back[size <= limit - usual]
        mild = mild[np.diff(mild, prepend=-2) > 1]  # disjoint pairs only
        if not len(mild):
            break
        stamps[mild], stamps[mild + 1] = stamps[mild + 1], stamps[mild]
    return stamps


def _usual(stamps: NDArray[Any]) -> float:
    """Median of the intervals that go forward."""
    intervals = np.diff(stamps).astype(np.float64)
    forward = intervals[intervals > 0]
    return median(forward) if len(forward) else 0.0


def _moved(stamps: NDArray[Any]) -> tuple[NDArray[np.int64], int] | None:
    """Time order and the number of rows that it moves; None if a row would not fall into a hole."""
    n = len(stamps)
    order = np.argsort(stamps, kind="stable").astype(np.int64)
    # A late row follows rows with larger stamps, which keep their mutual order.
    late = stamps < np.maximum.accumulate(stamps)
    count = int(np.count_nonzero(late))
    if count > _MAX_OUT_OF_ORDER * n:
        return None
    intervals = np.diff(stamps[order]).astype(np.float64)
    usual = _usual(stamps)
    place = np.flatnonzero(late[order])
    neighbours = distinct(np.clip(np.concatenate((place - 1, place)), 0, n - 2))
    gaps = intervals[neighbours]
    fits = bool((gaps >= _MIN_DISTANCE * usual).all() and (gaps <= _MAX_DISTANCE * usual).all())
    return (order, count) if fits and usual > 0 else None


def _wrong(stamps: NDArray[Any], back: NDArray[np.intp]) -> NDArray[np.int64] | None:
    """Rows with wrong stamps, without which time increases regularly; None if these do not explain all steps back."""
    n = len(stamps)
    wrong = []
    for row in back.tolist():  # one in a hundred rows at most
        if row > 0 and stamps[row - 1] <= stamps[row + 1]:
            wrong.append(row)  # too late
        elif row + 2 < n and stamps[row] <= stamps[row + 2]:
            wrong.append(row + 1)  # too early
        elif row == 0:
            wrong.append(0)  # before the clock was set
        else:
            return None
    intervals = np.diff(np.delete(stamps, wrong)).astype(np.float64)
    usual = _usual(stamps)
    row = np.clip(np.asarray(wrong) - 1 - np.arange(len(wrong)), 0, len(intervals) - 1)
    if intervals.min() < 0 or (intervals[row] > (_MAX_DISTANCE + 1) * usual).any() or not usual > 0:
        return None
    return np.asarray(wrong, dtype=np.int64)


def _mask_of_single(
    stamps: NDArray[Any],
    intervals: NDArray[Any],
    samples: Sequence[NDArray[Any]],
    where: Callable[[int], str],
    rows: NDArray[np.int64] | None,
) -> tuple[NDArray[np.bool_], Finding | None]:
    """Mask of the rows without duplicates, and the finding; None if the stamps repeat because the clock is coarse."""
    again = np.flatnonzero(intervals == 0) + 1
    same = np.ones(len(again), dtype=bool)
    for channel in samples:
        before, after = channel[again - 1], channel[again]
        same &= (before == after) | ((before != before) & (after != after))
    copies = bool(samples) and np.count_nonzero(same) >= _MIN_COPIES * len(again)
    if not copies:
        if len(again) > _MAX_REPEATED * len(intervals):
            return np.ones(0, dtype=bool), None
        apart = np.diff(again)
        if len(apart) >= 4 and float(np.std(apart)) < _REGULAR_SPREAD * float(np.mean(apart)):
            return np.ones(0, dtype=bool), None  # the resolution of the clock is a little coarser than the interval
    single = np.ones(len(stamps), dtype=bool)
    single[again] = False
    if np.count_nonzero(single) < 2:
        return np.ones(0, dtype=bool), None
    return single, _finding("repeated", len(again), len(stamps), where(_row(rows, int(again[0]))))


def cut(loaded: Loaded, choice: ColumnChoice, table: Table, error: DataError, *, min_rows: int) -> Loaded:
    """The rows of a damaged log before time goes backwards; raises `error`, with known damage, for other logs. The last
    of these rows is left out as well: either it or the next row has a wrong stamp.
    """
    findings = (*table.findings, *loaded.findings)
    if choice.time is None or not any(finding.severity == "error" for finding in findings):
        raise with_damage(error, table, loaded.findings) from None
    stamps = loaded.columns[choice.time]
    back = np.flatnonzero(stamps[1:] < stamps[:-1])
    rows = len(stamps)
    end = int(back[0]) if len(back) else rows
    if not min_rows <= end < rows:
        raise with_damage(error, table, loaded.findings) from None
    finding = fault(place=Place("row", end), reason="time goes backwards", kept=end, declared=rows)
    columns = {index: array[:end] for index, array in loaded.columns.items()}
    return replace(loaded, columns=columns, findings=(*loaded.findings, finding))


def with_damage(error: DataError, table: Table, findings: Sequence[Finding]) -> DataError:
    """An error about stamps with the damage that may have caused it."""
    if not isinstance(error, StampError):
        return error
    damage = [sentence(finding) for finding in (*table.findings, *findings) if finding.severity == "error"]
    return StampError(f"{error}. The log is damaged: {damage[0]}") if damage else error
