"""A fourth set of layouts, read once before any correction: ``python tests/layouts/run.py --module untried``."""

import itertools
import json
import math
from pathlib import Path

import numpy as np
from recording import ACCEL, EPOCH_S, GYRO, STANDARD_GRAVITY, Log, layout, save_rows, save_text, stamps, whole


@layout(
    file="serialLog00012.TXT",
    source="SparkFun ICM-20948 library, Example1_Basics: 'Scaled. Acc (mg) [ … ], Gyr (DPS) [ … ], Mag (uT) [ … ], …'",
    rate_hz=32,
    seconds=150,
    gyro_step=math.radians(0.01),
    accel_step=STANDARD_GRAVITY * 1e-5,
    asks="sampling rate",
    answers=(("--rate", "32"),),
)
def sparkfun_icm20948(path: Path, log: Log) -> None:
    def padded(values: np.ndarray) -> list[str]:
        return [("-" if value < 0 else " ") + f"{abs(value):08.2f}" for value in values]

    lines = ["Initialization of the sensor returned: All is well."]
    rows = zip(log.accel_g * 1e3, log.gyro_deg, log.fill(3, 40.0, 0.3), log.fill(1, 25.8, 0.05), strict=True)
    for accel, gyro, field, warmth in rows:
        cells = [", ".join(padded(values)) for values in (accel, gyro, field, warmth)]
        lines.append("Scaled. Acc (mg) [ {} ], Gyr (DPS) [ {} ], Mag (uT) [ {} ], Tmp (C) [ {} ]".format(*cells))
    save_text(path, "\r\n".join(lines) + "\r\n")


@layout(
    file="putty.log",
    source="Adafruit MPU6050 library, basic_readings: 'Acceleration X: …, Y: …, Z: … m/s^2', 'Rotation X: …'",
    rate_hz=100,
    seconds=60,
    gyro_step=1e-4,
    accel_step=1e-3,
    asks="sampling rate",
    answers=(("--rate", "100"),),
)
def adafruit_mpu6050(path: Path, log: Log) -> None:
    lines = [
        "=~=~=~=~=~=~=~=~=~=~=~= PuTTY log 2024.05.01 10:00:00 =~=~=~=~=~=~=~=~=~=~=~=",
        "Adafruit MPU6050 test!",
        "MPU6050 Found!",
        "Accelerometer range set to: +-8G",
        "Gyro range set to: +- 500 deg/s",
        "Filter bandwidth set to: 21 Hz",
        "",
    ]
    for accel, gyro in zip(log.accel.tolist(), log.gyro.tolist(), strict=True):
        lines += [
            "Acceleration X: {:.3f}, Y: {:.3f}, Z: {:.3f} m/s^2".format(*accel),
            "Rotation X: {:.4f}, Y: {:.4f}, Z: {:.4f} rad/s".format(*gyro),
            "Temperature: 24.37 degC",
            "",
        ]
    save_text(path, "\r\n".join(lines) + "\r\n")


@layout(
    file="Polar_Sense_B3D4A21E_20240501_100000_GYRO.txt",
    source="Polar Sensor Logger: 'Phone timestamp;sensor timestamp [ns];X [dps];Y [dps];Z [dps]', ns since 2000",
    rate_hz=52,
    seconds=120,
    channels=GYRO,
    gyro_step=math.radians(1e-5),
)
def polar_sensor_logger(path: Path, log: Log) -> None:
    since_2000 = 767_872_800 * 10**9 + whole(log.time * 1e9)
    save_rows(
        path,
        "Phone timestamp;sensor timestamp [ns];X [dps];Y [dps];Z [dps]\n",
        "%s;%d;%.5f;%.5f;%.5f",
        stamps(log.time, "{date}T{clock}.{f}", digits=3),
        since_2000,
        log.gyro_deg,
    )


