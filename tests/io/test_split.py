"""Bags of ROS 2 as folders, split into several files."""

import numpy as np
import pytest
from readings import six
from roslogs import imu, imu_cdr, imu_db3

from sigmatau.cli import main
from sigmatau.errors import DataError
from sigmatau.findings.reading import PartMissing
from sigmatau.io.read import read
from sigmatau.io.read.inspection import inspect
from sigmatau.io.read.options import ReadOptions

N, PARTS = 900, 3
STAMPS, VALUES = imu(N)


def there(record):
    """Rows that are there: lost ones leave their places empty."""
    values = six(record)
    return values[~np.isnan(values).any(axis=1)]


def db3(path, rows, pack=bytes, numbers=None):
    imu_db3(path, [(s, pack(imu_cdr(s, v))) for s, v in zip(STAMPS[rows], VALUES[rows], strict=True)], numbers)


def metadata(folder, names, prefix=""):
    listed = "".join(f"    - {prefix}{name}\n" for name in names)
    (folder / "metadata.yaml").write_text(
        f"rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: sqlite3\n  relative_file_paths:\n{listed}"
        f"  message_count: {N}\n"
    )


@pytest.fixture
def bag(tmp_path):
    folder = tmp_path / "bag"
    folder.mkdir()
    # In an order that is not that of the names.
    names = ["b_10.db3", "b_2.db3", "a_3.db3"]
    for k, name in enumerate(names):
        db3(folder / name, slice(k * N // PARTS, (k + 1) * N // PARTS))
    metadata(folder, names)
    return folder


@pytest.mark.parametrize("prefix", ["", "bag/"])
def test_the_parts_are_one_record(bag, prefix):
    metadata(bag, ["b_10.db3", "b_2.db3", "a_3.db3"], prefix)
    record = read(bag)
    np.testing.assert_array_equal(six(record), VALUES)
    assert record.findings == ()
    assert record.provenance.path == str(bag)
    assert "bag of 3 parts, joined in the order of metadata.yaml" in record.provenance.conversions
    (table,) = inspect(bag, ReadOptions()).tables
    assert (table.rows, table.findings) == (N, ())


@pytest.mark.parametrize("damage", ["missing", "empty", "rubbish"])
def test_a_part_that_cannot_be_read(bag, damage):
    if damage == "missing":
        (bag / "b_2.db3").unlink()
    else:
        (bag / "b_2.db3").write_bytes(b"" if damage == "empty" else b"SQLite format 3\0" + bytes(4000))
    record = read(bag)
    np.testing.assert_array_equal(there(record), np.concatenate([VALUES[: N // 3], VALUES[2 * N // 3 :]]))
    assert [(f.code, f.severity) for f in record.findings if f.code == "part_missing"] == [("part_missing", "error")]
    (details,) = (f.details for f in record.findings if f.code == "part_missing")
    assert (details.part, details.number, details.of) == ("b_2.db3", 2, 3)
    assert bool(details.reason) == (damage != "missing")


def test_no_part_at_all(bag):
    for part in bag.glob("*.db3"):
        part.unlink()
    with pytest.raises(DataError, match=r"bag: no part of the bag can be read: b_10\.db3: part 1 of 3 is missing"):
        read(bag)


def test_one_part_alone_says_so(bag):
    record = read(bag / "b_2.db3")
    np.testing.assert_array_equal(six(record), VALUES[N // 3 : 2 * N // 3])
    (finding,) = record.findings
    assert (finding.severity, finding.details) == ("info", PartMissing(number=2, of=3, alone=True))


def test_a_bag_of_one_part(bag):
    metadata(bag, ["b_10.db3"])
    record = read(bag)
    np.testing.assert_array_equal(six(record), VALUES[: N // 3])
    assert record.provenance.path == str(bag / "b_10.db3")


def test_at_the_command_line(bag, capsys):
    assert main(["analyze", str(bag), "--quiet", "--at-rest"]) == 0
    assert "gyro_x" in capsys.readouterr().out
    assert main(["inspect", str(bag), "--quiet"]) == 0
    assert f"{N} rows" in capsys.readouterr().out
    # A folder of such folders is several logs.
    assert main(["analyze", str(bag.parent), "--quiet", "--at-rest"]) == 0
    assert "bag" in capsys.readouterr().out


def test_messages_that_were_deleted(tmp_path):
    keep = [k for k in range(N) if not 300 <= k < 340]
    db3(tmp_path / "a.db3", keep, numbers=[k + 1 for k in keep])
    record = read(tmp_path / "a.db3")
    np.testing.assert_array_equal(there(record), VALUES[keep])
    assert not [f for f in record.findings if f.severity == "error"]


def test_messages_that_are_compressed_each(tmp_path):
    zstd = pytest.importorskip("backports.zstd", reason="backports.zstd packs what this test reads")
    db3(tmp_path / "a.db3", slice(N), zstd.compress)
    record = read(tmp_path / "a.db3")
    np.testing.assert_array_equal(six(record), VALUES)
    assert record.findings == ()
