"""Arrays: coverage of covariances, correlations, weights and hats, false alarms of correlation, the check on fused logs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np

from sigmatau import NoiseModel, Record, simulate
from sigmatau.arrays import Floats
from sigmatau.lab.arrays.analyze import analyze_array
from sigmatau.lab.arrays.array_fit import Conditions, estimate_coefficients, estimate_correlations, fit_array
from sigmatau.lab.arrays.components import Component
from sigmatau.lab.arrays.covariance_fit import CovarianceFit
from sigmatau.lab.arrays.fusing import FittedArray, make_virtual
from sigmatau.lab.arrays.weights import estimate_weights, optimal_vector
from studies.runner import run

SETS, CHUNK = 1000, 100
LOG_SETS = 1000  # logs that are analysed as a user does
SAMPLES, RATE = 1 << 14, 100.0  # of a record; [Hz]
LEVEL = 0.95
WHITE, WALK, FLICKER = 1e-4, 1e-4, 1.5e-3  # N [rad/√s], K [rad/s/√s], B [rad/s] of a sensor

# Sizes of the sensors in units of these, and the correlation of each pair by term.
CASES: Mapping[str, dict[str, Any]] = {
    "4 equal": {"sizes": (1, 1, 1, 1), "slow": "rate_random_walk", "white": 0.0, "correlated": 0.0},
    "4 unequal, correlated": {"sizes": (1, 1, 1.5, 2), "slow": "rate_random_walk", "white": 0.4, "correlated": 0.5},
    "3 with negative correlation": {"sizes": (1, 1, 1), "slow": "rate_random_walk", "white": -0.3, "correlated": -0.3},
    "4 with flicker": {"sizes": (1, 1, 1, 1.5), "slow": "bias_instability", "white": 0.2, "correlated": 0.3},
    "6 equal": {"sizes": (1,) * 6, "slow": "rate_random_walk", "white": 0.1, "correlated": 0.2},
}
HATS: Mapping[str, dict[str, Any]] = {
    "3 sensors": {"sizes": (1, 1, 2), "slow": "rate_random_walk"},
    "5 sensors": {"sizes": (1, 1, 1, 1.5, 2), "slow": "rate_random_walk"},
}
LOGS = {"3 equal": (1, 1, 1), "4 unequal": (1, 1, 1.5, 2)}  # analysed as a user does
TERMS = ("random_walk", "slow")


def covariance(seed: int, case: str) -> dict[str, float]:
    """Shares of a chunk of sets whose intervals contain the truth: coefficients, correlations and weights, by term."""
    rng = np.random.default_rng(seed)
    about = CASES[case]
    truth, model, components = _truth(about)
    n = len(about["sizes"])
    names = [f"gyro_{k}" for k in range(n)]
    hits: dict[str, list[float]] = {}
    for _ in range(CHUNK):
        fit = _fitted(model, components, truth, rng, common=False)
        coefficients = estimate_coefficients(names, fit, components, 1.0, LEVEL, ["", ""])
        correlations = estimate_correlations(names, fit, components, coefficients, 1.0, LEVEL)
        alarm = False
        for t, (term, component) in enumerate(zip(TERMS, components, strict=True)):
            for k, name in enumerate(names):
                each = coefficients[component.name][name]
                hits.setdefault(f"coefficient {term}", []).append(_contains(each, math.sqrt(truth[t, k, k])))
            for (i, j), each in zip(combinations(range(n), 2), correlations[component.name].values(), strict=True):
                expected = truth[t, i, j] / math.sqrt(truth[t, i, i] * truth[t, j, j])
                hits.setdefault(f"correlation {term}", []).append(_contains(each, expected))
                alarm |= each.correlated
            amounts = np.eye(2)[t]
            weights = estimate_weights(fit, amounts, level=LEVEL, widening=1.0)
            if weights is None:
                hits.setdefault("refused", []).append(1.0)
                continue
            for each, expected in zip(weights.values, optimal_vector(truth[t]), strict=True):
                hits.setdefault(f"weight {term}", []).append(_contains(each, expected))
            hits.setdefault(f"equal {term}", []).append(float(weights.differ))
        hits.setdefault("correlated", []).append(float(alarm))
    refused = len(hits.pop("refused", ()))
    return {name: float(np.mean(values)) for name, values in hits.items()} | {"refused": float(refused)}


def hat(seed: int, case: str) -> dict[str, float]:
    """Shares of a chunk of sets whose intervals and limits contain the coefficients, behind a common disturbance."""
    rng = np.random.default_rng(seed)
    about = {"white": 0.0, "correlated": 0.0, **HATS[case]}
    truth, model, components = _truth(about)
    names = [f"gyro_{k}" for k in range(len(about["sizes"]))]
    hits: dict[str, list[float]] = {}
    for _ in range(CHUNK):
        fit = _fitted(model, components, truth, rng, common=True)
        coefficients = estimate_coefficients(names, fit, components, 1.0, LEVEL, ["", ""])
        for t, (term, component) in enumerate(zip(TERMS, components, strict=True)):
            for k, name in enumerate(names):
                each = coefficients[component.name][name]
                hits.setdefault(f"coefficient {term}", []).append(_contains(each, math.sqrt(truth[t, k, k])))
                hits.setdefault(f"limits {term}", []).append(float(not each.observed))
    return {name: float(np.mean(values)) for name, values in hits.items()}


def fused(seed: int, case: str) -> dict[str, float]:
    """Shares of a chunk of sets whose fused samples are in the predicted band, and whose second half is in that of the
    first.
    """
    rng = np.random.default_rng(seed)
    about = {"sizes": LOGS[case], "slow": "rate_random_walk", "white": 0.0, "correlated": 0.0}
    truth, model, components = _truth(about)
    counts = dict.fromkeys(("fused", "half"), 0.0)
    first = np.einsum("tii->ti", truth)
    names = {"channel": "gyro_x", "quantity": "angular_rate", "unit": "rad/s"}
    for _ in range(CHUNK):
        record = _record(model, rng)
        samples = np.stack([record.stream_of(name).column(name) for name in record.channels])
        conditions = Conditions()
        fit = fit_array(samples, 1 / RATE, components, first, common=False, conditions=conditions)
        array = FittedArray(
            samples=samples,
            tau0=1 / RATE,
            components=components,
            first=first,
            conditions=conditions,
            fit=fit,
            widening=1.0,
            level=LEVEL,
            common=False,
        )
        virtual = make_virtual(array, "random_walk", units=["", ""], **names)
        assert virtual is not None
        assert virtual.second_half is not None
        counts["fused"] += virtual.curve.agrees
        counts["half"] += virtual.second_half.agrees
    return {name: count / CHUNK for name, count in counts.items()}


def log(seed: int, case: str) -> dict[str, float]:
    """The same shares for a chunk of logs that are analysed with `analyze_array`; logs that are called correlated."""
    rng = np.random.default_rng(seed)
    about = {"sizes": LOGS[case], "slow": "rate_random_walk", "white": 0.0, "correlated": 0.0}
    truth, model, _ = _truth(about)
    expected = optimal_vector(truth[0])
    counts = dict.fromkeys(("fused", "half", "correlated", "misfit", "weight"), 0.0)
    for _ in range(CHUNK):
        array = analyze_array(_record(model, rng), threads=1)
        assert array.virtual is not None
        assert array.virtual.second_half is not None
        counts["fused"] += array.virtual.curve.agrees
        counts["half"] += array.virtual.second_half.agrees
        counts["correlated"] += any(each.correlated for by in array.correlations.values() for each in by.values())
        counts["misfit"] += array.goodness.is_misfit
        values = array.virtual.weights.values
        counts["weight"] += float(np.mean([_contains(a, b) for a, b in zip(values, expected, strict=True)]))
    return {name: count / CHUNK for name, count in counts.items()}


def _truth(about: Mapping[str, Any]) -> tuple[Floats, NoiseModel, tuple[Component, ...]]:
    """True matrices of both terms, the model, and its components."""
    sizes = np.array(about["sizes"], dtype=float)
    slow = str(about["slow"])
    units = (WHITE, WALK if slow == "rate_random_walk" else FLICKER)
    n = len(sizes)
    truth = np.stack(
        [
            unit**2 * np.outer(sizes, sizes) * (r + (1 - r) * np.eye(n))
            for unit, r in zip(units, (about["white"], about["correlated"]), strict=True)
        ]
    )
    names = [f"gyro_{k}" for k in range(n)]
    terms = ("random_walk", slow)
    model = NoiseModel(
        channels={
            name: {term: float(unit * size) for term, unit in zip(terms, units, strict=True)}
            for name, size in zip(names, sizes, strict=True)
        },
        correlation={
            term: dict.fromkeys(combinations(names, 2), r)
            for term, r in zip(terms, (about["white"], about["correlated"]), strict=True)
            if r
        },
    )
    return truth, model, tuple(Component(name=term) for term in terms)


def _record(model: NoiseModel, rng: np.random.Generator) -> Record:
    return simulate(model, duration=SAMPLES / RATE, rate=RATE, rng=int(rng.integers(1 << 62)))


def _fitted(
    model: NoiseModel, components: tuple[Component, ...], truth: Floats, rng: np.random.Generator, *, common: bool
) -> CovarianceFit:
    """Fit of a simulated record; `common` adds a random walk and white noise to all sensors."""
    record = _record(model, rng)
    samples = np.stack([record.stream_of(name).column(name) for name in record.channels])
    if common:
        samples = samples + 0.01 * rng.standard_normal(SAMPLES) + np.cumsum(1e-3 * rng.standard_normal(SAMPLES))
    first = np.einsum("tii->ti", truth) * rng.uniform(0.5, 2.0, (2, 1))
    return fit_array(samples, 1 / RATE, components, first, common=common, conditions=Conditions())


def _contains(estimate: Any, truth: float) -> float:  # noqa: ANN401  an Estimate
    if estimate.value is None:
        return float(truth <= estimate.upper_limit)
    return float(estimate.low <= truth <= estimate.high)


def main() -> None:
    """Run the study and write docs/study/arrays.md."""
    chunks = range(SETS // CHUNK)
    cells: dict[str, Any] = {f"covariance, {case}, {k}": (covariance, (case,)) for case in CASES for k in chunks}
    cells |= {f"hat, {case}, {k}": (hat, (case,)) for case in HATS for k in chunks}
    cells |= {f"fused, {case}, {k}": (fused, (case,)) for case in LOGS for k in chunks}
    cells |= {f"log, {case}, {k}": (log, (case,)) for case in LOGS for k in range(LOG_SETS // CHUNK)}
    settings = repr((CASES, HATS, LOGS, CHUNK, SAMPLES, RATE, WHITE, WALK, FLICKER))
    results = run("arrays", cells, settings=settings)
    failures: list[str] = []
    lines = [_HEAD.format(sets=SETS, samples=SAMPLES, rate=RATE), "", *_covariances(results, failures), ""]
    lines += [*_hats(results, failures), "", *_logs(results, failures), "", "## Gates", "", _GATES, ""]
    lines += failures or ["All gates are met."]
    Path("docs/study/arrays.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


def _mean(results: Mapping[str, Any], name: str, sets: int = SETS) -> dict[str, float]:
    chunks = [results[f"{name}, {k}"] for k in range(sets // CHUNK)]
    return {key: float(np.mean([chunk[key] for chunk in chunks])) for key in chunks[0]}


def _error(sets: int) -> float:
    """Three standard errors of a share of 95 % of the sets."""
    return 3 * math.sqrt(LEVEL * (1 - LEVEL) / sets)


def _judge(failures: list[str], what: str, share: float, *, at_least: bool = False, sets: int = SETS) -> str:
    """The share in per cent; a failure if it is not 95 % within three standard errors of the sets."""
    if share < LEVEL - _error(sets) or (not at_least and share > LEVEL + _error(sets)):
        failures.append(f"- {what}: {100 * share:.1f} %")
    return f"{100 * share:.1f}"


def _alarms(failures: list[str], what: str, share: float, sets: int = SETS) -> str:
    if share > 1 - LEVEL + _error(sets):
        failures.append(f"- {what}: {100 * share:.1f} %")
    return f"{100 * share:.1f}"


def _covariances(results: Mapping[str, Any], failures: list[str]) -> list[str]:
    lines = ["## Covariance matrices and weights", "", _COVARIANCES, ""]
    kinds = [f"{kind} {term}" for kind in ("coefficient", "correlation", "weight") for term in TERMS]
    lines += ["| sensors | N | slow | r of N | r of slow | w for N | w for slow |", "|---" * 7 + "|"]
    for case in CASES:
        row = _mean(results, f"covariance, {case}")
        cells = [_judge(failures, f"{case}, {kind}", row[kind]) for kind in kinds]
        lines.append(f"| {case} | {' | '.join(cells)} |")
    equal = _mean(results, "covariance, 4 equal")
    alarm = _alarms(failures, "4 equal, called correlated", equal["correlated"])
    better = _alarms(failures, "4 equal, weights for N called better", equal["equal random_walk"])
    slower = _alarms(failures, "4 equal, weights for the slow noise called better", equal["equal slow"])
    refused = sum(
        results[f"covariance, {case}, {k}"].get("refused", 0.0) for case in CASES for k in range(SETS // CHUNK)
    )
    sets = len(CASES) * SETS
    return [*lines, "", _ALARMS.format(alarm=alarm, better=better, slower=slower, refused=refused, sets=sets)]


def _hats(results: Mapping[str, Any], failures: list[str]) -> list[str]:
    lines = ["## N-cornered hat", "", _HATS, "", "| sensors | N | slow | limits of slow |", "|---" * 4 + "|"]
    for case in HATS:
        row = _mean(results, f"hat, {case}")
        cells = [_judge(failures, f"hat, {case}, {term}", row[f"coefficient {term}"]) for term in TERMS]
        lines.append(f"| {case} | {' | '.join(cells)} | {100 * row['limits slow']:.0f} |")
    return lines


def _logs(results: Mapping[str, Any], failures: list[str]) -> list[str]:
    lines = ["## Fused logs", "", _FUSED, "", "| sensors | fused log | second half |", "|---" * 3 + "|"]
    for case in LOGS:
        row = _mean(results, f"fused, {case}")
        cells = [_judge(failures, f"fused, {case}, {key}", row[key], at_least=True) for key in ("fused", "half")]
        lines.append(f"| {case} | {' | '.join(cells)} |")
    lines += ["", _LOGS.format(sets=LOG_SETS), ""]
    lines += ["| sensors | fused log | second half | weights | called correlated | misfit |", "|---" * 6 + "|"]
    for case in LOGS:
        row, sets = _mean(results, f"log, {case}", LOG_SETS), LOG_SETS
        cells = [
            _judge(failures, f"log, {case}, {key}", row[key], at_least=True, sets=sets) for key in ("fused", "half")
        ]
        cells.append(_judge(failures, f"log, {case}, weights", row["weight"], sets=sets))
        cells.append(_alarms(failures, f"log, {case}, called correlated", row["correlated"], sets))
        lines.append(f"| {case} | {' | '.join(cells)} | {100 * row['misfit']:.1f} |")
    return lines


_HEAD = """# Arrays

