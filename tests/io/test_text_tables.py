"""Every accepted way to write one table gives the same numbers, bit for bit."""

import gzip

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sigmatau._native import formats
from sigmatau.errors import DataError
from sigmatau.io.read import read

# Five rows: time in s, two gyro axes in deg/s, one accelerometer axis in g.
ROWS = [
    ("0.00", "0.1", "-2.5", "1.001"),
    ("0.01", "0.2", "3e-3", "0.999"),
    ("0.02", "-0.3", "1.", "1.0"),
    ("0.03", ".4", "+7.25", "0.25"),
    ("0.04", "0.5", "-0.0", "123456.789"),
]
NAMES = ("time", "gyro_x", "gyro_y", "accel_z")
UNITS = ("s", "deg/s", "deg/s", "g")
OPTIONS = {"unit": {"time": "s", "gyro": "deg/s", "accel": "g"}}
BRACKETS = [f"{n} [{u}]" for n, u in zip(NAMES, UNITS, strict=True)]
BY_NUMBER = {"channels": {"time": 1, "gyro_x": 2, "gyro_y": 3, "accel_z": 4}}


def table(separator=",", end="\n", rows=ROWS):
    return "".join(separator.join(row) + end for row in rows)


def with_header(header=NAMES, separator=",", **kwargs):
    return separator.join(header) + kwargs.get("end", "\n") + table(separator, **kwargs)


def expected(column, factor):
    return np.array([float(row[column]) for row in ROWS]) * factor


def check(record, rate=100.0, findings=()):
    deg, g = np.pi / 180, 9.80665
    assert record.channels == ("gyro_x", "gyro_y", "accel_z")
    np.testing.assert_array_equal(record.stream_of("gyro_x").column("gyro_x"), expected(1, deg))
    np.testing.assert_array_equal(record.stream_of("gyro_y").column("gyro_y"), expected(2, deg))
    np.testing.assert_array_equal(record.stream_of("accel_z").column("accel_z"), expected(3, g))
    # 4e-16: the last digit of 4/0.04 and of the sum of four intervals
    assert [s.grid.rate for s in record.streams] == pytest.approx([rate, rate], rel=1e-14)
    assert record.provenance.rows == 5
    assert tuple((f.code, f.channel) for f in record.findings) == findings


DIALECTS = {
    "comma": with_header(),
    "semicolon": with_header(separator=";"),
    "tab": with_header(separator="\t"),
    "spaces": with_header(separator="   "),
    "leading and trailing spaces": with_header(separator="  ").replace("\n", "  \n   "),
    "comma and space": with_header(separator=", "),
    "CR LF": with_header(end="\r\n"),
    "byte order mark": "\ufeff" + with_header(),
    "blank lines": "\n\n" + with_header().replace("\n", "\n\n"),
    "quotes": with_header([f'"{n}"' for n in NAMES]).replace("0.999", '"0.999"'),
    "trailing delimiter": with_header(end=",\n"),
    "trailing delimiter in the rows alone": ",".join(NAMES) + "\n" + table(end=",\n"),
    "comments before": "# made by hand\n% x\n// 5 rows\n" + with_header(),
    "comments between": with_header().replace("\n0.02", "\n# lost the hammer here\n0.02"),
    "comment after the header": ",".join(NAMES) + "\n# 100 Hz\n" + table(),
    "header in a comment": "#" + with_header(),
    "header in a comment with a space": "# made by hand\n% " + with_header(separator=" "),
    "header in a comment above a remark": "# "
    + with_header(separator=" ").replace("\n", "\n# one two three four\n", 1),
    "commas in the header, spaces in the rows": ",".join(NAMES) + "\n" + table(" "),
    "row of dashes": ",".join(NAMES) + "\n----,----,----,----\n" + table(),
    "preface": "Device: 17\nrate,100\n\n" + with_header(),
    "row of units": ",".join(NAMES) + "\n" + ",".join(UNITS) + "\n" + table(),
    "row of units in brackets": ";".join(NAMES) + "\n[s];[deg/s];[°/s];(g)\n" + table(";"),
    "row of units in comments": "# " + " ".join(NAMES) + "\n# " + " ".join(UNITS) + "\n" + table(" "),
    "row of unknown units": ",".join(NAMES) + "\nticks,LSB,LSB,LSB\n" + table(),
    "units in brackets": with_header(BRACKETS),
    "units in brackets, spaces": with_header(BRACKETS, separator=" "),
    "units in parentheses": with_header(["time(s)", "gyro_x(deg/s)", "gyro_y (°/s)", "accel_z(g)"]),
    "quoted names with delimiters inside": with_header(
        ['"time [s]"', '"x, raw, gyro"', '"gyro_y"', '"accel_z"']
    ).replace("x, raw, gyro", "gyro_x"),
}


