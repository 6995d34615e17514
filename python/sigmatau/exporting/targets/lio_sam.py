"""LIO-SAM: the lines of ``params.yaml`` that describe the IMU."""

from __future__ import annotations

from sigmatau.exporting.target import Target
from sigmatau.exporting.text import digits, remark, setting, topic
from sigmatau.exporting.values import Numbers
from sigmatau.units import STANDARD_GRAVITY

__all__ = ["TARGET"]


def write(numbers: Numbers) -> str:
    """Lines for the parameters. The code squares the noise for GTSAM, and multiplies the biases' by √Δt of key frames."""
    rows = [
        ("imuAccNoise", numbers.noise("accel"), "N, m/s^2/sqrt(Hz)"),
        ("imuGyrNoise", numbers.noise("gyro"), "N, rad/s/sqrt(Hz)"),
        ("imuAccBiasN", numbers.walk("accel"), "K, m/s^3/sqrt(Hz)"),
        ("imuGyrBiasN", numbers.walk("gyro"), "K, rad/s^2/sqrt(Hz)"),
    ]
    gravity = numbers.number("gravity", digits(STANDARD_GRAVITY))
    lines = [
        "# Replace these lines of LIO-SAM's params.yaml; for ROS 2 under /**: ros__parameters: in place of lio_sam:.",
        "# Continuous-time densities: the code squares the noise, GTSAM divides it by dt; the biases' are multiplied by",
        "# sqrt(time between key frames). Nothing is multiplied by sqrt(rate), neither here nor there.",
        *map(remark, numbers.left_out()),
        "lio_sam:",
        f"  imuTopic: {topic(numbers.name('topic', 'imu_raw'))}",
        *(f"  {setting(key, number.value, f'{unit}; {number.words}')}" for key, number, unit in rows),
        f"  imuGravity: {digits(gravity)}  # m/s^2; where you are, not the sensor's",
    ]
    return "\n".join(lines) + "\n"


TARGET = Target(
    name="lio-sam",
    summary="LIO-SAM params.yaml: N and K, continuous (it squares them itself), one number for three axes",
    ending=".yaml",
    write=write,
    names={"topic": "imu_raw", "gravity": digits(STANDARD_GRAVITY)},
)
