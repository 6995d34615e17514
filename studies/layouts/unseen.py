"""A third set of layouts, read once before any correction: ``python tests/layouts/run.py --module unseen``."""

import itertools
import json
import math
from pathlib import Path

import numpy as np
from recording import ACCEL, EPOCH_S, GYRO, STANDARD_GRAVITY, Log, layout, save_rows, save_text, stamps, whole


@layout(
    file="Sensor_record_20240501_100000_AndroSensor.csv",
    source="AndroSensor for Android: 'ACCELEROMETER X (m/s²);…;GRAVITY X (m/s²);…;Time since start in ms ;YYYY-MO-DD …'",
    rate_hz=50,
    seconds=40,
    accel_step=1e-4,
    gyro_step=1e-4,
)
def androsensor(path: Path, log: Log) -> None:
    n = len(log.time)
    names = [
        f"{kind} {axis} ({unit})"
        for kind, unit in (
            ("ACCELEROMETER", "m/s²"),
            ("GRAVITY", "m/s²"),
            ("LINEAR ACCELERATION", "m/s²"),
            ("GYROSCOPE", "rad/s"),
            ("MAGNETIC FIELD", "μT"),
        )
        for axis in "XYZ"
    ]
    names += ["ORIENTATION Z (azimuth °)", "ORIENTATION X (pitch °)", "ORIENTATION Y (roll °)", "SOUND LEVEL (dB)"]
    names += ["Satellites in range", "Time since start in ms ", "YYYY-MO-DD HH-MI-SS_SSS"]
    gravity = np.tile(log.accel_mean, (n, 1)) + log.rng.normal(0, 2e-4, (n, 3))
    save_rows(
        path,
        ";".join(names) + "\n",
        ";".join(["%.4f"] * 19) + ";0;%d;%s",
        log.accel,
        gravity,
        log.accel - gravity,
        log.gyro,
        log.fill(3, 40.0, 0.3),
        log.fill(3, 90.0, 0.05),
        42.0 + log.rng.normal(0, 1.0, n),
        4 + whole(log.time * 1e3),
        stamps(log.time, "{date} {clock}:{f}", digits=3),
    )


@layout(
    file="left wrist_012967_2024-05-01 10-00-00.csv",
    source="GENEActiv PC software, raw CSV: 100 lines of pairs, then time with ':000', x, y, z, lux, button, temperature",
    rate_hz=100,
    seconds=60,
    channels=ACCEL,
    accel_step=STANDARD_GRAVITY * 1e-4,
    asks="meaning and unit of the columns, which the manual states",
    answers=(("--channels", "time=1,accel=2:4", "--unit", "accel=g"),),
)
def geneactiv(path: Path, log: Log) -> None:
    n = len(log.time)
    head = [
        "Device Type,GENEActiv",
        "Device Model,1.1",
        "Device Unique Serial Code,012967",
        "Device Firmware Version,Ver4.08a date30May13",
        "Calibration Date,2012-09-18 11:54:16:000",
        'Application name & version,"GENEActiv PC Software, Version 3.3"',
        *[""] * 4,
        "Measurement Frequency,100.0 Hz",
        "Start Time,2024-05-01 10:00:00:000",
        "Last measurement,2024-05-01 10:00:59:990",
        "Device Location Code,left wrist",
        "Time Zone,GMT +00:00",
        *[""] * 5,
        "Subject Code,p01",
        "Date of Birth,1980-1-1",
        "Sex,female",
        "Height,170",
        "Weight,65",
        "Handedness Code,right handed",
        "Subject Notes,",
        *[""] * 23,
    ]
    for axis in "xyz":
        head += [f"Sensor type,MEMS accelerometer {axis}-axis", "Range,-8 - 8", "Resolution,0.0039", "Units,g", ""]
    head += ["Sensor type,Lux Photodiode 400nm - 1100nm", "Range,0 - 5000", "Resolution,5", "Units,lux", ""]
    head += ["Sensor type,Linear active thermistor", "Range,0 - 70", "Resolution,0.3", "Units,deg. C"]
    head += [""] * (100 - len(head))
    save_rows(
        path,
        "\n".join(head) + "\n",
        "%s,%.4f,%.4f,%.4f,%d,0,%.1f",
        stamps(log.time, "{date} {clock}:{f}", digits=3),
        log.accel_g,
        log.rng.integers(0, 3, n),
        np.full(n, 25.3),
    )


