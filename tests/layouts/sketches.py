"""Layouts of sketches and small loggers."""

import json
import math
from pathlib import Path

import numpy as np
from recording import STANDARD_GRAVITY, Log, layout, save_rows, save_text, stamps, whole

MILLI_G = STANDARD_GRAVITY / 1000  # m/s²


@layout(
    file="serial_mpu6050_raw.txt",
    source="i2cdevlib, Arduino example MPU6050_raw: 'a/g:' and six counts with tabs, after messages of the start",
    rate_hz=100,
    seconds=90,
    gyro_step=math.radians(1 / 131),
    accel_step=STANDARD_GRAVITY / 16_384,
    asks="sampling rate, and unit and scale of the counts",
    answers=(
        (
            *("--channels", "accel=2:4,gyro=5:7", "--rate", "100", "--unit", "gyro=deg/s,accel=g"),
            *("--scale", "gyro=1/131,accel=1/16384"),
        ),
        (
            *("--channels", "accel=1:3,gyro=4:6", "--rate", "100", "--unit", "gyro=deg/s,accel=g"),
            *("--scale", "gyro=1/131,accel=1/16384"),
        ),
    ),
)
def arduino_mpu6050_raw(path: Path, log: Log) -> None:
    head = "Initializing I2C devices...\r\nTesting device connections...\r\nMPU6050 connection successful\r\n"
    save_rows(
        path,
        head,
        "a/g:\t%d\t%d\t%d\t%d\t%d\t%d",
        whole(log.accel_g * 16_384),
        whole(log.gyro_deg * 131),
        end="\r\n",
    )


@layout(
    file="nucleo_iks01a3.log",
    source="STM32duino X-NUCLEO-IKS01A3, example DataLogTerminal: '| Acc[mg]: … | Gyro[mdps]: … |'",
    rate_hz=104,
    seconds=80,
    gyro_step=math.radians(0.001),
    accel_step=MILLI_G,
    asks="sampling rate",
    answers=(("--rate", "104"),),
)
def stm32duino(path: Path, log: Log) -> None:
    save_rows(
        path,
        "",
        "| Acc[mg]: %d %d %d | Gyro[mdps]: %d %d %d |",
        whole(log.accel_g * 1e3),
        whole(log.gyro_deg * 1e3),
        end="\r\n",
    )


@layout(
    file="sensor_log.txt",
    source="MicroPython loggers of an MPU-6050: 'Timestamp(ms),AccX(g),AccY(g),AccZ(g),GyroX(d/s),GyroY(d/s),GyroZ(d/s)'",
    rate_hz=50,
    seconds=100,
)
def micropython(path: Path, log: Log) -> None:
    save_rows(
        path,
        "Timestamp(ms),AccX(g),AccY(g),AccZ(g),GyroX(d/s),GyroY(d/s),GyroZ(d/s)\n",
        "%d,%.4f,%.4f,%.4f,%.3f,%.3f,%.3f",
        whole(3021 + log.time * 1e3),
        log.accel_g,
        log.gyro_deg,
    )


@layout(
    file="motioncal_raw.txt",
    source="PJRC NXPMotionSense and MotionCal: 'Raw:' and nine counts (8192 per g, 16 per deg/s, 10 per µT)",
    rate_hz=100,
    seconds=60,
    gyro_step=math.radians(1 / 16),
    accel_step=STANDARD_GRAVITY / 8192,
    asks="meaning, sampling rate, unit and scale of the counts",
    answers=(
        (
            *("--channels", "accel=1:3,gyro=4:6", "--rate", "100", "--unit", "gyro=deg/s,accel=g"),
            *("--scale", "gyro=1/16,accel=1/8192"),
        ),
    ),
)
def teensy_motioncal(path: Path, log: Log) -> None:
    save_rows(
        path,
        "",
        "Raw:%d,%d,%d,%d,%d,%d,%d,%d,%d",
        whole(log.accel_g * 8192),
        whole(log.gyro_deg * 16),
        whole(log.fill(3, 400, 3)),
    )


