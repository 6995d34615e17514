"""Layouts of the software of manufacturers of inertial sensors."""

import math
from pathlib import Path

import numpy as np
from recording import STANDARD_GRAVITY, Log, layout, save_rows, save_text, stamps, whole

MILLI_G = STANDARD_GRAVITY / 1000  # m/s²


@layout(
    file="MT_0080005A3B-000-00.txt",
    source="Xsens MT Manager User Manual, section on the ASCII exporter; headers of exports of an MTi-630",
    rate_hz=100,
    seconds=60,
    asks="units of gyro and accelerometer; SampleTimeFine counts 0.1 ms, which the file does not state",
    answers=(("--unit", "gyro=rad/s,accel=m/s^2", "--rate", "100"),),
)
def xsens_mt_manager(path: Path, log: Log) -> None:
    n = len(log.time)
    head = (
        "// General information:\n//  MT Manager version:\t2022.0.0 rev 128012\n"
        "//  Xsens Device API version:\t2022.0.0 rev 128012\n// Device information:\n//  DeviceId:\t0080005A3B\n"
        "//  ProductCode:\tMTI-630-8A1G6\n//  Firmware Version:\t1.10.0 build 31 rev 118512\n//  Hardware Version:\t2.2.0\n"
        "// Device settings:\n//  Filter profile:\tGeneral(1.0)\n//  Option flags:\t0x00000000\n// Coordinate system:\tENU\n"
        "PacketCounter\tSampleTimeFine\tAcc_X\tAcc_Y\tAcc_Z\tGyr_X\tGyr_Y\tGyr_Z\tMag_X\tMag_Y\tMag_Z"
        "\tQuat_q0\tQuat_q1\tQuat_q2\tQuat_q3\n"
    )
    quaternion = np.tile([0.912871, 0.182574, 0.301511, 0.2], (n, 1)) + log.rng.normal(0, 2e-5, (n, 4))
    save_rows(
        path,
        head,
        "%05d\t%d\t" + "\t".join(["%.6f"] * 13),
        (np.arange(n) + 62_000) % 65_536,
        whole(48_213_377 + log.time * 1e4),
        log.accel,
        log.gyro,
        log.fill(3, 0.9, 0.001),
        quaternion,
    )


@layout(
    file="Xsens DOT 3_D422CD00316C_20240501_100000.csv",
    source="Movella DOT User Manual, chapter on recording and data export; headers of exports",
    rate_hz=60,
    seconds=100,
    asks="units of gyro, accelerometer and time",
    answers=(
        ("--unit", "gyro=deg/s,accel=m/s^2,time=us"),
        ("--unit", "gyro=deg/s,accel=m/s^2", "--rate", "60"),
    ),
)
def movella_dot(path: Path, log: Log) -> None:
    n = len(log.time)
    head = (
        "sep=,\r\nDeviceTag:,Xsens DOT 3\r\nFirmwareVersion:,2.0.0\r\nAppVersion:,v2021.0.0\r\nSyncStatus:,Unsynced\r\n"
        "OutputRate:,60Hz\r\nFilterProfile:,General\r\nMeasurementMode:,Extended (Euler)\r\n"
        "StartTime:,2024-05-01_10-00-00_000\r\n© Xsens Technologies B. V. 2005-2021\r\n\r\n"
        "PacketCounter,SampleTimeFine,Euler_X,Euler_Y,Euler_Z,Acc_X,Acc_Y,Acc_Z,Gyr_X,Gyr_Y,Gyr_Z\r\n"
    )
    save_rows(
        path,
        head,
        "%d,%d," + ",".join(["%.6f"] * 9),
        np.arange(1, n + 1),
        whole(1_305_420_117 + log.time * 1e6),
        log.fill(3, 20.0, 0.01),
        log.accel,
        log.gyro_deg,
        end="\r\n",
    )


