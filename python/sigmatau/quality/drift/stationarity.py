"""Stationarity of the noise over the record, by two tests.

Segments: the Allan variances of eight segments at octaves of τ are compared, with the covariance that the fitted noise
has in a segment. An Allan variance is skewed, like χ² over its degrees of freedom ν; its cube root is nearly normal with
variance 2/(9ν) of its squared mean (Wilson & Hilferty). The statistic is therefore the sum of squares of whitened cube
roots, χ² with 7 degrees of freedom per octave, over all octaves or the most significant one; docs/study/stability.md
measures the false alarms. Cusum: the running sum of the sizes of first differences is compared with a straight line; its
largest distance follows Kolmogorov's law and gives the time of the change.

References
----------
E. B. Wilson, M. M. Hilferty, "The distribution of chi-square", PNAS 17 (1931), :doi:`10.1073/pnas.17.12.684`; C. Inclán,
G. C. Tiao, "Use of cumulative sums of squares for retrospective detection of changes of variance", J. Am. Stat. Assoc. 89
(1994), :doi:`10.1080/01621459.1994.10476824`.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from sigmatau._native import kernels
from sigmatau._native.distributions import gamma_above
from sigmatau._native.gls import Components
from sigmatau.arrays import Floats, Ints
from sigmatau.findings.drift import NoiseChange, NonStationary, SegmentSpread
from sigmatau.findings.finding import Finding, Severity, Span
from sigmatau.fitting.components import linear_powers
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.frozen import frozen
from sigmatau.record.streams import Grid, Stream

# Segments of the record. [1] Study: docs/study/stability.md.
_SEGMENTS = 8
# Smallest number of segments without missing samples. [1] Judgement: half of the segments.
_MIN_SEGMENTS = 4
# Samples in the shortest segment, and the smallest number of blocks of the cusum. [samples] Judgement: an Allan
# variance at one sample then has 40 degrees of freedom.
_MIN_SAMPLES = 64
# Smallest number of degrees of freedom of a variance in a segment. [1] Derived: its cube root is then nearly normal
# (Wilson and Hilferty).
_MIN_FREEDOM = 10.0
# Probability of a false alarm of each of the two tests, for one channel. [1] Study: docs/study/stability.md.
_FALSE_ALARM = 2e-4
# Smallest ratio of deviations that is reported. [1] Judgement: a long record can show 0.3 %, which is insignificant in
# practice.
_MIN_RATIO = 1.05
# Smallest ratio of deviations that is a warning. [1] Judgement: three times the usual interval.
_WARNING_RATIO = 1.15
# Relative misfit of the variance beyond which the law of the fitted model is not used. [1] Judgement: the covariance
# of the test is then wrong by half.
_MAX_MISFIT = 0.25
# Largest number of blocks of the cusum. [1] Judgement: the time of a change then has an error of a thousandth of the record.
_CUSUM_BLOCKS = 1024
# Smallest number of samples in a block. [samples] Judgement: neighbouring blocks are then nearly independent.
_MIN_IN_BLOCK = 8


@frozen(eq=False)
class SegmentTest:
    """Allan variances of segments, and the test of whether they are equal."""

    m: Ints  # cluster sizes tested
    starts: Ints  # first sample of each segment
    avar: Floats  # Allan variance of each segment at each cluster size [unit²]
    p_value: float  # p-value of the scatter in stationary noise
    evidence: Floats  # χ² of each octave
    p_values: Floats  # p-value of each octave


def non_stationary(stream: Stream, fits: Mapping[str, NoiseFit]) -> list[Finding]:
    """Channels whose noise changes during the record: at most one ``"non_stationary"`` for each.

    The span is the segment with the largest deviation, or the time of the change if the cusum found it.

    Parameters
    ----------
    stream : Stream
        Segments with missing samples are left out.
    fits : mapping of str to NoiseFit
        They determine the distribution of the variances of segments. A channel without a fit is tested by the cusum only.
    """
    findings = []
    for channel in stream.channels:
        x, fitted = stream.column(channel), fits.get(channel)
        spread = None if fitted is None else _segment_spread(x, fitted, stream.grid)
        ratio = 1.0 if spread is None else spread.ratio
        spans: tuple[Span, ...] = () if spread is None else ((spread.largest_at, spread.largest_at + spread.length),)
        change = _noise_change(x, stream.grid)
        if change is not None:
            size = max(change.ratio, 1 / change.ratio) if change.ratio > 0 else np.inf
            if spread is not None and size < _MIN_RATIO:
                change = None
            else:
                ratio, spans = max(ratio, size), ((change.time, change.time),)
        if _MIN_RATIO <= ratio < np.inf and (spread is not None or change is not None):
            details = NonStationary(segments=spread, change=change)
            severity: Severity = "warning" if ratio >= _WARNING_RATIO else "info"
            findings.append(Finding(details=details, severity=severity, channels=(channel,), spans=spans, size=ratio))
    return findings


def _segment_spread(x: Floats, fitted: NoiseFit, grid: Grid) -> SegmentSpread | None:
    """Significant difference between segments, at the averaging time with the strongest evidence (not the largest ratio)."""
    tested = segment_test(x, fitted)
    if tested is None or not tested.p_value < _FALSE_ALARM:
        return None
    tau0 = fitted.tau0
    k = int(np.argmax(tested.evidence))
    deviation = np.sqrt(tested.avar[:, k])
    tau = float(tested.m[k]) * tau0
    significant = tested.m[tested.p_values < _FALSE_ALARM / len(tested.m)] * tau0
    return SegmentSpread(
        ratio=float(deviation.max() / deviation.min()),
        tau=tau,
        tau_min=float(significant[0]) if len(significant) else tau,
        tau_max=float(significant[-1]) if len(significant) else tau,
        largest_at=grid.time(int(tested.starts[np.argmax(deviation)])),
        smallest_at=grid.time(int(tested.starts[np.argmin(deviation)])),
        length=len(x) // _SEGMENTS * tau0,
    )


def _noise_change(x: Floats, grid: Grid) -> NoiseChange | None:
    largest = cusum(x)
    if largest is None or not largest.p_value < _FALSE_ALARM:
        return None
    return NoiseChange(time=grid.time(largest.sample), ratio=float(np.sqrt(largest.ratio)))


def segment_test(x: Floats, fitted: NoiseFit) -> SegmentTest | None:
    """χ² test of the Allan variances of eight segments; None without a model or with too few complete segments."""
    size = len(x) // _SEGMENTS
    if size < _MIN_SAMPLES or not fitted.model:
        return None
    starts = np.arange(_SEGMENTS) * size
    starts = np.array([s for s in starts if np.isfinite(np.add.reduce(x[s : s + size]))], dtype=np.int64)
    if len(starts) < _MIN_SEGMENTS:
        return None
    sizes = 2 ** np.arange(0, int(np.log2(size // 4)) + 1, dtype=np.int64)
    # Below τ_min the model does not hold: filtered noise has fewer degrees of freedom than white noise.
    sizes = sizes[sizes * fitted.tau0 >= (fitted.tau_min or 0.0) * (1 - 1e-9)]
    law = _law(fitted, size, sizes)
    if law is None:
        return None
    freedom, correlation = law
    names = [fitted.channel] * len(starts)
    avar = np.stack(
        kernels.allan_variances(
            [x[s : s + size] for s in starts], sizes, overlap="full", counting="standard", threads=None, names=names
        )[0]
    )
    mean = avar.mean(axis=0)
    followed = np.abs(fitted.avar(m=sizes) / np.maximum(mean, 1e-300) - 1) < _MAX_MISFIT + 3 * np.sqrt(
        2 / freedom / len(starts)
    )
    use = (freedom >= _MIN_FREEDOM) & followed & (avar.min(axis=0) > 0)
    if not use.any():
        return None
    roots = np.cbrt(avar[:, use])
    # In a stationary record the mean of the cube roots is 1 − 2/(9ν) of the cube root of the mean, in all segments.
    spread = np.sqrt(2 / (9 * freedom[use])) * roots.mean(axis=0) / (1 - 2 / (9 * freedom[use]))
    z = (roots - roots.mean(axis=0)) / spread
    try:
        factor = np.linalg.cholesky(correlation[np.ix_(use, use)])
    except np.linalg.LinAlgError:
        return None
    whitened = np.linalg.solve(factor, z.T)
    count = (len(starts) - 1) * int(use.sum())
    evidence = np.sum(z**2, axis=0)
    p_values = np.asarray(gamma_above((len(starts) - 1) / 2, evidence / 2))
    together = float(gamma_above(count / 2, float(np.sum(whitened**2)) / 2))
    # The sum over all octaves is insensitive to a change at few averaging times, and a single octave to a small change
    # at all of them. Therefore both are tested, and the smaller p-value is doubled (Bonferroni).
    return SegmentTest(
        m=sizes[use],
        starts=starts,
        avar=avar[:, use],
        p_value=min(2 * min(together, float(p_values.min()) * len(p_values)), 1.0),
        evidence=evidence,
        p_values=p_values,
    )


def _law(fitted: NoiseFit, size: int, sizes: Ints) -> tuple[Floats, Floats] | None:
    """Degrees of freedom of each variance in a segment, and the correlation of the variances."""
    if len(sizes) == 0:
        return None
    line = fitted.sinusoid[0] if fitted.sinusoid else None
    process = fitted.gauss_markov[0] if fitted.gauss_markov else None
    theta = linear_powers(fitted.model, fitted.tau0)
    if line is not None:
        theta.append(line.amplitude.value**2)
    elif process is not None:
        theta.append(process.sigma.value**2)
    parts = Components(
        size,
        sizes.tolist(),
        correlation_time=None if process is None else process.time.value / fitted.tau0,
        frequency=None if line is None else line.frequency.value * fitted.tau0,
    )
    values = np.array(theta)
    if not values.any():
        return None
    covariance = parts.covariance(values)
    ramp = fitted.model.get("rate_ramp", 0.0) * fitted.tau0
    squares = parts.m.astype(float) ** 2
    covariance = covariance + (ramp**2) * np.outer(squares, squares) * np.einsum("p,pij->ij", values, parts.slopes)
    expected = parts.design @ values + 0.5 * ramp**2 * squares
    variance = np.diag(covariance)
    if not variance.min() > 0:
        return None
    errors = np.sqrt(variance)
    return 2 * expected**2 / variance, covariance / np.outer(errors, errors)


@frozen
class Cusum:
    """Largest distance of the running sum from a straight line."""

    sample: int  # sample at the largest distance
    p_value: float  # p-value by Kolmogorov's law
    ratio: float  # mean square after the change over that before it


def cusum(x: Floats) -> Cusum | None:
    """Cusum of squared first differences over blocks; None if the record is too short.

    The scatter is measured between neighbouring blocks, so that neither correlated samples nor the change affect it.
    """
    length = max(-(-len(x) // _CUSUM_BLOCKS), _MIN_IN_BLOCK)
    count = len(x) // length
    if count < _MIN_SAMPLES:
        return None
    d = np.diff(x[: count * length].reshape(count, length), axis=1)
    squares = np.einsum("ij,ij->i", d, d)
    bad = np.flatnonzero(np.isnan(squares))
    number = np.full(count, length - 1)
    if len(bad):
        is_present = ~np.isnan(d[bad])
        number[bad] = is_present.sum(axis=1)
        squares[bad] = np.where(is_present, d[bad] ** 2, 0.0).sum(axis=1)
    keep = np.flatnonzero(2 * number > length)
    if len(keep) < _MIN_SAMPLES:
        return None
    # Cube roots are nearly normal, so that single blocks do not dominate.
    level = np.cbrt(squares[keep] / number[keep])
    scatter = float(np.sqrt(np.mean(np.diff(level) ** 2) / 2))
    if not scatter > 0:
        return None
    distance = np.cumsum(level - level.mean())
    k = int(np.argmax(np.abs(distance[:-1])))
    largest = abs(float(distance[k])) / (scatter * np.sqrt(len(level)))
    before, after = (squares[blocks].sum() / number[blocks].sum() for blocks in (keep[: k + 1], keep[k + 1 :]))
    return Cusum(
        sample=int((keep[k] + 1) * length),
        p_value=min(2 * float(np.exp(-2 * largest**2)), 1.0),
        ratio=float(after / before) if before > 0 else 1.0,
    )
