"""Units of time by the stamps, by names and by two columns; rates that no log has; counters that overflow."""

import numpy as np
import pytest
from stamping import codes

from known import seed_of
from sigmatau.cli import main
from sigmatau.errors import OptionError, StampError
from sigmatau.io.read import read

N = 2000
GRID = np.arange(N) * 10_000_000  # 100 Hz [ns]
EPOCH = 1_581_180_792_034_123_456  # 2020-02-08 [ns]


def log(tmp_path, names, *columns, sensor="gyro_x [rad/s]"):
    path = tmp_path / "log.csv"
    names = f"{names},{sensor}" if names else sensor
    rows = (",".join((*map(str, row), str(k % 7))) for k, row in enumerate(zip(*columns, strict=True)))
    path.write_text("\n".join([names, *rows]) + "\n")
    return path


def rate_of(record):
    return record.streams[0].grid.rate


SIZES = {
    "seconds": ([f"{t // 10**9}.{t % 10**9:09d}"[:-4] for t in (EPOCH + GRID).tolist()], "s"),
    "whole seconds": ((EPOCH + GRID) // 10**9, "s"),
    "milliseconds": ((EPOCH + GRID) // 10**6, "ms"),
    "microseconds": ((EPOCH + GRID) // 10**3, "us"),
    "nanoseconds": (EPOCH + GRID, "ns"),
}


class TestSize:
    @pytest.mark.parametrize(
        ("size", "name"), list(zip(SIZES, ("time", "timestamp", "%time", "t", "time"), strict=True))
    )
    def test_a_stamp_that_counts_from_1970_shows_its_unit(self, tmp_path, size, name):
        stamps, unit = SIZES[size]
        record = read(log(tmp_path, name, stamps), channels={"gyro_x": 2})
        assert rate_of(record) == pytest.approx(100.0, rel=1e-3 if size == "whole seconds" else 1e-6)
        assert f"time stamps in {unit} by their size, counted from 1970" in record.provenance.conversions

    @pytest.mark.parametrize("stamps", [GRID / 1e9, GRID // 10**6, GRID // 10**3, GRID, 1_581_180_792 + GRID // 10**3])
    def test_others_are_asked(self, tmp_path, stamps):
        with pytest.raises(OptionError, match=r"unit of the time stamps in column 'time' is not stated"):
            read(log(tmp_path, "time", stamps), channels={"gyro_x": 2})

    def test_it_is_not_asked_with_the_units_of_sensors(self, tmp_path):
        with pytest.raises(OptionError) as error:
            read(log(tmp_path, "time", EPOCH + GRID, sensor="gyro_x"))
        assert "--unit time" not in str(error.value)


NAMES = {
    "t_ms": 6,
    "time_us": 3,
    "timestamp (ns)": 0,
    "Time(ms)": 6,
    "time in ms": 6,
    "Time [us]": 3,
    "TimeUS": 3,
    "timestamp_ns": 0,
    "millis": 6,
    "micros": 3,
    "ms": 6,
    "us": 3,
    "time_boot_ms": 6,
    "timestamp_in_us": 3,
}


@pytest.mark.parametrize("name", NAMES)
def test_names_with_a_unit(tmp_path, name):
    record = read(log(tmp_path, f'"{name}"', GRID // 10 ** NAMES[name]))
    assert (rate_of(record), record.findings) == (pytest.approx(100.0, rel=1e-9), ())


HALVES = {
    "header.stamp.secs,header.stamp.nsecs": 9,
    "sec,nanosec": 9,
    "header.stamp.sec,header.stamp.nanosec": 9,
    "tv_sec,tv_usec": 6,
    "s,ms": 3,
    "seconds,microseconds": 6,
    "time_s,time_ms": 3,
    "stamp [s],stamp [ns]": 9,
}


class TestHalves:
    @pytest.mark.parametrize("names", HALVES)
    def test_they_are_joined_exactly(self, tmp_path, names):
        per_second = 10 ** HALVES[names]
        stamps = (EPOCH + GRID) // (10**9 // per_second)
        record = read(log(tmp_path, names, stamps // per_second, stamps % per_second), channels={"gyro_x": 3})
        (stream,) = record.streams
        assert (stream.grid.n, record.findings) == (N, ())
        assert stream.grid.rate == pytest.approx(100.0, rel=1e-9)
        assert stream.grid.jitter < 1e-12  # doubles of this size are good to 256 ns

    def test_the_second_column_may_be_first(self, tmp_path):
        record = read(
            log(tmp_path, "nsec,sec", (EPOCH + GRID) % 10**9, (EPOCH + GRID) // 10**9), channels={"gyro_x": 3}
        )
        assert rate_of(record) == pytest.approx(100.0, rel=1e-9)

    def test_two_clocks_are_not_joined(self, tmp_path):
        record = read(log(tmp_path, "time_s,time_ms", GRID // 10**9, GRID // 10**6), channels={"gyro_x": 3})
        assert rate_of(record) == pytest.approx(100.0, rel=1e-9)
        assert str(record.streams[0].grid.source) == "time stamps in column 'time_ms'"
        record = read(log(tmp_path, "time_s,time_ms", GRID / 1e9, [7] * N), channels={"gyro_x": 3})
        assert str(record.streams[0].grid.source) == "time stamps in column 'time_s'"

    @pytest.mark.parametrize(
        ("column", "value", "what"),
        [(0, 1_681_180_792, "wrong"), (1, 7_000_000_000, "wrong"), (0, "", "missing"), (1, "", "missing")],
    )
    def test_one_bad_half_names_its_line(self, tmp_path, column, value, what):
        halves = [list((EPOCH + GRID) // 10**9), list((EPOCH + GRID) % 10**9)]
        halves[column][1200] = value
        record = read(log(tmp_path, "sec,nanosec", *halves), channels={"gyro_x": 3})
        bad = next(f for f in record.findings if f.code == "bad_stamps")
        assert (bad.details.what, bad.details.place) == (what, "line 1202")
        assert record.streams[0].grid.n == N


class TestNoStamps:
    @pytest.mark.parametrize(
        ("names", "zeros"), [("%time,field.header.stamp", 1), ("%time,header.stamp.secs,header.stamp.nsecs", 2)]
    )
    def test_the_other_time_column_is_used(self, tmp_path, names, zeros):
        path = log(tmp_path, names, EPOCH + GRID, *[[0] * N] * zeros)
        record = read(path, channels={"gyro_x": names.count(",") + 2})
        assert rate_of(record) == pytest.approx(100.0, rel=1e-9)
        assert str(record.streams[0].grid.source) == "time stamps in column '%time'"
        assert any("time from '%time': all stamps in" in note for note in record.provenance.conversions)

    def test_without_another_column_it_is_refused(self, tmp_path):
        with pytest.raises(StampError, match=r"all stamps in column 'field\.header\.stamp' are 0"):
            read(log(tmp_path, "field.header.stamp", [0] * N), channels={"gyro_x": 2})

    def test_a_column_that_is_asked_for_is_not_replaced(self, tmp_path):
        path = log(tmp_path, "%time,field.header.stamp", EPOCH + GRID, [0] * N)
        with pytest.raises(StampError, match="all stamps"):
            read(path, channels={"gyro_x": 3, "time": "field.header.stamp"})


class TestImplausible:
    """Rates and lengths that no log of a gyro or accelerometer has."""

    @pytest.mark.parametrize(
        ("unit", "sensor"), [("ms", "gyro_x [rad/s]"), ("us", "accel_x [m/s^2]"), ("ns", "gyro_x [rad/s]")]
    )
    def test_a_unit_that_is_a_thousand_times_too_short(self, tmp_path, unit, sensor, capsys):
        path = log(tmp_path, "time", np.arange(N) / 40, sensor=sensor)
        with pytest.raises(OptionError, match=r"which is not a log of an? (?:gyro|accelerometer)") as error:
            read(path, unit={"time": unit})
        assert "--unit time=s (40 Hz, 50 s)" in str(error.value)
        assert main(["analyze", str(path), "--unit", f"time={unit}"]) == 2
        assert "--unit time=s (40 Hz" in capsys.readouterr().err
        assert rate_of(read(path, unit={"time": "s"})) == pytest.approx(40.0)

    @pytest.mark.parametrize("exponent", [0, 3, 6])
    def test_a_unit_that_is_too_long(self, tmp_path, exponent):
        with pytest.raises(OptionError, match=r"not a log of a gyro") as error:
            read(log(tmp_path, "time", GRID // 10**exponent), unit={"time": "min"})
        assert f"--unit time={ {0: 'ns', 3: 'us', 6: 'ms'}[exponent] } (100 Hz, 20 s)" in str(error.value)

    def test_a_unit_in_the_header_is_held_to_the_same_and_a_stated_rate_is_believed(self, tmp_path):
        path = log(tmp_path, "time [us]", GRID // 10**6)
        with pytest.raises(OptionError, match=r"in column 'time \[us\]' give 100000 Hz for 0.02 s"):
            read(path)
        assert rate_of(read(path, rate=100_000)) == pytest.approx(100_000, rel=1e-12)

    def test_other_signals_have_any_rate(self, tmp_path):
        path = log(tmp_path, "time", np.arange(N) * 3600, sensor="x")
        record = read(path, channels={"x": 2}, unit={"time": "s", "x": "K"})
        assert (rate_of(record), record.findings) == (pytest.approx(1 / 3600), ())
        record = read(path, channels={"x": 2}, unit={"time": "ns", "x": "K"})
        assert record.findings == ()

    @pytest.mark.parametrize(("step", "rate"), [(2, 0.5), (20, 0.05), (90, 1 / 90)])
    def test_a_log_of_averages_is_warned_of(self, tmp_path, step, rate):
        record = read(log(tmp_path, "time [s]", np.arange(N) * step))
        (finding,) = record.findings
        assert (finding.code, finding.severity) == ("implausible_rate", "warning")
        details = finding.details
        assert (details.unit, details.other_unit) == ("s", "ms")
        assert (details.rate, details.other_rate) == pytest.approx((rate, 1000 * rate))

    def test_a_date_has_no_other_unit(self, tmp_path):
        days = [f"2026-03-{1 + k // 1440:02d} {k // 60 % 24:02d}:{k % 60:02d}:00" for k in range(N)]
        assert codes(read(log(tmp_path, "time", days))) == []

    def test_a_usual_short_log_is_read(self, tmp_path):
        assert rate_of(read(log(tmp_path, "time [s]", (GRID / 1e9)[:90]))) == pytest.approx(100.0)


class TestSampleNumbers:
    """Whole numbers from 0 or 1 under a header of seconds: seconds of a log at 1 Hz, or numbers of the samples."""

    @pytest.mark.parametrize(
        ("name", "start", "form"),
        [("time [s]", 0, "{}"), ("Time (s)", 1, "{}.0"), ("timestamp_s", 0, "{}.0"), ("t_s", 1, "{}")],
    )
    def test_they_are_asked_for(self, tmp_path, name, start, form):
        path = log(tmp_path, name, [form.format(start + k) for k in range(N)])
        with pytest.raises(OptionError, match=rf"counts {start}, {start + 1}, {start + 2} ….*at 1 Hz, or numbers"):
            read(path)
        for rate in (100.0, 1.0):
            record = read(path, rate=rate)
            assert (rate_of(record), record.findings) == (rate, ())
        assert rate_of(read(path, unit={"time": "s"})) == pytest.approx(1.0)

    def test_numbers_are_lost_with_samples(self, tmp_path):
        numbers = [k for k in range(N) if k not in {7, 900, 901, 1400}]
        path = log(tmp_path, "time [s]", numbers)
        with pytest.raises(OptionError, match="numbers of the samples"):
            read(path)
        assert read(path, rate=100).streams[0].grid.n == N

    @pytest.mark.parametrize("start", [2, 300, 1_700_000_000])
    def test_a_clock_of_whole_seconds_does_not_begin_with_them(self, tmp_path, start):
        assert rate_of(read(log(tmp_path, "time [s]", start + np.arange(N)))) == pytest.approx(1.0)

    @pytest.mark.parametrize("step", [0.01, 0.1, 0.5, 2])
    def test_other_steps_are_none(self, tmp_path, step):
        assert rate_of(read(log(tmp_path, "time [s]", np.arange(N) * step))) == pytest.approx(1 / step)

    def test_other_signals_may_be_of_1_hz(self, tmp_path):
        assert rate_of(read(log(tmp_path, "time [s]", range(N), sensor="x [K]"), channels={"x": 2})) == 1.0


class TestWholeSeconds:
    """A clock of whole seconds, and samples that its ticks do not divide evenly."""

    @pytest.mark.parametrize(("rate", "seconds", "late"), [(50, 20, 0.0), (100, 300, 0.04), (400, 20, 0.04)])
    def test_the_rate_is_by_counts(self, tmp_path, rate, seconds, late):
        rng = np.random.default_rng(seed_of(f"whole seconds {rate} {seconds} {late}"))
        ticks = np.sort(np.arange(1, seconds) + late * rng.uniform(size=seconds - 1)) - 0.37
        stamps = np.searchsorted(ticks, np.arange(rate * seconds) / rate, side="right")
        record = read(log(tmp_path, "time [s]", 1_700_000_000 + stamps))
        found = {f.code: f for f in record.findings}
        assert "host_stamps" not in found
        finding = found["coarse_stamps"]
        assert finding.details.step == 1.0
        assert "time stamps are whole seconds" in finding.message
        error = abs(rate_of(record) / rate - 1)
        assert error <= finding.details.rate_error <= 1.5 * (1 + 2 * late * rate) / (rate * (seconds - 2))

    def test_no_share_of_intervals_that_is_0_is_stated(self, tmp_path):
        rng = np.random.default_rng(seed_of("scattered stamps"))
        stamps = np.cumsum(rng.uniform(0.055, 0.075, size=200))
        messages = [f.message for f in read(log(tmp_path, "time [s]", stamps)).findings]
        assert not any("0 %" in message or "bunched" in message for message in messages)


OVERFLOWS = {
    "micros, 32 bits": ("micros", (2**32 - 7_000_000 + GRID // 1000) % 2**32, 2.0**32, 1),
    "millis, 16 bits": ("millis", (60_000 + 7 * (GRID // 10**6)) % 2**16, 2.0**16, 3),
    "micros in seconds": ("time [s]", np.round((4294.0 + GRID / 1e9) % 4294.967296, 6), 4294.967296, 1),
    "ticks of 24 bits": ("t_us", (2**24 - 70_000 + GRID // 1000) % 2**24, 2.0**24, 2),
    "seconds of a minute": ("time [s]", np.round((47.3 + GRID / 1e9) % 60, 3), 60.0, 1),
    "seconds of a day": ("time [s]", np.round((86_395 + GRID / 1e9) % 86_400, 3), 86_400.0, 1),
    "milliseconds of a week": ("time_ms", (604_790_000 + GRID // 10**6) % 604_800_000, 604_800_000.0, 1),
}


class TestOverflows:
    @pytest.mark.parametrize("name", OVERFLOWS)
    def test_they_are_counted_on(self, tmp_path, name):
        column, stamps, period, times = OVERFLOWS[name]
        record = read(log(tmp_path, column, stamps.tolist()))
        (finding,) = record.findings
        assert (finding.code, finding.details.period, finding.size) == ("counter_overflows", period, times)
        assert finding.details.place == f"line {int(np.argmax(np.diff(stamps) < 0)) + 3}"
        assert rate_of(record) == pytest.approx(100.0 / (7 if times == 3 else 1), rel=1e-6)
        assert record.streams[0].grid.n == N

    @pytest.mark.parametrize(
        "stamps",
        [
            [*np.arange(0, 60, 0.01), *np.arange(0, 60, 0.01)],  # two logs of a minute, not a clock of one
            [*np.arange(5, 47, 0.01), *np.arange(5, 47, 0.01)],
            (np.arange(2000) * 1000 + 2**32 - 10**6 + 50_000 * (np.arange(2000) >= 1000)) % 2**32,  # with a gap
        ],
    )
    def test_other_steps_back_are_refused(self, tmp_path, stamps):
        with pytest.raises(StampError, match=r"time (goes backwards|begins again)"):
            read(log(tmp_path, "time [s]", np.round(stamps, 3)))

    @pytest.mark.parametrize("stride", [2, 5, 10])
    def test_those_of_every_other_sample_are_told(self, tmp_path, stride):
        path = log(tmp_path, "timestamp_s", np.arange(N) * stride)
        (finding,) = read(path).findings
        assert (finding.code, finding.details.stride) == ("implausible_rate", stride)
        record = read(path, channels={"time": "none"}, rate=73.0)
        assert (rate_of(record), record.findings) == (73.0, ())

    def test_times_at_other_intervals_are_no_numbers(self, tmp_path):
        (finding,) = read(log(tmp_path, "time [s]", np.arange(N) * 2.5)).findings
        assert (finding.code, finding.details.stride) == ("implausible_rate", 0)


@pytest.mark.parametrize(("since", "exponent"), [(1.238e15, 6), (1.2e12, 3), (1.4e9, 0)])
def test_a_clock_since_the_start_of_a_device_is_no_date(tmp_path, since, exponent):
    """Nanoseconds of a phone that is on for two weeks have as many digits as microseconds since 1970."""
    stamps = int(since) + np.arange(N) * (10**7 if exponent == 6 else 10**4 if exponent == 3 else 10)
    with pytest.raises(OptionError, match=r"unit of the time stamps .*is not stated.* 100 Hz"):
        read(log(tmp_path, "timestamp", stamps))


@pytest.mark.parametrize(
    "names", [("hour", "minute", "second", "millisecond"), ("h", "min", "s", "ms"), ("", "t.min", "t.sec", "t.usec")]
)
def test_hours_and_minutes_in_columns_are_joined(tmp_path, names):
    """Over midnight, or over the hour if there is no column of hours."""
    ticks = np.arange(N) * 10 + 1000 * (86400 - 7)  # ms
    per_second = 10**6 if names[-1].endswith("usec") else 1000
    parts = (ticks // 3_600_000 % 24, ticks // 60_000 % 60, ticks // 1000 % 60, ticks % 1000 * (per_second // 1000))
    columns = {name: part for name, part in zip(names, parts, strict=True) if name}
    rng = np.random.default_rng(seed_of("".join(names)))
    rows = np.column_stack([*columns.values(), rng.normal(0, 0.01, (N, 3))])
    path = tmp_path / "log.csv"
    header = ",".join([*columns, *(f"gyro_{axis} [rad/s]" for axis in "xyz")])
    np.savetxt(path, rows, delimiter=",", header=header, comments="", fmt=["%d"] * len(columns) + ["%.6f"] * 3)
    record = read(path)
    assert rate_of(record) == pytest.approx(100.0)
    assert record.streams[0].grid.n == N
    assert record.findings == ()
