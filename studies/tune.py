"""Does `tune` name the wrong noise of a filter, and is its factor right? Simulated Kalman filters with one wrong number.

    python -m studies.tune

writes docs/study/tune.md. The simulator is of its own: a truth in time, and a Kalman filter with its recursion from the
start, whose innovations and S are what a user has.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sigmatau import BiasFilter, Innovations, tune
from studies.runner import run

Floats = NDArray[np.float64]

RUNS = 1000
FACTOR = 3.0  # by which a filter is wrong
NOISES = ("measurement", "white", "slow")


@dataclass(frozen=True, slots=True, kw_only=True)
class Setting:
    """A true sensor with its aiding, in SI, and the length of a run in seconds."""

    noise: float
    walk: float
    deviation: float
    interval: float
    duration: float


SETTINGS: Mapping[str, Setting] = {
    "consumer gyro, 20 min": Setting(noise=1e-4, walk=1e-5, deviation=1e-4, interval=0.2, duration=1200.0),
    "consumer accelerometer, 2 h": Setting(noise=3e-3, walk=3e-5, deviation=0.01, interval=0.5, duration=7200.0),
    "tactical gyro, 1 h": Setting(noise=4e-5, walk=8e-7, deviation=1e-4, interval=0.5, duration=3600.0),
}
WRONG: Mapping[str, tuple[int, float]] = {
    "nothing": (0, 1.0),
    **{
        f"{name} {word}": (k, factor)
        for k, name in enumerate(NOISES)
        for word, factor in (("too small", 1 / FACTOR), ("too large", FACTOR))
    },
}


def innovations(setting: Setting, assumed: Setting, runs: int, rng: np.random.Generator) -> tuple[Floats, Floats]:
    """Innovations of Kalman filters that assume `assumed`, and their S, after the first tenth, in which they converge."""
    n, dt = round(setting.duration * 10 / 9 / setting.interval), setting.interval
    skipped = n // 10
    covariance = np.diag([(10 * assumed.deviation) ** 2, (100 * assumed.walk) ** 2])
    error = np.linalg.cholesky(covariance) @ rng.standard_normal((2, runs))
    transition = np.array([[1.0, dt], [0.0, 1.0]])
    shape = np.array([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]])
    added = np.diag([assumed.noise**2 * dt, 0.0]) + assumed.walk**2 * shape
    root = setting.walk * np.linalg.cholesky(shape)
    values, stated = np.empty((n - skipped, runs)), np.empty(n - skipped)
    for k in range(n):
        total = covariance[0, 0] + assumed.deviation**2
        innovation = error[0] + setting.deviation * rng.standard_normal(runs)
        if k >= skipped:
            values[k - skipped], stated[k - skipped] = innovation, total
        gain = covariance[:, 0] / total
        error = transition @ (error - gain[:, None] * innovation) + root @ rng.standard_normal((2, runs))
        error[0] += setting.noise * math.sqrt(dt) * rng.standard_normal(runs)
        covariance = transition @ (covariance - np.outer(gain, covariance[0])) @ transition.T + added
    return values, stated


def cell(name: str, wrong: str, runs: int, rng: np.random.Generator) -> list[int]:
    """Counts: verdicts right, something called wrong, and the intervals of the three factors that hold the truth."""
    setting = SETTINGS[name]
    place, factor = WRONG[wrong]
    numbers = [setting.deviation, setting.noise, setting.walk]
    true = [1.0, 1.0, 1.0]
    numbers[place] *= factor
    true[place] = 1 / factor
    assumed = Setting(
        deviation=numbers[0], noise=numbers[1], walk=numbers[2], interval=setting.interval, duration=setting.duration
    )
    values, stated = innovations(setting, assumed, runs, rng)
    time = np.arange(len(values), dtype=np.float64) * setting.interval
    counts = np.zeros(5, dtype=int)
    for series in values.T:
        data = Innovations(time=time, innovation=series, variance=stated)
        result = tune(data, filters=BiasFilter(noise=assumed.noise, walk=assumed.walk))["innovation"]
        expected = () if wrong == "nothing" else ((NOISES[place], "too small" if factor < 1 else "too large"),)
        named = tuple((cause.noise, cause.direction) for cause in result.causes)
        right = result.verdict == ("wrong" if expected else "consistent") and named == expected
        held = [
            each.low <= value and (each.high is None or value <= each.high)
            for each, value in zip(result.factors, true, strict=True)
        ]
        counts += np.array([right, result.verdict != "consistent", *held])
    return [int(count) for count in counts]


def _cell(seed: int, name: str, wrong: str) -> list[int]:
    return cell(name, wrong, RUNS, np.random.default_rng(seed))


def main() -> None:
    """Run the study and write its page."""
    cells = {f"tune {name} {wrong}": (_cell, (name, wrong)) for name in SETTINGS for wrong in WRONG}
    done = run("tune", cells, settings=f"{RUNS} {FACTOR} {SETTINGS}")
    lines, failed, judged = [_HEAD.format(runs=RUNS, factor=FACTOR)], 0, 0

    def text(count: int, low: float, high: float = 1.0) -> str:
        nonlocal failed, judged
        margin = 3 * math.sqrt(low * (1 - low) / RUNS)
        good = low - margin <= count / RUNS <= high + margin
        judged, failed = judged + 1, failed + (not good)
        return f"{100 * count / RUNS:.1f}" + ("" if good else " **missed**")

    for name, setting in SETTINGS.items():
        lines += [
            f"## {name.capitalize()}", "",
            f"N = {setting.noise:g}, K = {setting.walk:g}, √R = {setting.deviation:g} in SI, every {setting.interval:g} s.",
            "",
            "| noise of the filter | judged right | √R covered | N covered | K covered |", "|---|---|---|---|---|",
        ]  # fmt: skip
        for wrong in WRONG:
            right, _, *covered = done[f"tune {name} {wrong}"]
            row = " | ".join(text(count, 0.95, 0.95) for count in covered)
            lines.append(f"| {wrong} | {text(right, 0.95 if wrong == 'nothing' else 0.90)} | {row} |")
        lines.append("")
    lines.append(f"{judged - failed} of {judged} gates are met.")
    Path("docs/study/tune.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


_HEAD = """# Does tune name the wrong noise of a filter?

Made by `make study` (studies/tune.py). Kalman filters of an angle or a velocity and the bias of its sensor run on a
simulated truth. Each filter assumes one number that is wrong by a factor of {factor:g}: the deviation of its measurement √R,
N or K. The innovations after its convergence (a tenth of the run) and their S are given to `tune`, with N and K of the
filter.

*Judged right*: the verdict is "wrong", with this noise in this direction and no other; for *nothing* the verdict is
"consistent". *Covered*: the 95 % intervals of the factors that hold the truth. {runs} runs a row, in %. Gates: right in at
least 90 %, consistent in at least 95 %, coverage 95 %; each ± 3 standard errors.
"""


if __name__ == "__main__":
    main()