@layout(
    file="CWA-DATA.csv",
    source="Axivity AX3, OmGui 'Export Raw CSV': time, x, y, z in g without a header",
    rate_hz=100,
    seconds=60,
    channels=ACCEL,
    asks="meaning and unit of the columns",
    answers=(("--channels", "time=1,accel=2:4", "--unit", "accel=g"),),
)
def axivity_ax3(path: Path, log: Log) -> None:
    save_rows(path, "", "%s,%.6f,%.6f,%.6f", stamps(log.time, "{date} {clock}.{f}", digits=3), log.accel_g)


@layout(
    file="TAS1F25200112 (2024-05-01)-IMU.csv",
    source="ActiGraph Link, ActiLife IMU export: ten lines of text, 'Timestamp,Accelerometer X,…,Gyroscope X,…'",
    rate_hz=100,
    seconds=50,
    asks="units of gyro and accelerometer",
    answers=(("--unit", "gyro=deg/s,accel=g"),),
)
def actigraph_link(path: Path, log: Log) -> None:
    head = (
        "------------ Data File Created By ActiGraph Link IMU 9DOF Sensor ActiLife v6.13.4 Firmware v1.7.2 date format"
        " M/d/yyyy at 100 Hz  -----------\nSerial Number: TAS1F25200112\nStart Time 10:00:00\nStart Date 5/1/2024\n"
        "Epoch Period (hh:mm:ss) 00:00:00\nDownload Time 18:33:27\nDownload Date 5/2/2024\nCurrent Memory Address: 0\n"
        "Current Battery Voltage: 4.1     Mode = 12\n--------------------------------------------------\n"
        "Timestamp,Accelerometer X,Accelerometer Y,Accelerometer Z,Temperature,"
        "Gyroscope X,Gyroscope Y,Gyroscope Z,Magnetometer X,Magnetometer Y,Magnetometer Z\n"
    )
    save_rows(
        path,
        head,
        "%s," + ",".join(["%.6f"] * 10),
        stamps(log.time, "{date}T{clock}.{f}", digits=7),
        log.accel_g,
        log.fill(1, 25.0, 0.05),
        log.gyro_deg,
        log.fill(3, 40.0, 0.3),
    )


@layout(
    file="imu.txt",
    source="TUM VI dataset, dso/imu.txt: '# timestamp[ns] w.x w.y w.z a.x a.y a.z', separated by blanks",
    rate_hz=200,
    seconds=40,
    asks="units of gyro and accelerometer",
    answers=(("--unit", "gyro=rad/s,accel=m/s^2"),),
)
def tum_vi_dso(path: Path, log: Log) -> None:
    save_rows(
        path,
        "# timestamp[ns] w.x w.y w.z a.x a.y a.z\n",
        "%d %.10f %.10f %.10f %.10f %.10f %.10f",
        1520530308181901469 + whole(log.time * 1e9),
        log.gyro,
        log.accel,
    )


@layout(
    file="log_0_vehicle_imu_0.csv",
    source="pyulog ulog2csv of a PX4 log, message vehicle_imu: 'delta_angle[0],…,delta_velocity[0],…,delta_angle_dt,…'",
    rate_hz=200,
    seconds=30,
    asks="unit of time; delta_angle and delta_velocity are increments in rad and m/s",
    answers=(
        ("--input", "increments", "--unit", "gyro=rad,accel=m/s,time=us"),
        (
            "--channels",
            "time=2,gyro=5:7,accel=8:10",
            "--input",
            "increments",
            "--unit",
            "gyro=rad,accel=m/s,time=us",
        ),
    ),
)
def px4_vehicle_imu(path: Path, log: Log) -> None:
    names = ["timestamp", "timestamp_sample", "accel_device_id", "gyro_device_id"]
    names += [f"delta_{kind}[{i}]" for kind in ("angle", "velocity") for i in range(3)]
    names += ["delta_angle_dt", "delta_velocity_dt", "delta_angle_clipping", "delta_velocity_clipping"]
    names += ["accel_calibration_count", "gyro_calibration_count"]
    moment = 113_204_117 + whole(log.time * 1e6)
    save_rows(
        path,
        ",".join(names) + "\n",
        "%d,%d,2752778,2752778," + ",".join(["%.12f"] * 6) + ",5000,5000,0,0,1,1",
        moment + 214 + log.rng.integers(0, 60, len(log.time)),
        moment,
        log.gyro / 200,
        log.accel / 200,
    )


