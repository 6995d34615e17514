"""Time stamps: the rate and the grid they say, right for bunched, coarse, late and lost ones; what is wrong is said."""

import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import sigmatau
from known import cpu_unit, seed_of
from sigmatau import NoiseModel, Record, allan, fit, simulate
from sigmatau.errors import DataError, NonFiniteError, OptionError
from sigmatau.io import read
from sigmatau.io.read.time import stamps
from sigmatau.io.read.time.grid import fit_grid, resolution
from sigmatau.io.read.time.rows import in_order


def where(row):
    return f"line {row + 1}"


def ordered(t, *samples):
    return in_order(np.asarray(t), samples, where, "'t'")


def found(t, second=1.0, **more):
    return stamps.fit(ordered(t), second, where, "'t'", **more)


def codes(fit_or_record, *, least="info"):
    wanted = {"info": ("info", "warning", "error"), "warning": ("warning", "error")}[least]
    return [f.code for f in fit_or_record.findings if f.severity in wanted]


def record_of(t, x=None, **options):
    x = np.arange(len(t)) % 7.0 if x is None else x
    return sigmatau.from_frame({"t": np.asarray(t), "wx": x}, unit={"gyro": "rad/s", "time": "s"}, **options)


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
        assert one.notes == ("1403636579 s taken off the time stamps",)

    def test_two_stamps_that_one_double_cannot_tell_apart(self):
        t = 1_403_636_579_758_555_393 + np.arange(4, dtype=np.int64)
        assert len(set(t.astype(float))) == 1
        assert ordered(t).intervals.tolist() == [1.0, 1.0, 1.0]

    def test_few_rows(self):
        assert found(np.array([0.0, 1.0, 2.0, 3.0])).rate == pytest.approx(1.0)

    @pytest.mark.parametrize("share", [0.01, 0.05, 0.3])
    @pytest.mark.parametrize("jitter", [0.0, 0.1])
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
        assert "5 lost samples" in one.findings[0].effect

    def test_bunched_stamps(self):
        t = np.repeat(np.arange(2000) * 0.04, 4) + np.tile([0, 1e-3, 2e-3, 3e-3], 2000)  # four at once, every 40 ms
        one = found(t)
        assert one.rate == pytest.approx(100.0, rel=1e-3)  # within one bunch of 2000
        (finding,) = one.findings
        assert (finding.code, finding.severity, one.places) == ("host_stamps", "warning", None)
        assert "75 % of the intervals" in finding.message
        assert "would say 1e+03 Hz" in finding.message

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
        assert (finding.code, finding.severity, finding.size, finding.where) == ("gaps", "info", 1, "t = 5 s")
        assert "1 of 1001 samples (0.1 %) are missing in 1 gap of the time stamps; before line 501" in finding.message

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
        assert (finding.code, finding.severity, finding.where) == ("gaps", "warning", "t = 3000 s")
        assert "before row 300000" in finding.message
        assert "6000 lost samples left empty" in stream.grid.source

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
        assert "36000 s before row 18000" in finding.message
        assert "18000 of 30000 samples from row 0 on, and the other 12000 are left out" in finding.message

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


PATTERNS = {
    "every third": [1, 1, 0],
    "every fifth": [1, 1, 1, 1, 0],
    "every tenth": [1] * 9 + [0],
    "two of five": [1, 1, 0, 1, 0],
    "two together of five": [1, 1, 1, 0, 0],
    "two of five, from another row": [1, 0, 1, 0, 1],
}


