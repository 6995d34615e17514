"""Test of whether `tune` names the wrong noise of a filter with its factor: simulated Kalman filters with one wrong number.

    python -m studies.tune

writes docs/study/tune.md. The simulator is independent: a true state over time, and a Kalman filter with its recursion
from the start, whose innovations and S are the input.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from sigmatau import BiasFilter, Innovations, tune
from sigmatau.exporting.tuning.motion import MotionEffect
from studies.runner import run
from studies.tune_filters import AIDED, AIDINGS, MOTIONS, Floats, Setting, aided_innovations, moving_innovations

RUNS = 1000
FEWER_RUNS = 100  # runs of filters with several measurements, with a varying S, or with motion
FACTOR = 3.0  # factor by which a filter is wrong
NOISES = ("measurement", "white", "slow")


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
    """Numbers of correct verdicts, of verdicts "wrong", and of intervals of the three factors that contain the truth."""
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


def aided_cell(name: str, wrong: str, runs: int, rng: np.random.Generator) -> list[int]:
    """Numbers of correct verdicts, of verdicts "wrong", and of intervals of the factors that contain the truth."""
    aiding = AIDINGS[name]
    count = len(aiding.deviations)
    true = np.ones(count + 2)
    noises = ["measurement"] if count == 1 else [f"measurement {k + 1}" for k in range(count)]
    noises += ["white", "slow"]
    if wrong != "nothing":
        noise, factor = wrong.rsplit(" too ")
        true[noises.index(noise)] = FACTOR if factor == "small" else 1 / FACTOR
    time, values, stated = aided_innovations(aiding, 1 / true, runs, rng)
    shape = (slice(None), 0) if count == 1 else (slice(None),)
    variance = stated[:, 0, 0] if count == 1 else stated
    data = {
        str(k): Innovations(time=time, innovation=series[shape], variance=variance) for k, series in enumerate(values)
    }
    filter_ = BiasFilter(noise=AIDED.noise / true[-2], walk=AIDED.walk / true[-1])
    counts = np.zeros(2 + len(true), dtype=int)
    expected = () if wrong == "nothing" else (tuple(wrong.rsplit(" too ")),)
    for result in tune(data, filters=filter_).values():
        named = tuple((cause.noise, cause.direction.removeprefix("too ")) for cause in result.causes)
        right = result.verdict == ("wrong" if expected else "consistent") and named == expected
        held = [
            each.low <= value and (each.high is None or value <= each.high)
            for each, value in zip(result.factors, true, strict=True)
        ]
        counts += np.array([right, result.verdict != "consistent", *held])
    return [int(value) for value in counts]


def moving_cell(name: str, wrong: str, runs: int, rng: np.random.Generator) -> list[int]:
    """Numbers of correctly named scales and delays, of their intervals that contain the truth, and of correct noise
    verdicts.
    """
    scale, delay, uses_sensor_rate = MOTIONS[name]
    place, factor = WRONG[wrong]
    factors = np.ones(3)
    factors[place] = factor
    time, values, stated, rates = moving_innovations(scale, delay, factors, runs, rng, of_sensor=uses_sensor_rate)
    data = {
        str(k): Innovations(time=time, innovation=series, variance=stated, rate=rate)
        for k, (series, rate) in enumerate(zip(values, rates, strict=True))
    }
    filter_ = BiasFilter(noise=AIDED.noise * factors[1], walk=AIDED.walk * factors[2])
    expected = () if factor == 1 else ((NOISES[place], "too small" if factor < 1 else "too large"),)
    counts = np.zeros(4, dtype=int)
    for result in tune(data, filters=filter_).values():
        by_effect: dict[str, MotionEffect] = {effect.effect: effect for effect in result.motion}
        named = tuple((cause.noise, cause.direction) for cause in result.causes)
        truths = {"scale": scale, "delay": delay}
        counts += np.array(
            [
                all(by_effect[effect].has_error == (truth != 0) for effect, truth in truths.items()),
                *(by_effect[effect].low <= truth <= by_effect[effect].high for effect, truth in truths.items()),
                result.noise_verdict == ("wrong" if expected else "consistent") and named == expected,
            ]
        )
    return [int(value) for value in counts]


def names_of_noises(count: int) -> list[str]:
    """Noises of a filter with some measurements."""
    measurements = ["measurement"] if count == 1 else [f"measurement {k + 1}" for k in range(count)]
    return [*measurements, "white", "slow"]


def wrong_numbers(count: int) -> list[str]:
    """Wrong numbers of the filters with some measurements."""
    return ["nothing", *(f"{noise} too {size}" for noise in names_of_noises(count) for size in ("small", "large"))]


def _cell(seed: int, name: str, wrong: str) -> list[int]:
    return cell(name, wrong, RUNS, np.random.default_rng(seed))


def _aided_cell(seed: int, name: str, wrong: str) -> list[int]:
    return aided_cell(name, wrong, FEWER_RUNS, np.random.default_rng(seed))


def _moving_cell(seed: int, name: str, wrong: str) -> list[int]:
    return moving_cell(name, wrong, FEWER_RUNS, np.random.default_rng(seed))


class Gates:
    """Counts as text, and how many of them miss their gates."""

    def __init__(self) -> None:
        self.judged = self.failed = 0

    def text(self, count: int, runs: int, low: float, high: float = 1.0) -> str:
        """A percentage, with a mark if it is outside the gate and 3 standard errors."""
        margin = 3 * math.sqrt(low * (1 - low) / runs)
        good = low - margin <= count / runs <= high + margin
        self.judged, self.failed = self.judged + 1, self.failed + (not good)
        return f"{100 * count / runs:.1f}" + ("" if good else " **missed**")


MOVING_CASES = (*((name, "nothing") for name in MOTIONS), ("scale 0.2 %, delay 2 ms", "white too small"))


def main() -> None:
    """Run the study and write its page."""
    cells = {f"tune {name} {wrong}": (_cell, (name, wrong)) for name in SETTINGS for wrong in WRONG}
    done = run("tune", cells, settings=f"{RUNS} {FACTOR} {SETTINGS}")
    aided = {
        f"tune {name} {wrong}": (_aided_cell, (name, wrong))
        for name, aiding in AIDINGS.items()
        for wrong in wrong_numbers(len(aiding.deviations))
    }
    done |= run("tune-aided", aided, settings=f"{FEWER_RUNS} {FACTOR} {AIDED} {AIDINGS}")
    moving = {f"tune {name} {wrong}": (_moving_cell, (name, wrong)) for name, wrong in MOVING_CASES}
    done |= run("tune-moving", moving, settings=f"{FEWER_RUNS} {FACTOR} {AIDED} {MOTIONS}")
    gates = Gates()
    lines = [_HEAD.format(runs=RUNS, factor=FACTOR)]
    for name, setting in SETTINGS.items():
        lines += [
            f"## {name.capitalize()}", "",
            f"N = {setting.noise:g}, K = {setting.walk:g}, √R = {setting.deviation:g} in SI, every {setting.interval:g} s.",
            "",
            "| noise of the filter | judged right | √R covered | N covered | K covered |", "|---|---|---|---|---|",
        ]  # fmt: skip
        for wrong in WRONG:
            right, _, *covered = done[f"tune {name} {wrong}"]
            row = " | ".join(gates.text(count, RUNS, 0.95, 0.95) for count in covered)
            lines.append(f"| {wrong} | {gates.text(right, RUNS, 0.95 if wrong == 'nothing' else 0.90)} | {row} |")
        lines.append("")
    lines.append(_AIDED_HEAD.format(runs=FEWER_RUNS))
    for name, aiding in AIDINGS.items():
        count = len(aiding.deviations)
        columns = ["√R"] if count == 1 else [f"√R {k + 1}" for k in range(count)]
        columns = [f"{column} covered" for column in (*columns, "N", "K")]
        lines += [
            f"### {name}", "", _AIDED[aiding.kind], "",
            f"| noise of the filter | judged right | {' | '.join(columns)} |", "|---" * (2 + len(columns)) + "|",
        ]  # fmt: skip
        for wrong in wrong_numbers(count):
            right, _, *covered = done[f"tune {name} {wrong}"]
            row = " | ".join(gates.text(each, FEWER_RUNS, 0.95, 0.95) for each in covered)
            lines.append(f"| {wrong} | {gates.text(right, FEWER_RUNS, 0.95 if wrong == 'nothing' else 0.90)} | {row} |")
        lines.append("")
    lines += [
        _MOVING_HEAD.format(runs=FEWER_RUNS),
        "| motion | noise of the filter | named right | scale covered | delay covered | noise judged right |",
        "|---|---|---|---|---|---|",
    ]
    for name, wrong in MOVING_CASES:
        scale, delay, _ = MOTIONS[name]
        named, *covered, right = done[f"tune {name} {wrong}"]
        texts = [
            gates.text(named, FEWER_RUNS, 0.90 if scale or delay else 0.95),
            *(gates.text(each, FEWER_RUNS, 0.95) for each in covered),
            gates.text(right, FEWER_RUNS, 0.95 if wrong == "nothing" else 0.90),
        ]
        lines.append(f"| {name} | {wrong} | {' | '.join(texts)} |")
    lines += ["", f"{gates.judged - gates.failed} of {gates.judged} gates are met."]
    Path("docs/study/tune.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


_HEAD = """# Does tune name the wrong noise of a filter?