@layout(
    file="flight.tlog.csv",
    source="pymavlink mavlogdump.py --format csv --types SCALED_IMU2: 'timestamp,time_boot_ms,xacc,…,xgyro,…,temperature'",
    rate_hz=50,
    seconds=100,
    gyro_step=1e-3,
    accel_step=STANDARD_GRAVITY * 1e-3,
    asks="units: MAVLink states mG and mrad/s",
    answers=(
        ("--unit", "gyro=mrad/s,accel=mg"),
        ("--channels", "time=2,accel=3:5,gyro=6:8", "--unit", "gyro=mrad/s,accel=mg,time=ms"),
    ),
)
def mavlink_scaled_imu2(path: Path, log: Log) -> None:
    save_rows(
        path,
        "timestamp,time_boot_ms,xacc,yacc,zacc,xgyro,ygyro,zgyro,xmag,ymag,zmag,temperature\n",
        "%.8f,%d,%d,%d,%d,%d,%d,%d,%d,%d,%d,4512",
        EPOCH_S + log.time + log.rng.uniform(0, 0.004, len(log.time)),
        81_250 + whole(log.time * 1e3),
        whole(log.accel_g * 1e3),
        whole(log.gyro * 1e3),
        whole(log.fill(3, 300.0, 2.0)),
    )


@layout(
    file="TS-02092_2024-05-01-10-00-00_lowg.csv",
    source="IMeasureU Blue Trident, Capture.U: 'unix_timestamp_microsec,time_s,ax_m/s/s,…,gx_deg/s,…'",
    rate_hz=225,
    seconds=35,
)
def capture_u(path: Path, log: Log) -> None:
    names = [f"a{axis}_m/s/s" for axis in "xyz"] + [f"g{axis}_deg/s" for axis in "xyz"]
    save_rows(
        path,
        ",".join(["unix_timestamp_microsec", "time_s", *names]) + "\n",
        "%d,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f",
        EPOCH_S * 10**6 + whole(log.time * 1e6),
        log.time,
        log.accel,
        log.gyro_deg,
    )


@layout(
    file="serial_monitor.txt",
    source="Adafruit_LSM9DS1, example lsm9ds1: 'Accel X: … m/s^2\tY: … m/s^2 \tZ: … m/s^2 ', lines of Mag and Gyro",
    rate_hz=100,
    seconds=40,
    asks="sampling rate",
    answers=(("--rate", "100"),),
)
def adafruit_lsm9ds1(path: Path, log: Log) -> None:
    line = "%s X: {0} {1}\tY: {0} {1} \tZ: {0} {1} \n".format
    row = line("%.5f", "m/s^2") + line("%.2f", "uT") + line("%.6f", "rad/s")
    n = len(log.time)
    labels = [["Accel"] * n, ["Mag"] * n, ["Gyro"] * n]
    save_rows(
        path,
        "LSM9DS1 data read demo\nFound LSM9DS1 9DOF\n",
        row,
        *itertools.chain.from_iterable(zip(labels, (log.accel, log.fill(3, 40.0, 0.3), log.gyro), strict=True)),
    )


@layout(
    file="DATA-001.CSV",
    source="Gulf Coast Data Concepts X16-1D user manual: lines with ';' first, ';Headers, Time,Ax,Ay,Az', 2048 counts a g",
    rate_hz=200,
    seconds=60,
    channels=ACCEL,
    accel_step=STANDARD_GRAVITY / 2048,
    asks="unit and scale of the counts",
    answers=(("--unit", "accel=g", "--scale", "accel=1/2048"), ("--unit", "accel=g,time=s", "--scale", "accel=1/2048")),
)
def gcdc_x16(path: Path, log: Log) -> None:
    head = (
        ";Title, http://www.gcdataconcepts.com, X16-1D, ADXL345\n;Version, 1116, Build date, Jan 27 2014,  SN:CCDC1016\n"
        ";Start_time, 2024-05-01, 10:00:00.000\n;Temperature, -999.00, deg C,  Vbat, 1467, mv\n;SampleRate, 200,Hz\n"
        ";Deadband, 0, counts\n;DeadbandTimeout, 5.000,sec\n;Headers, Time,Ax,Ay,Az\n"
    )
    save_rows(path, head, "%.3f,%d,%d,%d", 0.008 + log.time, whole(log.accel_g * 2048))


