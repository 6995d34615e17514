"""Spectral lines: vibration, mains, fans, and what they do to the Allan deviation.

One transform of the whole record, with Hann's taper, is looked at bin by bin for steady lines, and averaged over 4, 16, 64 …
bins for unsteady ones. At each width a bin is held against the median of its block of the spectrum and of the blocks on
either side, whichever is largest: so slopes, roll-offs and nulls of the spectrum are no lines.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau import _kernels
from sigmatau.allan import cluster_sizes
from sigmatau.fitting.components import LINEAR, components
from sigmatau.fitting.gls import Gls
from sigmatau.results import Finding, Printed, seconds, two_digits
from sigmatau.spectrum import good_length, hann, without_line
from sigmatau.streams import Stream

__all__ = ["Line", "find_lines", "lines"]

Floats = NDArray[np.float64]

FALSE_ALARM = 1e-4
"""Probability of any line in a clean channel, all bins and widths together."""

NOTICEABLE = 1.10
"""A line is a warning where it makes σ(τ) larger by this factor at some τ; below, it is good to know."""

_LONGEST = 1 << 22  # samples in a transform; of longer records four such stretches are averaged
_STRETCHES = 4
_SHORTEST = 512
_WIDEST = 1 << 12
_FACTOR = 4  # from one width to the next
_BLOCK = 32  # least bins of a width in a block: their median has an error of 1/4 of a bin's
_OCTAVE_SHARE = 1 / 16  # of its frequency, the width of a block: 1/11 octave
# A power under Hann's taper has the correlation (2/3)² with its neighbour, (1/6)² with the next.
_NEIGHBOURS = (4 / 9, 1 / 36)
_ENOUGH = 1024  # bins for a median, evenly taken: its error is then 5 %, less than that of any bin it is held against
_LEAST_RATIO = 1.5  # what stands out by less at any width is a curved spectrum as likely as a line
_STEADY = 3.0  # bins
_MOST_NAMED = 4
_MAINS = (50.0, 60.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Line(Printed):
    """A line in a channel's spectrum.

    Attributes
    ----------
    frequency : float
        [Hz]
    amplitude : float
        Of the sinusoid; of an unsteady line, of a steady one with the same power. [unit]
    width : float
        Of the band that holds 80 % of its power; 0 if that is the record's resolution. [Hz]
    ratio : float
        Density over that of the noise beside it, at the width that shows the line best.
    harmonics : tuple of Line
        Lines at whole multiples of its frequency, folded at half the sampling rate.
    mains : str
        Which multiple of the mains' frequency may be behind it, in words; empty if none.
    low, high : float
        The band that was taken as the line. [Hz]
    unit : str
    """

    frequency: float
    amplitude: float
    width: float
    ratio: float
    low: float
    high: float
    unit: str
    harmonics: tuple[Line, ...] = ()
    mains: str = ""

    def to_dict(self) -> dict[str, Any]:
        return {
            "frequency_hz": self.frequency,
            "amplitude": self.amplitude,
            "width_hz": self.width,
            "ratio": self.ratio,
            "unit": self.unit,
            "mains": self.mains,
            "harmonics": [line.to_dict() for line in self.harmonics],
        }

    def __repr__(self) -> str:
        width = f", {two_digits(self.width)} Hz wide" if self.width else ""
        more = f", harmonics at {_listed(self.harmonics)}" if self.harmonics else ""
        mains = f", perhaps {self.mains}" if self.mains else ""
        return f"{_hertz(self.frequency)} Hz, amplitude {self.amplitude:.3g} {self.unit}{width}{more}{mains}"


@dataclass(frozen=True, slots=True, eq=False)
class _Periodogram:
    """Two-sided density at whole multiples of `step`, from bin 0; `dof` degrees of freedom each."""

    density: Floats
    step: float
    dof: float


def lines(stream: Stream) -> list[Finding]:
    """Findings ``spectral_line``: one a channel that has any, with all its lines.

    Parameters
    ----------
    stream : Stream
        Static data. Missing samples are taken as the channel's mean, which hides no line and makes none.

    Returns
    -------
    list of Finding
        A warning where σ(τ) grows by a tenth or more at some τ, else an info. `changes` holds by which factor a fit of the
        noise terms at all averaging times, which knows no line, finds random walk and bias instability larger.

    Notes
    -----
    Of white, flicker or walking noise each ratio has Snedecor's law F(ν, ν′), with ν the degrees of freedom of a bin and
    ν′ those that give the variance of the median it is held against; the threshold is that of a false alarm of 1e-4 over
    all bins and widths of a channel.
    """
    found = []
    for channel in stream.channels:
        y = _filled(stream, channel)
        if y is None:
            continue
        spectrum = _periodogram(y, stream.grid.tau0)
        groups = _lines_of(spectrum, stream)
        if groups:
            found.append(_finding(stream, channel, groups, spectrum))
    return found


def find_lines(stream: Stream) -> dict[str, tuple[Line, ...]]:
    """The lines of every channel, strongest first, each with its harmonics; see `lines`."""
    found: dict[str, tuple[Line, ...]] = {}
    for channel in stream.channels:
        y = _filled(stream, channel)
        found[channel] = () if y is None else _lines_of(_periodogram(y, stream.grid.tau0), stream)
    return found


def strongest_line(y: Floats) -> tuple[float, float] | None:
    """Of a series without a mean, frequency and amplitude of the line that stands out most; None if there is none.

    The frequency is in sampling rates.
    """
    spectrum = _periodogram(y, 1.0)
    clusters = _clusters(spectrum)
    if not clusters:
        return None
    cluster = max(clusters, key=lambda each: each.ratio * each.noise * (each.last - each.first + 1))
    line = _measured(spectrum, cluster, "")
    return line.frequency, line.amplitude


def _filled(stream: Stream, channel: str) -> Floats | None:
    """Samples with 0 for mean, slope and what is missing; None if too few are there, or they never change."""
    y = np.ascontiguousarray(stream.column(channel))
    if stream.mask is not None:
        there = np.isfinite(y)
        if there.mean() < 0.5:
            return None
        if not there.all():
            t = np.flatnonzero(there)
            kept = y[there]
            middle = t.mean()
            slope = float((t - middle) @ (kept - kept.mean())) / float((t - middle) @ (t - middle))
            filled = np.zeros(len(y))
            # Scaled to the power that the whole would have.
            filled[there] = (kept - kept.mean() - slope * (t - middle)) / math.sqrt(there.mean())
            y = filled
        else:
            y = without_line(y)
    elif len(y) >= _SHORTEST:
        y = without_line(y)
    if len(y) < _SHORTEST or not y.max() > y.min():
        return None
    return y


def _periodogram(y: Floats, tau0: float) -> _Periodogram:
    count = 1 if len(y) <= _LONGEST else _STRETCHES
    length = good_length(len(y) if count == 1 else _LONGEST // 2)
    taper = _taper(length)
    density = np.zeros(length // 2 + 1)
    for start in np.linspace(0, len(y) - length, count).astype(int):
        parts = np.fft.rfft(y[start : start + length] * taper).view(np.float64)
        parts *= parts
        density += parts[::2] + parts[1::2]
    density *= tau0 / (float(taper @ taper) * count)
    return _Periodogram(density, 1 / (length * tau0), 2.0 * count)


@functools.lru_cache(maxsize=2)
def _taper(length: int) -> Floats:
    """Kept for the other axes of a record."""
    return hann(length)


def _lines_of(spectrum: _Periodogram, stream: Stream) -> tuple[Line, ...]:
    clusters = _clusters(spectrum)
    if not clusters:
        return ()
    found = [_measured(spectrum, cluster, stream.unit) for cluster in clusters]
    return _grouped(_distinct(found, spectrum.step), stream.grid.rate, spectrum.step)


@dataclass(frozen=True, slots=True)
class _Cluster:
    """Bins that stand out together, `first` to `last`; the noise below them, and by how much they do at best."""

    first: int
    last: int
    noise: float
    ratio: float


def _clusters(spectrum: _Periodogram) -> list[_Cluster]:
    """Where the spectrum stands out at any width."""
    bins = len(spectrum.density) - 1  # the last bin, half the sampling rate, has half the degrees of freedom
    averaged, width, hits = spectrum.density[:bins], 1, []
    while width <= _WIDEST and bins >= 256 * width:
        blocks, steps, thresholds, mean_over_median = _law(len(averaged), width, spectrum.dof, bins)
        spans = list(zip(blocks[:-1], blocks[1:], steps, strict=True))
        medians = np.array([_median(averaged[a:b:step]) for a, b, step in spans]) * mean_over_median
        beside = np.concatenate(([medians[0]], medians, [medians[-1]]))
        noise = np.maximum(np.maximum(beside[:-2], beside[2:]), medians)
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
    return _merged(hits)


def _median(values: Floats) -> float:
    """Of an odd number of values: the last of an even number is left out. numpy.median takes four times as long."""
    middle = (len(values) - 1) // 2
    return float(np.partition(values[: 2 * middle + 1], middle)[middle])


@functools.lru_cache(maxsize=64)
def _law(count: int, width: int, dof: float, bins: int) -> tuple[NDArray[np.int64], NDArray[np.int64], Floats, float]:
    """Edges of the blocks, every which bin the median is of, by which factor bins must stand out, mean over median.

    The first block is too low for a test: it is only held against the second.
    """
    from scipy.special import chdtri, fdtri

    shared = 2 * sum(c * max(1 - k / width, 0) for k, c in enumerate(_NEIGHBOURS, 1))
    freedom = dof * width / (1 + shared)
    # Neighbours are correlated, 4/9 at width 1 and less at larger ones: a block has fewer independent bins.
    correlated = 1 + 2 * sum(_NEIGHBOURS) / width
    edges = [4]
    while edges[-1] < count:
        edges.append(edges[-1] + max(_BLOCK, int(edges[-1] * _OCTAVE_SHARE)))
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
    thresholds = np.maximum(fdtri(freedom, 2 / variance, 1 - probability), _LEAST_RATIO)
    thresholds[0] = np.inf
    return blocks, steps, thresholds, 1 / median


def _merged(hits: list[tuple[int, int, float, float]]) -> list[_Cluster]:
    """Bins of all widths that touch, or nearly, as one."""
    merged: list[_Cluster] = []
    for first, last, noise, ratio in sorted(hits):
        apart = max(last - first + 1, 8)
        if merged and first <= merged[-1].last + apart:
            old = merged[-1]
            best = (noise, ratio) if ratio > old.ratio else (old.noise, old.ratio)
            merged[-1] = _Cluster(old.first, max(old.last, last), *best)
        else:
            merged.append(_Cluster(first, last, noise, ratio))
    return merged


def _measured(spectrum: _Periodogram, cluster: _Cluster, unit: str) -> Line:
    first, last = max(cluster.first - 3, 1), min(cluster.last + 3, len(spectrum.density) - 1)
    excess = spectrum.density[first : last + 1] - cluster.noise
    power = max(2 * float(excess.sum()) * spectrum.step, 0.0)  # both signs of the frequency
    held = np.cumsum(np.maximum(excess, 0))
    low, high = np.searchsorted(held, [0.1 * held[-1], 0.9 * held[-1]])
    wide = float(high - low)
    k = first + int(np.argmax(excess))
    if wide <= _STEADY:
        frequency, wide = _refined(spectrum.density, k), 0.0
    else:
        above = np.maximum(excess, 0)
        frequency = float(above @ np.arange(first, last + 1)) / float(above.sum())
    return Line(
        frequency=frequency * spectrum.step,
        amplitude=math.sqrt(2 * power),
        width=wide * spectrum.step,
        ratio=cluster.ratio,
        low=first * spectrum.step,
        high=last * spectrum.step,
        unit=unit,
    )


def _refined(density: Floats, k: int) -> float:
    """Where between bins a steady line is: Hann's taper gives neighbours at distance δ the amplitudes (1 + δ)/(2 − δ)."""
    if not 0 < k < len(density) - 1:
        return float(k)
    side = 1 if density[k + 1] >= density[k - 1] else -1
    ratio = math.sqrt(density[k + side] / density[k])
    return k + side * min(max((2 * ratio - 1) / (ratio + 1), 0.0), 0.5)