class TestPatterns:
    @pytest.mark.parametrize("jitter", [0.0, 1e-6, 1e-3])
    @pytest.mark.parametrize("pattern", PATTERNS.values(), ids=PATTERNS)
    def test_rows_lost_in_a_pattern(self, pattern, jitter):
        """The finest grid that the steps fit, not the mean interval: 100 Hz without every fifth row is not 80 Hz."""
        rng = np.random.default_rng(seed_of(f"pattern {pattern} {jitter}"))
        k = np.flatnonzero(np.tile(pattern, 60_000 // len(pattern)))
        one = found(k / 100 + rng.normal(0, 1, len(k)) * jitter)
        assert one.rate == pytest.approx(100.0, rel=1e-6)
        np.testing.assert_array_equal(one.places, k - k[0])
        (finding,) = one.findings
        assert (finding.code, finding.size) == ("gaps", one.n - len(k))

    def test_it_goes_on_to_the_record(self):
        k = np.flatnonzero(np.tile([1, 1, 1, 1, 0], 12_000))
        record = record_of(k / 100, k * 1.0)
        column = record.streams[0].column("gyro_x")
        np.testing.assert_array_equal(column[k], k * 1.0)
        assert np.isnan(np.delete(column, k)).all()
        assert record.streams[0].grid.rate == pytest.approx(100, rel=1e-12)

    @pytest.mark.parametrize("jitter", [0.0, 1e-3])
    def test_every_second_row_cannot_be_told(self, jitter):
        rng = np.random.default_rng(seed_of(f"every second {jitter}"))
        one = found(np.arange(30_000) / 50 + rng.normal(0, 1, 30_000) * jitter)
        assert (one.places, one.findings) == (None, ())
        assert one.rate == pytest.approx(50, rel=1e-6)

    def test_the_user_decides_what_stamps_cannot(self):
        """80 Hz by a clock in steps of 10 ms, and 100 Hz without every fifth row: the same stamps."""
        k = np.flatnonzero(np.tile([1, 1, 1, 1, 0], 12_000))
        even = np.floor(np.arange(48_000) * 1.25 + 1e-9)
        np.testing.assert_array_equal(k, even)
        (finding,) = found(k / 100).findings
        assert "even samples at 80 Hz so too" in finding.message
        assert "--rate 80 " in finding.remedy
        one = found(k / 100, rate=80.0)
        assert (one.places, one.findings) == (None, ())
        assert one.rate == pytest.approx(80.0, rel=1e-5)
        one = found(k / 100, rate=100.0)
        assert (one.n, [f.code for f in one.findings]) == (59_999, ["gaps"])
        assert "without fail" not in one.findings[0].message

    def test_a_long_pattern_is_of_a_coarse_clock_unless_the_user_says_otherwise(self):
        k = np.flatnonzero(np.tile([1] * 99 + [0], 600))
        one = found(k / 100)
        assert one.rate == pytest.approx(99, rel=1e-4)
        assert codes(one) == ["coarse_stamps", "rate_not_nominal"]
        assert "100 Hz with 1 of every 100 samples lost" in one.findings[0].message
        np.testing.assert_array_equal(found(k / 100, rate=100.0).places, k)

    @pytest.mark.parametrize("rate", [833.0, 800.03, 600.03, 512.0, 995.0])
    def test_a_clock_that_beats_with_the_samples_is_no_loss(self, rate):
        one = found(np.floor(np.arange(60_000) / rate * 1e3) / 1e3)
        assert one.places is None
        assert one.rate == pytest.approx(rate, rel=1e-5)


class TestOrder:
    def test_backwards_and_standing_still(self):
        with pytest.raises(DataError, match=r"line 4: time goes backwards in column 't', from 2\.0 to 1\.5; sort"):
            ordered([0, 1.0, 2.0, 1.5, 3.0])
        with pytest.raises(DataError, match="1 times more"):
            ordered([0, 1.0, 0.5, 1.5, 1.0])
        with pytest.raises(DataError, match=r"all stamps in column 't' are 5"):
            ordered([5, 5, 5])
        extremes = ordered([np.iinfo(np.int64).min + 1, np.iinfo(np.int64).max])
        assert extremes.intervals[0] > 1e19  # and does not wrap

    def test_a_clock_that_was_set_back(self):
        t = np.arange(5000) / 100.0
        t[3000:] -= 1.0
        with pytest.raises(DataError, match=r"line 3001: time goes backwards .* from 29\.99 to 29\.0"):
            ordered(t)

    def test_late_rows_are_put_in_order(self):
        t = np.arange(5000) / 100.0
        x = np.arange(5000.0)
        at = np.arange(5000)
        at[[1000, 1001]] = at[[1001, 1000]]
        at[2000:2012] = np.r_[2004:2012, 2000:2004]  # a packet of four after its successors
        record = record_of(t[at], x[at])
        np.testing.assert_array_equal(record.streams[0].column("gyro_x"), x)
        (finding,) = record.findings
        assert (finding.code, finding.severity, finding.size) == ("rows_out_of_order", "warning", 5)
        assert "5 of 5000 rows" in finding.message
        assert "row 1001" in finding.message

    def test_a_stamp_that_is_wrong_leaves_its_place_empty(self):
        for wrong in (1e6, -5.0, 30.004, 12.304):  # the last falls between two others
            t = np.arange(5000) / 100.0
            t[1234] = wrong
            record = record_of(t, np.arange(5000.0))
            assert codes(record) == ["wrong_stamps", "gaps"], wrong
            assert record.findings[0].where in ("row 1234", "row 1235")
            column = record.streams[0].column("gyro_x")
            assert np.flatnonzero(np.isnan(column)).tolist() == [1234]
            np.testing.assert_array_equal(np.delete(column, 1234), np.delete(np.arange(5000.0), 1234))

    def test_many_rows_out_of_order_are_refused(self):
        rng = np.random.default_rng(seed_of("shuffled"))
        with pytest.raises(DataError, match="time goes backwards"):
            ordered(rng.permutation(1000) / 100.0)

    def test_rows_without_a_stamp(self):
        t = np.arange(2000) / 100.0
        t[[50, 700]] = np.nan
        record = record_of(t, np.arange(2000.0))
        assert codes(record) == ["missing_stamps", "gaps"]
        assert "2 of 2000 rows have no time stamp, the first: row 50" in record.findings[0].message
        assert np.flatnonzero(record.streams[0].mask[:, 0]).tolist() == [50, 700]
        t[:1200] = np.nan
        with pytest.raises(NonFiniteError, match="no time stamp in 1200 of 2000 rows"):
            record_of(t)


class TestDuplicates:
    def test_every_sample_twice(self):
        rng = np.random.default_rng(seed_of("twice"))
        x = rng.normal(size=5000)
        record = record_of(np.repeat(np.arange(5000) / 100.0, 2), np.repeat(x, 2))
        np.testing.assert_array_equal(record.streams[0].column("gyro_x"), x)
        assert record.streams[0].grid.rate == pytest.approx(100.0, rel=1e-12)
        (finding,) = record.findings
        assert (finding.code, finding.severity, finding.size) == ("duplicate_samples", "warning", 5000)
        assert "1.41 times" in finding.effect

    @pytest.mark.parametrize("share", [0.1, 0.5, 1.0])
    def test_the_effect_that_is_stated(self, share):
        """Kept, and taken at the rate of the sensor: the random walk grows by √((1 + 3s) / (1 + s))."""
        rng = np.random.default_rng(seed_of(f"duplicates {share}"))
        ratios = []
        for _ in range(20):
            x = rng.normal(size=40_000)
            doubled = np.repeat(x, 1 + (rng.random(len(x)) < share))
            pair = [
                allan(Record.from_arrays(rate=100, gyro_x=y), taus=[0.64, 1.28])["gyro_x"].avar.mean()
                for y in (doubled, x)
            ]
            ratios.append(pair[0] / pair[1])
        t = np.repeat(np.arange(1000), 1 + (np.arange(1000) < 1000 * share)) / 100
        said = ordered(t, np.repeat(rng.normal(size=1000), 1 + (np.arange(1000) < 1000 * share))).findings[0].effect
        stated = float(said.split("random walk ")[1].split(" times")[0])
        error = np.std(ratios, ddof=1) / len(ratios) ** 0.5 / 2
        assert np.mean(ratios) ** 0.5 == pytest.approx(stated, abs=3 * error + 0.005)  # three digits are printed

    def test_one_stamp_twice_with_other_samples(self):
        t = np.arange(5000) / 100.0
        t = np.insert(t, 1234, t[1234])
        x = np.random.default_rng(seed_of("other samples")).normal(size=5001)
        record = record_of(t, x)
        assert codes(record) == ["duplicate_samples"]
        np.testing.assert_array_equal(record.streams[0].column("gyro_x"), np.delete(x, 1235))


class TestJitter:
    @pytest.mark.parametrize("share", [0.1, 0.15, 0.2])
    def test_no_row_is_lost_or_moved(self, share):
        """At 0.2 of an interval twelve of 60,000 stamps are behind the next, one in eighty nearer to another place."""
        rng = np.random.default_rng(seed_of(f"honest jitter {share}"))
        for _ in range(5):
            x = np.arange(60_000.0)
            record = record_of((x + rng.normal(0, share, len(x))) / 100, x)
            assert codes(record) == ["jitter"]
            np.testing.assert_array_equal(record.streams[0].column("gyro_x"), x)
            assert record.streams[0].grid.rate == pytest.approx(100, rel=4 * share * 12**0.5 / len(x) ** 1.5)

    def test_beside_a_loss_few_are_moved(self):
        """Only a stamp beside a hole, nearer to it than to its own place, cannot be told from one that belongs there."""
        share, loss = 0.2, 0.01
        rng = np.random.default_rng(seed_of("jitter and loss"))
        k = np.flatnonzero(rng.random(60_000) >= loss)
        one = found((k + rng.normal(0, share, len(k))) / 100)
        assert one.n == k[-1] - k[0] + 1
        moved = np.flatnonzero(one.places != k - k[0])
        expected = 2 * loss * 0.00621 * len(k)  # two rows beside each hole, each beyond half an interval on that side
        assert len(moved) <= 2 * expected + 3 * (2 * expected) ** 0.5  # and those that are swapped there
        holes = np.flatnonzero(np.diff(k) > 1)
        assert all(np.abs(holes - m).min() <= 5 for m in moved)

    def test_it_is_measured(self):
        rng = np.random.default_rng(seed_of("jitter"))
        for share in (0.01, 0.1):
            t = np.arange(200_000) / 100.0 + rng.normal(0, share / 100, 200_000)
            grid = record_of(t).streams[0].grid
            # 512 blocks of 64, two of each for its line: relative error 1 / √(2·512·62)
            assert grid.jitter == pytest.approx(share / 100, rel=4 / (2 * 512 * 62) ** 0.5)

    def test_it_is_told_and_is_nothing_for_rates(self):
        rng = np.random.default_rng(seed_of("jitter of rates"))
        t = np.arange(20_000) / 100.0 + rng.normal(0, 1e-3, 20_000)
        record = sigmatau.from_frame(
            {"t": t, "az": 9.81 + rng.normal(size=len(t)), "ax": t, "ay": t}, unit={"time": "s", "accel": "m/s^2"}
        )
        (finding,) = record.findings
        assert (finding.code, finding.severity, finding.unit) == ("jitter", "info", "s")
        assert "none on rates" in finding.effect
        assert finding.size == pytest.approx(1e-3, rel=0.05)

    def increments(self, rng, n, sigma, *, own=0.0):
        """Velocity of 9.81 m/s² over intervals that scatter by sigma, and what noise of its own it has."""
        t = np.arange(n + 1) / 100.0 + rng.normal(0, sigma, n + 1)
        angle = rng.normal(0, own, n + 1) if own else np.zeros(n + 1)
        return t[1:], 9.81 * np.diff(t) + np.diff(angle) + rng.normal(0, 1e-7, n)

    def test_the_effect_that_is_stated(self):
        """Q_j = |m| σ_j, and by how much the quantization noise is larger than the sensor's own."""
        rng = np.random.default_rng(seed_of("jitter of increments"))
        sigma, own = 5e-4, 9.81 * 5e-4
        values, stated = [], []
        for _ in range(8):
            t, dv = self.increments(rng, 20_000, sigma, own=own)
            frame = {"t": t, "dvz": dv}
            record = sigmatau.from_frame(
                frame, channels={"time": "t", "accel_z": "dvz"}, unit={"time": "s", "accel": "m/s"}, input="increments"
            )
            (finding,) = [f for f in record.findings if f.code == "jitter"]
            assert (finding.severity, finding.channel) == ("warning", "accel_z")
            assert finding.size == pytest.approx(9.81 * sigma, rel=0.05)
            stated.append(dict(finding.changes)["quantization"])
            values.append(fit(allan(record)["accel_z"])["quantization"].value / own)
        error = np.hypot(np.std(values, ddof=1), np.std(stated, ddof=1)) / len(values) ** 0.5
        assert np.mean(values) == pytest.approx(np.mean(stated), abs=3 * error)
        assert np.mean(stated) == pytest.approx(2**0.5, abs=0.1)

    def test_stamps_that_scatter_beside_samples_that_do_not(self):
        rng = np.random.default_rng(seed_of("jitter of stamps alone"))
        t = np.arange(20_000) / 100.0 + rng.normal(0, 1e-3, 20_000)
        dv = 0.0981 + rng.normal(0, 1e-5, len(t))
        record = sigmatau.from_frame(
            {"t": t, "dvz": dv},
            channels={"time": "t", "accel_z": "dvz"},
            unit={"time": "s", "accel": "m/s"},
            input="increments",
        )
        (finding,) = record.findings
        assert (finding.code, finding.severity) == ("jitter", "info")
        assert "the instants of sampling do not" in finding.effect


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
        for _ in range(200):
            assert "rate_drift" not in codes(found(np.arange(3000) / 100.0 + rng.normal(0, 1e-3, 3000)))

    def test_ten_millionths_are_not_said(self):
        x = np.arange(100_000) / 100.0
        assert found(x + 0.5e-5 * x**2 / x[-1]).findings == ()


class TestNominal:
    def test_near_a_round_rate(self):
        one = found(np.arange(10_000) / 99.3)
        assert [(f.code, f.severity) for f in one.findings] == [("rate_not_nominal", "info")]
        assert "0.7 % less than 100 Hz" in one.findings[0].message

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
        (finding,) = stamps.mismatch(given_rate, found(np.arange(1000) / true), kind)
        changes = dict(finding.changes)
        assert set(right.observed) >= {"quantization", "random_walk", "bias_instability", "rate_random_walk"}
        for term in right.observed:
            ratio = abs(wrong[term].value / right[term].value)
            assert ratio == pytest.approx(changes.get(term, 1.0), rel=1e-6), term
        assert finding.code == "rate_mismatch"


def log(tmp_path, header, times):
    path = tmp_path / "log.csv"
    lines = [f"{t},{i % 7}" for i, t in enumerate(times)]
    path.write_text(f"{header},wx [rad/s]\n" + "\n".join(lines) + "\n")
    return path


class TestText:
    def test_lines_are_those_of_the_file(self, tmp_path):
        path = tmp_path / "log.csv"
        path.write_text("t [s],wx [rad/s]\n0,1\n\n# note\n1,1\n2,1\n\n1.5,1\n3,1\n")
        with pytest.raises(DataError, match=r"log\.csv, line 8: time goes backwards .* from 2\.0 to 1\.5"):
            read(path)
        with pytest.raises(DataError, match="line 8: time goes backwards"):
            read(path, rate=1)

    def test_the_given_rate_is_used_and_a_difference_told(self, tmp_path):
        path = log(tmp_path, "t [s]", np.arange(100) / 50)
        assert read(path, rate=50.04).findings == ()
        record = read(path, rate=100)
        assert record.streams[0].grid.rate == 100
        assert record.streams[0].grid.source == "given"
        (finding,) = record.findings
        assert finding.code == "rate_mismatch"
        assert "100 Hz" in finding.message
        assert "50 Hz" in finding.message

    def test_with_a_rate_the_unit_of_time_is_not_needed(self, tmp_path):
        path = log(tmp_path, "t", np.arange(100) / 50)
        record = read(path, rate=100)
        assert record.findings == ()
        assert any("checked for order and gaps only" in c for c in record.provenance.conversions)
        path = log(tmp_path, "t", np.delete(np.arange(100), [40, 41]))
        record = read(path, rate=100)
        assert [(f.code, f.where) for f in record.findings] == [("gaps", "t = 0.4 s")]
        assert record.streams[0].grid.n == 100

    @pytest.mark.parametrize(("unit", "step"), [("s", 1 / 128), ("ms", 7.8125), ("us", 7812.5), ("ns", 7812500)])
    def test_units_of_time(self, tmp_path, unit, step):
        path = log(tmp_path, "t", [repr(i * step) for i in range(100)])
        assert read(path, unit={"time": unit}).streams[0].grid.rate == pytest.approx(128.0, rel=1e-13)

    def test_ticks(self, tmp_path):
        path = log(tmp_path, "t", range(0, 1000, 10))
        record = read(path, unit={"time": "us"}, scale={"time": 40})  # a tick of 40 µs
        assert record.streams[0].grid.rate == pytest.approx(2500.0, rel=1e-13)

    def test_nanoseconds_in_text_stay_exact(self, tmp_path):
        start = 1_403_636_579_758_555_393
        path = log(tmp_path, "t [ns]", [start + 10 * k for k in range(100)])
        assert read(path).streams[0].grid.rate == pytest.approx(1e8, rel=1e-14)
        path = log(tmp_path, "t [ns]", ["" if k == 50 else start + 10 * k for k in range(100)])
        record = read(path)
        assert record.streams[0].grid.rate == pytest.approx(1e8, rel=1e-14)
        assert codes(record, least="warning")[0] == "implausible_rate" or "missing_stamps" in codes(record)
        path = log(tmp_path, "t [ns]", [start, start + 2, start + 1, start + 3])  # the same double, all four
        with pytest.raises(DataError, match=f"line 4: time goes backwards .* from {start + 2} to {start + 1};"):
            read(path)


def test_an_implausible_rate_is_told():
    """Seconds in a column that says microseconds."""
    (finding,) = found(np.arange(1000) / 200.0, second=1e-6).findings
    assert finding.code == "implausible_rate"
    assert "2e+08 Hz" in finding.message


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
    error = stamps.without_unit(stamps_of, np.diff(stamps_of).astype(float), "'t'")
    assert f"say e.g. --unit time={unit}," in str(error)


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
    """None of 300; and nothing is left out, moved, or laid beside another place."""
    rng = np.random.default_rng(seed_of("clean stamps"))
    for k in range(300):
        t = clean_stamps(rng)
        one = found(t)
        assert codes(one, least="warning") == [], k
        assert (one.rows, one.places, one.n) == (None, None, len(t)), k


@pytest.mark.parametrize("kind", ["even", "integers", "jitter"])
def test_speed(kind):
    """1.44e6 stamps take some 15 ms of one core: no loop over rows."""
    n = 1_440_000
    rng = np.random.default_rng(seed_of("speed of stamps"))
    t = {
        "even": np.arange(n) / 400,
        "integers": 1_403_636_579_758_555_393 + 2_500_000 * np.arange(n),
        "jitter": np.arange(n) / 400 + rng.normal(0, 1e-5, n),
    }[kind]
    spent = []
    for _ in range(5):
        start = time.process_time()
        found(t, 1e-9 if kind == "integers" else 1.0)
        spent.append(time.process_time() - start)
    assert min(spent) < 2.5 * cpu_unit()


anything = hnp.arrays(
    np.float64,
    st.integers(4, 60),
    elements=st.floats(-1e6, 1e6)
    | st.floats(-1e30, 1e30)
    | st.floats(allow_infinity=False).map(float)
    | st.integers(0, 50).map(float),
)
growing = anything.map(lambda t: np.sort(np.abs(t)))


@settings(max_examples=300, deadline=None)
@given(anything | growing | growing.map(lambda t: np.cumsum(np.clip(t, 0, 1e12))), st.booleans())
def test_any_stamps_make_a_record_or_an_error_of_ours(t, with_rate):
    """And every sample that is not said to be left out is in the record, in order, once."""
    x = np.arange(len(t)) + 1.0
    try:
        record = record_of(t, x, **({"rate": 10.0} if with_rate else {}))
    except (DataError, OptionError):
        return
    kept = record.streams[0].column("gyro_x")
    kept = kept[~np.isnan(kept)]
    left_out = sum(
        int(f.size) for f in record.findings if f.code in ("missing_stamps", "wrong_stamps", "duplicate_samples")
    )
    cut = next((f for f in record.findings if f.code == "long_pauses"), None)
    if cut is not None:
        left_out += int(cut.message.split("the other ")[1].split(" ")[0])
    assert len(kept) == len(t) - left_out
    assert len(set(kept.tolist())) == len(kept)
    assert set(kept.tolist()) <= set(x.tolist())
    if "rows_out_of_order" not in codes(record):
        assert (np.diff(kept) > 0).all()


@settings(max_examples=200, deadline=None)
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
