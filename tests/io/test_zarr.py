"""Zarr stores, formats 2 and 3: the numbers, what they are called, and chunks that are missing or damaged."""

import gc
import itertools
import json
import pickle
import time

import numpy as np
import pytest

import sigmatau
from container_damage import survives
from known import seed_of
from sigmatau.cli import main
from sigmatau.errors import DataError, OptionError
from sigmatau.io.read.formats import zarr_store

zarr = pytest.importorskip("zarr", reason="Zarr needs the extra cluster")

N, CHUNK = 20_000, 2000
AXES = [f"{sensor}_{axis}" for sensor in ("gyro", "accel") for axis in "xyz"]
UNITS = {name: "rad/s" if name.startswith("gyro") else "m/s^2" for name in AXES}


@pytest.fixture(autouse=True)
def small_blocks(monkeypatch):
    monkeypatch.setattr(zarr_store, "_BLOCK_BYTES", 2 * 8 * CHUNK)


def numbers():
    x = 1e-3 * np.random.default_rng(seed_of("zarr")).standard_normal((N, 6))
    x[:, 5] += 9.81
    return x


def by_axis(place, x, *, version, dtype="f8", shards=None, group="", scale=None):
    """An array for each axis; integers are counts of 1e-6."""
    top = zarr.open_group(str(place), mode="w", zarr_format=version, attributes={"rate": 100.0})
    root = top.create_group(group) if group else top
    for k, name in enumerate(AXES):
        attributes = {"unit": UNITS[name], **({} if scale is None else {"scale_factor": scale})}
        array = root.create_array(
            name, shape=(len(x),), chunks=(CHUNK,), dtype=dtype, attributes=attributes,
            **({} if shards is None else {"shards": (shards,)}),
        )  # fmt: skip
        array[:] = x[:, k] if scale is None else np.rint(x[:, k] / scale)
    return place


def wide(place, x, *, version):
    """One array of all axes."""
    root = zarr.open_group(str(place), mode="w", zarr_format=version, attributes={"sample_rate": 100})
    array = root.create_array("imu", shape=x.shape, chunks=(CHUNK, 4), dtype="f8")
    array[:] = x
    array.attrs["columns"] = AXES
    array.attrs["units"] = UNITS
    return place


KINDS = {
    "by axis": by_axis,
    "in a group": lambda place, x, version: by_axis(place, x, version=version, group="imu"),
    "counts": lambda place, x, version: by_axis(place, x, version=version, dtype="i4", scale=1e-6),
    "wide": wide,
    "sharded": lambda place, x, version: by_axis(place, x, version=version, shards=2 * CHUNK),
    "sharded counts": lambda place, x, version: by_axis(
        place, x, version=version, shards=2 * CHUNK, dtype="i4", scale=1e-6
    ),
}
CASES = [case for case in itertools.product(KINDS, (2, 3)) if "sharded" not in case[0] or case[1] == 3]


@pytest.mark.parametrize(("kind", "version"), CASES)
def test_numbers(tmp_path, kind, version):
    x = numbers()
    record = sigmatau.read(KINDS[kind](tmp_path / "log.zarr", x, version=version))
    assert record.channels == tuple(AXES)
    assert [(s.unit, s.grid.rate, s.grid.source.place in ("rate", "sample_rate"), s.mask) for s in record.streams] == [
        ("rad/s", 100.0, True, None),
        ("m/s^2", 100.0, True, None),
    ]
    assert record.findings == ()
    assert record.provenance.format == "zarr"
    expected = 1e-6 * np.rint(x / 1e-6) if "counts" in kind else x
    for k, name in enumerate(AXES):
        np.testing.assert_allclose(record.stream_of(name).column(name), expected[:, k], rtol=1e-15, atol=0)


def chunk_of(place, name, number, version):
    """The file of a chunk, counted along the samples."""
    array = place / name
    if name == "imu":
        return array / f"{number}.0" if version == 2 else array / "c" / str(number) / "0"
    return array / str(number) if version == 2 else array / "c" / str(number)


@pytest.mark.parametrize(("kind", "version"), [case for case in CASES if case[0] != "in a group"])
def test_a_missing_chunk_is_missing_samples_and_never_zeros(tmp_path, kind, version):
    place = KINDS[kind](tmp_path / "log.zarr", numbers(), version=version)
    array, lost = "imu" if kind == "wide" else "gyro_y", 2 * CHUNK if "sharded" in kind else CHUNK
    chunk_of(place, array, 2, version).unlink()
    record = sigmatau.read(place)
    gone = slice(2 * lost, 3 * lost)
    for name in AXES:
        column = record.stream_of(name).column(name)
        expected = np.zeros(N, dtype=bool)
        if name == "gyro_y" or (kind == "wide" and AXES.index(name) < 4):  # the chunks of the wide array have four axes
            expected[gone] = True
        np.testing.assert_array_equal(np.isnan(column), expected)
    found = next(one for one in record.findings if one.code == "missing_chunks")
    total = 2 * N // CHUNK if kind == "wide" else N // lost
    assert found.severity == "error"
    assert (found.details.array, found.details.count, found.details.of, found.details.first) == (
        array,
        1,
        total,
        2 * lost,
    )
    if kind == "counts":
        assert main(["analyze", str(place), "--json", str(tmp_path / "a.json"), "--method", "gls", "-q"]) == 4
        assert "missing_chunks" in {one["code"] for one in json.loads((tmp_path / "a.json").read_text())["findings"]}


