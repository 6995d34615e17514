"""Repeatability over runs: size and power of the tests, coverage of the intervals; for numbers and for simulated records."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from sigmatau import NoiseModel, analyze, compare_runs, simulate
from sigmatau.lab.lots.group_effects import GroupEffects, group_effects
from studies.runner import run

SETS = 2000
RUNS = (3, 7, 30)
RATIOS = (0.0, 0.5, 1.0, 2.0, 4.0)  # spread between runs over the error of a run
UNEVEN = 0.5  # standard deviation of the logarithm of the errors, in the second half of the study
SHIFT = 6.0  # shift of the outlying run, in standard deviations of a value

PARTS = 5
UNITS = 60  # simulated units per part
DAYS = 7
DURATION, RATE = 1800.0, 20.0  # duration [s] and rate [Hz] of a record
TRUE = {"random_walk": 8.7e-5, "bias_instability": 1.2e-4}  # true coefficients of a gyro [SI]
SPREADS = (0.0, 0.05, 0.2)  # standard deviation of the logarithm of coefficients from day to day
LEVEL = 0.95


def numbers(seed: int, k: int, ratio: float, spread: float) -> dict[str, float]:
    """Shares of the sets of one cell. The mean is 0 and the errors have the median 1."""
    rng = np.random.default_rng(seed)
    errors = np.exp(rng.normal(0.0, spread, (SETS, k)))
    values = ratio * rng.standard_normal((SETS, k)) + errors * rng.standard_normal((SETS, k))
    effects = group_effects(values, errors, level=LEVEL)
    new_error = np.exp(rng.normal(0.0, spread, SETS))
    new = ratio * rng.standard_normal(SETS) + new_error * rng.standard_normal(SETS)
    moved = values.copy()
    moved[:, 0] += SHIFT * np.sqrt(ratio**2 + errors[:, 0] ** 2)
    with_odd = group_effects(moved, errors, level=LEVEL)
    named = (with_odd.outlier_p < 1 - LEVEL) & (with_odd.outlier == 0)
    return {**_shares(effects, truth=0.0, ratio=ratio, new=new, values=values), "outlier power": float(named.mean())}


def _shares(
    effects: GroupEffects, *, truth: float, ratio: float, new: np.ndarray[Any, Any], values: np.ndarray[Any, Any]
) -> dict[str, float]:
    tau = (effects.tau_low <= ratio + 1e-12) & (effects.tau_high >= ratio - 1e-12)
    rule = values.std(axis=1, ddof=1) < 1.0
    return {
        "varies": float((effects.p_value < 1 - LEVEL).mean()),
        "too alike": float((effects.p_low < (1 - LEVEL) / 2).mean()),
        "tau": float(tau.mean()),
        "mean": float((np.abs(effects.mean - truth) <= effects.mean_error).mean()),
        "next": float((np.abs(new - effects.mean) <= effects.next_error).mean()),
        "outlier": float((effects.outlier_p < 1 - LEVEL).mean()),
        "paper": float(rule.mean()),
    }


def records(seed: int, spread: float) -> dict[str, list[float]]:
    """Units of simulated days, analysed and compared: shares as from `numbers`, by term."""
    rng = np.random.default_rng(seed)
    counts: dict[str, list[list[float]]] = {term: [] for term in TRUE}
    for _ in range(UNITS):
        factors = np.exp(rng.normal(0.0, spread, (DAYS + 1, len(TRUE))))
        results = []
        for day in factors:
            terms = {term: value * float(factor) for (term, value), factor in zip(TRUE.items(), day, strict=True)}
            model = NoiseModel(channels={"gyro_x": terms})
            record = simulate(model, duration=DURATION, rate=RATE, rng=int(rng.integers(1 << 62)))
            results.append(analyze(record, threads=1).to_dict())
        compared = compare_runs(results[:DAYS])
        for term, value in TRUE.items():
            comparison = compared["gyro_x", term]
            after = results[DAYS]["channels"]["gyro_x"]["fit"]["terms"][term]
            if comparison.k < 2 or comparison.p_value is None or comparison.p_low is None or after.get("value") is None:
                counts[term].append([float(comparison.k), *[math.nan] * 6])
                continue
            assert comparison.tau_low is not None
            assert comparison.tau_high is not None
            assert comparison.low is not None
            assert comparison.high is not None
            assert comparison.next_low is not None
            assert comparison.next_high is not None
            counts[term].append(
                [
                    float(comparison.k),
                    float(comparison.p_value < 1 - LEVEL),
                    float(comparison.p_low < (1 - LEVEL) / 2),
                    float(comparison.tau_low <= spread <= comparison.tau_high),
                    float(comparison.low <= value <= comparison.high),
                    float(comparison.next_low <= after["value"] <= comparison.next_high),
                    float((comparison.outlier_p or 1.0) < 1 - LEVEL),
                ]
            )
    return {term: np.nanmean(np.array(rows), axis=0).tolist() for term, rows in counts.items()}


def main() -> None:
    """Run the study and write docs/study/repeatability.md."""
    cells: dict[str, Any] = {
        f"k {k}, tau/s {ratio}, errors {spread}": (numbers, (k, ratio, spread))
        for spread in (0.0, UNEVEN)
        for k in RUNS
        for ratio in RATIOS
    }
    cells |= {f"records, spread {spread}, part {p}": (records, (spread,)) for spread in SPREADS for p in range(PARTS)}
    settings = repr((SETS, PARTS, UNITS, DAYS, DURATION, RATE, TRUE, SHIFT, LEVEL))
    results = run("repeatability", cells, settings=settings)
    lines = [_HEAD.format(sets=SETS)]
    failures: list[str] = []
    for spread in (0.0, UNEVEN):
        accepted = [results[f"k {k}, tau/s 0.0, errors 0.0"]["paper"] for k in RUNS]
        wrong = results["k 3, tau/s 4.0, errors 0.0"]["paper"]
        equal = _EQUAL.format(least=100 * min(accepted), most=100 * max(accepted), wrong=100 * wrong)
        lines += ["", equal if spread == 0 else _UNEQUAL, "", *_TABLE]
        for k in RUNS:
            for ratio in RATIOS:
                shares = results[f"k {k}, tau/s {ratio}, errors {spread}"]
                lines.append(_row(k, ratio, shares))
                failures += _failures(
                    f"k = {k}, τ/s = {ratio:g}, errors {'equal' if spread == 0 else 'unequal'}", ratio, shares
                )
    lines += ["", *_rows_of_records(results), "", "## Gates", "", _GATES, ""]
    lines += failures or ["All gates are met."]
    Path("docs/study/repeatability.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


def _row(k: int, ratio: float, shares: Mapping[str, float]) -> str:
    names = ("varies", "too alike", "tau", "mean", "next", "outlier", "outlier power", "paper")
    return f"| {k} | {ratio:g} | " + " | ".join(f"{100 * shares[name]:.1f}" for name in names) + " |"


def _failures(where: str, ratio: float, shares: Mapping[str, float]) -> list[str]:
    def error(p: float) -> float:
        return 3 * math.sqrt(p * (1 - p) / SETS)

    failures = []
    if ratio == 0 and abs(shares["varies"] - 0.05) > error(0.05):
        failures.append(f"- {where}: the size of the test is {100 * shares['varies']:.1f} %")
    failures += [
        f"- {where}: the interval of {_NAMES[name]} covers {100 * shares[name]:.1f} %"
        for name in ("tau", "mean", "next")
        if shares[name] < 0.95 - error(0.95)
    ]
    if shares["outlier"] > 0.05 + error(0.05):
        failures.append(f"- {where}: {100 * shares['outlier']:.1f} % false outliers")
    return failures


_NAMES = {"tau": "τ", "mean": "the mean", "next": "the next run"}


def _rows_of_records(results: Mapping[str, Any]) -> list[str]:
    lines = [_RECORDS.format(units=PARTS * UNITS, days=DAYS, minutes=DURATION / 60, rate=RATE), ""]
    lines += [
        "| term | spread [%] | days that show it | p < 5 % | p_low < 2.5 % | τ covered | mean covered | day 8 covered"
        " | outlier |",
        "|---" * 9 + "|",
    ]
    for term in TRUE:
        for spread in SPREADS:
            parts = [results[f"records, spread {spread}, part {p}"][term] for p in range(PARTS)]
            k, *shares = np.mean(parts, axis=0).tolist()
            name = term.replace("_", " ")
            lines.append(
                f"| {name} | {100 * spread:g} | {k:.2f} of {DAYS} | "
                + " | ".join(f"{100 * x:.0f}" for x in shares)
                + " |"
            )
    return lines


_TABLE = [
    "| runs | τ/s | p < 5 % | p_low < 2.5 % | τ | mean | next run | false outlier | true outlier | paper's rule |",
    "|---" * 10 + "|",
]

_HEAD = """# Repeatability over runs

