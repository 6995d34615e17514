"""Whether the noise stays the same over the record.

Two tests. Segments: the Allan variance of each of eight segments at octaves of τ, held against that of the others with
the covariance that the fitted noise has in a segment. An Allan variance is skewed, like χ² over its degrees of freedom ν;
its cube root is not (Wilson & Hilferty): it is nearly normal with variance 2/(9ν) of its mean squared. So the statistic is
a sum of squares of whitened cube roots, χ² with 7 degrees of freedom an octave, or that of the worst octave alone; the size
is measured in docs/study/stability.md. Cusum: the running sum of the size of first differences against a straight line,
whose largest distance has Kolmogorov's law; it says when the noise changed.

References
----------
E. B. Wilson, M. M. Hilferty, "The distribution of chi-square", PNAS 17 (1931), :doi:`10.1073/pnas.17.12.684`; C. Inclán,
G. C. Tiao, "Use of cumulative sums of squares for retrospective detection of changes of variance", J. Am. Stat. Assoc. 89
(1994), :doi:`10.1080/01621459.1994.10476824`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sigmatau._native import kernels
from sigmatau.findings.finding import Finding
from sigmatau.fitting.components import LINEAR, components, power_of_interval
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.record.streams import Stream
from sigmatau.results import duration_text, seconds

__all__ = ["SegmentTest", "cusum", "non_stationary", "segment_test"]

Floats = NDArray[np.float64]

SEGMENTS = 8
_LEAST_SEGMENTS = 4
_LEAST_FREEDOM = 10.0
_LEAST_SAMPLES = 64  # in a segment

_FALSE_ALARM = 2e-4
"""Of each of the two tests, for a channel."""

_LEAST = 1.05
"""A smaller ratio of deviations is of no consequence, however sure: a long record shows 0.3 %."""

_MATTERS = 1.15
_FOLLOWED = 0.25
"""A model further than this from the curve, as a share of the variance, gives no law for an octave."""

_CUSUM_BLOCKS = 1024
_LEAST_IN_BLOCK = 8


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class SegmentTest:
    """Allan variances of segments, and whether they are one.

    Attributes
    ----------
    m : ndarray of int, shape (n_tau,)
        Cluster sizes tested.
    starts : ndarray of int, shape (n_segments,)
        First sample of each segment.
    avar : ndarray, shape (n_segments, n_tau)
        [unit²]
    p_value : float
        Probability of as large a scatter in stationary noise.
    evidence : ndarray, shape (n_tau,)
        χ² of each octave by itself.
    p_values : ndarray, shape (n_tau,)
        Of the same.
    """

    m: NDArray[np.int64]
    starts: NDArray[np.int64]
    avar: Floats
    p_value: float
    evidence: Floats
    p_values: Floats


def non_stationary(stream: Stream, fits: Mapping[str, NoiseFit]) -> list[Finding]:
    """Whether the noise of each channel is the same all through the record.

    Parameters
    ----------
    stream : Stream
        Missing samples are NaN; segments that miss one are left out.
    fits : mapping of str to NoiseFit
        Gives the law of the segments' variances. A channel without a fit is tested by the cusum alone.

    Returns
    -------
    list of Finding
        ``"non_stationary"``, at most one a channel: a warning if deviations of segments differ by more than 15 %.
    """
    findings = []
    for channel in stream.channels:
        x = stream.column(channel)
        fitted = fits.get(channel)
        tested = None if fitted is None else segment_test(x, fitted)
        finding = _finding(stream, channel, tested, cusum(x))
        if finding is not None:
            findings.append(finding)
    return findings


def segment_test(x: Floats, fitted: NoiseFit) -> SegmentTest | None:
    """χ² of the Allan variances of eight segments; None if there is no law for them or too few segments are whole.

    Parameters
    ----------
    x : ndarray, shape (n,)
        Rates, NaN where missing.
    fitted : NoiseFit
        Of the whole record.
    """
    size = len(x) // SEGMENTS
    if size < _LEAST_SAMPLES or not fitted.model:
        return None
    starts = np.arange(SEGMENTS) * size
    starts = np.array([s for s in starts if np.isfinite(np.add.reduce(x[s : s + size]))], dtype=np.int64)
    if len(starts) < _LEAST_SEGMENTS:
        return None
    sizes = 2 ** np.arange(0, int(np.log2(size // 4)) + 1, dtype=np.int64)
    # Below τ_min the model does not hold: a filter makes fewer degrees of freedom than white noise.
    sizes = sizes[sizes * fitted.tau0 >= (fitted.tau_min or 0.0) * (1 - 1e-9)]
    law = _law(fitted, size, sizes)
    if law is None:
        return None
    freedom, correlation = law
    avar = np.stack(
        [
            kernels.allan_variances(
                [x[s : s + size]], sizes, overlap="full", counting="standard", threads=1, names=[fitted.channel]
            )[0][0]
            for s in starts
        ]
    )
    mean = avar.mean(axis=0)
    followed = np.abs(fitted.avar(m=sizes) / np.maximum(mean, 1e-300) - 1) < _FOLLOWED + 3 * np.sqrt(
        2 / freedom / len(starts)
    )
    use = (freedom >= _LEAST_FREEDOM) & followed & (avar.min(axis=0) > 0)
    if not use.any():
        return None
    roots = np.cbrt(avar[:, use])
    # The mean of the cube roots is that of a stationary record but for 2/(9ν) of it, which all segments share.
    spread = np.sqrt(2 / (9 * freedom[use])) * roots.mean(axis=0) / (1 - 2 / (9 * freedom[use]))
    z = (roots - roots.mean(axis=0)) / spread
    from scipy.special import gammaincc

    try:
        factor = np.linalg.cholesky(correlation[np.ix_(use, use)])
    except np.linalg.LinAlgError:
        return None
    whitened = np.linalg.solve(factor, z.T)
    count = (len(starts) - 1) * int(use.sum())
    evidence = np.sum(z**2, axis=0)
    p_values = np.asarray(gammaincc((len(starts) - 1) / 2, evidence / 2))
    together = float(gammaincc(count / 2, float(np.sum(whitened**2)) / 2))
    # A change at few averaging times is lost in the sum over all, a small one at all of them in each: both have half the
    # chance.
    return SegmentTest(
        m=sizes[use],
        starts=starts,
        avar=avar[:, use],
        p_value=min(2 * min(together, float(p_values.min()) * len(p_values)), 1.0),
        evidence=evidence,
        p_values=p_values,
    )


def _law(fitted: NoiseFit, size: int, sizes: NDArray[np.int64]) -> tuple[Floats, Floats] | None:
    """Degrees of freedom of each variance in a segment, and their correlation."""
    if len(sizes) == 0:
        return None
    line = fitted.sinusoid[0] if fitted.sinusoid else None
    process = fitted.gauss_markov[0] if fitted.gauss_markov else None
    theta = {name: fitted.model.get(name, 0.0) ** 2 * fitted.tau0 ** (power_of_interval(name) - 2) for name in LINEAR}
    if process is not None:
        theta["gauss_markov"] = process.sigma.value**2
    if line is not None:
        theta["sinusoid"] = line.amplitude.value**2
    parts = components(
        size,
        tuple(int(m) for m in sizes),
        correlation_time=None if process is None else process.time.value / fitted.tau0,
        frequency=None if line is None else line.frequency.value * fitted.tau0,
    )
    values = np.array([theta[name] for name in parts.names])
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
    return 2 * expected**2 / variance, covariance / np.sqrt(np.outer(variance, variance))


@dataclass(frozen=True, slots=True, kw_only=True)
class Cusum:
    """The largest distance of the running sum of squares from a straight line.

    Attributes
    ----------
    at : int
        Sample of the largest distance.
    p_value : float
        By Kolmogorov's law.
    ratio : float
        Mean square after over that before.
    """

    at: int
    p_value: float
    ratio: float


def cusum(x: Floats) -> Cusum | None:
    """Cusum of squared first differences over blocks; None if the record is too short.

    The scatter of the blocks is taken from neighbours, so that correlated samples do not matter as long as blocks are
    independent, nor does a change.
    """
    length = max(-(-len(x) // _CUSUM_BLOCKS), _LEAST_IN_BLOCK)
    count = len(x) // length
    if count < _LEAST_SAMPLES:
        return None
    d = np.diff(x[: count * length].reshape(count, length), axis=1)
    squares = np.einsum("ij,ij->i", d, d)
    bad = np.flatnonzero(np.isnan(squares))
    number = np.full(count, length - 1)
    if len(bad):
        there = ~np.isnan(d[bad])
        number[bad] = there.sum(axis=1)
        squares[bad] = np.where(there, d[bad] ** 2, 0.0).sum(axis=1)
    keep = np.flatnonzero(2 * number > length)
    if len(keep) < _LEAST_SAMPLES:
        return None
    # Cube roots: normal, so that no block rules.
    level = np.cbrt(squares[keep] / number[keep])
    scatter = float(np.sqrt(np.mean(np.diff(level) ** 2) / 2))
    if not scatter > 0:
        return None
    distance = np.cumsum(level - level.mean())
    k = int(np.argmax(np.abs(distance[:-1])))
    largest = abs(float(distance[k])) / (scatter * np.sqrt(len(level)))
    power = squares[keep]
    before, after = (
        power[: k + 1].sum() / number[keep][: k + 1].sum(),
        power[k + 1 :].sum() / number[keep][k + 1 :].sum(),
    )
    return Cusum(
        at=int((keep[k] + 1) * length),
        p_value=min(2 * float(np.exp(-2 * largest**2)), 1.0),
        ratio=float(after / before) if before > 0 else 1.0,
    )


def _finding(stream: Stream, channel: str, tested: SegmentTest | None, change: Cusum | None) -> Finding | None:
    tau0 = stream.grid.tau0
    texts, ratios, where = [], [1.0], ""
    if tested is not None and tested.p_value < _FALSE_ALARM:
        # Where the evidence is strongest: long times have few degrees of freedom, and a large span by chance.
        k = int(np.argmax(tested.evidence))
        deviation = np.sqrt(tested.avar[:, k])
        ratios.append(float(deviation.max() / deviation.min()))
        beyond = tested.m[tested.p_values < _FALSE_ALARM / len(tested.m)] * tau0
        tau = seconds(float(tested.m[k]) * tau0)
        times = f"τ = {tau} s"
        if len(beyond) > 1:
            times += f" (beyond chance from τ = {seconds(beyond[0])} s to {seconds(beyond[-1])} s)"
        high = seconds(int(tested.starts[np.argmax(deviation)]) * tau0)
        low = seconds(int(tested.starts[np.argmin(deviation)]) * tau0)
        texts.append(
            f"the deviations of eight segments differ by {ratios[-1]:.2f} times at {times}: largest in the"
            f" {duration_text(stream.grid.n // SEGMENTS * tau0)} from t = {high} s on, smallest in those from t = {low} s on"
        )
        where = f"t = {high} s"
    if change is not None and change.p_value < _FALSE_ALARM:
        ratio = float(np.sqrt(change.ratio))
        size_of = max(ratio, 1 / ratio) if ratio > 0 else np.inf
        if size_of >= _LEAST or not texts:
            ratios.append(size_of)
            texts.append(
                f"short-time noise changes by {ratio:.3g} times at about t = {seconds(change.at * tau0)} s"
                " (squared first differences)"
            )
            where = f"t = {seconds(change.at * tau0)} s"
    largest = max(ratios)
    if not texts or largest < _LEAST or not np.isfinite(largest):
        return None
    return Finding(
        code="non_stationary",
        severity="warning" if largest >= _MATTERS else "info",
        channel=channel,
        message="; ".join(texts),
        where=where,
        size=largest,
        effect="coefficients are means over the record (of squares), and their intervals too short",
        remedy="look what changed then (--stability MAP.png shows it), and analyse a part that is even with --window",
    )
