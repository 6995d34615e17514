"""Texts that are changed before they are read: tables of databases and statistics programs, printed objects, colours."""

import gzip

import numpy as np
import pytest

from known import seed_of
from sigmatau import OptionError, inspect
from sigmatau.io.read import read
from sigmatau.io.read.formats.translations import read_translated
from sigmatau.io.read.table import HEAD, Head

N = 1500
NAMES = ("time_s", *(f"gyro_{axis}_rad_s" for axis in "xyz"), *(f"acc_{axis}_m_s2" for axis in "xyz"))


def samples(name):
    rng = np.random.default_rng(seed_of(name))
    gyro = rng.normal(rng.uniform(-0.01, 0.01, 3), 0.002, (N, 3))
    return np.column_stack([np.arange(N) / 100, gyro, rng.normal([0.3, -0.5, 9.79], 0.01, (N, 3))]).round(7)


def as_rows(rows, mark, end=""):
    return [mark.join(f"{value:.7f}" for value in row) + end for row in rows.tolist()]


def database(rows):
    rule = "+".join(["-" * 14] * 7)
    return [" | ".join(NAMES), rule, *(" " + row for row in as_rows(rows, " | ")), f"({N} rows)", ""]


def bordered(rows):
    rule = "+" + "+".join(["-" * 14] * 7) + "+"
    body = [f"| {row} |" for row in as_rows(rows, " | ")]
    return [rule, f"| {' | '.join(NAMES)} |", rule, *body, rule, f"{N} rows in set (0.02 sec)", ""]


def markdown(rows):
    return [
        f"| {' | '.join(NAMES)} |",
        "|" + "|".join([":---:"] * 7) + "|",
        *(f"| {row} |" for row in as_rows(rows, " | ")),
    ]


def exponents(rows):
    lines = ["".join(name.rjust(18) for name in NAMES)]
    return lines + ["".join(f"{value:18.9E}" for value in row).replace("E", "D") for row in rows.tolist()]


def small_exponents(rows):
    return [",".join(NAMES)] + [",".join(f"{value:.9e}" for value in row).replace("e", "d") for row in rows.tolist()]


def attributes(rows):
    head = ["% a comment", "@RELATION imu", "", *(f"@ATTRIBUTE {name}  NUMERIC" for name in NAMES[:-1])]
    return [*head, f"@attribute '{NAMES[-1]}' real", "", "@DATA", *as_rows(rows, ",")]


def row_names(rows):
    names = " ".join(f'"{name}"' for name in NAMES)
    return [names, *(f'"{k}" {row}' for k, row in enumerate(as_rows(rows, " "), start=1))]


def station(rows):
    head = ['"TOA5","roof","CR6","7423","CR6.Std.12","CPU:imu.CR6","40671","Fast"']
    head.append('"SECONDS","Gyro_X","Gyro_Y","Gyro_Z","Accel_X","Accel_Y","Accel_Z"')
    head += ['"s","rad/s","rad/s","rad/s","m/s^2","m/s^2","m/s^2"', '"","Smp","Smp","Smp","Smp","Smp","Smp"']
    return head + as_rows(rows, ",")


def lists(rows):
    return [
        "time_s: {:.7f} Gyr (rad/s) [ {:.7f}, {:.7f}, {:.7f} ], Acc (m/s^2) [{:.7f}, {:.7f}, {:.7f}]".format(*row)
        for row in rows.tolist()
    ]


def bare_lists(rows):
    return [
        "time_s={:.7f} gyr_rad_s=[{:.7f}, {:.7f}, {:.7f}] acc_m_s2: ({:.7f},{:.7f},{:.7f})".format(*r)
        for r in rows.tolist()
    ]


def dictionaries(rows):
    return [
        str({"time_s": t, "gyro_rad_s": {"x": x, "y": y, "z": z}, "acc_m_s2": a}) for t, x, y, z, *a in rows.tolist()
    ]


def objects(rows):
    return [
        "Imu(time_s={:.7f}, gyro_rad_s=Vector3(x={:.7f}, y={:.7f}, z={:.7f}), "
        "accel_m_s2=Vector3(x={:.7f}, y={:.7f}, z={:.7f}))".format(*row)
        for row in rows.tolist()
    ]


def colours(rows):
    return [f"\x1b[0;32m{line}\x1b[0m" for line in [",".join(NAMES), *as_rows(rows, ",")]]


def gazebo(rows):
    """Fields that are 0 are not printed."""
    lines = []
    for time, *six in rows.tolist():
        second, part = divmod(round(time * 1e9), 10**9)
        parts = ([f"    sec: {second}"] if second else []) + ([f"    nsec: {part}"] if part else [])
        lines += ["header {", "  stamp {", *parts, "  }", "}", 'entity_name: "imu"']
        for name, vector in (("angular_velocity", six[:3]), ("linear_acceleration", six[3:])):
            lines += [f"{name} {{", *(f"  {a}: {v:.7f}" for a, v in zip("xyz", vector, strict=True)), "}"]
        lines.append("")
    return lines


FORMS = (
    database,
    bordered,
    markdown,
    exponents,
    small_exponents,
    attributes,
    row_names,
    station,
    lists,
    bare_lists,
    dictionaries,
    objects,
    colours,
)