def _distinct(found: Sequence[Line], step: float) -> list[Line]:
    """Strongest first, without what is only the skirt of a stronger one."""
    kept: list[Line] = []
    for line in sorted(found, key=lambda each: -each.amplitude):
        skirts = any(
            abs(line.frequency - other.frequency) <= max(20 * step, 3 * other.width, 2 * (other.high - other.low))
            and line.amplitude < 0.3 * other.amplitude
            for other in kept
        )
        if not skirts:
            kept.append(line)
    return kept


def _grouped(found: Sequence[Line], rate: float, step: float) -> tuple[Line, ...]:
    """Harmonics under their fundamental: the lowest line of which others are whole multiples, folded."""
    left = sorted(found, key=lambda line: line.frequency)
    groups: list[Line] = []
    while left:
        line = left.pop(0)
        own = max(line.width, step)
        members = []
        for other in left:
            order = max(round(other.frequency / line.frequency), 2)
            error = min(abs(_fold(k * line.frequency, rate) - other.frequency) for k in {order, 2, 3, 4, 5})
            # An unsteady line's harmonic is as much wider; many a weak line would be a high multiple by chance.
            if order <= 16 and error <= min(1.5 * order * own, 0.1 * line.frequency):
                members.append(other)
        left = [other for other in left if other not in members]
        groups.append(
            Line(
                frequency=line.frequency,
                amplitude=line.amplitude,
                width=line.width,
                ratio=line.ratio,
                low=line.low,
                high=line.high,
                unit=line.unit,
                harmonics=tuple(members),
                mains=_mains(line, rate),
            )
        )
    return tuple(sorted(groups, key=lambda line: -line.amplitude))


