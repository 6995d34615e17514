"""Examples of findings for `test_words`."""

from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds import reading as kinds
from sigmatau.findings.kinds.reading import Place


def error(kind, **fields):
    return Finding(details=kind(**fields), severity="error")


def warning(kind, **fields):
    return Finding(details=kind(**fields), severity="warning")


def info(kind, **fields):
    return Finding(details=kind(**fields), severity="info")


SHARE = {"kept": 30, "declared": 31, "counted": "messages", "topic": "/imu"}

EXAMPLES = [
    error(kinds.BrokenOff, place=Place("line", 102), kept=100),
    error(kinds.BrokenOff, what="gzip stream", place=Place("line", 102), kept=100),
    error(kinds.BrokenOff, inside="number", kept=100),
    error(kinds.BrokenOff, place=Place("byte", 4000, of=4012), inside="message", kept=1, counted="messages"),
    error(kinds.BrokenOff, place=Place("row", 100), inside="row", got=5, expected=28, kept=100),
    error(kinds.BrokenOff, place=Place("segment", 3, byte=900), got=100, expected=400),
    error(kinds.BrokenOff, what="array", kept=600, declared=1000),
    error(kinds.BrokenOff, part="b_2.db3", reason="the database cannot be read further (database disk image)", **SHARE),
    warning(
        kinds.BrokenOff, place=Place("byte", 9000), reason="the file has no index at its end", **SHARE | {"kept": 31}
    ),
    error(kinds.Damaged, place=Place("line", 102), reason="bytes that are not text", kept=100),
    error(kinds.Damaged, **SHARE),
    error(
        kinds.Damaged,
        place=Place("row group", 2, of=4),
        got=900,
        expected=1000,
        measured="rows",
        kept=1000,
        declared=4000,
    ),
    error(
        kinds.Damaged,
        place=Place("message", 5),
        got=33,
        expected=32,
        measured="samples",
        kept=128,
        counted="samples",
        topic="sensor_gyro_fifo:0",
    ),
    error(kinds.Damaged, what="definition of sensor_gyro", reason="'int' is not a field"),
    error(kinds.Damaged, place=Place("row", 700), reason="time goes backwards", kept=700, declared=1000),
    error(kinds.NoEndMark, what="stream"),
    error(kinds.PartMissing, part="b_2.db3", number=2, of=3),
    error(kinds.PartMissing, part="b_2.db3", number=2, of=3, reason="is empty"),
    info(kinds.PartOfSeveral, number=2, of=3),
    error(kinds.BrokenMessages, count=3, places=(112, 4000, 9000), kept=997),
    error(kinds.BytesBetween, bytes=96, count=2, place=Place("byte", 4000), kept=997),
    error(kinds.BrokenLines, count=50, inner=48, examples=((51, "has a wrong checksum"),), kept=950, topic="VNYMR"),
    warning(kinds.BrokenLines, count=1, inner=0, examples=((1, "does not begin with $"),), kept=950, topic="VNYMR"),
    info(kinds.OtherSentences, count=500, example="VNGYR", topic="VNYMR"),
    error(kinds.OtherSentences, count=500, example="VNGYR", topic="VNYMR", line=201, run=300),
    error(kinds.BytesNotRead, bytes=40_000, place=Place("byte", 9000), after="the Arrow file"),
    error(kinds.BytesNotRead, bytes=1, place=Place("byte", 0)),
    info(kinds.Filler, bytes=4096, place=Place("byte", 9000), after="the last message", value=0),
    error(kinds.HiddenRows, line=32),
    error(kinds.HiddenRows, line=32, count=10),
    info(kinds.Comments, line=22),
    info(kinds.Comments, line=22, count=2),
    info(kinds.HeaderAgain, line=502),
    error(kinds.SecondHeader, line=502, kept=500),
    info(kinds.NoLineEnd),
    error(kinds.NeverWritten, rows=1000, zeros=400, kept=599),
    error(kinds.NeverWritten, rows=1000, zeros=400, kept=599, column="'time [s]'", is_time=True),
    error(kinds.NeverWritten, rows=1000, zeros=400, kept=599, column="'gyro_z'"),
    info(kinds.ColumnsNotRead, columns=("'pressure [Pa]'",), channels=(("gyro_z", 2), ("pressure", 3))),
    info(
        kinds.ColumnsNotRead,
        columns=tuple(f"'coil_{k} [V]'" for k in range(6)),
        channels=(
            *(
                (f"{sensor}_{axis}", k)
                for k, (sensor, axis) in enumerate([(s, a) for s in ("gyro", "accel") for a in "xyz"], 2)
            ),
            *((f"coil_{k}", 8 + k) for k in range(4)),
        ),
        as_rates=True,
        topic="/imu",
    ),
    info(kinds.ColumnsByGravity, gyro=(2, 4), accel=(5, 7), time=1, gravity=9.8066, other=0.0123),
    warning(kinds.GravityOnGyro, gyro=9.8066, accel=0.0123),
    error(kinds.Unusable, reason="line 12: column time [s] has 'x', which is not a number; correct or delete the line"),
    warning(kinds.UnknownMessages, count=12),
    warning(kinds.UnfinishedMessage, place=Place("byte", 4000), bytes=12),
    info(kinds.DeletedMessages, count=200, topic="/imu"),
    error(kinds.PropertyChanged, topic="IMU", name="wf_increment", old=0.01, new=0.005, kept=600),
    error(kinds.UnequalLengths, lengths=(("Gyro X", 1000), ("Gyro Y", 1000), ("Gyro Z", 600))),
    error(kinds.MissingSamples, column="gyro_x", count=17, fill=-9999.0),
    warning(kinds.LoggerDropouts, count=2, total=0.17, longest=0.12),
    Finding(details=kinds.UnitOverruled(given="V", stated="Pa"), severity="warning", channels=("p",)),
    Finding(
        details=kinds.UnitOverruled(given="rad/s", stated="V", known=False), severity="warning", channels=("gyro_x",)
    ),
]
