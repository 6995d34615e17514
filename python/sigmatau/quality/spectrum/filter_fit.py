"""The fit of a low-pass filter to a spectrum.

White and flicker noise behind a filter, images folded in, with what comes after the filter (a white floor, quantization, a
rate random walk, none of which it touches), against the same terms without a filter; by the likelihood of χ² densities.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sigmatau.arrays import Bools, Floats
from sigmatau.findings.kinds.spectrum import LowPassFilter
from sigmatau.quality.spectrum import filter_models
from sigmatau.spectrum.result import Spectrum

__all__ = ["fit_low_pass", "promising"]

EVIDENCE = 40.0
"""Least gain in deviance for a filter. By chance it has a χ² law of three degrees of freedom (corner, floor, shape) at one
corner, 1e-8; some fifty corners and shapes that differ make 1e-6."""

_PER_OCTAVE = 16
_FIRST = 5.0  # resolutions; below, Hann's taper smears a spectrum as steep as f⁻² by more than 2 %
_LOWEST = 3.0  # corner over the lowest frequency
_MOST_FREEDOM = (
    2e4  # a bin is not trusted to better than 1 %: so wide is a bin, and so rounded the shapes of real filters
)
_CORNERS = 2.0 ** np.arange(-7.5, -0.4, 0.5)  # in sampling rates
_HIGHEST = (0.40, 0.45)  # of digital filters, which end at half the sampling rate
_LAST_CORNER = 0.49
_PRECISION = 2e-3  # of a corner: densities are means over 1/16 octave, shapes are taken in the middle
_DEPTH = 1e-9  # of the largest density: below is the rounding of the samples
_ZERO = 1 / 128
_SOME = (0.03, 0.1, 0.2, 0.3, 0.4, 0.45)
_ALIKE = 10.0  # deviance by which another shape may be worse and still be possible
_LARGEST_FLOOR = 0.5
_LEAST_POINTS = 24
_FLATTEST = 0.95
# What may come after the filter beside a rate random walk: nothing, quantization, a white floor; by its column. Each
# flattens a roll-off, so that it must be worth a price.
_VARIANTS = {"": -1, "quantization": 3, "floor": 4}
_PRICE = 25.0
_PRUNINGS = 2
_OUTLIER = 5.0


def fit_low_pass(spectrum: Spectrum, *, without: Sequence[tuple[float, float]] = ()) -> LowPassFilter | None:
    """The filter that a spectrum shows, or None; see `low_pass`. Bands `without`, of lines, are left out. [Hz]"""
    points = _points(spectrum, without)
    if points is None or not _promising(points):
        return None
    best = _best(points)
    for _ in range(_PRUNINGS):
        shape = min(best, key=lambda each: best[each][0])
        rest = points.pruned(_columns(shape, best[shape][1], np.array(points.frequency)), best[shape][2])
        if rest is None:
            break
        points, best = rest, _best(rest)
    shape = min(best, key=lambda each: best[each][0])
    least = points.deviance(_unfiltered(points.frequency))[0]
    score, x, variant = best[shape]
    gain = least - score
    if gain < EVIDENCE or gain < 0.5 * (least - len(points.density)):
        return None
    _, theta = points.deviance(_columns(shape, x, np.array(points.frequency)), variant)
    white, floor, quantization = theta[0], theta[4], theta[3]
    level = white + floor
    at_nyquist, at_zero = filter_models.folded_white(shape, x, [0.5, 0.0], 1.0)
    # White noise after the filter fills it up: where that is most of it, it is coloured noise beside white, no filter.
    if level <= 0 or floor > _LARGEST_FLOOR * level or (white * at_nyquist / at_zero + floor) / level > _FLATTEST:
        return None
    # Quantization after it may do so, too: where the sum falls nowhere below the random walk, none has been seen to fall.
    frequency = np.array(points.frequency)
    left = white * filter_models.folded_white(shape, x, frequency, 1.0) / at_zero + floor
    if float((left + quantization * np.sin(np.pi * frequency) ** 2).min()) > _FLATTEST * level:
        return None
    rate = 1 / spectrum.tau0
    alike = tuple(s for s in sorted(best, key=lambda s: best[s][0]) if s != shape and best[s][0] < score + _ALIKE)
    spread = max((abs(best[s][1] - x) for s in alike), default=0.0)
    ratio = float(filter_models.relative_avar(shape, x, 1, 1.0)[0])
    return LowPassFilter(
        shape=shape,
        order=filter_models.order_of(shape),
        corner=x * rate,
        error=math.hypot(points.error(shape, variant, x), _PRECISION * x, spread / 2) * rate,
        alike=alike,
        alike_corners=tuple(best[each][1] * rate for each in alike),
        misfit=score / len(points.density),
        tau0=spectrum.tau0,
        # A spectrum q·sin²(πf) of quantization has the Allan variance 3q/4 at one sample.
        sigma_one_sample=math.sqrt((white * ratio + floor + 0.75 * quantization) / level),
        right_from=max(filter_models.right_from(shape, x, 1.0) * white / level, 1.0) / rate,
    )


def promising(spectrum: Spectrum) -> bool:
    """Whether a fit is worth its time."""
    points = _points(spectrum, ())
    try:
        return points is not None and _promising(points)
    except RuntimeError:  # non-negative least squares found no end: a spectrum of rounding, over 15 digits
        return False


def _best(points: _Points) -> dict[str, tuple[float, float, str]]:
    """Score, corner and variant by shape."""
    corners = [float(x) for x in _CORNERS if x >= _LOWEST * points.frequency[0]]
    best: dict[str, tuple[float, float, str]] = {}
    everywhere = corners
    for shape in filter_models.SHAPES:
        corners = (
            [*(x for x in everywhere if x < _HIGHEST[0]), *_HIGHEST] if filter_models.digital(shape) else everywhere
        )
        tables = [_table(shape, x, points.frequency) for x in corners]
        coarse = {}
        for variant in _VARIANTS:
            scores = [points.score(table, variant, steps=2) for table in tables]
            coarse[variant] = (min(scores), corners[int(np.argmin(scores))])
        other = min((v for v in _VARIANTS if v), key=lambda v: coarse[v][0])
        best[shape] = min((*points.refined(shape, v, coarse[v][1], to=0.01), v) for v in ("", other))
    least = min(score for score, _, _ in best.values())
    for shape, (score, x, variant) in best.items():
        if score < least + 10 * _ALIKE:
            best[shape] = (*points.refined(shape, variant, x, to=1e-3), variant)
    return best


@dataclass(frozen=True, slots=True, eq=False)
class _Points:
    """Densities near 1, their degrees of freedom, frequencies in sampling rates, and what is nothing."""

    density: Floats
    freedom: Floats
    frequency: tuple[float, ...]
    nothing: float

    def deviance(self, columns: Floats, variant: str = "both", *, steps: int = 3) -> tuple[float, Floats]:
        """Least Σ ν (P/S − 1 − ln P/S), the likelihood of χ² densities, over S = columns·θ with θ ≥ 0; and θ."""
        from scipy.optimize import nnls

        kept = [k for k in range(columns.shape[1]) if k < 3 or variant == "both" or _VARIANTS[variant] == k]
        chosen = columns[:, kept]
        expected = self.density + self.nothing
        for _ in range(steps):
            weights = np.sqrt(self.freedom / 2) / expected
            coefficients, _ = nnls(chosen * weights[:, None], self.density * weights)
            expected = np.maximum(chosen @ coefficients + self.nothing, 1e-3 * self.density)
        theta = np.zeros(columns.shape[1])
        theta[kept] = coefficients
        ratio = (self.density + self.nothing) / expected
        return float(self.freedom @ (ratio - 1 - np.log(ratio))), theta

    def pruned(self, columns: Floats, variant: str) -> _Points | None:
        """Without what stands out above a fit that is no fit; None if it is one, or if nothing does, or too much."""
        deviance, theta = self.deviance(columns, variant)
        if deviance < 2 * len(self.density):
            return None
        kept = (self.density / (columns @ theta + self.nothing) - 1) * np.sqrt(self.freedom / 2) < _OUTLIER
        if kept.all() or kept.sum() < max(0.6 * len(kept), _LEAST_POINTS):
            return None
        return _Points(self.density[kept], self.freedom[kept], tuple(np.array(self.frequency)[kept]), self.nothing)

    def score(self, columns: Floats, variant: str, *, steps: int = 3) -> float:
        """Deviance, and a price for what comes after the filter."""
        return self.deviance(columns, variant, steps=steps)[0] + (_PRICE if variant else 0.0)

    def at(self, shape: str, variant: str, corner: float) -> float:
        return self.score(_columns(shape, corner, np.array(self.frequency)), variant)

    def refined(self, shape: str, variant: str, corner: float, *, to: float) -> tuple[float, float]:
        """Least score near a corner of the grid, and where."""
        from scipy.optimize import minimize_scalar

        highest = math.log(_LAST_CORNER) if filter_models.digital(shape) else math.inf
        result = minimize_scalar(
            lambda x: self.at(shape, variant, math.exp(x)),
            bounds=(math.log(corner) - 0.35, min(math.log(corner) + 0.35, highest)),
            method="bounded",
            options={"xatol": to, "maxiter": 20},
        )
        return float(result.fun), math.exp(float(result.x))

    def error(self, shape: str, variant: str, corner: float) -> float:
        """Standard error of the corner, from the curvature of the deviance."""
        step = 0.02
        middle = self.at(shape, variant, corner)
        # On the flatter side, where another term takes the part of the filter; at its coefficient of 0 the other is steep.
        sides = min(self.at(shape, variant, corner * (1 + step)), self.at(shape, variant, corner * (1 - step)))
        curvature = max(2 * (sides - middle), 1e-9) / (step * corner) ** 2
        return min(math.sqrt(2 / curvature), corner)


def _points(spectrum: Spectrum, without: Sequence[tuple[float, float]]) -> _Points | None:
    """What is fitted: means over 1/16 octave; None if that is too little."""
    above = spectrum.frequency > _FIRST * spectrum.resolution
    frequency, kept = spectrum.frequency[above], np.ones(int(above.sum()), dtype=bool)
    for low, high in without:
        # A resonance has skirts as wide as itself.
        skirt = max(high - low, 3 * spectrum.resolution)
        kept &= (frequency < low - skirt) | (frequency > high + skirt)
    if kept.sum() < 32:
        return None
    density, freedom, centres = _binned(
        frequency * spectrum.tau0, spectrum.density[above], kept, _even(spectrum.dof)[above]
    )
    if len(density) < _LEAST_POINTS or not density.min() > 0:
        return None
    scale = float(np.median(density))
    return _Points(density / scale, freedom, centres, _DEPTH * float(density.max()) / scale)


def _promising(points: _Points) -> bool:
    """Whether a few filters, of which one is like any other to some degree, are any better than none."""
    least = points.deviance(_unfiltered(points.frequency))[0]
    some = min(
        points.deviance(_table(shape, x, points.frequency))[0]
        for shape, corners in (("first_order", _CORNERS[1::2]), ("mean", _CORNERS[1::2]), ("digital2", _SOME))
        for x in corners
    )
    return least - some > EVIDENCE / 4


def _binned(frequency: Floats, density: Floats, kept: Bools, dof: Floats) -> tuple[Floats, Floats, tuple[float, ...]]:
    """Means over 1/16 octave of the bins that are kept and are no lines."""
    edges = frequency[0] * 2.0 ** (np.arange(0, math.log2(frequency[-1] / frequency[0]) + 1, 1 / _PER_OCTAVE))
    # Towards half the sampling rate, a zero of digital filters, each is an eighth octave of the distance to it; the last
    # 1/64 is left out.
    step = frequency[1] - frequency[0]
    least = max(_ZERO, 8 * step)
    ends = 0.5 - 0.5 * 2.0 ** -np.arange(0, max(math.log2(0.5 / least), 0), 1 / 8)
    ends = ends[(ends > frequency[0]) & (0.5 - ends < (1 - 2 ** (-1 / _PER_OCTAVE)) / (1 - 2 ** (-1 / 8)) * ends)]
    edges = np.concatenate((edges[edges < (ends[0] if len(ends) else 0.5 - least)], ends))
    kept = kept & (frequency < 0.5 - least)
    starts = np.unique(np.searchsorted(frequency, edges * (1 - 1e-9)))
    starts = starts[starts < np.searchsorted(frequency, 0.5 - least)]
    kept = kept & (density < _beside(density) * (1 + 8 * np.sqrt(2 / dof) + 40 / dof))
    number = np.add.reduceat(kept.astype(float), starts)
    there = number > 0
    number = np.maximum(number, 1)
    means = np.add.reduceat(np.where(kept, density, 0), starts) / number
    centres = np.add.reduceat(np.where(kept, frequency, 0), starts) / number
    freedom = np.add.reduceat(np.where(kept, dof, 0), starts) / number
    freedom = np.minimum(freedom * number / (1 + 2 * (4 / 9) * np.maximum(1 - 1 / number, 0)), _MOST_FREEDOM)
    return means[there], freedom[there], tuple(float(f) for f in centres[there])


def _even(dof: Floats) -> Floats:
    """Half the sampling rate, where half of the degrees of freedom are, counts as its neighbours do."""
    return np.append(dof[:-1], dof[-2])


def _beside(density: Floats) -> Floats:
    """Medians of about 33 bins around each, in blocks of 11."""
    blocks = max(len(density) // 11, 1)
    edges = np.linspace(0, len(density), blocks + 1).astype(int)
    medians = [np.median(density[max(a - 11, 0) : b + 11]) for a, b in itertools.pairwise(edges)]
    return np.repeat(medians, np.diff(edges))


@functools.lru_cache(maxsize=8)
def _unfiltered(frequency: tuple[float, ...]) -> Floats:
    """White, flicker, rate random walk and quantization of the sampled record, each 1 somewhere within."""
    sine = np.sin(np.pi * np.array(frequency))
    return np.column_stack([np.ones_like(sine), sine.min() / sine, (sine.min() / sine) ** 2, sine**2])


def _columns(shape: str, corner: float, frequency: Floats) -> Floats:
    white = filter_models.folded_white(shape, corner, np.append(frequency, 0.0), 1.0)
    flicker = filter_models.folded_flicker(shape, corner, frequency, 1.0) * (2 * np.pi * frequency.min())
    sine = np.sin(np.pi * frequency)
    after = [(sine.min() / sine) ** 2, sine**2, np.ones_like(sine)]
    return np.column_stack([white[:-1] / white[-1], flicker, *after])


@functools.lru_cache(maxsize=512)
def _table(shape: str, corner: float, frequency: tuple[float, ...]) -> Floats:
    """Kept for the other axes of a record."""
    return _columns(shape, corner, np.array(frequency))
