"""OpenVINS: ``kalibr_imu_chain.yaml``, with the intrinsics of an ideal sensor to be replaced."""

from __future__ import annotations

from sigmatau.exporting.target import Target
from sigmatau.exporting.targets.kalibr import densities
from sigmatau.exporting.text import digits, topic
from sigmatau.exporting.values import Numbers

__all__ = ["TARGET"]


def write(numbers: Numbers) -> str:
    """The text of the file, for OpenCV's reader, which wants its own first line."""
    lines = [
        "%YAML:1.0",
        "",
        "# Continuous-time densities: OpenVINS divides N^2 by dt and multiplies K^2 by dt itself.",
        "# Its own sample files are inflated, white noise x 2 and random walk x 10: --noise-factor 2 --walk-factor 10.",
        "imu0:",
        "  # Yours, from the camera-IMU calibration; no Allan variance shows it:",
        "  T_i_b:",
        *_matrix([[float(i == j) for j in range(4)] for i in range(4)]),
        *(f"  {line}" for line in densities(numbers)),
        f"  rostopic: {topic(numbers.name('topic', '/imu0'))}",
        "  time_offset: 0.0",
        f"  update_rate: {digits(numbers.rate())}  # Hz",
        "  # Intrinsics of an ideal sensor; model is kalibr (the same as calibrated) or rpng:",
        '  model: "kalibr"',
    ]
    for key in ("Tw", "R_IMUtoGYRO", "Ta", "R_IMUtoACC"):
        lines += [f"  {key}:", *_matrix([[float(i == j) for j in range(3)] for i in range(3)])]
    lines += ["  Tg:", *_matrix([[0.0] * 3] * 3)]
    return "\n".join(lines) + "\n"


def _matrix(rows: list[list[float]]) -> list[str]:
    return [f"    - [{', '.join(map(digits, row))}]" for row in rows]


TARGET = Target(
    name="openvins",
    summary="OpenVINS kalibr_imu_chain.yaml: N and K, continuous, one number for three axes; its samples are inflated",
    ending=".yaml",
    write=write,
    needs_rate=True,
    names={"topic": "/imu0"},
)
