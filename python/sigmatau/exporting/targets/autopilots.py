"""PX4 and ArduPilot: process noise of their Kalman filters, as parameter files that ground stations load.

EKF2 of PX4 adds (dt·p)² to the variance of the angle (velocity) at each prediction, and (dt·p)² to that of the bias, so that
N²·dt and K²·dt are p = N/√dt and p = K/√dt. The states of EKF3 of ArduPilot are angle and velocity increments: a step adds
(dt·p)² to the variance of the angle and (dt²·p)² to that of the bias times dt, which are N²·dt and K²·dt·dt² for the same p.
The numbers hold for one step dt.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from sigmatau.errors import OptionError
from sigmatau.exporting.statements import pair_remarks
from sigmatau.exporting.target import Target
from sigmatau.exporting.text import comment, number, remark, single
from sigmatau.exporting.turn_on import TURN_ON_NAMES, turn_on
from sigmatau.exporting.values import Numbers
from sigmatau.hints import Hint
from sigmatau.results import seconds

_STEP = Hint("step")
_LONGEST_STEP = 1.0  # s; no filter of a vehicle predicts less often

# EKF2_PREDICT_US as it is delivered.
_PX4_STEP = 0.01  # s
# Samples are summed until 12 ms less half a loop are full (EKF_TARGET_DT, readIMUData): five loops of 400 Hz.
_ARDUPILOT_STEP = 0.0125  # s


@dataclass(frozen=True, slots=True, kw_only=True)
class _Parameter:
    """A parameter of an autopilot."""

    name: str
    sensor: str
    kind: str
    unit: str
    low: float  # The documented range, which ground stations may enforce
    high: float
    cut: float = 1.0  # Largest value that the filter uses


_PX4_PARAMETERS = (  # the first releases of EKF2 replace what is below the least by it
    _Parameter(name="EKF2_GYR_NOISE", sensor="gyro", kind="noise", unit="rad/s", low=1e-4, high=0.1),
    _Parameter(name="EKF2_ACC_NOISE", sensor="accel", kind="noise", unit="m/s^2", low=0.01, high=1.0),
    _Parameter(name="EKF2_GYR_B_NOISE", sensor="gyro", kind="walk", unit="rad/s^2", low=0.0, high=0.01),
    _Parameter(name="EKF2_ACC_B_NOISE", sensor="accel", kind="walk", unit="m/s^3", low=0.0, high=0.01),
)
# Initial uncertainty of a bias, with the largest documented value; 0.1 rad/s and 0.2 m/s^2 as delivered.
_PX4_INITIAL = (("EKF2_GBIAS_INIT", "gyro", "rad/s", 0.2), ("EKF2_ABIAS_INIT", "accel", "m/s^2", 0.5))
_ARDUPILOT_PARAMETERS = (
    _Parameter(name="EK3_GYRO_P_NSE", sensor="gyro", kind="noise", unit="rad/s", low=1e-4, high=0.1),
    _Parameter(name="EK3_ACC_P_NSE", sensor="accel", kind="noise", unit="m/s^2", low=0.01, high=1.0, cut=5.0),
    _Parameter(name="EK3_GBIAS_P_NSE", sensor="gyro", kind="walk", unit="rad/s^2", low=1e-5, high=1e-3),
    _Parameter(name="EK3_ABIAS_P_NSE", sensor="accel", kind="walk", unit="m/s^3", low=1e-5, high=0.02),
)


def _write_px4(numbers: Numbers) -> str:
    """Vehicle, component, name, value and type (9: single precision), with tabs between."""
    ids = [_identity(numbers, key) for key in ("vehicle", "component")]
    step = _step(numbers, _PX4_STEP)
    lines = [
        f"# EKF2 noise for a prediction step of {seconds(1000 * step)} ms, EKF2_PREDICT_US ="
        f" {round(1e6 * step)}; {_STEP} changes it.",
        "# Not densities: each is p = density/sqrt(dt), and the filter uses (dt*p)^2. Single precision.",
        *map(remark, pair_remarks(numbers, has_turn_on=True)),
        "# vehicle\tcomponent\tname\tvalue\ttype",
    ]
    for name, value, words in [*_rows(numbers, _PX4_PARAMETERS, step), *_initial_rows(numbers)]:
        lines += [f"# {words}", "\t".join([*ids, name, single(value, name), "9"])]
    return "\n".join(lines) + "\n"


def _write_ardupilot(numbers: Numbers) -> str:
    """NAME,VALUE; comments on lines of their own, which every loader skips."""
    step = _step(numbers, _ARDUPILOT_STEP)
    lines = [
        f"# EK3 noise for a filter step of {seconds(1000 * step)} ms. Steps by SCHED_LOOP_RATE: 12.5 ms at 400 Hz, 13.33"
        f" at 300, 10 at 200 or 100, 20 at 50; set it with {_STEP}.",
        "# Not densities: each is p = density/sqrt(dt), and the filter uses (dt*p)^2 and (dt^2*p)^2.",
        *map(remark, pair_remarks(numbers)),
    ]
    for name, value, words in _rows(numbers, _ARDUPILOT_PARAMETERS, step):
        lines += [f"# {words}", f"{name},{single(value, name)}"]
    return "\n".join(lines) + "\n"


def _rows(numbers: Numbers, parameters: tuple[_Parameter, ...], step: float) -> list[tuple[str, float, str]]:
    """Name, value and comment of each parameter; N/√dt and K/√dt."""
    result = []
    for parameter in parameters:
        number = numbers.noise(parameter.sensor) if parameter.kind == "noise" else numbers.walk(parameter.sensor)
        value = number.value / math.sqrt(step)
        letter = "N" if parameter.kind == "noise" else "K"
        words = f"{parameter.name} [{parameter.unit}] = {letter}/sqrt(dt), dt = {step:g} s; {number.words}"
        if value > parameter.cut:
            words += f"; the filter limits it to {parameter.cut:g}"
        elif not parameter.low <= value <= parameter.high:
            documented = f"{parameter.low:g} to {parameter.high:g}"
            words += f"; outside the documented range, {documented}: a ground station may reject it"
        result.append((parameter.name, value, comment(words)))
    return result


def _initial_rows(numbers: Numbers) -> list[tuple[str, float, str]]:
    """Name, value and comment of the uncertainty of the initial biases of PX4, if the model has turn-on biases."""
    result = []
    for name, sensor, unit, largest in _PX4_INITIAL:
        start = turn_on(numbers, sensor)
        if start is not None:
            words = f"{name} [{unit}], the uncertainty of the bias at start; {start.words}"
            if start.value > largest:
                words += f"; outside the documented range, 0 to {largest:g}: a ground station may reject it"
            result.append((name, start.value, comment(words)))
    return result


def _step(numbers: Numbers, default: float) -> float:
    """The step of the filter; raises `OptionError` for milliseconds given as seconds. [s]"""
    step = numbers.choices.step or default
    if step > _LONGEST_STEP:
        raise OptionError(
            f"{{option}} {step:g} is too long for an autopilot; the unit is s: {step:g} ms is"
            f" {Hint('step', value=step / 1000)}",
            option="step",
        )
    return step


def _identity(numbers: Numbers, key: str) -> str:
    value = number(numbers.name(key, "1"), key, low=1)
    if value != int(value) or value > 255:
        raise OptionError(f"{{option}} {key}={value:g}: want a whole number from 1 to 255", option="name")
    return str(int(value))


PX4 = Target(
    name="px4",
    summary=f"PX4 EKF2 parameters: N/sqrt(dt) and K/sqrt(dt), dt its prediction step (10 ms, {_STEP})",
    ending=".params",
    write=_write_px4,
    has_step=True,
    has_walk=True,
    names={"vehicle": "1", "component": "1", **TURN_ON_NAMES},
)

ARDUPILOT = Target(
    name="ardupilot",
    summary=f"ArduPilot EK3 parameters: N/sqrt(dt) and K/sqrt(dt), dt the step of its filter (12.5 ms, {_STEP})",
    ending=".parm",
    write=_write_ardupilot,
    has_step=True,
    has_walk=True,
)
