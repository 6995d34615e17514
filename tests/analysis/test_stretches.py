"""A record that is summed in stretches: the curve of the stream, gaps included."""

import itertools
import pickle

import numpy as np
import pytest

import sigmatau
from known import seed_of
from sigmatau.analysis import stretches
from sigmatau.analysis.stretches import as_complete
from sigmatau.errors import DataError, OptionError
from sigmatau.estimators.gapped import GappedSums
from sigmatau.io.read.formats import zarr_store
from sigmatau.io.read.stretches import unread

zarr = pytest.importorskip("zarr", reason="records in chunks need the extra cluster")

N, CHUNK = 600_000, 20_000
AXES = ("gyro_x", "gyro_y")


def noise(name, n=N, axes=2):
    return 1e-3 * np.random.default_rng(seed_of(name)).standard_normal((n, axes))


def store(path, x, *, version=3, columns=AXES):
    group = zarr.open_group(str(path), mode="w", zarr_format=version, attributes={"rate": 100.0})
    for k, name in enumerate(columns):
        array = group.create_array(name, shape=(len(x),), chunks=(CHUNK,), dtype="f8", attributes={"unit": "rad/s"})
        array[:] = x[:, k]
    return path


def key(path, version, name, number):
    return path / name / str(number) if version == 2 else path / name / "c" / str(number)


@pytest.fixture(autouse=True)
def small_stretches(monkeypatch):
    monkeypatch.setattr(stretches, "_VALUES", 200_000)
    monkeypatch.setattr(zarr_store, "_BLOCK_BYTES", 1)


def summed(place, **reading):
    """The sums of all stretches, each as it comes from another process, and the plan."""
    plan = stretches.divide(str(place), reading, {})
    parts = [
        pickle.loads(pickle.dumps(stretches.sum_stretch(str(place), reading, *bounds))) for bounds in plan.stretches
    ]
    assert len(parts) > 5
    for part in parts[1:]:
        stretches.merge_sums(parts[0], part)
    return parts[0], plan


def streamed(x):
    stream = sigmatau.Accumulator(*AXES, rate=100, long="strided")
    stream.push(x)
    return stream.snapshot()


@pytest.mark.parametrize("version", [2, 3])
def test_the_curve_is_that_of_the_stream(tmp_path, version):
    x = noise("stretches, whole") + np.array([5.0, -3.0])  # a mean a thousand times the noise
    found, plan = summed(store(tmp_path / "long.zarr", x, version=version))
    expected = streamed(x)
    for name in AXES:
        curve = found[name].snapshot()
        same = expected[name].at(curve.m)
        np.testing.assert_allclose(curve.avar, same.avar, rtol=1e-12)
        np.testing.assert_array_equal(curve.n_pairs, same.n_pairs)
        assert curve.m[-1] == expected[name].m[-1]
    assert [start for start, _ in plan.stretches] == [k * 100_000 for k in range(6)]


def test_npy_is_divided_too(tmp_path):
    x = noise("stretches, npy")
    np.save(tmp_path / "long.npy", x)
    found, _ = summed(tmp_path / "long.npy", rate=100, channels={"gyro_x": 1, "gyro_y": 2}, unit={"gyro": "rad/s"})
    expected = streamed(x)["gyro_x"]
    curve = found["gyro_x"].snapshot()
    np.testing.assert_allclose(curve.avar, expected.at(curve.m).avar, rtol=1e-12)


def pooled(x, sizes, strides):
    """Pairs within runs, by another way: phase of each run, starts at multiples of the stride from the first sample."""
    ends = np.flatnonzero(np.diff(np.concatenate([[0], np.isfinite(x), [0]]))).reshape(-1, 2)
    phases = []
    for start, stop in ends:
        run = x[start:stop].astype(np.longdouble)
        phases.append(np.concatenate([np.zeros(1, np.longdouble), np.cumsum(run - run.mean())]))
    for m, stride in zip(sizes, strides, strict=True):
        squares = []
        for (start, stop), phase in zip(ends, phases, strict=True):
            k = np.arange(-start % stride, stop - start - 2 * m + 1, stride)
            squares.append((phase[k + 2 * m] - 2 * phase[k + m] + phase[k]) ** 2)
        every = np.concatenate(squares)
        yield every.sum() / (2.0 * m * m * len(every)), len(every)


GAPS = {
    "none at the ends": [(50_000, 50_001), (99_999, 100_001), (123_456, 250_000), (250_001, 250_004)],
    "at both ends": [(0, 7), (400_000, 400_100), (N - 3, N)],
    "a whole stretch": [(100_000, 200_000), (300_000, 300_001)],
    "single samples": [(k, k + 1) for k in range(1000, N, 45_678)],
    "all but one run": [(0, 200_000), (340_000, N)],
}


@pytest.mark.parametrize("case", GAPS)
def test_pairs_within_runs_count(tmp_path, case):
    x = noise(f"stretches, {case}")
    for start, stop in GAPS[case]:
        x[start:stop, 0] = np.nan
    found, _ = summed(store(tmp_path / "gaps.zarr", x))
    curve = found["gyro_x"].snapshot()
    strides = np.ones_like(curve.m) if curve.stride is None else curve.stride
    variances, pairs = zip(*pooled(x[:, 0], curve.m, strides), strict=True)
    np.testing.assert_allclose(curve.avar, variances, rtol=1e-12)
    np.testing.assert_array_equal(curve.n_pairs, pairs)
    assert curve.missing == np.isnan(x[:, 0]).sum()
    assert found["gyro_y"].snapshot().missing == 0  # each channel by itself