@layout(
    file="dataLog00012.TXT",
    source="SparkFun OpenLog Artemis: 'rtcDate,rtcTime,aX,…,gX,…,mX,…,imu_degC,output_Hz,' in milli g and deg/s",
    rate_hz=50,
    seconds=80,
    gyro_step=math.radians(0.01),
    accel_step=STANDARD_GRAVITY * 1e-5,
    asks="units of gyro and accelerometer, which the manual states",
    answers=(
        ("--unit", "gyro=deg/s,accel=mg"),
        ("--channels", "time=2,accel=3:5,gyro=6:8", "--unit", "gyro=deg/s,accel=mg"),
    ),
)
def openlog_artemis(path: Path, log: Log) -> None:
    n = len(log.time)
    save_rows(
        path,
        "rtcDate,rtcTime,aX,aY,aZ,gX,gY,gZ,mX,mY,mZ,imu_degC,output_Hz,\n",
        "%s," + ",".join(["%.2f"] * 10) + ",%.3f,",
        stamps(log.time, "{m}/{d}/{Y},{clock}.{f}", digits=2),
        log.accel_g * 1e3,
        log.gyro_deg,
        log.fill(3, 40.0, 0.3),
        log.fill(1, 28.0, 0.05),
        50.0 + log.rng.normal(0, 0.02, n),
    )


@layout(
    file="idle.3vk2j1.json",
    source="Edge Impulse data acquisition format: one JSON with 'interval_ms', 'sensors' (name, units) and 'values'",
    rate_hz=100,
    seconds=60,
    asks="rows in an array within one JSON: a refusal is right too",
)
def edge_impulse(path: Path, log: Log) -> None:
    sensors = [{"name": f"acc{axis}", "units": "m/s2"} for axis in "XYZ"]
    sensors += [{"name": f"gyr{axis}", "units": "d/s"} for axis in "XYZ"]
    payload = {
        "device_name": "ac:87:a3:0a:2d:1b",
        "device_type": "ARDUINO_NANO33BLE",
        "interval_ms": 10,
        "sensors": sensors,
        "values": np.round(np.hstack([log.accel, log.gyro_deg]), 5).tolist(),
    }
    protected = {"ver": "v1", "alg": "none", "iat": EPOCH_S}
    save_text(path, json.dumps({"protected": protected, "signature": "0" * 64, "payload": payload}))


@layout(
    file="rc_14.log",
    source='Autosport Labs RaceCapture, log file reference: \'"Interval"|"ms"|0|0|1,…,"AccelX"|"G"|-3.0|3.0|50,…\' , sparse',
    rate_hz=50,
    seconds=60,
    gyro_step=math.radians(0.01),
    accel_step=STANDARD_GRAVITY * 1e-4,
    asks="axes of Yaw, Pitch and Roll",
    answers=(
        ("--channels", "time=1,accel=4:6,gyro_z=7,gyro_y=8,gyro_x=9"),
        ("--channels", "time=1,accel=4:6,gyro_z=7,gyro_y=8,gyro_x=9", "--unit", "gyro=deg/s,accel=g,time=ms"),
    ),
)
def racecapture(path: Path, log: Log) -> None:
    names = ['"Interval"|"ms"|0|0|1', '"Utc"|"ms"|0|0|1', '"Battery"|"Volts"|0.0|20.0|1']
    names += [f'"Accel{axis}"|"G"|-3.0|3.0|50' for axis in "XYZ"]
    names += [f'"{name}"|"Deg/Sec"|-120|120|50' for name in ("Yaw", "Pitch", "Roll")]
    moment = whole(log.time * 1e3)
    save_rows(
        path,
        ",".join(names) + "\n",
        "%d,%d,%s,%.4f,%.4f,%.4f,%.2f,%.2f,%.2f",
        402 + moment,
        EPOCH_S * 1000 + moment,
        ["12.62" if i % 50 == 0 else "" for i in range(len(moment))],
        log.accel_g,
        log.gyro_deg[:, ::-1],
    )


