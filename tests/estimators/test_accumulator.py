"""Records in pieces against records as a whole; what a stream refuses; records that do not fit."""

import copy
import itertools

import numpy as np
import pytest

from sigmatau import Accumulator, NoiseModel, Record, allan, analyze, simulate
from sigmatau.errors import DataError, NonFiniteError, OptionError, RecordTooShortError
from sigmatau.estimators.accumulator import strided_sizes
from sigmatau.estimators.deviation_kinds import cluster_sizes
from sigmatau.record import memory as memory_module


def rates(n, seed=0):
    rng = np.random.default_rng(seed)
    return 1e3 + rng.standard_normal((n, 2)) + np.cumsum(1e-3 * rng.standard_normal((n, 2)), axis=0)


def pushed(chunks, **options):
    stream = Accumulator("gyro_x", "accel_y", rate=100, **options)
    for chunk in chunks:
        stream.push(chunk)
    return stream


class TestAgainstTheWholeRecord:
    @pytest.mark.parametrize("long", ["exact", "strided"])
    @pytest.mark.parametrize("size", [1, 999, 70_000])
    def test_short_clusters_are_exact(self, long, size):
        y = rates(8000 if size == 1 else 100_000)
        curves = pushed([y[k : k + size] for k in range(0, len(y), size)], long=long, taus="octave").snapshot()
        whole = allan(Record.from_arrays(rate=100, gyro_x=y[:, 0], accel_y=y[:, 1]), taus="octave")
        for channel, curve in curves.items():
            short = curve.m <= (4096 if long == "strided" else curve.m.max())
            expected = whole[channel]
            assert curve.m.tolist() == expected.m.tolist()
            assert curve.avar[short] == pytest.approx(expected.avar[short], rel=1e-12)
            assert curve.n_pairs[short].tolist() == expected.n_pairs[short].tolist()
            # A ramp is what is left of a rate of 1e3, rounded to 1e-13, of which thousands are summed.
            assert curve.ramp[short] == pytest.approx(expected.ramp[short], rel=1e-6, abs=1e-10)
            assert (curve.quantity, curve.unit) == (expected.quantity, expected.unit)
            assert (curve.stride is None) == (long == "exact" or curve.m.max() <= 4096)

    def test_strides_are_stated(self):
        curve = pushed([rates(100_000)], long="strided", taus="octave").snapshot()["gyro_x"]
        assert curve.stride[curve.m <= 4096].tolist() == [1] * 13
        assert curve.stride[curve.m > 4096].tolist() == [64, 64, 64]
        assert curve.to_dict()["stride"] == curve.stride.tolist()
        m = curve.m[-1]
        assert curve.n_pairs[-1] == (100_000 - 2 * m) // 64 + 1

    def test_units_increments_and_mappings(self):
        y = rates(5000)
        expected = pushed([y]).snapshot()["gyro_x"].adev
        stream = Accumulator("gyro_x", rate=100, unit={"gyro": "deg"}, input="increments")
        stream.push({"gyro_x": np.degrees(y[:, 0]) / 100})
        assert stream.snapshot()["gyro_x"].adev == pytest.approx(expected, rel=1e-9)
        signal = Accumulator("phase", rate=1, unit={"phase": "V"})
        signal.push(y[:, 0])
        assert signal.snapshot()["phase"].unit == "V"

    def test_merging_in_any_order(self):
        y = rates(300_000)
        cuts = [0, 10, 90_001, 180_000, 300_000]
        parts = [pushed([y[a:b]], start=a, long="strided") for a, b in itertools.pairwise(cuts)]
        parts[2].merge(parts[3])
        parts[0].merge(parts[1])
        parts[0].merge(parts[2])
        whole = pushed([y], long="strided").snapshot()
        for channel, curve in parts[0].snapshot().items():
            assert curve.avar == pytest.approx(whole[channel].avar, rel=1e-12)
            assert curve.n_pairs.tolist() == whole[channel].n_pairs.tolist()
        assert parts[0].n == 300_000

    @pytest.mark.parametrize("make", [Accumulator.copy, copy.copy, copy.deepcopy])
    def test_a_copy_goes_its_own_way(self, make):
        y = rates(2000)
        stream = pushed([y[:1000]])
        twin = make(stream)
        stream.push(y[1000:])
        assert (twin.n, stream.n) == (1000, 2000)
        twin.push(y[1000:])
        assert twin.snapshot()["gyro_x"].avar.tolist() == stream.snapshot()["gyro_x"].avar.tolist()


