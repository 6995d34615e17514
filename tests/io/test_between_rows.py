"""Lines among the rows that are no rows: comments, headers further down, blank lines by the million, absurd lines."""

import contextlib
import gzip
import time

import numpy as np
import pytest

from sigmatau.errors import DataError
from sigmatau.findings.reading import SkippedLines
from sigmatau.io.read import read

HEADER = "time [s],gyro_x [deg/s],gyro_y [deg/s]\n"
ROWS = [f"{k / 100},{k},{2 * k}\n" for k in range(60)]
LIMIT = 20.0  # seconds; each takes well under one


def there(record):
    """Samples of the first channel, without the places that lost rows leave empty."""
    stream = record.streams[0]
    return stream.grid.n - (0 if stream.mask is None else int(stream.mask[:, 0].sum()))


def write(path, text):
    path.write_bytes(gzip.compress(text.encode()) if path.suffix == ".gz" else text.encode())
    return path


def codes(record):
    return [(f.code, f.severity) for f in record.findings]


@pytest.mark.parametrize("mark", ["#", "%", "//"])
@pytest.mark.parametrize("name", ["log.csv", "log.csv.gz"])
def test_a_row_that_became_a_comment_is_told(tmp_path, mark, name):
    rows = list(ROWS)
    rows[30] = mark + rows[30][len(mark) :]
    record = read(write(tmp_path / name, HEADER + "".join(rows)), rate=100)
    assert there(record) == 59
    found = next(f for f in record.findings if f.code == "skipped_lines")
    assert found.severity == "error"
    assert found.details == SkippedLines(what="comments", line=32)


def test_many_of_them_without_a_time_column(tmp_path):
    rows = [f"{k}.5 {k} 7\n" for k in range(60)]
    for k in range(20, 30):
        rows[k] = "%" + rows[k][1:]
    record = read(write(tmp_path / "log", "gyro_x gyro_y gyro_z\n" + "".join(rows)), rate=100, unit={"gyro": "deg/s"})
    assert codes(record) == [("skipped_lines", "error")]
    assert record.findings[0].details == SkippedLines(what="comments", line=22, count=10)


def test_a_remark_is_skipped(tmp_path):
    text = HEADER + "".join(ROWS[:20]) + "# lost the hammer here\n#\n" + "".join(ROWS[20:])
    record = read(write(tmp_path / "log.csv", text))
    assert (record.streams[0].grid.n, codes(record)) == (60, [])


@pytest.mark.parametrize(
    "second",
    [
        "#time [s],gyro_y [deg/s],gyro_x [deg/s]\n",
        "# time [s], gyro_x [rad/s], gyro_y [rad/s]\n",
        "#time [ms],gyro_x [deg/s],gyro_y [deg/s]\n",
    ],
)
def test_another_header_ends_the_reading(tmp_path, second):
    text = "#" + HEADER + "".join(ROWS[:30]) + second + "".join(ROWS[30:])
    record = read(write(tmp_path / "log.csv", text))
    assert record.streams[0].grid.n == 30
    assert codes(record) == [("skipped_lines", "error")]
    assert record.findings[0].details == SkippedLines(what="header", line=32, kept=30)


def test_the_same_header_again_does_not(tmp_path):
    text = "#" + HEADER + "".join(ROWS[:30]) + "#" + HEADER + "".join(ROWS[30:])
    record = read(write(tmp_path / "log.csv", text))
    assert record.streams[0].grid.n == 60
    assert codes(record) == []


@pytest.mark.parametrize(
    "line",
    [
        ",".join(["123456789012345678901234567890"] * 8) + ",x",
        "1" * 200_000 + "x",
        "a" + " " * 100_000 + "x",
        "#" + "(" * 100_000,
        "a [" + " " * 100_000 + "x",
    ],
    ids=["integers and a word", "a long number", "spaces", "brackets", "an open unit"],
)
@pytest.mark.parametrize("row", ["1,2\n", "1\n"])
def test_no_line_takes_for_ever(tmp_path, line, row):
    path = write(tmp_path / "log.csv", line + "\n" + row * 50)
    begun = time.monotonic()
    with contextlib.suppress(ValueError):
        read(path, rate=1)
    assert time.monotonic() - begun < LIMIT


