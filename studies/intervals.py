"""Error bars of an Allan deviation: the paper's eq. (26) and χ² with the exact degrees of freedom, by type of noise."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sigmatau._native import kernels
from sigmatau.noise.terms import avar
from sigmatau.noise.uncertainty import chi2_factors, degrees_of_freedom, percentage_error
from studies.runner import run
from studies.samples import simulated

Floats = NDArray[np.float64]

RECORDS = 4000
N = 4096
SIZES = np.array([4, 40, 204, 409, 819, 1024, 1365, 1843])
TYPES = {"Q": "quantization", "N": "random_walk", "B": "bias_instability", "K": "rate_random_walk"}
PARTS = 4


def cell(seed: int, letter: str) -> list[list[float]]:
    """Allan variances of a part of the records, over their expectation."""
    rng = np.random.default_rng(seed)
    expected = avar(TYPES[letter], 1.0, m=SIZES, tau0=1.0)
    rows = []
    for _ in range(RECORDS // PARTS):
        y = simulated(N, 1.0, {TYPES[letter]: 1.0}, seed=int(rng.integers(1 << 62)))
        variances, _, _ = kernels.allan_variances(
            [y], SIZES, overlap="full", counting="standard", threads=1, names=["x"]
        )
        rows.append((variances[0] / expected).tolist())
    return rows


def main() -> None:
    """Run the study and write docs/study/intervals.md."""
    cells = {f"{letter} {k}": (cell, (letter,)) for letter in TYPES for k in range(PARTS)}
    results = run("intervals", cells, settings=repr((RECORDS, N, SIZES.tolist())))
    delta = percentage_error(N, SIZES)
    lines = [
        _HEAD.format(records=RECORDS, n=N),
        "| T over the record | " + " | ".join(f"{m / N:.3g}" for m in SIZES) + " |",
    ]
    lines += ["|---" * (len(SIZES) + 1) + "|", _row("eq. (26) [%]", 100 * delta)]
    failures = []
    for letter, term in TYPES.items():
        ratio = np.sqrt(np.array([row for k in range(PARTS) for row in results[f"{letter} {k}"]]))
        edf = degrees_of_freedom({term: 1.0}, n=N, m=SIZES, tau0=1.0)
        low, high = chi2_factors(edf)
        chi2 = np.mean((ratio * low <= 1) & (ratio * high >= 1), axis=0)
        lines += [
            _row(f"{letter}: sd over eq. (26)", ratio.std(axis=0) / delta, digits=2),
            _row(f"{letter}: eq. (26) ±1 covers [%]", 100 * _covers(ratio, delta, 1.0)),
            _row(f"{letter}: eq. (26) ±1.96 covers [%]", 100 * _covers(ratio, delta, 1.96)),
            _row(f"{letter}: exact degrees of freedom", edf, digits=3),
            _row(f"{letter}: χ² covers [%], of 95", 100 * chi2),
            _row(f"{letter}: median bias of σ [%]", 100 * (np.median(ratio, axis=0) - 1)),
        ]
        error = math.sqrt(0.95 * 0.05 / RECORDS)
        failures += [
            f"- {letter} at {m}: χ² covers {100 * c:.1f} %"
            for m, c in zip(SIZES, chi2, strict=True)
            if not 0.935 - 3 * error <= c <= 0.985 + 3 * error
        ]
    lines += ["", "## Gates", "", "χ² with the exact degrees of freedom covers 93.5 to 98.5 %.", ""]
    lines += failures or ["All gates are met."]
    Path("docs/study/intervals.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


def _covers(ratio: Floats, delta: Floats, times: float) -> Floats:
    inside = (ratio * (1 - times * delta) <= 1) & (ratio * (1 + times * delta) >= 1)
    return np.asarray(inside.mean(axis=0))


def _row(name: str, values: Floats, *, digits: int | None = None) -> str:
    texts = (f"{v:.1f}" if digits is None else f"{v:.{digits}g}" if v < 1000 else f"{v:.0f}" for v in values)
    return f"| {name} | " + " | ".join(texts) + " |"


_HEAD = """# Error bars of an Allan deviation

Made by `make study` (studies/intervals.py): {records} simulated records of {n} samples for each type of noise; the seeds
are derived from the names of the cells. All deviations are overlapped. The rows give the true standard deviation of the
deviation, divided by eq. (26) of the paper; the coverage of the intervals by eq. (26), which would be 68.3 and 95 % for
exact intervals; and the coverage of the intervals by χ² with the exact equivalent degrees of freedom, which sigmatau
prints and draws."""

if __name__ == "__main__":
    main()
