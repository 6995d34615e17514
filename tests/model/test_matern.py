"""Matérn processes: autocovariance, density and Allan variance against Bessel functions; sums for filters; refusals."""

import json
import math

import numpy as np
import pytest
from scipy.special import gamma, kv

import sigmatau as st
from known import seed_of
from sigmatau import ChannelModel, DataError, GaussMarkov, Matern, NoiseModel
from sigmatau.cli import main
from sigmatau.exporting.export import prepare

SMOOTHNESS = (0.02, 0.1, 0.25, 0.4, 0.4999, 0.5)
TIMES = (0.02, 0.5, 30.0, 1e4)
TAU0 = 0.1


def autocovariance(t, time, smoothness):
    """The definition, with K of SciPy; 1 at the lag 0."""
    x = np.asarray(t, dtype=float) / time
    with np.errstate(invalid="ignore"):
        value = 2 ** (1 - smoothness) / gamma(smoothness) * x**smoothness * kv(smoothness, x)
    return np.where(x == 0, 1.0, value)


@pytest.mark.parametrize("smoothness", SMOOTHNESS)
@pytest.mark.parametrize("time", TIMES)
def test_autocovariance_is_the_bessel_function(time, smoothness):
    lags = np.array([0, 1, 2, 7, 40, 300, 5000])
    model = ChannelModel(matern=(Matern(sigma=2.0, time=time, smoothness=smoothness),))
    got = model.autocovariance(lags, tau0=TAU0)
    # Bessel functions of SciPy have about 1e-13; the sum 5e-15 of the variance.
    assert got == pytest.approx(4 * autocovariance(lags * TAU0, time, smoothness), abs=4e-12)


@pytest.mark.parametrize("smoothness", SMOOTHNESS)
@pytest.mark.parametrize("time", TIMES)
def test_allan_variance_is_that_of_the_autocovariance(time, smoothness):
    """Half the variance of the difference of two means of m samples, from all pairs of samples."""
    model = ChannelModel(matern=(Matern(sigma=1.0, time=time, smoothness=smoothness),))
    for m in (1, 3, 64):
        signs = np.repeat([1.0, -1.0], m)
        pairs = np.abs(np.subtract.outer(np.arange(2 * m), np.arange(2 * m)))
        # The sum of the structure function, which unlike that of the autocovariance does not cancel.
        structure = 1 - autocovariance(pairs * TAU0, time, smoothness)
        expected = -(signs @ structure @ signs) / (2 * m * m)
        # 1 − r loses the digits of r, 1e-13, over the size of the structure function.
        error = 1e-10 + 2e-12 / structure[0, 1]
        assert model.avar(m=[m], tau0=TAU0)[0] == pytest.approx(expected, rel=error), m


def test_allan_variance_is_the_integral_of_the_density():
    """4 ∫ S sin⁴(πfmτ₀)/(m sin πfτ₀)² df of the sampled density, by Gauss-Legendre in ln f: to 1e-10."""
    model = ChannelModel(matern=(Matern(sigma=1.0, time=3.0, smoothness=0.3),))
    nodes, weights = np.polynomial.legendre.leggauss(40)
    edges = np.concatenate([np.geomspace(1e-12, 1e-2, 60), np.linspace(1e-2, 0.5 / TAU0, 400)[1:]])
    middle, half = (edges[1:] + edges[:-1]) / 2, np.diff(edges) / 2
    f = (middle[:, None] + half[:, None] * nodes).ravel()
    w = (half[:, None] * weights).ravel()
    density = model.psd(f, tau0=TAU0)
    for m in (1, 4, 50):
        gain = np.sin(np.pi * f * m * TAU0) ** 4 / (m * np.sin(np.pi * f * TAU0)) ** 2
        assert model.avar(m=[m], tau0=TAU0)[0] == pytest.approx(4 * (w * density * gain).sum(), rel=1e-10), m


@pytest.mark.parametrize("smoothness", SMOOTHNESS)
def test_density_of_samples_is_the_sum_of_images(smoothness):
    """Poisson's sum of the density before sampling; the images above 2000 rates are an integral."""
    process = Matern(sigma=1.5, time=0.7, smoothness=smoothness)
    model = ChannelModel(matern=(process,))
    f = np.array([0.003, 0.2, 2.0, 4.9])
    k = np.arange(-2000, 2001)
    images = process.psd(f[:, None] + k / TAU0).sum(axis=1)
    # ∫ of the power law beyond, from half an image further on: (1 + x²)^−α is x^−2α to 1e-8 there.
    alpha = smoothness + 0.5
    level = process.psd(np.array([0.0]))[0] * (2 * np.pi * process.time) ** (-2 * alpha)
    ends = np.stack([2000.5 / TAU0 + f, 2000.5 / TAU0 - f])
    beyond = level * TAU0 * (ends ** (1 - 2 * alpha)).sum(axis=0) / (2 * alpha - 1)
    assert model.psd(f, tau0=TAU0) == pytest.approx(images + beyond, rel=1e-7)


