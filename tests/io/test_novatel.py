"""NovAtel's raw logs: lines printed in the manual, and messages built from its tables with a CRC-32 of our own."""

import struct

import numpy as np
import pytest

from container_damage import mutants
from known import seed_of
from sigmatau.errors import DataError, OptionError
from sigmatau.io.read import read
from sigmatau.io.read.formats import novatel

N = 100
COUNTS = np.random.default_rng(seed_of("novatel")).integers(-(2**20), 2**20, size=(N, 6))

# docs.novatel.com, OEM7, RAWIMUSX and RAWIMUS: the examples; and one of the tests of NovAtel's own decoder
PRINTED = [
    b"%RAWIMUSXA,2209,491674.014;04,41,2209,491674.013699,ea59fe00,329308016,-2706935,4508389,196192,417138,-1000837*038422a7",
    b"%RAWIMUSA,2209,491612.254;2209,491612.253588,ea5afe00,329303960,-2512321,4410363,309705,607017,-1009773*1fb76c28",
    b"%RAWIMUSXA,1692,484620.664;00,11,1692,484620.664389000,00801503,43110635,-817242,-202184,-215194,-41188,-9895*a5db8c7b",
]


def crc32(data):
    """As the manual's C code: bit by bit."""
    crc = 0
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0xEDB88320 if crc & 1 else 0)
    return crc


def binary(name, i, kind=11):
    seconds, counts = 1000 + i / 100, COUNTS[i].tolist()
    if name.endswith("X"):
        body = struct.pack("<BBHdI6i", 0, kind, 2209, seconds, 0, *counts)
    else:
        body = struct.pack("<IdI6i", 2209, seconds, 0, *counts)
    number = {"RAWIMU": 268, "RAWIMUS": 325, "RAWIMUX": 1461, "RAWIMUSX": 1462}[name]
    if "S" in name:
        header = struct.pack("<3sBHHi", b"\xaaD\x13", len(body), number, 2209, round(1000 * seconds))
    else:
        header = struct.pack("<3sBHBBHHBBHiIHH", b"\xaaD\x12", 28, number, 0, 32, len(body), 0, 0, 0, 2209, 0, 0, 0, 0)
    return header + body + struct.pack("<I", crc32(header + body))


def ascii_(name, i, kind=11):
    seconds = f"{1000 + i / 100:.9f}"
    info = f"00,{kind:02d}," if name.endswith("X") else ""
    counts = ",".join(map(str, COUNTS[i]))
    head = (
        f"{name}A,2209,1000.0" if "S" in name else f"{name}A,COM1,0,68.5,FINESTEERING,2209,1000.0,024c0040,6125,30019"
    )
    body = f"{head};{info}2209,{seconds},00000077,{counts}"
    return f"{'%' if 'S' in name else '#'}{body}*{crc32(body.encode()):08x}\r\n".encode()


def check(record, rows=slice(None), angle=2.0**-33, velocity=2.0**-27 * 0.3048):
    # x, y, z of the log are its last, minus its second, its first
    for sensor, first, scale in (("gyro", 3, angle), ("accel", 0, velocity)):
        for axis, k, sign in (("x", 2, 1), ("y", 1, -1), ("z", 0, 1)):
            got = record.stream_of(f"{sensor}_{axis}").column(f"{sensor}_{axis}")
            np.testing.assert_allclose(
                got[~np.isnan(got)], COUNTS[rows, first + k] * (sign * scale * 100.0), rtol=1e-12
            )


@pytest.mark.parametrize("line", PRINTED)
def test_printed_lines(line):
    assert novatel.sniff(line + b"\r\n", None)
    assert not novatel.sniff(line[:-12] + bytes([line[-12] ^ 1]) + line[-11:] + b"\r\n", None)


@pytest.mark.parametrize("make", [ascii_, binary])
@pytest.mark.parametrize("name", ["RAWIMUX", "RAWIMUSX"])
def test_with_the_type(tmp_path, name, make):
    path = tmp_path / "log.gps"
    path.write_bytes(b"".join(make(name, i) for i in range(N)))
    record = read(path, input="increments")
    check(record)
    assert [s.grid.rate for s in record.streams] == pytest.approx([100, 100], rel=1e-12)
    assert record.findings == ()
    assert any("HG1700 AG58" in c for c in record.provenance.conversions)
    with pytest.raises(OptionError, match="--input increments"):
        read(path)


# OEM7 manual, "Raw IMU Scale Factors": one count in rad and in m/s
MANUAL = {
    5: (2.0**-33, 2.0**-27 * 0.3048),
    8: (2.0**-19, 2.0**-14),
    12: (2.0**-33, 2.0**-26 * 0.3048),
    26: (1e-9, 2e-8),
    32: (2.0**-21 * np.pi / 180, 2.0**-22),
    58: (2.0**-33, 2.0**-29),
}