class TestRefusals:
    def test_arguments(self):
        for options, name in [
            ({"rate": 0}, "rate"),
            ({"rate": "100"}, "rate"),
            ({"rate": 1, "long": "short"}, "long"),
            ({"rate": 1, "start": -1}, "start"),
            ({"rate": 1, "start": True}, "start"),
            ({"rate": 1, "input": "accumulated"}, "input"),
            ({"rate": 1, "taus": "all"}, "taus"),
            ({"rate": 1, "taus": [0.1]}, "taus"),
            ({"rate": 1, "unit": {"gyro": "g"}}, "unit"),
            ({"rate": 1, "unit": {"gyro_z": "deg/s"}}, "unit"),
        ]:
            with pytest.raises(OptionError) as caught:
                Accumulator("gyro_x", **options)
            assert caught.value.option in (name, None), options
        for channels in [(), ("a", "a"), (1,)]:
            with pytest.raises(OptionError, match="different names"):
                Accumulator(*channels, rate=1)

    @pytest.mark.parametrize("bad", [np.nan, np.inf, -1e131])
    def test_a_bad_sample_names_itself_and_changes_nothing(self, bad):
        y = rates(3000)
        stream = pushed([y[:2000]], start=500)
        before = stream.snapshot()["accel_y"].avar.tolist()
        chunk = y[2000:].copy()
        chunk[7, 1] = bad
        with pytest.raises(
            NonFiniteError, match=r"`accel_y` is .* at index 2507 of the record, 7 of the chunk"
        ) as caught:
            stream.push(chunk)
        assert (caught.value.channel, caught.value.index) == ("accel_y", 2507)
        assert stream.n == 2000
        assert stream.snapshot()["accel_y"].avar.tolist() == before

    def test_shapes(self):
        stream = pushed([])
        for chunk in [np.zeros(4), np.zeros((4, 3)), np.zeros((2, 2, 2)), {"gyro_x": [1.0]}]:
            with pytest.raises(ValueError, match="`chunk` has"):
                stream.push(chunk)
        with pytest.raises(ValueError, match="one length"):
            stream.push({"gyro_x": [1.0, 2.0], "accel_y": [1.0]})
        stream.push(np.empty((0, 2)))
        assert stream.n == 0
        with pytest.raises(RecordTooShortError):
            stream.snapshot()

    def test_merging_what_does_not_follow(self):
        y = rates(1000)
        stream = pushed([y])
        other = Accumulator("gyro_x", rate=100, start=1000)
        for later, words in [
            (pushed([y], start=999), "begins at sample 999"),
            (pushed([y], start=1000, long="strided"), "differ in channels"),
            (pushed([y], start=1000, taus="octave"), "different averaging times"),
            (other, "differ in channels"),
        ]:
            with pytest.raises(ValueError, match=words):
                stream.merge(later)
        with pytest.raises(TypeError):
            stream.merge(y)
        assert stream.n == 1000


class TestRecordsThatDoNotFit:
    model = NoiseModel(channels={"gyro_x": {"random_walk": 1e-3, "rate_random_walk": 5e-5}})

    def test_analyze_says_what_it_did(self, monkeypatch):
        record = simulate(self.model, duration=2000, rate=100, rng=1)
        exact = analyze(record)
        asked = analyze(record, long="strided")
        monkeypatch.setattr(memory_module, "available", lambda: 1000)
        forced = analyze(record)
        assert not any(f.code == "strided" for f in exact.findings)
        for analysis, out_of_memory in [(asked, False), (forced, True)]:
            (finding,) = [f for f in analysis.findings if f.code == "strided"]
            assert (finding.details.tau, finding.details.samples) == (pytest.approx(61.44), 200_000)
            assert finding.details.out_of_memory == out_of_memory
            fit, expected = analysis.fits["gyro_x"], exact.fits["gyro_x"]
            assert fit["random_walk"].value == pytest.approx(expected["random_walk"].value, rel=1e-3)
            assert fit["rate_random_walk"].value == pytest.approx(expected["rate_random_walk"].value, rel=0.05)
        assert analyze(record, long="exact").curves["gyro_x"].stride is None
        with pytest.raises(DataError, match="not enough memory"):
            analyze(record, overlap="none")

    def test_refused_combinations(self):
        record = simulate(self.model, duration=100, rate=100, rng=1)
        for options in [{"long": "none"}, {"long": "strided", "overlap": "none"}, {"long": "strided", "taus": "all"}]:
            with pytest.raises(OptionError):
                analyze(record, **options)

    def test_memory_is_known(self):
        available = memory_module.available()
        assert available is None or available > 1 << 20
        stream = simulate(self.model, duration=100, rate=100, rng=1).streams[0]
        assert memory_module.needed(stream, 4) == 8 * 10_000 * 2
        assert memory_module.fits(stream, None)


