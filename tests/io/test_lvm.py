"""LabVIEW measurement files by the published layout."""

import numpy as np
import pytest
from readings import axes

import known
from container_damage import cut, survives
from sigmatau.errors import DataError, OptionError
from sigmatau.io.read import read

N, RATE = 600, 100.0
STEP = 0.300 / 60 * np.sqrt(RATE)  # deg/s: 0.300 deg/√h at 100 Hz
VALUES = np.random.default_rng(known.seed_of("lvm")).normal(0, STEP, (N, 3)).round(6)


def number(value, comma):
    return f"{value:.6f}".replace(".", ",") if comma else f"{value:.6f}"


def file_header(separator, comma, x):
    tags = [
        ("Writer_Version", "2"),
        ("Reader_Version", "2"),
        ("Separator", "Comma" if separator == "," else "Tab"),
        ("Decimal_Separator", "," if comma else "."),
        ("Multi_Headings", "Yes"),
        ("X_Columns", x),
        ("Time_Pref", "Relative"),
        ("Date", "2026/03/01"),
        ("Time", "12:00:00,5" if comma else "12:00:00.5"),
    ]
    lines = ["LabVIEW Measurement", *(separator.join(tag) for tag in tags)]
    return [*lines, f"***End_of_Header***{separator}", ""]


def segment(rows, separator="\t", *, comma=False, x="One", second=0.5, x0=0.0, note="", delta=0.01, unit="deg/s"):
    tags = {
        "Channels": ["3"],
        "Samples": [str(len(rows))] * 3,
        "Date": ["2026/03/01"] * 3,
        "Time": [f"12:00:{second:09.6f}".replace(".", "," if comma else ".")] * 3,
        "Y_Unit_Label": [unit] * 3,
        "X_Dimension": ["Time"] * 3,
        "X0": [number(x0, comma)] * 3,
        "Delta_X": [number(delta, comma)] * 3,
    }
    lines = [separator.join([tag, *values]) for tag, values in tags.items()]
    names = ["Gyro X", "Gyro Y", "Gyro Z"]
    xs = ["X_Value", names[0], "X_Value", names[1], "X_Value", names[2]] if x == "Multi" else ["X_Value", *names]
    lines += ["***End_of_Header***", separator.join([*xs, "Comment"])]
    for k, row in enumerate(rows):
        time = "" if x == "No" else number(x0 + k * delta, comma)
        values = [number(value, comma) for value in row]
        fields = [f for v in values for f in (time, v)] if x == "Multi" else [time, *values]
        lines.append(separator.join([*fields, note if k == 0 else ""]))
    return [*lines, ""]


def save(path, *segments, separator="\t", comma=False, x="One", end="\r\n"):
    path.write_text(end.join([*file_header(separator, comma, x), *(line for s in segments for line in s)]))
    return path


@pytest.mark.parametrize(
    ("separator", "comma", "x", "end", "note"),
    [
        ("\t", False, "One", "\r\n", "the table, then the lamp"),
        ("\t", False, "Multi", "\n", ""),
        ("\t", True, "No", "\n", "the table, then the lamp"),
        ("\t", True, "Multi", "\r\n", "the table, then the lamp"),
        (",", False, "One", "\n", "the table then the lamp"),
        (",", False, "No", "\r\n", ""),
        (",", False, "Multi", "\r\n", "the table then the lamp"),
    ],
)
def test_every_layout(tmp_path, separator, comma, x, end, note):
    rows = segment(VALUES, separator, comma=comma, x=x, note=note)
    record = read(save(tmp_path / "log.lvm", rows, separator=separator, comma=comma, x=x, end=end))
    np.testing.assert_allclose(axes(record, "gyro"), VALUES * np.pi / 180, rtol=1e-15)
    assert record.streams[0].grid.rate == pytest.approx(RATE, rel=1e-9)
    assert {f.code for f in record.findings} <= {"unused_columns"}  # X_Value of the other channels


@pytest.mark.parametrize("x", ["One", "No"])
def test_segments_that_begin_again_have_the_times_of_their_headers(tmp_path, x):
    parts = [VALUES[:200], VALUES[200:400], VALUES[400:]]
    seconds = [0.5, 2.5, 6.5]  # two seconds are missing after the second segment
    rows = [segment(part, x=x, second=second) for part, second in zip(parts, seconds, strict=True)]
    record = read(save(tmp_path / "log.lvm", *rows, x=x))
    grid = record.streams[0].grid
    assert (grid.n, grid.rate) == (800, pytest.approx(RATE, rel=1e-6))
    missing = np.isnan(axes(record, "gyro")[:, 0])
    assert (np.flatnonzero(missing)[0], np.count_nonzero(missing)) == (400, 200)
    np.testing.assert_allclose(axes(record, "gyro")[~missing], VALUES * np.pi / 180, rtol=1e-15)


