"""`sigmatau curve` of a figure: the list of its lines, the result, and what it asks for."""

import json

import numpy as np
import pytest

import sigmatau as st
from drawn_curves import DEGREES_PER_HOUR, TRUTH, by_hand, deviation, drawn, times
from sigmatau.cli import main


def run(capsys, *words):
    code = main(["curve", *map(str, words)])
    out, err = capsys.readouterr()
    return code, out, " ".join(err.split())


def test_from_a_figure_to_a_model(tmp_path, capsys):
    path = by_hand(tmp_path / "hand.svg")
    code, out, _ = run(capsys, path, "--list")
    assert code == 0
    assert "1     #e3001b  30 points" in out
    assert "log, a point is read to 0.58 %" in out
    model, result = tmp_path / "m.toml", tmp_path / "r.json"
    code, out, err = run(capsys, path, "--unit", "deg/h", "-o", model, "--json", result)
    assert code == 0
    assert out.startswith("gyro   generalised least squares")
    assert "info: the length of the record is not known" in err
    content = json.loads(result.read_text())["channels"]["gyro"]
    term = content["fit"]["terms"]["random_walk"]
    assert term["low"] < TRUTH["random_walk"] < term["high"]
    assert len(content["curve"]["digitising_error"]) == len(content["curve"]["tau_s"])
    assert st.NoiseModel.read(model).channels["gyro"]["random_walk"] == pytest.approx(term["value"])
    code, _, err = run(capsys, path, "--unit", "deg/h", "--rate", 100, "--hours", 24)
    assert code == 0
    assert "is not known" not in err


def test_a_page_of_a_pdf(tmp_path, capsys):
    pytest.importorskip("pypdfium2")
    code, out, _ = run(
        capsys, drawn(tmp_path / "type3.pdf"), "--unit", "deg/h", "--page", 1, "--line", "gyro_z=#1f77b4"
    )
    assert code == 0
    assert out.startswith("gyro_z ")


def test_clicked_points(tmp_path, capsys):
    tau = times()
    places = np.stack([250 + 80 * np.log10(tau), 400 - 90 * np.log10(DEGREES_PER_HOUR * deviation(tau))], axis=1)
    np.savetxt(tmp_path / "c.csv", places[::-1], delimiter=",", header="x,y", comments="")
    axes = ("--x-axis", "90=0.01,490=1000", "--y-axis", "400=1", "--y-axis", "130=1000")
    code, out, _ = run(capsys, tmp_path / "c.csv", "--unit", "deg/h", *axes)
    assert code == 0
    assert "angle random walk" in out


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        ((), 2, "needs the unit of its rate. Give --unit deg/h"),
        (("--unit", "deg/sqrt(h)"), 2, "is not the unit of a rate"),
        (("--unit", "deg/h", "--line", "2"), 2, "--line: no line is '2' among 1 #e3001b (30 points)"),
        (("--unit", "deg/h", "--page", "2"), 2, "--page is for PDF files"),
        (("--unit", "deg/h", "--columns", "x=1"), 2, "--columns is for tables"),
        (("--unit", "deg/h", "--linear", "y"), 2, "--linear is for stated axes"),
        (("--unit", "deg/h", "--x-axis", "1=2"), 2, "--x-axis needs two points"),
        (("--unit", "deg/h", "--x-axis", "a=2,3=4"), 2, "'a' is not a coordinate"),
        (("--unit", "deg/h", "--hours", "0.01"), 1, "above half of the record. Correct its length"),
    ],
)
def test_what_is_not_clear_is_asked(tmp_path, capsys, words, code, message):
    found, out, err = run(capsys, by_hand(tmp_path / "hand.svg"), *words)
    assert (found, out) == (code, "")
    assert message in err


def test_a_table_needs_rate_and_length(tmp_path, capsys):
    (tmp_path / "c.csv").write_text("tau,adev [deg/h]\n" + "".join(f"{k},{k}\n" for k in range(1, 20)))
    code, _, err = run(capsys, tmp_path / "c.csv", "--rate", 1)
    assert code == 2
    assert "Give --hours too" in err
    code, _, err = run(capsys, tmp_path / "absent.svg", "--unit", "deg/h")
    assert code == 1
    assert "No such file" in err
