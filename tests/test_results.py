"""How numbers are printed."""

from dataclasses import replace

from findings.examples_disturbances import EXAMPLES as DISTURBANCES
from findings.examples_fit import EXAMPLES as FITS
from findings.examples_reading import EXAMPLES as FILES
from sigmatau.findings.curves import ConstantChannel
from sigmatau.findings.finding import Finding, ranked
from sigmatau.findings.wording import causes
from sigmatau.results import csv_text, wrapped


def test_finding_prints_itself():
    finding = Finding(
        details=ConstantChannel(samples=100, value=0.0, rate_unit="rad/s"), severity="error", channels=("gyro_x",)
    )
    assert str(finding) == f"error: gyro_x: {finding.message}. {finding.action}".removesuffix(". ")
    assert finding.to_dict()["code"] == finding.code == "constant_channel"
    assert finding.to_dict()["details"] == {"samples": 100, "value": 0.0, "rate_unit": "rad/s"}


def test_findings_are_ranked_by_what_they_change():
    """By the factor on the random walk, then on the bias instability, then on the rate random walk; not by kind."""
    factors = {
        "a": {"random_walk": 0.5},
        "b": {"random_walk": 1.9, "bias_instability": 9.0},
        "c": {"random_walk": 1.01},
        "d": {"bias_instability": 0.2},
        "e": {"bias_instability": 3.0, "quantization": 40.0},
        "f": {"rate_random_walk": 1e3},
        "g": {"quantization": 1e6},
        "h": {},
    }
    expected = [
        replace(DISTURBANCES[k % 2], severity="warning", channels=(name,), factors=tuple(changed.items()))
        for k, (name, changed) in enumerate(factors.items())
    ]
    no_model = next(replace(one, severity="warning") for one in FITS if one.code == "no_adequate_model")
    assert list(ranked([*reversed(expected), no_model])) == [no_model, *expected]


def test_of_one_kind_the_axis_that_changes_most_is_shown():
    spikes = next(one for one in DISTURBANCES if one.code == "spikes")
    large = replace(spikes, severity="warning", channels=("gyro_x",), size=9.0)
    wrong = replace(large, channels=("gyro_y",), size=1.0, factors=(("random_walk", 2.0),))
    (line,) = causes([large, wrong], rest="--verbose")
    assert line.startswith("! gyro y:")


def test_what_matters_most_is_said_first():
    """Errors, then that no model is adequate, then steps, which may be all of the rate random walk; each once."""
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
    found = ranked([*said, said[0]])
    assert [f.code for f in found] == [
        *("damaged", "no_adequate_model", "no_adequate_model", "not_static", "spikes", "window_chosen"),
    ]
    assert [f.channel for f in found[1:3]] == ["gyro_x", "gyro_y"]


def test_an_option_is_not_divided_at_the_end_of_a_line():
    assert wrapped(["A well-known bias: give --turn-on"], width=28) == ["A well-known bias: give", "  --turn-on"]
    assert wrapped(["a long word, and a well-known one"], width=25) == ["a long word, and a well-", "  known one"]


def test_text_of_a_table_is_no_formula_of_a_spreadsheet():
    columns = {"unit": ["=1+1", "@x", "-7", "SN=7"], "value": [-1.5e-7, 2.0, None, 3.0], "n": [-1, 2, 3, 4]}
    assert csv_text(columns) == "unit,value,n\n'=1+1,-1.5e-07,-1\n'@x,2.0,2\n'-7,,3\nSN=7,3.0,4\n"
    with_comma = csv_text(columns, decimal_comma=True)
    assert with_comma == "unit;value;n\n'=1+1;-1,5e-07;-1\n'@x;2,0;2\n'-7;;3\nSN=7;3,0;4\n"