@layout(
    file="vn100_ascii.txt",
    source="VectorNav VN-100 Interface Control Document: asynchronous ASCII message VNIMU",
    rate_hz=40,
    seconds=120,
    asks="sampling rate",
    answers=(("--rate", "40"),),
)
def vectornav_vnimu(path: Path, log: Log) -> None:
    n = len(log.time)
    values = np.column_stack(
        [
            log.fill(3, 0.6, 0.001),
            log.accel,
            log.gyro,
            27.6 + log.rng.normal(0, 0.02, n),
            101.32 + log.rng.normal(0, 0.005, n),
        ]
    )
    lines = []
    for row in values.tolist():
        body = "VNIMU," + ",".join(
            [f"{value:+08.4f}" for value in row[:6]]
            + [f"{value:+010.6f}" for value in row[6:9]]
            + [f"{row[9]:+05.1f}", f"{row[10]:+08.3f}"]
        )
        parity = 0
        for byte in body.encode():
            parity ^= byte
        lines.append(f"${body}*{parity:02X}")
    save_text(path, "\r\n".join(lines) + "\r\n")


@layout(
    file="imu_vn310.csv.gz",
    source="INSTINCT navigation toolkit, ImuDataLogger.cpp: header of the CSV of VectorNav data",
    rate_hz=200,
    seconds=60,
    asks="units of gyro and accelerometer",
    answers=(
        ("--unit", "gyro=rad/s,accel=m/s^2"),
        ("--channels", "time=1,accel=9:11,gyro=12:14", "--unit", "gyro=rad/s,accel=m/s^2"),
    ),
)
def instinct_vectornav(path: Path, log: Log) -> None:
    n = len(log.time)
    head = (
        "Time [s],GpsCycle,GpsWeek,GpsToW,TimeStartup,UnCompMagX,UnCompMagY,UnCompMagZ,UnCompAccX,UnCompAccY,UnCompAccZ,"
        "UnCompGyroX,UnCompGyroY,UnCompGyroZ,Temperature\n"
    )
    save_rows(
        path,
        head,
        "%.6f,2,258,%.6f,%d,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.7f,%.7f,%.7f,%.2f",
        log.time,
        295_218 + log.time,
        whole(15_213_377_000 + log.time * 1e9),
        log.fill(3, 0.4, 0.001),
        log.accel,
        log.gyro,
        31 + log.rng.normal(0, 0.02, n),
    )


@layout(
    file="imuData.txt",
    source="SBG Systems sbgECom, tools/sbgBasicLogger, loggerEntryImu.cpp: two header lines, names and units",
    rate_hz=200,
    seconds=60,
)
def sbg_basic_logger(path: Path, log: Log) -> None:
    n = len(log.time)
    head = (
        "timestamp\tstatus\taccelX\taccelY\taccelZ\tgyroX\tgyroY\tgyroZ\ttemperature\n"
        "(us)\t(na)\t(m.s^-2)\t(m.s^-2)\t(m.s^-2)\t(deg.s^-1)\t(deg.s^-1)\t(deg.s^-1)\t(degC)\n"
    )
    save_rows(
        path,
        head,
        "%d\t511\t%.6g\t%.6g\t%.6g\t%.6g\t%.6g\t%.6g\t%.6g",
        whole(62_310_004 + log.time * 1e6),
        log.accel,
        log.gyro_deg,
        38 + log.rng.normal(0, 0.01, n),
    )


@layout(
    file="SensorConnect_GX5.csv",
    source="MicroStrain SensorConnect, CSV export of a 3DM-GX5; headers quoted by public analysis scripts",
    rate_hz=100,
    seconds=80,
    asks="units of gyro and accelerometer",
    answers=(
        ("--unit", "gyro=rad/s,accel=g"),
        ("--channels", "time=1,accel=2:4,gyro=5:7", "--unit", "gyro=rad/s,accel=g"),
    ),
)
def microstrain_sensorconnect(path: Path, log: Log) -> None:
    names = ",".join(f"inertial-6253.76535:scaled{kind}{axis}" for kind in ("Accel", "Gyro") for axis in "XYZ")
    save_rows(
        path,
        f"DATA_START\nTime,{names}\n",
        "%s,%.9f,%.9f,%.9f,%.9f,%.9f,%.9f",
        stamps(log.time, "{m}/{d}/{Y} {clock}.{f}", digits=9),
        log.accel_g,
        log.gyro,
    )


