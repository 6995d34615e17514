"""NumPy's files."""

import io
import zipfile

import numpy as np
import pytest
from readings import axes

from sigmatau.errors import DataError
from sigmatau.io.read import read
from sigmatau.record import on_disk
from sigmatau.record.on_disk import FileColumn

N = 50
DATA = np.random.default_rng(1).normal(size=(N, 4))
OPTIONS = {"rate": 100, "channels": {"gyro": "2:4"}, "unit": {"gyro": "rad/s"}}


@pytest.mark.parametrize("order", ["C", "F"])
@pytest.mark.parametrize("dtype", ["f8", "f4", ">f8", "i4", "i2", "u1"])
def test_array(tmp_path, dtype, order):
    data = np.asarray(np.abs(DATA) * 50, dtype=dtype, order=order)
    np.save(tmp_path / "a.npy", data)
    record = read(tmp_path / "a.npy", **OPTIONS)
    np.testing.assert_array_equal(axes(record, "gyro"), data[:, 1:].astype(float))
    assert record.provenance.format == "npy"
    assert record.provenance.ignored == ("column 1",)


def test_an_array_stays_on_disk(tmp_path):
    np.save(tmp_path / "a.npy", DATA)
    (stream,) = read(tmp_path / "a.npy", **OPTIONS).streams
    assert all(isinstance(raw, FileColumn) for raw in stream.samples.raw)


@pytest.mark.parametrize("order", ["C", "F"])
def test_parts_of_columns_on_disk(tmp_path, order, monkeypatch):
    # Rows of 1 kB: every third is read with those between, every hundredth alone.
    data = np.asarray(np.random.default_rng(2).normal(size=(3000, 128)), order=order)
    np.save(tmp_path / "a.npy", data)
    (stream,) = read(tmp_path / "a.npy", **OPTIONS).streams
    for step in (1, 3, 100, 5000):
        for start, stop in ((0, 3000), (7, 2990), (5, 5)):
            for k, column in enumerate(stream.samples.raw):
                np.testing.assert_array_equal(column[start:stop:step], data[start:stop:step, k + 1])
    monkeypatch.setattr(on_disk, "_PART", 700)
    for threads in (1, 3):
        (held,) = on_disk.loaded((stream.cut(10, 2500),), threads)
        for k, column in enumerate(held.samples.raw):
            assert isinstance(column, np.ndarray)
            np.testing.assert_array_equal(column, data[10:2500, k + 1])


@pytest.mark.parametrize("bad", [np.inf, -1e70])
def test_a_missing_value_of_one_column_on_disk(tmp_path, bad):
    data = np.zeros((70_000, 4)) + np.arange(70_000)[:, None] % 5
    data[69_000, 2] = bad
    data[68_000, 3] = np.nan
    np.save(tmp_path / "a.npy", data)
    (stream,) = read(tmp_path / "a.npy", **OPTIONS).streams
    np.testing.assert_array_equal(np.argwhere(stream.mask), [[68_000, 2], [69_000, 1]])
    (held,) = on_disk.loaded((stream,))
    assert all(isinstance(raw, np.ndarray) for raw in held.samples.raw)
    for channel in stream.channels:
        np.testing.assert_array_equal(held.column(channel), stream.column(channel))


def test_structured_array(tmp_path):
    data = np.zeros(N, dtype=[("t_ns", "i8"), ("gyro_dps", "f4", (3,)), ("label", "U3")])
    data["t_ns"] = 10**18 + 1 + np.arange(N) * 10_000_000
    data["gyro_dps"] = DATA[:, :3]
    np.save(tmp_path / "a.npy", data)
    record = read(tmp_path / "a.npy")
    np.testing.assert_array_equal(axes(record, "gyro"), data["gyro_dps"].astype(float) * (np.pi / 180))
    assert record.streams[0].grid.rate == pytest.approx(100, rel=1e-15)
    assert record.provenance.ignored == ("label",)


