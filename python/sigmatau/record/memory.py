"""How much memory there is, and whether the curves of a stream fit into it."""

from __future__ import annotations

import os
from pathlib import Path

from sigmatau.record.streams import Stream

__all__ = ["available", "fits", "needed"]

_SHARE = 0.8
"""Of the memory that is free: the rest is for everybody else."""


def available() -> int | None:
    """Bytes that can be had without swapping; None if the system does not say."""
    try:
        for line in Path("/proc/meminfo").read_text(encoding="ascii").splitlines():
            if line.startswith("MemAvailable:"):
                return min(int(line.split()[1]) * 1024, *_limits())
    except (OSError, ValueError, IndexError):
        pass
    try:
        return os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, OSError, ValueError):
        return None


def _limits() -> list[int]:
    """What the control group leaves, as in a container; a number beyond all memory if there is no limit."""
    try:
        group = Path("/sys/fs/cgroup")
        most = (group / "memory.max").read_text(encoding="ascii").strip()
        if most != "max":
            return [max(int(most) - int((group / "memory.current").read_text(encoding="ascii")), 0)]
    except (OSError, ValueError):
        pass
    return [1 << 62]


def needed(stream: Stream, threads: int | None) -> int:
    """Bytes that the exact curves of a stream take beside its raw samples: rates in SI, and a phase for each thread."""
    channels = len(stream.channels)
    workers = min(channels, threads or os.cpu_count() or 1)
    return 8 * stream.grid.n * (channels + workers)


def fits(stream: Stream, threads: int | None) -> bool:
    """Whether the exact curves of a stream can be computed in memory."""
    free = available()
    return free is None or needed(stream, threads) <= _SHARE * free