@pytest.mark.parametrize("text", DIALECTS.values(), ids=DIALECTS)
def test_dialect(tmp_path, text):
    path = tmp_path / "log.csv"
    path.write_bytes(text.encode())
    ended = not text.rpartition("\n")[2].strip()
    findings = () if ended else (("skipped_lines", None),)
    check(read(path, **OPTIONS), findings=findings)


@pytest.mark.parametrize("separator", [",", ";", "\t", " ", "  \t "])
def test_without_header(saved, separator):
    path = saved(table(separator), "log")
    record = read(path, **OPTIONS, **BY_NUMBER)
    check(record)
    assert "no header" in record.provenance.conversions[0]


@pytest.mark.parametrize("name", ["log.csv.gz", "log.csv"])
def test_gzip_by_content_not_by_name(tmp_path, name):
    path = tmp_path / name
    # Two compressed files one after the other are one.
    half = len(DIALECTS["comma"]) // 2
    text = DIALECTS["comma"].encode()
    path.write_bytes(gzip.compress(text[:half]) + gzip.compress(text[half:]))
    check(read(path, **OPTIONS))


def test_units_of_the_file_need_no_option(tmp_path):
    path = tmp_path / "log.csv"
    for text in (DIALECTS["units in brackets"], DIALECTS["row of units"]):
        path.write_text(text)
        check(read(path))


def test_windows_1252(tmp_path):
    path = tmp_path / "log.csv"
    path.write_bytes(with_header(["time [s]", "gyro_x [°/s]", "gyro_y [°/s]", "accel_z [g]"]).encode("cp1252"))
    record = read(path)
    check(record)
    assert "Windows-1252" in record.provenance.conversions[0]


def test_words_in_columns_that_are_not_used(tmp_path):
    path = tmp_path / "log.csv"
    rows = [(*row, "imu_link", "nan", '"a, b"') for row in ROWS]
    path.write_text(with_header([*NAMES, "frame", "yaw", "note"], rows=rows))
    record = read(path, **OPTIONS)
    check(record)
    assert record.provenance.ignored == ("frame", "yaw", "note")


def test_half_of_the_columns_are_words(tmp_path):
    path = tmp_path / "log.csv"
    words = ("frame", "mode", "note", "state")
    path.write_text(with_header([*NAMES, *words], rows=[(*row, "imu_link", "static", "a", "ok") for row in ROWS]))
    record = read(path, **OPTIONS)
    check(record)
    assert record.provenance.ignored == words


def test_provenance_says_what_was_done(saved):
    path = saved("# preface\n" + with_header(["time [s]", "wx [deg/s]", "gyro_y [rad/s]", "accel_z [g]"]))
    record = read(path, unit={"gyro_y": "deg/s"})
    check(record, findings=(("unit_overruled", "gyro_y"),))
    p = record.provenance
    assert p.path == str(path)
    assert p.format == "text"
    assert p.sha256 == __import__("hashlib").sha256(path.read_bytes()).hexdigest()
    words = "; ".join(p.conversions)
    assert "comma-separated text, header on line 2" in words
    assert "units in the header" in words
    assert "gyro_x from column 'wx [deg/s]'" in words
    assert "accel_z: g to m/s^2" in words
    assert "100 Hz from time stamps in column 'time [s]'" in words


