"""Effect of disturbances, left out by default, on the coefficients: coverage, wrong terms, false alarms.

``python -m studies.disturbances`` writes docs/study/disturbances.md; ``--parts 1`` stops after a part of the records.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, lfilter, sosfilt

import sigmatau as st
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.quality.facts import keep_facts
from sigmatau.quality.samples.disturbances import without
from studies import false_alarms
from studies.runner import run

Floats = NDArray[np.float64]
Axes = dict[str, Floats]

RECORDS, PARTS = 200, 10
MINUTES, RATE = 20.0, 50.0
COVERED, WRONG, WARNED, LEFT_OUT = 0.92, 0.08, 0.02, 0.01

TERMS = ("random_walk", "bias_instability", "rate_random_walk")
GYRO = {"random_walk": "0.3 deg/sqrt(h)", "bias_instability": "10 deg/h", "rate_random_walk": "20 deg/h/sqrt(h)"}
ACCEL = {"random_walk": "0.06 m/s/sqrt(h)", "bias_instability": "0.04 mg", "rate_random_walk": "3 m/s/h^(3/2)"}
MODEL = {"gyro_x": GYRO, "gyro_y": GYRO, "gyro_z": GYRO, "accel_z": ACCEL}
# standard deviation of a sample
_SIGMA = {"gyro": math.radians(0.3) / 60 * math.sqrt(RATE), "accel": 0.06 / 60 * math.sqrt(RATE)}


def clean(rng: np.random.Generator, minutes: float, rate: float) -> Axes:
    """Three gyros with a bias, and an accelerometer with gravity."""
    model = st.NoiseModel.from_dict({"channels": MODEL})
    record = st.simulate(model, duration=60 * minutes, rate=rate, rng=rng)
    axes = {name: np.array(record.stream_of(name).column(name)) for name in MODEL}
    for name, mean in zip(MODEL, (0.004, -0.002, 0.001, 9.80665), strict=True):
        axes[name] += mean
    return axes


def _size(name: str) -> float:
    return _SIGMA[name.split("_")[0]]


def _ringing(axes: Axes, rng: np.random.Generator, sigmas: float, decay: float, frequency: float) -> None:
    n = len(axes["gyro_x"])
    t = np.arange(int(8 * decay * RATE)) / RATE
    place = int(rng.integers(n // 20, n - n // 20))
    for name, x in axes.items():
        wave = np.exp(-t / decay) * np.cos(2 * np.pi * frequency * t + rng.uniform(0, 6))
        x[place : place + len(t)] += rng.normal() * sigmas * _size(name) * wave


def bump(axes: Axes, rng: np.random.Generator) -> None:
    """A passer-by, three times: 15 standard deviations of a sample, decays within seconds."""
    for _ in range(3):
        _ringing(axes, rng, 15, 0.5, 7.0)


def knock(axes: Axes, rng: np.random.Generator) -> None:
    """A knock: 300 standard deviations, decays within a second."""
    _ringing(axes, rng, 300, 0.08, 15.0)


def zero_row(axes: Axes, rng: np.random.Generator) -> None:
    """One row of zeros."""
    row = int(rng.integers(1, len(axes["gyro_x"])))
    for x in axes.values():
        x[row] = 0.0


def zero_first_row(axes: Axes, rng: np.random.Generator) -> None:
    """The first row is written before the first sample."""
    for x in axes.values():
        x[0] = 0.0


def dropouts(axes: Axes, rng: np.random.Generator) -> None:
    """0.1 % of the rows are zeros."""
    lost = rng.random(len(axes["gyro_x"])) < 1e-3
    for x in axes.values():
        x[lost] = 0.0


def spikes(axes: Axes, rng: np.random.Generator) -> None:
    """1 % of the samples of each axis are spikes of random size."""
    for name, x in axes.items():
        is_spike = rng.random(len(x)) < 0.01
        x[is_spike] += rng.normal(size=int(is_spike.sum())) * 200 * _size(name)


def outlier(axes: Axes, rng: np.random.Generator) -> None:
    """One sample of 1e9 standard deviations on each axis."""
    for name, x in axes.items():
        x[int(rng.integers(len(x)))] += 1e9 * _size(name)


def start(axes: Axes, rng: np.random.Generator) -> None:
    """A filter that starts from zero."""
    for x in axes.values():
        x *= 1 - np.exp(-(np.arange(len(x)) + 0.5) / RATE / 0.5)


FAULTS: dict[str, Callable[[Axes, np.random.Generator], None]] = {
    "three bumps": bump,
    "a knock": knock,
    "a zero row": zero_row,
    "a zero first row": zero_first_row,
    "0.1 % dropouts": dropouts,
    "1 % spikes": spikes,
    "an outlier of 1e9 σ": outlier,
    "a start transient": start,
}
WARM_UP, PULSES = "a warm-up with a thermometer", "pulses of 1 to 3 σ a step"
CASES = ("nothing", *FAULTS, WARM_UP, PULSES)


def record(rng: np.random.Generator, case: str) -> st.Record:
    """A record with a fault."""
    if case == WARM_UP:
        axes = clean(rng, 60.0, RATE / 2)
        t = np.arange(len(axes["gyro_x"])) * 2 / RATE
        warmer = 15 * (1 - np.exp(-t / 1200))
        for name in ("gyro_x", "gyro_y", "gyro_z"):
            axes[name] += math.radians(5) / 3600 * warmer
        degrees = 25 + warmer + 0.02 * rng.standard_normal(len(t))
        return st.Record.from_arrays(rate=RATE / 2, **axes, temperature=degrees)  # type: ignore[arg-type]
    axes = clean(rng, MINUTES, RATE)
    if case in FAULTS:
        FAULTS[case](axes, rng)
    if case == PULSES:
        increments = {}
        for name, x in axes.items():
            step = rng.uniform(1, 3) * _size(name) / RATE
            increments[name] = np.diff(np.floor(np.cumsum(x / RATE) / step), prepend=0.0) * step
        return st.Record.from_arrays(rate=RATE, input="increments", **increments)  # type: ignore[arg-type]
    return st.Record.from_arrays(rate=RATE, **axes)  # type: ignore[arg-type]


def _wrong(fitted: NoiseFit, case: str) -> bool:
    """Whether a part is observed that is not in the record."""
    allowed = {*TERMS, *(["quantization"] if case == PULSES else [])}
    terms = any(term.observed for name, term in fitted.terms.items() if name not in allowed)
    drift = case != WARM_UP and bool(fitted.warm_up or fitted.regressors)
    return terms or drift or bool(fitted.gauss_markov or fitted.resonance or fitted.sinusoid)


def part(seed: int, case: str) -> list[dict[str, Any]]:
    """Statements on each channel, for a part of the records of a case."""
    rng, rows = np.random.default_rng(seed), []
    truth = st.NoiseModel.from_dict({"channels": MODEL})
    for _ in range(RECORDS // PARTS):
        analysis = st.analyze(record(np.random.default_rng(int(rng.integers(1 << 62))), case), threads=1)
        left_out = {code for f in analysis.findings if f.left_out for code in [f.code]}
        warnings = {f.code for f in analysis.findings if f.severity != "info"}
        for name, fitted in analysis.fits.items():
            held = []
            for term in TERMS:
                value, stated = truth[name].terms[term], fitted.terms[term]
                if stated.low is not None and stated.high is not None:
                    held.append(bool(stated.low <= value <= stated.high))
                else:
                    held.append(stated.upper_limit is not None and value <= stated.upper_limit)
            rows.append(
                {"held": held, "wrong": _wrong(fitted, case), "left": sorted(left_out), "said": sorted(warnings)}
            )
    return rows


def clean_part(seed: int, grade: str, length: str) -> list[tuple[bool, bool]]:
    """Whether clean records of six axes have a warning, and whether samples are left out."""
    rng, rows = np.random.default_rng(seed), []
    for k in range(false_alarms.A_CELL):
        clean_record = false_alarms.record(int(rng.integers(1 << 62)), grade, length, gravity=k % 2 == 0)
        findings = st.analyze(clean_record, threads=1).findings
        rows.append((any(f.severity != "info" for f in findings), any(f.left_out for f in findings)))
    return rows


FILTERS = (
    *(f"Butterworth, order {k}, 0.3 to 20 Hz" for k in (1, 2, 3, 4)),
    "mean of 2 to 200",
    "exponential, 0.02 to 2 s",
)
FILTERED, FILTERED_PARTS, FILTERED_RATE, FILTERED_SAMPLES = 200, 4, 100.0, 60_000


def filtered(rng: np.random.Generator, name: str) -> st.Record:
    """Three gyros at 100 Hz with white noise after a filter, alone or with flicker noise or a walk; half are rounded."""
    n, rate = FILTERED_SAMPLES, FILTERED_RATE
    x = rng.standard_normal((3, 2 * n))
    if name.startswith("B"):
        corner = math.exp(rng.uniform(math.log(0.3), math.log(20)))
        x = sosfilt(butter(int(name.split()[2][0]), corner / (rate / 2), output="sos"), x)
    elif name.startswith("m"):
        k = round(math.exp(rng.uniform(math.log(2), math.log(200))))
        x = lfilter(np.full(k, 1 / k), [1.0], x)
    else:
        x = lfilter([1.0], [1.0, -math.exp(-1 / rate / math.exp(rng.uniform(math.log(0.02), math.log(2))))], x)
    x = x[:, n:] / x[:, n:].std()
    f = np.fft.rfftfreq(2 * n, 1 / rate)
    f[0] = f[1]
    if slow_noise := rng.integers(3):
        slow = np.fft.irfft(np.fft.rfft(rng.standard_normal((3, 2 * n))) * f ** (-slow_noise / 2))[:, :n]
        x = x + slow / slow.std() * 10 ** rng.uniform(-1.5, 1)
    if rng.random() < 0.5:
        step = np.diff(x).std() * 10 ** rng.uniform(-2, 0.7)
        x = np.round(x / step) * step
    return st.Record.from_arrays(rate=rate, gyro=1e-3 * x.T)


def filtered_part(seed: int, name: str) -> list[list[str]]:
    """Causes by which samples of clean filtered records are left out."""
    rng, rows = np.random.default_rng(seed), []
    for _ in range(FILTERED // FILTERED_PARTS):
        with keep_facts():
            findings = without(filtered(rng, name).streams[0])[1]
        rows.append(sorted({f.code for f in findings if f.left_out}))
    return rows


def main(parts: int = PARTS) -> None:
    """Run the study and write docs/study/disturbances.md."""
    cells: dict[str, tuple[Any, tuple[Any, ...]]] = {
        f"clean {name}": (clean_part, arguments) for name, (_, arguments) in false_alarms.cells().items()
    }
    for name in FILTERS:
        cells |= {f"filtered {name} {k}": (filtered_part, (name,)) for k in range(min(parts, FILTERED_PARTS))}
    cells |= {f"{case} {k}": (part, (case,)) for k in range(parts) for case in CASES}
    results = run("disturbances", cells, settings=repr((RECORDS, PARTS, MINUTES, RATE, MODEL, CASES)))
    Path("docs/study/disturbances.md").write_text(page(results), encoding="utf-8")


def page(results: Mapping[str, Any]) -> str:
    """Page of the study, for the finished cells."""
    records = RECORDS // PARTS * sum(name.startswith(f"{PULSES} ") for name in results)
    lines, fails = [_HEAD.format(records=records, covered=100 * COVERED, wrong=100 * WRONG)], []
    for case in CASES:
        rows = [row for name, some in results.items() if name.rpartition(" ")[0] == case for row in some]
        n = len(rows)
        shares = [sum(row["held"][k] for row in rows) / n for k in range(len(TERMS))]
        wrong = sum(row["wrong"] for row in rows) / n
        share_left = sum(bool(row["left"]) for row in rows) / n
        share_warned = sum(bool(row["said"]) for row in rows) / n
        values = " | ".join(f"{100 * share:.1f}" for share in (*shares, wrong, share_left, share_warned))
        lines.append(f"| {case} | {n} | {values} |")
        slack = 3 * math.sqrt(COVERED * (1 - COVERED) / n)
        if min(shares) < COVERED - slack or wrong > WRONG + slack:
            fails.append(case)
    every = [one for name, some in results.items() if name.startswith("clean ") for one in some]
    shares = [sum(one[k] for one in every) / len(every) for k in range(2)]
    for share, limit, event in zip(shares, (WARNED, LEFT_OUT), ("warnings", "left out"), strict=True):
        if share > limit + 3 * math.sqrt(limit * (1 - limit) / len(every)):
            fails.append(f"clean records, {event}")
    rows = []
    for name in FILTERS:
        lost = [causes for cell, some in results.items() if cell.startswith(f"filtered {name}") for causes in some]
        share = sum(map(bool, lost)) / len(lost)
        rows.append(
            f"| {name} | {len(lost)} | {100 * share:.1f} | {', '.join(sorted({c for causes in lost for c in causes}))} |"
        )
        if share > LEFT_OUT + 3 * math.sqrt(LEFT_OUT * (1 - LEFT_OUT) / len(lost)):
            fails.append(name)
    warned, out = (100 * share for share in shares)
    lines.append(_CLEAN.format(records=len(every), warned=warned, left=out, w=100 * WARNED, o=100 * LEFT_OUT))
    lines += [_FILTERED, *rows, ""]
    lines.append(f"Limits that do not hold: {', '.join(fails) if fails else 'none'}.\n")
    return "\n".join(lines)


_HEAD = """# Disturbances

