"""Rows of several sensors in turn, without a column that tells them: found from the samples; one sensor never is."""

import numpy as np
import pytest
from scipy import signal

from known import seed_of
from sigmatau.errors import DataError, OptionError
from sigmatau.io.read import read
from sigmatau.io.read.frame import from_frame
from sigmatau.io.read.inspection import inspect
from sigmatau.io.read.interleaving import find_interleaving
from sigmatau.io.read.options import ReadOptions
from sigmatau.io.read.turns import compare_slow_noise

NAMES = ("gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z")
ROWS = 4800
DRAWS = 6  # logs of each kind; the study of interleaved rows has hundreds
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
@pytest.mark.parametrize(("sensors", "axes"), [(2, 3), (3, 6), (4, 3)])
def test_sensors_in_turn_are_found(kind, sensors, axes):
    rng = np.random.default_rng(seed_of(f"{sensors} sensors in turn"))
    samples = rng.normal(size=(ROWS, axes)) + np.tile(BIASES[:sensors, :axes], (ROWS // sensors, 1))
    found = find_interleaving(channels(samples), stamps(kind, sensors))
    assert found is not None
    assert found.sensors == sensors
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
    assert f"every {'third' if len(turns) == 3 else 'fourth'} row" in str(found.error("2", ""))


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


# A line of one phase makes such means as two sensors of different rates, or of equal differences of their biases.
LINES_THAT_ASK = {
    "a line at half the rate on all axes of a gyro": ("groups", "one"),
    "a line at a third of the rate, of one phase": ("even", "groups", "one", "none"),
}


@pytest.mark.parametrize("name", ONE_SENSOR)
@pytest.mark.parametrize("kind", ["even", "none"])
def test_one_sensor_is_not_taken_for_several(name, kind):
    rng = np.random.default_rng(seed_of(f"one sensor {name} {kind}"))
    found = [find_interleaving(channels(ONE_SENSOR[name](rng)), stamps(kind, 2)) for _ in range(DRAWS)]
    if kind in LINES_THAT_ASK.get(name, ()):
        assert not any(one.certain for one in found if one is not None)
    else:
        assert found == [None] * DRAWS


@pytest.mark.parametrize("name", ONE_SENSOR)
@pytest.mark.parametrize("kind", ["groups", "one"])
def test_one_sensor_with_stamps_in_groups_is_at_most_asked(name, kind):
    rng = np.random.default_rng(seed_of(f"one sensor {name} {kind}"))
    found = [find_interleaving(channels(ONE_SENSOR[name](rng)), stamps(kind, 2)) for _ in range(DRAWS)]
    assert all(one is None or one.sign == "stamps" or name in LINES_THAT_ASK for one in found)
    if name in ("walking", "each sample twice"):  # neighbouring rows have their noise in common
        assert found.count(None) >= DRAWS - 1


def with_wander(rng, rows, period):
    """Two series of six axes with white noise and a random walk that exceeds it from 300 rows on."""
    walk = 0.006 * np.cumsum(rng.normal(size=(period, rows // period, 6)), axis=1)
    return rng.normal(size=walk.shape) + walk


@pytest.mark.parametrize("kind", ["even", "none"])
def test_a_line_at_half_the_rate_of_a_sensor_that_wanders_is_no_second_sensor(kind):
    rng = np.random.default_rng(seed_of("a line and a wander"))
    rows = 20 * ROWS
    line = np.outer((-1.0) ** np.arange(rows), [8, -4, 5, 3, -9, 6])
    samples = with_wander(rng, rows, 1)[0] + line
    assert find_interleaving(channels(samples), stamps(kind, 2, rows)) is None
    flat = rng.normal(size=samples.shape) + line  # nothing tells
    found = find_interleaving(channels(flat), stamps(kind, 2, rows))
    assert found is not None
    assert not found.certain


@pytest.mark.parametrize("kind", ["even", "groups", "one", "none"])
def test_two_sensors_that_wander_are_certain(kind):
    rng = np.random.default_rng(seed_of("two that wander"))
    rows = 20 * ROWS
    samples = with_wander(rng, rows, 2).transpose(1, 0, 2).reshape(rows, 6) + np.tile(BIASES[:2], (rows // 2, 1))
    found = find_interleaving(channels(samples), stamps(kind, 2, rows))
    assert found is not None
    assert found.certain


@pytest.mark.parametrize("kind", ["groups", "one"])
@pytest.mark.parametrize("sensors", [2, 3, 4])
def test_sensors_of_one_bias_are_asked_for_by_their_stamps(kind, sensors):
    rng = np.random.default_rng(seed_of(f"{sensors} of one bias"))
    found = find_interleaving(channels(rng.normal(size=(ROWS, 6))), stamps(kind, sensors))
    assert found is not None
    assert (found.sensors, found.sign, found.certain) == (sensors, "stamps", False)


@pytest.mark.parametrize("kind", ["even", "none"])
def test_sensors_of_one_bias_are_asked_for_by_their_scatter(kind):
    rng = np.random.default_rng(seed_of("two scatters"))
    samples = rng.normal(size=(ROWS, 6)) * np.resize([1.0, 1.6], ROWS)[:, None]
    found = find_interleaving(channels(samples), stamps(kind, 2))
    assert found is not None
    assert (found.sensors, found.sign) == (2, "scatter")
    # Medians of 16 parts of 127 differences each: their standard errors are 0.02 of the scatter.
    assert found.size == pytest.approx(1.6, abs=3 * 0.02 * 2**0.5 * 1.6 + 0.1)


@pytest.mark.parametrize("size", [256, 2000, 20_000])
def test_noise_of_two_sensors_is_hardly_ever_in_common(size):
    rng = np.random.default_rng(seed_of(f"null {size}"))
    walks = (np.cumsum(rng.normal(size=(2, size, 6)), axis=1) * scale for scale in [0, 0.01, 0.1, 1] * 10)
    verdicts = [compare_slow_noise(*(rng.normal(size=walk.shape) + walk)) for walk in walks]
    assert verdicts.count("in common") <= 1


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
    rate = {"rate": 200.0} if kind == "none" else {}
    words = r"2 interleaved sensors.*: the means of every second row of gyro_z .* differ by 0\.008"
    with pytest.raises(OptionError, match=words) as raised:
        read(path, unit=unit, **rate)
    assert "--interleaved 2 --topic imu0" in raised.value.for_command_line()
    both = [
        read(path, unit=unit, interleaved=2, topic=f"imu{k}", **({"rate": 100.0} if rate else {})) for k in range(2)
    ]
    for k, record in enumerate(both):
        assert record.stream_of("gyro_z").grid.rate == pytest.approx(100.0, rel=1e-3)
        np.testing.assert_allclose(record.stream_of("gyro_z").column("gyro_z"), samples[k::2, 2], atol=1e-6)
    assert read(path, unit=unit, interleaved=1, **rate).stream_of("gyro_z").grid.n == ROWS


@pytest.mark.parametrize("frame", [True, False])
def test_a_stated_number_is_checked(tmp_path, frame):
    rng = np.random.default_rng(seed_of("stated"))
    samples = rng.normal(size=(ROWS, 6)) + np.tile(BIASES[:2], (ROWS // 2, 1))
    path = written(tmp_path / "log.csv", samples)

    def reading(**options):
        if frame:
            return from_frame({name: samples[:, k] for k, name in enumerate(NAMES)}, **options)
        return read(path, **options)

    how = {"unit": {"gyro": "rad/s", "accel": "m/s^2"}, "rate": 100.0}
    with pytest.raises(OptionError, match="the means repeat after 2 rows"):
        reading(interleaved=4, topic="imu0", **how)
    with pytest.raises(OptionError, match="3 leaves rows of several sensors in imu1"):
        reading(interleaved=3, topic="imu1", **how)
    with pytest.raises(OptionError, match=r"has several sensors: imu0 .* imu1"):
        reading(interleaved=2, **how)
    for wrong in (0, 17, True, 1.5, "no"):
        with pytest.raises(OptionError, match="must be a number of sensors, 1 to 16"):
            reading(interleaved=wrong, **how)


def test_a_lost_row_changes_the_turns(tmp_path):
    rng = np.random.default_rng(seed_of("lost row"))
    samples = rng.normal(size=(ROWS, 6)) + np.tile(BIASES[:2], (ROWS // 2, 1))
    path = written(tmp_path / "log.csv", np.delete(samples, 3001, axis=0))
    unit = {"gyro": "rad/s", "accel": "m/s^2"}
    with pytest.raises(DataError, match=r"a lost or added row between line (\d+) and line (\d+)") as raised:
        read(path, unit=unit, rate=100.0, interleaved=2, topic="imu0")
    first, last = (int(word.strip(",")) for word in str(raised.value).split() if word.strip(",").isdigit())
    assert first <= 3002 <= last


def test_inspect_asks_and_separates(tmp_path):
    rng = np.random.default_rng(seed_of("inspected"))
    samples = rng.normal(size=(ROWS, 6)) + np.tile(BIASES[:2], (ROWS // 2, 1))
    path = written(tmp_path / "log.csv", samples, stamps("one", 2))
    unit = {"gyro": "rad/s", "accel": "m/s^2", "time": "s"}
    assert "--interleaved 2 --topic imu0" in inspect(path, ReadOptions(unit=unit)).tables[0].wanting
    assert [table.topic for table in inspect(path, ReadOptions(unit=unit, interleaved=2)).tables] == ["imu0", "imu1"]


def test_the_case_without_its_column_of_instances_is_refused(saved, field_data):
    lines = (field_data / "cases" / "two_imus_interleaved_bias.csv").read_text().splitlines()
    path = saved("\n".join(",".join(f for k, f in enumerate(line.split(",")) if k != 1) for line in lines) + "\n")
    unit = {"gyro": "rad/s", "accel": "m/s^2"}
    with pytest.raises(OptionError, match="2 interleaved sensors"):
        read(path, unit=unit)


ORDERS = {
    "pairs in random order": lambda rng, count: np.concatenate([rng.permutation(count) for _ in range(ROWS // count)]),
    "any order": lambda rng, count: rng.integers(0, count, ROWS),
    "blocks of 10": lambda rng, count: np.repeat(np.tile(np.arange(count), ROWS // 10 // count), 10),
    "blocks of 32": lambda rng, count: np.repeat(np.tile(np.arange(count), ROWS // 32 // count), 32),
}


@pytest.mark.parametrize("name", ORDERS)
@pytest.mark.parametrize("axes", [3, 6])
def test_sensors_in_no_fixed_order_are_asked_for(name, axes):
    rng = np.random.default_rng(seed_of(f"order {name} {axes}"))
    order = ORDERS[name](rng, 2)
    found = find_interleaving(channels(rng.normal(size=(len(order), axes)) + BIASES[order][:, :axes]), None)
    assert found is not None
    assert (found.sign, found.certain) == ("groups", False)
    assert "no fixed order" in str(found.error("2", ""))
    assert "own file" in str(found.error_of_count("2", "imu0", 2))


@pytest.mark.parametrize("levels", [0.15, 0.5, 2.0])
def test_a_coarse_line_of_one_sensor_is_no_group(levels):
    rng = np.random.default_rng(seed_of(f"coarse line {levels}"))
    for _ in range(20):
        found = find_interleaving(channels(np.round(levels * line(rng.uniform(0, 0.5), 6)(rng))), None)
        assert found is None or found.sign != "groups"
