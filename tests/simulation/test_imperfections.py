"""What a simulated log has beside noise: each against its formula, over the same noise."""

import json
import math

import numpy as np
import pytest

from known import seed_of
from sigmatau import Imperfections, NoiseModel, OptionError, allan, simulate
from sigmatau.model.channel import ChannelModel
from sigmatau.simulation.imperfections import Outage, Temperature, WarmUp

MODEL = NoiseModel(
    channels={
        "gyro_x": {"random_walk": 1e-4},
        "gyro_y": {"random_walk": 1e-4, "bias_instability": 1e-5},
        "accel_z": {"random_walk": 1e-3},
    }
)
N, RATE = 20_000, 100.0
T = np.arange(N) / RATE


def run(imperfections=None, model=MODEL, **options):
    options = {"duration": N / RATE, "rate": RATE, "rng": seed_of("imperfections")} | options
    record = simulate(model, imperfections=imperfections, **options)
    return {name: record.stream_of(name).column(name) for name in record.channels}


CLEAN = run()


def test_nothing_is_there_unless_it_is_given():
    assert all(np.array_equal(values, CLEAN[name]) for name, values in run(Imperfections()).items())


def test_level_of_a_channel_goes_before_its_sensors():
    got = run(Imperfections(level={"gyro": 0.1, "gyro_y": -0.2, "accel_z": 9.8}))
    for name, level in {"gyro_x": 0.1, "gyro_y": -0.2, "accel_z": 9.8}.items():
        assert np.array_equal(got[name], CLEAN[name] + level)


def test_warm_up():
    got = run(Imperfections(warm_up={"gyro": WarmUp(amplitude=-0.03, time=50.0)}))
    for name in ("gyro_x", "gyro_y"):
        np.testing.assert_allclose(got[name] - CLEAN[name], -0.03 * np.exp(-T / 50), rtol=0, atol=1e-16)
    assert np.array_equal(got["accel_z"], CLEAN["accel_z"])


def test_temperature():
    warm = Temperature(start=20.0, end=35.0, time=60.0, swing=2.0, resolution=0.0625, sensitivity={"gyro_x": 1e-3})
    got = run(Imperfections(temperature=warm))
    true = 35 - 15 * np.exp(-T / 60) + 2 * np.sin(2 * math.pi * T / 86400)
    shown = got.pop("temperature")
    assert np.abs(shown - true).max() <= 0.0625 / 2 * (1 + 1e-9)
    assert np.array_equal(shown / 0.0625, np.rint(shown / 0.0625))
    assert np.ptp(shown) > 14
    np.testing.assert_allclose(got["gyro_x"] - CLEAN["gyro_x"], 1e-3 * (true - 20), rtol=0, atol=1e-15)
    assert np.array_equal(got["gyro_y"], CLEAN["gyro_y"])
    stream = simulate(MODEL, duration=10, rate=RATE, rng=1, imperfections=Imperfections(temperature=warm)).streams[-1]
    assert (stream.name, stream.quantity, stream.unit) == ("temperature", "temperature", "degC")


def test_steps_and_saturation_of_rates():
    got = run(Imperfections(lsb={"gyro": 1e-4}, saturation={"gyro_y": 5e-4}))
    np.testing.assert_allclose(got["gyro_x"], 1e-4 * np.rint(CLEAN["gyro_x"] / 1e-4), rtol=1e-15)
    assert np.abs(got["gyro_y"]).max() == pytest.approx(5e-4)
    assert np.abs(CLEAN["gyro_y"]).max() > 2e-3
    np.testing.assert_allclose(got["gyro_y"], 1e-4 * np.rint(np.clip(CLEAN["gyro_y"], -5e-4, 5e-4) / 1e-4), rtol=1e-15)


@pytest.mark.parametrize("output", ["increments", "accumulated"])
def test_other_output_holds_the_same_rates(output):
    got = run(Imperfections(output=output, level={"gyro_x": 0.5}))
    np.testing.assert_allclose(got["gyro_x"], CLEAN["gyro_x"] + 0.5, rtol=0, atol=1e-11)
    np.testing.assert_allclose(got["accel_z"], CLEAN["accel_z"], rtol=0, atol=1e-13)


@pytest.mark.parametrize("output", ["increments", "accumulated"])
def test_steps_of_the_running_sum(output):
    """Both give the rounded sum to within half a step however long it grows, so that increments lose nothing."""
    step = 2e-5  # 2 standard deviations of an increment: far too coarse to round each by itself
    given = Imperfections(output=output, lsb={"gyro": step}, level={"gyro": 1e-3})
    got = run(given)["gyro_x"]
    angle = np.cumsum(got) / RATE
    np.testing.assert_allclose(angle / step, np.rint(angle / step), rtol=0, atol=1e-6)
    assert np.abs(angle - np.cumsum(CLEAN["gyro_x"] + 1e-3) / RATE).max() <= step / 2 * (1 + 1e-9)


