"""Stationarity and correlation of axes: the laws of the tests, planted changes, and what cannot be judged."""

import numpy as np
import pytest
from studies.samples import simulated

from known import seed_of
from sigmatau import NoiseModel, Record, allan, analyze, read, simulate
from sigmatau.fitting.fit import fit
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.quality.drift.stationarity import cusum, non_stationary, segment_test
from sigmatau.quality.spectrum.axis_correlation import INFLATION, _chance, cross_axis

N = 4096
MIXTURES = {
    "N": {"random_walk": 1.0},
    "Q and B": {"quantization": 10.0, "bias_instability": 0.2},
    "K": {"random_walk": 0.01, "rate_random_walk": 1.0},
    "N, B, R": {"random_walk": 1.0, "bias_instability": 0.3, "rate_ramp": 1e-3},
}


def true_fit(model, n=N):
    return NoiseFit(
        channel="x", quantity="signal", rate_unit="1", n=n, tau0=1.0, terms={}, model=model, verdict="adequate", tau_min=1.0
    )  # fmt: skip


def fits_of(stream):
    return {channel: fit(curve) for channel, curve in allan(Record(streams=(stream,))).items()}


@pytest.mark.parametrize("name", MIXTURES)
def test_law_of_the_segments_and_the_cusum(name):
    """The size of both tests at 5 % and 1 %; at 1e-4 docs/study/stability.md has it from 36,000 records."""
    rng = np.random.default_rng(seed_of(f"law {name}"))
    records, p = 120, []
    for _ in range(records):
        y = simulated(N, 1.0, MIXTURES[name], seed=int(rng.integers(1 << 62)))
        p.append([segment_test(y, true_fit(MIXTURES[name])).p_value, cusum(y).p_value])
    for level in (0.05, 0.01):
        share = (np.array(p) < level).mean(axis=0)
        # At most 1.3 times the nominal size, see the study, and three standard errors; at least half of it.
        least, most = 0.5 * level, 1.3 * level
        assert (share <= most + 3 * np.sqrt(most * (1 - most) / records)).all(), (level, share)
        assert (share >= least - 3 * np.sqrt(least * (1 - least) / records)).all(), (level, share)


def test_clean_records_raise_nothing():
    """Fits and all: 10 records of two axes; a warning in 0.1 % of channels is asked for, so that one is a chance of 2 %."""
    rng = np.random.default_rng(seed_of("clean"))
    model = NoiseModel(
        channels={
            "gyro_x": {"random_walk": 1e-4, "bias_instability": 2e-5},
            "gyro_y": {"quantization": 1e-4, "random_walk": 1e-4, "rate_random_walk": 1e-6},
        }
    )
    warned = 0
    for _ in range(10):
        stream = simulate(model, duration=600, rate=20, rng=rng).streams[0]
        found = [*non_stationary(stream, fits_of(stream)), *cross_axis(stream)]
        warned += sum(finding.severity == "warning" for finding in found)
    assert warned <= 1


