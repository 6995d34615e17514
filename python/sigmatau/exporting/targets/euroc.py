"""EuRoC (ASL) data sets: ``imu0/sensor.yaml``."""

from __future__ import annotations

from sigmatau.exporting.target import Target
from sigmatau.exporting.targets.kalibr import densities
from sigmatau.exporting.text import digits
from sigmatau.exporting.values import Numbers

__all__ = ["TARGET"]


def write(numbers: Numbers) -> str:
    """The text of the file."""
    identity = ", ".join(digits(float(i == j)) for i in range(4) for j in range(4))
    lines = [
        "sensor_type: imu",
        "comment: noise parameters written by sigmatau",
        "# Pose of the sensor in the body frame; yours, no Allan variance shows it.",
        "T_BS:",
        "  cols: 4",
        "  rows: 4",
        f"  data: [{identity}]",
        f"rate_hz: {digits(numbers.rate())}",
        "# Continuous-time densities, not divided by sqrt(rate).",
        *densities(numbers),
    ]
    return "\n".join(lines) + "\n"


TARGET = Target(
    name="euroc",
    summary="EuRoC sensor.yaml (ASL data sets): N and K, continuous, one number for three axes",
    ending=".yaml",
    write=write,
    needs_rate=True,
)
