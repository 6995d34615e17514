"""A second set of layouts, not used to develop the program: ``python tests/layouts/run.py --module blind``."""

import math
import zlib
from pathlib import Path

import numpy as np
from recording import ACCEL, EPOCH_S, GYRO, STANDARD_GRAVITY, Log, layout, save_rows, save_text, stamps, whole

POLAR_EPOCH_S = 946684800  # 2000-01-01 00:00:00 UTC


@layout(
    file="outing_12.csv",
    source='MoTeC i2 Pro, Export Data: \'"Format","MoTeC CSV File"\', pairs, names, units, quoted values; a car on a track',
    rate_hz=100,
    seconds=60,
    motion="drive",
    asks="axes of G Force Long, Lat, Vert and of the rates",
    answers=(
        ("--channels", "time=1,accel=4:6,gyro=7:9"),
        ("--channels", "time=1,accel=4:6,gyro=7:9", "--unit", "accel=g"),
    ),
)
def motec_csv(path: Path, log: Log) -> None:
    names = (
        "Time",
        "Distance",
        "Ground Speed",
        "G Force Long",
        "G Force Lat",
        "G Force Vert",
        "Roll Rate",
        "Pitch Rate",
    )
    units = ("s", "m", "km/h", "G", "G", "G", "deg/s", "deg/s", "deg/s")
    head = (
        '"Format","MoTeC CSV File",,,"Workbook",""\n"Venue","Test Track",,,"Worksheet",""\n'
        '"Vehicle","BMW M4 GT4",,,"Vehicle Desc",""\n"Driver","Test Driver",,,"Engine ID",""\n"Device","ADL"\n'
        '"Comment","",,,"Session","FP1"\n"Log Date","01/05/2024",,,"Origin Time","0.000","s"\n'
        '"Log Time","10:00:00",,,"Start Time","0.000","s"\n"Sample Rate","100.000","Hz",,"End Time","59.990","s"\n'
        '"Duration","59.990","s",,"Start Distance","0","m"\n"Range","entire outing",,,"End Distance","0","m"\n'
        '"Beacon Markers","31.500 "\n\n\n'
        + ",".join(f'"{name}"' for name in (*names, "Yaw Rate"))
        + "\n"
        + ",".join(f'"{unit}"' for unit in units)
        + "\n\n\n"
    )
    save_rows(
        path,
        head,
        ",".join(['"%.3f"'] * 3 + ['"%.5f"'] * 6),
        log.time,
        log.time * 31.2,
        112.3 + 8 * np.sin(log.time / 9),
        log.accel_g,
        log.gyro_deg,
    )


@layout(
    file="Polar_H10_7E0A2B23_20240501_100000_ACC.txt",
    source="Polar Sensor Logger: 'Phone timestamp;sensor timestamp [ns];X [mg];Y [mg];Z [mg]', whole mg, ns since 2000",
    rate_hz=200,
    seconds=60,
    channels=ACCEL,
    accel_step=STANDARD_GRAVITY * 1e-3,
)
def polar_h10_acc(path: Path, log: Log) -> None:
    save_rows(
        path,
        "Phone timestamp;sensor timestamp [ns];X [mg];Y [mg];Z [mg]\n",
        "%s;%d;%d;%d;%d",
        stamps(log.time, "{date}T{clock}.{f}", digits=3),
        (EPOCH_S - POLAR_EPOCH_S) * 10**9 + whole(log.time * 1e9),
        whole(log.accel_g * 1e3),
    )


@layout(
    file="Polar_Sense_A1B2C3D4_20240501_100000_GYRO.txt",
    source="Polar Sensor Logger with a Verity Sense: 'Phone timestamp;sensor timestamp [ns];X [dps];Y [dps];Z [dps]'",
    rate_hz=52,
    seconds=90,
    channels=GYRO,
    gyro_step=math.radians(0.07),
)
def polar_verity_gyro(path: Path, log: Log) -> None:
    save_rows(
        path,
        "Phone timestamp;sensor timestamp [ns];X [dps];Y [dps];Z [dps]\n",
        "%s;%d;%.2f;%.2f;%.2f",
        stamps(log.time, "{date}T{clock}.{f}", digits=3),
        (EPOCH_S - POLAR_EPOCH_S) * 10**9 + whole(log.time * 1e9),
        np.round(log.gyro_deg / 0.07) * 0.07,
    )