Made by `make study` (studies/repeatability.py): {sets} sets of simulated values for each row; the seeds are derived
from the names of the rows. A value is the sum of a deviation of its run with standard deviation τ and an error with
the known standard deviation s. `sigmatau compare` and `sigmatau.random_effects` see logarithms of coefficients like
this. All numbers are in per cent of the sets.

- *p < 5 %*: Cochran's test says that the runs vary: its size at τ = 0, its power elsewhere. *p_low < 2.5 %*: the test
  says that the runs are more alike than their errors allow.
- *τ*, *mean*, *next run*: the 95 % interval contains the true value; for the next run, the prediction interval contains
  the value of one more run.
- *false outlier*: a run is reported as an outlier although all belong. *true outlier*: the first run is moved by 6 standard
  deviations of a value, and is named.
- *paper's rule*: the standard deviation of the values is below s, which the paper takes as the proof of
  repeatability."""

_EQUAL = """## Equal errors

The paper's rule accepts {least:.0f} to {most:.0f} % of the sets that are perfectly repeatable, and {wrong:.0f} % of
the three-day sets with a spread of 4 s. The intervals of the mean and of the next run are wider than necessary for
three runs: with their t quantile of 4.3 they allow for a spread that three runs cannot exclude. Of three runs, one is
named only if it is about 50 standard deviations away."""

_UNEQUAL = """## Unequal errors

The standard deviation of the logarithms of the errors is 0.5, so that one in twenty differs by more than a factor of
2.7 from the median. The errors of the runs are known, that of the next run is not."""

_GATES = """The size of the test at τ = 0 is 5 %. The intervals contain the true value in 95 % of the sets or more. At most
5 % false outliers. All within 3 standard errors of the simulation. Cells that fail are listed, not repeated."""

_RECORDS = """## From records to the comparison

{units} simulated gyros with N and B, {days} days of {minutes:.0f} minutes at {rate:g} Hz each, and one more day that
is not compared. The days are analysed and compared by `analyze` and `compare_runs`, so that the errors come from the
intervals of the fits (their upper halves; see [the how-to page](../how-to/repeatability.md)). The coefficients vary
from day to day with the given standard deviation. In per cent of the gyros; the standard error of 95 % is 1.3 %."""

if __name__ == "__main__":
    main()
