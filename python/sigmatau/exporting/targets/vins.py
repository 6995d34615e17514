"""VINS-Mono and VINS-Fusion: lines of their configuration.

The code propagates by the mid-point rule and treats the two halves of a step, dt/2 each, as independent: a step adds
2*(dt/2)^2*n^2 = dt^2*n^2/2, which is N^2*dt for n = N*sqrt(2f). A bias adds (dt*w)^2, which is K^2*dt for w = K*sqrt(f).
"""

from sigmatau.exporting.template import GRAVITY, template

TARGET = template(
    "vins",
    program="VINS-Mono, VINS-Fusion",
    summary="VINS-Mono, VINS-Fusion: N*sqrt(2*rate) and K*sqrt(rate), discrete, one number for three axes",
    aliases=("vins-mono", "vins-fusion"),
    text="""\
# Replace these lines of your VINS-Mono or VINS-Fusion configuration.
# Discrete, for {rate} Hz: the code multiplies by the step and does not know the rate.
# The noise is N*sqrt(2*rate): integration_base.h treats the two halves of a step as independent, so that the
# common N*sqrt(rate) propagates to half the covariance. For N*sqrt(rate) divide acc_n and gyr_n by sqrt(2).
{omitted}
imu_topic: {topic}
acc_n: {accel N*sqrt(2*rate)}
gyr_n: {gyro N*sqrt(2*rate)}
acc_w: {accel K*sqrt(rate)}
gyr_w: {gyro K*sqrt(rate)}
g_norm: {gravity}  # m/s^2; at your location, not measured by the sensor
""",
    names={"topic": "/imu0", "gravity": GRAVITY},
)
