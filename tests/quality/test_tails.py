"""Tails of the noise: spikes that do not stand out from it, the interval of the random walk, and its level."""

import math

import numpy as np
import pytest

from known import seed_of
from sigmatau import Record, analyze, fit_channel
from sigmatau.quality.samples.tails import read_small_spikes, read_tail

RATE, N = 50.0, 60_000
DENSITY = 1 / math.sqrt(RATE)  # of white noise with the variance 1 [1/√Hz]


def student(df, name, n=N):
    """White noise of variance 1 with the tails of Student's t."""
    return np.random.default_rng(seed_of(name)).standard_t(df, n) / math.sqrt(df / (df - 2))


def normal(name, n=N):
    return np.random.default_rng(seed_of(name)).standard_normal(n)


def analysed(x, **options):
    return analyze(Record.from_arrays(rate=RATE, signal=x), **options)


def spikes_of(analysis):
    (finding,) = (finding for finding in analysis.findings if finding.code == "spikes")
    return finding


class TestReading:
    def test_factor_is_that_of_the_variances(self):
        """A tail cut at a size: the factor gives back the standard deviation of all samples."""
        x = student(3, "tail that is cut", 96_000)
        cut = np.abs(x) > 6
        read = read_tail(np.where(cut, np.nan, x), x[cut])
        assert read.factor == pytest.approx(x.std() / x[~cut].std(), rel=1e-3)
        kurtosis = np.mean(x**4) / np.var(x) ** 2 - 3
        # The tail through half of the spikes reaches one sample of the record at m (k/2)^(1/3).
        reach = np.median(np.abs(x[cut])) * (np.count_nonzero(cut) / 2) ** (1 / 3)
        beyond = 3 * reach**2 / np.var(x) / x.size
        assert read.error == pytest.approx(math.hypot(math.sqrt(kurtosis / x.size), beyond) / 2, rel=0.02)

    def test_slow_noise_is_no_part_of_it(self):
        x, spikes = normal("slow"), np.full(60, 5.0)
        slow = 30 * np.sin(np.arange(N) * 1e-4)
        assert read_tail(x + slow, spikes).factor == pytest.approx(read_tail(x, spikes).factor, rel=1e-4)

    def test_spikes_beyond_a_gap_are_not_of_the_tail(self):
        x = student(4, "tail and spikes")
        cut = np.abs(x) > 6
        clean = np.where(cut, np.nan, x)
        alone = read_tail(clean, x[cut])
        assert alone.factor > 1.005
        assert read_tail(clean, np.concatenate((x[cut], np.full(60, 300.0)))) == alone

    def test_without_spikes_or_noise_there_is_no_tail(self):
        assert read_tail(normal("none"), np.empty(0)).factor == 1
        assert read_tail(np.zeros(N), np.array([5.0])).factor == 1
        assert read_tail(np.full(N, np.nan), np.array([5.0])).factor == 1
        assert read_tail(normal("none"), np.zeros(1)).factor == 1

    def test_small_spikes_are_counted(self):
        x = normal("small spikes")
        assert read_small_spikes(x) == 1
        x[100:N:1500] += 6.5
        assert read_small_spikes(x) == pytest.approx(math.sqrt(1 + 6.5**2 / 1500), rel=1e-3)

    def test_noise_that_swells_has_no_small_spikes(self):
        swells = np.where(np.arange(N) % 1000 < 40, 10, 1)
        assert read_small_spikes(normal("swells") * swells) == 1
        assert read_small_spikes(np.full(N, np.nan)) == 1


@pytest.mark.parametrize("df", [3, 5])
def test_interval_holds_the_density_of_heavy_tails(df):
    """Of 5 records, 95 % less three standard errors. The interval without the spikes never covers with 3 degrees."""
    covered = 0
    for k in range(5):
        x = student(df, f"covered t{df} {k}")
        analysis = analysed(x)
        walk = analysis["signal"]["random_walk"]
        covered += walk.low <= DENSITY <= walk.high
        finding = spikes_of(analysis)
        assert finding.severity == "warning"
        assert finding.details.tail_factor > 1
        assert dict(finding.factors)["random_walk"] == pytest.approx(1 / finding.details.tail_factor)
    assert covered >= 5 * 0.95 - 3 * math.sqrt(5 * 0.95 * 0.05)


def test_both_readings_are_in_the_interval():
    x = student(3, "both readings")
    without, with_all = analysed(x), analysed(x, keep=("spikes",))
    walk, all_walk = without["signal"]["random_walk"], with_all["signal"]["random_walk"]
    assert walk.value * spikes_of(without).details.tail_factor == pytest.approx(all_walk.value, rel=3e-3)
    assert walk.low < walk.value < all_walk.value < walk.high
    assert spikes_of(with_all).factors == ()


def test_separate_spikes_change_nothing():
    x = normal("separate")
    before = analysed(x)["signal"]["random_walk"]
    x[500:N:6000] += 30
    analysis = analysed(x)
    walk, details = analysis["signal"]["random_walk"], spikes_of(analysis).details
    assert (details.tail_factor, details.small_factor, analysis["signal"].trust) == (1, 1, "good")
    assert walk.high - walk.low == pytest.approx(before.high - before.low, rel=0.05)


@pytest.mark.parametrize("level", [0.683, 0.95])
def test_level_holds_where_tails_are_heavy(level):
    """Of 60 records with all samples, whose tail has a fourth moment: the level, within three standard errors of 60."""
    covered = 0
    for k in range(60):
        record = Record.from_arrays(rate=RATE, signal=student(7, f"level {k}", 4000))
        walk = fit_channel(record, "signal", terms=["random_walk"], processes=[], level=level)["random_walk"]
        covered += walk.low <= DENSITY <= walk.high
    assert covered >= 60 * level - 3 * math.sqrt(60 * level * (1 - level))
    if level < 0.95:
        assert covered <= 60 * level + 3 * math.sqrt(60 * level * (1 - level))
