"""Text tables whose rows are of several sensors or instances: each kind of rows is a topic, and nothing else is."""

from dataclasses import dataclass

import numpy as np
import pytest

from known import seed_of
from sigmatau.errors import DataError, OptionError
from sigmatau.io.read import read
from sigmatau.io.read.inspection import inspect
from sigmatau.io.read.options import ReadOptions

UNITS = {"gyro": "rad/s", "accel": "m/s^2"}
GRAVITY = 9.80665


@dataclass
class Source:
    """A sensor that writes rows: kind, times [s], samples of shape (n, fields)."""

    kind: str
    t: np.ndarray
    values: np.ndarray


def noise(name, n, mean, sigma):
    return np.round(np.random.default_rng(seed_of(name)).normal(mean, sigma, (n, len(mean))), 6)


def gyro(name, rate, seconds=10.0, at=0.0, bias=0.0):
    n = int(rate * seconds)
    return at + np.arange(n) / rate, noise(f"gyro {name}", n, np.array([0.003, -0.001, 0.0005]) + bias, 9e-4)


def accel(name, rate, seconds=10.0, at=0.0, bias=0.0):
    n = int(rate * seconds)
    return at + np.arange(n) / rate, noise(f"accel {name}", n, np.array([0.1, -0.2, GRAVITY]) + bias, 0.01)


def imu(name, kind, rate=100.0, at=0.0, bias=0.0):
    t, rates = gyro(name, rate, at=at, bias=bias)
    return Source(kind, t, np.hstack((rates, accel(name, rate, at=at, bias=10 * bias)[1])))


def alone(name, kind, sensor, rate, at=0.0):
    t, values = sensor(name, rate, at=at)
    return Source(kind, t, values)


def temperatures(name, kind, rate, at=0.003):
    t = at + np.arange(int(10 * rate)) / rate
    return Source(kind, t, noise(f"temperature {name}", len(t), np.array([25.0]), 0.02))


def merged(sources, row):
    """The lines of all sources in time order; `row(kind, count, time, values)` writes one."""
    rows = [(t, k, i) for k, source in enumerate(sources) for i, t in enumerate(source.t)]
    return [row(sources[k].kind, i, t, [f"{v:.6f}" for v in sources[k].values[i]]) for t, k, i in sorted(rows)]


def first(separator=",", scale=1.0, figures=6):
    return lambda kind, i, t, values: separator.join([kind, f"{t * scale:.{figures}f}", *values])


def last(kind, i, t, values):
    return ",".join([f"{t:.6f}", *values, kind])


def middle(kind, i, t, values):
    return ",".join([f"{t:.6f}", kind, *values])


IMUS = [imu("two", "0"), imu("other", "1", at=6e-5, bias=0.006)]
HEADER = "I,time [s],gyro_x,gyro_y,gyro_z,accel_x,accel_y,accel_z"
PAIR = [alone("pair", "Gyro", gyro, 200.0), alone("pair", "Accel", accel, 62.5, at=1e-3)]
ANDROID = [alone("android", "UncalGyro", gyro, 200.0), alone("android", "UncalAccel", accel, 100.0, at=1e-3)]


def android(kind, i, t, values):
    return ",".join(
        [kind, f"{1577145765405 + round(1e3 * t)}", f"{round(1e9 * t) + 5_000_000_000}", *values, "0", "0", "0"]
    )


ANDROID_HEADERS = [
    "# Version: v3.0.5.6 Platform: 12",
    "# UncalGyro,utcTimeMillis,elapsedRealtimeNanos,UncalGyroXRadPerSec,UncalGyroYRadPerSec,UncalGyroZRadPerSec,"
    "DriftXRadPerSec,DriftYRadPerSec,DriftZRadPerSec",
    "# UncalAccel,utcTimeMillis,elapsedRealtimeNanos,UncalAccelXMps2,UncalAccelYMps2,UncalAccelZMps2,BiasXMps2,BiasYMps2,"
    "BiasZMps2",
]
NAMED = "I,time [s],gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s],accel_x [m/s^2],accel_y [m/s^2],accel_z [m/s^2]"

