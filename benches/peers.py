"""Comparison with other packages: overlapped Allan deviation of rates in memory.

Every party gets the same samples and averaging times. Before the measurement, the results must agree to 10⁻⁹.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import allan_variance
import allantools
import numba
import numpy as np
from numpy.typing import NDArray

from benches import text
from benches.measure import Settings, turns
from benches.text import Gate
from sigmatau import Record, allan

RTOL = 1e-9
AIMS = (15, 15, 16, 16)  # smallest speed relative to allantools: two lengths, two grids
AXES = ("gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z")


@dataclass(frozen=True)
class Grid:
    """Cluster sizes from 1 to `largest`, evenly spaced on a logarithmic scale up to rounding."""

    name: str
    largest: int
    count: int

    @property
    def sizes(self) -> NDArray[np.int64]:
        """Unique sizes; the rounding is that of the package allan-variance, which does not accept a list."""
        spaced = np.logspace(0.0, np.log2(self.largest), num=self.count, base=2)
        return np.unique(np.round(spaced)).astype(np.int64)


def octaves(n: int) -> Grid:
    """Powers of two up to half the record."""
    largest = (n // 2).bit_length() - 1
    return Grid("octaves", 2**largest, largest + 1)


def log_spaced(n: int, count: int = 100) -> Grid:
    """Sizes up to half the record, without those for which a peer has no term."""
    return Grid(f"{count} log-spaced", n // 2 - 1, count)


def noise(n: int, axis: int = 0) -> NDArray[np.float64]:
    """White noise with mean 1."""
    return np.random.default_rng((n, axis)).standard_normal(n) + 1.0


def ours(rate: NDArray[np.float64], grid: Grid, *, threads: int = 1) -> NDArray[np.float64]:
    """Allan deviation by this package."""
    return allan(Record.from_arrays(rate=1.0, y=rate), taus=grid.sizes, threads=threads)["y"].adev


def by_allantools(rate: NDArray[np.float64], grid: Grid) -> NDArray[np.float64]:
    """Allan deviation by allantools."""
    adev: NDArray[np.float64] = allantools.oadev(rate, rate=1.0, data_type="freq", taus=grid.sizes)[1]
    return adev


def by_allan_variance(rate: NDArray[np.float64], grid: Grid) -> NDArray[np.float64]:
    """Allan deviation by allan-variance, which omits the term of the first phase point."""
    avar = allan_variance.compute_avar(rate, tau_min=1, tau_max=grid.largest, n_clusters=grid.count)[1]
    return np.asarray(np.sqrt(avar), dtype=np.float64)


def by_numba(rate: NDArray[np.float64], grid: Grid) -> NDArray[np.float64]:
    """Allan deviation by a plain, compiled loop."""
    return np.asarray(np.sqrt(_loop(rate, grid.sizes)), dtype=np.float64)


@numba.njit  # type: ignore[untyped-decorator]
def _loop(rate: Any, sizes: Any) -> Any:
    n = rate.size
    phase = np.empty(n + 1)
    phase[0] = 0.0
    for i in range(n):
        phase[i + 1] = phase[i] + rate[i]
    variances = np.empty(sizes.size)
    for j in range(sizes.size):
        m = sizes[j]
        total = 0.0
        for k in range(n + 1 - 2 * m):
            difference = phase[k + 2 * m] - 2.0 * phase[k + m] + phase[k]
            total += difference * difference
        variances[j] = total / (2.0 * m * m * (n + 1 - 2 * m))
    return variances


PEERS: dict[str, Callable[[NDArray[np.float64], Grid], NDArray[np.float64]]] = {
    "allantools": by_allantools,
    "allan-variance": by_allan_variance,
    "numba": by_numba,
}


def check(rate: NDArray[np.float64], grid: Grid) -> None:
    """Raise AssertionError unless all results agree."""
    ours_ = ours(rate, grid)
    for name in ("allantools", "numba"):
        np.testing.assert_allclose(ours_, PEERS[name](rate, grid), rtol=RTOL, err_msg=name)
    # In a reversed record the omitted term is the last one, as in the paper.
    record = Record.from_arrays(rate=1.0, y=rate[::-1])
    paper = allan(record, taus=grid.sizes, counting="paper", threads=1)["y"].adev
    np.testing.assert_allclose(paper, by_allan_variance(rate, grid), rtol=RTOL, err_msg="allan-variance")


def measure(settings: Settings) -> dict[str, Any]:
    """Measure one axis, six axes, and every averaging time."""
    single_axis = []
    for samples, rounds, fewer in ((1.44e6, settings.rounds, settings.rounds), (1e7, 5, 3)):
        n = settings.samples(samples)
        rate = noise(n)
        for grid in (octaves(n), log_spaced(n)):
            check(rate, grid)
            calls = {name: _call(call, rate, grid) for name, call in PEERS.items()} | {"ours": _call(ours, rate, grid)}
            slow = fewer if grid.name == "octaves" else min(fewer, 5)
            medians = turns(calls, min(rounds, settings.rounds), fewer=dict.fromkeys(PEERS, slow))
            single_axis.append({"samples": n, "grid": grid.name, "taus": len(grid.sizes), "seconds": medians})
    return {"one": single_axis, "six": _six(settings), "all": _every(settings)}


def _call(call: Callable[..., Any], *arguments: Any, **named: Any) -> Callable[[], Any]:
    return lambda: call(*arguments, **named)


def _six(settings: Settings) -> list[dict[str, Any]]:
    n = settings.samples(1.44e6)
    rates: dict[str, Any] = {axis: noise(n, k) for k, axis in enumerate(AXES)}
    rows = []
    for grid in (octaves(n), log_spaced(n)):

        def six(sizes: NDArray[np.int64] = grid.sizes) -> dict[str, NDArray[np.float64]]:
            curves = allan(Record.from_arrays(rate=1.0, **rates), taus=sizes, threads=2)
            return {axis: curve.adev for axis, curve in curves.items()}

        def theirs(grid: Grid = grid) -> dict[str, NDArray[np.float64]]:
            return {axis: by_allantools(rate, grid) for axis, rate in rates.items()}

        our_curves, their_curves = six(), theirs()
        for axis in AXES:
            np.testing.assert_allclose(our_curves[axis], their_curves[axis], rtol=RTOL, err_msg=axis)
        medians = turns({"allantools": theirs, "ours": six}, settings.rounds, fewer={"allantools": 5})
        rows.append({"samples": n, "grid": grid.name, "taus": len(grid.sizes), "seconds": medians})
    return rows


def _every(settings: Settings) -> list[dict[str, Any]]:
    rows = []
    for samples, with_peers in ((1e5, True), (1e6, False)):
        n = settings.samples(samples)
        rate = noise(n)
        record = Record.from_arrays(rate=1.0, y=rate)
        calls: dict[str, Callable[[], Any]] = {}
        if with_peers:
            calls["allantools"] = _call(allantools.oadev, rate, rate=1.0, data_type="freq", taus="all")
            taus, adev = calls["allantools"]()[:2]
            ours_ = allan(record, taus="all", threads=1)["y"]
            np.testing.assert_allclose(ours_.adev[taus.astype(int) - 1], adev, rtol=RTOL)
        for threads in (1, 2):
            calls[f"ours{threads}"] = _call(allan, record, taus="all", threads=threads)
        rows.append({"samples": n, "seconds": turns(calls, settings.rounds, fewer={"allantools": 3})})
    return rows


def write(measured: dict[str, Any]) -> tuple[list[str], list[Gate]]:
    """Text of the section of the page, and its targets."""
    lines = [
        "## One axis, one thread",
        "",
        "Time from rates in memory to deviations. Ratios are the time of the other program divided by that of sigmatau."
        " `make bench PARTS=peers`.",
        "",
    ]
    rows, reached = [], []
    for row, aim in zip(measured["one"], AIMS, strict=True):
        s = row["seconds"]
        peers = [f"**{text.times(s[p] / s['ours'])}** ({text.seconds(s[p])})" for p in PEERS]
        rows.append([text.number(row["samples"]), f"{row['grid']} ({row['taus']})", text.seconds(s["ours"]), *peers])
        label = f"allantools, {text.number(row['samples'])} samples, {row['grid']}"
        reached.append(text.at_least(label, s["allantools"] / s["ours"], aim))
    lines += text.table(["samples", "averaging times", "sigmatau", *PEERS], rows)
    lines += ["numba: a simple compiled loop over averaging times, without reordered sums.", ""]
    lines += text.gates(reached)

    rows, six = [], []
    for row in measured["six"]:
        s = row["seconds"]
        ratio = s["allantools"] / s["ours"]
        grid = f"{row['grid']} ({row['taus']})"
        rows.append(
            [
                text.number(row["samples"]),
                grid,
                f"**{text.times(ratio)}**",
                text.seconds(s["ours"]),
                text.seconds(s["allantools"]),
            ]
        )
        six.append(text.at_least(f"six axes, two threads, {row['grid']}", ratio, 28))
    lines += [
        "## Six axes, two threads",
        "",
        "allantools processes the axes one after the other. `make bench PARTS=peers`.",
        "",
    ]
    lines += text.table(["samples", "averaging times", "ratio", "sigmatau", "allantools"], rows)
    lines += text.gates(six)

    rows = []
    for row in measured["all"]:
        s = row["seconds"]
        peer = s.get("allantools")
        ratio = f"**{text.times(peer / s['ours1'])}**" if peer else ""
        cells = [text.seconds(s["ours1"]), text.seconds(s["ours2"]), text.seconds(peer) if peer else "not run"]
        rows.append([text.number(row["samples"]), ratio, *cells])
    short, long = (row["seconds"] for row in measured["all"])
    every = [
        text.at_least("every averaging time, one thread", short["allantools"] / short["ours1"], 80),
        text.at_most("every averaging time of the longer record, one thread", long["ours1"], 0.8, "s"),
    ]
    lines += [
        "## Every averaging time",
        "",
        'All whole numbers of samples up to half the record: `taus="all"`. `make bench PARTS=peers`.',
        "",
    ]
    lines += text.table(["samples", "ratio", "sigmatau, one thread", "two threads", "allantools"], rows)
    lines += text.gates(every)
    return lines, [*reached, *six, *every]
