"""Rows of a log in the order of time: without those that have no stamp, that come twice, or that came late.

Whatever is left out or moved is said. What cannot be put right without a guess is refused.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.arrays import median_and_spread
from sigmatau.errors import DataError, NonFiniteError
from sigmatau.findings.finding import Finding

__all__ = ["NO_STAMP", "Rows", "in_order"]

NO_STAMP = np.iinfo(np.int64).min
"""Stands for a missing stamp among integers, as NumPy's NaT does."""

_NO_TIME = 1e100  # in any unit
_MOVED = 0.01  # share of rows that may be out of order
_NEAR = 3.0  # intervals from its new neighbours, at most, for a row that is moved
_APART = 0.5  # intervals, at least
_TWICE = 0.01  # share of stamps that come twice, above which the clock is taken to be coarse
_COPIES = 0.9  # of the repeated stamps, with the same samples: then the rows are copies
_JITTER = 6.0  # standard deviations of the intervals that a step back may be off: once in 1e9 intervals
_ROUNDS = 8
_JITTERED, _LEAST = 0.05, 64  # share of rows that jitter may swap; fewer stamps do not show their scatter
_REGULAR = 0.25  # relative spread of the distances between repeats that a clock a little too slow makes


@dataclass(frozen=True, slots=True, kw_only=True)
class Rows:
    """Rows that are used.

    Attributes
    ----------
    stamps : ndarray of int64 or float64, shape (n,)
        In order.
    intervals : ndarray of float64, shape (n - 1,)
    rows : ndarray of int64, shape (n,), or None
        Which rows of the table they are; None for all of them, as they stand.
    findings : tuple of Finding
    """

    stamps: NDArray[Any]
    intervals: NDArray[np.float64]
    rows: NDArray[np.int64] | None
    findings: tuple[Finding, ...]


def in_order(
    stamps: NDArray[Any],
    samples: Sequence[NDArray[Any]],
    where: Callable[[int], str],
    name: str,
    rows: NDArray[np.int64] | None = None,
) -> Rows:
    """Put rows in order by their stamps.

    Parameters
    ----------
    stamps : ndarray of int64 or float64, shape (n,)
        NaN, or the least integer, where there is none.
    samples : sequence of ndarray, shape (n,)
        The channels, to tell a row that was written twice from two rows with one stamp.
    where : callable
        Place of a row in the file, for the messages.
    name : str
        The column of the stamps, as messages name it.
    rows : ndarray of int64, shape (n,), optional
        Which rows of the table these are, if not all.

    Raises
    ------
    DataError
        If time goes backwards so that it is not clear where the rows belong, or stands still; `NonFiniteError` if more than
        half of the stamps are missing.
    """
    findings: list[Finding] = []
    least = stamps.min() if len(stamps) else 0  # NaN if there is one
    if (least != least) if stamps.dtype.kind == "f" else (least == NO_STAMP and stamps.dtype == np.int64):
        missing = np.isnan(stamps) if stamps.dtype.kind == "f" else stamps == NO_STAMP
        rows, without = _with_stamp(missing, where, name, rows)
        findings.append(without)
        stamps = stamps[~missing]
        samples = [channel[~missing] for channel in samples]
        least = stamps.min() if len(stamps) else 0
    most = stamps.max() if len(stamps) else 0
    if stamps.dtype.kind in "iu" and int(most) - int(least) >= 1 << 62:
        stamps = stamps.astype(np.float64)
    if stamps.dtype.kind == "f" and not max(abs(least), abs(most)) < _NO_TIME:
        worst = int(np.argmax(np.abs(stamps)))
        raise DataError(f", {where(_row(rows, worst))}: column {name} has {stamps[worst]}, which is no time")
    if len(stamps) and least == most:
        raise DataError(
            f"all stamps in column {name} are {stamps[0]}, so they say no rate; name another column by --channels time=…"
            " (in a bag or MCAP --channels time=log_time), or leave the stamps out by --channels time=none --rate HZ"
        )
    intervals = np.diff(stamps)
    signed = stamps.dtype.kind == "f" or stamps.dtype == np.int64  # in others a step back is a large one forward
    shortest = intervals.min() if len(intervals) else 1
    if len(intervals) and (not signed or shortest < 0):
        stamps = _unswapped(stamps)
        back = np.flatnonzero(stamps[1:] < stamps[:-1])
        intervals = np.diff(stamps)
        shortest = intervals.min()
        if len(back):
            kept, moved = _sorted(stamps, back, where, name, rows)
            findings.append(moved)
            stamps, samples = stamps[kept], [channel[kept] for channel in samples]
            rows = kept if rows is None else rows[kept]
            intervals = np.diff(stamps)
            shortest = intervals.min()
    if shortest == 0:
        single, twins = _without_twins(stamps, intervals, samples, where, rows)
        if twins is not None:
            findings.append(twins)
            stamps = stamps[single]
            rows = np.flatnonzero(single) if rows is None else rows[single]
            intervals = np.diff(stamps)
    return Rows(stamps=stamps, intervals=intervals.astype(np.float64, copy=False), rows=rows, findings=tuple(findings))