Made by `make study` (studies/tune.py). Kalman filters of an angle or a velocity and the bias of its sensor run on a
simulated truth. Each filter assumes one number that is wrong by a factor of {factor:g}: the deviation of its measurement √R,
N or K. The innovations after its convergence (a tenth of the run) and their S are given to `tune`, with N and K of the
filter.

*Judged right*: the verdict is "wrong", with this noise in this direction and no other; for *nothing* the verdict is
"consistent". *Covered*: 95 % intervals of the factors that contain the truth. {runs} runs a row, in %. Gates: right in at
least 90 %, consistent in at least 95 %, coverage 95 %; each ± 3 standard errors.
"""

_AIDED_HEAD = """## Several measurements, and an S that varies

The sensor and √R are those of the consumer gyro, 20 min. The filter has several measurements with a deviation each, or its S
varies. {runs} runs a row, the same gates.
"""

_AIDED = {
    "together": "Two measurements of the angle come together, with √R and 2 √R, every 0.2 s; S is a matrix.",
    "in turn": "One sensor every 0.2 s with √R, and one once a second with √R / 2 at times between.",
    "adaptive": "R follows the quality of the measurement: √R is 1 to 4 times as large, and 3 times more in bursts of 5 s.",
    "dropouts": "One of three measurements is lost, and all of 10 s in each 2 min.",
}

_MOVING_HEAD = """## Motion: a scale error, and a delay

The consumer gyro turns to and fro, 0.3 rad/s with a period of 7.3 s and 0.2 rad/s with 19 s. Its scale is wrong, or the
measurement is late. The rate given to `tune` is the true one, or that of the gyro with its noise. *Named right*: an error is
claimed for what is wrong, and for nothing else. *Covered*: intervals that contain the truth, wider than 95 % by what
the noise of the gyro in the rate can do. {runs} runs a row. Gates: named right in at least 90 % (nothing in 95 %), coverage
at least 95 %, the noise as above; each less 3 standard errors.
"""


if __name__ == "__main__":
    main()
