"""Test of the factor of vibration on N, and of its cause: pairs of simulated records at rest and with running motors.

    python -m studies.inflation

writes docs/study/inflation.md.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from sigmatau import NoiseModel, Record, analyze, simulate
from sigmatau.exporting.inflation import Cause, inflation
from studies.runner import run

PAIRS = 100
RATE = 50.0  # [Hz]
REST, RUNNING = 1800.0, 600.0  # durations of the records [s]
LINE = (13.0, 20.0)  # frequency [Hz]; amplitude over the deviation of a sample at rest
_DEG_SQRT_H = math.radians(1) / 60
NOISE, FLICKER = 0.3 * _DEG_SQRT_H, math.radians(6) / 3600

KINDS: Mapping[str, tuple[float, bool, tuple[Cause, ...]]] = {
    "nothing": (1.0, False, ()),
    "white, 1.5 times": (1.5, False, ("white vibration",)),
    "white, 3 times": (3.0, False, ("white vibration",)),
    "a line at 13 Hz": (1.0, True, ("lines",)),
    "white, 3 times, and the line": (3.0, True, ("white vibration", "lines")),
}


def record_of(noise: float, duration: float, rng: np.random.Generator, *, line: bool) -> Record:
    """A gyro with white noise and a bias instability, and a line of vibration whose phase is random."""
    model = NoiseModel(channels={"gyro_x": {"random_walk": noise, "bias_instability": FLICKER}})
    rates = simulate(model, duration=duration, rate=RATE, rng=rng).streams[0].column("gyro_x").copy()
    if line:
        frequency, amplitude = LINE
        phase = 2 * math.pi * (frequency * np.arange(len(rates)) / RATE + rng.uniform())
        rates += amplitude * NOISE * math.sqrt(RATE) * np.sin(phase)
    return Record.from_arrays(rate=RATE, unit={"gyro": "rad/s"}, gyro_x=rates)


def judge_kind(seed: int, name: str) -> list[int]:
    """Numbers of intervals that contain the true factor, and of correct causes."""
    rng = np.random.default_rng(seed)
    factor, line, causes = KINDS[name]
    counts = np.zeros(2, dtype=int)
    for _ in range(PAIRS):
        rest = analyze(record_of(NOISE, REST, rng, line=False), threads=1).to_source()
        running = analyze(record_of(factor * NOISE, RUNNING, rng, line=line), at_rest=True, threads=1).to_source()
        result = inflation(rest, running)
        measured = result.factors[0]
        low, high = measured.low or 0.0, math.inf if measured.high is None else measured.high
        covered = measured.value is not None and low <= factor <= high
        counts += np.array([covered, tuple(cause.cause for cause in result.causes) == causes])
    return [int(count) for count in counts]


def main() -> None:
    """Run the study and write its page."""
    cells = {f"inflation {name}": (judge_kind, (name,)) for name in KINDS}
    done = run("inflation", cells, settings=f"{PAIRS} {RATE} {REST} {RUNNING} {LINE} {NOISE} {FLICKER}")
    lines, failed, judged = [_HEAD.format(pairs=PAIRS, rest=REST / 60, running=RUNNING / 60, rate=RATE)], 0, 0
    lines += ["| vibration | factor on N covered | cause right |", "|---|---|---|"]
    for name, (_, _, causes) in KINDS.items():
        texts = []
        for count, smallest in zip(done[f"inflation {name}"], (0.95, 0.90 if causes else 0.95), strict=True):
            good = count / PAIRS >= smallest - 3 * math.sqrt(smallest * (1 - smallest) / PAIRS)
            judged, failed = judged + 1, failed + (not good)
            texts.append(f"{100 * count / PAIRS:.0f}" + ("" if good else " **missed**"))
        lines.append(f"| {name} | {' | '.join(texts)} |")
    lines += ["", f"{judged - failed} of {judged} gates are met."]
    Path("docs/study/inflation.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


_HEAD = """# Is the factor of vibration on N right?

Made by `make study` (studies/inflation.py). `tune --rest` compares a record at rest with one beside motors, see
[how much to inflate](../how-to/inflate.md). Here a gyro with 0.3°/√h and 6°/h is simulated for {rest:g} min at rest,
and for {running:g} min with vibration: more white noise, or a line of 20 times the noise of a sample, at {rate:g} Hz.
Beside the line alone N has an upper limit only, and so has its factor. {pairs} pairs a row, in %. Gates: the 95 %
interval contains the true factor in at least 95 %, the causes are those of the row and no others in at least 90 %
(nothing in 95 %); each less 3 standard errors.
"""


if __name__ == "__main__":
    main()
