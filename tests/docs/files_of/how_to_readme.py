"""The files of docs/how-to/README.md: a bag of ROS 1."""

from pathlib import Path

import numpy as np
from logs_of_pages import AXES, MEMS
from rosbags.rosbag1 import Writer
from rosbags.typesys import Stores, get_typestore

from known import seed_of
from sigmatau import NoiseModel, simulate

RATE = 100


def make(folder: Path) -> None:
    """A minute of a MEMS unit."""
    model = NoiseModel(channels={axis: MEMS[axis.split("_")[0]] for axis in AXES})
    record = simulate(model, duration=60.0, rate=RATE, rng=seed_of("static.bag"))
    samples = np.column_stack([record.stream_of(axis).column(axis) for axis in AXES])
    store = get_typestore(Stores.ROS1_NOETIC)
    imu, header, time, vector, quaternion = (
        store.types[name]
        for name in (
            "sensor_msgs/msg/Imu", "std_msgs/msg/Header", "builtin_interfaces/msg/Time", "geometry_msgs/msg/Vector3",
            "geometry_msgs/msg/Quaternion",
        )
    )  # fmt: skip
    none = np.zeros(9)
    with Writer(folder / "static.bag") as bag:
        connection = bag.add_connection("/imu/data", imu.__msgtype__, typestore=store)
        for k, sample in enumerate(samples):
            stamp = 1_700_000_000 * 10**9 + k * 10**9 // RATE
            head = header(seq=k, stamp=time(sec=stamp // 10**9, nanosec=stamp % 10**9), frame_id="imu")
            message = imu(
                header=head, orientation=quaternion(x=0.0, y=0.0, z=0.0, w=1.0), orientation_covariance=none,
                angular_velocity=vector(*sample[:3].tolist()), angular_velocity_covariance=none,
                linear_acceleration=vector(*sample[3:].tolist()), linear_acceleration_covariance=none,
            )  # fmt: skip
            bag.write(connection, stamp, store.serialize_ros1(message, imu.__msgtype__))
