"""Bandwidth of a sensor from logs at several rates: known filters come back, and what cannot be known is not stated."""

import json
import math

import numpy as np
import pytest
from studies.bandwidth_instrument import DENSITY, KINDS, Sensor, logs_of

import sigmatau as st
from known import seed_of
from sigmatau.fitting.sensor_filters import all_filters


def sensor(name, kind="one pole", corner=30.0):
    rng = np.random.default_rng(seed_of(name))
    return Sensor(kind, rng, lowest=corner, highest=corner), rng


def noise(name, n=4000):
    return np.random.default_rng(seed_of(name)).standard_normal(n)


@pytest.mark.parametrize("family", all_filters(), ids=lambda family: family.text)
@pytest.mark.parametrize("rate", [20.0, 100.0, 900.0])
def test_folded_is_the_sum_of_the_images(family, rate):
    numbers = np.array([math.log(30.0), *family.start])
    f = np.array([0.0, 1.0, 7.0, 33.0, 49.0])
    images = np.abs(f[:, None] + rate * np.arange(-20000, 20001))
    expected = family.power(images.ravel(), numbers).reshape(images.shape).sum(axis=1)
    # The sum ends at 20 000 images; one pole has 5e-5 of its power beyond.
    assert family.folded(f, rate, numbers) == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize("family", all_filters(), ids=lambda family: family.text)
def test_half_the_power_and_its_area(family):
    numbers = np.array([math.log(30.0), *family.start])
    assert family.power(np.array([30.0]), numbers)[0] == pytest.approx(0.5, abs=1e-3)
    f = np.linspace(0, 30000, 300001)
    assert family.equivalent(numbers) == pytest.approx(np.trapezoid(family.power(f, numbers), f), rel=1e-3)


@pytest.mark.parametrize("kind", KINDS)
def test_filters_come_back(kind):
    """Errors of five standard errors, as the intervals state them; their coverage is the study's."""
    device, rng = sensor(f"comes back, {kind}", kind)
    result = st.bandwidth(logs_of(device, np.array([20.0, 100.0, 500.0, 1000.0]), rng))["gyro_x"]
    assert result.verdict in ("adequate", "logs differ", "not explained")
    for interval, truth in ((result.bandwidth, device.truth()), (result.random_walk, DENSITY)):
        assert interval.low < interval.value < interval.high
        assert abs(math.log(interval.value / truth)) < 5 / 2 * math.log(interval.high / interval.low)
        assert math.log(interval.high / interval.low) < 0.4
    shown = [log.rate for log in result.logs]
    assert shown == [20.0, 100.0, 500.0, 1000.0]
    factors = [log.aliasing.value for log in result.logs]
    assert factors == sorted(factors, reverse=True)
    assert factors[0] > 1.2
    assert factors[-1] < 1.01


def test_aliasing_is_that_of_the_closed_form():
    device, rng = sensor("closed form")
    result = st.bandwidth(logs_of(device, np.array([50.0, 1000.0]), rng))["gyro_x"]
    from sigmatau.noise.terms import aliasing_inflation

    corner = result.bandwidth.value
    assert result.shape == "one pole"
    assert result.logs[0].aliasing.value == pytest.approx(aliasing_inflation(rate=50, bandwidth=corner), rel=1e-9)
    assert aliasing_inflation(rate=result.rate_needed.value, bandwidth=corner) == pytest.approx(1.02, abs=1e-4)


def test_a_slow_log_alone_has_a_lower_limit():
    device, rng = sensor("slow alone")
    result = st.bandwidth(logs_of(device, np.array([10.0]), rng))["gyro_x"]
    assert result.verdict == "rate too low"
    assert result.bandwidth.high is None
    assert result.random_walk.low is None
    assert result.bandwidth.low < 30
    assert result.random_walk.high > DENSITY
    assert result.record_at == 100
    assert "Record at 100 Hz or more" in repr(result)


def test_logs_of_another_sensor_are_refused_by_name():
    device, rng = sensor("two sensors")
    records = logs_of(device, np.array([50.0, 500.0, 1000.0]), rng)
    noisy = st.Record.from_arrays(rate=200, gyro_x=1.5 * device.samples(200.0, 8000, rng))
    with pytest.raises(st.DataError, match=r"^foreign\.csv: gyro_x is of another sensor") as error:
        st.bandwidth(records | {"foreign.csv": noisy})
    ratio = float(str(error.value).split("N is ")[1].split()[0])
    assert 1.4 < ratio < 1.6  # 1.5; the logs are of some thousand samples


def test_a_filter_that_changes_with_the_rate_is_refused():
    (slow, rng), (fast, _) = sensor("slow filter", "Butterworth", 20.0), sensor("fast filter", "Butterworth", 80.0)
    records = logs_of(fast, np.array([500.0, 1000.0, 2000.0]), rng)
    records["200Hz.csv"] = st.Record.from_arrays(rate=200, gyro_x=slow.samples(200.0, 8000, rng))
    with pytest.raises(st.DataError, match=r"^200Hz\.csv: gyro_x is of another sensor or configuration"):
        st.bandwidth(records)


@pytest.mark.parametrize("step", [1, 10])
def test_copies_are_used_once(step):
    device, rng = sensor("copies")
    y = device.samples(1000.0, 20000, rng)
    whole = st.Record.from_arrays(rate=1000, gyro_x=y)
    copy = st.Record.from_arrays(rate=1000 / step, gyro_x=y[::step])
    alone = st.bandwidth({"whole": whole})["gyro_x"]
    both = st.bandwidth({"whole": whole, "copy": copy})["gyro_x"]
    assert len(both.repeated) == 1
    assert both.bandwidth == alone.bandwidth
    assert both.repeated[0] in repr(both)


