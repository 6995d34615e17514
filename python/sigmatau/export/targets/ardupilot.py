"""ArduPilot: parameters ``EK3_*`` of its Kalman filter, as a file that Mission Planner, MAVProxy and QGroundControl load.

Its states are angle and velocity increments: a step adds (dt·p)² to the variance of the angle and (dt²·p)² to that of the
bias times dt, which are N²·dt and K²·dt·dt² for p = N/√dt and p = K/√dt.
"""

from __future__ import annotations

from sigmatau.export.numbers import Numbers
from sigmatau.export.target import Target
from sigmatau.export.targets.px4 import left_out, rows, step_of
from sigmatau.export.text import single
from sigmatau.results import seconds

__all__ = ["TARGET"]

_NAMES = (
    ("EK3_GYRO_P_NSE", "gyro", "noise", "rad/s"),
    ("EK3_ACC_P_NSE", "accel", "noise", "m/s^2"),
    ("EK3_GBIAS_P_NSE", "gyro", "walk", "rad/s^2"),
    ("EK3_ABIAS_P_NSE", "accel", "walk", "m/s^3"),
)


_FLOORS = {"EK3_GYRO_P_NSE": 1e-4, "EK3_ACC_P_NSE": 0.01}


def write(numbers: Numbers) -> str:
    """The text of the file, NAME,VALUE; comments on lines of their own, which every loader skips."""
    step = step_of(numbers)
    lines = [
        f"# EK3 noise for a filter step of {seconds(1000 * step)} ms: the longer of 10 ms and the loop; --step changes it.",
        "# Not densities: each is a density over sqrt(dt), of which the filter takes (dt*p)^2 and (dt^2*p)^2.",
        *left_out(numbers),
    ]
    for name, value, words in rows(numbers, _NAMES, _FLOORS):
        lines += [f"# {words}", f"{name},{single(value, name)}"]
    return "\n".join(lines) + "\n"


TARGET = Target(
    name="ardupilot",
    summary="ArduPilot EK3 parameters: N/sqrt(dt) and K/sqrt(dt), dt the step of its filter (10 ms, --step)",
    ending=".parm",
    write=write,
    has_step=True,
)
