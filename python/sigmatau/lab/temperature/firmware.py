"""Temperature parameters of autopilots: PX4 ``TC_*`` and ArduPilot ``INS_TCAL*``.

PX4 subtracts X0 + X1·d + X2·d² + X3·d³ from a raw sample, d = T - TREF with T limited to TMIN … TMAX; units are rad/s and
m/s² (``TemperatureCompensation::calc_thermal_offsets_3D``). The constant of an accelerometer is written as 0, because it
contains gravity; the calibration of positions measures the offset, as PX4's own calibration does.

ArduPilot subtracts (C1·d + C2·d² + C3·d³)·1e-6 with d = T - 35 °C, and adds its value at the temperature of the last
calibration of offsets; T is limited to TMIN … TMAX, and the constant has no parameter (``AP_InertialSensor::TCal``).

Both compute in single precision.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from sigmatau._version import __version__
from sigmatau.errors import DataError, OptionError
from sigmatau.lab.temperature.polynomial import BiasPolynomial
from sigmatau.lab.temperature.result import TemperatureCalibration
from sigmatau.record import stream_name

AUTOPILOTS = ("px4", "ardupilot")
"""Names of the targets."""

_DEGREE = 3  # degree of the polynomials of both autopilots
_ARDUPILOT_REFERENCE = 35.0  # TEMP_REFERENCE of AP_InertialSensor_tempcal.cpp [°C]
_ARDUPILOT_SCALE = 1e6  # SCALE_FACTOR of the same file
_ARDUPILOT_RANGE = (-70.0, 80.0)  # documented range of TMIN and TMAX [°C]
_ARDUPILOT_LEAST_RANGE = 10.0  # smallest range that the calibration of ArduPilot accepts [K]
_SENSORS = {"gyro": "G", "accel": "A"}
_AXES = "xyz"


def parameters_px4(result: TemperatureCalibration, *, instance: int = 0, device_id: int = 0) -> dict[str, float]:
    """Parameters ``TC_*`` of PX4 by name.

    Parameters
    ----------
    result : TemperatureCalibration
        Calibration of gyros, accelerometers or both, with polynomials of degree 3 or less.
    instance : int
        Number of the sensor in the autopilot, 0 to 3.
    device_id : int
        ``device_id`` of the sensor, which PX4 compares with ``TC_G0_ID``; a ULog has it in ``sensor_gyro``. If it is 0, set
        it in the ground station.

    Returns
    -------
    dict of str to float
        In the order of the file. [rad/s, m/s², per power of a kelvin; °C]

    Raises
    ------
    DataError
        If a sensor lacks an axis, or for a polynomial of a higher degree.
    OptionError
        For an instance outside 0 … 3, or a device id that is not a whole number of 32 bits.

    References
    ----------
    PX4-Autopilot, ``src/modules/temperature_compensation/TemperatureCompensation.cpp``.

    Examples
    --------
    >>> import numpy as np
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={f"gyro_{axis}": {"random_walk": 1e-4} for axis in "xyz"})
    >>> rates = st.simulate(model, duration=3600, rate=2, rng=1).streams[0]
    >>> columns = {name: rates.column(name) for name in rates.channels}
    >>> log = st.Record.from_arrays(rate=2, temperature=np.linspace(0, 50, 7200), **columns)
    >>> from sigmatau.lab.temperature.firmware import parameters_px4
    >>> parameters = parameters_px4(st.calibrate_temperature(log, degree=1), device_id=3670026)
    >>> parameters["TC_G_ENABLE"], parameters["TC_G0_ID"], parameters["TC_G0_X2_0"]
    (1.0, 3670026.0, 0.0)
    """
    if instance not in range(4):
        raise OptionError(f"{{option}} must be 0 to 3, not {instance!r}", option="instance")
    if isinstance(device_id, bool) or not isinstance(device_id, int) or not -(2**31) <= device_id < 2**32:
        raise OptionError(f"{{option}} must be a whole number of 32 bits, not {device_id!r}", option="device_id")
    parameters: dict[str, float] = {}
    for sensor, axes in _sensors(result).items():
        letter = _SENSORS[sensor]
        reference = float(np.float32(next(iter(axes.values())).reference))
        parameters[f"TC_{letter}_ENABLE"] = 1.0
        begin = f"TC_{letter}{instance}_"
        parameters[f"{begin}ID"] = float(device_id)
        for name, value in (("TMIN", result.low), ("TMAX", result.high), ("TREF", reference)):
            parameters[begin + name] = value
        for number, axis in enumerate(_AXES):
            for power, value in enumerate(_padded(axes[axis].about(reference))):
                constant = power == 0 and sensor == "accel"
                parameters[f"{begin}X{power}_{number}"] = 0.0 if constant else value
    return parameters


def parameters_ardupilot(result: TemperatureCalibration, *, instance: int = 1) -> dict[str, float]:
    """Parameters ``INS_TCALn_*`` of ArduPilot by name.

    Parameters
    ----------
    result : TemperatureCalibration
        Calibration of gyros, accelerometers or both, with polynomials of degree 3 or less. Coefficients of a sensor that it
        lacks are 0.
    instance : int
        Number of the IMU, 1 to 5.

    Returns
    -------
    dict of str to float
        In the order of the file. [1e-6 rad/s, 1e-6 m/s², per power of a kelvin; °C]

    Raises
    ------
    DataError
        If a sensor lacks an axis, for a polynomial of a higher degree, or a range of less than 10 K.
    OptionError
        For an instance outside 1 … 5.

    References
    ----------
    ArduPilot, ``libraries/AP_InertialSensor/AP_InertialSensor_tempcal.cpp``.

    Examples
    --------
    >>> import numpy as np
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={f"gyro_{axis}": {"random_walk": 1e-4} for axis in "xyz"})
    >>> rates = st.simulate(model, duration=3600, rate=2, rng=1).streams[0]
    >>> columns = {name: rates.column(name) for name in rates.channels}
    >>> log = st.Record.from_arrays(rate=2, temperature=np.linspace(0, 50, 7200), **columns)
    >>> from sigmatau.lab.temperature.firmware import parameters_ardupilot
    >>> parameters = parameters_ardupilot(st.calibrate_temperature(log, degree=1))
    >>> parameters["INS_TCAL1_ENABLE"], parameters["INS_TCAL1_TMAX"], parameters["INS_TCAL1_GYR3_Z"]
    (1.0, 50.0, 0.0)
    """
    if instance not in range(1, 6):
        raise OptionError(f"{{option}} must be 1 to 5, not {instance!r}", option="instance")
    if result.high - result.low < _ARDUPILOT_LEAST_RANGE:
        raise DataError(
            f"ArduPilot needs a range of {_ARDUPILOT_LEAST_RANGE:g} K; the log has {result.high - result.low:.3g} K."
            " Heat further"
        )
    sensors = _sensors(result)
    begin = f"INS_TCAL{instance}_"
    parameters = {f"{begin}ENABLE": 1.0, f"{begin}TMIN": result.low, f"{begin}TMAX": result.high}
    for power in range(1, _DEGREE + 1):
        for sensor, word in (("accel", "ACC"), ("gyro", "GYR")):
            for axis in _AXES:
                moved = sensors[sensor][axis].about(_ARDUPILOT_REFERENCE) if sensor in sensors else None
                value = 0.0 if moved is None else _padded(moved)[power] * _ARDUPILOT_SCALE
                parameters[f"{begin}{word}{power}_{axis.upper()}"] = value
    return parameters


def parameter_file(
    result: TemperatureCalibration, *, target: str, instance: int | None = None, device_id: int = 0
) -> str:
    """A file of parameters that ground stations load.

    Parameters
    ----------
    result : TemperatureCalibration
    target : {"px4", "ardupilot"}
    instance : int, optional
        Number of the sensor. Default: the first, 0 of PX4 and 1 of ArduPilot.
    device_id : int
        ``device_id`` for PX4, see `parameters_px4`.

    Returns
    -------
    str

    Raises
    ------
    OptionError
        For an unknown target, and as the functions of the targets.
    DataError
        As the functions of the targets.
    """
    if target not in AUTOPILOTS:
        raise OptionError(f"{{option}} {target!r} must be one of {', '.join(AUTOPILOTS)}", option="export")
    lines = [
        f"# Temperature parameters for {target}, written by sigmatau {__version__}",
        f"# from {result.source or 'a record'}, {result.low:.4g} to {result.high:.4g} degC",
    ]
    if target == "ardupilot":
        parameters = parameters_ardupilot(result, instance=1 if instance is None else instance)
        lines += [
            "# Polynomials in T - 35 degC, times 1e6, in rad/s and m/s^2. Calibrate the offsets again after loading it.",
            *(
                f"# {name} is outside the documented range, -70 to 80 degC: a ground station may reject it"
                for name in parameters
                if name.endswith(("TMIN", "TMAX"))
                and not _ARDUPILOT_RANGE[0] <= parameters[name] <= _ARDUPILOT_RANGE[1]
            ),
            *(f"{name},{_number(value)}" for name, value in parameters.items()),
        ]
        return "\n".join(lines) + "\n"
    parameters = parameters_px4(result, instance=instance or 0, device_id=device_id)
    lines.append("# Offset = X0 + X1*d + X2*d^2 + X3*d^3, d = T - TREF, in rad/s and m/s^2. X0 of accelerometers is 0.")
    if device_id == 0:
        lines.append("# ID is 0: set TC_G0_ID and TC_A0_ID to the device_id of the sensors, or PX4 applies nothing.")
    lines.append("# vehicle\tcomponent\tname\tvalue\ttype")
    for name, value in parameters.items():
        whole = name.endswith(("ENABLE", "ID"))
        lines.append(f"1\t1\t{name}\t{int(value) if whole else _number(value)}\t{6 if whole else 9}")
    return "\n".join(lines) + "\n"


def _number(value: float) -> str:
    """Text of a number from which the same single-precision number is read."""
    return f"{np.float32(value):.9g}"


def _padded(polynomial: BiasPolynomial) -> list[float]:
    """The four coefficients of a cubic."""
    return [*polynomial.coefficients.tolist(), *[0.0] * (_DEGREE - polynomial.degree)]


def _sensors(result: TemperatureCalibration) -> Mapping[str, dict[str, BiasPolynomial]]:
    """Polynomials by sensor and axis; raises `DataError` for a result that has no parameters in an autopilot."""
    sensors: dict[str, dict[str, BiasPolynomial]] = {}
    for name, channel in result.items():
        sensor, axis = stream_name(name), name.rpartition("_")[2]
        if sensor not in _SENSORS or axis not in _AXES:
            continue
        if channel.polynomial.degree > _DEGREE:
            raise DataError(f"{name} has degree {channel.polynomial.degree}; autopilots evaluate 3. Fit with degree 3")
        sensors.setdefault(sensor, {})[axis] = channel.polynomial
    if not sensors:
        raise DataError("no gyro and no accelerometer with axes x, y, z. Name the channels gyro_x … accel_z")
    for sensor, axes in sensors.items():
        if len(axes) < len(_AXES):
            missing = ", ".join(f"{sensor}_{axis}" for axis in _AXES if axis not in axes)
            raise DataError(f"{missing} is missing; an autopilot has parameters for three axes. Calibrate all axes")
    return sensors
