"""A time column for each signal: signals of one clock are a sensor, and signals of other rates keep their own."""

import numpy as np
import pytest

import known
from sigmatau import from_frame
from sigmatau.errors import OptionError
from sigmatau.io.read import read

N = 1600
RNG = np.random.default_rng(known.seed_of("repeated clocks"))
GYRO = RNG.normal(0, 0.05, (N, 3)).round(6)
ACCEL = (RNG.normal(0, 1e-3, (N, 3)) + np.array([0, 0, 1])).round(6)
GYRO_NAMES = [f"GYRO.{axis} (deg/s)" for axis in "XYZ"]
ACCEL_NAMES = [f"ACC.{axis} (g)" for axis in "XYZ"]


def pair_columns(names, values, rate, clock="X[s]"):
    """Each column behind a time column of its own."""
    time = np.arange(len(values)) / rate
    return [column for name, axis in zip(names, values.T, strict=True) for column in ((clock, time), (name, axis))]


def save(path, columns, delimiter=","):
    """Columns of several lengths; the cells below the end of the shorter ones are empty."""
    longest = max(len(values) for _, values in columns)
    cells = [[f"{value:.6f}" for value in values] + [""] * (longest - len(values)) for _, values in columns]
    lines = [delimiter.join(name for name, _ in columns), *(delimiter.join(row) for row in zip(*cells, strict=True))]
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.mark.parametrize(("clock", "delimiter"), [("X[s]", ","), ("Time (s)", ";"), ("X [s]", "\t")])
def test_one_clock_that_is_repeated(tmp_path, clock, delimiter):
    columns = [*pair_columns(ACCEL_NAMES, ACCEL, 160, clock), *pair_columns(GYRO_NAMES, GYRO, 160, clock)]
    path = save(tmp_path / "log.csv", columns, delimiter)
    for options in ({}, {"channels": {"time": 1, "gyro_x": 8, "gyro_y": 10, "gyro_z": 12}, "unit": {"gyro": "deg/s"}}):
        record = read(path, **options)
        stream = record.stream_of("gyro_z")
        assert stream.grid.rate == pytest.approx(160, rel=1e-5)
        np.testing.assert_allclose(stream.column("gyro_z"), np.radians(GYRO[:, 2]))
    assert not {"unused_columns"} & {finding.code for finding in read(path).findings}


@pytest.mark.parametrize("order", ["gyro first", "accelerometer first", "interleaved"])
def test_signals_of_other_rates_keep_their_own(tmp_path, order):
    emg = pair_columns(["EMG 1 (V)"], RNG.normal(0, 1e-4, (4 * N, 1)), 640)
    gyro, accel = pair_columns(GYRO_NAMES, GYRO, 160), pair_columns(ACCEL_NAMES, ACCEL[: N // 2], 80)
    columns = {
        "gyro first": [*gyro, *emg, *accel],
        "accelerometer first": [*emg, *accel, *gyro],
        "interleaved": [c for k in range(0, 6, 2) for c in (*accel[k : k + 2], *emg, *gyro[k : k + 2])],
    }[order]
    record = read(save(tmp_path / "log.csv", columns))
    for sensor, values, rate in (("gyro", np.radians(GYRO), 160), ("accel", 9.80665 * ACCEL[: N // 2], 80)):
        stream = record.stream_of(f"{sensor}_x")
        assert stream.grid.rate == pytest.approx(rate, rel=1e-5)
        np.testing.assert_allclose(stream.column(f"{sensor}_x"), values[:, 0])


def test_a_clock_for_each_sensor(tmp_path):
    time = np.arange(N) / 160
    columns = [("gyro time [s]", time), *zip(GYRO_NAMES, GYRO.T, strict=True)]
    columns += [("accel time [s]", time[: N // 2] * 2), *zip(ACCEL_NAMES, ACCEL[: N // 2].T, strict=True)]
    record = read(save(tmp_path / "log.csv", columns))
    assert {s.name: round(s.grid.rate, 3) for s in record.streams} == {"gyro": 160, "accel": 80}


def test_axes_of_several_clocks_are_asked_about(tmp_path):
    columns = [c for k, name in enumerate(GYRO_NAMES) for c in pair_columns([name], GYRO[:, k : k + 1], 160 + k)]
    with pytest.raises(OptionError, match=r"none with all axes.*clock1.*clock2.*clock3"):
        read(save(tmp_path / "log.csv", columns))


def test_two_clocks_of_one_sensor_are_not_separated(tmp_path):
    time = np.arange(N) / 160
    columns = [("time [s]", time), ("clock [ms]", 1e3 * time), *zip(GYRO_NAMES, GYRO.T, strict=True)]
    assert read(save(tmp_path / "log.csv", columns)).streams[0].grid.rate == pytest.approx(160, rel=1e-5)


def test_a_data_frame_as_pandas_names_the_columns():
    columns = [*pair_columns(ACCEL_NAMES, ACCEL, 160), *pair_columns(GYRO_NAMES, GYRO, 160)]
    frame = {f"{name}{f'.{k // 2}' if k and k % 2 == 0 else ''}": values for k, (name, values) in enumerate(columns)}
    assert from_frame(frame).stream_of("accel_y").grid.rate == pytest.approx(160, rel=1e-9)
