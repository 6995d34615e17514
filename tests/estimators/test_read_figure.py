"""Coefficients of figures: intervals that include the errors of reading, and what the length of the record changes."""

import math

import numpy as np
import pytest

import sigmatau as st
from drawn_curves import TERMS, TRUTH, by_hand, deviation, drawn, times
from known import seed_of

LEVEL = 0.95
PER_DECADE = 60.0  # [pixels]


def clicked(path, tau, adev, error, rng):
    """Write clicked points of a curve with errors in both coordinates; returns the clicked points of the two axes."""
    places = np.stack([100 + PER_DECADE * np.log10(tau / 0.01), 400 - PER_DECADE * np.log10(adev / 1e-6)], axis=1)
    np.savetxt(path, places + error * rng.standard_normal(places.shape), delimiter=",", header="x,y", comments="")
    clicks = error * rng.standard_normal(4)
    x_axis = {100 + clicks[0]: 0.01, 100 + 4 * PER_DECADE + clicks[1]: 100.0}
    return x_axis, {400 + clicks[2]: 1e-6, 400 - 3 * PER_DECADE + clicks[3]: 1e-3}


def coverage(fits):
    """Number of intervals or limits with the true value, by term, and the number of fits with terms."""
    fits = [each for each in fits if each.verdict == "adequate"]
    counts = dict.fromkeys(TRUTH, 0)
    for each in fits:
        for name, truth in TRUTH.items():
            term = each[name]
            low, high = (term.low, term.high) if term.observed else (0.0, term.upper_limit)
            counts[name] += low <= truth <= high
    return counts, len(fits)


def check(fits, runs):
    counts, count = coverage(fits)
    assert count >= 0.97 * runs
    margin = 3 * math.sqrt(LEVEL * (1 - LEVEL) / count)
    for name, covered in counts.items():
        assert abs(covered / count - LEVEL) < margin, (name, covered, count)


@pytest.mark.long
def test_intervals_of_clicked_points_hold(tmp_path):
    """Errors of reading alone: in a record of years those of the curve are smaller."""
    runs, fits = 200, []
    for k in range(runs):
        rng = np.random.default_rng(seed_of(f"clicked {k}"))
        x_axis, y_axis = clicked(tmp_path / "c.csv", times(), deviation(times()), 1.0, rng)
        options = {"x_axis": x_axis, "y_axis": y_axis, "point_error": 1.0, "rate": 100, "duration": 1e7}
        fits.append(st.fit(st.read_figure(tmp_path / "c.csv", unit="rad/s", **options)["gyro"], terms=TERMS))
    check(fits, runs)


@pytest.mark.long
def test_intervals_of_clicked_points_of_a_record_hold(tmp_path):
    """Errors of reading and of the curve of a record of 50 minutes."""
    runs, fits = 300, []
    model = st.NoiseModel(channels={"gyro_x": TRUTH})
    for k in range(runs):
        seed = seed_of(f"clicked record {k}")
        curve = st.allan(st.simulate(model, duration=3000, rate=20, rng=seed))["gyro_x"]
        rng = np.random.default_rng(seed + 1)
        x_axis, y_axis = clicked(tmp_path / "c.csv", curve.tau[:-2], curve.adev[:-2], 0.6, rng)
        options = {"x_axis": x_axis, "y_axis": y_axis, "point_error": 0.6, "rate": 20, "duration": 3000}
        fits.append(st.fit(st.read_figure(tmp_path / "c.csv", unit="rad/s", **options)["gyro"], terms=TERMS))
    check(fits, runs)


