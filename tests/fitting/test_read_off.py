"""Reading off: exact curves, what is refused, and how often a term is invented."""

import re

import numpy as np
import pytest

from known import seed_of
from sigmatau import NoiseModel, OptionError, Record, allan, analyze, read_off, simulate
from sigmatau.estimators.allan import DeviationCurve
from sigmatau.estimators.deviation_kinds import cluster_sizes
from sigmatau.fitting.read_off_regions import RULES
from sigmatau.noise.terms import TERMS, avar
from sigmatau.noise.uncertainty import percentage_error
from sigmatau.units import to_si


def exact(coefficients, *, rate=100.0, n=720_000, grid="octave", quantity="angular_rate", unit="rad/s"):
    """The curve that a mixture has on average."""
    m = cluster_sizes(grid, n=n, tau0=1 / rate)
    values = sum(avar(t, c, m=m, tau0=1 / rate) for t, c in coefficients.items())
    return DeviationCurve(
        channel="x",
        quantity=quantity,
        unit=unit,
        m=m,
        tau=m / rate,
        avar=values,
        n_pairs=n + 1 - 2 * m,
        ramp=np.zeros(len(m)),
        n=n,
        tau0=1 / rate,
    )


@pytest.mark.parametrize("grid", ["octave", "half", "quarter"])
@pytest.mark.parametrize("term", TERMS)
def test_one_term_alone_is_read_exactly(term, grid):
    found = read_off(exact({term: 3.7e-5}, grid=grid))
    assert list(found) == [term]
    c = found[term]
    assert c.value == pytest.approx(3.7e-5, rel=1e-9)
    assert c.slope == pytest.approx(TERMS[term].slope, abs=0.03)
    assert 1310 < c.tau_max <= 1800  # the last averaging time up to a quarter of the record
    # error by eq. (26) at the longest averaging time of the region
    assert c.error / c.value == pytest.approx(percentage_error(720_000, c.tau_max * 100)[0], rel=1e-9)


def test_paper_hg1700_gyro_x():
    """Table IV: 5.1154 arcsec and 0.094 deg/√h, the ± of the random walk 33 %."""
    truth = {"quantization": to_si(5.1154, "arcsec"), "random_walk": to_si(0.094, "deg/sqrt(h)")}
    found = read_off(exact(truth))
    assert list(found) == ["quantization", "random_walk"]
    # The lines add up to the curve, so neither holds the other term.
    for term, value in truth.items():
        assert found[term].value == pytest.approx(value, rel=1e-8)
    assert found["quantization"].tau_max < 2.468 < found["random_walk"].tau_min  # where the two lines cross
    assert found["random_walk"].percentage == pytest.approx(0.3336, abs=1e-4)
    assert found.texts("random_walk")[0][1] == "deg/√h"
    assert found.texts("quantization")[0][1] == "arcsec"


@pytest.mark.parametrize(
    ("quantity", "unit", "texts"),
    [
        ("angular_rate", "rad/s", ["arcsec", "deg/√h", "deg/h", "deg/h/√h", "deg/h²"]),
        ("acceleration", "m/s^2", ["m/s", "m/s/√h", "m/s/h", "m/s/h^{3/2}", "m/s/h²"]),
        ("signal", "V", ["mV·s", "mV/√Hz, two-sided", "mV", "mV/√s", "mV/s"]),
        ("signal", "1", ["s", "√s", "1", "1/√s", "1/s"]),
    ],
)
def test_units(quantity, unit, texts):
    for term, text in zip(TERMS, texts, strict=True):
        found = read_off(exact({term: 1e-3}, quantity=quantity, unit=unit))
        assert found.texts(term)[0][1] == text
    if quantity == "acceleration":
        found = read_off(exact({"bias_instability": 9.80665e-6}, quantity=quantity, unit=unit))
        assert [u for _, u in found.texts("bias_instability")] == ["m/s/h", "µg"]
        assert found.texts("bias_instability")[1][0].startswith("1.0")


def test_valley_between_random_walks_is_no_bias_instability():
    """The paper reads any valley as bias instability; with N and K alone B would be 1.62 √(NK)."""
    n, k = to_si(0.3, "deg/sqrt(h)"), to_si(30, "deg/h/sqrt(h)")
    found = read_off(exact({"random_walk": n, "rate_random_walk": k}, grid="quarter"))
    assert "bias_instability" not in found
    valley = allan_min(exact({"random_walk": n, "rate_random_walk": k}, grid="quarter"))
    assert valley / 0.664282 == pytest.approx(1.6176 * np.sqrt(n * k), rel=0.01)


