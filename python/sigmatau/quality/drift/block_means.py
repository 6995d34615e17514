"""Block means of a channel, their covariance for each noise term, and regression on them with the noise estimated too.

Differences of neighbouring block means are stationary for every term. Their covariance at lag l is the fourth difference of
the phase autocovariance s at strides of a block. The discrete sine transform makes them independent: exactly for a random
walk and a rate random walk, whose covariances are tridiagonal, and nearly so for flicker noise and quantization. A
regression then has one weight for each mode. The squared coefficients, which determine the weights, are estimated together
with the regression by restricted maximum likelihood (REML): a drift among the regressors does not increase the estimated
noise, and a rate random walk that looks like a drift does.

References
----------
H. D. Patterson, R. Thompson, "Recovery of inter-block information when block sizes are unequal", Biometrika 58 (1971),
:doi:`10.1093/biomet/58.3.545`; for the degrees of freedom F. E. Satterthwaite, Biometrics Bulletin 2 (1946),
:doi:`10.2307/3002019`.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sigmatau.arrays import Bools, Floats
from sigmatau.fitting.components import LINEAR
from sigmatau.fitting.gls import non_negative
from sigmatau.quality.samples.common import row_means
from sigmatau.record.streams import Stream

__all__ = ["BlockMeans", "Regression", "autocovariance", "block_means", "regress"]

BLOCKS = 512  # blocks in a record: a time constant of 1 % of the record spans five of them
_LEAST_SHARE = 0.5  # smallest share of its samples that a block must have for its mean to be used

_MOST_EMPTY = 0.25
"""Largest share of empty blocks, each of which is an unknown; with more, only the longest stretch is used."""

_LEAST_BLOCKS = 64
_STEPS = 15  # of the REML iteration, at most
_TOLERANCE = 1e-3  # relative change of the mode variances at which it ends


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class BlockMeans:
    """Means of equal blocks of one channel."""

    means: Floats  # NaN if too many samples of the block are missing [unit]
    length: int  # samples in a block
    first: int  # index of the first sample of the first block
    tau0: float  # sample interval [s]

    @property
    def step(self) -> float:
        """Length of a block. [s]"""
        return self.length * self.tau0

    @property
    def edges(self) -> Floats:
        """Edges of the blocks, from the first sample of the stream; shape (n_blocks + 1,). [s]"""
        return np.asarray((self.first + np.arange(len(self.means) + 1) * self.length) * self.tau0, dtype=np.float64)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Regression:
    """Estimate of one coefficient beside a level and a ramp."""

    value: float  # the coefficient and its standard error
    error: float
    freedom: float  # degrees of freedom of the squared standard error
    p_value: float  # Two-sided p-value by Student's t
    theta: Floats  # squared coefficients of the noise, per sample; order of `sigmatau.fitting.components.LINEAR`

    def half_width(self, *, level: float = 0.95) -> float:
        """Half the width of the confidence interval of the coefficient."""
        from scipy.special import stdtrit

        return float(stdtrit(self.freedom, 0.5 + level / 2)) * self.error


def block_means(
    stream: Stream, channel: str, *, blocks: int = BLOCKS, length: int | None = None, gaps: bool = False
) -> BlockMeans | None:
    """Means of a channel over at most `blocks` blocks, or over blocks of `length` samples; NaN if half of one is missing.

    If more than a quarter of the blocks has no mean, only the longest stretch of the others is kept. None if fewer than 64
    blocks are left. With `gaps` all blocks are kept, however few they are.
    """
    n = stream.grid.n
    length = -(-n // blocks) if length is None else length
    count = n // length
    if count < (1 if gaps else _LEAST_BLOCKS):
        return None
    means = row_means(stream.column(channel)[: count * length].reshape(count, length), least=_LEAST_SHARE)
    first = 0
    empty = np.isnan(means)
    if not gaps and empty.mean() > _MOST_EMPTY:
        edges = np.concatenate([[-1], np.flatnonzero(empty), [count]])
        k = int(np.argmax(np.diff(edges)))
        first, last = int(edges[k]) + 1, int(edges[k + 1])
        means = means[first:last]
        if len(means) < _LEAST_BLOCKS:
            return None
    return BlockMeans(means=means, length=length, first=first * length, tau0=stream.grid.tau0)


def autocovariance(term: str, lags: int, length: int) -> Floats:
    """Covariance of differences of neighbouring block means at lags 0 … `lags` − 1, for a squared coefficient of 1.

    The fourth difference, at strides of a block of `length` samples, of the phase autocovariance s(l) of the term (one of
    `sigmatau.fitting.components.LINEAR`), over length²; the sample interval is 1. Shape (lags,).
    """
    known = {
        "quantization": [6.0, -4.0, 1.0],
        "random_walk": [2.0 * length, -1.0 * length],
        # (|l|³ − |l|)/12 at strides of a block.
        "rate_random_walk": [(4 * length**3 + 2 * length) / 6, (length**3 - length) / 6],
    }.get(term)
    if known is None:
        return _flicker(lags, length)
    return np.array([*known, *[0.0] * lags][:lags]) / length**2


def _flicker(lags: int, length: int) -> Floats:
    """Fourth differences of −J(l)/2π, with J from the closed form of the Allan variance of flicker noise.

    J grows as l² ln l, whose fourth differences lose digits: beyond 64 blocks two terms of the fourth derivative's series
    are used.
    """
    from scipy.special import digamma

    exact = min(lags, 64)
    stride = np.abs(np.arange(-2, exact + 2, dtype=float)) * length
    h = np.where(stride >= 1, (digamma(np.maximum(stride, 1) - 0.5) + np.euler_gamma + 2 * math.log(2)) / 2, 0.0)
    j = -(4 * stride**2 - 1) / 2 * h + 2 * stride * (stride - 1) - (stride - 1) ** 2 / 2
    j[stride < 1] = 0.0
    s = -j / (2 * math.pi)
    result = np.empty(lags)
    result[:exact] = (s[4:] - 4 * s[3:-1] + 6 * s[2:-2] - 4 * s[1:-3] + s[:-4]) / length**2
    far = np.arange(exact, lags, dtype=float)
    result[exact:] = -(1 + 1 / far**2) / (math.pi * far**2)
    return result


@functools.lru_cache(maxsize=16)
def mode_variances(count: int, length: int) -> Floats:
    """Variance of each mode of `count` differences, by term, for a squared coefficient of 1; shape (count, 4)."""
    from scipy.fft import dst
    from scipy.linalg import toeplitz

    columns = []
    for term in LINEAR:
        matrix = toeplitz(autocovariance(term, count, length))
        if term == "quantization":
            # The square of a tridiagonal matrix except for its corners, which belong to the ends, see `Problem`.
            matrix[0, 0] = matrix[-1, -1] = 5 / length**2
        columns.append(np.diag(dst(dst(matrix, type=1, norm="ortho", axis=0), type=1, norm="ortho", axis=1)))
    result = np.stack(columns, axis=1)
    result.setflags(write=False)
    return result


def regress(data: BlockMeans, regressor: Floats, *, theta: Floats | None = None) -> Regression:
    """The coefficient of one regressor in the block means, beside a level, a ramp and noise.

    The regressor holds its means over the blocks; blocks where it is NaN are left out. The squared coefficients `theta` of
    the noise, shape (4,), are estimated together with the regression unless they are given.
    """
    return Problem(data, np.isnan(regressor)).solve(np.nan_to_num(regressor), theta)


class Problem:
    """Differences of block means as independent modes; beside level and ramp, the level may change in the blocks `steps`."""

    __slots__ = ("_fixed", "_modes", "_y", "count")

    def __init__(self, data: BlockMeans, unknown: Bools | None = None, *, steps: Sequence[int] = ()) -> None:
        from scipy.fft import dst

        means = data.means
        empty = np.isnan(means) if unknown is None else np.isnan(means) | unknown
        # The block in which the level changes has a free mean, and all later blocks have another level.
        inside = [k for k in steps if 0 < k < len(means) - 1]
        empty[inside] = True
        filled = np.where(empty, 0.0, means - means[~empty][0])
        # A block without a mean gets a free mean: this is exact and leaves the modes unchanged. The first and the last block
        # get one too: the modes of quantization noise are then exactly independent, because the corners of its covariance
        # belong to these blocks and would leak into all modes.
        free = empty.copy()
        free[[0, -1]] = True
        dummies = np.zeros((len(means), int(free.sum())))
        dummies[np.flatnonzero(free), np.arange(dummies.shape[1])] = 1.0
        after = np.arange(len(means))[:, None] >= np.array(inside, dtype=int)
        fixed = np.column_stack([np.arange(len(means), dtype=float), dummies, after.astype(float)])
        both = dst(np.diff(np.column_stack([filled, fixed]), axis=0), type=1, norm="ortho", axis=0)
        self._y, self._fixed = both[:, 0], both[:, 1:]
        self._modes = mode_variances(len(means) - 1, data.length)
        self.count = len(means) - 1

    def noise(self) -> Floats:
        """Squared coefficients by REML, beside the level and the ramp alone."""
        return self._reml(self._fixed)[0]

    def quick(self, regressors: Floats, theta: Floats) -> Floats:
        """Student's ratio of each single regressor, shape (n_blocks, k), for given noise; shape (k,)."""
        from scipy.fft import dst

        columns = dst(np.diff(regressors, axis=0), type=1, norm="ortho", axis=0)
        root = np.sqrt(self._modes @ theta)[:, None]
        q, _ = np.linalg.qr(self._fixed / root)
        y = self._y / root[:, 0]
        y = y - q @ (q.T @ y)
        columns = columns / root
        columns = columns - q @ (q.T @ columns)
        size = np.linalg.norm(columns, axis=0)
        return np.asarray(y @ columns / np.where(size > 0, size, np.inf))

    def solve(self, regressor: Floats, theta: Floats | None = None) -> Regression:
        """The coefficient of one regressor; see `regress`."""
        from scipy.fft import dst
        from scipy.special import stdtr

        column = dst(np.diff(regressor), type=1, norm="ortho")
        size = float(np.linalg.norm(column))
        if not size > 0:
            return Regression(value=0.0, error=math.inf, freedom=1.0, p_value=1.0, theta=np.zeros(len(LINEAR)))
        design = np.column_stack([self._fixed, column / size])
        given = theta is not None
        theta, left = self._reml(design) if theta is None else (theta, None)
        v = self._modes @ theta
        root = np.sqrt(v)
        q, r = np.linalg.qr(design / root[:, None])
        value = float(q[:, -1] @ (self._y / root)) / r[-1, -1]
        error = 1 / abs(r[-1, -1])
        freedom = 1e9
        if not given and left is not None:
            # The squared error is Σ w² v with the weights w of the modes; its variance follows from the covariance of θ.
            w = q[:, -1] / root / r[-1, -1]
            gradient = self._modes.T @ (w * w)
            free = theta > 0
            share = (left / v)[:, None] * self._modes[:, free]
            scale = np.linalg.norm(share, axis=0)
            information = 0.5 * (share / scale).T @ (share / scale)
            g = gradient[free] / scale
            scatter = float(g @ np.linalg.pinv(information) @ g)
            freedom = 2 * error**4 / scatter if scatter > 0 else freedom
        freedom = min(max(freedom, 1.0), 1e9)
        p_value = 2 * float(stdtr(freedom, -abs(value) / error))
        return Regression(value=value / size, error=error / size, freedom=freedom, p_value=p_value, theta=theta)

    def _reml(self, design: Floats) -> tuple[Floats, Floats]:
        """θ by REML, as iterated weighted least squares on squared modes, and 1 − leverage of each mode."""
        q, _ = np.linalg.qr(design / np.linalg.norm(design, axis=0))
        residual = self._y - q @ (q.T @ self._y)
        left = np.maximum(1 - np.einsum("ij,ij->i", q, q), 1e-6)
        # Start from means over half octaves of modes with equal relative errors, so that weak modes count.
        bands = np.floor(2 * np.log2(np.arange(1, self.count + 1))).astype(int)
        number = np.maximum(np.bincount(bands, weights=left), 1e-6)
        occupied = np.bincount(bands) > 0
        power = (np.bincount(bands, weights=residual**2) / number)[occupied]
        power = np.maximum(power, power.max() * 1e-12)
        column = (
            np.stack([np.bincount(bands, weights=left * m) for m in self._modes.T], axis=1)[occupied]
            / number[occupied, None]
        )
        theta = non_negative(column / power[:, None], np.ones(len(power)))
        for step in range(_STEPS):
            v = self._modes @ theta
            root = np.sqrt(v)
            q, _ = np.linalg.qr(design / root[:, None])
            y = self._y / root
            squares = (y - q @ (q.T @ y)) ** 2
            left = np.maximum(1 - np.einsum("ij,ij->i", q, q), 1e-6)
            # The equations of REML: Σ (modes/v)·(squares − (1 − leverage)·modes·θ/v) = 0.
            part = np.sqrt(left)
            new = non_negative(part[:, None] * self._modes / v[:, None], squares / part)
            new = np.where(new > 0, new, 0.0)
            if not new.any():
                break
            moved = np.abs(self._modes @ new - v) > _TOLERANCE * v
            theta = 0.5 * (theta + new) if step >= _STEPS // 2 else new
            if not moved.any():
                break
        return theta, left