def test_sizes_are_multiples_of_their_strides():
    for grid in ("octave", "half", "quarter", "eighth"):
        sizes = cluster_sizes(grid, n=1 << 30, tau0=1.0)
        assert strided_sizes(sizes).tolist() == sizes.tolist()
    assert strided_sizes(np.array([5, 4096, 4097, 5000, 262_143, 262_145])).tolist() == [5, 4096, 4992, 262_144]


def loss(term, m, stride, n):
    """By how much strides make the variance of an Allan variance larger, exactly, relative to every start.

    The second differences are a stationary Gaussian sequence, so that the variance of the mean of their squares is the sum
    of 2 C(l)² over all pairs of terms; C from the generalised autocovariance of the phase of each noise.
    """
    lag = np.arange(n + 1 - 2 * m, dtype=float)
    with np.errstate(divide="ignore", invalid="ignore"):
        phase = {
            "quantization": lambda k: (k == 0).astype(float),
            "random_walk": lambda k: -np.abs(k),
            "bias_instability": lambda k: np.where(k == 0, 0.0, k**2 * np.log(np.abs(np.where(k == 0, 1, k)))),
            "rate_random_walk": lambda k: np.abs(k) ** 3,
        }[term]
        weights = {-2: 1, -1: -4, 0: 6, 1: -4, 2: 1}
        covariance = sum(w * phase(lag + i * m) for i, w in weights.items())

    def variance(step):
        lags = np.arange(0, len(lag), step)
        pairs = len(lags) - np.arange(len(lags))
        counted = np.where(lags == 0, 1, 2) * pairs * covariance[lags] ** 2
        return counted.sum() / len(lags) ** 2

    return variance(stride) / variance(1) - 1


@pytest.mark.parametrize("m", [4160, 8192, 65_536])
def test_strides_lose_less_than_a_thousandth(m):
    """docs/theory/streams.md: less than 0.1 % of the variance for white noise and slower; 64 starts a cluster and more."""
    for term in ("random_walk", "bias_instability", "rate_random_walk"):
        assert -1e-3 < loss(term, m, 64, 1_000_000) < 1e-3, term
    # Of quantization noise all but every 64th term is lost.
    assert loss("quantization", m, 64, 1_000_000) == pytest.approx(63, rel=0.01)


def test_what_is_no_sample():
    stream = Accumulator("a", rate=1)
    with pytest.raises(NonFiniteError, match="index 4"):
        stream.push(np.ma.array([0, 0, 0, 0, 1e6, 0.0], mask=[0, 0, 0, 0, 1, 0]))
    for chunk in (np.array([1 + 2j]), np.array(["2020-01-01"], dtype="datetime64[s]"), np.array(["1", "2"])):
        with pytest.raises(DataError, match="want real numbers"):
            stream.push(chunk)
    assert stream.n == 0


def test_merged_with_itself():
    stream = Accumulator("a", rate=1)
    stream.merge(stream)
    assert stream.n == 0
    stream.push(np.arange(10.0))
    with pytest.raises(ValueError, match="begins at sample 0"):
        stream.merge(stream)


def test_options_of_the_wrong_form():
    with pytest.raises(TypeError, match="`unit` must be a mapping"):
        Accumulator("a", rate=1, unit="deg/s")
    with pytest.raises(OptionError, match="`start`"):
        Accumulator("a", rate=1, start=2**64)
