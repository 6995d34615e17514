"""Isaac ROS Visual SLAM (cuVSLAM): parameters of its node.

A sample adds N^2*calibration_frequency*dt^2 and K^2/calibration_frequency.
"""

from sigmatau.exporting.template import template

TARGET = template(
    "cuvslam",
    program="Isaac ROS Visual SLAM (cuVSLAM)",
    summary="Isaac ROS Visual SLAM (cuVSLAM): N and K, continuous, one number for three axes",
    aliases=("isaac-ros", "isaac-ros-visual-slam"),
    text="""\
# Parameters of the node visual_slam, used with tracking_mode: 1 (VIO).
# Continuous-time densities: cuVSLAM multiplies noise by sqrt(calibration_frequency) and divides walks by it, once. It adds
# the walk with each sample: calibration_frequency must be the rate of the IMU messages.
{omitted}
/**:
  ros__parameters:
    gyro_noise_density: {gyro N}
    gyro_random_walk: {gyro K}
    accel_noise_density: {accel N}
    accel_random_walk: {accel K}
    calibration_frequency: {rate}  # Hz
""",
)
