"""Dates and times of day as text: each spelling gives the rate of the log; damage names its line."""

import datetime as dt
import gzip

import numpy as np
import pytest

from sigmatau.errors import DataError, OptionError
from sigmatau.io.read import read

N = 2000
EVENING = dt.datetime(2019, 7, 22, 23, 59, 51)  # noqa: DTZ001  the log runs over midnight
MORNING = dt.datetime(2019, 7, 22, 9, 59, 51)  # noqa: DTZ001  and over a full hour
NOON = dt.datetime(2019, 7, 22, 11, 59, 51)  # noqa: DTZ001
AMBIGUOUS = dt.datetime(2019, 7, 8, 23, 59, 51)  # noqa: DTZ001


def millis(time):
    return time.microsecond // 1000


FORMS = {
    "hour of one digit": (MORNING, lambda t: f"{t.hour}:{t:%M:%S}.{millis(t):03}"),
    "colon before milliseconds": (MORNING, lambda t: f"{t:%H:%M:%S}:{millis(t):03}"),
    "milliseconds without zeros": (MORNING, lambda t: f"{t.hour}:{t.minute}:{t.second}:{millis(t)}"),
    "clock over midnight": (EVENING, lambda t: f"{t:%H:%M:%S}.{millis(t):03}"),
    "microseconds": (EVENING, lambda t: f"{t:%H:%M:%S.%f}"),
    "AM, PM over midnight": (EVENING, lambda t: f"{t:%I:%M:%S}.{millis(t):03} {t:%p}"),
    "am, pm at noon": (NOON, lambda t: f"{t:%I:%M:%S}.{millis(t):03}{t:%p}".lower()),
    "date with AM, PM": (EVENING, lambda t: f"{t:%m/%d/%Y %I:%M:%S}.{millis(t):03} {t:%p}"),
    "minutes and seconds, over an hour": (EVENING, lambda t: f"{t:%M:%S}.{millis(t):03}"),
    "day.month.year": (EVENING, lambda t: f"{t:%d.%m.%Y %H:%M:%S}.{millis(t):03}"),
    "day/month/year": (EVENING, lambda t: f"{t:%d/%m/%Y %H:%M:%S}.{millis(t):03}"),
    "month/day/year": (EVENING, lambda t: f"{t:%m/%d/%Y %H:%M:%S}.{millis(t):03}"),
    "month/day/year of two digits": (EVENING, lambda t: f"{t.month}/{t.day}/{t:%y} {t.hour}:{t:%M:%S}.{millis(t):03}"),
    "either order, over midnight": (AMBIGUOUS, lambda t: f"{t:%m/%d/%Y %H:%M:%S}.{millis(t):03}"),
    "the other order, over midnight": (AMBIGUOUS, lambda t: f"{t:%d/%m/%Y %H:%M:%S}.{millis(t):03}"),
    "name of the month": (EVENING, lambda t: f"{t.day}-{['Jul', 'Aug'][t.month - 7]}-{t:%Y %H:%M:%S}.{millis(t):03}"),
    "ISO without zeros": (EVENING, lambda t: f"{t.year}-{t.month}-{t.day} {t.hour}:{t:%M:%S}.{millis(t):03}"),
    "ISO with a zone": (EVENING, lambda t: f"{t.isoformat(timespec='milliseconds')}+05:30"),
    "ISO with Z": (EVENING, lambda t: f"{t.isoformat(timespec='microseconds')}Z"),
    "day of the year": (EVENING, lambda t: f"{t:%Y-%jT%H:%M:%S}.{millis(t):03}Z"),
    "day of the year with colons": (EVENING, lambda t: f"{t:%Y:%j:%H:%M:%S}.{millis(t):03}"),
    "comma in quotes": (EVENING, lambda t: f'"{t:%d/%m/%Y, %H:%M:%S}.{millis(t):03}"'),
}


def lines_of(start, form, rate=100, n=N):
    """Rows of a stamp and two small numbers."""
    step = 1_000_000 // rate
    return [f"{form(start + dt.timedelta(microseconds=step * k))},{k % 7},{k % 5}" for k in range(n)]


def log(tmp_path, rows, header="Time,gx [deg/s],b", name="log.csv"):
    path = tmp_path / name
    path.write_text("\n".join([header, *rows] if header else rows) + "\n")
    return path


def assert_regular(record, rate=100.0, n=N):
    (stream,) = record.streams
    assert (stream.grid.rate, stream.grid.n) == (pytest.approx(rate, rel=1e-9), n)
    assert record.findings == ()
    np.testing.assert_allclose(np.rad2deg(stream.column(stream.channels[0])[:9]), np.arange(9) % 7, atol=1e-12)


