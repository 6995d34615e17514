"""A record that begins near zero and settles at its mean, as a filter does that starts from zero."""

from __future__ import annotations

import numpy as np

from sigmatau.arrays import median_and_spread
from sigmatau.findings.disturbances import StartTransient
from sigmatau.findings.finding import Finding
from sigmatau.quality.samples.common import present
from sigmatau.quality.samples.masking import Found, in_seconds, mask_of
from sigmatau.record.streams import Stream

LONGEST_TRANSIENT = 10.0  # a record that settles later warms up [s]

# The first sample less the mean of a window of 1 s that begins 1 s later, compared with the same all over the record:
# Gaussian for each of the five terms. Threshold a·(1 + b/n) in robust standard deviations, n windows, see
# `sigmatau.quality.samples.motion`.
_WINDOW, _LEAST_WINDOWS = 1.0, 24  # [s], number
_THRESHOLD, _FEW_WINDOWS = 9.0, 12.0

_NEAR_ZERO = 0.5  # the first sample over the mean, at most
_RISING = 3  # samples after the first that must be between zero and the mean
_SETTLED = 4.0  # standard deviations of the noise about the mean


def settled_from(stream: Stream, channel: str, *, longest: float = LONGEST_TRANSIENT) -> int:
    """First sample of a channel at its mean, if it begins near zero and settles; 0 for any other beginning."""
    tau0 = stream.grid.tau0
    w = max(round(_WINDOW / tau0), 16)
    count = stream.grid.n // w - 2
    if count < _LEAST_WINDOWS:
        return 0
    c = stream.channels.index(channel)
    head = stream.samples.read(c, 0, min(round(longest / tau0) + 2 * w, stream.grid.n))
    level = float(np.nanmean(head[-w:])) if np.isfinite(head[-w:]).any() else np.nan
    first = head[: _RISING + 1]
    if not (np.isfinite(first).all() and np.isfinite(level)) or abs(first[0]) > _NEAR_ZERO * abs(level):
        return 0
    if first[0] == first[1] or not np.all((first < level) == (level > 0)):  # held at zero, or beyond the mean
        return 0
    x = stream.column(channel)[: (count + 2) * w].reshape(-1, w)
    means = np.nanmean(np.where(np.isfinite(x), x, level), axis=1)
    away = x[:count, 0] - means[1 : count + 1]
    there = present(away[1:])
    if len(there) < _LEAST_WINDOWS:
        return 0
    spread = median_and_spread(there)[1]
    if not abs(first[0] - level) > _THRESHOLD * (1 + _FEW_WINDOWS / len(there)) * spread:
        return 0
    far = np.flatnonzero(np.abs(head - level) > _SETTLED * spread)
    if len(far) < 2 or far[1] != 1:  # a single zero is a row without a sample
        return 0
    stop = int(far[np.flatnonzero(np.diff(far, append=10 * len(head)) > w // 2)[0]]) + 1
    return 0 if stop * tau0 > longest else min(max(2 * stop, stop + 4), stream.grid.n)


def start_transient(stream: Stream, *, longest: float = LONGEST_TRANSIENT) -> list[Found]:
    """Channels that begin near zero and settle at their mean within `longest` seconds, as a filter from zero does.

    At most one finding; the beginning of all axes is concerned, because they have the same filter.
    """
    if stream.quantity not in ("angular_rate", "acceleration"):
        return []
    stops = {c: stop for c in stream.channels if (stop := settled_from(stream, c, longest=longest))}
    if not stops:
        return []
    stop = max(stops.values())
    settled = stop * stream.grid.tau0
    finding = Finding(
        details=StartTransient(settled=settled),
        severity="warning",
        channels=tuple(stops),
        spans=in_seconds(stream, [(0, stop)]),
        size=settled,
        unit="s",
    )
    return [(finding, np.repeat(mask_of(stream.grid.n, [(0, stop)])[:, None], len(stream.channels), axis=1))]