@layout(
    file="recording_1588340120.csv",
    source="FHWS SensorReadout for Android, README: 'nanoseconds;EventId;x;y;z', a number for each kind (0, 1, 2, 3, 12)",
    rate_hz=200,
    seconds=30,
    channels=(),
    asks="several kinds of rows, each with a number that only the program's source explains: a refusal is right",
)
def sensor_readout(path: Path, log: Log) -> None:
    nanoseconds = 51_272_330 + whole(log.time * 1e9)
    field = log.fill(3, 30.0, 0.3)
    lines = ["0;-2;Wed May 01 10:00:00 GMT+02:00 2024;Pixel;FHWS", "0;50;STANDING;1"]
    for i, (t, accel, gyro) in enumerate(zip(nanoseconds.tolist(), log.accel.tolist(), log.gyro.tolist(), strict=True)):
        lines += [f"{t};0;" + ";".join(f"{v:.7g}" for v in accel), f"{t};3;" + ";".join(f"{v:.7g}" for v in gyro)]
        if i % 2:
            lines += [f"{t};1;0.0311;0.0482;9.8058", f"{t};12;0.19077;-0.15619;-0.64937;0.71935"]
        if i % 4 == 3:
            lines.append(f"{t};5;" + ";".join(f"{v:.2f}" for v in field[i]))
    save_text(path, "\n".join(lines) + "\n")


@layout(
    file="1714557600123.csv",
    source="Sensei for Android, README: 'Acceleration Sensor;epoch ms;ns;[x, y, z]', rows of several kinds, no header",
    rate_hz=100,
    seconds=40,
    asks="units of gyro and accelerometer",
    answers=(
        ("--unit", "gyro=rad/s,accel=m/s^2"),
        ("--unit", "gyro=rad/s,accel=m/s^2,time=ns"),
        ("--channels", "time=3", "--unit", "gyro=rad/s,accel=m/s^2,time=ns"),
    ),
)
def sensei(path: Path, log: Log) -> None:
    lines = []
    nanoseconds = 9_643_789_614_727 + whole(log.time * 1e9)
    field = log.fill(3, 30.0, 0.3)
    rows = zip(nanoseconds.tolist(), log.accel.tolist(), log.gyro.tolist(), field.tolist(), strict=True)
    for i, (t, accel, gyro, magnetic) in enumerate(rows):
        clock = EPOCH_S * 1000 + 10 * i
        lines.append(f"Acceleration Sensor;{clock};{t};[" + ", ".join(f"{v:.7g}" for v in accel) + "]")
        lines.append(f"Gyroscope Sensor;{clock};{t};[" + ", ".join(f"{v:.7g}" for v in gyro) + "]")
        if i % 2:
            lines.append(f"Magnetic Sensor;{clock};{t};[" + ", ".join(f"{v:.7g}" for v in magnetic) + "]")
    save_text(path, "\n".join(lines) + "\n")


@layout(
    file="CR6_IMU.dat",
    source="Campbell Scientific LoggerNet manual, TOA5: four lines ('TOA5', names, units, processing), quoted date and time",
    rate_hz=100,
    seconds=50,
    gyro_step=math.radians(1e-5),
    accel_step=STANDARD_GRAVITY * 1e-6,
)
def campbell_toa5(path: Path, log: Log) -> None:
    names = [f"{kind}_{axis}" for kind in ("Accel", "Gyro") for axis in "XYZ"]
    head = (
        '"TOA5","roof","CR6","7423","CR6.Std.12.01","CPU:imu.CR6","40671","Fast"\r\n'
        + ",".join(f'"{name}"' for name in ("TIMESTAMP", "RECORD", *names, "PTemp"))
        + '\r\n"TS","RN","g","g","g","deg/s","deg/s","deg/s","Deg C"\r\n'
        + '"","","Smp","Smp","Smp","Smp","Smp","Smp","Smp"\r\n'
    )
    clock = [text.rstrip("0").rstrip(".") for text in stamps(log.time, "{date} {clock}.{f}", digits=2)]
    clock = [text if len(text) >= 19 else text.ljust(19, "0") for text in clock]
    save_rows(
        path,
        head,
        '"%s",%d' + ",%.6f" * 3 + ",%.5f" * 3 + ",%.2f",
        clock,
        np.arange(len(clock)),
        log.accel_g,
        log.gyro_deg,
        log.fill(1, 24.9, 0.01),
        end="\r\n",
    )


