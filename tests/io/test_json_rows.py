"""JSON: rows line by line or in an array, and objects of arrays."""

import itertools
import json

import numpy as np
import pytest
from readings import axes

import known
from container_damage import cut, survives
from sigmatau.errors import DataError, OptionError
from sigmatau.io.read import opened, read
from sigmatau.io.read.options import ReadOptions

N = 900
STEP = 0.300 / 60 * np.sqrt(100.0)  # deg/s: 0.300 deg/√h at 100 Hz
RNG = np.random.default_rng(known.seed_of("json"))
GYRO, ACCEL = RNG.normal(0, STEP, (N, 3)), RNG.normal(0, 0.01, (N, 3)) + np.array([0, 0, 9.81])
START = 1_700_000_000_123_456_789
STAMPS = [START + 10_000_000 * k for k in range(N)]
UNIT = {"gyro": "deg/s", "accel": "m/s^2", "time": "ns"}
XYZ = ("x", "y", "z")


def named(values):
    return dict(zip(XYZ, values, strict=True))


ROWS = {
    "arrays": lambda t, g, a: {"t": t, "gyro": g, "accel": a},
    "nested": lambda t, g, a: {"imu": {"gyro": named(g), "accel": named(a)}, "timestamp": t, "id": "imu 7", "ok": True},
    "flat": lambda t, g, a: (
        {"time": t} | {f"g{k}": v for k, v in named(g).items()} | {"ax": a[0], "ay": a[1], "az": a[2]}
    ),
    "ros": lambda t, g, a: {
        "header": {"stamp": t, "frame_id": "x"},
        "angular_velocity": named(g),
        "linear_acceleration": named(a),
    },
}
FORMS = {
    "lines": lambda rows: "".join(json.dumps(row) + "\n" for row in rows),
    "lines below words": lambda rows: "Booting…\n\n" + "".join(json.dumps(row) + "\r\n" for row in rows),
    "array": lambda rows: json.dumps(rows),
    "indented": lambda rows: json.dumps(rows, indent=2) + "\n",
    "lines in an array": lambda rows: "[\n" + ",\n".join(map(json.dumps, rows)) + "\n]\n",
    "in an object": lambda rows: json.dumps({"device": "imu", "rate": 100, "samples": rows}),
}


def rows_of(kind, n=N):
    return [ROWS[kind](STAMPS[k], GYRO[k].tolist(), ACCEL[k].tolist()) for k in range(n)]


def exact(record, n=N):
    for name, values, factor in (("gyro", GYRO, np.pi / 180), ("accel", ACCEL, 1.0)):
        np.testing.assert_array_equal(axes(record, name), values[:n] * factor)
    grid = record.streams[0].grid
    assert (grid.n, grid.rate) == (n, pytest.approx(100, rel=1e-9))


@pytest.mark.parametrize(
    ("kind", "form"), [*zip(itertools.cycle(ROWS), FORMS, strict=False), ("ros", "lines"), ("flat", "array")]
)
def test_rows(tmp_path, kind, form):
    (tmp_path / "log").write_text(FORMS[form](rows_of(kind)))
    record = read(tmp_path / "log", unit=UNIT)
    exact(record)
    # The names of ROS state rad/s.
    assert {f.code for f in record.findings} <= {"unit_overruled", "unused_columns"}


def test_units_are_asked_for(tmp_path):
    (tmp_path / "log").write_text(FORMS["lines"](rows_of("arrays")))
    with pytest.raises(OptionError, match="does not state the unit of gyro_x"):
        read(tmp_path / "log")


@pytest.mark.parametrize("nested", [False, True])
def test_an_object_of_arrays(tmp_path, nested):
    gyro, accel = ({a: v[:, k].tolist() for k, a in enumerate(XYZ)} for v in (GYRO, ACCEL))
    flat = {f"gyro_{a}": gyro[a] for a in XYZ} | {f"accel_{a}": accel[a] for a in XYZ}
    document = {"time": STAMPS, "note": "lab", **({"gyro": GYRO.tolist(), "accel": accel} if nested else flat)}
    (tmp_path / "log").write_text(json.dumps(document))
    exact(read(tmp_path / "log", unit=UNIT))


def test_dates(tmp_path):
    rows = [
        {"time": f"2026-03-01T12:{k // 6000:02d}:{k / 100 % 60:06.3f}Z", "gyro": g.tolist()} for k, g in enumerate(GYRO)
    ]
    (tmp_path / "log").write_text(FORMS["lines"](rows))
    record = read(tmp_path / "log", unit={"gyro": "deg/s"})
    assert (record.streams[0].grid.n, record.streams[0].grid.rate) == (N, pytest.approx(100, rel=1e-9))


def test_a_field_that_rows_lack_is_missing(tmp_path):
    rows = rows_of("nested")
    del rows[5]["imu"]["gyro"]["y"]
    rows[6]["imu"]["accel"]["x"] = None
    (tmp_path / "log").write_text(FORMS["lines"](rows))
    record = read(tmp_path / "log", unit=UNIT)
    assert np.flatnonzero(np.isnan(record.stream_of("gyro_y").column("gyro_y"))).tolist() == [5]
    assert np.flatnonzero(np.isnan(record.stream_of("accel_x").column("accel_x"))).tolist() == [6]


def test_words_among_the_numbers(tmp_path):
    rows = rows_of("nested")
    rows[5]["imu"]["gyro"]["y"] = "overflow"
    (tmp_path / "log").write_text(FORMS["lines"](rows))
    with pytest.raises(DataError, match=r"row 5 .*: field imu\.gyro\.y has 'overflow', which is not a number"):
        read(tmp_path / "log", unit=UNIT)


