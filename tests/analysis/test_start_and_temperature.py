"""Results keep when the record started and how warm it was, if the log shows it."""

import numpy as np
import pytest

import sigmatau as st
from known import seed_of

N = 2000


def write(path, stamps, temperature=None, *, time="time"):
    rng = np.random.default_rng(seed_of("start of a record"))
    rates = 1e-4 * rng.standard_normal(N)
    head = f"{time},gyro_x [rad/s]" + (",temperature [degC]" if temperature is not None else "")
    rows = [f"{stamp},{rate:.8g}" for stamp, rate in zip(stamps, rates, strict=True)]
    if temperature is not None:
        rows = [f"{row},{degrees:.6g}" for row, degrees in zip(rows, temperature, strict=True)]
    path.write_text("\n".join([head, *rows, ""]))
    return path


DAY = np.datetime64("2026-05-07T09:30:00.250", "ms")
SECONDS = 1778146200.25  # of the same time from 1970
STAMPS = {
    "dates": [str(DAY + np.timedelta64(100 * k, "ms")) for k in range(N)],
    "seconds from 1970": [f"{SECONDS + 0.1 * k:.3f}" for k in range(N)],
    "nanoseconds from 1970": [f"{round(SECONDS * 1e9) + k * 100_000_000}" for k in range(N)],
}


@pytest.mark.parametrize("stamps", STAMPS)
def test_start(stamps, tmp_path):
    analysis = st.analyze(write(tmp_path / "x.csv", STAMPS[stamps]))
    assert analysis.source.started == "2026-05-07T09:30:00"
    assert st.Analysis.from_json(analysis.to_json()).source.started == analysis.source.started


@pytest.mark.parametrize("first", [0.0, 1.46e9])
def test_a_clock_from_boot_or_of_gps_has_no_date(first, tmp_path):
    """Seconds of GPS count from 1980: read from 1970 they would be ten years ago."""
    analysis = st.analyze(write(tmp_path / "x.csv", [f"{first + 0.1 * k:.1f}" for k in range(N)], time="time [s]"))
    assert analysis.source.started is None


def test_temperature(tmp_path):
    degrees = np.linspace(24.0, 26.0, N)
    analysis = st.analyze(write(tmp_path / "x.csv", STAMPS["dates"], degrees))
    temperature = st.Analysis.from_json(analysis.to_json()).source.temperature
    assert (temperature.mean, temperature.low, temperature.high) == pytest.approx((25.0, 24.0, 26.0))
    assert st.analyze(write(tmp_path / "y.csv", STAMPS["dates"])).source.temperature is None