# Instances: name, lines, topics, and what the question names.
INSTANCES = {
    "I first": ([HEADER, *merged(IMUS, first())], IMUS, ["imu0", "imu1"], "column 1 'I' has 0 and 1"),
    "tabs": (
        [HEADER.replace(",", "\t"), *merged(IMUS, first("\t"))], IMUS, ["imu0", "imu1"], "column 1 'I' has 0 and 1",
    ),
    "semicolons and decimal commas": (
        [HEADER.replace(",", ";"), *(line.replace(".", ",") for line in merged(IMUS, first(";")))],
        IMUS, ["imu0", "imu1"], "column 1 'I' has 0 and 1",
    ),
    "three": (
        [NAMED.replace("I,", "imu,"), *merged([*IMUS, imu("third", "2", at=1e-4, bias=-0.004)], first())],
        [*IMUS, imu("third", "2", at=1e-4, bias=-0.004)], ["imu0", "imu1", "imu2"], "column 1 'imu' has 0, 1 and 2",
    ),
    "other rates": (
        [NAMED.replace("I,", "sensor_id,"), *merged([IMUS[0], imu("slow", "1", 25.0, at=0.002, bias=0.01)], first())],
        [IMUS[0], imu("slow", "1", 25.0, at=0.002, bias=0.01)], ["imu0", "imu1"], "column 1 'sensor_id' has 0 and 1",
    ),
    "text, last column": (
        [
            "time [s],gyro_x,gyro_y,gyro_z,accel_x,accel_y,accel_z,frame_id",
            *merged([imu("left", "imu_left"), imu("right", "imu_right", at=4e-3)], last),
        ],
        [imu("left", "imu_left"), imu("right", "imu_right", at=4e-3)],
        ["imu_left", "imu_right"], "column 8 'frame_id' has imu_left and imu_right",
    ),
    "last column, even spacing": (
        [
            "time [s],gyro_x,gyro_y,gyro_z,accel_x,accel_y,accel_z,Instance",
            *merged([imu("even", "1"), imu("odd", "2", at=5e-3)], last),
        ],
        [imu("even", "1"), imu("odd", "2", at=5e-3)], ["imu1", "imu2"], "column 8 'Instance' has 1 and 2",
    ),
    "name not known, means differ": (
        [HEADER.replace("I,", "which,"), *merged(IMUS, first())], IMUS, ["imu0", "imu1"], "column 1 'which' has 0 and 1",
    ),
    "a row of units": (
        ["IMU,time,gyro_x,gyro_y,gyro_z,accel_x,accel_y,accel_z", "-,s,rad/s,rad/s,rad/s,m/s^2,m/s^2,m/s^2",
         *merged(IMUS, first())],
        IMUS, ["imu0", "imu1"], "column 1 'IMU' has 0 and 1",
    ),
    "one stamp for all": (
        [NAMED, *merged([IMUS[0], imu("same", "1", bias=0.002), imu("same too", "2", bias=-0.002)], first())],
        [IMUS[0], imu("same", "1", bias=0.002), imu("same too", "2", bias=-0.002)],
        ["imu0", "imu1", "imu2"], "column 1 'I' has 0, 1 and 2",
    ),
}  # fmt: skip


def saved(tmp_path, lines):
    path = tmp_path / "log.csv"
    path.write_text("\n".join(lines) + "\n")
    return path


def assert_equal(record, sensor, values, rate):
    """The samples of a sensor are these, at this rate."""
    stream = record.stream_of(f"{sensor}_x")
    assert stream.grid.rate == pytest.approx(rate, rel=1e-6)
    for k, axis in enumerate("xyz"):
        np.testing.assert_array_equal(stream.column(f"{sensor}_{axis}"), values[:, k])


