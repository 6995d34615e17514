"""Layouts of flight controllers."""

from pathlib import Path

import numpy as np
from recording import EPOCH_S, GYRO, Log, layout, save_rows, save_text, whole

ROS_UNITS = ("--unit", "gyro=rad/s,accel=m/s^2")


@layout(
    file="IMU.csv",
    source="pymavlink mavlogdump.py --format csv --types IMU; ArduPilot log message IMU with one instance",
    rate_hz=25,
    seconds=120,
    asks="units of gyro and accelerometer",
    answers=(ROS_UNITS, ("--unit", "gyro=rad/s,accel=m/s^2,time=s")),
)
def ardupilot_one_imu(path: Path, log: Log) -> None:
    save_rows(
        path,
        "timestamp,TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,EG,EA,T,GH,AH,GHz,AHz\n",
        "%.6f,%d,0,%.9f,%.9f,%.9f,%.8f,%.8f,%.8f,0,0,28.8,1,1,1000,1000",
        EPOCH_S + log.time,
        whole(65_645_398 + log.time * 1e6),
        log.gyro,
        log.accel,
    )


@layout(
    file="IMU_three_instances.csv",
    source="pymavlink mavlogdump.py --format csv --types IMU; ArduPilot log message IMU with instances I = 0, 1, 2",
    rate_hz=50,
    seconds=55,
    asks="which of the instances in column I",
    answers=(
        ROS_UNITS,
        ("--topic", "imu0", *ROS_UNITS),
        ("--topic", "imu0", "--unit", "gyro=rad/s,accel=m/s^2,time=s"),
    ),
)
def ardupilot_three_imus(path: Path, log: Log) -> None:
    n = len(log.time)
    lines = []
    instances = [(log.gyro, log.accel)]
    for _ in range(2):
        gyro = log.rng.normal(0, 0.01, 3) + log.rng.normal(0, 6e-4, (n, 3))
        instances.append((gyro, log.accel_mean + log.rng.normal(0, 0.007, (n, 3))))
    for index, moment in enumerate(log.time.tolist()):
        for instance, (gyro, accel) in enumerate(instances):
            micros = 65_645_398 + round(moment * 1e6) + 40 * instance
            cells = ",".join(f"{value:.7f}" for value in (*gyro[index], *accel[index]))
            lines.append(f"{EPOCH_S + moment + 4e-5 * instance:.6f},{micros},{instance},{cells},0,0,28.8,1,1,1000,1000")
    head = "timestamp,TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,EG,EA,T,GH,AH,GHz,AHz\n"
    save_text(path, head + "\n".join(lines) + "\n")


@layout(
    file="log_10_sensor_combined_0.csv",
    source="pyulog ulog2csv of a PX4 log, message sensor_combined: 'gyro_rad[0]', 'accelerometer_m_s2[0]'",
    rate_hz=200,
    seconds=45,
    asks="unit of the time stamp",
    answers=(("--unit", "time=us"), ("--unit", "gyro=rad/s,accel=m/s^2,time=us")),
)
def px4_sensor_combined(path: Path, log: Log) -> None:
    head = (
        "timestamp,gyro_rad[0],gyro_rad[1],gyro_rad[2],gyro_integral_dt,accelerometer_timestamp_relative,accelerometer_m_s2[0],"
        "accelerometer_m_s2[1],accelerometer_m_s2[2],accelerometer_integral_dt,accelerometer_clipping,gyro_clipping\n"
    )
    save_rows(
        path,
        head,
        "%d,%.8f,%.8f,%.8f,5000,0,%.8f,%.8f,%.8f,5000,0,0",
        whole(112_574_307 + log.time * 1e6),
        log.gyro,
        log.accel,
    )


@layout(
    file="log_10_sensor_gyro_0.csv",
    source="pyulog ulog2csv of a PX4 log, message sensor_gyro: 'timestamp,timestamp_sample,device_id,x,y,z,temperature,…'",
    rate_hz=250,
    seconds=45,
    channels=GYRO,
    asks="sensor, unit and time unit of the columns x, y, z",
    answers=(("--channels", "time=2,gyro=4:6", "--unit", "gyro=rad/s,time=us"),),
)
def px4_sensor_gyro(path: Path, log: Log) -> None:
    head = (
        "timestamp,timestamp_sample,device_id,x,y,z,temperature,error_count,clip_counter[0],clip_counter[1],clip_counter[2],"
        "samples\n"
    )
    sampled = 112_574_307 + log.time * 1e6
    save_rows(
        path,
        head,
        "%d,%d,2490378,%.8f,%.8f,%.8f,%.3f,0,0,0,0,4",
        whole(sampled + 310 + log.rng.uniform(0, 60, len(sampled))),
        whole(sampled),
        log.gyro,
        41 + log.rng.normal(0, 0.01, len(sampled)),
    )


