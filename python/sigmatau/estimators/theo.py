"""TheoBR and TheoH: Theo1 without its bias, and the Allan deviation continued by it.

References
----------
.. [1] D. A. Howe, "ThêoH: a hybrid, high-confidence statistic that improves on the Allan deviation," Metrologia 43, 2006,
   :doi:`10.1088/0026-1394/43/4/S20`.
.. [2] W. J. Riley, "Handbook of Frequency Stability Analysis," NIST Special Publication 1065, 2008, sections 5.2.16, 5.2.17.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from sigmatau._native import kernels
from sigmatau.errors import OptionError

SHORTEST = 89  # samples of the shortest record with a ratio: 90 points of the phase in `ratio_count`
LONGEST = 50_000  # samples of the longest record whose ratios are computed: N³/900 steps, a minute
_AT_ONCE = 16  # ratios between two reports of progress

Kernel = Callable[[str, NDArray[np.int64]], "tuple[list[NDArray[np.float64]], NDArray[np.int64]]"]


def ratio_count(n: int) -> int:
    """Number of averaging times whose Allan variance is compared with Theo1: up to about a tenth of the record [2]_."""
    return int(0.1 * (n + 1) / 3 - 3) + 1


def ratio_steps(n: int) -> float:
    """Approximate number of terms of the ratios."""
    count = ratio_count(n)
    return float(n) * count * (count + 5)


def steps(n: int, m: NDArray[np.int64], *, hybrid: bool) -> float:
    """Approximate number of terms of the ratios and of Theo1 at the cluster sizes `m`."""
    sizes = m[m > last_allan_size(n)] if hybrid else m
    return ratio_steps(n) + float(np.sum((n - sizes) * sizes)) if sizes.size else 1.0


def check_length(label: str, n: int) -> None:
    """Raise `OptionError` for a record whose ratios take too long."""
    if n > LONGEST:
        raise OptionError(
            f"{{option}}: the {label} of {n} samples takes some {ratio_steps(n):.0e} steps; the limit is {LONGEST} samples."
            " Take theo1, and its bias for the fitted noise",
            option="kind",
        )


def last_allan_size(n: int) -> int:
    """Largest cluster size at which TheoH is the Allan deviation: a tenth of the record [2]_."""
    return n // 10


def tau_over_m(n: int, m: NDArray[np.int64]) -> NDArray[np.float64]:
    """Averaging time of TheoH over the cluster size."""
    return np.where(m <= last_allan_size(n), 1.0, 0.75)


def allan_over_theo1(
    columns: Sequence[NDArray[np.float64]], names: Sequence[str], *, threads: int | None, tell: Callable[[float], None]
) -> NDArray[np.float64]:
    """Mean ratio of the Allan variance at m = 9, 12, 15 … to Theo1 at the same averaging times, by channel [1]_.

    `tell` is called with the number of steps after each part of the work.
    """
    n = len(columns[0])
    index = np.arange(ratio_count(n), dtype=np.int64)
    allan, _, _ = kernels.allan_variances(
        columns, 9 + 3 * index, overlap="full", counting="standard", threads=threads, names=names
    )
    ratios = np.zeros(len(columns))
    for first in range(0, len(index), _AT_ONCE):
        part = slice(first, first + _AT_ONCE)
        theo1, _ = kernels.deviations(
            "theo1", columns, 12 + 4 * index[part], overlap="full", threads=threads, names=names
        )
        ratios += [np.sum(_ratio(avar[part], dev**2)) for avar, dev in zip(allan, theo1, strict=True)]
        tell(float(n) * float(np.sum(6 + 2 * index[part])) * len(columns))
    return np.asarray(ratios / len(index))


def _ratio(avar: NDArray[np.float64], theo1: NDArray[np.float64]) -> NDArray[np.float64]:
    """Divide; a record without noise has no bias."""
    return np.divide(avar, theo1, out=np.ones(len(avar)), where=theo1 > 0)


def theo_deviations(
    columns: Sequence[NDArray[np.float64]],
    m: NDArray[np.int64],
    names: Sequence[str],
    *,
    hybrid: bool,
    threads: int | None,
    tell: Callable[[float], None],
) -> tuple[list[NDArray[np.float64]], NDArray[np.int64]]:
    """TheoBR, or TheoH if `hybrid`, of several channels of one length, and the number of terms of each size."""
    n = len(columns[0])
    allan_sizes = m[: np.searchsorted(m, last_allan_size(n), side="right")] if hybrid else m[:0]
    theo1_sizes = m[len(allan_sizes) :]
    deviations: list[list[NDArray[np.float64]]] = [[] for _ in columns]
    terms = []
    if allan_sizes.size:
        avar, _, pairs = kernels.allan_variances(
            columns, allan_sizes, overlap="full", counting="standard", threads=threads, names=names
        )
        terms.append(pairs)
        for parts, variance in zip(deviations, avar, strict=True):
            parts.append(np.sqrt(variance))
        if not theo1_sizes.size:
            tell(float(len(columns)))
    if theo1_sizes.size:
        factors = np.sqrt(allan_over_theo1(columns, names, threads=threads, tell=tell))
        for size in theo1_sizes:
            theo1, count = kernels.deviations(
                "theo1", columns, np.array([size]), overlap="full", threads=threads, names=names
            )
            terms.append(count)
            tell(float((n - size) * size) * len(columns))
            for parts, factor, deviation in zip(deviations, factors, theo1, strict=True):
                parts.append(factor * deviation)
    return [np.concatenate(parts) for parts in deviations], np.concatenate(terms)
