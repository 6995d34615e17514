"""Minima of the curve: of what was seen, and of all that the model has, against dense curves and bounds."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from sheets import N, judge, sheet

from known import seed_of
from sigmatau import NoiseModel, allan, compare_with, fit, simulate
from sigmatau.lab.datasheets.measured import measured
from sigmatau.model.channel import ChannelModel
from sigmatau.model.processes import GaussMarkov, Resonance, Sinusoid
from sigmatau.noise.terms import BIAS_LEVEL


class TestMinimum:
    def test_of_a_plateau(self):
        model = ChannelModel(terms={"random_walk": N, "bias_instability": 1e-4})
        assert measured(model, "minimum").value == pytest.approx(BIAS_LEVEL * 1e-4, rel=1e-3)  # N²/τ is left at 1e12 s

    def test_of_two_slopes(self):
        """σ² = N²/τ + K²τ/3 is least, 2NK/√3, at τ = √3·N/K."""
        model = ChannelModel(terms={"random_walk": N, "rate_random_walk": 1e-4}, limits={"bias_instability": 1e-9})
        assert measured(model, "minimum").value == pytest.approx(math.sqrt(2 * N * 1e-4 / math.sqrt(3)), rel=1e-6)

    def test_error_is_that_of_the_terms(self):
        """σ² = 2NK/√3: with both at an end of their intervals it is larger by the geometric mean of their factors."""
        values = {"random_walk": N, "rate_random_walk": 1e-4}
        ends = {"random_walk": (N / 1.1, N * 1.02), "rate_random_walk": (1e-4 / 1.6, 1e-4 * 1.3)}
        found = measured(ChannelModel(terms=values, intervals=ends, limits={"bias_instability": 1e-9}), "minimum")
        assert found.value / found.low == pytest.approx(math.sqrt(1.1 * 1.6), rel=1e-5)
        assert found.high / found.value == pytest.approx(math.sqrt(1.02 * 1.3), rel=1e-5)

    def test_what_was_not_seen_can_only_make_it_larger(self):
        seen = {"random_walk": N, "rate_random_walk": 1e-4}
        ends = {term: (0.98 * value, 1.02 * value) for term, value in seen.items()}
        narrow = measured(ChannelModel(terms=seen, limits={"bias_instability": 1e-9}, intervals=ends), "minimum")
        wide = measured(ChannelModel(terms=seen, limits={"bias_instability": 1e-2}, intervals=ends), "minimum")
        assert (wide.value, wide.low) == (narrow.value, narrow.low)
        floor = math.sqrt(2 * N * 1e-4 / math.sqrt(3))
        assert wide.high == pytest.approx(math.hypot(floor, BIAS_LEVEL * 1e-2), rel=1e-5)

    def test_of_white_noise_it_is_below_what_the_limits_make(self):
        model = ChannelModel(terms={"random_walk": N}, limits={"bias_instability": 1e-3, "rate_random_walk": 1e-4})
        found = measured(model, "minimum")
        assert found.value is None
        assert found.upper_limit == pytest.approx(
            math.hypot(math.sqrt(2 * N * 1e-4 / math.sqrt(3)), BIAS_LEVEL * 1e-3), rel=1e-5
        )

    def test_there_may_be_none(self):
        found = measured(ChannelModel(terms={"random_walk": N}), "minimum")
        assert not found.anything
        assert found.doubt.kind == "not_in_result"


def minimum(maximum):
    return {"bias_instability": {"maximum": f"{maximum!r} rad/s", "as": "minimum"}}


WALKS = {"random_walk": N, "rate_random_walk": 1e-4}
FLOOR = math.sqrt(2 * N * 1e-4 / math.sqrt(3))


class TestMinimumOfAllThatTheModelHas:
    """What was seen is a lower bound of the minimum: every other part of the noise adds to it."""

    def test_two_slopes_call_out_a_unit_whose_bias_instability_is_not_known(self):
        model = ChannelModel(terms=WALKS)
        found = measured(model, "minimum")
        assert (found.value, found.upper_limit) == (None, None)
        assert found.lower_limit == pytest.approx(FLOOR, rel=1e-6)
        judged = judge(model, minimum(FLOOR / 1.01))
        assert judged.status == "out"
        assert judged.to_dict()["readings"][0]["measured"]["lower_limit"] == found.lower_limit
        assert judge(model, minimum(FLOOR * 1.01)).status == "undecided"
        assert judge(model, minimum(found.lower_limit)).status == "undecided"

    def test_the_lower_bound_has_the_error_of_its_terms(self):
        ends = {"random_walk": (N / 1.1, N * 1.1), "rate_random_walk": (1e-4 / 1.6, 1.6e-4)}
        model = ChannelModel(terms=WALKS, intervals=ends)
        low = FLOOR / math.sqrt(1.1 * 1.6)
        assert measured(model, "minimum").lower_limit == pytest.approx(low, rel=1e-5)
        assert judge(model, minimum(0.99 * low)).status == "out"
        assert judge(model, minimum(0.99 * low), level=0.99).status == "undecided"  # the end of 95 % is one of 97.5 %
        assert judge(model, minimum(0.99 * FLOOR)).status == "undecided"

    def test_a_ramp_that_was_seen_has_its_interval_there(self):
        """σ² = N²/τ + R²τ²/2 is least, 1.5·(N²R)^⅔, at τ = (N/R)^⅔."""
        terms = {"random_walk": N, "rate_ramp": -1e-6}
        ends = {"random_walk": (N / 1.1, N * 1.1), "rate_ramp": (-1.3e-6, -1e-6 / 1.3)}
        found = measured(ChannelModel(terms=terms, intervals=ends, limits={"bias_instability": 1e-9}), "minimum")
        least = math.sqrt(1.5 * (N * N * 1e-6) ** (2 / 3))
        size = (1.1**2 * 1.3) ** (1 / 3)
        assert (found.low, found.value, found.high) == pytest.approx((least / size, least, least * size), rel=1e-5)

    def test_the_reason_is_in_the_table(self):
        model = ChannelModel(terms=WALKS)
        for claim, words in ((minimum(1.0), "lower bound"), ({"quantization": {"maximum": "1 rad"}}, "not measured")):
            verdict = compare_with(NoiseModel(channels={"gyro_x": model}), sheet(**claim))
            assert words in repr(verdict)

    def test_gauss_markov_is_part_of_the_curve(self):
        """Against the kernel of its exact curve, at the times of which the least is sought."""
        process = GaussMarkov(sigma=2e-4, time=30.0)
        model = ChannelModel(terms=WALKS, gauss_markov=(process,), limits={"bias_instability": 1e-9})
        m = np.unique(np.geomspace(1, 1e6, 4000).astype(int))
        assert measured(model, "minimum").value == pytest.approx(model.adev(m=m, tau0=1e-3).min(), rel=1e-4)

    def test_a_small_gauss_markov_process_hides_no_plateau(self):
        model = ChannelModel(
            terms={"bias_instability": 1e-3},
            intervals={"bias_instability": (0.9e-3, 1.1e-3)},
            gauss_markov=(GaussMarkov(sigma=1e-6, time=100.0),),
        )
        assert measured(model, "minimum").value == pytest.approx(BIAS_LEVEL * 1e-3, rel=1e-5)
        assert judge(model, minimum(BIAS_LEVEL * 0.8e-3)).status == "out"
        assert judge(model, minimum(BIAS_LEVEL * 1.2e-3)).status == "within"

    def test_a_resonance_is_part_of_the_minimum(self):
        """A small one leaves it, with its verdict; one as large as the minimum leaves it undecided."""
        ends = {term: (value / 1.01, value * 1.01) for term, value in WALKS.items()}
        more = {"terms": WALKS, "intervals": ends, "limits": {"bias_instability": 1e-9}}
        small, large = (Resonance(sigma=sigma, frequency=0.005, width=0.001) for sigma in (1e-9, FLOOR))
        with_small = ChannelModel(**more, resonance=(small,))
        assert measured(with_small, "minimum").value == pytest.approx(FLOOR, rel=1e-6)
        assert [judge(with_small, minimum(x * FLOOR)).status for x in (0.9, 1.1)] == ["out", "within"]
        judged = judge(ChannelModel(**more, resonance=(large,)), minimum(1.1 * FLOOR))
        assert judged.status == "undecided"
        assert "a resonance" in judged.reason

    def test_one_that_makes_the_minimum_has_no_known_error(self):
        """The model has no interval of a process: what it adds proves neither that a unit is out nor that it is within."""
        ends = {term: (value / 1.1, value * 1.1) for term, value in WALKS.items()}
        process = GaussMarkov(sigma=FLOOR, time=math.sqrt(3) * N / 1e-4 / 1.89)
        model = ChannelModel(terms=WALKS, intervals=ends, limits={"bias_instability": 1e-9}, gauss_markov=(process,))
        assert judge(model, minimum(0.9 * FLOOR)).status == "out"
        for maximum in (1.05 * FLOOR, 1.4 * FLOOR):
            judged = judge(model, minimum(maximum))
            assert judged.status == "undecided"
            assert "Gauss-Markov" in judged.reason

    def test_a_line_far_from_the_minimum_leaves_the_verdict(self):
        """39.7 Hz, as in the record of an accelerometer; the minimum is at 87 s."""
        lines = (Sinusoid(amplitude=N, frequency=39.7),)
        ends = {term: (value / 1.01, value * 1.01) for term, value in WALKS.items()}
        more = {"intervals": ends, "limits": {"bias_instability": 1e-9}}
        with_line = measured(ChannelModel(terms=WALKS, sinusoid=lines, **more), "minimum")
        without = measured(ChannelModel(terms=WALKS, **more), "minimum")
        for name in ("value", "low", "high"):
            assert getattr(with_line, name) == pytest.approx(getattr(without, name), rel=1e-4)
        limits = {"bias_instability": 1e-3, "rate_random_walk": 1e-4}
        white = measured(ChannelModel(terms={"random_walk": N}, limits=limits, sinusoid=lines), "minimum")
        plain = measured(ChannelModel(terms={"random_walk": N}, limits=limits), "minimum")
        assert white.upper_limit == pytest.approx(plain.upper_limit, rel=1e-3)

    def test_a_slow_line_is_part_of_the_curve(self):
        """Of a period longer than the minimum's time it adds; at whole periods it does not."""
        tau = math.sqrt(3) * N / 1e-4
        for frequency in (0.1 / tau, 0.4 / tau, 3 / tau):
            model = ChannelModel(terms=WALKS, sinusoid=(Sinusoid(amplitude=10 * FLOOR, frequency=frequency),))
            m = np.unique(np.geomspace(1, 1e6, 20_000).astype(int))
            curve = model.adev(m=m, tau0=1e-3).min()
            assert measured(model, "minimum").lower_limit == pytest.approx(curve, rel=0.01)

    def test_a_line_that_may_make_the_minimum_leaves_it_open(self):
        limits = {"bias_instability": 1e-6, "rate_random_walk": 1e-7}
        line = Sinusoid(amplitude=1.0, frequency=1e-5)
        found = measured(ChannelModel(terms={"random_walk": N}, limits=limits, sinusoid=(line,)), "minimum")
        assert not found.anything
        assert "sinusoid" in found.doubt.words

    def test_records_of_units_at_the_limit(self):
        """N and K make the minimum, at 17 s of 6.8 min; docs/study/datasheets.md has more records and levels."""
        n, k = 0.01, 1e-3
        truth = math.sqrt(2 * n * k / math.sqrt(3))
        model = NoiseModel(channels={f"gyro_{a}": {"random_walk": n, "rate_random_walk": k} for a in "xyz"})
        rng = np.random.default_rng(seed_of("minimum at the limit"))
        records, counts = 5, dict.fromkeys((0.5, 1.0, 2.0), 0)
        for _ in range(records):
            record = simulate(model, duration=409.6, rate=10.0, rng=rng)
            found = SimpleNamespace(fits={name: fit(curve) for name, curve in allan(record, threads=1).items()})
            for ratio in counts:
                counts[ratio] += len(compare_with(found, sheet(**minimum(truth / ratio))).of("out"))
        total = 3 * records
        assert counts[0.5] == 0
        assert counts[1.0] / total <= 0.05 + 3 * math.sqrt(0.05 * 0.95 / total)
        assert counts[2.0] > total / 2
