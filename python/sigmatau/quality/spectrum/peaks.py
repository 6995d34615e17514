"""Peaks of a spectrum that exceed the noise beside them by more than chance allows.

One transform of the whole record, with Hann's taper, is searched bin by bin for steady lines, and averaged over 4, 16, 64 …
bins for unsteady ones. At each width a bin is compared with the largest of three medians: that of its block of the spectrum
and those of the adjacent blocks. So slopes, roll-offs and nulls of the spectrum are not taken for lines. At the lowest bins
a spectrum may be as steep as flicker noise or a rate random walk, and the lower block would hide lines: there the spectrum
is first divided by a sum of white, flicker and random walk noise that is fitted to its medians.
"""

from __future__ import annotations

import functools
import itertools
import math
from dataclasses import dataclass

import numpy as np

from sigmatau.arrays import Floats, Ints
from sigmatau.fitting.non_negative import non_negative
from sigmatau.spectrum.tapers import good_length, hann

__all__ = ["Periodogram", "measured_lines", "periodogram", "strongest_line"]

FALSE_ALARM = 1e-4  # probability of any line in a clean channel, all bins and widths together
_LONGEST = 1 << 22  # samples in a transform; of longer records four such stretches are averaged
_STRETCHES = 4
_WIDEST = 1 << 12
_FACTOR = 4  # from one width to the next
_BLOCK = 32  # least bins of a width in a block: their median has an error of 1/4 of a bin's
_OCTAVE_SHARE = 1 / 16  # of its frequency, the width of a block: 1/11 octave
# A power under Hann's taper has the correlation (2/3)² with its neighbour, (1/6)² with the next.
_NEIGHBOURS = (4 / 9, 1 / 36)
_ENOUGH = 1024  # bins for a median, evenly spaced: its error is then 5 %, less than that of any bin
# A smaller ratio may be a curved spectrum: between the nulls of one running mean the maximum is twice the median, of two in
# a row four times.
_LEAST_RATIO = 2.5
_LEAST_WIDE = 4.2
_WIDE = 64  # bins; from this width on blocks are twice as long, so that a resonance is not half of its own block
_CORE = 3  # bins either side that hold a steady line: all but 1e-4 of its power


_LOW = 2048  # bins that are searched without the slope; a quarter of all at most
_LOWEST_FITTED = 4
_PER_OCTAVE = 2
_PASSES = 8
# A false alarm of 1e-4 more over these bins. The level that is fitted has an error of some 5 %, of 15 % at the lowest bins.
_LOW_MARGIN = 1.25

# Below the first block, from five cycles in the record on, a bin is compared with those from three to fourteen above it, as
# if the spectrum were that of a random walk, which is the steepest. Twelve correlated bins have twelve degrees of freedom
# together; their density over that of one bin follows Snedecor's F.
_SLOWEST, _ABOVE, _ABOVE_FREEDOM = 5, (3, 15), 12.0
_STEEP = 4.0  # ratio by which a line, and no random walk, falls within three bins on its lower side
_DYNAMIC = 1e-25  # of a spectrum in double precision


@dataclass(frozen=True, slots=True, eq=False)
class Periodogram:
    """Two-sided density at whole multiples of `step`, from 0 to half the sampling rate; `dof` degrees of freedom each."""

    density: Floats
    step: float
    dof: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Peak:
    """A line of a spectrum."""

    frequency: float  # [Hz]
    amplitude: float  # of the sinusoid; of an unsteady line, of a steady one with the same power
    width: float  # of the band that holds 80 % of its power; 0 if the line is as narrow as the resolution [Hz]
    ratio: float  # density over that of the noise beside it, at the width that shows the line best
    low: float  # the band that was taken as the line [Hz]
    high: float


def measured_lines(spectrum: Periodogram) -> list[Peak]:
    """All lines of a spectrum, harmonics not grouped."""
    return [_measured(spectrum, cluster) for cluster in _clusters(spectrum)]


def strongest_line(y: Floats) -> tuple[float, float] | None:
    """Frequency in sampling rates and amplitude of the strongest line of a series without a mean; None without a line."""
    spectrum = periodogram(y, 1.0)
    clusters = _clusters(spectrum)
    if not clusters:
        return None
    cluster = max(clusters, key=lambda each: each.ratio * each.noise * (each.last - each.first + 1))
    line = _measured(spectrum, cluster)
    return line.frequency, line.amplitude


