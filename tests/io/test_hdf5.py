"""HDF5, written by h5py."""

import numpy as np
import pytest
from readings import axes

from container_damage import cut, survives
from sigmatau.errors import DataError, OptionError
from sigmatau.io.read import read

h5py = pytest.importorskip("h5py")

N = 2000
RNG = np.random.default_rng(6)
T = np.arange(N) / 100
GYRO, ACCEL = RNG.normal(size=(N, 3)), RNG.normal(size=(N, 3))
CHECKED = {"chunks": True, "fletcher32": True}


def save(path, *, n=N, libver="earliest", **how):
    with h5py.File(path, "w", libver=libver) as file:
        group = file.create_group("imu0")
        for name, data, unit in (("t", T, "s"), ("gyro", GYRO, "deg/s"), ("accel", ACCEL, b"g")):
            group.create_dataset(name, data=data[:n], **how).attrs["units"] = unit
        group["gyro"].attrs["rate"] = 100.0
        file["gps/lat"] = T[: n // 2]
        file["words"] = "hello"


@pytest.mark.parametrize("how", [{}, CHECKED, {"chunks": True, "compression": "gzip", "shuffle": True}])
def test_groups_are_topics(tmp_path, how):
    save(tmp_path / "log", **how)
    record = read(tmp_path / "log")
    np.testing.assert_array_equal(axes(record, "gyro"), GYRO * (np.pi / 180))
    np.testing.assert_array_equal(axes(record, "accel"), ACCEL * 9.80665)
    assert record.streams[0].grid.rate == pytest.approx(100, rel=1e-13)
    assert record.provenance.topics == ("/imu0",)
    assert record.provenance.format == "hdf5"
    assert read(tmp_path / "log", topic="gps", rate=1, channels={"q": 1}, unit={"q": "1"}).channels == ("q",)


def test_compound(tmp_path):
    data = np.zeros(N, dtype=[("stamp_ns", "<i8"), ("gyro", ">f4", (3,)), ("label", "S3")])
    data["stamp_ns"] = 10**18 + 1 + np.arange(N) * 10_000_000
    data["gyro"] = GYRO
    with h5py.File(tmp_path / "log", "w") as file:
        file["a/imu"] = data
        file["a/imu"].attrs["gyro_units"] = "rad/s"
    record = read(tmp_path / "log")
    np.testing.assert_array_equal(axes(record, "gyro"), GYRO.astype("f4").astype(float))
    assert record.streams[0].grid.rate == pytest.approx(100, rel=1e-15)
    assert record.provenance.topics == ("/a/imu",)


def test_one_time_for_the_groups_below(tmp_path):
    with h5py.File(tmp_path / "log", "w") as file:
        file["log/t_s"] = T
        for k, axis in enumerate("xyz"):
            file[f"log/gyro/{axis}"] = GYRO[:, k]
            file[f"log/accel/{axis}"] = ACCEL[:, k]
    record = read(tmp_path / "log", unit={"gyro": "rad/s", "accel": "m/s^2"})
    np.testing.assert_array_equal(axes(record, "gyro"), GYRO)
    np.testing.assert_array_equal(axes(record, "accel"), ACCEL)


def test_two_rates_in_one_group(tmp_path):
    with h5py.File(tmp_path / "log", "w") as file:
        file["gyro"], file["accel"] = GYRO, ACCEL[::2]
    record = read(tmp_path / "log", rate=1, topic="/gyro", unit={"gyro": "rad/s"})
    assert record.channels == ("gyro_x", "gyro_y", "gyro_z")


def test_only_what_is_wanted_is_read(tmp_path):
    with h5py.File(tmp_path / "log", "w") as file:
        file["gyro"] = GYRO
        file.create_dataset("accel", ACCEL.shape, "f8")  # never written
    said = {"rate": 1, "unit": {"gyro": "rad/s"}}
    np.testing.assert_array_equal(axes(read(tmp_path / "log", channels={"gyro": "4:6"}, **said), "gyro"), GYRO)
    with pytest.raises(DataError, match="dataset accel was never written"):
        read(tmp_path / "log", rate=1, unit={"gyro": "rad/s", "accel": "g"})


def test_links_to_other_files_and_circles_are_not_followed(tmp_path):
    save(tmp_path / "log")
    with h5py.File(tmp_path / "log", "a") as file:
        file["imu0/again"] = file["imu0"]
        file["elsewhere"] = h5py.ExternalLink("/etc/passwd", "/")
        file["soft"] = h5py.SoftLink("/imu0")
    assert read(tmp_path / "log").provenance.topics == ("/imu0",)


@pytest.mark.parametrize("kind", ["external", "virtual"])
def test_samples_in_other_files_are_not_read(tmp_path, kind):
    """A log that names another file as the place of its samples: the HDF5 library would read that file."""
    GYRO[:, 0].tofile(tmp_path / "secret")
    with h5py.File(tmp_path / "log", "w") as file:
        file["more"] = np.zeros((5, 5, 5, N))  # more bytes than the other file
        if kind == "external":
            file.create_dataset("gyro_x", shape=(N,), dtype="f8", external=[(str(tmp_path / "secret"), 0, 8 * N)])
        else:
            save(tmp_path / "secret")
            layout = h5py.VirtualLayout(shape=(N,), dtype="f8")
            layout[:] = h5py.VirtualSource(str(tmp_path / "secret"), "imu0/t", shape=(N,))
            file.create_virtual_dataset("gyro_x", layout)
    with pytest.raises(DataError, match="dataset gyro_x has its samples in other files, which are not opened"):
        read(tmp_path / "log", rate=100, unit={"gyro": "rad/s"})


def test_a_filter_that_is_not_installed(tmp_path):
    """Programs in the folder of the log are not loaded; only those in HDF5_PLUGIN_PATH are, which the user sets."""
    with h5py.File(tmp_path / "log", "w") as file:
        file.create_dataset("gyro_x", data=GYRO[:, 0], chunks=(100,), compression="gzip")
    raw = bytearray((tmp_path / "log").read_bytes())
    place = raw.index(b"deflate") - 8
    assert int.from_bytes(raw[place : place + 2], "little") == 1
    raw[place : place + 2] = (32001).to_bytes(2, "little")
    (tmp_path / "log").write_bytes(raw)
    with pytest.raises(DataError, match="dataset gyro_x needs the HDF5 filter 32001, which is not installed"):
        read(tmp_path / "log", rate=100, unit={"gyro": "rad/s"})


def test_parts_that_were_never_written(tmp_path):
    with h5py.File(tmp_path / "log", "w") as file:
        file.create_dataset("wx", shape=(N,), dtype="f8", chunks=(100,))[:150] = 1.0
    with pytest.raises(DataError, match=r"dataset wx has 2 of 20 chunks"):
        read(tmp_path / "log", rate=1, unit={"gyro": "rad/s"})
    with h5py.File(tmp_path / "log", "w") as file:
        file.create_dataset("wx", shape=(1 << 40,), dtype="f8", chunks=(100,))
    with pytest.raises(DataError, match="never written"):
        read(tmp_path / "log", rate=1, unit={"gyro": "rad/s"})


@pytest.mark.parametrize("share", [0.1, 0.5, 0.99])
def test_cut_off(tmp_path, share):
    save(tmp_path / "log")
    raw = (tmp_path / "log").read_bytes()
    (tmp_path / "log").write_bytes(cut(raw, share))
    with pytest.raises(DataError, match=rf"truncated: it has {len(cut(raw, share))} of {len(raw)} bytes"):
        read(tmp_path / "log")


def test_a_heap_of_words_that_does_not_add_up(tmp_path):
    """The HDF5 library (2.0) looks for the next object for ever: found by mutation."""
    save(tmp_path / "log")
    raw = bytearray((tmp_path / "log").read_bytes())
    heap = raw.index(b"GCOL")
    free = heap + 16
    while raw[free : free + 2] != b"\0\0":
        free += 16 + -(-int.from_bytes(raw[free + 8 : free + 16], "little") // 8) * 8
    raw[free + 8 : free + 16] = bytes(8)
    (tmp_path / "log").write_bytes(raw)
    with pytest.raises(DataError, match="the sizes of a global heap are wrong"):
        read(tmp_path / "log")


def test_no_numbers(tmp_path):
    with h5py.File(tmp_path / "log", "w") as file:
        file["s"], file["cube"], file["c"] = "words", np.zeros((5, 5, 5)), np.zeros(9, complex)
    with pytest.raises(DataError, match="no dataset of numbers"):
        read(tmp_path / "log")
    with h5py.File(tmp_path / "log", "w") as file:
        file["p"] = T
    with pytest.raises(OptionError, match="no column with a known name"):
        read(tmp_path / "log")


@pytest.mark.parametrize("libver", ["earliest", "latest"])
def test_mutants(tmp_path, libver):
    path = tmp_path / "log"
    save(path, n=40, libver=libver, **CHECKED)
    assert survives(f"hdf5 {libver}", path.read_bytes(), path, 100) > 0


def test_packed_numbers_are_unpacked(tmp_path):
    counts = np.random.default_rng(2).integers(-3000, 3000, size=(N, 3)).astype("i2")
    with h5py.File(tmp_path / "log", "w") as file:
        file["gyro"] = counts
        file["gyro"].attrs.update(
            {"scale_factor": 0.01, "add_offset": 1.5, "units": "deg/s", "_FillValue": np.int16(-32768)}
        )
    record = read(tmp_path / "log", rate=100)
    np.testing.assert_array_equal(axes(record, "gyro"), (counts * 0.01 + 1.5) * (np.pi / 180))
    assert any("scale_factor" in c for c in record.provenance.conversions)
    counts[17, 1] = -32768
    with h5py.File(tmp_path / "log", "a") as file:
        file["gyro"][...] = counts
    record = read(tmp_path / "log", rate=100)
    assert np.flatnonzero(np.isnan(record.stream_of("gyro_y").column("gyro_y"))).tolist() == [17]
    assert [f.code for f in record.findings] == ["missing_values"]