def test_segments_whose_times_go_on(tmp_path):
    rows = [segment(VALUES[:300]), segment(VALUES[300:], x0=3.0, second=9.0)]
    record = read(save(tmp_path / "log.lvm", *rows))
    assert record.streams[0].grid.n == N
    assert record.findings == ()


def test_special_blocks_are_passed_over(tmp_path):
    path = save(tmp_path / "log.lvm", segment(VALUES))
    text = path.read_text().replace("Channels\t3", "***Start_Special***\n1,2,3\n4,5,6\n***End_Special***\nChannels\t3")
    path.write_text(text)
    np.testing.assert_allclose(axes(read(path), "gyro"), VALUES * np.pi / 180, rtol=1e-15)


def test_channels_without_a_unit(tmp_path):
    with pytest.raises(OptionError, match="unit of gyro_x, gyro_y, gyro_z"):
        read(save(tmp_path / "log.lvm", segment(VALUES, unit="Volts")))


def test_other_columns_are_another_topic(tmp_path):
    changed = [line.replace("Gyro", "Pressure") for line in segment(VALUES[:100], unit="bar")]
    record = read(save(tmp_path / "log.lvm", changed, segment(VALUES)))
    assert record.provenance.topics == ("segment 2",)
    assert record.streams[0].grid.n == N


def test_intervals_that_differ_are_refused(tmp_path):
    rows = [line.replace("Delta_X\t0.010000", "Delta_X\t0.020000") for line in segment(VALUES)]
    with pytest.raises(DataError, match=r"channels of different intervals \(Delta_X 0\.01, 0\.02 s\)"):
        read(save(tmp_path / "log.lvm", rows))


def test_a_word_among_the_numbers_is_named_with_its_line(tmp_path):
    path = save(tmp_path / "log.lvm", segment(VALUES[:300]), segment(VALUES[300:], x0=3.0))
    lines = path.read_text().splitlines()
    at = len(lines) - 50
    lines[at] = lines[at].replace(".", "x", 2)
    path.write_text("\n".join(lines))
    with pytest.raises(DataError, match=f"line {at + 1}: .*is not a number"):
        read(path)


@pytest.mark.parametrize("share", [0.3, 0.6, 0.999])
def test_cut(tmp_path, share):
    path = save(tmp_path / "log.lvm", segment(VALUES))
    path.write_bytes(cut(path.read_bytes(), share))
    record = read(path)
    n = record.streams[0].grid.n
    assert n > (N - 20) * share - 25
    np.testing.assert_allclose(axes(record, "gyro"), VALUES[:n] * np.pi / 180, rtol=1e-15)
    assert [f.code for f in record.findings] in (["damaged"], ["skipped_lines"])


def test_cut_in_the_header(tmp_path):
    path = save(tmp_path / "log.lvm", segment(VALUES))
    path.write_bytes(path.read_bytes()[:120])
    with pytest.raises(DataError, match="no end of its header"):
        read(path)


@pytest.mark.parametrize("x", ["One", "No", "Multi"])
def test_mutants(tmp_path, x):
    path = save(tmp_path / "log.lvm", segment(VALUES[:40], x=x), segment(VALUES[40:80], x=x, second=1.0), x=x)
    assert survives(f"lvm {x}", path.read_bytes(), path, 150) > 0


def test_a_later_header_of_another_unit_is_a_table_of_its_own(tmp_path):
    path = tmp_path / "log.lvm"
    save(path, segment(VALUES), segment(np.radians(VALUES), second=7.0, unit="rad/s"))
    with pytest.raises(OptionError, match=r"segment 1.*segment 2"):
        read(path)
    for topic in ("segment 1", "segment 2"):
        record = read(path, topic=topic)
        assert len(record.streams[0].column("gyro_x")) == N
        got = record.streams[0].column("gyro_x")
        np.testing.assert_allclose(got, np.radians(VALUES[:, 0]), atol=1e-6)  # rounded in the file
