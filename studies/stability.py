"""Drift, stationarity and correlation: share of clean and of faulty records with a finding."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau import NoiseModel, Record, simulate
from sigmatau.findings.finding import Finding
from sigmatau.fitting.channel import fit_channel
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.quality.drift.stationarity import cusum, non_stationary, segment_test
from sigmatau.quality.drift.without_drifts import subtract_drifts
from sigmatau.quality.fit_findings import by_channel
from sigmatau.quality.spectrum.axis_correlation import cross_axis
from sigmatau.record.record import make_stream
from sigmatau.record.streams import Stream
from studies.runner import run
from studies.samples import simulated

Floats = NDArray[np.float64]

MIXTURES: dict[str, dict[str, float]] = {
    "N": {"random_walk": 1.0},
    "N, B": {"random_walk": 1.0, "bias_instability": 0.05},
    "B": {"random_walk": 0.05, "bias_instability": 1.0},
    "N, weak K": {"random_walk": 1.0, "rate_random_walk": 1e-3},
    "N, K": {"random_walk": 1.0, "rate_random_walk": 4e-3},
    "K": {"random_walk": 0.01, "rate_random_walk": 1.0},
    "N, B, K": {"random_walk": 1.0, "bias_instability": 0.03, "rate_random_walk": 1e-3},
    "Q, N, R": {"quantization": 3.0, "random_walk": 0.2, "rate_ramp": 1e-3},
    "Q, B, K": {"quantization": 30.0, "bias_instability": 0.1, "rate_random_walk": 3e-3},
}
"""Mixtures at an interval of 1 s; 16384 samples."""

LAW_RECORDS = 4000
PARTS = 4
CLEAN_RECORDS = 320
FAULT_RECORDS = 48
TEMPERATURES = 512
SEGMENTED = 16384
LEVELS = (0.05, 0.01, 1e-3, 1e-4)
LENGTHS = ((600.0, 10.0), (600.0, 100.0), (3600.0, 10.0), (14400.0, 10.0))


def law(seed: int, name: str) -> list[list[float]]:
    """P-values of segments and cusum, for each record."""
    rng = np.random.default_rng(seed)
    model = MIXTURES[name]
    fitted = NoiseFit(
        channel="x", quantity="signal", rate_unit="1", n=SEGMENTED, tau0=1.0, terms={}, model=model, verdict="adequate",
        tau_min=1.0,
    )  # fmt: skip
    rows = []
    for _ in range(LAW_RECORDS // PARTS):
        y = simulated(SEGMENTED, 1.0, model, seed=int(rng.integers(1 << 62)))
        segments, change = segment_test(y, fitted), cusum(y)
        rows.append([1.0 if test is None else test.p_value for test in (segments, change)])
    return rows


def _temperature(rng: np.random.Generator) -> Floats:
    """A temperature without effect on the sensor: a walk, a cycle, a cooling, or a mixture."""
    t = np.arange(TEMPERATURES)
    kind = int(rng.integers(4))
    if kind == 0:
        return np.asarray(np.cumsum(rng.standard_normal(TEMPERATURES)))
    if kind == 1:
        return np.asarray(np.sin(2 * np.pi * (t / rng.uniform(40, 1000) + rng.uniform())))
    if kind == 2:
        return np.asarray(np.exp(-t / rng.uniform(10, 200)))
    return np.asarray(0.1 * np.cumsum(rng.standard_normal(TEMPERATURES)) + 5 * np.exp(-t / rng.uniform(10, 200)))


def clean(seed: int, k: int) -> list[list[int]]:
    """Findings of each check in records of three axes: warnings and infos."""
    rng = np.random.default_rng(seed)
    rows = []
    for _ in range(CLEAN_RECORDS // PARTS // len(LENGTHS)):
        duration, rate = LENGTHS[k % len(LENGTHS)]
        model = _model(rng, duration, rate)
        stream = simulate(model, duration=duration, rate=rate, rng=rng).streams[0]
        celsius = 25 + np.interp(np.arange(round(duration)), np.linspace(0, duration, TEMPERATURES), _temperature(rng))
        record = Record(streams=(stream, _thermometer(celsius)))
        fits, findings = _fitted(record)
        flat = subtract_drifts(record, stream, fits)
        findings = [*findings, *non_stationary(flat, fits), *cross_axis(stream)]
        findings = [finding for finding in findings if (finding.code, finding.severity) in CODES]
        counts = [0] * len(CODES)
        for finding in findings:
            counts[CODES.index((finding.code, finding.severity))] += 1
        rows.append(counts)
    return rows


CODES = [
    (code, severity)
    for code in ("warm_up", "temperature_drift", "non_stationary", "correlated_axes")
    for severity in ("warning", "info")
]
DRIFTS = [("warm_up", "info"), ("temperature_drift", "info")]


def _fitted(record: Record) -> tuple[dict[str, NoiseFit], list[Finding]]:
    """Fits of the sensor of a record, and their findings."""
    fits = {channel: fit_channel(record, channel) for channel in record.streams[0].channels}
    return fits, by_channel(fits, (), record)


def _model(rng: np.random.Generator, duration: float, rate: float) -> NoiseModel:
    """Three axes with a random mixture: N = 1, and other terms that cross it within the record."""
    channels = {}
    for axis in "xyz":
        cross = np.exp(rng.uniform(np.log(3 / rate), np.log(duration), size=4))
        has = rng.random(4) < 0.5
        terms = {"random_walk": 1.0}
        if has[0]:
            terms["quantization"] = float(np.sqrt(cross[0] / 3))
        if has[1]:
            terms["bias_instability"] = float(1.5 / np.sqrt(cross[1]))
        if has[2]:
            terms["rate_random_walk"] = float(np.sqrt(3) / cross[2])
        if has[3]:
            terms["rate_ramp"] = float(np.sqrt(2) / cross[3] ** 1.5)
        channels[f"gyro_{axis}"] = terms
    return NoiseModel(channels=channels)


def _thermometer(celsius: Floats) -> Stream:
    stream = make_stream("temperature", {"temperature": celsius}, rate=1.0, unit={})
    return replace(stream, quantity="temperature", unit="K")


FAULTS = ("warm-up", "temperature", "noise × 1.25 in one half", "K × 20 in one half", "axes correlated by 0.1")
SENSOR = {"random_walk": 0.005, "bias_instability": 1e-3, "rate_random_walk": 3e-5}
"""Coefficients in degrees and seconds: a good MEMS gyro."""


def fault(seed: int, name: str) -> list[float]:
    """Share of records of 2 h at 20 Hz in which a fault is detected, and mean ratio of the stated to the simulated size."""
    rng = np.random.default_rng(seed)
    detected, sizes = 0, []
    n, rate = 144_000, 20.0
    seconds = np.arange(n) / rate
    for _ in range(FAULT_RECORDS):
        model = NoiseModel(channels={f"gyro_{axis}": SENSOR for axis in "xy"})
        whole = simulate(model, duration=n / rate, rate=rate, rng=rng).streams[0]
        x, y = whole.column("gyro_x").copy(), whole.column("gyro_y")
        celsius = 25 + 2 * np.sin(2 * np.pi * np.arange(7200) / 2400)
        if name == FAULTS[0]:
            x += 0.03 * np.exp(-seconds / 400)
        elif name == FAULTS[1]:
            x += 0.01 * np.interp(seconds, np.arange(7200) + 0.5, celsius)
        elif name == FAULTS[2]:
            x[n // 2 :] += 0.75 * 0.005 * np.sqrt(rate) * rng.standard_normal(n // 2)
        elif name == FAULTS[3]:
            x[n // 2 :] += np.sqrt(399) * 3e-5 / np.sqrt(rate) * np.cumsum(rng.standard_normal(n // 2))
        else:
            x += 0.1 * y
        stream = Record.from_arrays(rate=rate, gyro_x=x, gyro_y=y).streams[0]
        if name == FAULTS[4]:
            findings = cross_axis(stream)
        else:
            single_axis = stream.only("gyro_x")
            record = Record(streams=(single_axis, _thermometer(celsius)) if name == FAULTS[1] else (single_axis,))
            fits, findings = _fitted(record)
            if name in FAULTS[:2]:
                code = "warm_up" if name == FAULTS[0] else "temperature_drift"
                findings = [finding for finding in findings if finding.code == code]
            else:
                findings = non_stationary(subtract_drifts(record, single_axis, fits), fits)
        detected += bool(findings)
        sizes += [finding.size for finding in findings if finding.size is not None]
    return [detected / FAULT_RECORDS, float(np.mean(sizes)) if sizes else 0.0]


def main() -> None:
    """Run the study and write docs/study/stability.md."""
    cells: dict[str, tuple[Callable[..., Any], tuple[Any, ...]]] = {
        f"law {name} {k}": (law, (name,)) for name in MIXTURES for k in range(PARTS)
    }
    cells |= {f"clean {k}": (clean, (k,)) for k in range(PARTS * len(LENGTHS))}
    cells |= {f"fault {name}": (fault, (name,)) for name in FAULTS}
    settings = repr((MIXTURES, LAW_RECORDS, CLEAN_RECORDS, FAULT_RECORDS, LENGTHS, SENSOR))
    results = run("stability", cells, settings=settings)
    lines = [_HEAD.format(records=LAW_RECORDS)]
    failures = []
    for name in MIXTURES:
        rows = np.array([row for k in range(PARTS) for row in results[f"law {name} {k}"]])
        shares = [f"{100 * (rows[:, c] < level).mean():.2f}" for c in (0, 1) for level in LEVELS[:3]]
        lines.append(f"| {name} | " + " | ".join(shares) + " |")
        for c, label in ((0, "segments"), (1, "cusum")):
            for level in LEVELS:
                bound = 1.3 * level + 3 * np.sqrt(level / len(rows)) + 1e-4
                if (rows[:, c] < level).mean() > bound:
                    failures.append(f"- {name}: {label}, {(rows[:, c] < level).mean():.2g} below p = {level:g}")
    counts = np.array([row for k in range(PARTS * len(LENGTHS)) for row in results[f"clean {k}"]])
    lines.append(_CLEAN.format(records=len(counts), channels=3 * len(counts)))
    for (code, severity), number in zip(CODES, counts.sum(axis=0), strict=True):
        lines.append(f"| {code} | {severity} | {number} |")
        if (severity == "warning" or (code, severity) in DRIFTS) and number > 1e-3 * 3 * len(counts) + 3 * np.sqrt(
            1e-3 * 3 * len(counts)
        ):
            failures.append(f"- {code}: {number} warnings in {3 * len(counts)} clean channels")
    lines.append(_FAULTS.format(records=FAULT_RECORDS))
    for name in FAULTS:
        share, size = results[f"fault {name}"]
        lines.append(f"| {name} | {100 * share:.0f} | {size:.3g} |")
        if share < 0.5:
            failures.append(f"- {name} is found in {100 * share:.0f} %")
    lines += ["", "## Gates", "", _GATES, "", *(failures or ["All gates are met."])]
    Path("docs/study/stability.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


_HEAD = """# Tests of drift, stationarity and correlation

