"""Fits of a Matérn process: bias, coverage of the intervals, and the test of the Gauss-Markov process."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import sigmatau as st
from sigmatau.units import to_si
from studies.runner import run

RECORDS = 100
TEST_RECORDS = 400  # of each cell with a Gauss-Markov process, whose share of rejections is small
RATE = 5.0
SIGMA = 20.0  # [deg/h]
LEVEL = 0.95
_MARKOV = 0.5  # smoothness of a Gauss-Markov process

CELLS = {
    "ν 0.1": (0.1, 20.0, 0.1, 2.0),
    "ν 0.25": (0.25, 20.0, 0.1, 2.0),
    "ν 0.25, long": (0.25, 300.0, 0.1, 4.0),
    "ν 0.25, weak": (0.25, 20.0, 0.6, 2.0),
    "ν 0.4": (0.4, 20.0, 0.1, 2.0),
    "Gauss-Markov": (0.5, 20.0, 0.1, 2.0),
    "Gauss-Markov, long": (0.5, 100.0, 0.1, 4.0),
    "Gauss-Markov, weak": (0.5, 20.0, 0.6, 2.0),
}
"""Smoothness, correlation time [s], random walk [deg/√h] and length of the record [h]."""


def cell(seed: int, smoothness: float, time: float, white: float, hours: float) -> list[dict[str, Any]]:
    """Values and intervals of each record."""
    process = st.Matern(sigma=to_si(SIGMA, "deg/h"), time=time, smoothness=smoothness)
    channel = st.ChannelModel(terms={"random_walk": to_si(white, "deg/sqrt(h)")}, matern=(process,))
    model, rng = st.NoiseModel(channels={"gyro_x": channel}), np.random.default_rng(seed)
    results = []
    for _ in range(TEST_RECORDS if smoothness == _MARKOV else RECORDS):
        log = st.simulate(model, duration=hours * 3600, rate=RATE, rng=rng)
        fit = st.fit_channel(log, "gyro_x", processes="matern", level=LEVEL).matern
        if fit is None:
            continue
        estimates = (fit.sigma, fit.time, fit.smoothness)
        truths = (process.sigma, time, smoothness)
        results.append(
            {
                "observed": fit.observed,
                "slope": fit.slope_observed,
                "ratio": [each.value / truth for each, truth in zip(estimates, truths, strict=True)],
                "inside": [
                    (each.low is None or each.low <= truth) and (each.high is None or truth <= each.high)
                    for each, truth in zip(estimates, truths, strict=True)
                ],
                "markov": fit.gauss_markov_p_value,
                "p_value": fit.p_value,
            }
        )
    return results


def main() -> None:
    """Run the study and write docs/study/matern.md."""
    settings = repr((RECORDS, TEST_RECORDS, RATE, SIGMA, LEVEL, CELLS))
    results = run("matern", {f"matern {name}": (cell, numbers) for name, numbers in CELLS.items()}, settings=settings)
    lines, failures = [_HEAD.format(records=RECORDS, tests=TEST_RECORDS, rate=RATE, sigma=SIGMA)], []
    for name, (smoothness, time, white, hours) in CELLS.items():
        records = results[f"matern {name}"]
        ratios = np.array([record["ratio"] for record in records])
        inside = np.array([record["inside"] for record in records]).mean(axis=0)
        below = {level: float(np.mean([record["markov"] < level for record in records])) for level in (0.05, 0.01)}
        observed, slope = (np.mean([record[key] for record in records]) for key in ("observed", "slope"))
        misfit = np.mean([record["p_value"] < 0.01 for record in records])
        numbers = [*np.median(ratios, axis=0), *(100 * inside)]
        lines.append(
            f"| {smoothness:g} | {time:g} s | {white:g} deg/√h | {hours:g} h | {100 * observed:.0f} | {100 * slope:.0f} |"
            f" {' | '.join(f'{x:.2f}' for x in numbers[:3])} | {' | '.join(f'{x:.0f}' for x in numbers[3:])} |"
            f" {100 * below[0.05]:.1f} | {100 * below[0.01]:.1f} | {100 * misfit:.1f} |"
        )
        error = 3 * np.sqrt(LEVEL * (1 - LEVEL) / len(records))
        failures += [
            f"- {name}: {what} holds in {100 * share:.0f} %"
            for what, share in zip(("σ", "T", "ν"), inside, strict=True)
            if share < LEVEL - error
        ]
        if smoothness == _MARKOV:
            failures += [
                f"- {name}: rejected at {100 * level:g} % in {100 * share:.1f} %"
                for level, share in below.items()
                if share > level + 3 * np.sqrt(level * (1 - level) / len(records))
            ]
    lines += ["", "## Gates", "", *(failures or ["All gates are met."])]
    Path("docs/study/matern.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


_HEAD = """# Fits of a Matérn process

Made by `make study` (studies/matern.py), with seeds derived from the names of the cells: {records} records of each cell,
{tests} where ν is 1/2, at {rate:g} Hz, with σ = {sigma:g} deg/h. `fit_channel(…, processes="matern")` fits one
[Matérn process](../theory/matern.md) in place of all slow noise, and tests the Gauss-Markov process, ν = 1/2. The columns
give the share of records [%] in which the process is observed, and in which the record limits ν; the median of the
estimates over the true values; the share [%] in which the 95 % intervals hold; the share [%] in which the test
rejects the Gauss-Markov process at 5 % and at 1 %; and that in which the p-value of the model is below 1 %.

The gates: each interval holds in at least 95 %, and the test rejects a Gauss-Markov process in at most 5 % and 1 %, each
within 3 standard errors.

| ν | T | N | record | observed | ν limited | σ | T | ν | σ holds | T holds | ν holds | 5 % | 1 % | p < 1 % |
|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|"""

if __name__ == "__main__":
    main()