@pytest.mark.parametrize("name", INSTANCES)
def test_instances_are_asked_for_and_read_one_by_one(tmp_path, name):
    lines, sources, topics, question = INSTANCES[name]
    path = saved(tmp_path, lines)
    with pytest.raises(OptionError) as refused:
        read(path, unit=UNITS)
    assert refused.value.option == "topic"
    assert question in str(refused.value)
    assert all(topic in str(refused.value) for topic in topics)
    for topic, source in zip(topics, sources, strict=True):
        record = read(path, unit=UNITS, topic=topic)
        rate = 1 / (source.t[1] - source.t[0])
        assert_equal(record, "gyro", source.values[:, :3], rate)
        assert_equal(record, "accel", source.values[:, 3:], rate)


TIME = {"time": "s", **UNITS}


def renamed(gyro_kind, accel_kind):
    return [Source(gyro_kind, PAIR[0].t, PAIR[0].values), Source(accel_kind, PAIR[1].t, PAIR[1].values)]


def two_clocks(kind, i, t, values):
    return ",".join([kind, "0", str(i), f"{1577145765405 + t * 1e3:.3f}", f"{t * 1e3:.3f}", *values])


TEMPERATURES = temperatures("rows", "Temp", 10.0)
BY_WORD = {
    "words first, no header": (merged(PAIR, first()), PAIR, TIME),
    "a counter and two clocks": (merged(PAIR, two_clocks), PAIR, TIME | {"time": "ms"}),
    "spaces": (merged(PAIR, first(" ")), PAIR, TIME),
    "semicolons": (merged(PAIR, first(";")), PAIR, TIME),
    "tabs": (merged(PAIR, first("\t")), PAIR, TIME),
    "word in the middle": (merged(PAIR, middle), PAIR, TIME),
    "word last, header": (["time,x,y,z,sensor", *merged(PAIR, last)], PAIR, TIME),
    "header": (["sensor,time [s],x,y,z", *merged(PAIR, first())], PAIR, UNITS),
    "short words": (merged(renamed("GYR", "ACC"), first()), PAIR, TIME),
    "words with colons": (merged(renamed("gyro:", "accel:"), first(" ")), PAIR, TIME),
    "names of Android": (
        merged(renamed("android.sensor.gyroscope", "android.sensor.accelerometer"), first()), PAIR, TIME,
    ),
    "quoted words": (merged(renamed('"Gyro"', '"Accel"'), first()), PAIR, TIME),
    "temperatures with fewer fields": (merged([*PAIR, TEMPERATURES], first()), PAIR, TIME),
    "GNSSLogger": ([*ANDROID_HEADERS, *merged(ANDROID, android)], ANDROID, {}),
    "words with values of unknown names": (
        ["timestamp_ms;type;v0;v1;v2", *merged(PAIR, lambda kind, i, t, v: ";".join([f"{1e3 * t:.3f}", kind, *v]))],
        PAIR, UNITS,
    ),
    "a block of each": (merged(PAIR[:1], first()) + merged(PAIR[1:], first()), PAIR, TIME),
    "one word": (merged(PAIR[:1], first()), PAIR[:1], {"time": "s", "gyro": "rad/s"}),
    "messages among the rows": (
[t for k, line in enumerate(merged(PAIR, first())) for t in [line] + [f"INFO,started task {k}"] * (k % 500 == 7)],
        PAIR, TIME,
    ),
    "one sensor and temperatures": (merged([PAIR[0], TEMPERATURES], first()), PAIR[:1], {"time": "s", "gyro": "rad/s"}),
}  # fmt: skip


@pytest.mark.parametrize("name", BY_WORD)
def test_one_gyro_and_one_accelerometer_are_one_record(tmp_path, name):
    lines, sources, unit = BY_WORD[name]
    record = read(saved(tmp_path, lines), unit=unit)
    assert {stream.name for stream in record.streams} == set(("gyro", "accel")[: len(sources)])
    for sensor, source in zip(("gyro", "accel"), sources, strict=False):
        assert_equal(record, sensor, source.values, 1 / (source.t[1] - source.t[0]))


