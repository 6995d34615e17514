"""Logs that were misread once, as their owners would run them: the right numbers, or a refusal that names the cause and the
next command, which is right.
"""

from __future__ import annotations

import json
import shlex
from dataclasses import dataclass, field
from typing import Any

import pytest

from sigmatau.cli import main
from sigmatau.units import to_si

SYMBOLS = {"gyro": "deg/sqrt(h)", "accel": "m/s/sqrt(h)"}
MADE: dict[str, tuple[float, float | None]] = {"gyro": (100.0, 0.300), "accel": (100.0, 0.0588)}
"""Rate [Hz] and random walk [deg/√h, m/s/√h] of the made records."""
ERRORS = 1.53
"""Half widths of a 95 % interval that are 3 standard errors."""


@dataclass(frozen=True, kw_only=True)
class Case:
    """Commands on a log, in the order in which a user gives them; the last one has the numbers or the verdict."""

    name: str
    commands: tuple[str, ...] = ("",)  # options of `analyze`; each but the last is refused (exit 2)
    named: tuple[tuple[str, ...], ...] = ()  # words that the message of each refusal has
    exit_code: int = 0
    sensors: dict[str, tuple[float, float | None]] = field(default_factory=lambda: MADE)  # {} for none
    axes: int = 3
    findings: tuple[str, ...] = ()  # codes that are there at the end
    no_findings: tuple[str, ...] = ()

    def __str__(self) -> str:
        return self.name


GYRO = {"gyro": MADE["gyro"]}
FALSE_OF_COUNTS = ("saturation", "interpolated", "stuck_samples")
PSINS = (
    "--channels gyro=1:3,accel=4:6 --rate 100 --input increments --unit gyro=arcsec,accel=m/s"
    " --scale gyro=0.1,accel=0.00122625"
)


def short(name: str, **expected: Any) -> tuple[Case, Case]:
    """A record too short to tell rest from motion, which the user then states."""
    return Case(name=name, exit_code=5, sensors={}), Case(name=name, commands=("--at-rest",), **expected)


CASES = (
    Case(
        name="two_imus_interleaved_bias.csv",
        commands=("--unit gyro=rad/s,accel=m/s^2,time=us", "--unit gyro=rad/s,accel=m/s^2,time=us --topic imu0"),
        named=(("'I'", "imu0", "imu1"),),
    ),
    Case(
        name="mux_gyro_accel_rows.csv",
        commands=("--channels time=4,gyro=6:8 --unit time=ms,gyro=rad/s",),
        sensors={"gyro": (200.0, 0.300)},
    ),
    Case(name="moving_phone_5s_xyz.csv", exit_code=5, sensors={}),
    *(
        Case(name="car_drive.csv", commands=(f"--unit time={unit},gyro=rad/s,accel=m/s^2",), exit_code=code, sensors={})
        for unit, code in (("s", 5), ("ms", 2), ("us", 2), ("ns", 2))
    ),
    Case(name="psins_quiet.imu", commands=(PSINS,), sensors={}, no_findings=FALSE_OF_COUNTS),
    Case(
        name="suggest_t_xyz.csv",
        commands=("", "--channels time=1,gyro=2:4 --unit time=s,gyro=rad/s"),
        named=(("--channels",),),
        sensors=GYRO,
    ),
    Case(
        name="suggest_zyx_epoch.csv",
        commands=("", "--channels time=1,gyro_x=5,gyro_y=4,gyro_z=3 --unit gyro=rad/s"),
        named=(("--channels",),),
        sensors=GYRO,
    ),
    Case(
        name="suggest_quat.csv",
        commands=("", "--channels time=1,gyro=6:8,accel=9:11 --unit time=s,gyro=rad/s,accel=m/s^2"),
        named=(("gyro=6:8,accel=9:11",),),
    ),
    Case(
        name="suggest_mag_between.csv",
        commands=("", "--channels time=1,accel=2:4,gyro=8:10 --unit time=s,gyro=rad/s,accel=m/s^2"),
        named=(("gyro=8:10",),),
    ),
    Case(
        name="mpu_accel_first.txt",
        commands=(
            "",
            "--channels time=1,accel=2:4,gyro=5:7 --unit time=ms,accel=g,gyro=deg/s --scale"
            " accel=0.00006103515625,gyro=0.007633587786259542",
        ),
        named=(("time=1,accel=2:4,gyro=5:7",),),
        sensors={"gyro": MADE["gyro"], "accel": (100.0, None)},  # its noise is not stated
    ),
    *short("kalibr_omega_alpha.csv"),
    Case(name="labview_comma.lvm", sensors={"gyro": (10.0, 0.02)}, axes=1),
    *short("xsens_mt_empty_columns.txt"),
    Case(
        name="arduino_arrow.txt",
        commands=("--channels accel=1:3,gyro=4:6 --unit accel=m/s^2,gyro=rad/s",),
    ),
    Case(name="clock_one_digit_hour.txt", exit_code=5, sensors={}),
    Case(name="clock_ampm.csv", sensors=GYRO),
    Case(name="clock_midnight.csv", sensors=GYRO),
    *short("plotjuggler_slash_dup.csv", sensors={"gyro": (400.0, 0.300), "accel": (400.0, 0.0588)}),
    Case(name="shimmer_units_row.csv"),
    # The stamps of a host, whose intervals scatter; the true rate and noise are not stated.
    Case(name="rostopic_zero_stamp.csv", sensors={}, findings=("host_stamps",)),
    Case(name="NumPy-.npz-SILENT-1389-log.npz", exit_code=5, sensors={}, findings=("unread_arrays",)),
    Case(name="CSV-SILENT-34-log.csv", exit_code=5, sensors={}, findings=("incomplete_sensor",)),
    Case(
        name="d435i_36s_two_topics.mcap",
        sensors={"gyro": (400.0, None), "accel": (200.0, None)},
    ),
)


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case.name} {case.commands[-1]}".strip())
def test_case(case, field_data, tmp_path, capsys):
    log = field_data / "cases" / case.name
    if not log.exists():
        pytest.skip(f"no field data: {log.name}")
    result = tmp_path / "result.json"
    for options, words in zip(case.commands[:-1], case.named, strict=True):
        assert main(["analyze", str(log), *shlex.split(options)]) == 2
        message = capsys.readouterr().err
        assert all(word in message for word in words), message
    code = main(["analyze", str(log), *shlex.split(case.commands[-1]), "--json", str(result)])
    said = capsys.readouterr()
    assert code == case.exit_code, said.err or said.out
    if code not in (0, 4, 5) or not result.exists():
        return
    stated = json.loads(result.read_text(encoding="utf-8"))
    codes = {finding["code"] for finding in stated["findings"]}
    assert set(case.findings) <= codes
    assert not codes & set(case.no_findings)
    if not case.sensors:
        return
    assert {channel.split("_")[0] for channel in stated["channels"]} == set(case.sensors)
    for sensor, (rate, walk) in case.sensors.items():
        channels = {name: channel for name, channel in stated["channels"].items() if name.startswith(sensor)}
        assert len(channels) == case.axes
        for name, channel in channels.items():
            assert channel["sample_rate_hz"] == pytest.approx(rate, rel=2e-3), name
            if walk is None:
                continue
            term = channel["fit"]["terms"]["random_walk"]
            truth = to_si(walk, SYMBOLS[sensor])
            assert abs(term["value"] - truth) <= ERRORS * (term["high"] - term["low"]) / 2, name
