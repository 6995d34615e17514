"""Numbers that are missing, rows that are another sensor's, and a temperature beside the sensors."""

import numpy as np
import pytest

import sigmatau
from known import seed_of
from sigmatau import Record, analyze
from sigmatau.errors import DataError, OptionError
from sigmatau.io.read import read
from sigmatau.io.read.columns import choose
from sigmatau.io.read.table import Column

HEADER = "time [s],gyro_x [deg/s]\n"
N = 10


def log(tmp_path, text):
    path = tmp_path / "log.csv"
    path.write_bytes(text.encode())
    return path


def rows(edit=None, n=N, separator=","):
    lines = [f"{i / 100}{separator}{i}" for i in range(n)]
    for row, text in (edit or {}).items():
        lines[row] = text
    return HEADER.replace(",", separator) + "".join(f"{line}\n" for line in lines)


def degrees(record):
    return record.streams[0].column("gyro_x") / (np.pi / 180)


WORDS = ["nan", "NaN", "-nan", "NA", "N/A", "null", "None", "", '""', " "]


class TestValues:
    @pytest.mark.parametrize("text", WORDS)
    def test_a_word_for_a_missing_number(self, tmp_path, text):
        record = read(log(tmp_path, rows({4: f"0.04,{text}"})))
        expected = np.arange(10.0)
        expected[4] = np.nan
        np.testing.assert_allclose(degrees(record), expected, rtol=1e-15)
        (finding,) = record.findings
        assert (finding.code, finding.channel, finding.size) == ("missing_values", "gyro_x", 1)
        assert (finding.details.place, finding.details.total) == ("line 6", 10)
        assert record.streams[0].mask.sum() == 1

    def test_a_first_row_of_nan_is_no_header(self, tmp_path):
        record = read(log(tmp_path, rows({0: "0,nan"})))
        assert record.streams[0].grid.n == 10
        assert np.isnan(degrees(record)[0])
        record = read(log(tmp_path, rows({0: "nan,nan"})))
        assert [f.code for f in record.findings] == ["bad_stamps"]
        assert record.streams[0].grid.n == 9

    @pytest.mark.parametrize("separator", [",", ";"])
    def test_last_columns_begin_after_thousands_of_rows(self, tmp_path, separator):
        head = separator.join(["time [s]", "gyro_x [deg/s]", "gyro_y [deg/s]", "accel_x [g]", "accel_y [g]"]) + "\n"
        early = [f"{i / 100},{i % 7},{i % 5},,\n" for i in range(3000)]
        late = [f"{i / 100},{i % 7},{i % 5},0.5,0.25\n" for i in range(3000, 4000)]
        record = read(log(tmp_path, head + "".join(early + late).replace(",", separator)))
        assert record.channels == ("gyro_x", "gyro_y", "accel_x", "accel_y")
        accel = record.stream_of("accel_y")
        assert (accel.grid.n, accel.grid.start - record.stream_of("gyro_x").grid.start) == (1000, 30.0)
        np.testing.assert_allclose(accel.column("accel_y"), 0.25 * 9.80665, rtol=1e-15)

    def test_tabs(self, tmp_path):
        record = read(log(tmp_path, rows({4: "0.04\t", 6: "\t"}, separator="\t")))
        assert [f.code for f in record.findings] == ["bad_stamps", "gaps", "missing_values"]
        assert np.flatnonzero(np.isnan(degrees(record))).tolist() == [4, 6]

    def test_one_finding_for_several_axes(self, tmp_path):
        text = "time [s],wx [rad/s],wy [rad/s]\n" + "".join(
            f"{i / 100},{'' if i in (3, 5) else i},{'' if i == 5 else i}\n" for i in range(4000)
        )
        (finding,) = read(log(tmp_path, text)).findings
        assert (finding.channels, finding.severity, finding.size) == (("gyro_x", "gyro_y"), "info", 2)
        details = finding.details
        assert (details.total, details.counts, details.strongest) == (4000, (2, 1), "gyro_x")

    @pytest.mark.parametrize(("share", "stamps"), [(0.6, True), (0.999, False), (1.0, True)])
    def test_one_empty_channel_costs_no_other(self, tmp_path, share, stamps):
        rng = np.random.default_rng(seed_of(f"empty channel {share} {stamps}"))
        n = 20_000
        x, y, z = 1e-3 * rng.normal(size=(3, n))
        y[rng.random(n) < share] = np.nan
        data = {"wx": x, "wy": y, "wz": z} | ({"t": np.arange(n) / 100} if stamps else {})
        unit = {"gyro": "rad/s"} | ({"time": "s"} if stamps else {})
        record = sigmatau.from_frame(data, unit=unit, **({} if stamps else {"rate": 100}))
        assert record.channels == ("gyro_x", "gyro_z")
        np.testing.assert_array_equal(record.streams[0].column("gyro_z"), z)
        (finding,) = record.findings
        assert (finding.code, finding.severity, finding.channel) == ("missing_values", "error", "gyro_y")
        assert (finding.size, finding.details.total) == (np.isnan(y).sum(), n)
        analysis = analyze(record)
        assert {f.code for f in analysis.findings} - {"second_explanation"} == {"missing_values"}
        alone = analyze(Record.from_arrays(rate=100, gyro_x=x, gyro_z=z))
        assert alone.fits["gyro_x"].observed == pytest.approx(analysis.fits["gyro_x"].observed, rel=1e-9)
        assert np.isnan(data["wy"]).any()

    def test_inspect_tells_of_channels_with_nothing_in_them(self, tmp_path):
        rng = np.random.default_rng(seed_of("nothing in them"))
        lines = [f"{k / 100:.2f},{a!r},,3.5" for k, a in enumerate((1e-3 * rng.normal(size=2000)).tolist())]
        path = log(tmp_path, "time [s],wx [rad/s],wy [rad/s],wz [rad/s]\n" + "\n".join(lines) + "\n")
        found = sigmatau.inspect(path)
        told = {(f.code, f.channel) for f in (*found.record.findings, *found.checks)}
        assert told == {("missing_values", "gyro_y"), ("constant_channel", "gyro_z")}
        analysis = analyze(read(path))
        assert {(f.code, f.channel) for f in analysis.findings} == told
        assert list(analysis.curves) == ["gyro_x"]

    @pytest.mark.parametrize(("end", "kept"), [("0.10,", 10), ("0.10,1", 10), ("0.10,1\n", 11), ("0.10,\n", 11)])
    def test_a_last_field_that_was_cut_off_is_no_missing_number(self, tmp_path, end, kept):
        record = read(log(tmp_path, rows() + end))
        assert record.streams[0].grid.n == kept
        if end == "0.10,":
            assert [(f.code, f.severity) for f in record.findings] == [("skipped_lines", "info")]

    def test_a_delimiter_at_the_end_of_every_line(self, tmp_path):
        text = "\n".join(f"{line}," for line in rows().splitlines())
        assert read(log(tmp_path, f"{text}\n")).streams[0].grid.n == 10

    def test_accumulated(self):
        """A missing angle costs the rates on both sides."""
        angle = np.cumsum(np.arange(20.0))
        angle[7] = np.nan
        record = sigmatau.from_frame({"wx": angle}, rate=1, unit={"gyro": "rad"}, input="accumulated")
        assert np.flatnonzero(np.isnan(record.streams[0].column("gyro_x"))).tolist() == [6, 7]

    def test_clean_logs_are_views_of_what_they_hold(self):
        x = np.random.default_rng(seed_of("views")).normal(size=1000)
        record = sigmatau.from_frame({"t": np.arange(1000) / 100, "wx": x}, unit={"gyro": "rad/s", "time": "s"})
        assert np.shares_memory(record.streams[0].samples.raw[0], x)
        assert record.streams[0].mask is None


