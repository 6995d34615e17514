"""Figures: what is on them."""

import numpy as np
import pytest

import sigmatau as st
from known import seed_of
from sigmatau import Record, allan, analyze
from sigmatau.errors import OptionError
from sigmatau.lab.lots.forest import limit_axis
from sigmatau.plot.style import new_figure
from sigmatau.units import to_si


@pytest.fixture(scope="module")
def record():
    y = np.random.default_rng(4).standard_normal((20_000, 3))
    return Record.from_arrays(rate=100, gyro=y * 1e-3, accel=y * 1e-2, volts=y[:, 0], unit={"volts": "V"})


def test_panels_and_labels(record):
    figure = analyze(record, method="read-off").plot()
    titles = {ax.get_title(): ax for ax in figure.axes if ax.get_visible()}
    assert list(titles) == ["Gyroscopes", "Accelerometers", "volts"]
    gyro = titles["Gyroscopes"]
    assert gyro.get_ylabel() == "Allan deviation σ(τ) [deg/h]"
    assert titles["Accelerometers"].get_ylabel() == "Allan deviation σ(τ) [µg]"
    assert titles["volts"].get_ylabel() == "Allan deviation σ(τ) [V]"
    assert "angle random walk" in {text.get_text() for text in gyro.texts}
    assert {"gyro_x", "gyro_y", "gyro_z"} <= {text.get_text() for text in gyro.get_legend().get_texts()}


def test_the_line_passes_through_its_coefficient(record):
    analysis = analyze(record, method="read-off")
    (ax,) = [a for a in analysis.plot().axes if a.get_title() == "volts"]
    dashed = next(line for line in ax.lines if line.get_linestyle() == "--" and len(line.get_xdata()) == 2)
    x, y = (np.log(v) for v in dashed.get_data())
    slope = (y[1] - y[0]) / (x[1] - x[0])
    assert slope == pytest.approx(-0.5)
    assert np.exp(y[0] - slope * x[0]) == pytest.approx(analysis.read_off["volts"]["random_walk"].value)


def test_curves_alone(record):
    curves = allan(record)
    assert len(curves.plot().axes) == 4
    ax = curves["gyro_x"].plot(unit="deg/s").axes[0]
    assert ax.get_ylabel().endswith("[deg/s]")
    assert ax.lines[0].get_ydata()[0] == pytest.approx(np.rad2deg(curves["gyro_x"].adev[0]))
    with pytest.raises(OptionError, match="does not fit"):
        curves["gyro_x"].plot(unit="g")


def test_the_fitted_model_is_drawn_through_the_curve(record):
    analysis = analyze(record)
    (ax,) = [a for a in analysis.plot().axes if a.get_title() == "volts"]
    (curve,) = [line for line in ax.lines if line.get_label().startswith("volts")]
    model = next(line for line in ax.lines if line.get_linestyle() == "--" and len(line.get_xdata()) > 2)
    x, y = model.get_data()
    assert x.tolist() == curve.get_xdata().tolist()
    assert np.abs(np.log(y[:10] / curve.get_ydata()[:10])).max() < 0.05
    band = ax.collections[0]
    low, _ = analysis.curves["volts"].interval()
    vertices = band.get_paths()[0].vertices[:, 1]
    assert vertices.min() == pytest.approx(min(low), rel=1e-6)
    assert "95 % confidence" in " ".join(t.get_text() for t in ax.get_legend().get_texts())


def test_a_model_without_intervals_is_dotted(record):
    t = np.arange(2**17) / 100
    y = np.random.default_rng(3).standard_normal(2**17) + np.sin(0.3 * t) + np.sin(2 * t)
    analysis = analyze(Record.from_arrays(rate=100, gyro_x=y), method="gls", at_rest=True)
    assert analysis.fits["gyro_x"].verdict == "descriptive"
    (ax,) = analysis.plot().axes
    assert not [line for line in ax.lines if line.get_linestyle() == "--" and len(line.get_xdata()) > 2]
    assert [line for line in ax.lines if line.get_linestyle() == ":" and len(line.get_xdata()) > 2]


