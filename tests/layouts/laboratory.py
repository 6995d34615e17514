"""Layouts of laboratory software, spreadsheets and databases."""

import math
from pathlib import Path

import numpy as np
from recording import EPOCH_S, GYRO, STANDARD_GRAVITY, Log, layout, save_rows, save_text, stamps, whole

MILLI_G = STANDARD_GRAVITY / 1000  # m/s²


@layout(
    file="gyro_bench_001.lvm",
    source="NI, specification of the LabVIEW measurement file (.lvm): tab-separated, X_Value, six channels, Comment",
    rate_hz=833,
    seconds=15,
)
def labview_lvm(path: Path, log: Log) -> None:
    n = len(log.time)
    names = [f"{sensor} {axis}" for sensor in ("Gyro", "Accel") for axis in "XYZ"]
    head = (
        "LabVIEW Measurement\t\r\nWriter_Version\t2\r\nReader_Version\t2\r\nSeparator\tTab\r\nDecimal_Separator\t.\r\n"
        "Multi_Headings\tNo\r\nX_Columns\tOne\r\nTime_Pref\tAbsolute\r\nOperator\tlab\r\nDate\t2024/05/01\r\n"
        "Time\t10:00:00.3337898254394531250\r\n***End_of_Header***\t\r\n\t\r\n"
        "Channels\t6\t\t\t\t\t\r\n"
        + "Samples"
        + f"\t{n}" * 6
        + "\r\nDate"
        + "\t2024/05/01" * 6
        + "\r\nTime"
        + "\t10:00:00.33" * 6
        + "\r\nY_Unit_Label"
        + "\tdeg/s" * 3
        + "\tm/s^2" * 3
        + "\r\nX_Dimension"
        + "\tTime" * 6
        + "\r\nX0"
        + "\t0.0000000000000000E+0" * 6
        + "\r\nDelta_X"
        + "\t1.2004801920768308E-3" * 6
        + "\r\n***End_of_Header***\t\t\t\t\t\t\r\nX_Value\t"
        + "\t".join(names)
        + "\tComment\r\n"
    )
    save_rows(path, head, "%.6f" + "\t%.6f" * 6, log.time, log.gyro_deg, log.accel, end="\r\n")


@layout(
    file="imu_table.csv",
    source="MATLAB documentation of writetable: variables with three columns become 'gyro_1,gyro_2,gyro_3'",
    rate_hz=250,
    seconds=50,
    asks="units, and which axis a number is",
    answers=(
        ("--unit", "gyro=rad/s,accel=m/s^2"),
        ("--unit", "gyro=rad/s,accel=m/s^2,time=s"),
        ("--channels", "time=1,gyro=2:4,accel=5:7", "--unit", "gyro=rad/s,accel=m/s^2,time=s"),
    ),
)
def matlab_writetable(path: Path, log: Log) -> None:
    save_rows(
        path,
        "t,gyro_1,gyro_2,gyro_3,accel_1,accel_2,accel_3\n",
        "%.15g,%.7g,%.7g,%.7g,%.7g,%.7g,%.7g",
        log.time,
        log.gyro,
        log.accel,
    )


@layout(
    file="frame_datetime_index.csv",
    source="pandas documentation of DataFrame.to_csv with a DatetimeIndex: a first column without a name, '+00:00'",
    rate_hz=100,
    seconds=80,
)
def pandas_datetime_index(path: Path, log: Log) -> None:
    times = [text.replace(".000000+", "+") for text in stamps(log.time, "{date} {clock}.{f}+00:00", digits=6)]
    save_rows(
        path,
        ",gyro_x_dps,gyro_y_dps,gyro_z_dps,acc_x_mps2,acc_y_mps2,acc_z_mps2\n",
        "%s,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f",
        times,
        log.gyro_deg,
        log.accel,
    )


@layout(
    file="frame_range_index.csv",
    source="pandas documentation of DataFrame.to_csv with a RangeIndex: a first column of row numbers without a name",
    rate_hz=104,
    seconds=80,
)
def pandas_range_index(path: Path, log: Log) -> None:
    save_rows(
        path,
        ",time [s],gyr_x [rad/s],gyr_y [rad/s],gyr_z [rad/s],acc_x [m/s²],acc_y [m/s²],acc_z [m/s²],temp [°C]\n",
        "%d,%.6f,%.7f,%.7f,%.7f,%.6f,%.6f,%.6f,24.5",
        np.arange(len(log.time)),
        log.time,
        log.gyro,
        log.accel,
    )


@layout(
    file="Messung_Drehrate.csv",
    source="Microsoft Excel, 'CSV UTF-8' with German regional settings: byte order mark, semicolons, decimal commas",
    rate_hz=100,
    seconds=80,
)
def excel_german(path: Path, log: Log) -> None:
    names = ["Zeit [s]"]
    names += [f"Drehrate {axis} [°/s]" for axis in "XYZ"] + [f"Beschleunigung {axis} [m/s²]" for axis in "XYZ"]
    save_rows(
        path,
        ";".join(names) + "\r\n",
        "%.3f;%.5f;%.5f;%.5f;%.5f;%.5f;%.5f",
        log.time,
        log.gyro_deg,
        log.accel,
        decimal=",",
        end="\r\n",
        encoding="utf-8-sig",
    )


