"""Errors and findings as wide as the terminal: no line is wider, and no command or path is divided."""

import os
import pty
import re
import subprocess
import sys

import pytest

from sigmatau.cli.messages import wrap_message

CONTRADICTION = (
    "sigmatau: shift-1/log.csv: the time stamps in column 'time [s]' give 200 Hz, which contradicts --rate 400. For 200 Hz,"
    " omit --rate and add --unit time=s; for 400 Hz, add --channels time=none"
)
COLUMNS = (
    "sigmatau: log.csv: has no column names; gravity (9.807) is in columns 5 to 7: run with --channels"
    " time=1,gyro=2:4,accel=5:7 --unit accel=g --scale accel=0.0001 gyro=0.02"
)
UNITS = (
    "sigmatau: log.csv: does not state the unit of gyro_x, gyro_y, gyro_z; give e.g. --unit gyro=deg/s --rate HZ (gyro noise"
    " 0.0012 deg/s rms) or --unit gyro=rad/s --rate HZ (gyro noise 0.071 deg/s rms). The values do not show which; see the"
    " manual of the sensor"
)
ACTION = (
    "  -> Give the unit of the accelerometer with --unit accel=g; or remove the column with --channels gyro=2:4 time=1"
)
PROGRAM = "sigmatau: is Parquet, which needs a library that is not installed: pip install 'sigmatau[parquet]'"
COMMANDS = {
    CONTRADICTION: ["--rate 400.", "--unit time=s;", "--channels time=none"],
    COLUMNS: ["--channels time=1,gyro=2:4,accel=5:7", "--unit accel=g", "--scale accel=0.0001 gyro=0.02"],
    UNITS: ["--unit gyro=deg/s --rate HZ", "--unit gyro=rad/s --rate HZ"],
    ACTION: ["--unit accel=g;", "--channels gyro=2:4 time=1"],
    PROGRAM: ["pip install"],
}


@pytest.mark.parametrize("message", COMMANDS)
@pytest.mark.parametrize("width", [50, 60, 72, 80, 100, 200])
def test_lines_fit_and_commands_are_whole(message, width):
    lines = wrap_message(message, width)
    assert max(map(len, lines)) <= width
    assert " ".join(line.strip() for line in lines) == message.strip()
    assert lines[0].startswith(message[:4])
    indent = "     " if message is ACTION else "  "
    assert all(line.startswith(indent) and line[len(indent)] != " " for line in lines[1:])
    for command in COMMANDS[message]:
        assert any(command in line for line in lines), lines


def test_a_command_in_one_line_if_it_fits():
    options = COLUMNS.partition("run with ")[2]
    assert f"  {options}" in wrap_message(COLUMNS, 2 + len(options))
    assert f"  {options}" not in wrap_message(COLUMNS, 1 + len(options))


def test_a_path_wider_than_the_terminal_is_not_divided():
    path = "/data/" + "a-long-name/" * 12 + "log.csv"
    lines = wrap_message(f"sigmatau: {path}: there is no such file", 60)
    assert lines == [f"sigmatau: {path}:", "  there is no such file"]


def shown(*words, columns):
    """What a command prints on a terminal as standard error."""
    leader, follower = pty.openpty()
    environment = {**os.environ, "COLUMNS": str(columns)}
    done = subprocess.run(
        [sys.executable, "-m", "sigmatau", *words],
        stdout=subprocess.DEVNULL,
        stderr=follower,
        env=environment,
        check=False,
    )
    os.close(follower)
    text = b""
    while True:
        try:
            part = os.read(leader, 4096)
        except OSError:  # Linux: no writer is left
            break
        if not part:
            break
        text += part
    os.close(leader)
    return done.returncode, re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", text.decode()).replace("\r\n", "\n")


def test_on_a_terminal_and_in_a_pipe(tmp_path):
    log = tmp_path / "log.csv"
    log.write_text("t [s],gyro_x\n" + "".join(f"{k / 100},{k % 7}.5\n" for k in range(200)))
    code, text = shown("analyze", str(log), columns=70)
    assert "sigmatau: " in text, text
    message = text[text.index("sigmatau: ") :].rstrip("\n")
    assert code == 2
    assert max(len(line) for line in message.split("\n") if str(log) not in line) <= 70
    done = subprocess.run(
        [sys.executable, "-m", "sigmatau", "analyze", str(log)], capture_output=True, text=True, check=False
    )
    assert done.stderr.count("\n") == 1
    assert " ".join(message.split()) == done.stderr.strip()