Made by `python -m studies.disturbances`: {records} simulated records for each fault, of three gyros (0.3 deg/√h, 10 deg/h,
20 deg/h/√h) and an accelerometer (0.06 m/s/√h, 0.04 mg, 3 m/s/h^1.5), 20 minutes at 50 Hz, analysed with
`sigmatau.analyze` and no options. The record with a thermometer is one hour long; it warms up by 15 K with a time constant
of 20 minutes, and its gyros change by 5 deg/h/K. Seeds are derived from the names of the cells; σ is the standard deviation
of a sample.

N, B, K: percentage of the axes whose interval, or upper limit, contains the true value ({covered:g} % at least). Wrong:
percentage of the axes with any term, process, line or drift observed that the record does not have ({wrong:g} % at most).
Left out, warned: percentage of the axes in whose record samples were left out, and there is a warning.

| fault | axes | N | B | K | wrong | left out | warned |
|---|---|---|---|---|---|---|---|"""

_CLEAN = """
Of {records} clean records of six axes ([their models](false-alarms.md)), {warned:.1f} % have a warning ({w:g} % at most)
and of {left:.1f} % samples are left out ({o:g} % at most).
"""

_FILTERED = f"""White noise of three gyros behind a filter ({FILTERED_RATE:g} Hz, 10 minutes), alone or beside flicker noise
or a random walk, in half of the records in steps of 0.01 to 5 standard deviations of the change from sample to sample.
Percentage of the records of which samples are left out ({100 * LEFT_OUT:g} % at most), and the causes:

| filter | records | left out | causes |
|---|---|---|---|"""


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--parts", type=int, default=PARTS)
    main(parser.parse_args().parts)
