"""The ends of what can be chosen and written: finite, not 0, and to all digits, or refused."""

import math
import re
import sys
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest

from sigmatau import DataError, NoiseModel, OptionError
from sigmatau.exporting.choices import Choices
from sigmatau.exporting.export import export
from sigmatau.exporting.targets import NAMES, target
from sigmatau.model.channel import ChannelModel

RATE = 200.0
FLAT = {"random_walk": 3e-4, "rate_random_walk": 7e-6}


def has_factors(name):
    """Whether the file of a target has numbers with a factor, and no matrices."""
    refused = {choice for rule in target(name).unused if rule.when is None for choice in rule.choices}
    return "noise_factor" not in refused and name != "state-space"


WITH_FACTORS = [name for name in NAMES if has_factors(name)]


@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf, 1e308, 1e-308, 1e60, 1e-60])
@pytest.mark.parametrize("name", ["noise_factor", "walk_factor", "filter_rate", "step", "horizon"])
def test_choices_have_a_range(name, value):
    with pytest.raises(OptionError, match=f"`{name}` must be a positive number, from 1e-0") as refused:
        Choices(**{name: value})
    assert refused.value.option == name


@pytest.mark.parametrize("name", ["noise", "walk"])
def test_values_have_a_range(name):
    for value in (0.0, math.nan, 1e-300, 1e300):
        with pytest.raises(OptionError, match="from 1e-100 to 1e"):
            Choices(**{name: {"gyro": value}})


@pytest.mark.parametrize("size", [1e-100, 1e100])
@pytest.mark.parametrize("factor", [1e-6, 1e6])
@pytest.mark.parametrize("name", WITH_FACTORS)
def test_the_least_and_the_most_are_written_or_refused(name, size, factor):
    """Each number of the file is finite, and none is 0 or short of digits where the model's is not."""
    terms = dict.fromkeys(("random_walk", "rate_random_walk", "bias_instability"), size)
    given = NoiseModel(channels={"gyro_x": terms, "accel_x": terms})
    chosen = {} if name == "ros" else {"walk_factor": factor}
    refused: list[str] = []
    for rate in (1e-6, 1e9):
        horizon = {} if target(name).has_horizon is False else {"horizon": 100 / rate}
        try:
            text = export(given, to=name, choices=Choices(filter_rate=rate, noise_factor=factor, **chosen, **horizon))
        except DataError as error:
            refused.append(str(error))
            continue
        assert name not in ("px4", "ardupilot")
        code = "\n".join(line.split(" #")[0].split("  %")[0].split("//")[0] for line in text.splitlines())
        found = [float(digits) for digits in re.findall(r"\d\.\d*e[+-]\d+", code)]
        assert len(found) > 1
        assert all(sys.float_info.min < value < math.inf for value in found)
        assert not re.search(r"\b(inf|nan)\b", code)
    assert all(re.search("cannot be written in single precision|out of range|in SI, not", text) for text in refused)


def test_single_precision_is_refused_by_name():
    for name, size in (("EKF2_GYR_NOISE", 1e-50), ("EKF2_GYR_NOISE", 1e39), ("EKF2_GYR_NOISE", 3e-40)):
        terms = {"random_walk": size, "rate_random_walk": 1e-6}
        given = NoiseModel(channels={"gyro_x": terms, "accel_x": terms})
        with pytest.raises(DataError, match=f"{name}: .* cannot be written in single precision"):
            export(given, to="px4", choices=Choices())


def test_an_upper_limit_whose_square_is_nothing():
    gyro = ChannelModel(terms={"random_walk": 1e-4}, limits={"rate_random_walk": 1e-200})
    given = NoiseModel(channels={"gyro_x": gyro, "accel_x": {"random_walk": 1e-3, "rate_random_walk": 1e-6}})
    with pytest.raises(DataError, match="1e-200 in SI is out of range"):
        export(given, to="fast-lio", choices=Choices(filter_rate=200.0, walk={"gyro": "upper-limit"}))


@pytest.mark.parametrize("value", [np.array([200.0]), Decimal(200), Fraction(200, 1), "200", True, 200j])
def test_choices_are_numbers(value):
    if isinstance(value, Fraction):  # a real number
        assert Choices(filter_rate=value).filter_rate == 200
        return
    with pytest.raises(OptionError, match="`filter_rate` must be"):
        Choices(filter_rate=value)


@pytest.mark.parametrize("text", ["9_8", "٣", "0x9", "1e300", "1e-300", " 9.8", "9.8 "])
def test_constants_are_plain_numbers(text):
    given = NoiseModel(channels={"gyro_x": FLAT, "accel_x": FLAT})
    with pytest.raises(OptionError, match="gravity"):
        export(given, to="vins", choices=Choices(filter_rate=RATE, names={"gravity": text}))


@pytest.mark.parametrize(("path", "words"), [(3, "name of a file"), ("a\0b", "null"), ("a" * 300, "too long")])
def test_names_that_no_file_has(path, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    given = NoiseModel(channels={"gyro_x": FLAT, "accel_x": FLAT})
    with pytest.raises((DataError, OptionError), match=words):
        export(given, to="kalibr", path=path, choices=Choices(filter_rate=RATE))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", WITH_FACTORS)
def test_factors_by_sensor(name):
    """Those of one sensor change its lines alone; a sensor without a factor has 1."""
    terms = FLAT | {"bias_instability": 1e-5}
    model = NoiseModel(channels={f"{sensor}_{axis}": terms for sensor in ("gyro", "accel") for axis in "xyz"})
    slow = {} if name == "ros" else {"horizon": 10.0}

    def lines(factor):
        factors = {"noise_factor": factor} | ({} if name == "ros" else {"walk_factor": factor})
        text = str(export(model, to=name, choices=Choices(filter_rate=RATE, **slow, **factors)))
        return text.splitlines()

    plain, doubled, gyro = lines(1.0), lines(2.0), lines({"gyro": 2.0})
    assert lines({"gyro": 2.0, "accel": 2.0}) == doubled
    assert plain != gyro != doubled
    changed = [
        (a, b, c) for a, b, c in zip(plain, gyro, doubled, strict=False) if a != b and not a.startswith(("#", "%"))
    ]
    assert all(b == c for _, b, c in changed)


def test_a_factor_of_a_sensor_that_the_model_lacks():
    with pytest.raises(OptionError, match="the model has no accelerometers") as refused:
        export(
            NoiseModel(channels={"gyro_x": FLAT}),
            to="state-space",
            choices=Choices(step=0.01, walk_factor={"accel": 2.0}),
        )
    assert refused.value.option == "walk_factor"
    with pytest.raises(OptionError, match="unknown sensor 'mag'"):
        Choices(noise_factor={"mag": 2.0})
