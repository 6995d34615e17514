"""Records with missing samples: the estimator, and what it is expected to show."""

import numpy as np
import pytest

from known import seed_of
from sigmatau import Record, allan, analyze, deviation, fit
from sigmatau.errors import DataError, NonFiniteError, OptionError, RecordTooShortError
from sigmatau.estimators.deviation_kinds import cluster_sizes
from sigmatau.findings.reasons import IncompleteRecord

N = 1024
SIZES = np.array([int(m) for m in cluster_sizes("half", n=N, tau0=1.0) if m <= N // 3])


def missing(case, n=N, *, share=0.05, outage=0):
    rng = np.random.default_rng(seed_of(case))
    mask = rng.random(n) < share
    start = n // 3
    mask[start : start + outage] = True
    return mask


MASKS = {
    "5 % at random": missing("loss"),
    "an outage": missing("outage", share=0, outage=100),
    "both": missing("both", outage=100),
    "30 % at random": missing("much", share=0.3),
}


def differences(mask, m):
    """Weights of every pair of clusters at least half full on the samples; slow and plain."""
    rows = []
    for start in range(len(mask) - 2 * m + 1):
        first, second = (1.0 - mask[k : k + m] for k in (start, start + m))
        if 2 * first.sum() >= m and 2 * second.sum() >= m:
            row = np.zeros(len(mask))
            row[start : start + m] = -first / first.sum()
            row[start + m : start + 2 * m] = second / second.sum()
            rows.append(row)
    return np.array(rows)


class TestEstimator:
    @pytest.mark.parametrize("name", MASKS)
    def test_it_is_the_mean_square_of_the_pairs(self, name):
        mask = MASKS[name]
        y = np.cumsum(np.random.default_rng(seed_of(name)).standard_normal(N)) + 9.8
        curve = allan(Record.from_arrays(rate=100, x=np.where(mask, np.nan, y)))["x"]
        for m, avar, pairs, ramp in zip(curve.m, curve.avar, curve.n_pairs, curve.ramp, strict=True):
            rows = differences(mask, m)
            z, d = rows @ (y - y.mean()), rows @ np.arange(N)
            assert pairs == len(rows)
            # 1e-12, less what the plain sums here lose.
            assert avar == pytest.approx(0.5 * np.mean(z * z), rel=3e-12)
            assert ramp == pytest.approx(100 * (z @ d) / (d @ d), rel=1e-9, abs=1e-9)

    def test_extended_precision(self):
        """A walk a thousand times its steps, on an offset, against whole numbers."""
        rng = np.random.default_rng(seed_of("extended precision"))
        whole = np.cumsum(rng.integers(-(2**20), 2**20, 4000)) + 2**34
        mask = rng.random(4000) < 0.05
        curve = allan(Record.from_arrays(rate=1, x=np.where(mask, np.nan, whole / 2.0**24)), taus=[1, 10, 300])["x"]
        sums, counts = (np.concatenate([[0], np.cumsum(x)]) for x in (np.where(mask, 0, whole), ~mask))
        for m, avar in zip(curve.m.tolist(), curve.avar, strict=True):
            exact, pairs = 0, 0
            for k in range(len(whole) - 2 * m + 1):
                s1, s2 = (int(sums[k + i + m] - sums[k + i]) for i in (0, m))
                c1, c2 = (int(counts[k + i + m] - counts[k + i]) for i in (0, m))
                if 2 * c1 >= m and 2 * c2 >= m:
                    pairs += 1
                    exact += ((s2 * c1 - s1 * c2) << 60) ** 2 // (c1 * c2) ** 2
            assert avar == pytest.approx(exact / (2**120 * 2**48) / (2 * pairs), rel=1e-12)

    def test_threads_and_channels(self):
        """Bit for bit; a channel that misses nothing is not touched by one that does."""
        y = np.random.default_rng(seed_of("threads")).standard_normal((20_000, 3))
        y[missing("threads", 20_000, outage=3000), 1] = np.nan
        one, two = (allan(Record.from_arrays(rate=1, gyro=y), threads=threads) for threads in (1, 2))
        alone = allan(Record.from_arrays(rate=1, gyro_x=y[:, 0]))["gyro_x"]
        for channel in one:
            assert np.array_equal(one[channel].avar, two[channel].avar)
        assert np.array_equal(one["gyro_x"].avar, alone.avar)
        assert one["gyro_x"].missing == 0
        assert one["gyro_y"].missing == int(np.isnan(y[:, 1]).sum())
        assert "missing)" in repr(one["gyro_y"])

    def test_paper_counting_and_disjoint_clusters(self):
        y = np.random.default_rng(seed_of("paper")).standard_normal(500)
        y[missing("paper", 500)] = np.nan
        paper = allan(Record.from_arrays(rate=1, y=y), counting="paper")["y"]
        shorter = allan(Record.from_arrays(rate=1, y=y[:-1]))["y"]
        assert paper.avar == pytest.approx(shorter.avar, rel=1e-12)
        disjoint = allan(Record.from_arrays(rate=1, y=y), overlap="none", taus=[7])["y"]
        rows = differences(np.isnan(y), 7)
        starts = [np.flatnonzero(row)[0] for row in rows]
        assert disjoint.n_pairs[0] <= 500 // 7 - 1 < len(starts)

    def test_what_is_not_there(self):
        y = np.full(100, np.nan)
        y[::40] = 1.0
        with pytest.raises(RecordTooShortError, match="misses 97 of 100 samples"):
            allan(Record.from_arrays(rate=1, y=y))
        y = np.random.default_rng(seed_of("half")).standard_normal(200_001)
        y[0] = np.nan
        with pytest.raises(OptionError, match="at most 100000 samples"):
            allan(Record.from_arrays(rate=1, y=y), taus="all")


class TestAnalysis:
    def test_record_with_gaps(self):
        y = np.random.default_rng(seed_of("analysis")).standard_normal((20_000, 3)) * 1e-3
        y[missing("analysis", 20_000)] = np.nan
        analysis = analyze(Record.from_arrays(rate=100, gyro=y))
        share = 100 * np.isnan(y[:, 0]).mean()
        assert f"20000 samples at 100 Hz (given), 200 s, {share:.2g} % of samples missing" in analysis.summary()
        for fitted in analysis.fits.values():
            assert fitted.verdict == "adequate"
            assert fitted["random_walk"].low <= 1e-4 <= fitted["random_walk"].high
        assert analysis.to_dict()["channels"]["gyro_x"]["samples"] == 20_000
        analysis.plot()

    def test_one_channel_with_hardly_a_sample(self):
        y = np.random.default_rng(seed_of("hardly")).standard_normal((5000, 3)) * 1e-3
        y[1:, 1] = np.nan
        analysis = analyze(Record.from_arrays(rate=100, gyro=y))
        assert list(analysis.curves) == ["gyro_x", "gyro_z"]
        faults = [(f.code, f.severity, f.channel) for f in analysis.findings if f.severity != "info"]
        assert faults == [("too_few_samples", "error", "gyro_y")]
        assert "none (gyro_x), 100 % (gyro_y)" in " ".join(analysis.summary().split())

    def test_a_constant_with_gaps(self):
        y = np.full(1000, 3.0)
        y[:10] = np.nan
        with pytest.raises(DataError, match="no channel is left to analyse"):
            analyze(Record.from_arrays(rate=100, gyro_x=y))

    def test_what_needs_every_sample_says_so(self):
        y = np.random.default_rng(seed_of("says so")).standard_normal(5000)
        y[17] = np.nan
        record = Record.from_arrays(rate=100, gyro_x=y)
        with pytest.raises(
            NonFiniteError, match=r"index 17.*the modified Allan deviation needs every one.*longest_run"
        ):
            deviation(record, kind="modified")
        with pytest.raises(NonFiniteError, match=r"bounded memory.*needs every one.*exact"):
            analyze(record, long="strided")


def test_least_squares_says_that_it_needs_every_sample():
    y = np.random.default_rng(seed_of("needs every sample")).standard_normal(5000)
    y[[17, 400]] = np.nan
    record = Record.from_arrays(rate=100, gyro_x=y)
    fitted = fit(allan(record)["gyro_x"])
    assert (fitted.verdict, fitted.reasons) == ("too_short", (IncompleteRecord(missing=2, samples=5000),))
    assert analyze(record, method="gls").fits["gyro_x"].reasons == fitted.reasons


@pytest.mark.parametrize("lost", MASKS)
def test_degrees_of_freedom_are_those_of_the_pairs(lost):
    """Against the scatter of 300 records, some 4 % of a standard deviation; a tenth is allowed for the approximation."""
    rng = np.random.default_rng(seed_of(f"freedom of the pairs {lost}"))
    found = []
    for _ in range(300):
        y = rng.standard_normal(N)
        y[MASKS[lost]] = np.nan
        found.append(allan(Record.from_arrays(rate=100, gyro_x=y), threads=1)["gyro_x"].avar)
    scatter = np.std(found, axis=0, ddof=1) / np.mean(found, axis=0)
    curve = analyze(Record.from_arrays(rate=100, gyro_x=1e-4 * y), at_rest=True).curves["gyro_x"]
    few = curve.m <= N // 8
    stated = np.sqrt(2 / curve.edf)
    assert stated[few] == pytest.approx(scatter[few], rel=0.1 + 3 * 0.04)


@pytest.mark.parametrize("method", ["likelihood", "gls"])
def test_a_short_record_with_gaps_is_not_sent_to_the_likelihood(method):
    """Too few samples for it: neither method is advised in place of the other."""
    values = np.random.default_rng(seed_of("short with gaps")).standard_normal(300)
    values[100:103] = np.nan
    record = Record.from_arrays(rate=100, gyro_x=1e-3 * values)
    (found,) = [one for one in analyze(record, method=method, at_rest=True).findings if one.code == "too_short"]
    assert not found.details.reasons[0].suits_likelihood
    assert "likelihood" not in str(found)
    assert found.action.startswith("Record longer")
