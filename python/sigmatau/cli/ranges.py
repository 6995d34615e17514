"""Ranges of averaging times on the command line."""

from __future__ import annotations

from collections.abc import Sequence

from sigmatau.analysis import Analysis
from sigmatau.cli.options import key_values
from sigmatau.errors import OptionError
from sigmatau.noise.terms import TERMS
from sigmatau.quality.selection.time_text import time_of
from sigmatau.results import seconds, wrapped

_EXAMPLE = "random_walk=1s:10s"


def read_off_ranges(values: Sequence[str]) -> dict[str, tuple[float, float]]:
    """The option ``--read-off-at``: ``["gyro_x.random_walk=1s:10s"]`` as ``{"gyro_x.random_walk": (1.0, 10.0)}``, in s."""
    found = {}
    for key, text in key_values(values, "read-off-at", _EXAMPLE).items():
        first, colon, last = text.partition(":")
        if not (first.strip() and colon and last.strip()):
            raise OptionError(
                f"--read-off-at {key}={text}: give the shortest and the longest averaging time, e.g. {_EXAMPLE}",
                option="read_off_at",
            )
        ends = [
            time_of(part, f"{key}={text}", option="read_off_at", forms=f"e.g. {_EXAMPLE} (ms, s, min, h, d)")
            for part in (first, last)
        ]
        found[key] = (ends[0], ends[1])
    return found


_FORCE = "--force draws a refused line"


def lines_by_hand(analysis: Analysis) -> list[str]:
    """What was read off in the given ranges beside a fit, a line a channel. A read-off without a fit has its own table."""
    lines = []
    for channel, read in analysis.read_off.items() if analysis.fits else ():
        texts = [
            f"{TERMS[name].label(read.quantity)} {' '.join(read.texts(name)[0])} ({one.region})"
            for name, one in read.items()
            if one.range_from == "given"
        ]
        if texts:
            lines.append(f"{channel} read off: {', '.join(texts)}")
    return wrapped(lines)


def refused_by_hand(analysis: Analysis, *, in_table: bool) -> list[str]:
    """The lines of given ranges that were refused, and why, a line each, unless the table has them."""
    lines = [
        f"{channel} {TERMS[refusal.term].label(read.quantity)} not read off from {seconds(refusal.tau_min)} to"
        f" {seconds(refusal.tau_max)} s: {refusal.reason}"
        for channel, read in analysis.read_off.items()
        for refusal in read.refused
        if refusal.by_hand
    ]
    return [*(() if in_table else lines), _FORCE] if lines else []
