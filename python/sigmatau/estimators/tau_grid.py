"""Grids of averaging times."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sigmatau.errors import OptionError, RecordTooShortError

TauGrid = Literal["octave", "half", "quarter", "eighth", "all"]

# First cluster sizes of each octave, doubled again and again: 2^j alone; with 3·2^j; with 5·2^j and 7·2^j, and so on. Such
# grids are chains (2m of one size is m of another), which the kernel can share work along.
_SEEDS: Mapping[str, tuple[int, ...]] = {
    "octave": (8,),
    "half": (8, 12),
    "quarter": (8, 10, 12, 14),
    "eighth": tuple(range(8, 16)),
}


def cluster_sizes(taus: TauGrid | ArrayLike, *, n: int, tau0: float) -> NDArray[np.int64]:
    """Cluster sizes in samples for a record of `n` samples, increasing, each at most n/2; see `allan`."""
    largest = n // 2
    if largest < 1:
        raise RecordTooShortError(f"{n} samples have no two clusters to compare", need=2, got=n)
    if isinstance(taus, str):
        if taus == "all":
            return np.arange(1, largest + 1, dtype=np.int64)
        if taus not in _SEEDS:
            grids = ", ".join((*_SEEDS, "all"))
            raise OptionError(f"unknown grid of τ {taus!r}; grids: {grids}, or times in s", option="taus")
        seeds = _SEEDS[taus]
        sizes = {seed << j for seed in seeds for j in range(largest.bit_length())}
        sizes |= {size // step for size in sizes for step in (2, 4, 8) if size % step == 0}
        return np.array(sorted(size for size in sizes if size <= largest), dtype=np.int64)
    times = averaging_times(taus)
    sizes_of = np.rint(times / tau0)
    if sizes_of.min() < 1:
        raise OptionError(
            f"τ = {times.min():.6g} s is shorter than half a sample interval ({tau0:.6g} s); the shortest is {tau0:.6g} s",
            option="taus",
        )
    if sizes_of.max() > largest:
        raise OptionError(
            f"τ = {times.max():.6g} s is longer than half the record; the longest is {largest * tau0:.6g} s",
            option="taus",
        )
    return np.unique(sizes_of).astype(np.int64)


def averaging_times(taus: ArrayLike) -> NDArray[np.float64]:
    """Averaging times as an array of shape (n_tau,); `OptionError` unless all of them are positive. [s]"""
    times = np.atleast_1d(np.asarray(taus, dtype=float))
    if times.ndim != 1 or times.size == 0:
        raise OptionError("{option} must be a list of averaging times in s", option="taus")
    bad = times[~(np.isfinite(times) & (times > 0))]
    if bad.size:
        raise OptionError(f"averaging times must be positive, got {float(bad[0])!r}", option="taus")
    return times