@pytest.mark.parametrize("name", FORMS)
def test_each_form(tmp_path, name):
    assert_regular(read(log(tmp_path, lines_of(*FORMS[name])), channels={"gyro_x": 2}))


@pytest.mark.parametrize(
    ("name", "header"),
    [
        ("hour of one digit", ""),
        ("clock over midnight", "Local time (UTC),x [deg/s],b"),
        ("day.month.year", ""),
        ("day.month.year", "Local time (UTC),x [deg/s],b"),
    ],
)
def test_a_clock_is_the_time_column_whatever_its_name(tmp_path, name, header):
    record = read(log(tmp_path, lines_of(*FORMS[name]), header), channels={"gyro_x": 2}, unit={"gyro": "deg/s"})
    assert_regular(record)


@pytest.mark.parametrize("separator", [";", "\t"])
def test_decimal_commas(tmp_path, separator):
    rows = [row.replace(",", separator).replace(".", ",") for row in lines_of(*FORMS["clock over midnight"])]
    path = log(tmp_path, rows, f"Zeit{separator}gx [deg/s]{separator}b")
    assert_regular(read(path, channels={"gyro_x": 2}))


@pytest.mark.parametrize(
    ("days", "order", "start"),
    [
        ("%d.%m.%Y", "day,time", EVENING),
        ("%m/%d/%Y", "time,day", AMBIGUOUS),
        ("%m/%d/%Y", "time,x,day", EVENING),
        ("%Y-%m-%d", "time,x,day", AMBIGUOUS),
        ("%d/%m/%y", "day,time", AMBIGUOUS),
    ],
)
def test_day_and_time_in_columns_of_their_own(tmp_path, days, order, start):
    rows = []
    for k in range(N):
        t = start + dt.timedelta(milliseconds=10 * k)
        texts = {"day": t.strftime(days), "time": f"{t.hour}:{t:%M:%S}.{millis(t):03}", "x": "1"}
        rows.append(",".join([*(texts[name] for name in order.split(",")), str(k % 7), str(k % 5)]))
    named = {"day": "Date", "time": "Time", "x": "x"}
    header = ",".join([*(named[name] for name in order.split(",")), "gx [deg/s]", "b"])
    assert_regular(read(log(tmp_path, rows, header), channels={"gyro_x": order.count(",") + 2}))


def test_two_nights(tmp_path):
    form = FORMS["clock over midnight"][1]
    start = dt.datetime(2019, 7, 22, 20)  # noqa: DTZ001
    rows = [f"{form(start + dt.timedelta(seconds=30 * k))},{k % 7},{k % 5}" for k in range(N)]  # 16.7 hours
    rows += [f"{form(start + dt.timedelta(seconds=30 * k))},{k % 7},{k % 5}" for k in range(N, 3 * N)]
    record = read(log(tmp_path, rows, "Time,t1,b"), channels={"x": 2}, unit={"x": "degC"})
    assert (record.streams[0].grid.n, record.findings) == (3 * N, ())
    assert record.streams[0].grid.rate == pytest.approx(1 / 30, rel=1e-9)


def test_an_order_that_the_values_do_not_show_is_asked(tmp_path):
    rows = [f"0{1 + k // 3}/0{4 + k % 3}/2019 00:00:00,{k % 7},1" for k in range(9)]
    with pytest.raises(OptionError, match=r"order of day and month in column 'Time' \(01/04/2019 00:00:00\)") as error:
        read(log(tmp_path, rows), channels={"x": 2})
    assert "--channels time=none --rate HZ" in str(error.value)
    assert read(log(tmp_path, rows), channels={"x": 2, "time": "none"}, rate=1).streams[0].grid.n == 9


def changed(rows, k, function):
    return [*rows[:k], function(rows[k]), *rows[k + 1 :]]


