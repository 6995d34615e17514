"""Models from results of `analyze`: what is in them, what is kept beside them, and what is no result."""

import json

import numpy as np
import pytest

from known import seed_of
from sigmatau import DataError, NoiseModel, Record, analyze, simulate
from sigmatau.model.channel import ChannelModel
from sigmatau.model.processes import GaussMarkov
from sigmatau.noise.terms import display_units


def result_of(noise, *, duration=3000.0, rate=20.0, name="case"):
    model = NoiseModel(channels={"gyro_x": noise})
    return analyze(simulate(model, duration=duration, rate=rate, rng=seed_of(f"model of a result, {name}")))


class TestAdequate:
    def test_observed_terms_are_in_it_and_limits_beside_it(self):
        analysis = result_of({"random_walk": 1e-3, "rate_random_walk": 3e-5})
        fitted = analysis.fits["gyro_x"]
        model = analysis.model.channels["gyro_x"]
        assert dict(model) == dict(fitted.model)
        for term, interval in model.intervals.items():
            assert interval == (fitted[term].low, fitted[term].high)
        assert set(model.limits) == {name for name, term in fitted.items() if term.upper_limit is not None}
        assert not set(model.limits) & set(model)
        assert model.covariance[0] == fitted.covariance[0]
        np.testing.assert_array_equal(model.covariance[1], fitted.covariance[1])
        assert (model.tau_min, model.duration) == (fitted.tau_min, 3000.0)

    def test_json_and_result_are_the_same_model(self, tmp_path):
        analysis = result_of({"random_walk": 1e-3, "bias_instability": 2e-4})
        path = tmp_path / "r.json"
        path.write_text(json.dumps(analysis.to_dict()))
        assert NoiseModel.read(path) == analysis.model

    def test_written_as_a_file_nothing_vanishes_silently(self, tmp_path):
        model = result_of({"random_walk": 1e-3, "rate_random_walk": 3e-5}).model
        model.write(tmp_path / "m.toml")
        text = (tmp_path / "m.toml").read_text(encoding="utf-8")
        channel = model.channels["gyro_x"]
        assert channel.limits
        for term, limit in channel.limits.items():
            (line,) = (row for row in text.splitlines() if row.startswith(f"# {term}: not seen"))
            assert f" = {limit:.2g} {channel.unit_of(term)}, 95 % limit" in line
        for term, (low, high) in channel.intervals.items():
            (line,) = (row for row in text.splitlines() if row.startswith(f"{term} = "))
            unit, factor = display_units(term, "angular_rate", "rad/s")[0]
            shown = [float(x) for x in line.split("[")[1].split("]")[0].split(",")]
            # Half the interval has two digits.
            assert shown == pytest.approx([low / factor, high / factor], abs=0.026 * (high - low) / factor)
            assert line.endswith(f"] {unit}, 95 % interval")
        assert "errors of random_walk, rate_random_walk go together" in text
        back = NoiseModel.read(tmp_path / "m.toml").channels["gyro_x"]
        assert dict(back) == dict(channel)
        assert not back.limits

    def test_it_describes_the_curve(self):
        analysis = result_of({"quantization": 1e-4, "random_walk": 1e-3})
        fitted, curve = analysis.fits["gyro_x"], analysis.curves["gyro_x"]
        np.testing.assert_allclose(
            analysis.model.avar("gyro_x", m=curve.m, tau0=curve.tau0), fitted.avar(m=curve.m), rtol=1e-12
        )

    def test_a_process(self):
        noise = ChannelModel(terms={"random_walk": 1e-3}, gauss_markov=(GaussMarkov(sigma=3e-3, time=5.0),))
        analysis = result_of(noise, name="process")
        (process,) = analysis.fits["gyro_x"].gauss_markov
        (found,) = analysis.model.channels["gyro_x"].gauss_markov
        assert (found.sigma, found.time) == (process.sigma.value, process.time.value)
        assert found.time == pytest.approx(5.0, rel=0.3)