class TestInterleaved:
    @pytest.mark.parametrize(("gyro_rate", "accel_rate"), [(100, 100), (100, 50), (400, 100)])
    def test_each_sensor_has_rows_of_its_own(self, tmp_path, gyro_rate, accel_rate):
        rng = np.random.default_rng(seed_of(f"interleaved {gyro_rate} {accel_rate}"))
        gyro, accel = rng.normal(size=10 * gyro_rate), rng.normal(size=10 * accel_rate)
        lines = [(f"{k / gyro_rate:.6f}", f"{v!r}", "") for k, v in enumerate(gyro.tolist())]
        lines += [(f"{k / accel_rate + 0.0013:.6f}", "", f"{v!r}") for k, v in enumerate(accel.tolist())]
        lines.sort(key=lambda line: float(line[0]))
        text = "time [s],gyro_x [rad/s],accel_x [m/s^2]\n" + "".join(",".join(line) + "\n" for line in lines)
        record = read(log(tmp_path, text))
        for stream, rate, values in zip(record.streams, (gyro_rate, accel_rate), (gyro, accel), strict=True):
            assert stream.grid.rate == pytest.approx(rate, rel=1e-9)
            assert stream.mask is None
            np.testing.assert_array_equal(stream.column(stream.channels[0]), values)
        assert record.streams[1].grid.start == pytest.approx(0.0013, abs=1e-9)
        assert record.findings == ()
        assert any("rows, with the stamps of these" in c for c in record.provenance.conversions)

    def test_without_stamps_it_is_refused(self, tmp_path):
        text = "gyro_x [rad/s],accel_x [m/s^2]\n" + "1,\n,2\n,2\n" * 20
        with pytest.raises(DataError, match=r"separate rows for gyro.*--channels time="):
            read(log(tmp_path, text), rate=100)

    def test_a_lost_row_is_a_gap_in_its_own_stream(self, tmp_path):
        lines = [f"{k / 200:.6f},{k}," if k % 2 else f"{k / 200:.6f},,{k}" for k in range(400) if k != 101]
        record = read(log(tmp_path, "time [s],gyro_x [rad/s],accel_x [m/s^2]\n" + "\n".join(lines) + "\n"))
        (finding,) = record.findings
        assert (finding.code, finding.channel, finding.size) == ("gaps", "gyro", 1)
        assert record.stream_of("accel_x").mask is None
        assert int(record.stream_of("gyro_x").mask.sum()) == 1


