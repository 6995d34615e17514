"""Parquet and Arrow, written by pyarrow."""

import numpy as np
import pytest

from container_damage import cut, survives
from sigmatau.errors import DataError
from sigmatau.io.read import read

pa = pytest.importorskip("pyarrow")
pq = pytest.importorskip("pyarrow.parquet")
ipc = pytest.importorskip("pyarrow.ipc")

N = 4000
RNG = np.random.default_rng(7)
STAMPS = 1_700_000_000_000_000_001 + np.arange(N) * 5_000_000
DATA = {f"{s}_{a}": RNG.normal(size=N) for s in ("gyro", "accel") for a in "xyz"}
UNITS = {"gyro": b"deg/s", "accel": b"g"}


def table(n=N, **more):
    fields = [pa.field("t", pa.timestamp("ns"))]
    fields += [pa.field(name, pa.float64(), metadata={b"unit": UNITS[name.split("_")[0]]}) for name in DATA]
    columns = [pa.array(STAMPS[:n]).cast(pa.timestamp("ns")), *(pa.array(x[:n]) for x in DATA.values())]
    for name, values in more.items():
        fields.append(pa.field(name, values.type))
        columns.append(values)
    return pa.table(columns, schema=pa.schema(fields))


def save(path, kind, data, rows=1000, **how):
    if kind == "parquet":
        pq.write_table(data, path, row_group_size=rows, **{"write_page_checksum": True} | how)
    else:
        maker = ipc.new_file if kind == "file" else ipc.new_stream
        with pa.OSFile(str(path), "wb") as sink, maker(sink, data.schema, **how) as writer:
            writer.write_table(data, max_chunksize=rows)


KINDS = pytest.mark.parametrize("kind", ["parquet", "file", "stream"])


@KINDS
class TestKinds:
    def test_exact(self, tmp_path, kind):
        save(tmp_path / "log", kind, table(words=pa.array(["a"] * N)))
        record = read(tmp_path / "log")
        for name, values in DATA.items():
            factor = np.pi / 180 if name.startswith("gyro") else 9.80665
            np.testing.assert_array_equal(record.stream_of(name).column(name), values * factor)
        assert record.streams[0].grid.rate == pytest.approx(200, rel=1e-15)
        assert record.findings == ()
        assert any("other types: words" in c for c in record.provenance.conversions)

    def test_structs_and_lists(self, tmp_path, kind):
        x, y, z = (pa.array(DATA[f"gyro_{a}"]) for a in "xyz")
        wide = np.stack([DATA[f"accel_{a}"] for a in "xyz"], axis=1)
        data = pa.table(
            {
                "imu": pa.StructArray.from_arrays([x, y, z], names=["wx", "wy", "wz"]),
                "acc": pa.FixedSizeListArray.from_arrays(pa.array(wide.ravel()), 3),
                "ms": pa.array(np.arange(N) * 10).cast(pa.duration("ms")),
            }
        )
        save(tmp_path / "log", kind, data)
        record = read(tmp_path / "log", channels={"time": "ms"}, unit={"gyro": "rad/s", "accel": "m/s^2"})
        for name, values in DATA.items():
            np.testing.assert_array_equal(record.stream_of(name).column(name), values)
        assert record.streams[0].grid.rate == pytest.approx(100, rel=1e-15)

    def test_nulls_and_nan_are_missing(self, tmp_path, kind):
        values = list(DATA["gyro_x"])
        values[2345] = None
        save(tmp_path / "log", kind, pa.table({"wx": values, "wy": DATA["gyro_y"]}))
        record = read(tmp_path / "log", rate=1, unit={"gyro": "rad/s"})
        assert np.flatnonzero(np.isnan(record.streams[0].column("gyro_x"))).tolist() == [2345]
        np.testing.assert_array_equal(record.streams[0].column("gyro_y"), DATA["gyro_y"])
        assert [(f.code, f.channel, f.details.place) for f in record.findings] == [
            ("missing_values", "gyro_x", "row 2345")
        ]
        said = {"rate": 1, "channels": {"gyro_y": "wy"}, "unit": {"gyro": "rad/s"}}
        assert read(tmp_path / "log", **said).channels == ("gyro_y",)
        save(tmp_path / "log", kind, pa.table({"wx": np.where(np.arange(N) == 17, np.nan, 1.0)}))
        assert read(tmp_path / "log", rate=1, unit={"gyro": "rad/s"}).findings[0].details.place == "row 17"
        save(tmp_path / "log", kind, pa.table({"wx": np.where(np.arange(N) == 17, np.inf, 1.0)}))
        assert read(tmp_path / "log", rate=1, unit={"gyro": "rad/s"}).findings[0].details.place == "row 17"

    def test_nulls_in_structs_lists_and_stamps(self, tmp_path, kind):
        start = 1_403_636_579_758_555_393
        stamps = [None if k == 7 else start + 5_000_000 * k for k in range(N)]
        vectors = [None if k == 9 else {"x": float(k), "y": 0.5 * k, "z": 1.0} for k in range(N)]
        lists = [None if k == 11 else [1.0 * k, 2.0 * k, 3.0 * k] for k in range(N)]
        data = {"t": pa.array(stamps), "gyro": vectors, "accel": pa.array(lists, pa.list_(pa.float64(), 3))}
        save(tmp_path / "log", kind, pa.table(data))
        record = read(tmp_path / "log", unit={"time": "ns", "gyro": "rad/s", "accel": "m/s^2"})
        assert record.streams[0].grid.rate == pytest.approx(200, rel=1e-15)
        for channel, missing, factor in (("gyro_y", 9, 0.5), ("accel_z", 11, 3.0)):
            expected = factor * np.arange(N)
            expected[[7, missing]] = np.nan
            np.testing.assert_array_equal(record.stream_of(channel).column(channel), expected)

    @pytest.mark.parametrize("share", [0.1, 0.5, 0.99])
    def test_cut_off(self, tmp_path, kind, share):
        path = tmp_path / "log"
        save(path, kind, table())
        path.write_bytes(cut(path.read_bytes(), share))
        if kind == "parquet" or share == 0.1:
            with pytest.raises(DataError, match="is truncated"):
                read(path)
            return
        record = read(path)
        rows = record.streams[0].grid.n
        assert rows in ((1000, 2000) if share == 0.5 else (3000,))  # whole batches; one more with a directory behind
        np.testing.assert_array_equal(record.stream_of("accel_z").column("accel_z"), DATA["accel_z"][:rows] * 9.80665)
        (finding,) = (f for f in record.findings if f.severity == "error")
        assert (finding.code, finding.details.kept) == ("damaged", rows)

    def test_no_numbers(self, tmp_path, kind):
        save(tmp_path / "log", kind, pa.table({"a": ["x"] * 9, "b": [True] * 9}))
        with pytest.raises(DataError, match=r"no column of numbers \(columns: a, b\)"):
            read(tmp_path / "log")


