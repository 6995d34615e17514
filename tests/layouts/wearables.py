"""Layouts of phones, watches and body-worn sensors."""

import json
import math
from pathlib import Path

import numpy as np
from recording import ACCEL, EPOCH_S, GYRO, STANDARD_GRAVITY, Log, layout, save_rows, save_text, stamps, whole


@layout(
    file="6014664_20240501.csv",
    source="Axivity AX6, OmGui and omconvert documentation: 'Time,Accel-X (g), …, Gyro-X (d/s), …'",
    rate_hz=100,
    seconds=100,
)
def axivity_ax6(path: Path, log: Log) -> None:
    save_rows(
        path,
        "Time,Accel-X (g), Accel-Y (g), Accel-Z (g), Gyro-X (d/s), Gyro-Y (d/s), Gyro-Z (d/s)\n",
        "%s,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f",
        stamps(log.time, "{date} {clock}.{f}", digits=3),
        log.accel_g,
        log.gyro_deg,
    )


@layout(
    file="MetaWear_2024-05-01T10.00.00.000_D5A1C7_Gyroscope_25.000Hz_1.5.0.csv",
    source="mbientlab MetaBase, export of a gyroscope ('epoc (ms),timestamp (-0400),elapsed (s),x-axis (deg/s),…')",
    rate_hz=25,
    seconds=120,
    channels=GYRO,
)
def mbientlab_metabase(path: Path, log: Log) -> None:
    save_rows(
        path,
        "epoc (ms),timestamp (-0400),elapsed (s),x-axis (deg/s),y-axis (deg/s),z-axis (deg/s)\n",
        "%d,%s,%.3f,%.3f,%.3f,%.3f",
        whole((EPOCH_S + log.time) * 1e3),
        stamps(log.time - 4 * 3600, "{date}T{H}.{M}.{S}.{f}", digits=3),
        log.time,
        log.gyro_deg,
    )


@layout(
    file="Session1_Shimmer_6749_Calibrated_SD.csv",
    source="Shimmer Consensys user manual, CSV export: 'sep=' row, names with the unit's number, a row of units",
    rate_hz=128,
    seconds=60,
)
def shimmer_consensys(path: Path, log: Log) -> None:
    names = ["Timestamp_Unix_CAL"]
    names += [f"{kind}_{axis}_CAL" for kind in ("Accel_WR", "Gyro", "Mag") for axis in "XYZ"]
    units = ["ms"] + ["m/(s^2)"] * 3 + ["deg/s"] * 3 + ["local_flux"] * 3
    head = (
        '"sep=\t"\n'
        + "".join(f"Shimmer_6749_{name}\t" for name in names)
        + "\n"
        + "".join(f"{unit}\t" for unit in units)
        + "\n"
    )
    save_rows(
        path,
        head,
        "%.4f\t" + "%.7f\t" * 9,
        (EPOCH_S + log.time) * 1e3,
        log.accel,
        log.gyro_deg,
        log.fill(3, 0.5, 0.002),
    )


@layout(
    file="Movesense_174630000192_imu6.json",
    source="Movesense device library, Meas/IMU API: JSON of notifications with arrays of eight samples",
    rate_hz=104,
    seconds=60,
    asks="several samples in a row: not a table; a refusal is right too",
)
def movesense_json(path: Path, log: Log) -> None:
    lines = []
    for first in range(0, len(log.time) - 7, 8):
        part = slice(first, first + 8)
        body = {
            "Timestamp": round(120_000 + 1e3 * log.time[first]),
            "ArrayAcc": [dict(zip("xyz", np.round(row, 5).tolist(), strict=True)) for row in log.accel[part]],
            "ArrayGyro": [dict(zip("xyz", np.round(row, 5).tolist(), strict=True)) for row in log.gyro_deg[part]],
        }
        lines.append(json.dumps({"Body": body, "Uri": "174630000192/Meas/IMU6/104"}))
    save_text(path, "\n".join(lines) + "\n")


