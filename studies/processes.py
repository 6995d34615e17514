"""Goodness of fit of a curve, false Gauss-Markov processes, and true processes."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import sigmatau as st
from sigmatau._native.gls import Components, Gls
from sigmatau.fitting.components import half_octaves
from sigmatau.fitting.fitted_values import Interval
from sigmatau.units import to_si
from studies.runner import run

Floats = NDArray[np.float64]

RECORDS = 200
PROCESS_RECORDS = 40
IDEAL: dict[str, dict[str, float]] = {
    "N": {"random_walk": 1.0},
    "K": {"rate_random_walk": 1.0},
    "B": {"bias_instability": 1.0},
    "N B": {"random_walk": 1.0, "bias_instability": 0.1},
    "N K": {"random_walk": 1.0, "rate_random_walk": 3e-3},
    "N B K": {"random_walk": 1.0, "bias_instability": 0.05, "rate_random_walk": 2e-3},
    "Q K": {"quantization": 1.0, "rate_random_walk": 1e-3},
    "Q N B K": {"quantization": 3.0, "random_walk": 1.0, "bias_instability": 0.1, "rate_random_walk": 3e-3},
}
LENGTHS = (2**12, 2**16)

# Correlation time [s] and standard deviation [deg/h] of processes, with 0.3 deg/√h in 3 h at 10 Hz.
PROCESSES = [(10.0, 20.0), (30.0, 20.0), (100.0, 20.0), (300.0, 20.0), (30.0, 5.0), (100.0, 5.0), (300.0, 5.0)]
_N, _RATE = 108_000, 10.0
_WHITE = to_si(0.3, "deg/sqrt(h)")
_REJECTED = 0.002


def ideal(seed: int, name: str, n: int) -> list[Any]:
    """P-value of the terms alone, and whether a process is detected, by record."""
    model, rng = st.NoiseModel(channels={"gyro_x": IDEAL[name]}), np.random.default_rng(seed)
    results = []
    for _ in range(RECORDS):
        curve = st.allan(st.simulate(model, duration=n, rate=1.0, rng=rng), taus="half", threads=1)["gyro_x"]
        fitted = st.fit(curve)
        results.append([_alone(curve, n), bool(fitted.gauss_markov), fitted.verdict, fitted.tau_min])
    return results


def _alone(curve: st.DeviationCurve, n: int) -> float:
    sizes = half_octaves(1, n // 3)
    gls = Gls(Components(n, sizes), curve.avar[: len(sizes)] / curve.avar[0])
    return gls.p_value(gls.fit())


def process(seed: int, time: float, deg_per_h: float) -> list[Any]:
    """Detection of a process, its intervals, and the excess of the model over the curve."""
    from scipy.signal import lfilter

    rng, sigma, decay = np.random.default_rng(seed), to_si(deg_per_h, "deg/h"), math.exp(-1 / (_RATE * time))
    results = []
    for _ in range(PROCESS_RECORDS):
        driven = rng.standard_normal(_N) * sigma * math.sqrt(1 - decay**2)
        driven[0] /= math.sqrt(1 - decay**2)
        rates: Floats = lfilter([1], [1, -decay], driven) + _WHITE * math.sqrt(_RATE) * rng.standard_normal(_N)
        record = st.Record.from_arrays(rate=_RATE, gyro_x=rates, unit={"gyro": "rad/s"})
        curve = st.allan(record, taus="half", threads=1)["gyro_x"]
        fitted = st.fit(curve)
        held = [_holds(process_.sigma, sigma) and _holds(process_.time, time) for process_ in fitted.gauss_markov]
        used = curve.m <= _N // 3
        above = float(np.sqrt((fitted.avar(m=curve.m[used]) / curve.avar[used]).max()))
        walk = fitted["random_walk"]
        good = walk.low is not None and walk.high is not None and walk.low <= _WHITE <= walk.high
        results.append([_alone(curve, _N), bool(held), all(held), fitted.verdict, above, good])
    return results


def _holds(interval: Interval, value: float) -> bool:
    return interval.low is not None and interval.high is not None and interval.low <= value <= interval.high


def main() -> None:
    """Run the study and write docs/study/processes.md."""
    cells: dict[str, Any] = {f"ideal {name} {n}": (ideal, (name, n)) for name in IDEAL for n in LENGTHS}
    cells |= {f"process {time:g} {size:g}": (process, (time, size)) for time, size in PROCESSES}
    results = run("processes", cells, settings=repr((RECORDS, PROCESS_RECORDS, IDEAL, PROCESSES)))
    lines, failures = [_HEAD.format(records=RECORDS)], []
    for name in IDEAL:
        for n in LENGTHS:
            rows = results[f"ideal {name} {n}"]
            p = np.array([row[0] for row in rows])
            shares = [*((p < limit).mean() for limit in (0.05, 0.01, 0.002)), np.mean([row[1] for row in rows])]
            refused = np.mean([row[2] != "adequate" for row in rows])
            moved = np.mean([row[3] is None or row[3] > 1 for row in rows])
            texts = " | ".join(f"{100 * share:.1f}" for share in (*shares, moved, refused))
            lines.append(f"| {name} | {n} | {texts} |")
            for label, share, limit in (("p < 0.05", shares[0], 0.05), ("a process", shares[3], 0.02)):
                if share > limit + 3 * math.sqrt(limit * (1 - limit) / len(rows)):
                    failures.append(f"- {name}, {n} samples: {label} in {100 * share:.1f} %")
    lines.append(_PROCESSES.format(records=PROCESS_RECORDS))
    for time, size in PROCESSES:
        rows = results[f"process {time:g} {size:g}"]
        rejected = np.array([row[0] < _REJECTED for row in rows])
        detected = np.array([row[1] for row in rows])
        either = float((detected | [row[3] != "adequate" for row in rows]).mean())
        held = np.mean([row[2] for row in rows if row[1]])
        above, walk = [row[4] for row in rows], np.mean([row[5] for row in rows])
        texts = " | ".join(f"{100 * share:.0f}" for share in (rejected.mean(), detected.mean(), either, held, walk))
        lines.append(f"| {time:g} s | {size:g} deg/h | {texts} | {np.median(above):.1f} | {max(above):.1f} |")
        if (time, size) == (100.0, 20.0) and either < 0.95 - 3 * math.sqrt(0.95 * 0.05 / len(rows)):
            failures.append(f"- {time:g} s, {size:g} deg/h: found or rejected in {100 * either:.0f} %")
    lines += ["", "## Gates", "", *(failures or ["All gates are met."])]
    Path("docs/study/processes.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


_HEAD = """# Goodness of fit of a curve, and Gauss–Markov processes

Made by `make study` (studies/processes.py), with seeds derived from the names of the cells. `sigmatau.fit` is used with its
defaults.

## Ideal records

{records} records of each mixture. The columns give the share of records [%] in which the p-value of the terms alone is below
a limit, in which a process is found that is not there, in which short times are left out, and in which no model is adequate.

| record of | samples | p < 0.05 | p < 0.01 | p < 0.002 | process | τ_min moved | refused |
|---|---|---|---|---|---|---|---|"""

_PROCESSES = """
## Records with a process

{records} records of 3 h at 10 Hz, with 0.3 deg/√h. Shares of records [%]: the terms alone have p < 0.002; the process is
found; it is found or no model is adequate; of those found, the intervals of σ and of the time both hold; the interval of the
random walk holds. Then the largest ratio of the deviation of the model to the measured one: its median and its maximum.
A record holds 36 correlation times of 300 s: walk and process are then hardly distinguished.

| time | σ | rejected | found | either | both hold | N holds | ratio | largest |
|---|---|---|---|---|---|---|---|---|"""

if __name__ == "__main__":
    main()