@layout(
    file="SENSOR.CSV",
    source="FlySight 2, firmware log.c: '$COL,IMU,time,wx,…', '$UNIT,IMU,s,deg/s,…', '$DATA', '$IMU,…' among '$BARO,…'",
    rate_hz=52,
    seconds=80,
    gyro_step=math.radians(0.001),
    accel_step=STANDARD_GRAVITY * 1e-5,
)
def flysight2(path: Path, log: Log) -> None:
    head = (
        "$FLYS,1\n$VAR,FIRMWARE_VER,v2023.09.22\n$VAR,DEVICE_ID,003b00555752501920313652\n$VAR,SESSION_ID,1c19e8c7\n"
        "$COL,BARO,time,pressure,temperature\n$UNIT,BARO,s,Pa,deg C\n$COL,MAG,time,x,y,z,temperature\n"
        "$UNIT,MAG,s,gauss,gauss,gauss,deg C\n$COL,IMU,time,wx,wy,wz,ax,ay,az,temperature\n"
        "$UNIT,IMU,s,deg/s,deg/s,deg/s,g,g,g,deg C\n$COL,VBAT,time,voltage\n$UNIT,VBAT,s,volt\n$DATA\n"
    )
    rows = []
    field = log.fill(3, 0.4, 0.003).tolist()
    for i, values in enumerate(np.hstack([log.gyro_deg, log.accel_g]).tolist()):
        moment = 59_970.376 + i / 52
        rows.append("$IMU,{:.3f},{:.3f},{:.3f},{:.3f},{:.5f},{:.5f},{:.5f},25.64".format(moment, *values))
        if i % 2 == 0:
            rows.append(f"$BARO,{moment + 0.004:.3f},{100_812.4 + field[i][0]:.2f},25.31")
            rows.append("$MAG,{:.3f},{:.3f},{:.3f},{:.3f},26".format(moment + 0.007, *field[i]))
        if i % 52 == 0:
            rows.append("$VBAT,%.3f,4.118" % (moment + 0.009))
    save_text(path, head + "\n".join(rows) + "\n")


@layout(
    file="imu_raw.csv",
    source="Boreas dataset, applanix/imu_raw.csv: 'GPSTime,angvel_z,angvel_y,angvel_x,accelz,accely,accelx'",
    rate_hz=200,
    seconds=40,
    asks="units of gyro and accelerometer",
    answers=(("--unit", "gyro=rad/s,accel=m/s^2"), ("--unit", "gyro=rad/s,accel=m/s^2,time=s")),
)
def boreas(path: Path, log: Log) -> None:
    save_rows(
        path,
        "GPSTime,angvel_z,angvel_y,angvel_x,accelz,accely,accelx\n",
        "%.6f" + ",%.12f" * 6,
        EPOCH_S + log.time,
        log.gyro[:, ::-1],
        log.accel[:, ::-1],
    )


@layout(
    file="RawGyro.csv",
    source="Zurich Urban MAV dataset: 'Timpstemp, Error_count, x, y, z, temperature, range_rad_s, scaling, x_raw, …', µs",
    rate_hz=100,
    seconds=60,
    channels=GYRO,
    asks="sensor, unit and time of the columns x, y, z",
    answers=(("--channels", "time=1,gyro=3:5", "--unit", "gyro=rad/s,time=us"),),
)
def zurich_raw_gyro(path: Path, log: Log) -> None:
    save_rows(
        path,
        "Timpstemp, Error_count, x, y, z, temperature, range_rad_s, scaling, x_raw, y_raw, z_raw, temperature_raw\n",
        "%d, 0, %.9f, %.9f, %.9f, %.2f, 34.9066, 0.0010653, %d, %d, %d, 0",
        42_117_204 + whole(log.time * 1e6),
        log.gyro,
        log.fill(1, 45.0, 0.05),
        whole(log.gyro / 0.0010653),
    )


