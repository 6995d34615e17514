"""Worker processes: their memory, their signals, and their end with the parent."""

from __future__ import annotations

import contextlib
import ctypes
import gc
import os
import signal
import threading
from collections.abc import Callable, Iterator

# Options of mallopt(3) of glibc.
_TRIM_THRESHOLD, _MMAP_THRESHOLD, _ARENA_MAX = -1, -3, -8
_LARGEST_MMAP_THRESHOLD = 32 << 20  # largest value that glibc accepts [bytes]


def keep_freed() -> None:
    """Reuse freed memory, with glibc: the system clears each page that it provides, which took a fifth of the time.

    Garbage is also collected less often: an analysis keeps most of its objects, and collections took 4 % of its time.
    """
    gc.set_threshold(100_000)
    mallopt = _from_libc("mallopt")
    if mallopt is None:
        return
    mallopt(_MMAP_THRESHOLD, _LARGEST_MMAP_THRESHOLD)
    mallopt(_TRIM_THRESHOLD, (1 << 31) - 1)
    mallopt(_ARENA_MAX, 1)


def return_freed() -> None:
    """Collect cycles and return freed memory to the system, which a process that only waits does not need."""
    gc.collect()
    trim()


def trim() -> None:
    """Return freed memory to the system, with glibc."""
    malloc_trim = _from_libc("malloc_trim")
    if malloc_trim is not None:
        malloc_trim(0)


def _from_libc(name: str) -> Callable[..., int] | None:
    """A function of glibc; None with another library, or on another system."""
    try:
        function: Callable[..., int] = getattr(ctypes.CDLL(None), name)
    except (OSError, AttributeError, TypeError):
        return None
    return function


@contextlib.contextmanager
def uninterrupted() -> Iterator[None]:
    """Block Ctrl-C until the end of the block: processes that receive it while they start print tracebacks.

    Processes started in the block begin with the signal blocked, also those started later by its threads.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    from multiprocessing import resource_tracker

    resource_tracker.ensure_running()  # it enables signals when it starts, so it must not start in the block
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def end_with_parent() -> None:
    """End this process when its parent is killed; otherwise it would wait for work for ever."""
    from multiprocessing import connection, parent_process

    parent = parent_process()
    if parent is None:
        return

    def wait() -> None:
        connection.wait([parent.sentinel])
        os._exit(1)

    threading.Thread(target=wait, daemon=True).start()