@layout(
    file="OpenBCI-RAW-2024-05-01_10-00-00.txt",
    source="OpenBCI GUI, raw data (.txt): '%' comments, 'Sample Index, EXG Channel 0, …, Accel Channel 0, …, Timestamp, …'",
    rate_hz=200,
    seconds=35,
    channels=ACCEL,
    asks="unit of the accelerometer",
    answers=(("--unit", "accel=g"),),
)
def openbci_ganglion(path: Path, log: Log) -> None:
    n = len(log.time)
    head = (
        "%OpenBCI Raw EXG Data\n%Number of channels = 4\n%Sample Rate = 200 Hz\n%Board = OpenBCI_GUI$BoardGanglionBLE\n"
        "Sample Index, EXG Channel 0, EXG Channel 1, EXG Channel 2, EXG Channel 3, Accel Channel 0, Accel Channel 1, "
        "Accel Channel 2, Other, Timestamp, Other, Timestamp (Formatted)\n"
    )
    save_rows(
        path,
        head,
        "%.1f" + ", %.6f" * 7 + ", 0.0, %.6f, 0.0, %s",
        np.arange(n) % 256,
        log.rng.normal(0, 12.0, (n, 4)),
        log.accel_g,
        EPOCH_S + log.time,
        stamps(log.time, "{date} {clock}.{f}", digits=3),
    )


@layout(
    file="imu_output.txt",
    source="CARLA simulator, printed data: 'IMUMeasurement(frame=…, timestamp=…, accelerometer=Vector3D(x=…, …), …)'",
    rate_hz=100,
    seconds=40,
    accel_step=1e-6,
    gyro_step=1e-6,
    asks="units of gyro and accelerometer",
    answers=(("--unit", "gyro=rad/s,accel=m/s^2"),),
)
def carla_imu(path: Path, log: Log) -> None:
    lines = []
    for i, (t, accel, gyro) in enumerate(zip(log.time.tolist(), log.accel.tolist(), log.gyro.tolist(), strict=True)):
        lines.append(
            f"IMUMeasurement(frame={339_878 + i}, timestamp={1424.411637 + t:f}, "
            "accelerometer=Vector3D(x={:f}, y={:f}, z={:f}), ".format(*accel)
            + "gyroscope=Vector3D(x={:f}, y={:f}, z={:f}), compass=4.717627)".format(*gyro)
        )
    save_text(path, "\n".join(lines) + "\n")


