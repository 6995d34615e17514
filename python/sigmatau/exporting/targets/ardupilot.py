"""ArduPilot: process noise of EKF3, as a parameter file that ground stations load.

The states of EKF3 are angle and velocity increments: a step adds (dt·p)² to the variance of the angle, and (dt²·p)² to
the variance of the bias times dt. These are N²·dt for p = N/√dt, and K²·dt·dt² for p = K/√dt. The numbers hold for one
step dt.
"""

from __future__ import annotations

from sigmatau.exporting.autopilot import STEP, AutopilotParameter, choose_step, parameter_rows
from sigmatau.exporting.statements import pair_remarks
from sigmatau.exporting.target import Target
from sigmatau.exporting.text import remark, single
from sigmatau.exporting.values import Numbers
from sigmatau.results import seconds

# Samples are summed until the sum covers 12 ms minus half a loop (EKF_TARGET_DT, readIMUData): five loops of 400 Hz.
_STEP = 0.0125  # [s]
_PARAMETERS = (
    AutopilotParameter(name="EK3_GYRO_P_NSE", sensor="gyro", kind="noise", unit="rad/s", low=1e-4, high=0.1),
    AutopilotParameter(name="EK3_ACC_P_NSE", sensor="accel", kind="noise", unit="m/s^2", low=0.01, high=1.0, cut=5.0),
    AutopilotParameter(name="EK3_GBIAS_P_NSE", sensor="gyro", kind="walk", unit="rad/s^2", low=1e-5, high=1e-3),
    AutopilotParameter(name="EK3_ABIAS_P_NSE", sensor="accel", kind="walk", unit="m/s^3", low=1e-5, high=0.02),
)


def write(numbers: Numbers) -> str:
    """Lines NAME,VALUE. Comments have separate lines, which every loader skips."""
    step = choose_step(numbers, _STEP)
    lines = [
        f"# EK3 noise for a filter step of {seconds(1000 * step)} ms. Steps by SCHED_LOOP_RATE: 12.5 ms at 400 Hz, 13.33"
        f" at 300, 10 at 200 or 100, 20 at 50; set it with {STEP}.",
        "# Not densities: each is p = density/sqrt(dt), and the filter uses (dt*p)^2 and (dt^2*p)^2.",
        *map(remark, pair_remarks(numbers)),
    ]
    for name, value, words in parameter_rows(numbers, _PARAMETERS, step):
        lines += [f"# {words}", f"{name},{single(value, name)}"]
    return "\n".join(lines) + "\n"


TARGET = Target(
    name="ardupilot",
    program="ArduPilot (EKF3)",
    columns=("N/√dt, K/√dt, dt of the filter", "nothing: dt is 12.5 ms (loop of 400 Hz), or `--step`"),
    aliases=("ekf3",),
    summary=f"ArduPilot EK3 parameters: N/sqrt(dt) and K/sqrt(dt), dt the step of its filter (12.5 ms, {STEP})",
    ending=".parm",
    write=write,
    has_step=True,
    has_walk=True,
)
