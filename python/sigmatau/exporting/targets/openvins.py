"""OpenVINS: ``kalibr_imu_chain.yaml``.

The YAML reader of OpenCV, which OpenVINS uses, needs the first line.
"""

from sigmatau.exporting.template import template
from sigmatau.hints import Hint

TARGET = template(
    "openvins",
    program="OpenVINS",
    summary="OpenVINS kalibr_imu_chain.yaml: N and K, continuous, one number for three axes; its samples are inflated",
    text="""\
%YAML:1.0

# Continuous-time densities: OpenVINS divides N^2 by dt and multiplies K^2 by dt itself.
# The sample files of OpenVINS are inflated, white noise x 2 and random walk x 10: """
    f"{Hint('noise_factor', value=2)} {Hint('walk_factor', value=10)}.\n"
    """\
imu0:
  # From your camera-IMU calibration; an Allan variance does not show it:
  T_i_b:
    - [1.0, 0.0, 0.0, 0.0]
    - [0.0, 1.0, 0.0, 0.0]
    - [0.0, 0.0, 1.0, 0.0]
    - [0.0, 0.0, 0.0, 1.0]
  {omitted}
  accelerometer_noise_density: {accel N}
  accelerometer_random_walk: {accel K}
  gyroscope_noise_density: {gyro N}
  gyroscope_random_walk: {gyro K}
  rostopic: {topic}
  time_offset: 0.0
  update_rate: {rate}  # Hz
  # Intrinsics of an ideal sensor; model is kalibr (the same as calibrated) or rpng:
  model: "kalibr"
"""
    + "".join(
        f"  {key}:\n    - [{d}, 0.0, 0.0]\n    - [0.0, {d}, 0.0]\n    - [0.0, 0.0, {d}]\n"
        for key, d in (("Tw", 1.0), ("R_IMUtoGYRO", 1.0), ("Ta", 1.0), ("R_IMUtoACC", 1.0), ("Tg", 0.0))
    ),
    names={"topic": "/imu0"},
)
