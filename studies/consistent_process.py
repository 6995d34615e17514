"""Test of whether KF-GINS with the exported Gauss-Markov biases states its errors as the file claims: six sensors.

    python -m studies.consistent_process

writes docs/study/consistent-process.md. Simulator, sensors and aiding are those of `studies.consistent`.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from sigmatau import Choices, NoiseModel, export
from sigmatau.exporting.consistent import judge_process
from sigmatau.exporting.values import Numbers
from sigmatau.model.processes import GaussMarkov
from studies.consistent import (
    KINDS,
    RATE,
    RUNS,
    SENSORS,
    SPACING,
    STEP,
    TIMES,
    UNITS,
    WARM_UP,
    WINDOWS,
    Filter,
    is_met,
    model_of,
    ratios,
    simulated,
)
from studies.runner import run

_MGAL = 1e-5
HORIZON = 60.0


def process_of(kind: str, text: str) -> tuple[float, GaussMarkov]:
    """N, σ and T of a file, in SI."""
    noise, bias = ("arw", "gbstd") if kind == "gyro" else ("vrw", "abstd")
    first = {key: float(re.findall(rf"^  {key}: \[?([-+.\de]+)", text, flags=re.MULTILINE)[0]) for key in (noise, bias)}
    hours = float(re.findall(r"^  corrtime: ([-+.\de]+)", text, flags=re.MULTILINE)[0])
    unit_of_n, unit_of_b = UNITS[kind][0], UNITS[kind][1] if kind == "gyro" else _MGAL
    return first[noise] * unit_of_n, GaussMarkov(sigma=first[bias] * unit_of_b, time=3600 * hours)


def filter_of(kind: str, text: str) -> Filter:
    """The process model of KF-GINS: F = I + F·dt, and white noise of the density 2σ²/T."""
    noise, process = process_of(kind, text)
    dt = 1 / RATE
    driven = 2 * process.sigma**2 / process.time
    return Filter(
        step=dt,
        transition=np.array([[1.0, dt], [0.0, 1.0 - dt / process.time]]),
        noise=np.diag([noise**2 * dt, driven * dt]),
    )


def judge_sensor(seed: int, kind: str, name: str) -> dict[str, list[list[float]]]:
    """Ratios with errors for both rules, and the statement of the file; NEES, then the error after the times."""
    rng = np.random.default_rng(seed)
    model = model_of(kind, SENSORS[kind][name])
    increments, bias = simulated(
        kind, SENSORS[kind][name], rng, round((WARM_UP + WINDOWS * SPACING + TIMES[-1]) / STEP) + 2, RUNS
    )
    whole = {sensor: model if sensor == kind else model_of(sensor, SENSORS[sensor]["flicker"]) for sensor in SENSORS}
    model_of_both = NoiseModel(channels={f"{sensor}_x": channel for sensor, channel in whole.items()})
    files = {"consistent": export(model_of_both, to="kf-gins")}
    if model.gauss_markov or "rate_random_walk" in model or "bias_instability" in model:
        files["Allan"] = export(model_of_both, to="kf-gins", choices=Choices(strict=True, horizon=HORIZON))
    filters = {rule: filter_of(kind, str(text)) for rule, text in files.items()}
    result = {
        rule: [[each.value, each.error] for each in row]
        for rule, row in zip(filters, ratios(list(filters.values()), kind, increments, bias, rng), strict=True)
    }
    noise, process = process_of(kind, str(files["consistent"]))
    truths = Numbers(model_of_both, Choices()).truths([f"{kind}_x"])
    stated = judge_process(truths, process, sensor=kind, noise=noise, horizon=HORIZON, mean=False)
    result["file"] = [[stated.nees, 0.0], *([1 / each.share, 0.0] for each in stated.stated)]
    result["sigma"] = [[process.sigma / UNITS[kind][1], 0.0]]
    return result


def main() -> None:
    """Run the study and write its page."""
    cells = {
        f"process {kind} {name}": (judge_sensor, (kind, name)) for kind, sensors in SENSORS.items() for name in sensors
    }
    done = run("consistent_process", cells, settings=f"{RUNS} {WARM_UP} {WINDOWS} {SPACING} {SENSORS}")
    hours = [(WARM_UP + k * SPACING) / 3600 for k in (0, WINDOWS - 1)]
    lines, failed, judged = [_HEAD.format(runs=RUNS, windows=WINDOWS, first=hours[0], last=hours[1])], 0, 0
    for kind, sensors in SENSORS.items():
        lines += [
            f"## {KINDS[kind]}", "",
            "| sensor | rule | bias NEES | error after 10 s | 60 s | 10 min |", "|---|---|---|---|---|---|",
        ]  # fmt: skip
        for name in sensors:
            result = done[f"process {kind} {name}"]
            stated = [value for value, _ in result["file"]]
            unit = "°/h" if kind == "gyro" else "µg"
            lines.append(
                f"| {name}, σ = {result['sigma'][0][0]:.3g} {unit} | *the file states* | "
                + " | ".join(f"{value:.2f}" for value in stated) + " |"
            )  # fmt: skip
            texts = []
            for j, (value, error) in enumerate(result["consistent"]):
                good = is_met(value, error, 1.0 if j == 2 else stated[j], 0.10 if j == 2 else 0.15)
                judged, failed = judged + 1, failed + (not good)
                texts.append(f"{value:.2f} ± {error:.2f}" + ("" if good else " **missed**"))
            lines.append(f"| | consistent | {' | '.join(texts)} |")
            if "Allan" in result:
                texts = [f"{value:.2f} ± {error:.2f}" for value, error in result["Allan"]]
                lines.append(f"| | Allan deviation (`--strict`) | {' | '.join(texts)} |")
        lines.append("")
    lines.append(f"{judged - failed} of {judged} gates are met.")
    Path("docs/study/consistent-process.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


_HEAD = """# Is a filter with the exported Gauss–Markov biases honest?

Made by `make study` (studies/consistent_process.py). KF-GINS has a first-order Gauss–Markov process (σ, T) for each bias.
No stationary process is right for a bias that has drifted since turn-on, so that the file states a run time: T is 60
horizons, 1 h, and σ is that with which a filter states its error after 60 s right when it has run for an hour. Here such
filters run for {first:.1f} to {last:.1f} h. Sensors, simulator and aiding are those of
[the study of N and K](consistent.md).

Cells are actual over stated: variance of the bias (NEES), and standard deviation of the angle or velocity without aiding;
more than 1 is overconfident. {runs} runs of {windows} times each, ± one standard error. Gates, for *consistent*: after 60 s
within 10 % of 1, all others within 15 % of the file's statement; each ± 3 standard errors. *Allan deviation* is the rule of
`--strict`, and of simulators: the largest process of the model, or one that has the Allan deviation of the flicker noise, or
of the walk, at 60 s. It describes the noise, and a filter with it is overconfident.
"""


if __name__ == "__main__":
    main()
