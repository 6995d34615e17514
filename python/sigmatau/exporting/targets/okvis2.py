"""OKVIS2: ``imu_parameters`` of its configuration.

The noise matrices have dt*sigma^2; the biases of the first state have the prior sigma_bg^2, sigma_ba^2.
"""

from sigmatau.exporting.template import GRAVITY, template
from sigmatau.exporting.turn_on import TURN_ON_NAMES

TARGET = template(
    "okvis2",
    program="OKVIS2",
    summary="OKVIS2 imu_parameters: N and K, continuous, and the turn-on bias; one number for three axes",
    aliases=("okvis",),
    text="""\
# Replace these lines of imu_parameters in your OKVIS2 configuration; keep use, a_max, g_max, g0, a0 and T_BS.
# Continuous-time densities: ImuError.cpp multiplies their squares by dt, and does not know the rate.
# sigma_bg and sigma_ba are the uncertainty of the initial biases, around g0 and a0.
{omitted}
imu_parameters:
    sigma_g_c: {gyro N}
    sigma_a_c: {accel N}
    sigma_gw_c: {gyro K}
    sigma_aw_c: {accel K}
    sigma_bg: {gyro turn-on 0.01}
    sigma_ba: {accel turn-on 0.1}
    g: {gravity}  # m/s^2; at your location, not measured by the sensor
""",
    names={"gravity": GRAVITY, **TURN_ON_NAMES},
)
