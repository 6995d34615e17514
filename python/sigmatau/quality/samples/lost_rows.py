"""Single rows of zeros: lost messages for which zeros were written."""

from __future__ import annotations

import math

import numpy as np

from sigmatau.arrays import Bools, median_and_spread
from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.values import Dropout
from sigmatau.quality.facts import stream_fact
from sigmatau.quality.samples.common import block_rms, change_of_white, longest_spans, mask_of_runs, present, sample_of
from sigmatau.quality.samples.masking import masked
from sigmatau.quality.samples.repeated_samples import runs_of_places
from sigmatau.quality.samples.resolution import resolution
from sigmatau.quality.samples.stuck_samples import WARN_SHARE, extent, stuck_runs, zero_rate, zero_runs
from sigmatau.record.streams import Stream

__all__ = ["dropout_masks", "lost_rows", "stuck_masks"]

# Distance of 0 from the level of a single channel, in standard deviations, beyond which noise does not reach it.
_BEYOND_NOISE = 12.0

# Nearer zeros are lost samples if no tail leads to them: ten times as many as lie within one standard deviation of 0. The
# end of a range that noise touches beyond 4 standard deviations has 0.02 times as many.
_BEYOND_TAIL = 4.0

# Least number of rows in which all axes are 0, and how many times more than by chance: axes whose numbers are coarse are 0
# together without a fault.
_MIN_ROWS, _TIMES_CHANCE, _SIGMAS = 3, 10.0, 6.0

_LOOKED_AT = 1 << 17

_RUN = 5  # rows of zeros in a row that are a run, see `stuck_samples`
_WARN_FACTOR = 1.02  # factor of the random walk from which on the finding is a warning


def zero_rows(stream: Stream) -> Bools | None:
    """Samples that are 0 on all axes of a stream at once more often than by chance; None if there are none.

    The chance of a 0 on one axis is q/(√(2π)·s) at most for steps q and noise of standard deviation s. A stream of one
    channel is judged where 0 is more than 12 standard deviations from its level.
    """
    together = np.ones(stream.grid.n, dtype=bool)
    for channel in stream.channels:
        zero = zero_rate(stream, channel)
        if zero is None:
            return None
        together &= stream.column(channel) == zero
        if np.count_nonzero(together) < _MIN_ROWS:
            return None
    count = int(np.count_nonzero(together))
    chances = [_chance_of_zero(stream, channel) for channel in stream.channels]
    if len(stream.channels) == 1 and chances[0] > 0:
        return None
    by_chance = len(together) * math.prod(chances)
    if count < _TIMES_CHANCE * by_chance + _SIGMAS * math.sqrt(by_chance) or count > len(together) / 2:
        return None
    return together


def _chance_of_zero(stream: Stream, channel: str) -> float:
    """The largest part of a channel's samples that can be 0 without a fault."""
    x = present(sample_of(stream, channel, most=_LOOKED_AT))
    if len(x) < 2:
        return 1.0
    (middle, spread), zero = median_and_spread(x), zero_rate(stream, channel)
    if zero is not None and spread > 0 and abs(middle - zero) > _BEYOND_NOISE * spread:
        return 0.0
    if zero is not None and spread > 0 and abs(middle - zero) > _BEYOND_TAIL * spread:
        lost = int(np.count_nonzero(x == zero))
        about = int(np.count_nonzero(np.abs(x - zero) < spread)) - lost
        if lost >= _MIN_ROWS and lost > _TIMES_CHANCE * about + _SIGMAS * math.sqrt(about):
            return 0.0
    found = resolution(stream, channel)
    if found is None:
        # Numbers without a visible step are no coarser than their differences show.
        return 1.0 if 2 * len(np.unique(x)) < len(x) else 1.0 / math.sqrt(len(x))
    scale = block_rms(x - middle)
    return min(found.step / (math.sqrt(2 * math.pi) * scale), 1.0) if scale > 0 else 1.0


@stream_fact
def lost_rows(
    stream: Stream, *, warn_share: float = WARN_SHARE, warn_factor: float = _WARN_FACTOR
) -> tuple[list[Finding], Stream]:
    """The finding ``dropout`` for rows of zeros outside long runs, and the stream without them.

    One finding for all axes, long runs of zeros included, a warning from the thresholds on: part of the record, and factor
    of the random walk. None, and the same stream, where all zeros are in runs, see
    `sigmatau.quality.samples.stuck_samples`.
    """
    rows = zero_rows(stream)
    if rows is None:
        return [], stream
    first, lengths = runs_of_places(np.flatnonzero(rows))
    if np.count_nonzero(lengths < _RUN) < _MIN_ROWS:
        return [], stream
    tau0 = stream.grid.tau0
    changes = {c: change_of_white(stream.column(c), rows, tau0) for c in stream.channels}
    strongest = max(changes, key=lambda c: changes[c][0])
    factor, tau = changes[strongest]
    share = float(rows.mean())
    finding = Finding(
        details=Dropout(strongest=strongest, tau=tau, **extent(rows, (first, lengths), tau0)),
        severity="warning" if share > warn_share or factor > warn_factor else "info",
        channels=tuple(stream.channels),
        spans=longest_spans(stream, first, lengths),
        size=share,
        factors=(("random_walk", factor),),
    )
    return [finding], masked(stream, rows)


def dropout_masks(stream: Stream) -> list[Bools]:
    """By channel, the samples that the findings ``dropout`` are about."""
    rows = zero_rows(stream)
    masks = []
    for channel in stream.channels:
        runs = mask_of_runs(stream.grid.n, *zero_runs(stream, channel, stream.column(channel)))
        masks.append(runs if rows is None else runs | rows)
    return masks


def stuck_masks(stream: Stream) -> list[Bools]:
    """By channel, the runs of equal samples that are longer than the noise can explain."""
    return [mask_of_runs(stream.grid.n, *stuck_runs(stream, c, stream.column(c))) for c in stream.channels]