@layout(
    file="LOG_SN30021_20240501_100000_0001_PIMU.csv.gz",
    source="Inertial Sense SDK, data set DID_PIMU (pimu_t: time, theta, vel, dt, status) as written by the CSV logger",
    rate_hz=250,
    seconds=60,
    asks="content of theta and vel (increments) and their units",
    answers=(
        ("--channels", "time=1,gyro=2:4,accel=5:7", "--input", "increments", "--unit", "gyro=rad,accel=m/s,time=s"),
    ),
)
def inertial_sense_pimu(path: Path, log: Log) -> None:
    save_rows(
        path,
        "time,theta[0],theta[1],theta[2],vel[0],vel[1],vel[2],dt,status\n",
        "%.4f,%.9f,%.9f,%.9f,%.8f,%.8f,%.8f,0.0040,16777216",
        311.204 + log.time,
        log.gyro / 250,
        log.accel / 250,
    )


@layout(
    file="user_2024_05_01_10_00_00_imu.csv",
    source="Aceinna INS401 user guide and its data decoder: header of the converted raw IMU message",
    rate_hz=100,
    seconds=100,
)
def aceinna_ins401(path: Path, log: Log) -> None:
    save_rows(
        path,
        "GPS_Week,GPS_MS[ms],Acc_X[m/s^2],Acc_Y[m/s^2],Acc_Z[m/s^2],Gyro_X[deg/s],Gyro_Y[deg/s],Gyro_Z[deg/s]\n",
        "2312,%d,%.7f,%.7f,%.7f,%.7f,%.7f,%.7f",
        whole(295_218_000 + log.time * 1e3),
        log.accel,
        log.gyro_deg,
    )


@layout(
    file="SensorTile_Log_N000.tsv",
    source="ST SensorTile DataLog firmware (STSW-STLKT01), datalog_application.c: header of the SD card log",
    rate_hz=100,
    seconds=90,
    gyro_step=math.radians(0.0175),
    accel_step=MILLI_G,
    asks="unit of the time stamp",
    answers=(("--unit", "time=ms"),),
)
def st_sensortile(path: Path, log: Log) -> None:
    n = len(log.time)
    head = (
        "Timestamp\tAccX [mg]\tAccY [mg]\tAccZ [mg]\tGyroX [mdps]\tGyroY [mdps]\tGyroZ [mdps]\tMagX [mgauss]\tMagY [mgauss]"
        "\tMagZ [mgauss]\tP [mB]\tT [°C]\tH [%]\tVOL [mV]\tBAT [%]\r\n"
    )
    save_rows(
        path,
        head,
        "%d\t%d\t%d\t%d\t%d\t%d\t%d\t%d\t%d\t%d\t%.2f\t%.1f\t%.1f\t4012\t91",
        whole(5120 + log.time * 1e3),
        whole(log.accel_g * 1e3),
        whole(whole(log.gyro_deg * 1e3 / 17.5) * 17.5),
        whole(log.fill(3, 400, 3)),
        987.2 + log.rng.normal(0, 0.02, n),
        25.5 + log.rng.normal(0, 0.02, n),
        44 + log.rng.normal(0, 0.1, n),
        end="\r\n",
        encoding="latin-1",
    )


@layout(
    file="Sens001.csv",
    source="ST STWIN and SensorTile.box SD logger: header 'Time [mS], AccX [mg], …, T ['C]'",
    rate_hz=100,
    seconds=90,
    gyro_step=math.radians(0.001),
    accel_step=MILLI_G,
)
def st_sensortile_box(path: Path, log: Log) -> None:
    n = len(log.time)
    head = (
        "Time [mS], AccX [mg], AccY [mg], AccZ [mg], GyroX [mdps], GyroY [mdps], GyroZ [mdps],"
        "MagX [mgauss],MagY [mgauss],MagZ [mgauss],P [mB],T ['C]\n"
    )
    save_rows(
        path,
        head,
        "%d, %d, %d, %d, %d, %d, %d, %d, %d, %d, %.2f, %.1f",
        whole(12_340 + log.time * 1e3),
        whole(log.accel_g * 1e3),
        whole(log.gyro_deg * 1e3),
        whole(log.fill(3, 400, 3)),
        987.2 + log.rng.normal(0, 0.02, n),
        25.5 + log.rng.normal(0, 0.02, n),
    )


