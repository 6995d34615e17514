"""A white level that changes along the record: the test for it, the interval of the random walk, and what is stated."""

import math

import numpy as np
import pytest

from known import seed_of
from sigmatau import Analysis, Record, analyze, fit_channel, read
from sigmatau.findings.fit import ChangingLevel
from sigmatau.fitting.changing_level import UNSTEADY, level_errors, unsteadiness
from sigmatau.model.parameters import Parameter

N, RATE, SAMPLES = 1e-4, 20.0, 36_000
CHANCE = 0.01  # standard deviation of the level of an eighth by chance
FINE = 16  # steps of a level in an eighth


def levels(logs, rng):
    return [(k, math.exp(x + CHANCE * rng.standard_normal()), CHANCE**2) for k, x in enumerate(logs)]


def most(share, count):
    """A share and three standard errors."""
    return count * share + 3 * math.sqrt(count * share * (1 - share))


def test_a_steady_level_is_seldom_called_a_change():
    rng = np.random.default_rng(seed_of("changing level, steady"))
    p = [unsteadiness(levels(np.zeros(8), rng)) for _ in range(2000)]
    assert sum(value < UNSTEADY for value in p) <= most(UNSTEADY, 2000)
    assert sum(value < 0.05 for value in p) <= most(0.05, 2000)


def test_a_slow_change_is_seen_earlier_than_by_the_scatter_of_all_eighths():
    """A trend of 5 chance errors over the record: of scatter alone, χ² with 7 degrees of freedom sees half as many."""
    rng = np.random.default_rng(seed_of("changing level, trend"))
    trend = 5 * CHANCE * (np.arange(8) - 3.5) / 8
    assert sum(unsteadiness(levels(trend, rng)) < UNSTEADY for _ in range(300)) > 0.5 * 300


def process(kind, rng):
    """Logarithms of N² along two records."""
    noise = rng.standard_normal(2 * 8 * FINE)
    t = np.arange(noise.size) / (8 * FINE)
    if kind == "white":
        return 0.2 * noise
    if kind == "walk":
        return 0.2 * np.cumsum(noise) / math.sqrt(8 * FINE)
    if kind == "sine":
        return 0.1 * np.sin(2 * np.pi * (t / 0.7 + rng.uniform()))
    if kind == "noisy tenth":
        starts = rng.uniform(0, 0.9, 2)
        return 0.7 * sum((t >= k + start) & (t < k + start + 0.1) for k, start in enumerate(starts))
    decay = math.exp(-1 / (0.3 * 8 * FINE))  # of the temperature: a correlation time of 0.3 records
    x = np.empty_like(noise)
    x[0] = noise[0]
    for k in range(1, len(x)):
        x[k] = decay * x[k - 1] + math.sqrt(1 - decay**2) * noise[k]
    return 0.1 * x


@pytest.mark.parametrize("kind", ["white", "walk", "sine", "noisy tenth", "temperature"])
def test_the_next_record_is_in_its_interval(kind):
    """Where the change is changed: the mean of this record, and that of the next one of the same process."""
    rng = np.random.default_rng(seed_of(f"changing level, {kind}"))
    changed, mean, following = 0, 0, 0
    for _ in range(100):
        eighths = np.log(np.exp(process(kind, rng)).reshape(16, FINE).mean(axis=1))
        measured = levels(eighths[:8], rng)
        if unsteadiness(measured) >= UNSTEADY:
            continue
        changed += 1
        errors = level_errors(measured, level=0.95)
        now, later = (math.log(np.mean(np.exp(part))) for part in (eighths[:8], eighths[8:]))
        value = math.log(np.mean([level for _, level, _ in measured]))
        statistical = 1.96 * CHANCE / math.sqrt(8)
        mean += abs(now - value) <= math.hypot(errors.mean, statistical)
        following += abs(later - value) <= math.hypot(errors.following, math.sqrt(2) * statistical)
    assert changed > 60
    assert mean >= changed - most(0.05, changed)
    assert following >= changed - most(0.05, changed)


def test_the_interval_follows_its_level_and_the_scatter():
    rng = np.random.default_rng(seed_of("changing level, scale"))
    logs = rng.standard_normal(8)
    small, large = ([(k, math.exp(scale * x), 1e-12) for k, x in enumerate(logs)] for scale in (0.01, 0.03))
    for name in ("mean", "following"):
        at = [getattr(level_errors(small, level=level), name) for level in (0.68, 0.95, 0.99)]
        assert at == sorted(at)
        assert getattr(level_errors(large, level=0.95), name) == pytest.approx(3 * at[1], rel=1e-6)


