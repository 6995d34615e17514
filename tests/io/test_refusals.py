"""What cannot be read is refused in one line: the file, the place, what was found, what to do."""

import gzip
import os

import numpy as np
import pytest

from sigmatau.errors import DataError, OptionError, RecordTooShortError, StampError, printable
from sigmatau.io.read import read

HEADER = "time [s],gyro_x [deg/s]\n"
GOOD = HEADER + "".join(f"{i / 100},{i}\n" for i in range(10))


def refuse(path, kind, words, **options):
    with pytest.raises(ValueError) as caught:  # noqa: PT011  the kind is held below
        read(path, **options)
    error = caught.value
    assert type(error) is kind, f"{type(error).__name__}: {error}"
    message = str(error)
    assert "\n" not in message
    assert message.startswith(printable(str(path)))
    assert len(message) < 800
    for word in words:
        assert word in message
    return error


def edited(line, text):
    lines = GOOD.split("\n")
    lines[line - 1] = text
    return "\n".join(lines)


DATA = {
    "empty": (b"", ["is empty"]),
    "one byte": (b"x", ["no line of numbers", "'x'"]),
    "one line end": (b"\n", ["blank lines"]),
    "only comments": (b"# a\n% b\n", ["only comments"]),
    "only a header": (b"time,gyro_x\n", ["no line of numbers"]),
    "prose": (b"It was a dark\nand stormy night.\n", ["no line of numbers", "line 1", "It was a dark"]),
    "short last row with a line end": (GOOD + "0.10\n", [", line 12", "1 field, 2 expected"]),
    "short row": (edited(6, "0.04"), [", line 6", "1 field, 2 expected"]),
    "long row": (edited(6, "0.04,4,4"), [", line 6", "3 fields, 2 expected"]),
    "cut first row": (HEADER + "0.0\n" + GOOD.partition("\n")[2], [", line 2", "1 field, but 2 on line 3"]),
    "word": (edited(6, "0.04,four"), [", line 6", "gyro_x", "'four'", "not a number"]),
    "hexadecimal": (edited(6, "0.04,0x10"), [", line 6", "'0x10'", "not a number"]),
    "underscore": (edited(6, "0.04,1_000"), ["'1_000'"]),
    "two points": (edited(6, "0.04,1.0.0"), ["'1.0.0'"]),
    "Fortran exponent": (edited(6, "0.04,1.0D+00"), ["'1.0D+00'"]),
    "two numbers in a field": (edited(6, "0.04,1 2"), ["'1 2'"]),
    "trailing remark": (edited(6, "0.04,4 # odd"), ["'4 # odd'"]),
    "time backwards": (edited(6, "0.01,4"), [", line 6", "backwards", "from 0.03 to 0.01", "sort"]),
    "time still": (HEADER + "5,1\n" * 6, ["all stamps", "5", "--rate"]),
    "one row": (HEADER + "0,1\n", ["1 row of data", "at least 4"]),
    "three rows": (HEADER + "0,1\n1,1\n2,1\n", ["3 rows of data", "at least 4"]),
    "decimal comma and point": (
        "t;wx\n0,5;2,5\n0,6;2.5\n" * 9,
        ["line 2", "decimal comma", "line 3", "'2.5'", "point"],
    ),
    "decimal comma and thousands": (
        "time [s];gyro_x [deg/s]\n" + "0,5;2,5\n0,6;1.234,5\n" * 9,
        [", line 3", "'1.234,5'", "not a number"],
    ),
    "decimal comma, one column": ("0,012\n0,123\n0,004\n0,310\n", ["decimal comma"]),
    "decimal comma, one column with a name": ("wx\n1,5\n2,5\n3,5\n4,5\n", ["decimal comma"]),
    "decimal comma and comma": ("t,wx\n0,1,1,5\n0,2,2,5\n0,3,1,5\n0,4,1,7\n", ["decimal comma"]),
    "thousands": (
        'time [s],gyro_x [deg/s]\n0,"1,234.5"\n1,"2,000.1"\n2,"3,1.2"\n',
        ["line 2", '"1,234.5"', "not a number"],
    ),
    "two delimiters": ("1.5,2.5;3.5\n" * 5, ["line 1", "another delimiter"]),
    "UTF-16 without a mark": (GOOD.encode("utf-16-le"), ["UTF-16"]),
    "old Mac": (GOOD.replace("\n", "\r"), ["CR alone"]),
    "null byte": (GOOD.replace("0.04", "0.0\0"), ["binary data", "not a format that is read: text tables"]),
    "NMEA": (b"$GPGGA,-1.0,2.0,3.0*68\n" * 9, ["line 1", "$GPGGA", "not read yet"]),
    "a result": (
        b'{\n "schema": 2,\n "sigmatau": "0.1.0"\n}\n',
        ["is a result of sigmatau, not a log", "sigmatau export"],
    ),
    "JSON": (b'{"a": [1, 2, 3],\n1, 2, 3, 4}\n', ["line 1", "is not JSON"]),
    "huge first line": (b"1," * 200_000, ["first line is longer than 256 KiB"]),
    "PDF": (b"%PDF-1.7\n1 2 3\n", ["binary data", "not a format that is read: text tables"]),
    "PNG": (b"\x89PNG\r\n\x1a\n\0\0", ["binary data"]),
    "zip": (b"PK\x03\x04" + bytes(50), ["zip archive"]),
    "bag": (b"#ROSBAG V2.0\n" + bytes(50), ["the head of the bag makes no sense", "copy or record the file again"]),
    "xz": (b"\xfd7zXZ\0" + bytes(50), ["xz"]),
    "gzip of nothing": (gzip.compress(b""), ["is empty after decompression"]),
    "gzip twice": (gzip.compress(gzip.compress(GOOD.encode())), ["compressed twice"]),
    "gzip magic alone": (b"\x1f\x8b", ["truncated"]),
    "gzip of rubbish": (b"\x1f\x8b\x08" + b"\xff" * 50, ["damaged"]),
}


