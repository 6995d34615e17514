"""Text whose values have names, and the YAML of ROS messages."""

import itertools
import re

import numpy as np
import pytest
from readings import axes

import known
from container_damage import cut, survives
from sigmatau.errors import DataError, OptionError
from sigmatau.io.live import Live
from sigmatau.io.read import read
from sigmatau.io.read.options import TableOptions

N, RATE = 900, 100.0
STEP = 0.300 / 60 * np.sqrt(RATE)  # deg/s: 0.300 deg/√h at 100 Hz
RNG = np.random.default_rng(known.seed_of("keyed"))
GYRO = RNG.normal(0, STEP, (N, 3)).round(6)
ACCEL = (RNG.normal(0, 0.01, (N, 3)) + np.array([0, 0, 9.81])).round(5)
UNIT = {"gyro": "deg/s", "accel": "m/s^2"}

# How sketches print a sample: `a` and `g` are the numbers of the accelerometer and the gyro, `t` milliseconds.
LINES = {
    "colons": "ax:{a[0]} ay:{a[1]} az:{a[2]} gx:{g[0]} gy:{g[1]} gz:{g[2]}",
    "equals and commas": "ax={a[0]},ay={a[1]},az={a[2]},gx={g[0]},gy={g[1]},gz={g[2]}",
    "colons and spaces": "gx: {g[0]} gy: {g[1]} gz: {g[2]} ax: {a[0]} ay: {a[1]} az: {a[2]}",
    "tabs": "Gyro X: {g[0]}\tGyro Y: {g[1]}\tGyro Z: {g[2]}\tAccel X: {a[0]}\tAccel Y: {a[1]}\tAccel Z: {a[2]}",
    "axes alone": "Accel X: {a[0]}, Y: {a[1]}, Z: {a[2]}, Gyro X: {g[0]}, Y: {g[1]}, Z: {g[2]}",
    "semicolons": "acc_x={a[0]}; acc_y={a[1]}; acc_z={a[2]}; gyr_x={g[0]}; gyr_y={g[1]}; gyr_z={g[2]}",
    "bars": "ax: {a[0]} | ay: {a[1]} | az: {a[2]} | gx: {g[0]} | gy: {g[1]} | gz: {g[2]}",
    "three values of a name": "Accel: {a[0]}, {a[1]}, {a[2]} Gyro: {g[0]}, {g[1]}, {g[2]}",
    "three values, tabs": "acc:\t{a[0]}\t{a[1]}\t{a[2]}\tgyr:\t{g[0]}\t{g[1]}\t{g[2]}",
    "sensors, then axes": "Gyro: x={g[0]} y={g[1]} z={g[2]} | Accel: x={a[0]} y={a[1]} z={a[2]}",
    "other values": "id:7 temp:25.25 gx:{g[0]} gy:{g[1]} gz:{g[2]} ax:{a[0]} ay:{a[1]} az:{a[2]} ok:true",
}
WITH_UNITS = {
    "behind the values": "gx: {g[0]} deg/s, gy: {g[1]} deg/s, gz: {g[2]} deg/s, ax: {a[0]} m/s^2, ay: {a[1]} m/s^2,"
    " az: {a[2]} m/s^2",
    "without a space": "gx:{g[0]}dps gy:{g[1]}dps gz:{g[2]}dps ax:{a[0]}m/s^2 ay:{a[1]}m/s^2 az:{a[2]}m/s^2",
    "in brackets": "Gyro (deg/s): X={g[0]}, Y={g[1]}, Z={g[2]}; Accel (m/s^2): X={a[0]}, Y={a[1]}, Z={a[2]}",
    "in brackets, three values": "gyro [deg/s]: {g[0]} {g[1]} {g[2]} acc [m/s^2]: {a[0]} {a[1]} {a[2]}",
    "behind the last axis": "Acceleration X: {a[0]}, Y: {a[1]}, Z: {a[2]} m/s^2\n"
    "Rotation X: {g[0]}, Y: {g[1]}, Z: {g[2]} deg/s\nTemperature: 36.53 degC\n",
    "lines without a blank one": "Accel X: {a[0]}, Y: {a[1]}, Z: {a[2]} m/s^2\nGyro X: {g[0]}, Y: {g[1]}, Z: {g[2]} deg/s",
}
ABOVE = {"nothing": "", "words": "Initializing MPU6050...\r\nAdafruit test!\n\n", "a cut line": "12 az: 9.81\n"}


def save(path, form, above="", end="\n", n=N):
    rows = [form.format(a=ACCEL[k].tolist(), g=GYRO[k].tolist(), t=10 * k, k=k) for k in range(n)]
    path.write_text(above + "".join(row + end for row in rows))
    return path


