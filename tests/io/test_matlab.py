"""MATLAB files, written by scipy.io (version 5) and mat-io (7.3, tables)."""

import warnings

import numpy as np
import pytest
import scipy.io
from readings import axes

from container_damage import cut, survives
from sigmatau.errors import DataError, OptionError
from sigmatau.findings.reading import Place
from sigmatau.io.read import read

N = 2000
RNG = np.random.default_rng(5)
T = np.arange(N) / 100
GYRO, ACCEL = RNG.normal(size=(N, 3)), RNG.normal(size=(N, 3))
UNITS = {"unit": {"gyro": "rad/s", "accel": "m/s^2", "time": "s"}}


def save(path, version, **variables):
    if version == "v7.3":
        matio = pytest.importorskip("matio")

        def tall(value):
            if isinstance(value, dict):
                return {k: tall(v) for k, v in value.items()}
            value = np.asarray(value)
            return value.reshape(-1, 1) if value.ndim < 2 and value.dtype.kind in "iuf" else value

        matio.save_to_mat(str(path), {k: tall(v) for k, v in variables.items()}, version=version)
    else:
        scipy.io.savemat(path, variables, do_compression=version == "compressed", oned_as="column")


@pytest.mark.parametrize("version", ["plain", "compressed", "v7.3"])
class TestVersions:
    def test_variables(self, tmp_path, version):
        save(tmp_path / "a.mat", version, t=T, gyro=GYRO, acc=ACCEL, fs=100.0, calibration=np.eye(3))
        record = read(tmp_path / "a.mat", **UNITS)
        np.testing.assert_array_equal(axes(record, "gyro"), GYRO)
        np.testing.assert_array_equal(axes(record, "accel"), ACCEL)
        assert record.streams[0].grid.rate == pytest.approx(100, rel=1e-13)
        assert record.provenance.format == "matlab"
        assert any("are not read: calibration" in c for c in record.provenance.conversions)
        unprotected = any("no checksum" in c for c in record.provenance.conversions)
        assert unprotected == (version == "plain")

    def test_structs_are_topics(self, tmp_path, version):
        imu = {"t": T, "gyro": GYRO, "acc": ACCEL}
        save(tmp_path / "a.mat", version, imu=imu, other={"t": T[::2], "gyro": GYRO[::2], "acc": ACCEL[::2]})
        with pytest.raises(OptionError, match=r"several sensors: imu .*2000 rows.*other .*1000 rows"):
            read(tmp_path / "a.mat", **UNITS)
        record = read(tmp_path / "a.mat", topic="other", **UNITS)
        np.testing.assert_array_equal(axes(record, "accel"), ACCEL[::2])
        assert record.provenance.topics == ("other",)

    def test_structs_in_structs(self, tmp_path, version):
        xyz = dict(zip("xyz", GYRO.T, strict=True))
        save(tmp_path / "a.mat", version, log={"time": T, "imu": {"gyro": xyz, "cfg": {"n": 5.0}}})
        record = read(tmp_path / "a.mat", **UNITS | {"unit": {"gyro": "rad/s", "time": "s"}})
        np.testing.assert_array_equal(axes(record, "gyro"), GYRO)

    def test_rows_and_integers(self, tmp_path, version):
        stamps = np.int64(1_700_000_000_000_000_001) + np.arange(N) * 5_000_000
        counts = RNG.integers(-30000, 30000, size=(3, N)).astype(np.int16)
        save(tmp_path / "a.mat", version, t_ns=stamps, gyro=counts)
        record = read(tmp_path / "a.mat", unit={"gyro": "rad/s"}, scale={"gyro": 0.5})
        np.testing.assert_array_equal(axes(record, "gyro"), counts.T * 0.5)
        assert record.streams[0].grid.rate == pytest.approx(200, rel=1e-15)
        assert any("its transpose" in c for c in record.provenance.conversions)

    @pytest.mark.parametrize("share", [0.1, 0.5, 0.99])
    def test_cut_off(self, tmp_path, version, share):
        path = tmp_path / "a.mat"
        save(path, version, t=T, gyro=GYRO, acc=ACCEL, later=np.stack([T, T], axis=1))
        path.write_bytes(cut(path.read_bytes(), share))
        if version == "v7.3" or share < 0.5:
            with pytest.raises(DataError, match="is truncated"):
                read(path, **UNITS)
            return
        # The variables before the break are read, and the loss is an error.
        record = read(path, channels={"time": "t", "gyro": "2:4"}, **UNITS | {"unit": {"gyro": "rad/s", "time": "s"}})
        np.testing.assert_array_equal(axes(record, "gyro"), GYRO)
        (finding,) = record.findings
        assert (finding.code, finding.severity) == ("damaged", "error")
        assert finding.details.place == Place("byte", path.stat().st_size)
        if share == 0.5 and version == "plain":
            assert finding.details.what == "variable acc"
            assert " bytes" in finding.details.reason


def test_nothing_can_be_read(tmp_path):
    (tmp_path / "a.mat").write_bytes(b"")
    save(tmp_path / "a.mat", "plain", s="words", c=np.array([[1, "a"]], dtype=object), z=1j * T, b=T > 1)
    with pytest.raises(DataError, match="no variable of numbers"):
        read(tmp_path / "a.mat")
    save(tmp_path / "a.mat", "plain", wx=T[:3])
    with pytest.raises(DataError, match="at least 4"):
        read(tmp_path / "a.mat")


