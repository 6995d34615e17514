"""EuRoC: ``sensor.yaml`` of the data sets in the format of ASL."""

from sigmatau.exporting.template import template

TARGET = template(
    "euroc",
    program="EuRoC (ASL)",
    summary="EuRoC sensor.yaml (ASL data sets): N and K, continuous, one number for three axes",
    aliases=("asl",),
    text="""\
sensor_type: imu
comment: noise parameters written by sigmatau
# Pose of the sensor in the body frame, from your calibration; an Allan variance does not show it.
T_BS:
  cols: 4
  rows: 4
  data: [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]
rate_hz: {rate}
# Continuous-time densities, not divided by sqrt(rate).
{omitted}
accelerometer_noise_density: {accel N}
accelerometer_random_walk: {accel K}
gyroscope_noise_density: {gyro N}
gyroscope_random_walk: {gyro K}
""",
)
