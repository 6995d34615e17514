"""Coverage of the intervals, false terms, and false misfits of the fit of a curve."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

import sigmatau as st
from sigmatau.fitting.planning import smallest_significant
from sigmatau.noise.terms import BIAS_LEVEL, NOISE
from studies.mixtures import ABSENT, SHORT, Mixture
from studies.runner import run

RECORDS = 1000
ABSENT_RECORDS = 2000
TIMES = (1.0, 1.5, 2.0, 3.0, 5.0, 10.0)
PARTS = 4

# term sought, and the other terms of the record
SOUGHT: dict[str, tuple[str, dict[str, float]]] = {
    "Q beside N, B": ("quantization", {"random_walk": 1.0, "bias_instability": 0.1}),
    "N beside Q, B": ("random_walk", {"quantization": 30.0, "bias_instability": 0.1}),
    "N beside B, K": ("random_walk", {"bias_instability": 0.1, "rate_random_walk": 1e-3}),
    "B beside N": ("bias_instability", {"random_walk": 1.0}),
    "B beside N, K": ("bias_instability", {"random_walk": 1.0, "rate_random_walk": 1e-3}),
    "K beside N": ("rate_random_walk", {"random_walk": 1.0}),
    "K beside N, B": ("rate_random_walk", {"random_walk": 1.0, "bias_instability": 0.1}),
    "K beside Q": ("rate_random_walk", {"quantization": 30.0}),
}
_N = 2**15

# Case of likelihood intervals: their median 95 % upper limits, in units of _ONE_SIGMA, by true value.
LIMIT_RECORDS = 400
_LIMIT_BACKGROUND = {"random_walk": 1.0, "bias_instability": 0.1}
_ONE_SIGMA = 1.1595e-3
PROFILE = {0.0: 1.6, 0.5: 1.75, 1.0: 2.2, 1.5: 2.7, 2.0: 3.4, 3.0: 4.4, 5.0: 6.6}


def sought(seed: int, name: str, times: float) -> list[dict[str, Any]]:
    """Statements of a fit on every noise term, for a part of the records of a cell."""
    term, background = SOUGHT[name]
    value = times * smallest_significant(background, term, n=_N, tau0=1.0, power=0.5)
    return _stated(seed, Mixture(_N, 1.0, {**background, term: value}), RECORDS // PARTS)


def absent(seed: int, name: str) -> list[dict[str, Any]]:
    """Statements of a fit, for a mixture that lacks terms."""
    return _stated(seed, ABSENT[name], ABSENT_RECORDS // PARTS)


def limit(seed: int, times: float) -> list[dict[str, Any]]:
    """Rate random walk with white and flicker noise, in units of the standard error of θ of an absent walk."""
    return _stated(
        seed, Mixture(_N, 1.0, {**_LIMIT_BACKGROUND, "rate_random_walk": times * _ONE_SIGMA}), LIMIT_RECORDS // PARTS
    )


def _stated(seed: int, mixture: Mixture, records: int) -> list[dict[str, Any]]:
    model = st.NoiseModel(channels={mixture.channel: mixture.truth})
    rng = np.random.default_rng(seed)
    results = []
    for _ in range(records):
        curve = st.allan(st.simulate(model, duration=mixture.n / mixture.rate, rate=mixture.rate, rng=rng), threads=1)[
            mixture.channel
        ]
        fitted = st.fit(curve)
        valley = float(curve.adev[curve.m <= curve.n // 4].min() / BIAS_LEVEL)
        results.append(
            {
                "verdict": fitted.verdict,
                "moved": fitted.tau_min is None or fitted.tau_min > 1.5 * curve.tau0,
                "extra": len(fitted.gauss_markov),
                "p": fitted.p_value,
                "valley": valley,
                "terms": {name: [t.observed, t.value, t.low, t.high, t.upper_limit] for name, t in fitted.items()},
            }
        )
    return results


def main() -> None:
    """Run the study and write docs/study/coverage.md."""
    cells: dict[str, Any] = {
        f"{name} x{times:g} {k}": (sought, (name, times)) for name in SOUGHT for times in TIMES for k in range(PARTS)
    }
    cells |= {f"absent from {name} {k}": (absent, (name,)) for name in ABSENT for k in range(PARTS)}
    cells |= {f"limit {times:g} {k}": (limit, (times,)) for times in PROFILE for k in range(PARTS)}
    results = run("coverage", cells, settings=repr((RECORDS, ABSENT_RECORDS, SOUGHT, TIMES, SHORT)))
    failures: list[str] = []
    lines = [_HEAD.format(records=RECORDS, n=_N), *_coverage(results, failures)]
    lines += [_ABSENT.format(records=ABSENT_RECORDS), *_false_alarms(results, failures)]
    lines += [_GOODNESS, *_goodness(results, failures), _VALLEY, *_valley(results, failures)]
    lines += [_LIMITS.format(records=LIMIT_RECORDS), *_limits(results)]
    lines += ["", "## Gates", "", *(failures or ["All gates are met."])]
    Path("docs/study/coverage.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


def _all(results: dict[str, Any], name: str) -> list[dict[str, Any]]:
    return [record for k in range(PARTS) for record in results[f"{name} {k}"]]


def _holds(stated: list[Any], value: float) -> bool:
    observed, _, low, high, limit = stated
    if observed:
        return bool(low <= value <= high)
    return limit is None or value <= limit


def _coverage(results: dict[str, Any], failures: list[str]) -> list[str]:
    lines, pooled = [], []
    for name, (term, background) in SOUGHT.items():
        detectable = smallest_significant(background, term, n=_N, tau0=1.0, power=0.5)
        for times in TIMES:
            records = [r for r in _all(results, f"{name} x{times:g}") if r["verdict"] == "adequate"]
            value = times * detectable
            stated = [r["terms"][term] for r in records]
            observed = [s for s in stated if s[0]]
            hold, hold_observed = (np.array([_holds(s, value) for s in group]) for group in (stated, observed))
            hold_background = np.array(
                [_holds(r["terms"][other_term], c) for r in records for other_term, c in background.items()]
            )
            width = np.median([(s[3] - s[2]) / 2 for s in observed]) / value if observed else math.nan
            lines.append(
                f"| {name} | {times:g} | {100 * len(observed) / len(stated):.1f} | {100 * hold.mean():.1f} |"
                f" {100 * hold_observed.mean():.1f} | {100 * width:.0f} | {100 * hold_background.mean():.1f} |"
            )
            if times > 1:
                pooled.append(hold)
                for which, cover in (("all", hold), ("observed", hold_observed)):
                    error = math.sqrt(0.92 * 0.08 / len(cover))
                    if cover.mean() < 0.92 - 3 * error:
                        failures.append(f"- {name}, {times:g} times, {which}: {100 * cover.mean():.1f} % covered")
    together = np.concatenate(pooled)
    error = math.sqrt(0.95 * 0.05 / len(together))
    lines += ["", f"Coverage of all cells from 1.5 times on: {100 * together.mean():.2f} % (limits 94 and 98.5 %)."]
    if not 0.94 - 3 * error <= together.mean() <= 0.985 + 3 * error:
        failures.append(f"- pooled coverage {100 * together.mean():.2f} %")
    return lines


def _false_alarms(results: dict[str, Any], failures: list[str]) -> list[str]:
    lines = []
    for name, mixture in ABSENT.items():
        records = [r for r in _all(results, f"absent from {name}") if r["verdict"] == "adequate"]
        shares = []
        for term in (*NOISE, "rate_ramp"):
            if term in mixture.truth:
                shares.append("")
                continue
            share = float(np.mean([r["terms"][term][0] for r in records]))
            shares.append(f"{100 * share:.1f}")
            if share > 0.065 + 3 * math.sqrt(0.065 * 0.935 / len(records)):
                failures.append(f"- {term} found in {100 * share:.1f} % of the records of {name}")
        lines.append(f"| {name} | {' | '.join(shares)} |")
    return lines


def _goodness(results: dict[str, Any], failures: list[str]) -> list[str]:
    lines = []
    for name in ABSENT:
        records = _all(results, f"absent from {name}")
        p = np.array([0.0 if r["moved"] or r["p"] is None else r["p"] for r in records])
        moved = float(np.mean([r["moved"] for r in records]))
        refused = float(np.mean([r["verdict"] != "adequate" for r in records]))
        extra = float(np.mean([r["extra"] > 0 for r in records]))
        size = float((p < 0.05).mean())
        lines.append(
            f"| {name} | {100 * size:.1f} | {100 * (p < 0.01).mean():.1f} | {100 * moved:.1f} | {100 * extra:.1f} |"
            f" {100 * refused:.1f} |"
        )
        allowed = 0.05 + 3 * math.sqrt(0.05 * 0.95 / len(records))
        for event, share in (("p < 0.05", size), ("τ_min moved", moved), ("refused", refused)):
            if share > allowed:
                failures.append(f"- {name}: {event} in {100 * share:.1f} % of the records")
    return lines


def _valley(results: dict[str, Any], failures: list[str]) -> list[str]:
    lines = []
    for name, mixture in ABSENT.items():
        if "bias_instability" in mixture.truth or "random_walk" not in mixture.truth:
            continue
        records = [r for r in _all(results, f"absent from {name}") if r["verdict"] == "adequate"]
        share_observed = float(np.mean([r["terms"]["bias_instability"][0] for r in records]))
        valley = np.median([r["valley"] for r in records])
        lines.append(f"| {name} | {100 * share_observed:.1f} | 100 | {valley:.3g} |")
        if share_observed > 0.065 + 3 * math.sqrt(0.065 * 0.935 / len(records)):
            failures.append(f"- bias instability invented in {100 * share_observed:.1f} % of the records of {name}")
    return lines


def _limits(results: dict[str, Any]) -> list[str]:
    lines = []
    for times, profile in PROFILE.items():
        records = [r for r in _all(results, f"limit {times:g}") if r["verdict"] == "adequate"]
        value = times * _ONE_SIGMA
        stated = [r["terms"]["rate_random_walk"] for r in records]
        ends = np.array([s[3] if s[0] else s[4] for s in stated])
        observed = 100 * np.mean([s[0] for s in stated])
        hold, above = (100 * np.mean(x) for x in ([_holds(s, value) for s in stated], ends >= value))
        lines.append(
            f"| {times:g} | {observed:.0f} | {hold:.1f} | {above:.1f} | {np.median(ends) / _ONE_SIGMA:.2f} | {profile:g} |"
        )
    return lines


_HEAD = """# Coverage of the intervals

