"""Single rows that are there twice: a program that writes a row again, or fills a lost one with the last."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from sigmatau.findings.finding import Finding
from sigmatau.quality.samples.common import place, when
from sigmatau.quality.samples.masking import leave_out_option, spans_of
from sigmatau.quality.samples.repeated_samples import repeats, runs_of_equal
from sigmatau.record.streams import Stream

__all__ = ["copied_rows", "copies", "copy_masks"]

# Rows equal on all axes at once must be so many, and so many times what chance makes of the axes' own equal neighbours, one
# axis at least being so fine that its neighbours are seldom equal. Longer runs are told as stuck samples.
_LEAST, _TIMES, _SIGMAS, _FINE, _LONGEST = 3, 10.0, 6.0, 1e-3, 4


def copied_rows(stream: Stream) -> NDArray[np.bool_] | None:
    """Samples that are equal to the one before on all axes of a stream, where chance does not make them; None if none are.

    If neighbours on axis c are equal by chance in a part p_c of all rows, they are so on all axes in ∏p_c.

    Parameters
    ----------
    stream : Stream
        Of two axes or more; of one, equal neighbours are judged by `sigmatau.quality.samples.repeated_samples`.

    Returns
    -------
    ndarray of bool, shape (n,), or None
    """
    if len(stream.channels) < 2 or any(t.kind == "accumulated" for t in stream.samples.transforms):
        return None
    together: NDArray[np.bool_] | None = None
    counts = []
    for channel in stream.channels:
        x = stream.column(channel)
        equal = x[1:] == x[:-1]
        together = equal if together is None else together & equal
        if np.count_nonzero(together) < _LEAST:
            return None
        counts.append(int(np.count_nonzero(equal)))
    if together is None:
        return None
    n, count = len(together), int(np.count_nonzero(together))
    chances = [(each - count) / max(n - count, 1) for each in counts]
    by_chance = n * math.prod(chances)
    if min(chances) > _FINE or count < _TIMES * by_chance + _SIGMAS * math.sqrt(by_chance):
        return None
    rows = np.concatenate(([False], together))
    first, lengths = runs_of_equal(np.cumsum(~rows).astype(np.float64), least=_LONGEST + 1)
    for start, size in zip(first.tolist(), lengths.tolist(), strict=True):
        rows[start : start + size] = False
    return rows if np.count_nonzero(rows) >= _LEAST else None


def copies(stream: Stream) -> list[Finding]:
    """Rows that are there twice, where they are too few to be a sensor slower than its log, see `repeated_samples`.

    Parameters
    ----------
    stream : Stream

    Returns
    -------
    list of Finding
        At most one ``"repeated_samples"``, an info. A part h of copies makes N² larger by 1 + 2h: each pair counts four
        times in the sum that two samples would count in.
    """
    rows = copied_rows(stream)
    if rows is None or repeats(stream) is not None:
        return []
    count, share = int(rows.sum()), float(rows.mean())
    factor = math.sqrt(1 + 2 * share)
    first = int(np.argmax(rows))
    what = "written twice, or lost and filled with the one before"
    longer = ""
    if stream.grid.source == "given":
        longer = (
            f"; if they were written twice, {stream.grid.rate:.6g} Hz counts them as time: every τ is"
            f" {100 * share:.2g} % too long"
        )
    return [
        Finding(
            code="repeated_samples",
            severity="info",
            message=(
                f"{count} of {stream.grid.n} samples ({100 * share:.2g} %) of {stream.name} equal the one before on all"
                f" {len(stream.channels)} axes, which chance does not make: {what}; the first at {when(first, stream)}"
            ),
            where=place(first, stream),
            size=share,
            effect=f"white noise is {100 * (factor - 1):.2g} % larger at all τ but the shortest{longer}",
            changes=(("random_walk", factor),),
            remedy=f"{leave_out_option(stream, spans_of(rows), kind='copies')} takes them for missing; look at the program"
            " that writes the log",
        )
    ]


def copy_masks(stream: Stream) -> list[NDArray[np.bool_]]:
    """By channel, the samples that `copies` tells of."""
    rows = copied_rows(stream)
    return [np.zeros(stream.grid.n, dtype=bool) if rows is None else rows.copy() for _ in stream.channels]
