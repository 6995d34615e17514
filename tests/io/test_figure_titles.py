"""Labels and titles of figures that change the values of an axis: no factor is lost without a question."""

import contextlib
import math
import time

import numpy as np
import pytest

import sigmatau as st
from drawn_curves import FORMATS, by_hand, deviation, figure, saved, times

OPTIONS = {"unit": "deg/h", "rate": 100, "duration": 1e7}
DECADES = ("0.01", "0.1", "1", "10", "100", "1000")


def raised(exponent, *, dx=0, rise=5, size=9):
    return f'10<tspan dx="{dx}" dy="-{rise}" font-size="{size}">{exponent}</tspan>'


@pytest.mark.parametrize(
    ("labels", "scale"),
    [
        (("0,001", "0,010", "0,100", "1,000"), 1e-3),
        (("1.000", "10.000", "100.000", "1.000.000"), 1e3),
        (("1,000", "10,000", "100,000", "1,000,000"), 1e3),
        (tuple(raised(k, dx=7) for k in range(4)), 1),
        (tuple(raised(k, size=12) for k in range(4)), 1),
        (tuple(raised(k, rise=1, size=8) for k in range(4)), 1),
    ],
)
def test_labels(tmp_path, labels, scale):
    curve = st.read_figure(by_hand(tmp_path / "a.svg", y=labels), **OPTIONS)["gyro"]
    assert curve.adev == pytest.approx(scale * deviation(curve.tau), rel=5e-3)


def test_powers_without_raised_exponents_are_a_question(tmp_path):
    path = by_hand(tmp_path / "a.svg", y=("100", "101", "102", "103"))
    with pytest.raises(st.OptionError, match="no labels beside ticks"):
        st.read_figure(path, **OPTIONS)


def test_exponents_beside_logarithmic_ticks_are_a_question(tmp_path):
    minor = "".join(f"M0 {300 - 100 * (k + math.log10(d)):.3f}H500" for k in range(3) for d in range(2, 10))
    path = by_hand(tmp_path / "a.svg", y=("0", "1", "2", "3"), rest=f'<path stroke="#ccc" d="{minor}"/>')
    with pytest.raises(st.OptionError, match="no labels beside ticks"):
        st.read_figure(path, **OPTIONS)


@pytest.mark.parametrize("name", FORMATS)
def test_a_factor_is_a_question(tmp_path, name):
    pytest.importorskip("matplotlib")
    if name.endswith("pdf"):
        pytest.importorskip("pypdfium2")
    drawing, axes = figure()
    axes.set(yscale="linear", ylabel="")
    axes.plot(times(), deviation(times()))
    axes.ticklabel_format(axis="y", style="sci", scilimits=(0, 0))
    with pytest.raises(st.OptionError, match="y axis have a factor"):
        st.read_figure(saved(drawing, tmp_path / name), **OPTIONS)


@pytest.mark.parametrize("name", FORMATS)
@pytest.mark.parametrize(
    ("title", "unit"),
    [("σ [°/s]", "°/s"), ("σ (mdps)", "mdps"), ("ADEV, dps", "dps"), (r"$\sigma$ [$^\circ$/s]", "°/s")],
)
def test_another_unit_in_the_title_is_a_question(tmp_path, name, title, unit):
    pytest.importorskip("matplotlib")
    if name.endswith("pdf"):
        pytest.importorskip("pypdfium2")
    drawing, axes = figure()
    axes.set_ylabel(title)
    axes.plot(times(), deviation(times()))
    path = saved(drawing, tmp_path / name)
    with pytest.raises(st.OptionError, match=f"y axis in {unit}, not deg/h"):
        st.read_figure(path, **OPTIONS)
    assert st.read_figure(path, **{**OPTIONS, "unit": unit})["gyro"].adev.min() > 0


