"""Rows of zeros, one here and one there: a message that was lost and filled with nothing."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from sigmatau.arrays import median_and_spread
from sigmatau.findings.finding import Finding
from sigmatau.quality.samples.common import (
    affected,
    axes_text,
    block_rms,
    change_of_white,
    place,
    present,
    sample_of,
    when,
)
from sigmatau.quality.samples.masking import leave_out_option, masked, spans_of
from sigmatau.quality.samples.resolution import resolution
from sigmatau.quality.samples.stuck_samples import stuck_runs, zero_runs
from sigmatau.record.streams import Stream

__all__ = ["dropout_masks", "lost_rows", "stuck_masks", "zero_rows", "zeros_of"]

# Samples of a channel alone are lost where 0 is so many of its standard deviations away; noise is not.
_FAR = 12.0

# Nearer ones are if no tail leads to them: ten times as many as lie within one standard deviation of 0. The end of a range
# that noise touches beyond 4 has 0.02 times as many.
_NO_TAIL = 4.0

# Rows in which all axes are 0 at once must be so many, and so many times what chance makes of the axes' own zeros: axes
# whose numbers are coarse rest at 0 together for their own reasons.
_LEAST, _TIMES, _SIGMAS = 3, 10.0, 6.0

_LOOKED_AT = 1 << 17

# From so large a part of the record or of the random walk on it matters.
_SHARE, _MATTERS = 1e-3, 1.02


def zeros_of(stream: Stream, channel: str) -> NDArray[np.bool_] | None:
    """Where the log holds the number 0 for a channel; None for accumulated values, whose changes are 0 where they stick."""
    zero = _zero(stream, channel)
    return None if zero is None else np.asarray(stream.column(channel) == zero)


def _zero(stream: Stream, channel: str) -> float | None:
    """The rate that the number 0 of the log stands for."""
    t = stream.samples.transforms[stream.channels.index(channel)]
    if t.kind == "accumulated":
        return None
    factor = t.scale * t.factor / (stream.grid.tau0 if t.kind != "rate" else 1.0)
    return -t.offset * factor if t.offset else 0.0


def zero_rows(stream: Stream) -> NDArray[np.bool_] | None:
    """Samples that are 0 on all axes of a stream at once more often than chance makes them; None if there are none.

    The chance of a 0 on one axis is q/(√(2π)·s) at most for steps q and noise of standard deviation s. A stream of one
    channel is judged where 0 is more than 12 standard deviations from its level.

    Parameters
    ----------
    stream : Stream

    Returns
    -------
    ndarray of bool, shape (n,), or None
    """
    together: NDArray[np.bool_] | None = None
    for channel in stream.channels:
        zeros = zeros_of(stream, channel)
        if zeros is None:
            return None
        together = zeros if together is None else together & zeros
        if np.count_nonzero(together) < _LEAST:
            return None
    if together is None:
        return None
    count = int(np.count_nonzero(together))
    chances = [_chance(stream, channel) for channel in stream.channels]
    if len(stream.channels) == 1 and chances[0] > 0:
        return None
    by_chance = len(together) * math.prod(chances)
    if count < _TIMES * by_chance + _SIGMAS * math.sqrt(by_chance) or count > len(together) / 2:
        return None
    return together


def _chance(stream: Stream, channel: str) -> float:
    """The largest part of a channel's samples that can be 0 without a fault."""
    x = present(sample_of(stream, channel, most=_LOOKED_AT))
    if len(x) < 2:
        return 1.0
    (middle, spread), zero = median_and_spread(x), _zero(stream, channel)
    if zero is not None and spread > 0 and abs(middle - zero) > _FAR * spread:
        return 0.0
    if zero is not None and spread > 0 and abs(middle - zero) > _NO_TAIL * spread:
        lost = int(np.count_nonzero(x == zero))
        about = int(np.count_nonzero(np.abs(x - zero) < spread)) - lost
        if lost >= _LEAST and lost > _TIMES * about + _SIGMAS * math.sqrt(about):
            return 0.0
    found = resolution(stream, channel)
    if found is None:
        # Numbers without a step that is seen: no coarser than their differences let one see.
        values = np.unique(x)
        if 2 * len(values) < len(x):
            return 1.0
        return 1.0 / math.sqrt(len(x))
    scale = block_rms(x - middle)
    return min(found.step / (math.sqrt(2 * math.pi) * scale), 1.0) if scale > 0 else 1.0


def lost_rows(stream: Stream) -> tuple[list[Finding], Stream]:
    """The finding ``dropout`` for rows of zeros that are no long runs, and the stream without them.

    Parameters
    ----------
    stream : Stream

    Returns
    -------
    list of Finding, Stream
        One finding for all axes, long runs of zeros included; none, and the very stream, where all zeros are in runs:
        of them `sigmatau.quality.samples.stuck_samples.dropouts` tells.
    """
    rows = zero_rows(stream)
    if rows is None:
        return [], stream
    spans = spans_of(rows)
    runs = sum(stop - start >= 5 for start, stop in spans)
    if len(spans) - runs < _LEAST:
        return [], stream
    factors = {c: change_of_white(stream.column(c), rows, stream.grid.tau0) for c in stream.channels}
    worst = max(factors, key=lambda c: factors[c][0])
    factor, tau = factors[worst]
    count, share = int(rows.sum()), float(rows.mean())
    longest = max(stop - start for start, stop in spans)
    several = f", up to {longest} in a row" if longest > 1 else ""
    at = f" of {worst}" if len(stream.channels) > 1 else ""
    finding = Finding(
        code="dropout",
        severity="warning" if share > _SHARE or factor > _MATTERS else "info",
        channel=stream.channels[0] if len(stream.channels) == 1 else None,
        message=(
            f"{count} samples ({100 * share:.2g} %) are 0 on {axes_text(stream.channels)} at once{several}, the first at"
            f" {when(spans[0][0], stream)}: lost, and written as nothing"
            if len(stream.channels) > 1
            else f"{count} samples ({100 * share:.2g} %) are 0{several}, the first at {when(spans[0][0], stream)}: lost, and"
            " written as nothing"
        ),
        where=place(spans[0][0], stream),
        size=share,
        effect=f"{affected(factor, term=f'random walk{at}')} (at τ = {tau:.3g} s)",
        changes=(("random_walk", factor),),
        remedy=f"{leave_out_option(stream, spans, kind='dropouts')} takes them for missing",
    )
    return [finding], masked(stream, rows)


def dropout_masks(stream: Stream) -> list[NDArray[np.bool_]]:
    """By channel, the samples that the findings ``dropout`` are about."""
    rows = zero_rows(stream)
    masks = []
    for channel in stream.channels:
        mask = np.zeros(stream.grid.n, dtype=bool) if rows is None else rows.copy()
        masks.append(_with(mask, *zero_runs(stream, channel, stream.column(channel))))
    return masks


def stuck_masks(stream: Stream) -> list[NDArray[np.bool_]]:
    """By channel, the runs of equal samples that noise does not make."""
    empty = np.zeros(stream.grid.n, dtype=bool)
    return [_with(empty.copy(), *stuck_runs(stream, c, stream.column(c))) for c in stream.channels]


def _with(mask: NDArray[np.bool_], first: NDArray[np.int64], lengths: NDArray[np.int64]) -> NDArray[np.bool_]:
    for start, size in zip(first.tolist(), lengths.tolist(), strict=True):
        mask[start : start + size] = True
    return mask
