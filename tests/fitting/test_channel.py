"""A channel by itself: what a method does not take is refused, not left out."""

import numpy as np
import pytest

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
    with pytest.raises(OptionError, match=f"`{option}` are of the likelihood: least squares has none"):
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
    for _ in range(20):
        record = Record.from_arrays(rate=100, gyro_x=rng.standard_normal(100_000), unit={"gyro": "rad/s"})
        fitted = fit_channel(record, "gyro_x", regressors=curves)
        widened += fitted.verdict == "widened"
        off += [one.value / ((one.high - one.low) / 2 / 1.96) for one in fitted.regressors.values()]
    assert widened <= 2  # 0.2 % are expected; before, 3 of 20
    assert np.std(off) == pytest.approx(1, abs=3 / np.sqrt(2 * len(off)))