def test_steps_of_the_running_sum_are_quantization_noise():
    """Q = lsb/√12, within 4 standard errors: where the angle walks two steps a sample, rounding errors are white."""
    step = 1e-4
    walk = 2 * step * math.sqrt(RATE)
    channel = ChannelModel(terms={"random_walk": walk})
    expected = ChannelModel(terms={"random_walk": walk, "quantization": step / math.sqrt(12)})
    model = NoiseModel(channels={f"gyro_{k}": channel for k in range(100)})
    options = {"duration": 100.0, "rate": RATE, "rng": seed_of("sum in steps")}
    given = Imperfections(output="increments", lsb={"gyro": step})
    curves = allan(simulate(model, imperfections=given, **options), taus=[1 / RATE, 2 / RATE, 4 / RATE])
    got = np.array([curve.avar for curve in curves.values()])
    error = got.std(axis=0, ddof=1) / math.sqrt(len(got))
    off = got.mean(axis=0) - expected.avar(m=(1, 2, 4), tau0=1 / RATE)
    assert (np.abs(off) <= 4 * error).all()
    # Without the steps the mean would be short by far more than the gate.
    assert (got.mean(axis=0) - channel.avar(m=(1, 2, 4), tau0=1 / RATE) > 4 * error).all()


def test_lost_rows():
    part = 0.02
    given = Imperfections(
        lost=part,
        outages=(Outage(start=0.0, length=0.05), Outage(start=50.0, length=3.0), Outage(start=199.9, length=60.0)),
    )
    got = run(given)
    missing = np.isnan(got["gyro_x"])
    outage = (T < 0.05) | ((T >= 50) & (T < 53)) | (T >= 199.9)
    outage[[0, -1]] = False
    assert missing[outage].all()
    assert not missing[[0, -1]].any()
    by_chance = np.count_nonzero(missing & ~outage)
    chances = np.count_nonzero(~outage) - 2
    assert by_chance == pytest.approx(part * chances, abs=4 * math.sqrt(part * (1 - part) * chances))
    for name, values in got.items():
        assert np.array_equal(np.isnan(values), missing)
        assert np.array_equal(values[~missing], CLEAN[name][~missing])


def test_a_lost_row_of_a_running_sum_costs_both_rates_beside_it():
    lost = np.isnan(run(Imperfections(outages=(Outage(start=1.0, length=0.015),), output="accumulated"))["gyro_x"])
    assert np.flatnonzero(lost).tolist() == [99, 100, 101]  # rows 100 and 101


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Imperfections(lost=0.6), "0 to 0.5"),
        (lambda: Imperfections(lost=math.nan), "0 to 0.5"),
        (lambda: Imperfections(output="angle"), "accumulated"),
        (lambda: Imperfections(lsb={"gyro": 0.0}), "positive"),
        (lambda: Imperfections(saturation={"gyro": -1.0}), "positive"),
        (lambda: Imperfections(level={"gyro": math.inf}), "must be a number"),
        (lambda: Imperfections(jitter=-1e-6), "jitter"),
        (lambda: WarmUp(amplitude=1.0, time=0.0), "time of a warm-up"),
        (lambda: Outage(start=-1.0, length=1.0), "start of an outage"),
        (lambda: Temperature(start=20.0, end=math.nan), "temperature at the end"),
        (lambda: Temperature(start=20.0, end=30.0, resolution=-1.0), "resolution"),
        (lambda: run(Imperfections(jitter=2e-3)), "tenth of the sample interval"),
        (lambda: run(Imperfections(level={"gyro_z": 1.0})), "gyro_z"),
        (lambda: run(flicker="best"), "flicker"),
        (
            lambda: run(
                Imperfections(output="increments"),
                NoiseModel(channels={"volt": ChannelModel(terms={"random_walk": 1.0}, quantity="signal", unit="V")}),
            ),
            "holds rates",
        ),
        (
            lambda: run(
                Imperfections(temperature=Temperature(start=1.0, end=2.0)),
                NoiseModel(
                    channels={"temperature": ChannelModel(terms={"random_walk": 1.0}, quantity="signal", unit="V")}
                ),
            ),
            "thermometer",
        ),
    ],
)
def test_wrong_values(make, words):
    with pytest.raises(OptionError, match=words):
        make()


def test_prints_itself_and_is_plain():
    given = Imperfections(
        level={"accel_z": 9.8},
        warm_up={"gyro": WarmUp(amplitude=1e-3, time=600.0)},
        temperature=Temperature(start=20.0, end=35.0, sensitivity={"gyro": 1e-5}),
        saturation={"gyro": 4.0},
        lsb={"gyro": 1e-4},
        lost=0.001,
        outages=(Outage(start=600.0, length=2.0),),
        jitter=2e-5,
    )
    content = json.loads(json.dumps(given.to_dict(), allow_nan=False))
    assert content["temperature"]["sensitivity"] == {"gyro": 1e-5}
    assert content["outages"] == [{"start_s": 600.0, "length_s": 2.0}]
    assert Imperfections().to_dict() == {"output": "rate"}
    for words in ("level of accel_z: 9.8", "20 °C to 35 °C in 1200 s", "rows lost: 0.1 %", "outage of 2 s at 600 s"):
        assert words in repr(given)
