"""Expected Allan variances of records with missing samples.

The Allan variance of such a record averages over pairs of neighbouring clusters that are both at least half full; a cluster
is the mean of its present samples. Missing samples are not filled in. The expected variance depends on which samples are
missing. That of a random walk is larger, because clusters have fewer samples. That of quantization noise is much larger at
long times, because its differences no longer cancel within a cluster (5 % of all samples missing at random: 10 times the
variance at 256 samples). That of a rate random walk is nearly the same. `Gaps` computes these expectations for one mask.
"""

from __future__ import annotations

from typing import Self
from weakref import WeakValueDictionary

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sigmatau._native import kernels
from sigmatau.frozen import frozen

Floats = NDArray[np.float64]

TERMS = ("quantization", "random_walk", "bias_instability", "rate_random_walk")  # Columns of `Expected.avar`

# What the kernel gives, column by column: pairs, TERMS[0], telescoping, TERMS[1:], square distance.
_PAIRS, _DISTANCE = 0, 6
_OF_TERMS = [1, 3, 4, 5]
_MOST_EXACT_SIZES = 100
_known: WeakValueDictionary[bytes, Gaps] = WeakValueDictionary()


@frozen(eq=False)
class Expected:
    """Expected Allan variances for unit coefficients, one sample interval being 1."""

    m: NDArray[np.int64]  # shape (n_tau,); cluster sizes
    # shape (n_tau,); pairs of clusters that are both at least half full. Of a size without one, all else is NaN.
    n_pairs: NDArray[np.int64]
    avar: Floats  # shape (n_tau, 4); of each of `TERMS`
    # shape (n_tau,); mean square of the distance of the mean times of the two clusters; m² without gaps. [samples²]
    square_distance: Floats


class Gaps:
    """Missing samples of a channel, and their effect on each term; see `Gaps.of`. Channels with the same missing
    samples share one object and its cached results.
    """

    __slots__ = ("__weakref__", "_packed", "_rows", "missing", "n")

    def __init__(self, packed: NDArray[np.uint8], n: int) -> None:
        self._packed = packed
        self.n = n  # samples of the grid
        self.missing = n - int(self.there.sum())  # how many samples are missing
        self._rows: dict[int, Floats] = {}

    @classmethod
    def of(cls, missing: NDArray[np.bool_]) -> Self:
        """The gaps of a channel. `missing`: true where a sample is missing, as in
        `sigmatau.record.streams.Stream.mask`.
        """
        return cls._shared(np.packbits(~missing), len(missing))

    @classmethod
    def _shared(cls, packed: NDArray[np.uint8], n: int) -> Self:
        import hashlib

        key = hashlib.blake2b(packed.tobytes() + n.to_bytes(8, "big"), digest_size=24).digest()
        found = _known.get(key)
        if not isinstance(found, cls):
            found = cls(packed, n)
            _known[key] = found
        return found

    def __reduce__(self) -> tuple[object, ...]:
        return Gaps._shared, (self._packed, self.n)

    def __repr__(self) -> str:
        return f"Gaps: {self.missing} of {self.n} samples missing"

    @property
    def there(self) -> NDArray[np.bool_]:
        """True where a sample is there, shape (n,)."""
        return np.unpackbits(self._packed, count=self.n).view(np.bool_)

    def expected(self, m: ArrayLike, *, threads: int | None = None) -> Expected:
        """Expected Allan variance of each term at cluster sizes `m`, each at most n/2.

        Exact for every pair that counts, but for flicker noise: it is made of Gauss-Markov processes, which is good to 1e-4
        of its variance, and clusters of 128 or more samples of them begin at every 64th
        to 128th part of their length, good to 1e-3 of what the gaps change; shorter clusters of records of more than half a
        million samples are looked at in evenly spread stretches, good to 1e-4.
        """
        sizes = np.atleast_1d(np.asarray(m, dtype=np.int64))
        new = np.array(sorted({int(size) for size in sizes} - self._rows.keys()), dtype=np.int64)
        if len(new):
            columns = kernels.masked_expectations(self.there, new, threads=threads)
            self._rows.update(zip(new.tolist(), columns, strict=True))
        rows = np.array([self._rows[int(size)] for size in sizes])
        return Expected(
            m=sizes,
            n_pairs=rows[:, _PAIRS].astype(np.int64),
            avar=rows[:, _OF_TERMS],
            square_distance=rows[:, _DISTANCE],
        )

    def ratio(self, term: str, m: ArrayLike) -> Floats:
        """Expected Allan variance of one term, or of the ramp, over that without gaps; 1 at sizes without a pair. Of
        more than 100 sizes, the rest is interpolated between 100.
        """
        sizes = np.atleast_1d(np.asarray(m, dtype=np.int64))
        grid = np.unique(sizes)
        if len(grid) > _MOST_EXACT_SIZES:
            grid = grid[np.unique(np.round(np.geomspace(1, len(grid), _MOST_EXACT_SIZES)).astype(int)) - 1]
        e = self.expected(grid)
        if term == "rate_ramp":
            values = e.square_distance / grid.astype(float) ** 2
        else:
            values = e.avar[:, TERMS.index(term)] / kernels.term_avar(term, 1.0, grid, 1.0)
        values = np.where(e.n_pairs > 0, values, 1.0)
        return np.asarray(np.interp(np.log(sizes), np.log(grid), values))