def test_named_columns_are_those_of_the_rows_of_the_sensor(tmp_path):
    path = saved(tmp_path, merged(PAIR, two_clocks))
    unit = {"time": "ms", "gyro": "rad/s"}
    record = read(path, channels={"time": 4, "gyro": "6:8"}, unit=unit)
    assert record.channels == ("gyro_x", "gyro_y", "gyro_z")
    assert_equal(record, "gyro", PAIR[0].values, 200.0)
    both = read(path, channels={"time": 4, "gyro": "6:8", "accel": "6:8"}, unit=unit | {"accel": "m/s^2"})
    assert_equal(both, "gyro", PAIR[0].values, 200.0)
    assert_equal(both, "accel", PAIR[1].values, 62.5)


def test_columns_of_instances_without_names_need_the_topic_too(tmp_path):
    path = saved(tmp_path, merged(IMUS, first()))
    channels = {"time": 2, "gyro": "3:5", "accel": "6:8"}
    with pytest.raises(OptionError, match="column 1 has 0 and 1") as refused:
        read(path, channels=channels, unit=TIME)
    assert refused.value.option == "topic"
    record = read(path, channels=channels, unit=TIME, topic="imu1")
    assert_equal(record, "gyro", IMUS[1].values[:, :3], 100.0)


def test_several_sensors_of_one_kind_are_asked_for(tmp_path):
    path = saved(tmp_path, merged([*PAIR, alone("linear", "LinearAccel", accel, 50.0)], first()))
    with pytest.raises(OptionError, match="column 1 has Gyro, LinearAccel and Accel") as refused:
        read(path, unit=TIME)
    assert refused.value.option == "topic"
    record = read(path, unit=TIME, topic=["Gyro", "Accel"])
    assert_equal(record, "accel", PAIR[1].values, 62.5)


def test_two_columns_that_tell_kinds_are_refused(tmp_path):
    rows = [f"{device},{line}" for line in merged(PAIR, first()) for device in ("left", "right")]
    with pytest.raises(
        DataError, match="column 1 'device' has left and right, and column 2 'sensor' has Gyro and Accel"
    ):
        read(saved(tmp_path, ["device,sensor,time [s],x,y,z", *rows]), unit=UNITS)


def test_a_table_of_results_by_axis_is_one_table(tmp_path):
    rows = [f"Gyro {axis},{0.01 * 2**k:.2f},{0.1 / 2**k:.6f}" for axis in "xyz" for k in range(12)]
    shown = inspect(saved(tmp_path, ["axis,tau,adev", *rows]), ReadOptions())
    assert [table.topic for table in shown.tables] == [""]


def counted(path, name, values, stamps, samples):
    """Write a table with a column of whole numbers behind the samples."""
    lines = [last(str(k), 0, t, [f"{v:.6f}" for v in row]) for k, t, row in zip(values, stamps, samples, strict=True)]
    path.write_text("\n".join([f"time [s],gyro_x,gyro_y,gyro_z,accel_x,accel_y,accel_z,{name}", *lines]) + "\n")
    return path


@pytest.mark.parametrize(
    ("name", "period"), [("frame", 2), ("tag", 3), ("id", 4), ("kind", 8), ("label", 16), ("imu_frame", 2)]
)
def test_a_counter_of_one_sensor_is_no_instance(tmp_path, name, period):
    source = imu(f"counter {name} {period}", "")
    path = counted(tmp_path / "log.csv", name, np.arange(len(source.t)) % period, source.t, source.values)
    if name == "imu_frame":  # the name of a device, of which sensors of one bias are told by nothing else
        with pytest.raises(OptionError, match="If the column is a counter of one sensor"):
            read(path, unit=UNITS)
    for stated in (1,) if name == "imu_frame" else (None, 1):
        record = read(path, unit=UNITS, interleaved=stated)
        assert record.streams[0].grid.n == len(source.t)
        assert record.streams[0].grid.rate == pytest.approx(100.0)