def check(record, rows, *, unused=False):
    assert record.streams[0].grid.rate == pytest.approx(100.0)
    for index, channel in enumerate(("gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z"), start=1):
        assert record.stream_of(channel).column(channel) == pytest.approx(rows[:, index], abs=1e-7)
    assert unused or record.findings == ()


@pytest.mark.parametrize("form", [*FORMS, gazebo])
def test_the_samples_are_those_of_the_text(tmp_path, form):
    rows = samples(form.__name__)
    lines = [*form(rows), ""]
    (tmp_path / "log.txt").write_bytes("\r\n".join(lines).encode())
    check(read(tmp_path / "log.txt"), rows)
    (tmp_path / "log.gz").write_bytes(gzip.compress("\n".join(lines).encode()))
    check(read(tmp_path / "log.gz"), rows)


@pytest.mark.parametrize("form", FORMS)
def test_a_truncated_text_is_read_up_to_its_end(tmp_path, form):
    rows = samples(form.__name__)
    path = tmp_path / "log.txt"
    text = "\n".join(form(rows)) + "\n"
    path.write_text(text[: len(text) * 2 // 3])
    record = read(path)
    count = record.streams[0].grid.n
    assert N / 2 < count < N
    assert record.stream_of("gyro_y").column("gyro_y") == pytest.approx(rows[:count, 2], abs=1e-7)


@pytest.mark.parametrize("form", [database, exponents, attributes, station, colours])
def test_a_wrong_cell_is_named_by_its_line(saved, form):
    lines = form(samples(form.__name__))
    place = len(lines) - 100
    lines[place] = lines[place].replace("0", "oo", 1)
    path = saved("\n".join(lines) + "\n", "log.txt")
    with pytest.raises(Exception, match=rf"line {place + 1}: "):
        read(path)


@pytest.mark.parametrize(("mark", "quote"), [("\t", '"'), (";", '"'), (",", '"'), ("\t", ""), (";", "")])
def test_commas_between_thousands_are_removed(saved, mark, quote):
    rows = samples(f"thousands{mark}{quote}")
    names = ["time_us", *NAMES[1:4]]
    lines = [mark.join(names)]
    for k, row in enumerate(rows[:, 1:4].tolist()):
        cells = [f"{1000 * 10 * k:,}", *(f"{value:.7f}" for value in row)]
        lines.append(mark.join(f"{quote}{cell}{quote}" for cell in cells))
    path = saved("\n".join(lines) + "\n")
    record = read(path)
    assert record.streams[0].grid.rate == pytest.approx(100.0)
    assert record.stream_of("gyro_z").column("gyro_z") == pytest.approx(rows[:, 3], abs=1e-7)


def test_messages_of_a_flight_controller_are_topics(saved):
    rows = samples("messages")
    lines = []
    for k, row in enumerate(rows.tolist()):
        six = [round(1000 * value) for value in row[1:]]
        fields = ", ".join(
            f"{name} : {value}"
            for name, value in zip(("xgyro", "ygyro", "zgyro", "xacc", "yacc", "zacc"), six, strict=True)
        )
        lines.append(
            f"2026-03-01 10:00:{k // 100:02d}.{k % 100:02d}: RAW_IMU {{time_usec : {10_000 * k}, {fields}, id : 0}}"
        )
        if k % 4 == 0:
            lines.append(
                f"2026-03-01 10:00:{k // 100:02d}.{k % 100:02d}: ATTITUDE {{time_boot_ms : {10 * k}, roll : nan, yaw : 1.5}}"
            )
    path = saved("\n".join(lines) + "\n", "mav.txt")
    assert [table.topic for table in inspect(path).tables] == ["RAW_IMU", "ATTITUDE"]
    record = read(path, unit={"gyro": "mrad/s", "accel": "m/s^2"}, scale={"accel": 0.001})
    assert record.streams[0].grid.rate == pytest.approx(100.0)
    assert record.stream_of("gyro_z").column("gyro_z") == pytest.approx(rows[:, 3], abs=5.1e-4)


def test_lists_of_several_kinds_of_rows(saved):
    rows = samples("kinds of rows")
    lines = []
    for time, *six in rows.tolist():
        lines += [
            f"Gyroscope;{time};[{six[0]}, {six[1]}, {six[2]}]",
            f"Accelerometer;{time};[{six[3]}, {six[4]}, {six[5]}]",
        ]
    path = saved("\n".join(lines) + "\n")
    with pytest.raises(OptionError, match=r"does not state the unit of gyro_x, gyro_y, gyro_z"):
        read(path)
    check(read(path, unit={"gyro": "rad/s", "accel": "m/s^2", "time": "s"}), rows, unused=True)


@pytest.mark.parametrize(
    "text",
    [
        "time_s,gyro_x,gyro_y,gyro_z\n" + "0.01,1,2,3\n" * 50,
        "t ax ay az\n" + "1 0.1 0.2 9.8\n2 0.1 0.2 9.8\n" * 50,
        "ax:0.01 ay:0.02 az:9.81\n" * 50,
        '{"gyro": {"x": 1, "y": 2, "z": 3}, "acc": {"x": 1, "y": 2, "z": 3}}\n' * 50,
        "label,a,b\nA|B,1,2\n" * 50,
        "serial 0.1D2 text\n" + "1,2,3\n" * 2000,
    ],
)
def test_other_texts_are_left_to_their_readers(saved, text):
    path = saved(text, "log.txt")
    assert read_translated(path, Head(data=text.encode()[:HEAD], whole=True, gzip=False)) == ()
