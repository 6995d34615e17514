"""Dropouts: zeros in place of lost samples, in runs of one channel or in rows of all channels."""

from __future__ import annotations

import math

import numpy as np

from sigmatau.arrays import Bools, distinct, median_and_spread
from sigmatau.findings.values import Dropout
from sigmatau.quality.samples.common import TIMES_CHANCE, beyond_chance, block_rms, mask_of_runs, present, take_samples
from sigmatau.quality.samples.masking import MaskedFinding
from sigmatau.quality.samples.resolution import resolution, usual_value
from sigmatau.quality.samples.stuck_samples import held, zero_rate, zero_runs
from sigmatau.record.streams import Stream

# Distance of 0 from the mean that the noise of a channel does not reach. [standard deviations] Judgement: beyond the
# tail of any sensor.
_BEYOND_NOISE = 12.0
# Distance above which zeros are lost samples if no tail reaches them: there are ten times as many zeros as samples
# within one standard deviation of 0. [standard deviations] Derived: for noise at an end of its range the ratio is 0.02.
_BEYOND_TAIL = 4.0
# Smallest number of rows in which all axes are 0; fewer are reported only if less than `_NO_CHANCE` are expected by
# chance. [samples] Judgement: one or two may be true zeros.
_MIN_ROWS = 3
# Expected number of zero rows by chance below which one or two are reported. [1] Judgement: one false alarm in 1000
# such records.
_NO_CHANCE = 1e-3
# Number of samples used to compute the probability of a zero. [samples] Judgement: limits the time.
_EXAMINED = 1 << 17


def zero_rows(stream: Stream) -> Bools | None:
    """Samples that are 0 on all axes of a stream at the same time, if chance does not explain their number; otherwise None.

    The chance of a 0 on one axis is at most q/(√(2π)·s) for steps q and noise of standard deviation s. A stream with one
    channel is judged if 0 is more than 12 standard deviations from its mean.
    """
    together, counts = np.ones(stream.grid.n, dtype=bool), list[int]()
    for channel in stream.channels:
        zero = zero_rate(stream, channel)
        if zero is None:
            return None
        here = stream.column(channel) == zero
        counts.append(int(np.count_nonzero(here)))
        together &= here
        if not together.any():
            return None
    count = int(np.count_nonzero(together))
    chances = [_chance_of_zero(stream, channel) for channel in stream.channels]
    if len(stream.channels) == 1 and chances[0] > 0:
        return None
    # Zeros outside of such rows: axes with a range that ends at 0 may be 0 together by chance.
    elsewhere = [(each - count) / max(len(together) - count, 1) for each in counts]
    by_chance = len(together) * max(math.prod(chances), math.prod(elsewhere))
    if count < beyond_chance(by_chance, times=TIMES_CHANCE) or count > len(together) / 2:
        return None
    if count < _MIN_ROWS and by_chance > _NO_CHANCE:
        return None
    return together


def _chance_of_zero(stream: Stream, channel: str) -> float:
    """Largest share of the samples of a channel that can be 0 without a fault."""
    x = present(take_samples(stream, channel, count=_EXAMINED))
    if len(x) < 2:
        return 1.0
    (middle, spread), zero = median_and_spread(x), zero_rate(stream, channel)
    steps = resolution(stream, channel)
    if steps is not None:  # with coarse numbers, more than half may be equal
        spread = max(spread, steps.step)
    if zero is not None and spread > 0 and abs(middle - zero) > _BEYOND_NOISE * spread:
        return 0.0
    if zero is not None and spread > 0 and abs(middle - zero) > _BEYOND_TAIL * spread:
        lost = int(np.count_nonzero(x == zero))
        about = int(np.count_nonzero(np.abs(x - zero) < spread)) - lost
        if lost >= _MIN_ROWS and lost > beyond_chance(about, times=TIMES_CHANCE):
            return 0.0
    if steps is None:
        # If half of n numbers occur once, no number has a share of much more than 1/n.
        return 1.0 if 2 * len(distinct(x)) < len(x) else min(4 / len(x), 1.0)
    scale = block_rms(x - middle)
    chance = steps.step / (math.sqrt(2 * math.pi) * scale) if scale > 0 else 1.0
    return min(max(chance, usual_value(stream, channel)), 1.0)


def dropouts(stream: Stream) -> list[MaskedFinding]:
    """Report zeros in place of lost samples: rows that are 0 on all axes, and runs of zeros of one axis. At most one
    finding.
    """
    rows = zero_rows(stream)
    masks = [mask_of_runs(stream.grid.n, *zero_runs(stream, channel)) for channel in stream.channels]
    mask = np.stack(masks if rows is None else [runs | rows for runs in masks], axis=1)
    return held(Dropout, stream, mask)
