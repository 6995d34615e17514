"""Rows of several sensors in turn, without a column that tells them: found from the samples; one sensor never is."""

import numpy as np
import pytest
from scipy import signal

from known import seed_of
from sigmatau.errors import DataError
from sigmatau.io.read import read
from sigmatau.io.read.interleaving import find_interleaving

NAMES = ("gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z")
ROWS = 4800
PERIOD = 0.01


def channels(samples):
    return {name: samples[:, k] for k, name in enumerate(NAMES[: samples.shape[1]])}


def stamps(kind, period, rows=ROWS):
    """Stamps of rows: even, of groups of `period` rows, with one stamp for each group, or none."""
    group, turn = np.arange(rows) // period, np.arange(rows) % period
    return {
        "even": np.arange(rows) * PERIOD / period,
        "groups": group * PERIOD + turn * 6e-5,
        "one": group * PERIOD,
        "none": None,
    }[kind]


BIASES = np.array(  # of four IMUs, over the standard deviation of the noise: gyro and accelerometer
    [[0, 0, 0, 0, 0, 0], [7, 5, 8, -4, 6, 3], [-4, 6, -3, 5, -6, 4], [3, -6, -6, 8, 3, -5]], dtype=float
)


@pytest.mark.parametrize("kind", ["even", "groups", "one", "none"])
@pytest.mark.parametrize("sensors", [2, 3, 4])
@pytest.mark.parametrize("axes", [3, 6])
def test_sensors_in_turn_are_found(kind, sensors, axes):
    rng = np.random.default_rng(seed_of(f"{sensors} sensors in turn"))
    samples = rng.normal(size=(ROWS, axes)) + np.tile(BIASES[:sensors, :axes], (ROWS // sensors, 1))
    found = find_interleaving(channels(samples), stamps(kind, sensors))
    assert found is not None
    assert found.sensors == sensors
    assert found.bunched == (kind in ("groups", "one"))
    column = NAMES.index(found.channel)
    expected = BIASES[:sensors, column] - BIASES[:sensors, column].mean()
    # Median of 16 means of 256 / sensors rows each: their standard error is 1.25 √(sensors / 4096).
    assert sorted(found.means) == pytest.approx(sorted(expected), abs=4 * 1.25 * np.sqrt(sensors / 4096))


@pytest.mark.parametrize("axes", [3, 6])
@pytest.mark.parametrize("turns", [(0, 0, 1), (0, 1, 0), (0, 0, 0, 1)])
def test_two_sensors_of_different_rates_are_found(turns, axes):
    rng = np.random.default_rng(seed_of(f"sensors of different rates {turns} {axes}"))
    samples = rng.normal(size=(ROWS, axes)) + np.resize(BIASES[np.array(turns), :axes], (ROWS, axes))
    intervals = np.where(np.resize(turns, ROWS) == 1, 0.4, 1.0)  # the rows of the slower one are in between
    found = find_interleaving(channels(samples), np.cumsum(intervals) * PERIOD)
    assert found is not None
    assert (found.sensors, found.period) == (2, len(turns))
    assert f"every {'third' if len(turns) == 3 else 'fourth'} row" in str(found.error("2"))


def test_sensors_in_turn_are_found_after_lost_rows():
    rng = np.random.default_rng(seed_of("lost rows"))
    samples = rng.normal(size=(ROWS, 6)) + np.tile(BIASES[:2], (ROWS // 2, 1))
    whole = np.delete(np.arange(ROWS), [1001, 2702, 3001])
    found = find_interleaving(channels(samples[whole]), stamps("groups", 2)[whole])
    assert found is not None
    assert found.sensors == 2


def white(rng):
    return rng.normal(size=(ROWS, 6))


def line(frequency, axes, *, equal=False):
    """A line at a share of the sampling rate on some axes."""

    def samples(rng):
        size = np.where(np.arange(6) < axes, 5.0 if equal else rng.uniform(1, 10, 6), 0.0)
        phase = 0.0 if equal else rng.uniform(0, 2 * np.pi)
        return white(rng) + size * np.cos(2 * np.pi * frequency * np.arange(ROWS) + phase)[:, None]

    return samples


def filtered(rng):
    return signal.lfilter(*signal.butter(2, rng.uniform(0.05, 0.9)), white(rng), axis=0)


def resonant(rng):
    angle = np.pi * rng.uniform(0.3, 1)
    return signal.lfilter([1], [1, -2 * 0.98 * np.cos(angle), 0.98**2], white(rng), axis=0)


ONE_SENSOR = {
    "white": white,
    "filtered": filtered,
    "resonant": resonant,
    "quantised": lambda rng: np.round(white(rng) * rng.uniform(0.3, 3)),
    "walking": lambda rng: white(rng) + 0.1 * np.cumsum(white(rng), axis=0),
    "moving": lambda rng: white(rng) + 50 * np.sin(np.outer(np.arange(ROWS), rng.uniform(1e-3, 0.08, 6))),
    "a line": line(0.237, 6),
    "a line at half the rate": line(0.5, 1, equal=True),
    "a line at half the rate on all axes of a gyro": line(0.5, 3, equal=True),
    "a line close to half the rate": line(0.4987, 6),
    "a line at a quarter of the rate": line(0.25, 6),
    "a line at a third of the rate, of one phase": line(1 / 3, 6, equal=True),
    "a converter with two phases": lambda rng: (
        white(rng) + np.outer((-1.0) ** np.arange(ROWS), rng.uniform(-0.5, 0.5, 6))
    ),
    "each sample twice": lambda rng: np.repeat(white(rng)[: ROWS // 2], 2, axis=0),
    "polled 1.5 times as fast": lambda rng: white(rng)[np.arange(ROWS) * 2 // 3],
    "accelerometer held every second row": lambda rng: np.hstack(
        (white(rng)[:, :3], np.repeat(white(rng)[: ROWS // 2, 3:], 2, axis=0))
    ),
}


@pytest.mark.parametrize("name", ONE_SENSOR)
@pytest.mark.parametrize("kind", ["even", "groups", "one", "none"])
def test_one_sensor_is_not_taken_for_several(name, kind):
    if kind in ("groups", "one") and "at half the rate on" in name:
        pytest.skip("two sensors of equal bias on three axes, with stamps in pairs, are the same rows")
    rng = np.random.default_rng(seed_of(f"one sensor {name} {kind}"))
    found = [find_interleaving(channels(ONE_SENSOR[name](rng)), stamps(kind, 2)) for _ in range(20)]
    assert found == [None] * 20


def written(path, samples, times=None, names=NAMES):
    header = [*(["time"] if times is not None else []), *names]
    rows = samples if times is None else np.column_stack((times, samples))
    path.write_text("\n".join([",".join(header), *(",".join(f"{v:.6f}" for v in row) for row in rows)]) + "\n")
    return path


@pytest.mark.parametrize("kind", ["even", "groups", "one", "none"])
def test_a_log_of_sensors_in_turn_is_refused(tmp_path, kind):
    rng = np.random.default_rng(seed_of("refused"))
    samples = 1e-3 * rng.normal(size=(ROWS, 6)) + 1e-3 * np.tile(BIASES[:2], (ROWS // 2, 1))
    path = written(tmp_path / "log.csv", samples, stamps(kind, 2))
    unit = {"gyro": "rad/s", "accel": "m/s^2"} | ({} if kind == "none" else {"time": "s"})
    with pytest.raises(
        DataError, match=r"2 interleaved sensors: the means of every second row of gyro_z .* differ by 0\.008"
    ):
        read(path, unit=unit, rate=200.0 if kind == "none" else None)


def test_the_case_without_its_column_of_instances_is_refused(tmp_path, field_data):
    lines = (field_data / "cases" / "two_imus_interleaved_bias.csv").read_text().splitlines()
    path = tmp_path / "log.csv"
    path.write_text("\n".join(",".join(f for k, f in enumerate(line.split(",")) if k != 1) for line in lines) + "\n")
    unit = {"gyro": "rad/s", "accel": "m/s^2"}
    with pytest.raises(DataError, match="2 interleaved sensors"):
        read(path, unit=unit)