@layout(
    file="Run_number_3_Rep_1.csv",
    source="Delsys Trigno, CSV export: a time column 'X[s]' before each channel, 'Sensor 1: ACC.X (g)'",
    rate_hz=1 / 0.00675,
    seconds=60,
)
def delsys_trigno(path: Path, log: Log) -> None:
    names = [f"Sensor 1: {kind}" for kind in ("ACC.{} (g)", "GYRO.{} (deg/s)")]
    head = ",".join(f"X[s],{name.format(axis)}" for name in names for axis in "XYZ") + "\n"
    columns = [column for part in (log.accel_g, log.gyro_deg) for axis in part.T for column in (log.time, axis)]
    save_rows(path, head, ",".join(["%.5f,%.6f"] * 6), *columns)


@layout(
    file="NEO1F18120387 (2024-05-01)RAW.csv",
    source="ActiGraph ActiLife, raw export: ten lines of text ('… at 100 Hz  Filter Normal'), 'Accelerometer X,…' in g",
    rate_hz=100,
    seconds=90,
    channels=ACCEL,
    accel_step=STANDARD_GRAVITY * 1e-3,
    asks="unit, and the sampling rate, stated only within a line of text",
    answers=(("--rate", "100", "--unit", "accel=g"),),
)
def actigraph_raw(path: Path, log: Log) -> None:
    head = (
        "------------ Data File Created By ActiGraph GT3X+ ActiLife v6.13.4 Firmware v3.2.1 date format M/d/yyyy at 100 Hz"
        "  Filter Normal -----------\nSerial Number: NEO1F18120387\nStart Time 10:00:00\nStart Date 5/1/2024\n"
        "Epoch Period (hh:mm:ss) 00:00:00\nDownload Time 10:31:05\nDownload Date 5/2/2024\nCurrent Memory Address: 0\n"
        "Current Battery Voltage: 4.07     Mode = 12\n--------------------------------------------------\n"
        "Accelerometer X,Accelerometer Y,Accelerometer Z\n"
    )
    save_rows(path, head, "%.3f,%.3f,%.3f", log.accel_g)


@layout(
    file="imu.txt",
    source="UZH-FPV Drone Racing Dataset: '# id timestamp ang_vel_x … lin_acc_x …', separated by blanks, seconds",
    rate_hz=500,
    seconds=14,
    asks="units of gyro and accelerometer",
    answers=(("--unit", "gyro=rad/s,accel=m/s^2,time=s"),),
)
def uzh_fpv(path: Path, log: Log) -> None:
    save_rows(
        path,
        "# id timestamp ang_vel_x ang_vel_y ang_vel_z lin_acc_x lin_acc_y lin_acc_z\n",
        "%d %.9f %.12f %.12f %.12f %.12f %.12f %.12f",
        np.arange(len(log.time)),
        1540820789.0 + log.time,
        log.gyro,
        log.accel,
    )


@layout(
    file="ms25.csv",
    source="NCLT dataset, read_ms25.py: utime (µs), magnetometer, acceleration (m/s²), rotation (rad/s), without a header",
    rate_hz=47,
    seconds=60,
    motion="drive",
    asks="meaning and units of the columns",
    answers=(("--channels", "time=1,accel=5:7,gyro=8:10", "--unit", "gyro=rad/s,accel=m/s^2,time=us"),),
)
def nclt_ms25(path: Path, log: Log) -> None:
    save_rows(
        path,
        "",
        "%d," + ",".join(["%.9f"] * 9),
        EPOCH_S * 10**6 + whole(log.time * 1e6),
        log.fill(3, 0.4, 0.002),
        log.accel,
        log.gyro,
    )


