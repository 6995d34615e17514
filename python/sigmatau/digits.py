"""Digits of a measured value: two of its error, and the value to the same place.

Screens, reports, tables, messages and comments in files print a value and its interval by `round_to_error` alone.
"""

from __future__ import annotations

import math

from sigmatau.frozen import frozen

_UNEVEN = 1.1  # ratio of the half widths of an interval above which one ± misstates one of them by more than a tenth
# smallest share of the smaller half width in the larger one: a smaller share leaves fewer than two digits
_SMALLEST_SHARE = 0.1
_PRECISION = 15  # digits of a double
_SMALLEST_EXPONENT, _LARGEST_EXPONENT = -4, 6  # exponents of numbers that are printed without a power of ten


@frozen
class Rounded:
    """A value and its interval as text, all to one place.

    Attributes
    ----------
    value : str
    low, high : str
        Ends of the interval; empty without an interval.
    error : str
        Half width of the interval; empty if its halves differ by more than a tenth.
    """

    value: str
    low: str = ""
    high: str = ""
    error: str = ""

    @property
    def interval(self) -> str:
        """``"[0.465, 0.520]"``; empty without an interval."""
        return f"[{self.low}, {self.high}]" if self.low else ""

    @property
    def cells(self) -> tuple[str, str]:
        """Value and interval in separate columns."""
        return self.value, self.interval

    @property
    def text(self) -> str:
        """``"0.97 ± 0.10"``; ``"13.6 [12.4, 15.7]"`` where one ± would mislead."""
        return f"{self.value} {self.error_text}".rstrip()

    @property
    def error_text(self) -> str:
        """``"± 0.10"``, or the interval where one ± would mislead."""
        return f"± {self.error}" if self.error else self.interval

    def with_unit(self, unit: str) -> str:
        """The text and its unit."""
        return f"{self.text} {unit}".rstrip()


def round_to_error(
    value: float,
    low: float | None = None,
    high: float | None = None,
    *,
    error: float | None = None,
    size: float = 1.0,
    sign: str = "",
) -> Rounded:
    """Round a value and its interval to the place of the second digit of the error.

    Parameters
    ----------
    value : float
    low, high : float, optional
        Ends of the interval. Without them and without `error` the value has three digits, zeros kept.
    error : float, optional
        Half width of a symmetric interval, in place of `low` and `high`.
    size : float
        Size of the unit in which the numbers are printed.
    sign : str
        ``"+"`` also for positive numbers.

    Returns
    -------
    Rounded

    Notes
    -----
    The error is the larger half width of an interval whose halves differ by at most a tenth, so that ± encloses it, and
    otherwise the smaller one, so that each half has two digits, but at
    least a tenth of the larger one. A positive number that would round to zero has one digit.

    Examples
    --------
    >>> round_to_error(0.9725, error=0.1049).text, round_to_error(0.512, 0.465, 0.52).text
    ('0.97 ± 0.10', '0.5120 [0.4650, 0.5200]')
    >>> round_to_error(0.001522, 0.001465, 0.001627).text, round_to_error(5.14, 0, 710).text
    ('0.001522 [0.001465, 0.001627]', '5 [0, 710]')
    """
    value, low, high, error = value / size, *(None if end is None else end / size for end in (low, high, error))
    if error is not None:
        low, high = value - error, value + error
    if low is None or high is None or not math.isfinite(value):
        return Rounded(value=significant(value, sign=sign, zeros=math.isfinite(value)))
    sides = [value - low, high - value] if error is None else [error, error]
    finite = [abs(side) for side in sides if math.isfinite(side) and side]
    if not finite:
        texts = [f"{number:{sign}.6g}" for number in (value, low, high)]
        return Rounded(value=texts[0], low=texts[1], high=texts[2], error="0" if error == 0 else "")
    smaller, larger = (min(finite), max(finite)) if min(sides) >= 0 else ((high - low) / 2,) * 2
    is_even = 0 < max(sides) <= _UNEVEN * (1 + 1e-9) * min(sides)
    half = larger if is_even else max(smaller, _SMALLEST_SHARE * larger)
    largest = max(abs(number) for number in (value, low, high) if math.isfinite(number))
    lowest = math.floor(math.log10(max(largest, half))) - _PRECISION + 1
    place = max(int(f"{half:.1e}".partition("e")[2]) - 1, lowest)  # place of the last digit, as a power of ten
    power = math.floor(math.log10(max(abs(value), half)))
    unit = power if power < _SMALLEST_EXPONENT or (power > _LARGEST_EXPONENT and place > 0) else 0
    texts = [_at_place(number, place, unit, sign=sign, is_positive=low >= 0) for number in (value, low, high)]
    error_text = _at_place(half, place, unit)
    if is_even and error is None and low > 0 and float(texts[0]) <= float(error_text):
        is_even = False  # 10.4 ± 9.97 as 10 ± 10 would reach zero
    return Rounded(value=texts[0], low=texts[1], high=texts[2], error=error_text if is_even else "")


def significant(value: float, digits: int = 3, *, sign: str = "", zeros: bool = False) -> str:
    """A number without an error, with some significant digits, and without an exponent up to a million.

    Parameters
    ----------
    value : float
    digits : int
    sign : str
        ``"+"`` also for positive numbers.
    zeros : bool
        Whether zeros at the end are kept.

    Returns
    -------
    str

    Examples
    --------
    >>> significant(5483.0), significant(0.51234, 2), significant(0.2, 2, zeros=True)
    ('5480', '0.51', '0.20')
    """
    text = f"{value:{sign}{'#' if zeros else ''}.{digits}g}".rstrip(".")
    return f"{float(text):{sign}.0f}" if "e+" in text and abs(value) < 1e6 else text


def _at_place(number: float, place: int, unit: int, *, sign: str = "", is_positive: bool = False) -> str:
    """A number rounded to a power of ten, in units of 10**`unit`."""
    if not math.isfinite(number):
        return f"{number:{sign}g}"
    if is_positive and 0 < number < 0.5 * 10.0**place:
        place = math.floor(math.log10(number))
    decimals = max(unit - place, 0)
    text = f"{round(number, -place) / 10.0**unit if unit else round(number, -place):{sign}.{decimals}f}"
    if not float(text):
        text = text.replace("-", "")  # of a negative zero
    return f"{text}e{unit}" if unit else text


def two_digits(value: float) -> str:
    """A limit, a share or a factor with two significant digits, see `significant`.

    Examples
    --------
    >>> two_digits(0.2431), two_digits(218.0)
    ('0.24', '220')
    """
    return significant(value, 2)


def limit_text(limit: float) -> str:
    """An upper limit with two significant digits, zeros kept.

    Examples
    --------
    >>> limit_text(0.2), limit_text(218.0)
    ('below 0.20', 'below 220')
    """
    return f"below {significant(limit, 2, zeros=True)}"