@layout(
    file="gyro-0.csv",
    source="gnss-ins-sim, saved results: 'gyro_x (deg/s),gyro_y (deg/s),gyro_z (deg/s)' without a time",
    rate_hz=100,
    seconds=60,
    channels=GYRO,
    asks="sampling rate",
    answers=(("--rate", "100"),),
)
def gnss_ins_sim(path: Path, log: Log) -> None:
    save_rows(path, "gyro_x (deg/s),gyro_y (deg/s),gyro_z (deg/s)\n", "%.14g,%.14g,%.14g", log.gyro_deg)


@layout(
    file="Log-20240501-100000 Track - 0.00.000.csv",
    source='TrackAddict, CSV log of a phone in a car: \'# RaceRender Data: …\', \'"Time","UTC Time","Lap",…,"Accel X",…\'',
    rate_hz=50,
    seconds=60,
    motion="drive",
    channels=ACCEL,
    asks="unit of the accelerometer",
    answers=(("--unit", "accel=g"), ("--unit", "accel=g,time=s")),
)
def trackaddict(path: Path, log: Log) -> None:
    names = ["Time", "UTC Time", "Lap", "GPS_Update", "GPS_Delay", "Latitude", "Longitude", "Altitude (m)"]
    names += ["Speed (Km/h)", "Heading", "Accuracy (m)", "Accel X", "Accel Y", "Accel Z", "Brake (calculated)"]
    n = len(log.time)
    save_rows(
        path,
        "# RaceRender Data: TrackAddict 4.6.2 on iOS 13.3 [iPhone9,3] (Mode: 0)\n# Vehicle: Mazda MX-5\n"
        "# GPS: iOS; Mode: Active\n" + ",".join(f'"{name}"' for name in names) + "\n",
        "%.3f,%.3f,0,%d,0.012,%.7f,%.7f,112.3,%.1f,%.1f,4.0,%.3f,%.3f,%.3f,0",
        log.time,
        EPOCH_S + log.time,
        (np.arange(n) % 50 == 0).astype(int),
        46.52 + 1e-5 * log.time,
        6.57 + 1e-5 * log.time,
        80 + 20 * np.sin(log.time / 9),
        90 + 40 * np.sin(log.time / 13),
        log.accel_g,
    )


@layout(
    file="mHealth_subject1.log",
    source="UCI MHEALTH dataset, readme: 24 columns separated by tabs without a header or a time, 50 Hz",
    rate_hz=50,
    seconds=60,
    asks="meaning, units and sampling rate",
    answers=(("--channels", "accel=6:8,gyro=9:11", "--rate", "50", "--unit", "gyro=deg/s,accel=m/s^2"),),
)
def uci_mhealth(path: Path, log: Log) -> None:
    n = len(log.time)
    save_rows(
        path,
        "",
        "\t".join(["%.5g"] * 23) + "\t0",
        log.accel[:, [1, 2, 0]] + log.rng.normal(0, 0.05, (n, 3)),
        log.rng.normal(0, 0.02, (n, 2)),
        log.accel,
        log.gyro_deg,
        log.fill(3, 40.0, 0.3),
        log.accel[:, [2, 0, 1]] + log.rng.normal(0, 0.05, (n, 3)),
        log.gyro_deg * 0.4 + log.rng.normal(0, 0.05, (n, 3)),
        log.fill(3, 40.0, 0.3),
    )


@layout(
    file="20240501-0001.csv",
    source="PicoScope 7, CSV export: 'Time,Channel A,Channel B,Channel C', '(ms),(V),(V),(V)', an empty line; an ADXL335",
    rate_hz=250,
    seconds=40,
    channels=ACCEL,
    asks="sensor, scale and offset of the volts",
    answers=(
        (
            "--channels",
            "time=1,accel=2:4",
            "--unit",
            "accel=g,time=ms",
            "--scale",
            "accel=10/3",
            "--offset",
            "accel=1.5",
        ),
    ),
)
def picoscope(path: Path, log: Log) -> None:
    save_rows(
        path,
        "Time,Channel A,Channel B,Channel C\n(ms),(V),(V),(V)\n\n",
        "%.8f,%.8f,%.8f,%.8f",
        log.time * 1e3,
        1.5 + 0.3 * log.accel_g,
    )


