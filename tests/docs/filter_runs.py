"""Tables of innovations for pages: a filter of an attitude and a bias, on a simulated gyro."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from studies.tune import Setting, innovations

from known import seed_of


def write_innovations(
    place: Path, columns: Mapping[str, tuple[str, str]], *, walk: float, duration: float = 1800.0
) -> None:
    """Innovations by channel, of a filter with N = 1e-4 and K = 3.3e-6 on a gyro with that N and another K."""
    assumed = Setting(noise=1e-4, walk=3.3e-6, deviation=1e-4, interval=0.2, duration=duration)
    true = Setting(noise=1e-4, walk=walk, deviation=1e-4, interval=0.2, duration=duration)
    table, header = [], ["t [s]"]
    for channel, (innovation, variance) in columns.items():
        rng = np.random.default_rng(seed_of(f"{place.name} {channel}"))
        values, stated = innovations(true, assumed, 1, rng)
        table += [values[:, 0], stated]
        header += [f"{innovation} [rad]", f"{variance} [rad^2]"]
    time = 0.2 * np.arange(len(table[0]))
    np.savetxt(place, np.column_stack([time, *table]), delimiter=",", header=",".join(header), comments="", fmt="%.9g")
