"""A bias as one Gauss-Markov process: the constants, where it is matched, and what is refused."""

import math

import numpy as np
import pytest

from sigmatau import OptionError
from sigmatau.exporting.choices import Choices
from sigmatau.exporting.gauss_markov import PEAK_TIME, SIGMA_OF_FLICKER, minimum_time, process
from sigmatau.exporting.values import Numbers
from sigmatau.model.channel import ChannelModel
from sigmatau.model.noise_model import NoiseModel
from sigmatau.model.processes import GaussMarkov

B, N, K = 5e-5, 1e-4, 1e-6
TAU0 = 0.01


def of(terms, **choices):
    given = terms if isinstance(terms, dict) else {"gyro_x": terms}
    return process(Numbers(NoiseModel(channels=given), Choices(**choices)), "gyro")


def avar_of(found, tau):
    gm = ChannelModel(gauss_markov=(GaussMarkov(sigma=found.sigma, time=found.time),))
    return float(gm.avar(m=[round(tau / TAU0)], tau0=TAU0)[0])


def test_its_hump_is_the_plateau_of_flicker_at_the_bottom_of_the_curve():
    found = of({"gyro_x": {"random_walk": N, "bias_instability": B, "rate_random_walk": K}})
    tau = math.sqrt(3) * N / K  # where N²/τ + K²τ/3 is least
    flicker = 2 * math.log(2) / math.pi * B**2
    # Continuous forms against samples: τ₀/τ² of the curvature.
    assert avar_of(found, tau) == pytest.approx(flicker, rel=1e-6)
    assert avar_of(found, tau / 1.3) < avar_of(found, tau) > avar_of(found, tau * 1.3)
    for half_a_decade in (10**0.5, 10**-0.5):
        assert math.sqrt(avar_of(found, tau * half_a_decade) / flicker) == pytest.approx(0.82, abs=0.01)
    assert "no field here for its rate random walk" in found.words


def test_constants_are_those_of_the_closed_form():
    def shape(x):  # σ²(T)/σ² at x = T/Tc, IEEE Std 952
        return (2 - (3 - 4 * math.exp(-x) + math.exp(-2 * x)) / x) / x

    h = 1e-5
    assert abs(shape(PEAK_TIME + h) - shape(PEAK_TIME - h)) < 1e-14
    assert SIGMA_OF_FLICKER**2 * shape(PEAK_TIME) == pytest.approx(2 * math.log(2) / math.pi, rel=1e-9)


@pytest.mark.parametrize("q", [0.0, 1e-5])
@pytest.mark.parametrize(("k", "r"), [(1e-6, 0.0), (0.0, 1e-9), (1e-6, 1e-9), (1e-9, 1e-12)])
@pytest.mark.parametrize("n", [1e-4, 1e-7])
def test_bottom_is_the_least_of_the_curve(q, n, k, r):
    model = ChannelModel(
        terms={"quantization": q, "random_walk": n, "rate_random_walk": k, "rate_ramp": r, "bias_instability": B}
    )
    found = minimum_time(model)

    def curve(tau):
        return 3 * (q / tau) ** 2 + n**2 / tau + k**2 * tau / 3 + (r * tau) ** 2 / 2

    near = found * (1 + np.array([-1e-3, -1e-4, 1e-4, 1e-3]))
    assert (curve(near) > curve(found)).all()
    if not q and not r:
        assert found == pytest.approx(math.sqrt(3) * n / k, rel=1e-9)


def test_without_a_bottom_a_horizon_is_asked_for_and_taken():
    flat = {"random_walk": N, "bias_instability": B}
    with pytest.raises(OptionError, match="no lowest point: give `horizon="):
        of({"gyro_x": flat})
    found = of({"gyro_x": flat}, horizon=100.0)
    assert (found.sigma, found.time) == (SIGMA_OF_FLICKER * B, 100 / PEAK_TIME)
    # A horizon that is given goes before the bottom of the curve.
    assert of({"gyro_x": flat | {"rate_random_walk": K}}, horizon=100.0).time == 100 / PEAK_TIME


def test_the_models_own_process_goes_first():
    own = ChannelModel(
        terms={"random_walk": N, "bias_instability": B, "rate_random_walk": K},
        gauss_markov=(GaussMarkov(sigma=2e-5, time=7.0), GaussMarkov(sigma=3e-5, time=300.0)),
    )
    found = of(own, walk_factor=2.0)
    assert (found.sigma, found.time) == (6e-5, 300.0)
    for part in (
        "largest of 2",
        "times 2",
        "no field here for its bias instability 10.31 deg/h and rate random walk 12.38",
    ):
        assert part in found.words


def test_a_walk_is_followed_up_to_the_horizon():
    walk = {"random_walk": N, "rate_random_walk": K}
    with pytest.raises(OptionError, match=r"no bias instability.*`horizon"):
        of({"gyro_x": walk})
    found = of({"gyro_x": walk}, horizon=60.0)
    assert found.density == pytest.approx(K, rel=1e-14)
    assert found.time == 600.0
    assert math.sqrt(avar_of(found, 60.0) / (K**2 * 60 / 3)) == pytest.approx(1 - 0.036, abs=1e-3)
    # In a target with one time for all, it is exact at the horizon.
    assert math.sqrt(avar_of(found.with_time(1e4), 60.0) / (K**2 * 60 / 3)) == pytest.approx(1, abs=1e-6)


