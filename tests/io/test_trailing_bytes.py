"""Bytes behind the end that a file declares: logs joined by ``cat``, several arrays in one file, and filler."""

import numpy as np
import pytest
from readings import axes
from roslogs import imu, imu_cdr, imu_db3, imu_mcap

from sigmatau.errors import DataError
from sigmatau.io.read import read

N = 400
SAID = {"rate": 100, "unit": {"gyro": "rad/s"}}
DATA = np.random.default_rng(1).normal(size=(N, 3))
FILLER = [(b"", None), (bytes(5000), "info"), (b"\xff" * 5000, "info"), (b"more" * 1000, "error")]


def hdf5(path, data, block=0):
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w", userblock_size=block) as file:
        file["gyro"] = data


def parquet(path, data):
    pa = pytest.importorskip("pyarrow")
    pq = pytest.importorskip("pyarrow.parquet")
    pq.write_table(pa.table({f"gyro_{a}": data[:, k] for k, a in enumerate("xyz")}), path, row_group_size=150)


def arrow(path, data, kind="file"):
    pa = pytest.importorskip("pyarrow")
    ipc = pytest.importorskip("pyarrow.ipc")
    table = pa.table({f"gyro_{a}": data[:, k] for k, a in enumerate("xyz")})
    with (ipc.new_file if kind == "file" else ipc.new_stream)(str(path), table.schema) as writer:
        writer.write_table(table, max_chunksize=150)


def npz(path, data):
    with path.open("wb") as file:
        np.savez(file, gyro=data)


def npy(path, data):
    with path.open("wb") as file:
        np.save(file, np.rec.fromarrays(data.T, names="gyro_x,gyro_y,gyro_z"))


def db3(path, data):
    stamps, values = imu(len(data))
    values[:, :3] = data
    imu_db3(path, [(s, imu_cdr(s, v)) for s, v in zip(stamps, values, strict=True)])


def mcap(path, data):
    pytest.importorskip("lz4", reason="lz4 packs what these tests read")
    pytest.importorskip("backports.zstd", reason="backports.zstd packs what these tests read")
    path.write_bytes(imu_mcap(len(data), 100)[0])


MAKERS = {"npy": npy, "npz": npz, "hdf5": hdf5, "db3": db3, "arrow": arrow, "mcap": mcap}
OPTIONS = {"db3": {}, "mcap": {}}


@pytest.mark.parametrize(("more", "severity"), FILLER, ids=["nothing", "zeros", "ff", "bytes"])
@pytest.mark.parametrize("kind", MAKERS)
def test_bytes_behind_the_end(tmp_path, kind, more, severity):
    path = tmp_path / "log"
    MAKERS[kind](path, DATA)
    whole = axes(read(path, **OPTIONS.get(kind, SAID)), "gyro")
    path.write_bytes(path.read_bytes() + more)
    record = read(path, **OPTIONS.get(kind, SAID))
    np.testing.assert_array_equal(axes(record, "gyro"), whole)
    assert [f.severity for f in record.findings] == ([] if severity is None else [severity])
    if severity is not None:
        assert record.findings[0].details.bytes == len(more)


@pytest.mark.parametrize("kind", ["npz", "hdf5", "db3", "arrow", "mcap"])
def test_two_logs_joined_are_told(tmp_path, kind):
    path = tmp_path / "log"
    MAKERS[kind](path, DATA)
    first = path.read_bytes()
    path.write_bytes(first + first)
    (finding,) = read(path, **OPTIONS.get(kind, SAID)).findings
    assert (finding.code, finding.severity, finding.details.bytes) == ("bytes_not_read", "error", len(first))


def test_hdf5_behind_a_block_of_the_user(tmp_path):
    hdf5(tmp_path / "log", DATA, block=512)
    assert not [f for f in read(tmp_path / "log", **SAID).findings if f.severity == "error"]
    (tmp_path / "log").write_bytes((tmp_path / "log").read_bytes() + b"more")
    (finding,) = read(tmp_path / "log", **SAID).findings
    assert (finding.code, finding.details.bytes) == ("bytes_not_read", 4)


@pytest.mark.parametrize("structured", [False, True])
def test_arrays_saved_one_after_the_other(tmp_path, structured):
    with (tmp_path / "a.npy").open("wb") as file:
        for piece in np.array_split(DATA, 7):
            np.save(file, np.rec.fromarrays(piece.T, names="wx,wy,wz") if structured else piece)
    said = SAID if structured else {**SAID, "channels": {"gyro": "1:3"}}
    record = read(tmp_path / "a.npy", **said)
    np.testing.assert_array_equal(axes(record, "gyro"), DATA)
    assert record.findings == ()
    assert "7 arrays" in record.provenance.conversions[0]


@pytest.mark.parametrize("other", [DATA[:, :2], DATA.astype("f4"), np.float64(3)])
def test_arrays_of_another_kind_are_told(tmp_path, other):
    with (tmp_path / "a.npy").open("wb") as file:
        np.save(file, DATA)
        np.save(file, other)
    record = read(tmp_path / "a.npy", **SAID, channels={"gyro": "1:3"})
    np.testing.assert_array_equal(axes(record, "gyro"), DATA)
    assert [f.severity for f in record.findings] == ["error"]


def test_parquet_files_joined_are_refused(tmp_path):
    parquet(tmp_path / "a", DATA)
    parquet(tmp_path / "b", -DATA[:250])
    (tmp_path / "ab").write_bytes((tmp_path / "a").read_bytes() + (tmp_path / "b").read_bytes())
    with pytest.raises(DataError, match="several Parquet files"):
        read(tmp_path / "ab", **SAID)


def test_arrow_streams_joined(tmp_path):
    arrow(tmp_path / "a", DATA, kind="stream")
    (tmp_path / "aa").write_bytes(2 * (tmp_path / "a").read_bytes())
    (finding,) = read(tmp_path / "aa", **SAID).findings
    assert finding.severity == "error"