@layout(
    file="esp32_imu.jsonl",
    source="ESP32 examples with ArduinoJson (serializeJson, a document a line): nested accel and gyro objects",
    rate_hz=100,
    seconds=80,
    asks="units of gyro and accelerometer",
    answers=(("--unit", "gyro=deg/s,accel=g"), ("--unit", "gyro=deg/s,accel=g,time=ms")),
)
def esp32_json_lines(path: Path, log: Log) -> None:
    lines = [
        json.dumps(
            {
                "ts_ms": 5012 + round(moment * 1e3),
                "accel": dict(zip("xyz", accel, strict=True)),
                "gyro": dict(zip("xyz", gyro, strict=True)),
            },
            separators=(",", ":"),
        )
        for moment, accel, gyro in zip(
            log.time.tolist(), np.round(log.accel_g, 5).tolist(), np.round(log.gyro_deg, 4).tolist(), strict=True
        )
    ]
    save_text(path, "\n".join(lines) + "\n")


@layout(
    file="mqtt_dump.jsonl",
    source="MQTT loggers (mosquitto_sub of a JSON topic): flat objects with the unit within the key",
    rate_hz=50,
    seconds=100,
)
def mqtt_json_lines(path: Path, log: Log) -> None:
    keys = ["gyro_x_dps", "gyro_y_dps", "gyro_z_dps", "accel_x_g", "accel_y_g", "accel_z_g"]
    values = np.column_stack([np.round(log.gyro_deg, 4), np.round(log.accel_g, 5)])
    lines = [
        json.dumps({"time_us": 71_002_344 + round(moment * 1e6), **dict(zip(keys, row, strict=True)), "dev": "imu-04"})
        for moment, row in zip(log.time.tolist(), values.tolist(), strict=True)
    ]
    save_text(path, "\n".join(lines) + "\n")


@layout(
    file="sense_hat.csv",
    source="Raspberry Pi Foundation, 'Sense HAT data logger': 'temp_h,temp_p,…,accel_x,…,gyro_x,gyro_y,gyro_z,timestamp'",
    rate_hz=25,
    seconds=120,
    asks="units of gyro and accelerometer",
    answers=(("--unit", "gyro=rad/s,accel=g"),),
)
def sense_hat(path: Path, log: Log) -> None:
    n = len(log.time)
    head = (
        "temp_h,temp_p,humidity,pressure,pitch,roll,yaw,mag_x,mag_y,mag_z,accel_x,accel_y,accel_z,gyro_x,gyro_y,gyro_z,"
        "timestamp\n"
    )
    ambient = np.column_stack(
        [
            31.5 + log.rng.normal(0, 0.05, n),
            30.2 + log.rng.normal(0, 0.05, n),
            41 + log.rng.normal(0, 0.1, n),
            1013.1 + log.rng.normal(0, 0.03, n),
        ]
    )
    save_rows(
        path,
        head,
        ",".join(["%.4f"] * 10 + ["%.8f"] * 6) + ",%s",
        ambient,
        log.fill(3, 180.0, 0.2),
        log.fill(3, 30.0, 0.3),
        log.accel_g,
        log.gyro,
        stamps(log.time + 1.3e-4 * log.rng.random(n), "{date} {clock}.{f}", digits=6),
    )


@layout(
    file="picoquake_D4E9.csv.gz",
    source="PicoQuake, docs/acquisition_data.md: comments ('# Config: data_rate = …'), 'count,a_x,a_y,a_z,g_x,g_y,g_z'",
    rate_hz=1000,
    seconds=30,
    asks="units, stated in the documentation only, and the sampling rate, stated only within a comment",
    answers=(("--rate", "1000", "--unit", "gyro=deg/s,accel=g"),),
)
def picoquake(path: Path, log: Log) -> None:
    head = (
        "# PLab PicoQuake Data\n# Time: 2024-05-01 10:00:00.333682, Device: D4E9 (E6632891E36F2029)\n"
        "# Num. samples: 30000, Duration: 30.0 s\n"
        "# Config: data_rate = 1000.0 Hz, filter = 250 Hz, acc_range = 4 g, gyro_range = 250.0 dps\n"
        "# Integrity: True, Skipped samples: 0\n\ncount,a_x,a_y,a_z,g_x,g_y,g_z\n"
    )
    save_rows(
        path,
        head,
        "%d,%.5f,%.5f,%.5f,%.4f,%.4f,%.4f",
        np.arange(1, len(log.time) + 1),
        log.accel_g,
        log.gyro_deg,
    )
