"""Basalt: the noise of its calibration file, JSON with an array of x, y and z for each value.

Continuous-time densities: Basalt multiplies noise by √imu_update_rate itself, and divides the difference of two biases by
σ·√dt. JSON has no comments, so the key ``about``, which Basalt ignores, describes the numbers.
"""

from __future__ import annotations

import json
from functools import partial

from sigmatau._version import __version__
from sigmatau.exporting.axes import by_axis
from sigmatau.exporting.statements import pair_remarks
from sigmatau.exporting.target import Target
from sigmatau.exporting.text import comment, joined, vector
from sigmatau.exporting.turn_on import TURN_ON_NAMES, turn_on
from sigmatau.exporting.values import Number, Numbers

_ROWS = (
    ("accel_noise_std", "accel", "N", "m/s^2/sqrt(Hz)"),
    ("gyro_noise_std", "gyro", "N", "rad/s/sqrt(Hz)"),
    ("accel_bias_std", "accel", "K", "m/s^3/sqrt(Hz)"),
    ("gyro_bias_std", "gyro", "K", "rad/s^2/sqrt(Hz)"),
)
# Weights of the priors of the first biases. Basalt exchanges them: sqrt_keypoint_vio.cpp applies vio_init_ba_weight to
# states 9 to 11, the bias of the gyros.
_PRIORS = (("gyro", "config.vio_init_ba_weight"), ("accel", "config.vio_init_bg_weight"))


def write(numbers: Numbers) -> str:
    """The text of the file."""
    about = [
        f"Noise parameters for basalt, written by sigmatau {__version__}",
        *numbers.source.head,
        "Merge value0 into your calibration: jq -s '.[0] * .[1]' calibration.json this.json",
        "Continuous-time densities: Basalt multiplies noise by sqrt(imu_update_rate) itself, walks by sqrt(dt)",
        *pair_remarks(numbers, has_turn_on=True),
    ]
    lines = [f'  "imu_update_rate": {numbers.rate_text()}']
    for key, sensor, letter, unit in _ROWS:
        axes = by_axis(numbers, sensor, partial(_density, sensor=sensor, letter=letter))
        lines.append(f'  "{key}": {vector(axis.value for axis in axes)}')
        about.append(f"{key}: {letter}, {unit}, x, y, z; {joined(axis.words for axis in axes)}")
    for sensor, key in _PRIORS:
        start = turn_on(numbers, sensor)
        if start is not None:
            about.append(
                f"{key} of your VIO configuration: {start.value**-2:.4g} = 1/sigma^2 of the {sensor}; {start.words}"
            )
    described = ",\n".join(f"  {json.dumps(comment(line))}" for line in about)
    return '{\n "value0": {\n' + ",\n".join(lines) + '\n },\n "about": [\n' + described + "\n ]\n}\n"


def _density(numbers: Numbers, sensor: str, letter: str) -> Number:
    return numbers.noise(sensor) if letter == "N" else numbers.walk(sensor)


TARGET = Target(
    name="basalt",
    program="Basalt",
    columns=("N", "K"),
    summary="Basalt calibration.json: N and K, continuous, by axis",
    ending=".json",
    write=write,
    needs_rate=True,
    has_rate_field=True,
    has_walk=True,
    needs_axes=True,
    per_axis=True,
    names=dict(TURN_ON_NAMES),
)