def test_a_broken_line_is_named(tmp_path):
    lines = FORMS["lines"](rows_of("arrays")).splitlines()
    lines[400] = lines[400][:30]
    (tmp_path / "log").write_text("\n".join([*lines, ""]))
    with pytest.raises(DataError, match=r"line 401: .* is not JSON; correct or delete the line"):
        read(tmp_path / "log", unit=UNIT)


@pytest.mark.parametrize(
    "content", ["{}", "[]", "[1, 2", '{"a": "b"}', '[{"a": []}]', '{"a": [{"b": "c"}]}', "[[[[[[[[[[["]
)
def test_nothing_to_read(tmp_path, content):
    (tmp_path / "log").write_text(content)
    with pytest.raises((DataError, OptionError)):
        read(tmp_path / "log", rate=100)


@pytest.mark.parametrize(("form", "share"), [("lines", 0.999), ("array", 0.2), ("array", 0.999), ("indented", 0.7)])
def test_cut(tmp_path, form, share):
    path = tmp_path / "log"
    path.write_bytes(cut(FORMS[form](rows_of("nested")).encode(), share))
    record = read(path, unit=UNIT)
    n = record.streams[0].grid.n
    assert N * share - 3 < n < N
    exact(record, n)
    assert [f.code for f in record.findings if f.severity == "error"] == ["damaged"]


@pytest.mark.parametrize("form", ["lines", "array", "in an object"])
def test_mutants(saved, form):
    path = saved(FORMS[form](rows_of("nested", 40)), "log")
    assert survives(f"json {form}", path.read_bytes(), path, 100, unit=UNIT) > 0


TAGS = {"word": ("gyro", "accel"), "name": ("Gyroscope", "Accelerometer"), "short": ("GYR", "ACC")}
TAGGED = {
    "x, y, z": lambda tag, t, v: {"sensor": tag, "t": t, **named(v)},
    "array": lambda tag, t, v: {"timestamp": t, "type": tag, "values": v},
    "nested": lambda tag, t, v: {"name": tag, "time": t, "data": named(v)},
    "texts": lambda tag, t, v: {"name": tag, "time": str(t), **{k: repr(x) for k, x in named(v).items()}},
    "names": lambda tag, t, v: {"kind": tag, "t_ns": t, **{f"{tag[0].lower()}{k}": x for k, x in named(v).items()}},
}


@pytest.mark.parametrize(
    ("kind", "tags", "order"),
    list(zip(TAGGED, itertools.cycle(TAGS), itertools.cycle(["in turn", "in blocks"]), strict=False)),
)
def test_rows_with_the_sensor_in_a_field(saved, kind, tags, order):
    gyro, accel = ([TAGGED[kind](tag, STAMPS[k], x[k].tolist()) for k in range(N)]
                   for tag, x in zip(TAGS[tags], (GYRO, ACCEL), strict=True))  # fmt: skip
    rows = [*gyro, *accel] if order == "in blocks" else [row for pair in zip(gyro, accel, strict=True) for row in pair]
    path = saved(FORMS["lines"](rows), "log.jsonl")
    record = read(path, unit=UNIT)
    exact(record)
    assert set(record.provenance.topics) == set(TAGS[tags])


@pytest.mark.parametrize("ids", [("imu0", "imu1"), (0, 1), ("left", "right")])
def test_rows_of_two_sensors_in_a_field_are_asked_for(saved, ids):
    rows = [{"id": ids[k % 2], "t": STAMPS[k // 2], "gyro": (GYRO[k // 2] + k % 2).tolist()} for k in range(2 * N)]
    path = saved(FORMS["lines"](rows), "log.jsonl")
    topics = [f"imu{name}" if isinstance(name, int) else name for name in ids]
    with pytest.raises(OptionError, match=f"has {ids[0]} and {ids[1]}, so the rows are of several sensors"):
        read(path, unit={"gyro": "deg/s", "time": "ns"})
    record = read(path, unit={"gyro": "deg/s", "time": "ns"}, topic=topics[1])
    column = record.stream_of("gyro_x").column("gyro_x")
    np.testing.assert_allclose(column, (GYRO[:, 0] + 1) * np.pi / 180, rtol=1e-15)  # rounding of a product


def test_rows_of_one_sensor_in_a_field(saved):
    path = saved(
        FORMS["lines"]([TAGGED["x, y, z"]("gyro", STAMPS[k], GYRO[k].tolist()) for k in range(N)]), "log.jsonl"
    )
    assert read(path, unit={"gyro": "deg/s", "time": "ns"}).channels == ("gyro_x", "gyro_y", "gyro_z")


def test_fields_that_begin_late(tmp_path):
    """Rows of another kind beyond the first ones, and beyond those that are held at once, have their fields read."""
    path = tmp_path / "log.jsonl"
    first = [{"t": k, "gx": 0.5} for k in range((1 << 16) + 10)]
    rows = [*first, *({"t": len(first) + k, "ax": 2.0, "az": 9.0} for k in range(50))]
    path.write_text(FORMS["lines"](rows))
    with opened(path, ReadOptions()) as (_, tables):
        assert [column.name for column in tables[0].columns] == ["t", "gx", "ax", "az"]
        columns = tables[0].load([0, 1, 2], 0).columns
    assert columns[0].dtype == np.int64
    assert np.isnan(columns[2]).sum() == len(first)
    assert np.nansum(columns[2]) == 100
    assert np.isnan(columns[1]).sum() == 50
