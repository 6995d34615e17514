"""Kalibr: ``imu.yaml``, flat, of its camera-IMU calibration."""

from __future__ import annotations

from sigmatau.export.numbers import Numbers
from sigmatau.export.target import Target
from sigmatau.export.text import comment, digits, quoted

__all__ = ["TARGET"]


def write(numbers: Numbers) -> str:
    """The text of the file. Kalibr divides by sqrt(1/update_rate) itself, and rejects what is not above 0."""
    rows = [
        ("accelerometer_noise_density", numbers.noise("accel"), "m/s^2/sqrt(Hz)"),
        ("accelerometer_random_walk", numbers.walk("accel"), "m/s^3/sqrt(Hz)"),
        ("gyroscope_noise_density", numbers.noise("gyro"), "rad/s/sqrt(Hz)"),
        ("gyroscope_random_walk", numbers.walk("gyro"), "rad/s^2/sqrt(Hz)"),
    ]
    lines = [
        "# Continuous-time densities: Kalibr makes them discrete with update_rate itself. Not divided by sqrt(rate) here.",
        *(f"{key}: {digits(number.value)}  # {unit}; {comment(number.words)}" for key, number, unit in rows),
        f"rostopic: {quoted(numbers.name('topic', '/imu0'))}",
        f"update_rate: {digits(numbers.rate())}  # Hz",
    ]
    return "\n".join(lines) + "\n"


TARGET = Target(
    name="kalibr",
    summary="Kalibr imu.yaml: N and K, continuous, one number for three axes",
    ending=".yaml",
    write=write,
    needs_rate=True,
    needs_walk=True,
    names={"topic": "/imu0"},
)
