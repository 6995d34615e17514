"""Rates logged with steps close to their noise: coverage of the intervals, which allow for rounding.

``python -m studies.coarse`` writes docs/study/coarse.md.
"""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from sigmatau import Record
from sigmatau.fitting.adjust import adjusted
from sigmatau.fitting.channel import fit_channel
from sigmatau.fitting.fitted_values import FittedTerm
from sigmatau.fitting.rounding import rounding_adjustment
from sigmatau.quality.samples.resolution import resolution
from studies.runner import run
from studies.samples import simulated

RECORDS, N, TAU0 = 60, 2**16, 0.01
RATIOS = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0, 3.0)
WHITE = 0.1  # standard deviation 1 of a sample
MIXTURES: dict[str, dict[str, float]] = {
    "N": {},
    "N B": {"bias_instability": 0.05},
    "N K": {"rate_random_walk": 0.02},
}
LETTERS = {"random_walk": "N", "bias_instability": "B", "rate_random_walk": "K"}


def rows(seed: int, mixture: str, ratio: float) -> list[dict[str, Any]]:
    """Intervals of some records with noise of `ratio` steps and a random mean; a constant record has none."""
    rng = np.random.default_rng(seed)
    step = WHITE / math.sqrt(TAU0) / ratio
    results = []
    for _ in range(RECORDS):
        terms = {"random_walk": WHITE, **MIXTURES[mixture]}
        y = simulated(N, TAU0, terms, seed=int(rng.integers(1 << 62))) + rng.uniform(0, step)
        record = Record.from_arrays(rate=1 / TAU0, gyro_x=np.round(y / step) * step)
        steps = resolution(record.streams[0], "gyro_x")
        if steps is None:
            continue
        plain = fit_channel(record, "gyro_x")
        wide = adjusted(plain, partial(rounding_adjustment, step=steps.step, noise=steps.noise))
        results.append(
            {
                "seen": steps.ratio,
                "walk": plain.model.get("random_walk", 0.0),
                "plain": {name: _ends(plain.terms[name]) for name in LETTERS},
                "wide": {name: _ends(wide.terms[name]) for name in LETTERS},
            }
        )
    return results


def _ends(term: FittedTerm) -> list[float | None]:
    return [term.low or 0.0, term.high if term.high is not None else term.upper_limit]


def _holds(ends: list[float | None], value: float) -> bool:
    low, high = ends
    return bool((low or 0.0) <= value and (high is None or value <= high))


def main() -> None:
    """Run the study and write docs/study/coarse.md."""
    cells = {f"coarse {name} {ratio}": (rows, (name, ratio)) for name in MIXTURES for ratio in RATIOS}
    results = run("coarse", cells, settings=repr((RECORDS, N, TAU0, MIXTURES)))
    lines = [_HEAD.format(n=N, records=RECORDS)]
    failures = []
    for name, terms in MIXTURES.items():
        for ratio in RATIOS:
            cell = results[f"coarse {name} {ratio}"]
            if not cell:
                continue
            # The random walk of the log, for any mean; rounding adds a twelfth of the square of a step.
            truth = {**terms, "random_walk": WHITE * math.sqrt(1 + 1 / (12 * ratio**2))}
            text = f"| {name} | {ratio} | {len(cell)}"
            text += f" | {min(r['seen'] for r in cell):.2f} … {max(r['seen'] for r in cell):.2f}"
            text += f" | {np.median([r['walk'] for r in cell]) / truth['random_walk']:.3f}"
            for term, letter in LETTERS.items():
                value = truth.get(term, 0.0)
                shares = [np.mean([_holds(r[kind][term], value) for r in cell]) for kind in ("plain", "wide")]
                text += f" | {100 * shares[0]:.0f} | {100 * shares[1]:.0f}"
                highs = [r["wide"][term][1] for r in cell if r["wide"][term][1] is not None]
                text += f" | {np.median(highs) / value:.2g}" if value else " | "
                if shares[1] < 0.92 - 3 * math.sqrt(0.92 * 0.08 / len(cell)):
                    failures.append(f"- {name}, {ratio} steps, {letter}: {100 * shares[1]:.0f} % covered")
            lines.append(text + " |")
    lines += ["", "Gate: 92 % covered in each row, with 3 standard errors.", "", *(failures or ["It is met."])]
    Path("docs/study/coarse.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


_HEAD = """# Noise near the step of the log

Made by `make study` (studies/coarse.py). White noise of a standard deviation of 1 with N = 0.1, alone, with B = 0.05 or with
K = 0.02; {n} samples at 100 Hz, {records} records a row. The samples are rounded to steps; the mean lies anywhere between
two. "Noise" is the standard deviation of the white noise in steps, before rounding; "seen" what the log shows. Records that
are constant after rounding are left out. True N is that of the log on average over the mean: the square root of
σ² + step²/12 a sample. "Plain": share of the intervals that contain the true value without an allowance for rounding;
"with": with it; "high": median upper end over the true value.

| mixture | noise | records | seen | N found | N plain | with | high | B plain | with | high | K plain | with | high |
|---|---|---|---|---|---|---|---|---|---|---|---|---|---|"""

if __name__ == "__main__":
    main()
