"""Lots: how often a clean lot names anybody, and whether the intervals of drifts, batches and rises contain the truth."""

from __future__ import annotations

import gzip
import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from sigmatau import Imperfections, NoiseModel, analyze, judge_lot, simulate
from sigmatau.arrays import Bools, Floats
from sigmatau.lab.lots.lot_statistics import FALSE_ALARMS, Series, distribution
from sigmatau.lab.lots.order_effect import fit_order
from sigmatau.lab.lots.robust_effect import estimate_effects
from studies.runner import CACHE, run

LOTS = 200
UNITS = 20  # of a clean lot
DURATION, RATE = 600.0, 20.0  # of a record [s], [Hz]
SPREAD, WALK_SPREAD = 0.05, 0.2  # between units: of N and of K, logarithm
TILT, BIAS = 0.03, 1e-4  # standard deviations of the means [m/s²], [rad/s]
NAMING = ("outlier", "slow_noise", "other_mean", "other_scale", "orientation")

SETS = 1000
SIZES = (10, 20, 40, 100)  # units of a series
SERIES_SIZES = (10, 20, 40)  # units of a lot of numbers
CASES = ("normal", "heavy tails", "a bad unit", "a fifth limits")
SCATTER = 0.05  # between units, in the cells of sizes, logarithm
CHANGES = {"drift": 0.3, "batch": 0.15, "rise": 0.03}  # size, in an order of 40 units; the last ten of them are a batch
FACTORS = (1.1, 1.2, 1.3, 1.5)  # of a unit that is not as the others
FAMILIES = 28  # series of a lot of six axes with random walk, 10 s means and slow noise
LEVEL = 0.95


def clean_lot(seed: int, number: int) -> dict[str, int]:
    """Kinds of remarks about one lot of good units, with their numbers. Records are kept in the cache."""
    file = CACHE / "lots" / f"{number:03d}.json.gz"
    file.parent.mkdir(parents=True, exist_ok=True)
    if not file.exists():
        temporary = file.with_suffix(".tmp")
        with gzip.open(temporary, "wt", compresslevel=3) as stream:
            json.dump(_results(np.random.default_rng(seed)), stream)
        temporary.replace(file)
    with gzip.open(file, "rt") as stream:
        lot = judge_lot(json.load(stream))
    counts = {code: sum(remark.code == code for unit in lot.units for remark in unit.remarks) for code in NAMING}
    return counts | {"order": len(lot.drifts)}


def _results(rng: np.random.Generator) -> dict[str, Any]:
    results = {}
    for unit in range(UNITS):
        channels, level = {}, {}
        for axis in "xyz":
            n = np.exp(SPREAD * rng.standard_normal(2))
            k = np.exp(WALK_SPREAD * rng.standard_normal(2))
            walks = {"random_walk": f"{0.1 * n[0]} deg/sqrt(h)", "rate_random_walk": f"{3 * k[0]} deg/h/sqrt(h)"}
            channels[f"gyro_{axis}"] = walks
            walks = {"random_walk": f"{0.03 * n[1]} m/s/sqrt(h)", "rate_random_walk": f"{k[1]} m/s/h/sqrt(h)"}
            channels[f"accel_{axis}"] = walks
            level[f"gyro_{axis}"] = float(BIAS * rng.standard_normal())
            level[f"accel_{axis}"] = float(TILT * rng.standard_normal() + (9.80665 if axis == "z" else 0))
        model = NoiseModel.from_dict({"channels": channels})
        seed = int(rng.integers(1 << 62))
        record = simulate(model, duration=DURATION, rate=RATE, rng=seed, imperfections=Imperfections(level=level))
        results[f"u{unit}"] = analyze(record, threads=1).to_dict()
    return results


def effects(seed: int, units: int, case: str) -> float:
    """Share of the intervals of a slope that contain it: 0.7 standard deviations over all units."""
    rng = np.random.default_rng(seed)
    x, hits = np.arange(units) / (units - 1), 0
    for _ in range(SETS):
        y, limited = _values(rng, units, case, 0.7 * x)
        low, high = estimate_effects(x, y, limited).interval(LEVEL)
        hits += bool(low[0] <= 0.7 <= high[0])
    return hits / SETS


def _values(rng: np.random.Generator, units: int, case: str, mean: Floats) -> tuple[Floats, Bools]:
    y = mean + (rng.standard_t(3, units) if case == "heavy tails" else rng.standard_normal(units))
    limited = np.zeros(units, dtype=bool)
    if case == "a bad unit":
        y[rng.integers(units)] += 28
    if case == "a fifth limits":
        limits = -0.5 + 0.3 * rng.standard_normal(units)
        limited, y = y < limits, np.maximum(y, limits)
    return y, limited


