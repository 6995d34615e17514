"""Targets whose file is a short YAML with one number for three axes: one entry of `_TEMPLATES` each.

To add a target of this kind, add one entry: the text of its file with a place in braces for each value, its summary, and the
defaults of its names. The order of the table is that of ``sigmatau export --list``. Places are:

``{gyro N}``, ``{accel K*sqrt(rate)}``
    A sensor and one of `_FORMS`: the number in this form, with its unit and origin in a comment.
``{omitted}``
    A line of its own: remarks on the noise that the format has no field for, with the indent of this line.
``{rate}``
    Rate of the filter [Hz]; it is then needed. Forms that contain ``rate`` need it too.
``{gyro turn-on 0.01}``
    Standard deviation of the bias at turn-on; the number is written if it is not known. The names of the target then need
    `TURN_ON_NAMES`.
``{topic}``, ``{gravity}``
    A name that the user can give with ``--name``.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

from sigmatau.exporting.statements import pair_remarks
from sigmatau.exporting.target import Target
from sigmatau.exporting.text import comment, digits, number_with_comment, remark, topic
from sigmatau.exporting.turn_on import TURN_ON_NAMES, turn_on, unknown_turn_on
from sigmatau.exporting.values import Numbers
from sigmatau.hints import Hint
from sigmatau.units import STANDARD_GRAVITY


class _Form(NamedTuple):
    """How a program takes a coefficient."""

    convert: Callable[[float, float], float]  # From coefficient [SI] and sampling rate [Hz] to the number of the file
    unit: str  # Its unit, where ``{}`` is rad/s or m/s^2 for N and its rate of change for K


# N and K as continuous two-sided densities; as standard deviations of a sample; as variances of a sample.
_FORMS = {
    "N": _Form(lambda n, _: n, "N, {}/sqrt(Hz)"),
    "K": _Form(lambda k, _: k, "K, {}/sqrt(Hz)"),
    "N*sqrt(2*rate)": _Form(lambda n, f: math.sqrt(2 * f) * n, "{} per sample = N*sqrt(2*rate)"),
    "K*sqrt(rate)": _Form(lambda k, f: math.sqrt(f) * k, "{} per sample = K*sqrt(rate)"),
    "N^2*rate": _Form(lambda n, f: n**2 * f, "({})^2 per sample = N^2*rate"),
    "K^2*rate": _Form(lambda k, f: k**2 * f, "({})^2 per sample = K^2*rate"),
}
_UNITS = {"gyro": {"N": "rad/s", "K": "rad/s^2"}, "accel": {"N": "m/s^2", "K": "m/s^3"}}
_TURN_ON = "turn-on "  # begins the form of a place for the turn-on bias
_PLACE = re.compile(r"\{(\w+)(?: ([^}]+))?\}")


class _Template(NamedTuple):
    """One target: line of ``--list``, text of the file with places for values, defaults of its names."""

    summary: str
    text: str
    names: dict[str, str] = {}  # noqa: RUF012  never changed


_GRAVITY = digits(STANDARD_GRAVITY)

_TEMPLATES = {
    # Kalibr divides by sqrt(1/update_rate) itself, and rejects what is not above 0.
    "kalibr": _Template(
        "Kalibr imu.yaml: N and K, continuous, one number for three axes",
        """\
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
        {"topic": "/imu0"},
    ),
    # OpenCV's reader, which OpenVINS uses, needs the first line.
    "openvins": _Template(
        "OpenVINS kalibr_imu_chain.yaml: N and K, continuous, one number for three axes; its samples are inflated",
        """\
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
        {"topic": "/imu0"},
    ),
    "euroc": _Template(
        "EuRoC sensor.yaml (ASL data sets): N and K, continuous, one number for three axes",
        """\
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
    ),
    # The code squares the noise for GTSAM, and multiplies that of the biases by the root of the time between key frames.
    "lio-sam": _Template(
        "LIO-SAM params.yaml: N and K, continuous (it squares them itself), one number for three axes",
        """\
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
        {"topic": "imu_raw", "gravity": _GRAVITY},
    ),
    # The code propagates by the mid-point rule and takes the two halves of a step, dt/2 each, for independent: a step adds
    # 2*(dt/2)^2*n^2 = dt^2*n^2/2, which is N^2*dt for n = N*sqrt(2f). A bias adds (dt*w)^2, which is K^2*dt for
    # w = K*sqrt(f).
    "vins": _Template(
        "VINS-Mono, VINS-Fusion: N*sqrt(2*rate) and K*sqrt(rate), discrete, one number for three axes",
        """\
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
        {"topic": "/imu0", "gravity": _GRAVITY},
    ),
    # The code multiplies noise by sqrt(f) and divides walks by sqrt(f): a step of a walk is K*sqrt(dt).
    "orb-slam3": _Template(
        "ORB-SLAM3 settings: N and K, continuous, one number for three axes",
        """\
# Replace these lines of your ORB-SLAM3 settings; keep your IMU.T_b_c1.
# Continuous-time densities: Tracking.cc multiplies noise by sqrt(IMU.Frequency) and divides walks by it, once.
{omitted}
IMU.NoiseGyro: {gyro N}
IMU.NoiseAcc: {accel N}
IMU.GyroWalk: {gyro K}
IMU.AccWalk: {accel K}
IMU.Frequency: {rate}  # Hz; with a decimal point, ORB-SLAM3 rejects an integer
""",
    ),
    # A step adds (F_w*dt)*Q*(F_w*dt)^T, which is N^2*dt for Q = N^2*f. UndistortPcl predicts from the last sample to the end
    # of the scan, r*dt, and begins the next scan with (1 - r)*dt: r^2 + (1 - r)^2, 2/3 on average, in place of one step.
    "fast-lio": _Template(
        "FAST-LIO, FAST-LIO2: variances N^2*rate and K^2*rate, discrete, one number for three axes",
        """\
# Replace these lines of your FAST-LIO configuration.
# Variances, discrete, for {rate} Hz: the filter adds (dt*F_w) Q (dt*F_w)^T at each step and does not know the rate.
# At the end of a scan it makes a step of its own, which splits a sample in two: of n samples a scan (n - 1/3)/n of the
# variance is added on average, 1.7 % less for n = 20.
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
        {"topic": "/livox/imu"},
    ),
    # The noise matrices have dt*sigma^2; the biases of the first state have the prior sigma_bg^2, sigma_ba^2.
    "okvis2": _Template(
        "OKVIS2 imu_parameters: N and K, continuous, and the turn-on bias; one number for three axes",
        """\
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
        {"gravity": _GRAVITY, **TURN_ON_NAMES},
    ),
    # A sample adds N^2*calibration_frequency*dt^2 and K^2/calibration_frequency.
    "cuvslam": _Template(
        "Isaac ROS Visual SLAM (cuVSLAM): N and K, continuous, one number for three axes",
        """\
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
    ),
}


def _write(template: _Template, numbers: Numbers) -> str:
    """The text of a file."""

    def value(place: re.Match[str]) -> str:
        name, form = place.groups()
        if form is not None and form.startswith(_TURN_ON):
            return _turn_on_field(numbers, name, form.removeprefix(_TURN_ON))
        if form is not None:
            return _coefficient(numbers, name, form)
        if name == "rate":
            return numbers.rate_text()
        if name == "topic":
            return topic(numbers.name(name, template.names[name]))
        return digits(numbers.number(name, template.names[name]))

    lines: list[str] = []
    has_turn_on = _TURN_ON in template.text
    for line in template.text.splitlines():
        if line.lstrip() == "{omitted}":
            remarks = pair_remarks(numbers, has_turn_on=has_turn_on)
            lines += [line.replace("{omitted}", remark(sentence)) for sentence in remarks]
        else:
            lines.append(_PLACE.sub(value, line))
    return "\n".join(lines) + "\n"


def _coefficient(numbers: Numbers, sensor: str, form: str) -> str:
    """N or K of a sensor in a form, with unit and origin in a comment."""
    number = numbers.noise(sensor) if form[0] == "N" else numbers.walk(sensor)
    rate = numbers.rate() if "rate" in form else math.nan
    unit = _FORMS[form].unit.format(_UNITS[sensor][form[0]])
    return number_with_comment(_FORMS[form].convert(number.value, rate), f"{unit}; {number.words}")


def _turn_on_field(numbers: Numbers, sensor: str, default: str) -> str:
    """The uncertainty of the initial bias of a sensor, or the number of the program's sample file."""
    unit = _UNITS[sensor]["N"]
    start = turn_on(numbers, sensor)
    if start is None:
        return f"{default}  # {comment(f'{unit}; from the sample file, {unknown_turn_on(sensor)}')}"
    return number_with_comment(start.value, f"{unit}; {start.words}")


def _target(name: str, template: _Template) -> Target:
    places = _PLACE.findall(template.text)
    scaled = any("rate" in form for _, form in places)
    has_field = any(place == "rate" for place, _ in places)
    return Target(
        name=name,
        summary=template.summary,
        ending=".yaml",
        write=partial(_write, template),
        needs_rate=scaled or has_field,
        has_rate_field=has_field and not scaled,
        names=template.names,
        has_walk=True,
    )


TARGETS = {name: _target(name, template) for name, template in _TEMPLATES.items()}
"""The targets by name."""
