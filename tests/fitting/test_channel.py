"""A channel by itself: what a method does not take is refused, not left out."""

import numpy as np
import pytest
from scipy.signal import lfilter

from known import seed_of
from sigmatau import DataError, OptionError, Record, fit_channel


@pytest.mark.parametrize(
    ("option", "value"),
    [("regressors", {"supply": np.arange(2000.0)}), ("processes", [1.0])],
    ids=lambda one: str(one)[:9],
)
def test_least_squares_have_no_regressors_and_no_processes(option, value):
    x = np.random.default_rng(seed_of("least squares")).standard_normal(2000)
    record = Record.from_arrays(rate=100, gyro_x=x, unit={"gyro": "rad/s"})
    with pytest.raises(OptionError, match=f"`{option}` need the likelihood: least squares has none"):
        fit_channel(record, "gyro_x", method="gls", **{option: value})
    assert fit_channel(record, "gyro_x", method="gls", **{option: None}).method == "gls"
    with pytest.raises(KeyError, match="gyro_y"):
        fit_channel(record, "gyro_y")


def test_a_channel_that_never_changes_is_refused():
    record = Record.from_arrays(rate=100, gyro_x=np.full(5000, 0.25), unit={"gyro": "rad/s"})
    with pytest.raises(DataError, match="never changes"):
        fit_channel(record, "gyro_x")


def test_many_regressors_of_any_size_leave_white_noise_adequate():
    """The lowest modes lose degrees of freedom to the regressors; the p-value counts them."""
    rng = np.random.default_rng(seed_of("many regressors"))
    time = np.arange(100_000) / 1e5
    sizes = 10.0 ** np.arange(-12, 12, 3)
    curves = {f"curve {k}": size * np.sin(2 * np.pi * (k + 1) * time + 1) for k, size in enumerate(sizes)}
    widened, off = 0, []
    for _ in range(5):
        record = Record.from_arrays(rate=100, gyro_x=rng.standard_normal(100_000), unit={"gyro": "rad/s"})
        fitted = fit_channel(record, "gyro_x", regressors=curves)
        widened += fitted.verdict == "widened"
        off += [one.value / ((one.high - one.low) / 2 / 1.96) for one in fitted.regressors.values()]
    assert widened <= 1  # 0.2 % are expected; before, 15 %
    assert np.std(off) == pytest.approx(1, abs=3 / np.sqrt(2 * len(off)))


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("processes", 3.0),
        ("processes", "abc"),
        ("processes", [-1.0]),
        ("processes", list(np.geomspace(0.1, 100, 50))),
        ("regressors", [np.arange(2000.0)]),
        ("regressors", {"text": ["a"] * 2000}),
        ("regressors", {"complex": np.arange(2000) * 1j}),
        ("regressors", {"huge": np.arange(2000) * 1e300}),
        ("regressors", {"short": np.arange(1000.0)}),
        ("regressors", {"nan": np.full(2000, np.nan)}),
        ("regressors", {f"curve {k}": np.cos(k * np.arange(2000.0)) for k in range(1, 40)}),
    ],
    ids=lambda one: str(one)[:20].partition("\n")[0],
)
def test_what_the_likelihood_cannot_use_is_refused(option, value):
    x = np.random.default_rng(seed_of("likelihood")).standard_normal(2000)
    record = Record.from_arrays(rate=100, gyro_x=x, unit={"gyro": "rad/s"})
    with pytest.raises(OptionError, match=f"`{option}`"):
        fit_channel(record, "gyro_x", **{option: value})


@pytest.mark.parametrize("time", [0.3, 1.0])
def test_white_noise_behind_a_slow_filter_alone(time):
    """Its density is that of a Gauss-Markov process: a random walk by either reading is inside what is stated."""
    decay, held = np.exp(-0.01 / time), 0
    for k in range(3):
        white = np.random.default_rng(seed_of(f"slow filter {time} {k}")).standard_normal(2**17)
        x = lfilter([1 - decay], [1, -decay], 1e-3 * white)
        fitted = fit_channel(Record.from_arrays(rate=100, gyro_x=x, unit={"gyro": "rad/s"}), "gyro_x")["random_walk"]
        high = fitted.high if fitted.observed else fitted.upper_limit
        held += (fitted.low or 0.0) <= 1e-4 <= high
    assert held >= 2
