"""Numbers that are missing among those of a record: how many, where, and what is said of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import NonFiniteError
from sigmatau.findings.finding import Finding
from sigmatau.record.streams import CHUNK, Columns
from sigmatau.results import seconds

__all__ = ["mask_of", "missing_values"]

_FEW = 1e-3  # of the rows: no more than that is no warning


def missing_values(
    missing: Mapping[str, NDArray[np.bool_]],
    where: Callable[[int], str],
    tau0: float,
    *,
    of: Mapping[str, int] | None = None,
    rows: str = "rows",
) -> tuple[Finding, ...]:
    """One finding about all channels that miss numbers; none if none does.

    Parameters
    ----------
    missing : mapping of str to ndarray of bool
        By channel, True where there is no number.
    where : callable
        Place of an index, for the message.
    tau0 : float
        Time from one to the next. [s]
    of : mapping of str to int, optional
        How many there are. Default: the length of the array.
    rows : str
        What they are called.
    """
    counts = {channel: int(np.count_nonzero(bad)) for channel, bad in missing.items()}
    counts = {channel: count for channel, count in counts.items() if count}
    if not counts:
        return ()
    total = max((of or {}).get(channel, len(missing[channel])) for channel in counts)
    worst = max(counts, key=lambda channel: counts[channel])
    first = min(int(np.argmax(missing[channel])) for channel in counts)
    count = counts[worst]
    each = f"{count} of {total}" if len(set(counts.values())) == 1 else f"up to {count} of {total} ({worst})"
    together = _together(missing[worst], where, tau0, rows)
    return (
        Finding(
            code="missing_values",
            severity="info" if count <= _FEW * total else "warning",
            channel=next(iter(counts)) if len(counts) == 1 else None,
            message=f"{each} {rows} have no number in {', '.join(counts)}; the first: {where(first)}{together}",
            where=where(first),
            size=count,
            effect="they are missing samples on the grid, left empty and never filled in",
            remedy="none is needed if they are few; look at the link or the converter if not",
        ),
    )


def _together(bad: NDArray[np.bool_], where: Callable[[int], str], tau0: float, rows: str) -> str:
    """Whether they are on end."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], bad.view(np.int8), [0]))))
    lengths = edges[1::2] - edges[::2]
    k = int(np.argmax(lengths))
    number, longest, begins = len(lengths), int(lengths[k]), int(edges[::2][k])
    if longest == 1:
        return ", none beside another" if number > 1 else ""
    long = f"{longest} {rows} ({seconds(longest * tau0)} s) on end"
    return f", {long}" if number == 1 else f"; in {number} stretches, the longest {long} from {where(begins)} on"


def mask_of(samples: Columns, channels: Sequence[str], *, finite: bool) -> NDArray[np.bool_] | None:
    """True where a rate is no number, shape (n, n_channels); None if all are. `finite`: the raw columns have been looked at.

    Raises
    ------
    NonFiniteError
        If one is infinite.
    """
    n = len(samples)
    mask: NDArray[np.bool_] | None = None
    for c, channel in enumerate(channels):
        if finite and samples.shrinks(c):
            continue
        for start in range(0, n, CHUNK):
            with np.errstate(over="ignore", invalid="ignore"):  # what a unit makes infinite is refused below
                x = samples.read(c, start, min(start + CHUNK, n))
                if np.isfinite(np.add.reduce(x)):
                    continue  # one NaN or infinity would have made the sum one, and this is faster
            bad = ~np.isfinite(x)
            if not bad.any():
                continue
            infinite = np.flatnonzero(np.isinf(x))
            if len(infinite):
                index = start + int(infinite[0])
                raise NonFiniteError(
                    f"`{channel}` is infinite at index {index} (t = {index * samples.tau0:.6g} s)",
                    channel=channel,
                    index=index,
                )
            if mask is None:
                mask = np.zeros((n, len(channels)), dtype=bool)
            mask[start : start + len(x), c] = bad
    return mask
