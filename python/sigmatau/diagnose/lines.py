"""Spectral lines: vibration, mains, fans, and what they do to the Allan deviation and the coefficients."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sigmatau import _kernels
from sigmatau.allan import cluster_sizes
from sigmatau.diagnose.peaks import Line, Periodogram, hertz, measured_lines, periodogram
from sigmatau.fitting.components import LINEAR, components
from sigmatau.fitting.gls import Gls
from sigmatau.results import Finding, seconds
from sigmatau.spectrum import without_line
from sigmatau.streams import Stream

__all__ = ["Line", "find_lines", "lines"]

Floats = NDArray[np.float64]

NOTICEABLE = 1.10
"""A line is a warning where it makes σ(τ) larger by this factor at some τ; below, it is good to know."""

_SHORTEST = 512
_MOST_NAMED = 4
_MAINS = (50.0, 60.0)
_NOTHING_LEFT = 0.05  # below, a factor says no more than that the fit has gone wrong


_LEAST_RUN = 64  # samples


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
    Of white, flicker or walking noise each density over the true one is a sum of χ² variables, whose weights are those of
    the correlation under Hann's taper; the far tail of that law, widened by Snedecor's F for the error of the median that
    it is held against, gives the threshold for a false alarm of 1e-4 over all bins and widths of a channel.
    """
    found = []
    for channel in stream.channels:
        y = _filled(stream, channel)
        if y is None:
            continue
        spectrum = periodogram(y, stream.grid.tau0)
        groups = _lines_of(spectrum, stream)
        if groups:
            found.append(_finding(stream, channel, groups, spectrum))
    return found


def find_lines(stream: Stream) -> dict[str, tuple[Line, ...]]:
    """The lines of every channel, strongest first, each with its harmonics; see `lines`."""
    found: dict[str, tuple[Line, ...]] = {}
    for channel in stream.channels:
        y = _filled(stream, channel)
        found[channel] = () if y is None else _lines_of(periodogram(y, stream.grid.tau0), stream)
    return found


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


def _lines_of(spectrum: Periodogram, stream: Stream) -> tuple[Line, ...]:
    found = measured_lines(spectrum, unit=stream.unit)
    return _grouped(_distinct(found, spectrum.step), stream.grid.rate, spectrum.step)


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
        groups.append(replace(line, harmonics=tuple(members), mains=_mains(line, rate)))
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


def _finding(stream: Stream, channel: str, groups: Sequence[Line], spectrum: Periodogram) -> Finding:
    strongest = groups[0]
    everything = [line for group in groups for line in (group, *group.harmonics)]
    effect, changes, factor = _effect(stream, channel, everything, spectrum)
    named = "; ".join(map(repr, groups[:_MOST_NAMED]))
    more = f"; and {len(groups) - _MOST_NAMED} weaker" if len(groups) > _MOST_NAMED else ""
    part = ", looked for in four stretches" if spectrum.dof > 2 else ""
    return Finding(
        code="spectral_line",
        severity="warning" if factor >= NOTICEABLE else "info",
        channel=channel,
        message=f"{'line' if len(everything) == 1 else 'lines'} in the spectrum: {named}{more}{part}",
        where=f"f = {hertz(strongest.frequency)} Hz",
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
    stream: Stream, channel: str, found: Sequence[Line], spectrum: Periodogram
) -> tuple[str, tuple[tuple[str, float], ...], float]:
    """In words; changes of coefficients; by which factor σ(τ) grows at worst."""
    whole = stream.only(channel).longest_run()
    if whole.grid.n < _LEAST_RUN:
        return "no run without a missing sample is long enough to tell what it does to σ(τ)", (), 1.0
    sizes = cluster_sizes("half", n=whole.grid.n, tau0=stream.grid.tau0)
    sizes = sizes[sizes <= whole.grid.n // 3]
    (measured,), _, _ = _kernels.allan_variances(
        [whole.column(channel)], sizes, overlap="full", counting="standard", threads=1, names=[channel]
    )
    column = sum((_avar(line, spectrum, sizes, stream.grid.tau0) for line in found), np.zeros(len(sizes)))
    # What is left is no less than the error of a single variance allows: a line may be all there is.
    rest = np.maximum(measured - column, 0.02 * measured)
    if not rest.min() > 0:
        return "the samples repeat themselves exactly: there is no noise beside it", (), 1.0
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
            if ratio < _NOTHING_LEFT:
                words.append(f"hardly any {term.replace('_', ' ')}")
            elif abs(ratio - 1) >= 0.01:
                changes.append((term, ratio))
                words.append(f"{term.replace('_', ' ')} {_times(ratio)} as large")
        if words:
            text += f"; a fit to all times that knows no line finds {' and '.join(words)}"
    return text, tuple(changes), factor


def _avar(line: Line, spectrum: Periodogram, sizes: NDArray[np.int64], tau0: float) -> Floats:
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
