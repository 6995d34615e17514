"""Logs of sensors other than inertial ones, simulated from their noise, for the pages of the documentation."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from known import seed_of
from sigmatau import ChannelModel, NoiseModel, simulate


def write_log(
    path: Path, channels: Mapping[str, tuple[Mapping[str, float], float]], *, unit: str, seconds: float, rate: float
) -> None:
    """Write a CSV with times and channels, each with its noise and its mean, in one unit."""
    models = {
        name: ChannelModel(terms=dict(noise), quantity="signal", unit=unit) for name, (noise, _) in channels.items()
    }
    record = simulate(NoiseModel(channels=models), duration=seconds, rate=rate, rng=seed_of(path.name))
    columns = [record.stream_of(name).column(name) + mean for name, (_, mean) in channels.items()]
    times = np.arange(len(columns[0])) / rate
    head = ",".join(["time [s]", *(f"{name} [{unit}]" for name in channels)])
    np.savetxt(path, np.column_stack([times, *columns]), delimiter=",", header=head, comments="", fmt="%.13g")
