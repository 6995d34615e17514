"""VINS-Mono and VINS-Fusion: the lines of their configuration that describe the IMU."""

from __future__ import annotations

import math

from sigmatau.exporting.target import Target
from sigmatau.exporting.text import digits, remark, setting, topic
from sigmatau.exporting.values import Numbers
from sigmatau.units import STANDARD_GRAVITY

__all__ = ["TARGET"]


def write(numbers: Numbers) -> str:
    """Lines for the configuration, deviations per sample.

    The code propagates by the mid-point rule and takes the two halves of a step, dt/2 each, for independent: a step adds
    2·(dt/2)²·n² = dt²·n²/2, which is N²·dt for n = N·√(2f). Biases add (dt·w)², which is K²·dt for w = K·√f.
    """
    rate = numbers.rate()
    noise, walk = math.sqrt(2 * rate), math.sqrt(rate)
    rows = [
        ("acc_n", noise, numbers.noise("accel"), "m/s^2 per sample = N*sqrt(2*rate)"),
        ("gyr_n", noise, numbers.noise("gyro"), "rad/s per sample = N*sqrt(2*rate)"),
        ("acc_w", walk, numbers.walk("accel"), "m/s^3 per sample = K*sqrt(rate)"),
        ("gyr_w", walk, numbers.walk("gyro"), "rad/s^2 per sample = K*sqrt(rate)"),
    ]
    lines = [
        "# Replace these lines of your VINS-Mono or VINS-Fusion configuration.",
        f"# Discrete, for {digits(rate)} Hz: the code has no rate, and multiplies by the step alone.",
        "# The noise is N*sqrt(2*rate): integration_base.h takes the two halves of a step for independent, so that the",
        "# common N*sqrt(rate) propagates to half the covariance. For that one divide acc_n and gyr_n by sqrt(2).",
        *map(remark, numbers.left_out()),
        f"imu_topic: {topic(numbers.name('topic', '/imu0'))}",
        *(setting(key, factor * number.value, f"{unit}; {number.words}") for key, factor, number, unit in rows),
        f"g_norm: {digits(numbers.number('gravity', digits(STANDARD_GRAVITY)))}  # m/s^2; where you are, not the sensor's",
    ]
    return "\n".join(lines) + "\n"


TARGET = Target(
    name="vins",
    summary="VINS-Mono, VINS-Fusion: N*sqrt(2*rate) and K*sqrt(rate), discrete, one number for three axes",
    ending=".yaml",
    write=write,
    needs_rate=True,
    names={"topic": "/imu0", "gravity": digits(STANDARD_GRAVITY)},
)
