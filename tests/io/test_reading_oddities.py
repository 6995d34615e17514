"""Logs that are laid out as few are: what is read, and what is said of what cannot be."""

import gzip

import numpy as np
import pytest

import sigmatau as st
from sigmatau.errors import DataError, OptionError
from sigmatau.io.read import read

N = 400
UNITS = {"gyro": "deg/s", "accel": "g"}
RNG = np.random.default_rng(7)
VALUES = np.round(np.column_stack([RNG.normal(0, 0.1, (N, 3)), RNG.normal([0, 0, 1], 0.01, (N, 3))]), 4)
ROWS = [",".join(map(str, row)) for row in VALUES.tolist()]
NAMES = "gx,gy,gz,ax,ay,az"


def text(tmp_path, *lines):
    path = tmp_path / "log.csv"
    path.write_text("\n".join(lines) + "\n")
    return path


def samples(record):
    return np.column_stack([record.stream_of(c).column(c) for c in ("gyro_x", "gyro_y", "gyro_z")]) * 180 / np.pi


@pytest.mark.parametrize(
    "above",
    [
        ["0.0012,0.0012,0.0012,9.80665,9.80665,9.80665", NAMES],  # scales above the names
        [NAMES, "48.7,11.5,530.0,2026.0,3.0,1.0"],  # a position and a date below them
        ["48.7,11.5,530.0,2026.0,3.0,1.0"],
        ["48.7 11.5", NAMES],
    ],
)
def test_numbers_above_the_samples(tmp_path, above):
    named = NAMES in above
    channels = None if named else {"gyro": "1:3", "accel": "4:6"}
    record = read(text(tmp_path, *above, *ROWS), rate=100, unit=UNITS, channels=channels)
    np.testing.assert_allclose(samples(record), VALUES[:, :3], rtol=1e-12)


def test_scales_above_counts(tmp_path):
    counts = [",".join(map(str, row)) for row in RNG.integers(-200, 200, (N, 6)).tolist()]
    record = read(text(tmp_path, NAMES, ",".join(["0.00061"] * 6), *counts), rate=100, unit=UNITS)
    assert record.streams[0].grid.n == N
    assert "line 2 skipped: its numbers are not those of a sample" in record.provenance.conversions


def test_a_first_sample_is_kept(tmp_path):
    """Whatever it is: a row without a sample, a knock, noise alone."""
    for first in ("0,0,0,0,0,0", "9,9,0,0,0,1", ROWS[0]):
        assert read(text(tmp_path, NAMES, first, *ROWS), rate=100, unit=UNITS).streams[0].grid.n == N + 1


@pytest.mark.parametrize(
    "header",
    [
        ["gyro,gyro,gyro,accel,accel,accel", "x,y,z,x,y,z"],
        ["Gyroscope,,,Accelerometer,,", "X,Y,Z,X,Y,Z"],
        ["Gyroscope,,,Accelerometer,,", "X,Y,Z,X,Y,Z", "deg/s,deg/s,deg/s,g,g,g"],
    ],
)
def test_names_and_axes_on_two_lines(tmp_path, header):
    unit = None if len(header) == 3 else UNITS
    record = read(text(tmp_path, *header, *ROWS), rate=100, unit=unit)
    assert record.channels == ("gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z")
    np.testing.assert_allclose(samples(record), VALUES[:, :3], rtol=1e-12)


@pytest.mark.parametrize("separator", [",", " ", "\t"])
@pytest.mark.parametrize("swapped", [False, True])
def test_date_and_time_in_two_columns(tmp_path, separator, swapped):
    stamps = np.datetime64("2026-03-01T23:59:59.000") + np.arange(N) * np.timedelta64(10, "ms")  # past midnight
    rows = []
    for stamp, row in zip(stamps, ROWS, strict=True):
        day, clock = str(stamp).split("T")
        rows.append(separator.join([*([clock, day] if swapped else [day, clock]), *row.split(",")]))
    names = ["Time", "Date"] if swapped else ["Date", "Time"]
    record = read(text(tmp_path, separator.join([*names, *NAMES.split(",")]), *rows), unit=UNITS)
    assert record.streams[0].grid.rate == pytest.approx(100, rel=1e-9)
    assert record.streams[0].grid.n == N
    assert not record.findings


def test_a_time_of_day_alone(tmp_path):
    rows = [f"12:00:{k / 100:09.6f},{row}" for k, row in enumerate(ROWS)]
    record = read(text(tmp_path, f"Time,{NAMES}", *rows), unit=UNITS)
    assert record.streams[0].grid.rate == pytest.approx(100, rel=1e-9)


