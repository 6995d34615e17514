"""Text tables that break off, or hold bytes that are no text: read up to there, and said."""

import gzip

import numpy as np
import pytest

from container_damage import mutants
from known import seed_of
from sigmatau.errors import DataError, OptionError
from sigmatau.findings.reading import Damaged, Place
from sigmatau.io.read import read

N = 6000
WX = np.random.default_rng(seed_of("breaks")).normal(size=(N, 3))
HEADER = "time [s],gyro_x [deg/s],temp,note,gyro_z [deg/s]\n"
ROWS = [f"{i / 100:.2f},{a:.6f},{b:.3f},imu,{c:.6f}\n" for i, (a, b, c) in enumerate(WX)]
TEXT = (HEADER + "".join(ROWS)).encode()
ENDS = np.cumsum([len(HEADER), *map(len, ROWS)])


def found(record):
    return [(f.code, f.severity) for f in record.findings if f.code not in ("irregular_stamps", "gaps")]


def check(record, rows):
    """That the first rows are there, and no others."""
    assert record.provenance.rows == rows
    expected = np.array([[float(row.split(",")[k]) for k in (1, 4)] for row in ROWS[:rows]])
    got = np.stack([record.stream_of(c).column(c) for c in ("gyro_x", "gyro_z")], axis=1)
    np.testing.assert_array_equal(got, expected * (np.pi / 180))


@pytest.mark.parametrize(
    ("encoding", "part", "shift"),
    [*(("ascii", 0.1, k) for k in range(12)), ("ascii", 0.99, 0), *(("utf-16", 0.5, 3 * k) for k in range(4))],
)
def test_cut(tmp_path, part, shift, encoding):
    path = tmp_path / "log.csv"
    cut = int(part * len(TEXT)) + shift
    path.write_bytes(TEXT[:cut].decode().encode(encoding))
    rows = int(np.searchsorted(ENDS, cut, side="right")) - 1
    record = read(path)
    if cut == ENDS[rows]:  # after a line end nobody can know
        check(record, rows)
        assert found(record) == []
    elif cut == ENDS[rows + 1] - 1:  # all but the line end itself
        check(record, rows + 1)
        assert found(record) == []
    elif TEXT[ENDS[rows] : cut].count(b",") == 4 and not TEXT[:cut].endswith(b","):
        check(record, rows)
        assert found(record) == [("skipped_lines", "info")]
    else:
        check(record, rows)
        assert found(record) == [("damaged", "error")]
        assert record.findings[0].details.kept == rows


def test_cut_names_the_line(tmp_path):
    path = tmp_path / "log.csv"
    path.write_bytes(TEXT[: ENDS[100] + 3])
    assert read(path).findings[0].details == Damaged(truncated=True, place=Place("line", 102), kept=100)


@pytest.mark.parametrize("part", [0.1, 0.5, 0.99])
def test_cut_compressed(tmp_path, part):
    path = tmp_path / "log.csv.gz"
    whole = gzip.compress(TEXT)
    path.write_bytes(whole[: int(part * len(whole))])
    record = read(path)
    rows = record.provenance.rows
    assert 0.9 * part * N < rows < N  # numbers without pattern: half the bytes hold half the rows
    check(record, rows)
    assert found(record) == [("damaged", "error")]


@pytest.mark.parametrize(("part", "garbage"), [(0.3, "flipped"), (0.6, "random"), (0.999, "null")])
@pytest.mark.parametrize("encoding", ["ascii", "utf-16"])
def test_damaged_page(tmp_path, part, garbage, encoding):
    raw = bytearray(TEXT.decode().encode(encoding))
    start = int(part * len(raw)) // 4096 * 4096
    page = np.frombuffer(raw[start : start + 4096], dtype=np.uint8)
    with_garbage = {
        "flipped": page ^ 0xFF,
        "random": np.random.default_rng(seed_of("page")).integers(0, 256, len(page), dtype=np.uint8),
        "null": page * 0,
    }[garbage]
    raw[start : start + 4096] = with_garbage.tobytes()
    path = tmp_path / "log.csv"
    path.write_bytes(raw)
    record = read(path)
    at = start if encoding == "ascii" else (start - 2) // 2
    check(record, int(np.searchsorted(ENDS, at, side="right")) - 1)
    (finding,) = [f for f in record.findings if f.severity == "error"]
    assert finding.code in ("damaged", "damaged")
    assert finding.details.place == Place("line", record.provenance.rows + 2)


