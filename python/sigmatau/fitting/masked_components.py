"""Components of a record with missing samples.

The expected variances are exact for the mask (`sigmatau.estimators.gaps`). Their exact covariance would be a sum over all
pairs of pairs of clusters. Instead, each process has the correlations that it has without gaps, and at each averaging time
the size of its expected variance. Quantization noise is treated as two processes: one telescopes, the other is white and
comes from the missing samples. For short clusters, fewer pairs increase the covariance like a shorter record. For long
clusters, a gap changes the set of pairs from one size to the next; their covariance is computed from the sums of a few
hundred blocks of samples, which represent the gaps (`sigmatau._native.kernels.masked_covariance`). Each matrix is the
covariance of a possible process, so that their sum is positive definite for every mask.

White noise where a large share of the samples is missing: if only half of all clusters are used, the set of pairs changes
within a fraction of a cluster, and differs from one cluster size to the next: neighbouring pairs, and variances at
neighbouring sizes, are less correlated than in a complete record. The Allan variance is a quadratic form ½ Σ Q(j, j′) y(j)
y(j′), with Q the mean of a(j) a(j′) over the pairs and a the weights ∓1/m of a pair on its samples. For white noise of
variance 1 the covariance of two variances is ½ Σ Q(j, j′) Q′(j, j′). The sum is evaluated at a few thousand samples j and at
distances that widen geometrically: it stays a sum of squares, and hence a covariance.
"""

from __future__ import annotations

import functools
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sigmatau._native import kernels
from sigmatau.estimators.gaps import Gaps
from sigmatau.fitting.components import LINEAR, Components, components, pairs_of_terms, with_sinusoid

Floats = NDArray[np.float64]

_BLOCKS = 256  # Smallest number of blocks of a record; the number is less than twice that
_LEAST_BLOCKS = 8  # Smallest number of blocks of a cluster for the blocks to resolve its beginning
_RIDGE = 1e-9  # added to a matrix, relative to its diagonal
_QUANTIZATION, _WHITE = LINEAR.index("quantization"), LINEAR.index("random_walk")


@functools.lru_cache(maxsize=32)
def components_with_gaps(
    n: int,
    m: tuple[int, ...],
    gaps: Gaps | None,
    *,
    correlation_time: float | None = None,
    frequency: float | None = None,
) -> Components:
    """The components of a record, see `sigmatau.fitting.components.components`, which has those without gaps. Every
    cluster size must have a pair. The component of a sinusoid ignores gaps.
    """
    if gaps is None:
        return components(n, m, correlation_time=correlation_time, frequency=frequency)
    if frequency is not None:
        return with_sinusoid(components_with_gaps(n, m, gaps), frequency)
    return _with_gaps(components(n, m, correlation_time=correlation_time), gaps, correlation_time)


def _with_gaps(full: Components, gaps: Gaps, correlation_time: float | None) -> Components:
    """The components with gaps from those of a complete record. `full`: without a ramp removed, and without a sinusoid;
    `correlation_time`: of the Gauss-Markov process [samples].
    """
    e = gaps.expected(full.m)
    sizes = full.m.astype(float)
    scales = e.avar / full.design[:, : len(LINEAR)]
    design = e.avar
    if correlation_time is not None:
        ratio = gaps.gauss_markov_ratio(correlation_time, full.m)
        scales = np.column_stack([scales, ratio])
        design = np.column_stack([design, ratio * full.design[:, -1]])
    # By term, the processes of its model, and their sizes over those without gaps.
    left_white = np.maximum(e.avar[:, _QUANTIZATION] - e.telescoping * full.design[:, _QUANTIZATION], 0) * sizes
    terms = range(len(full.names))
    made_of = [[(p, scales[:, p])] for p in terms]
    made_of[_QUANTIZATION] = [(_QUANTIZATION, e.telescoping), (_WHITE, left_white)]
    roots = [[(p, np.sqrt(np.outer(s, s))) for p, s in parts] for parts in made_of]
    tensors, slopes = _of_processes(full, gaps, e.n_pairs, correlation_time)
    noise = [
        (1 if p == q else 2) * sum(rp * rq * tensors[min(a, b), max(a, b)] for a, rp in roots[p] for b, rq in roots[q])
        for p, q in pairs_of_terms(len(full.names))
    ]
    nearer = sizes / np.sqrt(e.square_distance)
    slopes = [np.outer(nearer, nearer) * sum(root * slopes[a] for a, root in roots[p]) for p in terms]
    # Without gaps the mean difference is that of the two ends of the record. Missing samples change it: at short times by
    # as much as for white noise; at long times the blocks include it.
    short = _first_long(full)
    more = np.zeros(len(sizes))
    more[:short] = np.maximum(gaps.white_slopes(full.m[:short]) - np.diag(slopes[_WHITE])[:short], 0)
    for p in terms:
        slopes[p] = slopes[p] + np.diag(more * design[:, p] / design[:, _WHITE])
    return replace(
        full,
        design=design,
        noise=np.array(noise),
        slopes=np.array(slopes),
        squares=e.square_distance,
        gaps=gaps,
        powers=np.array([full.gains * sum(s[:, None] * full.spectra[a] for a, s in made_of[p]) for p in terms]),
    )


