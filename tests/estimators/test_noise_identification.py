"""Types of noise by the lag-1 autocorrelation, B1 and R(n): allantools, Stable32, simulated records."""

import json

import numpy as np
import pytest
from tests.estimators.agreement import nbs14_record

import known
from sigmatau import NoiseModel, Record, identify_noise, simulate
from sigmatau.errors import NonFiniteError, OptionError, RecordTooShortError
from sigmatau.estimators.noise_identification import b1_power, lag_1_power, rn_power

POWERS = {"quantization": 2, "random_walk": 0, "bias_instability": -1, "rate_random_walk": -2}


class TestAgainstAllantools:
    @pytest.mark.parametrize("term", POWERS)
    def test_lag_1(self, term):
        from allantools import ci

        model = NoiseModel(channels={"gyro_x": {term: 1.0}})
        record = simulate(model, duration=2000, rate=1, rng=known.seed_of(f"identify {term}"))
        rate = record.stream_of("gyro_x").column("gyro_x")
        sizes = [1, 2, 5, 20, 60]
        ours = identify_noise(record, taus=sizes)["gyro_x"]
        assert ours.methods == ("lag 1",) * len(sizes)
        # Theirs is not limited to 2 and −3.
        theirs = [ci.autocorr_noise_id(rate, m, data_type="freq")[0] for m in sizes]
        assert ours.alpha.tolist() == np.clip(theirs, -3, 2).tolist()

    @pytest.mark.parametrize("count", [5, 12, 29])
    def test_limits_of_b1(self, count):
        """Between two types: the geometric mean of their expectations, with α = b + 2 there."""
        from allantools import ci

        for b, powers in ((-1, (2, 0)), (-2, (0, -1)), (-3, (-1, -2)), (-4, (-2, -3))):
            limit = ci.b1_boundary(b, count)
            assert (b1_power(0.999 * limit, count), b1_power(1.001 * limit, count)) == powers

    @pytest.mark.parametrize("m", [2, 10, 100])
    def test_limit_of_rn(self, m):
        from allantools import ci

        limit = ci.rn_boundary(m, 0)
        assert (rn_power(0.999 * limit, m), rn_power(1.001 * limit, m)) == (2, 1)


def test_stable32():
    """The column Alpha of its files for this record: 0 up to 64 samples, and 1 at 128 and 256."""
    got = identify_noise(nbs14_record(), taus=[1, 2, 4, 8, 16, 32, 64, 128, 256])["y"]
    assert got.alpha[:6].tolist() == [0] * 6
    assert got.methods[:5] == ("lag 1",) * 5
    assert set(got.methods[6:]) <= {"B1", "R(n)"}


@pytest.mark.parametrize("term", POWERS)
def test_rate_of_success(term):
    """300 records: with 100 means at least 80 % (flicker noise 50 %) are right, with 12 means half of them."""
    count = 300
    model = NoiseModel(channels={f"gyro_{k}": {term: 1.0} for k in range(count)})
    record = simulate(model, duration=1200, rate=1, rng=known.seed_of(f"success {term}"))
    alpha = np.array([channel.alpha for channel in identify_noise(record, taus=[12, 100]).values()])
    right = np.mean(alpha == POWERS[term], axis=0)
    assert right[0] >= (0.5 if term == "bias_instability" else 0.8)
    assert right[1] >= 0.45


def test_white_noise_of_the_phase_by_rn():
    y = np.diff(np.random.default_rng(known.seed_of("phase")).standard_normal(2001))
    got = identify_noise(Record.from_arrays(rate=1, y=y), taus=[100, 200])["y"]
    assert got.methods == ("R(n)", "R(n)")
    assert got.alpha.tolist() == [2, 2]


def test_a_steep_noise_has_no_term():
    y = np.cumsum(np.cumsum(np.random.default_rng(1).standard_normal(1000)))
    got = identify_noise(Record.from_arrays(rate=1, y=y), taus=[1, 4])["y"]
    assert got.terms[0] is None
    assert got.alpha[0] == -3
    assert lag_1_power(np.zeros(40)) == 0


def test_result():
    y = np.random.default_rng(3).standard_normal(400)
    got = identify_noise(Record.from_arrays(rate=10, y=y), taus=[0.1, 10])
    plain = json.loads(json.dumps(got.to_dict(), allow_nan=False))["y"]
    assert list(plain) == ["m", "tau_s", "alpha", "n_means", "methods", "terms"]
    assert plain["n_means"] == [400, 4]
    assert identify_noise(Record.from_arrays(rate=10, y=y), taus=[20])["y"].n_means == [4]  # of shorter clusters
    assert repr(got["y"]).splitlines()[:2] == [
        "y: type of the noise",
        "           0.1 s  α = 0   random walk       lag 1, 400 means",
    ]


def test_errors():
    with pytest.raises(TypeError, match="must be a Record"):
        identify_noise(np.zeros(100))
    y = np.zeros(100)
    with pytest.raises(RecordTooShortError, match="at least 4 are needed"):
        identify_noise(Record.from_arrays(rate=1, y=y[:3]))
    with pytest.raises(OptionError, match="longer than half the record"):
        identify_noise(Record.from_arrays(rate=1, y=y), taus=[60])
    y[3] = np.nan
    with pytest.raises(NonFiniteError, match="longest_run"):
        identify_noise(Record.from_arrays(rate=1, y=y))
