"""Random walk of records that are not ideal: filters, lines, warm-up, spikes, noise that is not Gaussian."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import sigmatau as st
from studies.mixtures import si
from studies.runner import run

Floats = NDArray[np.float64]
RECORDS = 200
PARTS = 4
N, RATE = 2**18, 100.0
TRUTH = si(random_walk="0.3 deg/sqrt(h)", bias_instability="10.08 deg/h", rate_random_walk="21.6 deg/h/sqrt(h)")
_DEGREE = math.pi / 180
_SIGMA = TRUTH["random_walk"] * math.sqrt(RATE)


def _low_pass(y: Floats, _: np.random.Generator) -> Floats:
    from scipy.signal import lfilter

    decay = math.exp(-2 * math.pi * 30 / RATE)
    return np.asarray(lfilter([1 - decay], [1, -decay], y))


def _butterworth(y: Floats, _: np.random.Generator) -> Floats:
    from scipy.signal import butter, lfilter

    numerator, denominator = butter(2, 20, fs=RATE)
    return np.asarray(lfilter(numerator, denominator, y))


def _line(y: Floats, rng: np.random.Generator) -> Floats:
    phase = 2 * np.pi * 23.3 * np.arange(N) / RATE + rng.uniform(0, 2 * np.pi)
    return np.asarray(y + 0.05 * _DEGREE * np.sin(phase))


def _warm_up(y: Floats, _: np.random.Generator) -> Floats:
    return y + 0.02 * _DEGREE * np.exp(-np.arange(N) / RATE / 600)


def _spikes(y: Floats, rng: np.random.Generator) -> Floats:
    y = y.copy()
    y[rng.choice(N, 30, replace=False)] += 10 * _SIGMA
    return y


def _heavy_tails(y: Floats, rng: np.random.Generator) -> Floats:
    return y + _SIGMA * math.sqrt(3 / 5) * rng.standard_t(5, N)


def _varying(y: Floats, rng: np.random.Generator) -> Floats:
    power = 1 + 0.3 * np.sin(2 * np.pi * np.arange(N) / N + rng.uniform(0, 2 * np.pi))
    return y + _SIGMA * np.sqrt(power) * rng.standard_normal(N)


# name: (change of the record, whether it includes the white noise)
CASES: dict[str, tuple[Callable[[Floats, np.random.Generator], Floats] | None, bool]] = {
    "ideal": (None, False),
    "first-order low-pass, 30 Hz": (_low_pass, False),
    "Butterworth low-pass, 20 Hz": (_butterworth, False),
    "line at 23.3 Hz as large as the noise": (_line, False),
    "warm-up of 0.02 deg/s in 600 s": (_warm_up, False),
    "30 spikes of 10 sigma": (_spikes, False),
    "white noise with t5 tails": (_heavy_tails, True),
    "white noise that varies by 30 % in power": (_varying, True),
}


def cell(seed: int, case: str) -> list[dict[str, Any]]:
    """Fits of a part of the records."""
    degrade, brings_white = CASES[case]
    truth = {term: value for term, value in TRUTH.items() if not (brings_white and term == "random_walk")}
    model = st.NoiseModel(channels={"gyro_x": truth})
    rng = np.random.default_rng(seed)
    results = []
    for _ in range(RECORDS // PARTS):
        record = st.simulate(model, duration=N / RATE, rate=RATE, rng=rng)
        if degrade is not None:
            rates = degrade(np.array(record.streams[0].column("gyro_x")), rng)
            record = st.Record.from_arrays(rate=RATE, gyro_x=rates, unit={"gyro": "rad/s"})
        fitted = st.fit(st.allan(record, threads=1)["gyro_x"])
        results.append(
            {
                "verdict": fitted.verdict,
                "tau_min": fitted.tau_min,
                "process": bool(fitted.gauss_markov),
                "terms": {name: [t.observed, t.value, t.low, t.high, t.upper_limit] for name, t in fitted.items()},
            }
        )
    return results


def main() -> None:
    """Run the study and write docs/study/robustness.md."""
    cells = {f"{case} {k}": (cell, (case,)) for case in CASES for k in range(PARTS)}
    results = run("robustness", cells, settings=repr((RECORDS, N, RATE, TRUTH)))
    lines, failures = [_HEAD.format(records=RECORDS)], []
    for case in CASES:
        records = [record for k in range(PARTS) for record in results[f"{case} {k}"]]
        adequate = [r for r in records if r["verdict"] == "adequate"]
        refused = 1 - len(adequate) / len(records)
        row = f"| {case} | {100 * refused:.1f}"
        if not adequate:
            lines.append(row + " | | | | | | | | |")
            continue
        tau_min = np.median([r["tau_min"] for r in adequate])
        process = 100 * np.mean([r["process"] for r in adequate])
        row += f" | {tau_min:.2g} | {process:.0f}"
        for term, truth in TRUTH.items():
            stated = [r["terms"][term] for r in adequate]
            values = np.array([s[1] for s in stated if s[0]]) / truth
            covered = float(np.mean([s[2] <= truth <= s[3] if s[0] else s[4] is None or truth <= s[4] for s in stated]))
            text = f"{100 * (values.mean() - 1):+.1f} ± {100 * values.std():.1f}" if len(values) > 1 else ""
            row += f" | {text} | {100 * covered:.0f}"
            if term == "random_walk":
                error = 3 * values.std() / math.sqrt(len(values))
                if abs(values.mean() - 1) > 0.03 + error:
                    failures.append(f"- {case}: random walk biased by {100 * (values.mean() - 1):+.1f} %")
                if covered < 0.92 - 3 * math.sqrt(0.92 * 0.08 / len(stated)):
                    failures.append(f"- {case}: random walk covered in {100 * covered:.0f} %")
        lines.append(row + " |")
        if case == "ideal" and refused > 0.05 + 3 * math.sqrt(0.05 * 0.95 / len(records)):
            failures.append(f"- {100 * refused:.1f} % of the ideal records refused")
    lines += ["", _TAIL, "", "## Gates", "", *(failures or ["All gates are met."])]
    Path("docs/study/robustness.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


_HEAD = """# Robustness against filters, lines, drifts and spikes

Made by `make study` (studies/robustness.py): {records} simulated records per case of a MEMS gyro with 0.3 deg/√h, 10.08
deg/h and 21.6 deg/h/√h, 44 min at 100 Hz. The seeds are derived from the names of the cases, and `sigmatau.fit` is used
with its defaults. "Refused" is the share of records without an adequate model [%]. The other columns are for the
remaining records: median of the shortest averaging time of the fit [s], share with a process [%], and bias ± standard
deviation [%] and coverage of the 95 % intervals [%] of each term. The bias is that of the records in which the term is
observed.

| case | refused | τ_min | process | N | covers | B | covers | K | covers |
|---|---|---|---|---|---|---|---|---|---|"""

_TAIL = """In the Allan variance, spikes look like white noise: 30 spikes of 10 σ in 2^18 samples increase the random walk by
0.57 %, and the interval is that of the sum. Spikes must be removed from the samples before the curve is computed. A
warm-up looks like a rate random walk or a ramp."""

if __name__ == "__main__":
    main()