def _fold(frequency: float, rate: float) -> float:
    return abs(frequency - rate * round(frequency / rate))


def _mains(line: Line, rate: float) -> str:
    """The mains wander by ±0.2 Hz a multiple at most, usually by far less; the sampling rate is known to 1e-4."""
    if line.width > 0.2:
        return ""
    for order in (1, 2, 3):
        for mains in _MAINS:
            seen = _fold(order * mains, rate)
            if seen > 0.5 and abs(line.frequency - seen) <= 0.05 * order + 1e-4 * order * mains + line.width:
                name = f"{mains:g} Hz mains" if order == 1 else f"{order} times {mains:g} Hz mains"
                return name if seen == order * mains else f"{name} folded by the sampling rate"
    return ""


def _finding(stream: Stream, channel: str, groups: Sequence[Line], spectrum: _Periodogram) -> Finding:
    strongest = groups[0]
    everything = [line for group in groups for line in (group, *group.harmonics)]
    effect, changes, factor = _effect(stream, channel, everything, spectrum)
    named = "; ".join(map(repr, groups[:_MOST_NAMED]))
    more = f"; {len(groups) - _MOST_NAMED} weaker ones" if len(groups) > _MOST_NAMED else ""
    part = ", looked for in four stretches" if spectrum.dof > 2 else ""
    return Finding(
        code="spectral_line",
        severity="warning" if factor >= NOTICEABLE else "info",
        channel=channel,
        message=f"{'line' if len(everything) == 1 else 'lines'} in the spectrum: {named}{more}{part}",
        where=f"f = {_hertz(strongest.frequency)} Hz",
        size=strongest.amplitude,
        unit=stream.unit,
        effect=effect,
        changes=changes,
        remedy=(
            "find what shakes or couples at this frequency and record without it; else fit from averaging times well"
            " beyond its period"
        ),
    )