def test_no_checksum_of_a_file_that_was_changed(saved):
    path = saved(with_header(NAMES))
    kept, changed, gone = (read(path, **OPTIONS).provenance for _ in range(3))
    first = kept.sha256
    assert first == kept.to_dict()["sha256"] is not None
    with path.open("a") as log:
        log.write("\n")
    assert changed.sha256 is None
    path.unlink()
    assert gone.sha256 is None
    assert kept.sha256 == first


def test_a_large_table_is_the_same_as_its_rows(tmp_path):
    """Large enough to be read in pieces."""
    rng = np.random.default_rng(5)
    n = 120_000
    columns = [np.arange(n) / 100, *rng.standard_normal((2, n)) * [[1e-3], [1e2]]]
    path = tmp_path / "log.csv"
    path.write_bytes(b"time [s],wx [rad/s],accel_x [m/s^2]\n" + formats.format_text(",", columns))
    assert path.stat().st_size > 4 << 20
    record = read(path)
    assert record.provenance.rows == n
    for channel, column in zip(("gyro_x", "accel_x"), columns[1:], strict=True):
        np.testing.assert_array_equal(record.stream_of(channel).column(channel), column)
    lines = path.read_bytes().split(b"\n")
    for at in (60_000, 110_000):
        lines[at] = b"1.0,oops,2"
    path.write_bytes(b"\n".join(lines))
    with pytest.raises(ValueError, match=r"line 60001: column wx \[rad/s\] has 'oops'"):
        read(path)


def test_a_mistake_deep_in_the_file_is_found(tmp_path):
    path = tmp_path / "log.csv"
    lines = [f"{i / 100},{i}" for i in range(60_000)]  # beyond what the layout is found out from
    lines[50_000] = "500.0,oops"
    path.write_text("time [s],gyro_x [deg/s]\n" + "\n".join(lines))
    with pytest.raises(ValueError, match=r"line 50002: column gyro_x \[deg/s\] has 'oops'"):
        read(path)


@settings(max_examples=60, deadline=None)
@given(
    rows=st.lists(st.tuples(*[st.floats(-1e59, 1e59)] * 2), min_size=4, max_size=40),
    delimiter=st.sampled_from([",", ";", "\t", " "]),
    header=st.booleans(),
    compress=st.booleans(),
)
def test_what_is_written_is_read_bit_for_bit(tmp_path_factory, rows, delimiter, header, compress):
    path = tmp_path_factory.mktemp("bits") / "log"
    columns = [np.array(c) for c in zip(*rows, strict=True)]
    data = f"wx{delimiter}phase\n".encode() * header + formats.format_text(delimiter, columns)
    path.write_bytes(gzip.compress(data) if compress else data)
    record = read(path, rate=1, channels={"gyro_x": 1, "phase": 2}, unit={"gyro": "rad/s", "phase": "1"})
    for channel, column in zip(("gyro_x", "phase"), columns, strict=True):
        got = record.stream_of(channel).column(channel)
        np.testing.assert_array_equal(got.view(np.int64), column.view(np.int64))


def test_a_table_that_does_not_fit_is_refused_at_once(tmp_path, monkeypatch):
    from sigmatau.record import memory

    log = tmp_path / "long.csv"
    log.write_text("gyro_x [deg/s],gyro_y [deg/s]\n" + "0.125,0.25\n" * 100_000)
    assert read(log, rate=1).streams[0].grid.n == 100_000
    monkeypatch.setattr(memory, "available", lambda: 1_000_000)
    with pytest.raises(
        DataError, match=r"about 1e\+05 rows need 0.0016 GB of memory, but 0.001 GB are free; save it as"
    ):
        read(log, rate=1)
