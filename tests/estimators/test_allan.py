"""The curve: known answers, identities, laws, and a slow twin written from another equation."""

import math
import os
import re
import signal

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import known
from sigmatau import NoiseModel, Record, allan, analyze
from sigmatau._native import arguments
from sigmatau.errors import DataError, NonFiniteError, OptionError, RecordTooShortError
from sigmatau.estimators.accumulator import accumulate
from sigmatau.estimators.deviation_kinds import cluster_sizes


def record(y, rate=1.0):
    return Record.from_arrays(rate=rate, y=y)


def adev(y, m, **options):
    curve = allan(record(y), taus=list(m), **options)["y"]
    assert curve.m.tolist() == sorted(m)
    return dict(zip(curve.m.tolist(), curve.adev, strict=True))


def clusters(y, m, *, step):
    """Eq. (6) of the paper as it stands: cluster means and their differences, by loops over NumPy slices."""
    differences = [(np.mean(y[k + m : k + 2 * m]) - np.mean(y[k : k + m])) for k in range(0, len(y) - 2 * m + 1, step)]
    return np.mean(np.square(differences)) / 2, len(differences)


class TestKnownAnswers:
    def test_nbs14_overlapped(self):
        got = adev(known.nbs14(), known.NBS14_OVERLAPPED)
        assert got == pytest.approx(known.NBS14_OVERLAPPED, rel=1e-12)
        for m, printed in known.NBS14_PRINTED.items():
            assert float(f"{got[m]:.6e}") == printed

    def test_nbs14_disjoint(self):
        assert adev(known.nbs14(), known.NBS14_DISJOINT, overlap="none") == pytest.approx(
            known.NBS14_DISJOINT, rel=1e-12
        )

    def test_nine_points(self):
        """NIST SP 1065, table 30: nine digits."""
        assert adev(known.NINE_POINTS, [1, 2])[2] == pytest.approx(85.95287, abs=5e-6)
        disjoint = adev(known.NINE_POINTS, [1, 2], overlap="none")
        assert disjoint[1] == pytest.approx(91.22945, abs=5e-6)
        assert disjoint[2] == pytest.approx(115.808211, abs=5e-7)

    def test_paper_counting(self):
        """Eq. (6) read literally drops a term: 9.161625e-2 in place of NIST's 9.159953e-2."""
        got = adev(known.nbs14(), [10], counting="paper")[10]
        assert got == pytest.approx(9.161625e-2, abs=5e-8)
        assert allan(record(known.nbs14()), taus=[10], counting="paper")["y"].n_pairs[0] == 980
        assert allan(record(known.nbs14()), taus=[10])["y"].n_pairs[0] == 981

    @pytest.mark.parametrize(("name", "overlap"), [("oadev", "full")])
    def test_phase_dat(self, field_data, name, overlap):
        """PHASE.DAT: 1001 phases, no IMU; Stable32's five digits."""
        phase = np.loadtxt(field_data / "phasedat" / "PHASE.DAT")
        table = np.loadtxt(field_data / "phasedat" / f"phase_dat_{name}_octave.txt", skiprows=10)
        curve = allan(
            Record.from_arrays(rate=1, phase=phase, unit={"phase": "s"}, input="accumulated"),
            taus=table[:, 1],
            overlap=overlap,
        )["phase"]
        assert curve.n_pairs.tolist() == table[:, 2].astype(int).tolist()
        assert curve.adev == pytest.approx(table[:, 5], rel=1e-4)
        assert curve.unit == "1"