def test_few_eighths_say_nothing():
    assert unsteadiness([(k, 1 + k, 1e-6) for k in range(3)]) == 1.0
    assert unsteadiness([]) == 1.0
    assert unsteadiness([(k, 1 + k, 1e-6) for k in (0, 2, 3, 7)]) < 1e-9
    assert 0 < level_errors([(k, 1 + k, 1e-6) for k in (0, 2, 3, 7)], level=0.95).mean < math.inf


def record(name, gain):
    rng = np.random.default_rng(seed_of(f"changing level, {name}"))
    x = N * math.sqrt(RATE) * rng.standard_normal(SAMPLES) * gain
    return Record.from_arrays(rate=RATE, gyro_x=x, unit={"gyro": "rad/s"})


HALVES = np.repeat([0.9, 1.1], SAMPLES // 2)


def test_interval_covariance_and_range_are_those_of_a_process():
    analysis = analyze(record("halves", HALVES), threads=1)
    fitted = analysis["gyro_x"]
    walk = fitted["random_walk"]
    (adjustment,) = (step for step in fitted.adjustments if step.cause == "changing_level")
    (change,) = adjustment.changes
    assert walk.low < 0.9 * N < 1.1 * N < walk.high
    assert change.before.low > 0.95 * walk.value
    assert change.scale == pytest.approx((walk.high - walk.low) / change.before.width)
    error = math.sqrt(fitted.covariance.variance_of(Parameter("random_walk")))
    assert 0.5 < error / ((walk.high - walk.low) / 2 / 1.96) < 1.2
    (finding,) = (f for f in analysis.findings if f.code == "changing_level")
    details = finding.details
    assert isinstance(details, ChangingLevel)
    assert details.lowest == pytest.approx(0.9 * N, rel=0.03)
    assert details.highest == pytest.approx(1.1 * N, rel=0.03)
    assert details.next_lowest < walk.low < walk.high < details.next_highest
    assert finding.severity == "info"
    assert fitted.trust == "partial"  # for the finding `non_stationary`
    assert Analysis.from_json(analysis.to_json()).findings == analysis.findings


def test_the_level_of_the_interval_holds():
    widths = []
    for level in (0.68, 0.95):
        walk = fit_channel(record("halves", HALVES), "gyro_x", level=level)["random_walk"]
        widths.append(math.log(walk.high / walk.low))
    assert 2 < widths[1] / widths[0] < 4


def test_steady_noise_keeps_its_interval():
    for k in range(4):
        fitted = fit_channel(record(f"steady {k}", 1.0), "gyro_x")
        assert fitted.adjustments == ()
        walk = fitted["random_walk"]
        assert math.log(walk.high / walk.low) / 2 < 0.02


def test_missing_samples():
    gain = HALVES.copy()
    gain[SAMPLES // 8 : SAMPLES // 4 + SAMPLES // 16] = np.nan
    walk = fit_channel(record("gap", gain), "gyro_x")["random_walk"]
    assert walk.low < 0.9 * N < 1.1 * N < walk.high


def test_halves_of_a_real_accelerometer_agree(field_data):
    """ADIS16405: halves of the record and of its halves differed by 3.2 standard errors (rms), the worst by 8."""
    real = read(field_data / "adis16405_static.csv.gz", rate=100)
    stream, n = real.stream_of("accel_x"), 1_000_000
    walks = {}
    for parts in (2, 4):
        for k in range(parts):
            part = slice(k * n // parts, (k + 1) * n // parts)
            for channel in stream.channels:
                axis = Record.from_arrays(rate=100, unit={"accel": "m/s^2"}, **{channel: stream.column(channel)[part]})
                walks[parts, k, channel] = fit_channel(axis, channel)["random_walk"]
    deviates = []
    for channel in stream.channels:
        for parts, k in ((2, 0), (4, 0), (4, 2)):
            lower, upper = sorted((walks[parts, k, channel], walks[parts, k + 1, channel]), key=lambda walk: walk.value)
            sides = math.log(lower.high / lower.value), math.log(upper.value / upper.low)
            deviates.append(1.96 * math.log(upper.value / lower.value) / math.hypot(*sides))
    assert math.sqrt(np.mean(np.square(deviates))) < 1.1
    assert max(deviates) < 2.5
