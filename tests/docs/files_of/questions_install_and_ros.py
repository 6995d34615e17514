"""Files of docs/questions/install-and-ros.md."""

from pathlib import Path

import numpy as np
from rosbags import rosbag2
from rosbags.typesys import Stores, get_typestore

from page_records import index_model, simulated

_START = 1_700_000_000_000_000_000
_RATES = {"gyro": 200.0, "accel": 63.0}


def make(folder: Path) -> None:
    """A ROS 2 bag of a depth camera: two topics of one type, each with zeros for the other sensor."""
    model = index_model(folder / "imu.toml")
    store = get_typestore(Stores.ROS2_HUMBLE)
    types = store.types
    vector, imu = types["geometry_msgs/msg/Vector3"], types["sensor_msgs/msg/Imu"]
    header, stamp = types["std_msgs/msg/Header"], types["builtin_interfaces/msg/Time"]
    turned = types["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0)
    unknown, zero = np.zeros(9), vector(x=0.0, y=0.0, z=0.0)
    writer = rosbag2.Writer(folder / "rec", version=9, storage_plugin=rosbag2.StoragePlugin.MCAP)
    with writer:
        for sensor, rate in _RATES.items():
            record = simulated(f"questions: bag {sensor}", model, seconds=20, rate=rate)
            rows = np.stack([record.stream_of(f"{sensor}_{a}").column(f"{sensor}_{a}") for a in "xyz"], axis=1)
            rows[:, 2] += 9.81 if sensor == "accel" else 0.0
            topic = writer.add_connection(f"/camera/{sensor}/sample", imu.__msgtype__, typestore=store)
            for k, (x, y, z) in enumerate(rows.tolist()):
                stamp_ns = _START + round(k * 1e9 / rate)
                measured = vector(x=x, y=y, z=z)
                message = imu(
                    header=header(stamp=stamp(sec=stamp_ns // 10**9, nanosec=stamp_ns % 10**9), frame_id="imu"),
                    orientation=turned,
                    orientation_covariance=unknown,
                    angular_velocity=measured if sensor == "gyro" else zero,
                    angular_velocity_covariance=unknown,
                    linear_acceleration=measured if sensor == "accel" else zero,
                    linear_acceleration_covariance=unknown,
                )
                writer.write(topic, stamp_ns, store.serialize_cdr(message, imu.__msgtype__))
