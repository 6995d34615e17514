"""The likelihood of channels with missing samples: every kind of mask, and records at the limits of what can be fitted."""

import numpy as np
import pytest
from scipy.signal import lfilter
from studies.gaps import FILTERS, MASKS, MIXTURES, SETTLING, N, analysed, missing, truth_of
from studies.samples import simulated

from known import seed_of
from sigmatau import Record, analyze
from sigmatau._native.likelihood import summarize, summarize_masked
from sigmatau.fitting.likelihood import fit_samples
from sigmatau.fitting.pass_over import usable

RECORDS = 2
MIXTURES_HERE = ("N B K", "Q N", "N K strong", "K")
KINDS = ("5 % at random", "50 % at random", "20 % in blocks", "50 % in blocks", "every second", "4 gaps of 5 %")


@pytest.mark.parametrize("name", MIXTURES_HERE)
def test_intervals_hold(name):
    """Coverage of all kinds of masks together, the limit 3 standard errors below 94 % (studies/gaps.py has every cell)."""
    rng = np.random.default_rng(seed_of(f"missing samples, {name}"))
    mixture = MIXTURES[name]
    covered = []
    for mask in KINDS:
        for _ in range(RECORDS):
            y = simulated(N, 1.0, dict(mixture.truth), seed=int(rng.integers(1 << 62)))
            terms = dict(analysed(y, missing(*MASKS[mask], N, rng), 1.0).terms)
            for term, value in truth_of(name, mask).items():
                interval = terms[term].profile
                covered.append(interval.high is None or interval.low <= value <= interval.high)
    share = np.mean(covered)
    assert share >= 0.94 - 3 * np.sqrt(0.95 * 0.05 / len(covered))


def test_a_rate_random_walk_does_not_hide_white_noise():
    """Nine of ten records without it have a limit below K/3 (median 0.22 K; before, low frequencies leaked: 3.9 K)."""
    rng = np.random.default_rng(seed_of("limit of the random walk beside a rate random walk"))
    limits = []
    for _ in range(10):
        y = simulated(N, 1.0, {"rate_random_walk": 1.0}, seed=int(rng.integers(1 << 62)))
        limits.append(dict(analysed(y, missing("random", 0.5, N, rng), 1.0).terms)["random_walk"].profile.high)
    assert np.quantile(limits, 0.9, method="higher") < 1 / 3


def test_images_of_low_frequencies_are_no_lines():
    """With every second sample, half the rate shows what the frequency 0 does: before, lines in 55 of 100 records."""
    rng = np.random.default_rng(seed_of("images of low frequencies"))
    for _ in range(8):
        y = simulated(N, 1.0, dict(MIXTURES["N K strong"].truth), seed=int(rng.integers(1 << 62)))
        found = analysed(y, missing("second", 0.5, N, rng), 1.0)
        assert not found.sinusoid
        assert found.verdict != "widened"


def test_flicker_noise_in_front_of_a_mean_stays_in_front():
    """Both models have the same information: before, the noise was behind the mean in one of eight records, and B was 0."""
    rng = np.random.default_rng(seed_of("flicker noise in front of a mean"))
    truth = MIXTURES["N B K"].truth
    for _ in range(12):
        y = simulated(N + SETTLING, 1.0, dict(truth), seed=int(rng.integers(1 << 62)))
        y = np.ascontiguousarray(lfilter(*FILTERS["mean of 8"], y)[SETTLING:])
        found = analysed(y, missing(*MASKS["4 gaps of 5 %"], N, rng), 1.0)
        assert found.response.order == 8
        assert not found.response.of_white
        assert dict(found.terms)["bias_instability"].profile.high > 0.8 * truth["bias_instability"]


def test_what_a_mask_spreads_is_no_line_behind_a_mean():
    """Before, the lowest densities were lines in half of the records."""
    rng = np.random.default_rng(seed_of("what a mask spreads behind a mean"))
    for _ in range(6):
        y = simulated(N + SETTLING, 1.0, dict(MIXTURES["N B K"].truth), seed=int(rng.integers(1 << 62)))
        y = np.ascontiguousarray(lfilter(*FILTERS["mean of 8"], y)[SETTLING:])
        assert not analysed(y, missing(*MASKS["5 % at random"], N, rng), 1.0).sinusoid