def changes(seed: int, kind: str) -> dict[str, float]:
    """Shares of the series of 40 units with a change that is reported, with its kind, its first unit, and its size."""
    rng = np.random.default_rng(seed)
    order = np.arange(40.0)
    shape = {"drift": order / 39, "batch": (order >= 30) * 1.0, "rise": np.maximum(order - 29, 0.0)}[kind]
    first = 0 if kind == "drift" else 30
    names = tuple(f"u{k}" for k in range(40))
    counts = dict.fromkeys(("reported", "kind", "place", "covered"), 0)
    for _ in range(SETS):
        logs = CHANGES[kind] * shape + SCATTER * rng.standard_normal(40)
        effect = fit_order(names, logs, np.zeros(40, dtype=bool), probability=FALSE_ALARMS / FAMILIES).effect
        counts["reported"] += effect is not None
        if effect is not None and effect.kind == kind:
            counts["kind"] += 1
            counts["place"] += abs(int(effect.first[1:]) - first) <= 2
            counts["covered"] += effect.low <= math.expm1(CHANGES[kind]) <= effect.high
    return {
        "reported": counts["reported"] / SETS,
        "kind": counts["kind"] / max(counts["reported"], 1),
        "place": counts["place"] / max(counts["kind"], 1),
        "covered": counts["covered"] / max(counts["kind"], 1),
        "of": counts["kind"],
    }


