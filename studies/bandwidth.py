"""Fig. 12 of the paper: a sensor with a bandwidth of 30 Hz, sampled at 10 to 2000 Hz without an anti-alias filter.

The sampled processes are exact: an AR(1) process for the first-order filter, and for the second-order Butterworth filter
two states with the transition and noise of the continuous system over a sample interval.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import sigmatau as st
from sigmatau.noise.terms import aliasing_inflation
from studies.runner import run

Floats = NDArray[np.float64]

RECORDS = 100
PARTS = 4
BANDWIDTH = 30.0
RATES = (10.0, 50.0, 100.0, 500.0, 1000.0, 2000.0)
DURATION = 2000.0
TAU_MIN = 4.0
"""754 time constants of the first-order filter: N is still 0.1 % too small, and the error of a mean is 0.4 %."""
STATED = {1: (3.070, 1.405, 1.131, 1.006), 2: (2.58, 1.118, 1.009)}
"""Ratios stated for the first rates, from the folded spectrum at frequency 0."""


def filtered_white(n: int, *, rate: float, bandwidth: float, order: int, rng: np.random.Generator) -> Floats:
    """Samples of white noise of unit two-sided density after a Butterworth filter of order 1 or 2; shape (n,)."""
    from scipy.signal import lfilter

    w = 2 * math.pi * bandwidth
    if order == 1:
        p = math.exp(-w / rate)
        noise = rng.standard_normal(n) * math.sqrt(w / 2 * (1 - p * p))
        first = rng.standard_normal() * math.sqrt(w / 2)
        return np.asarray(lfilter([1.0], [1.0, -p], noise, zi=[p * first])[0])
    transition, covariance = _two_states(w, 1 / rate)
    noises = rng.standard_normal((n, 2)) @ np.linalg.cholesky(covariance).T
    # Stationary start: the position has the variance w/(2√2), the velocity w² times that, and both are independent.
    spread = math.sqrt(w / (2 * math.sqrt(2)))
    noises[0] += transition @ (rng.standard_normal(2) * [spread, w * spread])
    # Recursion of the position: (1 − tr z + det z²) x = (1 − F₁₁ z) e₀ + F₀₁ z e₁, with z the delay by one sample.
    drive = noises[:, 0].copy()
    drive[1:] += transition[0, 1] * noises[:-1, 1] - transition[1, 1] * noises[:-1, 0]
    return np.asarray(lfilter([1.0], [1.0, -np.trace(transition), np.linalg.det(transition)], drive))


def _two_states(w: float, step: float) -> tuple[Floats, Floats]:
    """Transition of position and velocity over a step, and the covariance of the noise during the step."""
    from scipy.linalg import expm

    system = np.array([[0.0, 1.0], [-w * w, -math.sqrt(2) * w]])
    transition = np.asarray(expm(system * step))
    stationary = np.diag([1.0, w * w]) * w / (2 * math.sqrt(2))
    return transition, stationary - transition @ stationary @ transition.T


def cell(seed: int, order: int, rate: float) -> list[float]:
    """Fit the random walks of a part of the records from `TAU_MIN` on."""
    rng = np.random.default_rng(seed)
    walks = []
    for _ in range(RECORDS // PARTS):
        y = filtered_white(round(DURATION * rate), rate=rate, bandwidth=BANDWIDTH, order=order, rng=rng)
        curve = st.allan(st.Record.from_arrays(rate=rate, gyro_x=y), threads=1)["gyro_x"]
        value = st.fit(curve, terms=["random_walk"], tau_min=TAU_MIN)["random_walk"].value
        walks.append(math.nan if value is None else value)
    return walks


def main() -> None:
    """Run the study and write docs/study/bandwidth.md."""
    cells = {
        f"order {order} {rate:g} Hz {k}": (cell, (order, rate))
        for order in (1, 2)
        for rate in RATES
        for k in range(PARTS)
    }
    results = run("bandwidth", cells, settings=repr((RECORDS, PARTS, BANDWIDTH, DURATION, TAU_MIN)))
    lines, failures = [_HEAD], []
    for k, rate in enumerate(RATES):
        row = f"| {rate:g} | {rate / BANDWIDTH:.3g}"
        for order in (1, 2):
            values = np.array([v for part in range(PARTS) for v in results[f"order {order} {rate:g} Hz {part}"]])
            mean, error = float(values.mean()), float(values.std(ddof=1)) / math.sqrt(len(values))
            law = aliasing_inflation(rate=rate, bandwidth=BANDWIDTH, order=order)
            stated = STATED[order][k] if k < len(STATED[order]) else law
            row += f" | {mean:.4f} ± {error:.4f} | {law:.4f} | {(mean - stated) / error:+.1f}"
            if not abs(mean - stated) <= 3 * error:
                failures.append(f"- order {order}, {rate:g} Hz: {mean:.4f} ± {error:.4f}, not {stated}")
        lines.append(row + " |")
    lines += [
        "",
        _TAIL,
        "",
        "## Gates",
        "",
        *(failures or ["All means are within 3 standard errors of the stated values."]),
    ]
    Path("docs/study/bandwidth.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


_HEAD = f"""# Bandwidth and sampling rate

Made by `make study` (studies/bandwidth.py). This study repeats Fig. 12 of the paper: white noise with random walk N,
low-pass filtered at {BANDWIDTH:g} Hz and sampled without an anti-alias filter. Each cell has {RECORDS} records of
{DURATION:g} s. The sampled processes are exact, and the seeds are derived from the names of the cells. N_eff/N is the
random walk that `sigmatau.fit` finds from τ = {TAU_MIN:g} s on, relative to the true one: mean of the records and its
standard error. "Law" is the folded spectrum at frequency 0, `sigmatau.noise.terms.aliasing_inflation`. z is the deviation
from the stated value (3.070, 1.405, 1.131, 1.006 and 2.58, 1.118, 1.009; the law for the other rates) in standard errors.

| rate [Hz] | over bandwidth | first order | law | z | second-order Butterworth | law | z |
|---|---|---|---|---|---|---|---|"""

_TAIL = """![Allan deviation at six sampling rates](../figures/bandwidth.svg)

The paper chooses 100 Hz for such a sensor, by the rule of 3 to 5 times the bandwidth. This sampling rate increases the
random walk by 13 % with a first-order filter and by 0.9 % with a second-order filter. The curves of 10 and 50 Hz in Fig.
12 are higher because of this aliasing, not because of long averaging times. At short times the filter removes noise: σ(τ)
follows the line of slope -1/2 only from about ten time constants of the filter on."""

if __name__ == "__main__":
    main()
