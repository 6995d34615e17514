"""VectorNav's lines, made here from the manual: XOR or CRC-16 of what stands between $ and *."""

import binascii
import functools
import gzip

import numpy as np
import pytest
from readings import axes

from container_damage import mutants
from known import seed_of
from sigmatau.errors import DataError, OptionError
from sigmatau.findings.reading import Place
from sigmatau.io.read import read

N = 200
VALUES = np.random.default_rng(seed_of("vectornav")).normal(size=(N, 13)).round(4)


def sentence(name, values, *, crc=False, appended=""):
    body = ",".join([name, *("nan" if np.isnan(v) else f"{v:+09.4f}" for v in values)]) + appended
    xor = 0
    for byte in body.encode():
        xor ^= byte
    # crc_hqx is CRC-16 with 0x1021, beginning with 0
    return f"${body}*{binascii.crc_hqx(body.encode(), 0):04X}\r\n" if crc else f"${body}*{xor:02X}\r\n"


def check(record, gyro, accel, rows):
    for name, first in (("gyro", gyro), ("accel", accel)):
        for k, axis in enumerate("xyz"):
            got = record.stream_of(f"{name}_{axis}").column(f"{name}_{axis}")
            np.testing.assert_array_equal(got, VALUES[rows, first + k])


SENTENCES = {
    # name: fields, where gyro and accelerometer begin
    "VNYMR": (12, 9, 6),
    "VNQMR": (13, 10, 7),
    "VNMAR": (9, 6, 3),
    "VNIMU": (11, 6, 3),
    "VNCMV": (10, 6, 3),
}


@pytest.mark.parametrize(("crc", "appended"), [(False, ""), (True, ",S000012"), (True, ",T0001,S000012")])
@pytest.mark.parametrize("name", SENTENCES)
def test_sentences(saved, name, crc, appended):
    width, gyro, accel = SENTENCES[name]
    path = saved("".join(sentence(name, row[:width], crc=crc, appended=appended) for row in VALUES), "log.txt")
    record = read(path, rate=100)
    check(record, gyro, accel, slice(None))
    assert record.provenance.format == "vectornav"
    assert record.findings == ()


def test_two_kinds_in_one_log(tmp_path):
    path = tmp_path / "log.txt"
    both = [sentence("VNACC", row[:3]) + sentence("VNGYR", row[3:6]) + sentence("VNYPR", row[:3]) for row in VALUES]
    path.write_text("$VNRRG,01,VN-100*5B\r\n" + "".join(both))
    record = read(path, rate=100)
    check(record, 3, 0, slice(None))
    assert record.provenance.topics == ("VNGYR", "VNACC")
    assert {f.severity for f in record.findings} <= {"warning", "info"}  # and that the others are not read


def test_increments(saved):
    path = saved("".join(sentence("VNDTV", [0.01, *row[:6]]) for row in VALUES), "log.txt")
    with pytest.raises(OptionError, match="--input increments"):
        read(path, rate=100)
    record = read(path, rate=100, input="increments")
    np.testing.assert_allclose(
        record.stream_of("gyro_x").column("gyro_x"), VALUES[:, 0] * np.pi / 180 * 100, rtol=1e-15
    )


def log():
    return [sentence("VNYMR", row[:12]).encode() for row in VALUES]


def test_a_broken_first_line_costs_no_row_between_others(tmp_path):
    path = tmp_path / "log.txt"
    path.write_bytes(log()[0][40:] + b"".join(log()[1:]))
    record = read(path, rate=100)
    check(record, 9, 6, slice(1, None))
    assert [(f.code, f.severity) for f in record.findings] == [("skipped_messages", "info")]
    details = record.findings[0].details
    assert (details.count, details.place, details.example) == (1, Place("line", 1), "does not begin with $")


def test_glued_lines_and_nan(tmp_path):
    path = tmp_path / "log.txt"
    lines = log()
    path.write_bytes(b"".join(lines[:50]) + lines[50][:30] + b"".join(lines[51:]))
    record = read(path, rate=100)
    check(record, 9, 6, np.delete(np.arange(N), [50, 51]))
    assert [(f.code, f.severity) for f in record.findings] == [("skipped_messages", "error")]
    assert record.findings[0].details.place == Place("line", 51)
    lines[7] = sentence("VNYMR", [*VALUES[7, :9], np.nan, 0, 0]).encode()
    path.write_bytes(b"".join(lines))
    missing = next(f for f in read(path, rate=100).findings if f.code == "missing_values")
    assert (missing.channel, missing.size) == ("gyro_x", 1)
    assert "row 7" in missing.details.place


@pytest.mark.parametrize("part", [0.1, 0.5, 0.99])
@pytest.mark.parametrize("compressed", [False, True])
def test_cut(tmp_path, part, compressed):
    path = tmp_path / "log.txt"
    whole = b"".join(log())
    raw = gzip.compress(whole) if compressed else whole
    path.write_bytes(raw[: int(part * len(raw)) + 17])
    record = read(path, rate=100)
    rows = record.provenance.rows
    assert 0.7 * part * N - 3 < rows < N
    check(record, 9, 6, slice(rows))
    assert ("damaged", "error") in [(f.code, f.severity) for f in record.findings]


def test_mutated_files(tmp_path):
    rng = np.random.default_rng(seed_of("mutated sentences"))
    path = tmp_path / "log.txt"
    known = {tuple(row) for row in VALUES[:40, 9:12]}
    outcomes = {"read": 0, "refused": 0}
    whole, turns = b"".join(log()[:40]), mutants(120)
    for _ in turns:
        raw = bytearray(whole)
        for _ in range(int(rng.integers(1, 20))):
            at = int(rng.integers(len(raw)))
            if rng.integers(2):
                raw[at] = int(rng.integers(256))
            else:
                del raw[at : at + int(rng.integers(1, 400))]
            if not raw:
                raw = bytearray(b"$")
        path.write_bytes(raw)
        try:
            record = read(path, rate=100)
        except (DataError, OptionError):
            outcomes["refused"] += 1
            continue
        outcomes["read"] += 1
        gyro = axes(record, "gyro")
        # Eight bits let one mutation in 256 pass, if it changes more than one bit.
        assert sum(tuple(row) not in known for row in gyro.tolist()) <= 2
    assert outcomes["read"] > len(turns) / 10


def test_a_sensor_that_was_switched_to_another_sentence(tmp_path):
    def line(body):
        return f"${body}*{functools.reduce(lambda a, b: a ^ b, body.encode()):02X}\r\n"

    own, other = line("VNACC,+1.5,-2.5,+3.5"), line("VNGYR,+0.1,+0.2,+0.3")
    (tmp_path / "log").write_text(own * 200 + other * 300)
    (finding,) = read(tmp_path / "log", topic="VNACC", rate=40).findings
    assert finding.severity == "error"
    said = finding.details
    assert (said.count, said.other, said.example, said.place) == (300, True, "$VNGYR", Place("line", 201))
    (tmp_path / "log").write_text((own + other * 3) * 100)
    (finding,) = read(tmp_path / "log", topic="VNACC", rate=40).findings
    assert finding.severity == "info"
