"""Raw binary files, packed by Python's struct."""

import struct

import numpy as np
import pytest

from known import seed_of
from sigmatau.cli import main
from sigmatau.errors import DataError, OptionError
from sigmatau.io.read import read

N = 100
RNG = np.random.default_rng(seed_of("raw"))
VALUES = RNG.normal(size=(N, 6)).astype(np.float32)
LAYOUT = "<u4 time[us],3f4 gyro[rad/s],3f4 accel[m/s^2]"


def packed(form, extra=()):
    return b"".join(struct.pack(form, 5000 * i, *extra, *map(float, row)) for i, row in enumerate(VALUES))


def check(record, rows=N):
    for k, channel in enumerate(f"{s}_{a}" for s in ("gyro", "accel") for a in "xyz"):
        np.testing.assert_array_equal(record.stream_of(channel).column(channel), VALUES[:rows, k].astype(float))
    assert [s.grid.rate for s in record.streams] == pytest.approx([200, 200], rel=1e-12)


@pytest.mark.parametrize(
    ("layout", "form", "header"),
    [
        (LAYOUT, "<I6f", 0),
        (" < u4 time [us] , 3 f4 gyro [rad/s] , 3F4 accel [m/s^2] ", "<I6f", 0),
        (LAYOUT.replace("<", ">"), ">I6f", 0),
        ("<u8 time[us],3f8 gyro[rad/s],3f8 accel[m/s^2]", "<Q6d", 0),
        ("header 7," + LAYOUT, "<I6f", 7),
        ("2x,<i8 time[us],x,f4 wx[rad/s],f4 wy[rad/s],f4 wz[rad/s],3f4 accel[m/s^2],4x", "<2xqx6f4x", 0),
    ],
)
def test_layouts(tmp_path, layout, form, header):
    path = tmp_path / "log.bin"
    path.write_bytes(b"\xff" * header + packed(form))
    record = read(path, layout=layout)
    check(record)
    assert record.findings == ()
    assert record.provenance.format == "raw"
    assert f"{N} rows of {struct.calcsize(form)} bytes" in record.provenance.conversions[0]


def test_integers(tmp_path):
    path = tmp_path / "log.bin"
    counts = RNG.integers(-(2**15), 2**15, size=(N, 3))
    path.write_bytes(b"".join(struct.pack(">3hB", *row, 7) for row in counts.tolist()))
    record = read(path, layout=">3i2 gyro[deg/s],u1 status", rate=100, scale={"gyro": 0.5})
    np.testing.assert_array_equal(record.stream_of("gyro_y").column("gyro_y"), counts[:, 1] * (0.5 * (np.pi / 180)))


@pytest.mark.parametrize("part", [0.1, 0.5, 0.99])
def test_cut(tmp_path, part):
    path = tmp_path / "log.bin"
    whole = packed("<I6f")
    cut = int(part * len(whole)) // 28 * 28 + 5
    path.write_bytes(whole[:cut])
    record = read(path, layout=LAYOUT)
    check(record, cut // 28)
    (finding,) = record.findings
    assert (finding.code, finding.severity) == ("damaged", "error")
    assert (finding.details.reason, finding.details.kept) == ("5 of 28 bytes", cut // 28)


def test_refused(tmp_path):
    path = tmp_path / "log.bin"
    path.write_bytes(packed("<I6f"))
    with pytest.raises(DataError, match="is binary data"):
        read(path)
    for layout, words in {
        "": "must be text",
        "u4 time": "low byte",
        "<u3 time": "a field has a count",
        "<f2 gyro": "unknown type f2",
        "<u4": "a field has a count",
        "<0f4 gyro": "from 1 to",
        "<99999999999f4 gyro": "from 1 to",
        "<999999999f4 gyro": "1 MiB",
        "4x": "no fields",
        "<f4 x,header 4": "a field has a count",
    }.items():
        with pytest.raises(OptionError, match=words) as caught:
            read(path, layout=layout)
        assert caught.value.option == "layout"
    with pytest.raises(DataError, match="too few for a row of 28 bytes after a header of 9000"):
        read(path, layout="header 9000," + LAYOUT)
    raw = bytearray(packed("<I6f"))
    raw[28 * 3 + 4 : 28 * 3 + 8] = struct.pack("<f", float("inf"))
    path.write_bytes(raw)
    assert [f.details.place for f in read(path, layout=LAYOUT).findings] == ["row 3"]


def test_random_layouts(tmp_path):
    """Words of the language in any order: an answer or an error of ours."""
    path = tmp_path / "log.bin"
    path.write_bytes(packed("<I6f"))
    words = [
        "<",
        ">",
        "3",
        "f4",
        "u8",
        "x",
        "12x",
        " ",
        ",",
        "gyro",
        "[rad/s]",
        "time[us]",
        "header 4",
        "[",
        "]",
        "i1 a",
    ]
    outcomes = {"read": 0, "refused": 0}
    for _ in range(400):
        layout = "".join(RNG.choice(words, int(RNG.integers(1, 12))))
        try:
            read(path, layout=layout, rate=100)
        except (DataError, OptionError):
            outcomes["refused"] += 1
        else:
            outcomes["read"] += 1
    assert outcomes["refused"] > 200


@pytest.mark.parametrize(
    "command", [["analyze", "--at-rest"], ["deviation", "--kind", "hadamard"]], ids=["analyze", "deviation"]
)
def test_command_line(tmp_path, capsys, command):
    path = tmp_path / "log.bin"
    path.write_bytes(packed("<I6f"))
    assert main([*command, str(path), "--layout", LAYOUT]) == 0
    assert "gyro_x" in capsys.readouterr().out
    assert main([*command, str(path), "--layout", "u4 time"]) == 2
    assert "low byte" in capsys.readouterr().err
