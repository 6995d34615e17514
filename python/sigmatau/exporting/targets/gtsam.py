"""GTSAM: a Python module that builds ``PreintegrationCombinedParams``, with the C++ equivalent in comments."""

from __future__ import annotations

from collections.abc import Callable

from sigmatau.exporting.choices import KINDS
from sigmatau.exporting.statements import pair_remarks
from sigmatau.exporting.target import Target
from sigmatau.exporting.text import comment, digits, measured, remark
from sigmatau.exporting.turn_on import TURN_ON_NAMES, turn_on_axes
from sigmatau.exporting.values import Number, Numbers
from sigmatau.units import STANDARD_GRAVITY

_AXES = "xyz"


def write(numbers: Numbers) -> str:
    """Text of the module: densities, which the module squares for the covariances."""
    rows = [
        ("ACCELEROMETER_NOISE", "accel", numbers.noise, numbers.channel_noise, "N, m/s^2/sqrt(Hz)"),
        ("GYROSCOPE_NOISE", "gyro", numbers.noise, numbers.channel_noise, "N, rad/s/sqrt(Hz)"),
        ("ACCELEROMETER_WALK", "accel", numbers.walk, numbers.channel_walk, "K, m/s^3/sqrt(Hz)"),
        ("GYROSCOPE_WALK", "gyro", numbers.walk, numbers.channel_walk, "K, rad/s^2/sqrt(Hz)"),
    ]
    lines = [*map(remark, pair_remarks(numbers, has_turn_on=True)), "# x, y, z"]
    for name, sensor, sensor_number, channel_number, unit in rows:
        lines += [f"{name} = (", *_axes(numbers, sensor, sensor_number, channel_number, unit), ")"]
    prior, prior_function = _prior(numbers)
    lines += prior
    gravity = numbers.number("gravity", digits(STANDARD_GRAVITY))
    integration = numbers.number("integration", "1.0e-8")
    module = _MODULE.format(numbers="\n".join(lines), gravity=digits(gravity), integration=digits(integration))
    return module + prior_function


def _prior(numbers: Numbers) -> tuple[list[str], str]:
    """Lines with the turn-on biases and the function that builds a prior; only a remark if a turn-on bias is unknown."""
    starts = {sensor: turn_on_axes(numbers, sensor) for sensor in ("accel", "gyro")}
    lacking = [KINDS[sensor] for sensor, axes in starts.items() if axes is None]
    if lacking:
        why = f"No prior of the first bias: the turn-on bias of the {lacking[0]} is not known."
        return [remark(why)] * (len(lacking) < len(starts)), ""
    lines: list[str] = []
    for name, sensor, unit in (("ACCELEROMETER_START", "accel", "m/s^2"), ("GYROSCOPE_START", "gyro", "rad/s")):
        rows = [f"    {measured(axis.value)},  # {comment(f'{unit}; {axis.words}')}" for axis in starts[sensor] or ()]
        lines += [f"{name} = (", *rows, ")"]
    return lines, _PRIOR


def _axes(
    numbers: Numbers,
    sensor: str,
    sensor_number: Callable[[str], Number],
    channel_number: Callable[[str], Number],
    unit: str,
) -> list[str]:
    """One line per axis: a common number, or with ``axes="each"`` that of the axis if the model has it."""
    if numbers.choices.axes != "each":
        number = sensor_number(sensor)
        first, *repeated = [f"    {measured(number.value)}," for _ in _AXES]
        return [f"{first}  # {comment(f'{unit}; {number.words}')}", *repeated]
    axes = {name.removeprefix(f"{sensor}_"): channel_number(name) for name in numbers.channels(sensor)}
    worst = max(axes.values(), key=lambda number: number.value)
    lines = []
    for axis in _AXES:
        words = unit if axis in axes else f"{unit}; {axis}: not in the model, the worst of the others"
        used = axes.get(axis, worst)
        lines.append(f"    {measured(used.value)},  # {comment(f'{words}; {used.words}')}")
    return lines


_MODULE = '''\
"""Noise parameters of an IMU for GTSAM: params() makes PreintegrationCombinedParams."""

# Continuous-time densities; their squares are GTSAM's covariances. GTSAM divides the noise by dt and multiplies the walks
# by dt itself: nothing here is multiplied by the sampling rate.
{numbers}
GRAVITY = {gravity}  # m/s^2; at your location, not measured by the sensor
INTEGRATION = {integration}  # error of the integration, not sensor noise; the default of GTSAM, 1, is too large


def params(gravity=GRAVITY):
    """PreintegrationCombinedParams with z up; use MakeSharedD for z down."""
    import gtsam
    import numpy as np

    made = gtsam.PreintegrationCombinedParams.MakeSharedU(gravity)
    made.setAccelerometerCovariance(np.diag(np.square(ACCELEROMETER_NOISE)))  # N^2, (m/s^2)^2/Hz
    made.setGyroscopeCovariance(np.diag(np.square(GYROSCOPE_NOISE)))  # N^2, (rad/s)^2/Hz
    made.setBiasAccCovariance(np.diag(np.square(ACCELEROMETER_WALK)))  # K^2, (m/s^3)^2/Hz
    made.setBiasOmegaCovariance(np.diag(np.square(GYROSCOPE_WALK)))  # K^2, (rad/s^2)^2/Hz
    made.setIntegrationCovariance(INTEGRATION * np.eye(3))  # not from the Allan variance
    # Not from the Allan variance either: the uncertainty of the initial bias belongs in the prior of the first bias. The
    # default is 1 up to GTSAM 4.2, which is far too large; later versions ignore or lack it.
    initial = getattr(made, "setBiasAccOmegaInit", None) or getattr(made, "setBiasAccOmegaInt", None)
    if initial is not None:
        initial(np.zeros((6, 6)))
    return made


# The same in C++, with Vector3 of the numbers above:
#   auto p = gtsam::PreintegrationCombinedParams::MakeSharedU(gravity);
#   p->accelerometerCovariance = accelerometer_noise.cwiseAbs2().asDiagonal();
#   p->gyroscopeCovariance = gyroscope_noise.cwiseAbs2().asDiagonal();
#   p->biasAccCovariance = accelerometer_walk.cwiseAbs2().asDiagonal();
#   p->biasOmegaCovariance = gyroscope_walk.cwiseAbs2().asDiagonal();
#   p->integrationCovariance = integration * gtsam::I_3x3;
#   p->biasAccOmegaInt = gtsam::Z_6x6;  // if the version has it
'''

_PRIOR = '''

def prior():
    """Noise model of a PriorFactorConstantBias on the first bias: spread of the bias between power-ups."""
    import gtsam
    import numpy as np

    return gtsam.noiseModel.Diagonal.Sigmas(np.array([*ACCELEROMETER_START, *GYROSCOPE_START]))
'''

TARGET = Target(
    name="gtsam",
    program="GTSAM",
    columns=("N²", "K²"),
    summary="GTSAM PreintegrationCombinedParams, a Python module: covariances N^2 and K^2, continuous, an axis each",
    ending=".py",
    write=write,
    has_walk=True,
    per_axis=True,
    names={"gravity": digits(STANDARD_GRAVITY), "integration": "1.0e-8", **TURN_ON_NAMES},
)
