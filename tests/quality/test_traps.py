"""The faults of records that make tools in use give wrong numbers: planted, seen, and their stated effect checked.

Rows of the first table of the survey of tools that a record's samples can carry. Those that a record cannot carry (one-sided
densities, counting, intervals) are tested where the mathematics is; filters and stamps, with the spectrum and the reader.
"""

import math

import numpy as np
import pytest
from clean_records import check_samples as check

from known import seed_of
from sigmatau import NoiseModel, Record, allan, fit, simulate

N = 0.0005  # rad/√s
RATE = 100.0
TERMS = {"random_walk": N, "bias_instability": 2e-5}


def sensor(name, *, rate=RATE, n=100_000):
    model = NoiseModel(channels={f"gyro_{axis}": TERMS for axis in "xyz"})
    record = simulate(model, duration=n / rate, rate=rate, rng=seed_of(name) % 2**60)
    return np.stack([record.streams[0].column(c) for c in record.channels], axis=1)


def random_walk(x, rate, *, tau_min=None):
    """Fitted, with its standard error; mean of the axes."""
    fits = [fit(c, tau_min=tau_min)["random_walk"] for c in allan(Record.from_arrays(rate=rate, gyro=x)).values()]
    error = math.sqrt(sum(((f.high - f.low) / 3.92) ** 2 for f in fits)) / 3
    return sum(f.value for f in fits) / 3, error


def findings(x, rate):
    return {f.code: f for f in check(Record.from_arrays(rate=rate, gyro=x).streams[0])}


@pytest.mark.parametrize("times", [2, 3])
def test_duplicated_samples_at_an_assumed_rate(times):
    """Each message twice in the log, the sensor's rate typed by hand: random walk × 1.41."""
    x = np.repeat(sensor("duplicated"), times, axis=0)
    finding = findings(x, RATE)["repeated_samples"]
    stated = dict(finding.factors)["random_walk"]
    assert stated == pytest.approx(math.sqrt(times), rel=1e-6)
    value, error = random_walk(x, RATE, tau_min=0.16 * times)
    assert value / N == pytest.approx(stated, abs=3 * error / N)
    # What the finding tells to do gives the sensor's own.
    value, error = random_walk(x[::times], RATE)
    assert value == pytest.approx(N, abs=3 * error)


def test_the_other_coefficients_of_duplicated_samples():
    """Times are stretched twice: quantization × 2, rate random walk × 0.71, ramp × 0.5; exact in the Allan variance."""
    for term, slope in (("quantization", -1.0), ("rate_random_walk", 0.5), ("rate_ramp", 1.0)):
        model = NoiseModel(channels={"gyro_x": {term: 1e-3}})
        x = simulate(model, duration=400.0, rate=RATE, rng=seed_of(f"other {term}") % 2**60).streams[0].column("gyro_x")
        x = x + 1e-5 * np.random.default_rng(seed_of(f"noise {term}")).normal(size=len(x))
        twice = Record.from_arrays(rate=RATE, gyro_x=np.repeat(x, 2))
        (finding,) = [f for f in check(twice.streams[0]) if f.code == "repeated_samples"]
        once = allan(Record.from_arrays(rate=RATE, gyro_x=x), taus=[5.12])["gyro_x"].adev[0]
        stretched = allan(twice, taus=[10.24])["gyro_x"].adev[0]
        # The same clusters, and those between: with quantization noise half of them begin within a sample.
        ratio = float(stretched / once) * 2**-slope
        assert ratio == pytest.approx(dict(finding.factors)[term], rel=0.3 if term == "quantization" else 0.01)


def test_duplicates_with_their_own_stamps_leave_the_random_walk():
    """At 200 Hz for the rows nothing is stretched: σ is low at one sample (0.5 ×), and right at long τ."""
    x = np.repeat(sensor("stamped"), 2, axis=0)
    finding = findings(x, 2 * RATE)["repeated_samples"]
    assert finding.details.sensor_rate == pytest.approx(100, rel=0.01)
    assert finding.details.sigma_one_sample == pytest.approx(0.5, rel=0.01)
    value, error = random_walk(x, 2 * RATE, tau_min=0.32)
    assert value == pytest.approx(N, abs=3 * error)
    curves = allan(Record.from_arrays(rate=2 * RATE, gyro=x), taus=[1 / (2 * RATE)])
    first = np.mean([float(c.adev[0]) for c in curves.values()])
    assert first / (N * math.sqrt(2 * RATE)) == pytest.approx(0.5, rel=3 * 0.5 * math.sqrt(3 / 300_000) + 1e-3)


def test_samples_interpolated_from_63_to_200_hz():
    """N reads 0.16 … 1.0 by τ: 0.16 at one sample, as stated, and 1 from eight of the sensor's samples on."""
    x = sensor("interpolated", rate=63.0)
    n = 300_000
    up = np.stack([np.interp(np.arange(n) * 63 / 200, np.arange(len(c)), c) for c in x.T], axis=1)
    finding = findings(up, 200.0)["interpolated"]
    stated = finding.details.upsampled.sigma_one_sample
    assert stated == pytest.approx(0.16, abs=0.005)
    curves = allan(Record.from_arrays(rate=200, gyro=up), taus=[0.005, 0.635])
    read = np.mean([c.adev * np.sqrt(c.tau) for c in curves.values()], axis=0) / N
    assert read[0] == pytest.approx(stated, abs=0.005 + 3 * 0.16 * 0.5 * math.sqrt(3 / 280_000))
    # 40 of the sensor's samples of 94,500, three axes; flicker adds 0.664²·B²·τ to N²: 0.02 %.
    assert read[1] == pytest.approx(1.0, abs=3 / math.sqrt(2 * 3 * (94_500 / 40 - 1)) + 0.005)


def test_decimation_without_averaging_cannot_be_seen_in_a_record():
    """400 → 100 Hz by leaving samples out: N × 2, and what is left is white noise like any other. Nothing can be said."""
    x = sensor("decimated", rate=400.0, n=400_000)[::4]
    assert findings(x, 100.0) == {}
    value, error = random_walk(x, 100.0)
    assert value / N == pytest.approx(2.0, abs=3 * error / N)


def test_g_taken_for_metres_per_second_squared():
    """Every coefficient of the accelerometers 9.81 × too small."""
    x = sensor("in g") / 50 + [0.01, -0.03, 1.02]
    right = Record.from_arrays(rate=RATE, unit={"accel": "g"}, accel=x)
    wrong = Record.from_arrays(rate=RATE, accel=x)
    (finding,) = check(wrong.streams[0])
    assert finding.code == "implausible_unit"
    pairs = [allan(r)["accel_z"] for r in (wrong, right)]
    fitted = [fit(c)["random_walk"].value for c in pairs]
    assert fitted[0] / fitted[1] == pytest.approx(dict(finding.factors)["random_walk"], rel=1e-9)


def test_a_knock_at_minute_ten():
    x = sensor("knocked")
    x[60_000:60_030] += 0.5 * np.random.default_rng(seed_of("the knock")).normal(size=(30, 3))
    finding = findings(x, RATE)["not_static"]
    assert finding.spans[0][0] == pytest.approx(600, abs=0.2)
    assert finding.channel is None


def test_the_sensor_without_a_fault():
    assert findings(sensor("without"), RATE) == {}