@layout(
    file="imu_unicode.txt",
    source="Microsoft Excel, 'Unicode Text (*.txt)': UTF-16 with a byte order mark, tabs",
    rate_hz=100,
    seconds=50,
    gyro_step=math.radians(0.001),
)
def excel_unicode_text(path: Path, log: Log) -> None:
    names = ["Time (ms)", *(f"Gyro {axis} (mdps)" for axis in "XYZ"), *(f"Accel {axis} (mg)" for axis in "XYZ")]
    save_rows(
        path,
        "\t".join(names) + "\r\n",
        "%d\t%d\t%d\t%d\t%.2f\t%.2f\t%.2f",
        whole(log.time * 1e3),
        whole(log.gyro_deg * 1e3),
        log.accel_g * 1e3,
        end="\r\n",
        encoding="utf-16",
    )


@layout(
    file="influx_cli.csv",
    source="InfluxDB 1.x documentation, influx -execute 'select * from imu' -format csv: 'name,time,…', time in ns",
    rate_hz=100,
    seconds=80,
    asks="units of gyro and accelerometer",
    answers=(("--unit", "gyro=rad/s,accel=m/s^2"), ("--unit", "gyro=rad/s,accel=m/s^2,time=ns")),
)
def influx_cli(path: Path, log: Log) -> None:
    save_rows(
        path,
        "name,time,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z\n",
        "imu,%d,%.7g,%.7g,%.7g,%.7g,%.7g,%.7g",
        [EPOCH_S * 10**9 + round(moment * 1e6) * 1000 for moment in log.time.tolist()],
        log.accel,
        log.gyro,
    )


@layout(
    file="influx_pivot.csv",
    source="InfluxDB 2.x documentation, annotated CSV of a pivoted query: '#datatype,…', ',result,table,_time,…', RFC 3339",
    rate_hz=100,
    seconds=60,
)
def influx_annotated(path: Path, log: Log) -> None:
    fields = "acc_x_mps2,acc_y_mps2,acc_z_mps2,gyro_x_radps,gyro_y_radps,gyro_z_radps"
    head = (
        "#datatype,string,long,dateTime:RFC3339"
        + ",double" * 6
        + "\r\n#group,false,false,false"
        + ",false" * 6
        + "\r\n#default,_result"
        + "," * 8
        + f"\r\n,result,table,_time,{fields}\r\n"
    )
    times = [
        text.rstrip("0").rstrip(".") + "Z" if "." in text else text
        for text in stamps(log.time, "{date}T{clock}.{f}", digits=9)
    ]
    save_rows(path, head, ",,0,%s,%.7g,%.7g,%.7g,%.7g,%.7g,%.7g", times, log.accel, log.gyro, end="\r\n", tail="\r\n")


@layout(
    file="influx_long.csv.gz",
    source="InfluxDB 2.x documentation, annotated CSV without pivot: a row per value, its name in _field",
    rate_hz=50,
    seconds=60,
    channels=(),
    asks="one column of values for several channels: a refusal is right",
)
def influx_long(path: Path, log: Log) -> None:
    head = (
        "#datatype,string,long,dateTime:RFC3339,double,string,string\r\n#group,false,false,false,false,true,true\r\n"
        "#default,_result,,,,,\r\n,result,table,_time,_value,_field,_measurement\r\n"
    )
    times = stamps(log.time, "{date}T{clock}.{f}Z", digits=3)
    lines = []
    for table, (name, values) in enumerate(
        zip(
            ("acc_x", "acc_y", "acc_z", "gyro_x", "gyro_y", "gyro_z"),
            np.column_stack([log.accel, log.gyro]).T.tolist(),
            strict=True,
        )
    ):
        lines += [f",,{table},{time},{value:.7g},{name},imu" for time, value in zip(times, values, strict=True)]
    save_text(path, head + "\r\n".join(lines) + "\r\n")


@layout(
    file="no_time_no_rate.csv",
    source="CSV logs of SPI drivers, a row a data-ready interrupt: six named columns with units, and no time",
    rate_hz=250,
    seconds=60,
    asks="sampling rate",
    answers=(("--rate", "250"),),
)
def no_rate(path: Path, log: Log) -> None:
    save_rows(
        path,
        "gx_dps,gy_dps,gz_dps,ax_g,ay_g,az_g\n",
        "%.5f,%.5f,%.5f,%.6f,%.6f,%.6f",
        log.gyro_deg,
        log.accel_g,
    )


@layout(
    file="scope_analog_gyros.csv",
    source="Saleae Logic 2, CSV export of analog channels: 'Time [s],Channel 0,Channel 1,Channel 2' in volts",
    rate_hz=500,
    seconds=40,
    channels=GYRO,
    asks="sensor, scale and offset of the volts",
    answers=(
        (
            *("--channels", "time=1,gyro=2:4", "--unit", "gyro=deg/s,time=s"),
            *("--scale", "gyro=300.3003003", "--offset", "gyro=1.23"),
        ),
    ),
)
def saleae_analog(path: Path, log: Log) -> None:
    save_rows(
        path,
        "Time [s],Channel 0,Channel 1,Channel 2\n",
        "%.9f,%.6f,%.6f,%.6f",
        log.time,
        1.23 + 0.00333 * log.gyro_deg,
    )


@layout(
    file="unnamed_triples.dat",
    source="Two three-axis sensors without a header, a counter in the first column: nothing distinguishes them",
    rate_hz=100,
    seconds=60,
    asks="meaning, units and sampling rate",
    answers=(("--channels", "gyro=2:4,accel=5:7", "--rate", "100", "--unit", "gyro=deg/s,accel=m/s^2"),),
)
def unnamed_triples(path: Path, log: Log) -> None:
    save_rows(path, "", "%d %.5f %.5f %.5f %.5f %.5f %.5f", np.arange(len(log.time)), log.gyro_deg, log.accel)
