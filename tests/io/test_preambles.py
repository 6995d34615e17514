"""Lines above a table: of any number, skipped on request, or with a stated rate."""

import gzip
import itertools

import numpy as np
import pytest
from readings import axes

import known
from sigmatau.errors import DataError, OptionError
from sigmatau.io.live import Live
from sigmatau.io.read import read
from sigmatau.io.read.options import TableOptions

N, RATE = 1000, 100.0
STEP = 0.300 / 60 * np.sqrt(RATE)  # deg/s: 0.300 deg/√h at 100 Hz
VALUES = np.random.default_rng(known.seed_of("preambles")).normal(0, STEP, (N, 6)).round(6)
HEADER = "t [s],gyro_x [deg/s],gyro_y [deg/s],gyro_z [deg/s],acc_x [g],acc_y [g],acc_z [g]"
ROWS = [f"{k / RATE:.2f}," + ",".join(map(str, row)) for k, row in enumerate(VALUES.tolist())]

PREAMBLES = {
    "words": lambda k: f"Note {k}: the quick brown fox",
    "keys and numbers": lambda k: f"setting_{k}: {k * 1.5}",
    "keys, commas, numbers": lambda k: f"Channel {k},{k},{k + 0.5}",
    "blank lines": lambda k: "" if k % 3 else f"Section {k}",
    "comments": lambda k: f"# value {k} = {k}",
    "a matrix": lambda k: ",".join(["1.0"] * 7) if 30 <= k < 36 else f"Calibration {k}",
}


def save(path, lines, encoding="utf-8", *, pack=False):
    text = "\n".join([*lines, ""]).encode(encoding)
    path.write_bytes(gzip.compress(text) if pack else text)
    return path


def exact(record, first=0):
    np.testing.assert_allclose(axes(record, "gyro"), VALUES[first:, :3] * np.pi / 180, rtol=1e-15)
    assert record.streams[0].grid.rate == pytest.approx(RATE, rel=1e-9)


@pytest.mark.parametrize(
    ("kind", "count"),
    [("words", 1), *itertools.product(PREAMBLES, (130, 2100)), ("keys, commas, numbers", 30_000)],
)
def test_the_table_is_found(tmp_path, kind, count):
    above = [PREAMBLES[kind](k) for k in range(count)]
    exact(read(save(tmp_path / "log.csv", [*above, HEADER, *ROWS])))


def test_the_lines_above_are_noted(tmp_path):
    record = read(save(tmp_path / "log.csv", ["Lab 3", "", "Unit 7", HEADER, *ROWS]))
    assert "2 lines of text above the header skipped, from line 1" in record.provenance.conversions


# Compressed text in UTF-16 is not read.
@pytest.mark.parametrize(("encoding", "pack"), [("utf-8", False), ("utf-8", True), ("utf-16", False)])
@pytest.mark.parametrize("count", [3, 50_000])
def test_skip(tmp_path, count, pack, encoding):
    """Of a preamble with a table of its own, which is as long as 2000 lines."""
    above = [f"{k},{k + 1}" for k in range(count)]
    path = save(tmp_path / "log.csv", [*above, HEADER, *ROWS], encoding, pack=pack)
    record = read(path, skip=count)
    exact(record)
    assert f"the first {count} lines skipped" in record.provenance.conversions
    assert record.provenance.options == {"skip": count}
    exact(read(path, skip=count + 1 + 10, channels={"time": 1, "gyro": "2:4"}, unit={"time": "s", "gyro": "deg/s"}), 10)


def test_skip_of_bytes_that_are_not_text(tmp_path):
    path = tmp_path / "log.csv"
    path.write_bytes(b"\x00\x01\x17\xff\n" + "\n".join([HEADER, *ROWS, ""]).encode())
    with pytest.raises(DataError, match="binary data"):
        read(path)
    exact(read(path, skip=1))