def periodogram(y: Floats, tau0: float) -> Periodogram:
    """Periodogram of samples without mean and slope; of more than 2^22, the mean over four evenly spread stretches."""
    count = 1 if len(y) <= _LONGEST else _STRETCHES
    length = 2 * good_length((len(y) if count == 1 else _LONGEST // 2) // 2)
    taper = _taper(length)
    density = np.zeros(length // 2 + 1)
    for start in np.linspace(0, len(y) - length, count).astype(int):
        parts = np.fft.rfft(y[start : start + length] * taper).view(np.float64)
        parts *= parts
        density += parts[::2] + parts[1::2]
    density *= tau0 / (float(taper @ taper) * count)
    return Periodogram(density, 1 / (length * tau0), 2.0 * count)


@functools.lru_cache(maxsize=2)
def _taper(length: int) -> Floats:
    """Kept for the other axes of a record."""
    return hann(length)


@dataclass(frozen=True, slots=True)
class _Cluster:
    """Adjacent bins of a line, `first` to `last`, the noise below them, and the largest ratio to it."""

    first: int
    last: int
    noise: float
    ratio: float


def _clusters(spectrum: Periodogram) -> list[_Cluster]:
    """Bins that exceed the noise at any width."""
    bins = len(spectrum.density) - 1  # the last bin, half the sampling rate, has half the degrees of freedom
    averaged, width, hits = spectrum.density[:bins], 1, []
    nothing = (
        _DYNAMIC * float(averaged.max(initial=0.0)) or 1.0
    )  # where a signal repeats itself, nothing is between its lines
    while width <= _WIDEST and bins >= 256 * width:
        blocks, steps, thresholds, mean_over_median = _law(len(averaged), width, spectrum.dof, bins)
        spans = list(zip(blocks[:-1], blocks[1:], steps, strict=True))
        medians = np.array([_median(averaged[a:b:step]) for a, b, step in spans]) * mean_over_median
        beside = np.concatenate(([medians[0]], medians, [medians[-1]]))
        noise = np.maximum(np.maximum(np.maximum(beside[:-2], beside[2:]), medians), nothing)
        largest = np.maximum.reduceat(averaged, blocks[:-1])
        for block in np.flatnonzero(largest > noise * thresholds):
            inside = averaged[blocks[block] : blocks[block + 1]]
            for k in np.flatnonzero(inside > noise[block] * thresholds[block]):
                first = int(blocks[block] + k) * width
                hits.append((first, first + width - 1, float(noise[block]), float(inside[k] / noise[block])))
        rest = len(averaged) // _FACTOR * _FACTOR
        averaged = sum(averaged[k:rest:_FACTOR] for k in range(1, _FACTOR)) + averaged[:rest:_FACTOR]
        averaged /= _FACTOR
        width *= _FACTOR
    return _merged([*hits, *_low_hits(spectrum, bins), *_lowest_hits(spectrum, bins)])


def _low_hits(spectrum: Periodogram, bins: int) -> list[tuple[int, int, float, float]]:
    """Steady lines among the lowest bins, against the noise that is fitted there; as hits of `_clusters`."""
    last = min(_LOW, bins // 4)
    level = _background(spectrum.density[: 2 * last], spectrum.dof)
    if level is None:
        return []
    ratio = spectrum.density[:last] / level[:last]
    blocks, _, _, mean_over_median = _law(last, 1, spectrum.dof, 2 * last)
    medians = np.array([_median(ratio[a:b]) for a, b in itertools.pairwise(blocks)]) * mean_over_median
    beside = np.concatenate(([medians[0]], medians, [medians[-1]]))
    # The blocks correct a poor fit.
    noise = np.maximum(np.maximum(np.maximum(beside[:-2], beside[2:]), medians), 1.0)
    each = np.repeat(noise, np.diff(blocks))
    above = ratio[blocks[0] :] / each
    threshold = _LOW_MARGIN * _exceeded(1, spectrum.dof, FALSE_ALARM / last)
    found = np.flatnonzero(above > threshold)
    found = found[found >= blocks[1] - blocks[0]]
    return [
        (k, k, float(level[k] * each[k - blocks[0]]), float(above[k - blocks[0]])) for k in (found + blocks[0]).tolist()
    ]


def _lowest_hits(spectrum: Periodogram, bins: int) -> list[tuple[int, int, float, float]]:
    """Overwhelming lines below the first block; as hits of `_clusters`."""
    from scipy.special import fdtri

    low, high = _ABOVE
    k = np.arange(_SLOWEST, 4 + _BLOCK)
    if bins < 4 * int(k[-1]):
        return []
    density = spectrum.density
    mean = np.array([density[each + low : each + high].mean() for each in k.tolist()])
    freedom = _ABOVE_FREEDOM * spectrum.dof / 2
    threshold = float(fdtri(spectrum.dof, freedom, 1 - FALSE_ALARM / len(k)))
    slope = ((k + (low + high - 1) / 2) / k) ** 2
    there = (density[k] > threshold * slope * mean) & (density[k] > _STEEP * density[k - low]) & (mean > 0)
    return [
        (j, j, float(noise), float(density[j] / noise)) for j, noise in zip(k[there].tolist(), mean[there], strict=True)
    ]


def _background(density: Floats, dof: float) -> Floats | None:
    """White, flicker and walking noise, 1, 1/k and 1/k² over bins k, that make the medians over half octaves."""
    from scipy.special import chdtri

    if len(density) < _BLOCK * 4:
        return None
    octaves = math.log2(len(density) / _LOWEST_FITTED)
    edges = np.unique(
        np.rint(_LOWEST_FITTED * 2.0 ** (np.arange(0, octaves * _PER_OCTAVE + 1) / _PER_OCTAVE)).astype(int)
    )
    edges = edges[edges <= len(density)]
    spans = list(itertools.pairwise(edges.tolist()))
    levels = np.array([_median(density[a:b]) for a, b in spans]) * (dof / float(chdtri(dof, 0.5)))
    if not levels.min() > 0:
        return None
    k = np.arange(1, len(density) + 1, dtype=float)
    k[1:] = np.arange(1, len(density))  # bin 0 is never looked at
    centres = np.sqrt(edges[:-1] * (edges[1:] - 1.0))
    columns = np.stack([np.ones_like(centres), 1 / centres, 1 / centres**2], axis=1)
    count = np.sqrt(np.diff(edges))
    expected, theta = levels, np.zeros(3)
    for _ in range(_PASSES):
        weights = count / expected
        theta = non_negative(columns * weights[:, None], levels * weights)
        expected = np.maximum(columns @ theta, 1e-3 * levels)
    return np.asarray(np.maximum(theta[0] + theta[1] / k + theta[2] / k**2, 1e-3 * float(levels.min())))


def _median(values: Floats) -> float:
    """Of an odd number of values: the last of an even number is left out. numpy.median takes four times as long."""
    middle = (len(values) - 1) // 2
    return float(np.partition(values[: 2 * middle + 1], middle)[middle])


@functools.lru_cache(maxsize=64)
def _law(count: int, width: int, dof: float, bins: int) -> tuple[Ints, Ints, Floats, float]:
    """Edges of blocks, every which bin the median is of, factors by which bins must stand out (never in the first),
    mean/median.
    """
    from scipy.special import chdtri, fdtri

    shared = 2 * sum(c * max(1 - k / width, 0) for k, c in enumerate(_NEIGHBOURS, 1))
    freedom = dof * width / (1 + shared)
    # Neighbours are correlated, 4/9 at width 1 and less at larger ones: a block has fewer independent bins.
    correlated = 1 + 2 * sum(_NEIGHBOURS) / width
    wide = width >= _WIDE
    edges = [4]
    while edges[-1] < count:
        edges.append(edges[-1] + max(_BLOCK * (1 + wide), int(edges[-1] * _OCTAVE_SHARE)))
    if len(edges) > 2 and count - edges[-2] < _BLOCK:
        edges.pop()
    edges[-1] = count
    blocks = np.array(edges, dtype=np.int64)
    steps = np.diff(blocks) // _ENOUGH + 1
    sizes = np.diff(blocks) / (steps * correlated)
    median = float(chdtri(freedom, 0.5)) / freedom
    # Variance of a median: 1/(4 n f²), with f the density of the law at its median.
    log_density = (
        freedom / 2 * math.log(freedom / 2)
        - math.lgamma(freedom / 2)
        + (freedom / 2 - 1) * math.log(median)
        - freedom * median / 2
    )
    variance = 1 / (4 * sizes * math.exp(2 * log_density) * median**2)
    probability = FALSE_ALARM * (1 - 1 / _FACTOR) / bins
    uncertain = fdtri(freedom, 2 / variance, 1 - probability) / (chdtri(freedom, probability) / freedom)
    thresholds = np.maximum(_exceeded(width, dof, probability) * uncertain, _LEAST_WIDE if wide else _LEAST_RATIO)
    thresholds[0] = np.inf
    return blocks, steps, thresholds, 1 / median


def _exceeded(width: int, dof: float, probability: float) -> float:
    """Value that the mean of neighbouring bins, of expectation 1, exceeds with the given probability.

    A sum of χ² variables with unequal weights, whose far tail is that of the largest: by the saddle point, with the factor
    of Bahadur and Rao, which is good to a tenth of the probability.
    """
    if width <= 16:
        lag = np.abs(np.subtract.outer(np.arange(width), np.arange(width)))
        weights = np.linalg.eigvalsh(np.where(lag < 3, np.array([1, 2 / 3, 1 / 6, 0])[np.minimum(lag, 3)], 0))
    else:
        angle = 2 * np.pi * np.arange(width) / width
        weights = 1 + 4 / 3 * np.cos(angle) + 1 / 3 * np.cos(2 * angle)
    shape = dof / 2
    weights = np.maximum(weights, 0) / (width * shape)
    low, high = 0.0, 1 / float(weights.max())
    level = 1.0
    for _ in range(80):
        s = (low + high) / 2
        rest = 1 - s * weights
        level = float(shape * (weights / rest).sum())
        spread = float(shape * ((weights / rest) ** 2).sum())
        log = -shape * float(np.log(rest).sum()) - s * level - math.log(s * math.sqrt(2 * math.pi * spread))
        if log > math.log(probability):
            low = s
        else:
            high = s
    return level


def _merged(hits: list[tuple[int, int, float, float]]) -> list[_Cluster]:
    """Clusters of bins of all widths that touch or nearly touch, because an unsteady line has gaps."""
    merged: list[_Cluster] = []
    for first, last, noise, ratio in sorted(hits):
        apart = max(last - first + 1, 8, first // 50)
        if merged and first <= merged[-1].last + apart:
            old = merged[-1]
            best = (noise, ratio) if ratio > old.ratio else (old.noise, old.ratio)
            merged[-1] = _Cluster(old.first, max(old.last, last), *best)
        else:
            merged.append(_Cluster(first, last, noise, ratio))
    return merged


def _refined(density: Floats, k: int) -> float:
    """Frequency of a steady line between bins: Hann's taper gives neighbours at distance δ the ratio (1 + δ)/(2 − δ)."""
    if not 0 < k < len(density) - 1:
        return float(k)
    side = 1 if density[k + 1] >= density[k - 1] else -1
    ratio = math.sqrt(density[k + side] / density[k])
    return k + side * min(max((2 * ratio - 1) / (ratio + 1), 0.0), 0.5)


def _measured(spectrum: Periodogram, cluster: _Cluster) -> Peak:
    """Power, frequency and width of a line; of a steady one in the bins over which Hann's taper spreads it."""
    first, last = max(cluster.first - 3, 1), min(cluster.last + 3, len(spectrum.density) - 1)
    excess = spectrum.density[first : last + 1] - cluster.noise
    top = int(np.argmax(excess))
    core = slice(max(top - _CORE, 0), top + _CORE + 1)
    whole, held = float(excess.sum()), float(excess[core].sum())
    # A mean of n bins of noise has the variance 1.94·2/dof/n.
    error = cluster.noise * math.sqrt(1.94 * 2 / spectrum.dof * len(excess))
    steady = held > 0.8 * (whole - 2 * error)
    if steady:
        peak = first + top
        frequency, wide, whole = _refined(spectrum.density, peak), 0.0, held
        first, last = max(peak - _CORE, first), min(peak + _CORE, last)
        nyquist = len(spectrum.density) - 1
        if last == nyquist:
            # Beyond half the sampling rate the density goes on as its mirror image: the half of the line that is seen is
            # counted twice, but for the bin in the middle. A line in that bin is ±A by turns, of power A² and not A²/2.
            whole = 2 * held - float(excess[-1])
            whole /= 4.0 if peak == nyquist else 2.0
    else:
        above = np.maximum(excess, 0)
        shares = np.cumsum(above) / above.sum()
        low, high = np.searchsorted(shares, [0.1, 0.9])
        frequency, wide = float(above @ np.arange(first, last + 1)) / float(above.sum()), float(high - low)
    return Peak(
        frequency=frequency * spectrum.step,
        amplitude=math.sqrt(4 * max(whole, 0.0) * spectrum.step),  # half its square is the power, of both signs of f
        width=wide * spectrum.step,
        ratio=cluster.ratio,
        low=first * spectrum.step,
        high=last * spectrum.step,
    )