def test_archive(tmp_path):
    path = tmp_path / "log.npz"
    np.savez_compressed(path, t_s=np.arange(N) / 100, gyro_dps=DATA[:, :3], acc_x=DATA[:, 3], fs=100.0, temp=DATA[:, 0])
    record = read(path, unit={"accel": "g"})
    np.testing.assert_array_equal(axes(record, "gyro"), DATA[:, :3] * (np.pi / 180))
    np.testing.assert_array_equal(record.stream_of("accel_x").column("accel_x"), DATA[:, 3] * 9.80665)
    assert record.streams[0].grid.rate == pytest.approx(100, rel=1e-13)
    assert record.channels[-1] == "temperature"
    assert read(path, channels={"gyro_x": "temp"}, unit={"gyro": "rad/s"}).channels == ("gyro_x",)


def test_objects_beside_numbers_do_not_matter(tmp_path):
    np.savez(tmp_path / "a.npz", wx=DATA[:, 0], meta=np.array([{"a": 1}], dtype=object))
    assert read(tmp_path / "a.npz", rate=1, unit={"gyro": "rad/s"}).channels == ("gyro_x",)


def test_not_a_number(tmp_path):
    data = DATA.copy()
    data[17, 2] = np.nan
    np.save(tmp_path / "a.npy", data)
    (finding,) = read(tmp_path / "a.npy", **OPTIONS).findings
    assert (finding.code, finding.channel, finding.size) == ("missing_values", "gyro_y", 1)
    assert finding.details.place == "row 17"
    data[17, 2] = np.inf
    np.save(tmp_path / "a.npy", data)
    assert read(tmp_path / "a.npy", **OPTIONS).findings == (finding,)
    data[17, 2] = 0
    data[5, 0] = np.inf  # a column that is not used
    np.save(tmp_path / "a.npy", data)
    assert read(tmp_path / "a.npy", **OPTIONS).channels == ("gyro_x", "gyro_y", "gyro_z")


@pytest.mark.parametrize(
    ("array", "words"),
    [
        (np.zeros((2, 3, 4)), r"shape \(2, 3, 4\)"),
        (np.zeros(()), r"shape \(\)"),
        (np.zeros((7, 1000)), "transpose"),
        (np.array([{}, {}]), "Python objects"),
        (np.zeros((N, 4), dtype=complex), "complex128, not real"),
        (np.zeros((N, 4), dtype="U3"), "not real"),
        (np.zeros((3, 4)), "3 rows of data; at least 4"),
        (np.zeros((0, 4)), "0 rows of data; at least 4"),
    ],
)
def test_refused_arrays(tmp_path, array, words):
    np.save(tmp_path / "a.npy", array, allow_pickle=True)
    with pytest.raises(DataError, match=words):
        read(tmp_path / "a.npy", **OPTIONS)


@pytest.mark.parametrize(
    ("arrays", "words"),
    [
        ({"wx": DATA[:, 0], "wy": DATA[:-1, 0]}, r"unequal length \(wx 50, wy 49\)"),
        ({"wx": np.array([{}] * 5)}, "wx hold objects or words"),
        ({"fs": 100.0}, "no array of numbers"),
        ({}, "no|without"),
    ],
)
def test_refused_archives(tmp_path, arrays, words):
    np.savez(tmp_path / "a.npz", **arrays)
    with pytest.raises(DataError, match=words):
        read(tmp_path / "a.npz", rate=1, unit={"gyro": "rad/s"})


