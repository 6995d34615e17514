"""Units within cells, and marks at the end of rows."""

import gzip

import numpy as np
import pytest

import known
from sigmatau.errors import DataError
from sigmatau.io.read import read

N = 1500
RNG = np.random.default_rng(known.seed_of("plain cells"))
GYRO = RNG.normal(0, 0.05, (N, 3)).round(6)
ACCEL = (RNG.normal(0, 1e-3, (N, 3)) + np.array([0, 0, 1])).round(6)
NAMES = ("gx", "gy", "gz", "ax", "ay", "az")


def save(path, cells, *, delimiter=",", end="\n", head=None):
    """Rows of these formats of the time, three rates and three specific forces."""
    lines = [delimiter.join(["Time", *NAMES])] if head is None else list(head)
    for k, values in enumerate(np.hstack([GYRO, ACCEL]).tolist()):
        row = (k / 100, *values)
        lines.append(delimiter.join(cell.format(value) for cell, value in zip(cells, row, strict=True)))
    data = (end.join(lines) + end).encode()
    path.write_bytes(gzip.compress(data) if path.suffix == ".gz" else data)
    return path


def check(record, *, rate=100):
    assert record.stream_of("gyro_x").grid.rate == pytest.approx(rate)
    np.testing.assert_allclose(record.stream_of("gyro_y").column("gyro_y"), np.radians(GYRO[:, 1]))
    np.testing.assert_allclose(record.stream_of("accel_z").column("accel_z"), 9.80665 * ACCEL[:, 2])


@pytest.mark.parametrize(
    ("name", "delimiter", "cell"),
    [
        ("log.csv", ",", "{:.2f} sec"),
        ("log.csv.gz", ";", "{:.2f}s"),
        ("log.csv", "\t", "{:.5f}e3 ms"),
        ("log.csv.gz", ",", "{:.5f}e6µs"),
        ("log.csv", ";", "{:.5f}e3ms"),
    ],
)
def test_times_with_their_unit(tmp_path, name, delimiter, cell):
    path = save(tmp_path / name, [cell, *["{!r}"] * 6], delimiter=delimiter)
    check(read(path, unit={"gyro": "deg/s", "accel": "g"}))


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_every_cell_with_its_unit(tmp_path, end):
    cells = ["{:.2f} s", *["{!r} deg/s"] * 3, *["{!r} g"] * 3]
    check(read(save(tmp_path / "log.csv", cells, end=end)))


def test_a_column_of_two_units_is_refused(tmp_path):
    path = save(tmp_path / "log.csv", ["{:.2f} s", *["{!r} deg/s"] * 3, *["{!r} g"] * 3])
    lines = path.read_text().split("\n")
    changed = [line.replace(" g", " deg/s") if k > 700 else line for k, line in enumerate(lines)]
    path.write_text("\n".join(changed))
    with pytest.raises(DataError, match="several units"):
        read(path)
    path.write_text("\n".join([*lines[:-1], lines[-2].replace(" g", " mg"), ""]))
    with pytest.raises(DataError, match=rf"line {N + 2}: column ax has '.* mg'"):
        read(path)


def test_a_name_of_another_unit_is_refused(tmp_path):
    head = ["Time (ms),gx (deg/s),gy (deg/s),gz (deg/s),ax (g),ay (g),az (g)"]
    with pytest.raises(DataError, match=r"'Time \(ms\)' has cells in 'sec'"):
        read(save(tmp_path / "log.csv", ["{:.2f} sec", *["{!r}"] * 6], head=head))


@pytest.mark.parametrize(
    ("mark", "head", "delimiter"), [(";", None, ","), ("|", [], ","), (";", [], "\t"), ("|", None, " ")]
)
def test_a_mark_at_the_end_of_rows(tmp_path, mark, head, delimiter):
    path = save(tmp_path / "log.txt", ["{:.2f}", *["{!r}"] * 5, f"{{!r}}{mark}"], delimiter=delimiter, head=head)
    channels = {} if head is None else {"channels": {"time": 1, "gyro": "2:4", "accel": "5:7"}}
    check(read(path, unit={"gyro": "deg/s", "accel": "g", "time": "s"}, **channels))


def test_a_semicolon_between_and_behind_is_a_delimiter(tmp_path):
    path = save(tmp_path / "log.txt", ["{:.2f}", *["{!r}"] * 5, "{!r};"], delimiter=";")
    check(read(path, unit={"gyro": "deg/s", "accel": "g", "time": "s"}))


def test_words_that_are_no_units_stay(tmp_path):
    path = save(
        tmp_path / "log.csv", ["{:.2f}", *["{!r}"] * 5, "{!r},3rd"], head=["Time," + ",".join(NAMES) + ",trial"]
    )
    check(read(path, unit={"gyro": "deg/s", "accel": "g", "time": "s"}))


@pytest.mark.parametrize("title", ["Headers", "Columns", "fields"])
def test_names_behind_a_semicolon(tmp_path, title):
    head = [";Title, logger, X16", ";SampleRate, 100,Hz", f";{title}, Time,{','.join(NAMES)}"]
    path = save(tmp_path / "log.csv", ["{:.2f}", *["{!r}"] * 6], head=head)
    check(read(path, unit={"gyro": "deg/s", "accel": "g", "time": "s"}))
