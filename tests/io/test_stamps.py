"""Time stamps: the rate and the grid they say, right for bunched, coarse, late and lost ones; what is wrong is said."""

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from stamping import codes, found, ordered, record_of

import sigmatau
from known import seed_of
from sigmatau import NoiseModel, Record, allan, fit, simulate
from sigmatau.io.read.time import plausible, stamps
from sigmatau.io.read.time.grid import fit_grid, resolution


class TestRate:
    def test_even_stamps(self):
        one = found(np.arange(1000) / 100.0)
        assert one.rate == pytest.approx(100.0, rel=1e-13)
        assert (one.start, one.findings, one.rows, one.places, one.n) == (0.0, (), None, None, 1000)

    def test_nanoseconds_since_1970_stay_exact(self):
        start = 1_403_636_579_758_555_393
        one = found(start + 5_000_000 * np.arange(5000, dtype=np.int64), 1e-9)
        assert one.rate == pytest.approx(200.0, rel=1e-15)
        assert one.start == pytest.approx(0.758555393, abs=1e-12)
        assert one.notes == ("1403636579 s subtracted from the time stamps",)

    def test_two_stamps_that_one_double_cannot_tell_apart(self):
        t = 1_403_636_579_758_555_393 + np.arange(4, dtype=np.int64)
        assert len(set(t.astype(float))) == 1
        assert ordered(t).intervals.tolist() == [1.0, 1.0, 1.0]

    def test_few_rows(self):
        assert found(np.array([0.0, 1.0, 2.0, 3.0])).rate == pytest.approx(1.0)

    @pytest.mark.parametrize(("share", "jitter"), [(0.01, 0.1), (0.05, 0.0), (0.3, 0.1)])
    def test_lost_samples_do_not_bend_it(self, share, jitter):
        """The mean interval is too long by the share; the places are right, one by one."""
        rng = np.random.default_rng(seed_of(f"lost {share} {jitter}"))
        k = np.flatnonzero(rng.random(100_000) >= share)
        t = (k + rng.normal(0, jitter, len(k)) if jitter else k) / 100.0
        one = found(np.sort(t))
        # The line through n stamps with jitter σ of the interval: σ √12 / n^1.5.
        assert one.rate == pytest.approx(100.0, rel=4 * max(jitter, 1e-9) * 12**0.5 / len(k) ** 1.5 + 1e-13)
        np.testing.assert_array_equal(one.places, k - k[0])

    @pytest.mark.parametrize("rate", [10.0, 99.3, 400.0, 995.0])
    @pytest.mark.parametrize("digits", [3, 6])
    def test_printed_stamps(self, rate, digits):
        t = np.round(np.arange(20_000) / rate, digits)
        one = found(t)
        assert one.rate == pytest.approx(rate, rel=10.0**-digits / t[-1])
        assert (one.places, codes(one, least="warning")) == (None, [])

    def test_a_clock_a_little_too_slow(self):
        """1005 Hz printed to the millisecond: now and then a stamp comes twice, and no sample is a copy."""
        t = np.floor(np.arange(100_000) / 1005 * 1e3) / 1e3
        one = found(t)
        assert one.rate == pytest.approx(1005, rel=1e-5)
        assert (one.n, codes(one)) == (100_000, ["coarse_stamps", "rate_not_nominal"])

    def test_coarse_stamps_are_no_gaps(self):
        t = np.floor(np.arange(4000) * 0.25) / 100  # 400 Hz, printed to 0.01 s
        one = found(t)
        assert one.rate == pytest.approx(400.0, rel=1e-3)  # the last step of the clock: 0.01 s of 10 s
        assert [(f.code, f.severity) for f in one.findings] == [("coarse_stamps", "info")]
        details = one.findings[0].details
        assert (details.step, details.hidden, details.single_precision) == (pytest.approx(0.01), 5, False)

    def test_bunched_stamps(self):
        t = np.repeat(np.arange(2000) * 0.04, 4) + np.tile([0, 1e-3, 2e-3, 3e-3], 2000)  # four at once, every 40 ms
        one = found(t)
        assert one.rate == pytest.approx(100.0, rel=1e-3)  # within one bunch of 2000
        (finding,) = one.findings
        assert (finding.code, finding.severity, one.places) == ("host_stamps", "warning", None)
        assert finding.size == pytest.approx(0.75, abs=0.005)
        assert finding.details.median_rate == pytest.approx(1000.0)

    def test_bunches_of_random_size_with_a_pause(self):
        rng = np.random.default_rng(seed_of("random bunches"))
        t = np.arange(50_000) / 100.0
        took = np.sort(rng.choice(len(t), 12_000, replace=False))  # when the host looks
        host = t[took[np.minimum(np.searchsorted(took, np.arange(len(t))), len(took) - 1)]]
        host = np.maximum.accumulate(host) + 1e-4 * np.arange(len(t)) % 1e-3 / 1e3
        host = np.sort(host)
        host[30_000:] += 60.0
        one = found(host)
        assert one.rate == pytest.approx(100.0, rel=2e-3)
        assert {"host_stamps", "gaps"} <= set(codes(one))
        assert one.n - len(t) == pytest.approx(6000, rel=0.02)  # about as many as fit into the pause

    def test_late_stamps_of_a_busy_host(self):
        """Stalls of several intervals, after which the stamps come all at once: nothing is lost."""
        rng = np.random.default_rng(seed_of("stalls"))
        t = np.arange(200_000) / 100.0
        t = np.maximum.accumulate(t + (rng.random(len(t)) < 0.002) * rng.exponential(0.03, len(t)))
        t += np.arange(len(t)) * 1e-12  # no two alike
        one = found(t)
        assert one.places is None
        assert one.rate == pytest.approx(100.0, rel=1e-5)
        assert "host_stamps" not in codes(one)  # one in a hundred is late, and the others are the sensor's

    def test_a_step_of_the_clock_by_part_of_a_sample_is_no_gap(self):
        for step in (0.1, 0.3, 0.45):
            t = np.arange(20_000) / 100.0
            t[9_000:] += step / 100
            assert found(t).places is None, step


