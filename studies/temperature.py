"""Temperature: coverage of means, polynomials, hysteresis and coefficients at a temperature; choice of the degree."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from sigmatau import NoiseModel, Record, simulate
from sigmatau.arrays import Floats
from sigmatau.lab.temperature.bias_fit import fit_bias
from sigmatau.lab.temperature.branches import Blocks, find_spans, split_blocks
from sigmatau.lab.temperature.noise_by_window import noise_terms, window_terms
from sigmatau.lab.temperature.over_runs import fit_runs
from sigmatau.lab.temperature.polynomial import from_scaled
from studies.runner import run

SETS = 1000
CHOICE_SETS = 500  # for the choice of a degree
HOURS, RATE = 3.0, 0.5  # of a record [h], [Hz]
LOW, HIGH = -40.0, 85.0  # [°C]
DEG_H = math.pi / 180 / 3600
# Noise: N [deg/√h], B [deg/h], K [deg/h/√h]
NOISES = {
    "N, B and K": (0.3, 5.0, 10.0),
    "N and B": (0.3, 5.0, 0.0),
    "N and K": (0.3, 0.0, 30.0),
    "N and small K": (0.3, 0.0, 5.0),
    "N": (0.3, 0.0, 0.0),
}
FULL = ("N, B and K", "N and K", "N and small K")  # noises with K
PROFILES = ("ramp", "soak")
TRUE = (50.0, 300.0, 100.0, -80.0)  # polynomial in (T - middle)/half range [deg/h]
LOOP = 40.0  # height of the hysteresis [deg/h]
RATIOS = (0.0, 1.0, 1.4, 2.0, 2.6)  # smallest ratio of the highest coefficient to its error
CURVES = {"linear": (50.0, 300.0, 0.0, 0.0), "weak quadratic": (50.0, 300.0, 15.0, 0.0), "cubic": TRUE}
WINDOW, WINDOW_RATE = 1200.0, 20.0  # of a window for coefficients [s], [Hz]
RUNS = (5, 8, 16)
LEVEL = 0.95
_Z = 1.959964


def temperatures(profile: str, n: int) -> Floats:
    """Temperature of a ramp up and down, or of steps up and down that are held, at n samples. [°C]"""
    if profile == "ramp":
        return LOW + (HIGH - LOW) * (1 - np.abs(2 * (np.arange(n) + 0.5) / n - 1))
    held = np.array([-40.0, 0.0, 40.0, 85.0, 40.0, 0.0, -40.0])
    place = (np.arange(n) + 0.5) / n * len(held)
    step = np.minimum(place.astype(int), len(held) - 1)
    before = held[np.maximum(step - 1, 0)]
    share = np.clip((place - step) / 0.3, 0, 1)
    return np.asarray(before + (held[step] - before) * np.where(step == 0, 1.0, share))


def noise_of(rng: np.random.Generator, noise: str, *, duration: float, rate: float) -> Floats:
    """Samples of the noise. [rad/s]"""
    n, b, k = NOISES[noise]
    terms = {"random_walk": f"{n} deg/sqrt(h)"}
    terms |= {"bias_instability": f"{b} deg/h"} if b else {}
    terms |= {"rate_random_walk": f"{k} deg/h/sqrt(h)"} if k else {}
    model = NoiseModel.from_dict({"channels": {"gyro_x": terms}})
    record = simulate(model, duration=duration, rate=rate, rng=int(rng.integers(1 << 62)))
    return record.streams[0].column("gyro_x")


def cycle(profile: str) -> tuple[Blocks, Floats, Floats]:
    """Blocks of a record, and polynomial and hysteresis in them. [rad/s]"""
    n = round(HOURS * 3600 * RATE)
    t = temperatures(profile, n)
    stream, thermometer = Record.from_arrays(rate=RATE, gyro_x=np.zeros(n), temperature=t).streams
    blocks = split_blocks(stream, thermometer)
    u = (blocks.temperature - (LOW + HIGH) / 2) / ((HIGH - LOW) / 2)
    loop = -0.5 * blocks.direction * LOOP * (1 - u * u)
    return blocks, u, loop * DEG_H


def coverage(seed: int, noise: str, profile: str) -> dict[str, float]:
    """Share of the intervals that contain the truth."""
    rng = np.random.default_rng(seed)
    blocks, u, loop = cycle(profile)
    truth = np.polynomial.polynomial.polyval(u, TRUE) * DEG_H + loop
    spans, m = find_spans(blocks), blocks.samples
    at_samples = fit_bias(blocks, truth, degree=3).columns(blocks, temperatures(profile, round(HOURS * 3600 * RATE)))
    counts: dict[str, list[float]] = {}
    for _ in range(SETS):
        x = noise_of(rng, noise, duration=HOURS * 3600, rate=RATE)
        e = x[: len(u) * m].reshape(len(u), m).mean(axis=1)
        level = float(e.mean())
        walk = _walk(x, at_samples)
        for name, hit in _hits(blocks, truth + e, truth + level, level, spans, walk).items():
            counts.setdefault(name, []).append(hit)
    return {name: float(np.mean(hits)) for name, hits in counts.items()}


def _walk(x: Floats, columns: Mapping[str, Floats]) -> float | None:
    """Random walk of the samples, beside the curves of the mean, as `calibrate_temperature` estimates it."""
    (stream,) = Record.from_arrays(rate=RATE, gyro_x=x).streams
    return noise_terms(stream, columns, level=LEVEL)["random_walk"].value


def _hits(
    blocks: Blocks, means: Floats, truth: Floats, level: float, spans: list[Any], walk: float | None
) -> dict[str, float]:
    fitted = fit_bias(blocks, means, degree=3, white=None if walk is None else walk**2 / blocks.length)
    result = fitted.fitted
    middle, half = (LOW + HIGH) / 2, (HIGH - LOW) / 2
    polynomial = from_scaled(
        result.coefficients[:4], result.covariance[:4, :4],
        scaled=(blocks.low, blocks.high), low=LOW, high=HIGH, reference=middle, level=LEVEL, unit="rad/s",
    )  # fmt: skip
    true = np.array(TRUE) * DEG_H / half ** np.arange(4)
    true[0] += level
    hits = {f"c{k}": float(abs(polynomial.coefficients[k] - true[k]) <= polynomial.errors[k]) for k in range(4)}
    curve = polynomial.values([LOW, middle, HIGH])
    exact = np.polynomial.polynomial.polyval(np.array([-1.0, 0.0, 1.0]), TRUE) * DEG_H + level
    hits["mean(T)"] = float(np.mean(np.abs(curve.value - exact) <= curve.high - curve.value))
    inside = []
    for span in spans:
        weights = np.zeros(len(means))
        weights[span.first : span.stop] = 1 / (span.stop - span.first)
        error = math.sqrt(weights @ result.noise @ weights)
        inside.append(abs(weights @ (means - truth)) <= _Z * error)
    hits["window mean"] = float(np.mean(inside))
    loop = fitted.hysteresis(level=LEVEL, unit="rad/s")
    assert loop is not None
    at_middle = LOOP * DEG_H * (1 - ((loop.temperature[2] - middle) / half) ** 2)
    hits["hysteresis"] = float(loop.low[2] <= at_middle <= loop.high[2])
    return hits


def degrees(seed: int, curve: str, noise: str) -> dict[str, list[float]]:
    """Coverage of mean(T), root mean square of its error [deg/h] and share of the right degree, by smallest ratio."""
    rng = np.random.default_rng(seed)
    blocks, u, _ = cycle("ramp")
    coefficients = np.array(CURVES[curve])
    right = int(np.flatnonzero(coefficients)[-1])
    white = (NOISES[noise][0] * DEG_H * 60) ** 2 / blocks.length
    places = np.linspace(-1, 1, 11)
    exact = np.polynomial.polynomial.polyval(places, coefficients) * DEG_H
    tables = {ratio: np.zeros(3) for ratio in RATIOS}
    for _ in range(CHOICE_SETS):
        x = noise_of(rng, noise, duration=HOURS * 3600, rate=RATE)
        e = x[: len(u) * blocks.samples].reshape(len(u), blocks.samples).mean(axis=1)
        means = np.polynomial.polynomial.polyval(u, coefficients) * DEG_H + e - e.mean()
        fits = [fit_bias(blocks, means, degree=degree, white=white) for degree in range(4)]
        tops = [each.fitted for each in fits]
        ratios = [abs(f.coefficients[k]) / math.sqrt(f.covariance[k, k]) for k, f in enumerate(tops)]
        for ratio in RATIOS:
            fitted = fits[next((k for k in (3, 2, 1) if ratios[k] >= ratio), 0)]
            p = fitted.degree + 1
            powers = np.vander(places, p, increasing=True)
            off = powers @ fitted.fitted.coefficients[:p] - exact
            error = np.sqrt(np.einsum("ij,jk,ik->i", powers, fitted.fitted.covariance[:p, :p], powers))
            tables[ratio] += [np.mean(np.abs(off) <= _Z * error), np.mean(off**2), fitted.degree == right]
    shares = {ratio: table / CHOICE_SETS for ratio, table in tables.items()}
    return {f"{ratio:g}": [s[0], math.sqrt(s[1]) / DEG_H, s[2]] for ratio, s in shares.items()}


def noise_at_temperature(seed: int, noise: str, profile: str) -> dict[str, float]:
    """Share of the intervals and limits of the coefficients of a window that contain the truth."""
    rng = np.random.default_rng(seed)
    n = round(WINDOW * WINDOW_RATE)
    t = 25 + (np.linspace(-12, 12, n) if profile == "ramp" else np.zeros(n))
    true = dict(zip(("random_walk", "bias_instability", "rate_random_walk"), NOISES[noise], strict=True))
    units = {"random_walk": DEG_H * 60, "bias_instability": DEG_H, "rate_random_walk": DEG_H / 60}
    counts = dict.fromkeys(true, 0)
    for _ in range(SETS):
        x = noise_of(rng, noise, duration=WINDOW, rate=WINDOW_RATE)
        drift = (5.0 * (t - 25) + 0.05 * (t - 25) ** 2) * DEG_H
        (stream,) = Record.from_arrays(rate=WINDOW_RATE, gyro_x=x + drift).streams
        terms = window_terms(stream, t, 0, n, level=LEVEL)
        for name, size in true.items():
            term, value = terms.get(name), size * units[name]
            if term is not None:
                low = term.low if term.value is not None else 0.0
                high = term.high if term.value is not None else term.upper_limit
                counts[name] += bool((low or 0.0) <= value <= (high or math.inf))
    return {name: count / SETS for name, count in counts.items()}


def over_runs(seed: int, runs: int) -> dict[str, float]:
    """Coverage of the polynomial of runs with a turn-on bias of 10 deg/h."""
    rng = np.random.default_rng(seed)
    t = np.linspace(LOW, HIGH, runs)
    u = (t - (LOW + HIGH) / 2) / ((HIGH - LOW) / 2)
    hits = np.zeros(2)
    for _ in range(SETS):
        means = (50 + 300 * u + 10 * rng.standard_normal(runs)) * DEG_H
        polynomial, _spread = fit_runs(t, means, degree=1, reference=25.0, level=LEVEL, unit="rad/s")
        curve = polynomial.values([60.0])
        exact = (50 + 300 * (60 - (LOW + HIGH) / 2) / ((HIGH - LOW) / 2)) * DEG_H
        slope = 300 * DEG_H / ((HIGH - LOW) / 2)
        hits += [
            abs(polynomial.coefficients[1] - slope) <= polynomial.errors[1],
            curve.low[0] <= exact <= curve.high[0],
        ]
    return {"slope": hits[0] / SETS, "mean(60 °C)": hits[1] / SETS}


def main() -> None:
    """Run the study and write docs/study/temperature.md."""
    cells: dict[str, Any] = {
        f"{noise}, {profile}": (coverage, (noise, profile)) for noise in NOISES for profile in PROFILES
    }
    cells |= {
        f"window, {noise}, {profile}": (noise_at_temperature, (noise, profile))
        for noise in ("N, B and K", "N")
        for profile in PROFILES
    }
    cells |= {f"{runs} runs": (over_runs, (runs,)) for runs in RUNS}
    cells |= {
        f"degree, {curve}, {noise}": (degrees, (curve, noise)) for curve in CURVES for noise in ("N, B and K", "N")
    }
    settings = repr((SETS, HOURS, RATE, LOW, HIGH, NOISES, TRUE, LOOP, RATIOS, CURVES, WINDOW, WINDOW_RATE))
    results = run("temperature", cells, settings=settings)
    failures: list[str] = []
    lines = [_HEAD.format(sets=SETS, hours=HOURS), "", *_coverage(results, failures), "", *_degrees(results), ""]
    lines += [*_windows(results, failures), "", *_runs(results, failures), "", "## Gates", "", _GATES, ""]
    lines += failures or ["All gates are met."]
    Path("docs/study/temperature.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


def _gate(share: float, *, sets: int = SETS, shown: bool) -> bool:
    error = 3 * math.sqrt(LEVEL * (1 - LEVEL) / sets)
    return share >= LEVEL - error and (not shown or share <= LEVEL + error)


def _coverage(results: Mapping[str, Any], failures: list[str]) -> list[str]:
    names = ("window mean", "mean(T)", "c0", "c1", "c2", "c3", "hysteresis")
    lines = [_MEANS, "", f"| noise | temperature | {' | '.join(names)} |", "|---" * (2 + len(names)) + "|"]
    for noise in NOISES:
        for profile in PROFILES:
            row = results[f"{noise}, {profile}"]
            lines.append(f"| {noise} | {profile} | " + " | ".join(f"{100 * row[name]:.1f}" for name in names) + " |")
            failures += [
                f"- {noise}, {profile}, {name}: {100 * row[name]:.1f} %"
                for name in names
                if not _gate(row[name], shown=noise in FULL)
            ]
    return lines


def _degrees(results: Mapping[str, Any]) -> list[str]:
    lines = [
        _CHOICE.format(sets=CHOICE_SETS),
        "",
        "| curve | noise | " + " | ".join(f"ratio {ratio:g}" for ratio in RATIOS) + " |",
    ]
    lines.append("|---" * (2 + len(RATIOS)) + "|")
    for curve in CURVES:
        for noise in ("N, B and K", "N"):
            row = results[f"degree, {curve}, {noise}"]
            texts = [f"{100 * c:.1f} · {rms:.2f} · {100 * right:.0f}" for c, rms, right in row.values()]
            lines.append(f"| {curve} | {noise} | {' | '.join(texts)} |")
    return lines


def _windows(results: Mapping[str, Any], failures: list[str]) -> list[str]:
    lines = [_NOISE, "", "| noise | window | N | B | K |", "|---" * 5 + "|"]
    for noise in ("N, B and K", "N"):
        for profile in PROFILES:
            row = results[f"window, {noise}, {profile}"]
            lines.append(
                f"| {noise} | {profile} | " + " | ".join(f"{100 * share:.1f}" for share in row.values()) + " |"
            )
            failures += [
                f"- window, {noise}, {profile}, {name}: {100 * share:.1f} %"
                for name, share in row.items()
                if not _gate(share, shown=False)
            ]
    return lines


def _runs(results: Mapping[str, Any], failures: list[str]) -> list[str]:
    lines = [_RUNS, "", "| runs | slope | mean at 60 °C |", "|---" * 3 + "|"]
    for runs in RUNS:
        row = results[f"{runs} runs"]
        lines.append(f"| {runs} | {100 * row['slope']:.1f} | {100 * row['mean(60 °C)']:.1f} |")
        failures += [
            f"- {runs} runs, {name}: {100 * share:.1f} %" for name, share in row.items() if not _gate(share, shown=True)
        ]
    return lines


_HEAD = """# Temperature

