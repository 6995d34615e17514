"""Records that were interpolated to a higher rate.

Interpolation weights the true samples by the position between them, so that the power of differences of the record varies at
the true rate. The spectrum of the squared differences has a line there, which no stationary noise has, filtered or not. A
better interpolation without such a line leaves the spectrum empty above half the true rate.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError
from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.spectrum import Resampled
from sigmatau.quality.facts import channel_fact
from sigmatau.quality.spectrum import filter_models
from sigmatau.record.streams import Stream
from sigmatau.spectrum.estimate import welch
from sigmatau.spectrum.result import Spectrum
from sigmatau.spectrum.tapers import good_length, hann

__all__ = ["resampled", "upsampled"]

Floats = NDArray[np.float64]

DEPTH = 0.25
"""Least amplitude of the squared differences, over their mean. Linear interpolation from 63 to 200 Hz has 1.3, from 95 to
100 Hz 0.6; a clean record of 2^17 samples has 0.02 at the largest of its frequencies."""

EMPTY = 1e-3
"""Largest density of an empty band over that beside it; the band must be a tenth of the spectrum."""

_SAMPLES = 1 << 16
_SHORTEST = 1 << 10
_EXACT = 1e-6  # of the root mean square: differences below are none
_SKIRT = 64  # bins: a transform without a taper spreads a line far
_BLOCK = 64  # bins whose median is the noise beside a line
_STANDS_OUT = 40.0  # bin over the noise: by chance in one of 1e13 times the bins, where the noise is flat
_CORE = 3  # bins to either side that hold the power of a steady line
_LEAST_NOTHING = 0.02
_OUTLIER = 16.0
_SUDDEN = 10  # edge over its width, at least: a digital filter of fourth order is as steep, but not as sudden


def upsampled(stream: Stream) -> list[Finding]:
    """Findings ``interpolated``: one a channel that was interpolated from samples at a lower rate.

    Parameters
    ----------
    stream : Stream
        Static data. The first stretch of 2^16 samples without a missing one is used, or the longest.

    Returns
    -------
    list of Finding
        Warnings. `factors` holds the random walk read off at one sample over the sensor's own.
    """
    found = []
    for channel in stream.channels:
        what = resampled(stream, channel)
        if what is not None:
            found.append(
                Finding(
                    details=what,
                    severity="warning",
                    channels=(channel,),
                    size=what.rate,
                    unit="Hz",
                    factors=(("random_walk", what.sigma_one_sample),),
                )
            )
    return found


@channel_fact
def channel_spectrum(stream: Stream, channel: str) -> Spectrum | None:
    """Welch's estimate of a channel; None if too many samples are missing."""
    try:
        return welch(np.ascontiguousarray(stream.column(channel)), stream, channel)
    except DataError:
        return None


@channel_fact
def resampled(stream: Stream, channel: str) -> Resampled | None:
    """How a channel was interpolated, or None; see `upsampled`."""
    spectrum = channel_spectrum(stream, channel)
    return None if spectrum is None else _resampled(np.ascontiguousarray(stream.column(channel)), spectrum)


def _resampled(y: Floats, spectrum: Spectrum) -> Resampled | None:
    tau0 = spectrum.tau0
    piece = _piece(y)
    if piece is None:
        return None
    nothing = []
    for order in (1, 2):
        difference = np.diff(piece, n=order)
        power = difference * difference
        mean = float(power.mean())
        if not mean > 0:
            return None
        nothing.append(float(np.mean(power < (_EXACT * _EXACT) * mean)))
        np.minimum(power, _OUTLIER * mean, out=power)
        swing = _swing(power)
        if swing is None:
            continue
        rest = _without_lines(difference)
        if rest is not difference:
            power = rest * rest
            mean = float(power.mean())
            swing = _swing(np.minimum(power, _OUTLIER * mean)) if mean > 0 else None
            if swing is None:
                continue
        if order == 1:
            second = np.diff(piece, n=2)
            nothing.append(float(np.mean(second * second < (_EXACT * _EXACT) * mean)))
        kind, rate = _source(swing[0], nothing[0], nothing[1], spectrum)
        shape: filter_models.Shape = "mean" if kind == "held" else "bartlett"
        if kind == "smooth":
            short = _short(spectrum, rate)
        else:
            short = math.sqrt(float(filter_models.relative_avar(shape, 1 / rate, 1, 1.0)[0]))
        if short >= 1:
            continue  # interpolation takes power from the short times: this is a vibration that comes and goes
        return Resampled(
            kind=kind,
            rate=rate / tau0,
            log_rate=1 / tau0,
            sigma_one_sample=short,
            right_from=filter_models.right_from(shape, 1 / rate, 1.0) * tau0,
            depth=swing[1],
        )
    return _empty(spectrum)


def _piece(y: Floats) -> Floats | None:
    """The first stretch of `_SAMPLES` without a missing sample, or the longest there is."""
    piece = y[:_SAMPLES]
    if np.isnan(piece).any():
        edges = np.concatenate(([-1], np.flatnonzero(np.isnan(y)), [len(y)]))
        runs = np.diff(edges)
        long = np.flatnonzero(runs > _SAMPLES)
        k = int(long[0]) if len(long) else int(np.argmax(runs))
        piece = y[edges[k] + 1 : min(edges[k + 1], edges[k] + 1 + _SAMPLES)]
    return piece if len(piece) >= _SHORTEST else None


