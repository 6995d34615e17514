"""Layouts of robots, vehicles and their data sets."""

from pathlib import Path

import numpy as np
from recording import EPOCH_S, STANDARD_GRAVITY, Log, layout, save_rows, stamps, whole

ROS_UNITS = ("--unit", "gyro=rad/s,accel=m/s^2")


@layout(
    file="imu0.csv",
    source="Kalibr, bag extractor and bag creator: 'timestamp,omega_x,omega_y,omega_z,alpha_x,alpha_y,alpha_z', ns",
    rate_hz=200,
    seconds=50,
    asks="units of gyro and accelerometer",
    answers=(ROS_UNITS, ("--unit", "gyro=rad/s,accel=m/s^2,time=ns")),
)
def kalibr(path: Path, log: Log) -> None:
    save_rows(
        path,
        "timestamp,omega_x,omega_y,omega_z,alpha_x,alpha_y,alpha_z\n",
        "%d,%.8f,%.8f,%.8f,%.7f,%.7f,%.7f",
        [EPOCH_S * 10**9 + round(moment * 1e6) * 1000 for moment in log.time.tolist()],
        log.gyro,
        log.accel,
    )


@layout(
    file="data.csv",
    source="EuRoC MAV dataset, mav0/imu0/data.csv: '#timestamp [ns],w_RS_S_x [rad s^-1],…,a_RS_S_x [m s^-2],…'",
    rate_hz=200,
    seconds=35,
)
def euroc(path: Path, log: Log) -> None:
    names = ["#timestamp [ns]"]
    names += [f"w_RS_S_{axis} [rad s^-1]" for axis in "xyz"] + [f"a_RS_S_{axis} [m s^-2]" for axis in "xyz"]
    save_rows(
        path,
        ",".join(names) + "\r\n",
        "%d,%.17f,%.17f,%.17f,%.15f,%.15f,%.15f",
        [EPOCH_S * 10**9 + round(moment * 1e6) * 1000 + 142_143 for moment in log.time.tolist()],
        log.gyro,
        log.accel,
        end="\r\n",
    )


@layout(
    file="data_B.txt",
    source="TUM-RGBD-GT2IMU, trajWrite.m: '# timestamp wx wy wz ax ay az', separated by blanks",
    rate_hz=250,
    seconds=45,
    asks="units of gyro and accelerometer",
    answers=(ROS_UNITS, ("--unit", "gyro=rad/s,accel=m/s^2,time=s")),
)
def tum_rgbd_imu(path: Path, log: Log) -> None:
    save_rows(
        path,
        "# timestamp wx wy wz ax ay az \n",
        "%.6f %.6f %.6f %.6f %.6f %.6f %.6f ",
        EPOCH_S + log.time,
        log.gyro,
        log.accel,
    )


@layout(
    file="imu_data.csv.gz",
    source="ROS 1, rostopic echo -b BAG -p /imu/data: '%time,field.header.seq,field.header.stamp,…' of sensor_msgs/Imu",
    rate_hz=100,
    seconds=60,
)
def rostopic_echo(path: Path, log: Log) -> None:
    names = ["%time", "field.header.seq", "field.header.stamp", "field.header.frame_id"]
    names += [f"field.orientation.{axis}" for axis in "xyzw"] + [f"field.orientation_covariance{i}" for i in range(9)]
    names += [f"field.angular_velocity.{axis}" for axis in "xyz"]
    names += [f"field.angular_velocity_covariance{i}" for i in range(9)]
    names += [f"field.linear_acceleration.{axis}" for axis in "xyz"]
    names += [f"field.linear_acceleration_covariance{i}" for i in range(9)]
    nanos = [EPOCH_S * 10**9 + round(moment * 1e9) for moment in log.time.tolist()]
    covariance = ",".join(["0.0"] * 9)
    save_rows(
        path,
        ",".join(names) + "\n",
        f"%d,%d,%d,imu_link,0.0,0.0,0.0,1.0,-1.0,{covariance[4:]},%.9f,%.9f,%.9f,{covariance},%.8f,%.8f,%.8f,{covariance}",
        [stamp + 812_000 for stamp in nanos],
        np.arange(len(nanos)) + 311,
        nanos,
        log.gyro,
        log.accel,
    )


