"""Windows: times and units, the calmest part by independent criteria, and the bias of choosing by one's own noise."""

import math
from dataclasses import replace

import numpy as np
import pytest
from studies.selection_bias import selection_bias

from known import seed_of
from sigmatau import NoiseModel, OptionError, Record, allan, simulate
from sigmatau.quality.selection.window import choose, criterion, cut, most_stable, scatter
from sigmatau.record.record import make_stream


def plain(n=3600, rate=1.0, **more):
    return Record.from_arrays(rate=rate, gyro_x=np.arange(float(n)), **more)


class TestCut:
    @pytest.mark.parametrize(
        ("text", "first", "last"),
        [
            ("600s:1800s", 600, 1799),
            (" 10 min : 0.5h ", 600, 1799),
            ("50min:", 3000, 3599),
            (":2e3s", 0, 1999),
            (":1h", 0, 3599),
            (":", 0, 3599),
        ],
    )
    def test_times(self, text, first, last):
        (stream,) = cut(plain(), text).streams
        x = stream.column("gyro_x")
        assert (x[0], x[-1], stream.grid.n) == (first, last, last - first + 1)
        assert stream.grid.start == first

    def test_streams_with_clocks_of_their_own(self):
        """Times are from the beginning of the first stream; each is cut on its own grid."""
        gyro = make_stream("gyro", {"gyro_x": np.arange(100.0)}, rate=1.0, unit={}, start=1000.0)
        accel = make_stream("accel", {"accel_x": np.arange(1000.0)}, rate=10.0, unit={}, start=1010.0)
        both = cut(Record(streams=(gyro, accel)), "20s:40s")
        assert both.streams[0].column("gyro_x").tolist() == list(range(20, 40))
        assert both.streams[1].column("accel_x").tolist() == list(range(100, 300))
        assert "window from 20 s to 40 s" in both.provenance.conversions

    @pytest.mark.parametrize(
        ("text", "words"),
        [
            ("600", "is not understood"),
            ("600:1800", "not a time with a unit"),
            ("1s:2s:3s", "is not understood"),
            ("10min:5min", "before it begins"),
            ("-5s:10s", "not a time with a unit"),
            ("0s:2h", "the record is 3600 s long"),
            ("2h:", "before it begins"),
            ("10s:12s", "leaves 2 samples"),
            ("calmest=1h", "is not understood"),
            ("most-stable=1", "not a time with a unit"),
            ("most-stable=2h", "3600 s long"),
            ("most-stable=0s", "longer than 0 s"),
        ],
    )
    def test_refused(self, text, words):
        with pytest.raises(OptionError, match=words) as caught:
            choose(plain(), text)
        assert caught.value.option == "window"

    def test_choose_times(self):
        record, found = choose(plain(), "10min:20min")
        assert record.streams[0].grid.n == 600
        assert found == []


def calm_between(name, first, last, n=14_400):
    """White noise, ten times less between two samples."""
    x = np.random.default_rng(seed_of(name)).standard_normal(n)
    x[first:last] *= 0.1
    return x


