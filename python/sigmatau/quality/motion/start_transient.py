"""Check for a record that begins near zero and settles at its mean, like the output of a filter that starts from zero."""

from __future__ import annotations

import numpy as np

from sigmatau.arrays import median_and_spread
from sigmatau.findings.disturbances import StartTransient
from sigmatau.findings.finding import Finding
from sigmatau.quality.motion.windows import FEW_WINDOWS, MIN_WINDOWS, WINDOW, WINDOW_LENGTH
from sigmatau.quality.samples.common import present
from sigmatau.quality.samples.masking import MaskedFinding, in_seconds, mask_from_spans
from sigmatau.record.streams import Stream

# Time within which a filter settles. [s] Judgement: a record that settles later warms up.
_LONGEST = 10.0
# Distance of the first sample from the mean of a window that begins 1 s later, over the robust standard deviation of
# such distances in the record. [1] Derived: the 7 of `_STEP_SPREADS` in windows.py, for a difference that is Gaussian
# for each of the five terms, and a margin.
_SIGMAS = 9.0
# Largest ratio of the first sample to the mean. [1] Judgement: a filter that starts from zero has settled by less than
# half after one sample.
_NEAR_ZERO = 0.5
# Number of further samples that must be between zero and the mean. [samples] Judgement: a single zero may be a lost row.
_RISING = 3
# Distance from the mean, in standard deviations of the noise, within which a sample has settled. [1] Derived: noise
# exceeds it once in 16 000 samples.
_SETTLED = 4.0


def settled_from(stream: Stream, channel: str) -> int:
    """Index of the first sample at the mean, for a channel that begins near zero and settles; otherwise 0."""
    tau0 = stream.grid.tau0
    w = max(round(WINDOW_LENGTH / tau0), WINDOW)
    count = stream.grid.n // w - 2
    if count < MIN_WINDOWS:
        return 0
    c = stream.channels.index(channel)
    head = stream.samples.read(c, 0, min(round(_LONGEST / tau0) + 2 * w, stream.grid.n))
    level = float(np.nanmean(head[-w:])) if np.isfinite(head[-w:]).any() else np.nan
    first = head[: _RISING + 1]
    if not (np.isfinite(first).all() and np.isfinite(level)) or abs(first[0]) > _NEAR_ZERO * abs(level):
        return 0
    # held at zero, or on the other side of the mean
    if first[0] == first[1] or not np.all((first < level) == (level > 0)):
        return 0
    x = stream.column(channel)[: (count + 2) * w].reshape(-1, w)
    means = np.nanmean(np.where(np.isfinite(x), x, level), axis=1)
    distance = x[:count, 0] - means[1 : count + 1]
    differences = present(distance[1:])
    if len(differences) < MIN_WINDOWS:
        return 0
    spread = median_and_spread(differences)[1]
    if not abs(first[0] - level) > _SIGMAS * (1 + FEW_WINDOWS / len(differences)) * spread:
        return 0
    unsettled = np.flatnonzero(np.abs(head - level) > _SETTLED * spread)
    if len(unsettled) < 2 or unsettled[1] != 1:  # a single zero is a row without a sample
        return 0
    stop = int(unsettled[np.flatnonzero(np.diff(unsettled, append=10 * len(head)) > w // 2)[0]]) + 1
    return 0 if stop * tau0 > _LONGEST else min(max(2 * stop, stop + 4), stream.grid.n)


def start_transient(stream: Stream) -> list[MaskedFinding]:
    """Report channels that begin near zero and settle at their mean within ten seconds, like a filter that starts from zero.

    At most one finding. It applies to all axes, because they have the same filter.
    """
    if stream.quantity not in ("angular_rate", "acceleration"):
        return []
    stops = {c: stop for c in stream.channels if (stop := settled_from(stream, c))}
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
    return [(finding, np.repeat(mask_from_spans(stream.grid.n, [(0, stop)])[:, None], len(stream.channels), axis=1))]
