"""Eq. (26) and the paper's ±."""

import pytest

import known
from sigmatau import percentage_error


@pytest.mark.parametrize(
    ("n", "m", "expected"),
    [
        (2000, 500, 0.40824829),
        (2000, 10, 0.050125471),
        (1_440_000, 2**14, 0.075857503),
        (1_440_000, 2**18, 0.333586805),
    ],
)
def test_eq_26(n, m, expected):
    assert percentage_error(n, m)[0] == pytest.approx(expected, rel=5e-8)


def test_paper_examples():
    """Section II-D: 40 % and 5 %; Section IV: 0.06 % at one sample of the CIMU."""
    assert round(100 * percentage_error(2000, 500)[0]) == 41  # "approximately 40 %"
    assert round(100 * percentage_error(2000, 10)[0]) == 5
    assert round(100 * percentage_error(1_440_000, 1)[0], 2) == 0.06


@pytest.mark.parametrize("cell", known.PLUS_MINUS)
def test_plus_minus_of_the_tables(cell):
    value, printed, n, m, rounded, digits = known.PLUS_MINUS[cell]
    delta = percentage_error(n, m)[0]
    error = value * (round(delta, 3) if rounded else delta)
    assert error == pytest.approx(printed, abs=0.51 * 10**-digits)  # half a unit of the printed digit


def test_wrong_sizes():
    with pytest.raises(ValueError, match="1 … 99"):
        percentage_error(100, [100])
