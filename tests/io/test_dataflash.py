"""ArduPilot logs: bytes made as ArduPilot's own definitions of its messages say."""

import struct

import numpy as np
import pytest
from readings import axes

from container_damage import outcomes
from known import seed_of
from sigmatau.errors import DataError, OptionError
from sigmatau.findings.reading import Place
from sigmatau.io.read import read

LETTERS = {
    "B": "B",
    "b": "b",
    "Q": "Q",
    "f": "f",
    "I": "I",
    "H": "H",
    "c": "h",
    "C": "H",
    "e": "i",
    "E": "I",
    "d": "d",
    "n": "4s",
    "N": "16s",
    "Z": "64s",
}
KINDS = {  # number, letters, fields, units, factors: as libraries/AP_Logger/LogStructure.h has them
    "FMT": (128, "BBnNZ", "Type,Length,Name,Format,Columns", "-b---", "-----"),
    "UNIT": (177, "QbZ", "TimeUS,Id,Label", "s--", "F--"),
    "FMTU": (178, "QBNN", "TimeUS,FmtType,UnitIds,MultIds", "s---", "F---"),
    "MULT": (179, "Qbd", "TimeUS,Id,Mult", "s--", "F--"),
    "IMU": (
        82,
        "QBffffffIIfBBHH",
        "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,EG,EA,T,GH,AH,GHz,AHz",
        "s#EEEooo--O--zz",
        "F-000000-----00",
    ),
    "GYR": (90, "QBQfff", "TimeUS,I,SampleUS,GyrX,GyrY,GyrZ", "s#sEEE", "F-F000"),
    "ACC": (91, "QBQfff", "TimeUS,I,SampleUS,AccX,AccY,AccZ", "s#sooo", "F-F000"),
    "ATT": (92, "Qcc", "TimeUS,Roll,Pitch", "sdd", "FBB"),
    "XKF1": (94, "Qfff", "TimeUS,GX,GY,GZ", "sEEE", "F000"),
    "NAV": (93, "QcCeE", "TimeUS,A,B,C,D", "sdddd", "FBBBB"),
}
N = 400
RNG = np.random.default_rng(seed_of("dataflash"))
VALUES = RNG.normal(size=(2, N, 6)).astype(np.float32)
STAMPS = 987_654_321 + 5000 * np.arange(N)


def message(name, *values):
    number, letters = KINDS[name][:2]
    values = [v.encode() if isinstance(v, str) else v for v in values]
    return b"\xa3\x95" + bytes([number]) + struct.pack("<" + "".join(LETTERS[c] for c in letters), *values)


def definitions(*names, units=True):
    names = ("FMT", *(("UNIT", "FMTU", "MULT") if units else ()), *names)
    out = b""
    for name in names:
        number, letters, fields = KINDS[name][:3]
        length = 3 + struct.calcsize("<" + "".join(LETTERS[c] for c in letters))
        out += message("FMT", number, length, name, letters, fields)
    if units:
        for letter, label in {"s": "s", "E": "rad/s", "o": "m/s/s", "O": "degC", "z": "Hz", "d": "deg"}.items():
            out += message("UNIT", 1, ord(letter), label)
        for letter, factor in {"-": 0.0, "0": 1.0, "F": 1e-6, "B": 1e-2}.items():
            out += message("MULT", 1, ord(letter), factor)
        for name in names:
            out += message("FMTU", 1, KINDS[name][0], *KINDS[name][3:])
    return out


def imu(k, instance=0):
    values = map(float, VALUES[instance, k])
    return message("IMU", STAMPS[k] + 7 * instance, instance, *values, 0, 0, 31.5, 1, 1, 1000, 1000)


@pytest.fixture
def file(tmp_path):
    return tmp_path / "log.dat"  # by content, not by name


