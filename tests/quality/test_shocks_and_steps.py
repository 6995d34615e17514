"""Shocks, motion and tilt; and noise of every slope, which is none of these."""

import math

import numpy as np
import pytest

from known import seed_of
from sigmatau import NoiseModel, Record, allan, simulate
from sigmatau.quality.facts import keep_facts
from sigmatau.quality.motion.shocks_and_steps import not_static, shocks
from sigmatau.quality.motion.windows import bursts, mean_steps, summarise_windows
from sigmatau.quality.samples.masking import masked

RATE, N = 50.0, 150_000


def white(name, shape=(N, 3)):
    return np.random.default_rng(seed_of(name)).normal(size=shape)


def accel(x, rate=RATE):
    return Record.from_arrays(rate=rate, accel=x).streams[0]


def at_rest(stream):
    """Whether nothing is told of a stream."""
    with keep_facts():
        return not_static(stream) == shocks(stream) == []


def test_a_knock_is_placed_and_named_on_its_axes():
    x = white("knock")
    x[60_000:60_020, :2] += 15 * white("knock itself", (20, 2))
    ((finding, mask),) = shocks(accel(x))
    assert finding.code == "not_static"
    assert finding.severity == "warning"
    assert finding.channels == ("accel_x", "accel_y")
    (burst,) = finding.details.bursts
    assert burst.shock
    assert burst.channels == finding.channels
    assert finding.spans == ((1200.0, 1201.0),)
    assert np.array_equal(np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.all(axis=1)))
    assert np.flatnonzero(mask.all(axis=1))[[0, -1]].tolist() == [59_950, 60_099]  # with a window on either side
    assert 3 < finding.size < 30


def test_motion_of_a_minute():
    x = white("minute")
    x[60_000:63_000] *= 5
    ((finding, _),) = shocks(accel(x))
    assert finding.channels == ("accel_x", "accel_y", "accel_z")
    (burst,) = finding.details.bursts
    assert not burst.shock
    assert burst.stop - burst.start == 60
    assert finding.size == pytest.approx(5, rel=0.4)  # the largest of 180 windows of 49 changes


@pytest.mark.parametrize("at", [30_000, 75_000, 75_123, 120_011])
@pytest.mark.parametrize("size", [-0.5, 0.5])
def test_tilt_is_found_where_it_is(at, size):
    x = white(f"tilt {at}")
    x[at:, 2] += size
    (finding,) = not_static(accel(x))
    assert finding.channel == "accel_z"
    (step,) = finding.details.steps
    assert finding.spans == ((step.time, step.time),)
    # A step of half a standard deviation is placed to some 20 samples, and windows are of 50.
    assert step.time == pytest.approx(at / RATE, abs=4.0)
    assert step.size == math.copysign(finding.size, size)
    # Six windows of 4 s at least on either side, their medians: 1.25·√(2/6/200) = 0.05.
    assert finding.size == pytest.approx(0.5, abs=3 * 0.05)


def test_a_tilt_adds_its_square_over_the_length_to_the_rate_random_walk():
    """K² + Δ²/T: as the Allan variance says, on average over 20 records."""
    walk, white_noise, step, duration, rate = 2e-4, 1e-3, 0.03, 4000.0, 10.0
    model = NoiseModel(channels={"accel_x": {"random_walk": white_noise, "rate_random_walk": walk}})
    m = 2000  # 200 s
    measured = []
    for k in range(20):
        record = simulate(model, duration=duration, rate=rate, rng=seed_of(f"tilted {k}") % 2**60)
        x = np.array(record.streams[0].column("accel_x"))
        y = x.copy()
        y[19_000:] += step
        stream = Record.from_arrays(rate=rate, accel_x=y).streams[0]
        (finding,) = not_static(stream)
        curves = allan(Record.from_arrays(rate=rate, a=x, b=y), taus=[m / rate])
        measured.append(3 * float(curves["b"].avar[0] - curves["a"].avar[0]) * rate / m)
        assert finding.details.added_walk == pytest.approx(finding.size / math.sqrt(duration))
    error = np.std(measured, ddof=1) / math.sqrt(20)
    # Of T - 2τ starts of pairs: a little more than Δ²/T.
    assert abs(np.mean(measured) - step**2 / (duration - 2 * m / rate)) < 3 * error


