"""Time stamps of text tables: lines, units, ticks, nanoseconds, a rate that is given."""

import numpy as np
import pytest
from stamping import codes

from sigmatau.errors import DataError
from sigmatau.io.read import read
from sigmatau.record.sampling import RateSource


def log(tmp_path, header, times):
    path = tmp_path / "log.csv"
    lines = [f"{t},{i % 7}" for i, t in enumerate(times)]
    path.write_text(f"{header},wx [rad/s]\n" + "\n".join(lines) + "\n")
    return path


class TestText:
    def test_lines_are_those_of_the_file(self, saved):
        path = saved("t [s],wx [rad/s]\n0,1\n\n# note\n1,1\n2,1\n\n1.5,1\n3,1\n")
        with pytest.raises(DataError, match=r"log\.csv, line 8: time goes backwards .* from 2\.0 to 1\.5"):
            read(path)
        with pytest.raises(DataError, match="line 8: time goes backwards"):
            read(path, rate=1)

    def test_the_given_rate_is_used_and_a_difference_told(self, tmp_path):
        path = log(tmp_path, "t [s]", np.arange(100) / 50)
        assert read(path, rate=50.04).findings == ()
        record = read(path, rate=54)
        assert record.streams[0].grid.rate == 54
        assert record.streams[0].grid.source == RateSource(kind="given")
        (finding,) = record.findings
        assert finding.code == "rate_mismatch"
        assert (finding.details.used, finding.details.other) == pytest.approx((54.0, 50.0))

    def test_with_a_rate_the_unit_of_time_is_not_needed(self, tmp_path):
        path = log(tmp_path, "t", np.arange(100) / 50)
        record = read(path, rate=50)
        assert record.findings == ()
        assert "time stamps in s by the given rate" in record.provenance.conversions
        assert str(record.streams[0].grid.source) == "given, and time stamps in column 't' agree"
        path = log(tmp_path, "t", np.delete(np.arange(100), [40, 41]))
        record = read(path, rate=100)
        assert any("checked for order and gaps only" in c for c in record.provenance.conversions)
        assert [(f.code, f.spans) for f in record.findings] == [("gaps", (pytest.approx((0.4, 0.42)),))]
        assert record.streams[0].grid.n == 100

    @pytest.mark.parametrize(("unit", "step"), [("s", 1 / 128), ("ms", 7.8125), ("us", 7812.5), ("ns", 7812500)])
    def test_units_of_time(self, tmp_path, unit, step):
        path = log(tmp_path, "t", [repr(i * step) for i in range(100)])
        assert read(path, unit={"time": unit}).streams[0].grid.rate == pytest.approx(128.0, rel=1e-13)

    def test_ticks(self, tmp_path):
        path = log(tmp_path, "t", range(0, 100_000, 10))
        record = read(path, unit={"time": "us"}, scale={"time": 40})  # a tick of 40 µs
        assert record.streams[0].grid.rate == pytest.approx(2500.0, rel=1e-13)

    def test_nanoseconds_in_text_stay_exact(self, tmp_path):
        start = 1_403_636_579_758_555_393
        path = log(tmp_path, "t [ns]", [start + 10_000_000 * k for k in range(100)])
        assert read(path).streams[0].grid.rate == pytest.approx(100, rel=1e-14)
        path = log(tmp_path, "t [ns]", ["" if k == 50 else start + 10_000_000 * k for k in range(100)])
        record = read(path)
        assert record.streams[0].grid.rate == pytest.approx(100, rel=1e-14)
        assert "bad_stamps" in codes(record)
        path = log(tmp_path, "t [ns]", [start, start + 2, start + 1, start + 3])  # the same double, all four
        with pytest.raises(DataError, match=f"line 4: time goes backwards .* from {start + 2} to {start + 1};"):
            read(path)