def _effect(
    stream: Stream, channel: str, found: Sequence[Line], spectrum: _Periodogram
) -> tuple[str, tuple[tuple[str, float], ...], float]:
    """In words; changes of coefficients; by which factor σ(τ) grows at worst."""
    whole = stream.only(channel).longest_run()
    sizes = cluster_sizes("half", n=whole.grid.n, tau0=stream.grid.tau0)
    sizes = sizes[sizes <= whole.grid.n // 3]
    (measured,), _, _ = _kernels.allan_variances(
        [whole.column(channel)], sizes, overlap="full", counting="standard", threads=1, names=[channel]
    )
    column = sum((_avar(line, spectrum, sizes, stream.grid.tau0) for line in found), np.zeros(len(sizes)))
    # What is left is no less than the error of a single variance allows: a line may be all there is.
    rest = np.maximum(measured - column, 0.02 * measured)
    factors = np.sqrt(measured / rest)
    worst = int(np.argmax(factors))
    factor = float(factors[worst])
    tau = sizes[worst] * stream.grid.tau0
    text = f"σ(τ) is up to {_times(factor)} what it would be without, at τ = {seconds(tau)} s"
    changes = []
    if factor >= NOTICEABLE and len(sizes) >= 8:
        ratios = _change(whole.grid.n, sizes, measured, rest)
        words = []
        for term, ratio in ratios.items():
            if abs(ratio - 1) >= 0.01:
                changes.append((term, ratio))
                words.append(f"{term.replace('_', ' ')} {_times(ratio)} as large")
        if words:
            text += f"; a fit to all times that knows no line finds {' and '.join(words)}"
    return text, tuple(changes), factor


def _avar(line: Line, spectrum: _Periodogram, sizes: NDArray[np.int64], tau0: float) -> Floats:
    """Allan variance of a line: of the sinusoid if it is steady, else of its band of the spectrum by eq. (11s)."""
    if line.width == 0:
        return _kernels.sinusoid_avar(line.amplitude, line.frequency, sizes, tau0)
    first, last = round(line.low / spectrum.step), round(line.high / spectrum.step)
    frequency = np.arange(first, last + 1) * spectrum.step
    excess = spectrum.density[first : last + 1]
    # The noise below the line is what makes its power the stated one.
    excess = excess - (excess.sum() - line.amplitude**2 / (4 * spectrum.step)) / len(excess)
    few = max(1, len(excess) // 512)  # bins that are taken together: far less than any 1/τ where they still count
    frequency, excess = (
        np.add.reduceat(frequency, np.arange(0, len(frequency), few))
        / np.diff(np.append(np.arange(0, len(frequency), few), len(frequency))),
        np.add.reduceat(excess, np.arange(0, len(excess), few)),
    )
    angle = math.pi * frequency * tau0
    gains = np.sin(np.outer(sizes, angle)) ** 4 / np.outer(sizes.astype(float) ** 2, np.sin(angle) ** 2)
    return np.asarray(np.maximum(4 * spectrum.step * (gains @ excess), 0.0))


def _change(n: int, sizes: NDArray[np.int64], measured: Floats, rest: Floats) -> Mapping[str, float]:
    """By which factor generalised least squares finds random walk and bias instability larger with the line."""
    scale = float(np.median(measured))
    parts = components(n, tuple(int(m) for m in sizes))
    try:
        with np.errstate(divide="raise", invalid="raise"):
            theta = [Gls(parts, avar / scale).fit() for avar in (measured, rest)]
    except (FloatingPointError, np.linalg.LinAlgError):
        return {}
    found = {}
    for term in ("random_walk", "bias_instability"):
        p = LINEAR.index(term)
        if theta[0][p] > 0 and theta[1][p] > 0:
            found[term] = math.sqrt(theta[0][p] / theta[1][p])
    return found


def _times(factor: float) -> str:
    return f"{factor:.2f} times" if factor < 9.95 else f"{factor:.0f} times"


def _hertz(frequency: float) -> str:
    return f"{frequency:.4g}"


def _listed(found: Sequence[Line]) -> str:
    texts = [_hertz(line.frequency) for line in found[:_MOST_NAMED]]
    return ", ".join(texts) + (" …" if len(found) > _MOST_NAMED else "") + " Hz"