@pytest.mark.parametrize("tail", ["", "1,2\n"])
def test_blank_lines_without_number(tmp_path, tail):
    """A hundred million line ends are a hundred kilobytes of compressed ones."""
    path = tmp_path / "log.csv.gz"
    with gzip.open(path, "wb", compresslevel=1) as log:
        log.write((HEADER + "".join(ROWS)).encode())
        for _ in range(100):
            log.write(b"\n" * (1 << 20))
        log.write(tail.encode())
    begun = time.monotonic()
    with pytest.raises(DataError, match=r"expands from 0\.\d+ MB to more than 67\.1 MB: .*--max-expansion"):
        read(path)
    if tail:
        with pytest.raises(DataError, match="line 104857662: 2 fields, 3 expected"):
            read(path, max_expansion=1100)
    else:
        assert read(path, max_expansion=1100).streams[0].grid.n == 60
    assert time.monotonic() - begun < LIMIT


def test_compressed_after_it_was_cut(tmp_path):
    rows = [f"{k / 100:.2f},{k:.4f},{2 * k:.4f}\n" for k in range(60)]
    text = (HEADER + "".join(rows))[:-3]
    for name in ("log.csv", "log.csv.gz"):
        record = read(write(tmp_path / name, text))
        assert there(record) == 59
        assert codes(record) == [("skipped_lines", "info")]


DATES = [
    ("2026-03-01 12:00:{s:02d}.{ms:03d}", ",", "timestamp"),
    ("2026-03-01T12:00:{s:02d}.{ms:03d}Z", "\t", "time [s]"),
    ("2026/03/01 12:00:{s:02d}.{ms:03d}", ",", "datetime"),
    ("2026-03-01T13:00:{s:02d}.{ms:03d}000001+01:00", "\t", "timestamp"),
    ('"2026-03-01 12:00:{s:02d},{ms:03d}"', ",", "time [s]"),
]


@pytest.mark.parametrize(("spelled", "delimiter", "name"), DATES)
def test_dates_are_stamps(tmp_path, spelled, delimiter, name):
    rows = [delimiter.join([spelled.format(s=k // 100, ms=10 * (k % 100)), str(k % 7), "0.5\n"]) for k in range(600)]
    text = delimiter.join([name, "gyro_x [deg/s]", "gyro_y [deg/s]"]) + "\n" + "".join(rows)
    record = read(write(tmp_path / "log.csv", text))
    assert record.streams[0].grid.rate == pytest.approx(100, rel=1e-12)  # to the nanosecond
    assert record.streams[0].grid.n == 600
    assert codes(record) == []


def test_a_unit_for_dates_changes_nothing(tmp_path):
    rows = [f"2026-03-01 12:00:{k:02d};{k},5\n" for k in range(60)]
    record = read(write(tmp_path / "log.csv", "time;gyro_x [deg/s]\n" + "".join(rows)), unit={"time": "s"})
    assert record.streams[0].grid.rate == pytest.approx(1, rel=1e-12)
    np.testing.assert_allclose(np.rad2deg(record.streams[0].column("gyro_x")[:2]), [0.5, 1.5], rtol=1e-15)


def test_a_bad_date_is_named(tmp_path):
    rows = [f"2026-03-01 12:00:{k:02d},{k}\n" for k in range(60)]
    rows[30] = "2026-03-01 12:00:61,30\n"
    with pytest.raises(DataError, match="line 32: column time has '2026-03-01 12:00:61', which is not a time"):
        read(write(tmp_path / "log.csv", "time,gyro_x [deg/s]\n" + "".join(rows)))


def test_no_circles_about_stamps_that_are_words(tmp_path):
    rows = [f"12h00m{k:02d},{k}\n" for k in range(60)]
    path = write(tmp_path / "log.csv", "time,gyro_x [deg/s]\n" + "".join(rows))
    with pytest.raises(DataError, match=r"neither a number nor a date.*--channels time=none --rate HZ"):
        read(path, unit={"time": "s"})
