"""Kalibr: ``imu.yaml``, flat, of its camera-IMU calibration."""

from __future__ import annotations

from sigmatau.exporting.target import Target
from sigmatau.exporting.text import digits, remark, setting, topic
from sigmatau.exporting.values import Numbers

__all__ = ["TARGET", "densities"]


def densities(numbers: Numbers) -> list[str]:
    """What Kalibr, OpenVINS and EuRoC share: four lines of continuous densities, N and K as they are."""
    rows = [
        ("accelerometer_noise_density", numbers.noise("accel"), "N, m/s^2/sqrt(Hz)"),
        ("accelerometer_random_walk", numbers.walk("accel"), "K, m/s^3/sqrt(Hz)"),
        ("gyroscope_noise_density", numbers.noise("gyro"), "N, rad/s/sqrt(Hz)"),
        ("gyroscope_random_walk", numbers.walk("gyro"), "K, rad/s^2/sqrt(Hz)"),
    ]
    lines = [setting(key, number.value, f"{unit}; {number.words}") for key, number, unit in rows]
    return [*map(remark, numbers.left_out()), *lines]


def write(numbers: Numbers) -> str:
    """The text of the file. Kalibr divides by sqrt(1/update_rate) itself, and rejects what is not above 0."""
    lines = [
        "# Continuous-time densities: Kalibr makes them discrete with update_rate itself. Not divided by sqrt(rate) here.",
        "# random_walk is the rate random walk K, not the bias instability B, which has another unit.",
        *densities(numbers),
        f"rostopic: {topic(numbers.name('topic', '/imu0'))}",
        f"update_rate: {digits(numbers.rate())}  # Hz",
    ]
    return "\n".join(lines) + "\n"


TARGET = Target(
    name="kalibr",
    summary="Kalibr imu.yaml: N and K, continuous, one number for three axes",
    ending=".yaml",
    write=write,
    needs_rate=True,
    names={"topic": "/imu0"},
)
