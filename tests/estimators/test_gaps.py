"""Records with missing samples: the estimator, what it is expected to show, its covariance, and the fit."""

import math
import pickle

import numpy as np
import pytest

from known import seed_of
from sigmatau import NoiseModel, Record, allan, analyze, deviation, fit, simulate
from sigmatau._native import kernels
from sigmatau.errors import DataError, NonFiniteError, OptionError, RecordTooShortError
from sigmatau.estimators.deviation_kinds import cluster_sizes
from sigmatau.estimators.gaps import Gaps
from sigmatau.findings.kinds.fit import IsolatedSamples
from sigmatau.fitting.components import LINEAR, components, pairs_of_terms
from sigmatau.fitting.masked_components import components_with_gaps, white_covariance

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
}


def lost(y, rng, *, outage=6000):
    """A record without 5 % of its samples, and without those of an outage."""
    left = np.where(rng.random(len(y)) < 0.05, np.nan, y)
    start = int(rng.integers(0, len(y) - outage))
    left[start : start + outage] = np.nan
    return left


def curve_with_gaps(truth, rng):
    """The curve of 2^15 simulated samples at 100 Hz, some of which are missing."""
    record = simulate(NoiseModel(channels={"gyro_x": truth}), duration=327.68, rate=100, rng=rng)
    y = lost(record.streams[0].column("gyro_x"), rng)
    return allan(Record.from_arrays(rate=100, gyro_x=y), threads=1)["gyro_x"]


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


def autocovariances(n):
    """Of unit processes; generalised for flicker, of which a constant makes no difference."""
    lag = np.abs(np.subtract.outer(np.arange(n), np.arange(n)))
    harmonic = np.concatenate([[0], np.cumsum(1 / (2 * np.arange(1, n) - 1))])
    return {
        "quantization": 2.0 * (lag == 0) - (lag == 1),
        "random_walk": 1.0 * (lag == 0),
        "bias_instability": -2 / math.pi * harmonic[lag],
        "rate_random_walk": np.minimum.outer(np.arange(1, n + 1), np.arange(1, n + 1)).astype(float),
    }


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
        assert one["gyro_x"].gaps is None
        assert one["gyro_y"].gaps.missing == int(np.isnan(y[:, 1]).sum())
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


class TestExpectations:
    @pytest.mark.parametrize("name", MASKS)
    def test_sums_over_the_mask(self, name):
        mask = MASKS[name][:240]
        sizes = [1, 2, 5, 12, 32, 80]
        expected = Gaps.of(mask).expected(sizes)
        of = autocovariances(len(mask))
        for k, m in enumerate(sizes):
            rows = differences(mask, m)
            for p, term in enumerate(LINEAR):
                sums = 0.5 * np.mean(np.sum(rows @ of[term] * rows, axis=1))
                # Flicker by a quadrature; the sums here are of large numbers for the random walk of the rate.
                assert expected.avar[k, p] == pytest.approx(sums, rel=1e-4 if term == "bias_instability" else 1e-10)
            assert expected.square_distance[k] == pytest.approx(np.mean((rows @ np.arange(len(mask))) ** 2), rel=1e-10)
            for time in (3.0, 25.0, 400.0):
                lag = np.abs(np.subtract.outer(np.arange(len(mask)), np.arange(len(mask))))
                sums = 0.5 * np.mean(np.sum(rows @ np.exp(-lag / time) * rows, axis=1))
                got = Gaps.of(mask).gauss_markov_ratio(time, [m])[0] * kernels.gauss_markov_avar(1.0, time, [m], 1.0)[0]
                assert got == pytest.approx(sums, rel=2e-3)  # interpolated between correlation times

    def test_nothing_missing(self):
        expected = Gaps.of(np.zeros(N, dtype=bool)).expected(SIZES)
        assert expected.avar == pytest.approx(components(N, tuple(SIZES.tolist())).design, rel=1e-9)
        assert expected.ratios == pytest.approx(np.ones_like(expected.ratios), rel=1e-9)

    @pytest.mark.parametrize("term", LINEAR)
    def test_simulated_records(self, term):
        mask = MASKS["both"]
        variances = []
        rng = np.random.default_rng(seed_of("simulated " + term))
        for _ in range(400):
            y = kernels.simulate(N, 1.0, {term: 1.0}, seed=int(rng.integers(1 << 62)), stream=0)
            y[mask] = np.nan
            variances.append(
                kernels.masked_variances(y, SIZES, overlap="full", counting="standard", threads=1, name="y")[0]
            )
        expected = Gaps.of(mask).expected(SIZES).avar[:, LINEAR.index(term)]
        error = np.std(variances, axis=0, ddof=1) / math.sqrt(len(variances))
        # As many sizes as there are, hardly independent: 4 standard errors.
        assert np.all(np.abs(np.mean(variances, axis=0) - expected) < 4 * error)

    def test_lost_samples_leave_white_noise_of_quantization(self):
        """3.3 times the variance at 64 samples and 10.2 times at 256, 5 % missing at random (simulated elsewhere)."""
        ratio = Gaps.of(missing("quantization", 200_000)).ratio("quantization", [64, 256])
        assert ratio == pytest.approx([3.3, 10.2], rel=0.05)

    def test_one_object_for_one_mask(self):
        mask = MASKS["both"]
        gaps = Gaps.of(mask)
        assert Gaps.of(mask.copy()) is gaps
        assert pickle.loads(pickle.dumps(gaps)) is gaps
        assert Gaps.of(mask[:-1]) is not gaps
        assert np.array_equal(gaps.there, ~mask)
        assert repr(gaps) == f"Gaps: {mask.sum()} of 1024 samples missing"