def test_gaps_and_lines_change_little():
    device, rng = sensor("gaps")
    y = device.samples(500.0, 40000, rng)
    clean = st.bandwidth(st.Record.from_arrays(rate=500, gyro_x=y))["gyro_x"]
    with_line = y + 0.2 * y.std() * np.sin(2 * np.pi * 20.0 * np.arange(len(y)) / 500)
    with_line[[7000, 7001, 25000]] = np.nan
    spoiled = st.bandwidth(st.Record.from_arrays(rate=500, gyro_x=with_line))["gyro_x"]
    assert spoiled.logs[0].lines > 0
    width = math.log(clean.bandwidth.high / clean.bandwidth.low)
    assert abs(math.log(spoiled.bandwidth.value / clean.bandwidth.value)) < width


def test_a_strong_line_is_subtracted():
    """A line of 20 standard deviations leaks into the whole spectrum."""
    device, rng = sensor("strong line")
    y = device.samples(500.0, 20000, rng)
    clean = st.bandwidth(st.Record.from_arrays(rate=500, gyro_x=y))["gyro_x"]
    hum = 20 * y.std() * np.sin(2 * np.pi * 50.03 * np.arange(len(y)) / 500 + 1)
    spoiled = st.bandwidth(st.Record.from_arrays(rate=500, gyro_x=y + hum))["gyro_x"]
    assert spoiled.shape == clean.shape
    assert spoiled.bandwidth.value == pytest.approx(clean.bandwidth.value, rel=0.01)
    assert spoiled.random_walk.value == pytest.approx(clean.random_walk.value, rel=0.01)


def test_a_digital_filter_of_a_single_log():
    from scipy.signal import butter, sosfilt

    white = np.random.default_rng(seed_of("digital")).standard_normal(21_000)
    y = sosfilt(butter(2, 40.0, fs=400, output="sos"), white)[1000:]
    result = st.bandwidth(st.Record.from_arrays(rate=400, gyro_x=y))["gyro_x"]
    assert result.shape == "digital Butterworth, 2 poles"
    assert result.verdict == "adequate"
    assert result.bandwidth.value == pytest.approx(40, rel=0.05)
    assert result.random_walk.value == pytest.approx(1 / 20, rel=0.05)  # 1 / √(400 Hz)


def test_too_short_and_constant():
    with pytest.raises(st.RecordTooShortError, match="has 100 samples; at least 1000 are needed") as error:
        st.bandwidth({"short.csv": st.Record.from_arrays(rate=100, gyro_x=noise("short", 100))})
    assert (error.value.need, error.value.got) == (1000, 100)
    samples = noise("losses", 3000)
    samples[::97] = np.nan
    with pytest.raises(st.RecordTooShortError, match="has 0 samples in runs of 256 without gaps"):
        st.bandwidth({"losses.csv": st.Record.from_arrays(rate=100, gyro_x=samples)})
    with pytest.raises(st.DataError, match=r"flat\.csv: gyro_x never changes"):
        st.bandwidth({"flat.csv": st.Record.from_arrays(rate=100, gyro_x=np.ones(1000))})


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"tolerance": 0}, "`tolerance` must be between 0 and 1"),
        ({"level": 95}, "`level` must be between 0 and 1"),
        ({"channels": ["gyro_y"]}, "`channels` must be some of gyro_x"),
    ],
)
def test_wrong_options(wrong, message):
    with pytest.raises(st.OptionError, match=message):
        st.bandwidth(st.Record.from_arrays(rate=100, gyro_x=noise("options")), **wrong)


def test_units_must_agree():
    records = [st.Record.from_arrays(rate=100, unit={"field": unit}, field=noise(unit)) for unit in ("T", "V")]
    with pytest.raises(st.DataError, match="Give logs of one sensor"):
        st.bandwidth(records)


def test_json_and_figure():
    device, rng = sensor("json")
    found = st.bandwidth(logs_of(device, np.array([50.0, 500.0]), rng))
    content = json.loads(json.dumps(found.to_dict(), allow_nan=False))["gyro_x"]
    assert content["bandwidth"]["unit"] == "Hz"
    assert content["logs"][0]["rate_hz"] == 50
    assert len(content["response"]["frequency_hz"]) == len(content["response"]["low"])
    figure = found.plot()
    labels = [line.get_label() for line in figure.axes[0].lines]
    assert labels == ["50 Hz", "500 Hz"]
    with pytest.raises(st.OptionError, match="must be one of gyro_x"):
        found.plot("gyro_y")


@pytest.mark.parametrize(
    ("records", "options", "error", "words"),
    [
        ({}, {}, st.OptionError, "`records` is empty"),
        ([], {}, st.OptionError, "`records` is empty"),
        ({"a": np.zeros(10)}, {}, TypeError, "must be records"),
        ([np.zeros(10)], {}, TypeError, "must be records"),
        ([], {"tolerance": "x"}, st.OptionError, "`tolerance` must be between 0 and 1, not 'x'"),
        ([], {"level": 2}, st.OptionError, "`level` must be between 0 and 1, not 2"),
    ],
)
def test_what_is_no_record_and_no_share(records, options, error, words):
    with pytest.raises(error, match=words):
        st.bandwidth(records, **options)