@layout(
    file="Log_N001.csv",
    source="ST FP-SNS-ALLMEMS, SD card logger: a unit for the first axis only ('AccX [mg], AccY, AccZ')",
    rate_hz=52,
    seconds=110,
    gyro_step=math.radians(0.001),
    accel_step=MILLI_G,
    asks="unit of y and z, stated for x only",
    answers=(("--unit", "gyro=mdeg/s,accel=mg"),),
)
def st_allmems(path: Path, log: Log) -> None:
    save_rows(
        path,
        "hh:mm:ss.ms, AccX [mg], AccY, AccZ, GyroX [mdps], GyroY, GyroZ, MagX [mgauss], MagY, MagZ\n",
        "%s, %d, %d, %d, %d, %d, %d, %d, %d, %d",
        stamps(log.time, "{clock}.{f}", digits=3),
        whole(log.accel_g * 1e3),
        whole(log.gyro_deg * 1e3),
        whole(log.fill(3, 400, 3)),
    )


@layout(
    file="adis16470_fx3.csv.gz",
    source="Analog Devices iSensor FX3 evaluation GUI, register log of an ADIS16470 (0.1 deg/s and 1.25 mg per LSB)",
    rate_hz=2000,
    seconds=30,
    gyro_step=math.radians(0.1),
    accel_step=1.25 * MILLI_G,
    asks="sampling rate, and unit and scale of the counts",
    answers=(("--rate", "2000", "--unit", "gyro=deg/s,accel=mg", "--scale", "gyro=0.1,accel=1.25"),),
)
def adi_adis16470(path: Path, log: Log) -> None:
    n = len(log.time)
    save_rows(
        path,
        "DIAG_STAT,X_GYRO_OUT,Y_GYRO_OUT,Z_GYRO_OUT,X_ACCL_OUT,Y_ACCL_OUT,Z_ACCL_OUT,TEMP_OUT,DATA_CNTR\n",
        "0,%d,%d,%d,%d,%d,%d,%d,%d",
        whole(log.gyro_deg / 0.1),
        whole(log.accel_g * 1e3 / 1.25),
        whole(287 + log.rng.normal(0, 0.4, n)),
        (np.arange(n) + 61_000) % 65_536,
    )


@layout(
    file="20240501-100000_G370PDS0_W0000015.csv",
    source="Seiko Epson, Python library and logger for IMU devices (esensorlib), README: example log of an M-G370",
    rate_hz=200,
    seconds=60,
    asks="sampling rate, stated only within a comment",
    answers=(("--rate", "200"),),
)
def epson_g370(path: Path, log: Log) -> None:
    head = (
        "#Log created in Python,,,Sample Rate,200.0,Filter Cfg,k128_fc25,,,\n"
        "#Creation Date:,2024-05-01 10:00:00.056749,PROD_ID=G370PDS0,VERSION=29FD,SERIAL_NUM=W0000015,,,,,,\n"
        "#Scaled Data,SF_GYRO=+0.00666667 / 2^16 (deg/s)/bit,SF_ACCL=+0.40000000 / 2^16 mg/bit\n"
        "Sample No.,Gx[dps],Gy[dps],Gz[dps],Ax[mG],Ay[mG],Az[mG]\n"
    )
    save_rows(
        path,
        head,
        "%d,%.8f,%.8f,%.8f,%.8f,%.8f,%.8f",
        np.arange(len(log.time)),
        log.gyro_deg,
        log.accel_g * 1e3,
        tail="#Log End,2024-05-01 10:01:00.056749\n",
    )