def series(seed: int, units: int) -> float:
    """Share of the lots of numbers without a fault that name a unit, a drift or a batch: 28 normal series each."""
    rng = np.random.default_rng(seed)
    named = sum(any(_names(rng.standard_normal(units), units) for _ in range(FAMILIES)) for _ in range(SETS // 4))
    return named / (SETS // 4)


def _names(logs: Floats, units: int) -> bool:
    described = distribution("gyro_x", _series(SCATTER * logs, units), families=FAMILIES)
    return bool(described.outliers) or described.order is not None


def _series(logs: Floats, units: int) -> Series:
    return Series(
        channels=("gyro_x",),
        what="random_walk",
        units=tuple(f"u{k}" for k in range(units)),
        logs=logs,
        errors=np.zeros(units),
        limited=np.zeros(units, dtype=bool),
    )


def outlier(seed: int, units: int, factor: float) -> float:
    """Share of the lots in which a unit with a factor on one axis is named."""
    rng = np.random.default_rng(seed)
    named = 0
    for _ in range(SETS // 4):
        logs = SCATTER * rng.standard_normal(units)
        logs[units // 3] = math.log(factor)
        described = distribution("gyro_x", _series(logs, units), families=FAMILIES)
        named += f"u{units // 3}" in described.outliers
    return named / (SETS // 4)


def main() -> None:
    """Run the study and write docs/study/lots.md."""
    cells: dict[str, Any] = {
        f"effect, {units} units, {case}": (effects, (units, case)) for units in SIZES for case in CASES
    }
    cells |= {f"change, {kind}": (changes, (kind,)) for kind in CHANGES}
    cells |= {f"series of {units}": (series, (units,)) for units in SERIES_SIZES}
    cells |= {
        f"outlier of {units}, {factor}": (outlier, (units, factor)) for units in SERIES_SIZES for factor in FACTORS
    }
    cells |= {f"clean lot {number}": (clean_lot, (number,)) for number in range(LOTS)}
    # A cell does not depend on the number of lots, so that more lots can be added.
    settings = repr((UNITS, DURATION, RATE, SPREAD, WALK_SPREAD, TILT, BIAS, SETS, CHANGES, FAMILIES, SCATTER))
    results = run("lots", cells, settings=settings)
    failures: list[str] = []
    lines = [_HEAD.format(lots=LOTS, units=UNITS), "", *_clean(results, failures), "", *_numbers(results, failures), ""]
    lines += [*_coverage(results, failures), "", *_changes(results, failures), "", "## Gates", "", _GATES, ""]
    lines += failures or ["All gates are met."]
    Path("docs/study/lots.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


def _error(share: float, sets: int) -> float:
    return 3 * math.sqrt(share * (1 - share) / sets)


def _clean(results: Mapping[str, Any], failures: list[str]) -> list[str]:
    lots = [results[f"clean lot {number}"] for number in range(LOTS)]
    named = sum(any(lot.values()) for lot in lots)
    if named / LOTS > FALSE_ALARMS + _error(FALSE_ALARMS, LOTS):
        failures.append(f"- clean lots: {100 * named / LOTS:.1f} % name a unit, a drift or a batch")
    rows = [(name.replace("_", " "), sum(bool(lot[name]) for lot in lots)) for name in (*NAMING, "order")]
    words = {
        "order": "drift or batch",
        "other scale": "scale or gravity",
        "other mean": "mean",
        "slow noise": "slow noise",
    }
    table = [f"| {words.get(name, name)} | {count} | {100 * count / LOTS:.1f} |" for name, count in rows]
    sentence = f"{named} of {LOTS} lots ({100 * named / LOTS:.1f} %) name a unit, a drift or a batch."
    return ["## Clean lots, from records", "", sentence, "", "| named | lots | % |", "|---" * 3 + "|", *table]


def _numbers(results: Mapping[str, Any], failures: list[str]) -> list[str]:
    lines = [_NUMBERS.format(families=FAMILIES, scatter=100 * SCATTER), ""]
    lines += ["| units | names anybody | " + " | ".join(f"× {factor:g}" for factor in FACTORS) + " |", "|---" * 6 + "|"]
    for units in SERIES_SIZES:
        false = results[f"series of {units}"]
        if false > FALSE_ALARMS + _error(FALSE_ALARMS, SETS // 4):
            failures.append(f"- series of {units} units: {100 * false:.1f} % name a unit, a drift or a batch")
        shares = [results[f"outlier of {units}, {factor}"] for factor in FACTORS]
        lines.append(f"| {units} | {100 * false:.1f} | " + " | ".join(f"{100 * share:.0f}" for share in shares) + " |")
    return lines


def _coverage(results: Mapping[str, Any], failures: list[str]) -> list[str]:
    lines = [_EFFECTS.format(sets=SETS), "", "| units | " + " | ".join(CASES) + " |", "|---" * (1 + len(CASES)) + "|"]
    for units in SIZES:
        shares = {case: results[f"effect, {units} units, {case}"] for case in CASES}
        for case, share in shares.items():
            if share < LEVEL - _error(LEVEL, SETS) or (share > LEVEL + _error(LEVEL, SETS) and "limits" not in case):
                failures.append(f"- slope of {units} units, {case}: {100 * share:.1f} %")
        lines.append(f"| {units} | " + " | ".join(f"{100 * share:.1f}" for share in shares.values()) + " |")
    return lines


def _changes(results: Mapping[str, Any], failures: list[str]) -> list[str]:
    lines = [_CHANGES.format(sets=SETS, scatter=100 * SCATTER), ""]
    lines += ["| change | size [%] | reported | its kind | first unit within 2 | size covered |", "|---" * 6 + "|"]
    for kind, size in CHANGES.items():
        row = results[f"change, {kind}"]
        if abs(row["covered"] - LEVEL) > _error(LEVEL, max(int(row["of"]), 1)):
            failures.append(f"- size of a {kind}: {100 * row['covered']:.1f} % covered")
        shares = " | ".join(f"{100 * row[key]:.1f}" for key in ("reported", "kind", "place", "covered"))
        lines.append(f"| {kind} | {100 * size:g} | {shares} |")
    return lines


_HEAD = """# Lots

Made by `make study` (studies/lots.py); the seeds are derived from the names of the rows. `sigmatau lot` compares the units
of a lot with each other: orientation, means and gravity, coefficients, slow noise, drift and batches. All these tests share
one probability of 5 % that a lot without a fault names anybody.

Clean lots: {lots} lots of {units} simulated units with six axes, 10 minutes at 20 Hz each, analysed and compared as by
`analyze` and `judge_lot`. N varies by 5 % between units and axes, K by 20 %; accelerometers are tilted, gyros are biased."""

_NUMBERS = """## Series of numbers

Lots of {families} series of normal values with a standard deviation of {scatter:g} %: the share of lots that name anybody,
and the share that name a unit with one axis this factor above the others. In per cent."""

_EFFECTS = """## Coverage of a slope

{sets} series for each number: share of the 95 % intervals of the robust regression that contain the slope, in per cent.
*Heavy tails*: Student's t with three degrees of freedom. *A bad unit*: one value 28 standard deviations above the line.
*A fifth limits*: about a fifth to a third of the values are upper limits; their intervals may be wider than necessary."""

_CHANGES = """## Drifts and batches

{sets} series of 40 units with a standard deviation of {scatter:g} %; the last ten units are the batch, or rise from unit to
unit. *Its kind* is of the reported changes, the last two columns are of those with the right kind. In per cent."""

_GATES = """At most 5 % of clean lots name anybody. The intervals of slopes, drifts and batches contain the true value in
95 % of the sets. All within 3 standard errors of the simulation. Cells that fail are listed, not repeated."""


if __name__ == "__main__":
    main()