@layout(
    file="mav.txt",
    source="pymavlink mavlogdump.py without --format: '2024-05-01 10:00:00.32: RAW_IMU {time_usec : …, …}' among others",
    rate_hz=50,
    seconds=80,
    gyro_step=1e-3,
    accel_step=STANDARD_GRAVITY * 1e-3,
    asks="units of gyro and accelerometer",
    answers=(
        ("--unit", "gyro=mrad/s,accel=mg"),
        ("--unit", "gyro=rad/s,accel=mg", "--scale", "gyro=0.001"),
        ("--unit", "gyro=rad/s,accel=g", "--scale", "gyro=0.001,accel=0.001"),
    ),
)
def mavlogdump_text(path: Path, log: Log) -> None:
    accel, gyro = whole(log.accel_g * 1e3).tolist(), whole(log.gyro * 1e3).tolist()
    clock = stamps(log.time, "{date} {clock}.{f}", digits=2)
    lines = []
    for i, (t, a, g) in enumerate(zip(clock, accel, gyro, strict=True)):
        lines.append(
            f"{t}: RAW_IMU {{time_usec : {92_575_068 + 20_000 * i}, xacc : {a[0]}, yacc : {a[1]}, zacc : {a[2]}, "
            f"xgyro : {g[0]}, ygyro : {g[1]}, zgyro : {g[2]}, xmag : 289, ymag : -95, zmag : 224, id : 0, "
            "temperature : 3369}"
        )
        if i % 5 == 0:
            lines.append(
                f"{t}: ATTITUDE {{time_boot_ms : {92_575 + 20 * i}, roll : 0.0143, pitch : -0.0021, yaw : 1.5121, "
                "rollspeed : 0.0012, pitchspeed : -0.0007, yawspeed : 0.0002}"
            )
        if i % 50 == 0:
            lines.append(
                f"{t}: HEARTBEAT {{type : 2, autopilot : 3, base_mode : 81, custom_mode : 0, system_status : 3, "
                "mavlink_version : 3}"
            )
    save_text(path, "\n".join(lines) + "\n")


@layout(
    file="xsens_imu.csv",
    source="MulRan and KAIST Complex Urban, file player: ns, quaternion, Euler angles, gyro, acceleration, field; a car",
    rate_hz=100,
    seconds=45,
    motion="drive",
    asks="meaning and units of the columns",
    answers=(("--channels", "time=1,gyro=9:11,accel=12:14", "--unit", "gyro=rad/s,accel=m/s^2"),),
)
def mulran_xsens(path: Path, log: Log) -> None:
    n = len(log.time)
    save_rows(
        path,
        "",
        "%d" + ",%.6f" * 16,
        1_561_000_444_390_857_630 + whole(log.time * 1e9),
        np.tile([0.0123, -0.0049, 0.7031, 0.7109], (n, 1)),
        np.tile([0.7, -0.4, 89.4], (n, 1)),
        log.gyro,
        log.accel,
        log.fill(3, 0.4, 0.003),
    )


@layout(
    file="bosch.log",
    source="TEX-CUP data set, imu.txt: week, whole seconds and fraction of a second, specific force in m/s², rate in deg/s",
    rate_hz=150,
    seconds=40,
    asks="meaning and units of the columns",
    answers=(
        ("--channels", "accel=4:6,gyro=7:9", "--rate", "150", "--unit", "gyro=deg/s,accel=m/s^2"),
        ("--channels", "time=2,accel=4:6,gyro=7:9", "--unit", "gyro=deg/s,accel=m/s^2"),
    ),
)
def tex_cup(path: Path, log: Log) -> None:
    seconds = 403_218.25 + log.time
    save_rows(
        path,
        "",
        "%5d %7d %17.15f" + " %13.9f" * 6,
        np.full(len(log.time), 2051),
        np.floor(seconds).astype(int),
        seconds % 1,
        log.accel,
        log.gyro_deg,
    )


@layout(
    file="00000042-IMU.csv",
    source="ArduPilot Mission Planner, a log saved as CSV: ',Timestamp,,TimeUS,I,GyrX,…', row numbers and 'mm:ss.s'",
    rate_hz=50,
    seconds=100,
    asks="units of gyro and accelerometer, and unit of time",
    answers=(
        ("--unit", "gyro=rad/s,accel=m/s^2"),
        ("--unit", "gyro=rad/s,accel=m/s^2,time=us"),
        ("--channels", "time=4", "--unit", "gyro=rad/s,accel=m/s^2,time=us"),
    ),
)
def mission_planner(path: Path, log: Log) -> None:
    n = len(log.time)
    clock = [f"{int(25 + t // 60):02d}:{t % 60:04.1f}" for t in log.time.tolist()]
    save_rows(
        path,
        ",Timestamp,,TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,EG,EA,T,GH,AH,GHz,AHz\n",
        "%d,%s,IMU,%d,0" + ",%.7g" * 6 + ",0,0,28.82777,1,1,1000,1000",
        1933 + 7 * np.arange(n),
        clock,
        65_645_398 + whole(log.time * 1e6),
        log.gyro,
        log.accel,
    )


