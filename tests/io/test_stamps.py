"""The rate from time stamps: right for bunched and coarse stamps, unmoved by gaps."""

import numpy as np
import pytest

from sigmatau.errors import DataError
from sigmatau.io import read
from sigmatau.io.read import stamps


def where(row):
    return f"line {row + 1}"


def fit(t, second=1.0):
    return stamps.fit(t, stamps.check_order(t, where, "'t'"), second, where, "'t'")


def test_even_stamps():
    found = fit(np.arange(1000) / 100.0)
    assert found.rate == pytest.approx(100.0, rel=1e-13)
    assert (found.start, found.findings) == (0.0, ())


def test_one_gap_of_a_minute_in_two_hours():
    t = np.arange(720_000) / 100.0
    t[300_000:] += 60.0
    found = fit(t)
    assert found.rate == pytest.approx(100.0, rel=1e-4)
    (finding,) = found.findings
    assert (finding.code, finding.severity) == ("irregular_stamps", "warning")
    assert "1 of 719999 intervals" in finding.message
    assert "60.01 s, ends on line 300001" in finding.message
    assert "0.01 s" in finding.effect
    assert "1 gap left out" in found.source


def test_wrong_stamps_at_the_ends():
    t = 1.7e9 + np.arange(10_000) / 50.0
    t[0] = 0.0  # before the clock was set
    t[-1] += 3600.0
    assert fit(t).rate == pytest.approx(50.0, rel=1e-6)


def test_coarse_stamps_are_not_irregular():
    t = np.floor(np.arange(4000) * 0.25) / 100  # 400 Hz, printed to 0.01 s
    found = fit(t)
    assert found.rate == pytest.approx(400.0, rel=1e-3)  # the last step of the clock: 0.01 s of 10 s
    assert found.findings == ()


def test_bunched_stamps():
    t = np.repeat(np.arange(2000) * 0.04, 4) + np.tile([0, 1e-3, 2e-3, 3e-3], 2000)  # four at once, every 40 ms
    found = fit(t)
    assert found.rate == pytest.approx(100.0, rel=1e-3)  # within one bunch of 2000
    assert found.findings[0].code == "irregular_stamps"


def test_a_lost_sample_is_told():
    t = np.delete(np.arange(1001) / 100.0, 500)
    assert "1 of 999 intervals" in fit(t).findings[0].message


def test_nanoseconds_since_1970_stay_exact():
    start = 1_403_636_579_758_555_393
    t = start + 5_000_000 * np.arange(5000, dtype=np.int64)
    found = fit(t, 1e-9)
    assert found.rate == pytest.approx(200.0, rel=1e-15)
    assert found.start == pytest.approx(0.758555393, abs=1e-12)
    assert found.notes == ("1403636579 s taken off the time stamps",)


def test_two_stamps_that_one_double_cannot_tell_apart():
    t = 1_403_636_579_758_555_393 + np.arange(4, dtype=np.int64)
    assert len(set(t.astype(float))) == 1
    assert stamps.check_order(t, where, "'t'").tolist() == [1.0, 1.0, 1.0]


def test_few_rows():
    assert fit(np.array([0.0, 1.0, 2.0, 3.0])).rate == pytest.approx(1.0)


def test_backwards_and_standing_still():
    with pytest.raises(DataError, match=r"line 4: time goes backwards in column 't', from 2\.0 to 1\.5; sort"):
        stamps.check_order(np.array([0, 1.0, 2.0, 1.5, 3.0]), where, "'t'")
    with pytest.raises(DataError, match="1 times more"):
        stamps.check_order(np.array([0, 1.0, 0.5, 1.5, 1.0]), where, "'t'")
    with pytest.raises(DataError, match=r"all stamps in column 't' are 5"):
        stamps.check_order(np.array([5, 5, 5]), where, "'t'")
    extremes = np.array([np.iinfo(np.int64).min, np.iinfo(np.int64).max])
    assert stamps.check_order(extremes, where, "'t'")[0] > 1e19  # and does not wrap


def log(tmp_path, header, times):
    path = tmp_path / "log.csv"
    lines = [f"{t},{i % 7}" for i, t in enumerate(times)]
    path.write_text(f"{header},wx [rad/s]\n" + "\n".join(lines) + "\n")
    return path


def test_lines_are_those_of_the_file(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("t [s],wx [rad/s]\n0,1\n\n# note\n1,1\n2,1\n\n1.5,1\n3,1\n")
    with pytest.raises(DataError, match=r"log\.csv, line 8: time goes backwards .* from 2\.0 to 1\.5"):
        read(path)
    with pytest.raises(DataError, match="line 8: time goes backwards"):
        read(path, rate=1)


def test_the_given_rate_is_used_and_a_difference_told(tmp_path):
    path = log(tmp_path, "t [s]", np.arange(100) / 50)
    assert read(path, rate=50.04).findings == ()
    record = read(path, rate=100)
    assert record.streams[0].grid.rate == 100
    assert record.streams[0].grid.source == "given"
    (finding,) = record.findings
    assert finding.code == "rate_mismatch"
    assert "100 Hz" in finding.message
    assert "50 Hz" in finding.message


def test_with_a_rate_the_unit_of_time_is_not_needed(tmp_path):
    path = log(tmp_path, "t", np.arange(100) / 50)
    record = read(path, rate=100)
    assert record.findings == ()
    assert any("checked for order only" in c for c in record.provenance.conversions)


@pytest.mark.parametrize(("unit", "step"), [("s", 1 / 128), ("ms", 7.8125), ("us", 7812.5), ("ns", 7812500)])
def test_units_of_time(tmp_path, unit, step):
    path = log(tmp_path, "t", [repr(i * step) for i in range(100)])
    assert read(path, unit={"time": unit}).streams[0].grid.rate == pytest.approx(128.0, rel=1e-13)


def test_ticks(tmp_path):
    path = log(tmp_path, "t", range(0, 1000, 10))
    record = read(path, unit={"time": "us"}, scale={"time": 40})  # a tick of 40 µs
    assert record.streams[0].grid.rate == pytest.approx(2500.0, rel=1e-13)


def test_nanoseconds_in_text_stay_exact(tmp_path):
    start = 1_403_636_579_758_555_393
    path = log(tmp_path, "t [ns]", [start + 10 * k for k in range(100)])
    assert read(path).streams[0].grid.rate == pytest.approx(1e8, rel=1e-14)
    path = log(tmp_path, "t [ns]", [start, start + 2, start + 1, start + 3])  # the same double, all four
    with pytest.raises(DataError, match=f"line 4: time goes backwards .* from {start + 2} to {start + 1};"):
        read(path)


def test_an_implausible_rate_is_told():
    """Seconds in a column that says microseconds."""
    (finding,) = fit(np.arange(1000) / 200.0, second=1e-6).findings
    assert finding.code == "implausible_rate"
    assert "2e+08 Hz" in finding.message


@pytest.mark.parametrize(
    ("stamps_of", "unit"),
    [
        (1_700_000_000_000_000_000 + 5_000_000 * np.arange(100), "ns"),  # our time, 200 Hz; as us it would be 0.2 Hz
        (np.arange(100) * 10.0, "ms"),
        (np.arange(100) / 200.0, "s"),
        (5_000 * np.arange(100), "us"),
    ],
)
def test_the_unit_offered_is_the_likeliest(stamps_of, unit):
    error = stamps.without_unit(stamps_of, np.diff(stamps_of).astype(float), "'t'")
    assert f"say e.g. --unit time={unit}," in str(error)