def changed(name, *, factor, n=72_000, rate=10.0):
    rng = np.random.default_rng(seed_of(name))
    x = 1e-3 * rng.standard_normal(n)
    x[n // 2 :] *= factor
    return Record.from_arrays(rate=rate, gyro_x=x).streams[0]


def test_a_change_of_noise_is_found_with_its_time_and_size():
    stream = changed("louder", factor=1.5)
    (finding,) = non_stationary(stream, fits_of(stream))
    assert (finding.code, finding.severity, finding.channel) == ("non_stationary", "warning", "gyro_x")
    # Segments and the cusum both know 1.5; each segment's deviation at short τ has an error of 0.6 %.
    assert finding.size == pytest.approx(1.5, rel=0.1)
    ((when, _),) = finding.spans
    # The change is located to the block of a thousandth of the record, but for a few where the noise does not tell.
    assert when == pytest.approx(3600, abs=72)
    assert finding.details.change.time == when
    assert finding.details.change.ratio == pytest.approx(1.5, rel=0.02)
    assert finding.details.segments.ratio == pytest.approx(1.5, rel=0.1)
    assert finding.details.segments.largest_at >= 3600 > finding.details.segments.smallest_at


def test_a_small_change_is_an_info_and_a_very_small_one_nothing():
    stream = changed("slightly louder", factor=1.1)
    (finding,) = non_stationary(stream, fits_of(stream))
    assert finding.severity == "info"
    assert non_stationary(changed("hardly louder", factor=1.02), {}) == []


def test_a_slow_change_shows_at_long_times_alone():
    """A rate random walk in one half: first differences know nothing of it, segments do."""
    rng = np.random.default_rng(seed_of("walk in one half"))
    n = 72_000
    x = 1e-3 * rng.standard_normal(n)
    x[n // 2 :] += 3e-5 * np.cumsum(rng.standard_normal(n // 2))
    assert cusum(x).p_value > 1e-4
    stream = Record.from_arrays(rate=10.0, gyro_x=x).streams[0]
    (finding,) = non_stationary(stream, fits_of(stream))
    assert finding.severity == "warning"
    assert finding.details.change is None
    ((start, stop),) = finding.spans
    assert start == finding.details.segments.largest_at >= 3600
    assert stop == start + 900


def test_gaps():
    """Segments that miss samples are left out; the cusum goes on."""
    stream = changed("gaps", factor=1.5)
    x = stream.column("gyro_x").copy()
    fits = fits_of(stream)
    x[100:200] = x[40_000] = np.nan
    tested = segment_test(x, fits["gyro_x"])
    assert tested.starts.tolist() == [9000 * k for k in (1, 2, 3, 5, 6, 7)]
    gapped = Record.from_arrays(rate=10.0, gyro_x=x).streams[0]
    (finding,) = non_stationary(gapped, fits)
    assert finding.severity == "warning"
    x[::7] = np.nan
    assert segment_test(x, fits["gyro_x"]) is None
    assert cusum(x).p_value < 1e-6


def test_a_change_begins_with_the_first_block_that_has_it():
    """An alternating signal of amplitude 1, and of 10 from a boundary of the blocks of 64 samples on."""
    at = 300 * 64
    x = (-1.0) ** np.arange(2**16) * np.where(np.arange(2**16) < at, 1.0, 10.0)
    found = cusum(x)
    assert found.sample == at
    assert found.ratio == pytest.approx(100)


def test_no_judgement():
    assert cusum(np.arange(100.0)) is None
    assert cusum(np.zeros(10_000)) is None
    assert cusum(np.full(10_000, np.nan)) is None
    assert segment_test(np.zeros(400), true_fit({"random_walk": 1.0}, 400)) is None
    assert segment_test(np.ones(N), true_fit({})) is None
    stream = Record.from_arrays(rate=10.0, gyro_x=np.zeros(10_000)).streams[0]
    assert non_stationary(stream, {}) == []


def three_axes(name, n=20_000, rate=20.0, *, common=0.0):
    rng = np.random.default_rng(seed_of(name))
    y = rng.standard_normal((n, 3))
    shared = rng.standard_normal(n)
    y[:, :2] = np.sqrt(1 - common) * y[:, :2] + np.sqrt(common) * shared[:, None]
    return Record.from_arrays(rate=rate, accel=y).streams[0]


def test_correlated_axes():
    (finding,) = cross_axis(three_axes("common", common=0.4))
    assert (finding.code, finding.severity) == ("correlated_axes", "info")
    assert finding.channels == ("accel_x", "accel_y")
    # White noise of 20000 samples: the correlation of differences has the error √(1.5/20000) = 0.9 %.
    assert finding.size == pytest.approx(0.4, abs=4 * 0.009)
    (pair,) = finding.details.pairs
    assert (pair.first, pair.second, pair.mean_length) == ("accel_x", "accel_y", 0.0)
    assert pair.coefficient == finding.size
    (weak,) = cross_axis(three_axes("weakly common", common=0.15))
    assert weak.severity == "info"


def test_slow_common_noise():
    """Common to two axes only over seconds: neighbouring samples do not show it."""
    rng = np.random.default_rng(seed_of("slow common"))
    n = 40_000
    y = rng.standard_normal((n, 3))
    y[:, :2] += 0.1 * np.cumsum(rng.standard_normal(n))[:, None]
    (finding,) = cross_axis(Record.from_arrays(rate=20.0, gyro=y).streams[0])
    assert finding.details.only_slow


@pytest.mark.parametrize("lost", [0.0, 0.05])
@pytest.mark.parametrize("walk", [1e-4, 3e-5])
def test_a_walk_that_axes_share(walk, lost):
    """One rate random walk on three axes, hidden by their own white noise in means over 1 s; with lost samples, too."""
    rng = np.random.default_rng(seed_of(f"shared walk {walk} {lost}"))
    n = 100_000
    shared = walk / np.sqrt(50.0) * np.cumsum(rng.standard_normal(n))
    y = 3e-4 * np.sqrt(50.0) * rng.standard_normal((n, 3)) + shared[:, None] * [1.0, -1.0, 1.0]
    y[rng.random((n, 3)) < lost] = np.nan
    (finding,) = cross_axis(Record.from_arrays(rate=50.0, gyro=y).streams[0])
    assert (finding.code, finding.severity) == ("correlated_axes", "info")
    # Differences of means over T have the variance 2(N²/T + K²T/3), the last part of which is shared; of 61 means at least
    # the correlation has an error of (1 − r²)/√(61/1.125).
    length = finding.details.pairs[0].mean_length
    expected = 1 / (1 + 3 * (3e-4 / (walk * length)) ** 2)
    assert finding.size == pytest.approx(expected, abs=3 * max((1 - expected**2) / np.sqrt(61 / 1.125), 0.03))
    pairs = {(pair.first, pair.second) for pair in finding.details.pairs}
    assert pairs == {("gyro_x", "gyro_y"), ("gyro_x", "gyro_z"), ("gyro_y", "gyro_z")}


def test_axes_that_warm_up_together_are_no_warning():
    """The fit allows for the drifts; that the axes share them is information."""
    rng = np.random.default_rng(seed_of("together"))
    n = 60_000
    drift = 6e-3 * np.exp(-np.arange(n) / 20.0 / 900)
    y = 1e-3 * rng.standard_normal((n, 2)) + drift[:, None]
    found = analyze(Record.from_arrays(rate=20.0, gyro_x=y[:, 0], gyro_y=y[:, 1])).findings
    assert sorted((f.code, f.severity) for f in found) == [
        ("correlated_axes", "info"),
        ("warm_up", "info"),
        ("warm_up", "info"),
    ]


@pytest.mark.parametrize("terms", MIXTURES)
def test_law_of_few_means(terms):
    """Of 61 means of any colour no more than 1e-3 of pairs pass the bound of 1e-3, which is made for the worst."""
    rng = np.random.default_rng(seed_of(f"few means {terms}"))
    changes = []
    for _ in range(90):
        y = simulated(61 * 8, 1.0, MIXTURES[terms], seed=int(rng.integers(1 << 62)))
        d = np.diff(y.reshape(61, 8).mean(axis=1))
        d -= d.mean()
        changes.append(d / np.linalg.norm(d))
    both = np.abs(np.array(changes) @ np.array(changes).T)[np.triu_indices(90, 1)]
    # 4005 pairs, nearly independent of each other: √(1e-3/4005) is the error.
    assert np.mean(both > _chance(60, 1e-3, INFLATION)) <= 1e-3 + 3 * np.sqrt(1e-3 / len(both))


def test_correlation_with_gaps_and_without_noise():
    stream = three_axes("gaps in axes", common=0.5)
    y = np.stack([stream.column(c) for c in stream.channels], axis=1)
    y[::50, 0] = np.nan
    y[3000:9000, 2] = np.nan
    (finding,) = cross_axis(Record.from_arrays(rate=20.0, accel=y).streams[0])
    assert finding.size == pytest.approx(0.5, abs=0.05)
    y[:, 0] = np.nan
    y[:, 1] = 3.0
    assert cross_axis(Record.from_arrays(rate=20.0, accel=y).streams[0]) == []
    assert cross_axis(stream.only("accel_x")) == []
    y = np.random.default_rng(seed_of("extreme")).standard_normal((20_000, 3)) * [1.0, 1e130, 1e-200]
    assert cross_axis(Record.from_arrays(rate=20.0, accel=y).streams[0]) == []


@pytest.mark.parametrize("name", ["white", "angle", "filtered", "walk"])
def test_law_of_the_correlation(name):
    """Independent axes of any colour: at most one finding in 180 pairs, where 1e-4 of streams is asked for."""
    rng = np.random.default_rng(seed_of(f"correlation {name}"))
    found = 0
    for _ in range(60):
        y = rng.standard_normal((3000, 3))
        if name == "angle":
            y = np.diff(y, axis=0)
        elif name == "filtered":
            y = np.apply_along_axis(np.convolve, 0, y, np.ones(20), mode="valid")
        elif name == "walk":
            y = np.cumsum(y, axis=0)
        found += len(cross_axis(Record.from_arrays(rate=10.0, gyro=y).streams[0]))
    assert found <= 1


def test_ramps_are_not_correlated():
    """All axes may have a ramp; that is no common noise."""
    rng = np.random.default_rng(seed_of("ramps"))
    y = rng.standard_normal((20_000, 3)) + 0.05 * np.arange(20_000)[:, None]
    assert cross_axis(Record.from_arrays(rate=20.0, gyro=y).streams[0]) == []


def test_real_accelerometers_share_a_line(field_data):
    """Six ADIS16405 axes: the accelerometers have a line at 0.53 … 0.57 Hz in common, the gyros nothing."""
    record = read(field_data / "adis16405_static.csv.gz", rate=100)
    gyro, accel = record.streams
    assert cross_axis(gyro) == []
    (finding,) = cross_axis(accel)
    assert finding.severity == "info"
    assert any((p.first, p.second, p.mean_length) == ("accel_x", "accel_y", 1.0) for p in finding.details.pairs)
    accel = accel.only("accel_x")
    fits = fits_of(accel)
    # It is not quite steady: the deviation moves by a tenth.
    found = non_stationary(accel, fits)
    assert found
    assert all(1.05 <= one.size < 1.3 for one in found)
