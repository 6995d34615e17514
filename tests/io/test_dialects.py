"""Text as other programs and apps export it: each in its published form, with at most a unit or a rate given."""

import zipfile

import numpy as np
import pytest
from readings import axes

from known import seed_of
from sigmatau import units
from sigmatau.errors import DataError, OptionError
from sigmatau.io.read import read

N = 40
RNG = np.random.default_rng(seed_of("dialects"))
GYRO = RNG.normal(size=(N, 3)).round(6)
ACCEL = RNG.normal(size=(N, 3)).round(6)
T_NS = 1_403_636_579_758_555_392 + 5_000_000 * np.arange(N)
SI = {"gyro": "rad/s", "accel": "m/s^2"}
DEG = np.pi / 180


def check(record, gyro=GYRO, accel=ACCEL, rate=200.0):
    for sensor, values in (("gyro", gyro), ("accel", accel)):
        if values is None:
            assert sensor not in [s.name for s in record.streams]
            continue
        for axis, column in zip("xyz", values.T, strict=True):
            stream = record.stream_of(f"{sensor}_{axis}")
            np.testing.assert_array_equal(stream.column(f"{sensor}_{axis}"), column)
            # the median of intervals that are whole nanoseconds or rounded decimals
            assert stream.grid.rate == pytest.approx(rate, rel=1e-9)
    assert [finding for finding in record.findings if finding.code != "unused_columns"] == []


def lines(header, rows, separator=",", end="\n"):
    return header + "".join(separator.join(map(str, row)) + end for row in rows)


def rows(first):
    return [(*f, *g, *a) for f, g, a in zip(first, GYRO.tolist(), ACCEL.tolist(), strict=True)]


XSENS = """// General information:
//  MT Manager version: 4.6
//  XDA version: 4.6 revision 54109
// Device information:
//  DeviceId: 0368001A
//  ProductCode: MTi-30-2A5G4
//  Firmware Version: 1.8.2
//  Sample rate: 200.0Hz
//  Coordinate system: ENU
PacketCounter\tSampleTimeFine\tAcc_X\tAcc_Y\tAcc_Z\tGyr_X\tGyr_Y\tGyr_Z\tTemperature\tStatusWord
"""


@pytest.mark.parametrize("end", ["\n", "\r\n", "\t\r\n"])
def test_xsens(tmp_path, end):
    path = tmp_path / "MT_0368001A-000.txt"
    body = [(65500 + i, 50 * i, *ACCEL[i], *GYRO[i], 23.5, "00000007") for i in range(N)]
    path.write_bytes(lines(XSENS.replace("\n", end), body, "\t", end).encode())
    check(read(path, rate=200, unit=SI))
    check(read(path, rate=200))  # the manual of MT Manager states the units
    path.write_bytes(path.read_bytes().replace(b"MT Manager", b"Recorder"))
    with pytest.raises(OptionError, match="--unit gyro="):
        read(path, rate=200)


def phyphox(sensor, unit, times, values, separator=",", comma="."):
    quoted = ["Time (s)", *(f"{sensor} {a} ({unit})" for a in "xyz"), f"Absolute ({unit})"]
    header = separator.join(f'"{name}"' for name in quoted) + "\n"
    body = [(f"{t:.9E}", *(f"{v!r}" for v in xyz), 1.0) for t, xyz in zip(times, values.tolist(), strict=True)]
    text = lines("", body, separator)
    return header + text.replace(".", comma)


@pytest.mark.parametrize(("separator", "comma"), [(",", "."), ("\t", "."), (";", "."), ("\t", ","), (";", ",")])
def test_phyphox_csv(tmp_path, separator, comma):
    path = tmp_path / "Raw Data.csv"
    path.write_text(phyphox("Gyroscope", "rad/s", np.arange(N) / 200, GYRO, separator, comma))
    record = read(path)
    check(record, accel=None)
    assert ("decimal commas" in record.provenance.conversions[0]) == (comma == ",")
    path.write_text(phyphox("Acceleration", "m/s^2", np.arange(N) / 200, ACCEL, separator, comma))
    check(read(path), gyro=None)


def zipped(path, members):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in members.items():
            archive.writestr(name, text)
    return path


def phyphox_zip(path):
    return zipped(
        path,
        {
            "Accelerometer.csv": phyphox("Acceleration", "m/s^2", np.arange(N) / 100, ACCEL),
            "Gyroscope.csv": phyphox("Gyroscope", "rad/s", np.arange(N) / 200, GYRO),
            "meta/device.csv": '"property","value"\n"version","1.1.16"\n"deviceModel","Pixel 7"\n',
            "meta/time.csv": '"event","experiment time","system time"\n"START",0.0E0,1.7E9\n"PAUSE",9.0E0,1.7E9\n',
        },
    )