NAMES = {
    "temp": None,
    "Temp": None,
    "temperature": None,
    "imu_temp": None,
    "temp_c": "degC",
    "temperature_degC": "degC",
    "temp [°C]": "degC",
    "Temperature (C)": "degC",
    "temp [K]": "K",
    "temp_f": "degF",
    "gyro_temp": None,
    "sensor_temperature": None,
    "T [degC]": "degC",
}
NO_NAMES = ["t", "T", "tempo", "temp_x", "temp [mV]", "temp [LSB]", "temp_raw", "battery_temp", "temporary", "ambient"]


class TestTemperature:
    @pytest.mark.parametrize(("name", "unit"), NAMES.items(), ids=NAMES)
    def test_names(self, name, unit):
        choice = choose([Column(name="gyro_x"), Column(name=name)], None)
        assert choice.temperature is not None
        assert (choice.temperature.index, choice.temperature.unit) == (1, unit)
        assert list(choice.channels) == ["gyro_x"]

    @pytest.mark.parametrize("name", NO_NAMES)
    def test_other_names(self, name):
        assert choose([Column(name="gyro_x"), Column(name=name)], None).temperature is None

    def test_of_several_the_one_of_the_whole_sensor(self):
        names = ("gyro_x", "gyro_temp", "temp", "accel_temp")
        assert choose([Column(name=n) for n in names], None).temperature.index == 2
        names = ("gyro_x", "temp", "temperature")
        assert choose([Column(name=n) for n in names], None).temperature is None

    @pytest.mark.parametrize(
        ("name", "values"),
        [("temp", lambda c: c), ("temp [K]", lambda c: c + 273.15), ("temp_f", lambda c: 1.8 * c + 32)],
    )
    def test_the_stream(self, name, values):
        celsius = 25 + np.arange(1000) / 100
        data = {"t": np.arange(1000) / 100, "wx": celsius, name: values(celsius)}
        record = sigmatau.from_frame(data, unit={"gyro": "rad/s", "time": "s"})
        stream = record.stream_of("temperature")
        assert (stream.name, stream.quantity, stream.unit) == ("temperature", "temperature", "degC")
        np.testing.assert_allclose(stream.column("temperature"), celsius, rtol=1e-12)
        assert stream.grid == record.streams[0].grid
        assumed = any("degC assumed" in c for c in record.provenance.conversions)
        assert assumed == (name == "temp")
        assert record.findings == ()

    def test_it_is_never_refused(self, tmp_path):
        numbers = [f"{i / 100},{i}" for i in range(40)]
        for column, there in (
            (["x"] * 40, False),
            ([""] * 40, False),
            (["inf"] * 40, False),
            (["-3920"] * 40, False),  # counts
            (["", "", "", "20"] * 10, True),
            (["20"] * 39 + [""], True),
        ):
            pairs = zip(numbers, column, strict=True)
            record = read(log(tmp_path, "time [s],gyro_x [deg/s],temp,n\n" + "".join(f"{a},{b},1\n" for a, b in pairs)))
            np.testing.assert_allclose(degrees(record), np.arange(40.0), rtol=1e-15)
            assert record.findings == ()
            assert ("temperature" in record.channels) == there
            assert ("temp" in record.provenance.ignored) == (not there)

    def test_it_takes_part_in_the_gaps(self):
        keep = np.delete(np.arange(1000), [300, 301])
        data = {"t": keep / 100, "wx": keep * 1.0, "temp": 20 + keep / 1e3}
        stream = sigmatau.from_frame(data, unit={"gyro": "rad/s", "time": "s"}).stream_of("temperature")
        assert np.flatnonzero(np.isnan(stream.column("temperature"))).tolist() == [300, 301]

    def test_of_increments_it_is_none(self):
        data = {"t": np.arange(100) / 100, "wx": np.arange(100.0), "temp": np.full(100, 20.0)}
        record = sigmatau.from_frame(data, unit={"gyro": "rad", "time": "s"}, input="accumulated")
        assert (record.streams[0].grid.n, record.streams[1].grid.n) == (99, 100)
        assert set(record.streams[1].column("temperature")) == {20.0}

    def test_only_what_is_asked_for(self, tmp_path):
        text = "time [s],gyro_x [deg/s],temp\n" + "".join(f"{i / 100},{i},20\n" for i in range(40))
        assert read(log(tmp_path, text), channels={"gyro_x": 2}).channels == ("gyro_x",)
        with pytest.raises(OptionError, match="unit of temp"):
            read(log(tmp_path, text), channels={"gyro_x": 2, "temp": 3})

    def test_analyze_leaves_it_out(self):
        rng = np.random.default_rng(seed_of("temperature"))
        x = rng.normal(size=20_000)
        alone = Record.from_arrays(rate=100, gyro_x=x)
        degrees = 20 + rng.normal(size=20_000)
        beside = Record.from_arrays(rate=100, gyro_x=x, temperature=degrees, unit={"temperature": "degC"})
        assert beside.stream_of("temperature").quantity == "temperature"
        one, other = analyze(alone), analyze(beside)
        assert list(other.curves) == ["gyro_x"]
        np.testing.assert_array_equal(one.curves["gyro_x"].avar, other.curves["gyro_x"].avar)
        # Its noise may stay in the model by chance, where it changes next to nothing.
        walk, beside_it = one.fits["gyro_x"]["random_walk"], other.fits["gyro_x"]["random_walk"]
        assert beside_it.value == pytest.approx(walk.value, abs=0.1 * (walk.high - walk.low))


