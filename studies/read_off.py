"""Read-off of coefficients: choice and test of the rules of `sigmatau.fitting.read_off_regions`.

Each case is a mixture of terms in SI. A record is simulated, and its curve on half octaves is read by the rules in use
and by others, in which one number of one rule is changed. Two numbers judge the rule of a term: how often the term is
reported in a case that does not contain it, and in a case where it dominates the curve over a decade or more. The errors
of the reported coefficients follow.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from sigmatau.estimators.allan import allan
from sigmatau.fitting.read_off import read_off
from sigmatau.fitting.read_off_regions import LARGEST_ERROR, RULES, SMALLEST_REST, Rule
from sigmatau.model.noise_model import NoiseModel
from sigmatau.noise.terms import TERMS, avar
from sigmatau.simulation.in_memory import simulate
from sigmatau.units import to_si
from studies.runner import run

RECORDS = 200
CHANGES: list[tuple[str, tuple[float, ...]]] = [
    ("tolerance", (0.06, 0.1, 0.15)),
    ("slope_error", (0.06, 0.1, 0.2)),
    ("rest", (0.05, 0.1, 0.15, 0.2, 0.3)),
    ("gain", (1.0, 2.0, 6.0)),
    ("scatter", (0.3, 1.0)),
]
USED = "rules in use"


def _si(**coefficients: str) -> dict[str, float]:
    return {term: to_si(float(text.split()[0]), text.split()[1]) for term, text in coefficients.items()}


# name: (rate [Hz], length [s], channel, coefficients). The units of the paper are from its Tables II, IV and V; in the
# other cases two terms meet where a third could be detected.
CASES: dict[str, tuple[float, float, str, dict[str, float]]] = {
    "Q alone": (100, 7200, "gyro", _si(quantization="1 arcsec")),
    "N alone": (100, 7200, "gyro", _si(random_walk="0.1 deg/sqrt(h)")),
    "B alone": (100, 7200, "gyro", _si(bias_instability="10 deg/h")),
    "K alone": (100, 7200, "gyro", _si(rate_random_walk="10 deg/h/sqrt(h)")),
    "HG1700 gyro X": (100, 7200, "gyro", _si(quantization="5.1154 arcsec", random_walk="0.094 deg/sqrt(h)")),
    "HG1700 gyro Y": (100, 7200, "gyro", _si(quantization="1.2742 arcsec", random_walk="0.088 deg/sqrt(h)")),
    "HG1700 accel X": (100, 7200, "accel", _si(quantization="5.886e-4 m/s", rate_random_walk="0.76 m/s/h^(3/2)")),
    "HG1700 accel Z": (100, 7200, "accel", _si(quantization="6.069e-4 m/s", rate_random_walk="3.35 m/s/h^(3/2)")),
    "CIMU gyro X": (200, 7200, "gyro", _si(quantization="0.973 arcsec", random_walk="0.0015 deg/sqrt(h)")),
    "CIMU accel X": (200, 7200, "accel", _si(quantization="4.667e-4 m/s", rate_ramp="2.64 m/s/h^2")),
    "CIMU gyro Y": (200, 7200, "gyro", _si(quantization="0.517 arcsec", random_walk="0.0019 deg/sqrt(h)")),
    "HG1700 accel Y": (100, 7200, "accel", _si(quantization="6.108e-4 m/s", rate_random_walk="1.16 m/s/h^(3/2)")),
    "MotionPak II accel X": (
        100,
        7200,
        "accel",
        _si(random_walk="0.0166 m/s/sqrt(h)", bias_instability="4.36 m/s/h"),
    ),
    "MotionPak II gyro X": (100, 7200, "gyro", _si(random_walk="0.512 deg/sqrt(h)", bias_instability="13.6 deg/h")),
    "MEMS, N B K": (
        100,
        10485,
        "gyro",
        _si(random_walk="0.3 deg/sqrt(h)", bias_instability="10.08 deg/h", rate_random_walk="21.6 deg/h/sqrt(h)"),
    ),
    "N and K, no B": (100, 7200, "gyro", _si(random_walk="0.3 deg/sqrt(h)", rate_random_walk="30 deg/h/sqrt(h)")),
    "N and strong K, no B": (
        100,
        7200,
        "gyro",
        _si(random_walk="0.1 deg/sqrt(h)", rate_random_walk="300 deg/h/sqrt(h)"),
    ),
    "N and R": (100, 7200, "gyro", _si(random_walk="0.3 deg/sqrt(h)", rate_ramp="30 deg/h^2")),
    "Q and B": (100, 7200, "gyro", _si(quantization="1 arcsec", bias_instability="0.036 deg/h")),
    "Q and larger B": (100, 7200, "gyro", _si(quantization="1 arcsec", bias_instability="0.1 deg/h")),
    "B and R": (100, 7200, "gyro", _si(bias_instability="10 deg/h", rate_ramp="470 deg/h^2")),
    "N and larger R": (100, 7200, "gyro", _si(random_walk="0.3 deg/sqrt(h)", rate_ramp="424 deg/h^2")),
    "N and larger K, no B": (
        100,
        7200,
        "gyro",
        _si(random_walk="0.3 deg/sqrt(h)", rate_random_walk="85 deg/h/sqrt(h)"),
    ),
}


def tried() -> dict[str, dict[str, Rule]]:
    """Sets of rules by name: the rules in use, and for each term rules with one changed number."""
    sets = {USED: dict(RULES)}
    for term, rule in RULES.items():
        for field, values in CHANGES:
            for value in values:
                if value != getattr(rule, field):
                    sets[f"{term} {field} {value:g}"] = dict(RULES) | {term: replace(rule, **{field: value})}
    return sets


def cell(seed: int, case: str) -> dict[str, Any]:
    """Readings of one case: ``{term: [[value, δ], …]}`` for the rules in use; for another set, the count of its changed
    term.
    """
    rate, duration, stream, coefficients = CASES[case]
    channel = f"{stream}_x"
    model = NoiseModel(channels={channel: coefficients})
    rng = np.random.default_rng(seed)
    used: dict[str, list[list[float]]] = {}
    counts = dict.fromkeys((name for name in tried() if name != USED), 0)
    for _ in range(RECORDS):
        curve = allan(simulate(model, duration=duration, rate=rate, rng=rng), threads=1)[channel]
        for term, c in read_off(curve).items():
            used.setdefault(term, []).append([c.value, c.percentage])
        for name, rules in tried().items():
            if name != USED:
                counts[name] += name.split()[0] in read_off(curve, rules=rules)
    return {USED: used, **counts}


def dominated(case: str) -> dict[str, float]:
    """Decades of τ, up to a quarter of the record, over which a term is 90 % of the variance or more."""
    rate, duration, _, coefficients = CASES[case]
    m = np.unique(np.geomspace(1, rate * duration / 4, 400).astype(int))
    parts = {term: avar(term, value, m=m, tau0=1 / rate) for term, value in coefficients.items()}
    total = np.sum(list(parts.values()), axis=0)
    result = {}
    for term, part in parts.items():
        inside = m[part >= 0.9 * total]
        result[term] = float(np.log10(inside[-1] / inside[0])) if len(inside) > 1 else 0.0
    return result


def main() -> None:
    """Run the study and write docs/study/read-off.md."""
    settings = repr((RECORDS, CHANGES, RULES, CASES, LARGEST_ERROR, SMALLEST_REST))
    results = run("read_off", {case: (cell, (case,)) for case in CASES}, settings=settings)
    ruled = {case: dominated(case) for case in CASES}
    lines = [_HEAD.format(records=RECORDS, cases=len(CASES))]
    for term, rule in RULES.items():
        for field, values in CHANGES:
            for value in sorted({*values, getattr(rule, field)}):
                name = USED if value == getattr(rule, field) else f"{term} {field} {value:g}"
                false, where = _false(results, name, term)
                mark = "**" if name == USED else ""
                detected = _detected(results, name, term, ruled)
                lines.append(f"| {term} | {field} | {mark}{value:g}{mark} | {false:.1f} | {where} | {detected:.0f} |")
    lines.append(_SECOND)
    for case in CASES:
        for term in TERMS:
            row = _row(case, term, results[case][USED].get(term, []), ruled[case])
            if row is not None:
                lines.append(row)
    Path("docs/study/read-off.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


def _share(result: dict[str, Any], name: str, term: str) -> float:
    """Share of the records of a case in which a term is reported. [%]"""
    return 100 * (len(result[USED].get(term, [])) if name == USED else result[name]) / RECORDS


def _false(results: dict[str, Any], name: str, term: str) -> tuple[float, str]:
    """Largest share of records of a case without the term in which it is reported, and the case. [%]"""
    cells = {case: _share(results[case], name, term) for case, (_, _, _, truth) in CASES.items() if term not in truth}
    where = max(cells, key=lambda case: cells[case])
    return cells[where], where if cells[where] else "none"


def _detected(results: dict[str, Any], name: str, term: str, ruled: dict[str, dict[str, float]]) -> float:
    """Mean share of records in which the term is reported, over the cases in which it dominates a decade. [%]"""
    return float(np.mean([_share(results[case], name, term) for case in CASES if ruled[case].get(term, 0) >= 1]))


def _row(case: str, term: str, readings: list[list[float]], ruled: dict[str, float]) -> str | None:
    truth = CASES[case][3]
    share = f"{100 * len(readings) / RECORDS:.1f}"
    if term not in truth:
        return f"| {case} | {term} | absent | {share} | | | |" if readings else None
    if not readings:
        return f"| {case} | {term} | {ruled[term]:.1f} | {share} | | | |"
    values = np.array(readings)
    ratio = values[:, 0] / abs(truth[term])
    bias, stated = 100 * (ratio.mean() - 1), 100 * values[:, 1].mean()
    spread = f"{100 * ratio.std(ddof=1):.1f}" if len(ratio) > 1 else ""
    return f"| {case} | {term} | {ruled[term]:.1f} | {share} | {bias:+.1f} | {spread} | {stated:.1f} |"


_HEAD = """# Accuracy of coefficients read off the curve

Made by `make study` (studies/read_off.py): {cases} cases with {records} simulated records each, at half octaves; the
seeds are derived from the names of the cases. Each row changes one number of the rule of one term
(`sigmatau.fitting.read_off_regions.Rule`); bold is the rule in use.

- false: share of records in which the term is reported although the record does not contain it, for the worst case; "in"
  names this case.
- found: mean share of records in which the term is reported, over the cases in which it is 90 % of the variance over at
  least one decade of τ (up to a quarter of the record).

| term | number | value | false [%] | in | found [%] |
|---|---|---|---|---|---|"""

_SECOND = """
## All cases with the rules in use

"Decades" is the range of τ in which the term is 90 % of the variance. "Stated" is the mean error by eq. (26). Bias and
standard deviation of the reported values are in per cent of the true value. The stated errors are not the true errors: most
are larger, because many points carry a line; a few are smaller. A term that is there and has no line of its own biases the
lines beside it.

| case | term | decades | reported [%] | bias [%] | sd [%] | stated [%] |
|---|---|---|---|---|---|---|"""

if __name__ == "__main__":
    main()
