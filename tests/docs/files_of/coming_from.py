"""The files of docs/coming-from: small logs in the formats of other programs, and their results."""

import struct
from pathlib import Path

import numpy as np
from scipy.io import savemat

from known import nbs14, seed_of
from sigmatau import NoiseModel, simulate, write

RATE = 100.0
AXES = [f"{sensor}_{axis}" for sensor in ("gyro", "accel") for axis in "xyz"]
GYRO = {"random_walk": 1e-4, "bias_instability": 3e-5}
ACCEL = {"random_walk": 1e-3, "bias_instability": 3e-4}

# As allan_variance_ros writes it: the keys of Kalibr
KALIBR = """\
#Accelerometer
accelerometer_noise_density: 0.00105
accelerometer_random_walk: 1.3e-05

#Gyroscope
gyroscope_noise_density: 0.000103
gyroscope_random_walk: 9.2e-07

rostopic: '/imu/data'
update_rate: 100.0
"""
AXIS = """\
   {axis}:
      {name}_n: {noise}
      {name}_w: {minimum}
"""


def _imu_utils() -> str:
    """A result in the form of imu_utils."""
    text = "%YAML:1.0\n---\ntype: IMU\nname: mems\n"
    for block, unit, noise, minimum in (("Gyr", "rad/s", 2e-3, 2.2e-5), ("Acc", "m/s^2", 2e-2, 2.3e-4)):
        text += f'{block}:\n   unit: " {unit}"\n'
        for axis in ("avg-axis", "x-axis", "y-axis", "z-axis"):
            text += AXIS.format(axis=axis, name=block.lower(), noise=noise, minimum=minimum)
    return text


def make(folder: Path) -> None:
    """The files that the pages name."""
    six = NoiseModel(channels={axis: GYRO if axis.startswith("gyro") else ACCEL for axis in AXES})
    record = simulate(six, duration=300, rate=RATE, rng=seed_of("static.csv"))
    write(record, folder / "static.csv")
    _bag(folder / "imu.bag", np.column_stack([record.stream_of(axis).column(axis) for axis in AXES]))
    gyro_z = simulate(NoiseModel(channels={"gyro_z": GYRO}), duration=3600, rate=RATE, rng=seed_of("gyro.mat"))
    savemat(folder / "gyro.mat", {"omega": gyro_z.stream_of("gyro_z").column("gyro_z")[:, None]})
    values = nbs14()
    np.savetxt(folder / "nbs14.txt", values)
    np.savetxt(folder / "phase.txt", np.concatenate([[0.0], np.cumsum(values - values.mean())]))
    (folder / "old-imu.yaml").write_text(KALIBR, encoding="utf-8")
    (folder / "imu-utils.yaml").write_text(_imu_utils(), encoding="utf-8")


def _bag(path: Path, rates: np.ndarray) -> None:
    """A ROS 1 bag of sensor_msgs/Imu, by rosbags; columns are gyro xyz and accel xyz."""
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_typestore

    frame, start = b"imu_link", 1_700_000_000 * 10**9
    unknown = [0.0] * 9
    with Writer(path) as bag:
        topic = bag.add_connection("/imu/data", "sensor_msgs/msg/Imu", typestore=get_typestore(Stores.ROS1_NOETIC))
        for k, row in enumerate(rates.tolist()):
            stamp = start + round(k / RATE * 1e9)
            head = struct.pack("<IIII", k, stamp // 10**9, stamp % 10**9, len(frame)) + frame
            numbers = [0.0, 0.0, 0.0, 1.0, *unknown, *row[:3], *unknown, *row[3:], *unknown]
            bag.write(topic, stamp, head + struct.pack("<37d", *numbers))
