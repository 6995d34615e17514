"""Rows lost in a regular pattern, and clocks that look like it."""

import numpy as np
import pytest
from stamping import codes, found, record_of

from known import seed_of

PATTERNS = {
    "every third": [1, 1, 0],
    "every fifth": [1, 1, 1, 1, 0],
    "every tenth": [1] * 9 + [0],
    "two of five": [1, 1, 0, 1, 0],
    "two together of five": [1, 1, 1, 0, 0],
    "two of five, from another row": [1, 0, 1, 0, 1],
}


class TestPatterns:
    @pytest.mark.parametrize("jitter", [0.0, 1e-3])
    @pytest.mark.parametrize("pattern", PATTERNS.values(), ids=PATTERNS)
    def test_rows_lost_in_a_pattern(self, pattern, jitter):
        """The finest grid that the steps fit, not the mean interval: 100 Hz without every fifth row is not 80 Hz."""
        rng = np.random.default_rng(seed_of(f"pattern {pattern} {jitter}"))
        k = np.flatnonzero(np.tile(pattern, 60_000 // len(pattern)))
        one = found(k / 100 + rng.normal(0, 1, len(k)) * jitter)
        assert one.rate == pytest.approx(100.0, rel=1e-6)
        np.testing.assert_array_equal(one.places, k - k[0])
        (finding,) = one.findings
        assert (finding.code, finding.size) == ("gaps", one.n - len(k))

    def test_it_goes_on_to_the_record(self):
        k = np.flatnonzero(np.tile([1, 1, 1, 1, 0], 12_000))
        record = record_of(k / 100, k * 1.0)
        column = record.streams[0].column("gyro_x")
        np.testing.assert_array_equal(column[k], k * 1.0)
        assert np.isnan(np.delete(column, k)).all()
        assert record.streams[0].grid.rate == pytest.approx(100, rel=1e-12)

    @pytest.mark.parametrize("jitter", [0.0, 1e-3])
    def test_every_second_row_cannot_be_told(self, jitter):
        rng = np.random.default_rng(seed_of(f"every second {jitter}"))
        one = found(np.arange(30_000) / 50 + rng.normal(0, 1, 30_000) * jitter)
        assert (one.places, one.findings) == (None, ())
        assert one.rate == pytest.approx(50, rel=1e-6)

    def test_the_user_decides_what_stamps_cannot(self):
        """80 Hz by a clock in steps of 10 ms, and 100 Hz without every fifth row: the same stamps."""
        k = np.flatnonzero(np.tile([1, 1, 1, 1, 0], 12_000))
        even = np.floor(np.arange(48_000) * 1.25 + 1e-9)
        np.testing.assert_array_equal(k, even)
        (finding,) = found(k / 100).findings
        assert finding.details.even_rate == pytest.approx(80.0)
        assert finding.details.period == 4
        one = found(k / 100, rate=80.0)
        assert (one.places, one.findings) == (None, ())
        assert one.rate == pytest.approx(80.0, rel=1e-5)
        one = found(k / 100, rate=100.0)
        assert (one.n, [f.code for f in one.findings]) == (59_999, ["gaps"])
        assert one.findings[0].details.even_rate is None

    def test_a_long_pattern_is_of_a_coarse_clock_unless_the_user_says_otherwise(self):
        k = np.flatnonzero(np.tile([1] * 99 + [0], 600))
        one = found(k / 100)
        assert one.rate == pytest.approx(99, rel=1e-4)
        assert codes(one) == ["coarse_stamps", "rate_not_nominal"]
        details = one.findings[0].details
        assert (details.step, details.period, details.lost) == (pytest.approx(0.01), 100, 1)
        np.testing.assert_array_equal(found(k / 100, rate=100.0).places, k)

    @pytest.mark.parametrize("rate", [833.0, 800.03, 600.03, 512.0, 995.0])
    def test_a_clock_that_beats_with_the_samples_is_no_loss(self, rate):
        one = found(np.floor(np.arange(60_000) / rate * 1e3) / 1e3)
        assert one.places is None
        assert one.rate == pytest.approx(rate, rel=1e-5)


class TestSlower:
    """A log that keeps every k-th sample from some time on."""

    def test_losses_at_random_are_none(self):
        rng = np.random.default_rng(seed_of("losses that are no rate"))
        for share in (0.02, 0.1, 0.3, 0.5):
            for _ in range(10):
                k = np.flatnonzero(rng.random(30_000) > share)
                said = next(f for f in found(k / 100.0).findings if f.code == "gaps")
                assert said.details.even_rate is None