@layout(
    file="IMU-20240501T10-00-00.csv",
    source="Bitcraze Crazyflie client, log block to CSV: 'Timestamp,acc.x,acc.y,acc.z,gyro.x,gyro.y,gyro.z', ms",
    rate_hz=100,
    seconds=60,
    asks="units of gyro, accelerometer and time",
    answers=(
        ("--unit", "gyro=deg/s,accel=g"),
        ("--unit", "gyro=deg/s,accel=g,time=ms"),
    ),
)
def crazyflie(path: Path, log: Log) -> None:
    save_rows(
        path,
        "Timestamp,acc.x,acc.y,acc.z,gyro.x,gyro.y,gyro.z\n",
        "%d" + ",%.9g" * 6,
        48_310 + whole(log.time * 1e3),
        log.accel_g,
        log.gyro_deg,
    )


@layout(
    file="imu.arff",
    source="Weka documentation, ARFF: '@relation', '@attribute NAME numeric', '@data', values with commas",
    rate_hz=100,
    seconds=50,
)
def weka_arff(path: Path, log: Log) -> None:
    names = ["time_s", *(f"gyro_{axis}_rad_s" for axis in "xyz"), *(f"acc_{axis}_m_s2" for axis in "xyz")]
    head = "% wrist, still on a table\n@relation imu\n\n" + "".join(f"@attribute {name} numeric\n" for name in names)
    head += "@attribute activity {lying,sitting,walking}\n\n@data\n"
    save_rows(path, head, "%.2f" + ",%.6f" * 6 + ",lying", log.time, log.gyro, log.accel)


@layout(
    file="imu.txt",
    source="R documentation of write.table with its defaults: quoted names, and row names without a name",
    rate_hz=100,
    seconds=50,
    gyro_step=math.radians(1e-6),
    accel_step=1e-6,
)
def r_write_table(path: Path, log: Log) -> None:
    names = ["time.s", *(f"gyro_{axis}.deg.s" for axis in "xyz"), *(f"acc_{axis}.m.s2" for axis in "xyz")]
    save_rows(
        path,
        " ".join(f'"{name}"' for name in names) + "\n",
        '"%d" %.7g' + " %.6f" * 6,
        np.arange(1, len(log.time) + 1),
        log.time,
        log.gyro_deg,
        log.accel,
    )


@layout(
    file="imu.out",
    source="PostgreSQL documentation of psql, aligned format: ' t | gx | …', a line '---+---', and '(5000 rows)' at the end",
    rate_hz=100,
    seconds=50,
    accel_step=1e-6,
    gyro_step=1e-6,
)
def psql_aligned(path: Path, log: Log) -> None:
    names = ["ts", *(f"gyro_{axis}_rad_s" for axis in "xyz"), *(f"acc_{axis}_m_s2" for axis in "xyz")]
    head = " " * 11 + "ts" + " " * 11 + " | " + " | ".join(name.center(14) for name in names[1:])
    head += "\n" + "+".join(["-" * 26] + ["-" * 16] * 6) + "\n"
    save_rows(
        path,
        head,
        " %-24s" + " | %14.6f" * 6,
        [text.rstrip("0").rstrip(".") for text in stamps(log.time, "{date} {clock}.{f}", digits=2)],
        log.gyro,
        log.accel,
        tail="(5000 rows)\n\n",
    )


