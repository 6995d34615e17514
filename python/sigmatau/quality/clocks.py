"""Comparison of the clocks of several records of one unit. Its lines, resonances and filter corners have the same
frequencies in all records.

A record whose frequencies all differ from those of the other records by one factor was read with a wrong rate, or sampled by
another clock.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import Literal

import numpy as np

from sigmatau.findings.finding import Finding
from sigmatau.findings.rates import ClockOff
from sigmatau.fitting.fitted_values import Interval
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.frozen import frozen

# Number of lines of a channel that are compared. [1] Judgement: weaker lines are rarely in all records.
_STRONGEST = 8
# Largest logarithm of the factor of a clock that is searched for. [1] Judgement: a larger one is a wrong rate, and
# marks would be mistaken for each other.
_FARTHEST = math.log(1.25)
# Smallest number of marks that must show the factor. [1] Judgement: two may have the same ratio by chance.
_MIN_MARKS = 3
# Smallest share of the marks that agree with the factor within their errors. [1] Judgement: a quarter of the lines has
# other causes.
_MIN_SHARE_OF_MARKS = 0.75
# Largest ratio of the marks without the factor to those with it. [1] Judgement: see `_MIN_SHARE_OF_MARKS`.
_CONTRARY = 0.25
# Share of unmoved marks above which two records have the same clock. [1] Judgement: half of the marks.
_MIN_UNMOVED = 0.5
# Error of a line over the width of its excluded band, which also contains the foot of the line. [1] Judgement: the line
# fills half of the band, and the error of its centre is a quarter of that.
_FOOT = 0.125
# Largest multiple of the lowest line that another line may be. [1] Judgement: higher ones match by chance.
_HIGHEST_MULTIPLE = 20


@frozen(kw_only=False)
class Mark:
    """A frequency of a record that does not depend on its noise.

    Attributes
    ----------
    channel : str
    kind : {"line", "resonance", "corner"}
        Kind of the frequency.
    frequency : float
        [Hz]
    error : float
        Half width of its interval, over the frequency. [1]
    """

    channel: str
    kind: Literal["line", "resonance", "corner"]
    frequency: float
    error: float


@frozen(kw_only=False)
class _Shift:
    """Marks of a record, compared with those of another record."""

    same: bool  # whether most marks have the same frequency
    factor: float | None  # logarithm of the common factor of the moved marks; None if they have none
    error: float
    marks: int


def collect_marks(fits: Mapping[str, NoiseFit]) -> tuple[Mark, ...]:
    """The marks of a record, from its fits by channel."""
    marks: list[Mark | None] = []
    for channel, fitted in fits.items():
        lines = fitted.sinusoid[:_STRONGEST]
        marks += [_mark(channel, "line", line.frequency, _FOOT) for line in lines]
        marks += [_mark(channel, "resonance", process.frequency, 0.5) for process in fitted.resonance]
        if (response := fitted.response) is not None and response.corner is not None:
            corner = Interval(value=response.corner, low=response.low, high=response.high, unit="Hz")
            marks.append(_mark(channel, "corner", corner, 0.5))
    return tuple(mark for mark in marks if mark is not None)


def _mark(channel: str, kind: Literal["line", "resonance", "corner"], frequency: Interval, part: float) -> Mark | None:
    """Build a mark whose error is `part` of its interval; None without an interval, or if it is wider than the frequency."""
    value, low, high = frequency.value, frequency.low, frequency.high
    if value and low is not None and high is not None and 0 < high - low < value:
        return Mark(channel, kind, value, part * (high - low) / value)
    return None


def compare_clocks(records: Mapping[str, Sequence[Mark]]) -> dict[str, Finding]:
    """Find the records whose clock is wrong; the finding of each states its factor.

    Parameters
    ----------
    records : mapping of str to sequence of Mark
        Marks of each record. With fewer than three records, it is not clear which clock is wrong.
    """
    shifts = {(a, b): _shift(records[a], records[b]) for a, b in combinations(records, 2)}
    off: dict[str, Finding] = {}
    for name in records:
        names = [name2 for name2 in records if name2 != name]
        shifted = [(name2, shifts.get((name, name2)) or _reversed(shifts[name2, name])) for name2 in names]
        shifted = [(name2, shift) for name2, shift in shifted if shift.factor is not None]
        if len(shifted) < 2 or 2 * len(shifted) <= len(names):
            continue
        pairs = list(combinations([name2 for name2, _ in shifted], 2))
        alike = sum((shifts.get((a, b)) or shifts[b, a]).same for a, b in pairs)
        logarithms = np.array([shift.factor for _, shift in shifted], dtype=float)
        middle = float(np.median(logarithms))
        error = float(np.median([shift.error for _, shift in shifted]))
        if 2 * alike <= len(pairs) or np.abs(logarithms - middle).max() > max(3 * error, 0.1 * abs(middle)):
            continue
        factor = math.exp(middle)
        details = ClockOff(
            factor=factor,
            low=math.exp(middle - error),
            high=math.exp(middle + error),
            marks=min(shift.marks for _, shift in shifted),
            others=len(shifted),
        )
        off[name] = Finding(details=details, severity="warning", size=factor)
    return off


def _reversed(shift: _Shift) -> _Shift:
    factor = None if shift.factor is None else -shift.factor
    return _Shift(shift.same, factor, shift.error, shift.marks)


def _shift(ours: Sequence[Mark], theirs: Sequence[Mark]) -> _Shift:
    """Find the factor between the frequencies of two records."""
    pairs = [
        (k, math.log(a.frequency / b.frequency), a.error + b.error)
        for k, a in enumerate(ours)
        for b in theirs
        if (a.channel, a.kind) == (b.channel, b.kind) and abs(math.log(a.frequency / b.frequency)) < _FARTHEST
    ]
    comparable = min(len(ours), len(theirs))
    unmoved = _matching_marks(pairs, 0.0)
    same = bool(unmoved) and len(unmoved) >= _MIN_UNMOVED * comparable
    if comparable < _MIN_MARKS or not pairs:
        return _Shift(same, None, 0.0, 0)
    shift = max((d for _, d, _ in pairs), key=lambda d: (len(_matching_marks(pairs, d) - unmoved), -abs(d)))
    shifted = _matching_marks(pairs, shift)
    moved, contrary = shifted - unmoved, unmoved - shifted
    enough = len(moved) >= _MIN_MARKS and len(shifted) >= _MIN_SHARE_OF_MARKS * comparable
    if not enough or len(contrary) > _CONTRARY * len(moved) or _one_origin([ours[k] for k in moved]):
        return _Shift(same, None, 0.0, 0)
    measured = [(d, e) for k, d, e in pairs if k in moved and abs(d - shift) <= e]
    weights = np.array([1 / max(e, 1e-9) ** 2 for _, e in measured])
    factor = float(np.average([d for d, _ in measured], weights=weights))
    return _Shift(same, factor, float(1 / np.sqrt(weights.sum())), len(moved))


def _matching_marks(pairs: Sequence[tuple[int, float, float]], shift: float) -> set[int]:
    """Marks that agree, after a shift and within both errors, with a mark of the other record."""
    return {k for k, d, e in pairs if abs(d - shift) <= e}


def _one_origin(marks: Sequence[Mark]) -> bool:
    """Whether all marks may be a line and its multiples: a fan with another speed does not indicate a wrong clock."""
    if any(mark.kind != "line" for mark in marks):
        return False
    lowest = min(marks, key=lambda mark: mark.frequency)
    for mark in marks:
        times = mark.frequency / lowest.frequency
        nearest = round(times)
        if nearest > _HIGHEST_MULTIPLE or abs(times - nearest) > times * (mark.error + lowest.error):
            return False
    return True