def test_smoothness_of_one_half_is_the_gauss_markov_process():
    lags, m, f = np.arange(20), [1, 10, 100], np.array([0.01, 1.0, 4.0])
    matern = ChannelModel(matern=(Matern(sigma=3.0, time=2.0, smoothness=0.5),))
    markov = ChannelModel(gauss_markov=(GaussMarkov(sigma=3.0, time=2.0),))
    assert matern.psd(f) == pytest.approx(markov.psd(f), rel=1e-14)
    assert np.array_equal(matern.psd(f, tau0=TAU0), markov.psd(f, tau0=TAU0))
    assert np.array_equal(matern.avar(m=m, tau0=TAU0), markov.avar(m=m, tau0=TAU0))
    assert np.array_equal(matern.autocovariance(lags, tau0=TAU0), markov.autocovariance(lags, tau0=TAU0))
    assert matern.expand_matern(rate=10.0) == markov


@pytest.mark.parametrize("smoothness", SMOOTHNESS)
@pytest.mark.parametrize("time", TIMES)
def test_processes_of_filters_have_the_density(time, smoothness):
    """To the 0.01 % of the docstring, at all frequencies up to half the rate, and so has the Allan deviation."""
    model = ChannelModel(matern=(Matern(sigma=1.0, time=time, smoothness=smoothness),))
    expanded = model.expand_matern(rate=1 / TAU0)
    f, m = np.geomspace(1e-6, 0.5 / TAU0, 400), 2 ** np.arange(20)
    assert expanded.psd(f, tau0=TAU0) == pytest.approx(model.psd(f, tau0=TAU0), rel=1e-4)
    assert expanded.adev(m=m, tau0=TAU0) == pytest.approx(model.adev(m=m, tau0=TAU0), rel=1e-4)
    assert not expanded.matern


def test_expanded_model_is_a_linear_system():
    """The state space has the Allan variance of the process, with a bandwidth too."""
    process = Matern(sigma=1e-4, time=5.0, smoothness=0.2)
    bare = ChannelModel(terms={"random_walk": 1e-5}, matern=(process,))
    for model in (bare, ChannelModel(terms=bare.terms, matern=(process,), bandwidth=st.LowPass(order=1, corner=3.0))):
        system = st.state_space(model.expand_matern(rate=10.0), dt=TAU0)
        m = np.array([1, 8, 64, 512])
        assert np.sqrt(system.avar(m)) == pytest.approx(model.adev(m=m, tau0=TAU0), rel=2e-4)
        assert len(system.states) < 25


def test_systems_and_files_have_the_sum():
    """As those of the expanded model; the head of a file states it."""
    process = Matern(sigma=1e-4, time=0.2, smoothness=0.4)
    model = NoiseModel(channels={"gyro_z": ChannelModel(terms={"random_walk": 1e-5}, matern=(process,))})
    expanded = model.expand_matern(rate=100)
    f = np.geomspace(1e-3, 50, 20)
    assert st.arma(model["gyro_z"], dt=0.01).psd(f) == pytest.approx(model["gyro_z"].psd(f, tau0=0.01), rel=1e-3)
    error, same = (st.predict(each, after=[60], rate=100)["heading"].rms for each in (model, expanded))
    assert np.array_equal(error, same)
    choices = st.Choices(filter_rate=100)
    made, alike = (prepare(each, to="ieee952", choices=choices) for each in (model, expanded))
    (stated,) = [line for line in made.content.splitlines() if "sum of" in line]
    assert "Matern process is a sum of Gauss-Markov processes at 100 Hz" in stated
    assert [line for line in made.content.splitlines() if line != stated] == alike.content.splitlines()
    assert [finding.code for finding in made.findings if finding.channels] == ["matern_as_processes"]
    assert st.export(model, to="state-space", choices=choices) == st.export(expanded, to="state-space", choices=choices)
    assert "matern" in st.export(model, to="model")
    curves = st.allan(st.simulate(model, duration=100, rate=100, rng=seed_of("matern verify")))
    assert st.verify(model, curves)["gyro_z"].p_value > 1e-3
    alone = NoiseModel(channels={"gyro_z": ChannelModel(matern=(process,))})
    curves = st.allan(st.simulate(alone, duration=100, rate=100, rng=seed_of("matern alone")))
    assert st.verify(alone, curves)["gyro_z"].p_value > 1e-3


