"""A disturbance in half an hour of six axes, through the whole tool: what is told, how many warnings, and what is not."""

import math

import numpy as np
import pytest
from clean_records import check_samples as check

from known import seed_of
from sigmatau import NoiseModel, Record, allan, analyze, simulate
from sigmatau.quality.samples.repeated_samples import repeated_samples

RATE, N = 100.0, 180_000
T = np.arange(N) / RATE


def six(name):
    rng = np.random.default_rng(seed_of(name))
    gyro = 2e-4 * rng.normal(size=(N, 3)) + [2e-3, -1e-3, 1.5e-3]
    return gyro, 5e-3 * rng.normal(size=(N, 3)) + [0.1, -0.15, 9.803]


def told(gyro, accel):
    return analyze(Record.from_arrays(rate=RATE, gyro=gyro, accel=accel), threads=1).findings


def warnings_of(findings):
    return [finding for finding in findings if finding.severity != "info"]


def test_a_ringing_knock_is_no_filter_and_no_correlation():
    gyro, accel = six("ringing knock")
    ring = np.exp(-np.arange(100) / 20) * np.sin(np.arange(100) * 0.9)
    gyro[72_000:72_100] += 0.2 * ring[:, None]
    accel[72_000:72_100] += ring[:, None] * [2, 1, 3]
    found = told(gyro, accel)
    assert [(f.code, bool(f.left_out)) for f in found] == [("not_static", True)] * 2
    for finding in found:
        assert [burst.shock for burst in finding.details.bursts] == [True]
        assert finding.spans[0][0] == 720.0


def test_a_light_knock_is_a_knock_and_no_spikes():
    gyro, accel = six("light knock")
    ring = np.exp(-np.arange(60) / 8) * np.sin(np.arange(60) * 0.9)
    gyro[72_000:72_060] += 0.005 * ring[:, None]
    accel[72_000:72_060] += ring[:, None] * [0.1, 0.05, 0.2]
    for stream in Record.from_arrays(rate=RATE, gyro=gyro, accel=accel).streams:
        (finding,) = check(stream)
        assert finding.code == "not_static"
        assert [burst.shock for burst in finding.details.bursts] == [True]
        assert finding.spans[0][0] == pytest.approx(720, abs=0.5)


def test_rows_that_are_wrong_are_spikes():
    """On all axes at once, but in one row: no knock."""
    gyro, _ = six("wrong rows")
    gyro[np.random.default_rng(seed_of("which rows")).choice(N, 40, replace=False)] += 0.01
    assert {f.code for f in check(Record.from_arrays(rate=RATE, gyro=gyro).streams[0])} == {"spikes"}


@pytest.mark.parametrize("seconds", [1.0, 5.0])
def test_a_rotation_is_motion(seconds):
    """A degree a second at most, so smooth that no two samples differ by it."""
    gyro, accel = six(f"rotation {seconds}")
    n = round(seconds * RATE)
    gyro[108_000 : 108_000 + n, 1] += math.radians(1) * np.sin(np.pi * np.arange(n) / n) ** 2
    found = told(gyro, accel)
    (finding,) = found
    assert (finding.code, finding.channel, finding.severity) == ("not_static", "gyro_y", "info")
    assert 0 < finding.left_out < 0.05 * N
    (burst,) = finding.details.bursts
    assert burst.departure > 0
    assert burst.start == pytest.approx(1080, abs=seconds + 2)


def test_no_excursions_of_slow_noise():
    """Of 12 channels of each slow term, and of both with white noise, none: by the law below 1e-5 a channel."""
    for terms in (
        {"bias_instability": 1e-3},
        {"rate_random_walk": 1e-4, "random_walk": 1e-3},
        {"rate_random_walk": 1e-3},
    ):
        model = NoiseModel(channels={f"gyro_{k}": terms for k in range(12)})
        record = simulate(model, duration=1200.0, rate=16.0, rng=seed_of(f"slow {terms}"))
        for stream in record.streams:
            assert not [f for f in check(stream) if f.severity != "info"]


def test_a_start_from_zero_is_told_once():
    from scipy.signal import butter, lfilter

    gyro, accel = six("from zero")
    b, a = butter(2, 10 / (RATE / 2))
    for x, name in ((gyro, "gyro"), (accel, "accel")):
        (finding,) = check(Record.from_arrays(rate=RATE, **{name: lfilter(b, a, x, axis=0)}).streams[0])
        assert finding.code == "start_transient"
        ((start, stop),) = finding.spans
        assert start == 0
        assert 0 < stop == finding.details.settled < 1
        settled = lfilter(b, a, x - x[0], axis=0) + x[0]
        assert check(Record.from_arrays(rate=RATE, **{name: settled}).streams[0]) == []


@pytest.mark.parametrize("time", [60.0, 240.0])
def test_a_warm_up_is_told_once(time):
    gyro, accel = six(f"warm-up {time}")
    gyro[:, 0] += (1e-3 if time > 100 else 2e-4) * np.exp(-T / time)
    findings = [(f.code, f.severity) for f in told(gyro, accel)]
    assert findings.count(("warm_up", "info")) == 1
    # A rate random walk is seen in one of twenty records without it; it has its other explanation.
    assert {*findings} <= {("warm_up", "info"), ("second_explanation", "info")}


def test_each_of_several_steps_is_told_and_is_the_reason():
    gyro, accel = six("several steps")
    gyro[60_000:, 0] += 1e-4
    gyro[120_000:, 0] += 1.5e-4
    (finding,) = warnings_of(told(gyro, accel))
    assert finding.code == "not_static"
    assert [step.time for step in finding.details.steps] == pytest.approx([600, 1200], abs=5)
    assert [start for start, _ in finding.spans] == [step.time for step in finding.details.steps]
    start, stop = finding.details.keep
    assert (stop or 1800) - (start or 0) == pytest.approx(600, abs=100)


@pytest.mark.parametrize("share", [0.05, 0.2])
def test_lost_samples_with_the_last_in_their_place(share):
    """Random walk larger at all averaging times by what is stated: over 15 channels."""
    ratios, stated = [], []
    for k in range(5):
        x = six(f"held {share} {k}")[0]
        lost = np.random.default_rng(seed_of(f"lost {share} {k}")).random(N) < share
        lost[0] = False
        y = x[np.maximum.accumulate(np.where(lost, 0, np.arange(N)))]
        (finding,) = repeated_samples(Record.from_arrays(rate=RATE, gyro=y).streams[0])
        assert finding.details.pattern == "irregular"
        stated.append(dict(finding.factors)["random_walk"])
        both = [allan(Record.from_arrays(rate=RATE, gyro=z), taus=[0.64]) for z in (y, x)]
        ratios += [float(a.adev[0] / b.adev[0]) for a, b in zip(*(c.values() for c in both), strict=True)]
    error = np.std(ratios, ddof=1) / math.sqrt(15)
    assert np.mean(stated) == pytest.approx(math.sqrt((1 + share) / (1 - share)), rel=0.01)
    # At 64 samples a copy beyond the end of a cluster still counts: 1/64 of the variance at most.
    assert np.mean(ratios) == pytest.approx(np.mean(stated), abs=3 * error + 0.005)