@layout(
    file="Gyroscope.csv",
    source="Sensor Logger (iOS, Android) documentation: 'time,seconds_elapsed,z,y,x', time in ns, rad/s",
    rate_hz=100,
    seconds=90,
    channels=GYRO,
    asks="sensor and unit of the columns z, y, x",
    answers=(("--channels", "time=2,gyro_x=5,gyro_y=4,gyro_z=3", "--unit", "gyro=rad/s,time=s"),),
)
def sensor_logger_gyroscope(path: Path, log: Log) -> None:
    elapsed = 0.0706953125 + log.time
    save_rows(
        path,
        "time,seconds_elapsed,z,y,x\n",
        "%d,%.10f,%.17f,%.17f,%.17f",
        [EPOCH_S * 10**9 + round(value * 1e7) * 100 for value in elapsed.tolist()],
        elapsed,
        log.gyro[:, ::-1],
    )


@layout(
    file="TotalAcceleration.csv",
    source="Sensor Logger (iOS, Android) documentation: 'time,seconds_elapsed,z,y,x', time in ns, m/s²",
    rate_hz=100,
    seconds=90,
    channels=ACCEL,
    asks="sensor and unit of the columns z, y, x",
    answers=(("--channels", "time=2,accel_x=5,accel_y=4,accel_z=3", "--unit", "accel=m/s^2,time=s"),),
)
def sensor_logger_acceleration(path: Path, log: Log) -> None:
    elapsed = 0.0706953125 + log.time
    save_rows(
        path,
        "time,seconds_elapsed,z,y,x\n",
        "%d,%.10f,%.15f,%.15f,%.15f",
        [EPOCH_S * 10**9 + round(value * 1e7) * 100 for value in elapsed.tolist()],
        elapsed,
        log.accel[:, ::-1],
    )


@layout(
    file="Gyroscope rotation rate.csv",
    source="phyphox, experiment 'Gyroscope (rotation rate)', export 'CSV (semicolon, decimal comma)'",
    rate_hz=200,
    seconds=60,
    channels=GYRO,
)
def phyphox_gyroscope(path: Path, log: Log) -> None:
    save_rows(
        path,
        '"Time (s)";"Gyroscope x (rad/s)";"Gyroscope y (rad/s)";"Gyroscope z (rad/s)";"Absolute (rad/s)"\n',
        "%.9E;%.9E;%.9E;%.9E;%.9E",
        0.01234 + log.time,
        log.gyro,
        np.linalg.norm(log.gyro, axis=1),
        decimal=",",
    )


@layout(
    file="Acceleration with g.csv",
    source="phyphox, experiment 'Acceleration with g', export 'CSV (tabulator, decimal point)'",
    rate_hz=400,
    seconds=30,
    channels=ACCEL,
)
def phyphox_acceleration(path: Path, log: Log) -> None:
    names = [f'"Acceleration {axis} (m/s^2)"' for axis in "xyz"]
    save_rows(
        path,
        "\t".join(['"Time (s)"', *names, '"Absolute acceleration (m/s^2)"']) + "\n",
        "%.9E\t%.9E\t%.9E\t%.9E\t%.9E",
        0.01234 + log.time,
        log.accel,
        np.linalg.norm(log.accel, axis=1),
    )


@layout(
    file="MultiRecord_20240501.csv",
    source="Physics Toolbox Sensor Suite, Multi Record: 'time,gFx,gFy,gFz,wx,wy,wz,Bx,By,Bz,'",
    rate_hz=100,
    seconds=90,
    asks="units of gyro (and accelerometer)",
    answers=(("--unit", "gyro=rad/s,accel=g"), ("--unit", "gyro=rad/s,accel=g,time=s")),
)
def physics_toolbox(path: Path, log: Log) -> None:
    save_rows(
        path,
        "time,gFx,gFy,gFz,wx,wy,wz,Bx,By,Bz,\n",
        "%.4f," + "%.5f," * 6 + "%.3f,%.3f,%.3f,",
        0.0042 + log.time,
        log.accel_g,
        log.gyro,
        log.fill(3, 40.0, 0.3),
    )