@layout(
    file="imu_topic.txt",
    source="Gazebo documentation, gz topic --echo of gz.msgs.IMU: protocol buffers as text, 'angular_velocity { x: … }'",
    rate_hz=50,
    seconds=28,
)
def gazebo_echo(path: Path, log: Log) -> None:
    lines = []
    for t, accel, gyro in zip(log.time.tolist(), log.accel.tolist(), log.gyro.tolist(), strict=True):
        second, nanosecond = divmod(round(t * 1e9) + 4_000_000, 10**9)
        lines += ["header {", "  stamp {", *([f"    sec: {second}"] if second else [])]
        lines += [*([f"    nsec: {nanosecond}"] if nanosecond else []), "  }", "  data {", '    key: "seq"']
        lines += [f'    value: "{round(t * 50)}"', "  }", "}", 'entity_name: "car::link::imu"', "orientation {"]
        lines += [
            "  w: 1",
            "}",
            "angular_velocity {",
            *(f"  {a}: {v:.17g}" for a, v in zip("xyz", gyro, strict=True)),
            "}",
        ]
        lines += ["linear_acceleration {", *(f"  {a}: {v:.17g}" for a, v in zip("xyz", accel, strict=True)), "}", ""]
    save_text(path, "\n".join(lines) + "\n")


@layout(
    file="imu.mat",
    source="GNU Octave manual, save in its text format: '# name: imu', '# type: matrix', '# rows: …', values with blanks",
    rate_hz=100,
    seconds=50,
    asks="meaning and units of the columns",
    answers=(("--channels", "time=1,gyro=2:4,accel=5:7", "--unit", "gyro=rad/s,accel=m/s^2,time=s"),),
)
def octave_text(path: Path, log: Log) -> None:
    head = (
        "# Created by Octave 8.4.0, Wed May 01 10:00:00 2024 UTC <user@host>\n"
        f"# name: imu\n# type: matrix\n# rows: {len(log.time)}\n# columns: 7\n"
    )
    save_rows(path, head, " %.4g" + " %.9g" * 6, log.time, log.gyro, log.accel, tail="\n\n")


@layout(
    file="CASE1.DAT",
    source="Fortran list output with a D exponent and fixed width, names in a first line: 'TIME(S)  WX(DEG/S)  …  AX(G)'",
    rate_hz=100,
    seconds=50,
    gyro_step=math.radians(1e-7),
    accel_step=STANDARD_GRAVITY * 1e-7,
)
def fortran_exponents(path: Path, log: Log) -> None:
    names = ["TIME(S)", *(f"W{axis}(DEG/S)" for axis in "XYZ"), *(f"A{axis}(G)" for axis in "XYZ")]
    lines = ["".join(name.rjust(16) for name in names)]
    rows = np.column_stack([log.time, log.gyro_deg, log.accel_g]).tolist()
    lines += ["".join(f"{value:16.7E}" for value in row).replace("E", "D") for row in rows]
    save_text(path, "\n".join(lines) + "\n")


@layout(
    file="sensors.jsonl",
    source="SensorServer for Android, README: '{values:[x,y,z],timestamp:ns,accuracy:3,type:android.sensor.gyroscope}'",
    rate_hz=100,
    seconds=25,
    asks="units of gyro and accelerometer, and which of the kinds of documents is which",
    answers=(
        ("--unit", "gyro=rad/s,accel=m/s^2"),
        ("--unit", "gyro=rad/s,accel=m/s^2,time=ns"),
    ),
)
def sensor_server(path: Path, log: Log) -> None:
    lines = []
    nanoseconds = (1_238_531_440_319_498 + whole(log.time * 1e9)).tolist()
    kinds = (("accelerometer", log.accel), ("gyroscope", log.gyro), ("magnetic_field", log.fill(3, 30.0, 0.3)))
    for i, (kind, values) in itertools.product(range(len(nanoseconds)), kinds):
        document = {
            "values": [round(value, 8) for value in values[i].tolist()],
            "timestamp": nanoseconds[i],
            "accuracy": 3,
            "type": f"android.sensor.{kind}",
        }
        lines.append(json.dumps(document, separators=(",", ":")))
    save_text(path, "\n".join(lines) + "\n")
