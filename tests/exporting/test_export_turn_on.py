"""The turn-on bias in the files of the targets that have a field for it, in their units."""

import json
import math
import re
from xml.etree import ElementTree as ET

import pytest

import vio
from sigmatau import Choices, NoiseModel, OptionError, TurnOn, export
from sigmatau.exporting.export import prepare
from sigmatau.exporting.targets import NAMES, target
from sigmatau.units import find

SIGMA = {"gyro": (1e-3, 3e-3, 2e-3), "accel": (0.01, 0.02, 0.06)}
NOISE = {"random_walk": 1e-4, "bias_instability": 1e-5, "rate_random_walk": 1e-6}
PLAIN = NoiseModel(channels={f"{s}_{a}": NOISE for s in SIGMA for a in "xyz"})
SPREADS = {
    f"{s}_{a}": TurnOn(sigma=SIGMA[s][k], low=SIGMA[s][k] / 2, high=SIGMA[s][k] * 2, power_ups=8)
    for s in SIGMA
    for k, a in enumerate("xyz")
}
MODEL = PLAIN.with_turn_on(SPREADS)
WITH_ROOM = [name for name in NAMES if "gyro_turn_on_bias" in target(name).names]


def text_of(model, name, **choices):
    return export(model, to=name, choices=Choices(filter_rate=100.0, **choices))


def in_si(name, text):
    """Of gyro and accelerometer, x, y and z, in SI."""
    if name == "okvis2":
        content = vio.parse(text)["imu_parameters"]
        return {"gyro": [content["sigma_bg"]] * 3, "accel": [content["sigma_ba"]] * 3}
    if name == "kf-gins":
        content = vio.parse(text)
        return {
            "gyro": [v * find("deg/h").factor for v in content["initbgstd"]],
            "accel": [v * find("mGal").factor for v in content["initbastd"]],
        }
    if name == "px4":
        rows = dict(re.findall(r"^1\t1\t(\w+)\t(\S+)\t9$", text, flags=re.M))
        return {"gyro": [float(rows["EKF2_GBIAS_INIT"])] * 3, "accel": [float(rows["EKF2_ABIAS_INIT"])] * 3}
    if name == "gtsam":
        space = {}
        exec(text, space)
        return {"gyro": list(space["GYROSCOPE_START"]), "accel": list(space["ACCELEROMETER_START"])}
    if name == "gazebo":
        root = ET.fromstring(text)
        elements = {"gyro": "angular_velocity", "accel": "linear_acceleration"}
        return {s: [float(e.text) for e in root.iterfind(f".//{path}//bias_stddev")] for s, path in elements.items()}
    weights = re.findall(r"config\.vio_init_b[ag]_weight of your VIO configuration: (\S+) =", text)
    gyro, accel = (float(weight) ** -0.5 for weight in weights)  # The code takes the weight of ba for the gyro
    assert "vio_init_ba_weight of your VIO configuration" in json.loads(text)["about"][-2]
    return {"gyro": [gyro] * 3, "accel": [accel] * 3}


@pytest.mark.parametrize("name", WITH_ROOM)
def test_the_worst_axis_or_each(name):
    found = in_si(name, text_of(MODEL, name))
    for sensor, values in found.items():
        assert values == pytest.approx([max(SIGMA[sensor])] * 3, rel=1e-3)
    if target(name).per_axis and name != "basalt":  # whose configuration has one weight
        for sensor, values in in_si(name, text_of(MODEL, name, axes="each")).items():
            assert values == pytest.approx(SIGMA[sensor], rel=1e-3)
    mean = in_si(name, text_of(MODEL, name, axes="mean"))
    assert mean["gyro"] == pytest.approx([1e-3 * math.sqrt(14 / 3)] * 3, rel=1e-3)


@pytest.mark.parametrize("name", WITH_ROOM)
def test_a_value_of_the_user_comes_first(name):
    given = text_of(MODEL, name, names={"gyro_turn_on_bias": "0.05", "accel_turn_on_bias": "0.4"})
    assert in_si(name, given) == {
        "gyro": pytest.approx([0.05] * 3, rel=1e-3),
        "accel": pytest.approx([0.4] * 3, rel=1e-3),
    }
    with pytest.raises(OptionError, match="gyro_turn_on_bias"):
        text_of(MODEL, name, names={"gyro_turn_on_bias": "-0.05"})


@pytest.mark.parametrize("name", WITH_ROOM)
def test_the_file_says_how_well_it_is_known(name):
    assert "(95 %), 8 power-ups, about its mean" in text_of(MODEL, name)
    few = PLAIN.with_turn_on({"gyro_y": TurnOn(sigma=1e-3, low=4.5e-4, high=3.2e-2, power_ups=2)})
    prepared = prepare(few, to=name, choices=Choices(filter_rate=100.0))
    (finding,) = [finding for finding in prepared.findings if finding.code == "wide_turn_on"]
    assert (finding.channels, finding.details.power_ups) == (("gyro_y",), 2)
    assert name == "gtsam" or "not measured for gyro_x, gyro_z" in prepared.content


def test_without_a_spread_its_upper_end_is_written():
    none = PLAIN.with_turn_on({"gyro_x": TurnOn(sigma=0.0, low=0.0, high=2e-3, power_ups=5)})
    text = text_of(none, "okvis2")
    assert vio.parse(text)["imu_parameters"]["sigma_bg"] == 2e-3
    assert "no spread observed, the upper end" in text


@pytest.mark.parametrize("name", NAMES)
def test_a_model_without_it_is_written_as_before(name):
    """Only OKVIS2 and the plugins of Gazebo have a field that must have a number."""
    plain = text_of(PLAIN, name)
    assert ("turn-on" in plain) == (name in ("okvis2", "gazebo"))
    if name == "okvis2":
        content = vio.parse(plain)["imu_parameters"]
        assert (content["sigma_bg"], content["sigma_ba"]) == (0.01, 0.1)  # of its sample file


@pytest.mark.parametrize("name", [n for n in NAMES if target(n).has_walk and n not in WITH_ROOM])
def test_a_target_without_room_says_so(name):
    assert "no field for turn-on bias of the gyros" in text_of(MODEL, name)


def test_the_sheet_of_ieee_952_has_it_by_axis():
    rows = [line.split("  ") for line in text_of(MODEL, "ieee952").splitlines() if "turn-on bias" in line]
    assert len(rows) == 6
    assert "8 power-ups" in " ".join(rows[0])
    assert rows[1][-1] == "0.003 rad/s"