def test_any_division_gives_the_same(tmp_path):
    """Stretches of every kind of border: in a run, in a gap, before and behind it."""
    rng = np.random.default_rng(seed_of("stretches, divisions"))
    x = rng.standard_normal(5000)
    x[rng.random(5000) < 0.002] = np.nan
    x[2000:2300] = np.nan

    def new(start):
        return sigmatau.Accumulator("gyro_x", rate=1, long="strided", start=start)

    whole = GappedSums(new)
    whole.push(x)
    expected = whole.snapshot()
    for _ in range(50):
        borders = [0, *sorted(rng.integers(0, 5000, 6).tolist()), 5000]
        parts = []
        for start, stop in itertools.pairwise(borders):
            part = GappedSums(new, start)
            part.push(x[start:stop])
            parts.append(part)
        while len(parts) > 1:  # in any order of neighbours
            k = int(rng.integers(len(parts) - 1))
            parts[k].merge(parts.pop(k + 1))
        curve = parts[0].snapshot()
        np.testing.assert_allclose(curve.avar, expected.avar, rtol=1e-12)
        np.testing.assert_array_equal(curve.n_pairs, expected.n_pairs)
        assert curve.missing == expected.missing


def test_stretches_must_follow_each_other():
    def new(start):
        return sigmatau.Accumulator("gyro_x", rate=1, start=start)

    first, later = GappedSums(new), GappedSums(new, 10)
    first.push(np.zeros(9))
    with pytest.raises(ValueError, match="begins at sample 10, this one ends before 9"):
        first.merge(later)


@pytest.mark.parametrize("version", [2, 3])
def test_a_missing_chunk_is_a_stated_gap(tmp_path, version):
    x = noise("stretches, chunk")
    place = store(tmp_path / "long.zarr", x, version=version)
    key(place, version, "gyro_x", 7).unlink()
    found, plan = summed(place)
    (lost,) = plan.findings
    assert (lost.code, lost.severity, lost.details.count, lost.details.first) == (
        "missing_chunks",
        "error",
        1,
        7 * CHUNK,
    )
    x[7 * CHUNK : 8 * CHUNK, 0] = np.nan
    curve = found["gyro_x"].snapshot()
    assert curve.missing == CHUNK
    strides = np.ones_like(curve.m) if curve.stride is None else curve.stride
    np.testing.assert_allclose(curve.avar, next(zip(*pooled(x[:, 0], curve.m, strides), strict=True)), rtol=1e-12)
    result = stretches.analyze_sums(plan, found, method="likelihood")
    codes = [one.code for one in result.findings]
    assert {"missing_chunks", "in_stretches", "pairs_across_gaps"} <= set(codes)
    for name in AXES:
        term = result[name]["random_walk"]
        assert term.low < 1e-4 < term.high


@pytest.mark.parametrize("version", [2, 3])
def test_a_damaged_chunk_is_an_error(tmp_path, version):
    place = store(tmp_path / "long.zarr", noise("stretches, damage"), version=version)
    chunk = key(place, version, "gyro_y", 12)
    chunk.write_bytes(chunk.read_bytes()[:1000])
    with pytest.raises(DataError, match=r"chunk (c/)?12 of array gyro_y is damaged \(.*copy it again, or delete it"):
        summed(place)


def test_coverage_with_gaps():
    """Intervals of the curve with gaps hold: 95 % of them contain the random walk, within 3 standard errors."""
    trials, inside = 150, 0
    for trial in range(trials):
        x = noise(f"trial stretches, coverage {trial}", 20_000, 1)[:, 0]
        x[6000:6500] = x[15_000:15_003] = np.nan
        sums = GappedSums(lambda start: sigmatau.Accumulator("gyro_x", rate=100, long="strided", start=start))
        sums.push(x)
        curve = sums.snapshot()
        walk = sigmatau.fit(as_complete(curve))["random_walk"]
        inside += walk.low <= 1e-4 <= walk.high
    assert abs(inside / trials - 0.95) <= 3 * np.sqrt(0.95 * 0.05 / trials) + 0.02  # and 5 % wider intervals


def test_what_needs_all_samples_is_refused(tmp_path):
    place = str(store(tmp_path / "long.zarr", noise("stretches, refused", 1000)))
    with pytest.raises(OptionError, match="needs the whole record in a worker"):
        stretches.divide(place, {}, {"window": "0s:5s"})
    (tmp_path / "log.csv").write_text("gyro_x [rad/s]\n" + "1e-3\n2e-3\n" * 50)
    with pytest.raises(DataError, match="which is not read in stretches"):
        unread(tmp_path / "log.csv", rate=100)
    np.save(tmp_path / "log.npy", np.zeros((100, 1)))
    with pytest.raises(OptionError, match="states no rate"):
        unread(tmp_path / "log.npy", channels={"gyro_x": 1}, unit={"gyro": "rad/s"})