@pytest.mark.parametrize("term", ["quantization", "random_walk", "bias_instability", "rate_random_walk", "rate_ramp"])
def test_each_term_alone_is_static(term):
    """A pure rate random walk and pure flicker noise above all, which wander."""
    model = NoiseModel(channels={f"accel_{axis}": {term: 1e-3} for axis in "xyz"})
    for k in range(4):
        record = simulate(model, duration=2000.0, rate=20, rng=seed_of(f"{term} {k}") % 2**60)
        assert at_rest(record.streams[0])


@pytest.mark.parametrize("windows", [48, 60, 100])
def test_few_windows_have_no_far_ones(windows):
    """The spread of few is not well known: at most 0.001 of channels, and three standard errors."""
    rng = np.random.default_rng(seed_of(f"few {windows}"))
    records, found = 1000, 0
    for _ in range(records):
        stream = Record.from_arrays(rate=16, accel_x=rng.normal(size=16 * windows)).streams[0]
        found += bool(mean_steps(stream, summarise_windows(stream, "accel_x")))
    assert found <= 0.001 * records + 3 * math.sqrt(0.001 * records)


def test_up_and_back_is_two_changes():
    x = white("back", (N, 1))
    x[50_000:60_000] += 3
    stream = Record.from_arrays(rate=RATE, accel_x=x[:, 0]).streams[0]
    changes = mean_steps(stream, summarise_windows(stream, "accel_x"))
    assert [round(c.sample / 1000) for c in changes] == [50, 60]
    assert [c.size for c in changes] == pytest.approx([3, -3], abs=0.3)
    assert len(not_static(stream)[0].details.steps) == 2


def test_a_single_spike_is_no_knock():
    x = white("spike")
    x[70_020, 0] += 1000
    x[90_020:90_022, 1] += 1000
    assert at_rest(accel(x))


@pytest.mark.parametrize("ratio", [0.05, 0.15, 0.3, 1.0])
@pytest.mark.parametrize("drift", [0.0, 0.7, 5.0])
def test_coarse_steps_are_no_motion(ratio, drift):
    """Rounding noise comes and goes with the mean, and a mean that rests moves on by a step."""
    x = white(f"coarse {ratio}") * ratio + np.linspace(0, drift, N)[:, None]
    assert at_rest(accel(np.round(x)))


def test_a_tilt_by_a_knock_is_told_and_the_knock_left_out():
    x = white("both", (N, 1))[:, 0]
    x[60_000:60_050] *= 20
    x[60_050:] += 1
    stream = Record.from_arrays(rate=RATE, accel_x=x).streams[0]
    ((finding, mask),) = shocks(stream)
    (burst,) = finding.details.bursts
    assert burst.shock
    (tilt,) = not_static(stream, still=masked(stream, mask))
    (step,) = tilt.details.steps
    assert step.size == pytest.approx(1, abs=0.3)


def test_a_mean_that_returns_after_a_shock_is_no_step():
    """A shock with a mean of its own, of some windows."""
    x = white("returns", (N, 1))[:, 0]
    x[60_000:60_400] = 20 * x[60_000:60_400] + 3
    stream = Record.from_arrays(rate=RATE, accel_x=x).streams[0]
    ((_, mask),) = shocks(stream)
    assert not_static(stream, still=masked(stream, mask)) == []


def test_a_mean_that_returns_where_samples_are_left_out_is_no_step():
    """As after a bump that the other sensor shows longer: the level is that of the samples that are there."""
    x = white("bump of the other", (N, 1))[:, 0]
    x[60_000:60_300] -= 8
    gone = np.zeros(N, dtype=bool)
    gone[60_100:60_450] = True
    stream = Record.from_arrays(rate=RATE, accel_x=x).streams[0]
    assert not_static(masked(stream, gone), still=masked(stream, gone)) == []
    x[60_450:] -= 8
    (step,) = not_static(masked(stream, gone), still=masked(stream, gone))[0].details.steps
    assert step.size == pytest.approx(-8, abs=0.3)