@layout(
    file="xsens_imu.csv",
    source="Complex Urban and MulRan datasets, file player: ns, quaternion, angles, gyro, acceleration, field",
    rate_hz=100,
    seconds=45,
    asks="meaning and units of the columns",
    answers=(("--channels", "time=1,gyro=9:11,accel=12:14", "--unit", "gyro=rad/s,accel=m/s^2,time=ns"),),
)
def complex_urban_xsens(path: Path, log: Log) -> None:
    angles = np.array([0.012, -0.021, 1.34]) + log.rng.normal(0, 1e-5, (len(log.time), 3))
    half = angles[:, 2] / 2
    quaternion = np.column_stack([angles[:, 0] / 2, angles[:, 1] / 2, np.sin(half), np.cos(half)])
    save_rows(
        path,
        "",
        "%d," + ",".join(["%.8f"] * 16),
        EPOCH_S * 10**9 + whole(log.time * 1e9),
        quaternion,
        angles,
        log.gyro,
        log.accel,
        log.fill(3, 0.5, 0.002),
    )


@layout(
    file="imu-data.csv",
    source="bagpy, message_by_topic of sensor_msgs/Imu: 'Time,header.seq,header.stamp.secs,…,orientation_covariance_0,…'",
    rate_hz=100,
    seconds=30,
    asks="units, which the message fixes and the file does not state",
    answers=(("--unit", "gyro=rad/s,accel=m/s^2,time=s"),),
)
def bagpy(path: Path, log: Log) -> None:
    n = len(log.time)
    names = ["Time", "header.seq", "header.stamp.secs", "header.stamp.nsecs", "header.frame_id"]
    names += [f"orientation.{axis}" for axis in "xyzw"] + [f"orientation_covariance_{i}" for i in range(9)]
    for kind in ("angular_velocity", "linear_acceleration"):
        names += [f"{kind}.{axis}" for axis in "xyz"] + [f"{kind}_covariance_{i}" for i in range(9)]
    covariance = ",".join(["0.0"] * 9)
    nanos = whole(log.time * 1e9)
    save_rows(
        path,
        ",".join(names) + "\n",
        f"%.9f,%d,%d,%d,imu_link,0.0,0.0,0.0,1.0,{covariance},%.9f,%.9f,%.9f,{covariance},%.9f,%.9f,%.9f,{covariance}",
        EPOCH_S + log.time + 0.0021 + log.rng.uniform(0, 1e-4, n),
        np.arange(812, 812 + n),
        EPOCH_S + nanos // 10**9,
        nanos % 10**9,
        log.gyro,
        log.accel,
    )


@layout(
    file="imu_data.csv",
    source="LIONav, utils/imu_analysis/export_imu_csv.py: 'time,ax,ay,az,gx,gy,gz', epoch seconds",
    rate_hz=100,
    seconds=45,
    asks="units of gyro and accelerometer",
    answers=(("--unit", "gyro=rad/s,accel=m/s^2,time=s"),),
)
def lionav(path: Path, log: Log) -> None:
    save_rows(
        path, "time,ax,ay,az,gx,gy,gz\n", "%r,%r,%r,%r,%r,%r,%r", EPOCH_S + log.time, log.accel, log.gyro, end="\r\n"
    )


@layout(
    file="ACCLOG.csv",
    source="M5stick-IMUtracker, README_AccDump.md: 'n,t_sec,ax_g,ay_g,az_g,gx_dps,gy_dps,gz_dps'",
    rate_hz=200,
    seconds=40,
)
def m5stick(path: Path, log: Log) -> None:
    save_rows(
        path,
        "n,t_sec,ax_g,ay_g,az_g,gx_dps,gy_dps,gz_dps\n",
        "%d,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f",
        np.arange(len(log.time)),
        log.time,
        log.accel_g,
        log.gyro_deg,
    )


