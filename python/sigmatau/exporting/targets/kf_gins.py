"""KF-GINS: the block ``imunoise`` of its configuration.

The biases are first-order Gauss-Markov processes with one correlation time for all, driven by noise of density 2σ²/corrtime.
KF-GINS converts the units of the file itself.
"""

from __future__ import annotations

import math

from sigmatau.exporting.gauss_markov import OWN_PROCESSES, Process, noises_and_processes, replaced_noise
from sigmatau.exporting.target import Target
from sigmatau.exporting.text import digits, joined, measured, number, remark, vector
from sigmatau.exporting.turn_on import TURN_ON_NAMES, turn_on_axes
from sigmatau.exporting.values import Numbers
from sigmatau.hints import Hint
from sigmatau.results import seconds
from sigmatau.units import find


def write(numbers: Numbers) -> str:
    """The text of the block; vectors are forward, right, down."""
    found = noises_and_processes(numbers)
    time = _time(numbers, [p for _, axes in found.values() for p in axes])
    lines = [
        "# KF-GINS converts these units itself. Axes forward, right, down, as in the IMU file.",
        *map(remark, replaced_noise(numbers)),
        "imunoise:",
    ]
    for key, sensor, unit in (("arw", "gyro", "deg/sqrt(h)"), ("vrw", "accel", "m/s/sqrt(h)")):
        size = find(unit).factor
        noise, _ = found[sensor]
        lines.append(f"  {key}: {vector(n.value / size for n in noise)}  # {unit}; {joined(n.words for n in noise)}")
    for key, sensor, unit in (("gbstd", "gyro", "deg/h"), ("abstd", "accel", "mGal")):
        size = find(unit).factor
        shared = [p.at(time) for p in found[sensor][1]]
        words = joined(p.words for p in shared)
        lines.append(f"  {key}: {vector(p.sigma / size for p in shared)}  # {unit}, standard deviation; {words}")
    for key in ("gsstd", "asstd"):
        ppm = number(numbers.name(key, "300"), key)
        origin = "given" if key in numbers.choices.names else f"from the sample of KF-GINS, {Hint('names', key, 'PPM')}"
        lines.append(
            f"  {key}: [{', '.join([digits(ppm)] * 3)}]  # ppm; scale factor, not visible in a static record: {origin}"
        )
    lines.append(f"  corrtime: {measured(time / 3600)}  # h; {seconds(time)} s, {_of_time(numbers)}")
    lines += _initial_lines(numbers)
    return "\n".join(lines) + "\n"


def _initial_lines(numbers: Numbers) -> list[str]:
    """Keys beside the block for the initial biases, if the model has turn-on biases; KF-GINS takes gbstd, abstd else."""
    lines = []
    for key, sensor, unit in (("initbgstd", "gyro", "deg/h"), ("initbastd", "accel", "mGal")):
        axes = turn_on_axes(numbers, sensor)
        if axes is not None:
            size = find(unit).factor
            words = joined(number.words for number in axes)
            lines.append(f"{key}: {vector(number.value / size for number in axes)}  # {unit}; {words}")
    return ["# Uncertainty of the initial biases, keys of their own beside imunoise:", *lines] if lines else []


def _time(numbers: Numbers, processes: list[Process]) -> float:
    """The one correlation time. [s]"""
    if "corrtime" in numbers.choices.names:
        return 3600 * number(numbers.choices.names["corrtime"], "corrtime", least=1e-6, most=1e6)
    times = [p.time for p in processes]
    if min(times) == max(times):
        return times[0]
    return math.exp(sum(map(math.log, times)) / len(times))


def _of_time(numbers: Numbers) -> str:
    if "corrtime" in numbers.choices.names:
        return "given"
    return f"one for all: geometric mean of the processes, {Hint('names', 'corrtime', 'HOURS')}"


TARGET = Target(
    name="kf-gins",
    summary="KF-GINS imunoise: N, each bias as a Gauss-Markov process with one correlation time, by axis",
    ending=".yaml",
    write=write,
    has_process=True,
    has_horizon=True,
    unused=(OWN_PROCESSES,),
    needs_axes=True,
    per_axis=True,
    names={"gsstd": "300", "asstd": "300", "corrtime": "", **TURN_ON_NAMES},
)
