"""PX4: process noise of EKF2, as a parameter file that ground stations load.

At each prediction EKF2 adds (dt·p)² to the variance of the angle (velocity) and to that of the bias. These are N²·dt for
p = N/√dt, and K²·dt for p = K/√dt. The numbers hold for one step dt.
"""

from __future__ import annotations

from sigmatau.errors import OptionError
from sigmatau.exporting.autopilot import STEP, AutopilotParameter, choose_step, parameter_rows
from sigmatau.exporting.statements import pair_remarks
from sigmatau.exporting.target import Target
from sigmatau.exporting.text import comment, number, remark, single
from sigmatau.exporting.turn_on import TURN_ON_NAMES, turn_on
from sigmatau.exporting.values import Numbers
from sigmatau.results import seconds

_STEP = 0.01  # default of EKF2_PREDICT_US [s]
_PARAMETERS = (  # the first releases of EKF2 raise smaller values to the minimum
    AutopilotParameter(name="EKF2_GYR_NOISE", sensor="gyro", kind="noise", unit="rad/s", low=1e-4, high=0.1),
    AutopilotParameter(name="EKF2_ACC_NOISE", sensor="accel", kind="noise", unit="m/s^2", low=0.01, high=1.0),
    AutopilotParameter(name="EKF2_GYR_B_NOISE", sensor="gyro", kind="walk", unit="rad/s^2", low=0.0, high=0.01),
    AutopilotParameter(name="EKF2_ACC_B_NOISE", sensor="accel", kind="walk", unit="m/s^3", low=0.0, high=0.01),
)
# Initial uncertainty of a bias, with the largest documented value; the defaults are 0.1 rad/s and 0.2 m/s^2.
_INITIAL = (("EKF2_GBIAS_INIT", "gyro", "rad/s", 0.2), ("EKF2_ABIAS_INIT", "accel", "m/s^2", 0.5))


def write(numbers: Numbers) -> str:
    """Lines of vehicle, component, name, value and type (9: single precision), separated by tabs."""
    ids = [_identity(numbers, key) for key in ("vehicle", "component")]
    step = choose_step(numbers, _STEP)
    lines = [
        f"# EKF2 noise for a prediction step of {seconds(1000 * step)} ms, EKF2_PREDICT_US ="
        f" {round(1e6 * step)}; {STEP} changes it.",
        "# Not densities: each is p = density/sqrt(dt), and the filter uses (dt*p)^2. Single precision.",
        *map(remark, pair_remarks(numbers, has_turn_on=True)),
        "# vehicle\tcomponent\tname\tvalue\ttype",
    ]
    for name, value, words in [*parameter_rows(numbers, _PARAMETERS, step), *_initial_rows(numbers)]:
        lines += [f"# {words}", "\t".join([*ids, name, single(value, name), "9"])]
    return "\n".join(lines) + "\n"


def _initial_rows(numbers: Numbers) -> list[tuple[str, float, str]]:
    """Name, value and comment of the uncertainty of the initial biases of PX4, if the model has turn-on biases."""
    result = []
    for name, sensor, unit, largest in _INITIAL:
        start = turn_on(numbers, sensor)
        if start is not None:
            words = f"{name} [{unit}], the uncertainty of the bias at start; {start.words}"
            if start.value > largest:
                words += f"; outside the documented range, 0 to {largest:g}: a ground station may reject it"
            result.append((name, start.value, comment(words)))
    return result


def _identity(numbers: Numbers, key: str) -> str:
    value = number(numbers.name(key, "1"), key, low=1)
    if value != int(value) or value > 255:
        raise OptionError(f"{{option}} {key}={value:g}: want a whole number from 1 to 255", option="name")
    return str(int(value))


TARGET = Target(
    name="px4",
    program="PX4 (EKF2)",
    columns=("N/√dt, K/√dt, dt of the filter", "nothing: dt is 10 ms (`EKF2_PREDICT_US`), or `--step`"),
    aliases=("ekf2",),
    summary=f"PX4 EKF2 parameters: N/sqrt(dt) and K/sqrt(dt), dt its prediction step (10 ms, {STEP})",
    ending=".params",
    write=write,
    has_step=True,
    has_walk=True,
    names={"vehicle": "1", "component": "1", **TURN_ON_NAMES},
)
