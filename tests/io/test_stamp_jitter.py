"""Jitter of time stamps: measured, told, and what it does to increments."""

import numpy as np
import pytest
from stamping import codes, found, record_of

import sigmatau
from known import seed_of
from sigmatau import allan, fit


class TestJitter:
    @pytest.mark.parametrize("share", [0.1, 0.15, 0.2])
    def test_no_row_is_lost_or_moved(self, share):
        """At 0.2 of an interval twelve of 60,000 stamps are behind the next, one in eighty nearer to another place."""
        rng = np.random.default_rng(seed_of(f"honest jitter {share}"))
        for _ in range(2):
            x = np.arange(60_000.0)
            record = record_of((x + rng.normal(0, share, len(x))) / 100, x)
            assert codes(record) == ["jitter"]
            np.testing.assert_array_equal(record.streams[0].column("gyro_x"), x)
            assert record.streams[0].grid.rate == pytest.approx(100, rel=4 * share * 12**0.5 / len(x) ** 1.5)

    @pytest.mark.parametrize("share", [0.25, 0.3, 0.35])
    def test_large_jitter_is_no_bunch(self, share):
        """Places can no longer be told one by one; that none is empty can."""
        rng = np.random.default_rng(seed_of(f"large jitter {share}"))
        for n in (1000, 60_000):
            for _ in range(2):
                record = record_of((np.arange(n) + rng.normal(0, share, n)) / 100)
                assert codes(record) == ["jitter"]
                grid = record.streams[0].grid
                assert grid.n == n
                # Put in order, stamps scatter a little less: 1.5 % at 0.35.
                assert grid.jitter == pytest.approx(share / 100, rel=0.03 + 4 / (2 * min(n, 512 * 64)) ** 0.5)

    @pytest.mark.parametrize("size", [2, 3, 4, 10])
    def test_bunches_are_no_jitter(self, size):
        rng = np.random.default_rng(seed_of(f"bunches and no jitter {size}"))
        k = np.arange(12_000)
        t = (k // size * size + size - 1 + 0.02 * (k % size) + rng.normal(0, 1e-3, len(k))) / 100
        assert "host_stamps" in codes(found(np.sort(t)))

    def test_large_jitter_with_a_lost_sample_is_not_passed_over(self):
        rng = np.random.default_rng(seed_of("large jitter, one lost"))
        for _ in range(8):
            k = np.delete(np.arange(20_000), rng.integers(1000, 19_000))
            assert "host_stamps" in codes(found((k + rng.normal(0, 0.3, len(k))) / 100))

    def test_beside_a_loss_few_are_moved(self):
        """Only a stamp beside a hole, nearer to it than to its own place, cannot be told from one that belongs there."""
        share, loss = 0.2, 0.01
        rng = np.random.default_rng(seed_of("jitter and loss"))
        k = np.flatnonzero(rng.random(60_000) >= loss)
        one = found((k + rng.normal(0, share, len(k))) / 100)
        assert one.n == k[-1] - k[0] + 1
        moved = np.flatnonzero(one.places != k - k[0])
        expected = 2 * loss * 0.00621 * len(k)  # two rows beside each hole, each beyond half an interval on that side
        assert len(moved) <= 2 * expected + 3 * (2 * expected) ** 0.5  # and those that are swapped there
        holes = np.flatnonzero(np.diff(k) > 1)
        assert all(np.abs(holes - m).min() <= 5 for m in moved)

    def test_it_is_measured(self):
        rng = np.random.default_rng(seed_of("jitter"))
        for share in (0.01, 0.1):
            t = np.arange(200_000) / 100.0 + rng.normal(0, share / 100, 200_000)
            grid = record_of(t).streams[0].grid
            # 512 blocks of 64, two of each for its line: relative error 1 / √(2·512·62)
            assert grid.jitter == pytest.approx(share / 100, rel=4 / (2 * 512 * 62) ** 0.5)

    def test_it_is_told_and_is_nothing_for_rates(self):
        rng = np.random.default_rng(seed_of("jitter of rates"))
        t = np.arange(20_000) / 100.0 + rng.normal(0, 1e-3, 20_000)
        record = sigmatau.from_frame(
            {"t": t, "az": 9.81 + rng.normal(size=len(t)), "ax": t, "ay": t}, unit={"time": "s", "accel": "m/s^2"}
        )
        (finding,) = record.findings
        assert (finding.code, finding.severity, finding.unit) == ("jitter", "info", "s")
        assert (finding.channels, finding.details.added) == ((), None)
        assert finding.size == pytest.approx(1e-3, rel=0.05)

    def test_what_it_adds_to_increments(self):
        """Q = |m| σ: what a fit finds, if the velocity is 9.81 m/s² over intervals that scatter."""
        rng = np.random.default_rng(seed_of("jitter of increments"))
        for sigma in (5e-4, 3e-3):
            t = np.arange(20_001) / 100.0 + rng.normal(0, sigma, 20_001)
            dv = 9.81 * np.diff(t) + rng.normal(0, 1e-7, 20_000)
            frame, channels = (
                {"t": t[1:], "dvz": dv, "dvx": 0.01 * dv},
                {"time": "t", "accel_x": "dvx", "accel_z": "dvz"},
            )
            unit = {"time": "s", "accel": "m/s"}
            record = sigmatau.from_frame(frame, channels=channels, unit=unit, input="increments")
            (finding,) = [f for f in record.findings if f.code == "jitter"]
            assert (finding.severity, finding.details.unit) == ("info", "m/s")
            assert finding.details.added == pytest.approx(9.81 * sigma, rel=0.05)
            fitted = fit(allan(record)["accel_z"])["quantization"].value
            assert fitted == pytest.approx(finding.details.added, rel=0.05)