@layout(
    file="2024-05-01_10_00_00_my_iOS_device.csv",
    source="SensorLog for iOS, CSV header: 'loggingTime(txt),loggingSample(N),accelerometerTimestamp_sinceReboot(s),…'",
    rate_hz=100,
    seconds=50,
)
def sensorlog_ios(path: Path, log: Log) -> None:
    n = len(log.time)
    head = (
        "loggingTime(txt),loggingSample(N),accelerometerTimestamp_sinceReboot(s),accelerometerAccelerationX(G),"
        "accelerometerAccelerationY(G),accelerometerAccelerationZ(G),gyroTimestamp_sinceReboot(s),gyroRotationX(rad/s),"
        "gyroRotationY(rad/s),gyroRotationZ(rad/s),magnetometerTimestamp_sinceReboot(s),magnetometerX(µT),magnetometerY(µT),"
        "magnetometerZ(µT)\n"
    )
    save_rows(
        path,
        head,
        "%s,%d,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.3f,%.3f,%.3f",
        stamps(log.time, "{date} {clock}.{f} +0000", digits=3),
        np.arange(1, n + 1),
        62_608.1 + log.time,
        log.accel_g,
        62_608.1021 + log.time,
        log.gyro,
        62_608.1043 + log.time,
        log.fill(3, 40.0, 0.3),
    )


@layout(
    file="2024-05-01_10_00_00_Apple Watch.csv",
    source="SensorLog for watchOS, device motion: 'motionRotationRateX(rad/s)', 'motionUserAccelerationX(G)'",
    rate_hz=100,
    seconds=60,
    motion="hand",
)
def sensorlog_watch(path: Path, log: Log) -> None:
    n = len(log.time)
    head = (
        "loggingTime(txt),loggingSample(N),motionTimestamp_sinceReboot(s),motionYaw(rad),motionRoll(rad),motionPitch(rad),"
        "motionRotationRateX(rad/s),motionRotationRateY(rad/s),motionRotationRateZ(rad/s),motionUserAccelerationX(G),"
        "motionUserAccelerationY(G),motionUserAccelerationZ(G),batteryState(N),batteryLevel(R)\n"
    )
    save_rows(
        path,
        head,
        "%s,%d,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,1,0.84",
        stamps(log.time, "{date} {clock}.{f} +0000", digits=3),
        np.arange(1, n + 1),
        62_608.1 + log.time,
        np.cumsum(log.gyro, axis=0) / 100,
        log.gyro,
        log.accel_g - log.accel_mean / STANDARD_GRAVITY,
    )