def _row(rows: NDArray[np.int64] | None, k: int) -> int:
    return k if rows is None else int(rows[k])


def _with_stamp(
    missing: NDArray[np.bool_], where: Callable[[int], str], name: str, rows: NDArray[np.int64] | None
) -> tuple[NDArray[np.int64], Finding]:
    count, first = int(np.count_nonzero(missing)), int(np.argmax(missing))
    place = where(_row(rows, first))
    if 2 * count > len(missing):
        raise NonFiniteError(
            f", {place}: column {name} has no time stamp in {count} of {len(missing)} rows; name another column by"
            " --channels time=…, or give --rate HZ without one",
            channel=name,
            index=_row(rows, first),
        )
    kept = np.flatnonzero(~missing) if rows is None else rows[~missing]
    return kept, Finding(
        code="missing_stamps",
        severity="warning",
        message=f"{count} of {len(missing)} rows have no time stamp, the first: {place}",
        where=place,
        size=count,
        effect="they are left out, and are gaps in the record",
        remedy="if their samples are good, cut the time column out and give --rate HZ",
    )


def _sorted(
    stamps: NDArray[Any],
    back: NDArray[np.intp],
    where: Callable[[int], str],
    name: str,
    rows: NDArray[np.int64] | None,
) -> tuple[NDArray[np.int64], Finding]:
    """The order of time, if few rows are out of it and each of them fits into a hole between others; else an error."""
    row = int(back[0]) + 1
    place = where(_row(rows, row))
    if len(back) <= _MOVED * len(stamps):
        if (moved := _moved(stamps)) is not None:
            order, count = moved
            first = int(np.flatnonzero(order != np.arange(len(order)))[0])
            return order, Finding(
                code="rows_out_of_order",
                severity="warning",
                message=f"{count} of {len(stamps)} rows stand out of the order of time, the first: {place}",
                where=place,
                size=count,
                effect=f"they are put where their stamps belong, the first at {stamps[order[first]]}; no sample is changed",
                remedy="look at the link or the program that writes the log: it delivers late",
            )
        if (wrong := _wrong(stamps, back)) is not None:
            at = where(_row(rows, int(wrong[0])))
            kept = np.delete(np.arange(len(stamps)), wrong)
            return kept, Finding(
                code="wrong_stamps",
                severity="warning",
                message=f"{len(wrong)} of {len(stamps)} stamps stand far from those before and after, the first: {at}",
                where=at,
                size=len(wrong),
                effect="these rows are left out, and are gaps in the record",
                remedy="none is needed; look for the cause if there are more than a few",
            )
    times = "" if len(back) == 1 else f", and {len(back) - 1} times more further on"
    raise DataError(
        f", {place}: time goes backwards in column {name}, from {stamps[row - 1]} to {stamps[row]}{times};"
        f" sort the rows, cut the file there{_wrapped(stamps, row)}, or leave the stamps out by --channels time=none"
        " --rate HZ"
    )


def _wrapped(stamps: NDArray[Any], row: int) -> str:
    """What to say of a step back that is the range of a counter."""
    back = float(stamps[row - 1]) - float(stamps[row])
    bits = next((bits for bits in (16, 32) if 0.95 * 2**bits < back <= 2**bits), None)
    return "" if bits is None else f", add 2^{bits} to the rest if it is a counter of {bits} bits that began anew"


def _unswapped(stamps: NDArray[Any]) -> NDArray[Any]:
    """Stamps that go back by no more than their own jitter, handed on between neighbours: the rows are in order.

    A row that came late would leave a hole, and a step of two intervals on either side of it; a stamp that is wrong stands
    far beyond the scatter of the others.
    """
    count = int(np.count_nonzero(stamps[1:] < stamps[:-1]))
    if len(stamps) < _LEAST or count > _JITTERED * len(stamps):
        return stamps
    intervals = np.diff((stamps - stamps.min()).astype(np.float64))
    usual, spread = median_and_spread(intervals)
    most = _JITTER * spread
    if not most > usual:
        return stamps
    stamps = stamps.copy()
    for _ in range(_ROUNDS):  # a stamp may be behind several
        back = np.flatnonzero(stamps[1:] < stamps[:-1])
        size = (stamps[back] - stamps[back + 1]).astype(np.float64)
        mild = back[size <= most - usual]
        mild = mild[np.diff(mild, prepend=-2) > 1]  # one pair has no stamp of another
        if not len(mild):
            break
        stamps[mild], stamps[mild + 1] = stamps[mild + 1], stamps[mild]
    return stamps


