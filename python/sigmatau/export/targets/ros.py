"""ROS: the covariances of ``sensor_msgs/Imu``, row by row, as YAML.

They are those of one sample. White noise of density N² that nothing has filtered has N²·rate; behind a bandwidth a sample
has less, and samples are correlated, which the message cannot say. All zeros means unknown, −1 that there is no such data.
"""

from __future__ import annotations

import functools

import numpy as np

from sigmatau.errors import DataError
from sigmatau.export.axes import by_axis, refuse
from sigmatau.export.numbers import Number, Numbers
from sigmatau.export.target import Target
from sigmatau.export.text import said, vector
from sigmatau.model import ChannelModel
from sigmatau.model.state_space import state_space
from sigmatau.results import Finding

__all__ = ["TARGET"]

_FIELDS = (
    ("gyro", "angular_velocity_covariance", "(rad/s)^2"),
    ("accel", "linear_acceleration_covariance", "(m/s^2)^2"),
)
_ABSENT = [-1.0, *[0.0] * 8]


def write(numbers: Numbers) -> str:
    """The text of the file, with the keys of the message."""
    refuse(numbers, "ros", "the message has the noise of a sample alone, no bias", "walk", "walk_factor")
    if not any(numbers.has(sensor) for sensor, _, _ in _FIELDS):
        raise DataError("the model has neither gyros nor accelerometers, which sensor_msgs/Imu is of")
    lines = [
        "# sensor_msgs/Imu: covariance of one sample, row by row. [0] = -1: there is no such data.",
        f"orientation_covariance: {vector(_ABSENT)}  # of an attitude that was estimated, which no noise model has",
    ]
    for sensor, field, unit in _FIELDS:
        if not numbers.has(sensor):
            lines.append(f"{field}: {vector(_ABSENT)}  # the model has none")
            continue
        found = by_axis(numbers, sensor, functools.partial(_variance, sensor=sensor))
        matrix = np.diag([variance.value for variance in found])
        together = ""
        if numbers.choices.axes == "each":
            names = [f"{sensor}_{axis}" for axis in "xyz"]
            for term, of in (("random_walk", _white), ("quantization", _quantization)):
                deviation = np.sqrt([of(numbers, name) for name in names])
                matrix += (numbers.model.of(names).correlation_matrix(term) - np.eye(3)) * np.outer(
                    deviation, deviation
                )
        elif _shared(numbers, sensor):
            together = "; axes that share noise are taken for independent, --axes each writes what they share"
        lines.append(f"{field}: {vector(matrix.ravel())}  # {unit}; {said(v.words for v in found)}{together}")
    return "\n".join(lines) + "\n"


def _variance(numbers: Numbers, *, sensor: str) -> Number:
    """Variance of a sample by the user's choice of axis, and what it is."""
    channels = numbers.channels(sensor)
    rate = numbers.rate()
    by_channel = {}
    for name in channels:
        numbers.noise_of(name)  # which says what is missing
        by_channel[name] = _white(numbers, name) + _quantization(numbers, name)
    if numbers.choices.axes == "mean":
        value = sum(by_channel.values()) / len(by_channel)
        used = list(channels)
        models, source = (
            list(channels.values()),
            f"mean of {', '.join(channels)}{next(filter(None, map(numbers.doubt, channels)), '')}",
        )
    else:
        worst = max(by_channel, key=lambda name: by_channel[name])
        value, models, used = by_channel[worst], [channels[worst]], [worst]
        source = ("" if len(channels) == 1 else f"worst of {len(channels)} axes, ") + numbers.noise_of(worst).words
    parts = "N^2*rate" if all(model.bandwidth is None for model in models) else "variance behind the bandwidth"
    if any("quantization" in model for model in models):
        parts += " + 2*(Q*rate)^2"
    limited = [model for model in models if model.bandwidth is not None]
    if limited:  # of all axes: what is worst behind a filter need not be worst without
        corner = ", ".join(dict.fromkeys(f"{m.bandwidth.corner:g} Hz" for m in limited if m.bandwidth is not None))
        plain = numbers.noise(sensor).value ** 2 * rate
        parts += (
            f" of {corner}: samples are correlated, and a filter that takes them for independent needs N^2*rate ="
            f" {plain:.4g} instead"
        )
    else:
        parts += _filtered(numbers, used, value)
    return Number(value=value, words=f"{parts}; {source}")


def _filtered(numbers: Numbers, channels: list[str], value: float) -> str:
    """What the analysis says of a filter that the model has not: words, and a finding.

    Behind a low-pass neighbours are alike, so that half the mean square of their differences, which is the Allan variance
    at one sample, is less than the variance of a sample, and N²·rate is more.
    """
    found = {name: numbers.source.corners[name] for name in channels if name in numbers.source.corners}
    if not found:
        return ""
    axes = ", ".join(f"{name} {corner:.3g} Hz" for name, corner in found.items())
    known = [numbers.choices.noise_factor**2 * numbers.source.first[n] for n in found if n in numbers.source.first]
    range_ = (
        f": it is between {max(known):.3g}, half the mean square of differences of neighbours, and this"
        if known
        else ""
    )
    numbers.find(
        Finding(
            code="low_pass_filter",
            severity="warning",
            message=f"a low-pass filter was found ({axes}), and {value:.3g} is the variance of samples without one",
            effect=f"the variance of a sample is smaller{range_}",
            remedy="right for a filter that takes samples for independent; for the variance itself give the channel its"
            " bandwidth in a model file",
        )
    )
    return f", as without the low-pass filter that was found ({axes}); the variance of a sample is smaller{range_}"


def _shared(numbers: Numbers, sensor: str) -> bool:
    """Whether axes of a sensor share noise that is in a sample."""
    pairs = (pair for term in ("random_walk", "quantization") for pair in numbers.model.correlation.get(term, {}))
    return any(set(pair) <= set(numbers.channels(sensor)) for pair in pairs)


def _quantization(numbers: Numbers, name: str) -> float:
    """Variance of the quantization in one sample, the difference of two errors of the angle over the interval."""
    q = numbers.choices.noise_factor * numbers.model.channels[name].get("quantization", 0.0)
    return 2 * (q * numbers.rate()) ** 2


def _white(numbers: Numbers, name: str) -> float:
    """Variance of the random walk in one sample."""
    model = numbers.model.channels[name]
    noise = numbers.noise_of(name).value  # observed or chosen, with its factor
    alone = ChannelModel(
        terms={"random_walk": noise}, bandwidth=model.bandwidth, quantity=model.quantity, unit=model.unit
    )
    system = state_space(alone, dt=1 / numbers.rate())
    return float((system.H @ system.P0 @ system.H.T + system.R)[0, 0])


TARGET = Target(
    name="ros",
    summary="ROS sensor_msgs/Imu covariances of one sample, N^2*rate where nothing filters it, by axis",
    ending=".yaml",
    write=write,
    needs_rate=True,
    per_axis=True,
)
