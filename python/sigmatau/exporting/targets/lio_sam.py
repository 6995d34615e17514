"""LIO-SAM: lines of ``params.yaml``.

The code squares the noise for GTSAM, and multiplies the noise of the biases by the root of the time between key frames.
"""

from sigmatau.exporting.template import GRAVITY, template

TARGET = template(
    "lio-sam",
    program="LIO-SAM",
    summary="LIO-SAM params.yaml: N and K, continuous (it squares them itself), one number for three axes",
    text="""\
# Replace these lines of LIO-SAM's params.yaml; for ROS 2 under /**: ros__parameters: in place of lio_sam:.
# Continuous-time densities: the code squares the noise, GTSAM divides it by dt; LIO-SAM multiplies that of the biases
# by sqrt(time between key frames). Nothing is multiplied by sqrt(rate), here or in LIO-SAM.
{omitted}
lio_sam:
  imuTopic: {topic}
  imuAccNoise: {accel N}
  imuGyrNoise: {gyro N}
  imuAccBiasN: {accel K}
  imuGyrBiasN: {gyro K}
  imuGravity: {gravity}  # m/s^2; at your location, not measured by the sensor
""",
    names={"topic": "imu_raw", "gravity": GRAVITY},
)