def exact(record, gyro=GYRO, accel=ACCEL):
    for name, values, factor in (("gyro", gyro, np.pi / 180), ("accel", accel, 1.0)):
        np.testing.assert_allclose(axes(record, name), values * factor, rtol=1e-15)


@pytest.mark.parametrize(("form", "above"), list(zip(LINES, itertools.cycle(ABOVE), strict=False)))
def test_names_and_values(tmp_path, form, above):
    path = save(tmp_path / "log.txt", LINES[form], ABOVE[above])
    exact(read(path, rate=100, unit=UNIT))
    with pytest.raises(OptionError, match="does not state the unit"):
        read(path, rate=100)


@pytest.mark.parametrize(
    ("form", "above", "end"),
    list(zip(WITH_UNITS, itertools.cycle(ABOVE), itertools.cycle(["\n", "\r\n"]), strict=False)),
)
def test_units(tmp_path, form, above, end):
    record = read(save(tmp_path / "log.txt", WITH_UNITS[form], ABOVE[above], end), rate=100)
    exact(record)
    assert {f.code for f in record.findings} <= {"unused_columns"}


@pytest.mark.parametrize("time", ["t:{t}", "millis={t}", "time_ms: {t}"])
def test_a_time(tmp_path, time):
    path = save(tmp_path / "log.txt", f"{time}, {LINES['colons and spaces']}")
    assert read(path, unit={**UNIT, "time": "ms"}).streams[0].grid.rate == pytest.approx(100, rel=1e-9)


def test_the_clock_of_the_serial_monitor(tmp_path):
    rows = [f"12:00:{0.01 * k:06.3f} -> gx:{g[0]} gy:{g[1]} gz:{g[2]}" for k, g in enumerate(GYRO.tolist())]
    (tmp_path / "log.txt").write_text("\n".join([*rows, ""]))
    record = read(tmp_path / "log.txt", unit={"gyro": "deg/s"})
    assert (record.streams[0].grid.n, record.streams[0].grid.rate) == (N, pytest.approx(100, rel=1e-9))


def test_names_that_change_places_are_told(tmp_path):
    path = save(tmp_path / "log.txt", LINES["colons"])
    lines = path.read_text().splitlines()
    lines[500] = lines[500].replace("gx", "g#").replace("gy", "gx").replace("g#", "gy")
    path.write_text("\n".join([*lines, ""]))
    with pytest.raises(DataError, match=r"line 501: other names than on line 1 .*; correct or delete the line"):
        read(path, rate=100, unit=UNIT)


@pytest.mark.parametrize("form", ["colons", "behind the last axis"])
def test_a_line_of_another_form_is_named(tmp_path, form):
    path = save(tmp_path / "log.txt", {**LINES, **WITH_UNITS}[form])
    lines = path.read_text().splitlines()
    per = len(lines) // N
    lines[500 * per] = "I2C read failed, code 3"
    path.write_text("\n".join([*lines, ""]))
    with pytest.raises(DataError, match=rf"line {500 * per + 1}: "):
        read(path, rate=100, unit=UNIT)


def test_live(tmp_path):
    text = save(tmp_path / "log.txt", LINES["colons"], ABOVE["words"]).read_bytes()
    for size in (50, 10**6):
        live = Live(TableOptions(rate=100, unit=UNIT).checked())
        taken = [live.push(text[k : k + size]) for k in range(0, len(text), size)]
        samples = np.concatenate([piece for piece in taken if piece.size])
        assert live.channels == tuple(f"{s}_{a}" for s in ("gyro", "accel") for a in "xyz")
        np.testing.assert_array_equal(samples, np.hstack([GYRO, ACCEL]))


@pytest.mark.parametrize(("form", "share"), [("colons", 0.3), ("tabs", 0.77), ("axes alone", 0.999), ("colons", 0.999)])
def test_cut(tmp_path, form, share):
    path = save(tmp_path / "log.txt", LINES[form])
    path.write_bytes(cut(path.read_bytes(), share))
    record = read(path, rate=100, unit=UNIT)
    n = record.streams[0].grid.n
    assert N * share - 15 < n < N
    exact(record, GYRO[:n], ACCEL[:n])  # also if the text ends behind a number, which no finding can tell
    assert [f.code for f in record.findings] in (["damaged"], ["skipped_lines"], [])


@pytest.mark.parametrize("form", ["colons", "behind the last axis"])
def test_mutants(tmp_path, form):
    path = save(tmp_path / "log.txt", {**LINES, **WITH_UNITS}[form], n=60)
    assert survives(f"keyed {form}", path.read_bytes(), path, 100, rate=100, unit=UNIT) > 0


COVARIANCE = {"block": "".join("\n- 0.0" for _ in range(9)), "inline": " [0.0" + ", 0.0" * 8 + "]"}


