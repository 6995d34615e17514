"""Printed values and intervals: two digits of the error, one place, and no ± beside a value that is not symmetric."""

import math
from decimal import Context, Decimal

import numpy as np
import pytest

from known import seed_of
from sigmatau.digits import limit_text, round_to_error, significant, two_digits

PAIRS = 10_000


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (0.973, 0.973 * 0.0758575, "0.973 ± 0.074"),  # eq. (27) of the paper
        (0.0015, 0.0015 * 0.3335868, "0.00150 ± 0.00050"),  # eq. (28), which it prints with one digit
        (2.64, 2.64 * 0.3335868, "2.64 ± 0.88"),  # eq. (29)
        (13.6, 1.4, "13.6 ± 1.4"),
        (0.9725, 0.1049, "0.97 ± 0.10"),
        (123456, 7890, "123500 ± 7900"),
        (0.512, 0.00999, "0.512 ± 0.010"),
        (1.41e-8, 2e-10, "1.410e-8 ± 0.020e-8"),
        (12345678, 350000, "1.235e7 ± 0.035e7"),
        (0.003, 0.5, "0.00 ± 0.50"),
        (-3.2, 0.8, "-3.20 ± 0.80"),
        (2.0, 0.0, "2 ± 0"),
    ],
)
def test_value_and_error(value, error, text):
    assert round_to_error(value, error=error).text == text


@pytest.mark.parametrize(
    ("value", "low", "high", "text"),
    [
        (0.001522, 0.001465, 0.001627, "0.001522 [0.001465, 0.001627]"),
        (13.6, 12.4, 15.1, "13.6 [12.4, 15.1]"),
        (13.6, 12.4, 14.75, "13.6 ± 1.2"),
        (5.14, 0, 710, "5 [0, 710]"),
        (0.3, 0.1, 710, "0.3 [0.1, 710]"),
        (10.4, 0.44, 20.3, "10 [0.4, 20]"),  # 10 ± 10 would reach zero
        (0, 0, 0.5, "0.00 [0.00, 0.50]"),
        (-0.001, -0.6, 0.3, "0.00 [-0.60, 0.30]"),
        (2, -1, math.inf, "2.0 [-1.0, inf]"),
        (1, 1, 1, "1 [1, 1]"),
        (5.12345, None, None, "5.12"),
        (54832.0, None, None, "54800"),
    ],
)
def test_value_and_interval(value, low, high, text):
    assert round_to_error(value, low, high).text == text


def _pairs():
    """Values of 24 decades, half widths from 1e-5 of them to 30 times them, halves alike or up to 10 times different."""
    rng = np.random.default_rng(seed_of("digits"))
    value = 10 ** rng.uniform(-12, 12, PAIRS) * rng.choice([-1, 1], PAIRS, p=[0.2, 0.8])
    below = np.abs(value) * 10 ** rng.uniform(-5, 1.5, PAIRS)
    ratio = np.where(rng.random(PAIRS) < 0.5, rng.uniform(0.85, 1.2, PAIRS), 10 ** rng.uniform(-1, 1, PAIRS))
    return np.stack([value, value - below, value + below * ratio], axis=1).tolist()


def _second_digit(number: float) -> Decimal:
    """The place of the second significant digit of a number rounded to two."""
    two = Context(prec=2).create_decimal_from_float(number)
    return Decimal(1).scaleb(two.adjusted() - 1)


def test_property_over_random_intervals():
    """The printed numbers are the value and its ends to half a digit, to one place, and ± stands for even halves alone."""
    even = 0
    for value, low, high in _pairs():
        shown = round_to_error(value, low, high)
        smaller, larger = sorted((value - low, high - value))
        is_even = larger <= 1.1 * smaller
        half = larger if is_even else max(smaller, 0.1 * larger)
        place = _second_digit(half)
        for number, text in ((value, shown.value), (low, shown.low), (high, shown.high)):
            rounded = Decimal(text)
            if rounded and low > 0 and number < place / 2:  # one digit of its own, because it is not zero
                assert abs(rounded / Decimal(number) - 1) <= Decimal("0.5")
                continue
            assert abs(rounded - Decimal(number)) <= place * Decimal("0.500001")
            assert rounded % place == 0
            if "." in text:  # zeros are kept
                assert rounded.as_tuple().exponent == place.adjusted()
        assert (Decimal(shown.low) > 0) == (low > 0)  # an interval without zero is not printed with it
        if not shown.error:
            assert "±" not in shown.text
            assert not is_even or low < larger / 10  # an even one that ± would extend to zero
            continue
        even += 1
        assert is_even
        assert shown.text == f"{shown.value} ± {shown.error}"
        error = Decimal(shown.error)
        assert 10 <= error / place <= 99
        assert abs(error - Decimal(larger)) <= place * Decimal("0.500001")
        for end, sign in ((low, -1), (high, 1)):  # it encloses the interval to half a digit of value and error each
            assert sign * (Decimal(shown.value) + sign * error - Decimal(end)) >= -place * Decimal("1.000002")
    assert 0.2 * PAIRS < even < 0.5 * PAIRS


def test_limits_keep_zeros_and_factors_do_not():
    assert [limit_text(x) for x in (0.2, 0.204, 218.0, 20.0, 3.0)] == [
        *("below 0.20", "below 0.20", "below 220", "below 20", "below 3.0"),
    ]
    assert two_digits(3.0) == "3"
    assert significant(0.5, sign="+") == "+0.5"
