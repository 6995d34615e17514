"""The step of the numbers, however they were scaled, printed or rounded; and what it does."""

import math

import numpy as np
import pytest
from scipy.signal import lfilter

from known import seed_of
from sigmatau import Record, allan, check
from sigmatau.quality.samples.counts import rounding_by_sums
from sigmatau.quality.samples.resolution import coarse_resolution, common_step, find_step, resolution, rounded
from sigmatau.quality.samples.spikes import find_spikes
from sigmatau.record.streams import Columns, Grid, Stream, Transform

N = 100_000


def counts(name, spread):
    return np.round(np.random.default_rng(seed_of(name)).normal(size=N) * spread)


def stream_of(raw, **transform):
    return Stream(
        name="gyro",
        quantity="angular_rate",
        unit="rad/s",
        channels=("gyro_x",),
        grid=Grid(n=len(raw) - (transform.get("kind") == "accumulated"), tau0=0.01),
        samples=Columns((raw,), (Transform(**transform),), 0.01),
    )


@pytest.mark.parametrize("spread", [0.3, 1.0, 30.0, 3000.0])
@pytest.mark.parametrize(
    ("write", "exact"),
    [
        (lambda k: k * 0.05, 1e-12),  # deg/s of the ADIS16405
        (lambda k: np.deg2rad(k / 131) - 0.123456, 1e-9),  # an offset taken off, after conversion
        (lambda k: k * 1e-3 + 1e6, 1e-6),  # a huge offset
        (lambda k: np.float32(k / 4096 * 9.80665).astype(float), 1e-4),  # single precision
        (lambda k: np.round(k * 0.00333333, 5), 2e-3),  # printed with five decimals
        (lambda k: np.round(k / 16.4, 3), 2e-3),
    ],
)
def test_step_is_that_of_the_counts(spread, write, exact):
    k = counts(f"step {spread}", spread)
    x = write(k)
    step = (write(np.array([1e4])) - write(np.array([0.0])))[0] / 1e4
    assert common_step(x) == pytest.approx(step, rel=max(exact, 1e-3 if spread == 0.3 else 0))


def test_two_values_have_a_step_and_one_has_none():
    assert common_step(np.array([1.0, 3.0] * 50)) == pytest.approx(2.0)
    assert common_step(np.ones(100)) is None
    assert common_step(np.full(100, np.nan)) is None


@pytest.mark.parametrize("n", [2, 3, 4, 5, 8, 20, 50, 1000, 20_000])
def test_noise_of_double_precision_has_none(n):
    rng = np.random.default_rng(seed_of(f"none {n}"))
    assert [common_step(rng.normal(size=n)) for _ in range(60 if n < 5000 else 5)].count(None) in (60, 5)


@pytest.mark.parametrize("form", ["counts", "accumulated", "differenced"])
@pytest.mark.parametrize(("noise", "mean"), [(0.27, -12.13), (0.29, 23.19), (0.38, 1.87), (0.4, -14.03), (1.0, 7.27)])
def test_the_rounding_of_an_angle_is_no_step_of_its_counts(form, noise, mean):
    """A counter in double precision: its differences are multiples of S but for ε of the angle. Nothing is wrong with it."""
    angle = np.floor(np.cumsum(np.random.default_rng(seed_of(f"dust {noise} {mean}")).normal(mean, noise, 200_001)))
    raw = {"counts": np.diff(angle) * 5e-7, "accumulated": angle * 5e-7, "differenced": np.diff(angle * 5e-7)}[form]
    record = Record.from_arrays(rate=100, gyro_x=raw, input="accumulated" if form == "accumulated" else "increments")
    stream = record.streams[0]
    assert find_step(stream, "gyro_x") * 0.01 == pytest.approx(5e-7, rel=1e-6)
    assert not find_spikes(stream.column("gyro_x")).any()
    found = check(record)
    assert {f.severity for f in found} == {"info"}
    assert found[0].code == "coarse_resolution"


@pytest.mark.parametrize("ratio", [0.5, 0.7, 1.0, 2.0])
def test_what_rounding_adds_to_the_random_walk(ratio):
    """q²/12 a sample: as the Allan variance with and without it says, on average over 12 records, to a tenth of it."""
    rng = np.random.default_rng(seed_of(f"adds {ratio}"))
    stated, measured = [], []
    for _ in range(12):
        x = rng.normal(size=N) * ratio + rng.uniform()
        (finding,) = coarse_resolution(Record.from_arrays(rate=100, gyro_x=np.round(x)).streams[0])
        stated.append(dict(finding.factors)["random_walk"])
        curves = allan(Record.from_arrays(rate=100, a=x, b=np.round(x)), taus=[0.16])
        measured.append(float(curves["b"].adev[0] / curves["a"].adev[0]))
        assert finding.severity == ("warning" if stated[-1] > 1.05 else "info")
    stated, measured = np.array(stated), np.array(measured)
    error = np.std(stated - measured, ddof=1) / math.sqrt(12)
    added = math.sqrt(1 + 1 / (12 * ratio**2)) - 1
    assert abs(np.mean(stated - measured)) <= 0.1 * added + 3 * error
    assert stated.mean() - 1 == pytest.approx(added, rel=0.1)


