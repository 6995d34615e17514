"""Processes in place of terms: a process is no term, and what a record does not tell apart is stated."""

import math

import numpy as np
import pytest

from known import seed_of
from sigmatau import ChannelModel, GaussMarkov, NoiseModel, Record, fit_channel, predict, simulate
from sigmatau.fitting.fitted_values import SecondModel
from sigmatau.model.numbers import adev_interval

N = 1e-4
RATE, DURATION = 10.0, 3600.0
COUNT = 10


def process(time, ratio):
    """A process whose density at frequency 0 is `ratio` times that of the white noise."""
    return GaussMarkov(sigma=N * math.sqrt(ratio / (2 * time)), time=time)


def fits(name, **noise):
    model = NoiseModel(channels={"gyro_x": ChannelModel(**noise)})
    rng = np.random.default_rng(seed_of(f"second explanations, {name}"))
    for _ in range(COUNT):
        yield fit_channel(simulate(model, duration=DURATION, rate=RATE, rng=rng), "gyro_x")


def most(share):
    """A share of the records and three standard errors."""
    return COUNT * share + 3 * math.sqrt(COUNT * share * (1 - share))


@pytest.mark.parametrize(("time", "ratio"), [(10.0, 1), (100.0, 5)])
def test_a_process_is_no_bias_instability(time, ratio):
    """Before processes were fitted in its place, 40 to 80 % of such records had one whose interval excluded 0."""
    false = sum(
        fit["bias_instability"].observed
        for fit in fits(f"{time:g}", terms={"random_walk": N}, gauss_markov=(process(time, ratio),))
    )
    assert false <= most(0.05)


def test_flicker_noise_is_observed():
    observed, covered = 0, 0
    for fit in fits("flicker", terms={"random_walk": N, "bias_instability": 5e-5}):
        term = fit["bias_instability"]
        observed += term.observed
        covered += term.observed and term.low <= 5e-5 <= term.high
    assert observed >= COUNT - most(0.03)
    assert covered >= observed - most(0.06)


def test_rate_random_walk_is_observed():
    """It gives way to a process that is better beyond chance: 92 to 98 % are observed, of 98 % without processes."""
    walks = [fit["rate_random_walk"] for fit in fits("walk", terms={"random_walk": N, "rate_random_walk": 5e-6})]
    assert sum(walk.observed for walk in walks) >= COUNT - most(0.07)
    assert sum((walk.low or 0.0) <= 5e-6 <= (walk.high or walk.upper_limit) for walk in walks) >= COUNT - most(0.06)


def test_both_slow_terms_are_observed():
    """Without other explanations 100 and 93 % of them were."""
    terms = {"random_walk": N, "bias_instability": 5e-5, "rate_random_walk": 5e-6}
    several = list(fits("both", terms=terms))
    assert sum(fit["bias_instability"].observed for fit in several) >= COUNT - most(0.05)
    assert sum(fit["rate_random_walk"].observed for fit in several) >= COUNT - most(0.23)


def test_a_process_that_is_a_little_better_is_named():
    """The rate random walk stays observed, with a lower end nearer to 0; the process is in the model and in the curve."""
    stays = 0
    for fit in fits("named", terms={"random_walk": N, "rate_random_walk": 5e-6}):
        walk = fit["rate_random_walk"]
        others = [second for second in fit.second if "rate_random_walk" not in second.terms]
        if not (walk.observed and others):
            continue
        stays += 1
        assert 0.0 < walk.low < walk.value
        low, high = adev_interval(fit.to_model(), m=[9000], tau0=0.1)
        assert all(low <= math.sqrt(other.avar(m=[9000], tau0=0.1)[0]) <= high for other in fit.to_model().alternatives)
    assert stays


@pytest.mark.parametrize("time", [2000])
def test_a_warm_up_is_no_rate_random_walk(time):
    """Without warm-ups in its place, a quarter of such records had one; with those up to a third of the record, 14 %."""
    model = NoiseModel(channels={"gyro_x": {"random_walk": N, "bias_instability": 5e-5}})
    rng = np.random.default_rng(seed_of(f"second explanations, warm-up {time}"))
    drift = 2e-4 * np.exp(-np.arange(round(RATE * DURATION)) / (RATE * time))
    false, named = 0, 0
    for _ in range(COUNT):
        x = simulate(model, duration=DURATION, rate=RATE, rng=rng).streams[0].column("gyro_x")
        fit = fit_channel(Record.from_arrays(rate=RATE, gyro_x=x + drift, unit={"gyro": "rad/s"}), "gyro_x")
        false += fit["rate_random_walk"].observed
        named += any(second.warm_up is not None for second in fit.second)
    assert false <= most(0.05)
    assert named > 0