@pytest.mark.long
def test_intervals_of_drawn_figures_hold(tmp_path):
    """Drawn lines are read more exactly than their width, which is the stated error: the intervals hold, and are narrow."""
    pytest.importorskip("matplotlib")
    fits, runs = [], 40
    for k in range(runs):
        rng = np.random.default_rng(seed_of(f"drawn {k}"))
        style = {"width": rng.uniform(0.5, 4), "size": rng.uniform((3, 2.5), (11, 8)), "grid": bool(k % 2)}
        path = drawn(
            tmp_path / ("texts.svg" if k % 3 else "outlines.svg"), tau=times(count=rng.integers(25, 90)), **style
        )
        fits.append(st.fit(st.read_figure(path, unit="deg/h", rate=100, duration=1e7)["gyro"], terms=TERMS))
    counts, count = coverage(fits)
    assert count == runs
    assert min(counts.values()) >= 0.95 * count
    walks = [each["random_walk"] for each in fits]
    assert max((walk.high - walk.low) / walk.value for walk in walks) < 0.1


def test_the_error_of_the_scale_is_common(tmp_path):
    """Two clicks a decade apart, each wrong by 2 %: an error of all coefficients that more points do not reduce."""
    tau, adev = times(80), deviation(times(80))
    np.savetxt(tmp_path / "c.csv", np.stack([np.log10(tau), -np.log10(adev)], axis=1), delimiter=",")
    error = math.log10(1.02)
    options = {"x_axis": {-2.0: 0.01, 3.0: 1000.0}, "y_axis": {6.0: 1e-6, 3.0: 1e-3}, "rate": 100, "duration": 1e7}
    curve = st.read_figure(tmp_path / "c.csv", unit="rad/s", point_error=error, **options)["gyro"]
    covariance = curve.digitising
    far = covariance[0, len(tau) // 3]
    assert 0.3 * 0.02**2 < far < 1.5 * 0.02**2
    fit = st.fit(curve, terms=TERMS)
    half = (fit["random_walk"].high - fit["random_walk"].low) / (2 * fit["random_walk"].value)
    assert half > 1.96 * math.sqrt(0.3) * 0.02


def test_values_without_axes(tmp_path):
    tau = times()
    np.savetxt(tmp_path / "c.csv", np.stack([tau, 3600 * np.degrees(deviation(tau))], axis=1), delimiter=",")
    with pytest.raises(st.OptionError, match="give their relative error"):
        st.read_figure(tmp_path / "c.csv", unit="deg/h")
    curve = st.read_figure(tmp_path / "c.csv", unit="deg/h", point_error=0.02)["gyro"]
    assert curve.adev == pytest.approx(deviation(curve.tau), rel=5e-3)
    assert np.sqrt(np.diag(curve.digitising)[0]) == pytest.approx(0.02 * math.sqrt(1 + 1 + 0.25 + 0.25), rel=0.05)
    with pytest.raises(st.OptionError, match="is relative"):
        st.read_figure(tmp_path / "c.csv", unit="deg/h", point_error=2)


def test_several_clicked_curves_share_a_table(tmp_path):
    """Their points are at different x: the cell of a curve without a point in a row is empty."""
    tau = times(20)
    x, y = 100 + 80 * np.log10(tau), 100 - 90 * np.log10(deviation(tau))
    rows = [f"{a:.2f},{b:.2f}," for a, b in zip(x, y, strict=True)]
    rows += [f"{a + 0.3:.2f},,{b - 27.09:.2f}" for a, b in zip(x[:15], y[:15], strict=True)]
    path = tmp_path / "c.csv"
    path.write_text("\n".join(["x,gyro_x,gyro_y", *sorted(rows)]) + "\n")
    axes = {"x_axis": {100: 1, 180: 10}, "y_axis": {100: 1, 190: 0.1}}
    columns = {"x": "1", "gyro_x": "2", "gyro_y": "3"}
    curves = st.read_figure(path, unit="rad/s", columns=columns, **axes)
    assert (len(curves["gyro_x"].tau), len(curves["gyro_y"].tau)) == (20, 15)
    assert curves["gyro_x"].adev == pytest.approx(deviation(curves["gyro_x"].tau), rel=3e-3)
    assert curves["gyro_y"].adev == pytest.approx(2 * deviation(curves["gyro_y"].tau), rel=0.012)
    alone = st.read_figure(path, unit="rad/s", columns={"x": "1", "gyro_y": "3"}, **axes)["gyro_y"]
    assert np.array_equal(alone.adev, curves["gyro_y"].adev)
    path.write_text("\n".join(["x,gyro_x,gyro_y", *rows[:23]]) + "\n")
    with pytest.raises(st.DataError, match=r"has 3 points of gyro_y\. Click 8 or more"):
        st.read_figure(path, unit="rad/s", columns=columns, **axes)
    path.write_text("\n".join(["x,gyro_x,gyro_y", *rows[:19], ",5,6"]) + "\n")
    with pytest.raises(st.DataError, match=r"the point is not two numbers\. Remove this row"):
        st.read_figure(path, unit="rad/s", columns=columns, **axes)


def test_an_unknown_length_is_the_shortest_possible(tmp_path):
    """The intervals are then wider than for any other length, and contain those of a stated one."""
    path = by_hand(tmp_path / "hand.svg")
    default = st.read_figure(path, unit="deg/h")["gyro"]
    assert default.n == 2 * default.m[-1]
    assert default.tau0 == pytest.approx(0.01)
    stated = st.read_figure(path, unit="deg/h", rate=100, duration=24 * 3600)["gyro"]
    wide, narrow = (st.fit(curve, terms=TERMS)["bias_instability"] for curve in (default, stated))
    assert wide.low < narrow.low
    assert narrow.high < wide.high
    for options, message in (
        ({"duration": 100}, "above half of the record"),
        ({"rate": 10}, "below the sample interval"),
    ):
        with pytest.raises(st.DataError, match=message):
            st.read_figure(path, unit="deg/h", **options)


def test_the_curve_has_the_error_of_reading(tmp_path):
    curve = st.read_figure(by_hand(tmp_path / "hand.svg"), unit="deg/h", rate=100, duration=1e5)["gyro"]
    bare = st.read_figure(by_hand(tmp_path / "hand.svg"), unit="deg/h", rate=100, duration=1e5, point_error=1e-9)[
        "gyro"
    ]
    assert np.all(curve.error > bare.error)
    low, high = curve.interval(noise=TRUTH)
    bare_low, bare_high = bare.interval(noise=TRUTH)
    assert np.all(low < bare_low)
    assert np.all(bare_high < high)
    assert "error of reading the figure" in curve.interval_text
    assert curve.to_dict()["digitising_error"] == pytest.approx(np.sqrt(np.diag(curve.digitising)))
    part = curve.at(curve.m[3:9])
    assert np.array_equal(part.digitising, curve.digitising[3:9, 3:9])
    walk = st.read_off(curve)["random_walk"]
    assert walk.value - 2 * walk.error < TRUTH["random_walk"] < walk.value + 2 * walk.error


@pytest.mark.parametrize(
    ("rows", "options", "message"),
    [
        ("x,y\n1,2\n", {"point_error": 0.02}, "has 1 points. Click 8 or more"),
        ("x,y,z\n1,2,3\n", {"point_error": 0.02}, "has 3 columns: x, y, z. Name two"),
        ("".join(f"{k // 2},{k + 1}\n" for k in range(20)), {"point_error": 0.02}, "two points at x = 0"),
        ("".join(f"{k + 1},{k}\n" for k in range(20)), {"point_error": 0.02}, "values that are not positive"),
        ("".join(f"{k + 1},{k + 1}\n" for k in range(20)), {"line": 1}, "is for SVG and PDF files"),
        ("".join(f"{k + 1},{k + 1}\n" for k in range(20)), {"x_axis": {1: 1, 2: 2}}, "coordinates need two axes"),
        ("".join(f"{k + 1},{k + 1}\n" for k in range(20)), {"point_error": -1}, "must be a positive number"),
        ("".join(f"{k + 1},{k + 1}\n" for k in range(20)), {"unit": "deg/sqrt(h)"}, "is not the unit of a rate"),
    ],
)
def test_points_that_cannot_be_used(tmp_path, rows, options, message):
    (tmp_path / "c.csv").write_text(rows)
    with pytest.raises(ValueError, match=message):
        st.read_figure(tmp_path / "c.csv", **{"unit": "deg/h"} | options)