@pytest.mark.parametrize("cut", [5, 50, 200, 1000, -10])
def test_cut_off(tmp_path, cut):
    np.save(tmp_path / "a.npy", DATA)
    np.savez(tmp_path / "a.npz", wx=DATA[:, 0], wy=DATA[:, 1])
    for path in (tmp_path / "a.npy", tmp_path / "a.npz"):
        path.write_bytes(path.read_bytes()[:cut])
        if path.suffix == ".npy" and cut in (1000, -10):  # whole rows of it are left
            record = read(path, **OPTIONS)
            n = record.streams[0].grid.n
            assert n == (path.stat().st_size - 128) // DATA[0].nbytes
            for k, channel in enumerate(record.channels):
                np.testing.assert_array_equal(record.stream_of(channel).column(channel), DATA[:n, 1 + k])
            assert [(f.code, f.severity) for f in record.findings] == [("damaged", "error")]
            continue
        with pytest.raises(DataError):
            read(path, **OPTIONS)


def test_a_zip_archive_of_something_else(tmp_path):
    for name in ("a.zip", "a.npz"):
        with zipfile.ZipFile(tmp_path / name, "w") as archive:
            archive.writestr("hello.txt", "hello")
        with pytest.raises(DataError, match=r"zip archive without (?:\.npy arrays|text tables)"):
            read(tmp_path / name)


def test_compressed_npy(tmp_path):
    import gzip

    buffer = io.BytesIO()
    np.save(buffer, DATA)
    (tmp_path / "a.npy.gz").write_bytes(gzip.compress(buffer.getvalue()))
    with pytest.raises(DataError, match="decompress it first"):
        read(tmp_path / "a.npy.gz", **OPTIONS)


def test_a_negative_shape_is_damaged(tmp_path):
    header = b"{'descr': '<f8', 'fortran_order': False, 'shape': (-5,)}"
    (tmp_path / "a.npy").write_bytes(b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header)
    with pytest.raises(DataError, match="damaged or truncated"):
        read(tmp_path / "a.npy", **OPTIONS)


@pytest.mark.parametrize("version", [1, 2, 3])
def test_a_long_header_is_named(tmp_path, version):
    header = b"{'descr': '<f8', 'fortran_order': False, 'shape': (9, 3)}" + b" " * 20_000
    length = len(header).to_bytes(2 if version == 1 else 4, "little")
    (tmp_path / "a.npy").write_bytes(b"\x93NUMPY" + bytes([version, 0]) + length + header + bytes(9 * 3 * 8))
    with pytest.raises(DataError, match="a header of 20057 bytes, and at most 10000 are read"):
        read(tmp_path / "a.npy", **OPTIONS)


def test_names_from_a_file_cannot_write_to_the_terminal(tmp_path):
    np.savez(tmp_path / "a.npz", **{"gyro\x1b[31m": np.array(["word"])})
    with pytest.raises(DataError, match=r"gyro\\x1b\[31m"):
        read(tmp_path / "a.npz", **OPTIONS)


@pytest.mark.parametrize("share", [0.3, 0.6, 0.9, 0.99])
def test_a_cut_archive_of_several_arrays(tmp_path, share):
    path = tmp_path / "a.npz"
    np.savez(path, **{f"gyro_{a}": DATA[:, k] for k, a in enumerate("xyz")}, t=np.arange(N))
    whole = path.read_bytes()
    for length in range(int(share * len(whole)), min(int(share * len(whole)) + 64, len(whole) - 1)):
        path.write_bytes(whole[:length])
        with pytest.raises(DataError, match=r"damaged or truncated|zip archive"):
            read(path, rate=1, unit={"gyro": "rad/s"})


def test_an_array_with_a_damaged_name_is_told(tmp_path):
    """The first letter of its name is lost: NumPy passes over it in silence."""
    path = tmp_path / "log.npz"
    np.savez(path, time_s=np.arange(100) / 100, gyro_rad_s=np.ones((100, 3)), accel_m_s2=np.eye(100)[:, :3])
    path.write_bytes(path.read_bytes().replace(b"gyro_rad_s.npy", b"\0yro_rad_s.npy"))
    (finding,) = (f for f in read(path).findings if f.code == "unread_arrays")
    assert (finding.severity, finding.details.names) == ("warning", ("yro_rad_s.npy",))