@layout(
    file="imu_echo.csv.gz",
    source="ROS 2, ros2 topic echo --csv of sensor_msgs/Imu: values in the order of the message, without a header",
    rate_hz=200,
    seconds=40,
    asks="meaning and units of the columns",
    answers=(
        ("--channels", "time=none,gyro=17:19,accel=29:31", "--rate", "200", *ROS_UNITS),
        ("--channels", "gyro=17:19,accel=29:31", "--rate", "200", *ROS_UNITS),
    ),
)
def ros2_topic_echo(path: Path, log: Log) -> None:
    covariance = ",".join(["0.0"] * 9)
    micros = whole(log.time * 1e6)
    save_rows(
        path,
        "",
        f"%d,%d,imu_link,0.0,0.0,0.0,1.0,{covariance},%.9f,%.9f,%.9f,{covariance},%.8f,%.8f,%.8f,{covariance}",
        EPOCH_S + micros // 10**6,
        micros % 10**6 * 1000 + 318,
        log.gyro,
        log.accel,
    )


@layout(
    file="plotjuggler_export.csv",
    source="PlotJuggler, CSV export of a ROS 2 bag: '__time,/imu/data/angular_velocity/x,…'",
    rate_hz=100,
    seconds=60,
)
def plotjuggler(path: Path, log: Log) -> None:
    names = ["__time"]
    names += [f"/imu/data/{kind}/{axis}" for kind in ("angular_velocity", "linear_acceleration") for axis in "xyz"]
    names += [f"/imu/data/orientation/{axis}" for axis in "wxyz"]
    save_rows(
        path,
        ",".join(names) + "\n",
        "%.9f,%.9f,%.9f,%.9f,%.8f,%.8f,%.8f,1.0,0.0,0.0,0.0",
        EPOCH_S + log.time,
        log.gyro,
        log.accel,
    )


@layout(
    file="2011_09_26_drive_0005_oxts.txt",
    source="KITTI raw data, dataformat.txt of oxts: 30 values a line, joined into a file; a car that drives",
    rate_hz=10,
    seconds=120,
    motion="drive",
    asks="meaning, units and sampling rate",
    answers=(("--channels", "accel=12:14,gyro=18:20", "--rate", "10", *ROS_UNITS),),
)
def kitti_oxts(path: Path, log: Log) -> None:
    n = len(log.time)
    speed = 8 + np.cumsum(log.accel[:, 0] - log.accel_mean[0]) / 10
    save_rows(
        path,
        "",
        " ".join(["%.12f"] * 2 + ["%.6f"] * 4 + ["%.8f"] * 5 + ["%.10f"] * 12) + " 0.25 0.03 4 9 6 6 6",
        49.015 + np.cumsum(speed) * 1e-6,
        8.434 + np.cumsum(speed) * 1e-6,
        116.4 + log.rng.normal(0, 0.01, n),
        np.cumsum(log.gyro, axis=0) / 10,
        speed,
        0.2 * speed,
        speed,
        0.01 * speed,
        0.02 * speed,
        log.accel,
        log.accel + log.rng.normal(0, 0.02, (n, 3)),
        log.gyro,
        log.gyro + log.rng.normal(0, 0.001, (n, 3)),
    )


@layout(
    file="rlg_static.imu",
    source="PSINS toolbox, imufile convention: seven columns, increments of angle (rad) and velocity (m/s), time (s)",
    rate_hz=100,
    seconds=80,
    asks="meaning, content and units of the columns",
    answers=(
        ("--channels", "gyro=1:3,accel=4:6,time=7", "--input", "increments", "--unit", "gyro=rad,accel=m/s,time=s"),
    ),
)
def psins_imu(path: Path, log: Log) -> None:
    save_rows(
        path,
        "",
        "%.10e %.10e %.10e %.9e %.9e %.9e %.4f",
        log.gyro / 100,
        log.accel / 100,
        91_620.01 + log.time,
    )