def _of_processes(
    full: Components, gaps: Gaps, n_pairs: NDArray[np.int64], correlation_time: float | None
) -> tuple[dict[tuple[int, int], Floats], list[Floats]]:
    """Γ of pairs of processes with the sizes of a complete record, and the covariances of the ramps."""
    shorter = np.sqrt((full.n + 1 - 2 * full.m) / n_pairs)
    fewer = np.outer(shorter, shorter)
    alike = _of_white(full, gaps, fewer) if gaps.missing > HEAVY_LOSS * full.n else fewer
    tensors = {
        (p, q): alike * full.noise[k] * (1.0 if p == q else 0.5)
        for k, (p, q) in enumerate(pairs_of_terms(len(full.names)))
    }
    slopes = [fewer * slope for slope in full.slopes]
    first = _first_long(full)
    if first == len(full.m):
        return tensors, slopes
    times = () if correlation_time is None else (correlation_time,)
    avar, noise, ramps = kernels.masked_covariance(
        gaps.there, full.m[first:], block=_block(full.n), correlation_times=times
    )
    # In units of the variance of a complete record.
    size = [np.sqrt(full.design[first:, p + 1] / avar[p]) for p in range(len(avar))]
    scale = [np.outer(s, s) for s in size]
    for (a, b), found in zip(pairs_of_terms(len(avar)), noise, strict=True):
        tensors[a + 1, b + 1] = _joined(tensors[a + 1, b + 1], scale[a] * scale[b] * found)
    near = np.sqrt(gaps.expected(full.m[first:]).square_distance) / full.m[first:]
    for a, found in enumerate(ramps):
        slopes[a + 1] = _joined(slopes[a + 1], scale[a] * np.outer(near, near) * found)
    return tensors, slopes


def _of_white(full: Components, gaps: Gaps, fewer: Floats) -> Floats:
    """Covariances over those of a complete record after a heavy loss: at short times those of white noise. The sizes of
    the variances are applied elsewhere.
    """
    short = _first_long(full)
    whole = pairs_of_terms(len(full.names)).index((_WHITE, _WHITE))
    scale = gaps.expected(full.m[:short]).avar[:, _WHITE] / full.design[:short, _WHITE]
    exact = white_covariance(gaps.there, full.m[:short])
    alike = fewer.copy()
    alike[:short, :short] = exact / (full.noise[whole, :short, :short] * np.outer(scale, scale))
    root = np.sqrt(np.diag(alike)[:short] / np.diag(fewer)[:short])
    alike[:short, short:] *= root[:, None]
    alike[short:, :short] *= root
    return alike


