"""Time stamps out of order, twice, wrong or missing: rows are put right or left out, and that is said."""

import contextlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from stamping import codes, ordered, record_of

from known import seed_of
from sigmatau.errors import DataError, NonFiniteError, OptionError
from sigmatau.findings.stamps import BadStamps
from sigmatau.io.read import read


class TestOrder:
    def test_backwards_and_standing_still(self):
        with pytest.raises(DataError, match=r"line 4: time goes backwards in column 't', from 2\.0 to 1\.5; sort"):
            ordered([0, 1.0, 2.0, 1.5, 3.0])
        with pytest.raises(DataError, match="1 times more after it"):
            ordered([0, 1.0, 0.5, 1.5, 1.0])
        with pytest.raises(DataError, match=r"all stamps in column 't' are 5"):
            ordered([5, 5, 5])
        extremes = ordered([np.iinfo(np.int64).min + 1, np.iinfo(np.int64).max])
        assert extremes.intervals[0] > 1e19  # and does not wrap

    def test_a_clock_that_was_set_back(self):
        t = np.arange(5000) / 100.0
        t[3000:] -= 1.0
        with pytest.raises(DataError, match=r"line 3001: time goes backwards .* from 29\.99 to 29\.0"):
            ordered(t)

    def test_late_rows_are_put_in_order(self):
        t = np.arange(5000) / 100.0
        x = np.arange(5000.0)
        at = np.arange(5000)
        at[[1000, 1001]] = at[[1001, 1000]]
        at[2000:2012] = np.r_[2004:2012, 2000:2004]  # a packet of four after its successors
        record = record_of(t[at], x[at])
        np.testing.assert_array_equal(record.streams[0].column("gyro_x"), x)
        (finding,) = record.findings
        assert (finding.code, finding.severity, finding.size) == ("bad_stamps", "warning", 5)
        assert finding.details == BadStamps(what="late", rows=5000, place="row 1001")

    def test_a_stamp_that_is_wrong_leaves_its_place_empty(self):
        for wrong in (1e6, -5.0, 30.004, 12.304):  # the last falls between two others
            t = np.arange(5000) / 100.0
            t[1234] = wrong
            record = record_of(t, np.arange(5000.0))
            assert codes(record) == ["bad_stamps", "gaps"], wrong
            assert record.findings[0].details.place in ("row 1234", "row 1235")
            column = record.streams[0].column("gyro_x")
            assert np.flatnonzero(np.isnan(column)).tolist() == [1234]
            np.testing.assert_array_equal(np.delete(column, 1234), np.delete(np.arange(5000.0), 1234))

    def test_many_rows_out_of_order_are_refused(self):
        rng = np.random.default_rng(seed_of("shuffled"))
        with pytest.raises(DataError, match="time goes backwards"):
            ordered(rng.permutation(1000) / 100.0)

    @pytest.mark.parametrize(("block", "sensors", "offset"), [(5, 2, 0.5), (10, 3, 0.0), (32, 2, 0.0), (10, 2, 0.5)])
    def test_blocks_of_several_sensors_are_never_read_without_their_stamps(self, block, sensors, offset):
        of_blocks = np.arange(960).reshape(-1, 1, block) + offset * np.arange(sensors)[:, None] / sensors
        with pytest.raises(DataError, match=r"blocks of rows have the same times.*Sort the rows") as error:
            ordered(of_blocks.ravel() / 100.0)
        assert "none" not in str(error.value)

    def test_a_clock_that_is_set_back_now_and_then_is_of_one_sensor(self):
        t = np.arange(5000) / 100.0 - 0.3 * (np.arange(5000) // 1000)
        with pytest.raises(DataError, match=r"ignore the stamps with --channels time=none"):
            ordered(t)

    def test_rows_without_a_stamp(self):
        t = np.arange(2000) / 100.0
        t[[50, 700]] = np.nan
        record = record_of(t, np.arange(2000.0))
        assert codes(record) == ["bad_stamps", "gaps"]
        missing = record.findings[0]
        assert (missing.size, missing.details.rows, missing.details.place) == (2, 2000, "row 50")
        assert np.flatnonzero(record.streams[0].mask[:, 0]).tolist() == [50, 700]
        t[:1200] = np.nan
        with pytest.raises(NonFiniteError, match="no time stamp in 1200 of 2000 rows"):
            record_of(t)


class TestDuplicates:
    def test_every_sample_twice(self):
        rng = np.random.default_rng(seed_of("twice"))
        x = rng.normal(size=5000)
        record = record_of(np.repeat(np.arange(5000) / 100.0, 2), np.repeat(x, 2))
        np.testing.assert_array_equal(record.streams[0].column("gyro_x"), x)
        assert record.streams[0].grid.rate == pytest.approx(100.0, rel=1e-12)
        (finding,) = record.findings
        assert (finding.code, finding.severity, finding.size) == ("bad_stamps", "warning", 5000)
        assert finding.details.what == "repeated"

    def test_one_stamp_twice_with_other_samples(self):
        t = np.arange(5000) / 100.0
        t = np.insert(t, 1234, t[1234])
        x = np.random.default_rng(seed_of("other samples")).normal(size=5001)
        record = record_of(t, x)
        assert codes(record) == ["bad_stamps"]
        np.testing.assert_array_equal(record.streams[0].column("gyro_x"), np.delete(x, 1235))


anything = hnp.arrays(
    np.float64,
    st.integers(4, 60),
    elements=st.floats(-1e6, 1e6)
    | st.floats(-1e30, 1e30)
    | st.floats(allow_infinity=False).map(float)
    | st.integers(0, 50).map(float),
)
growing = anything.map(lambda t: np.sort(np.abs(t)))


def test_a_stamp_beyond_all_others_makes_no_grid_up_to_it():
    """2⁵² of the shortest intervals from the rest, where places can no longer be counted one by one."""
    t = np.cumsum(
        [0, 0, 2e-5, 2e-5, 1, 1, 1, 1, 1, 8, 13, 15, 30, 122, 824683, 951259, 1e6, 1e6, 1e6, 1e6, 90066216413.0]
    )
    with contextlib.suppress(DataError, OptionError):
        assert record_of(t, np.arange(21.0)).streams[0].grid.n < 1000


@settings(max_examples=60, deadline=None)
@given(anything | growing | growing.map(lambda t: np.cumsum(np.clip(t, 0, 1e12))), st.booleans())
def test_any_stamps_make_a_record_or_an_error_of_ours(t, with_rate):
    """And every sample that is not said to be left out is in the record, in order, once."""
    x = np.arange(len(t)) + 1.0
    try:
        record = record_of(t, x, **({"rate": 10.0} if with_rate else {}))
    except (DataError, OptionError):
        return
    kept = record.streams[0].column("gyro_x")
    kept = kept[~np.isnan(kept)]
    bad = [f for f in record.findings if f.code == "bad_stamps"]
    left_out = sum(int(f.size) for f in bad if f.details.what != "late")
    cut = next((f for f in record.findings if f.code == "long_pauses"), None)
    if cut is not None:
        left_out += cut.details.total - cut.details.used
    assert len(kept) == len(t) - left_out
    assert len(set(kept.tolist())) == len(kept)
    assert set(kept.tolist()) <= set(x.tolist())
    if "late" not in [f.details.what for f in bad]:
        assert (np.diff(kept) > 0).all()


def test_blocks_that_share_their_times_are_several_sensors_without_stamps_too(tmp_path):
    """FIFO blocks of two sensors; a clock that begins again is one, and a statement of a single sensor settles it."""
    path = tmp_path / "log.csv"
    rng = np.random.default_rng(seed_of("blocks that share their times"))
    blocks = np.concatenate([np.tile(np.arange(10 * k, 10 * k + 10) * 0.01, 2) for k in range(60)])
    again = np.tile(np.arange(300) * 0.01, 4)
    for times, refused in ((blocks, True), (again, False), (np.arange(1200) * 0.01, False)):
        columns = np.column_stack([times, rng.normal(0, 0.01, (len(times), 3))])
        names = "time [s],gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s]"
        np.savetxt(path, columns, delimiter=",", fmt="%.6f", header=names, comments="")
        if refused:
            with pytest.raises(OptionError, match=r"blocks of rows have the same times in column 'time \[s\]'"):
                read(path, channels={"time": "none"}, rate=100)
        record = read(path, channels={"time": "none"}, rate=100, interleaved=1 if refused else None)
        assert record.streams[0].grid.n == len(times)
