"""Stamps whose digits are a clock, and day numbers: read as seconds, and never as another rate."""

import datetime as dt

import numpy as np
import pytest

from known import seed_of
from sigmatau import read
from sigmatau.errors import OptionError
from sigmatau.io.read.time.overflows import read_clock_digits

RATE, N = 100, 3000
UNIT = {"gyro": "rad/s"}


def digits(start, pattern, n=N):
    times = [dt.datetime.fromisoformat(start) + dt.timedelta(seconds=k / RATE) for k in range(n)]
    return [f"{time:{pattern}}.{time.microsecond // 1000:03d}" for time in times]


def write(path, stamps):
    gyro = np.random.default_rng(seed_of("clock digits")).normal(size=(len(stamps), 3)) * 1e-3
    rows = (f"{stamp},{x:.6f},{y:.6f},{z:.6f}\n" for stamp, (x, y, z) in zip(stamps, gyro, strict=True))
    path.write_text("time,gyro_x,gyro_y,gyro_z\n" + "".join(rows))
    return path


@pytest.mark.parametrize(
    ("start", "pattern", "unit"),
    [
        ("2024-03-04 09:51:50", "%H%M%S", {}),
        ("2024-03-04 09:59:50", "%Y%m%d%H%M%S", {"time": "s"}),
        ("2024-02-29 23:59:50", "%H%M%S", {"time": "s"}),
        ("2024-02-29 23:59:50", "%Y%m%d%H%M%S", {}),
    ],
)
def test_a_clock(tmp_path, start, pattern, unit):
    record = read(write(tmp_path / "clock.csv", digits(start, pattern)), unit=UNIT | unit)
    assert record.streams[0].grid.rate == pytest.approx(RATE, rel=1e-4)
    assert record.streams[0].grid.n == N  # no minute has 100 seconds
    assert not {finding.code for finding in record.findings} - {
        "counter_overflows",
        "coarse_stamps",
        "irregular_stamps",
    }


@pytest.mark.parametrize(
    "stamps",
    [
        np.arange(5000) * 0.01,  # seconds within a minute
        np.arange(20_000) * 0.01 + 95000,  # seconds beyond it
        np.append(np.arange(0, 59, 0.01), np.arange(100, 159, 0.01)),  # a pause of 41 s, not at the full minute
        np.arange(100) * 1.0 + 20240230235900.0,  # no date
    ],
)
def test_other_numbers_are_not_a_clock(stamps):
    assert read_clock_digits(stamps) is None


@pytest.mark.parametrize("first", [45355.41, 739315.41])
def test_day_numbers(tmp_path, first):
    path = write(tmp_path / "days.csv", [f"{first + k / RATE / 86400:.10f}" for k in range(N)])
    record = read(path, unit=UNIT)
    assert record.streams[0].grid.rate == pytest.approx(RATE, rel=1e-4)
    assert read(path, unit=UNIT | {"time": "d"}).streams[0].grid.rate == pytest.approx(RATE, rel=1e-4)
    with pytest.raises(OptionError, match=r"give --unit time=d \(100 Hz"):
        read(path, unit=UNIT | {"time": "s"})


def test_days_from_zero_are_asked_for(tmp_path):
    path = write(tmp_path / "days.csv", [f"{k / RATE / 86400:.10f}" for k in range(N)])
    with pytest.raises(OptionError, match=r"as h 2400 Hz, as d 100 Hz\); give --unit time=d, --unit time=h"):
        read(path, unit=UNIT)


def test_a_log_that_begins_again_is_not_read_without_its_stamps(tmp_path):
    path = write(tmp_path / "twice.csv", [f"{k % 1500 / RATE:.2f}" for k in range(N)])
    with pytest.raises(ValueError, match="time begins again") as error:
        read(path, unit=UNIT | {"time": "s"})
    assert "time=none" not in str(error.value)
