"""Taking turns, so that whatever else the machine does falls on all parties, and what the page says of the machine."""

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
    """How much is measured.

    Attributes
    ----------
    rounds : int
        Of what is quick; what takes a peer seconds has fewer.
    scale : float
        Of the numbers of samples; 1 but for tests.
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
        """So many samples, scaled; at least 1000."""
        return max(1000, round(n * self.scale))


def turns(
    calls: Mapping[str, Callable[[], Any]], rounds: int, *, fewer: Mapping[str, int] | None = None
) -> dict[str, float]:
    """Median wall time of each call, one after the other in every round. [s]

    `fewer` limits the rounds of some calls; they take part in the first ones.
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
    found = re.search(rf"^{field}:\s*(\d+) kB", text, flags=re.MULTILINE)
    if found is None:
        raise RuntimeError(f"the system does not say {field}")
    return 1024 * int(found.group(1))


def machine() -> dict[str, str]:
    """Processor, cores, system and versions; nothing that names the machine."""
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8")
        models = re.findall(r"^model name\s*:\s*(.*)$", text, flags=re.MULTILINE)
    except OSError:
        models = []
    rustc = subprocess.run(["rustc", "--version"], capture_output=True, text=True, check=False)
    found = {
        "processor": models[0] if models else platform.machine(),
        "cores": str(os.cpu_count()),
        "system": f"{platform.system()} {re.sub(r'[^0-9.].*', '', platform.release())}",
        "Python": platform.python_version(),
        "rustc": rustc.stdout.split()[1] if rustc.returncode == 0 else "unknown",
    }
    for package in PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = "absent"
    return found


def load() -> str:
    """Mean number of running processes over the last minute."""
    return f"{os.getloadavg()[0]:.1f}"
