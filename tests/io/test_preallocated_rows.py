"""Rows at the end that were never written: files that were laid out in advance, cut and filled with zeros."""

import numpy as np
import pytest
from readings import six

from sigmatau.findings.reading import NeverWritten
from sigmatau.io.read import read
from sigmatau.io.read.frame import from_frame

N, WRITTEN = 5000, 3100
DATA = np.random.default_rng(3).normal(size=(N, 6))
STAMPS = np.arange(N) * 5_000 + 10**9
SAID = {"unit": {"gyro": "rad/s", "accel": "m/s^2"}, "channels": {"gyro": "1:3", "accel": "4:6"}, "rate": 200}


def told(record):
    (finding,) = (f for f in record.findings if f.code == "never_written")
    assert finding.severity == "error"
    return finding.details


def test_open_memmap(tmp_path):
    array = np.lib.format.open_memmap(tmp_path / "a.npy", mode="w+", dtype="f8", shape=(N, 6))
    array[:WRITTEN] = DATA[:WRITTEN]
    del array
    record = read(tmp_path / "a.npy", **SAID)
    np.testing.assert_array_equal(six(record), DATA[: WRITTEN - 1])
    assert told(record) == NeverWritten(rows=N, zeros=N - WRITTEN, kept=WRITTEN - 1)


def test_hdf5(tmp_path):
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "a", "w") as file:
        dataset = file.create_dataset("imu", shape=(N, 6), dtype="f8")
        dataset[:WRITTEN] = DATA[:WRITTEN]
    record = read(tmp_path / "a", **SAID)
    np.testing.assert_array_equal(six(record), DATA[: WRITTEN - 1])
    told(record)


@pytest.mark.parametrize("cut", [0, 1, 3, 9, 20])
def test_raw_with_stamps_cut_within_a_row(tmp_path, cut):
    rows = np.zeros(N, dtype=[("t", "<u8"), ("v", "<f8", (6,))])
    rows["t"], rows["v"] = STAMPS, DATA
    data = rows.tobytes()
    end = WRITTEN * rows.itemsize + cut
    (tmp_path / "a").write_bytes(data[:end] + bytes(len(data) - end))
    record = read(tmp_path / "a", layout="<u8 t[us],3f8 gyro[rad/s],3f8 accel[m/s^2]")
    kept = len(six(record))
    assert WRITTEN - 1 <= kept <= WRITTEN
    np.testing.assert_array_equal(six(record), DATA[:kept])
    told(record)


def test_a_ulog_filled_up_with_zeros(tmp_path):
    logs = pytest.importorskip("benches.logs")
    stamps, values = logs.made(3000)
    path = logs.KINDS["PX4 ULog"].make(tmp_path, stamps, values)
    whole = path.read_bytes()
    for end in range(60_000, 60_040):
        path.write_bytes(whole[:end] + bytes(len(whole) - end))
        record = read(path)
        n = len(six(record))
        assert 1000 < n < 2000
        np.testing.assert_array_equal(six(record), values[:n])
        assert [f.severity for f in record.findings] == ["error"]


def frame(values):
    columns = {
        f"{s}_{a}": values[:, k].copy() for k, (s, a) in enumerate((s, a) for s in ("gyro", "accel") for a in "xyz")
    }
    return from_frame(columns, rate=200, unit=SAID["unit"])


def test_sensors_that_rest_at_0_are_read():
    some = DATA.copy()
    some[3000:, 0] = 0  # one axis that is 0 before, too
    some[10, 0] = 0
    some[-7:] = 0
    assert frame(some).findings == ()
    assert six(frame(some)).shape == DATA.shape
    coarse = np.round(DATA * 0.2)  # mostly 0 in all columns
    coarse[-12:] = 0
    coarse[100:110] = 0
    assert frame(coarse).findings == ()
    assert six(frame(np.zeros_like(DATA))).shape == DATA.shape
