"""Examples of findings for `test_words`."""

from sigmatau.findings import columns, reading
from sigmatau.findings.finding import Finding
from sigmatau.findings.reading import Place


def error(kind, **fields):
    return Finding(details=kind(**fields), severity="error")


def warning(kind, **fields):
    return Finding(details=kind(**fields), severity="warning")


def info(kind, **fields):
    return Finding(details=kind(**fields), severity="info")


SHARE = {"kept": 30, "declared": 31, "counted": "messages", "topic": "/imu"}

EXAMPLES = [
    error(reading.Damaged, truncated=True, place=Place("line", 102), kept=100),
    error(reading.Damaged, truncated=True, what="gzip stream", place=Place("line", 102), kept=100),
    error(reading.Damaged, truncated=True, inside="line", kept=100),
    error(reading.Damaged, truncated=True, place=Place("byte", 4000, of=4012), inside="message", **SHARE),
    error(reading.Damaged, truncated=True, place=Place("row", 100), inside="row", reason="5 of 28 bytes", kept=100),
    error(reading.Damaged, truncated=True, place=Place("segment", 3, byte=900), reason="100 of 400 bytes"),
    error(reading.Damaged, truncated=True, what="array", kept=600, declared=1000),
    error(
        reading.Damaged,
        truncated=True,
        part="b_2.db3",
        reason="the database cannot be read further (database disk image)",
        **SHARE,
    ),
    warning(
        reading.Damaged,
        truncated=True,
        place=Place("byte", 9000),
        reason="the file has no index at its end",
        **SHARE | {"kept": 31},
    ),
    error(reading.Damaged, place=Place("line", 102), reason="bytes that are not text", kept=100),
    error(reading.Damaged, **SHARE),
    error(reading.Damaged, place=Place("row group", 2, of=4), reason="900 of 1000 rows", kept=1000, declared=4000),
    error(reading.Damaged, what="definition of sensor_gyro", reason="'int' is not a field"),
    error(reading.Damaged, place=Place("row", 700), reason="time goes backwards", kept=700, declared=1000),
    error(reading.PartMissing, part="b_2.db3", number=2, of=3),
    error(reading.PartMissing, part="b_2.db3", number=2, of=3, reason="is empty"),
    info(reading.PartMissing, number=2, of=3, alone=True),
    error(reading.MissingChunks, array="imu/gyro_x", count=2, of=100, first=30000),
    error(reading.SkippedMessages, count=3, place=Place("byte", 112), kept=997),
    error(
        reading.SkippedMessages,
        count=50,
        unit="lines",
        place=Place("line", 51),
        example="has a wrong checksum",
        kept=950,
    ),
    info(
        reading.SkippedMessages,
        count=1,
        unit="lines",
        place=Place("line", 1),
        example="does not begin with $",
        kept=950,
    ),
    warning(reading.SkippedMessages, count=1, place=Place("byte", 4000)),
    warning(
        reading.SkippedMessages, count=3, unit="lines", example="gyro_x 0.1 0.2 0.3 0.4 0.5 0.6 0.7 0.8 0.9 1.0 1.1"
    ),
    warning(reading.SkippedMessages, count=12, other=True),
    info(reading.SkippedMessages, count=500, other=True, example="$VNGYR", kept=950),
    error(reading.SkippedMessages, count=500, other=True, example="$VNGYR", place=Place("line", 201), kept=950),
    error(reading.BytesNotRead, bytes=40_000, place=Place("byte", 9000), after="the Arrow file"),
    error(reading.BytesNotRead, bytes=1, place=Place("byte", 0)),
    info(reading.BytesNotRead, bytes=4096, place=Place("byte", 9000), after="the last message", padding=True),
    error(reading.SkippedLines, what="comments", line=32),
    error(reading.SkippedLines, what="comments", line=32, count=10),
    error(reading.SkippedLines, what="header", line=502, kept=500),
    info(reading.SkippedLines, what="last"),
    error(reading.NeverWritten, rows=1000, zeros=400, kept=599),
    error(reading.NeverWritten, rows=1000, zeros=400, kept=599, column="'time [s]'"),
    info(columns.ColumnsByGravity, gyro=(2, 4), accel=(5, 7), time=1, gravity=9.8066, other=0.0123),
    warning(columns.IncompleteSensor, missing="gyro_z"),
    warning(columns.IncompleteSensor, missing="gyro_z", column="gyro_z [rad/s1_000", number=4),
    warning(columns.UnreadSensor, sensor="accel", columns=("Accu E", "Accu N", "Accu U"), numbers=(2, 3, 4)),
    warning(columns.UnreadSensor, sensor="gyro", columns=("P [rad/s]", "Q [rad/s]", "R [rad/s]"), numbers=(3, 5, 7)),
    info(columns.UnusedColumns, columns=("alpha_x",)),
    info(columns.UnusedColumns, columns=("Microstrain filter status", *(f"field {k}" for k in range(12)))),
    warning(columns.MixedUnits, units=(("gyro_x", "deg/s"), ("gyro_y", "deg/s"), ("gyro_z", "rad/s"))),
    warning(reading.UnreadArrays, names=("yro_rad_s.npy",)),
    warning(columns.GravityOnGyro, gyro=9.8066, accel=0.0123),
    error(
        reading.Unusable, reason="line 12: column time [s] has 'x', which is not a number; correct or delete the line"
    ),
    warning(reading.LoggerDropouts, count=2, total=0.17, longest=0.12),
    Finding(details=columns.UnitOverruled(given="V", stated="Pa"), severity="warning", channels=("p",)),
    Finding(
        details=columns.UnitOverruled(given="rad/s", stated="V", known=False), severity="warning", channels=("gyro_x",)
    ),
    Finding(
        details=columns.UnitOverruled(given="rad/s", stated="furlong/s", known=False),
        severity="warning",
        channels=("gyro_x",),
    ),
]