def allan_min(curve):
    return curve.adev.min()


def test_low_pass_at_the_short_end_is_not_read():
    """White noise behind a low-pass rises into its slope −1/2: no plateau, and the random walk from beyond it."""
    from sigmatau._native import kernels

    base = exact({"random_walk": 1e-4})
    values = kernels.band_limited_avar(1e-4, "butterworth2", 3.0, base.m, base.tau0)
    curve = DeviationCurve(
        channel="x", quantity="angular_rate", unit="rad/s", m=base.m, tau=base.tau, avar=values, n_pairs=base.n_pairs,
        ramp=base.ramp,
        n=base.n, tau0=base.tau0,
    )  # fmt: skip
    found = read_off(curve)
    assert list(found) == ["random_walk"]
    assert found["random_walk"].value == pytest.approx(1e-4, rel=0.03)
    assert found["random_walk"].tau_min >= 0.16


def test_hump_is_refused_with_its_reason():
    """A sinusoid falls off like quantization noise, but from a hump."""
    from sigmatau._native import kernels

    base = exact({"random_walk": 1e-6})
    hump = kernels.gauss_markov_avar(1e-3, 20.0, base.m, base.tau0)
    curve = DeviationCurve(
        channel="x", quantity="angular_rate", unit="rad/s", m=base.m, tau=base.tau, avar=base.avar + hump,
        n_pairs=base.n_pairs, n=base.n, tau0=base.tau0, ramp=base.ramp,
    )  # fmt: skip
    found = read_off(curve)
    assert "rate_random_walk" not in found
    assert [r.term for r in found.refused] == ["rate_random_walk"]
    assert "falls below it later" in found.refused[0].reason
    assert "not rate random walk" in repr(found)


@pytest.mark.parametrize("grid", ["octave", "half", "quarter"])
@pytest.mark.parametrize(
    "mixture",
    [
        {"quantization": to_si(1, "arcsec"), "bias_instability": to_si(0.036, "deg/h")},
        {"quantization": to_si(1, "arcsec"), "bias_instability": to_si(0.1, "deg/h")},
        {"bias_instability": to_si(10, "deg/h"), "rate_ramp": to_si(470, "deg/h^2")},
        {"random_walk": to_si(0.3, "deg/sqrt(h)"), "rate_ramp": to_si(424, "deg/h^2")},
        {"random_walk": to_si(0.3, "deg/sqrt(h)"), "rate_random_walk": to_si(85, "deg/h/sqrt(h)")},
        {"quantization": to_si(25, "arcsec"), "rate_random_walk": to_si(120, "deg/h/sqrt(h)")},
    ],
)
def test_where_two_terms_cross_there_is_no_third(mixture, grid):
    """A crossing has every slope in between, for a while; on the mean curve nothing but the two may be read."""
    found = read_off(exact(mixture, grid=grid))
    assert set(found) <= set(mixture)
    assert len(found) >= 1


# Cases of docs/study/read-off.md in small: the terms that the record holds; anything else read off is invented.
CASES = {
    "quantization": {"quantization": 1e-5},
    "random walk": {"random_walk": 1e-4},
    "rate random walk": {"rate_random_walk": 1e-6},
    "N and K": {"random_walk": to_si(0.3, "deg/sqrt(h)"), "rate_random_walk": to_si(60, "deg/h/sqrt(h)")},
    "Q and K": {"quantization": to_si(25, "arcsec"), "rate_random_walk": to_si(120, "deg/h/sqrt(h)")},
}


@pytest.mark.parametrize("case", CASES)
def test_terms_are_not_invented(case):
    """At most 5 % of the records of a case, ± 3 standard errors: with 20 records, 5 % + 15 % is three of them."""
    rng = np.random.default_rng(seed_of(case))
    model = NoiseModel(channels={"gyro_x": CASES[case]})
    records = 20
    invented = dict.fromkeys(set(TERMS) - set(CASES[case]), 0)
    for _ in range(records):
        for term in read_off(allan(simulate(model, duration=1310.72, rate=100, rng=rng))["gyro_x"]):
            if term in invented:
                invented[term] += 1
    limit = records * (0.05 + 3 * np.sqrt(0.05 * 0.95 / records))
    assert max(invented.values()) <= limit, invented