@pytest.mark.parametrize("kind", MANUAL)
def test_scales_of_the_manual(tmp_path, kind):
    path = tmp_path / "log.gps"
    path.write_bytes(b"".join(binary("RAWIMUSX", i, kind) for i in range(N)))
    check(read(path, input="increments"), angle=MANUAL[kind][0], velocity=MANUAL[kind][1])


def test_the_end_of_a_week(tmp_path):
    """A week has 604800 s: the seconds begin again, the time goes on."""
    path = tmp_path / "log.gps"
    lines = []
    for i in range(N):
        week, seconds = divmod(2210 * 604_800_00 - N // 2 + i, 604_800_00)
        counts = ",".join(map(str, COUNTS[i]))
        body = f"RAWIMUSXA,{week},{seconds / 100:.3f};00,11,{week},{seconds / 100:.6f},00000077,{counts}"
        lines.append(f"%{body}*{crc32(body.encode()):08x}\r\n")
    path.write_text("".join(lines), newline="")
    record = read(path, input="increments")
    check(record)
    assert record.findings == ()
    assert [s.grid.rate for s in record.streams] == pytest.approx([100, 100], rel=1e-9)


@pytest.mark.parametrize("make", [ascii_, binary])
@pytest.mark.parametrize(("name", "kind"), [("RAWIMU", 11), ("RAWIMUS", 11), ("RAWIMUSX", 99)])
def test_without_a_known_scale(tmp_path, name, kind, make):
    path = tmp_path / "log.gps"
    path.write_bytes(b"".join(make(name, i, kind) for i in range(N)))
    with pytest.raises(OptionError, match="--unit gyro=rad"):
        read(path, input="increments")
    record = read(path, input="increments", unit={"gyro": "rad", "accel": "m/s"}, scale={"gyro": 0.5, "accel": 0.25})
    check(record, angle=0.5, velocity=0.25)


@pytest.mark.parametrize("make", [ascii_, binary])
@pytest.mark.parametrize("part", [0.1, 0.5, 0.99])
def test_cut_and_broken(tmp_path, part, make):
    path = tmp_path / "log.gps"
    messages = [make("RAWIMUSX", i) for i in range(N)]
    ends = np.cumsum([0, *map(len, messages)])
    whole = b"".join(messages)
    cut = int(part * len(whole)) + 5
    path.write_bytes(whole[:cut])
    record = read(path, input="increments")
    check(record, slice(int(np.searchsorted(ends, cut, side="right")) - 1))
    assert ("damaged", "error") in [(f.code, f.severity) for f in record.findings]
    raw = bytearray(whole)
    at = int(part * (N - 2))
    raw[ends[at] + 40] ^= 2
    path.write_bytes(raw)
    record = read(path, input="increments", rate=100)
    check(record, np.delete(np.arange(N), at))
    # A message that is lost between others leaves its place empty.
    assert np.flatnonzero(np.isnan(record.streams[0].column("gyro_y"))).tolist() == [at]
    assert ("skipped_messages", "error") in [(f.code, f.severity) for f in record.findings]


@pytest.mark.parametrize("make", [ascii_, binary])
def test_mutated_files(tmp_path, make):
    rng = np.random.default_rng(seed_of("mutated novatel"))
    path = tmp_path / "log.gps"
    whole = b"".join(make("RAWIMUSX", i) for i in range(30))
    known = {int(c) for c in COUNTS[:30, 5]}
    for _ in mutants(100):
        raw = bytearray(whole)
        for _ in range(int(rng.integers(1, 12))):
            at = int(rng.integers(len(raw)))
            raw[at] = int(rng.integers(256))
            if rng.integers(3) == 0:
                del raw[at : at + int(rng.integers(1, 100))]
        path.write_bytes(raw)
        try:
            record = read(path, input="increments", rate=1)
        except (DataError, OptionError):
            continue
        got = record.stream_of("gyro_x").column("gyro_x") / 2.0**-33
        assert set(np.rint(got[~np.isnan(got)]).astype(int).tolist()) <= known


@pytest.mark.parametrize("make", [ascii_, binary])
def test_other_logs_before_and_between(tmp_path, make):
    path = tmp_path / "log.gps"
    other = b"#BESTPOSA,COM1,0,68.5,FINESTEERING,2209,1000.0,024c0040,6125,30019;1,2*00000000\r\n"
    path.write_bytes(other * 10_000 + b"".join(make("RAWIMUSX", i) + other * (i == 50) for i in range(N)))
    record = read(path, input="increments")
    check(record)
    assert not [f for f in record.findings if f.severity == "error"]
