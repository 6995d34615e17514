"""Measurement in turns, so that other load affects all parties, and description of the machine."""

from __future__ import annotations

import os
import platform
import re
import statistics
import subprocess
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

PACKAGES = ("sigmatau", "numpy", "scipy", "allantools", "allan-variance", "numba", "pandas")


@dataclass(frozen=True, kw_only=True)
class Settings:
    """Extent of the measurement.

    Attributes
    ----------
    rounds : int
        Number of rounds of fast work; work that takes a peer seconds has fewer.
    scale : float
        Factor on the numbers of samples; 1 except in tests.
    billion : bool
        Push 10⁹ samples as well.
    """

    rounds: int
    scale: float = 1.0
    billion: bool = False

    @property
    def is_trial(self) -> bool:
        """Whether the run only shows that everything works: what is repeated to be measured is done once."""
        return self.scale < 1

    def samples(self, n: float) -> int:
        """Scale a number of samples; at least 1000."""
        return max(1000, round(n * self.scale))


def turns(
    calls: Mapping[str, Callable[[], Any]], rounds: int, *, fewer: Mapping[str, int] | None = None
) -> dict[str, float]:
    """Median wall time of each call, one after the other in every round. [s]

    `fewer` limits some calls to the first rounds.
    """
    times: dict[str, list[float]] = {name: [] for name in calls}
    for k in range(rounds):
        for name, call in calls.items():
            if k < (fewer or {}).get(name, rounds):
                start = time.perf_counter()
                call()
                times[name].append(time.perf_counter() - start)
    return {name: statistics.median(seconds) for name, seconds in times.items()}


def status_bytes(field: str) -> int:
    """A size from /proc/self/status, such as ``VmHWM``."""
    text = Path("/proc/self/status").read_text(encoding="ascii")
    match = re.search(rf"^{field}:\s*(\d+) kB", text, flags=re.MULTILINE)
    if match is None:
        raise RuntimeError(f"the system does not say {field}")
    return 1024 * int(match.group(1))


def machine() -> dict[str, str]:
    """Processor, cores, system and versions, without the name of the machine."""
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8")
        models = re.findall(r"^model name\s*:\s*(.*)$", text, flags=re.MULTILINE)
    except OSError:
        models = []
    rustc = subprocess.run(["rustc", "--version"], capture_output=True, text=True, check=False)
    facts = {
        "processor": models[0] if models else platform.machine(),
        "cores": str(os.cpu_count()),
        "system": f"{platform.system()} {re.sub(r'[^0-9.].*', '', platform.release())}",
        "Python": platform.python_version(),
        "rustc": rustc.stdout.split()[1] if rustc.returncode == 0 else "unknown",
    }
    for package in PACKAGES:
        try:
            facts[package] = version(package)
        except PackageNotFoundError:
            facts[package] = "absent"
    return facts


def load() -> str:
    """Mean number of running processes over the last minute."""
    return f"{os.getloadavg()[0]:.1f}"
