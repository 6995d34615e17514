"""How a process that analyses many records uses memory."""

from __future__ import annotations

import ctypes
import gc

# Options of mallopt(3) of glibc.
_TRIM_THRESHOLD, _MMAP_THRESHOLD, _ARENA_MAX = -1, -3, -8
_LARGEST_MMAP_THRESHOLD = 32 << 20  # that glibc takes [bytes]


def keep_freed() -> None:
    """Use freed memory again, with glibc: the system clears each page that it gives, which took a fifth of the time.

    Collections of cycles are rare too, because an analysis keeps most objects that it makes: they took 4 % of its time.
    """
    gc.set_threshold(100_000)
    try:
        mallopt = ctypes.CDLL(None).mallopt
    except (OSError, AttributeError, TypeError):  # another library, or another system
        return
    mallopt(_MMAP_THRESHOLD, _LARGEST_MMAP_THRESHOLD)
    mallopt(_TRIM_THRESHOLD, (1 << 31) - 1)
    mallopt(_ARENA_MAX, 1)