def save_blackbox(path: Path, log: Log, head: str) -> None:
    """Write the rows of a Betaflight flight: gyroADC in whole deg/s, accSmooth in counts of 1/2048 g."""
    n = len(log.time)
    save_rows(
        path,
        head,
        "%6d, %9d, %3d, %3d, %3d, %4d, %4d, %4d, %4d, %4d, %4d, %4d, %4d, %4d, %4d, %4d",
        np.arange(n),
        whole(55_158_008 + log.time * 1e6),
        whole(log.rng.normal(0, 6, (n, 3))),
        whole(log.rng.normal(0, 10, (n, 3))),
        whole(log.gyro_deg),
        whole(log.accel_g * 2048),
        whole(400 + log.rng.normal(0, 20, (n, 2))),
    )


@layout(
    file="LOG00007.01.csv",
    source="Betaflight blackbox_decode: 'loopIteration, time (us), axisP[0], …, gyroADC[0], …, accSmooth[0], …' of a flight",
    rate_hz=500,
    seconds=18,
    motion="flight",
    asks="units and scale of gyro and accelerometer",
    answers=(("--unit", "gyro=deg/s,accel=g", "--scale", "accel=1/2048"),),
)
def betaflight_decode(path: Path, log: Log) -> None:
    head = (
        "loopIteration, time (us), axisP[0], axisP[1], axisP[2], rcCommand[0], rcCommand[1], rcCommand[2], gyroADC[0], "
        "gyroADC[1], gyroADC[2], accSmooth[0], accSmooth[1], accSmooth[2], motor[0], motor[1]\n"
    )
    save_blackbox(path, log, head)


@layout(
    file="btfl_001.bbl.csv",
    source="Betaflight Blackbox Explorer, Export CSV: quoted pairs of the flight's head, then the column names",
    rate_hz=500,
    seconds=18,
    motion="flight",
    asks="units and scale of gyro and accelerometer, unit of time",
    answers=(
        ("--unit", "gyro=deg/s,accel=g,time=us", "--scale", "accel=1/2048"),
        ("--skip", "6", "--unit", "gyro=deg/s,accel=g,time=us", "--scale", "accel=1/2048"),
    ),
)
def betaflight_explorer(path: Path, log: Log) -> None:
    names = [f"{kind}[{i}]" for kind in ("axisP", "rcCommand", "gyroADC", "accSmooth") for i in range(3)]
    head = (
        '"Product","Blackbox flight data recorder by Nicholas Sherlock"\n"firmwareType","3"\n'
        '"firmware","4.4.2"\n"gyro_scale","0x3f800000"\n"acc_1G",2048\n"looptime",125\n'
        + ",".join(f'"{name}"' for name in ["loopIteration", "time", *names, "motor[0]", "motor[1]"])
        + "\n"
    )
    save_blackbox(path, log, head)


@layout(
    file="FLY125.csv.gz",
    source="DatCon CSV of a DJI flight log: 'Clock:Tick#,Clock:offsetTime,IMU_ATTI(0):…,IMU_ATTI(0):accelX,…,gyroX,…'",
    rate_hz=200,
    seconds=60,
    asks="units of gyro and accelerometer",
    answers=(
        ("--unit", "gyro=deg/s,accel=g,time=s"),
        ("--channels", "time=2,accel=6:8,gyro=9:11", "--unit", "gyro=deg/s,accel=g,time=s"),
    ),
)
def dji_datcon(path: Path, log: Log) -> None:
    n = len(log.time)
    head = (
        "Clock:Tick#,Clock:offsetTime,IMU_ATTI(0):roll:C,IMU_ATTI(0):pitch:C,IMU_ATTI(0):yaw:C,IMU_ATTI(0):accelX,"
        "IMU_ATTI(0):accelY,IMU_ATTI(0):accelZ,IMU_ATTI(0):gyroX,IMU_ATTI(0):gyroY,IMU_ATTI(0):gyroZ,IMU_ATTI(0):magX,"
        "IMU_ATTI(0):magY,IMU_ATTI(0):magZ,GPS:numSats,Motor:Speed:RFront\n"
    )
    save_rows(
        path,
        head,
        "%d,%.6f,%.4f,%.4f,%.4f,%.7f,%.7f,%.7f,%.7f,%.7f,%.7f,%d,%d,%d,14,0",
        whole(4_500_000 + log.time * 4.5e6),
        log.time - 12.5,
        log.fill(3, 3.0, 0.01),
        log.accel_g,
        log.gyro_deg,
        whole(log.fill(3, 900, 4))[:n],
    )