class TestAgainstClusterMeans:
    @pytest.mark.parametrize("n", [4, 5, 63, 64, 1000, 3000])
    @pytest.mark.parametrize("overlap", ["full", "none"])
    def test_every_size(self, n, overlap):
        rng = np.random.default_rng(n)
        y = 3.0 + np.cumsum(rng.standard_normal(n))
        sizes = sorted({*range(1, min(n // 2, 9) + 1), n // 7 or 1, n // 3, n // 2})
        curve = allan(record(y), taus=sizes, overlap=overlap)["y"]
        for m, avar, pairs in zip(curve.m, curve.avar, curve.n_pairs, strict=True):
            expected, count = clusters(y, m, step=1 if overlap == "full" else m)
            assert pairs == count
            # cluster means of size m lose about √m·ε·|y| to rounding in the twin
            assert avar == pytest.approx(expected, rel=1e-10)


class TestIdentities:
    @pytest.mark.parametrize("rate", [1.0, 100.0, 1 / 3])
    def test_ramp(self, rate):
        """σ² = R²T²/2 for every cluster size."""
        n, slope = 30_000, -2.5e-3
        y = 7.0 + slope * np.arange(n) / rate
        curve = allan(record(y, rate))["y"]
        assert curve.avar == pytest.approx(slope**2 * curve.tau**2 / 2, rel=1e-9)
        # 1e-9 because y itself is rounded at 7 ± 1e-15 and the ramp moves by 1e-5 … 1e-3 a sample
        exact = allan(record(slope * np.arange(n)))["y"]
        assert exact.avar == pytest.approx(slope**2 * exact.tau**2 / 2, rel=1e-12)

    @pytest.mark.parametrize("kind", ["increments", "accumulated"])
    def test_input_kinds(self, kind):
        rng = np.random.default_rng(7)
        y = rng.standard_normal(5000)
        theta = np.concatenate(([0.0], np.cumsum(y) / 100.0))
        values = np.diff(theta) if kind == "increments" else theta
        curve = allan(Record.from_arrays(rate=100, gyro_x=values, input=kind))["gyro_x"]
        expected = allan(Record.from_arrays(rate=100, gyro_x=y))["gyro_x"]
        assert curve.n == 5000
        assert curve.avar == pytest.approx(expected.avar, rel=1e-11)

    def test_units_only_scale(self):
        y = np.random.default_rng(2).standard_normal(1000)
        in_degrees = allan(Record.from_arrays(rate=50, gyro_x=y, unit={"gyro": "deg/s"}))["gyro_x"]
        in_radians = allan(Record.from_arrays(rate=50, gyro_x=np.deg2rad(y)))["gyro_x"]
        assert in_degrees.avar == pytest.approx(in_radians.avar, rel=1e-13)
        assert in_degrees.unit == "rad/s"


finite = st.floats(-1e6, 1e6, allow_nan=False, width=32)


class TestLaws:
    @settings(max_examples=60, deadline=None)
    @given(st.lists(finite, min_size=4, max_size=200), st.floats(-1e3, 1e3), st.sampled_from(["full", "none"]))
    def test_a_constant_rate_does_not_show(self, y, offset, overlap):
        y = np.array(y)
        a = allan(record(y), overlap=overlap)["y"].avar
        b = allan(record(y + offset), overlap=overlap)["y"].avar
        scale = np.abs(y).max() + abs(offset)
        assert b == pytest.approx(a, rel=1e-9, abs=(1e-13 * scale) ** 2 + 1e-13 * scale * math.sqrt(a.max()))


class TestGrids:
    @pytest.mark.parametrize("n", [2, 3, 4, 5, 17, 1000, 1_000_000])
    def test_octaves_are_the_papers(self, n):
        sizes = cluster_sizes("octave", n=n, tau0=0.01)
        assert sizes.tolist() == [2**j for j in range(25) if 2**j <= n // 2]

    @pytest.mark.parametrize(("grid", "per_octave"), [("half", 2), ("quarter", 4)])
    def test_finer_grids(self, grid, per_octave):
        sizes = cluster_sizes(grid, n=1 << 20, tau0=1.0)
        assert sizes[0] == 1
        assert sizes[-1] <= 1 << 19
        assert ((sizes >= 1024) & (sizes < 2048)).sum() == per_octave
        assert (np.diff(sizes) > 0).all()
        assert set(cluster_sizes("octave", n=1 << 20, tau0=1.0)) <= set(sizes)

    def test_lists_are_rounded_to_samples_and_say_so(self):
        curve = allan(record(np.arange(100.0) ** 2, rate=100), taus=[0.014, 0.016, 0.5])["y"]
        assert curve.m.tolist() == [1, 2, 50]
        assert curve.tau == pytest.approx([0.01, 0.02, 0.5])

    @pytest.mark.parametrize("taus", [[0], [-1], [math.nan], [0.4], [51], [], "thirds"])
    def test_impossible_times(self, taus):
        with pytest.raises(OptionError):
            allan(record(np.zeros(100)), taus=taus)


class TestEveryTime:
    def test_nbs14(self):
        curve = allan(record(known.nbs14()), taus="all")["y"]
        assert curve.m.tolist() == list(range(1, 501))
        got = dict(zip(curve.m.tolist(), curve.adev, strict=True))
        assert {m: got[m] for m in known.NBS14_OVERLAPPED} == pytest.approx(known.NBS14_OVERLAPPED, rel=1e-12)
        disjoint = allan(record(known.nbs14()), taus="all", overlap="none")["y"].adev
        assert disjoint[np.array(list(known.NBS14_DISJOINT)) - 1] == pytest.approx(
            list(known.NBS14_DISJOINT.values()), rel=1e-12
        )

    @pytest.mark.parametrize("counting", ["standard", "paper"])
    @pytest.mark.parametrize("n", [4, 5, 20_000, 65_537])
    def test_sizes_that_other_grids_have(self, n, counting):
        """From 20 000 samples on, transforms make the larger ones: to 1e-9 of what the sums are."""
        y = 1e3 + np.cumsum(np.random.default_rng(n).standard_normal(n))
        every = allan(record(y), taus="all", counting=counting)["y"]
        some = allan(record(y), taus="eighth", counting=counting)["y"]
        assert every.m.tolist() == list(range(1, (n - (counting == "paper")) // 2 + 1))
        assert every.avar[some.m - 1] == pytest.approx(some.avar, rel=1e-9)
        # the means of the differences come from other partial sums of a phase of about n: 1e-16 of that, over m²
        ramp = some.ramp / np.abs(some.ramp).max()
        assert every.ramp[some.m - 1] / np.abs(some.ramp).max() == pytest.approx(ramp, rel=1e-9, abs=1e-12)
        assert every.n_pairs[some.m - 1].tolist() == some.n_pairs.tolist()

    def test_is_printed_without_its_middle(self):
        lines = repr(allan(record(np.arange(3000.0) % 7), taus="all")["y"]).splitlines()
        assert len(lines) == 2 + 200 + 1
        assert lines[102].split() == ["…", "1300", "more"]
        assert (lines[101].split()[0], lines[103].split()[0], lines[-1].split()[0]) == ("100", "1401", "1500")
        whole = repr(allan(record(np.arange(300.0) % 7), taus="all")["y"])
        assert len(whole.splitlines()) == 2 + 150


@pytest.mark.parametrize("n", [4, 64, 96, 1000])
@pytest.mark.parametrize("grid", ["octave", "half", "quarter", "all"])
def test_paper_counting_on_every_grid(n, grid):
    """One term fewer: at m = n/2 none is left, and the grid ends before it."""
    y = np.random.default_rng(n).standard_normal(n)
    curve = allan(record(y), taus=grid, counting="paper")["y"]
    assert (curve.n_pairs == n - 2 * curve.m).all()
    assert curve.n_pairs.min() >= 1


class TestBadData:
    def test_missing_sample(self):
        y = np.zeros(100)
        y[17] = math.nan
        bad = Record.from_arrays(rate=100, gyro_x=y)
        assert allan(bad)["gyro_x"].missing == 1
        with pytest.raises(NonFiniteError, match=r"`gyro_x` has missing samples \(1 rows, the first at index 17") as e:
            accumulate(bad.streams[0], taus="octave")
        assert (e.value.channel, e.value.index) == ("gyro_x", 17)
        assert bad.longest_run().streams[0].grid.n == 82
        assert bad.longest_run().streams[0].grid.start == pytest.approx(0.18)
        allan(bad.longest_run())

    @pytest.mark.parametrize(("sample", "what"), [(math.inf, "infinite"), (1e160, "1e+160, too large to be squared,")])
    def test_infinite_sample(self, sample, what):
        with pytest.raises(NonFiniteError, match=re.escape(f"`gyro_x` is {what} at index 2")):
            Record.from_arrays(rate=1, gyro_x=[0, 1, sample, 3, 4])

    def test_too_short(self):
        with pytest.raises(RecordTooShortError) as e:
            record([1.0, 2.0, 3.0])
        assert (e.value.need, e.value.got) == (4, 3)

    @pytest.mark.parametrize("rate", [0, -1, math.nan, math.inf])
    def test_rate(self, rate):
        with pytest.raises(OptionError, match="positive"):
            record(np.zeros(10), rate)

    @pytest.mark.parametrize(
        ("change", "words"),
        [
            ({"input": "rates"}, "`input` must be one of"),
            ({"unit": {"gyros": "deg/s"}}, "not a channel; channels: gyro, gyro_x"),
            ({"gyro": np.zeros((10, 3))}, "given twice"),
            ({"y": np.zeros(10, dtype=complex)}, "complex128"),
            ({"y": np.zeros(10, dtype="datetime64[s]")}, "datetime64"),
            ({"y": ["a", "b", "c", "d"]}, "want real numbers"),
            ({"rate": "10"}, "positive number"),
        ],
    )
    def test_arrays_that_are_not_what_they_should_be(self, change, words):
        with pytest.raises((DataError, OptionError), match=words):
            Record.from_arrays(**({"rate": 1.0, "gyro_x": np.zeros(10)} | change))

    def test_masked_values_are_missing(self):
        y = np.ma.masked_array(np.arange(10.0), mask=[False] * 9 + [True])
        assert Record.from_arrays(rate=1, y=y).streams[0].mask.sum() == 1

    def test_no_record(self):
        with pytest.raises(OptionError, match=r"an array needs `rate`, .*allan\(x, rate=100\)"):
            allan(np.zeros(100))
        with pytest.raises(
            TypeError, match=r"must be a Record or an array of shape \(n,\), not \(100, 3\).*gyro=array"
        ):
            allan(np.zeros((100, 3)), rate=1)
        with pytest.raises(TypeError, match=r"see sigmatau\.read for files"):
            allan("log.csv")
        with pytest.raises(OptionError, match="`rate` is for an array"):
            allan(Record.from_arrays(rate=1, x=np.zeros(100)), rate=1)

    def test_an_array(self):
        x = np.random.default_rng(7).standard_normal(1000)
        curve = allan(x, rate=10, unit="deg/s")
        assert (curve.unit, curve.n, curve.tau0) == ("deg/s", 1000, 0.1)
        np.testing.assert_array_equal(curve.avar, allan(Record.from_arrays(rate=10, signal=x))["signal"].avar)

    def test_shapes(self):
        with pytest.raises(DataError, match="unequal"):
            Record.from_arrays(rate=1, gyro_x=np.zeros(10), gyro_y=np.zeros(11))
        with pytest.raises(DataError, match=r"shape \(10, 2\)"):
            Record.from_arrays(rate=1, gyro=np.zeros((10, 2)))
        with pytest.raises(DataError, match="no channel"):
            Record.from_arrays(rate=1)

    @pytest.mark.parametrize("option", [{"overlap": "half"}, {"counting": "nist"}, {"threads": 0}, {"threads": 10**30}])
    def test_options(self, option):
        with pytest.raises(OptionError, match=next(iter(option))):
            allan(record(np.zeros(10)), **option)

    def test_unknown_channel(self):
        with pytest.raises(KeyError, match="channels: y"):
            allan(record(np.arange(10.0)))["x"]


def test_chunks_are_the_columns_and_can_be_had_again():
    y = np.random.default_rng(3).standard_normal((1000, 3))
    stream = Record.from_arrays(rate=10, accel=y, unit={"accel": "g"}).streams[0]
    for size in (1, 7, 1000, 5000):
        assert np.array_equal(np.concatenate(list(stream.chunks(size))), y * 9.80665)
    theta = Record.from_arrays(rate=10, gyro=y, input="accumulated").streams[0]
    pieces = np.concatenate(list(theta.chunks(64)))
    assert np.array_equal(pieces, np.stack([theta.column(c) for c in theta.channels], axis=1))
    assert pieces.shape == (999, 3)


def test_results_compare_by_identity():
    a, b = (allan(record(np.arange(10.0)))["y"] for _ in range(2))
    assert a == a
    assert a != b
    assert len({a, b}) == 2


def test_results_are_frozen():
    curve = allan(record(np.arange(10.0)))["y"]
    with pytest.raises(ValueError, match="read-only"):
        curve.avar[0] = 0
    with pytest.raises(AttributeError):
        curve.n = 3
    assert repr(curve).splitlines()[0] == "y: Allan deviation, 10 samples at 1 Hz [1]"


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork on this system")
def test_a_forked_process_has_threads_of_its_own():
    """Its copy of the pool has none, and would wait for them for ever."""
    y = np.random.default_rng(0).standard_normal(300_000)
    expected = allan(record(y))["y"].avar.tolist()
    child = os.fork()
    if child == 0:
        signal.alarm(20)
        os._exit(0 if allan(record(y))["y"].avar.tolist() == expected else 1)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0


@pytest.mark.parametrize("n", [1, 4095, 4096, 4097, 10_000])
def test_columns_of_any_layout_are_the_same(n):
    table = np.random.default_rng(n).standard_normal((n + 5, 3))
    plain = [np.array(table[5:, k]) for k in range(3)]
    layouts = [
        [table[5:, k] for k in range(3)],
        [np.asfortranarray(table)[5:, k] for k in range(3)],
        [column[::-1].copy()[::-1] for column in plain],
        [column.astype(">f8") for column in plain],
        [plain[0], table[5:, 1], plain[2].tolist()],
    ]
    for columns in layouts:
        got = arguments.contiguous(columns, "abc")
        assert [column.tolist() for column in got] == [column.tolist() for column in plain]
        assert all(column.flags.c_contiguous and column.dtype == np.float64 and column.dtype.isnative for column in got)


@pytest.mark.parametrize("size", [1e100, 1e-100])
def test_numbers_that_no_fit_can_square(size):
    y = np.random.default_rng(3).standard_normal(2000)
    analysis = analyze(Record.from_arrays(rate=100, a=size * y, b=y))
    (finding,) = [f for f in analysis.findings if f.severity == "error"]
    assert (finding.code, finding.channel) == ("out_of_range", "a")
    assert list(analysis.curves) == ["b"]
    assert allan(Record.from_arrays(rate=100, a=size * y))["a"].adev[0] == pytest.approx(size, rel=0.1)


def test_the_interval_for_a_noise_is_that_of_the_analysis():
    white = record(np.random.default_rng(known.seed_of("interval for a noise")).standard_normal(4096))
    analysis = analyze(white)
    curve = allan(white)["y"]
    fitted = analysis["y"].model
    expected = analysis.curves["y"].interval(level=0.99)
    # The analysis interpolates the degrees of freedom of some sizes.
    np.testing.assert_allclose(curve.interval(noise=fitted, level=0.99), expected, rtol=0.01)
    low, high = curve.interval(noise="random_walk")
    assert np.all(low > curve.interval(noise="random_walk", level=0.99)[0])
    assert np.all(high > curve.adev)


def test_missing_samples_widen_the_interval_for_a_noise():
    y = np.random.default_rng(known.seed_of("interval with missing samples")).standard_normal(4096)
    whole = allan(record(y), taus=[64])["y"]
    y[1000:2000] = np.nan
    cut = allan(record(y), taus=[64])["y"]
    low, high = np.transpose([[edge[0] for edge in curve.interval(noise="random_walk")] for curve in (whole, cut)])
    widths = np.log(high / low)
    # Three quarters of the pairs are left: wider by the root of 4/3, 1.15.
    assert 1.1 < widths[1] / widths[0] < 1.2


@pytest.mark.parametrize(
    ("overlap", "options", "message"),
    [
        ("full", {"level": 0.99}, r"`level` needs the noise, interval\(noise='random_walk'\)"),
        ("full", {"noise": "white"}, "`noise`: unknown term 'white'"),
        ("full", {"noise": NoiseModel(channels={"gyro_x": {"random_walk": 1.0}})}, r"one channel: model\['gyro_x'\]"),
        ("none", {"noise": "random_walk"}, "`noise` needs a curve of overlapping clusters"),
    ],
)
def test_intervals_that_cannot_be_had(overlap, options, message):
    curve = allan(record(np.arange(64.0) % 3), overlap=overlap)["y"]
    with pytest.raises(OptionError, match=message):
        curve.interval(**options)
