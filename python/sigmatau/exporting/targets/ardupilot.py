"""ArduPilot: parameters ``EK3_*`` of its Kalman filter, as a file that Mission Planner, MAVProxy and QGroundControl load.

Its states are angle and velocity increments: a step adds (dt·p)² to the variance of the angle and (dt²·p)² to that of the
bias times dt, which are N²·dt and K²·dt·dt² for p = N/√dt and p = K/√dt.
"""

from __future__ import annotations

from sigmatau.exporting.target import Target
from sigmatau.exporting.targets.px4 import Parameter, left_out, rows, step_of
from sigmatau.exporting.text import single
from sigmatau.exporting.values import Numbers
from sigmatau.results import seconds

__all__ = ["TARGET"]

# Samples are summed until 12 ms less half a loop are full (EKF_TARGET_DT, readIMUData): five loops of 400 Hz.
_STEP = 0.0125  # s

_PARAMETERS = (
    Parameter(name="EK3_GYRO_P_NSE", sensor="gyro", kind="noise", unit="rad/s", least=1e-4, most=0.1),
    Parameter(name="EK3_ACC_P_NSE", sensor="accel", kind="noise", unit="m/s^2", least=0.01, most=1.0, cut=5.0),
    Parameter(name="EK3_GBIAS_P_NSE", sensor="gyro", kind="walk", unit="rad/s^2", least=1e-5, most=1e-3),
    Parameter(name="EK3_ABIAS_P_NSE", sensor="accel", kind="walk", unit="m/s^3", least=1e-5, most=0.02),
)


def write(numbers: Numbers) -> str:
    """The text of the file, NAME,VALUE; comments on lines of their own, which every loader skips."""
    step = step_of(numbers, _STEP)
    lines = [
        f"# EK3 noise for a filter step of {seconds(1000 * step)} ms. It is 12.5 ms where SCHED_LOOP_RATE is 400, 13.33 of"
        " 300, 10 of 200 or 100, 20 of 50: --step.",
        "# Not densities: each is a density over sqrt(dt), of which the filter takes (dt*p)^2 and (dt^2*p)^2.",
        *left_out(numbers),
    ]
    for name, value, words in rows(numbers, _PARAMETERS, step):
        lines += [f"# {words}", f"{name},{single(value, name)}"]
    return "\n".join(lines) + "\n"


TARGET = Target(
    name="ardupilot",
    summary="ArduPilot EK3 parameters: N/sqrt(dt) and K/sqrt(dt), dt the step of its filter (12.5 ms, --step)",
    ending=".parm",
    write=write,
    has_step=True,
)
