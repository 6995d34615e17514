"""PX4: parameters ``EKF2_*`` of its Kalman filter, as a file that QGroundControl loads.

Each prediction adds (dt·p)² to the variance of the angle (velocity), and (dt·p)² to that of the bias, so that N²·dt and
K²·dt are p = N/√dt and p = K/√dt: the numbers hold for one step dt, which is EKF2_PREDICT_US.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from sigmatau.errors import OptionError
from sigmatau.exporting.choices import given
from sigmatau.exporting.target import Target
from sigmatau.exporting.text import comment, number, single
from sigmatau.exporting.values import Number, Numbers
from sigmatau.results import seconds

__all__ = ["TARGET", "Parameter", "left_out", "rows", "step_of"]

_LONGEST_STEP = 1.0  # s; no filter of a vehicle predicts so seldom

_STEP = 0.01  # s; EKF2_PREDICT_US as it is delivered


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameter:
    """A parameter of an autopilot.

    Attributes
    ----------
    name : str
    sensor : {"gyro", "accel"}
    kind : {"noise", "walk"}
    unit : str
    least, most : float
        The range that is documented, which ground stations may hold a value to.
    cut : float
        What the filter takes of what is larger.
    """

    name: str
    sensor: str
    kind: str
    unit: str
    least: float
    most: float
    cut: float = 1.0


_PARAMETERS = (  # the first releases of EKF2 put the least in the place of what is below it
    Parameter(name="EKF2_GYR_NOISE", sensor="gyro", kind="noise", unit="rad/s", least=1e-4, most=0.1),
    Parameter(name="EKF2_ACC_NOISE", sensor="accel", kind="noise", unit="m/s^2", least=0.01, most=1.0),
    Parameter(name="EKF2_GYR_B_NOISE", sensor="gyro", kind="walk", unit="rad/s^2", least=0.0, most=0.01),
    Parameter(name="EKF2_ACC_B_NOISE", sensor="accel", kind="walk", unit="m/s^3", least=0.0, most=0.01),
)


def rows(numbers: Numbers, parameters: tuple[Parameter, ...], step: float) -> list[tuple[str, float, str]]:
    """Name, value and comment of each parameter; N/√dt and K/√dt."""
    result = []
    for of in parameters:
        found: Number = numbers.noise(of.sensor) if of.kind == "noise" else numbers.walk(of.sensor)
        value = found.value / math.sqrt(step)
        letter = "N" if of.kind == "noise" else "K"
        words = f"{of.name} [{of.unit}] = {letter}/sqrt(dt), dt = {step:g} s; {found.words}"
        if value > of.cut:
            words += f"; above {of.cut:g}, which is what the filter takes instead"
        elif not of.least <= value <= of.most:
            side, end = ("below", of.least) if value < of.least else ("above", of.most)
            words += f"; {side} {end:g}, the {'least' if value < of.least else 'most'} documented: a ground station may"
            words += " refuse it or ask"
        result.append((of.name, value, comment(words)))
    return result


def step_of(numbers: Numbers, default: float) -> float:
    """The step of the filter; raises `OptionError` for one that must be milliseconds taken for seconds. [s]"""
    step = numbers.choices.step or default
    if step > _LONGEST_STEP:
        raise OptionError(
            f"{{option}} {step:g}: it is in seconds, and no filter of an autopilot has one of {step:g} s; {step:g} ms are"
            f" {given('step', step / 1000)}",
            option="step",
        )
    return step


def left_out(numbers: Numbers) -> list[str]:
    """A comment on slow noise that a walk is not, unless the walk was chosen to stand for it."""
    lines = []
    for sensor in ("gyro", "accel"):
        channels = numbers.channels(sensor).values()
        slow = any("bias_instability" in model or model.gauss_markov for model in channels)
        if slow and numbers.choices.walk.get(sensor) != "horizon":
            lines.append(
                f"# {sensor}: the model has flicker or Gauss-Markov noise too, which has no place here and is in no number;"
                f" --rate-random-walk {sensor}=horizon --horizon S makes the walk stand for all of it."
            )
    return lines


def write(numbers: Numbers) -> str:
    """The text of the file: vehicle, component, name, value, type (9: single precision), with tabs between."""
    ids = [_identity(numbers, key) for key in ("vehicle", "component")]
    step = step_of(numbers, _STEP)
    lines = [
        f"# EKF2 noise for a prediction step of {seconds(1000 * step)} ms: right while EKF2_PREDICT_US is"
        f" {round(1e6 * step)}; --step changes it.",
        "# Not densities: each is a density over sqrt(dt), of which the filter takes (dt*p)^2. Single precision.",
        *left_out(numbers),
        "# vehicle\tcomponent\tname\tvalue\ttype",
    ]
    for name, value, words in rows(numbers, _PARAMETERS, step):
        lines += [f"# {words}", "\t".join([*ids, name, single(value, name), "9"])]
    return "\n".join(lines) + "\n"


def _identity(numbers: Numbers, key: str) -> str:
    value = number(numbers.name(key, "1"), key, least=1)
    if value != int(value) or value > 255:
        raise OptionError(f"{{option}} {key}={value:g}: want a whole number from 1 to 255", option="name")
    return str(int(value))


TARGET = Target(
    name="px4",
    summary="PX4 EKF2 parameters: N/sqrt(dt) and K/sqrt(dt), dt its prediction step (10 ms, --step)",
    ending=".params",
    write=write,
    has_step=True,
    names={"vehicle": "1", "component": "1"},
)