@layout(
    file="esp32_mpu6050.csv",
    source="ESP32 register reader of an MPU-6050: 'time_ms,accel_x_g,…,gyro_x_dps,…', four decimals",
    rate_hz=50,
    seconds=100,
)
def esp32_mpu6050(path: Path, log: Log) -> None:
    save_rows(
        path,
        "time_ms,accel_x_g,accel_y_g,accel_z_g,gyro_x_dps,gyro_y_dps,gyro_z_dps\n",
        "%d,%.4f,%.4f,%.4f,%.4f,%.4f,%.4f",
        29098 + whole(log.time * 1e3),
        log.accel_g,
        log.gyro_deg,
    )


@layout(
    file="dati_sensori.csv",
    source="Serial logger in Python, Italian: 'Timestamp,Acc x (g),…,Gyro x (deg/s),…,Pressione (milliBar)'",
    rate_hz=50,
    seconds=90,
)
def serial_italian(path: Path, log: Log) -> None:
    names = [f"Acc {axis} (g)" for axis in "xyz"] + [f"Gyro {axis} (deg/s)" for axis in "xyz"]
    names += [f"Mag {axis} (microTesla)" for axis in "xyz"] + ["Pressione (milliBar)", "Altitudine (m)"]
    save_rows(
        path,
        ",".join(["Timestamp", *names]) + "\n",
        "%s," + ",".join(["%.5f"] * 6 + ["%.2f"] * 5),
        stamps(log.time, "{date} {clock}.{f}", digits=6),
        log.accel_g,
        log.gyro_deg,
        log.fill(3, 40.0, 0.3),
        1013.2 + log.rng.normal(0, 0.05, len(log.time)),
        112.0 + log.rng.normal(0, 0.4, len(log.time)),
    )


@layout(
    file="LOG00012.01.csv",
    source="iNav blackbox_decode with --unit-rotation deg/s --unit-acceleration m/s2: ' gyroADC[0] (deg/s)'",
    rate_hz=500,
    seconds=20,
    gyro_step=math.radians(0.01),
    accel_step=0.01,
)
def inav_units(path: Path, log: Log) -> None:
    n = len(log.time)
    names = ["loopIteration", "time (us)", "axisP[0]", "axisP[1]", "axisP[2]"]
    names += [f"gyroADC[{i}] (deg/s)" for i in range(3)] + [f"accSmooth[{i}] (m/s/s)" for i in range(3)]
    names += ["motor[0]", "vbat (V)", "flightModeFlags (flags)"]
    save_rows(
        path,
        ", ".join(names) + "\n",
        "%d, %d, %d, %d, %d, %.2f, %.2f, %.2f, %.2f, %.2f, %.2f, 1000, 16.21, 0",
        np.arange(0, 4 * n, 4),
        51_203_117 + whole(log.time * 1e6),
        whole(log.rng.normal(0, 2, (n, 3))),
        log.gyro_deg,
        log.accel,
    )


@layout(
    file="tek0003ALL.csv",
    source="Tektronix MDO3000 oscilloscope, waveform .csv of three channels: an ADXL335 (0.3 V/g, 1.5 V at zero)",
    rate_hz=250,
    seconds=40,
    channels=ACCEL,
    asks="sensor, scale and offset of the volts",
    answers=(
        (
            "--channels",
            "time=1,accel=2:4",
            "--unit",
            "accel=g,time=s",
            "--scale",
            "accel=10/3",
            "--offset",
            "accel=1.5",
        ),
    ),
)
def tektronix_volts(path: Path, log: Log) -> None:
    head = (
        "Model,MDO3024\nFirmware Version,1.26\n\nPoint Format,Y,Y,Y\nHorizontal Units,S,S,S\nHorizontal Scale,4,4,4\n"
        "Horizontal Delay,0,0,0\nSample Interval,0.004,0.004,0.004\nRecord Length,10000,10000,10000\n"
        "Gating,0.0% to 100.0%,0.0% to 100.0%,0.0% to 100.0%\nProbe Attenuation,1,1,1\nVertical Units,V,V,V\n"
        "Vertical Offset,0,0,0\nVertical Scale,0.5,0.5,0.5\nVertical Position,0,0,0\n,,,\n,,,\n,,,\n"
        "Label,,,\nTIME,CH1,CH2,CH3\n"
    )
    save_rows(path, head, "%.6e,%.7f,%.7f,%.7f", log.time - 20.0, 1.5 + 0.3 * log.accel_g)