@pytest.mark.parametrize("dtype", ["f4", "i2"])
def test_a_missing_chunk_inside_a_shard(tmp_path, dtype):
    """The library leaves out chunks of nothing but the fill value: no sensor reads 0 for so long."""
    root = zarr.open_group(str(tmp_path / "log.zarr"), mode="w", attributes={"rate": 100.0})
    array = root.create_array("gyro_x", shape=(N,), chunks=(CHUNK,), shards=(5 * CHUNK,), dtype=dtype)
    x = np.random.default_rng(seed_of("zarr, shard")).integers(-50, 50, N)
    x[3 * CHUNK : 4 * CHUNK] = 0
    array[:] = x
    column = sigmatau.read(tmp_path / "log.zarr", unit={"gyro": "rad/s"}).streams[0].column("gyro_x")
    assert np.flatnonzero(np.isnan(column)).tolist() == list(range(3 * CHUNK, 4 * CHUNK))


@pytest.mark.parametrize(("kind", "version"), [case for case in CASES if case[0] != "in a group"])
def test_a_damaged_chunk_is_an_error_that_names_it(tmp_path, kind, version):
    place = KINDS[kind](tmp_path / "log.zarr", numbers(), version=version)
    array = "imu" if kind == "wide" else "gyro_y"
    chunk = chunk_of(place, array, 3, version)
    whole = chunk.read_bytes()
    empty = [] if "sharded" in kind else [b""]  # the library takes an empty shard for one that is not stored
    for damaged in (whole[: len(whole) // 2], whole[:-1], b"\xff" * len(whole), *empty):
        chunk.write_bytes(damaged)
        with pytest.raises(DataError, match=rf"log\.zarr: chunk (c/)?3(\.0|/0)? of array {array} is damaged \("):
            sigmatau.read(place)


def test_nothing_was_written(tmp_path):
    root = zarr.open_group(str(tmp_path / "log.zarr"), mode="w", attributes={"rate": 100.0})
    root.create_array("gyro_x", shape=(N,), chunks=(CHUNK,), dtype="f8")
    with pytest.raises(DataError, match="array gyro_x was never written"):
        sigmatau.read(tmp_path / "log.zarr")


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("group", ["", "imu"])
def test_an_array_without_its_metadata_is_told(tmp_path, version, group):
    place = by_axis(tmp_path / "log.zarr", numbers(), version=version, group=group)
    (place / "notes.txt").write_text("no array, and no damage")
    assert sigmatau.read(place).findings == ()
    (place / group / "gyro_x" / (".zarray" if version == 2 else "zarr.json")).unlink()
    record = sigmatau.read(place)  # without a warning of the library, which would be an error
    assert record.channels == tuple(AXES[1:])
    ((code, severity, what),) = [
        (one.code, one.severity, one.details.what) for one in record.findings if one.code != "incomplete_sensor"
    ]
    assert (code, severity, what) == ("damaged", "error", f"array {group}/gyro_x".replace(" /", " "))


def test_damaged_stores(tmp_path):
    place = by_axis(tmp_path / "log.zarr", numbers(), version=3)
    (place / "gyro_x" / "zarr.json").write_text('{"zarr_format": 3, "node_type": "array", "shape": [')
    with pytest.raises(DataError, match=r"log\.zarr: "):
        sigmatau.read(place)
    (place / "zarr.json").write_text("{}")
    with pytest.raises(DataError, match=r"log\.zarr: is a damaged Zarr store \("):
        sigmatau.read(place)


def test_refusals(tmp_path):
    place = by_axis(tmp_path / "log.zarr", numbers(), version=3)
    with pytest.raises(OptionError, match="is for raw binary files"):
        sigmatau.read(place, layout="f4 gyro_x")
    pytest.importorskip("fsspec", reason="URLs need the extra cluster")
    with pytest.raises(DataError, match=r"none\.zarr: is not a Zarr store"):
        sigmatau.read("memory://none.zarr")


def test_read_from_a_url(tmp_path):
    fsspec = pytest.importorskip("fsspec", reason="URLs need the extra cluster")
    x = numbers()
    place = by_axis(tmp_path / "log.zarr", x, version=3)
    memory = fsspec.filesystem("memory")
    memory.put(str(place), "/zarr-test.zarr", recursive=True)
    try:
        for url in ("memory://zarr-test.zarr", f"file://{place}"):
            record = sigmatau.read(url)
            assert record.provenance.path == url
            np.testing.assert_array_equal(record.streams[0].column("gyro_x"), x[:, 0])
    finally:
        memory.rm("/zarr-test.zarr", recursive=True)


def test_samples_stay_in_the_store(tmp_path, monkeypatch):
    """Streams are read by chunk: bounded memory for a record of any length."""
    x = numbers()
    place = by_axis(tmp_path / "log.zarr", x, version=3)
    record = sigmatau.read(place)
    blocks = [len(column._rows._blocks) for stream in record.streams for column in stream.samples.raw]
    assert max(blocks) <= zarr_store._KEPT_BLOCKS
    exact = sigmatau.analyze(record, method="gls", long="strided")
    whole = sigmatau.analyze(
        sigmatau.Record.from_arrays(rate=100, **{name: x[:, k] for k, name in enumerate(AXES)}),
        method="gls",
        long="strided",
    )
    for name in AXES:
        np.testing.assert_array_equal(exact.curves[name].avar, whole.curves[name].avar)


@pytest.mark.parametrize("changes", [{"shape": [10**8], "chunks": [1]}, {"shape": [10**13]}, {"shape": [2**70]}])
def test_too_many_chunks(tmp_path, changes):
    """Their names are not listed: 10⁸ of them take minutes and gigabytes."""
    place = by_axis(tmp_path / "log.zarr", numbers(), version=2)
    metadata = place / "gyro_x" / ".zarray"
    metadata.write_text(json.dumps(json.loads(metadata.read_text()) | changes))
    with pytest.raises(DataError, match="array gyro_x has more than 1000000 chunks; write it with larger chunks"):
        sigmatau.read(place)


def test_damaged_metadata_is_an_error_without_tracebacks(tmp_path, caplog):
    """asyncio logged a traceback for each further array, when its task was removed."""
    place = by_axis(tmp_path / "log.zarr", numbers(), version=2)
    for name in AXES:
        (place / name / ".zattrs").write_bytes(b"{\xff")
    with pytest.raises(DataError, match="is a damaged Zarr store"):
        sigmatau.read(place)
    time.sleep(0.2)  # the other tasks of the library end
    gc.collect()
    assert caplog.text == ""


class Payload:
    """Would run a program where it is unpickled."""

    def __init__(self, place):
        self.place = place

    def __reduce__(self):
        return open, (str(self.place), "w")


@pytest.mark.parametrize(
    ("version", "changes"),
    [
        (2, {"filters": [{"id": "pickle", "protocol": 5}], "compressor": None}),
        (2, {"filters": [{"id": "shuffle", "elementsize": 1}, {"id": "pickle", "protocol": 5}], "compressor": None}),
        (2, {"compressor": {"id": "pickle", "protocol": 5}}),
        (2, {"dtype": "|O", "filters": [{"id": "pickle", "protocol": 5}], "compressor": None, "fill_value": None}),
        (3, {"codecs": [{"name": "numcodecs.pickle", "configuration": {"protocol": 5}}]}),
        (3, {"codecs": [{"name": "pickle"}, {"name": "bytes", "configuration": {"endian": "little"}}]}),
    ],
)
def test_codecs_that_run_programs_are_refused(tmp_path, version, changes):
    place = by_axis(tmp_path / "log.zarr", numbers(), version=version)
    array = place / "gyro_x"
    metadata = array / (".zarray" if version == 2 else "zarr.json")
    metadata.write_text(json.dumps(json.loads(metadata.read_text()) | changes))
    for chunk in array.rglob("*"):
        if chunk.name.isdigit() and chunk.is_file():
            chunk.write_bytes(pickle.dumps(Payload(tmp_path / "ran")))
    with pytest.raises(DataError):
        sigmatau.read(place).stream_of("gyro_x").column("gyro_x")
    assert not (tmp_path / "ran").exists()


@pytest.mark.parametrize(("kind", "version"), [("by axis", 2), ("by axis", 3), ("sharded counts", 3)])
def test_mutants(tmp_path, kind, version):
    """Each file of the store in turn: metadata and chunks."""
    place = KINDS[kind](tmp_path / "log.zarr", numbers(), version=version)
    files = sorted(path for path in place.rglob("*") if path.is_file())
    chosen = [path for path in files if not path.name.isdigit()] + [path for path in files if path.name.isdigit()][:4]
    good = 0
    for path in chosen:
        raw = path.read_bytes()
        good += survives(
            f"zarr {kind} {version} {path.relative_to(place)}", raw, path, 100 / len(chosen) + 1, place=place
        )
        path.write_bytes(raw)
    assert good > 0