def test_commands_count_or_refuse_the_process(tmp_path, capsys):
    """`predict` counts it and states how; `plan` refuses the channel that has one, in Python too."""
    file = tmp_path / "model.toml"
    rows = (
        'gyro_x]\nrandom_walk = "0.1 deg/sqrt(h)"\nmatern = [{ sigma = "9 deg/h", time = "10 min", smoothness = 0.2 }]',
        'gyro_y]\nrandom_walk = "0.1 deg/sqrt(h)"',
    )
    file.write_text("\n".join(f"[channels.{row}" for row in rows), encoding="utf-8")
    assert main(["predict", str(file), "--after", "60s", "--json"]) == 0
    out, err = capsys.readouterr()
    assert err.strip() == "gyro_x: a Matérn process counts as the sum of Gauss-Markov processes that it is"
    assert set(json.loads(out)["errors"]) >= {"roll", "pitch"}
    plan = ["plan", str(file), "--term", "rate_random_walk", "--hours", "2", "--rate", "10"]
    assert main(plan) == 2
    assert "gyro_x: planning does not count a Matérn process. Give a Gauss-Markov process" in capsys.readouterr().err
    assert main([*plan, "--channels", "gyro_y"]) == 0
    assert "gyro_y: rate random walk" in capsys.readouterr().out
    channel = NoiseModel.read(file)["gyro_x"]
    kind = {"channel": "gyro_x", "quantity": "angular_rate", "rate_unit": "rad/s"}
    with pytest.raises(st.OptionError, match="a Matérn process, which planning does not count"):
        st.plan(channel, "rate_random_walk", rate=10, duration=7200, **kind)


def test_range_of_the_smoothness():
    for wrong in (0.0, 0.019, 0.51, math.nan, "0.3", True):
        with pytest.raises(DataError, match="smoothness"):
            Matern(sigma=1.0, time=1.0, smoothness=wrong)


def test_model_file_has_the_smoothness_without_a_unit():
    process = Matern(sigma=1e-4, time=5.0, smoothness=0.2)
    model = NoiseModel(channels={"gyro_x": ChannelModel(matern=(process,))})
    assert "smoothness = 0.2 }" in model.to_toml()
    assert NoiseModel.from_dict({"channels": {"gyro_x": {"matern": [_table("0.3 deg/h", 0.2)]}}})
    for wrong in ("0.2", "0.2 s", True, None):
        with pytest.raises(DataError, match="a number without a unit, smoothness"):
            NoiseModel.from_dict({"channels": {"gyro_x": {"matern": [_table("0.3 deg/h", wrong)]}}})
    whole = _table("1 deg/h", 0.2)
    for row, words in (
        ({part: whole[part] for part in ("sigma", "time")}, r"matern lacks smoothness; write \{ sigma = .*= 0.3 \}"),
        ({"smoothness": 0.2}, "matern lacks sigma and time"),
        (whole | {"nu": 0.2}, "matern has an unknown part 'nu'"),
        (whole | {"smoothness": 0.7}, "must be a number from 0.02 to 0.5, not 0.7"),
        (whole | {"smoothness": 0}, "must be a number from 0.02 to 0.5, not 0"),
    ):
        with pytest.raises(DataError, match=words):
            NoiseModel.from_dict({"channels": {"gyro_x": {"matern": [row]}}})
    with pytest.raises(DataError, match=r"matern is a list, matern = \[.*smoothness = 0.3 \}\]"):
        NoiseModel.from_dict({"channels": {"gyro_x": {"matern": "9 deg/h"}}})


def _table(sigma, smoothness):
    return {"sigma": sigma, "time": "10 min", "smoothness": smoothness}


def test_minimum_of_the_curve_includes_the_process():
    """Against the curve of samples at a high rate."""
    from sigmatau.model.minimum import min_adev

    terms = {"random_walk": 1.0, "rate_random_walk": 0.5}
    model = ChannelModel(terms=terms, matern=(Matern(sigma=3.0, time=20.0, smoothness=0.3),))
    lowest, tau = min_adev(terms, model)
    near = np.round(np.geomspace(0.5, 2, 41) * tau / 1e-3).astype(int)
    assert model.adev(m=near, tau0=1e-3).min() == pytest.approx(lowest, rel=1e-3)
