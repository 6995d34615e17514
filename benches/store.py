"""Time of a store: adding 5000 units × 7 days × 6 axes × 5 terms, and computing their repeatability.

``python -m benches.store`` makes the results in a temporary folder (1.7 GB for 35 000 files) and prints the times, on
SQLite and, if PostgreSQL is installed, on a separate server. ``--memory`` adds results from memory in one process.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from benches.comparison import DAYS, results, write

ROOT = Path(__file__).parent.parent


def main() -> None:
    """Make the results, add them, and compare them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--units", type=int, default=5000)
    parser.add_argument("--folder", type=Path, help="where the results are made, and kept")
    parser.add_argument("--memory", action="store_true")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary, contextlib.ExitStack() as stack:
        folder = arguments.folder or Path(temporary)
        files = folder / "json"
        if not arguments.memory and not files.exists():
            files.mkdir(parents=True)
            write(files, "json", arguments.units)
        places = {"SQLite": str(Path(temporary) / "lab.db")}
        if url := stack.enter_context(_postgresql()):
            places["PostgreSQL"] = url + "postgres"
        for name, place in places.items():
            add = ("store", "add", str(files), "--store", place, "-q")
            added = _memory(place, arguments.units) if arguments.memory else _command(*add)
            again = "" if arguments.memory else f", the same again in {_command(*add)}"
            print(
                f"{name}: {arguments.units * DAYS} runs added in {added}{again}; load {os.getloadavg()[0]:.1f}",
                flush=True,
            )
            if arguments.memory:  # results with the same numbers, which count as copies of a log
                continue
            compared = ", ".join(_repeatability(place) for _ in range(3))
            print(f"{name}: repeatability {compared}; as a command {_command('compare', '--store', place)}", flush=True)


def _command(*words: str) -> str:
    """Measure the wall time, and the CPU time of all processes of the command, the only meaningful time on a busy
    machine. [s]
    """
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run([sys.executable, "-m", "sigmatau", *words], check=True, stdout=subprocess.DEVNULL)
    seconds, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return f"{seconds:.1f} s (CPU {cpu:.1f} s)"


def _repeatability(place: str) -> str:
    """Time of query and statistics, without the start of the program: wall and CPU. [s]"""
    from sigmatau.lab.store.store import Store

    with Store(place) as store:
        start, cpu = time.perf_counter(), time.process_time()
        store.compare()
        return f"{time.perf_counter() - start:.2f} s (CPU {time.process_time() - cpu:.2f} s)"


def _memory(place: str, units: int) -> str:
    """Add results of `analyze` in one process, without the time to make them."""
    import copy

    from sigmatau.analysis.forms import BriefResultForm
    from sigmatau.analysis.reading import result_of_dict
    from sigmatau.lab.store.rows import Entry
    from sigmatau.lab.store.store import Store

    made = results()
    spent, count = 0.0, 0
    with Store(place) as store:
        while count < units * DAYS:
            batch: list[Entry] = []
            for k in range(count, min(count + 1000, units * DAYS)):
                result: dict[str, Any] = copy.copy(made[k % len(made)])
                result["source"] = {**result["source"], "path": f"{k // DAYS}/{k % DAYS}.csv", "sha256": f"{k:064x}"}
                batch.append(
                    Entry(
                        result=result_of_dict(result, as_form=BriefResultForm),
                        content=result,
                        unit=f"unit{k // DAYS:05}",
                    )
                )
            start = time.perf_counter()
            store.add(batch)
            spent += time.perf_counter() - start
            count += len(batch)
    return f"{spent:.1f} s"


@contextlib.contextmanager
def _postgresql() -> Iterator[str]:
    """The server of the tests; None if PostgreSQL is not installed."""
    sys.path.insert(0, str(ROOT / "tests"))
    from lab.store.postgresql import programs, server  # type: ignore[import-not-found]

    if programs() is None:
        yield ""
        return
    with server() as url:
        yield url


if __name__ == "__main__":
    main()
