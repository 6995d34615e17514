"""Checks of a record, which have no peer: compared with a Fourier transform, as a measure of the machine."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

import sigmatau
from benches import text
from benches.measure import Settings, turns
from benches.text import Gate
from sigmatau.fitting.likelihood import fit_samples
from sigmatau.io.read.time import stamps
from sigmatau.io.read.time.rows import in_order
from sigmatau.quality.samples.check import check as check_samples
from sigmatau.spectrum.estimate import psd


def measure(settings: Settings) -> dict[str, Any]:
    """Time of each check on six clean axes, of all checks together, and of three kinds of time stamps."""
    n, n_stamps = settings.samples(1e6), settings.samples(1_440_000)
    rng = np.random.default_rng(1)
    gyro, accel = (1e-3 * rng.standard_normal((n, 3)) for _ in range(2))
    record = sigmatau.Record.from_arrays(rate=100, gyro=gyro, accel=accel + np.array([0, 0, 9.8]))

    calls = {
        "samples": lambda: [check_samples(stream) for stream in record.streams],
        "spectra": lambda: [spectrum.binned() for spectrum in psd(record).values()],
        "fits": lambda: [fit_samples(stream, channel) for stream in record.streams for channel in stream.channels],
        "all checks: `sigmatau.check`": lambda: sigmatau.check(record),
    }
    times = {
        "even": np.arange(n_stamps) / 400,
        "integers": 1_403_636_579_758_555_393 + 2_500_000 * np.arange(n_stamps),
        "jitter": np.arange(n_stamps) / 400 + rng.normal(0, 1e-5, n_stamps),
    }
    rows = {kind: in_order(t, (), _row, "'t'") for kind, t in times.items()}
    checks_of_time: dict[str, Callable[[], Any]] = {
        kind: partial(stamps.fit, rows[kind], 1e-9 if kind == "integers" else 1.0, _row, "'t'") for kind in times
    }
    x = rng.standard_normal(1 << 20)
    calls["transform"] = lambda: np.fft.rfft(x)
    return {
        "samples": n,
        "stamps": n_stamps,
        "checks": turns(calls, settings.rounds),
        "times": turns(checks_of_time, settings.rounds),
    }


def _row(row: int) -> str:
    return f"row {row}"


def write(measured: dict[str, Any]) -> tuple[list[str], list[Gate]]:
    """The section of the page."""
    checks = dict(measured["checks"])
    transform = checks.pop("transform")
    wanted = [*checks.items(), *((f"time stamps, {kind}", spent) for kind, spent in measured["times"].items())]
    rows = [[label, text.seconds(spent), f"{spent / transform:.1f}"] for label, spent in wanted]
    return [
        "## Checks of a record",
        "",
        *text.prose(
            f"Six clean axes of {text.number(measured['samples'])} samples, {text.number(measured['stamps'])} time stamps;",
            f"the last column is relative to a Fourier transform of 2²⁰ numbers, {text.seconds(transform)}.",
            "Other packages have no such checks. `make bench PARTS=checks`.",
        ),
        *text.table(["", "wall time", "transforms"], rows),
    ], []