def test_an_index_of_pandas(tmp_path):
    pd = pytest.importorskip("pandas")
    index = pd.to_datetime(STAMPS)
    pd.DataFrame({"gyro_x_dps": DATA["gyro_x"]}, index=index).to_parquet(tmp_path / "log")
    assert read(tmp_path / "log").streams[0].grid.rate == pytest.approx(200, rel=1e-15)


@KINDS
def test_mutants(tmp_path, kind):
    path = tmp_path / "log"
    save(path, kind, table(60), rows=20)
    assert survives(f"arrow {kind}", path.read_bytes(), path, 140) > 0


def test_mutants_with_compression(tmp_path):
    path = tmp_path / "log"
    save(path, "file", table(60), rows=20, options=ipc.IpcWriteOptions(compression="zstd"))
    assert survives("arrow zstd", path.read_bytes(), path, 140) > 0


def test_a_stream_cut_between_two_batches_is_an_error(tmp_path):
    save(tmp_path / "log", "stream", table())
    (tmp_path / "log").write_bytes((tmp_path / "log").read_bytes()[:-8])
    (finding,) = read(tmp_path / "log").findings
    assert (finding.code, finding.severity) == ("damaged", "error")


def test_a_list_with_its_unit_in_the_name(tmp_path):
    wide = np.stack([DATA[f"gyro_{a}"] for a in "xyz"], axis=1)
    data = pa.table({"gyro [rad/s]": pa.array(wide.tolist(), type=pa.list_(pa.float64(), 3))})
    save(tmp_path / "log", "parquet", data)
    record = read(tmp_path / "log", rate=100)
    for axis in "xyz":
        np.testing.assert_array_equal(record.stream_of(f"gyro_{axis}").column(f"gyro_{axis}"), DATA[f"gyro_{axis}"])
