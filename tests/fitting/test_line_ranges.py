"""Where the line of each fitted term can be laid, and what is read off there."""

from dataclasses import replace

import numpy as np
import pytest

from known import seed_of
from sigmatau import NoiseModel, Record, analyze, simulate
from sigmatau.fitting.fitted_values import FittedTerm
from sigmatau.fitting.read_off import read_off, read_off_with_fit
from sigmatau.fitting.tables import fit_table, read_off_legend
from sigmatau.units import to_si

TRUTH = {"quantization": to_si(5.1154, "arcsec"), "random_walk": to_si(0.094, "deg/sqrt(h)")}


@pytest.fixture(scope="module")
def analysis():
    model = NoiseModel(channels={"gyro_x": TRUTH})
    return analyze(simulate(model, duration=1800, rate=100, rng=seed_of("line ranges, HG1700")))


def test_ranges_end_where_the_lines_cross(analysis):
    fit = analysis["gyro_x"]
    crossing = 3 * (fit["quantization"].value / fit["random_walk"].value) ** 2
    ranges = fit.line_ranges
    assert list(ranges) == ["quantization", "random_walk"]
    eighth = 2 ** (1 / 8)
    assert ranges["quantization"][0] == 0.01
    assert crossing / eighth <= ranges["quantization"][1] <= crossing
    assert crossing <= ranges["random_walk"][0] <= crossing * eighth
    assert 1800 / 4 / eighth <= ranges["random_walk"][1] <= 1800 / 4


def test_beside_a_fit_lines_are_laid_in_its_ranges(analysis):
    read, ranges = analysis.read_off["gyro_x"], analysis["gyro_x"].line_ranges
    assert {name: one.range_from for name, one in read.items()} == {"quantization": "fit", "random_walk": "fit"}
    for name, one in read.items():
        assert ranges[name][0] <= one.tau_min
        assert one.tau_max <= ranges[name][1]
    # 1.3 % is the standard deviation of N by the likelihood of such a record; a line does not do better.
    assert read["random_walk"].value == pytest.approx(TRUTH["random_walk"], rel=0.1)
    assert read["quantization"].value == pytest.approx(TRUTH["quantization"], rel=0.01)
    assert "(τ 0.01 … 1.92 s)" in fit_table(analysis.fits, analysis.read_off)
    written = analysis.to_dict()["channels"]["gyro_x"]
    assert written["fit"]["terms"]["random_walk"]["tau_s"] == list(ranges["random_walk"])
    assert "tau_s" not in written["fit"]["terms"]["bias_instability"]  # not observed
    assert written["read_off"]["random_walk"]["range_from"] == "fit"


def test_rules_are_independent_of_the_fit(analysis):
    alone = read_off(analysis.curves["gyro_x"])
    assert {one.range_from for one in alone.values()} == {"rules"}
    assert alone["quantization"].tau_max < analysis.read_off["gyro_x"]["quantization"].tau_max


def test_the_method_reads_beside_the_fit_and_says_so(analysis):
    """The same lines as beside the coefficients of the fit; a record without a model is read by the rules."""
    model = NoiseModel(channels={"gyro_x": TRUTH})
    record = simulate(model, duration=1800, rate=100, rng=seed_of("line ranges, HG1700"))
    alone = analyze(record, method="read-off")
    assert not alone.fits
    lines, beside = alone.read_off["gyro_x"], analysis.read_off["gyro_x"]
    assert {name: line.to_dict() for name, line in lines.items()} == {
        name: line.to_dict() for name, line in beside.items()
    }
    assert "where the fitted model says that its term is most of the\n  variance" in repr(alone)
    poor = replace(analysis["gyro_x"], p_value=1e-9)
    by_rules = read_off_with_fit(analysis.curves["gyro_x"], poor, {})
    assert {line.range_from for line in by_rules.values()} == {"rules"}
    assert "By rules on the curve alone, without a model: gyro_x." in read_off_legend({"gyro_x": by_rules})


def hidden_in(fit):
    """The fit with a bias instability that is observed, and nowhere half of the variance."""
    small = 1e-3 * fit["random_walk"].value
    term = FittedTerm(term="bias_instability", unit="rad/s", observed=True, level=0.95, value=small)
    return replace(fit, terms={**fit.terms, "bias_instability": term}, model={**fit.model, "bias_instability": small})


def test_term_that_is_hidden_everywhere(analysis):
    fit = hidden_in(analysis["gyro_x"])
    assert fit.line_ranges["bias_instability"] is None
    assert fit.to_dict()["terms"]["bias_instability"]["tau_s"] is None
    read = read_off_with_fit(analysis.curves["gyro_x"], fit, {})
    assert list(read) == ["quantization", "random_walk"]
    assert [(one.term, one.reason) for one in read.refused] == [
        ("bias_instability", "other noise hides it at all averaging times")
    ]
    text = fit_table({"gyro_x": fit}, {"gyro_x": read})
    assert "not read off, hidden by other noise: bias instability" in text
    # A given range has the same answer with the slope, unless it is forced.
    spans = {"bias_instability": (100, 400)}
    by_hand = read_off_with_fit(analysis.curves["gyro_x"], fit, spans)
    assert "which has the slope -0." in by_hand.refused[-1].reason
    forced = read_off_with_fit(analysis.curves["gyro_x"], fit, spans, force=True)["bias_instability"]
    assert (forced.range_from, forced.forced) == ("given", True)


def test_lines_begin_where_the_model_describes_the_curve(analysis):
    fit = analysis["gyro_x"]
    assert replace(fit, tau_min=0.5).line_ranges["quantization"][0] == pytest.approx(0.5, rel=0.1)
    assert replace(fit, tau_min=10.0).line_ranges["quantization"] is None
    assert replace(fit, tau_min=1000.0).line_ranges == {"quantization": None, "random_walk": None}


def test_a_fit_without_intervals_says_no_ranges(analysis):
    fit = replace(analysis["gyro_x"], verdict="descriptive")
    assert fit.line_ranges == {}
    read = read_off_with_fit(analysis.curves["gyro_x"], fit, {})
    assert {one.range_from for one in read.values()} == {"rules"}


def test_behind_a_filter_the_line_begins_where_the_curve_reaches_it():
    model = NoiseModel.from_dict(
        {"channels": {"gyro_x": {"random_walk": "0.3 deg/sqrt(h)", "bandwidth": {"order": 2, "corner": "5 Hz"}}}}
    )
    fit = analyze(simulate(model, duration=600, rate=100, rng=seed_of("line ranges, filter")))["gyro_x"]
    first, last = fit.line_ranges["random_walk"]
    share = fit.model["random_walk"] ** 2 / first / fit.avar(m=[round(first * 100)])[0]
    assert 0.05 < first < 0.5  # 5 Hz
    assert 1.1 < share <= 1.25
    assert last > 100


def test_missing_samples_are_not_read_beside_a_fit():
    rng = np.random.default_rng(seed_of("line ranges, missing"))
    x = rng.standard_normal(20_000)
    x[rng.choice(len(x), 1000, replace=False)] = np.nan
    analysis = analyze(Record.from_arrays(rate=100, gyro_x=x, unit={"gyro": "rad/s"}), at_rest=True)
    assert analysis["gyro_x"]["random_walk"].observed
    read = analysis.read_off["gyro_x"]
    assert not read.coefficients
    assert {one.reason for one in read.refused} == {"5 % of the samples are missing"}
