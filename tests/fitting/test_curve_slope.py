"""The slope of a curve and its error, over records of pure terms."""

import numpy as np
import pytest

import known
import sigmatau as st
from sigmatau.noise.terms import TERMS

RECORDS = 80
STRETCH = {
    "quantization": (16, 1024),
    "random_walk": (16, 1024),
    "bias_instability": (16, 512),
    "rate_random_walk": (16, 512),
}


def curve_of(term, seed, *, n=16384):
    model = st.NoiseModel(channels={"gyro_x": {term: 1.0}})
    return st.allan(st.simulate(model, duration=n, rate=1, rng=seed))["gyro_x"]


@pytest.mark.parametrize("term", STRETCH)
def test_interval_covers_the_slope_of_the_term(term):
    first, last = STRETCH[term]
    covered, found = 0, []
    for k in range(RECORDS):
        slope = st.fit_slope(curve_of(term, known.seed_of(f"slope {term} {k}")), tau_min=first, tau_max=last)
        low, high = slope.interval()
        covered += low <= TERMS[term].slope <= high
        found.append((slope.value - TERMS[term].slope) / slope.error)
        assert term in slope.terms
    assert covered / RECORDS >= 0.95 - 3 * np.sqrt(0.95 * 0.05 / RECORDS)
    assert np.std(found) == pytest.approx(1, abs=3 / np.sqrt(2 * RECORDS) + 0.03)  # and the intervals are not too wide


def test_names_the_term():
    curve = curve_of("random_walk", known.seed_of("slope names"))
    slope = st.fit_slope(curve, tau_min=1, tau_max=100)
    assert slope.terms == ("random_walk",)
    assert slope.exponent == pytest.approx(0, abs=6 * slope.error)
    assert repr(slope).endswith(": angle random walk")
    assert slope.points == (curve.tau <= 100).sum()
    assert slope.to_dict()["tau_s"] == [1.0, slope.tau_max]


def test_a_crossing_is_no_term():
    """Half a decade on either side of where white noise meets a rate random walk the slope is 0; far off it is theirs."""
    model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1.0, "quantization": 8.0}})
    curve = st.allan(st.simulate(model, duration=200_000, rate=1, rng=known.seed_of("slope crossing")))["gyro_x"]
    slope = st.fit_slope(curve, tau_min=100, tau_max=400)  # they cross at 192 s, with the slope -3/4
    assert slope.terms == ()
    assert repr(slope).endswith("no term has this slope")


def test_short_records_exclude_no_true_term():
    """Each term is tested with the error of a curve of that term: that of quantization noise is ten times smaller."""
    missed = 0
    for k in range(RECORDS):
        curve = curve_of("random_walk", known.seed_of(f"slope short {k}"), n=600)
        missed += "random_walk" not in st.fit_slope(curve, tau_min=64, tau_max=256).terms
    assert missed / RECORDS <= 0.05 + 3 * np.sqrt(0.05 * 0.95 / RECORDS)


def test_is_the_slope_of_the_read_off():
    """One mechanism: the slope by which a line in a given range is refused."""
    curve = curve_of("rate_random_walk", known.seed_of("slope refused"))
    slope = st.fit_slope(curve, tau_min=10, tau_max=1000)
    refused = st.read_off(curve, rules={}, random_walk=(10, 1000))
    assert f"slope {slope.value:+.3f} ±" in refused.refused[0].reason
    accepted = st.read_off(curve, rules={}, rate_random_walk=(10, 1000))["rate_random_walk"]
    assert accepted.slope == slope.value
    assert slope.terms == ("rate_random_walk",)


def test_without_overlap_the_error_is_that_of_eq_26():
    model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1.0}})
    record = st.simulate(model, duration=4096, rate=1, rng=known.seed_of("slope disjoint"))
    curve = st.allan(record, overlap="none")["gyro_x"]
    slope = st.fit_slope(curve, tau_min=1, tau_max=100)
    assert abs(slope.value + 0.5) < 4 * slope.error


@pytest.mark.parametrize(
    ("message", "span"),
    [
        ("`tau_min`: must be two averaging times in s, the shorter one first", (10, 1)),
        ("`tau_min`: must be two averaging times", (0, 1)),
        ("has no averaging time from 1e\\+06 s to 2e\\+06 s", (1e6, 2e6)),
        ("has one averaging time from 1.9 s to 2.1 s, 2 s; a slope needs two", (1.9, 2.1)),
    ],
)
def test_wrong_stretches(message, span):
    curve = curve_of("random_walk", 1, n=1024)
    with pytest.raises(st.OptionError, match=message):
        st.fit_slope(curve, tau_min=span[0], tau_max=span[1])
    with pytest.raises(TypeError, match="DeviationCurve"):
        st.fit_slope({"gyro_x": curve}, tau_min=1, tau_max=10)


@pytest.mark.parametrize(("value", "text"), [(-0.4446, "mostly angle random walk"), (-0.493, "angle random walk")])
def test_a_slope_between_those_of_terms(value, text):
    slope = st.CurveSlope(
        channel="gyro_x", quantity="angular_rate", tau_min=0.1, tau_max=8, points=9, value=value, error=0.0053,
        terms=("random_walk",),
    )  # fmt: skip
    assert repr(slope).endswith(f"± 0.0053: {text}")