@layout(
    file="gear_s-1-5-2024-10-0-0.aequ.csv",
    source="Samsung Gear S logger of heartsome.de: 's_A;time_A;x_A;y_A;z_A;…;s_R;time_R;x_R;y_R;z_R', equidistant",
    rate_hz=50,
    seconds=90,
    asks="sensor and units of the columns, of which a letter stands in the row",
    answers=(("--channels", "time=2,accel=3:5,gyro=19:21", "--unit", "gyro=deg/s,accel=m/s^2,time=ms"),),
)
def gear_s(path: Path, log: Log) -> None:
    moment = whole(log.time * 1e3)
    save_rows(
        path,
        "s_A;time_A;x_A;y_A;z_A;s_B;time_B;x_B;s_M;time_M;x_M;y_M;z_M;s_L;time_L;x_L;s_R;time_R;x_R;y_R;z_R\n",
        "A;%d;%.12f;%.12f;%.12f;B;%d;;M;%d;;;;L;%d;;R;%d;%.12f;%.12f;%.12f",
        moment,
        log.accel,
        moment,
        moment,
        moment,
        moment,
        log.gyro_deg,
    )


@layout(
    file="logfile_2024_05_01_10_00_00.txt",
    source="GetSensorData for Android and its descendants: 'ACCE;AppTimestamp(s);SensorTimestamp(s);Acc_X(m/s^2);…'",
    rate_hz=100,
    seconds=40,
    asks="kinds of rows, whose columns only a comment names: a refusal is right too",
)
def getsensordata(path: Path, log: Log) -> None:
    head = (
        "% LogFile created by the 'GetSensorData' App for Android.\n% Date of creation: 2024\n%\n% LogFile Data format:\n"
        "% Accelerometer data: 'ACCE;AppTimestamp(s);SensorTimestamp(s);Acc_X(m/s^2);Acc_Y(m/s^2);Acc_Z(m/s^2);Accuracy'\n"
        "% Gyroscope data: 'GYRO;AppTimestamp(s);SensorTimestamp(s);Gyr_X(rad/s);Gyr_Y(rad/s);Gyr_Z(rad/s);Accuracy'\n"
        "% Magnetometer data: 'MAGN;AppTimestamp(s);SensorTimestamp(s);Mag_X(uT);Mag_Y(uT);Mag_Z(uT);Accuracy(integer)'\n%\n"
    )
    rows = []
    for kind, delay, values in (
        ("ACCE", 0.0, log.accel),
        ("GYRO", 0.0011, log.gyro),
        ("MAGN", 0.0023, log.fill(3, 40, 0.3)),
    ):
        for moment, row in zip((log.time + delay).tolist(), values.tolist(), strict=True):
            cells = ";".join(f"{value:.5f}" for value in row)
            rows.append((moment, f"{kind};{moment + 0.021:.3f};{8112.25 + moment:.6f};{cells};3"))
    save_text(path, head + "\n".join(text for _, text in sorted(rows)) + "\n")


@layout(
    file="20240501T100000_sensor.txt",
    source="Maka Niu camera, sensor_data_readme.txt: 'IMUN:' and ns, date, time, g, deg/s, µT, °C, among other rows",
    rate_hz=50,
    seconds=60,
    asks="kinds of rows, which are not a table: a refusal is right too",
)
def maka_niu(path: Path, log: Log) -> None:
    lines = []
    clock = stamps(log.time, "{Y}{m}{d}\t{H}{M}{S}.{f}", digits=3)
    field = log.fill(3, 40.0, 0.3).tolist()
    for i, (accel, gyro) in enumerate(zip(log.accel_g.tolist(), log.gyro_deg.tolist(), strict=True)):
        start = f"{161_753_520_979 + i * 20_000_000}\t{clock[i]}"
        if i % 50 == 0:
            lines.append(f"GNSS:{start}\t42.3592682\t-71.1121308")
            lines.append(f"BATT:{start}\t10.03")
        cells = "\t".join(f"{value:.5f}" for value in (*accel, *gyro)) + "\t" + "\t".join(f"{v:.2f}" for v in field[i])
        lines.append(f"IMUN:{start}\t{cells}\t24.6")
    save_text(path, "\n".join(lines) + "\n")


