"""Available memory, and whether the curves of a stream fit into it."""

from __future__ import annotations

import os
from pathlib import Path

from sigmatau.record.streams import Stream

__all__ = ["available", "fits", "needed"]

_USABLE_SHARE = 0.8
"""Share of the free memory that may be used."""


def available() -> int | None:
    """Memory available without swapping; None if the system does not report it. [bytes]"""
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
    """Memory left by the control group of a container; a very large number without a limit. [bytes]"""
    try:
        group = Path("/sys/fs/cgroup")
        most = (group / "memory.max").read_text(encoding="ascii").strip()
        if most != "max":
            return [max(int(most) - int((group / "memory.current").read_text(encoding="ascii")), 0)]
    except (OSError, ValueError):
        pass
    return [1 << 62]


def needed(stream: Stream, threads: int | None) -> int:
    """Memory for the exact curves of a stream besides its raw samples: rates in SI, and one phase per thread. [bytes]"""
    channels = len(stream.channels)
    workers = min(channels, threads or os.cpu_count() or 1)
    return 8 * stream.grid.n * (channels + workers)


def fits(stream: Stream, threads: int | None) -> bool:
    """Whether the exact curves of a stream can be computed in memory."""
    free = available()
    return free is None or needed(stream, threads) <= _USABLE_SHARE * free
