"""A channel by itself: what a method does not take is refused, not left out."""

import numpy as np
import pytest

from known import seed_of
from sigmatau import OptionError, Record, fit_channel


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
