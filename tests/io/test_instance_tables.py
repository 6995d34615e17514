"""Columns of instances and of words in tables that are not text: MATLAB, HDF5, Parquet, NumPy, data frames."""

import numpy as np
import pytest
from scipy.io import savemat

import sigmatau as st
from known import seed_of
from sigmatau.errors import OptionError
from sigmatau.io.read import read
from sigmatau.io.read.inspection import inspect
from sigmatau.io.read.options import ReadOptions

N = 4000
UNIT = {"gyro": "rad/s", "accel": "m/s^2", "time": "s"}
AXES = ("gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z")


def of_two(**last):
    """Rows of two IMUs of 100 Hz in turn, with other columns after them."""
    rng = np.random.default_rng(seed_of("columns of two IMUs"))
    turn = np.arange(N) % 2
    samples = rng.normal(0, 1e-3, (N, 6)) + np.where(turn, 0.006, 0.0)[:, None]
    return {"time": np.arange(N) // 2 * 0.01 + turn * 6e-5, **dict(zip(AXES, samples.T, strict=True)), **last}


def of_words(gyro="Gyro", accel="Accel"):
    """Rows of a gyro of 200 Hz and an accelerometer of 50 Hz."""
    rng = np.random.default_rng(seed_of("columns of words"))
    is_accel = np.arange(N) % 5 == 4
    t = np.where(is_accel, np.arange(N) // 5 * 0.02 + 0.001, np.arange(N) * 0.0)
    t[~is_accel] = np.arange(np.count_nonzero(~is_accel)) * 0.005
    values = rng.normal(0, 1e-3, (N, 3)) + np.where(is_accel[:, None], [0.1, 0.2, 9.8], [0.0, 0.0, 0.0])
    return {"time": t, **dict(zip("xyz", values.T, strict=True)), "sensor": np.where(is_accel, accel, gyro)}


def to_npz(path, columns):
    np.savez(path, **columns)


def to_mat(path, columns):
    savemat(path, columns)


def to_parquet(path, columns):
    pa = pytest.importorskip("pyarrow")
    import pyarrow.parquet as pq

    pq.write_table(pa.table(columns), path)


def to_hdf5(path, columns):
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w") as file:
        for name, values in columns.items():
            file[name] = values


WRITERS = {"log.npz": to_npz, "log.mat": to_mat, "log.parquet": to_parquet, "log.h5": to_hdf5}


@pytest.mark.parametrize(
    ("name", "column"), list(zip(WRITERS, ("I", "imu", "sensor_id", "I"), strict=True)), ids=WRITERS
)
def test_instances_are_topics(tmp_path, name, column):
    columns = of_two(**{column: np.arange(N) % 2})
    WRITERS[name](tmp_path / name, columns)
    with pytest.raises(
        OptionError, match=rf"'{column}' has 0 and 1, so the rows are of several sensors: .*imu0"
    ) as refused:
        read(tmp_path / name, unit=UNIT)
    assert refused.value.option == "topic"
    for turn in (0, 1):
        stream = read(tmp_path / name, unit=UNIT, topic=f"imu{turn}").stream_of("gyro_x")
        assert stream.grid.rate == pytest.approx(100.0)
        np.testing.assert_array_equal(stream.column("gyro_x"), columns["gyro_x"][turn::2])
    shown = inspect(tmp_path / name, ReadOptions(unit=UNIT))
    assert [(t.rows, t.rate) for t in shown.tables] == [(N // 2, pytest.approx(100.0))] * 2


@pytest.mark.parametrize("name", ["log.npz", "log.parquet"])
@pytest.mark.parametrize(
    ("column", "values"),
    [
        ("seq", np.arange(N) % 4),
        ("status", np.arange(N) % 2),
        ("sensor_id", np.zeros(N)),
        ("sensor", np.random.default_rng(seed_of("random")).integers(0, 2, N)),
        ("imu", np.arange(N) // 100),
    ],
)
def test_other_columns_are_not_instances(tmp_path, name, column, values):
    columns = of_two(**{column: values})
    of_one = {key: value[::2] if key != column else value[: N // 2] for key, value in columns.items()}
    WRITERS[name](tmp_path / name, of_one)
    record = read(tmp_path / name, unit=UNIT)
    assert record.stream_of("gyro_x").grid.n == N // 2


@pytest.mark.parametrize("words", [("Gyro", "Accel"), ("android.gyroscope", "android.accelerometer")])
def test_words_in_parquet_and_frames_are_sensors(tmp_path, words):
    columns = of_words(*words)
    is_accel = columns["sensor"] == words[1]
    to_parquet(tmp_path / "log.parquet", columns)
    pd = pytest.importorskip("pandas")
    frame = pd.DataFrame(columns)
    records = [
        read(tmp_path / "log.parquet", unit=UNIT),
        st.from_frame(frame, unit=UNIT),
        st.from_frame(columns, unit=UNIT),
    ]
    for record in records:
        gyro, accel = record.stream_of("gyro_x"), record.stream_of("accel_x")
        assert (gyro.grid.rate, accel.grid.rate) == (pytest.approx(200.0), pytest.approx(50.0))
        np.testing.assert_array_equal(gyro.column("gyro_x"), columns["x"][~is_accel])
        np.testing.assert_array_equal(accel.column("accel_z"), columns["z"][is_accel])


def test_instances_of_a_frame_are_chosen_by_topic():
    columns = of_two(frame_id=np.where(np.arange(N) % 2, "right", "left"))
    with pytest.raises(OptionError, match="'frame_id' has left and right"):
        st.from_frame(columns, unit=UNIT)
    record = st.from_frame(columns, unit=UNIT, topic="right")
    np.testing.assert_array_equal(record.stream_of("gyro_z").column("gyro_z"), columns["gyro_z"][1::2])


def test_instances_of_dataflash_keep_their_names(field_data):
    shown = inspect(field_data / "field" / "dataflash_171.bin", ReadOptions())
    assert {"IMU", "IMU2", "IMU3"} <= {table.topic for table in shown.tables}