@pytest.mark.parametrize("ratio", [0.1, 0.2, 0.3])
@pytest.mark.parametrize("phase", [0.1, 0.3, 0.5])
def test_below_half_a_step_it_is_not_known_what_rounding_adds(phase, ratio):
    x = np.random.default_rng(seed_of(f"below {phase}")).normal(size=N) * ratio + phase
    (finding,) = coarse_resolution(Record.from_arrays(rate=100, gyro_x=np.round(x)).streams[0])
    assert finding.severity == "warning"
    assert finding.factors == ()
    assert (finding.details.rounding, finding.details.added) == ("unknown", None)
    assert rounded(finding)


def test_fine_steps_are_not_told():
    x = np.random.default_rng(seed_of("fine")).normal(size=N) * 10
    assert coarse_resolution(Record.from_arrays(rate=100, gyro_x=np.round(x)).streams[0]) == []


def test_increments_get_quantization_noise_and_no_random_walk():
    (finding,) = coarse_resolution(stream_of(counts("coarse increments", 1), kind="increments", scale=1e-4))
    assert finding.severity == "info"
    assert finding.factors == ()
    assert finding.details.rounding == "quantization"
    assert finding.details.added == pytest.approx(1e-4 / math.sqrt(12), rel=1e-6)
    assert not rounded(finding)


def test_a_line_is_not_coarse():
    assert coarse_resolution(Record.from_arrays(rate=100, gyro_x=np.arange(10_000) * 0.001).streams[0]) == []


def test_noise_in_steps():
    found = resolution(Record.from_arrays(rate=100, gyro_x=counts("prints", 2)).streams[0], "gyro_x")
    assert found.step == pytest.approx(1.0)
    assert found.ratio == pytest.approx(math.sqrt(4 + 1 / 12), rel=0.05)  # 500 blocks of 32, their median


@pytest.mark.parametrize("steps", [0.3, 0.6])
@pytest.mark.parametrize("drift", [0.0, 30.0])
def test_rates_that_were_made_of_differences_of_angles(steps, drift):
    """The rounding of the angle in double precision is not the step of its increments, nor an end of a range."""
    pulses = np.round(np.cumsum(np.random.default_rng(seed_of(f"pulses {steps} {drift}")).normal(drift, steps, 30_000)))
    step = 1.2345e-6
    record = Record.from_arrays(rate=100, gyro=np.diff(pulses * step) * 100, unit={"gyro": "rad/s"})
    assert resolution(record.streams[0], "gyro").step == pytest.approx(100 * step, rel=1e-6)
    assert "saturation" not in {finding.code for finding in check(record)}


def counts_of(name, *, noise, rate=0.0, n=60_000):
    """Counts of an angle that moves by `noise` counts a sample, and turns by `rate`."""
    rng = np.random.default_rng(seed_of(name))
    angle = np.cumsum(noise * rng.standard_normal(n + 1) + rate) + rng.uniform()
    return np.diff(np.round(angle))


@pytest.mark.parametrize("rate", [0.0, 0.013, 0.5, 7.25])
@pytest.mark.parametrize("noise", [0.01, 0.2, 0.7, 1.0])
def test_counts_of_an_angle_are_recognised(noise, rate):
    assert rounding_by_sums(counts_of(f"counts {noise} {rate}", noise=noise, rate=rate)) == "of_sums"


@pytest.mark.parametrize(
    "write",
    [
        lambda k: k * 1.00137e-3 - 7.7e-5,
        lambda k: np.float32(np.rad2deg(k * 1e-3)).astype(float),
        lambda k: k * 64.0,
        lambda k: np.round(k * 0.0333, 4),
    ],
)
@pytest.mark.parametrize(("noise", "rate"), [(0.3, 0.11), (0.8, 0.0)])
def test_counts_are_recognised_however_they_are_written(write, noise, rate):
    (found,) = coarse_resolution(stream_of(write(counts_of(f"written {noise}", noise=noise, rate=rate))))
    assert found.details.rounding == "quantization"
    assert found.walk_factor is None
    assert found.details.passing == pytest.approx(100 * rate, abs=2)


@pytest.mark.parametrize("noise", [0.25, 0.4, 0.6, 1.0, 2.0])
def test_rounded_rates_are_no_counts(noise):
    """Rates with white, filtered, slow noise, a tone or a resonance, each sample rounded by itself."""
    rng = np.random.default_rng(seed_of(f"rates {noise}"))
    white = noise * rng.standard_normal(N) + rng.uniform()
    smooth = np.convolve(white, [0.25, 0.5, 0.25], "same")
    slow = white + np.cumsum(rng.standard_normal(N)) / 300
    tone = white + 0.7 * np.cos(2 * np.pi * 0.23 * np.arange(N))
    ringing = white + lfilter([0.1], [1, -0.6, 0.9], rng.standard_normal(N))
    for samples in (white, smooth, slow, tone, ringing):
        assert rounding_by_sums(np.round(samples)) != "of_sums"
    if noise < 0.7:
        assert rounding_by_sums(np.round(white)) == "of_samples"


def test_increments_that_were_rounded_by_themselves_have_white_rounding():
    k = np.round(0.6 * np.random.default_rng(seed_of("own rounding")).standard_normal(N) + 0.2)
    (found,) = coarse_resolution(stream_of(k, kind="increments"))
    assert found.details.rounding == "white"
