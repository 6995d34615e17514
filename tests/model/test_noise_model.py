"""Noise models: files to the same bits, and what is refused, with channel and key."""

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as some

import sigmatau as st
from sigmatau import ChannelModel, DataError, GaussMarkov, LowPass, Matern, NoiseModel, OptionError, Sinusoid
from sigmatau.noise.terms import TERMS

positive = some.floats(1e-100, 1e100)
names = some.text(some.characters(codec="utf-8", exclude_categories=["Cc", "Cs"]), min_size=1, max_size=12)


@some.composite
def channels(draw):
    terms = draw(some.dictionaries(some.sampled_from(sorted(TERMS)), positive, min_size=1))
    return ChannelModel(
        terms=terms,
        gauss_markov=tuple(draw(some.lists(some.builds(GaussMarkov, sigma=positive, time=positive), max_size=2))),
        matern=tuple(
            draw(
                some.lists(
                    some.builds(Matern, sigma=positive, time=positive, smoothness=some.floats(0.02, 0.5)), max_size=2
                )
            )
        ),
        sinusoid=tuple(draw(some.lists(some.builds(Sinusoid, amplitude=positive, frequency=positive), max_size=2))),
        bandwidth=draw(some.none() | some.builds(LowPass, order=some.integers(1, 9), corner=some.floats(1e-9, 1e12)))
        if "random_walk" in terms
        else None,
    )


@settings(deadline=None, max_examples=20)
@given(some.dictionaries(names.map("gyro_".__add__), channels(), min_size=1, max_size=3))
def test_a_model_file_reads_back_to_the_same_bits(tmp_path_factory, given_channels):
    model = NoiseModel(channels=given_channels)
    path = tmp_path_factory.mktemp("models") / "model.toml"
    model.write(path)
    assert NoiseModel.read(path) == model


def test_correlations_read_back(tmp_path):
    walk = {"random_walk": 1.0}
    model = NoiseModel(
        channels={"gyro_x": walk, "gyro_y": walk}, correlation={"random_walk": {("gyro_x", "gyro_y"): 0.1 + 0.2}}
    )
    model.write(tmp_path / "m.toml")
    assert NoiseModel.read(tmp_path / "m.toml") == model


@pytest.mark.parametrize(("sided", "expected"), [("two", 1.0), ("one", 2**-0.5)])
def test_noise_density(sided, expected):
    table = {"noise_density": "1 (rad/s)/√Hz", "sided": sided}
    model = NoiseModel.from_dict({"channels": {"gyro_x": table}})
    assert model.channels["gyro_x"]["random_walk"] == pytest.approx(expected, rel=1e-15)


def test_correlations_that_contradict():
    walk = {"random_walk": 1.0}
    pairs = {("gyro_x", "gyro_y"): 0.9, ("gyro_y", "gyro_z"): 0.9, ("gyro_x", "gyro_z"): -0.9}
    with pytest.raises(DataError, match="contradict"):
        NoiseModel(channels=dict.fromkeys(("gyro_x", "gyro_y", "gyro_z"), walk), correlation={"random_walk": pairs})


WRONG = {
    "nan": ('[channels.gyro_x]\nrandom_walk = "nan deg/√h"', ["gyro_x", "random_walk"]),
    "bool": ("[channels.gyro_x]\nrandom_walk = true", ["gyro_x", "random_walk"]),
    "list": ("[channels.gyro_x]\nbias_instability = [[1]]", ["gyro_x", "bias_instability"]),
    "table": ("[channels.gyro_x.gauss_markov.a.b]\nc = 1", ["gyro_x", "gauss_markov"]),
    "bool order": (
        '[channels.gyro_x]\nrandom_walk = "1 deg/√h"\nbandwidth = {order = true, corner = "1 Hz"}',
        ["gyro_x", "order"],
    ),
    "no side": ('[channels.gyro_x]\nnoise_density = "1 mdps/√Hz"', ["gyro_x", "noise_density", "sided"]),
    "deep": ("a = " + "[" * 100_000, []),
    "channels is a number": ("channels = 3", ["channels"]),
    "correlation is text": (
        '[channels.gyro_x]\nrandom_walk = "1 deg/√h"\n[correlation]\nrandom_walk = "x"',
        ["correlation"],
    ),
}


@pytest.mark.parametrize("case", WRONG)
def test_wrong_files_say_channel_and_key(case, tmp_path):
    text, words = WRONG[case]
    path = tmp_path / "model.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises((DataError, OptionError)) as caught:
        NoiseModel.read(path)
    assert all(word in str(caught.value) for word in [str(path), *words])


@pytest.mark.parametrize("content", [b"\x00\xff\xfe" * 50, b"", b"[" * 100_000, b"[]", b"3", b'{"channels": 3}'])
@pytest.mark.parametrize("ending", ["json", "toml"])
def test_what_is_no_model(content, ending, tmp_path):
    path = tmp_path / f"m.{ending}"
    path.write_bytes(content)
    with pytest.raises((DataError, OptionError)):
        NoiseModel.read(path)


def test_model_of_an_analysis(tmp_path):
    model = NoiseModel.from_dict({"channels": {"gyro_x": {"random_walk": "5 mdps/√Hz"}}})
    analysis = st.analyze(st.simulate(model, duration=600, rate=100, rng=1))
    found = analysis.model
    assert found["gyro_x"]["random_walk"] > 0
    path = tmp_path / "r.json"
    path.write_text(json.dumps(analysis.to_dict()))
    assert st.Analysis.from_json(path).model == found


class TestMappingOfChannels:
    MODEL = NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}, "accel_x": {"random_walk": 1e-3}})

    def test_subscripts(self):
        assert self.MODEL["gyro_x"] is self.MODEL.channels["gyro_x"]
        assert list(self.MODEL) == ["gyro_x", "accel_x"]
        assert len(self.MODEL) == 2
        assert "gyro_y" not in self.MODEL
        with pytest.raises(KeyError, match="no channel 'gyro_y'; channels: gyro_x, accel_x"):
            self.MODEL["gyro_y"]

    @pytest.mark.parametrize("name", ["state_space", "arma"])
    def test_functions_of_one_channel_refuse_a_model_of_several(self, name):
        function = getattr(st, name)
        with pytest.raises(OptionError, match=rf"2 channels.*{name}\(model\['gyro_x'\]"):
            function(self.MODEL, dt=0.01)
        with pytest.raises(OptionError, match=r'must be a ChannelModel, not dict; .* analysis\.model\["gyro_x"\]'):
            function({"random_walk": 1e-4}, dt=0.01)


def test_density_of_samples_ends_at_half_their_rate():
    walk = ChannelModel(terms={"rate_random_walk": 1.0})
    assert walk.psd([50.0, 0.5 / 0.01 * (1 + 1e-12)], tau0=0.01) == pytest.approx(0.01**2 / 4, rel=1e-9)
    with pytest.raises(OptionError, match=r"at most 1/\(2·tau0\), 50 Hz, not 100"):
        walk.psd([1.0, 100.0], tau0=0.01)
    assert walk.psd([100.0]) == pytest.approx((1 / (2 * np.pi * 100.0)) ** 2)
