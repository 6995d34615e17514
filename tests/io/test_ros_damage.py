"""Damaged logs of ROS: cut off, flipped, mutated, with lengths that are not true; what is read is true, or it is said."""

import contextlib
import itertools
import shutil
import subprocess
import sys
import time

import numpy as np
import pytest
from readings import six
from roslogs import KINDS, N, imu, imu_cdr, imu_mcap, rosbags_log

from container_damage import mutants
from known import seed_of
from sigmatau.errors import DataError, OptionError
from sigmatau.io.read import read

pytest.importorskip("lz4", reason="lz4 packs what these tests read")
pytest.importorskip("backports.zstd", reason="backports.zstd packs what these tests read")


def outcome(path, values):
    """Rows that were read, which must be the first ones; the severest finding, or None."""
    try:
        record = read(path, rate=200.0)
    except (DataError, OptionError):
        return None, "refused"
    rows = record.provenance.rows
    np.testing.assert_array_equal(six(record), values[:rows])
    codes = [(f.severity, f.code) for f in record.findings if f.code == "damaged"]
    return rows, min(codes, default=None)


def made(kind, folder, n=3000):
    if kind.startswith("mcap/"):
        data, _, values = imu_mcap(n, 50, kind.split("/")[1].replace("none", ""))
        path = folder / "log.mcap"
        path.write_bytes(data)
        return path, values
    path, _, values = rosbags_log(kind, folder, n)
    # Alone, so that nothing beside it tells what it should hold.
    return shutil.copy(path, folder / "alone"), values


ALL = ["mcap/none", "mcap/zstd", "mcap/lz4", *KINDS]


@pytest.mark.parametrize("share", [0.1, 0.5, 0.99])
@pytest.mark.parametrize("kind", ALL)
def test_cut_off(tmp_path, kind, share):
    path, values = made(kind, tmp_path)
    data = path.read_bytes()
    path.write_bytes(data[: int(share * len(data))])
    rows, found = outcome(path, values)
    assert found in ("refused", ("error", "damaged"), ("warning", "damaged"))
    if kind in ("mcap/none", "mcap/zstd", "mcap/lz4", "mcap", "bag"):
        # No more than a chunk is lost, and the index at the end, of some percent.
        assert share - 0.02 <= rows / len(values) <= share + 0.05
    if found == ("warning", "damaged"):
        assert rows == len(values)


@pytest.mark.parametrize("missing", [1, 40, 700])
def test_database_cut_inside_its_last_page(tmp_path, missing):
    path, values = made("db3", tmp_path)
    path.write_bytes(path.read_bytes()[:-missing])
    rows, found = outcome(path, values)
    assert found == ("error", "damaged")
    assert 0.98 < rows / len(values) < 1


@pytest.mark.parametrize("kind", ALL)
def test_a_flipped_page(tmp_path, kind):
    path, values = made(kind, tmp_path)
    data = bytearray(path.read_bytes())
    start = len(data) // 2 // 4096 * 4096
    data[start : start + 4096] = bytes(255 - b for b in data[start : start + 4096])
    path.write_bytes(data)
    rows, found = outcome(path, values)
    assert found in ("refused", ("error", "damaged"))
    assert rows is None or rows < len(values)
    if kind.startswith("mcap/"):
        assert abs(rows - 0.5 * len(values)) < 0.05 * len(values)


@pytest.mark.parametrize("kind", ["mcap/none", "mcap/zstd", "mcap/lz4", "mcap", "db3", "bag", "bag-lz4", "bag-bz2"])
def test_mutated(tmp_path, kind):
    rng = np.random.default_rng(seed_of(f"mutated {kind}"))
    path, values = made(kind, tmp_path, n=12)
    whole = path.read_bytes()
    shorter, turns = 0, mutants(100)
    for _ in turns:
        data = bytearray(whole)
        for _ in range(int(rng.integers(1, 4))):
            at = int(rng.integers(len(data)))
            if rng.random() < 0.5:
                data[at] = int(rng.choice([0, 1, 0x7F, 0x80, 0xFF, data[at] ^ 1]))
            elif rng.random() < 0.5:
                del data[at : at + int(rng.integers(1, 50))]
            else:
                data[at:at] = rng.bytes(int(rng.integers(1, 20)))
        path.write_bytes(data)
        started = time.perf_counter()
        if kind.startswith("mcap/"):
            # Checksums over all: what is read is true, and never silently shorter.
            rows, found = outcome(path, values)
            assert found is not None or rows == len(values)
            shorter += found is not None
        else:
            with contextlib.suppress(DataError, OptionError):
                read(path, rate=200.0)
        assert time.perf_counter() - started < 50
    assert shorter > len(turns) / 2 or not kind.startswith("mcap/")


MEASURE = """
import resource, sys
from sigmatau.errors import DataError
from sigmatau.io.read import read
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
for path in sys.argv[1:]:
    try:
        read(path)
        sys.exit(f"{path} was read")
    except DataError as error:
        assert "byte" in str(error), error
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)
"""


def test_declared_lengths_take_no_memory(tmp_path):
    data, _, _ = imu_mcap(30, 10)
    at = data.index(b"\x06", 8 + 9 + 8)  # the first chunk, behind the head
    paths = []
    # Its length, the length of what it holds, and of what is packed.
    for place, size in itertools.product((1, 25, 49), (1 << 29, 1 << 40, (1 << 64) - 1)):
        changed = bytearray(data)
        changed[at + place : at + place + 8] = size.to_bytes(8, "little")
        paths.append(tmp_path / f"{place}-{size}.mcap")
        paths[-1].write_bytes(changed[: -len(changed) // 2] if place == 1 else changed)
    run = subprocess.run(  # a process of its own, for its high-water mark
        [sys.executable, "-c", MEASURE, *map(str, paths)], capture_output=True, text=True, check=False
    )
    assert run.returncode == 0, run.stderr
    kib = int(run.stdout)
    assert kib < 50_000


def test_damage_that_stamps_show_before_it_is_found_out(tmp_path):
    data, _, values = imu_mcap(N, 100, "", crc=False)
    at = data.index(imu_cdr(*(x[400] for x in imu(N))))
    wrong = bytearray(data)
    wrong[at + 4 : at + 8] = b"\0\0\0\0"  # the seconds of one stamp
    (tmp_path / "log").write_bytes(wrong)
    record = read(tmp_path / "log")  # one stamp that stands far off: its row is left out and its place empty
    lost = np.isnan(six(record)).any(axis=1)
    assert np.flatnonzero(lost).tolist() == [400]
    np.testing.assert_array_equal(six(record)[~lost], np.delete(values, 400, axis=0))
    assert {f.code for f in record.findings} == {"bad_stamps", "gaps"}
    (tmp_path / "log").write_bytes(wrong[: at + 20_000])
    record = read(tmp_path / "log")
    assert {f.code for f in record.findings if f.severity == "error"} == {"damaged"}
    wrong[at + 4 : at + 8] = data[at + 4 : at + 8]
    for k in (400, 401, 402):  # and stamps that cannot be put in order
        place = data.index(imu_cdr(*(x[k] for x in imu(N))))
        wrong[place + 4 : place + 8] = (int.from_bytes(data[place + 4 : place + 8], "little") - 2).to_bytes(4, "little")
    (tmp_path / "log").write_bytes(wrong)
    with pytest.raises(DataError, match=r"message 400 .*time begins again"):
        read(tmp_path / "log")