def test_a_curve_of_an_array_is_drawn_in_its_unit_or_another_one():
    curve = allan(np.random.default_rng(seed_of("curve of an array")).standard_normal(1000), rate=100, unit="deg/s")
    for unit, factor in (("deg/s", 1), ("deg/h", 3600), (None, 1)):
        (line,) = (line for line in curve.plot(unit=unit).axes[0].lines[:1])
        assert line.get_ydata() == pytest.approx(factor * curve.adev, rel=1e-12)
    with pytest.raises(OptionError, match="units that do: rad/s"):
        curve.plot(unit="g")


def test_of_every_averaging_time_as_many_are_drawn_as_can_be_told_apart(record):
    curve = allan(record, taus="all")["gyro_x"]
    line = curve.plot(unit="rad/s").axes[0].lines[0]
    x, y = line.get_data()
    assert len(curve.m) == 10_000
    assert len(x) < 2000
    assert x[:256] == pytest.approx(curve.tau[:256])
    # 256 an octave: neighbours are two such steps apart at most
    assert np.log2(x[1:] / x[:-1])[256:].max() < 2 / 256
    assert np.interp(np.log(x), np.log(curve.tau), curve.adev) == pytest.approx(y)
    assert line.get_marker() == ""
    assert allan(record, taus="eighth")["gyro_x"].plot().axes[0].lines[0].get_marker() == "o"


class TestOverlay:
    def records(self):
        whole = np.random.default_rng(1).standard_normal((20_000, 2)) * 1e-3
        return {
            f"{100 / k:g} Hz": st.allan(
                st.Record.from_arrays(rate=100 / k, gyro_x=whole[::k, 0], accel_z=whole[::k, 1])
            )
            for k in (1, 5, 20)
        }

    def test_a_panel_a_channel_a_line_a_record(self):
        curves = self.records()
        panels = st.plot_overlay(curves).axes
        assert [ax.get_title() for ax in panels] == ["gyro_x", "accel_z"]
        assert [[line.get_label() for line in ax.lines] for ax in panels] == [list(curves)] * 2
        line = panels[0].lines[1]
        np.testing.assert_allclose(line.get_xdata(), curves["20 Hz"]["gyro_x"].tau)
        np.testing.assert_allclose(line.get_ydata() * to_si(1, "deg/h"), curves["20 Hz"]["gyro_x"].adev)
        assert "deg/h" in panels[0].get_ylabel()
        assert panels[0].get_legend() is not None

    def test_a_channel_that_some_records_lack(self):
        curves = {"a": self.records()["100 Hz"], "b": {"gyro_x": self.records()["5 Hz"]["gyro_x"]}}
        gyro, accel = st.plot_overlay(curves, style="paper").axes
        assert [len(gyro.lines), len(accel.lines)] == [2, 1]

    def test_errors(self):
        with pytest.raises(OptionError, match="`curves` has no curve"):
            st.plot_overlay({"a": {}})
        volts, metres = (
            st.allan(Record.from_arrays(rate=1, x=np.arange(100.0) ** 2, unit={"x": unit})) for unit in ("V", "m")
        )
        with pytest.raises(OptionError, match="x is in m in b, and in V in another record"):
            st.plot_overlay({"a": volts, "b": metres})


@pytest.mark.parametrize(("middle", "spread"), [(1_000_020.0, 10.0), (9.80661, 1e-5), (0.3, 0.02)])
def test_a_forest_has_no_offset_at_the_corner_of_its_axis(middle, spread):
    """Means of an accelerometer, in µg and in m/s², are near gravity and differ little."""
    ax = new_figure(4, 2).subplots()
    limit_axis(ax, middle - 2 * spread, middle + 2 * spread)
    axis = ax.xaxis
    labels = [label.get_text() for label in axis.get_ticklabels()]
    assert axis.get_major_formatter().get_offset() == ""
    assert min(abs(float(label) - middle) for label in labels) < 3 * spread
