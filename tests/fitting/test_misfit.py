"""The floor of a fit: of a record that no model describes, the random walk alone has an interval, and the trust is poor."""

import json

import numpy as np
import pytest

from known import seed_of
from sigmatau import Analysis, NoiseModel, Record, analyze
from sigmatau.model.numbers import adev_interval

RATE, WALK = 50.0, 1e-3 / np.sqrt(50.0)


def stepped(below, per_octave, factor):
    """Gains of white noise whose density jumps between two levels, below a frequency, as no model of the five terms does."""
    return lambda f: np.where((f < below) & (np.floor(per_octave * np.log2(f)) % 2 == 0), factor, 1.0)


# Gains, and the random walk: of the level above the steps, and of the mean of both levels where a filter is fitted to them.
KINDS = {
    "slow steps": (stepped(1.0, 2, 3.0), WALK),
    "steps": (stepped(3.0, 2, 1.8), WALK),
    "filtered": (stepped(6.0, 3, 0.7), WALK * np.sqrt((1 + 0.7**2) / 2)),
}


@pytest.fixture(scope="module", params=KINDS)
def case(request):
    """Two analyses of a kind, and its random walk."""
    gain, walk = KINDS[request.param]
    found = []
    for k in range(2):
        white = np.random.default_rng(seed_of(f"misfit {request.param} {k}")).standard_normal(60_000)
        f = np.fft.rfftfreq(len(white), 1 / RATE)
        f[0] = f[1]
        y = np.fft.irfft(np.fft.rfft(white) * gain(f), len(white))
        found.append(analyze(Record.from_arrays(rate=RATE, gyro_x=1e-3 * y, unit={"gyro": "rad/s"})))
    return found, walk


def test_only_the_random_walk_has_an_interval(case):
    """Its interval holds the level of the white noise, also where a filter is fitted to the misfit."""
    analyses, truth = case
    for analysis in analyses:
        fitted = analysis["gyro_x"]
        assert fitted.p_value < 1e-6
        assert fitted.trust == "poor"
        walk = fitted["random_walk"]
        assert walk.low < truth < walk.high
        for name, term in fitted.items():
            if name != "random_walk":
                assert (term.observed, term.value, term.low, term.high) == (False, None, None, None), name
                assert (term.upper_limit, term.p_value) == (None, None), name
        assert all(one.time.low is one.sigma.high is None for one in fitted.gauss_markov)
        assert fitted.covariance.names == ("random_walk",)
        (finding,) = (one for one in analysis.findings if one.code == "widened")
        assert finding.details.only_walk
        assert "no model fits: only the random walk has an interval" in fitted.headline()
        assert str(fitted).count("unknown: the model does not fit") == len(fitted) - 1


def test_the_model_describes_the_curve_without_limits(case):
    for analysis in case[0]:
        channel = NoiseModel.from_result(analysis)["gyro_x"]
        assert set(channel.intervals) == {"random_walk"}
        assert not channel.limits
        m = np.unique(np.geomspace(1, 1000, 12).astype(int))
        low, high = adev_interval(channel, m=m, tau0=1 / RATE)
        assert (low < high).all()


def test_json_has_what_is_known(case):
    content = case[0][0].to_dict()["channels"]["gyro_x"]
    known = {name: set(term) for name, term in content["fit"]["terms"].items() if "observed" in term}
    assert all(("value" in keys) == (name == "random_walk") for name, keys in known.items())
    back = Analysis.from_json(json.dumps(case[0][0].to_dict()))
    assert (back["gyro_x"].trust, str(back["gyro_x"])) == ("poor", str(case[0][0]["gyro_x"]))
