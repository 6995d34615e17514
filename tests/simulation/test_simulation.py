"""Model files and simulated records."""

import math

import numpy as np
import pytest

from known import seed_of
from sigmatau import DataError, NoiseModel, OptionError, allan, simulate
from sigmatau.io.write import write
from sigmatau.units import to_si

MODEL = """
[channels.gyro_x]
random_walk = "0.3 deg/sqrt(h)"
bias_instability = "12 deg/h"
rate_random_walk = "20 deg/h/√h"
[channels.gyro_y]
noise_density = "0.005 deg/s/sqrt(Hz)"
sided = "one"
[channels.accel_z]
quantization = "5e-4 m/s"
rate_ramp = "-2.5 m/s/h^2"
noise_density = "100 ug/√Hz"
sided = "two"
"""


def parse(tmp_path, text):
    path = tmp_path / "m.toml"
    path.write_text(text, encoding="utf-8")
    return NoiseModel.read(path)


def test_values_with_units(tmp_path):
    model = parse(tmp_path, MODEL)
    assert model.channels["gyro_x"] == pytest.approx(
        {
            "random_walk": math.radians(0.3) / 60,
            "bias_instability": math.radians(12) / 3600,
            "rate_random_walk": math.radians(20) / 3600 / 60,
        },
        rel=1e-15,
    )
    # A one-sided density is √2 larger than the two-sided one, whose root is the random walk.
    assert model.channels["gyro_y"]["random_walk"] == pytest.approx(math.radians(0.005) / math.sqrt(2), rel=1e-15)
    assert model.channels["accel_z"] == pytest.approx(
        {"quantization": 5e-4, "rate_ramp": -2.5 / 3600**2, "random_walk": 100e-6 * 9.80665}, rel=1e-15
    )
    assert "angle random walk 0.3 deg/√h" in repr(model)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "no channel"),
        ("[channels.gyro_x]", "no term"),
        ("[channel.gyro_x]\nrandom_walk = '1 deg/sqrt(h)'", "unknown key 'channel'"),
        ("channels = 3", "tables"),
        ("[channels.gyro_x]\narw = '1 deg/sqrt(h)'", "unknown term 'arw'"),
        ("[channels.gyro_x]\ngauss_markov = [{}]", r'lacks sigma and time; write { sigma = "1 deg/h", time = "1 s" }'),
        ("[channels.accel_x]\nsinusoid = 1", r'sinusoid = \[{ amplitude = "1 ug", frequency = "1 Hz" }\]'),
        ("[channels.gyro_x]\nrandom_walk = 0.1", r'random_walk = "1 deg/sqrt\(h\)"'),
        ("[channels.gyro_x]\nrate_random_walk = 0.1", r'rate_random_walk = "1 deg/h/sqrt\(h\)"'),
        ("[channels.accel_x]\nnoise_density = 0.1\nsided = 'one'", r'noise_density = "1 ug/sqrt\(Hz\)"'),
        ("[channels.gyro_x]\nrandom_walk = 0.3", "is not a value with a unit"),
        ("[channels.gyro_x]\nrandom_walk = '0.3'", "is not a value with a unit"),
        ("[channels.gyro_x]\nrandom_walk = '0.3 furlongs'", "unknown unit 'furlongs'"),
        ("[channels.gyro_x]\nrandom_walk = '0.3 deg/h'", "does not fit"),
        ("[channels.gyro_x]\nrandom_walk = '-0.3 deg/√h'", "positive"),
        ("[channels.gyro_x]\nrandom_walk = '1e999 deg/√h'", "positive"),
        ("[channels.gyro_x]\nnoise_density = '1 deg/s/√Hz'", "sided"),
        ("[channels.gyro_x]\nrandom_walk = '1 deg/√h'\nsided = 'one'", "belongs to noise_density"),
        (
            "[channels.gyro_x]\nrandom_walk = '1 deg/√h'\nnoise_density = '1 deg/s/√Hz'\nsided = 'two'",
            "same coefficient",
        ),
        ("[channels.mag_x]\nrandom_walk = '1 deg/√h'", "begin with gyro_ or accel_"),
        ("[channels.gyro_x", "not a TOML file"),
    ],
)
def test_wrong_model_files(tmp_path, text, words):
    with pytest.raises(DataError, match=r"m\.toml: .*" + words):
        parse(tmp_path, text)


def test_absent_model_file(tmp_path):
    with pytest.raises(DataError, match="No such file"):
        NoiseModel.read(tmp_path / "absent.toml")


class TestSimulate:
    model = NoiseModel(
        channels={"gyro_x": {"random_walk": 1e-4}, "accel_x": {"quantization": 1e-3, "random_walk": 1e-2}}
    )

    def test_seed(self):
        a, b, c = (simulate(self.model, duration=10, rate=100, rng=s) for s in (3, 3, 4))
        x = [r.streams[0].column("gyro_x") for r in (a, b, c)]
        assert np.array_equal(x[0], x[1])
        assert not np.array_equal(x[0], x[2])
        g = [simulate(self.model, duration=10, rate=100, rng=np.random.default_rng(5)) for _ in range(2)]
        assert np.array_equal(*(r.streams[1].column("accel_x") for r in g))

    def test_a_channel_does_not_depend_on_the_others(self):
        alone = NoiseModel(channels={"accel_x": self.model.channels["accel_x"]})
        a = simulate(alone, duration=10, rate=100, rng=1).streams[0].column("accel_x")
        b = simulate(self.model, duration=10, rate=100, rng=1).streams[1].column("accel_x")
        assert np.array_equal(a, b)

    @pytest.mark.parametrize(
        "wrong",
        [{"rate": 0}, {"rate": math.nan}, {"duration": -1}, {"duration": 0.03}, {"duration": 1e12}, {"rng": -1}],
    )
    def test_wrong_arguments(self, wrong):
        with pytest.raises(OptionError):
            simulate(self.model, **({"duration": 10, "rate": 100, "rng": 0} | wrong))

    def test_mean_avar_is_the_models(self):
        """Every term at once, 200 records: the mean at each octave within 4 standard errors."""
        coefficients = {
            "quantization": 1e-3,
            "random_walk": 4e-3,
            "bias_instability": 6e-3,
            "rate_random_walk": 3e-3,
            "rate_ramp": 1e-4,
        }
        model = NoiseModel(channels={f"gyro_{k}": coefficients for k in range(200)})
        curves = allan(simulate(model, duration=40.96, rate=50, rng=seed_of("every term at once")), taus="octave")
        got = np.array([c.avar for c in curves.values()])
        expected = model.avar("gyro_0", m=curves["gyro_0"].m, tau0=0.02)
        error = got.std(axis=0, ddof=1) / np.sqrt(len(got))
        assert (np.abs(got.mean(axis=0) - expected) <= 4 * error).all()

    def test_endings(self, tmp_path):
        with pytest.raises(OptionError, match=r"\.csv"):
            write(simulate(self.model, duration=1, rate=100, rng=1), tmp_path / "a.xlsx")


def test_the_demo_model_is_the_papers():
    from importlib import resources

    model = NoiseModel.read(str(resources.files("sigmatau.data") / "hg1700.toml"))
    assert model.channels["gyro_x"]["quantization"] == pytest.approx(to_si(5.1154, "arcsec"))
    # "2.119 m/s/h" in Table IV is a line read at √3 s: 2.119/3600 m/s
    assert model.channels["accel_x"]["quantization"] == pytest.approx(2.119 / 3600, rel=1e-4)