def recorded(case, absent, **coefficients):
    rng = np.random.default_rng(seed_of(case))
    y = simulated(len(absent), 0.01, coefficients, seed=int(rng.integers(1 << 62)))
    y[absent] = np.nan
    return Record.from_arrays(rate=100.0, gyro_x=y)


def fitted(record):
    return analyze(record).fits["gyro_x"]


class TestLimits:
    def test_all_but_600_samples(self):
        n = 20_000
        rng = np.random.default_rng(seed_of("all but 600 samples"))
        absent = np.ones(n, dtype=bool)
        absent[rng.choice(n, 600, replace=False)] = False
        record = recorded("all but 600 samples", absent, random_walk=1e-3)
        assert usable(record.streams[0], "gyro_x")
        result = fit_samples(record.streams[0], "gyro_x")
        term = result["random_walk"]
        # N² of 600 white samples: 2/600, and the interval not wider than twice that.
        assert term.low <= 1e-3 <= term.high
        assert term.high - term.low < 2 * 2 * 1.96 * 1e-3 / np.sqrt(2 * 600)

    def test_600_samples_in_a_row(self):
        """Missing samples before the first and after the last one are no gap."""
        absent = np.ones(50_000, dtype=bool)
        absent[20_000:20_600] = False
        record = recorded("600 samples in a row", absent, random_walk=1e-3)
        stream = record.streams[0]
        alone = Record.from_arrays(rate=100.0, gyro_x=stream.column("gyro_x")[20_000:20_600]).streams[0]
        assert usable(stream, "gyro_x")
        a, b = (fit_samples(s, "gyro_x")["random_walk"] for s in (stream, alone))
        assert (a.value, a.low, a.high) == (b.value, b.low, b.high)

    def test_too_few_samples_and_too_few_places(self):
        absent = np.ones(50_000, dtype=bool)
        absent[::100] = False
        assert not usable(recorded("too few", absent, random_walk=1e-3).streams[0], "gyro_x")
        absent = np.ones(2_000_000, dtype=bool)
        absent[:400] = absent[-400:] = False
        assert not usable(recorded("too few places", absent, random_walk=1e-3).streams[0], "gyro_x")

    def test_one_long_gap(self):
        absent = np.zeros(40_000, dtype=bool)
        absent[8_000:32_000] = True
        record = recorded("one long gap", absent, random_walk=1e-3, rate_random_walk=1e-3)
        result = fitted(record)
        assert result.method == "likelihood"
        for term in ("random_walk", "rate_random_walk"):
            assert result[term].low <= 1e-3 <= result[term].high

    def test_nothing_but_singles(self):
        """Without neighbours the random walk stands for quantization noise as well."""
        absent = np.ones(60_000, dtype=bool)
        absent[::3] = False
        steps, white = 2e-5, 1e-3
        result = fitted(recorded("nothing but singles", absent, random_walk=white, quantization=steps))
        assert result.method == "likelihood"
        assert not result["quantization"].observed
        assert result["quantization"].upper_limit is None
        both = np.sqrt(white**2 + 2 * steps**2 * 100)
        assert result["random_walk"].low <= both <= result["random_walk"].high


def test_a_record_without_missing_samples_has_no_mask():
    """A complete channel has the same digits whatever is missing in others; with an empty mask, about the same result."""
    y = simulated(2**14, 1.0, {"random_walk": 1.0}, seed=seed_of("complete"))
    record = Record.from_arrays(rate=1.0, gyro_x=y)
    with_column = Record.from_arrays(rate=1.0, gyro_x=y, gyro_y=np.where(np.arange(2**14) == 77, np.nan, y))
    results = [fit_samples(r.streams[0], "gyro_x") for r in (record, with_column)]
    assert results[0]["random_walk"].value == results[1]["random_walk"].value
    plain = dict(summarize([y], samples=len(y), tau0=1.0).fit().model)
    assert results[0]["random_walk"].value == plain["random_walk"]
    # Both ways describe the same record.
    masked = summarize_masked(lambda: [y], present=np.ones(len(y), dtype=bool), tau0=1.0).fit()
    assert dict(masked.model)["random_walk"] == pytest.approx(plain["random_walk"], rel=0.005)