def _usual(stamps: NDArray[Any]) -> float:
    """Median of the intervals that go forward."""
    intervals = np.diff(stamps).astype(np.float64)
    forward = intervals[intervals > 0]
    return float(np.median(forward)) if len(forward) else 0.0


def _moved(stamps: NDArray[Any]) -> tuple[NDArray[np.int64], int] | None:
    """The order of time and how many rows it moves against the others; None if a row would not fall into a hole."""
    n = len(stamps)
    order = np.argsort(stamps, kind="stable").astype(np.int64)
    # A row that came late is passed by all that should have come after it; those keep their order among themselves.
    late = stamps < np.maximum.accumulate(stamps)
    count = int(np.count_nonzero(late))
    if count > _MOVED * n:
        return None
    intervals = np.diff(stamps[order]).astype(np.float64)
    usual = _usual(stamps)
    place = np.flatnonzero(late[order])
    beside = np.unique(np.clip(np.concatenate((place - 1, place)), 0, n - 2))
    gaps = intervals[beside]
    fits = bool((gaps >= _APART * usual).all() and (gaps <= _NEAR * usual).all())
    return (order, count) if fits and usual > 0 else None


def _wrong(stamps: NDArray[Any], back: NDArray[np.intp]) -> NDArray[np.int64] | None:
    """Rows whose stamps fit nowhere, while time goes on as if nothing were between the rows before and after them."""
    n = len(stamps)
    wrong = []
    for at in back.tolist():  # one in a hundred rows at most
        if at > 0 and stamps[at - 1] <= stamps[at + 1]:
            wrong.append(at)  # too late
        elif at + 2 < n and stamps[at] <= stamps[at + 2]:
            wrong.append(at + 1)  # too early
        elif at == 0:
            wrong.append(0)  # before the clock was set
        else:
            return None
    left = np.diff(np.delete(stamps, wrong)).astype(np.float64)
    usual = _usual(stamps)
    at = np.clip(np.asarray(wrong) - 1 - np.arange(len(wrong)), 0, len(left) - 1)
    if left.min() < 0 or (left[at] > (_NEAR + 1) * usual).any() or not usual > 0:
        return None
    return np.asarray(wrong, dtype=np.int64)


def _without_twins(
    stamps: NDArray[Any],
    intervals: NDArray[Any],
    samples: Sequence[NDArray[Any]],
    where: Callable[[int], str],
    rows: NDArray[np.int64] | None,
) -> tuple[NDArray[np.bool_], Finding | None]:
    """Rows without the second of each pair that was written twice; all rows if the clock is just coarse."""
    again = np.flatnonzero(intervals == 0) + 1
    same = np.ones(len(again), dtype=bool)
    for channel in samples:
        one, other = channel[again - 1], channel[again]
        same &= (one == other) | ((one != one) & (other != other))
    copies = bool(samples) and np.count_nonzero(same) >= _COPIES * len(again)
    if not copies:
        if len(again) > _TWICE * len(intervals):
            return np.ones(0, dtype=bool), None
        apart = np.diff(again)
        if len(apart) >= 4 and float(np.std(apart)) < _REGULAR * float(np.mean(apart)):
            return np.ones(0, dtype=bool), None  # the clock's step is a little longer than the interval
    single = np.ones(len(stamps), dtype=bool)
    single[again] = False
    if np.count_nonzero(single) < 2:
        return np.ones(0, dtype=bool), None
    place = where(_row(rows, int(again[0])))
    share = len(again) / np.count_nonzero(single)
    factor = float(np.sqrt((1 + 3 * share) / (1 + share))) if share <= 1 else float(np.sqrt(1 + share))
    held = "stamp and samples" if same.all() else "the stamp"
    return single, Finding(
        code="duplicate_samples",
        severity="warning",
        message=f"{len(again)} of {len(stamps)} rows repeat {held} of the row before, the first: {place}",
        where=place,
        size=len(again),
        effect=(
            "the second of each is left out, so nothing is changed; kept, and taken at the rate of the sensor, they would"
            f" make a random walk {_larger(factor)}"
        ),
        remedy="look at the program that writes the log: it writes rows twice",
    )


def _larger(factor: float) -> str:
    return f"{factor:.3g} times as large" if factor >= 1.1 else f"{100 * (factor - 1):.2g} % larger"