@pytest.mark.parametrize(("name", "way"), [("frame", "bias"), ("tag", "noise"), ("id", "instant")])
def test_sensors_under_such_names_are_instances(tmp_path, name, way):
    first, second = imu(f"{name} {way} 0", "0"), imu(f"{name} {way} 1", "1", bias=0.006 if way == "bias" else 0.0)
    if way == "noise":
        second.values = second.values.mean(axis=0) + 4 * (second.values - second.values.mean(axis=0))
    at = 1e-4 if way == "instant" else 5e-3
    stamps = np.stack((first.t, first.t + at), axis=1).ravel()
    samples = np.stack((first.values, second.values), axis=1).reshape(len(stamps), -1)
    path = counted(tmp_path / "log.csv", name, np.arange(len(stamps)) % 2, stamps, samples)
    with pytest.raises(OptionError, match=f"'{name}' has 0 and 1, so the rows are of several sensors"):
        read(path, unit=UNITS)
    assert read(path, unit=UNITS, topic="imu1").streams[0].grid.n == len(second.t)


def test_a_line_of_a_kind_is_named_by_its_line_in_the_file(tmp_path):
    lines = merged(PAIR, first())
    broken = max(k for k, line in enumerate(lines) if line.startswith("Accel"))
    lines[broken] = lines[broken].rsplit(",", 1)[0]
    with pytest.raises(DataError, match=rf"line {broken + 1}: 4 fields, 5 expected"):
        read(saved(tmp_path, lines), unit=TIME)


def test_inspection_lists_the_kinds_with_rows_and_rate(tmp_path):
    shown = inspect(saved(tmp_path, merged(PAIR, first())), ReadOptions(unit=TIME))
    assert [(t.topic, t.rows, pytest.approx(t.rate), t.chosen) for t in shown.tables] == [
        ("Gyro", 2000, 200.0, True),
        ("Accel", 625, 62.5, True),
    ]


RATES = gyro("counted", 100.0)
N = len(RATES[0])
RNG = np.random.default_rng(seed_of("other columns"))
OTHERS = {
    "constant instance I": np.zeros(N),
    "sequence seq modulo 4": np.arange(N) % 4,
    "sequence without a known name: buffer": np.arange(N) % 2,
    "second": np.arange(N) // 100 % 60,
    "random flag valid": RNG.integers(0, 2, N),
    "rare flag": (RNG.random(N) < 0.05).astype(int),
    "blinking led": np.arange(N) // 25 % 2,
    "new magnetometer sample every third row": (np.arange(N) % 3 == 0).astype(int),
    "coarse temperature": np.round(25 + 0.5 * np.sin(np.arange(N) / 300) + RNG.normal(0, 0.3, N)),
    "coarse signal": np.abs(np.round(RNG.normal(3, 1, N))),
    "alternating line": 2 + (-1) ** np.arange(N),
}


@pytest.mark.parametrize(
    ("name", "place", "header"), [(name, *((0, True), (4, False))[k % 2]) for k, name in enumerate(OTHERS)]
)
def test_other_columns_of_small_numbers_are_not_instances(tmp_path, name, place, header):
    names, rows = ["time [s]", "gyro_x", "gyro_y", "gyro_z"], []
    for t, values, number in zip(*RATES, OTHERS[name], strict=True):
        row = [f"{t:.2f}", *(f"{v:.6f}" for v in values)]
        rows.append(",".join([*row[:place], f"{number:.0f}", *row[place:]]))
    names.insert(place, name)
    path = saved(tmp_path, [",".join(names)] * header + rows)
    start = 2 if place == 0 else 1
    record = read(
        path, unit={"gyro": "rad/s", "time": "s"}, channels={"time": start, "gyro": f"{start + 1}:{start + 3}"}
    )
    assert_equal(record, "gyro", RATES[1], 100.0)


@pytest.mark.parametrize(
    ("words", "alternating"),
    [(("OK", "WARN"), False), (("A", "V"), True), (("true", "false"), False), (("old", "new"), True)],
)
def test_a_status_word_is_not_a_kind(tmp_path, words, alternating):
    rng = np.random.default_rng(seed_of(f"status {words}"))
    state = np.arange(N) % 2 if alternating else rng.integers(0, 2, N)
    rows = [",".join([f"{t:.2f}", *(f"{v:.6f}" for v in values), words[s]])
            for t, values, s in zip(*RATES, state, strict=True)]  # fmt: skip
    record = read(saved(tmp_path, ["time [s],gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s],status", *rows]))
    assert_equal(record, "gyro", RATES[1], 100.0)