@layout(
    file="trial_linearAccelerations.sto",
    source="OpenSim STOFileAdapter, table of Vec3: 'DataType=Vec3', 'endheader', cells 'x,y,z' separated by tabs",
    rate_hz=100,
    seconds=60,
    channels=ACCEL,
    asks="three values in a cell: not a table; a refusal is right too",
)
def opensim_sto(path: Path, log: Log) -> None:
    save_rows(
        path,
        "DataRate=100.000000\nDataType=Vec3\nversion=3\nOpenSimVersion=4.1\nendheader\ntime\tpelvis_imu\n",
        "%.2f\t%.8f,%.8f,%.8f",
        log.time,
        log.accel,
    )


@layout(
    file="imu6.csv",
    source="R, write.csv of the matrix imu6 of the package imudata (XSens MTi-G): row names, '\"Gyro. X\"', '\"Accel. X\"'",
    rate_hz=100,
    seconds=60,
    asks="sampling rate and units",
    answers=(("--rate", "100", "--unit", "gyro=rad/s,accel=m/s^2"),),
)
def r_write_csv(path: Path, log: Log) -> None:
    names = [f'"{kind}. {axis}"' for kind in ("Gyro", "Accel") for axis in "XYZ"]
    save_rows(
        path,
        ",".join(['""', *names]) + "\n",
        '"%d",%.15g,%.15g,%.15g,%.15g,%.15g,%.15g',
        np.arange(1, len(log.time) + 1),
        log.gyro,
        log.accel,
    )


@layout(
    file="imu_timetable.csv",
    source="MATLAB documentation of writetimetable: row times of type duration are written as '0.01 sec'",
    rate_hz=100,
    seconds=60,
    asks="units of gyro and accelerometer",
    answers=(("--unit", "gyro=rad/s,accel=m/s^2,time=s"),),
)
def matlab_timetable(path: Path, log: Log) -> None:
    save_rows(
        path,
        "Time,gyroX,gyroY,gyroZ,accelX,accelY,accelZ\n",
        "%.5g sec,%.15g,%.15g,%.15g,%.15g,%.15g,%.15g",
        log.time,
        log.gyro,
        log.accel,
    )


@layout(
    file="WAVE0001.TXT",
    source="Hioki 8807 manual, text file: '\"INTERVAL\", 5.000E-03', '\"VERT_UNITS\", …', '\"DATA\"', scaled to g",
    rate_hz=200,
    seconds=40,
    channels=ACCEL,
    accel_step=STANDARD_GRAVITY * 1e-4,
    asks="sensor and axes of the channels",
    answers=(("--channels", "time=1,accel=2:4", "--unit", "accel=g,time=s"),),
)
def hioki_text(path: Path, log: Log) -> None:
    head = (
        '"COMMENT", "8807 MEM DATA"\n"DATE", "05-01-2024"\n"TIME", "10:00:00"\n"NUM_SIGS", 4\n"INTERVAL", 5.000E-03\n'
        '"HORZ_UNITS", "S"\n"VERT_UNITS", "S", "G", "G", "G"\n"SIGNAL", "TIME", "ACH1", "ACH2", "ACH3"\n"DATA"\n'
    )
    save_rows(path, head, "%+.6E, %+.4E, %+.4E, %+.4E", log.time, log.accel_g)


