"""Consecutive duplicate rows: written twice, or written in place of a lost row."""

from __future__ import annotations

import math

import numpy as np

from sigmatau.arrays import Bools
from sigmatau.findings.finding import Finding
from sigmatau.findings.values import RepeatedSamples
from sigmatau.quality.samples.common import TIMES_CHANCE, beyond_chance, mask_of_runs, spans_of_runs
from sigmatau.quality.samples.masking import MaskedFinding
from sigmatau.quality.samples.repeated_samples import repeats, runs_of_places
from sigmatau.record.streams import Stream

# Smallest number of rows that are equal on all axes. [samples] Judgement: one or two may be equal by chance.
_MIN_ROWS = 3
# Largest share of rows in which neighbours on the finest axis are equal by chance. [1] Judgement: coarser axes stay at
# one value together.
_MAX_CHANCE = 1e-3
# Longest run of copies that is reported as such. [samples] Judgement: longer runs are stuck samples.
_MAX_RUN = 3


def copied_rows(stream: Stream) -> Bools | None:
    """Samples that equal the previous one on all axes of a stream, if chance does not explain their number; otherwise None.

    If neighbours on axis c are equal by chance in a share p_c of all rows, they are equal on all axes in ∏p_c.
    `sigmatau.quality.samples.repeated_samples` judges a stream with one axis.
    """
    if len(stream.channels) < 2 or any(t.kind == "accumulated" for t in stream.samples.transforms):
        return None
    together: Bools | None = None
    counts = []
    for channel in stream.channels:
        x = stream.column(channel)
        equal = x[1:] == x[:-1]
        together = equal if together is None else together & equal
        if np.count_nonzero(together) < _MIN_ROWS:
            return None
        counts.append(int(np.count_nonzero(equal)))
    if together is None:
        return None
    n, count = len(together), int(np.count_nonzero(together))
    chances = [(each - count) / max(n - count, 1) for each in counts]
    by_chance = n * math.prod(chances)
    if min(chances) > _MAX_CHANCE or count < beyond_chance(by_chance, times=TIMES_CHANCE):
        return None
    rows = np.concatenate(([False], together))
    first, lengths = runs_of_places(np.flatnonzero(rows))
    long = lengths > _MAX_RUN
    rows &= ~mask_of_runs(len(rows), first[long], lengths[long])
    return rows if np.count_nonzero(rows) >= _MIN_ROWS else None


def copies(stream: Stream) -> list[MaskedFinding]:
    """Report duplicate rows, if they are too few for a sensor that is slower than its log. At most one finding."""
    rows = copied_rows(stream)
    if rows is None or repeats(stream) is not None:
        return []
    share, rate = float(rows.mean()), stream.grid.rate
    first, lengths = runs_of_places(np.flatnonzero(rows))
    spans, more_spans = spans_of_runs(stream, first, lengths)
    finding = Finding(
        details=RepeatedSamples(
            pattern="rows",
            copies=int(rows.sum()),
            share=share,
            times=1 / (1 - share),
            shortest=1,
            longest=int(lengths.max()) + 1,
            log_rate=rate,
            sensor_rate=rate * (1 - share),
            rate_given=stream.grid.source.given_alone,
            sigma_one_sample=1.0,
            right_from=1,
            walk_at_log_rate=1.0,
            walk_at_sensor_rate=1.0,
        ),
        severity="warning",
        channels=tuple(stream.channels),
        spans=spans,
        more_spans=more_spans,
        size=share,
    )
    return [(finding, np.repeat(rows[:, None], len(stream.channels), axis=1))]
