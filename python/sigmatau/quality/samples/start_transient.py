"""A record that begins with a filter's way from zero to the level of its input."""

from __future__ import annotations

import numpy as np

from sigmatau.arrays import median_and_spread
from sigmatau.findings.finding import Finding
from sigmatau.quality.samples.common import affected, axes_text, change_of_white, length, present
from sigmatau.record.streams import Stream

__all__ = ["settled_from", "start_transient"]

# The first sample less the mean of a window of 1 s that begins 1 s later, against the same all over the record: Gaussian for
# each of the five terms, with the threshold of a change of level.
_WINDOW_S, _LEAST_WINDOWS = 1.0, 24
_FAR, _FEW = 9.0, 12.0

# It begins nearer to zero than to its level, and the next samples are on the way.
_NEARER, _ON_THE_WAY = 0.5, 3
_MOST_S = 10.0  # longer ones are a warm-up
_LEFT = 4.0  # standard deviations of the noise about the level
_MATTERS = 1.02


def settled_from(stream: Stream, channel: str) -> int:
    """From which sample on a channel is at its level, if it begins at zero and comes to it; 0 for any other beginning."""
    tau0 = stream.grid.tau0
    w = max(round(_WINDOW_S / tau0), 16)
    count = stream.grid.n // w - 2
    if count < _LEAST_WINDOWS:
        return 0
    c = stream.channels.index(channel)
    head = stream.samples.read(c, 0, min(round(_MOST_S / tau0) + 2 * w, stream.grid.n))
    level = float(np.nanmean(head[w : 2 * w])) if np.isfinite(head[w : 2 * w]).any() else np.nan
    first = head[: _ON_THE_WAY + 1]
    if not (np.isfinite(first).all() and np.isfinite(level)) or abs(first[0]) > _NEARER * abs(level):
        return 0
    if first[0] == first[1] or not np.all(
        (first < level) == (level > 0)
    ):  # held at zero is not there; above it, no way
        return 0
    x = stream.column(channel)[: (count + 2) * w].reshape(-1, w)
    means = np.nanmean(np.where(np.isfinite(x), x, level), axis=1)
    away = x[:count, 0] - means[1 : count + 1]
    there = present(away[1:])
    if len(there) < _LEAST_WINDOWS:
        return 0
    spread = median_and_spread(there)[1]
    if not abs(first[0] - level) > _FAR * (1 + _FEW / len(there)) * spread:
        return 0
    far = np.flatnonzero(np.abs(head - level) > _LEFT * spread)
    stop = int(far[np.flatnonzero(np.diff(far, append=10 * len(head)) > w // 2)[0]]) + 1
    return 0 if stop * tau0 > _MOST_S else min(max(2 * stop, stop + 4), stream.grid.n)


def start_transient(stream: Stream) -> list[Finding]:
    """Channels that begin at zero and settle at their level within seconds, as a filter does whose state was not set.

    Parameters
    ----------
    stream : Stream
        Angular rates or accelerations; of other signals nothing is said.

    Returns
    -------
    list of Finding
        One for all channels concerned.
    """
    if stream.quantity not in ("angular_rate", "acceleration"):
        return []
    stops = {c: stop for c in stream.channels if (stop := settled_from(stream, c))}
    if not stops:
        return []
    stop, tau0 = max(stops.values()), stream.grid.tau0
    factors = {}
    for channel, until in stops.items():
        x = stream.column(channel)
        bad = np.zeros(len(x), dtype=bool)
        bad[:until] = True
        factors[channel] = change_of_white(x, bad, tau0)
    worst = max(factors, key=lambda c: factors[c][0])
    factor, tau = factors[worst]
    matters = factor > _MATTERS
    return [
        Finding(
            code="start_transient",
            severity="warning" if matters else "info",
            channel=worst if len(stops) == 1 else None,
            message=(
                f"{axes_text(tuple(stops))}: the record begins near zero and settles at its level within"
                f" {length(stop, stream)}, as a filter does that starts from zero"
            ),
            where=f"t = 0 s to {stop * tau0:.6g} s",
            size=stop * tau0,
            unit="s",
            effect=f"{f'{worst}: ' if len(stops) > 1 else ''}{affected(factor)} (at τ = {tau:.3g} s)",
            changes=(("random_walk", factor),) if matters else (),
            remedy=f"--window {max(int(np.ceil(stop * tau0)), 1)}s: leaves it out",
        )
    ]