def test_cases_of_rows(field_data):
    two = field_data / "cases" / "two_imus_interleaved_bias.csv"
    unit = {"gyro": "rad/s", "accel": "m/s^2"}
    with pytest.raises(OptionError, match="column 2 'I' has 0 and 1"):
        read(two, unit=unit)
    assert [read(two, unit=unit, topic=f"imu{k}").stream_of("gyro_x").grid.rate for k in (0, 1)] == pytest.approx(
        [100.0] * 2
    )
    mux = field_data / "cases" / "mux_gyro_accel_rows.csv"
    gyros = read(mux, channels={"time": 4, "gyro": "6:8"}, unit={"time": "ms", "gyro": "rad/s"})
    assert gyros.stream_of("gyro_x").grid.rate == pytest.approx(200.0, rel=1e-6)
    for axis in "xyz":  # white noise of 0.300 deg/√h: its standard error is 1/√(2n)
        scatter = np.std(gyros.stream_of("gyro_x").column(f"gyro_{axis}"))
        assert np.degrees(scatter / np.sqrt(200.0)) * 60 == pytest.approx(0.300, rel=3 / np.sqrt(2 * 2285))
    both = read(mux, unit={"time": "ms", **unit})
    assert both.stream_of("accel_x").grid.rate == pytest.approx(62.5, rel=1e-6)


@pytest.mark.parametrize("style", ["comments", "marks", "comments in another order"])
def test_names_above_the_rows_are_those_of_their_kind(tmp_path, style):
    names = {"GYRO": "GYRO,time(s),gx(rad/s),gy(rad/s),gz(rad/s)", "MAGN": "MAGN,time(s),x(uT),y(uT),z(uT)"}
    if style == "marks":
        head = ["$LOG,2", "$COL,GYRO,time,wx,wy,wz", "$UNIT,GYRO,s,rad/s,rad/s,rad/s", "$COL,MAGN,time,x,y,z",
                "$UNIT,MAGN,s,uT,uT,uT", "$DATA"]  # fmt: skip
    else:
        order = sorted(names, reverse=style != "comments")
        head = ["% made by a logger", *(f"% data of {kind.lower()}: '{names[kind]}'" for kind in order)]
    mark = "$" if style == "marks" else ""
    rates = np.random.default_rng(seed_of(f"names above {style}")).normal(0, 1e-3, (1500, 3)).round(6)
    rows = []
    for k, (x, y, z) in enumerate(rates.tolist()):
        rows += [f"{mark}GYRO,{k / 100:.2f},{x},{y},{z}", f"{mark}MAGN,{k / 100 + 0.002:.3f},31.2,5.1,-40.{k % 10}"]
    path = tmp_path / "log.csv"
    path.write_text("\n".join([*head, *rows]) + "\n")
    record = read(path)
    assert record.channels == ("gyro_x", "gyro_y", "gyro_z")
    assert record.streams[0].grid.rate == pytest.approx(100)
    np.testing.assert_allclose(record.streams[0].column("gyro_y"), rates[:, 1])


