"""Speed, in one process: ``make bench``.

Beside allantools: rates in memory to the overlapped Allan deviation on octaves. The two take turns, so that whatever else
the machine does falls on both; the median of each and the ratio are printed. First of all the two must agree.

Then the fit, which has no peer: the covariance tensors of a record of 2^20 samples on half octaves, and with them the fits
of six axes of a MEMS unit, with tests, intervals and limits of every term.
"""

from __future__ import annotations

import argparse
import platform
import statistics
import time
from functools import partial

import allantools
import numpy as np

from sigmatau import NoiseModel, Record, allan, fit, simulate
from sigmatau.fitting.components import components


def ours(rate: np.ndarray, sizes: list[int], threads: int) -> np.ndarray:
    return allan(Record.from_arrays(rate=1.0, y=rate), taus=sizes, threads=threads)["y"].adev


def theirs(rate: np.ndarray, sizes: list[int]) -> np.ndarray:
    return allantools.oadev(rate, rate=1.0, data_type="freq", taus=sizes)[1]


def fits(rounds: int) -> None:
    """Γ of N = 2^20 on half octaves, then six fits with it, in a process that is warm."""
    degree = np.pi / 180
    noise = {"random_walk": 5e-3 * degree, "bias_instability": 2.8e-3 * degree, "rate_random_walk": 1e-4 * degree}
    model = NoiseModel(channels={f"{s}_{a}": noise for s in ("gyro", "accel") for a in "xyz"})
    curves = allan(simulate(model, duration=2**20 / 100, rate=100, rng=1))
    for curve in curves.values():
        fit(curve)
    tensors, six = [], []
    for _ in range(rounds):
        components.cache_clear()
        start = time.perf_counter()
        components(2**20, tuple(int(m) for m in curves["gyro_x"].m if m <= 2**20 // 3))
        tensors.append(time.perf_counter() - start)
        for curve in curves.values():
            fit(curve)  # brings back what the limits need
        start = time.perf_counter()
        for curve in curves.values():
            fit(curve)
        six.append(time.perf_counter() - start)
    print(f"\n{'covariance tensors, 2^20 samples, half octaves':<50} {1e3 * statistics.median(tensors):>7.1f} ms")
    print(f"{'six fits with tests, intervals, limits':<50} {1e3 * statistics.median(six):>7.1f} ms")


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
    fits(arguments.rounds)


if __name__ == "__main__":
    main()