def test_no_region():
    rng = np.random.default_rng(5)
    found = read_off(allan(Record.from_arrays(rate=1, y=rng.standard_normal(8)))["y"])
    assert len(found) == 0
    with pytest.raises(KeyError, match="read: none"):
        found["random_walk"]
    assert "no term has a region" in repr(found)


def test_rules_can_be_changed():
    curve = exact({"random_walk": 1e-4})
    assert len(read_off(curve, rules={})) == 0
    assert list(read_off(curve, rules={"random_walk": RULES["random_walk"]})) == ["random_walk"]


def test_a_dense_grid_reads_like_a_sparse_one():
    """Every τ of a record would be a search over 10⁸ regions; it is thinned."""
    rng = np.random.default_rng(seed_of("dense grid"))
    record = Record.from_arrays(rate=10, gyro_x=rng.standard_normal(40_000))
    dense = read_off(allan(record, taus=np.arange(1, 20_001) / 10)["gyro_x"])["random_walk"]
    sparse = read_off(allan(record, taus="quarter")["gyro_x"])["random_walk"]
    assert dense.value == pytest.approx(sparse.value, rel=0.01)
    assert dense.tau_max == pytest.approx(sparse.tau_max, rel=0.2)


def test_coefficient_in_another_unit():
    c = read_off(exact({"random_walk": to_si(0.3, "deg/sqrt(h)")}))["random_walk"]
    assert c.to("deg/√h") == pytest.approx(0.3)
    with pytest.raises(OptionError, match="does not fit"):
        c.to("deg/h")


def test_notebooks_show_what_is_printed():
    found = read_off(exact({"random_walk": 1e-4}))
    assert found._repr_html_().startswith("<pre>x: read off")


