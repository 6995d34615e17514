"""A sampling rate that contradicts the time stamps of the log: refused with both readings, and with the option for each."""

import itertools
import math

import numpy as np
import pytest
from stamping import codes

from known import seed_of
from sigmatau import from_frame, inspect, read
from sigmatau.errors import OptionError
from sigmatau.io.read.time.plausible import NOMINAL_RATIO

ROWS = 3000
RATE = 200.0  # of the sensor that made the logs [Hz]
SENSOR = ("gyro_x [rad/s]", "gyro_y [rad/s]", "gyro_z [rad/s]")
NANOSECONDS = 1_700_000_000_000_000_000  # of a day in 2023


def log(tmp_path, name, stamps, *, header=SENSOR):
    rng = np.random.default_rng(seed_of("stated rate"))
    cells = rng.normal(0, 1e-3, (len(stamps), 3))
    lines = [",".join([str(t), *(f"{x:.6f}" for x in row)]) for t, row in zip(stamps, cells, strict=True)]
    path = tmp_path / "log.csv"
    path.write_text("\n".join([",".join([name, *header]), *lines]) + "\n")
    return path


def jittered(name):
    t = np.arange(ROWS) / RATE
    return np.sort(t + np.random.default_rng(seed_of(name)).normal(0, 1e-3, ROWS))


