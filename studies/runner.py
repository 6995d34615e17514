"""Execution of a study: named cells with seeds from their names, on all cores; results are stored, so that a stopped
study can continue.
"""

from __future__ import annotations

import hashlib
import json
import os
import sys
import time
from collections.abc import Callable, Mapping
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import Any

CACHE = Path(".study")
WORKERS = int(os.environ.get("STUDY_WORKERS", os.cpu_count() or 1))
"""Number of processes; the environment variable STUDY_WORKERS limits it."""


def seed_of(name: str) -> int:
    """Seed from the name of a case: neither chosen nor changed."""
    return int.from_bytes(hashlib.sha256(name.encode()).digest()[:7], "big")


def run(
    study: str, cells: Mapping[str, tuple[Callable[..., Any], tuple[Any, ...]]], *, settings: str
) -> dict[str, Any]:
    """Compute every cell that is not in the cache and return all by name.

    Parameters
    ----------
    study : str
        Name of the cache.
    cells : mapping
        Name to ``(function, arguments)``; the function is called as ``function(seed, *arguments)`` in a worker process
        and returns something that JSON can hold.
    settings : str
        Further settings on which the results depend, besides the name of a cell and the code; other settings have another
        cache. After a change of the code delete ``.study``.
    """
    CACHE.mkdir(exist_ok=True)
    cache = CACHE / f"{study}-{seed_of(settings):014x}.json"
    done: dict[str, Any] = json.loads(cache.read_text()) if cache.exists() else {}
    remaining = [name for name in cells if name not in done]
    started = time.monotonic()
    with ProcessPoolExecutor(WORKERS) as pool:
        futures = {pool.submit(cells[name][0], seed_of(name), *cells[name][1]): name for name in remaining}
        for k, future in enumerate(as_completed(futures), 1):
            if future.exception() is not None:
                pool.shutdown(cancel_futures=True)
            done[futures[future]] = future.result()
            temporary = cache.with_suffix(".tmp")
            temporary.write_text(json.dumps(done))
            temporary.replace(cache)
            sys.stderr.write(f"\r{study}: {k}/{len(remaining)} cells, {time.monotonic() - started:.0f} s ")
            sys.stderr.flush()
    if remaining:
        sys.stderr.write("\n")
    return {name: done[name] for name in cells}
