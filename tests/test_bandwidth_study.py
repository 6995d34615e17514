"""Fig. 12 of the paper, a fast version of studies/bandwidth.py: N from the Allan variance at 3 s, records of 1000 s."""

import math

import numpy as np
import pytest
from studies.bandwidth import BANDWIDTH, RATES, STATED, filtered_white

import known
from sigmatau import Record, allan
from sigmatau.noise.terms import aliasing_inflation

CASES = [(order, rate, stated) for order in (1, 2) for rate, stated in zip(RATES, STATED[order], strict=False)]


@pytest.mark.parametrize(("order", "rate", "stated"), CASES)
def test_inflation(order, rate, stated):
    """Mean of 60 records within three standard errors of the value of the folded spectrum at 0."""
    rng = np.random.default_rng(known.seed_of(f"figure 12, order {order}, {rate:g} Hz"))
    found = []
    for _ in range(60):
        y = filtered_white(round(1000 * rate), rate=rate, bandwidth=BANDWIDTH, order=order, rng=rng)
        curve = allan(Record.from_arrays(rate=rate, gyro_x=y), taus=[3.0], threads=1)["gyro_x"]
        found.append(math.sqrt(curve.avar[0] * 3.0))
    error = np.std(found, ddof=1) / math.sqrt(60)
    assert error < 0.01 * stated  # so that the gate can tell 1.131 from 1.095, 2.58 from 2.66
    assert np.mean(found) == pytest.approx(stated, abs=3 * error)


@pytest.mark.parametrize(("order", "stated"), STATED.items())
def test_closed_form(order, stated):
    found = [aliasing_inflation(rate=rate, bandwidth=BANDWIDTH, order=order) for rate in RATES[: len(stated)]]
    assert found == pytest.approx(stated, abs=0.006 if order == 2 else 0.0006)  # as many digits as are stated


@pytest.mark.parametrize(
    ("order", "stated"),
    {1: (1.776, 1.309, 1.158, 1.094, 1.062, 1.016), 2: (1.469, 1.062, 1.013, 1.004, 1.002, 1.000)}.items(),
)
def test_table_of_the_theory(order, stated):
    found = [aliasing_inflation(rate=30.0 * ratio, bandwidth=30.0, order=order) for ratio in (1, 2, 3, 4, 5, 10)]
    assert found == pytest.approx(stated, abs=0.0006)


def test_first_order_is_x_coth_x():
    for rate in (1.0, 30.0, 400.0, 1e5):
        x = math.pi * 30 / rate
        assert aliasing_inflation(rate=rate, bandwidth=30.0) == pytest.approx(math.sqrt(x / math.tanh(x)), rel=1e-12)


@pytest.mark.parametrize("order", [2, 3, 5, 8])
def test_sum_of_images(order):
    """Another route: the images added up, which fall as k^(-2·order)."""
    k = np.arange(-4000, 4001)
    for rate in (20.0, 60.0, 150.0):
        images = 1 / (1 + (k * rate / 30.0) ** (2 * order))
        assert aliasing_inflation(rate=rate, bandwidth=30.0, order=order) == pytest.approx(
            math.sqrt(images.sum()), rel=1e-9
        )


@pytest.mark.parametrize("wrong", [{"rate": 0.0}, {"bandwidth": -1.0}, {"order": 0}, {"order": 10}, {"rate": math.inf}])
def test_wrong_arguments(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        aliasing_inflation(**{"rate": 100.0, "bandwidth": 30.0, **wrong})