def _swing(power: Floats) -> tuple[float, float] | None:
    """Frequency in sampling rates at which squared differences vary, and the amplitude over their mean."""
    length = good_length(len(power) - len(power) % 2)
    z = power[:length] - power[:length].mean()
    mean = float(power.mean())
    turns = np.abs(float(z[::2].mean() - z[1::2].mean())) / mean  # at half the sampling rate: true rate 1/2
    sd = float(z.std()) / mean * math.sqrt(4 / length)
    if turns > max(2 * DEPTH, 6 * sd) and length % 2 == 0:
        return 0.5, turns
    lines, density = _lines(z[:length])
    if not lines.any():
        return None
    k = int(np.argmax(np.where(lines, density, 0)))
    core = density[max(k - _CORE, 1) : k + _CORE + 1]
    middle = max(k - _CORE, 1) + np.arange(len(core))
    amplitude = 2 * math.sqrt(float(core.sum()) / length)
    if amplitude <= DEPTH * mean:
        return None
    return float(core @ middle) / float(core.sum()) / length, amplitude / mean


def _lines(y: Floats) -> tuple[NDArray[np.bool_], Floats]:
    """Bins of a periodogram that stand out, and the periodogram, whose sum over a line is a quarter of its squared
    amplitude times the number of samples.
    """
    taper = hann(len(y))
    density = np.abs(np.fft.rfft(y * taper)) ** 2 / float(taper @ taper)
    blocks = len(density) // _BLOCK
    lines = np.zeros(len(density), dtype=bool)
    if blocks < 2:
        return lines, density
    whole = density[: blocks * _BLOCK].reshape(blocks, _BLOCK)
    medians = np.median(whole, axis=1) / math.log(2)
    beside = np.concatenate((medians[:1], medians, medians[-1:]))
    noise = np.maximum(np.maximum(beside[:-2], beside[2:]), medians)
    lines[: blocks * _BLOCK] = (whole > _STANDS_OUT * noise[:, None]).ravel()
    lines[blocks * _BLOCK :] = density[blocks * _BLOCK :] > _STANDS_OUT * noise[-1]
    lines[:_BLOCK] = False  # slow noise
    return lines, density


def _without_lines(difference: Floats) -> Floats:
    """Differences without the lines of the record: the square of a sinusoid varies at twice its frequency."""
    length = good_length(len(difference))
    lines, _ = _lines(difference[:length])
    if not lines.any():
        return difference
    transform = np.fft.rfft(difference[:length])
    transform[np.convolve(lines, np.ones(2 * _SKIRT + 1), mode="same") > 0.5] = 0
    return np.fft.irfft(transform, length)


def _source(frequency: float, held: float, straight: float, spectrum: Spectrum) -> tuple[str, float]:
    """How it was interpolated, and the true rate, in sampling rates.

    The swing is at the true rate or at a multiple of it, folded. The shares of first and second differences that are nothing
    tell which: held samples leave 1 − rate, straight lines 1 − 2·rate. If there are none, the spectrum tells, which is down
    to a half at 0.32 (straight lines) to 0.5 (the best interpolation) of the true rate.
    """
    rates = [f / k for k in (1, 2, 3) for f in (frequency, 1 - frequency)]
    for kind, share, count in (("held", held, 1), ("linear", straight, 2)):
        if share > _LEAST_NOTHING:
            guess = (1 - share) / count
            nearest = min(rates, key=lambda rate: abs(rate - guess))
            if abs(nearest - guess) < 0.02:
                return kind, nearest
    f, density = spectrum.frequency * spectrum.tau0, spectrum.density
    plateau = float(np.median(density[(f > 0.02) & (f < 0.08)]))
    half = float(f[np.flatnonzero(density > 0.5 * plateau)[-1]])

    def away(rate: float) -> float:
        x = math.log(rate / half)
        return max(math.log(2.0) - x, x - math.log(3.13), 0.0)

    rate = min(rates[:2], key=away)
    return "smooth", rate


def _short(spectrum: Spectrum, rate: float) -> float:
    """σ at one sample over what white noise at the plateau makes; eq. (11) for samples is 4·∫S·sin²(πf)df there."""
    f, density = spectrum.frequency * spectrum.tau0, spectrum.density
    plateau = float(np.median(density[(f > 0.02 * rate) & (f < 0.15 * rate)]))
    return math.sqrt(4 * float(density @ np.sin(np.pi * f) ** 2) * float(f[1] - f[0]) / plateau)


def _empty(spectrum: Spectrum) -> Resampled | None:
    """A band up to half the sampling rate with nothing in it, beyond an edge steeper than a filter's of eighth order."""
    density, frequency = spectrum.density, spectrum.frequency
    blocks = len(density) // 8
    if blocks < 16:
        return None
    levels = np.median(density[: blocks * 8].reshape(blocks, 8), axis=1)
    centres = frequency[: blocks * 8].reshape(blocks, 8).mean(axis=1)
    top = float(np.median(levels[-blocks // 10 :]))
    if not top > 0:
        return None
    full = np.flatnonzero(levels > 0.25 * np.median(levels[: max(blocks // 4, 2)]))
    gone = np.flatnonzero(levels > 2 * EMPTY * levels[full].max() if len(full) else levels > np.inf)
    if not len(full) or not len(gone):
        return None
    edge, end = int(full[-1]), int(gone[-1]) + 1
    if end >= 0.9 * blocks or end - edge > max(3, edge // _SUDDEN):
        return None
    share = float(np.median(levels[end:]) / np.median(levels[max(edge - 8, 0) : edge + 1]))
    if share > EMPTY:
        return None
    band = 2 * float(centres[edge])
    brick = band * spectrum.tau0
    return Resampled(
        kind="empty",
        rate=band,
        log_rate=1 / spectrum.tau0,
        # White noise up to f_b alone: AVAR(1) is half the mean square of first differences.
        sigma_one_sample=math.sqrt(max(brick * (1 - float(np.sinc(brick))), 0.0)),
        right_from=max(2 / brick, 1.0) * 4 * spectrum.tau0,
        depth=share,
    )