class TestArrays:
    """What a file would be told of is told of arrays as well."""

    @pytest.mark.parametrize("share", [5e-4, 0.4, 0.7])
    def test_nan_is_told(self, share):
        rng = np.random.default_rng(seed_of(f"nan in arrays {share}"))
        x = 1e-3 * rng.normal(size=20_000)
        x[np.flatnonzero(rng.random(len(x)) < share)] = np.nan
        record = Record.from_arrays(rate=100, gyro_x=x, gyro_y=1e-3 * rng.normal(size=len(x)))
        (finding,) = record.findings
        lost = int(np.isnan(x).sum())
        assert (finding.code, finding.channel, finding.size) == ("missing_values", "gyro_x", lost)
        assert finding.severity == ("info" if share < 1e-3 else "warning")
        first = int(np.flatnonzero(np.isnan(x))[0])
        assert (finding.details.total, finding.details.unit) == (20_000, "samples")
        assert finding.details.place.startswith(f"index {first} (t = ")
        assert finding in analyze(record).findings

    def test_a_block_is_told_with_its_length(self):
        rng = np.random.default_rng(seed_of("a block of nan"))
        gyro = 1e-3 * rng.normal(size=(20_000, 3))
        gyro[1000:8900, 1] = np.nan
        (finding,) = Record.from_arrays(rate=100, gyro=gyro).findings
        details = finding.details
        assert (finding.channels, finding.size, finding.spans) == (("gyro_y",), 7900, (pytest.approx((10.0, 89.0)),))
        assert (details.total, details.place, details.runs, details.longest) == (
            20_000,
            "index 1000 (t = 10 s)",
            1,
            7900,
        )