class TestCovariance:
    @pytest.mark.parametrize("name", MASKS)
    def test_exact_sums(self, name):
        """How near the approximation comes to all pairs of pairs: N + B + K; 13 % off at worst, at two samples."""
        n, mask = N // 2, MASKS[name][N // 4 : 3 * N // 4]
        sizes = np.array([2, 4, 8, 16, 32, 64, 128])
        parts = components_with_gaps(n, tuple(sizes.tolist()), Gaps.of(mask))
        theta = np.array([0.0, 1.0, 0.05, 1e-4])
        of = autocovariances(n)
        process = sum(t * of[term] for t, term in zip(theta, LINEAR, strict=True))
        rows = [differences(mask, int(m)) for m in sizes]
        half = [a @ process for a in rows]
        exact = np.array([[0.5 * np.mean((a @ b.T) ** 2) for b in rows] for a in half])
        got = parts.covariance(theta)
        assert got == pytest.approx(exact, rel=0.15)
        assert np.linalg.eigvalsh(got / np.sqrt(np.outer(np.diag(got), np.diag(got)))).min() > 0
        # As a fit sees it: misfits would be as large as they should be, to a fifth.
        assert np.trace(np.linalg.solve(got, exact)) / len(sizes) == pytest.approx(1, abs=0.2)

    @pytest.mark.parametrize("name", MASKS)
    @pytest.mark.parametrize("time", [None, 30.0])
    def test_positive_definite(self, name, time):
        parts = components_with_gaps(N, tuple(SIZES.tolist()), Gaps.of(MASKS[name]), correlation_time=time)
        for theta in np.eye(len(parts.names)) + 0.01:
            covariance = parts.covariance(theta)
            assert np.linalg.eigvalsh(covariance / np.sqrt(np.outer(*[np.diag(covariance)] * 2))).min() > 0

    def test_without_gaps_blocks_change_little(self):
        """The way of the blocks, taken where it is not needed."""
        whole = components(N, tuple(SIZES.tolist()))
        same = components_with_gaps(N, tuple(SIZES.tolist()), Gaps.of(np.zeros(N, dtype=bool)))
        scale = np.sqrt([np.outer(np.diag(m), np.diag(m)) for m in whole.noise[[4, 7, 9]]])
        assert [pairs_of_terms(4)[k] for k in (4, 7, 9)] == [(1, 1), (2, 2), (3, 3)]
        assert np.abs((same.noise - whole.noise)[[4, 7, 9]] / scale).max() < 0.02