def test_damage_that_leaves_a_line_of_the_right_length(tmp_path):
    """From the words of one line to those of another: as many fields as there should be."""
    path = tmp_path / "log.csv"
    start, end = (ENDS[k] + ROWS[k].index("imu") + 1 for k in (50, 90))
    path.write_bytes(TEXT[:start] + bytes([0xCF, 0xD1]) * ((end - start) // 2) + TEXT[end:])
    record = read(path)
    check(record, 50)
    assert found(record) == [("damaged", "error")]


def test_zeros_after_a_power_failure(tmp_path):
    path = tmp_path / "log.csv"
    path.write_bytes(TEXT + bytes(3 << 20))
    record = read(path)
    check(record, N)
    assert found(record) == [("damaged", "error")]


def test_damage_in_a_compressed_file_is_refused(tmp_path):
    path = tmp_path / "log.csv.gz"
    whole = bytearray(gzip.compress(TEXT))
    whole[len(whole) // 2 : len(whole) // 2 + 4096] = bytes(4096)
    path.write_bytes(whole)
    with pytest.raises(DataError):
        read(path)
    whole = bytearray(gzip.compress(TEXT))
    whole[-8] ^= 1
    path.write_bytes(whole)
    with pytest.raises(DataError, match="compressed data are damaged"):
        read(path)


def test_bad_lines_among_good_ones_are_refused(tmp_path):
    path = tmp_path / "log.csv"
    for bad, words in (
        (b"1.0,2.0\n", "line 102: 2 fields, 5 expected"),
        (b"1.0,oops,2,3,4\n", "line 102: column gyro_x .* has 'oops'"),
        ("1.0,传感器断开传感器断开,2,3,4\n".encode(), "line 102: column gyro_x .* not a number"),
    ):
        path.write_bytes(TEXT[: ENDS[100]] + bad + TEXT[ENDS[100] :])
        with pytest.raises(DataError, match=words):
            read(path)


def test_a_last_number_of_any_form_without_a_line_end(tmp_path):
    path = tmp_path / "log.csv"
    rows = "".join(f"{i},{v!r}\n" for i, v in enumerate(WX[:50, 0].tolist()))
    path.write_text("time [s],gyro_x [deg/s]\n" + rows.rstrip("\n"))
    record = read(path)
    assert [(f.code, f.severity) for f in record.findings] == [("skipped_lines", "info")]
    assert record.provenance.rows == 49  # 1.25 cut off is 1.2


def test_a_last_comment_without_a_line_end_truncates_no_number(tmp_path):
    path = tmp_path / "log.csv"
    rows = "".join(f"{i},{v!r}\n" for i, v in enumerate(WX[:50, 0].tolist()))
    path.write_text("time [s],gyro_x [deg/s]\n" + rows + "# end")
    record = read(path)
    assert record.provenance.rows == 50
    assert record.findings == ()


def test_mutated_files(tmp_path):
    """A result or an error of ours, and never more rows than there are lines."""
    rng = np.random.default_rng(seed_of("mutated text"))
    small = HEADER.encode() + "".join(ROWS[:40]).encode()
    forms = [small, small.decode().encode("utf-16"), small.replace(b",", b";").replace(b".", b",")]
    forms.append(gzip.compress(small))
    path = tmp_path / "log.csv"
    outcomes = {"read": 0, "refused": 0}
    turns = mutants(240)
    for turn in turns:
        raw = bytearray(forms[turn % len(forms)])
        for _ in range(int(rng.integers(1, 4))):
            at = int(rng.integers(len(raw)))
            match rng.integers(4):
                case 0:
                    raw[at] = int(rng.integers(256))
                case 1:
                    del raw[at : at + int(rng.integers(1, 60))]
                case 2:
                    raw[at:at] = rng.integers(0, 256, int(rng.integers(1, 60)), dtype=np.uint8).tobytes()
                case _:
                    del raw[max(at, 1) :]
        path.write_bytes(raw)
        try:
            record = read(path)
        except (DataError, OptionError):
            outcomes["refused"] += 1
        else:
            outcomes["read"] += 1
            assert record.provenance.rows <= 60
    assert min(outcomes.values()) > len(turns) / 20
