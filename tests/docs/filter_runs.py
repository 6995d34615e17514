"""Tables of innovations for pages: a filter of an attitude and a bias, on a simulated gyro."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from studies.tune import innovations
from studies.tune_filters import AIDINGS, Setting, aided_innovations, moving_innovations

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


def write_turning_innovations(place: Path) -> None:
    """Innovations and rate of a filter whose sensor has a scale error of 0.2 %, with the noise that it assumes."""
    rng = np.random.default_rng(seed_of(place.name))
    true = np.array([1.0, 1.0, 1 / 3.0])  # K of the pages is a third of that of the simulated gyro
    time, values, stated, rates = moving_innovations(2e-3, 0.0, true, 1, rng, of_sensor=True, duration=600.0)
    np.savetxt(
        place, np.column_stack([time, values[0], stated, rates[0]]), delimiter=",", comments="", fmt="%.9g",
        header="t [s],nu_gyro_x [rad],S_gyro_x [rad^2],rate_gyro_x [rad/s]",
    )  # fmt: skip


def write_joint_innovations(place: Path) -> None:
    """Innovations of a filter with two sensors at their own times, with the name of the sensor in each row."""
    rng = np.random.default_rng(seed_of(place.name))
    aiding = AIDINGS["Two sensors at times of their own"]
    time, values, stated = aided_innovations(aiding, np.array([1.0, 1.0, 1.0, 1 / 3.0]), 1, rng, duration=300.0)
    rows = ["t [s],sensor,nu [rad],S [rad^2]"]
    for k, moment in enumerate(time):
        column = int(np.isnan(values[0, k, 0]))
        rows.append(
            f"{moment:.9g},{('gnss', 'camera')[column]},{values[0, k, column]:.9g},{stated[k, column, column]:.9g}"
        )
    place.write_text("\n".join(rows) + "\n")