def test_errors_name_the_line_of_the_file(tmp_path):
    rows = [*ROWS[:100], ROWS[100].replace(".", "x", 2), *ROWS[101:]]
    path = save(tmp_path / "log.csv", ["1,2"] * 7 + [HEADER, *rows])
    with pytest.raises(DataError, match=r"line 109: .*is not a number"):
        read(path, skip=7)


@pytest.mark.parametrize(
    ("skip", "words"), [(-1, "0 or more"), (1.5, "a number of lines"), (True, "a number of lines")]
)
def test_what_skip_is_not(tmp_path, skip, words):
    with pytest.raises(OptionError, match=words):
        read(save(tmp_path / "log.csv", [HEADER, *ROWS]), skip=skip)


def test_skip_refused(tmp_path):
    with pytest.raises(OptionError, match="has fewer than 2001 lines"):
        read(save(tmp_path / "log.csv", [HEADER, *ROWS]), skip=2000)
    np.save(tmp_path / "log.npy", VALUES)
    with pytest.raises(OptionError, match="is for text tables, and this is a NumPy file"):
        read(tmp_path / "log.npy", skip=1)
    (tmp_path / "log.raw").write_bytes(VALUES.tobytes())
    with pytest.raises(OptionError, match="is for text tables; skip bytes by `header`"):
        read(tmp_path / "log.raw", skip=1, layout="6f8 gyro")


def test_live():
    options = TableOptions().checked()
    text = "\n".join([*(f"Warming up: {k} of 130" for k in range(130)), HEADER, *ROWS, ""]).encode()
    for size in (100, 10**6):
        live = Live(options)
        taken = [live.push(text[k : k + size]) for k in range(0, len(text), size)]
        samples = np.concatenate([piece for piece in taken if piece.size])
        np.testing.assert_array_equal(samples, VALUES)
    above = "\n".join(["1,2"] * 70).encode()
    for size in (100, 10**6):
        live, logged = Live(options, skip=70), above + b"\n" + text
        taken = [live.push(logged[k : k + size]) for k in range(0, len(logged), size)]
        np.testing.assert_array_equal(np.concatenate([piece for piece in taken if piece.size]), VALUES)


@pytest.mark.parametrize(
    ("line", "rate"),
    [
        ("// Update Rate: 100.0Hz", 100),
        ("# sampling rate [Hz]: 100", 100),
        ("Sample rate (Hz),100", 100),
        ("Sampling frequency = 100 Hz", 100),
        ("Output_Rate: 60Hz", 60),
        ("Sample rate: 100", None),  # perhaps of another unit
        ("Baud rate: 115200 Hz", None),
    ],
)
def test_a_stated_rate(tmp_path, line, rate):
    header, rows = HEADER.partition(",")[2], [row.partition(",")[2] for row in ROWS]
    path = save(tmp_path / "log.csv", ["Unit 7", line, header, *rows])
    if rate is None:
        with pytest.raises(OptionError, match="--rate HZ"):
            read(path)
        return
    record = read(path)
    assert record.streams[0].grid.rate == rate
    assert record.streams[0].grid.source.line == 2


def test_rates_that_contradict_each_other(tmp_path):
    header, rows = HEADER.partition(",")[2], [row.partition(",")[2] for row in ROWS]
    with pytest.raises(OptionError, match="--rate HZ"):
        read(save(tmp_path / "log.csv", ["Update rate: 100 Hz", "Output rate: 50 Hz", header, *rows]))