def test_a_walk_that_was_not_seen_is_chosen():
    quiet = ChannelModel(terms={"random_walk": N}, limits={"rate_random_walk": 2e-6, "bias_instability": 3e-6})
    with pytest.raises(OptionError, match=r"no slow noise \(its bias instability is below 0.62 deg/h\).*upper-limit"):
        of(quiet)
    with pytest.raises(OptionError, match="needs `horizon`"):
        of(quiet, walk={"gyro": "upper-limit"})
    assert of(quiet, walk={"gyro": "upper-limit"}, horizon=10.0).density == pytest.approx(2e-6, rel=1e-14)
    assert of(quiet, walk={"gyro": 5e-6}, horizon=10.0, walk_factor=2.0).density == pytest.approx(1e-5, rel=1e-14)


def test_axes():
    axes = {f"gyro_{a}": {"random_walk": N, "bias_instability": s * B, "rate_random_walk": s * K} for a, s in
            (("x", 1.0), ("y", 2.0), ("z", 4.0))}  # fmt: skip
    worst, mean = of(axes), of(axes, axes="mean")
    tau = math.sqrt(3) * N / K / PEAK_TIME
    assert (worst.sigma, worst.time) == pytest.approx((4 * SIGMA_OF_FLICKER * B, tau / 4), rel=1e-9)
    assert (mean.sigma, mean.time) == pytest.approx((math.sqrt(7) * SIGMA_OF_FLICKER * B, tau / 2), rel=1e-9)
    assert "worst of 3 axes, gyro_z" in worst.words
    assert "root mean square of gyro_x, gyro_y, gyro_z" in mean.words
    assert "exact at" not in mean.words  # three bottoms, and none of them its own


def test_the_mean_of_axes_of_several_kinds_is_of_processes_of_one_time():
    """The σ of a walk belongs to its time; beside that of another time it says nothing."""
    flicker = {"random_walk": N, "bias_instability": B}
    walk = {"random_walk": N, "rate_random_walk": K}
    mean = of({"gyro_x": flicker, "gyro_y": walk}, axes="mean", horizon=60.0)
    wanted = (2 * math.log(2) / math.pi * B**2 + K**2 * 60 / 3) / 2
    assert avar_of(mean, 60.0) == pytest.approx(wanted, rel=1e-5)


def numbers_of(terms, **choices):
    return Numbers(NoiseModel(channels=terms), Choices(**choices))


class TestMoreSlowNoiseThanTheProcess:
    """What is written is held against all slow noise of the model where it is to be right."""

    def test_a_small_process_of_the_model_itself(self):
        own = ChannelModel(
            terms={"random_walk": N, "bias_instability": 1000 * B}, gauss_markov=(GaussMarkov(sigma=B, time=50.0),)
        )
        numbers = numbers_of({"gyro_x": own})
        found = process(numbers, "gyro")
        assert (found.sigma, found.time) == (B, 50.0)
        (finding,) = numbers.findings
        assert (finding.code, finding.severity) == ("slow_noise_left_out", "warning")
        # Flicker of 1000 B, σ² = 2 ln2/π·B², over the peak of the process, which is that of flicker of B/1.076.
        ratio = math.hypot(1000 * SIGMA_OF_FLICKER, 1)
        assert finding.channels == ("gyro_x",)
        assert finding.details.ratio == pytest.approx(ratio, rel=1e-3)
        assert f"{ratio:.3g} times" in found.words

    def test_a_walk_beside_flicker_at_a_horizon(self):
        terms = {"random_walk": N, "bias_instability": B}
        axes = {"gyro_x": terms | {"rate_random_walk": 3 * K}, "gyro_y": {**terms, "bias_instability": 1.2 * B}}
        numbers = numbers_of(axes, horizon=2000.0)
        found = process(numbers, "gyro")
        assert "gyro_y" in found.origin  # that of the largest bias instability, and the curve of x is above it
        ratio = math.sqrt((2 * math.log(2) / math.pi * B**2 + (3 * K) ** 2 * 2000 / 3) / avar_of(found, 2000.0))
        assert ratio > 1.3
        assert f"all slow noise of gyro_x has {ratio:.3g} times" in found.words
        assert [f.code for f in numbers.findings] == ["slow_noise_left_out"]

    @pytest.mark.parametrize("horizon", [None, 50.0])
    def test_nothing_is_said_where_it_is_right(self, horizon):
        terms = {"random_walk": N, "bias_instability": B, "rate_random_walk": K / 10}
        numbers = numbers_of({"gyro_x": terms, "gyro_y": terms}, horizon=horizon, walk_factor=3.0)
        assert "all slow noise" not in process(numbers, "gyro").words
        assert numbers.findings == []
