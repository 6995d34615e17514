"""Spectrum of a log in bins of an eighth of an octave, by cosine modes, for fits of a sensor's filter.

The modes of the cosine transform of white noise are independent, each χ² with one degree of freedom; those of a random
walk are nearly independent. Therefore no taper is needed, and slow noise does not leak into the white band.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np

from sigmatau.arrays import Bools, Floats, median, run_edges
from sigmatau.errors import DataError, RecordTooShortError
from sigmatau.frozen import frozen

MIN_RUN = 256
MIN_SAMPLES = 1000
"""Smallest number of samples of a run without gaps, and of all runs; with fewer, slow noise hides the white band.
"""

NODES = 5
"""Frequencies in a bin at which a model is averaged."""

_PER_OCTAVE = 8
_LOWEST_MODE = 4  # lowest mode that is used; lower modes contain the drift of the record
_OCTAVES_OF_PEAK = 12  # octaves below half the rate in which the octave with the most variance is searched
# octaves below that peak from which bins are used: slower noise contains no information about the filter
_OCTAVES_BELOW = 8
_WEAKEST = 1e-3  # density, over that of the peak, below which converter noise hides that of the sensor
_MIN_MODES = 16  # smallest number of modes of a bin whose median is used, or that can be the peak
_LINE = 30.0  # power of a mode over the mean of its bin that makes it a line; noise reaches it in 4 of 10⁸ cases
_MODES_BESIDE_LINE = 8  # number of modes on either side of a line that are left out with it
_LEAKAGE = 0.02  # largest leakage of a line, over the noise, in modes that are not left out
_SUBTRACTED_LINE = 1e4  # power, over the noise beside it, above which a line is subtracted before the transform
_MAX_LINES = 12  # largest number of lines that are subtracted
_LOWEST_PEAK = 8  # index of the first frequency at which lines are searched
_NEIGHBOURS = 200  # number of frequencies on either side to which a line is compared
_GOLDEN = 0.6180339887498949  # golden section of an interval
_GOLDEN_STEPS = 30  # number of sections, to 1e-6 of a frequency step
_ZERO_DENSITY = 1e-300  # replaces a density of 0
_MAX_RUNS = 64  # largest number of runs without gaps that are used, the longest ones
_MEDIAN_OF_MODE = 0.45493642  # median of χ² with one degree of freedom
_SAMPLES_FOR_STEP = 4096  # number of samples in which the step of the values is searched
_STEP_TOLERANCE = 1e-3  # largest distance of a difference from a multiple of the step, relative to the step
_MAX_STEPS = 1e4  # largest number of steps in the largest difference: above it, quantization does not matter


@frozen(eq=False)
class LogSpectrum:
    """Densities of one log of one channel.

    Attributes
    ----------
    name : str
        Name of the log.
    rate : float
        [Hz]
    duration : float
        Duration of the samples that are used. [s]
    nodes : ndarray, shape (n_bins, NODES)
        Frequencies in each bin. [Hz]
    density : ndarray, shape (n_bins,)
        Two-sided. [(unit of the rate)²/Hz]
    modes : ndarray, shape (n_bins,)
        Degrees of freedom of each density.
    quantization : float
        Two-sided density of the rounding of the values. [(unit of the rate)²/Hz]
    lines : int
        Modes of lines that are left out.
    """

    name: str
    rate: float
    duration: float
    nodes: Floats
    density: Floats
    modes: Floats
    quantization: float
    lines: int


def log_spectrum(name: str, rate: float, y: Floats, channel: str = "") -> LogSpectrum:
    """Spectrum of one channel of a log; NaN are gaps.

    Raises
    ------
    RecordTooShortError
        If there are fewer than `MIN_SAMPLES` in runs of `MIN_RUN` without gaps.
    DataError
        If the channel never changes.
    """
    runs = [y[start:stop] for start, stop in run_edges(np.isfinite(y)) if stop - start >= MIN_RUN]
    runs = sorted(runs, key=len, reverse=True)[:_MAX_RUNS]
    usable = sum(map(len, runs))
    if usable < MIN_SAMPLES:
        has_gaps = not np.isfinite(y).all()
        amount = f"{usable} samples in runs of {MIN_RUN} without gaps" if has_gaps else f"{len(y)} samples"
        raise RecordTooShortError(
            f"{name}: {channel} has {amount}; at least {MIN_SAMPLES} are needed, better 30 000."
            f" Record {'again without losses' if has_gaps else 'longer'}",
            need=MIN_SAMPLES,
            got=usable if has_gaps else len(y),
        )
    lowest = max(_LOWEST_MODE * rate / (2 * len(runs[0])), rate / 2 ** (1 + _OCTAVES_OF_PEAK + _OCTAVES_BELOW))
    octaves = math.log2(0.5 * rate / lowest)
    count = math.floor(octaves * _PER_OCTAVE)
    edges = 0.5 * rate * 2.0 ** (np.arange(-count, 1) / _PER_OCTAVE)
    power, modes, lines = np.zeros(count), np.zeros(count), 0
    for run in runs:
        first, run_density, masked = _binned(run, rate, edges)
        power += first
        modes += run_density
        lines += masked
    used = modes > 0
    density = np.where(used, power / np.maximum(modes, 1), 0.0)
    middle = np.sqrt(edges[1:] * edges[:-1])
    used &= _white_band(middle, density, modes, rate)
    if not (used & (density > 0)).any():
        raise DataError(f"{name}: {channel} never changes, or has no noise in its spectrum. Leave it out")
    fractions = (np.arange(NODES) + 0.5) / NODES
    nodes = edges[:-1, None] + np.diff(edges)[:, None] * fractions
    return LogSpectrum(
        name=name,
        rate=rate,
        duration=usable / rate,
        nodes=nodes[used],
        density=density[used],
        modes=modes[used],
        quantization=_quantization(runs[0]) / rate,
        lines=lines,
    )


def _binned(y: Floats, rate: float, edges: Floats) -> tuple[Floats, Floats, int]:
    """Sum of the densities of the modes in each bin, the number of modes, and the number that belongs to lines."""
    n = len(y)
    modes = cosine_modes(_without_strong_lines(y - y.mean())) ** 2 * (2 / (n * rate))
    # Mode k has the frequency k·rate/(2n). The last edge is half the rate, which no mode has.
    places = np.minimum(np.ceil(edges * (2 * n / rate) - 0.5).astype(np.int64), n)
    places = np.maximum(places, _LOWEST_MODE)
    pairs = list(itertools.pairwise(places.tolist()))
    noise = _without_lines(modes, pairs)
    sums, counts = np.zeros(len(pairs)), np.zeros(len(pairs))
    for k, (start, stop) in enumerate(pairs):
        binned = modes[start:stop][noise[start:stop]]
        sums[k], counts[k] = binned.sum(), len(binned)
    return sums, counts, int(np.count_nonzero(~noise))


def cosine_modes(y: Floats) -> Floats:
    """Σ y_j cos(π (j + ½) k / n), k = 0 … n − 1, by one complex transform (Makhoul 1980)."""
    n = len(y)
    turned = np.concatenate((y[::2], y[1::2][::-1]))
    transformed = np.fft.rfft(turned)
    k = np.arange(n // 2 + 1)
    twisted = transformed * np.exp(-0.5j * np.pi * k / n)
    modes = np.empty(n)
    modes[: n // 2 + 1] = twisted.real
    modes[n - k[1 : (n + 1) // 2]] = -twisted.imag[1 : (n + 1) // 2]
    return modes


def _without_strong_lines(y: Floats) -> Floats:
    """Subtract from the samples the sinusoids that leak into the whole spectrum. The frequency of each is fitted too."""
    n = len(y)
    t = np.arange(n) - 0.5 * (n - 1)
    window = 1 + np.cos(2 * np.pi * t / n)
    for _ in range(_MAX_LINES):
        spectrum = np.abs(np.fft.rfft(y * window)) ** 2
        k = _LOWEST_PEAK + int(np.argmax(spectrum[_LOWEST_PEAK:]))
        neighbours = spectrum[max(k - _NEIGHBOURS, _LOWEST_PEAK) : k + _NEIGHBOURS]
        if not spectrum[k] > _SUBTRACTED_LINE * median(neighbours):
            break
        low, high = (k - 1) / n, (k + 1) / n
        for _ in range(_GOLDEN_STEPS):
            a, b = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
            powers = [abs(np.dot(y * window, np.exp(-2j * np.pi * x * t))) for x in (a, b)]
            low, high = (a, high) if powers[0] < powers[1] else (low, b)
        phase = np.pi * (low + high) * t
        waves = np.column_stack([np.cos(phase), np.sin(phase)])
        y = y - waves @ np.linalg.lstsq(waves, y, rcond=None)[0]
    return y


def _without_lines(modes: Floats, pairs: Sequence[tuple[int, int]]) -> Bools:
    """Select the modes of noise, without lines and their leakage, which falls as the square of the distance."""
    noise = np.ones(len(modes), dtype=bool)
    for start, stop in pairs:
        if stop - start < _MIN_MODES:
            continue
        mean = median(modes[start:stop]) / _MEDIAN_OF_MODE
        for k in (np.flatnonzero(modes[start:stop] > _LINE * mean) + start).tolist():
            side = _MODES_BESIDE_LINE + math.ceil(
                math.sqrt(float(modes[k]) / max(_LEAKAGE * mean, _ZERO_DENSITY)) / math.pi
            )
            noise[max(k - side, 0) : k + side + 1] = False
    return noise


def _white_band(f: Floats, density: Floats, modes: Floats, rate: float) -> Bools:
    """Bins from eight octaves below the octave with the most variance, without those of the filter's deep stop band."""
    candidates = (modes >= _MIN_MODES) & (f > rate / 2 ** (1 + _OCTAVES_OF_PEAK))
    if not candidates.any():
        return np.zeros(len(f), dtype=bool)
    peak = int(np.argmax(np.where(candidates, f * density, 0.0)))
    return np.asarray((f >= f[peak] / 2**_OCTAVES_BELOW) & (density > _WEAKEST * density[peak]))


def _quantization(y: Floats) -> float:
    """Variance of the rounding of values to integer steps, step²/12; 0 if they have no step. [unit²]"""
    differences = np.abs(np.diff(y[:_SAMPLES_FOR_STEP]))
    differences = differences[differences > 0]
    if not len(differences):
        return 0.0
    step = float(differences.min())
    steps = differences / step
    whole = np.abs(steps - np.round(steps)) <= _STEP_TOLERANCE * np.maximum(steps, 1)
    return step * step / 12 if whole.all() and steps.max() < _MAX_STEPS else 0.0