class TestMostStable:
    def test_by_its_own_scatter(self):
        record = Record.from_arrays(rate=1.0, gyro_x=calm_between("own", 4800, 8400))
        chosen, (finding,) = choose(record, "most-stable=1h")
        assert criterion(record, record.streams[0]).kind == "own"
        assert chosen.streams[0].grid.start == 4800
        assert chosen.streams[0].grid.n == 3600
        # Another clock is another start, and the same time in the record.
        later = replace(record.streams[0], grid=replace(record.streams[0].grid, start=1e4))
        again, (said,) = most_stable(replace(record, streams=(later,)), 3600.0)
        assert again.streams[0].grid.start == 14_800
        assert said == finding
        assert finding.code == "window_chosen"
        (window,) = finding.details.windows
        assert (window.start, window.criterion, window.by, window.block) == (4800.0, "own", "gyro", 60.0)
        assert window.relative < 0.5
        assert finding.spans == ((4800.0, 8400.0),)

    def test_by_the_other_sensor(self):
        """The gyro's window is where the accelerometer is calm, and the other way round."""
        record = Record.from_arrays(
            rate=1.0, gyro_x=calm_between("gyro", 1200, 4800), accel_x=calm_between("accel", 9000, 12_600)
        )
        chosen, (finding,) = most_stable(record, 3600.0)
        # To two blocks: one with ten times the noise may have a mean like the others by chance.
        assert [stream.grid.start for stream in chosen.streams] == pytest.approx([9000, 1200], abs=120)
        windows = [(one.stream, one.criterion, one.by) for one in finding.details.windows]
        assert windows == [("gyro", "other", "accel"), ("accel", "other", "gyro")]

    def test_by_temperature(self):
        gyro = Record.from_arrays(rate=1.0, gyro_x=calm_between("hot", 1200, 4800)).streams[0]
        celsius = 20 + 5 * np.sin(np.linspace(0, np.pi, 1440))  # changes least about its top
        warm = make_stream("temperature", {"temperature": celsius}, rate=0.1, unit={}, start=0.0)
        record = Record(streams=(gyro, replace(warm, quantity="temperature", unit="K")))
        chosen, (finding,) = most_stable(record, 3600.0)
        assert criterion(record, gyro).kind == "temperature"
        # The top is at 7200 s; blocks of a minute.
        assert chosen.streams[0].grid.start == pytest.approx(5400, abs=60)
        assert chosen.streams[1].grid.start == chosen.streams[0].grid.start
        (window,) = finding.details.windows
        assert (window.criterion, window.by) == ("temperature", "temperature")

    def test_gaps_and_several_axes(self):
        x, y = calm_between("gap x", 4800, 8400), calm_between("gap y", 4800, 8400)
        x[::10] = np.nan
        y[6000:6060] = np.nan
        chosen, _ = most_stable(Record.from_arrays(rate=1.0, gyro_x=x, gyro_y=y), 3600.0)
        assert chosen.streams[0].grid.start == 4800
        # An outage as long as half the window is not calm but empty.
        x[4800:6600] = np.nan
        chosen, _ = most_stable(Record.from_arrays(rate=1.0, gyro_x=x), 3600.0)
        assert chosen.streams[0].grid.start >= 6240  # at most a tenth of its blocks

    def test_whole_record_and_constant_channels(self):
        record = plain()
        assert choose(record, "most-stable=1h")[0].streams[0].grid.n == 3600
        still = Record.from_arrays(rate=1.0, gyro_x=np.ones(7200))
        assert choose(still, "most-stable=1h")[0].streams[0].grid.start == 0

    def test_scatter_is_the_standard_deviation(self):
        means = np.random.default_rng(seed_of("scatter")).standard_normal((2, 30)) + 1e3
        expected = [np.log(means[:, k : k + 8].std(axis=1, ddof=1)).sum() for k in range(23)]
        assert scatter(means, 8) == pytest.approx(expected, rel=1e-6)


TRUTH = {  # THEORY, section 5: best 2 h of 4 h by the least standard deviation of 60 s means; two digits printed
    "N, B, K": (0.89, 0.80, 0.65, 0.51),
    "K": (0.85, 0.73, 0.55, 0.41),
}
MODELS = {  # the MEMS gyro of section 4.2, deg/s
    "N, B, K": {"random_walk": 0.005, "bias_instability": 0.0028, "rate_random_walk": 1e-4},
    "K": {"rate_random_walk": 1e-4},
}
TAUS = (300.0, 600.0, 1200.0, 1800.0)
THEIR_DRAWS = 100  # not stated there; of their Monte Carlo of other kinds the least is 40, most 150 to 250


class TestSelectionBias:
    @pytest.mark.parametrize("name", MODELS)
    def test_known(self, name):
        """Within three standard errors: ours, those of a hundred draws of theirs, and half a digit of print."""
        bias = selection_bias(
            {"x": MODELS[name]}, n=1_440_000, window=720_000, tau0=0.01, rng=seed_of(name), draws=2000
        )
        found = bias["x"]
        for tau, expected in zip(TAUS, TRUTH[name], strict=True):
            ours = float(np.interp(tau, found.tau, found.error))
            theirs = ours * math.sqrt(found.draws / THEIR_DRAWS)
            assert found.at(tau) == pytest.approx(expected, abs=3 * math.hypot(ours, theirs) + 0.005), tau

    def test_against_samples(self):
        """The whole way with samples and `most_stable` itself, against the simulation of block means alone."""
        rng = np.random.default_rng(seed_of("against samples"))
        model = NoiseModel(channels={"gyro_x": MODELS["N, B, K"]})
        sizes, records, rows = np.array([120, 600, 1200]), 150, []
        for _ in range(records):
            chosen, _ = most_stable(simulate(model, duration=9600, rate=0.5, rng=rng), 4800.0)
            rows.append(allan(chosen, taus=sizes, threads=1)["gyro_x"].avar)
        expected = model.avar("gyro_x", m=sizes // 2, tau0=2.0)
        rows = np.array(rows) / expected
        bias = selection_bias(model.channels, n=4800, window=2400, tau0=2.0, rng=seed_of("blocks"))["gyro_x"]
        error = np.hypot(rows.std(axis=0) / math.sqrt(records), np.interp(sizes, bias.tau, bias.error))
        for k, tau in enumerate(sizes):
            assert rows[:, k].mean() == pytest.approx(bias.at(float(tau)), abs=3 * error[k])
        assert bias.at(1200.0) < 0.75  # there is something to see