@layout(
    file="swift-gnss-20240501.sbp.json",
    source="Swift Navigation libsbp, sbp2json of MSG_IMU_RAW: a JSON a line with counts of a BMI160 and tow in ms",
    rate_hz=100,
    seconds=40,
    gyro_step=math.radians(1 / 262.4),
    accel_step=STANDARD_GRAVITY / 4096,
    asks="units and scale of the counts, and the unit of tow",
    answers=(
        ("--unit", "gyro=deg/s,accel=g,time=ms", "--scale", "gyro=10/2624,accel=1/4096"),
        (
            "--channels",
            "time=tow,accel_x=acc_x,accel_y=acc_y,accel_z=acc_z,gyro_x=gyr_x,gyro_y=gyr_y,gyro_z=gyr_z",
            "--unit",
            "gyro=deg/s,accel=g,time=ms",
            "--scale",
            "gyro=10/2624,accel=1/4096",
        ),
    ),
)
def swift_sbp2json(path: Path, log: Log) -> None:
    accel, gyro = whole(log.accel_g * 4096).tolist(), whole(log.gyro_deg * 262.4).tolist()
    lines = []
    for i, (a, g) in enumerate(zip(accel, gyro, strict=True)):
        names = {f"acc_{axis}": a["xyz".index(axis)] for axis in "xyz"}
        names |= {"crc": (i * 40_503) % 65_536}
        names |= {f"gyr_{axis}": g["xyz".index(axis)] for axis in "xyz"}
        names |= {
            "length": 17,
            "msg_type": 2304,
            "preamble": 85,
            "sender": 4096,
            "tow": 295_218_000 + 10 * i,
            "tow_f": 0,
        }
        lines.append(json.dumps(names, separators=(",", ":")))
    save_text(path, "\n".join(lines) + "\n")


@layout(
    file="punch.csv",
    source="Arduino Nano 33 BLE Sense, IMU_Capture.ino: 'aX,aY,aZ,gX,gY,gZ', a blank line after each 119 rows",
    rate_hz=119,
    seconds=60,
    gyro_step=math.radians(1e-3),
    accel_step=STANDARD_GRAVITY * 1e-3,
    asks="sampling rate and units",
    answers=(("--rate", "119", "--unit", "gyro=deg/s,accel=g"),),
)
def arduino_imu_capture(path: Path, log: Log) -> None:
    lines = ["aX,aY,aZ,gX,gY,gZ"]
    for i, values in enumerate(np.hstack([log.accel_g, log.gyro_deg]).tolist(), start=1):
        lines.append(",".join(f"{value:.3f}" for value in values))
        if i % 119 == 0:
            lines.append("")
    save_text(path, "\r\n".join(lines) + "\r\n")


@layout(
    file="2024-05-01-10-00-00_data.csv",
    source="Garmin FitCSVTool: 'Type,Local Number,Message,Field 1,Value 1,Units 1,…', 25 samples in a cell ('12|14|…')",
    rate_hz=25,
    seconds=120,
    channels=ACCEL,
    asks="several samples in a cell: not a table; a refusal is right too",
)
def garmin_fit_csv(path: Path, log: Log) -> None:
    names = ["Type", "Local Number", "Message"] + [
        f"{kind} {i}" for i in range(1, 7) for kind in ("Field", "Value", "Units")
    ]
    lines = [",".join(names), "Definition,3,accelerometer_data,timestamp,1,,timestamp_ms,1,,sample_time_offset,25,,"]
    offsets = "|".join(str(40 * i) for i in range(25))
    counts = whole(log.accel_g * 1e3)
    for second in range(len(counts) // 25):
        cells = ["|".join(map(str, axis)) for axis in counts[25 * second : 25 * second + 25].T.tolist()]
        fields = "".join(f',accel_{axis},"{cell}",counts' for axis, cell in zip("xyz", cells, strict=True))
        lines.append(
            f'Data,3,accelerometer_data,timestamp,"{1083492000 + second}",s,timestamp_ms,"0",ms,'
            f'sample_time_offset,"{offsets}",ms{fields}'
        )
    save_text(path, "\n".join(lines) + "\n")
