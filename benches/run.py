"""Speed beside allantools, in one process: ``make bench``.

Rates in memory to the overlapped Allan deviation on octaves. The two take turns, so that whatever else the machine does
falls on both; the median of each and the ratio are printed. First of all the two must agree.
"""

from __future__ import annotations

import argparse
import platform
import statistics
import time
from functools import partial

import allantools
import numpy as np

from sigmatau import Record, allan


def ours(rate: np.ndarray, sizes: list[int], threads: int) -> np.ndarray:
    return allan(Record.from_arrays(rate=1.0, y=rate), taus=sizes, threads=threads)["y"].adev


def theirs(rate: np.ndarray, sizes: list[int]) -> np.ndarray:
    return allantools.oadev(rate, rate=1.0, data_type="freq", taus=sizes)[1]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--samples", type=float, nargs="+", default=[1e5, 1.44e6, 1e7])
    parser.add_argument("--rounds", type=int, default=5)
    arguments = parser.parse_args()
    print(f"{platform.processor() or platform.machine()}, Python {platform.python_version()}, NumPy {np.__version__},")
    print(f"allantools {allantools.__version__}; medians of {arguments.rounds} rounds, one axis, octaves\n")
    print(f"{'samples':>10} {'allantools':>12} {'1 thread':>10} {'ratio':>7} {'2 threads':>10} {'ratio':>7}")
    for samples in arguments.samples:
        n = int(samples)
        rate = np.random.default_rng(n).standard_normal(n) + 1.0
        sizes = [2**j for j in range(n.bit_length()) if 2**j <= n // 2]
        np.testing.assert_allclose(ours(rate, sizes, 1), theirs(rate, sizes), rtol=1e-9)
        calls = [partial(theirs, rate, sizes), partial(ours, rate, sizes, 1), partial(ours, rate, sizes, 2)]
        times: list[list[float]] = [[], [], []]
        for _ in range(arguments.rounds):
            for call, seconds in zip(calls, times, strict=True):
                start = time.perf_counter()
                call()
                seconds.append(time.perf_counter() - start)
        peer, one, two = (1e3 * statistics.median(seconds) for seconds in times)
        print(f"{n:>10} {peer:>9.1f} ms {one:>7.1f} ms {peer / one:>6.1f}x {two:>7.1f} ms {peer / two:>6.1f}x")


if __name__ == "__main__":
    main()