@layout(
    file="gnss_log_2024_05_01_10_00_00.txt.gz",
    source="Google GNSSLogger for Android: a comment for each kind of row, '# UncalGyro,utcTimeMillis,…'",
    rate_hz=100,
    seconds=60,
    accel_rate_hz=50,
)
def android_gnsslogger(path: Path, log: Log) -> None:
    sensors = (
        "UncalAccel,utcTimeMillis,elapsedRealtimeNanos,UncalAccelXMps2,UncalAccelYMps2,UncalAccelZMps2,BiasXMps2,BiasYMps2,"
        "BiasZMps2",
        "UncalGyro,utcTimeMillis,elapsedRealtimeNanos,UncalGyroXRadPerSec,UncalGyroYRadPerSec,UncalGyroZRadPerSec,"
        "DriftXRadPerSec,DriftYRadPerSec,DriftZRadPerSec",
        "UncalMag,utcTimeMillis,elapsedRealtimeNanos,UncalMagXMicroT,UncalMagYMicroT,UncalMagZMicroT,BiasXMicroT,"
        "BiasYMicroT,BiasZMicroT",
    )
    head = (
        "# \n# Header Description:\n# \n# Version: v3.0.5.6 Platform: 13 Manufacturer: Google Model: Pixel 6\n# \n"
        "# Fix,Provider,LatitudeDegrees,LongitudeDegrees,AltitudeMeters,SpeedMps,AccuracyMeters,UnixTimeMillis\n"
        "# \n" + "".join(f"# {names},CalibrationAccuracy\n# \n" for names in sensors)
    )
    rows = []
    for kind, time, values, bias in (
        ("UncalGyro", log.time + 0.0013, log.gyro, "-3.9329554E-4,-2.0115673E-4,0.0056578554,3"),
        ("UncalAccel", log.accel_time + 0.0041, log.accel, "0.0,0.0,0.0,3"),
        ("UncalMag", log.accel_time + 0.0052, log.fill(3, 40.0, 0.3)[: len(log.accel_time)], "12.5,-33.1,8.0,3"),
    ):
        jitter = log.rng.normal(0, 2e-5, len(time))
        for moment, row in zip((time + jitter).tolist(), values.tolist(), strict=True):
            nanos = 17_373_971_210_561 + round(moment * 1e9)
            cells = ",".join(f"{value:.7f}" for value in row)
            rows.append((moment, f"{kind},{int((EPOCH_S + moment) * 1e3)},{nanos},{cells},{bias}"))
    save_text(path, head + "\n".join(text for _, text in sorted(rows)) + "\n")


@layout(
    file="AngularVelocity.csv",
    source="MATLAB Mobile and writetimetable: 'Timestamp,X,Y,Z' with MATLAB's default date format and fractions",
    rate_hz=100,
    seconds=90,
    channels=GYRO,
    asks="sensor and unit of the columns X, Y, Z",
    answers=(("--channels", "time=1,gyro=2:4", "--unit", "gyro=rad/s"),),
)
def matlab_mobile(path: Path, log: Log) -> None:
    save_rows(
        path,
        "Timestamp,X,Y,Z\n",
        "%s,%.8f,%.8f,%.8f",
        stamps(log.time, "{d}-May-{Y} {clock}.{f}", digits=3),
        log.gyro,
    )


@layout(
    file="imu1.csv",
    source="OxIOD dataset, documentation of imu*.csv: sixteen columns without a header, phone carried while walking",
    rate_hz=100,
    seconds=50,
    motion="walk",
    asks="meaning and units of the columns",
    answers=(("--channels", "time=1,gyro=5:7,accel=11:13", "--unit", "time=s,gyro=rad/s,accel=g"),),
)
def oxiod(path: Path, log: Log) -> None:
    gravity = np.tile(log.accel_mean / STANDARD_GRAVITY, (len(log.time), 1)) + log.rng.normal(0, 1e-3, log.accel.shape)
    save_rows(
        path,
        "",
        "%.6f," + ",".join(["%.8f"] * 12) + ",%.4f,%.4f,%.4f",
        499_122.318 + log.time,
        np.sin(np.cumsum(log.gyro, axis=0) / 100),
        log.gyro,
        gravity,
        log.accel_g - log.accel_mean / STANDARD_GRAVITY,
        log.fill(3, 40.0, 0.3),
    )


@layout(
    file="gyro.csv",
    source="ADVIO dataset, documentation of iphone/gyroscope.csv: time, x, y, z without a header, phone held while walking",
    rate_hz=100,
    seconds=60,
    motion="walk",
    channels=GYRO,
    asks="meaning and units of the columns",
    answers=(("--channels", "time=1,gyro=2:4", "--unit", "time=s,gyro=rad/s"),),
)
def advio(path: Path, log: Log) -> None:
    save_rows(path, "", "%.9f,%.9f,%.9f,%.9f", 0.00411 + log.time, log.gyro)


