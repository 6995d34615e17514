"""Models, and readers of the files for simulators, for their tests."""

import ast
import math
import re

import numpy as np
import pytest

from sigmatau.exporting.gauss_markov import PEAK_TIME
from sigmatau.model.channel import ChannelModel
from sigmatau.model.noise_model import NoiseModel

EXACT = 1e-12
RATE = 200.0
D2R = math.pi / 180
AXES = "xyz"
SIZES = {"x": 1.0, "y": 0.7, "z": 1.3}
N, B, K = {"gyro": 8.7e-5, "accel": 1.3e-3}, {"gyro": 4e-5, "accel": 5e-4}, {"gyro": 1.6e-6, "accel": 2.4e-5}
TAU = {"gyro": math.sqrt(3) * 8.7e-5 / 1.6e-6 / PEAK_TIME, "accel": math.sqrt(3) * 1.3e-3 / 2.4e-5 / PEAK_TIME}


def model():
    """Three axes of one shape, so that the bottom of each curve is at the same time."""
    return NoiseModel(
        channels={
            f"{sensor}_{axis}": {
                "random_walk": size * N[sensor],
                "bias_instability": size * B[sensor],
                "rate_random_walk": size * K[sensor],
            }
            for sensor in ("gyro", "accel")
            for axis, size in SIZES.items()
        }
    )


def one(name="gyro_x", **more):
    """Sensors of one axis, with further properties of the first."""
    terms = {"random_walk": 1e-4, "bias_instability": 1e-5, "rate_random_walk": 1e-6}
    gyro = ChannelModel(terms=terms, **more)
    accel = ChannelModel(terms=terms, quantity="acceleration", unit="m/s^2")
    return NoiseModel(channels={name: gyro, "accel_x": accel})


def expected(coefficient, sensor, axes):
    sizes = list(SIZES.values())
    if axes == "each":
        return [size * coefficient[sensor] for size in sizes]
    size = max(sizes) if axes == "worst" else math.sqrt(sum(s**2 for s in sizes) / 3)
    return [size * coefficient[sensor]] * 3


every_axis_policy = pytest.mark.parametrize("axes", ["worst", "mean", "each"])


def block_yaml(text):
    """Parse the written YAML: an optional key, and below it keys with flow sequences and comments."""
    values = {}
    for line in text.splitlines():
        content = line.split(" #")[0].rstrip() if not line.startswith("#") else ""
        if not content:
            continue
        key, value = re.fullmatch(r" *([a-z_]+):(.*)", content).groups()
        assert key not in values
        values[key] = ast.literal_eval(value.strip()) if value.strip() else None
    return values


def adev(sigma, time, tau):
    """Allan deviation of a Gauss-Markov process of any scale, IEEE Std 952; that of a walk where three terms would
    cancel.
    """
    x = tau / time
    if x < 1e-4:
        return np.asarray(sigma) * math.sqrt(2 * x / 3 - x**2 / 2)
    return np.asarray(sigma) * math.sqrt(2 * (1 - (3 - 4 * math.exp(-x) + math.exp(-2 * x)) / (2 * x)) / x)