@pytest.mark.parametrize(("term", "most"), [("random_walk", 0.005), ("quantization", 0.05)])
def test_few_missing_samples_change_little_of_what_is_read(term, most):
    """1 %, the most with which anything is read off."""
    rng = np.random.default_rng(seed_of(f"read off {term}, few missing"))
    n, values = 20_000, []
    for _ in range(8):
        white = rng.normal(size=n + 1)
        x = white[1:] if term == "random_walk" else np.diff(white)
        x[rng.choice(n, n // 100, replace=False)] = np.nan
        values.append(read_off(allan(Record.from_arrays(rate=1, gyro_x=x))["gyro_x"])[term].value)
    error = np.std(values, ddof=1) / len(values) ** 0.5
    assert np.mean(values) == pytest.approx(1, abs=3 * error + most)


def test_nothing_is_read_off_where_many_samples_are_missing():
    x = np.random.default_rng(seed_of("many missing")).normal(size=5000)
    x[::20] = np.nan
    found = read_off(allan(Record.from_arrays(rate=1, gyro_x=x))["gyro_x"])
    assert not found.coefficients
    assert {one.reason for one in found.refused} == {"5 % of the samples are missing"}


@pytest.mark.parametrize(("q", "n"), [(0.973, 0.0015), (0.517, 0.0019), (0.577, 0.0018)])
def test_regions_of_the_cimu_end_where_terms_cross(q, n):
    """Table II; before, the quantization of the X gyro was read up to 1311 s, and no random walk of any."""
    truth = {"quantization": to_si(q, "arcsec"), "random_walk": to_si(n, "deg/sqrt(h)")}
    crossing = 3 * (truth["quantization"] / truth["random_walk"]) ** 2  # 351, 62 and 86 s
    found = read_off(exact(truth, rate=200, n=1_440_000, grid="half"))
    assert crossing / 5 <= found["quantization"].tau_max <= crossing / 2
    if n == 0.0015:
        assert "random_walk" not in found  # five times the crossing is a quarter of the record
    else:
        assert crossing <= found["random_walk"].tau_min <= 2 * crossing
        assert found["random_walk"].value == pytest.approx(truth["random_walk"], rel=1e-6)


def test_lines_together_follow_the_curve():
    """Each line alone would hold the other term too: HG1700's random walk by 14 %, see docs/study/read-off.md."""
    truth = {"quantization": to_si(5.1154, "arcsec"), "random_walk": to_si(0.094, "deg/sqrt(h)")}
    found = read_off(exact(truth), quantization=(0.01, 2.56), random_walk=(2.56, 1310.72))
    for term, value in truth.items():
        assert found[term].value == pytest.approx(value, rel=1e-8)
        assert found[term].range_from == "given"
    alone = read_off(exact(truth), random_walk=(2.56, 1310.72), rules={})
    assert list(alone) == ["random_walk"]
    assert alone["random_walk"].value > 1.05 * truth["random_walk"]


def test_a_given_range_overrides_the_rules():
    curve = exact({"random_walk": 1e-4}, grid="half")
    found = read_off(curve, random_walk=(1, 10))
    assert found["random_walk"].value == pytest.approx(1e-4)
    assert (found["random_walk"].tau_min, found["random_walk"].tau_max) == (1.28, 7.68)
    assert found["random_walk"].error == pytest.approx(1e-4 * percentage_error(720_000, 768)[0])
    assert "τ 1.28 … 7.68 s, given" in repr(found)
    assert found.to_dict()["random_walk"]["range_from"] == "given"
    # The random walk by the rules leaves nothing for a plateau here, and stays.
    plateau = read_off(curve, bias_instability=(2, 4))
    assert list(plateau) == ["random_walk"]
    assert plateau["random_walk"].to_dict() == read_off(curve)["random_walk"].to_dict()
    (refusal,) = plateau.refused
    assert (refusal.term, refusal.by_hand) == ("bias_instability", True)
    assert re.search(r"reach the curve there, which has the slope -0\.500 ± 0\.0\d+, not 0", refusal.reason)
    forced = read_off(curve, bias_instability=(2, 4), force=True)
    assert list(forced) == ["random_walk", "bias_instability"]
    assert forced["bias_instability"].slope == pytest.approx(-0.5)
    assert forced["random_walk"].to_dict() == plateau["random_walk"].to_dict()
    assert "given, forced: not the slope of the curve" in repr(forced)
    # Two lines cannot both be laid through the same points of one slope.
    both = read_off(curve, random_walk=(1, 10), quantization=(1, 10))
    assert list(both) == ["random_walk"]
    assert "reach the curve" in both.refused[0].reason


@pytest.mark.parametrize(
    ("truth", "term", "span", "slope"),
    [
        ({"rate_ramp": 1e-7}, "random_walk", (350, 1311), "+1.00"),
        ({"rate_random_walk": 1e-5}, "bias_instability", (1, 100), "+0.500"),
        ({"quantization": 1e-4}, "random_walk", (0.1, 10), "-1.0000"),
    ],
)
def test_a_line_where_the_curve_has_another_slope(truth, term, span, slope):
    curve = exact(truth, grid="half")
    refused = read_off(curve, rules={}, **{term: span})
    assert not refused.coefficients
    assert refused.refused[0].reason.startswith(f"the curve has the slope {slope} ± 0.")
    assert read_off(curve, rules={}, **{term: span}, force=True)[term].forced
    (true,) = truth
    assert not read_off(curve, rules={}, **{true: span})[true].forced


def test_the_error_of_a_slope_holds():
    """Standard deviation of the slope over simulated curves, against the error by eq. (26): white and red noise."""
    for term in ("random_walk", "rate_random_walk"):
        rng = np.random.default_rng(seed_of(f"slope of {term}"))
        slopes = []
        for _ in range(60):
            x = rng.standard_normal(4096)
            x = x if term == "random_walk" else np.cumsum(x)
            line = read_off(
                allan(Record.from_arrays(rate=1, gyro_x=x))["gyro_x"], rules={}, force=True, **{term: (16, 512)}
            )
            slopes.append(line[term].slope)
        # Eq. (26) is 20 % too large for white noise, and correlation makes the slope of red noise better.
        assert 0.5 < np.std(slopes, ddof=1) / line[term].slope_error < 1 + 3 / np.sqrt(2 * 60)


def test_lines_by_hand_do_not_change_the_others():
    """A line of a random walk where a ramp rises, beside a quantization noise that is given by hand."""
    truth = {"quantization": 4.667e-4, "rate_ramp": to_si(2.64, "m/s/h^2")}
    curve = exact(truth, rate=200, n=1_440_000, grid="half")
    plain, by_hand = read_off(curve), read_off(curve, random_walk=(350, 1311), quantization=(0.005, 10))
    assert by_hand["rate_ramp"].to_dict() == plain["rate_ramp"].to_dict()
    assert by_hand["quantization"].range_from == "given"
    assert by_hand["quantization"].value == pytest.approx(truth["quantization"], rel=1e-6)
    assert [refusal.term for refusal in by_hand.refused] == ["random_walk"]


def test_one_point_and_long_times():
    curve = exact({"rate_ramp": 1e-7})
    found = read_off(curve, rate_ramp=(2500, 2700))["rate_ramp"]
    assert (found.value, found.slope, found.tau_max) == (pytest.approx(1e-7), None, 2621.44)
    assert found.to_dict()["slope"] is None


@pytest.mark.parametrize(
    ("span", "message"),
    [
        ((10, 1), r"the shorter one first, not \(10, 1\)"),
        ((float("nan"), 1), r"not \(nan, 1\)"),
        ((0, 1), r"not \(0, 1\)"),
        ((1, float("inf")), r"not \(1, inf\)"),
        (5, "not 5"),
        ("ab", "not 'ab'"),
        ((1, 2, 3), r"not \(1, 2, 3\)"),
        ((True, 2), "must be two"),
        ((5000, 9000), "x has no averaging time from 5000 s to 9000 s; it has 19 from 0.01 s to 2621.44 s"),
    ],
)
def test_impossible_ranges(span, message):
    with pytest.raises(OptionError, match=message) as error:
        read_off(exact({"random_walk": 1e-4}), random_walk=span)
    assert error.value.option == "random_walk"
    assert str(error.value).startswith("`random_walk`: ")


def test_a_given_range_is_read_with_missing_samples_and_disjoint_clusters():
    rng = np.random.default_rng(seed_of("given range, gaps"))
    x = rng.standard_normal(20_000)
    x[rng.choice(len(x), 1000, replace=False)] = np.nan
    record = Record.from_arrays(rate=1, gyro_x=x)
    found = read_off(allan(record)["gyro_x"], random_walk=(1, 100))
    assert list(found) == ["random_walk"]
    # 5 % of missing samples make a random walk 2.6 % larger; the line's own error is 0.7 %.
    assert found["random_walk"].value == pytest.approx(1.026, abs=0.03)
    whole = allan(Record.from_arrays(rate=1, gyro_x=rng.standard_normal(20_000)), overlap="none")["gyro_x"]
    assert read_off(whole, random_walk=(1, 100))["random_walk"].value == pytest.approx(1, abs=0.03)


def test_ranges_by_channel_and_sensor():
    rng = np.random.default_rng(seed_of("read off at"))
    record = Record.from_arrays(rate=100, gyro=rng.standard_normal((60_000, 3)), accel=rng.standard_normal((60_000, 3)))
    found = analyze(
        record,
        method="read-off",
        at_rest=True,
        read_off_at={"random_walk": (1, 10), "gyro.random_walk": (2, 8), "gyro_x.random_walk": (4, 8)},
    ).read_off
    first = {channel: one["random_walk"].tau_min for channel, one in found.items()}
    assert first == {"gyro_x": 5.12, "gyro_y": 2.56, "gyro_z": 2.56, "accel_x": 1.28, "accel_y": 1.28, "accel_z": 1.28}
    for key, span, message in (
        ("walk", (1, 2), "`read_off_at` walk: unknown term 'walk'"),
        (
            "gyro_w.random_walk",
            (1, 2),
            "`read_off_at` gyro_w.random_walk: no channel or sensor 'gyro_w'; channels: gyro_x",
        ),
        ("random_walk", (2, 1), "`read_off_at` random_walk: must be two averaging times"),
        ("gyro.random_walk", (1e4, 1e5), "`read_off_at` gyro.random_walk: the curve of gyro_x has no averaging time"),
    ):
        with pytest.raises(OptionError) as error:
            analyze(record, method="read-off", at_rest=True, read_off_at={key: span})
        assert str(error.value).startswith(message)
    with pytest.raises(OptionError, match="must be ranges"):
        analyze(record, read_off_at=(1, 2))