Made by `make study` (studies/arrays.py); the seeds are derived from the names of the rows. `sigmatau array` estimates the
covariance of the noise of several sensors, and the weights of a virtual sensor.

{sets} simulated sets for each row where no other number is given, of {samples} samples at {rate:g} Hz. All numbers are in
per cent."""

_COVARIANCES = """Share of the 95 % intervals and limits that contain the truth, for random walk (N) and the slow noise: rate
random walk, or bias instability in the row with flicker. *r*: correlation of a pair; *w*: weights that minimise a term."""

_ALARMS = """Of the sets of four equal, independent sensors, {alarm} % have a pair that is called correlated. Weights are
called better than equal ones in {better} % for N, and in {slower} % for the slow noise. In {refused:.0f} of {sets} sets,
weights for the slow noise were refused, because the record determines its covariance too weakly; they are not counted."""

_HATS = """Independent sensors with a common disturbance that is larger than their noise at all averaging times. *Limits*:
share of the coefficients of slow noise that have a limit only."""

_FUSED = """Share of the sets whose weighted mean has its Allan deviation in the predicted band at all averaging times; and
the same for the second half, with weights and prediction from the first half alone. Independent sensors; weights for N."""

_LOGS = """{sets} logs for each row, analysed by `analyze_array` as a user does, with components from the fits of the
sensors; coverage of the weights; logs in which a pair of independent sensors is called correlated, or the model does not
fit."""

_GATES = """Coverage is 95 %, at least 95 % of the fused logs are in their band, and at most 5 % of the sets name a
correlation or better weights that do not exist, all within 3 standard errors of the simulation. Cells that fail are listed,
not repeated."""


if __name__ == "__main__":
    main()