@pytest.mark.parametrize(("content", "words"), DATA.values(), ids=DATA)
def test_data(tmp_path, content, words):
    path = tmp_path / "log.csv"
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    stamps = words in (DATA["time backwards"][1], DATA["time still"][1])
    kind = RecordTooShortError if "at least 4" in words else StampError if stamps else DataError
    refuse(path, kind, words)


@pytest.mark.parametrize("text", ["inf", "-Infinity", "1e400"])
def test_infinite_values_are_missing(saved, text):
    path = saved(edited(6, f"0.04,{text}"))
    (finding,) = read(path).findings
    assert (finding.code, finding.channel, finding.size, finding.details.place) == (
        "missing_values",
        "gyro_x",
        1,
        "line 6",
    )


@pytest.mark.parametrize("keep", [0.3, 0.9])
def test_gzip_cut_in_the_middle(tmp_path, keep):
    path = tmp_path / "log.csv.gz"
    values = np.random.default_rng(3).normal(size=50_000)
    whole = gzip.compress((HEADER + "".join(f"{i / 100},{v}\n" for i, v in enumerate(values))).encode())
    path.write_bytes(whole[: int(keep * len(whole))])
    assert [(f.code, f.severity) for f in read(path).findings] == [("damaged", "error")]
    path.write_bytes(whole[:-8] + b"\0" + whole[-7:])
    refuse(path, DataError, ["compressed data are damaged", "line", "may be wrong"])


def test_a_line_without_end(saved):
    path = saved(GOOD + "7" * (3 << 20))
    refuse(path, DataError, [", line 12", "longer than 1 MiB"])


def options(**kwargs):
    return kwargs


