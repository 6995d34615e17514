"""Parameters of autopilots, evaluated as their firmware does, against the polynomial."""

import numpy as np
import pytest

from sigmatau import calibrate_temperature
from sigmatau.errors import DataError, OptionError
from sigmatau.lab.temperature.firmware import parameter_file, parameters_ardupilot, parameters_px4
from temperature_logs import AXES, log, ramp

T = np.linspace(-60, 110, 18)  # also outside the calibrated range, where both limit the temperature


@pytest.fixture(scope="module")
def result():
    return calibrate_temperature(log("firmware", ramp(7_200), rate=1.0, channels=AXES), degree=3)


def polynomial_at(result, channel, temperature):
    inside = np.clip(temperature, result.low, result.high)
    return result[channel].polynomial.values(inside).value


def read_px4(text):
    rows = [line.split("\t") for line in text.splitlines() if not line.startswith("#")]
    assert {tuple(row[:2]) for row in rows} == {("1", "1")}
    assert all(row[4] == ("6" if row[2].endswith(("ENABLE", "ID")) else "9") for row in rows)
    return {row[2]: np.float32(row[3]) for row in rows}


def px4_offset(parameters, sensor, axis, temperature):
    """`calc_thermal_offsets_3D` of TemperatureCompensation.cpp, in single precision."""
    p = {name.removeprefix(f"TC_{sensor}0_"): value for name, value in parameters.items()}
    temperature = np.float32(temperature)
    if temperature > p["TMAX"]:
        delta = p["TMAX"] - p["TREF"]
    elif temperature < p["TMIN"]:
        delta = p["TMIN"] - p["TREF"]
    else:
        delta = temperature - p["TREF"]
    return p[f"X0_{axis}"] + p[f"X1_{axis}"] * delta + p[f"X2_{axis}"] * delta * delta + p[f"X3_{axis}"] * delta**3


def test_px4_offsets_are_the_polynomial(result):
    parameters = read_px4(parameter_file(result, target="px4", device_id=3670026))
    assert parameters["TC_G_ENABLE"] == parameters["TC_A_ENABLE"] == 1
    assert parameters["TC_G0_ID"] == 3670026
    for sensor, letter in (("gyro", "G"), ("accel", "A")):
        for number, axis in enumerate("xyz"):
            wanted = polynomial_at(result, f"{sensor}_{axis}", T)
            if sensor == "accel":  # zero at TREF, as PX4's own calibration
                wanted = wanted - polynomial_at(result, f"{sensor}_{axis}", np.array([25.0]))
            offsets = [px4_offset(parameters, letter, number, t) for t in T]
            # single precision of the largest term, 1e-7 of a few 1e-3
            assert offsets == pytest.approx(wanted, abs=3e-9 if sensor == "gyro" else 3e-8)


def read_ardupilot(text):
    rows = [line.split(",") for line in text.splitlines() if not line.startswith("#")]
    return {name: np.float32(value) for name, value in rows}


def ardupilot_corrected(parameters, sensor, axis, value, temperature, cal_temperature):
    """`TCal::correct_sensor` of AP_InertialSensor_tempcal.cpp, in single precision."""

    def polynomial(tdiff):
        c = [parameters[f"INS_TCAL1_{sensor}{k}_{axis}"] for k in (1, 2, 3)]
        return (c[0] + (c[1] + c[2] * tdiff) * tdiff) * tdiff * np.float32(1e-6)

    low, high = parameters["INS_TCAL1_TMIN"], parameters["INS_TCAL1_TMAX"]
    t, cal = (np.clip(np.float32(each), low, high) for each in (temperature, cal_temperature))
    return value - polynomial(t - np.float32(35)) + polynomial(cal - np.float32(35))


def test_ardupilot_takes_the_change_since_the_calibration_of_offsets_away(result):
    parameters = read_ardupilot(parameter_file(result, target="ardupilot"))
    assert parameters["INS_TCAL1_ENABLE"] == 1
    assert len(parameters) == 21
    for sensor, word in (("gyro", "GYR"), ("accel", "ACC")):
        for axis in "xyz":
            truth = polynomial_at(result, f"{sensor}_{axis}", T)
            at_offsets = polynomial_at(result, f"{sensor}_{axis}", np.array([20.0]))[0]
            for t, raw in zip(T, truth, strict=True):
                corrected = ardupilot_corrected(parameters, word, axis.upper(), raw, t, 20.0)
                assert corrected == pytest.approx(at_offsets, abs=1e-8 if sensor == "gyro" else 1e-7)


def test_the_documented_range_of_ardupilot_is_said(result):
    assert "INS_TCAL1_TMAX is outside the documented range" in parameter_file(result, target="ardupilot")


def test_instances(result):
    assert "TC_A2_X1_0" in parameters_px4(result, instance=2)
    assert "INS_TCAL3_GYR1_X" in parameters_ardupilot(result, instance=3)
    for wrong, call in (
        (4, parameters_px4),
        (-1, parameters_px4),
        (0, parameters_ardupilot),
        (6, parameters_ardupilot),
    ):
        with pytest.raises(OptionError, match="must be"):
            call(result, instance=wrong)
    with pytest.raises(OptionError, match="32 bits"):
        parameters_px4(result, device_id=2**40)
    with pytest.raises(OptionError, match="px4"):
        parameter_file(result, target="kalibr")


def test_what_an_autopilot_has_no_parameters_for():
    gyros = ["gyro_x", "gyro_y", "gyro_z"]
    quintic = calibrate_temperature(log("quintic", ramp(7_200), rate=1.0, channels=gyros), degree=5)
    with pytest.raises(DataError, match="degree 5"):
        parameters_px4(quintic)
    one = calibrate_temperature(log("one axis", ramp(7_200), rate=1.0), degree=1)
    with pytest.raises(DataError, match="gyro_y, gyro_z is missing"):
        parameters_ardupilot(one)
    narrow = calibrate_temperature(log("narrow", ramp(7_200, 20, 27), rate=1.0, channels=gyros), degree=1)
    with pytest.raises(DataError, match="10 K"):
        parameters_ardupilot(narrow)
    assert parameters_px4(narrow)["TC_G0_TREF"] == 25
    alone = parameters_ardupilot(calibrate_temperature(log("gyros", ramp(7_200), rate=1.0, channels=gyros), degree=1))
    assert alone["INS_TCAL1_ACC1_X"] == 0
