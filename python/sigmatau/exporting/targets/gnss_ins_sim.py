"""gnss-ins-sim: ``imu_err``, the dictionary of its class IMU, as Python.

gnss-ins-sim converts the units itself. Its biases are first-order Gauss-Markov processes that start at 0; without a
correlation time, or with an infinite one, a bias is white noise.
"""

from __future__ import annotations

from sigmatau.exporting.gauss_markov import OWN_PROCESSES, noises_and_processes, omitted_by_process, replaced_noise
from sigmatau.exporting.target import Target
from sigmatau.exporting.text import joined, remark, vector
from sigmatau.exporting.values import Numbers
from sigmatau.units import find


def write(numbers: Numbers) -> str:
    """The text of a Python file with ``imu_err``."""
    values = noises_and_processes(numbers)
    lines = [
        "# gnss_ins_sim.sim.imu_model.IMU(accuracy=imu_err, axis=6); it converts these units itself.",
        *map(remark, (*replaced_noise(numbers), *omitted_by_process(numbers))),
        "import numpy as np",
        "",
        "imu_err = {",
    ]
    for sensor, walk, walk_unit, bias_unit in (
        ("gyro", "gyro_arw", "deg/sqrt(h)", "deg/h"),
        ("accel", "accel_vrw", "m/s/sqrt(h)", "m/s^2"),
    ):
        noise, bias = values[sensor]
        size, bias_size = find(walk_unit).factor, find(bias_unit).factor
        about = joined(p.words for p in bias)
        lines += [
            _row(f"{sensor}_b", [0.0, 0.0, 0.0], f"{bias_unit}; constant bias, which an Allan variance does not show"),
            _row(walk, [n.value / size for n in noise], f"{walk_unit}; {joined(n.words for n in noise)}"),
            _row(
                f"{sensor}_b_stability",
                [p.sigma / bias_size for p in bias],
                f"{bias_unit}, standard deviation; {about}",
            ),
            _row(
                f"{sensor}_b_corr", [p.time for p in bias], "s, correlation time; infinite would mean white noise here"
            ),
        ]
    return "\n".join([*lines, "}"]) + "\n"


def _row(key: str, values: list[float], words: str) -> str:
    return f'    "{key}": np.array({vector(values)}),  # {words}'


TARGET = Target(
    name="gnss-ins-sim",
    program="gnss-ins-sim (imu_err)",
    columns=("N; σ, Tc", "`--horizon`, if the curve has no minimum"),
    summary="gnss-ins-sim imu_err: N, each bias as a Gauss-Markov process, by axis",
    ending=".py",
    write=write,
    has_process=True,
    has_horizon=True,
    unused=(OWN_PROCESSES,),
    needs_axes=True,
    per_axis=True,
)