def test_gaps_are_no_motion():
    x = white("gaps")
    x[np.random.default_rng(seed_of("lost")).random(N) < 0.05] = np.nan
    x[40_000:44_000] = np.nan
    assert not_static(accel(x)) == []
    assert shocks(accel(x)) == []
    x[60_000:60_100] += 40 * white("through gaps", (100, 3))
    ((finding, _),) = shocks(accel(x))
    assert [burst.shock for burst in finding.details.bursts] == [True]


def test_bursts_and_signals():
    x = white("bursts", (N, 1))[:, 0]
    x[60_000:60_100] *= 10
    stream = Record.from_arrays(rate=RATE, signal=x).streams[0]
    (burst,) = bursts(stream, summarise_windows(stream, "signal"))
    assert (burst.start, burst.stop) == (60_000, 60_100)
    assert at_rest(stream)  # a temperature may do as it likes


class TestStepsAcrossGaps:
    """The sensor is moved, or its bias jumps, while nothing is recorded for 10 s; a fit would take it for a walk."""

    @pytest.mark.parametrize("size", [-0.4, 0.4])
    def test_told(self, size):
        """Ten times the error of means over 16 s."""
        x = white("step across a gap", (N, 1))[:, 0]
        x[60_500:] += size
        x[60_000:60_500] = np.nan
        (finding,) = not_static(Record.from_arrays(rate=RATE, accel_x=x).streams[0])
        (step,) = finding.details.steps
        assert not step.gradual
        assert step.size == pytest.approx(size, abs=0.2)
        assert abs(step.time - 1205) <= step.uncertainty

    @pytest.mark.parametrize("share", [0.03, 0.05, 0.1])
    def test_told_of_a_gap_that_is_long_for_its_record(self, share):
        """Twenty times the error of means over 16 s, in a record of 5 min."""
        n = round(300 * RATE)
        x = white(f"step across {share}", (N, 1))[:n, 0]
        gap = slice(n // 2, n // 2 + round(share * n))
        x[gap.stop :] += 2.0
        x[gap] = np.nan
        (finding,) = not_static(Record.from_arrays(rate=RATE, accel_x=x).streams[0])
        (step,) = finding.details.steps
        assert step.size == pytest.approx(2.0, abs=0.3)
        assert abs(step.time - (gap.start + gap.stop) / 2 / RATE) <= step.uncertainty

    def test_a_small_step_across_a_long_gap(self):
        """33 times the error of means over 16 s: 0.05 deg/s of a gyro with 0.36 deg/√h."""
        n, count = round(300 * RATE), 20
        x = white("small steps", (N, count))[:n]
        gap = slice(n // 2, n // 2 + round(15 * RATE))
        x[gap.stop :] += 33 / np.sqrt(16 * RATE)
        x[gap] = np.nan
        steps = [not_static(Record.from_arrays(rate=RATE, accel_x=x[:, k]).streams[0]) for k in range(count)]
        assert sum(map(bool, steps)) >= 0.7 * count  # 0.92 are expected, 0.4 with the limit for the largest of many

    @pytest.mark.parametrize("share", [0.03, 0.1])
    @pytest.mark.parametrize("slow", [0.0, 0.01, 0.1])
    def test_a_long_gap_in_noise_has_none(self, slow, share):
        n = round(300 * RATE)
        x = white(f"long gap {slow} {share}") + slow * np.cumsum(white(f"walk beside {slow} {share}"), axis=0)
        x = x[:n]
        x[n // 3 : n // 3 + round(share * n)] = np.nan
        assert not_static(accel(x)) == []

    @pytest.mark.parametrize("slow", [0.0, 0.001, 0.01, 0.1])
    def test_noise_of_every_slope_has_none(self, slow):
        """Steps from sample to sample of a walk, from none to one tenth of the white noise."""
        x = white(f"no step across a gap {slow}") + slow * np.cumsum(white(f"walk {slow}"), axis=0)
        x[60_000:60_500] = np.nan
        assert not_static(accel(x)) == []

    def test_a_drift_goes_on(self):
        x = white("drift across a gap") + 20 * np.exp(-np.arange(N) / 40_000)[:, None]
        x[60_000:60_500] = np.nan
        assert all(step.gradual for one in not_static(accel(x)) for step in one.details.steps)
