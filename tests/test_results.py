"""How numbers are printed."""

import pytest

from sigmatau.findings.finding import Finding, by_severity
from sigmatau.results import value_error_text


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
    finding = Finding(code="c", severity="warning", message="is odd", channel="gyro_x", effect="N too large")
    assert str(finding) == "warning: gyro_x: is odd (N too large)"
    assert finding.to_dict()["code"] == "c"


def test_what_matters_most_is_said_first():
    """Errors, then that no model is adequate, then other warnings as they were found."""
    said = [
        Finding(code=code, severity=severity, message="", channel=channel)
        for code, severity, channel in (
            ("spikes", "warning", "gyro_x"),
            ("window", "info", None),
            ("not_static", "warning", "gyro_x"),
            ("no_adequate_model", "warning", "gyro_x"),
            ("no_adequate_model", "warning", "gyro_y"),
            ("damaged", "error", None),
        )
    ]
    found = by_severity([*said, said[0]])
    assert [f.code for f in found] == [
        *("damaged", "no_adequate_model", "no_adequate_model", "spikes", "not_static", "window"),
    ]
    assert [f.channel for f in found[1:3]] == ["gyro_x", "gyro_y"]
