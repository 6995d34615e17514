"""inspect finds what shows only against a fit, as analyze does, and says when it has not looked."""

import numpy as np
import pytest

from known import seed_of
from sigmatau import analyze, inspect, read
from sigmatau.quality import inspection

RATE, N = 50.0, 60_000


def log(path, gyro, temperature=None):
    table = [np.arange(len(gyro)) / RATE, gyro]
    names = ["time [s]", "gyro_x [rad/s]"]
    if temperature is not None:
        table.append(temperature)
        names.append("temperature [degC]")
    np.savetxt(path, np.column_stack(table), delimiter=",", header=",".join(names), comments="", fmt="%.9g")
    return path


@pytest.fixture(scope="module")
def white():
    return 1e-3 * np.random.default_rng(seed_of("drifts")).standard_normal(N)


@pytest.fixture
def faulty(white, tmp_path):
    """A log by the code of the finding that it has to show."""
    t = np.arange(N) / RATE

    def made(code):
        if code == "warm_up":
            return log(tmp_path / "a.csv", white + 2e-3 * np.exp(-t / 120))
        if code == "temperature_drift":
            degrees = 25 + 3 * np.sin(2 * np.pi * t / 500)
            return log(tmp_path / "b.csv", white + 3e-4 * (degrees - 25), degrees)
        return log(tmp_path / "c.csv", np.where(t < 600, white, 1.5 * white))

    return made


@pytest.mark.parametrize(
    ("code", "severity"), [("warm_up", "info"), ("temperature_drift", "info"), ("non_stationary", "warning")]
)
def test_inspect_finds_it_as_analyze_does(faulty, code, severity):
    path = faulty(code)
    found = [f for f in inspect(path).findings if f.code == code]
    assert found == [f for f in analyze(read(path)).findings if f.code == code]
    assert [f.severity for f in found] == [severity]


def test_nothing_is_found_in_white_noise(white, tmp_path):
    assert inspect(log(tmp_path / "white.csv", white)).findings == ()


def test_of_a_long_record_it_is_said_what_was_not_looked_for(faulty, monkeypatch):
    monkeypatch.setattr(inspection, "FITTED", N - 1)
    (said,) = [
        f for f in inspect(faulty("non_stationary")).findings if f.code in ("non_stationary", "checked_without_fit")
    ]
    assert said.code == "checked_without_fit"
    assert said.details.samples == N


def test_gaps_are_told_with_their_times_and_lengths(white, tmp_path):
    """One of 60 s, and one of two samples: both with the time in the record; and rows without numbers as a stretch."""
    path = log(tmp_path / "gaps.csv", white)
    lines = path.read_text().splitlines(keepends=True)
    kept = lines[: 1 + 20_000] + lines[1 + 23_000 : 1 + 50_000] + lines[1 + 50_002 :]
    path.write_text("".join(kept))
    (said,) = [f for f in read(path).findings if f.code == "gaps"]
    assert [gap.samples for gap in said.details.longest] == [3000, 2]
    assert said.details.longest[0].place == "line 20002"
    assert said.spans == (pytest.approx((400.0, 460.0)), pytest.approx((1000.0, 1000.04)))
    empty = log(tmp_path / "empty.csv", np.where((np.arange(N) >= 20_000) & (np.arange(N) < 23_000), np.nan, white))
    (said,) = [f for f in read(empty).findings if f.code == "missing_values"]
    assert (said.details.place, said.details.runs, said.details.longest) == ("line 20002", 1, 3000)
    x = white.copy()
    x[20_000:23_000] = x[[100, 40_000]] = np.nan
    (said,) = [f for f in read(log(tmp_path / "several.csv", x)).findings if f.code == "missing_values"]
    assert (said.details.longest_place, said.details.runs, said.details.longest) == ("line 20002", 3, 3000)
