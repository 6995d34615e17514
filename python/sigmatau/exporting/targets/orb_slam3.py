"""ORB-SLAM3: the lines of its settings that describe the IMU."""

from __future__ import annotations

from sigmatau.exporting.target import Target
from sigmatau.exporting.text import digits, remark, setting
from sigmatau.exporting.values import Numbers

__all__ = ["TARGET"]


def write(numbers: Numbers) -> str:
    """Lines for the settings. The code multiplies noise by √f and divides walks by √f, a walk's step being K·√dt."""
    rows = [
        ("IMU.NoiseGyro", numbers.noise("gyro"), "N, rad/s/sqrt(Hz)"),
        ("IMU.NoiseAcc", numbers.noise("accel"), "N, m/s^2/sqrt(Hz)"),
        ("IMU.GyroWalk", numbers.walk("gyro"), "K, rad/s^2/sqrt(Hz)"),
        ("IMU.AccWalk", numbers.walk("accel"), "K, m/s^3/sqrt(Hz)"),
    ]
    lines = [
        "# Replace these lines of your ORB-SLAM3 settings; IMU.T_b_c1 stays yours.",
        "# Continuous-time densities: Tracking.cc multiplies noise by sqrt(IMU.Frequency) and divides walks by it, once.",
        *map(remark, numbers.left_out()),
        *(setting(key, number.value, f"{unit}; {number.words}") for key, number, unit in rows),
        f"IMU.Frequency: {digits(numbers.rate())}  # Hz; with a point, ORB-SLAM3 stops at an integer",
    ]
    return "\n".join(lines) + "\n"


TARGET = Target(
    name="orb-slam3",
    summary="ORB-SLAM3 settings: N and K, continuous, one number for three axes",
    ending=".yaml",
    write=write,
    needs_rate=True,
)
