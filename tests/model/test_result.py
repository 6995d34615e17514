"""Models from results of `analyze`: what is in them, what is kept beside them, and what is no result."""

import json
from dataclasses import replace

import numpy as np
import pytest

from known import seed_of
from sigmatau import Analysis, DataError, NoiseModel, Record, analyze, simulate
from sigmatau.digits import round_to_error
from sigmatau.fitting.noise_fit import Fits
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
        assert not set(model.limits) & set(model.intervals)
        assert model.covariance.names == fitted.covariance.names
        np.testing.assert_array_equal(model.covariance.matrix, fitted.covariance.matrix)
        assert (model.tau_min, model.duration) == (fitted.tau_min, 3000.0)

    def test_json_and_result_are_the_same_model(self, tmp_path):
        analysis = result_of({"random_walk": 1e-3, "bias_instability": 2e-4})
        path = tmp_path / "r.json"
        path.write_text(json.dumps(analysis.to_dict()))
        assert Analysis.from_json(path).model == NoiseModel.from_result(analysis) == analysis.model

    def test_written_as_a_file_nothing_vanishes_silently(self, tmp_path):
        model = result_of({"random_walk": 1e-3, "rate_random_walk": 3e-5}).model
        model.write(tmp_path / "m.toml")
        text = (tmp_path / "m.toml").read_text(encoding="utf-8")
        channel = model.channels["gyro_x"]
        assert channel.limits
        for term, limit in channel.limits.items():
            start = f"{term} = " if term in channel else f"# {term}: not seen"
            (line,) = (row for row in text.splitlines() if row.startswith(start))
            assert f" = {limit:.2g} {channel.unit_of(term)}, 95 % limit" in line
        for term, (low, high) in channel.intervals.items():
            (line,) = (row for row in text.splitlines() if row.startswith(f"{term} = "))
            unit, factor = display_units(term, "angular_rate", "rad/s")[0]
            number = round_to_error(channel.terms[term] / factor, low / factor, high / factor).text
            assert line.endswith(f"# {number} {unit}, 95 % interval")
        assert "correlation of the errors of random_walk, rate_random_walk" in text
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
        _ = analyze(record, at_rest=True).model


def test_json_is_no_model_file(tmp_path):
    path = tmp_path / "r.json"
    path.write_text("{}")
    with pytest.raises(
        DataError, match=r"r\.json: not a model file \(\.toml\)\. If this is a result: Analysis\.from_json"
    ):
        NoiseModel.read(path)


def test_an_error_names_the_channel_and_channels_without_a_model_are_left_out():
    analysis = result_of({"random_walk": 1e-3})
    fit = analysis["gyro_x"]
    short = replace(fit, channel="gyro_y", model={}, verdict="too_short")
    assert list(replace(analysis, fits=Fits({"gyro_x": fit, "gyro_y": short})).model) == ["gyro_x"]
    wrong = replace(fit, model={"random_walk": -1.0})
    with pytest.raises(DataError, match=r"channel 'gyro_x': .*random_walk"):
        _ = replace(analysis, fits=Fits({"gyro_x": wrong})).model
    with pytest.raises(DataError, match="too_short"):
        short.to_model()


def test_coefficients_that_were_read_off_are_no_model():
    model = NoiseModel(channels={"gyro_x": {"random_walk": 1e-3}})
    analysis = analyze(simulate(model, duration=60.0, rate=20.0, rng=1), method="read-off")
    with pytest.raises(DataError, match="only read off; a model needs a fit"):
        _ = analysis.model