Made by `make study` (studies/temperature.py); the seeds are derived from the names of the rows. Shares of 95 % intervals
that contain the truth, in per cent, from {sets} simulated sets for each row.

Records of {hours:g} h between -40 and 85 °C and back: a ramp, or seven soaks with transitions. The mean is a cubic
polynomial of temperature with a hysteresis of up to 40 deg/h. Noise: N = 0.3 deg/√h, B = 5 deg/h,
K = 10 deg/h/√h; *N and K*: K = 30; *N and small K*: K = 5 deg/h/√h."""

_MEANS = """## Means, polynomial, hysteresis

The truth of a mean is polynomial and hysteresis plus the mean of the noise over the record, because the bias of a run
includes it. Without K the intervals still allow for a rate random walk that the record cannot exclude: they contain the
truth more often than stated."""

_CHOICE = """## Degree

The highest coefficient is left out while it is smaller than a ratio times its standard error; 1 is the default. In each
cell: coverage of mean(T) at 11 temperatures [%], root mean square of its error [deg/h], and share of the right degree [%],
from {sets} sets. Larger ratios choose the degree of a pure polynomial more often, and leave out weak coefficients, which
costs coverage."""

_NOISE = """## Coefficients at a temperature

Windows of 20 min at 20 Hz, with the temperature held, or ramping by 24 K with a sensitivity of 5 deg/h/K. Intervals of
coefficients that are observed, and upper limits of the others."""

_RUNS = """## Runs

Runs at equally spaced temperatures with a turn-on bias of 10 deg/h: ordinary least squares with Student's t."""

_GATES = """95 % within 3 standard errors of the simulation where the record shows K; at least that without K, and for
coefficients at a temperature. Cells that fail are listed, not repeated."""


if __name__ == "__main__":
    main()