Made by `make study` (studies/stability.py).

## False alarm rates of the tests

{records} clean records of each mixture; the seeds are derived from the names of the cells. The columns give the share of
records [%] in which the p-value of a test is below 5, 1 and 0.1 %. The test of segments uses the true noise.

| mixture | segments 5 | 1 | 0.1 | cusum 5 | 1 | 0.1 |
|---|---|---|---|---|---|---|"""

_CLEAN = """
## Clean records

{records} records of three axes. Each axis has N and any of Q, B, K and R, which cross N between three samples and the
length of the record. The records are 10 min at 10 and 100 Hz, and 1 h and 4 h at 10 Hz, with a temperature that is a random
walk, a cycle or a cooling curve and independent of the sensor. They are fitted and checked. Findings in {channels} channels:

| finding | severity | number |
|---|---|---|"""

_FAULTS = """
## Simulated faults

{records} records per fault, of 2 h at 20 Hz with N 0.005, B 0.001, K 3e-5 (seconds and degrees). Warm-up: 0.03 with a
time constant of 400 s. Temperature: 0.01 per kelvin, cycles of ± 2 K in 40 min. Change of noise in the second half of
the record: N × 1.25, K × 20.

| fault | found [%] | size stated, mean |
|---|---|---|"""

_GATES = """The tests of segments and cusum reject at most 1.3 times as often as their nominal rates of 5, 1, 0.1 and
0.01 %. At most 0.1 % of clean channels have a finding. Each fault is found in more than half of the records. All gates are
within three standard errors."""

if __name__ == "__main__":
    main()
