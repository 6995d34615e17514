"""Samples taken for missing: how a stream goes without them, and how the option that leaves them out is spelled."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sigmatau.arrays import runs
from sigmatau.record.streams import Stream

__all__ = ["leave_out_option", "mask_of", "masked", "spans_of", "without_steps"]

# Stretches closer than this are one in the text of an option, and of more stretches than this only the kind is named.
_TOGETHER_S, _LISTED = 1.0, 8

_DIGITS = 3  # of a second; ends are rounded outwards


def masked(stream: Stream, mask: NDArray[np.bool_]) -> Stream:
    """The stream with samples taken for missing; its log, and what is known of its numbers, stays as it is.

    Parameters
    ----------
    stream : Stream
    mask : ndarray of bool, shape (n,) or (n, n_channels)
        True for the rates to take for missing, on all channels or on each.

    Returns
    -------
    Stream
        The very same if the mask has none.
    """
    if not mask.any():
        return stream
    missing = np.array(np.broadcast_to(mask.reshape(len(mask), -1), (stream.grid.n, len(stream.channels))))
    if stream.mask is not None:
        missing |= stream.mask
    return replace(stream, samples=replace(stream.samples, missing=missing), mask=missing)


def mask_of(n: int, spans: Iterable[tuple[int, int]]) -> NDArray[np.bool_]:
    """True in some stretches of n samples, which may reach beyond its ends; shape (n,)."""
    mask = np.zeros(n, dtype=bool)
    for start, stop in spans:
        mask[max(start, 0) : max(stop, 0)] = True
    return mask


def spans_of(bad: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First sample of each stretch of True, and the first after it."""
    return runs(bad)


def leave_out_option(stream: Stream, spans: Sequence[tuple[int, int]], *, kind: str = "") -> str:
    """The option that takes some stretches for missing: ``"--leave-out 720s:722s,1080s:1083.2s"``.

    Parameters
    ----------
    stream : Stream
        Times are from the beginning of the record, also where this is a window of it.
    spans : sequence of (int, int)
        Samples, stop not included. Those less than 1 s apart are put together if they are many.
    kind : str
        What stands for all of them if they are still too many to list: ``"dropouts"``, ``"stuck"``; empty if nothing does.
    """
    tau0 = stream.grid.tau0
    joined: list[tuple[int, int]] = []
    gap = _TOGETHER_S / tau0 if len(spans) > _LISTED else 0.0
    for start, stop in sorted(spans):
        if joined and start - joined[-1][1] <= gap:
            joined[-1] = (joined[-1][0], max(stop, joined[-1][1]))
        else:
            joined.append((start, stop))
    if len(joined) > _LISTED and kind:
        return f"--leave-out {kind}"
    listed = sorted(sorted(joined, key=lambda span: span[0] - span[1])[:_LISTED])
    return "--leave-out " + ",".join(
        f"{_outward(start * tau0 + stream.grid.lead, math.floor)}s:{_outward(stop * tau0 + stream.grid.lead, math.ceil)}s"
        for start, stop in listed
    )


# Two changes of level that cancel to this part of them are one that came and went.
_BACK = 0.3


def without_steps(stream: Stream, steps: Sequence[tuple[int, int, float]]) -> str:
    """The option that leaves changes of level out of a record.

    Of a level that comes back, what is between; else the longest part with one level, because a record without the moment
    of a change still has both levels.

    Parameters
    ----------
    stream : Stream
    steps : sequence of (int, int, float)
        Sample of each change in order of time, to how many samples that is known, and its size.
    """
    if len(steps) == 2:
        (first, near, up), (second, wide, down) = steps
        if abs(up + down) < _BACK * max(abs(up), abs(down)):
            option = leave_out_option(stream, [(max(first - near, 0), min(second + wide, stream.grid.n))])
            return f"{option} takes the time between for missing"
    edges = [(0, 0), *((at, about) for at, about, _ in steps), (stream.grid.n, 0)]
    k = max(range(len(edges) - 1), key=lambda i: edges[i + 1][0] - edges[i][0])
    tau0, lead = stream.grid.tau0, stream.grid.lead
    start, stop = edges[k][0] + edges[k][1], edges[k + 1][0] - edges[k + 1][1]
    begins = f"{_outward(start * tau0 + lead, math.ceil)}s" if k or lead else ""
    ends = f"{_outward(stop * tau0 + lead, math.floor)}s" if k < len(steps) or lead else ""
    times = ", ".join(f"{at * tau0:.6g} s" for at, _, _ in steps[:_LISTED])
    listed = f"; the level changes at {times}" if len(steps) > 1 else ""
    return f"--window {begins}:{ends} is the longest part with one level{listed}"


def _outward(time: float, to_whole: Callable[[float], int]) -> str:
    scale = 10**_DIGITS
    whole = to_whole(round(time * scale, 3))  # three digits more, for what rounding leaves
    return f"{whole / scale:.{_DIGITS}f}".rstrip("0").rstrip(".")