def test_phyphox_zip(tmp_path):
    record = read(phyphox_zip(tmp_path / "Inertia 2026-01-01 12-00-00.zip"))
    assert [round(s.grid.rate, 6) for s in record.streams] == [200.0, 100.0]
    for sensor, values in (("gyro", GYRO), ("accel", ACCEL)):
        np.testing.assert_array_equal(axes(record, sensor), values)
    assert sorted(record.provenance.topics) == ["Accelerometer.csv", "Gyroscope.csv"]
    assert any("left out: meta/device.csv" in c for c in record.provenance.conversions)
    one = read(tmp_path / "Inertia 2026-01-01 12-00-00.zip", topic="Gyroscope.csv")
    check(one, accel=None)


def sensor_logger(values, rate):
    body = [(T_NS[0] + int(1e9 / rate) * i, repr(i / rate), *values[i][::-1]) for i in range(N)]
    return lines("time,seconds_elapsed,z,y,x\n", body)


def test_sensor_logger(tmp_path):
    path = tmp_path / "Gyroscope.csv"
    path.write_text(sensor_logger(GYRO, 200))
    check(read(path, unit={"gyro": "rad/s"}), accel=None)
    both = zipped(
        tmp_path / "log.zip",
        {
            "Gyroscope.csv": sensor_logger(GYRO, 200),
            "TotalAcceleration.csv": sensor_logger(ACCEL, 200),
            "Gravity.csv": sensor_logger(ACCEL, 200),
        },
    )
    check(read(both, unit=SI))
    path.rename(tmp_path / "values.csv")  # then nothing says what x, y and z are
    with pytest.raises(OptionError, match="no column with a known name"):
        read(tmp_path / "values.csv")


@pytest.mark.parametrize("part", [0.1, 0.5, 0.99])
def test_zip_cut_and_damaged(tmp_path, part):
    path = phyphox_zip(tmp_path / "log.zip")
    whole = path.read_bytes()
    path.write_bytes(whole[: int(part * len(whole))])
    with pytest.raises(DataError, match=r"log\.zip: is a damaged or truncated zip archive"):
        read(path)
    raw = bytearray(whole)
    raw[int(part * len(whole) * 0.5)] ^= 0xFF
    path.write_bytes(raw)
    try:
        record = read(path)
    except (DataError, OptionError):
        return
    np.testing.assert_array_equal(record.stream_of("gyro_x").column("gyro_x"), GYRO[:, 0])


def test_zip_of_excel(tmp_path):
    with pytest.raises(DataError, match="Excel"):
        read(zipped(tmp_path / "a.xlsx", {"[Content_Types].xml": "<x/>", "xl/sheet.xml": "<x/>"}))


HEADER = "time [s];gyro_x [°/s];gyro_y [°/s];gyro_z [°/s];accel_x [µg];accel_y [µg];accel_z [µg]\n"


@pytest.mark.parametrize(
    ("encoding", "says", "comma"),
    [
        ("utf-8", "", ","),
        ("utf-8-sig", "UTF-8 with a byte order mark", "."),
        ("utf-16", "UTF-16 LE", ","),
        ("utf-16-be", "UTF-16 BE", "."),
        ("cp1252", "Windows-1252", ","),
    ],
)
def test_encodings(tmp_path, encoding, says, comma):
    path = tmp_path / "log.csv"
    preface = "Messung vom 3. Mai, Prüfstand 2\r\nSensor: A-17\r\n\r\n"
    body = lines("", rows([[i / 200] for i in range(N)]), ";").replace(".", comma)
    mark = "\ufeff" if encoding == "utf-16-be" else ""
    path.write_bytes((mark + preface + HEADER + body).encode(encoding))
    record = read(path)
    check(record, gyro=GYRO * DEG, accel=ACCEL * units.find("ug").factor)
    note = record.provenance.conversions[0]
    assert says in note
    assert ("decimal commas" in note) == (comma == ",")
    assert "header on line 4" in note


@pytest.mark.parametrize("separator", ["\t", "  ", ";"])
def test_decimal_commas(tmp_path, separator):
    path = tmp_path / "log.txt"
    body = lines("", rows([[i / 200] for i in range(N)]), separator).replace(".", ",")
    path.write_text("Time Gyr_X Gyr_Y Gyr_Z Acc_X Acc_Y Acc_Z\n".replace(" ", separator) + body)
    check(read(path, unit={**SI, "time": "s"}))
    path.write_text(body)  # no header
    check(read(path, unit={**SI, "time": "s"}, channels={"time": 1, "gyro": "2:4", "accel": "5:7"}))


def test_decimal_commas_quote_the_file(saved):
    path = saved(
        "time [s];gyro_x [rad/s]\n" + "".join(f"0,{i};1,{i}\n" for i in range(10)) + "1,0;oops,5.\n1,1;1\n", "log.txt"
    )
    with pytest.raises(DataError, match=r"line 12: column gyro_x \[rad/s\] has 'oops,5\.'"):
        read(path)
