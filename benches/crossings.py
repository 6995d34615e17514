"""Calls from one file of the package to another, as a measure of the code that a piece of work runs through.

    python -m benches.crossings

counts the calls in `analyze` of a simulated log of six axes, and in the export of its result to Kalibr. A call counts if
its caller, the nearest function of the package on the stack, is in another file. The counts depend neither on other load
nor on the length of the record; ``tests/test_crossings.py`` checks their limits.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from types import FrameType
from typing import NamedTuple

import sigmatau
from sigmatau.analysis import Analysis
from sigmatau.record.record import Record

_PACKAGE = str(Path(sigmatau.__file__).parent)

ANALYZE_LIMIT = 1784
"""Largest number of crossings of `analyze`: half of the 3472 that were needed when a result was passed on as JSON, and 48
of quantiles that import no masked arrays of NumPy.
"""

KALIBR_LIMIT = 402
"""Largest number of crossings of an export of four numbers. There were 697 when a result was passed on as JSON, and 327
before the reference filter and the state space shared the steps of linear systems. A model is asked for its Matérn
processes once.
"""


class Traced(NamedTuple):
    """Functions and files of the package that a call runs through."""

    files: int
    functions: int
    crossings: int
    calls: int


def trace(work: Callable[[], object]) -> Traced:
    """Count the functions and files that a call runs through, in its thread.

    Parameters
    ----------
    work : callable
        Called once. Its first imports are counted too.

    Returns
    -------
    Traced
    """
    files, functions = set[str](), set[tuple[str, str]]()
    calls = crossings = 0

    def count(frame: FrameType, event: str, _: object) -> None:
        nonlocal calls, crossings
        file = frame.f_code.co_filename
        if event != "call" or not file.startswith(_PACKAGE):
            return
        calls += 1
        files.add(file)
        functions.add((file, frame.f_code.co_qualname))
        caller = frame.f_back
        while caller is not None and not caller.f_code.co_filename.startswith(_PACKAGE):
            caller = caller.f_back
        crossings += caller is not None and caller.f_code.co_filename != file

    sys.setprofile(count)
    try:
        work()
    finally:
        sys.setprofile(None)
    return Traced(len(files), len(functions), crossings, calls)


def simulated() -> Record:
    """Simulate the log: 20 minutes of six axes at 50 Hz, with a random walk and a bias instability."""
    walks = {"gyro": 1e-4, "accel": 1e-3}
    channels = {
        f"{sensor}_{axis}": {"random_walk": walk, "bias_instability": 1e-5}
        for sensor, walk in walks.items()
        for axis in "xyz"
    }
    return sigmatau.simulate(sigmatau.NoiseModel(channels=channels), duration=1200, rate=50, rng=1)


def counted() -> dict[str, Traced]:
    """Trace both pieces of work, each after a first run."""
    record = simulated()
    analysis: Analysis = sigmatau.analyze(record, threads=1)
    analysis.export(to="kalibr")
    return {
        "analyze": trace(lambda: sigmatau.analyze(record, threads=1)),
        "kalibr": trace(lambda: analysis.export(to="kalibr")),
    }


if __name__ == "__main__":
    for name, traced in counted().items():
        print(name, *(f"{count} {kind}" for kind, count in traced._asdict().items()))
