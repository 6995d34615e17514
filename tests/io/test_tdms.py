"""LabVIEW's TDMS, written by npTDMS's writer."""

import numpy as np
import pytest
from readings import axes

from container_damage import cut, survives
from sigmatau.errors import DataError, OptionError
from sigmatau.io.read import read
from sigmatau.record.sampling import RateSource

nptdms = pytest.importorskip("nptdms")

N = 1000
RNG = np.random.default_rng(8)
GYRO, ACCEL = RNG.normal(size=(N, 3)), RNG.normal(size=(N, 3))
STEP = {"wf_increment": 0.005, "wf_start_offset": 0.0, "wf_samples": N}


def save(path, pieces=1, properties=STEP, n=N, **more):
    with nptdms.TdmsWriter(path) as writer:
        for k in range(pieces):
            rows = slice(k * n // pieces, (k + 1) * n // pieces)
            channels = [
                nptdms.ChannelObject("IMU", f"{name} {a}", data[rows, i], properties=properties | {"unit_string": unit})
                for name, data, unit in (("Gyro", GYRO, "deg/s"), ("Accel", ACCEL, "g"))
                for i, a in enumerate("XYZ")
            ]
            channels += [nptdms.ChannelObject(*key.split("/"), data[rows]) for key, data in more.items()]
            writer.write_segment(channels)


@pytest.mark.parametrize("pieces", [1, 5])
def test_exact_with_the_rate_of_the_waveform(tmp_path, pieces):
    save(tmp_path / "log", pieces, **{"Other/T": GYRO[:, 0], "Other/words": np.array(["a"] * N)})
    record = read(tmp_path / "log")
    np.testing.assert_array_equal(axes(record, "gyro"), GYRO * (np.pi / 180))
    np.testing.assert_array_equal(axes(record, "accel"), ACCEL * 9.80665)
    assert record.streams[0].grid.rate == 200.0
    assert record.streams[0].grid.source == RateSource(kind="file", place="wf_increment")
    assert record.provenance.topics == ("IMU",)
    assert record.findings == ()


def test_the_rate_that_is_given_is_compared_with_the_waveform(tmp_path):
    save(tmp_path / "log")
    assert [f.code for f in read(tmp_path / "log", rate=190).findings] == ["rate_mismatch"]
    with pytest.raises(OptionError, match=r"wf_increment.*200 Hz, which contradicts --rate 100\. For 200 Hz, omit"):
        read(tmp_path / "log", rate=100)
    record = read(tmp_path / "log", rate=100, channels={"time": "none"})
    assert [f.code for f in record.findings] == ["rate_mismatch"]
    assert read(tmp_path / "log", rate=200).findings == ()
    save(tmp_path / "log", properties={})
    with pytest.raises(OptionError, match="give --rate"):
        read(tmp_path / "log")


def test_a_time_channel_goes_before_the_waveform(tmp_path):
    start = np.datetime64("2026-01-02T03:04:05", "us")
    save(tmp_path / "log", **{"IMU/Time": start + np.arange(N) * np.timedelta64(10_000, "us")})
    assert read(tmp_path / "log").streams[0].grid.rate == pytest.approx(100, rel=1e-9)


@pytest.mark.parametrize("pieces", [1, 10])
@pytest.mark.parametrize("share", [0.1, 0.5, 0.99])
def test_cut_off(tmp_path, pieces, share):
    path = tmp_path / "log"
    save(path, pieces)
    path.write_bytes(cut(path.read_bytes(), share))
    record = read(path)
    if pieces == 1 and share < 0.9:  # one channel after the other: the last of them are not there at all
        assert record.channels == (("gyro_x",) if share == 0.1 else ("gyro_x", "gyro_y", "gyro_z"))
        n = record.streams[0].grid.n
        np.testing.assert_array_equal(record.streams[0].column("gyro_x"), GYRO[:n, 0] * (np.pi / 180))
        assert [(f.code, f.severity) for f in record.findings] == [("damaged", "error")]
        return
    rows = record.streams[0].grid.n
    assert N * share - N / pieces <= rows + N * 0.06
    assert rows < N
    np.testing.assert_array_equal(axes(record, "accel"), ACCEL[:rows] * 9.80665)
    (finding,) = record.findings
    assert (finding.code, finding.severity) == ("damaged", "error")


def test_nothing_to_read(tmp_path):
    with nptdms.TdmsWriter(tmp_path / "log") as writer:
        writer.write_segment([nptdms.ChannelObject("g", "words", np.array(["a", "b"]))])
    with pytest.raises(DataError, match="no channel of numbers"):
        read(tmp_path / "log")


@pytest.mark.parametrize("pieces", [1, 3])
def test_mutants(tmp_path, pieces):
    path = tmp_path / "log"
    save(path, pieces, n=30)
    assert survives(f"tdms {pieces}", path.read_bytes(), path, 100) > 0
