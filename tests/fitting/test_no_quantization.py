"""Where the samples have no step, the random walk is known as well as without quantization noise, and intervals hold."""

import numpy as np
import pytest

from known import seed_of
from sigmatau import NoiseModel, Record, analyze, fit_channel, simulate

RATE, SECONDS, WALK, BIAS = 50.0, 1200.0, 1e-4, 3e-5
SIGMA = WALK * np.sqrt(RATE)  # of a sample
BOUND = 1.96 / np.sqrt(2 * RATE * SECONDS)  # half width by the Cramér-Rao bound of white noise
AXES = [f"gyro_{k}" for k in "xyz"]


def white(name, *, axes=3, bias=0.0):
    """Independent white axes, with a bias instability or not."""
    noise = {"random_walk": WALK} | ({"bias_instability": bias} if bias else {})
    model = NoiseModel(channels=dict.fromkeys(AXES[:axes], noise))
    return simulate(model, duration=SECONDS, rate=RATE, rng=seed_of(name))


def half_width(term):
    """Relative."""
    return (term.high - term.low) / 2 / term.value


# Limits of the median half width over the bound of white noise alone. With a bias instability the bound itself is higher.
@pytest.fixture(scope="module", params=[(0.0, 1.15), (BIAS, 1.25)], ids=["N", "N + B"])
def limit(request):
    """A bias instability and the limit."""
    return request.param


@pytest.fixture(scope="module")
def walks(limit):
    """The random walk of 12 axes."""
    analyses = (analyze(white(f"no quantization {limit[0]} {k}", bias=limit[0])) for k in range(4))
    return [analysis[axis]["random_walk"] for analysis in analyses for axis in AXES]


def test_half_width_is_that_of_the_bound(walks, limit):
    """It was 1.7 times the bound with free quantization noise in every fit."""
    assert np.median([half_width(walk) for walk in walks]) < limit[1] * BOUND


def test_intervals_hold(walks):
    """95 %, less three standard errors."""
    inside = np.mean([walk.low <= WALK <= walk.high for walk in walks])
    assert inside > 0.95 - 3 * np.sqrt(0.95 * 0.05 / len(walks))


def test_a_coarse_step_leaves_room():
    """A step as large as the noise may be one of angles: the interval is that of a record whose step is not known."""
    record = white("a coarse step leaves room", axes=1)
    wide, coarse, sharp, fine = (
        half_width(fit_channel(record, "gyro_x", step=step)["random_walk"]) for step in (None, SIGMA, 0.0, 0.01 * SIGMA)
    )
    assert coarse == wide
    assert sharp < wide / 1.3
    assert sharp <= fine < 1.1 * sharp


def test_quantization_noise_that_shows_stays():
    """Noise of its density needs no step: jitter of the time stamps, or angles rounded before they were scaled by axes."""
    angle = 3 * WALK * np.sqrt(1 / RATE)
    rng = np.random.default_rng(seed_of("quantization noise that shows stays"))
    y = SIGMA * rng.standard_normal(60_000) + RATE * angle * np.diff(rng.standard_normal(60_001))
    record = Record.from_arrays(rate=RATE, gyro_x=y, unit={"gyro": "rad/s"})
    without_step, unknown = (fit_channel(record, "gyro_x", step=step) for step in (0.0, None))
    assert without_step["quantization"].observed
    assert without_step == unknown


def test_limit_of_quantization_noise_stays():
    """The step is no measurement: the limit is that of the samples."""
    record = white("limit of quantization noise stays", axes=1)
    sharp, wide = (fit_channel(record, "gyro_x", step=step)["quantization"] for step in (0.0, None))
    assert not sharp.observed
    assert sharp.upper_limit == pytest.approx(wide.upper_limit, rel=0.05)