def test_two_units_on_a_page_are_a_question(tmp_path):
    """Nothing shows which of the panels a line is in."""
    titles = ("σ [deg/h]", "σ [µg]")
    rest = "".join(
        f'<text transform="translate({-50 - 600 * k} 200) rotate(-90)">{t}</text>' for k, t in enumerate(titles)
    )
    path = by_hand(tmp_path / "a.svg", rest=rest)
    for unit, others in (("deg/h", "µg"), ("ug", "deg/h")):
        with pytest.raises(st.OptionError, match=f"has y axes in {unit} and {others}"):
            st.read_figure(path, **{**OPTIONS, "unit": unit})
    curve = st.read_figure(path, y_axis={320: 1, 20: 1000}, **OPTIONS)["gyro"]
    assert curve.adev == pytest.approx(deviation(curve.tau), rel=5e-3)


@pytest.mark.parametrize("unit", ["(deg/h)²", "deg²/h²"])
def test_squares_in_the_title_are_a_question(tmp_path, unit):
    rest = f'<text transform="translate(-50 200) rotate(-90)">AVAR [{unit}]</text>'
    path = by_hand(tmp_path / "a.svg", rest=rest)
    with pytest.raises(st.OptionError, match="has variances"):
        st.read_figure(path, **OPTIONS)
    curve = st.read_figure(path, content="variance", **OPTIONS)["gyro"]
    assert curve.adev[0] == pytest.approx(
        np.radians(1 / 3600) * np.sqrt(deviation(0.01) / np.radians(1 / 3600)), rel=5e-3
    )


TITLES = (
    *(
        "Averaging Time (Hours)",
        "Time, hours",
        "τ / h",
        "Frequency [Hz]",
        "τ (msec)",
        "τ [usec]",
        "time (milliseconds)",
    ),
    *("number of samples", "Samples per cluster"),
)


@pytest.mark.parametrize("title", TITLES)
def test_another_unit_along_x_is_a_question(tmp_path, title):
    path = by_hand(tmp_path / "a.svg", rest=f'<text x="250" y="340">{title}</text>')
    with pytest.raises(st.OptionError, match="has an x axis in"):
        st.read_figure(path, **OPTIONS)


def test_linear_axes_of_logarithms_are_a_question(tmp_path):
    path = by_hand(tmp_path / "a.svg", y=("1", "2", "3", "4"), rest='<text x="0" y="-9">log10 σ</text>')
    with pytest.raises(st.OptionError, match="a title has a logarithm"):
        st.read_figure(path, **OPTIONS)


@pytest.mark.parametrize(
    "rest",
    [
        '<text x="1" y="2">' + "1" * 2_000_000 + "</text>",
        "".join(f'<text x="5" y="{k / 100}">{k % 1000}</text>' for k in range(30_000)),
        '<path stroke="#00f" fill="none" d="M0 0h9v1h9v1h9v1h9v1h9v1h9v1h9v1"/>' * 3000,
        '<text font-size="0" x="5" y="5">10</text>',
    ],
    ids=["long text", "many texts", "many lines", "no size"],
)
def test_damage_is_no_delay(tmp_path, rest):
    before = time.process_time()
    with contextlib.suppress(st.DataError):
        st.read_figure(by_hand(tmp_path / "a.svg", rest=rest), line="#e3001b", **OPTIONS)
    assert time.process_time() - before < 30


@pytest.mark.parametrize("name", FORMATS)
def test_a_curve_cut_by_the_axes(tmp_path, name):
    """A point just outside of the axes is hidden, and does not take the curve out of the reach of the labels."""
    pytest.importorskip("matplotlib")
    if name.endswith("pdf"):
        pytest.importorskip("pypdfium2")
    drawing, axes = figure()
    axes.plot(times(), np.degrees(deviation(times())) * 3600)
    axes.set(xlim=(0.1, 500), ylim=(20, 80))
    curve = st.read_figure(saved(drawing, tmp_path / name), **OPTIONS)["gyro"]
    assert curve.adev == pytest.approx(deviation(curve.tau), rel=1e-2)