def message(k, covariance, names, lead=""):
    seconds, nanoseconds = divmod(1_700_000_000_995_000_000 + 10_000_000 * k, 10**9)
    gyro, accel, matrix = (GYRO[k] * np.pi / 180).tolist(), ACCEL[k].tolist(), COVARIANCE[covariance]
    vector = lambda numbers: "".join(f"\n  {a}: {x!r}" for a, x in zip("xyzw", numbers, strict=False))  # noqa: E731
    return (
        f"{lead}header:\n  stamp:\n    {names[0]}: {seconds}\n    {names[1]}: {nanoseconds}\n  frame_id: imu link\n"
        f"orientation:{vector((0.0, 0.0, 0.0, 1.0))}\norientation_covariance:{matrix}\n"
        f"angular_velocity:{vector(gyro)}\nangular_velocity_covariance:{matrix}\n"
        f"linear_acceleration:{vector(accel)}\nlinear_acceleration_covariance:{matrix}\n---\n"
    )


def echoed(path, covariance="block", names=("sec", "nanosec"), n=N, above="", end="\n"):
    text = above + "".join(message(k, covariance, names) for k in range(n))
    path.write_bytes(text.replace("\n", end).encode())
    return path


@pytest.mark.parametrize("end", ["\n", "\r\n"])
@pytest.mark.parametrize(("covariance", "names"), [("block", ("sec", "nanosec")), ("inline", ("secs", "nsecs"))])
def test_echo(tmp_path, covariance, names, end):
    record = read(echoed(tmp_path / "imu.yaml", covariance, names, end=end))
    exact(record)
    grid = record.streams[0].grid
    assert (grid.n, grid.rate) == (N, pytest.approx(100, rel=1e-9))
    assert {f.code for f in record.findings} <= {"unused_columns"}


def test_echo_below_a_warning_and_with_lost_messages(tmp_path):
    lost = "A message was lost!!!\n\ttotal count change:3\n\ttotal count: 3---\n".replace("---", "")
    path = echoed(tmp_path / "imu.yaml", above="WARNING: topic [/imu] does not appear to be published yet\n")
    text = path.read_text()
    at = [match.start() for match in re.finditer("header:", text)]
    path.write_text(text[: at[300]] + lost + text[at[303] :])
    record = read(path)
    assert record.streams[0].grid.n == N
    missing = np.isnan(record.stream_of("gyro_x").column("gyro_x"))
    assert np.flatnonzero(missing).tolist() == [300, 301, 302]


@pytest.mark.parametrize("share", [0.2, 0.6, 0.9999])
def test_echo_cut(tmp_path, share):
    path = echoed(tmp_path / "imu.yaml")
    path.write_bytes(cut(path.read_bytes(), share))
    record = read(path)
    n = record.streams[0].grid.n
    assert N * share - 2 <= n < N
    exact(record, GYRO[:n], ACCEL[:n])
    assert "damaged" in {f.code for f in record.findings} or share == 0.9999


def test_echo_mutants(tmp_path):
    path = echoed(tmp_path / "imu.yaml", n=12)
    assert survives("echo", path.read_bytes(), path, 100) > 0


def test_an_address_within_a_table_is_no_name(tmp_path):
    """The colons of a device's address stand in each row of a tab-separated table."""
    path = tmp_path / "WT901.txt"
    head = "time\tDeviceName\tAccX(g)\tAccY(g)\tAccZ(g)\tAsX(°/s)\tAsY(°/s)\tAsZ(°/s)\tT(°C)\t\r\n"
    row = "2024-05-01T10:00:{:06.3f}\tHC-06(00:0C:BF:19:3F:0D)\t0.01\t-0.155\t0.954\t{}\t-0.793\t0.183\t27.61\t\r\n"
    path.write_bytes((head + "".join(row.format(k / 100, k % 3) for k in range(400))).encode())
    record = read(path)
    assert set(record.channels) >= {"gyro_x", "gyro_z", "accel_x", "accel_z"}
    assert record.streams[0].grid.rate == pytest.approx(100.0)


def test_lines_of_dashes_above_a_table_are_no_documents(tmp_path):
    """A head between two lines of dashes, as ActiLife writes it; the second was taken for the end of a YAML document."""
    head = "---------- Data File\nStart Time 10:00:00\nAddress: 0\nVoltage: 4.07     Mode = 12\n----------\n"
    values = np.random.default_rng(known.seed_of("dashes above a table")).standard_normal((300, 3))
    path = tmp_path / "raw.csv"
    rows = "".join(",".join(map(repr, row)) + "\n" for row in values.tolist())
    path.write_text(f"{head}Accelerometer X,Accelerometer Y,Accelerometer Z\n{rows}")
    record = read(path, rate=100, unit={"accel": "m/s^2"})
    np.testing.assert_array_equal(axes(record, "accel"), values)