def test_axes_by_number(tmp_path):
    log = text(tmp_path, "Time,accl0,accl1,accl2,rot0,rot1,rot2", *(f"{k / 100},{row}" for k, row in enumerate(ROWS)))
    record = read(log, unit={"accel": "g", "gyro": "rad/s", "time": "s"})
    assert record.channels == ("gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z")
    assert record.stream_of("accel_x").column("accel_x")[0] == pytest.approx(VALUES[0, 0] * 9.80665)
    with pytest.raises(OptionError, match="has no column with a known name"):  # perhaps four units, or a norm
        read(text(tmp_path, "rot0,rot1,rot2,rot3", *(row.rsplit(",", 2)[0] for row in ROWS)), rate=100)


def test_rates_beside_increments(tmp_path):
    names = "gyro_x,gyro_y,gyro_z,DeltaAngleX,DeltaAngleY,DeltaAngleZ"
    log = text(tmp_path, names, *ROWS)
    record = read(log, rate=100, unit={"gyro": "deg/s"})
    np.testing.assert_allclose(samples(record), VALUES[:, :3], rtol=1e-12)
    note = "DeltaAngleX, DeltaAngleY, DeltaAngleZ not read: increments of channels that also have rates"
    assert note in record.provenance.conversions
    record = read(log, rate=100, unit={"gyro": "deg"}, input="increments")
    np.testing.assert_allclose(samples(record), VALUES[:, 3:] * 100, rtol=1e-12)


@pytest.mark.parametrize("spelled", ["ug*s", "µg·s", "ug s"])
def test_increments_of_velocity_in_g_seconds(spelled):
    assert st.units.find(spelled).factor == pytest.approx(9.80665e-6)
    assert st.units.find(spelled).si == "m/s"


def test_counts_need_a_scale(tmp_path):
    with pytest.raises(OptionError, match=r"gyro_x: counts need a scale; .*--scale gyro=0\.01"):
        read(text(tmp_path, "gyro_x", "1", "2", "3", "4", "5"), rate=1, unit={"gyro": "counts"})
    with pytest.raises(OptionError, match="--scale"):
        read(text(tmp_path, "gyro_x [counts]", "1", "2", "3", "4", "5"), rate=1)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n", "git lfs pull"),
        (b"<!DOCTYPE html>\n<html><body>404</body></html>\n", "a web page"),
        (b'\n<?xml version="1.0"?>\n<html xmlns="x">', "a web page"),
        (b"# a\n" * 200_000 + b"gyro_x\n1\n", "only comments and blank lines in its first 256 KiB; .* --skip N"),
        (b"\n" * 300_000 + b"gyro_x\n1\n", "only blank lines in its first 256 KiB; .* --skip N"),
        (b"\n", "has only blank lines$"),
        (
            b"1.5," * 100_000,
            "the first line is longer than 256 KiB, all of it numbers. Write each sample on its own line",
        ),
        (b"1.5 " * 1000, "all of it numbers"),
        (b"gyro_x,gyro_y\n" + b"1.5," * 100_000, "the second line is longer than .*, all of it numbers"),
        (b"gyro_x,gyro_y\n" + b"x" * 400_000, "the second line is longer than .*, so this is not a text table"),
    ],
)
@pytest.mark.parametrize("packed", [False, True])
def test_what_is_no_table_is_named(tmp_path, content, words, packed):
    path = tmp_path / "log.csv"
    path.write_bytes(gzip.compress(content) if packed else content)
    with pytest.raises(DataError, match=words):
        read(path, rate=100)


def test_gravity_on_the_gyro_is_told(tmp_path):
    log = text(tmp_path, NAMES, *ROWS)
    right = read(log, rate=100, unit=UNITS)
    exchanged = read(log, rate=100, unit=UNITS, channels={"gyro": "4:6", "accel": "1:3"})
    assert "gravity_on_gyro" not in {f.code for f in right.findings}
    (finding,) = (f for f in exchanged.findings if f.code == "gravity_on_gyro")
    assert (finding.severity, finding.details.gyro) == ("warning", pytest.approx(1, abs=0.01))


def test_names_that_readings_have(tmp_path):
    names = "accReading_x,accReading_y,accReading_z,gyroReading_x,gyroReading_y,gyroReading_z"
    record = read(text(tmp_path, names, *ROWS), rate=100, unit=UNITS)
    assert record.stream_of("accel_x").column("accel_x")[0] == pytest.approx(VALUES[0, 0] * 9.80665)
