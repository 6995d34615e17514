"""Available memory, and whether the curves of a stream fit into it."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path

from sigmatau.record.streams import Stream

_USABLE_SHARE = 0.8
"""Share of the free memory that may be used."""


def available() -> int | None:
    """Memory available without swapping, within the limits of the process and of its control groups; None if the system
    does not report it. [bytes]
    """
    free = _free()
    limits = [*_process_limits(), *_group_limits(), *([] if free is None else [free])]
    return min(limits, default=None)


def _free() -> int | None:
    with contextlib.suppress(OSError, ValueError, IndexError):
        for line in Path("/proc/meminfo").read_text(encoding="ascii").splitlines():
            if line.startswith("MemAvailable:"):
                return int(line.split()[1]) * 1024
    with contextlib.suppress(AttributeError, OSError, ValueError):
        return os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    return None


def _process_limits() -> Iterator[int]:
    """Memory left by the process's own limits (``ulimit -v``, ``ulimit -d``). [bytes]"""
    with contextlib.suppress(ImportError, OSError, ValueError, IndexError):
        import resource

        pages = [int(word) for word in Path("/proc/self/statm").read_text(encoding="ascii").split()]
        for limit, used in ((resource.RLIMIT_AS, pages[0]), (resource.RLIMIT_DATA, pages[5])):
            largest = resource.getrlimit(limit)[0]
            if largest != resource.RLIM_INFINITY:
                yield max(largest - used * resource.getpagesize(), 0)


def _group_limits() -> Iterator[int]:
    """Memory left by the control groups of the process; the page cache counts as free. [bytes]"""
    root = Path("/sys/fs/cgroup")
    process_group = Path()
    with contextlib.suppress(OSError, ValueError):
        process_group = Path(
            Path("/proc/self/cgroup").read_text(encoding="utf-8").strip().rpartition(":")[2].lstrip("/")
        )
    for group in (process_group, *process_group.parents):
        with contextlib.suppress(OSError, ValueError):
            largest = (root / group / "memory.max").read_text(encoding="ascii").strip()
            if largest != "max":
                used = int((root / group / "memory.current").read_text(encoding="ascii"))
                stat = dict(line.split() for line in (root / group / "memory.stat").read_text("ascii").splitlines())
                yield max(int(largest) - used + int(stat.get("inactive_file", 0)), 0)


def needed(stream: Stream, threads: int | None) -> int:
    """Memory for the exact curves of a stream besides its raw samples: rates in SI, and one phase per thread. [bytes]"""
    channels = len(stream.channels)
    workers = min(channels, threads or os.cpu_count() or 1)
    return 8 * stream.grid.n * (channels + workers)


def fits(stream: Stream, threads: int | None) -> bool:
    """Whether the exact curves of a stream can be computed in memory."""
    free = available()
    return free is None or needed(stream, threads) <= _USABLE_SHARE * free