@pytest.mark.parametrize(
    ("term", "value", "sigma", "time", "limit"),
    [("bias_instability", 5e-5, 3.6e-5, 20.0, 0.12), ("rate_random_walk", 5e-6, 5e-5, 100.0, 0.22)],
)
def test_interval_holds_a_term_beside_a_weak_process(term, value, sigma, time, limit):
    """Joined only with processes that gain 6, the intervals held B in 71 and K in 53 % of the records; now 88 and 78.

    A rate random walk that gives way to any process holds the truth in 83 %, and is then observed in 78 % where it is alone.
    """
    missed = 0
    noise = {"terms": {"random_walk": N, term: value}, "gauss_markov": (GaussMarkov(sigma=sigma, time=time),)}
    for fit in fits(f"weak process of {time:g}", **noise):
        quantity = fit[term]
        high = quantity.high if quantity.observed else quantity.upper_limit
        missed += not (quantity.low or 0.0) <= value <= high
        # A rate random walk that a process opens to 0 has the process named.
        assert term != "rate_random_walk" or quantity.observed or not quantity.value or fit.second
    assert missed <= most(limit)


def power_law(exponent, flicker):
    """Processes, three in a decade, that add up to a density of f^−exponent; at 0.01 Hz that of a bias instability."""
    times = 10 ** np.arange(-0.5, 6.0, 1 / 3)
    weight = (0.02 * math.pi) ** (exponent - 1) * math.sin(0.5 * math.pi * exponent) / math.pi * math.log(10) / 3
    variances = flicker**2 * weight * times ** (exponent - 1)
    return tuple(GaussMarkov(sigma=math.sqrt(v), time=t) for v, t in zip(variances, times, strict=True))


@pytest.mark.parametrize(("exponent", "covered", "false"), [(0.8, 0.12, 0.05), (1.2, 0.3, 0.1), (1.5, 0.12, 0.2)])
def test_other_exponents_are_in_the_interval(exponent, covered, false):
    """With the exponent 1 alone N is covered in 48, 77 and 92 %, and a rate random walk is observed in 0, 53 and 78 %.

    An hour seldom shows that 1.2 is not 1: allowing for it always would make the intervals of clean records twice as wide.
    """
    missed, walks, named = 0, 0, 0
    for fit in fits(f"exponent {exponent}", terms={"random_walk": N}, gauss_markov=power_law(exponent, 5e-5)):
        white = fit["random_walk"]
        missed += not white.low <= N <= white.high
        walks += fit["rate_random_walk"].observed
        exponents = [second.exponent for second in fit.second if second.exponent is not None]
        named += any(abs(found - exponent) < 0.3 for found in exponents)
    assert missed <= most(covered)
    assert walks <= most(false)
    assert named > COUNT / 4


def test_second_model_is_in_the_interval_and_in_the_prediction():
    """A weak flicker noise may be a process: the interval of the term begins at 0, and curve and prediction hold both."""
    several = [fit for fit in fits("weak", terms={"random_walk": N, "bias_instability": 1e-5}) if fit.second]
    assert several
    for fit in several:
        for second in fit.second:
            for term in set(fit.model) - set(second.terms):
                assert not fit[term].observed
        model = fit.to_model()
        assert len(model.alternatives) == len(fit.second)
        m = np.array([10, 100, 1000, 9000])
        low, high = adev_interval(model, m=m, tau0=0.1)
        for other in model.alternatives:
            adev = np.sqrt(other.avar(m=m, tau0=0.1))
            assert np.all((low < adev) & (adev < high))


def test_prediction_holds_other_models():
    walk = {"random_walk": N}
    other = ChannelModel(terms=walk, gauss_markov=(GaussMarkov(sigma=1e-4, time=100.0),))
    one = ChannelModel(terms={**walk, "bias_instability": 5e-5})
    both = ChannelModel(terms=one.terms, alternatives=(other,))
    heading = {
        name: predict(NoiseModel(channels={"gyro_z": model}), after=[60.0, 600.0], rate=10)["heading"]
        for name, model in {"one": one, "other": other, "both": both}.items()
    }
    np.testing.assert_array_equal(heading["both"].rms, heading["one"].rms)
    np.testing.assert_allclose(heading["both"].low, np.minimum(heading["one"].rms, heading["other"].rms))
    np.testing.assert_allclose(heading["both"].high, np.maximum(heading["one"].rms, heading["other"].rms))


def test_other_models_in_a_model_file(tmp_path):
    other = ChannelModel(terms={"random_walk": N}, gauss_markov=(GaussMarkov(sigma=1e-5, time=50.0),))
    model = NoiseModel(
        channels={"gyro_x": ChannelModel(terms={"random_walk": N, "bias_instability": 1e-5}, alternatives=(other,))}
    )
    model.write(tmp_path / "m.toml")
    back = NoiseModel.read(tmp_path / "m.toml").channels["gyro_x"]
    assert back.alternatives == (other,)
    assert back.scaled(2.0).alternatives[0].gauss_markov[0].sigma == 2e-5


def test_words_name_the_process():
    (fit,) = (
        fit
        for fit in [
            next(
                iter(
                    f
                    for f in fits("weak", terms={"random_walk": N, "bias_instability": 1e-5})
                    if "bias_instability" in f.unclear and f.second
                )
            )
        ]
    )
    assert isinstance(fit.second[0], SecondModel)
    assert "or a Gauss-Markov process of" in repr(fit)
    assert fit.why_not("bias_instability") == "a Gauss-Markov process explains the record as well"