@layout(
    file="novatel_rawimusx.txt",
    source="NovAtel OEM7 commands and logs, RAWIMUSXA: counts of increments, order Z, −Y, X, a checksum after each row",
    rate_hz=200,
    seconds=30,
    asks="counts of increments with a sign, rows of messages: not a table; a refusal is right too",
)
def novatel_rawimusx(path: Path, log: Log) -> None:
    signs = np.array([1, -1, 1])
    accel = whole(log.accel[:, ::-1] * signs / 200 * 2**31 / 200)
    gyro = whole(log.gyro_deg[:, ::-1] * signs / 200 * 2**31 / 720)
    lines = []
    for i, cells in enumerate(np.hstack([accel, gyro]).tolist()):
        moment = 295_218 + i / 200
        values = ",".join(map(str, cells))
        body = f"RAWIMUSXA,2312,{moment:.3f};00,41,2312,{moment:.9f},00801503,{values}"
        lines.append(f"%{body}*{zlib.crc32(body.encode(), 0xFFFFFFFF) ^ 0xFFFFFFFF:08x}")
    save_text(path, "\r\n".join(lines) + "\r\n")


@layout(
    file="MT_20240501.csv",
    source="Logger of an Xsens MTi in C: 'PacketCounter;SampleTimeFine;UTC_Nano;…;Acc_X;…;tv_sec;tv_usec;'",
    rate_hz=100,
    seconds=45,
    asks="units, and the clock: SampleTimeFine counts 0.1 ms, which the file does not state",
    answers=(
        ("--rate", "100", "--unit", "gyro=rad/s,accel=m/s^2"),
        ("--channels", "time=none,accel=12:14,gyro=15:17", "--rate", "100", "--unit", "gyro=rad/s,accel=m/s^2"),
    ),
)
def xsens_gps_logger(path: Path, log: Log) -> None:
    n = len(log.time)
    moment = whole(log.time * 1e6)
    head = (
        "PacketCounter;SampleTimeFine;UTC_Nano;UTC_Year;UTC_Month;UTC_Day;UTC_Hour;UTC_Minute;UTC_Second;UTC_Valid;"
        "StatusWord;Acc_X;Acc_Y;Acc_Z;Gyr_X;Gyr_Y;Gyr_Z;Roll;Pitch;Yaw;Latitude;Longitude;Altitude;Vel_X;Vel_Y;Vel_Z;"
        "tv_sec;tv_usec;\n"
    )
    save_rows(
        path,
        head,
        "%d;%d;%d;2024;5;1;10;%d;%d;7;12583047;%.6f;%.6f;%.6f;%.6f;%.6f;%.6f;0.4;-0.7;91.2;46.52;6.57;412.1;0.0;0.0;0.0;%d;%d;",
        (41_200 + np.arange(n)) % 65_536,
        1_812_400 + moment // 100,
        moment % 10**6 * 1000,
        moment // 60_000_000,
        moment // 10**6 % 60,
        log.accel,
        log.gyro,
        EPOCH_S + moment // 10**6,
        moment % 10**6,
    )


@layout(
    file="gesture.csv",
    source="ESP32 recorder with Adafruit_MPU6050: 'time;acc_x;acc_y;acc_z;gyro_x;gyro_y;gyro_z', millis(), four decimals",
    rate_hz=200,
    seconds=40,
    gyro_step=1e-4,
    asks="units of gyro, accelerometer and time",
    answers=(("--unit", "gyro=rad/s,accel=m/s^2,time=ms"),),
)
def esp32_semicolon(path: Path, log: Log) -> None:
    save_rows(
        path,
        "time;acc_x;acc_y;acc_z;gyro_x;gyro_y;gyro_z\n",
        "%d;%.4f;%.4f;%.4f;%.4f;%.4f;%.4f",
        1523 + whole(log.time * 1e3),
        log.accel,
        log.gyro,
    )


