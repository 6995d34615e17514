"""Powers in the text of reports."""

import pytest

from sigmatau.reporting.markup import raised


@pytest.mark.parametrize(
    ("text", "html"),
    [
        ("f^-1.11 explains", "f<sup>-1.11</sup> explains"),
        ("0.1 m/s^2.", "0.1 m/s<sup>2</sup>."),
        ("m/s/h^{3/2}", "m/s/h<sup>3/2</sup>"),
    ],
)
def test_an_exponent_with_decimals_is_whole(text, html):
    assert raised(text) == html