COUNTER = (np.arange(N) + (1 << 32) // 100 - 300) * 100 % (1 << 32)  # SampleTimeFine at 100 Hz, 300 rows before 2³²
EMPTY = {
    "in the middle": ("PacketCounter\tSampleTimeFine\tYear\tMonth\tGyr_X\tGyr_Y\tGyr_Z", "{p}\t{t}\t\t\t{x}"),
    "at the end": ("PacketCounter\tSampleTimeFine\tGyr_X\tGyr_Y\tGyr_Z\tStatus\tRSSI", "{p}\t{t}\t{x}\t\t"),
    "a tab at the end": ("PacketCounter\tSampleTimeFine\tGyr_X\tGyr_Y\tGyr_Z\tStatus\t", "{p}\t{t}\t{x}\t\t"),
    "at the beginning": ("Year\tMonth\tSampleTimeFine\tGyr_X\tGyr_Y\tGyr_Z", "\t\t{t}\t{x}"),
    "more than half": ("A\tB\tC\tD\tE\tF\tSampleTimeFine\tGyr_X\tGyr_Y\tGyr_Z", "\t\t\t\t\t\t{t}\t{x}"),
    "commas": ("PacketCounter,SampleTimeFine,Year,Gyr_X,Gyr_Y,Gyr_Z,Status", "{p},{t},,{c},"),
}


@pytest.mark.parametrize("lost", [0, 5])
@pytest.mark.parametrize("kind", EMPTY)
def test_mt_manager_with_empty_columns(tmp_path, kind, lost):
    header, form = EMPTY[kind]
    rows = [
        form.format(
            p=k % 65536, t=COUNTER[k], x="\t".join(map(str, VALUES[k, :3])), c=",".join(map(str, VALUES[k, :3]))
        )
        for k in range(N)
        if not 400 <= k < 400 + lost
    ]
    above = ["// General information:", "//  MT Manager version: 4.6.0", "// Update Rate: 100.0Hz"]
    record = read(save(tmp_path / "log.txt", [*above, header, *rows]), unit={"gyro": "deg/s"})
    grid = record.streams[0].grid
    assert (grid.n, grid.rate) == (N, pytest.approx(RATE, rel=1e-9))
    present = ~np.isnan(axes(record, "gyro")[:, 0])
    assert np.count_nonzero(~present) == lost
    np.testing.assert_allclose(axes(record, "gyro")[present], VALUES[present, :3] * np.pi / 180, rtol=1e-15)


@pytest.mark.parametrize(
    ("per_second", "unit"), [(1_000_000, "us"), (1_000_000, "ns"), (10_000, "s"), (1_000_000, "ms")]
)
def test_a_unit_for_a_counter_that_the_reader_converts(tmp_path, per_second, unit):
    """That of the counts or of the converted stamps adds nothing; another one would give a rate far from the stated one."""
    above = ["OutputRate:,60Hz", "PacketCounter,SampleTimeFine,Gyr_X,Gyr_Y,Gyr_Z"]
    rows = [f"{k},{round(k * per_second / 60)}," + ",".join(map(str, VALUES[k, :3])) for k in range(N)]
    path = save(tmp_path / "log.csv", [*above, *rows])
    units = {"gyro": "deg/s", "time": unit}
    if unit in ("us", "ns"):
        record = read(path, unit=units)
        assert record.streams[0].grid.rate == pytest.approx(60.0, rel=1e-4)
        assert "unit_overruled" not in {finding.code for finding in record.findings}
        return
    with pytest.raises(OptionError, match=rf"time={unit}: .*'SampleTimeFine' counts in .*; leave out the unit of time"):
        read(path, unit=units)


def test_tabs_that_align_are_no_empty_columns(tmp_path):
    rows = ["\t\t".join(row.split(",")) for row in ROWS]
    exact(read(save(tmp_path / "log.txt", [HEADER.replace(",", "\t\t"), *rows])))


def test_one_line_of_all_numbers(tmp_path):
    flat = ",".join(str(x) for row in VALUES[:, :3].tolist() for x in row)
    with pytest.raises(
        DataError, match=r"for samples of 3 numbers: tr -s ',' '\\n' < LOG \| paste -d, - - - > rows\.csv"
    ):
        read(save(tmp_path / "log.csv", [flat]))


def test_a_row_for_each_channel(tmp_path):
    lines = [f"g{a}," + ",".join(map(str, VALUES[:, k])) for k, a in enumerate("xyz")]
    with pytest.raises(
        DataError, match=r"has 3 rows of 1001 fields, so a row is a channel; .* usecols=range\(1, 1001\)"
    ):
        read(save(tmp_path / "log.csv", lines))