@pytest.mark.parametrize("units", [True, False])
def test_imu(file, units):
    log = definitions("IMU", "ATT", units=units) + b"".join(
        imu(k) + message("ATT", STAMPS[k], 100, -50) for k in range(N)
    )
    file.write_bytes(log)
    record = read(file)
    np.testing.assert_array_equal(axes(record, "gyro"), VALUES[0, :, :3].astype(float))
    np.testing.assert_array_equal(axes(record, "accel"), VALUES[0, :, 3:].astype(float))
    assert record.streams[0].grid.rate == pytest.approx(200, rel=1e-12)  # TimeUS, and not T, which is a temperature
    assert record.findings == ()
    assert (record.provenance.format, record.provenance.topics) == ("dataflash", ("IMU[0]",))
    hundredths = read(
        file, topic="ATT", channels={"roll": "Roll", "pitch": "Pitch"}, unit={"roll": "deg", "pitch": "deg"}
    )
    assert (hundredths.stream_of("roll").column("roll") == 1.0).all()
    assert (hundredths.stream_of("pitch").column("pitch") == -0.5).all()


def test_hundredths(file):
    """LogStructure.h: the types c, C, e and E are integers in hundredths, whatever their factor."""
    file.write_bytes(definitions("NAV") + b"".join(message("NAV", STAMPS[k], -50, 50, -75, 75) for k in range(N)))
    record = read(
        file, topic="NAV", channels={name: name.upper() for name in "abcd"}, unit=dict.fromkeys("abcd", "deg")
    )
    assert [set(record.stream_of(name).column(name)) for name in "abcd"] == [{-0.5}, {0.5}, {-0.75}, {0.75}]


def test_instances_are_topics(file):
    file.write_bytes(definitions("IMU") + b"".join(imu(k, i) for k in range(N) for i in (0, 1)))
    with pytest.raises(OptionError, match=r"several sensors: IMU\[0\] \(gyro and accel, 400 rows\), IMU\[1\]"):
        read(file)
    record = read(file, topic="IMU[1]")
    np.testing.assert_array_equal(axes(record, "accel"), VALUES[1, :, 3:].astype(float))


def test_raw_samples(file):
    log = definitions("GYR", "ACC")
    for k in range(N):
        sample, values = STAMPS[k], list(map(float, VALUES[0, k]))
        log += message("GYR", sample + 900 * (k % 3), 0, sample, *values[:3])
        if k % 2 == 0:
            log += message("ACC", sample + 950, 0, sample, *values[3:])
    file.write_bytes(log)
    record = read(file)
    np.testing.assert_array_equal(axes(record, "gyro"), VALUES[0, :, :3].astype(float))
    np.testing.assert_array_equal(axes(record, "accel"), VALUES[0, ::2, 3:].astype(float))
    assert [round(s.grid.rate, 6) for s in record.streams] == [200, 100]
    assert record.findings == ()
    assert record.provenance.topics == ("GYR[0]", "ACC[0]")


def test_units_that_the_file_defines_hold(file):
    log = definitions("IMU")
    unit = message("UNIT", 1, ord("E"), "rad/s")
    assert unit in log
    file.write_bytes(log.replace(unit, message("UNIT", 1, ord("E"), "deg/s")) + b"".join(map(imu, range(N))))
    np.testing.assert_array_equal(axes(read(file), "gyro"), VALUES[0, :, :3].astype(float) * (np.pi / 180))
    # A factor that has no name: the unit is asked for.
    fmtu = message("FMTU", 1, 82, *KINDS["IMU"][3:])
    assert fmtu in log
    scaled = message("FMTU", 1, 82, KINDS["IMU"][3], "F-BBB000-----00")
    file.write_bytes(log.replace(fmtu, scaled) + b"".join(map(imu, range(N))))
    with pytest.raises(OptionError, match="does not state the unit of gyro_x"):
        read(file)


def test_not_a_number(file):
    log = bytearray(definitions("IMU") + b"".join(map(imu, range(N))))
    row = len(imu(0))
    log[-10 * row + 12 : -10 * row + 16] = struct.pack("<f", np.inf)
    file.write_bytes(log)
    (finding,) = read(file).findings
    assert (finding.code, finding.size) == ("missing_values", 1)
    assert finding.details.place == "message 391 of IMU[0]"


