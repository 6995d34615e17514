"""Kalibr: ``imu.yaml``.

Kalibr divides by sqrt(1/update_rate) itself, and rejects numbers that are not above 0.
"""

from sigmatau.exporting.template import template

TARGET = template(
    "kalibr",
    program="Kalibr",
    summary="Kalibr imu.yaml: N and K, continuous, one number for three axes",
    text="""\
# Continuous-time densities, not divided by sqrt(rate): Kalibr makes them discrete with update_rate itself.
# random_walk is the rate random walk K, not the bias instability B, which has another unit.
{omitted}
accelerometer_noise_density: {accel N}
accelerometer_random_walk: {accel K}
gyroscope_noise_density: {gyro N}
gyroscope_random_walk: {gyro K}
rostopic: {topic}
update_rate: {rate}  # Hz
""",
    names={"topic": "/imu0"},
)