class TestPlaces:
    def test_a_lost_sample_is_told(self):
        one = found(np.delete(np.arange(1001) / 100.0, 500))
        (finding,) = one.findings
        assert (finding.code, finding.severity, finding.size) == ("gaps", "info", 1)
        assert finding.spans == (pytest.approx((5.0, 5.01)),)
        (gap,) = finding.details.longest
        assert (finding.details.samples, finding.details.gaps) == (1001, 1)
        assert (gap.samples, gap.place) == (1, "line 501")
        assert (gap.start, gap.length) == pytest.approx((5.0, 0.01))

    def test_one_gap_of_a_minute_in_two_hours(self):
        t = np.arange(720_000) / 100.0
        t[300_000:] += 60.0
        x = np.arange(720_000) % 11.0
        record = record_of(t, x)
        stream = record.streams[0]
        assert stream.grid.rate == pytest.approx(100.0, rel=1e-12)
        assert (stream.grid.n, int(stream.mask.sum())) == (726_000, 6000)
        column = stream.column("gyro_x")
        np.testing.assert_array_equal(column[:300_000], x[:300_000])
        assert np.isnan(column[300_000:306_000]).all()
        np.testing.assert_array_equal(column[306_000:], x[300_000:])
        (finding,) = record.findings
        assert (finding.code, finding.severity) == ("gaps", "warning")
        assert finding.spans == (pytest.approx((3000.0, 3060.0)),)
        assert finding.details.longest[0].place == "row 300000"
        assert stream.grid.source.lost == 6000

    def test_accumulated_values_across_a_gap(self):
        angle = np.cumsum(np.arange(1001) % 5.0)
        keep = np.delete(np.arange(1001), 500)
        record = sigmatau.from_frame(
            {"t": keep / 100, "wx": angle[keep]}, unit={"time": "s", "gyro": "rad"}, input="accumulated"
        )
        column = record.streams[0].column("gyro_x")
        assert np.flatnonzero(np.isnan(column)).tolist() == [499, 500]
        np.testing.assert_allclose(np.delete(column, [499, 500]), np.delete(np.diff(angle) * 100, [499, 500]))

    def test_a_pause_longer_than_the_record(self):
        t = np.arange(30_000) / 100.0
        t[18_000:] += 36_000
        record = record_of(t)
        assert record.streams[0].grid.n == 18_000
        (finding,) = record.findings
        assert (finding.code, finding.severity) == ("long_pauses", "warning")
        details = finding.details
        assert (details.longest, details.place) == (pytest.approx(36_000, abs=0.1), "row 18000")
        assert (details.pauses, details.used, details.total) == (1, 18_000, 30_000)

    def test_wrong_stamps_at_the_ends(self):
        t = 1.7e9 + np.arange(10_000) / 50.0
        t[0] = 0.0  # before the clock was set
        t[-1] += 3600.0
        one = found(t)
        assert one.rate == pytest.approx(50.0, rel=1e-6)
        assert (one.n, one.rows[0], one.rows[-1]) == (9998, 1, 9998)
        assert "long_pauses" in codes(one)

    def test_nothing_but_pauses(self):
        """A row a minute and then some in a bunch: no few pauses make a record of it."""
        rng = np.random.default_rng(seed_of("nothing but pauses"))
        one = found(np.cumsum(10.0 ** rng.uniform(-3, 6, 500)))
        assert set(codes(one)) & {"irregular_stamps", "host_stamps", "long_pauses"}


class TestDrift:
    @pytest.mark.parametrize(("change", "severity"), [(5e-3, "warning"), (5e-4, "info")])
    def test_a_rate_that_changes(self, change, severity):
        x = np.arange(100_000) / 100.0
        one = found(x + 0.5 * change * x**2 / x[-1])
        finding = next(f for f in one.findings if f.code == "rate_drift")
        assert finding.severity == severity
        assert finding.size == pytest.approx(0.9 * change, rel=0.02)  # from the first tenth to the last
        assert one.places is None

    def test_jitter_alone_is_no_drift(self):
        """A tenth of 300 stamps has a rate that is only good to 7e-5: ten of them differ by 2e-4."""
        rng = np.random.default_rng(seed_of("jitter alone"))
        for _ in range(80):
            assert "rate_drift" not in codes(found(np.arange(3000) / 100.0 + rng.normal(0, 1e-3, 3000)))

    def test_ten_millionths_are_not_said(self):
        x = np.arange(100_000) / 100.0
        assert found(x + 0.5e-5 * x**2 / x[-1]).findings == ()


