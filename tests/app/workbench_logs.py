"""Logs for the tests of the workbench."""

import numpy as np
import pytest

from known import seed_of
from sigmatau import Record, write

AXES = [f"{sensor}_{axis}" for sensor in ("gyro", "accel") for axis in "xyz"]


def write_log(path, *, rows=6000, rate=100.0, units=("rad/s", "m/s^2"), header=True):
    """A log of six axes at rest."""
    noise = np.random.default_rng(seed_of(path.name)).standard_normal((rows, 6)) * np.repeat([1e-3, 1e-2], 3)
    noise[:, 5] += 9.81
    names = [f"{axis} [{units[axis.startswith('accel')]}]" if units else axis for axis in AXES]
    text = ",".join(["time [s]", *names]) if header else ""
    table = np.column_stack([np.arange(rows) / rate, noise])
    np.savetxt(path, table, delimiter=",", header=text, comments="", fmt="%.9g")
    return path


def write_long(path):
    """Write a log that takes a second to analyse, but little time to read."""
    white = np.random.default_rng(seed_of(path.name)).standard_normal((400_000, 3)) * 1e-3
    write(Record.from_arrays(rate=100, unit={"gyro": "rad/s"}, gyro=white), path)
    return path


def write_bag(path, topics, *, rows=3000, rate=100.0):
    """A ROS 1 bag of sensors at rest, by rosbags: `topics` has the size of the white noise of each gyroscope."""
    rosbag1 = pytest.importorskip("rosbags.rosbag1")
    typesys = pytest.importorskip("rosbags.typesys")
    store = typesys.get_typestore(typesys.Stores.ROS1_NOETIC)
    types = store.types
    imu, header, stamp = (
        types[f"{name}"] for name in ("sensor_msgs/msg/Imu", "std_msgs/msg/Header", "builtin_interfaces/msg/Time")
    )
    vector, turned, no = (
        types["geometry_msgs/msg/Vector3"],
        types["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0),
        np.zeros(9),
    )
    noise = np.random.default_rng(seed_of(path.name)).standard_normal((rows, 3))
    with rosbag1.Writer(path) as bag:
        connections = {name: bag.add_connection(name, imu.__msgtype__, typestore=store) for name in topics}
        for k, (x, y, z) in enumerate(noise.tolist()):
            nanoseconds = 1_700_000_000_000_000_000 + round(k * 1e9 / rate)
            seconds, rest = divmod(nanoseconds, 10**9)
            for name, size in topics.items():
                rates = vector(x * size, y * size, z * size)
                forces = vector(x * 1e-2, y * 1e-2, 9.81 + z * 1e-2)
                message = imu(header(k, stamp(seconds, rest), "imu"), turned, no, rates, no, forces, no)
                bag.write(connections[name], nanoseconds, store.serialize_ros1(message, imu.__msgtype__))
    return path