@layout(
    file="LpmsLog_20240501.csv.gz",
    source="LP-Research OpenZen and LpmsControl: header of the data log ('SensorId, TimeStamp (s), FrameNumber, …')",
    rate_hz=100,
    seconds=60,
)
def lpms(path: Path, log: Log) -> None:
    n = len(log.time)
    head = (
        "SensorId, TimeStamp (s), FrameNumber, AccX (g), AccY (g), AccZ (g), GyroX (deg/s), GyroY (deg/s), GyroZ (deg/s), "
        "MagX (uT), MagY (uT), MagZ (uT), EulerX (deg), EulerY (deg), EulerZ (deg), QuatW, QuatX, QuatY, QuatZ, "
        "LinAccX (g), LinAccY (g), LinAccZ (g), Pressure (kPa), Altitude (m), Temperature (degC), HeaveMotion (m)\n"
    )
    linear = log.accel_g - log.accel_mean / STANDARD_GRAVITY
    save_rows(
        path,
        head,
        "1, %.4f, %d, " + ", ".join(["%.6f"] * 19) + ", 98.72, 0.0, 31.5, 0.0",
        log.time + 0.01,
        np.arange(1, n + 1),
        log.accel_g,
        log.gyro_deg,
        log.fill(3, 40.0, 0.3),
        log.fill(3, 30.0, 0.01),
        np.tile([0.9, 0.2, 0.3, 0.25], (n, 1)) + log.rng.normal(0, 1e-5, (n, 4)),
        linear,
    )


@layout(
    file="LoggedData_CalInertialAndMag.csv",
    source="x-io Technologies x-IMU API: header of CalInertialAndMag.csv ('Packet number,Gyroscope X (deg/s),…')",
    rate_hz=256,
    seconds=45,
    asks="sampling rate",
    answers=(("--rate", "256"),),
)
def x_io_x_imu(path: Path, log: Log) -> None:
    head = (
        "Packet number,Gyroscope X (deg/s),Gyroscope Y (deg/s),Gyroscope Z (deg/s),Accelerometer X (g),Accelerometer Y (g),"
        "Accelerometer Z (g),Magnetometer X (G),Magnetometer Y (G),Magnetometer Z (G)\n"
    )
    save_rows(
        path,
        head,
        "%d," + ",".join(["%.5f"] * 9),
        np.arange(len(log.time)) + 7,
        log.gyro_deg,
        log.accel_g,
        log.fill(3, 0.4, 0.003),
    )


@layout(
    file="sensors.csv",
    source="x-io Technologies NGIMU software, session files ('Time (s),Gyroscope X (deg/s),…,Barometer (hPa)')",
    rate_hz=400,
    seconds=25,
)
def x_io_ngimu(path: Path, log: Log) -> None:
    n = len(log.time)
    head = (
        "Time (s),Gyroscope X (deg/s),Gyroscope Y (deg/s),Gyroscope Z (deg/s),Accelerometer X (g),Accelerometer Y (g),"
        "Accelerometer Z (g),Magnetometer X (uT),Magnetometer Y (uT),Magnetometer Z (uT),Barometer (hPa)\n"
    )
    save_rows(
        path,
        head,
        "%.4f,%.5f,%.5f,%.5f,%.6f,%.6f,%.6f,%.2f,%.2f,%.2f,%.2f",
        log.time,
        log.gyro_deg,
        log.accel_g,
        log.fill(3, 40.0, 0.3),
        987.2 + log.rng.normal(0, 0.02, n),
    )


@layout(
    file="WT901_20240501.txt",
    source="WitMotion software, tab-separated record of a WT901 ('time DeviceName ChipTime() AccX(g) … AsX(°/s) …')",
    rate_hz=100,
    seconds=60,
    gyro_step=math.radians(2000 / 32_768),
    accel_step=STANDARD_GRAVITY * 16 / 32_768,
)
def witmotion(path: Path, log: Log) -> None:
    head = (
        "time\tDeviceName\tChipTime()\tAccX(g)\tAccY(g)\tAccZ(g)\tAsX(°/s)\tAsY(°/s)\tAsZ(°/s)\tAngleX(°)\tAngleY(°)\tAngleZ(°)"
        "\tHX(uT)\tHY(uT)\tHZ(uT)\tT(°C)\t\r\n"
    )
    save_rows(
        path,
        head,
        "%s\tHC-06(00:0C:BF:19:3F:0D)\tnull\t" + "\t".join(["%.3f"] * 12) + "\t27.61\t",
        stamps(log.time, "{date}T{clock}.{f}", digits=3),
        np.round(log.accel_g * 2048) / 2048,
        np.round(log.gyro_deg * 32_768 / 2000) * 2000 / 32_768,
        log.fill(3, 30.0, 0.01),
        log.fill(3, 40.0, 0.3),
        end="\r\n",
    )
