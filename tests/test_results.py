"""How numbers are printed."""

from dataclasses import replace

import pytest

from findings.examples_disturbances import EXAMPLES as DISTURBANCES
from findings.examples_fit import EXAMPLES as FITS
from findings.examples_reading import EXAMPLES as FILES
from sigmatau.findings.finding import Finding, by_severity
from sigmatau.findings.kinds.fit import ConstantChannel
from sigmatau.results import value_error_text, wrapped


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (0.973, 0.973 * 0.0758575, "0.973 ± 0.074"),  # eq. (27) of the paper
        (0.0015, 0.0015 * 0.3335868, "0.0015 ± 0.0005"),  # eq. (28)
        (2.64, 2.64 * 0.3335868, "2.64 ± 0.88"),  # eq. (29)
        (13.6, 1.4, "13.6 ± 1.4"),
        (123456, 7890, "123500 ± 7900"),
        (5.1154, 0.068, "5.115 ± 0.068"),
        (0.512, 0.00999, "0.51 ± 0.01"),
        (1e-20, 1e-22, "1e-20 ± 1e-22"),
        (2.0, 0.0, "2 ± 0"),
    ],
)
def test_value_error_text(value, error, text):
    assert value_error_text(value, error) == text


def test_finding_prints_itself():
    finding = Finding(
        details=ConstantChannel(samples=100, value=0.0, rate_unit="rad/s"), severity="error", channels=("gyro_x",)
    )
    assert str(finding) == f"error: gyro_x: {finding.message}. {finding.action}".removesuffix(". ")
    assert finding.to_dict()["code"] == finding.code == "constant_channel"
    assert finding.to_dict()["details"] == {"samples": 100, "value": 0.0, "rate_unit": "rad/s"}


def test_no_adequate_model_is_the_first_of_the_warnings():
    warnings = [replace(one, severity="warning") for one in FITS if one.code == "no_adequate_model"][:1]
    found = by_severity([*(replace(one, severity="warning") for one in DISTURBANCES[:2]), *warnings])
    assert found[0].code == "no_adequate_model"


def test_what_matters_most_is_said_first():
    """Errors, then that no model is adequate, then other warnings as they were found."""
    order = ("spikes", "window_chosen", "not_static", "no_adequate_model", "damaged")
    examples = {one.code: one for one in (*DISTURBANCES, *FITS, *FILES)}
    severities = {"window_chosen": "info", "damaged": "error"}
    said = [
        replace(examples[code], severity=severities.get(code, "warning"), channels=channels)
        for code, channels in (
            *((code, ("gyro_x",) if code == "no_adequate_model" else ()) for code in order[:4]),
            ("no_adequate_model", ("gyro_y",)),
            ("damaged", ()),
        )
    ]
    found = by_severity([*said, said[0]])
    assert [f.code for f in found] == [
        *("damaged", "no_adequate_model", "no_adequate_model", "spikes", "not_static", "window_chosen"),
    ]
    assert [f.channel for f in found[1:3]] == ["gyro_x", "gyro_y"]


def test_an_option_is_not_divided_at_the_end_of_a_line():
    assert wrapped(["A well-known bias: give --turn-on"], width=28) == ["A well-known bias: give", "  --turn-on"]
    assert wrapped(["a long word, and a well-known one"], width=25) == ["a long word, and a well-", "  known one"]