class TestThermometersOfArrays:
    @pytest.mark.parametrize(
        ("name", "unit"), [("temperature", None), ("temp", "degC"), ("imu_temp", "K"), ("temp", "degF")]
    )
    def test_a_name_that_says_so_is_a_temperature(self, name, unit):
        scale, offset = {"K": (1.0, 273.15), "degF": (1.8, 32.0)}.get(unit, (1.0, 0.0))
        degrees = 25 + np.linspace(0, 10, 1000)
        given = {name: unit} if unit else {}
        record = Record.from_arrays(
            rate=100, gyro_x=np.zeros(1000), unit=given, input="increments", **{name: degrees * scale + offset}
        )
        stream = record.stream_of(name)
        assert (stream.quantity, stream.unit) == ("temperature", "degC")
        np.testing.assert_allclose(stream.column(name), degrees, rtol=1e-13)
        assert ("degC assumed" in str(record.provenance.conversions)) == (unit is None)

    def test_numbers_that_are_none_and_names_that_say_nothing_are_signals(self):
        x = np.zeros(1000)
        record = Record.from_arrays(rate=100, gyro_x=x, temperature=x + 4000, warmth=x + 25)
        assert [s.quantity for s in record.streams] == ["angular_rate", "signal", "signal"]
        assert "treated as a signal" in record.provenance.conversions[0]
        volts = Record.from_arrays(rate=100, gyro_x=x, temperature=x + 1, unit={"temperature": "V"})
        assert (volts.streams[1].quantity, volts.streams[1].unit) == ("signal", "V")
        assert Record.from_arrays(rate=100, temperature=x + 25).streams[0].quantity == "signal"

    def test_what_follows_it_is_told_and_it_has_no_coefficients(self):
        rng = np.random.default_rng(seed_of("a gyro that follows arrays"))
        t = np.arange(100_000) / 50
        swing = np.sin(2 * np.pi * t / 900)
        gyro = 3e-3 * rng.normal(size=len(t)) + 2e-3 * swing
        found = analyze(
            Record.from_arrays(rate=50, gyro_x=gyro, temperature=25 + 3 * swing + 0.05 * rng.normal(size=len(t)))
        )
        assert list(found.fits) == ["gyro_x"]
        said = {f.code: f for f in found.findings}
        assert "late_drift" not in said
        # 2e-3 rad/s by 3 K, in SI; its interval in the message is of 95 %.
        assert said["temperature_drift"].size == pytest.approx(2e-3 / 3, rel=0.01)
