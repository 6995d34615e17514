"""Thresholds of the spike detector, neighbours of samples, and medians of rows."""

from __future__ import annotations

from statistics import NormalDist

import numpy as np

from sigmatau.arrays import Floats, Ints
from sigmatau.frozen import frozen

NORMAL_QUARTILE = NormalDist().inv_cdf(0.75)  # median of absolute standard normal deviates


@frozen
class SpikeThresholds:
    """Thresholds of spikes: `find_spikes`, `dense_spikes`, and `tails`. Standard deviations are those of the noise."""

    false_spikes: float = 1e-4
    """Spikes that noise alone makes in a record, on average. [samples] Judgement: one false alarm in 10⁴ channels.
    The residual (a sample less a median of its neighbours) of Gaussian noise no smoother than a random walk is
    Gaussian in its tail, and a spike must be one on both sides."""

    least_height: float = 6.0
    """Height of a spike, at least. [standard deviations] Judgement: a smaller one in a short record would be a guess
    at its tail."""

    steps: float = 1.0
    """Height that is added for rounding. [steps] Derived: a step q moves a sample and a median by q/2 each."""

    unseen: float = 0.3
    """Noise below it leaves no trace in the scatter of numbers with this step. [steps] Study: docs/study/coarse.md;
    noise of 0.2 steps shows 0.06 to 0.5."""

    spoiled: float = 2.0
    """Scale of blocks over that of the median beyond which most blocks of 32 residuals contain a spike. [1] Derived:
    from some 2 % of spikes on."""

    tail_from: float = 4.0
    """Beginning of the tail. [standard deviations] Derived: beyond it noise has 1.6 of the residuals that the scale
    is taken from."""

    tail_count: int = 12
    """Residuals there from which on the tail is examined. [samples] Derived: so many are not noise, see `tail_from`."""

    rounds: int = 8
    """How often the rest is searched again. [1] Judgement: spikes beside each other hide each other."""

    min_residuals: int = 1024
    """Samples that have all four neighbours before them, below which samples with two of these count too. [samples]
    Judgement: their scale is known to 2 %."""

    min_samples: int = 32
    """Samples from which a scale can be taken. [samples] Judgement: one block of `block_rms`."""

    side: int = 4
    """Neighbours on either side. [samples] Derived: their median tolerates one other spike among them."""

    wide: int = 16
    """The same where two of four are often spikes. [samples] Judgement: 20 % of spikes are seldom half of 16."""

    stretch: int = 1024
    """Length of the stretches that the scale is taken from. [samples] Judgement: bounds the time of a long record."""

    stretches: int = 24
    """Their number. [1] Judgement: see `stretch`."""

    scatter_side: int = 32
    """Neighbours on either side whose scatter a spike must exceed too. [samples] Judgement: in a shock all samples
    are large."""

    smooth: float = 0.4
    """Fourth differences, over 6, in units of the residual, below which noise is smooth: medians of neighbours then
    follow slopes, but no extremes, which are not spikes. [1] Derived: 0.8 for white noise and 0.53 for a random
    walk; a spike beyond the threshold then has 15 standard deviations of it."""

    hump_from: float = 5.0
    """Beginning of the hump. [standard deviations] Derived: of 24 000 samples of Gaussian noise 0.01 are beyond it."""

    hump_ratio: float = 2.0
    """Samples beyond 5 over those from 4 to 5, at least. [1] Derived: Laplace's law has 0.4, Student's of 4 degrees
    0.8, of 3 degrees 1.2; spikes of 6 standard deviations have 5."""

    false_share: float = 1e-5
    """Share of noise among the spikes found. [1] Judgement: it is 1e-4 where the scale of the noise is known to 7 %
    only."""

    near_false_share: float = 1e-2
    """The same where more than `near_share` of the spikes is above that threshold by less than `near_width`. [1]
    Judgement: spikes below the threshold would be missed, which costs more."""

    near_width: float = 1.0
    """Distance above the threshold within which spikes are near it. [standard deviations] Judgement: see
    `near_false_share`."""

    near_share: float = 0.05
    """Part of the spikes that is near it. [1] Judgement: see `near_false_share`."""

    remaining: float = 3.5
    """Spikes remain if more samples are beyond it than noise makes. [standard deviations] Derived: of 24 000 samples
    of Gaussian noise 11 are beyond it."""

    times: float = 2.0
    """Samples there over those of noise, from which on spikes remain. [1] Judgement: Gaussian noise has one times."""

    many_spikes: float = 0.05
    """Share of spikes beyond which half of the neighbours are often spikes. [1] Derived: of four neighbours two are
    in 1.4 % of the cases."""

    max_share: float = 0.25
    """Share of spikes beyond which the noise has no scale. [1] Judgement: the median of the residuals of such a
    record is not that of its noise."""

    apart: int = 3
    """Spikes are independent: those from here to `reach` from another are counted. [samples] Judgement: a spike
    behind a filter has two samples or three."""

    reach: int = 16
    """The end of that range. [samples] Judgement: noise that swells does so for longer."""

    clustered: float = 2.0
    """Their number over that by chance beyond which the noise swells. [1] Judgement: independent spikes have one
    times."""

    scatter_factor: float = 3.0
    """Factor over the scatter of its neighbours that a spike must exceed. [1] Judgement: noise that swells for a
    moment does not."""

    scatter_factor_many: float = 2.0
    """The same where half of the neighbours may be spikes. [1] Judgement: their scatter is then larger."""

    one_side: float = 0.5
    """Part of the residual that a spike must have against either side. [1] Derived: at a step of the mean a sample
    is far from one side only."""

    almost: float = 1.5
    """Samples below the threshold by less than this are examined again without the spikes beside them. [standard
    deviations] Judgement: a spike beside another moves the median by so much."""

    almost_rounds: int = 4
    """How often they are. [1] Judgement: of spikes beside each other each round finds one on either side."""

    least_residuals: int = 512
    """Residuals that the tail is taken from, at least. [samples] Judgement: their scale is known to 4 %."""

    scale_block: int = 128
    """Samples of the blocks whose scale a spike is compared with, the noisiest of three. [samples] Judgement: a
    median of them is known to 7 %."""

    tail_exponent: float = 3.0
    """Exponent α of the heaviest tail that ends without a gap. [1] Derived: Student's t with 3 degrees of freedom.
    Of the k largest samples the ratio of the smallest to the next smaller one exceeds r with probability r^-kα."""

    small: float = 4.5
    """Height of small spikes, which stand alone. [standard deviations] Derived: noise is beyond it once in 150 000
    samples."""

    quiet: float = 2.0
    """Variance of the other samples of the block and of its neighbours over the usual one, at most. [1] Derived: χ²
    with 31 degrees of freedom reaches 2 times its mean once in 1000 blocks."""

    mean_block: int = 32
    """Samples whose mean is taken off. [samples] Judgement: slower noise is not part of the white level."""

    min_present: int = 2
    """Samples of a block that have a scatter. [samples] Derived: the variance of one is not defined."""


THRESHOLDS = SpikeThresholds()


def neighbours(x: Floats, indices: Ints, first: int, last: int) -> Floats:
    """The samples from `first` to `last` after each index; NaN beyond the ends."""
    places = indices[:, None] + np.arange(first, last + 1)
    inside = (places >= 0) & (places < len(x))
    return np.where(inside, x[np.clip(places, 0, len(x) - 1)], np.nan)


def medians(rows: Floats) -> Floats:
    """Median of each row without NaN; NaN for an empty row."""
    ordered = np.sort(rows, axis=1)  # NaN last
    count = np.isfinite(ordered).sum(axis=1)
    row = np.arange(len(rows))
    both = ordered[row, np.maximum(count - 1, 0) // 2] + ordered[row, np.minimum(count // 2, rows.shape[1] - 1)]
    return np.asarray(np.where(count > 0, both / 2, np.nan))


def stretches(x: Floats) -> list[Floats]:
    """Evenly spread stretches of a long record, which bound the time; else the record."""
    length, count = THRESHOLDS.stretch, THRESHOLDS.stretches
    if len(x) <= length * count:
        return [x]
    return [x[start : start + length] for start in np.linspace(0, len(x) - length, count).astype(int).tolist()]
