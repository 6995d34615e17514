"""Missing numbers of a record: how many there are, and where."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from sigmatau.arrays import run_edges
from sigmatau.errors import NonFiniteError
from sigmatau.findings.finding import Finding
from sigmatau.findings.spans import longest_spans
from sigmatau.findings.stamps import MissingValues
from sigmatau.record.streams import CHUNK, Columns

# share of the rows up to which missing numbers are not a warning: they change the coefficients by a smaller share
_FEW_MISSING = 1e-3

LARGEST_SAMPLE = 1e140
"""Largest magnitude of a sample, in SI: the squares of differences and their sums stay finite below it."""


def missing_values(
    missing: Mapping[str, NDArray[np.bool_]],
    where: Callable[[int], str],
    tau0: float,
    *,
    totals: Mapping[str, int] | None = None,
    unit: Literal["rows", "samples"] = "rows",
    dropped: bool = False,
) -> tuple[Finding, ...]:
    """One finding about all channels with missing numbers; empty if no number is missing.

    Parameters
    ----------
    missing : mapping of str to ndarray of bool
        By channel, True where a number is missing.
    where : callable
        Returns the place in the file or array, in words, for an index.
    tau0 : float
        Time from one row to the next. [s]
    totals : mapping of str to int, optional
        Number of rows. Default: the length of the array.
    unit : {"rows", "samples"}
        What is counted: rows of a file, or samples of the record.
    dropped : bool
        Whether the channels are left out of the record.
    """
    counts = {channel: int(np.count_nonzero(bad)) for channel, bad in missing.items()}
    counts = {channel: count for channel, count in counts.items() if count}
    if not counts:
        return ()
    total = max((totals or {}).get(channel, len(missing[channel])) for channel in counts)
    strongest = max(counts, key=lambda channel: counts[channel])
    runs = {channel: run_edges(missing[channel]) for channel in counts}
    lengths = np.diff(runs[strongest])
    k = int(np.argmax(lengths))
    start, longest = int(runs[strongest][k, 0]), int(lengths[k, 0])
    spans, more_spans = longest_spans(*np.unique(np.concatenate([*runs.values()]), axis=0).T * tau0)
    details = MissingValues(
        total=total,
        counts=tuple(counts.values()),
        strongest=strongest,
        place=where(min(int(np.argmax(missing[channel])) for channel in counts)),
        runs=len(lengths),
        longest=longest,
        longest_place=where(start),
        unit=unit,
        dropped=dropped,
    )
    few_missing = counts[strongest] <= _FEW_MISSING * total
    return (
        Finding(
            details=details,
            severity="error" if dropped else "info" if few_missing else "warning",
            channels=tuple(counts),
            spans=spans if unit == "samples" else (),
            more_spans=more_spans if unit == "samples" else 0,
            size=counts[strongest],
        ),
    )


def find_missing(samples: Columns, channels: Sequence[str], *, finite: bool) -> NDArray[np.bool_] | None:
    """Mask of the rates that are NaN, shape (n, n_channels); None if there is no NaN.

    `finite`: whether the raw columns are known to be finite.

    Raises
    ------
    NonFiniteError
        If a rate is infinite, or larger than `LARGEST_SAMPLE`.
    """
    n = len(samples)
    mask: NDArray[np.bool_] | None = None
    for c, channel in enumerate(channels):
        if finite and samples.shrinks(c):
            continue
        for start in range(0, n, CHUNK):
            # a value that overflows in SI is refused below
            with np.errstate(over="ignore", invalid="ignore"):
                x = samples.read(c, start, min(start + CHUNK, n))
                if np.dot(x, x) <= LARGEST_SAMPLE**2:
                    continue  # fast path: a NaN, an infinity or a very large sample would show in the sum
            bad = ~(np.abs(x) <= LARGEST_SAMPLE)
            if not bad.any():
                continue
            infinite = np.flatnonzero(bad & ~np.isnan(x))
            if len(infinite):
                index = start + int(infinite[0])
                what = "infinite" if np.isinf(x[infinite[0]]) else f"{x[infinite[0]]:.3g}, too large to be squared,"
                raise NonFiniteError(
                    f"`{channel}` is {what} at index {index} (t = {index * samples.tau0:.6g} s)",
                    channel=channel,
                    index=index,
                )
            if mask is None:
                mask = np.zeros((n, len(channels)), dtype=bool)
            mask[start : start + len(x), c] = bad
    return mask