def _block(n: int) -> int:
    """Samples of a block of a record of n samples."""
    return 1 << max((n // _BLOCKS).bit_length() - 1, 0)


def _first_long(full: Components) -> int:
    """Index of the first cluster size that the blocks resolve."""
    return int(np.searchsorted(full.m, _LEAST_BLOCKS * _block(full.n)))


def _joined(whole: Floats, long: Floats) -> Floats:
    """A covariance whose last rows and columns are replaced, with their covariance with the others adapted. The last
    variables become linear functions of what they were, so that the result is a covariance again.
    """
    first = len(whole) - len(long)
    if first == 0:
        return long
    before, now = whole[first:, first:], long
    try:
        factors = [np.linalg.cholesky(matrix + _RIDGE * np.diag(np.diag(matrix))) for matrix in (before, now)]
        shared = np.linalg.solve(factors[0], whole[first:, :first])
        cross = factors[1] @ shared
    except np.linalg.LinAlgError:
        cross = np.sqrt(np.diag(now) / np.diag(before))[:, None] * whole[first:, :first]
    return np.block([[whole[:first, :first], cross.T], [cross, now]])


HEAVY_LOSS = 0.25  # Share of missing samples; below it, gaps change the covariance only by the number of pairs
_SAMPLES = 6000  # rows of the sum, about
_ALL_DISTANCES = 24  # up to here, every distance is used [samples]
_PER_OCTAVE = 12  # ranges of longer distances


def white_covariance(there: NDArray[np.bool_], m: NDArray[np.int64]) -> Floats:
    """Covariance of the Allan variances of white noise of variance 1, for the pairs of clusters at least half full.
    `m`: cluster sizes, each with a pair; the result is positive semidefinite; good to about 3 %.
    """
    n = len(there)
    edges = _edges(min(2 * int(m.max()), n))
    width = np.diff(edges)
    # An odd step samples every phase of a periodic mask.
    step = max(n // _SAMPLES, 1) | 1
    rows = np.arange(0, n, step)
    rows = rows[there[rows]]
    # Each row takes another distance from every range, so that all distances are sampled.
    within = (np.arange(len(rows))[:, None] * 0.6180339887498949 + np.arange(len(width)) * 0.41421356) % 1
    far = edges[:-1] + np.floor(within * width).astype(np.int64)
    second = rows[:, None] + far
    use = second < n
    use[use] = there[second[use]]
    weight = np.broadcast_to(np.sqrt(np.where(edges[:-1] == 0, 1.0, 2.0) * width * step), use.shape)[use]
    first, second = np.broadcast_to(rows[:, None], use.shape)[use], second[use]
    forms = np.stack([weight * _form(there, int(size), first, second) for size in m])
    return np.asarray(0.5 * np.einsum("ik,jk->ij", forms, forms, optimize=True))


def _edges(longest: int) -> NDArray[np.int64]:
    """Beginnings of ranges of distances, and the end of the last."""
    octaves = np.log2(max(longest / _ALL_DISTANCES, 1))
    wider = _ALL_DISTANCES * 2 ** (np.arange(1, int(np.ceil(octaves * _PER_OCTAVE)) + 1) / _PER_OCTAVE)
    return np.unique(np.concatenate([np.arange(_ALL_DISTANCES + 1), np.round(wider)])).astype(np.int64)


def _form(there: NDArray[np.bool_], m: int, i: NDArray[np.int64], j: NDArray[np.int64]) -> Floats:
    """Mean over the pairs of the product of their weights on samples i ≤ j, which are not missing."""
    counts = np.concatenate([[0], np.cumsum(there)])
    in_cluster = counts[m:] - counts[:-m]
    full = 2 * in_cluster >= m
    reciprocal = np.where(full, 1.0 / np.maximum(in_cluster, 1), 0.0)
    r1, r2 = reciprocal[:-m], reciprocal[m:]
    pairs = np.count_nonzero(full[:-m] & full[m:])
    last = len(r1)

    def total(values: Floats, low: NDArray[np.int64], high: NDArray[np.int64]) -> Floats:
        """Sum over the starts from low up to before high."""
        sums = np.concatenate([[0.0], np.cumsum(values)])
        high = np.clip(high, 0, last)
        return np.asarray(sums[high] - sums[np.clip(low, 0, high)])

    both = np.where(r2 > 0, r1 * r1, 0.0)
    found = total(both, j - m + 1, i + 1)
    both = np.where(r1 > 0, r2 * r2, 0.0)
    found += total(both, j - 2 * m + 1, i - m + 1)
    # Sample i in the first cluster, sample j in the second.
    found -= total(r1 * r2, np.maximum(i - m, j - 2 * m) + 1, np.minimum(i, j - m) + 1)
    return found / pairs
