"""The sampling rate, from time stamps that may be coarse, bunched, in any unit, and now and then wrong."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau import units
from sigmatau.errors import DataError, OptionError
from sigmatau.results import Finding

__all__ = ["Fit", "check_order", "fit", "mismatch", "without_unit"]

_RARE = 1000  # one interval in so many may be a gap
_LONG = 20.0  # times as long as all the intervals that are not rare
_LATE = 1.5  # sample intervals without a sample
_AGREE = 1e-3  # relative difference of two rates that are the same
_PLAUSIBLE = (0.01, 1e5)  # sampling rates of inertial sensors. [Hz]
_OURS = (6e8, 4e9)  # 1989 to 2096, counted from 1970. [s]
_EPOCH = 1e8  # a clock beyond this counts from long ago. [s]


@dataclass(frozen=True, slots=True, kw_only=True)
class Fit:
    """What the stamps say.

    Attributes
    ----------
    rate : float
        Sampling rate. [Hz]
    start : float
        First stamp, whole seconds taken off if it counts from long ago. [s]
    source : str
        How the rate was found, in words.
    notes : tuple of str
    findings : tuple of Finding
    """

    rate: float
    start: float
    source: str
    notes: tuple[str, ...]
    findings: tuple[Finding, ...]


def check_order(stamps: NDArray[Any], where: Callable[[int], str], name: str) -> NDArray[np.float64]:
    """The intervals between stamps, in their own unit; shape (n - 1,).

    Integers are subtracted as integers: nanoseconds since 1970 do not fit into a double.

    Parameters
    ----------
    stamps : ndarray of int64 or float64, shape (n,)
    where : callable
        Place of a row in the file, for the messages.
    name : str
        The column, as messages name it.

    Raises
    ------
    DataError
        If time goes backwards (even if a rate is given: the samples are then not in order), or stands still.
    """
    if stamps.dtype.kind in "iu" and int(stamps.max()) - int(stamps.min()) >= 1 << 62:
        stamps = stamps.astype(np.float64)
    intervals = np.diff(stamps)
    signed = stamps.dtype.kind == "f" or stamps.dtype == np.int64  # in others a step back is a large one forward
    if not signed or intervals.min() < 0:
        back = np.flatnonzero(stamps[1:] < stamps[:-1])
        if len(back):
            row = int(back[0]) + 1
            times = "" if len(back) == 1 else f", and {len(back) - 1} times more further on"
            raise DataError(
                f", {where(row)}: time goes backwards in column {name}, from {stamps[row - 1]} to {stamps[row]}{times};"
                f" sort the rows, cut the file there{_wrapped(stamps, row)}, or leave the stamps out by --channels time=none"
                " --rate HZ"
            )
    if stamps[0] == stamps[-1]:
        raise DataError(
            f"all stamps in column {name} are {stamps[0]}, so they say no rate; name another column by --channels time=…"
            " (in a bag or MCAP --channels time=log_time), or leave the stamps out by --channels time=none --rate HZ"
        )
    return intervals.astype(np.float64, copy=False)


def _wrapped(stamps: NDArray[Any], row: int) -> str:
    """What to say of a step back that is the range of a counter."""
    back = float(stamps[row - 1]) - float(stamps[row])
    bits = next((bits for bits in (16, 32) if 0.95 * 2**bits < back <= 2**bits), None)
    return "" if bits is None else f", add 2^{bits} to the rest if it is a counter of {bits} bits that began anew"


def fit(
    stamps: NDArray[Any],
    intervals: NDArray[np.float64],
    second: float,
    where: Callable[[int], str],
    name: str,
) -> Fit:
    """The sampling rate that the stamps say: samples over time, gaps taken out.

    The mean interval over the whole record is right for stamps that come in bunches or are printed coarsely, of which a
    median would make nonsense. It is wrong only by what is no sampling at all: so intervals more than 20 times as long as
    all but the longest thousandth are left out.

    Parameters
    ----------
    stamps : ndarray, shape (n,)
    intervals : ndarray, shape (n - 1,)
        From `check_order`.
    second : float
        One unit of the stamps. [s]
    where, name
        As in `check_order`.
    """
    n = len(intervals)
    rare = min(max(math.ceil(n / _RARE), 3), n // 4)
    shortest, longest = float(intervals.min()), float(intervals.max())
    kept = intervals
    if not (shortest > 0 and longest <= _LONG * shortest):  # else no interval can be so long
        usual = float(np.partition(intervals, n - 1 - rare)[n - 1 - rare])
        kept = intervals[intervals <= _LONG * usual] if usual > 0 else intervals
    interval = float(kept.sum()) / len(kept)
    tau0 = interval * second
    rate = 1.0 / tau0

    first = int(stamps[0]) if stamps.dtype.kind in "iu" else float(stamps[0])
    start = first * second
    notes: tuple[str, ...] = ()
    source = f"time stamps in column {name}"
    if abs(start) >= _EPOCH:
        ticks = round(1 / second) if second < 1 else 1
        whole, rest = divmod(first, ticks) if second <= 1 else (0, first)
        start = float(rest) * second
        notes = (f"{int(whole)} s taken off the time stamps",)
    if len(kept) < n:
        source += f", {n - len(kept)} gap{'s' if n - len(kept) > 1 else ''} left out"
    findings = (*_implausible(rate), *_irregular(intervals, interval, second, where))
    return Fit(rate=rate, start=start, source=source, notes=notes, findings=findings)


def _implausible(rate: float) -> tuple[Finding, ...]:
    if _PLAUSIBLE[0] <= rate <= _PLAUSIBLE[1]:
        return ()
    return (
        Finding(
            code="implausible_rate",
            severity="warning",
            message=f"the time stamps say {rate:.6g} Hz",
            effect="no usual rate of a sensor: check the unit of the stamps, --unit time=s|ms|us|ns, or give --rate HZ",
        ),
    )


def _irregular(
    intervals: NDArray[np.float64], interval: float, second: float, where: Callable[[int], str]
) -> tuple[Finding, ...]:
    if intervals.max() <= _LATE * interval:
        return ()
    # Stamps that repeat are coarser than the sampling, and the clock's own step is no gap.
    repeated = np.count_nonzero(intervals == 0) > 0.01 * len(intervals)
    step = float(intervals[intervals > 0].min()) if repeated else 0.0
    late = intervals > _LATE * interval + step * (1 + 1e-6)
    count = int(np.count_nonzero(late))
    if not count:
        return ()
    row = int(np.argmax(intervals))
    longest = intervals[row] * second
    tau0 = interval * second
    return (
        Finding(
            code="irregular_stamps",
            severity="warning",
            message=(
                f"{count} of {len(intervals)} intervals between time stamps are longer than {_LATE:g} sample intervals;"
                f" the longest, {longest:.6g} s, ends on {where(row + 1)}"
            ),
            effect=(
                f"samples are analysed as if evenly spaced by {tau0:.6g} s, which is right if the stamps alone are late;"
                " if samples were lost, they bend the curve"
            ),
        ),
    )


def mismatch(given: float, found: Fit) -> tuple[Finding, ...]:
    """A finding if the rate that was given is not that of the stamps."""
    if abs(found.rate / given - 1) <= _AGREE:
        return ()
    return (
        Finding(
            code="rate_mismatch",
            severity="warning",
            message=f"the rate given is {given:.6g} Hz, the time stamps say {found.rate:.6g} Hz",
            effect=(
                f"the given rate is used; if it is wrong, averaging times are off by {found.rate / given:.4g}, a random walk"
                " by the root of that, a rate random walk by its inverse root"
            ),
        ),
    )


def without_unit(stamps: NDArray[Any], intervals: NDArray[np.float64], name: str) -> OptionError:
    """The question for the unit of the stamps, with the rate that each unit would make."""
    mean = float(intervals.sum()) / len(intervals)
    rates = [(symbol, 1 / (mean * units.find(symbol).factor)) for symbol in ("s", "ms", "us", "ns")]
    likely = [(symbol, rate) for symbol, rate in rates if _PLAUSIBLE[0] <= rate <= _PLAUSIBLE[1]] or rates
    offered = ", ".join(f"as {symbol} {float(f'{rate:.4g}'):g} Hz" for symbol, rate in likely)
    # A clock that counts from 1970 has one unit in which it shows a year of our time; else a rate near 100 Hz is likeliest.
    first = float(stamps[0])
    example = min(
        likely,
        key=lambda row: (not _OURS[0] <= first * units.find(row[0]).factor <= _OURS[1], abs(math.log(row[1] / 100))),
    )
    return OptionError(
        f"the unit of the time stamps in column {name} is not stated ({stamps[0]}, {stamps[1]} …: {offered});"
        f" say e.g. --unit time={example[0]}, or give --rate HZ",
        option="unit",
    )