@pytest.mark.parametrize(
    ("name", "goes_on"), [("imu", True), ("sensor_id", False), ("Device", False), ("label", True), ("segment", True)]
)
def test_blocks_of_rows_are_of_several_devices(tmp_path, name, goes_on):
    """A column of a device divides the rows; a label or a segment describes a part of the log of one sensor."""
    _, values = gyro(f"blocks {name}", 100.0, seconds=40.0)
    rows = []
    for k, axes in enumerate(values.tolist()):
        block = k // 400
        t = k / 100 if goes_on else (block // 2 * 400 + k % 400) / 100
        rows.append(f"{t:.2f},{block % 2},{','.join(map(str, axes))}")
    path = tmp_path / "log.csv"
    path.write_text("\n".join([f"time [s],{name},gyro_x,gyro_y,gyro_z", *rows, ""]))
    if name in ("label", "segment"):
        assert read(path, unit={"gyro": "rad/s"}).streams[0].grid.n == len(values)
        return
    with pytest.raises(OptionError, match=rf"column 2 '{name}' has 0 and 1, so the rows are of several sensors"):
        read(path, unit={"gyro": "rad/s"})
    stream = read(path, unit={"gyro": "rad/s"}, topic="imu1").stream_of("gyro_x")
    of_second = values.reshape(-1, 2, 400, 3)[:, 1, :, 0].ravel()
    x = stream.column("gyro_x")
    np.testing.assert_array_equal(x[~np.isnan(x)], of_second)


def test_short_tags_of_sensors_with_other_noise(tmp_path):
    """One letter for each sensor, without a header: the noise of the rows tells that they are of several sensors."""
    sources = [alone("G", "G", gyro, 200.0), alone("A", "A", accel, 100.0, at=0.0001)]
    rows = merged(sources, lambda kind, i, t, v: f"{kind} {1e6 * t:.0f} {' '.join(v)}")
    path = tmp_path / "log.txt"
    path.write_text("\n".join([*rows, ""]))
    how = {"channels": {"time": 2, "gyro": "3:5"}, "unit": {"gyro": "rad/s", "time": "us"}}
    with pytest.raises(OptionError, match="column 1 has G and A, so the rows are of several sensors"):
        read(path, **how)
    assert read(path, topic="G", **how).streams[0].grid.rate == pytest.approx(200.0, rel=1e-3)


@pytest.mark.parametrize(("devices", "column"), [(("1", "2", "7"), "imu"), (("0", "1"), "sensor_id")])
def test_devices_one_after_the_other_are_topics_however_late(tmp_path, column, devices):
    """Rows of the second device begin below the head of the file, and times begin again or go on."""
    rows, values = [], {}
    for number, device in enumerate(devices):
        t, values[device] = gyro(f"late {column}{device}", 100.0, seconds=90.0)
        t = t + (90.0 * number if column == "imu" else 0.0)
        rows += [f"{device},{s:.2f},{','.join(map(str, v))}" for s, v in zip(t, values[device].tolist(), strict=True)]
    path = tmp_path / "log.csv"
    path.write_text("\n".join([f"{column},time [s],gyro_x,gyro_y,gyro_z", *rows, ""]))
    listed = " and ".join([", ".join(devices[:-1]), devices[-1]])
    with pytest.raises(OptionError, match=rf"column 1 '{column}' has {listed}, so the rows are of several sensors"):
        read(path, unit={"gyro": "rad/s"})
    for device in devices:
        record = read(path, unit={"gyro": "rad/s"}, topic=f"imu{device}")
        np.testing.assert_array_equal(record.stream_of("gyro_y").column("gyro_y"), values[device][:, 1])
        assert [note for note in record.provenance.conversions if note.startswith("rows with")] == [
            f"rows with {device} in column 1 '{column}'"
        ]


@pytest.mark.parametrize(
    ("names", "rates"),
    [(("gyro_{} [rad/s]", "accel_{} [m/s^2]"), (100.0, 100.0)), (("gyr{}", "acc{}"), (100.0, 50.0))],
)
def test_a_row_for_each_value(tmp_path, names, rates):
    rows, columns = [], {}
    for sensor, name, rate in zip((gyro, accel), names, rates, strict=True):
        t, values = sensor(f"long {name}{rate}", rate)
        for axis, column in zip("xyz", values.T, strict=True):
            columns[name.format(axis)] = column
            rows += [(s, name.format(axis), v) for s, v in zip(t.tolist(), column.tolist(), strict=True)]
    path = tmp_path / "log.csv"
    path.write_text("\n".join(["time_s,signal,value", *(f"{s:.2f},{name},{v}" for s, name, v in sorted(rows)), ""]))
    record = read(path, **({} if "[" in names[0] else {"unit": UNITS}))
    for sensor, name, rate in zip(("gyro", "accel"), names, rates, strict=True):
        assert record.stream_of(f"{sensor}_x").grid.rate == pytest.approx(rate)
        for axis in "xyz":
            got = record.stream_of(f"{sensor}_{axis}").column(f"{sensor}_{axis}")
            np.testing.assert_array_equal(got, columns[name.format(axis)])
