"""FAST-LIO and FAST-LIO2: the lines of their configuration that describe the IMU."""

from __future__ import annotations

from sigmatau.exporting.target import Target
from sigmatau.exporting.text import digits, remark, setting, topic
from sigmatau.exporting.values import Numbers

__all__ = ["TARGET"]


def write(numbers: Numbers) -> str:
    """Lines for the configuration, variances: a step adds (F_w·dt)·Q·(F_w·dt)ᵀ, which is N²·dt for Q = N²·f."""
    rate = numbers.rate()
    rows = [
        ("acc_cov", numbers.noise("accel"), "(m/s^2)^2 per sample = N^2*rate"),
        ("gyr_cov", numbers.noise("gyro"), "(rad/s)^2 per sample = N^2*rate"),
        ("b_acc_cov", numbers.walk("accel"), "(m/s^3)^2 per sample = K^2*rate"),
        ("b_gyr_cov", numbers.walk("gyro"), "(rad/s^2)^2 per sample = K^2*rate"),
    ]
    lines = [
        "# Replace these lines of your FAST-LIO configuration.",
        f"# Variances, discrete, for {digits(rate)} Hz: the filter adds (dt*F_w) Q (dt*F_w)^T at each step and has no rate.",
        "# The 0.1 and 0.0001 of its own files are round numbers far above a sensor's: see --noise-factor, --walk-factor.",
        *map(remark, numbers.left_out()),
        "common:",
        f"  imu_topic: {topic(numbers.name('topic', '/livox/imu'))}",
        "mapping:",
        *(f"  {setting(key, number.value**2 * rate, f'{unit}; {number.words}')}" for key, number, unit in rows),
    ]
    return "\n".join(lines) + "\n"


TARGET = Target(
    name="fast-lio",
    summary="FAST-LIO, FAST-LIO2: variances N^2*rate and K^2*rate, discrete, one number for three axes",
    ending=".yaml",
    write=write,
    needs_rate=True,
    names={"topic": "/livox/imu"},
)
