"""Single rows that are there twice: found where chance does not make them, silent where it does."""

import math

import numpy as np
import pytest
from clean_records import check_samples as check

from known import seed_of
from sigmatau import NoiseModel, Record, analyze, simulate
from sigmatau.quality.samples.duplicate_rows import copies

RATE = 100.0


def white(name, n=60_000):
    return 1e-4 * np.random.default_rng(seed_of(name)).standard_normal((n, 3))


def written_twice(name, share, *, decimals=13):
    samples = np.round(white(name), decimals)
    rng = np.random.default_rng(seed_of(f"{name}, which"))
    again = 1 + (rng.random(len(samples)) < share)
    return np.repeat(samples, again, axis=0), int((again == 2).sum())


@pytest.mark.parametrize("share", [1e-4, 1e-3, 5e-3, 1e-2])
def test_each_is_counted(share):
    samples, count = written_twice(f"written twice {share}", share)
    ((said, mask),) = copies(Record.from_arrays(rate=RATE, gyro=samples).streams[0])
    assert said.code == "repeated_samples"
    assert (said.details.pattern, said.details.copies) == ("rows", count)
    assert said.size == said.details.share == count / len(samples)
    assert np.count_nonzero(mask, axis=0).tolist() == [count] * 3


@pytest.mark.parametrize("steps", [0.3, 1.0, 3.0, 100.0])
def test_coarse_numbers_are_equal_by_chance(steps):
    """Steps of the noise: neighbours are equal on all three axes now and then, by chance: no finding in 10 records."""
    for k in range(10):
        samples = 1e-4 * np.round(1e4 * white(f"coarse {steps} {k}", 20_000) * steps)
        assert copies(Record.from_arrays(rate=RATE, unit={"gyro": "deg/s"}, gyro=samples).streams[0]) == []


def test_clean_records_of_single_precision():
    for k in range(10):
        samples = white(f"single {k}", 20_000).astype(np.float32)
        assert copies(Record.from_arrays(rate=RATE, gyro=samples).streams[0]) == []


def test_what_sticks_is_not_told_twice():
    samples = white("sticks")
    samples[30_000:30_060] = samples[30_000]
    found = check(Record.from_arrays(rate=RATE, gyro=samples).streams[0])
    assert {f.code for f in found} == {"stuck_samples"}


def test_a_sensor_slower_than_its_log_is_told_once():
    found = check(Record.from_arrays(rate=RATE, gyro=np.repeat(white("slow", 20_000), 2, axis=0)).streams[0])
    assert [f.code for f in found if f.code == "repeated_samples"] == ["repeated_samples"]


class TestTooCoarse:
    """Below half a step of noise rounding is no white noise; the intervals then hold for any mean."""

    def test_intervals_allow_for_it(self):
        rng = np.random.default_rng(seed_of("too coarse"))
        fine = 1e-4 * rng.standard_normal(60_000)
        coarse = 1e-3 * np.round(1e-4 * rng.standard_normal(60_000) / 1e-3 + 0.35)
        analysis = analyze(Record.from_arrays(rate=RATE, gyro_x=fine, gyro_y=coarse))
        fitted = analysis.fits["gyro_y"]
        assert fitted.verdict == "widened"
        assert "too coarse" in fitted.reason
        walk = fitted["random_walk"]
        assert walk.upper_limit >= 1e-4 / math.sqrt(RATE)  # a mean at a level shows nothing of so little noise
        assert all(t.upper_limit > 0 for t in fitted.values())
        clean = analysis.fits["gyro_x"]
        assert clean.verdict == "adequate"
        assert fitted["bias_instability"].upper_limit > 10 * clean["bias_instability"].upper_limit
        codes = [f.code for f in analysis.findings if f.channel == "gyro_y" and f.severity == "warning"]
        assert codes == ["coarse_resolution"]
        row = next(line for line in analysis.summary().splitlines() if line.startswith("gyro_y"))
        assert "the model fits roughly" in row

    def test_steps_that_noise_blurs_leave_the_intervals(self):
        rng = np.random.default_rng(seed_of("blurred"))
        x = np.round(2.0 * rng.standard_normal(60_000))
        analysis = analyze(Record.from_arrays(rate=RATE, gyro_x=1e-4 * x))
        assert analysis.fits["gyro_x"].verdict == "adequate"


def test_findings_of_several_axes_name_them():
    """Gyros and accelerometers from straight lines: a finding each; and what it does to σ(τ₀)."""
    t = np.arange(0, 60_000) / 2.5
    streams = {}
    for name in ("gyro", "accel"):
        knots = white(f"lines {name}", 24_001)
        streams[name] = np.stack([np.interp(t, np.arange(len(knots)), knots[:, k]) for k in range(3)], axis=1)
    record = Record.from_arrays(rate=RATE, **streams)
    found = [f for s in record.streams for f in check(s) if f.code == "interpolated"]
    assert len(found) == 2
    for finding, name in zip(found, ("gyro", "accel"), strict=True):
        assert finding.channels == tuple(f"{name}_{axis}" for axis in "xyz")
        curve = analyze(Record.from_arrays(rate=RATE, **{name: streams[name]}), method="read-off").curves[f"{name}_x"]
        long = curve.adev[np.argmin(np.abs(curve.tau - 5.12))] * np.sqrt(5.12 / curve.tau0)
        # 60 000 samples, 58 pairs of 5.12 s that overlap: some 10 %; three of them
        assert curve.adev[0] / long == pytest.approx(dict(finding.factors)["random_walk"], rel=0.3)


def test_accelerometers_have_an_acceleration_random_walk():
    model = NoiseModel(channels={c: {"random_walk": 1e-4} for c in ("gyro_x", "accel_x")})
    record = simulate(model, duration=600, rate=100, rng=seed_of("words"))
    columns = {c: record.stream_of(c).column(c).copy() for c in ("gyro_x", "accel_x")}
    for column in columns.values():
        column[25_000:] += 0.01
    for stream in Record.from_arrays(rate=100, **columns).streams:
        (step,) = (f for f in check(stream) if f.code == "not_static")
        assert step.details.added_walk > 0
        assert ("acceleration random walk" in step.message) == (stream.name == "accel")
        assert "rate random walk" in step.message or stream.name == "accel"