@layout(
    file="Magnetometer.csv",
    source="phyphox, experiment 'Magnetometer', export 'CSV (comma, decimal point)'",
    rate_hz=100,
    seconds=60,
    channels=(),
    asks="no gyro and no accelerometer: a refusal is right",
)
def phyphox_magnetometer(path: Path, log: Log) -> None:
    field = log.fill(3, 40.0, 0.3)
    names = [f'"Magnetic field {axis} (µT)"' for axis in "xyz"]
    save_rows(
        path,
        ",".join(['"Time (s)"', *names, '"Absolute field (µT)"']) + "\n",
        "%.9E,%.9E,%.9E,%.9E,%.9E",
        log.time,
        field,
        np.linalg.norm(field, axis=1),
    )


@layout(
    file="GX010042_GYRO.csv",
    source="gopro-telemetry, CSV of the stream GYRO: 'cts,date,Gyroscope (z) [rad/s],Gyroscope (x) [rad/s],…'",
    rate_hz=200,
    seconds=45,
    channels=GYRO,
    gyro_step=1 / 939,
)
def gopro_telemetry(path: Path, log: Log) -> None:
    counts = np.round(log.gyro[:, [2, 0, 1]] * 939)
    head = "cts,date,Gyroscope (z) [rad/s],Gyroscope (x) [rad/s],Gyroscope (y) [rad/s],temperature [°C]\n"
    save_rows(
        path,
        head,
        "%.6f,%s,%.15f,%.15f,%.15f,38.1",
        153.538 + log.time * 1e3,
        stamps(log.time, "{date}T{clock}.{f}Z", digits=3),
        counts / 939,
    )


@layout(
    file="Insta360_table.gcsv",
    source="Gyroflow documentation, .gcsv log format 1.3: tscale, gscale (rad/s) and ascale (g) within the head",
    rate_hz=500,
    seconds=30,
    gyro_step=0.00122173047,
    accel_step=STANDARD_GRAVITY * 0.00048828125,
)
def gyroflow_gcsv(path: Path, log: Log) -> None:
    head = (
        "GYROFLOW IMU LOG\nversion,1.3\nid,custom_logger_name\norientation,YxZ\nnote,development_test\n"
        "fwversion,FIRMWARE_0.1.0\ntimestamp,1714557600\nvendor,potatocam\nvideofilename,videofilename.mp4\n"
        "lensprofile,potatocam/potatocam_mark1_prime_7_5mm_4k\nlens_info,wide\nframe_readout_time,16.23\n"
        "frame_readout_direction,0\ntscale,0.001\ngscale,0.00122173047\nascale,0.00048828125\nt,gx,gy,gz,ax,ay,az\n"
    )
    save_rows(
        path,
        head,
        "%d,%d,%d,%d,%d,%d,%d",
        whole(log.time * 1e3),
        whole(log.gyro / 0.00122173047),
        whole(log.accel_g / 0.00048828125),
    )


@layout(
    file="tag_wrist.csv",
    source="Wrist tags with an LSM6DSO and a firmware of its own, header 'frame_id,tick_ms,acc_x,…,gyr_z' in counts",
    rate_hz=104,
    seconds=60,
    gyro_step=math.radians(0.0175),
    accel_step=STANDARD_GRAVITY * 0.122e-3,
    asks="unit and scale of the counts",
    answers=(("--unit", "gyro=mdeg/s,accel=mg", "--scale", "gyro=17.5,accel=0.122"),),
)
def lsm6dso_counts(path: Path, log: Log) -> None:
    save_rows(
        path,
        "frame_id,tick_ms,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z\n",
        "%d,%d,%d,%d,%d,%d,%d,%d",
        np.arange(1, len(log.time) + 1),
        whole(5272 + log.time * 1e3),
        whole(log.accel_g * 1e3 / 0.122),
        whole(log.gyro_deg * 1e3 / 17.5),
    )
