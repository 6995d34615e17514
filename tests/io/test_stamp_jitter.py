"""Jitter of time stamps: measured, told, and what it does to increments."""

import numpy as np
import pytest
from stamping import record_of

import sigmatau
from known import seed_of
from sigmatau import allan, fit


class TestJitter:
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
        assert "none on rates" in finding.effect
        assert finding.size == pytest.approx(1e-3, rel=0.05)

    def increments(self, rng, n, sigma, *, own=0.0):
        """Velocity of 9.81 m/s² over intervals that scatter by sigma, and what noise of its own it has."""
        t = np.arange(n + 1) / 100.0 + rng.normal(0, sigma, n + 1)
        angle = rng.normal(0, own, n + 1) if own else np.zeros(n + 1)
        return t[1:], 9.81 * np.diff(t) + np.diff(angle) + rng.normal(0, 1e-7, n)

    def test_the_effect_that_is_stated(self):
        """Q_j = |m| σ_j, and by how much the quantization noise is larger than the sensor's own."""
        rng = np.random.default_rng(seed_of("jitter of increments"))
        sigma, own = 5e-4, 9.81 * 5e-4
        values, stated = [], []
        for _ in range(8):
            t, dv = self.increments(rng, 20_000, sigma, own=own)
            frame = {"t": t, "dvz": dv}
            record = sigmatau.from_frame(
                frame, channels={"time": "t", "accel_z": "dvz"}, unit={"time": "s", "accel": "m/s"}, input="increments"
            )
            (finding,) = [f for f in record.findings if f.code == "jitter"]
            assert (finding.severity, finding.channel) == ("warning", "accel_z")
            assert finding.size == pytest.approx(9.81 * sigma, rel=0.05)
            stated.append(dict(finding.changes)["quantization"])
            values.append(fit(allan(record)["accel_z"])["quantization"].value / own)
        error = np.hypot(np.std(values, ddof=1), np.std(stated, ddof=1)) / len(values) ** 0.5
        assert np.mean(values) == pytest.approx(np.mean(stated), abs=3 * error)
        assert np.mean(stated) == pytest.approx(2**0.5, abs=0.1)

    def test_stamps_that_scatter_beside_samples_that_do_not(self):
        rng = np.random.default_rng(seed_of("jitter of stamps alone"))
        t = np.arange(20_000) / 100.0 + rng.normal(0, 1e-3, 20_000)
        dv = 0.0981 + rng.normal(0, 1e-5, len(t))
        record = sigmatau.from_frame(
            {"t": t, "dvz": dv},
            channels={"time": "t", "accel_z": "dvz"},
            unit={"time": "s", "accel": "m/s"},
            input="increments",
        )
        (finding,) = record.findings
        assert (finding.code, finding.severity) == ("jitter", "info")
        assert "the instants of sampling do not" in finding.effect