@layout(
    file="VBOX0003.vbo",
    source="Racelogic VBOX file format (.vbo): [header], [channel units], [column names], [data]; a car on a track",
    rate_hz=100,
    seconds=60,
    motion="drive",
    asks="names and units, stated in sections of the head",
    answers=(
        ("--channels", "accel=8:10,gyro=11:13", "--rate", "100", "--unit", "gyro=deg/s,accel=g"),
        ("--skip", "36", "--channels", "accel=8:10,gyro=11:13", "--rate", "100", "--unit", "gyro=deg/s,accel=g"),
    ),
)
def racelogic_vbo(path: Path, log: Log) -> None:
    names = ["satellites", "time", "latitude", "longitude", "velocity kmh", "heading", "height"]
    extra = ["X_Accel", "Y_Accel", "Z_Accel", "PitchRate", "RollRate", "YawRate"]
    head = (
        "File created on 01/05/2024 @ 10:00:00\r\n\r\n[header]\r\n"
        + "".join(f"{name}\r\n" for name in names + extra)
        + "\r\n[channel units]\r\n"
        + "g\r\n" * 3
        + "deg/s\r\n" * 3
        + "\r\n[comments]\r\n(c) 2001 - 2024 Racelogic\r\nLog Rate (Hz) : 100.00\r\n\r\n[column names]\r\n"
        + "sats time lat long velocity heading height X_Accel Y_Accel Z_Accel PitchRate RollRate YawRate \r\n\r\n[data]\r\n"
    )
    speed = 80 + 3.6 * np.cumsum(log.accel[:, 0] - log.accel_mean[0]) / 100
    save_rows(
        path,
        head,
        "010 %s +03120.%06d +00058.%06d %07.3f 182.40 +0104.20 %+.4f %+.4f %+.4f %+.3f %+.3f %+.3f ",
        stamps(log.time, "{H}{M}{S}.{f}", digits=2),
        whole(12_000 + np.cumsum(np.abs(speed)) * 0.2),
        whole(31_000 + np.cumsum(np.abs(speed)) * 0.1),
        np.abs(speed),
        log.accel_g,
        log.gyro_deg,
        end="\r\n",
    )


@layout(
    file="aim_session_12.csv",
    source='AiM RaceStudio, CSV export: \'"Format","AiM CSV File"\', pairs, names, units, quoted values; a kart on a track',
    rate_hz=50,
    seconds=60,
    motion="drive",
    asks="axes of InlineAcc, LateralAcc, VerticalAcc",
    answers=(("--channels", "time=1,accel=3:5,gyro=6:8"),),
)
def aim_racestudio(path: Path, log: Log) -> None:
    names = ["Time", "GPS Speed", "InlineAcc", "LateralAcc", "VerticalAcc", "RollRate", "PitchRate", "YawRate"]
    units = ["s", "km/h", "g", "g", "g", "deg/s", "deg/s", "deg/s"]
    pairs = {
        "Format": "AiM CSV File",
        "Session": "Lonato",
        "Vehicle": "KZ",
        "Racer": "",
        "Championship": "",
        "Comment": "",
        "Date": "Wednesday, May 1, 2024",
        "Time": "10:00 AM",
        "Sample Rate": "50",
        "Duration": "60.000",
        "Segment": "Session",
    }
    head = (
        "".join(f'"{key}","{value}"\r\n' for key, value in pairs.items())
        + "\r\n"
        + ",".join(f'"{name}"' for name in names)
        + "\r\n"
        + ",".join(f'"{unit}"' for unit in units)
        + "\r\n\r\n"
    )
    speed = 60 + 3.6 * np.cumsum(log.accel[:, 0] - log.accel_mean[0]) / 50
    save_rows(
        path,
        head,
        ",".join(['"%.3f"'] + ['"%.4f"'] * 7),
        log.time,
        np.abs(speed),
        log.accel_g,
        log.gyro_deg,
        end="\r\n",
    )


@layout(
    file="imu_array.csv",
    source="Array boards that log two IMUs in a row: the device as prefix of the names ('imu0_gX_dps', 'imu1_gX_dps')",
    rate_hz=100,
    seconds=60,
    asks="which of the two IMUs of a row",
    answers=(
        (
            "--channels",
            "time=micros,gyro_x=imu0_gX_dps,gyro_y=imu0_gY_dps,gyro_z=imu0_gZ_dps,"
            "accel_x=imu0_aX_mg,accel_y=imu0_aY_mg,accel_z=imu0_aZ_mg",
            "--unit",
            "time=us,gyro=deg/s,accel=mg",
        ),
        ("--topic", "imu0", "--unit", "time=us"),
    ),
)
def two_imus_in_a_row(path: Path, log: Log) -> None:
    n = len(log.time)
    names = ["micros"]
    names += [
        f"imu{unit}_{kind}" for unit in (0, 1) for kind in (*(f"a{x}_mg" for x in "XYZ"), *(f"g{x}_dps" for x in "XYZ"))
    ]
    second_accel = np.array([12.0, -31.0, 996.0]) + log.rng.normal(0, 1.9, (n, 3))
    second_gyro = np.array([0.31, -0.12, 0.55]) + log.rng.normal(0, 0.11, (n, 3))
    save_rows(
        path,
        ",".join(names) + "\n",
        "%d," + ",".join(["%.3f", "%.3f", "%.3f", "%.5f", "%.5f", "%.5f"] * 2),
        whole(4_310_212 + log.time * 1e6),
        log.accel / STANDARD_GRAVITY * 1e3,
        log.gyro_deg,
        second_accel,
        second_gyro,
    )
