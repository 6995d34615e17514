"""Spectral lines from vibration, mains or fans, and their effect on the Allan deviation and the coefficients."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from sigmatau._native import kernels
from sigmatau.arrays import Floats, Ints
from sigmatau.errors import DataError, OptionError
from sigmatau.estimators.allan import DeviationCurve, allan, cluster_sizes
from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.spectrum import Line, Mains, SpectralLines
from sigmatau.fitting.fit import fit
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.fitting.tau_min import LEAST_TIMES
from sigmatau.quality.effects import compared, in_fit
from sigmatau.quality.facts import channel_fact
from sigmatau.quality.samples.motion import bursts, summary
from sigmatau.quality.spectrum.peaks import Periodogram, measured_lines, periodogram
from sigmatau.record.record import Record
from sigmatau.record.streams import Stream
from sigmatau.spectrum.tapers import without_line

__all__ = ["find_lines", "lines", "lines_in_fits"]

SIGMA_FACTOR_WARNED = 1.10  # factor on σ(τ) at any τ from which lines are a warning

_LEAST_SAMPLES = 512
_LEAST_RUN = 64  # samples without a missing one, for the effect on σ(τ)
_MAINS = (50.0, 60.0)
_MOST_REMOVED = 12  # steady lines that are removed from the samples: weaker ones change no coefficient
_LEAST_REST = 0.02  # of a variance: no less is left when lines are removed
_NEGLIGIBLE = 2e-3  # of a variance: a line that makes less need not be removed
_CLEAR = 0.02  # of a variance, 1 % in σ: beyond it no line matters
_RINGING = 3.0  # [s] before and after motion that are left out with it
_SAME_RATE = 1e-12  # relative difference of equal sampling rates
_ROUNDING = 4e-15  # of the largest sample: a few of the last digits of double precision


def lines(stream: Stream, *, factor_warned: float = SIGMA_FACTOR_WARNED) -> list[Finding]:
    """One finding ``spectral_line`` for each channel that has lines, with all of them; see `lines_in_fits` for `factors`.

    Missing samples are replaced by the channel's mean, which neither hides a line nor makes one; so are samples in motion.
    A channel that moves for half of the record is not judged. A warning if lines make σ(τ) larger by `factor_warned` at any
    τ.

    Notes
    -----
    Of white, flicker or walking noise each density over the true one is a sum of χ² variables, whose weights are those of
    the correlation under Hann's taper. The far tail of that law, widened by Snedecor's F for the error of the median that
    it is compared with, gives the threshold for a false alarm of 1e-4 over all bins and widths of a channel.
    """
    scans = [_scanned(stream, channel) for channel in stream.channels]
    found = {scan.channel: _details(stream, scan) for scan in scans if scan is not None and scan.groups}
    # One fit option is advised for all axes: that of the slowest lines.
    latest = max((details.clear_from or 0.0 for details in found.values()), default=0.0)
    tau_min = latest if latest > stream.grid.tau0 * (1 + 1e-9) else 0.0
    return [
        Finding(
            details=replace(details, tau_min=tau_min),
            severity="warning" if details.factor >= factor_warned else "info",
            channels=(channel,),
            size=details.lines[0].amplitude,
            unit=stream.unit,
        )
        for channel, details in found.items()
    ]


def lines_in_fits(stream: Stream, fits: Mapping[str, NoiseFit], found: Sequence[Finding]) -> list[Finding]:
    """Findings ``spectral_line`` of `lines` with the factors of the lines on the printed fits; all others are left as they
    are.

    The lines are removed from the samples (steady ones) or from the variances (others), and the rest is fitted from the
    same shortest averaging time on. A fit that begins beyond a line, or has a sinusoid for it, hardly changes.
    """
    return [
        _fitted(stream, fits[finding.channel], finding)
        if finding.code == "spectral_line" and finding.channel in stream.channels and finding.channel in fits
        else finding
        for finding in found
    ]


def find_lines(stream: Stream) -> dict[str, tuple[Line, ...]]:
    """The lines of every channel, strongest first, each with its harmonics; see `lines`."""
    scans = {channel: _scanned(stream, channel) for channel in stream.channels}
    return {channel: () if scan is None else scan.groups for channel, scan in scans.items()}


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class _Scan:
    """The spectrum of a channel and its lines; `moved` if times of motion were left out."""

    channel: str
    spectrum: Periodogram
    groups: tuple[Line, ...]
    moved: bool = False

    @property
    def everything(self) -> list[Line]:
        return [line for group in self.groups for line in (group, *group.harmonics)]


@channel_fact
def _scanned(stream: Stream, channel: str) -> _Scan | None:
    found = _scan(stream, channel, ())
    if found is None or not found.groups or stream.quantity not in ("angular_rate", "acceleration"):
        return found
    # A mount that rings after a shock makes a line, too: only lines at rest count.
    moving = [(burst.start, burst.stop) for burst in bursts(stream, summary(stream, channel))]
    return _scan(stream, channel, moving) if moving else found


def _scan(stream: Stream, channel: str, moving: Sequence[tuple[int, int]]) -> _Scan | None:
    y = _filled(stream, channel, without=moving)
    if y is None:
        return None
    spectrum = periodogram(y, stream.grid.tau0)
    groups = _grouped(_distinct(measured_lines(spectrum), spectrum.step), stream.grid.rate, spectrum.step)
    return _Scan(channel=channel, spectrum=spectrum, groups=groups, moved=bool(moving))


def _filled(stream: Stream, channel: str, *, without: Sequence[tuple[int, int]]) -> Floats | None:
    """Samples without mean and slope, 0 where missing and in stretches `without`; None if too few, or all on a line."""
    y = np.ascontiguousarray(stream.column(channel))
    # A ramp alone leaves its rounding error, which has lines.
    rounding = _ROUNDING * max(float(np.fmax.reduce(y, initial=0.0)), -float(np.fmin.reduce(y, initial=0.0)))
    if without:
        y = y.copy()
        margin = round(_RINGING / stream.grid.tau0)
        for start, stop in without:
            y[max(start - margin, 0) : stop + margin] = np.nan
    if stream.mask is not None or without:
        there = np.isfinite(y)
        if there.mean() < 0.5:
            return None
        if not there.all():
            t = np.flatnonzero(there)
            kept = y[there]
            middle = t.mean()
            slope = float((t - middle) @ (kept - kept.mean())) / float((t - middle) @ (t - middle))
            y = np.zeros(len(y))
            # Scaled to the power of the whole record.
            y[there] = (kept - kept.mean() - slope * (t - middle)) / math.sqrt(there.mean())
        else:
            y = without_line(y)
    elif len(y) >= _LEAST_SAMPLES:
        y = without_line(y)
    if len(y) < _LEAST_SAMPLES or not y.max() - y.min() > rounding:
        return None
    return y


def _distinct(found: Sequence[Line], step: float) -> list[Line]:
    """Lines, strongest first, without those that are the skirt of a stronger one."""
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
    """Lines with their harmonics: others at whole multiples of the frequency of the lowest, folded."""
    left = sorted(found, key=lambda line: line.frequency)
    groups: list[Line] = []
    while left:
        line = left.pop(0)
        own = max(line.width, step)
        members = []
        for other in left:
            order = max(round(other.frequency / line.frequency), 2)
            error = min(abs(_fold(k * line.frequency, rate) - other.frequency) for k in {order, 2, 3, 4, 5})
            # The harmonic of an unsteady line is wider by its order. High multiples match weak lines by chance.
            if order <= 16 and error <= min(1.5 * order * own, 0.1 * line.frequency):
                members.append(other)
        left = [other for other in left if other not in members]
        groups.append(replace(line, harmonics=tuple(members), mains=_mains(line, rate)))
    return tuple(sorted(groups, key=lambda line: -line.amplitude))


def _fold(frequency: float, rate: float) -> float:
    return abs(frequency - rate * round(frequency / rate))


def _mains(line: Line, rate: float) -> Mains | None:
    """The mains wander by ±0.2 Hz a multiple at most, usually by far less; the sampling rate is known to 1e-4."""
    if line.width > 0.2:
        return None
    for multiple in (1, 2, 3):
        for mains in _MAINS:
            seen = _fold(multiple * mains, rate)
            if seen > 0.5 and abs(line.frequency - seen) <= 0.05 * multiple + 1e-4 * multiple * mains + line.width:
                return Mains(frequency=mains, multiple=multiple, folded=seen != multiple * mains)
    return None


def _details(stream: Stream, scan: _Scan) -> SpectralLines:
    details = SpectralLines(
        lines=scan.groups,
        factor=1.0,
        tau=None,
        clear_from=None,
        stretches=round(scan.spectrum.dof / 2),
        between_motion=scan.moved,
    )
    whole = stream.only(scan.channel).longest_run()
    if whole.grid.n < _LEAST_RUN:
        return details
    tau0 = stream.grid.tau0
    sizes = cluster_sizes("half", n=whole.grid.n, tau0=tau0)
    sizes = sizes[sizes <= whole.grid.n // 3]
    (measured,), _, _ = kernels.allan_variances(
        [whole.column(scan.channel)], sizes, overlap="full", counting="standard", threads=1, names=[scan.channel]
    )
    column = sum((_avar(line, scan.spectrum, sizes, tau0) for line in scan.everything), np.zeros(len(sizes)))
    # What is left is no less than the error of a single variance allows: a line may be all there is.
    rest = np.maximum(measured - column, _LEAST_REST * measured)
    if not rest.min() > 0:  # the samples repeat themselves exactly: there is no noise beside the lines
        return details
    factors = np.sqrt(measured / rest)
    worst = int(np.argmax(factors))
    above = np.flatnonzero(column > _CLEAR * rest)
    first = int(above[-1]) + 1 if len(above) else 0
    return replace(
        details,
        factor=float(factors[worst]),
        tau=float(sizes[worst] * tau0),
        clear_from=float(sizes[first] * tau0) if len(sizes) - first >= LEAST_TIMES else None,
    )


def _fitted(stream: Stream, fitted: NoiseFit, finding: Finding) -> Finding:
    """A finding with the effect of its lines on the printed fit."""
    scan = _scanned(stream, fitted.channel)
    if scan is None or fitted.tau_min is None or fitted.n != stream.grid.n:
        return finding
    try:
        after = fit(_curve_without(stream, scan, fitted), tau_min=fitted.tau_min)
    except (DataError, OptionError):  # too few averaging times
        return finding
    changes = compared(fitted, after)
    return replace(finding, **in_fit(changes, fitted, after, without=(finding.code,)))


def _curve_without(stream: Stream, scan: _Scan, fitted: NoiseFit) -> DeviationCurve:
    """The curve without the lines; lines that are negligible at the averaging times of the fit may remain."""
    one = stream.only(scan.channel)
    tau0 = stream.grid.tau0
    sizes = cluster_sizes("half", n=stream.grid.n, tau0=tau0)
    used = sizes[sizes * tau0 >= (fitted.tau_min or 0.0) * (1 - 1e-9)]
    least = _NEGLIGIBLE * fitted.avar(m=used)
    matter = [line for line in scan.everything if (_avar(line, scan.spectrum, used, tau0) > least).any()]
    steady = [line for line in matter if line.width == 0][:_MOST_REMOVED]
    if steady:
        rest = _without_sinusoids(one.column(scan.channel), steady, tau0)
        one = one.with_rates([rest])
    curve = allan(Record(streams=(one,)))[scan.channel]
    others = [_avar(line, scan.spectrum, curve.m, tau0) for line in matter if line.width > 0]
    left = curve.avar - sum(others, np.zeros(len(curve.m)))
    return replace(curve, avar=np.maximum(left, _LEAST_REST * curve.avar))


def _without_sinusoids(y: Floats, steady: Sequence[Line], tau0: float) -> Floats:
    """Samples without each line: a sinusoid whose amplitude and phase may change linearly, for an error of half a bin."""
    there = np.isfinite(y)
    whole = bool(there.all())
    level = float(y.mean() if whole else y[there].mean())
    rest = y - level
    t = np.arange(len(y), dtype=float)
    slow = 2 * t / len(y) - 1
    for line in steady:
        turn = np.exp(2j * math.pi * line.frequency * tau0 * t)
        parts = [turn.real] if _alternates(line, tau0) else [turn.real, turn.imag]
        columns = np.column_stack([*parts, *(slow * part for part in parts)])
        used = columns if whole else columns[there]
        theta = np.linalg.solve(used.T @ used, used.T @ (rest if whole else rest[there]))
        rest = rest - columns @ theta
    return np.asarray(rest + level)


def _alternates(line: Line, tau0: float) -> bool:
    return abs(line.frequency * tau0 - 0.5) < _SAME_RATE


def _avar(line: Line, spectrum: Periodogram, sizes: Ints, tau0: float) -> Floats:
    """Allan variance of a line: of the sinusoid if it is steady, else of its band of the spectrum by eq. (11s)."""
    if line.width == 0:
        # At half the sampling rate there is no phase: alternating ±A has twice the power of a sinusoid.
        amplitude = line.amplitude * (math.sqrt(2) if _alternates(line, tau0) else 1.0)
        return kernels.sinusoid_avar(amplitude, line.frequency, sizes, tau0)
    first, last = round(line.low / spectrum.step), round(line.high / spectrum.step)
    frequency = np.arange(first, last + 1) * spectrum.step
    excess = spectrum.density[first : last + 1]
    # The noise level under the line is chosen such that the line has its power.
    excess = excess - (excess.sum() - line.amplitude**2 / (4 * spectrum.step)) / len(excess)
    few = max(1, len(excess) // 512)  # bins that are averaged: far less than 1/τ wherever the line matters
    at = np.arange(0, len(excess), few)
    frequency = np.add.reduceat(frequency, at) / np.diff(np.append(at, len(excess)))
    excess = np.add.reduceat(excess, at)
    angle = math.pi * frequency * tau0
    gains = np.sin(np.outer(sizes, angle)) ** 4 / np.outer(sizes.astype(float) ** 2, np.sin(angle) ** 2)
    return np.asarray(np.maximum(4 * spectrum.step * (gains @ excess), 0.0))