class TestFit:
    def test_unbiased_and_covered(self):
        """Least squares on the curve of a record with gaps: a free fit of the terms that are there, with intervals."""
        truth, count = {"quantization": 0.002, "random_walk": 0.05, "bias_instability": 0.1}, 6
        rng = np.random.default_rng(seed_of("gaps Q N B both"))
        fits = [fit(curve_with_gaps(truth, rng), terms=truth) for _ in range(count)]
        assert np.mean([each.verdict != "adequate" for each in fits]) <= 0.05 + 3 * math.sqrt(0.05 * 0.95 / count)
        for term, value in truth.items():
            ratios = np.array([(each.model[term] / value) ** 2 for each in fits])
            assert abs(ratios.mean() - 1) < 3 * ratios.std(ddof=1) / math.sqrt(count)
            held = [each[term].low <= value <= each[term].high for each in fits]
            assert np.mean(held) >= 0.92 - 3 * math.sqrt(0.08 * 0.92 / count)

    def test_a_ramp_is_seen_through_gaps(self):
        truth = {"random_walk": 0.05, "rate_ramp": 2e-3}
        rng = np.random.default_rng(seed_of("ramp through gaps"))
        record = simulate(NoiseModel(channels={"gyro_x": truth}), duration=327.68, rate=100, rng=rng)
        y = lost(record.streams[0].column("gyro_x"), rng)
        fitted = fit(allan(Record.from_arrays(rate=100, gyro_x=y))["gyro_x"])
        ramp = fitted["rate_ramp"]
        assert ramp.observed
        assert ramp.low <= 2e-3 <= ramp.high
        assert ramp.low > 1e-3

    def test_no_ramp_where_there_is_none(self):
        """Lost samples leave noise in the mean differences of short clusters, which looks like a ramp."""
        rng = np.random.default_rng(seed_of("no ramp"))
        model = NoiseModel(channels={"gyro_x": {"random_walk": 0.05, "rate_random_walk": 0.05}})
        seen, count = [], 10
        for k in range(count):
            whole = simulate(model, duration=327.68, rate=100, rng=rng).streams[0].column("gyro_x")
            # Two masks: what is expected of each takes most of the time.
            y = lost(whole, np.random.default_rng(seed_of(f"no ramp, mask {k % 2}")), outage=0)
            curve = allan(Record.from_arrays(rate=100, gyro_x=y))["gyro_x"]
            seen.append(fit(curve, terms=["random_walk", "rate_random_walk", "rate_ramp"])["rate_ramp"].observed)
        assert np.mean(seen) <= 0.05 + 3 * math.sqrt(0.05 * 0.95 / count)

    def test_variance_and_freedom_are_those_of_the_record(self):
        truth = {"quantization": 0.002, "random_walk": 0.05, "bias_instability": 0.1}
        rng = np.random.default_rng(seed_of("freedom"))
        record = simulate(NoiseModel(channels={"gyro_x": truth}), duration=327.68, rate=100, rng=rng)
        y = lost(record.streams[0].column("gyro_x"), rng)
        curve = allan(Record.from_arrays(rate=100, gyro_x=y))["gyro_x"]
        fitted = fit(curve)
        ratio = curve.avar / fitted.avar(m=curve.m)
        edf = fitted.degrees_of_freedom(m=curve.m)
        assert np.all(np.abs(ratio - 1) < 5 * np.sqrt(2 / edf))
        whole = allan(record)["gyro_x"]
        assert np.all(edf[curve.m < 1000] < fit(whole).degrees_of_freedom(m=curve.m[curve.m < 1000]))


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
        assert "none (gyro_x), 1e+02 % (gyro_y)" in analysis.summary() or "100 % (gyro_y)" in analysis.summary()

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


class TestMuchMissing:
    @pytest.mark.parametrize("share", [0.5, 0.7, "every second"])
    def test_covariance_of_white_noise(self, share):
        """Against all pairs of pairs of clusters; 1.3 % off at worst."""
        mask = np.arange(500) % 2 == 1 if share == "every second" else missing(f"much {share}", 500, share=share)
        rows = {m: differences(mask, m) for m in (1, 2, 4, 8, 16, 32)}
        sizes = [m for m, found in rows.items() if len(found)]
        exact = np.array([[0.5 * np.mean((rows[a] @ rows[b].T) ** 2) for b in sizes] for a in sizes])
        root = np.sqrt(np.diag(exact))
        got = white_covariance(~mask, np.array(sizes))
        assert got / np.outer(root, root) == pytest.approx(exact / np.outer(root, root), abs=0.03)

    @pytest.mark.parametrize("share", [0.5, 0.7])
    def test_a_good_model_is_called_good(self, share):
        """Of 200 records of 10⁵ samples 2 were refused at 50 %, none at 70 %; a third before."""
        model = NoiseModel(channels={"gyro_x": {"random_walk": 0.05, "bias_instability": 0.08}})
        good, white, count = [], [], 2
        for k in range(count):
            y = simulate(model, duration=400, rate=100, rng=seed_of(f"good {share} {k}") % 2**60)
            x = np.where(missing(f"good mask {share} {k}", 40_000, share=share), np.nan, y.streams[0].column("gyro_x"))
            fitted = fit(allan(Record.from_arrays(rate=100, gyro_x=x))["gyro_x"])
            good.append(fitted.verdict == "adequate")
            white.append(fitted.model.get("random_walk", 0.0))
        # 1 % of all records and three standard errors.
        assert np.mean(good) >= 1 - 0.01 - 3 * math.sqrt(0.01 / count)
        # What bias instability there is at short times is part of it where it is not seen.
        assert np.mean(white) == pytest.approx(0.05, rel=0.03)

    def test_every_second_sample(self):
        """Quantization noise of samples that are two apart is white: it is no other term."""
        model = NoiseModel(channels={"gyro_x": {"random_walk": 0.05}})
        x = simulate(model, duration=400, rate=100, rng=seed_of("second") % 2**60).streams[0].column("gyro_x").copy()
        x[1::2] = np.nan
        fitted = fit(allan(Record.from_arrays(rate=100, gyro_x=x))["gyro_x"])
        # 20 000 samples: 0.5 %.
        assert fitted.observed["random_walk"] == pytest.approx(0.05, rel=0.02)
        assert "quantization" not in fitted.observed
        assert fitted.reasons[-1] == IsolatedSamples()