def test_big_endian(tmp_path):
    """By hand from the published layout: one matrix of doubles, in the order of the other machines."""
    name = b"wx"
    values = T[:100].astype(">f8").tobytes()
    body = b"".join(
        [
            np.array([6, 8, 6, 0], ">u4").tobytes(),
            np.array([5, 8, 100, 1], ">u4").tobytes(),
            np.array([(len(name) << 16) + 1], ">u4").tobytes() + name.ljust(4, b"\0"),
            np.array([9, len(values)], ">u4").tobytes() + values,
        ]
    )
    header = b"MATLAB 5.0 MAT-file".ljust(116) + bytes(8) + b"\x01\x00MI"
    path = tmp_path / "log"
    path.write_bytes(header + np.array([14, len(body)], ">u4").tobytes() + body)
    np.testing.assert_array_equal(scipy.io.loadmat(path)["wx"][:, 0], T[:100])
    record = read(path, rate=1, unit={"gyro": "rad/s"})
    np.testing.assert_array_equal(record.streams[0].column("gyro_x"), T[:100])


def test_declared_sizes_are_checked(tmp_path):
    path = tmp_path / "a.mat"
    save(path, "plain", wx=T, wy=T)
    raw = bytearray(path.read_bytes())
    assert int.from_bytes(raw[160:164], "little") == N  # the rows of the first
    raw[160:164] = (1 << 30).to_bytes(4, "little")
    path.write_bytes(raw)
    record = read(path, rate=1, unit={"gyro": "rad/s"})
    assert record.channels == ("gyro_y",)
    assert [f.code for f in record.findings] == ["damaged"]
    assert record.findings[0].details.what == "variable wx"


@pytest.mark.parametrize("version", ["v7", "v7.3"])
class TestTables:
    def table(self, path, version, index=None, units=("deg/s", "deg/s", "deg/s", "g")):
        matio = pytest.importorskip("matio")
        pandas = pytest.importorskip("pandas")
        frame = pandas.DataFrame({"wx": GYRO[:, 0], "wy": GYRO[:, 1], "wz": GYRO[:, 2], "ax": ACCEL[:, 0]})
        frame.attrs["VariableUnits"] = frame.attrs["varUnits"] = list(units)
        if index is not None:
            frame.index = pandas.Index(index, name="Time")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # about formats of display
            matio.save_to_mat(str(path), {"imu": frame, "before": np.ones((5, 1))}, version=version)

    def test_table(self, tmp_path, version):
        self.table(tmp_path / "a.mat", version)
        channels = {"gyro": "1:3"}
        record = read(tmp_path / "a.mat", topic="imu", rate=50, channels=channels, unit={"gyro": "rad/s"})
        np.testing.assert_array_equal(axes(record, "gyro"), GYRO)

    def test_timetable(self, tmp_path, version):
        self.table(tmp_path / "a.mat", version, np.arange(N) * np.timedelta64(2500, "us"))
        record = read(tmp_path / "a.mat", unit={"gyro": "rad/s"})
        np.testing.assert_array_equal(axes(record, "gyro"), GYRO)
        assert record.streams[0].grid.rate == pytest.approx(400, rel=1e-12)

    def test_row_times_that_are_dates(self, tmp_path, version):
        start = np.datetime64("2026-01-02T03:04:05", "ns")
        self.table(tmp_path / "a.mat", version, start + np.arange(N) * np.timedelta64(10_000_000, "ns"))
        record = read(tmp_path / "a.mat", unit={"gyro": "rad/s"})
        assert record.streams[0].grid.rate == pytest.approx(100, rel=1e-9)  # a double of ms since 1970 has 0.2 µs

    def test_cut_off(self, tmp_path, version):
        path = tmp_path / "a.mat"
        self.table(path, version, np.arange(N) * np.timedelta64(2500, "us"))
        path.write_bytes(cut(path.read_bytes(), 0.5))
        with pytest.raises(DataError):
            read(path, unit={"gyro": "rad/s"})


@pytest.mark.parametrize("version", ["plain", "compressed", "v7.3"])
def test_mutants(tmp_path, version):
    path = tmp_path / "a.mat"
    t = T[:60]
    save(path, version, imu={"t": t, "gyro": GYRO[:60], "acc": ACCEL[:60]}, spare=t)
    good = survives(f"matlab {version}", path.read_bytes(), path, 100 if version == "v7.3" else 200, **UNITS)
    assert good > 0  # else they would be too broken to show anything


def test_links_of_version_73_to_other_files_are_not_followed(tmp_path):
    h5py = pytest.importorskip("h5py")
    path = tmp_path / "log.mat"
    save(path, "v7.3", t=T, gyro=GYRO, acc=ACCEL)
    before = read(path, **UNITS)
    with h5py.File(path, "a") as file:
        file["elsewhere"] = h5py.ExternalLink(str(tmp_path / "other.mat"), "/imu")  # which does not exist
    after = read(path, **UNITS)
    assert after.channels == before.channels
    assert after.findings == before.findings