@pytest.mark.parametrize(
    ("name", "row"),
    [("clock over midnight", 300), ("date with AM, PM", 1500), ("day/month/year", 1500), ("ISO with a zone", 300)],
)
class TestDamage:
    def test_a_bad_text_names_its_line(self, tmp_path, name, row):
        rows = changed(lines_of(*FORMS[name]), row, lambda text: "00:0x" + text[5:])
        with pytest.raises(DataError, match=rf"line {row + 2}: column Time has '00:0x.*', which is not a time"):
            read(log(tmp_path, rows), channels={"gyro_x": 2})

    def test_a_wrong_time_names_its_line(self, tmp_path, name, row):
        wrong = FORMS[name][1](FORMS[name][0] - dt.timedelta(hours=7))
        rows = changed(lines_of(*FORMS[name]), row, lambda text: ",".join([wrong, *text.split(",")[1:]]))
        found = {f.code: f for f in read(log(tmp_path, rows), channels={"gyro_x": 2}).findings}
        assert set(found) == {"bad_stamps", "gaps"}
        assert (found["bad_stamps"].details.what, found["bad_stamps"].details.place) == ("wrong", f"line {row + 2}")

    def test_no_time_names_its_line(self, tmp_path, name, row):
        rows = changed(lines_of(*FORMS[name]), row, lambda text: "," + text.partition(",")[2])
        found = {f.code: f for f in read(log(tmp_path, rows), channels={"gyro_x": 2}).findings}
        assert (found["bad_stamps"].details.what, found["bad_stamps"].details.place) == ("missing", f"line {row + 2}")

    def test_a_log_that_is_cut(self, tmp_path, name, row):
        path = log(tmp_path, lines_of(*FORMS[name]))
        text = path.read_text().splitlines(keepends=True)
        for end in (text[row + 1][:4], text[row + 1][:14], text[row + 1].rstrip()[:-2]):
            path.write_text("".join(text[: row + 1]) + end)
            record = read(path, channels={"gyro_x": 2})
            assert record.streams[0].grid.n == row
            assert [(f.code, f.severity) for f in record.findings] == [("damaged", "error")]


ARROWS = {"channels": {"gyro": "1:3"}, "unit": {"gyro": "deg/s"}}


def arrows(separator=",", arrow=" -> ", start=EVENING):
    """Lines as the serial monitor of the Arduino IDE writes them."""
    times = (start + dt.timedelta(milliseconds=10 * k) for k in range(N))
    return [
        f"{t:%H:%M:%S}.{millis(t):03}{arrow}{separator.join((str(k % 7), str(k % 5), '1.5'))}"
        for k, t in enumerate(times)
    ]


class TestArrows:
    @pytest.mark.parametrize(
        ("separator", "arrow"), [(",", " -> "), ("\t", "->"), (" ", " -> "), (";", "->"), (", ", " -> ")]
    )
    def test_columns_are_counted_behind_the_arrow(self, tmp_path, separator, arrow):
        path = log(tmp_path, arrows(separator, arrow), "")
        record = read(path, **ARROWS)
        assert_regular(record)
        assert "time of day before -> on each line, read as column clock" in record.provenance.conversions
        path.write_bytes(gzip.compress(path.read_bytes()))
        assert_regular(read(path, **ARROWS))
        path.write_text("\n".join(arrows(separator, arrow)), encoding="utf-16")
        assert_regular(read(path, **ARROWS))

    def test_a_header_behind_an_arrow(self, tmp_path):
        header = "23:59:50.900 -> Ready\n23:59:50.950 -> \n23:59:50.990 -> gx [deg/s],gy [deg/s],gz [deg/s]"
        assert_regular(read(log(tmp_path, arrows(), header)))

    def test_the_clock_of_the_sensor_before_that_of_the_monitor(self, tmp_path):
        rows = [row.replace("-> ", f"-> {5 * k},") for k, row in enumerate(arrows())]
        record = read(log(tmp_path, rows, "0:00:00.1 -> millis,gx [deg/s],gy [deg/s],gz [deg/s]"))
        assert_regular(record, rate=200.0)

    @pytest.mark.parametrize(
        ("damage", "words"),
        [
            (lambda row: row.partition("-> ")[2], "line 801: 3 fields, 4 expected"),
            (lambda row: row[:19], "line 801: 2 fields, 3 expected"),
            (
                lambda row: row.replace("23:59:59", "23:5x:59").replace("00:00", "00:0x"),
                "clock has '.*', which is not a time",
            ),
            (lambda row: row.replace("1.5", "1.5x"), "line 801: column number 3 has '1.5x'"),
        ],
    )
    def test_damage_names_its_line(self, tmp_path, damage, words):
        with pytest.raises(DataError, match=words):
            read(log(tmp_path, changed(arrows(), 800, damage), ""), **ARROWS)

    @pytest.mark.parametrize("size", [4, 13, 17, 19])
    def test_a_log_that_is_cut(self, saved, size):
        path = saved("\n".join([*arrows()[:1000], arrows()[1000][:size]]), "log.txt")
        record = read(path, **ARROWS)
        assert record.streams[0].grid.n == 1000
        assert [f.code for f in record.findings] == ["damaged"]

    def test_an_arrow_in_a_few_lines_is_no_clock(self, tmp_path):
        rows = [f"{k / 100},{k % 7},{k % 5}" for k in range(N)]
        path = log(tmp_path, ["12:00:00.000 -> started", *rows], "time [s],gx [deg/s],b")
        with pytest.raises(OptionError, match=r"no column names|known name"):
            read(path)
