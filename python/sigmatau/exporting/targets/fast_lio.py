"""FAST-LIO and FAST-LIO2: lines of their configuration.

A step adds (F_w*dt)*Q*(F_w*dt)^T, which is N^2*dt for Q = N^2*f. UndistortPcl predicts from the last sample to the end of
the scan, r*dt, and begins the next scan with (1 - r)*dt: it adds r^2 + (1 - r)^2, 2/3 on average, instead of one step.
"""

from sigmatau.exporting.template import template
from sigmatau.hints import Hint

TARGET = template(
    "fast-lio",
    program="FAST-LIO",
    summary="FAST-LIO, FAST-LIO2: variances N^2*rate and K^2*rate, discrete, one number for three axes",
    text="""\
# Replace these lines of your FAST-LIO configuration.
# Variances, discrete, for {rate} Hz: the filter adds (dt*F_w) Q (dt*F_w)^T at each step and does not know the rate.
# The filter makes an extra step at the end of each scan, which splits a sample in two. With n samples per scan, it adds
# (n - 1/3)/n of the variance on average: 1.7 % less for n = 20.
# The sample files of FAST-LIO have 0.1 and 0.0001, far above sensor noise: see """
    f"{Hint('noise_factor')}, {Hint('walk_factor')}.\n"
    """\
{omitted}
common:
  imu_topic: {topic}
mapping:
  acc_cov: {accel N^2*rate}
  gyr_cov: {gyro N^2*rate}
  b_acc_cov: {accel K^2*rate}
  b_gyr_cov: {gyro K^2*rate}
""",
    names={"topic": "/livox/imu"},
)
