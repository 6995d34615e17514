"""Excel workbooks, made by the published layout."""

import datetime as dt
import itertools
import sys
import zipfile
from importlib.util import find_spec

import numpy as np
import pytest
from benches.texts import workbook

import known
from container_damage import cut, survives
from sigmatau.errors import DataError, OptionError
from sigmatau.io.read import read

N = 600
STEP = 0.300 / 60 * np.sqrt(100.0)  # deg/s: 0.300 deg/√h at 100 Hz
VALUES = np.random.default_rng(known.seed_of("xlsx")).normal(0, STEP, (N, 3))
HEADER = ["t [s]", "gyro_x [deg/s]", "gyro_y [deg/s]", "gyro_z [deg/s]"]
ROWS = [[k / 100, *row] for k, row in enumerate(VALUES.tolist())]
UNIT = {"gyro": "deg/s"}

needs_calamine = pytest.mark.skipif(find_spec("python_calamine") is None, reason="python-calamine reads workbooks")


def exact(record, values=VALUES):
    columns = [record.stream_of(f"gyro_{a}").column(f"gyro_{a}") for a in "xyz"]
    np.testing.assert_array_equal(np.stack(columns, axis=1), values * (np.pi / 180))
    assert record.streams[0].grid.rate == pytest.approx(100, rel=1e-9)


@needs_calamine
@pytest.mark.parametrize("above", [[], [["Lab 3"], [], ["Operator", "A. B."], []], [[None], ["x"] * 9] * 30])
def test_a_sheet(tmp_path, above):
    record = read(workbook(tmp_path / "log.xlsx", {"Sheet1": [*above, HEADER, *ROWS]}))
    exact(record)
    assert {f.code for f in record.findings} <= {"unused_columns"}


@needs_calamine
def test_a_row_of_units(tmp_path):
    rows = [["t", "gx", "gy", "gz"], ["s", "deg/s", "deg/s", "deg/s"], *ROWS]
    exact(read(workbook(tmp_path / "log.xlsx", {"Sheet1": rows})))


@needs_calamine
def test_sheets_are_topics(tmp_path):
    path = workbook(tmp_path / "log.xlsx", {"notes": [["hand-held"]], "a": [HEADER, *ROWS], "b": [HEADER, *ROWS[:300]]})
    with pytest.raises(OptionError, match=r"a \(gyro\), b \(gyro\); choose"):
        read(path)
    exact(read(path, topic="b"), VALUES[:300])
    only = read(workbook(tmp_path / "log.xlsx", {"notes": [["hand-held"]], "a": [HEADER, *ROWS], "empty": []}))
    exact(only)
    assert any(note.startswith("left out: notes (") for note in only.provenance.conversions)


@needs_calamine
def test_empty_cells_are_missing(tmp_path):
    rows = [list(row) for row in ROWS]
    rows[7][2] = None
    record = read(workbook(tmp_path / "log.xlsx", {"Sheet1": [HEADER, *rows]}))
    assert np.flatnonzero(np.isnan(record.stream_of("gyro_y").column("gyro_y"))).tolist() == [7]


@needs_calamine
def test_a_word_is_named_with_its_row(tmp_path):
    rows = [list(row) for row in ROWS]
    rows[7][2] = "#DIV/0!"
    with pytest.raises(DataError, match=r"line 9: column gyro_y \[deg/s\] has '#DIV/0!', which is not a number"):
        read(workbook(tmp_path / "log.xlsx", {"Sheet1": [HEADER, *rows]}))


@needs_calamine
@pytest.mark.parametrize("name", ["Date", "when", "Timestamp"])
def test_dates(tmp_path, name):
    start = dt.datetime(2026, 3, 1, 23, 59, 58)  # noqa: DTZ001
    rows = [[start + dt.timedelta(milliseconds=10 * k), *row] for k, row in enumerate(VALUES.tolist())]
    workbook(tmp_path / "log.xlsx", {"Sheet1": [[name, *HEADER[1:]], *rows]})
    record = read(tmp_path / "log.xlsx")
    assert (record.streams[0].grid.n, record.streams[0].grid.rate) == (N, pytest.approx(100, rel=1e-6))


def test_without_the_library(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "python_calamine", None)
    path = workbook(tmp_path / "log.xlsx", {"Sheet1": [HEADER, *ROWS]})
    with pytest.raises(DataError, match=r"an Excel workbook, which needs a library .* pip install 'sigmatau\[excel\]'"):
        read(path)


@needs_calamine
@pytest.mark.parametrize("rows", [[], [["a", "b"], ["c", "d"]]])
def test_nothing_to_read(tmp_path, rows):
    with pytest.raises(DataError, match="Excel workbook without a table of numbers"):
        read(workbook(tmp_path / "log.xlsx", {"Sheet1": rows}))


@needs_calamine
@pytest.mark.parametrize("share", [0.3, 0.9, 0.999])
def test_cut(tmp_path, share):
    path = workbook(tmp_path / "log.xlsx", {"Sheet1": [HEADER, *ROWS]})
    path.write_bytes(cut(path.read_bytes(), share))
    with pytest.raises(DataError, match="damaged or truncated"):
        read(path)


@needs_calamine
@pytest.mark.parametrize("entity", ["other", "small", "large"])
def test_entities_are_not_expanded(tmp_path, entity):
    """An entity that is another file, or 10¹¹ characters, is not a number: the reader knows only those of XML."""
    (tmp_path / "secret").write_text("0.5")
    places = "abcdefghijk"
    nested = "".join(f'<!ENTITY {y} "{f"&{x};" * 10}">' for x, y in itertools.pairwise(places))
    other = f'<!ENTITY other SYSTEM "{(tmp_path / "secret").as_uri()}">'
    kinds = f'<!DOCTYPE worksheet [{other}<!ENTITY small "0.5"><!ENTITY a "1">{nested}]>'
    value = {"large": places[-1]}.get(entity, entity)
    plain = workbook(tmp_path / "plain.xlsx", {"Sheet1": [HEADER, *ROWS]})
    with zipfile.ZipFile(plain) as read_from, zipfile.ZipFile(tmp_path / "log.xlsx", "w") as archive:
        for name in read_from.namelist():
            text = read_from.read(name).decode()
            if name.endswith("sheet1.xml"):
                text = kinds + text.replace(f"<v>{ROWS[7][1]!r}</v>", f"<v>&{value};</v>")
                assert f"&{value};" in text
            archive.writestr(name, text)
    record = read(tmp_path / "log.xlsx")
    got = record.stream_of("gyro_x").column("gyro_x") * (180 / np.pi)
    assert len(got) == N
    assert np.isnan(got[7])
    np.testing.assert_allclose(np.delete(got, 7), np.delete(VALUES[:, 0], 7), rtol=1e-12)


@needs_calamine
def test_mutants(tmp_path):
    path = workbook(tmp_path / "log.xlsx", {"Sheet1": [HEADER, *ROWS[:40]]})
    survives("xlsx", path.read_bytes(), path, 150)  # checksums of the archive refuse most of them
