"""How formats are told apart: before a reader is loaded, and by it."""

import gzip
import subprocess
import sys
import tarfile

import pytest
from benches.logs import KINDS, made

from sigmatau.errors import DataError
from sigmatau.io.read import read, registry
from sigmatau.io.read.table import HEAD, Head

NEEDS = {
    "MCAP": "rosbags",
    "ROS": "rosbags",
    "HDF5": "h5py",
    "Parquet": "pyarrow",
    "Arrow": "pyarrow",
    "LabVIEW": "nptdms",
    "Excel": "python_calamine",
}


@pytest.fixture(params=[name for name in KINDS if name not in ("raw binary", "CSV, gzip")])
def log(request, tmp_path):
    for word, library in NEEDS.items():
        if request.param.startswith(word):
            pytest.importorskip(library, reason="it writes the log")
    return request.param, KINDS[request.param].make(tmp_path, *made(200))


def test_no_reader_is_passed_over(log):
    """What a reader takes, its mark takes too: else it would depend on the mark and not on the reader."""
    data = log[1].read_bytes()[:HEAD]
    readers = [
        (entry, registry.import_module(f"sigmatau.io.read.formats.{entry.module}")) for entry in registry._FORMATS
    ]
    taken = [
        (entry, reader)
        for entry, reader in readers
        if (reader.sniff(data, log[1]) if entry.sniffs else entry.likely(data))
    ]
    assert all(entry.likely(data) for entry, _ in taken)
    assert registry.find_reader(Head(data=data, whole=True, gzip=False), log[1]) is taken[0][1]


def test_compressed(log):
    """By gzip: read if the entry of the registry says so, else refused."""
    name, path = log
    entry = next(entry for entry in registry._FORMATS if entry.accept(path.read_bytes()[:HEAD], path))
    packed = path.with_name("packed.gz")
    packed.write_bytes(gzip.compress(path.read_bytes()))
    if entry.gzip:
        assert read(packed, **KINDS[name].options).provenance.rows == 200
    else:
        with pytest.raises(DataError, match="compressed by gzip; decompress it first"):
            read(packed, **KINDS[name].options)


def test_a_table_loads_no_other_reader(tmp_path):
    path = KINDS["CSV"].make(tmp_path, *made(20))
    code = (
        "import sys, sigmatau; sigmatau.read(sys.argv[1]);"
        "print(*sorted(m.rpartition('.')[2] for m in sys.modules if m.startswith('sigmatau.io.read.')))"
    )
    said = subprocess.run([sys.executable, "-c", code, str(path)], check=True, capture_output=True, text=True).stdout
    others = {entry.module for entry in registry._FORMATS} - {"text"}
    assert "text" in said.split()
    assert not others & set(said.split())


@pytest.mark.parametrize(
    ("module", "name", "command"),
    [("bz2", "log.db3.bz2", "bzip2 -d"), ("lzma", "log.csv.xz", "xz -d"), ("zstd", "log.db3.zstd", "zstd -d")],
)
def test_compressed_by_others(tmp_path, module, name, command):
    library = pytest.importorskip("backports.zstd" if module == "zstd" else module)
    (tmp_path / name).write_bytes(library.compress(b"t,gyro_x\n0,1\n" * 1000))
    with pytest.raises(DataError, match=rf"decompress it first \({command} {name}\)"):
        read(tmp_path / name)


@pytest.mark.parametrize("mode", ["w", "w:gz"])
def test_archives_of_tar(tmp_path, mode):
    (tmp_path / "log.csv").write_text("t,gyro_x\n0,1\n" * 1000)
    with tarfile.open(tmp_path / "log.tar", mode) as archive:
        archive.add(tmp_path / "log.csv", "log.csv")
    with pytest.raises(DataError, match=r"decompress it first \(tar -xf log\.tar\)"):
        read(tmp_path / "log.tar")