@pytest.mark.parametrize("part", [0.2, 0.5, 0.99])
def test_cut(file, part):
    head, row = definitions("IMU"), len(imu(0))
    whole = head + b"".join(map(imu, range(N)))
    length = int(part * len(whole))
    rows, rest = divmod(length - len(head), row)
    assert rest
    file.write_bytes(whole[:length])
    record = read(file)
    assert record.provenance.rows == rows
    np.testing.assert_array_equal(axes(record, "gyro"), VALUES[0, :rows, :3].astype(float))
    (finding,) = record.findings
    assert (finding.code, finding.severity) == ("damaged", "error")
    assert finding.details.place == Place("byte", length - rest, of=length)


def test_a_flipped_page(file):
    head, row = definitions("IMU"), len(imu(0))
    whole = bytearray(head + b"".join(map(imu, range(N))))
    whole[8192:12288] = bytes(b ^ 0xFF for b in whole[8192:12288])
    file.write_bytes(whole)
    record = read(file)
    rows = (8192 - len(head)) // row  # without the message that reaches into the page
    assert record.provenance.rows == rows
    np.testing.assert_array_equal(axes(record, "accel"), VALUES[0, :rows, 3:].astype(float))
    (finding,) = record.findings
    assert (finding.code, finding.severity) == ("damaged", "error")


def test_refused(file):
    whole = definitions("IMU") + imu(0)
    for log, words in (
        (whole[:60], "without data: the file is truncated at byte 0 of 60, inside a message"),
        (definitions("IMU", units=False)[:89], "without data"),
        (b"\xa3\x95\x52" + bytes(300), "without data: .*kind 82, which is not defined"),
        (whole[:90].replace(b"BBnNZ", b"BBnN\xff"), "a definition that is not text"),
        (whole[:90].replace(b"BBnNZ", b"BBnNQ"), "FMT defined as 89 bytes with 5 names"),
        (whole[:90].replace(b"BBnNZ", b"BBnN?"), "unknown type '\\?'"),
    ):
        file.write_bytes(log)
        with pytest.raises(DataError, match=words):
            read(file)


def test_mutations(file):
    """No other error than ours, and no end of reading, whatever bytes are changed."""
    rng = np.random.default_rng(seed_of("dataflash mutations"))
    rows = b"".join(map(imu, range(20)))
    raw = b"".join(message("GYR", STAMPS[k], 0, STAMPS[k], *map(float, VALUES[0, k, :3])) for k in range(20))
    logs = [definitions("IMU") + rows, definitions("IMU", units=False) + rows, definitions("GYR") + raw]
    assert outcomes(rng, logs, file) >= {"read", "told", "DataError"}


def test_filler_behind_the_last_message(file):
    for byte in b"\0", b"\xff":
        file.write_bytes(definitions("IMU") + b"".join(map(imu, range(N))) + byte * 5000)
        record = read(file)
        np.testing.assert_array_equal(axes(record, "gyro"), VALUES[0, :, :3].astype(float))
        assert [(f.code, f.severity) for f in record.findings] == [("bytes_not_read", "info")]


def test_a_kind_that_is_defined_under_two_numbers(file):
    number, letters, fields = KINDS["IMU"][:3]
    length = len(imu(0))
    again = message("FMT", number + 100, length, "IMU", letters, fields)
    rows = b"".join(imu(k) for k in range(N))
    others = b"".join(b"\xa3\x95" + bytes([number + 100]) + imu(k, 1)[3:] for k in range(N))
    file.write_bytes(definitions("IMU", units=False) + again + rows + others)
    with pytest.raises(OptionError, match=r"IMU\[0\] of kind 82 .*IMU\[1\] of kind 182"):
        read(file)
    np.testing.assert_array_equal(axes(read(file, topic="of kind 182"), "accel"), VALUES[1, :, 3:].astype(float))


@pytest.mark.parametrize("units", [True, False])
def test_biases_of_a_filter_are_no_gyro(file, units):
    rows = b"".join(message("XKF1", t, *values) for t, values in zip(STAMPS, VALUES[0, :, :3].tolist(), strict=True))
    file.write_bytes(definitions("XKF1", units=units) + rows)
    with pytest.raises(OptionError, match=r"GX bias|has no IMU"):
        read(file)
    file.write_bytes(definitions("XKF1", "IMU", units=units) + rows + b"".join(map(imu, range(N))))
    assert read(file).provenance.topics[0].startswith("IMU")