def test_a_short_record_has_no_model():
    record = Record.from_arrays(rate=100, gyro_x=np.random.default_rng(1).standard_normal(12), unit={"gyro": "rad/s"})
    with pytest.raises(DataError, match="no channel of this result has a model"):
        NoiseModel.from_result(analyze(record, at_rest=True).to_dict())


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("{}", "it has no channels"),
        ("[]", "a result of sigmatau analyze is an object, not list"),
        ("null", "a result of sigmatau analyze is an object, not NoneType"),
        ('{"channels": 3}', "it has no channels"),
        ('{"channels": {"gyro_x": 3}}', "channel 'gyro_x': not a result"),
        ('{"channels": {"gyro_x": {"fit": {"model": {}}}}}', "channel 'gyro_x': not a result"),
        ("{", "no JSON"),
        ("[" * 100_000, "no JSON"),
        ("\x00", "no JSON"),
    ],
)
def test_what_is_no_result(tmp_path, content, words):
    path = tmp_path / "r.json"
    path.write_text(content)
    with pytest.raises(DataError, match=r"r\.json: .*" + words):
        NoiseModel.read(path)


def test_one_channel_is_asked_for():
    content = result_of({"random_walk": 1e-3}).to_dict()
    with pytest.raises(DataError, match="no channel 'gyro_q'; channels: gyro_x"):
        NoiseModel.from_result(content, channels=["gyro_q"])


def test_an_error_names_the_channel_and_one_asked_for_must_have_a_model():
    content = result_of({"random_walk": 1e-3}).to_dict()
    fit = content["channels"]["gyro_x"]["fit"]
    wrong = {**fit, "model": {"random_walk": float("nan")}}
    with pytest.raises(DataError, match=r"channel 'gyro_x': .*random_walk"):
        NoiseModel.from_result({"channels": {"gyro_x": {**content["channels"]["gyro_x"], "fit": wrong}}})
    none = {**fit, "model": {}, "verdict": "too_short"}
    short = {**content["channels"]["gyro_x"], "fit": none}
    both = {"channels": {**content["channels"], "gyro_y": short}}
    assert list(NoiseModel.from_result(both).channels) == ["gyro_x"]
    with pytest.raises(DataError, match="channel 'gyro_y' has no model: its fit is 'too_short'"):
        NoiseModel.from_result(both, channels=["gyro_x", "gyro_y"])


DAMAGES = {
    "level true": (lambda fit: fit["terms"]["random_walk"].update(level=True), "the level of an interval .* not True"),
    "level 2": (lambda fit: fit["terms"]["random_walk"].update(level=2), "the level of an interval .* not 2"),
    "no covariance names": (lambda fit: fit["covariance"].update(terms=[{}]), "covariance must be names"),
    "a coefficient that is true": (
        lambda fit: fit["model"].update(random_walk=True),
        "random_walk must be a number, not True",
    ),
    "a bound that is true": (
        lambda fit: fit["terms"]["random_walk"].update(low=True),
        "low must be a number, not True",
    ),
    "a limit that is NaN": (
        lambda fit: fit["terms"]["rate_ramp"].update(upper_limit=float("nan")),
        "upper_limit must be",
    ),
    "no verdict": (lambda fit: fit.pop("verdict"), "verdict of its fit is None"),
    "a verdict of null": (lambda fit: fit.update(verdict=None), "verdict of its fit is None"),
    "an unknown verdict": (
        lambda fit: fit.update(verdict="Adequate"),
        "verdict of its fit is 'Adequate'; .* adequate.* or descr",
    ),
    "a verdict that is a list": (lambda fit: fit.update(verdict=["adequate"]), "verdict of its fit is"),
}


@pytest.fixture(scope="module")
def whole():
    return result_of({"random_walk": 1e-3}, duration=300.0, name="to be damaged").to_dict()


@pytest.mark.parametrize("case", DAMAGES)
def test_damaged_results_are_refused(case, whole):
    damage, words = DAMAGES[case]
    content = json.loads(json.dumps(whole))
    assert "random_walk" in NoiseModel.from_result(content)["gyro_x"]
    damage(content["channels"]["gyro_x"]["fit"])
    with pytest.raises(DataError, match=f"channel 'gyro_x': .*{words}"):
        NoiseModel.from_result(content)


def test_coefficients_that_were_read_off_are_no_model():
    model = NoiseModel(channels={"gyro_x": {"random_walk": 1e-3}})
    analysis = analyze(simulate(model, duration=60.0, rate=20.0, rng=1), method="read-off")
    with pytest.raises(DataError, match="only read off; a model needs a fit"):
        NoiseModel.from_result(analysis.to_dict())
