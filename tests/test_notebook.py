"""The notebook of the docs, cell by cell, and what their displays show."""

import ast
import json

import numpy as np
import pytest

import sigmatau as st
from conftest import ROOT
from known import seed_of
from sigmatau.errors import OptionError
from sigmatau.findings.finding import Findings

LONGEST = 100  # characters of a line that a user writes


def shown(value):
    """What a notebook displays of a value: its picture, table or text."""
    for name in ("_repr_png_", "_repr_html_"):
        if callable(made := getattr(value, name, None)) and (content := made()):
            return content
    return repr(value)


def test_every_cell_runs_and_shows_something(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    cells = json.loads((ROOT / "docs" / "notebook.ipynb").read_text(encoding="utf-8"))["cells"]
    scope, displays = {}, []
    for cell in (cell for cell in cells if cell["cell_type"] == "code"):
        assert max(len(line.rstrip()) for line in cell["source"]) <= LONGEST
        tree = ast.parse("".join(cell["source"]))
        last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
        exec(compile(tree, "notebook", "exec"), scope)
        if last is not None:
            displays.append(shown(eval(compile(ast.Expression(last.value), "notebook", "eval"), scope)))
    pictures = [one for one in displays if isinstance(one, bytes)]
    assert [one[:8] for one in pictures] == [b"\x89PNG\r\n\x1a\n"] * 3
    tables = [one for one in displays if isinstance(one, str) and "<table" in one]
    assert len(tables) == 5
    assert tables[1].count("<svg") == 3
    filtered, raw = scope["np"].std(scope["estimates"][1000:]), scope["np"].std(scope["rates"][1000:2000])
    assert filtered < raw / 3


@pytest.fixture(scope="module")
def analysis():
    y = np.random.default_rng(seed_of("frames")).standard_normal((20_000, 4)) * 1e-3
    return st.analyze(st.Record.from_arrays(rate=100, gyro=y[:, :3], accel_x=y[:, 3]))


def test_tables(analysis):
    rows = analysis.to_dataframe()
    assert list(rows)[:8] == ["channel", "term", "value", "low", "high", "unit", "observed", "trust"]
    assert list(rows["channel"].unique()) == ["gyro_x", "gyro_y", "gyro_z", "accel_x"]
    walk = rows[(rows["channel"] == "gyro_y") & (rows["term"] == "random_walk")].iloc[0]
    fitted = analysis["gyro_y"]["random_walk"]
    assert (walk["value"], walk["low"], walk["unit"], walk["trust"]) == (
        fitted.value,
        fitted.low,
        "rad/sqrt(s)",
        "good",
    )
    curves = analysis.curves.to_dataframe()
    assert len(curves) == sum(len(curve.tau) for curve in analysis.curves.values())
    np.testing.assert_array_equal(curves[curves["channel"] == "gyro_z"]["adev"], analysis.curves["gyro_z"].adev)
    assert isinstance(analysis.findings, Findings)
    assert list(analysis.findings.to_dataframe()["code"]) == [one.code for one in analysis.findings]
    assert list(analysis.fits.to_dataframe()["term"]) == list(rows["term"])


def test_a_table_without_pandas_says_what_to_do(analysis, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "pandas", None)
    with pytest.raises(ImportError, match=r"pip install pandas; .*\.columns\(\)"):
        analysis.to_dataframe()
    polars = pytest.importorskip("polars")
    assert polars.DataFrame(analysis.curves.columns()).height > 0


def test_a_channel_by_its_name(analysis):
    assert analysis["gyro_x"] is analysis.fits["gyro_x"]
    for known in (analysis, analysis.fits, analysis.curves):
        with pytest.raises(KeyError, match="no channel 'gyro_a'; channels: gyro_x, gyro_y"):
            known["gyro_a"]
    x = np.random.default_rng(1).standard_normal(1000)
    read_off = st.analyze(st.Record.from_arrays(rate=10, x=x, flat=np.ones(1000)), method="read-off")
    with pytest.raises(KeyError, match="no fit of 'x': the coefficients were read off"):
        read_off["x"]
    with pytest.raises(KeyError, match=r"no channel 'flat' .*not analysed.*; channels: x"):
        read_off["flat"]
    assert list(read_off.to_dataframe()["term"]) == ["random_walk"]
    assert "gyro_x" in analysis
    assert "gyro_a" not in analysis
    assert [analysis[name] for name in analysis] == list(analysis.fits.values())
    assert list(read_off) == []


def test_the_table_of_a_record_that_moves_has_no_rows(analysis):
    """But columns: a file of one line feed is no CSV."""
    t = np.arange(20_000) / 100
    moving = st.analyze(st.Record.from_arrays(rate=100, gyro_x=np.sin(t / 3), unit={"gyro": "rad/s"}))
    assert moving.rest.verdict == "not_at_rest"
    assert moving.columns() == {name: [] for name in analysis.columns()}


def test_deviations_of_a_model_at_averaging_times(analysis):
    model = analysis.model
    times = [0.1, 1.0, 10.0]
    expected = model["gyro_x"].adev(m=[10, 100, 1000], tau0=0.01)
    np.testing.assert_allclose(model.adev(times)["gyro_x"], expected, rtol=1e-12)
    np.testing.assert_allclose(model.adev("gyro_x", times), expected, rtol=1e-12)
    by_hand = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-3, "bias_instability": 1e-4}})
    plateau = 2 * np.log(2) / np.pi * 1e-8
    np.testing.assert_allclose(
        by_hand["gyro_x"].adev([1.0, 100.0]), np.sqrt([1e-6 + plateau, 1e-8 + plateau]), rtol=1e-5
    )
    with pytest.raises(OptionError, match="`tau`"):
        by_hand["gyro_x"].adev()
    with pytest.raises(OptionError, match="`tau` must be positive"):
        by_hand["gyro_x"].adev([0.0])


class TestFigures:
    def test_given_axes(self, analysis):
        from matplotlib.figure import Figure

        axes = Figure().subplots(1, 2)
        assert analysis.plot(ax=axes) is axes[0].figure
        assert [ax.get_title() for ax in axes] == ["Gyroscopes", "Accelerometer"]
        one = Figure().subplots()
        assert analysis.curves["gyro_x"].plot(one).axes == [one]
        with pytest.raises(OptionError, match="`ax` must be 2 axes, one a panel, not 1"):
            analysis.plot(ax=one)

    def test_lines_and_values_of_the_terms(self, analysis):
        (ax,) = analysis.plot("gyro_x").axes
        value = analysis["gyro_x"].texts("random_walk")[-1]
        assert ax.get_title() == "Gyroscope"
        assert "N" in [text.get_text() for text in ax.texts]
        assert ax.get_legend().get_texts()[0].get_text().startswith(f"gyro_x: N = {value[0]} {value[2]}")
        gyros, _ = analysis.plot().axes[:2]
        curves = [line for line in gyros.lines if line.get_label().startswith("gyro_")]
        assert len({line.get_marker() for line in curves}) == len(curves) > 1
        assert any(text.get_text().startswith(f"gyro_x: N = {value[0]}") for text in gyros.get_legend().get_texts())