def bunched():
    """Eight samples that a host receives together."""
    return np.repeat(np.arange(8, ROWS + 8, 8) / RATE, 8) + np.tile(np.arange(8) * 1e-5, ROWS // 8)


SECONDS = np.round(np.arange(ROWS) / RATE, 6)
STAMPS = {
    "seconds": ("time [s]", SECONDS, "", ""),
    "milliseconds by name": ("time_ms", np.arange(ROWS) * 5, "", ""),
    "jitter of arrival": ("time [s]", jittered("arrival"), "", ""),
    "bunches of a host": ("time [s]", bunched(), "", ""),
    "unit by size": ("t", NANOSECONDS + np.arange(ROWS) * 5_000_000, " in ns", " and add --unit time=ns"),
    "unit by rate": ("t", SECONDS, " in s", " and add --unit time=s"),
    "integers without a unit": ("t", np.arange(ROWS) * 5, " in ms", " and add --unit time=ms"),
    "lost samples": ("time [s]", np.delete(SECONDS, np.s_[::9]), "", ""),
}


@pytest.mark.parametrize(("case", "ratio"), list(zip(STAMPS, itertools.cycle((0.5, 2.0, 5.0)), strict=False)))
def test_both_readings_are_offered_and_right(tmp_path, case, ratio):
    name, stamps, in_unit, unit = STAMPS[case]
    path = log(tmp_path, name, stamps)
    with pytest.raises(OptionError) as refused:
        read(path, rate=RATE * ratio)
    message = refused.value.for_command_line()
    by_stamps = message.split(" give ")[1].split(" Hz")[0]
    assert float(by_stamps) == pytest.approx(RATE, rel=0.01)
    assert message == (
        f"{path}: the time stamps in column {name!r} give {by_stamps} Hz{in_unit},"
        f" which contradicts --rate {RATE * ratio:g}."
        f" For {by_stamps} Hz, omit --rate{unit}; for {RATE * ratio:g} Hz, add --channels time=none"
    )
    units = {"time": unit.split("=")[1]} if unit else None
    assert read(path, unit=units).streams[0].grid.rate == pytest.approx(RATE, rel=0.01)
    ignored = read(path, rate=RATE * ratio, channels={"time": "none"})
    assert ignored.streams[0].grid.rate == RATE * ratio
    assert ignored.findings == ()


@pytest.mark.parametrize(
    ("case", "ratio"), list(zip(STAMPS, itertools.cycle((0.999 * NOMINAL_RATIO, 1.01 / NOMINAL_RATIO)), strict=False))
)
def test_one_nominal_rate_is_a_finding(tmp_path, case, ratio):
    """Two clocks of one nominal rate: the stated rate is used, and what it changes is stated."""
    name, stamps, _, _ = STAMPS[case]
    record = read(log(tmp_path, name, stamps), rate=RATE * ratio)
    assert record.streams[0].grid.rate == pytest.approx(RATE * ratio)
    (finding,) = (f for f in record.findings if f.code == "rate_mismatch")
    assert dict(finding.factors)["random_walk"] == pytest.approx(math.sqrt(1 / ratio), rel=0.01)


@pytest.mark.parametrize("interval", [1, 50, 50_000])
def test_a_counter_is_no_clock(tmp_path, interval):
    """Numbers of the samples, and ticks of 0.1 ms and 100 ns."""
    record = read(log(tmp_path, "t", np.arange(ROWS) * interval), rate=RATE)
    assert record.streams[0].grid.rate == RATE
    assert codes(record) == []
    assert any("checked for order and gaps only" in note for note in record.provenance.conversions)


def test_a_rate_replaces_stamps_that_no_sensor_has(tmp_path):
    """Milliseconds under the name of seconds: 0.2 Hz, which few logs have, and 200 Hz in another unit."""
    for name, stamps in (("time [s]", np.arange(ROWS) * 5), ("time_ms", np.arange(ROWS) / RATE)):
        record = read(log(tmp_path, name, stamps), rate=RATE)
        assert record.streams[0].grid.rate == RATE
        assert codes(record, least="warning") == ["rate_mismatch"]
    slow = np.arange(ROWS) / 40  # as ms 40 kHz for 0.075 s
    assert read(log(tmp_path, "time_ms", slow), rate=40).streams[0].grid.rate == 40
    with pytest.raises(OptionError, match=r"give 0\.2 Hz, which contradicts --rate 400"):
        read(log(tmp_path, "time [s]", np.arange(ROWS) * 5), rate=400)


def test_a_unit_that_the_user_gives_is_not_overridden(tmp_path):
    path = log(tmp_path, "time", SECONDS)
    with pytest.raises(OptionError) as refused:
        read(path, rate=RATE, unit={"time": "ms"})
    assert refused.value.for_command_line().endswith(
        "give 200000 Hz, which contradicts --rate 200. For 200 Hz, give --unit time=s"
    )
    assert read(path, rate=RATE, unit={"time": "s"}).findings == ()


def test_a_time_column_that_the_user_names(tmp_path):
    path = log(tmp_path, "tick", SECONDS)
    named = {"gyro": "2:4", "time": 1}
    with pytest.raises(OptionError, match="put time=none in place of the time column in --channels"):
        read(path, rate=400, channels=named, unit={"time": "s"})
    assert read(path, rate=400, channels={**named, "time": "none"}).streams[0].grid.rate == 400


def test_columns_without_names(tmp_path):
    """Gravity tells the columns with ``time=none`` too, so that the answer to the refusal works alone."""
    rng = np.random.default_rng(seed_of("without names"))
    accel = rng.normal([0, 0, 9.81], 1e-2, (ROWS, 3))
    cells = np.column_stack([SECONDS, rng.normal(0, 1e-3, (ROWS, 3)), accel])
    path = tmp_path / "log.csv"
    np.savetxt(path, cells, delimiter=",", fmt="%.6f")
    units = {"gyro": "rad/s", "accel": "m/s^2"}
    with pytest.raises(OptionError, match=r"column 1 give 200 Hz in s.*add --channels time=none"):
        read(path, rate=400, unit=units)
    record = read(path, rate=400, unit=units, channels={"time": "none"})
    assert {stream.name: stream.grid.rate for stream in record.streams} == {"gyro": 400, "accel": 400}


def test_a_frame_and_an_inspection(tmp_path):
    frame = {"time [s]": SECONDS, "gyro_x [rad/s]": np.sin(np.arange(ROWS))}
    with pytest.raises(OptionError, match=r"give 200 Hz, which contradicts --rate 400"):
        from_frame(frame, rate=400)
    asked = inspect(log(tmp_path, "time [s]", SECONDS), rate=400)
    assert asked.record is None
    assert "which contradicts --rate 400" in asked.tables[0].wanting


def test_stamps_without_a_rate_are_no_evidence(tmp_path):
    """Bunches of a host in twelve pieces with long pauses: the mean rate of the stamps is not that of the sensor."""
    piece = bunched()[:1600]
    stamps = np.concatenate([100 * k + piece for k in range(12)])
    record = read(log(tmp_path, "time [s]", stamps), rate=RATE)
    assert record.streams[0].grid.rate == RATE
    assert {"irregular_stamps", "rate_mismatch"} <= set(codes(record))
