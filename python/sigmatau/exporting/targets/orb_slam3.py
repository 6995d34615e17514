"""ORB-SLAM3: lines of its settings.

The code multiplies noise by sqrt(f) and divides walks by sqrt(f): a step of a walk is K*sqrt(dt).
"""

from sigmatau.exporting.template import template

TARGET = template(
    "orb-slam3",
    program="ORB-SLAM3",
    summary="ORB-SLAM3 settings: N and K, continuous, one number for three axes",
    text="""\
# Replace these lines of your ORB-SLAM3 settings; keep your IMU.T_b_c1.
# Continuous-time densities: Tracking.cc multiplies noise by sqrt(IMU.Frequency) and divides walks by it, once.
{omitted}
IMU.NoiseGyro: {gyro N}
IMU.NoiseAcc: {accel N}
IMU.GyroWalk: {gyro K}
IMU.AccWalk: {accel K}
IMU.Frequency: {rate}  # Hz; with a decimal point, ORB-SLAM3 rejects an integer
""",
)