@layout(
    file="ActigraphGT9X-AccelerationCalibrated-NA.TAS1E23150066-ACCEL.2024-05-01-10-00-00-000-M0400.sensor.csv.gz",
    source="mHealth storage format, sensor files: 'HEADER_TIME_STAMP,X_ACCELERATION_METERS_PER_SECOND_SQUARED,…'",
    rate_hz=80,
    seconds=80,
    channels=ACCEL,
)
def mhealth_sensor(path: Path, log: Log) -> None:
    names = [f"{axis}_ACCELERATION_METERS_PER_SECOND_SQUARED" for axis in "XYZ"]
    save_rows(
        path,
        ",".join(["HEADER_TIME_STAMP", *names]) + "\n",
        "%s,%.6f,%.6f,%.6f",
        stamps(log.time, "{date} {clock}.{f}", digits=3),
        log.accel,
    )


@layout(
    file="data_1600_accel_phone.txt",
    source="WISDM dataset, raw phone accelerometer: subject, activity letter, ns, x, y, z and a semicolon; walking",
    rate_hz=20,
    seconds=120,
    motion="walk",
    channels=ACCEL,
    asks="meaning and units of the columns",
    answers=(("--channels", "time=3,accel=4:6", "--unit", "accel=m/s^2,time=ns"),),
)
def wisdm(path: Path, log: Log) -> None:
    save_rows(path, "", "1600,A,%d,%.7f,%.7f,%.7f;", 252_207_918_580_802 + whole(log.time * 1e9), log.accel)


@layout(
    file="subject101.dat",
    source="PAMAP2 dataset, readme: 54 columns separated by blanks, NaN for a missing heart rate; a hand that moves",
    rate_hz=100,
    seconds=15,
    motion="hand",
    asks="meaning and units of the columns",
    answers=(("--channels", "time=1,accel=5:7,gyro=11:13", "--unit", "gyro=rad/s,accel=m/s^2,time=s"),),
)
def pamap2(path: Path, log: Log) -> None:
    n = len(log.time)
    parts: list[np.ndarray] = []
    for place in range(3):
        scale = 1.0 if place == 0 else 0.6
        parts += [np.full(n, 30.375 + place), log.accel * scale, log.accel * scale + log.rng.normal(0, 0.05, (n, 3))]
        parts += [log.gyro * scale, log.fill(3, 40.0, 0.3), np.tile([1.0, 0.0, 0.0, 0.0], (n, 1))]
    columns = np.column_stack(parts)
    save_rows(
        path,
        "",
        "%.2f 4 %s " + " ".join(["%.5g"] * columns.shape[1]),
        8.38 + log.time,
        ["104" if i % 11 == 0 else "NaN" for i in range(n)],
        columns,
    )


@layout(
    file="Gyroscope_standing_waist.csv",
    source="RealWorld (HAR) dataset, University of Mannheim: 'id,attr_time,attr_x,attr_y,attr_z', epoch ms",
    rate_hz=50,
    seconds=120,
    channels=GYRO,
    asks="sensor and unit of the columns",
    answers=(("--channels", "time=2,gyro=3:5", "--unit", "gyro=rad/s,time=ms"),),
)
def realworld_har(path: Path, log: Log) -> None:
    save_rows(
        path,
        "id,attr_time,attr_x,attr_y,attr_z\n",
        "%d,%d,%.9f,%.9f,%.9f",
        np.arange(1, len(log.time) + 1),
        EPOCH_S * 1000 + whole(log.time * 1e3),
        log.gyro,
    )


@layout(
    file="ACC.csv",
    source="Empatica E4, ACC.csv: a row of the start, a row of the rate, counts of 1/64 g without a header; worn on a wrist",
    rate_hz=32,
    seconds=120,
    motion="hand",
    channels=ACCEL,
    accel_step=STANDARD_GRAVITY / 64,
    asks="meaning, rate, unit and scale, which stand in two rows or the manual only",
    answers=(("--channels", "accel=1:3", "--rate", "32", "--unit", "accel=g", "--scale", "accel=1/64", "--skip", "2"),),
)
def empatica_e4(path: Path, log: Log) -> None:
    head = f"{EPOCH_S}.000000, {EPOCH_S}.000000, {EPOCH_S}.000000\n32.000000, 32.000000, 32.000000\n"
    save_rows(path, head, "%d,%d,%d", whole(log.accel_g * 64))