Made by `make study` (studies/coverage.py). Each cell has {records} simulated records of {n} samples, with seeds derived
from the names of the cells. `sigmatau.fit` chooses the terms and the averaging times for each record. The columns are:

- times: true coefficient, divided by the coefficient that is observed in half of the records. The latter is computed in
  advance from the other terms by `sigmatau.fitting.planning.smallest_significant`.
- found: share of records in which the term is observed.
- covered: share of records whose interval contains the true value. The interval is [low, high] if the term is observed, and
  [0, limit] otherwise. "Covered, found" counts only records in which the term is observed.
- half width: median of (high − low)/2 in per cent of the coefficient.
- others covered: coverage of the intervals of the other terms of the mixture.

| term | times | found [%] | covered [%] | covered, found [%] | half width [%] | others covered [%] |
|---|---|---|---|---|---|---|"""

_ABSENT = """
## Absent terms

{records} records of each mixture: share in which an absent term is observed; nominal value 5 %, limit 6.5 % [%]. Letters are
those of IEEE 952: Q quantization, N random walk, B bias instability, K rate random walk, R ramp.

| record of | Q | N | B | K | R |
|---|---|---|---|---|---|"""

_GOODNESS = """
## Goodness of fit with the right model

The same records. The columns give the share of records [%] with a p-value of the goodness of fit below 0.05 and 0.01 for
all averaging times, with the shortest times left out, with a Gauss–Markov process, and without an adequate model.

| record of | p < 0.05 | p < 0.01 | τ_min moved | process | refused |
|---|---|---|---|---|---|"""

_VALLEY = """
## Bias instability and the minimum of the curve

Records without bias instability. "Fit" and "lowest point" are the shares of records in which the fit, and the rule
"minimum of the curve divided by 0.664", report a bias instability; the rule always does. "Invented" is the median value
of the rule for a random walk of 1 at one sample.

| record of | fit [%] | lowest point [%] | invented |
|---|---|---|---|"""

_LIMITS = """
## Comparison of upper limits with a profile likelihood

A rate random walk in addition to a random walk of 1 and a bias instability of 0.1, {records} records per row. The
coefficient is in units of the one whose square is the standard error of an absent one (1.1595e-3). "Profile" is the
median one-sided 95 % limit of the profile likelihood of block means with a Whittle likelihood, from 250 records. Its
coverage is 100 % up to 1, and 92 to 94 % above. "Upper end" is the upper end of our 95 % interval, which is exceeded in
2.5 % of records if the term is well observed.

| coefficient | found [%] | interval covers [%] | upper end covers [%] | median upper end | profile |
|---|---|---|---|---|---|"""

if __name__ == "__main__":
    main()