OPTIONS = {
    "no rate": ("gyro_x [deg/s]\n" + "1\n" * 9, options(), "rate", ["no time column", "--rate HZ"]),
    "no unit": (
        "time [s],gyro_x,accel_y\n" + "".join(f"{i},1,1\n" for i in range(9)),
        options(),
        "unit",
        ["gyro_x, accel_y", "--unit gyro=deg/s,accel=UNIT"],
    ),
    "unit of increments": (
        "time [s],gyro_x\n" + "".join(f"{i},1\n" for i in range(9)),
        options(input="increments"),
        "unit",
        ["unit of gyro_x", "gyro=rad (whole numbers may be counts"],
    ),
    "no unit of a signal": (
        "t [s],p\n" + GOOD.partition("\n")[2],
        options(channels={"x": 2}),
        "unit",
        ["unit of x", "--unit x=1"],
    ),
    "no unit of time": (
        "time,gyro_x [deg/s]\n1459.63,0\n1459.73,0\n1459.83,0\n1459.93,0\n",
        options(),
        "unit",
        ["1459.63, 1459.73", "as s 10 Hz", "as ms 10000 Hz", "--unit time=s"],
    ),
    "unknown unit": (GOOD, options(unit={"gyro": "furlong"}), "unit", ["gyro_x", "'furlong'", "deg/s"]),
    "unit of another kind": (GOOD, options(unit={"gyro": "g"}), "unit", ["gyro_x", "'g'", "deg/s"]),
    "unknown unit of time": (GOOD, options(unit={"time": "fortnight"}), "unit", ["time", "'fortnight'", "ms"]),
    "rate in a unit of increments": (GOOD, options(unit={"gyro": "deg"}), "unit", ["gyro_x", "increments"]),
    "increments in a unit of rate": (GOOD, options(input="increments"), "unit", ["gyro_x", "increments", "rad"]),
    "unit of nothing": (GOOD, options(unit={"gyr": "deg/s"}), "unit", ["gyr", "gyro_x"]),
    "unit of no time": (
        "gyro_x [deg/s]\n" + "1\n" * 9,
        options(unit={"time": "s"}, rate=1),
        "unit",
        ["no time column"],
    ),
    "scale of nothing": (GOOD, options(scale={"accel": 2}), "scale", ["accel", "gyro_x"]),
    "offset of time": (GOOD, options(offset={"time": 2}), "offset", ["time"]),
    "negative scale of time": (GOOD, options(scale={"time": -1}), "scale", ["positive"]),
    "no such column": (
        GOOD,
        options(channels={"gyro_x": "wx"}),
        "channels",
        ["'wx'", "1 'time [s]', 2 'gyro_x [deg/s]'"],
    ),
    "nothing recognised": ("a,b\n" + "1,2\n" * 9, options(), "channels", ["1 'a', 2 'b'", "--channels"]),
    "no names": (
        "1,2\n" * 9,
        options(),
        "channels",
        ["no column names", "values do not show", "--channels time=N,gyro=N:N"],
    ),
    "300 columns": (",".join(["1"] * 300) + "\n" + ",".join(["2"] * 300) + "\n", options(), "channels", ["300 in all"]),
    "one name twice": (
        "gyro_x [deg/s],gyro_x [deg/s]\n" + "1,2\n" * 9,
        options(rate=1),
        "channels",
        ["columns 1", "and 2", "both look like gyro_x", "--channels gyro_x=1"],
    ),
}


@pytest.mark.parametrize(("content", "given", "option", "words"), OPTIONS.values(), ids=OPTIONS)
def test_options(saved, content, given, option, words):
    path = saved(content)
    error = refuse(path, OptionError, words, **given)
    assert error.option == option


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"rate": 0}, "positive"),
        ({"rate": -1}, "positive"),
        ({"rate": float("nan")}, "positive"),
        ({"rate": float("inf")}, "positive"),
        ({"rate": "100"}, "'100'"),
        ({"rate": True}, "True"),
        ({"rate": 10**400}, "positive"),
        ({"input": "rates"}, "rate, increments, accumulated"),
        ({"unit": "deg/s"}, "mapping"),
        ({"unit": {"gyro": 3}}, "must be a word"),
        ({"channels": ["gyro_x"]}, "mapping"),
        ({"channels": {"gyro_x": 1.0}}, "name or a number"),
        ({"channels": {"gyro_x": True}}, "name or a number"),
        ({"channels": {1: "wx"}}, "mapping of names"),
        ({"scale": {"gyro": float("nan")}}, "finite"),
        ({"scale": {"gyro": 0}}, "finite number but 0, not 0"),
        ({"scale": {"gyro": "2"}}, "'2'"),
        ({"offset": {"gyro": None}}, "finite"),
    ],
)
def test_options_of_the_wrong_kind(tmp_path, given, words):
    with pytest.raises(OptionError, match=words):
        read(tmp_path / "not looked at", **given)


def test_places_that_are_no_file(tmp_path):
    refuse(tmp_path / "missing.csv", DataError, ["no such file"])
    refuse(str(tmp_path / "mis\0sing"), DataError, ["cannot contain a null character"])
    refuse(tmp_path / ("x" * 300), DataError, ["cannot be read"])
    folder = tmp_path / "x.csv"
    folder.mkdir()
    refuse(folder, DataError, ["is a directory"])
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    refuse(tmp_path / "loop", DataError, ["symbolic links"])
    os.mkfifo(tmp_path / "pipe")
    refuse(tmp_path / "pipe", DataError, ["not a regular file"])  # and does not wait for a writer


def test_a_file_below_a_file(tmp_path):
    (tmp_path / "log.csv").write_text(GOOD)
    refuse(tmp_path / "log.csv" / "more", DataError, ["cannot be read", "Not a directory"])


def test_permission_denied(saved, monkeypatch):
    path = saved(GOOD)

    def denied(*_, **__):
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr("pathlib.Path.open", denied)  # tests may run as root, who may read all
    refuse(path, DataError, ["cannot be read: Permission denied"])
