"""KF-GINS: the block ``imunoise`` of its configuration.

The biases are first-order Gauss-Markov processes with a common correlation time, driven by noise of density 2σ²/corrtime.
KF-GINS is a filter: with the written σ it states its error at the horizon correctly, like a filter with a consistent K.
KF-GINS converts the units of the file itself.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import partial

from sigmatau.exporting.axes import by_axis, noises
from sigmatau.exporting.choices import KINDS
from sigmatau.exporting.consistent import HORIZON, consistent_process, judge_process
from sigmatau.exporting.gauss_markov import OWN_PROCESSES, Process, omitted_by_process, process, replaced_noise
from sigmatau.exporting.statements import SHARE_OF_UNOBSERVED, factors_remark, worst_of_axes
from sigmatau.exporting.target import Target, Unused
from sigmatau.exporting.text import digits, joined, measured, number, remark, vector
from sigmatau.exporting.turn_on import TURN_ON_NAMES, turn_on_axes
from sigmatau.exporting.values import Numbers
from sigmatau.hints import Hint
from sigmatau.model.processes import GaussMarkov
from sigmatau.navigation.reference_filter import RUN, run_of_process
from sigmatau.results import duration_text, seconds
from sigmatau.units import find

_BIASES = (("gbstd", "gyro", "deg/h"), ("abstd", "accel", "mGal"))


def write(numbers: Numbers) -> str:
    """The text of the block; vectors are forward, right, down."""
    consistent = [sensor for sensor in KINDS if _is_consistent(numbers, sensor)]
    approximated = {
        sensor: by_axis(numbers, sensor, partial(process, sensor=sensor))
        for sensor in KINDS
        if sensor not in consistent
    }
    time = _time(numbers, consistent, [axis for axes in approximated.values() for axis in axes])
    biases = {sensor: tuple(axis.with_time(time) for axis in axes) for sensor, axes in approximated.items()}
    biases |= {
        sensor: by_axis(numbers, sensor, partial(_consistent, sensor=sensor, time=time)) for sensor in consistent
    }
    noise = {sensor: noises(numbers, sensor) for sensor in KINDS}
    lines = [
        "# KF-GINS converts these units itself. Axes forward, right, down, as in the IMU file.",
        *map(remark, (*replaced_noise(numbers), *omitted_by_process(numbers, has_turn_on=True))),
        *(remark(_states(numbers, sensor, biases[sensor])) for sensor in consistent),
        "imunoise:",
    ]
    for key, sensor, unit in (("arw", "gyro", "deg/sqrt(h)"), ("vrw", "accel", "m/s/sqrt(h)")):
        size = find(unit).factor
        words = joined(axis.words for axis in noise[sensor])
        lines.append(f"  {key}: {vector(axis.value / size for axis in noise[sensor])}  # {unit}; {words}")
    for key, sensor, unit in _BIASES:
        size = find(unit).factor
        words = joined(axis.words for axis in biases[sensor])
        lines.append(
            f"  {key}: {vector(axis.sigma / size for axis in biases[sensor])}  # {unit}, standard deviation; {words}"
        )
    for key in ("gsstd", "asstd"):
        ppm = number(numbers.name(key, "300"), key)
        origin = "given" if key in numbers.choices.names else f"from the sample of KF-GINS, {Hint('names', key, 'PPM')}"
        lines.append(
            f"  {key}: [{', '.join([digits(ppm)] * 3)}]  # ppm; scale factor, not visible in a static record: {origin}"
        )
    lines.append(f"  corrtime: {measured(time / 3600)}  # h; {seconds(time)} s, {_time_words(numbers, consistent)}")
    lines += _initial_lines(numbers)
    return "\n".join(lines) + "\n"


def _is_consistent(numbers: Numbers, sensor: str) -> bool:
    """Whether σ is that of a consistent filter: always, unless a walk is chosen or the user wants only observed terms."""
    chosen = numbers.choices.strict or sensor in numbers.choices.walk or not numbers.has(sensor)
    return not chosen and any(truth.slow for truth in numbers.truths(numbers.channels(sensor)))


def _consistent(numbers: Numbers, sensor: str, time: float) -> Process:
    """Consistent process of a sensor: the largest of its axes, or their root mean square."""
    names = list(numbers.channels(sensor))
    slow = [name for name, truth in zip(names, numbers.truths(names), strict=True) if truth.slow]
    factor, horizon = numbers.factor("rate_random_walk", sensor), numbers.choices.horizon or HORIZON
    chosen = {
        name: consistent_process(
            truth, sensor=sensor, noise=_noise(numbers, sensor, [name]), horizon=horizon, time=time
        )
        for name, truth in zip(slow, numbers.truths(slow), strict=True)
    }
    sigmas = {name: factor * each.process.sigma for name, each in chosen.items()}
    worst = max(sigmas, key=lambda name: sigmas[name])
    sigma, axis = sigmas[worst], worst if len(sigmas) == 1 else f"worst of {len(sigmas)} axes, {worst}"
    if numbers.choices.axes == "mean" and len(sigmas) > 1:
        sigma, axis = (
            math.sqrt(sum(each**2 for each in sigmas.values()) / len(sigmas)),
            f"root mean square of {', '.join(slow)}",
        )
    times = "" if factor == 1 else f", times {factor:g}"
    doubts = next(filter(None, map(numbers.doubt, slow)), "")
    states = f"its error after {duration_text(horizon)}"
    words = f"consistent: a filter with it states {states} correctly"
    if chosen[worst].is_floor:
        words = f"the smallest σ used here; N alone states {states}"
    origin = f"{axis}: {words}{times}{doubts}"
    return Process(sigma=sigma, time=time, origin=origin, fit="", place="the horizon")


def _noise(numbers: Numbers, sensor: str, names: Iterable[str]) -> float:
    """N of a filter for some axes, without its factor."""
    return max(numbers.channel_noise(name).value for name in names) / numbers.factor("random_walk", sensor)


def _states(numbers: Numbers, sensor: str, biases: Iterable[Process]) -> str:
    """Sentence on the errors that a filter with the numbers of a sensor states."""
    names, horizon = list(numbers.channels(sensor)), numbers.choices.horizon or HORIZON
    each = numbers.choices.axes == "each"
    judged = [
        judge_process(
            numbers.truths([name] if each else names),
            GaussMarkov(sigma=bias.sigma, time=bias.time),
            sensor=sensor,
            noise=numbers.channel_noise(name).value if each else numbers.noise(sensor).value,
            horizon=horizon,
            mean=numbers.choices.axes == "mean",
        )
        for name, bias in zip(names, biases, strict=False)
        if each or name == names[0]
    ]
    worst = worst_of_axes(numbers, judged)
    run = duration_text(run_of_process(horizon, next(iter(biases)).time))
    share = SHARE_OF_UNOBSERVED.get(numbers.choices.unobserved, "")
    is_assumed = any(truth.assumed for truth in numbers.truths(names))
    assumed = f" Terms that were not observed count {share}." if is_assumed else ""
    every = f", the worst of {len(judged)} axes" if len(judged) > 1 else ""
    return f"{worst.text()}; in a run of {run}{every}.{assumed}{factors_remark(numbers, sensor)}"


def _initial_lines(numbers: Numbers) -> list[str]:
    """Keys for the initial biases if the model has turn-on biases; without them KF-GINS uses gbstd and abstd."""
    lines = []
    for key, sensor, unit in (("initbgstd", "gyro", "deg/h"), ("initbastd", "accel", "mGal")):
        axes = turn_on_axes(numbers, sensor)
        if axes is not None:
            size = find(unit).factor
            words = joined(number.words for number in axes)
            lines.append(f"{key}: {vector(number.value / size for number in axes)}  # {unit}; {words}")
    return ["# Uncertainty of the initial biases, separate keys beside imunoise:", *lines] if lines else []


def _time(numbers: Numbers, consistent: list[str], processes: list[Process]) -> float:
    """Common correlation time. [s]"""
    if "corrtime" in numbers.choices.names:
        return 3600 * number(numbers.choices.names["corrtime"], "corrtime", low=1e-6, high=1e6)
    if consistent:
        return RUN * (numbers.choices.horizon or HORIZON)
    times = [each.time for each in processes]
    if min(times) == max(times):
        return times[0]
    return math.exp(sum(map(math.log, times)) / len(times))


def _time_words(numbers: Numbers, consistent: list[str]) -> str:
    if "corrtime" in numbers.choices.names:
        return "given"
    if consistent:
        return f"{RUN:g} horizons, {Hint('names', 'corrtime', 'HOURS')}"
    return f"one for all: geometric mean of the processes, {Hint('names', 'corrtime', 'HOURS')}"


def _has_horizon_without_use(numbers: Numbers) -> bool:
    """Whether the horizon is not used: all processes are those of the model, and no σ is that of a consistent filter."""
    when = OWN_PROCESSES.when
    return not any(_is_consistent(numbers, sensor) for sensor in KINDS) and when is not None and when(numbers)


def _is_approximated(numbers: Numbers) -> bool:
    """Whether no σ is that of a consistent filter, so that terms that were not observed have no effect."""
    return not any(_is_consistent(numbers, sensor) for sensor in KINDS)


TARGET = Target(
    name="kf-gins",
    program="KF-GINS (imunoise)",
    columns=("N; σ, Tc, consistent as K is", "nothing"),
    summary="KF-GINS imunoise: N, each bias as a Gauss-Markov process with one correlation time, by axis",
    ending=".yaml",
    write=write,
    has_process=True,
    has_horizon=True,
    has_unobserved=True,
    has_consistent=True,
    unused=(
        Unused(choices=("horizon",), why=OWN_PROCESSES.why, when=_has_horizon_without_use),
        Unused(choices=("unobserved",), why="its processes are those of observed terms", when=_is_approximated),
    ),
    needs_axes=True,
    per_axis=True,
    names={"gsstd": "300", "asstd": "300", "corrtime": "", **TURN_ON_NAMES},
)