class TestNominal:
    def test_near_a_round_rate(self):
        one = found(np.arange(10_000) / 99.3)
        assert [(f.code, f.severity) for f in one.findings] == [("rate_not_nominal", "info")]
        assert one.findings[0].details.nominal == 100.0
        assert one.findings[0].size == pytest.approx(-0.007)

    @pytest.mark.parametrize("rate", [100.0, 62.5, 104.17, 99.98, 225.0, 1125 / 11])
    def test_rates_that_are_meant(self, rate):
        assert found(np.arange(10_000) / rate).findings == ()

    @pytest.mark.parametrize("kind", ["rate", "increments"])
    def test_what_a_wrong_rate_changes(self, kind):
        """By a fit of one record at both rates: the model is the same in units of samples, so the factors are exact."""
        truth = {"quantization": 2e-4, "random_walk": 1e-3, "bias_instability": 1e-3, "rate_random_walk": 2e-3}
        model = NoiseModel(channels={"gyro_x": truth})
        given_rate, true = 120.0, 100.0
        simulated = simulate(model, duration=1000, rate=true, rng=seed_of("wrong rate"))
        x = simulated.streams[0].column("gyro_x") / (true if kind == "increments" else 1.0)
        records = [
            Record.from_arrays(rate=r, gyro_x=x, unit={"gyro": "rad" if kind == "increments" else "rad/s"}, input=kind)
            for r in (given_rate, true)
        ]
        wrong, right = (fit(allan(r)["gyro_x"]) for r in records)
        (finding,) = stamps.mismatch(given_rate, found(np.arange(1000) / true).rate, kind)
        factors = dict(finding.factors)
        assert set(right.observed) >= {"quantization", "random_walk", "bias_instability", "rate_random_walk"}
        for term in right.observed:
            ratio = abs(wrong[term].value / right[term].value)
            assert ratio == pytest.approx(factors.get(term, 1.0), rel=1e-6), term
        assert finding.code == "rate_mismatch"


@pytest.mark.parametrize(
    ("stamps_of", "unit"),
    [
        (1_700_000_000_000_000_000 + 5_000_000 * np.arange(100), "ns"),  # our time, 200 Hz; as us it would be 0.2 Hz
        (np.arange(100) * 10.0, "ms"),
        (np.arange(100) / 200.0, "s"),
        (5_000 * np.arange(100), "us"),
    ],
)
def test_the_unit_offered_is_the_likeliest(stamps_of, unit):
    error = plausible.ask_for_unit(stamps_of, np.diff(stamps_of).astype(float), "'t'")
    assert re.search(rf"give --unit time={unit}(,| or) ", str(error))


def clean_stamps(rng):
    """Stamps of a sound log: regular, printed to 1 µs or 1 ms, or with jitter up to a tenth of the interval."""
    rate = float(10 ** rng.uniform(1, np.log10(400)))
    n = int(min(rng.uniform(600, 14_400) * rate, 60_000))
    t = np.arange(n) / rate + (1.7e9 if rng.integers(2) else 0.0)
    match int(rng.integers(4)):
        case 1:
            return np.round(t, 6)
        case 2:
            return np.round(t, 3)
        case 3:
            return np.sort(t + rng.normal(0, 0.1 / rate, n))
    return t


def test_clean_stamps_raise_no_warning():
    """None of 100; and nothing is left out, moved, or laid beside another place."""
    rng = np.random.default_rng(seed_of("clean stamps"))
    for k in range(100):
        t = clean_stamps(rng)
        one = found(t)
        assert codes(one, least="warning") == [], k
        assert (one.rows, one.places, one.n) == (None, None, len(t)), k


@settings(max_examples=80, deadline=None)
@given(
    st.lists(st.integers(0, 40), min_size=30, max_size=200), st.sampled_from([0.0, 0.05, 0.1]), st.integers(0, 2**31)
)
def test_places_under_any_loss(holes, jitter, seed):
    """One sample after each number of lost ones, most of them none: the places are exact."""
    lost = np.where(np.arange(len(holes)) % 3 == 0, np.minimum(holes, 3), 0)
    k = np.arange(len(holes)) + np.cumsum(lost)
    t = (k + np.random.default_rng(seed).uniform(-jitter, jitter, len(k)) * 1.5) / 50.0
    t = t - t[0]
    one = fit_grid(t, np.diff(t), resolution(np.diff(t), float(t[-1])))
    if one.kind == "grid" and one.places is not None:
        np.testing.assert_array_equal(one.places, (k - k[0])[one.start : one.stop] - (k - k[0])[one.start])
    else:
        assert one.stop - one.start == len(t)