@pytest.mark.parametrize(
    ("x", "y"),
    [
        (("10 ms", "100 ms", "1 s", "10 s", "100 s", "1 ks"), ("1", "10", "100", "1k")),
        (("10ms", "100ms", "1s", "10s", "100s", "1000s"), ("1", "10", "100", "1 K")),
        (("10000 µs", "100000 us", "1 s", "10 s", "100 s", "1000 s"), ("1", "10", "0.1k", "0,001M")),
        (("10m", "100m", "1", "10", "100", "1k"), ("1000m", "10", "100", "1k")),
        (("10⁻² s", "10⁻¹ s", "10⁰ s", "10¹ s", "10² s", "10³ s"), ("1", "10", "100", "1000")),
    ],
)
def test_prefixes_and_units_of_time_in_labels(tmp_path, x, y):
    curve = st.read_figure(by_hand(tmp_path / "a.svg", x=x, y=y), **OPTIONS)["gyro"]
    assert curve.tau[0] == pytest.approx(0.01)
    assert curve.adev == pytest.approx(deviation(curve.tau), rel=5e-3)


def test_minutes_hours_and_days_in_labels(tmp_path):
    pytest.importorskip("matplotlib")
    drawing, axes = figure()
    axes.plot(times(), np.degrees(deviation(times())) * 3600)
    axes.set_xticks([0.01, 1, 60, 3600, 86400], ["10 ms", "1 s", "1 min", "1 h", "1 d"])
    curve = st.read_figure(saved(drawing, tmp_path / "texts.svg"), **OPTIONS)["gyro"]
    assert curve.tau[0] == pytest.approx(0.01, rel=1e-3)
    assert curve.adev == pytest.approx(deviation(curve.tau), rel=3e-3)


@pytest.mark.parametrize(
    ("labels", "message"),
    [
        ({"x": ("0.001 m", "0.01 m", "0.1 m", "1 m", "10 m", "100 m")}, "m can be milli or minutes"),
        ({"y": ("1 m", "10 m", "100 m", "1000 m")}, "m can be milli or minutes"),
        ({"x": ("0.01", "0.1", "1", "10", "100", "1000 s")}, "not all labels of its x axis have a unit"),
        ({"y": ("1 s", "10 s", "100 s", "1000 s")}, "the labels of its y axis are times"),
        ({"x": ("0.01", "0.1", "1", "10", "100", "1000 ms")}, "the label 1000 ms of its x axis contradicts"),
        ({"x": ("0.01 kg", "0.1 kg", "1 kg", "10 kg", "100 kg", "1 t")}, "x axis has no labels beside ticks"),
        ({"y": ("1", "10 k", "100", "1000")}, "y axis"),
    ],
)
def test_labels_whose_suffix_is_not_clear_are_a_question(tmp_path, labels, message):
    with pytest.raises(st.OptionError, match=message):
        st.read_figure(by_hand(tmp_path / "a.svg", **labels), **OPTIONS)


@pytest.mark.parametrize("text", ["[°/s]", "σ [°/s]", "ADEV, °/s"])
@pytest.mark.parametrize("name", FORMATS)
def test_a_unit_above_the_y_axis_is_compared(tmp_path, name, text):
    pytest.importorskip("matplotlib")
    if name.endswith("pdf"):
        pytest.importorskip("pypdfium2")
    drawing, axes = figure()
    axes.set_ylabel("")
    axes.text(-0.08, 1.04, text, transform=axes.transAxes)
    axes.plot(times(), deviation(times()))
    path = saved(drawing, tmp_path / name)
    with pytest.raises(st.OptionError, match="y axis in °/s, not deg/h"):
        st.read_figure(path, **OPTIONS)
    assert st.read_figure(path, **{**OPTIONS, "unit": "°/s"})["gyro"].adev.min() > 0


def test_other_texts_above_the_figure_are_not_compared(tmp_path):
    """A caption far to the right, and a text above an axis whose title has the unit."""
    title = '<text transform="translate(-50 200) rotate(-90)">σ [deg/h]</text>'
    for rest in ('<text x="200" y="-9">Noise, °/s</text>', title + '<text x="-20" y="-9">of a gyro in °/s</text>'):
        curve = st.read_figure(by_hand(tmp_path / "a.svg", rest=rest), **OPTIONS)["gyro"]
        assert curve.adev == pytest.approx(deviation(curve.tau), rel=5e-3)
