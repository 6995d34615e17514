"""Coefficients of figures: intervals that include the errors of reading, and what the length of the record changes."""

import math

import numpy as np
import pytest

import sigmatau as st
from drawn_curves import TERMS, TRUTH, by_hand, deviation, drawn, times
from known import seed_of

LEVEL = 0.95
CURVE = "".join(f"{15 * k},{200 - 10 * k}\n" for k in range(20))
AXES = {"x_axis": {0: 0.01, 300: 1000}, "y_axis": {300: 1, 0: 1000}}
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


def test_points_of_an_axis_that_are_close_are_refused(tmp_path):
    """A tenth of a decade: the scale at the curve would be wrong by more than an interval states."""
    tau, rng = times(24), np.random.default_rng(seed_of("close"))
    x_axis, y_axis = clicked(tmp_path / "c.csv", tau, deviation(tau), 1.0, rng)
    options = {"unit": "rad/s", "x_axis": x_axis, "y_axis": y_axis}
    assert st.read_figure(tmp_path / "c.csv", **options)["gyro"].adev == pytest.approx(deviation(tau), rel=0.2)
    close = {"x_axis": {100: 0.01, 106: 0.01 * 10**0.1}, "y_axis": {400: 1e-6, 394: 1e-6 * 10**0.1}}
    for name, axis in close.items():
        with pytest.raises(st.OptionError, match=f"points of the {name[0]} axis are too close"):
            st.read_figure(tmp_path / "c.csv", **options | {name: axis})
    with pytest.raises(st.OptionError, match="are too close"):
        st.read_figure(tmp_path / "c.csv", **options, point_error=1e9)


def test_the_ends_of_a_curve_are_read_with_an_error(tmp_path):
    """Clicks beside the first sample and half of the record are no contradiction, those far away are."""
    tau = np.geomspace(0.01, 500.0, 24)
    x, y = 100 + 30 * np.log10(tau), 400 - 60 * np.log10(deviation(tau))
    x[0] -= 5
    x[-1] += 3
    np.savetxt(tmp_path / "c.csv", np.stack([x, y], axis=1), delimiter=",")
    axes = {"x_axis": {40: 0.01, 190: 1000}, "y_axis": {760: 1e-6, 580: 1e-3}, "unit": "rad/s"}
    curve = st.read_figure(tmp_path / "c.csv", rate=100, duration=1000, point_error=3, **axes)["gyro"]
    assert (curve.m[0], curve.m[-1], curve.n) == (1, 50_000, 100_000)
    assert curve.adev[[0, -1]] == pytest.approx(deviation(tau[[0, -1]]), rel=0.3)
    for options in ({"rate": 30, "duration": 1000}, {"rate": 100, "duration": 300}):
        with pytest.raises(st.DataError, match="an averaging time of"):
            st.read_figure(tmp_path / "c.csv", point_error=1, **options, **axes)


def test_the_weight_of_a_point_on_a_linear_axis_does_not_follow_its_error(tmp_path):
    """A flat curve 8 pixels above 0, clicked a pixel too high and too low in turns."""
    y = 400 - 8 + np.resize([1, -1], 24)
    np.savetxt(tmp_path / "c.csv", np.stack([10 * np.arange(24), y], axis=1), delimiter=",")
    axes = {"x_axis": {0: 0.01, 230: 1000}, "y_axis": {400: 0, 100: 300}, "linear": "y"}
    curve = st.read_figure(tmp_path / "c.csv", unit="deg/h", rate=100, duration=1e6, **axes)["gyro"]
    errors = np.sqrt(np.diag(curve.digitising))
    assert errors[3:-3] == pytest.approx(errors[4], rel=0.1)
    assert curve.adev[[4, 5]] == pytest.approx(np.radians(np.array([7, 9]) / 3600), rel=0.04)


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
        (CURVE, AXES | {"duration": 1e18}, r"has a record of 1e\+20 samples\. Correct the x axis"),
        (CURVE, AXES | {"rate": 1e14}, "has a record of"),
        (CURVE, AXES | {"x_axis": {0: 1e-300, 300: 1e300}}, "are too close, or a value is wrong"),
        (CURVE, AXES | {"y_axis": {300: 1e-300, 0: 1e300}}, "are too close, or a value is wrong"),
        (CURVE, AXES | {"y_axis": {200: 1e-300, 195: 1}, "point_error": 1e-5}, "not positive or too large"),
    ],
)
def test_points_that_cannot_be_used(tmp_path, rows, options, message):
    (tmp_path / "c.csv").write_text(rows)
    with pytest.raises(ValueError, match=message):
        st.read_figure(tmp_path / "c.csv", **{"unit": "deg/h"} | options)
