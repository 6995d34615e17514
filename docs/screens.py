"""Write docs/screens.md: ``PYTHONPATH=python .venv/bin/python docs/screens.py``, where the field data are.

A page of what `sigmatau analyze` prints for real logs; tests/test_screens.py compares it.
"""

from __future__ import annotations

import contextlib
import io
import os
import shlex
import tempfile
from pathlib import Path

from sigmatau.cli import main

PAGE = Path(__file__).resolve().parent / "screens.md"
DATA = Path(os.environ.get("SIGMATAU_FIELD_DATA", PAGE.parents[2] / "shared" / "data"))

# Title, and command; {data} is the folder of the logs
SCREENS = (
    ("An industrial MEMS unit", "analyze adis16405_static.csv.gz --rate 100"),
    (
        "A MEMS module with lines of its supply",
        "analyze field/ch104.mat --rate 100 --channels gyro=4:6,accel=1:3 --unit gyro=deg/s,accel=g",
    ),
    (
        "A room with people",
        "analyze field/vn100_stationary.mat --channels time=1,gyro=11:13,accel=8:10 --unit time=us,gyro=rad/s,accel=m/s^2",
    ),
    ("Two minutes", "analyze field/xdot_1.csv.gz --unit gyro=deg/s,accel=m/s^2,time=s"),
    ("Two minutes of another unit", "analyze field/xdot_2.csv.gz --unit gyro=deg/s,accel=m/s^2,time=s"),
    (
        "Turned by hand",
        "analyze field/many_positions.log --channels accel=1:3,gyro=4:6 --rate 100 --unit accel=m/s^2,gyro=rad/s",
    ),
    ("In flight", "analyze field/dataflash_171.bin --topic IMU"),
    ("Held in a hand", "analyze field/moving_1khz.csv.gz"),
)
DEMO = "analyze demo/static.csv"


def screen(command: str, folder: Path) -> str:
    """What a command prints in a folder, in 80 columns."""
    out, before = io.StringIO(), Path.cwd()
    os.environ["COLUMNS"] = "80"
    os.chdir(folder)
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(out):
            main(shlex.split(command))
    finally:
        os.chdir(before)
    return out.getvalue()


def block(title: str, command: str, text: str) -> str:
    """A section of the page."""
    return f"## {title}\n\n```text\n$ sigmatau {command.replace('field/', '')}\n{text}```\n"


def page() -> str:
    """The whole page."""
    with tempfile.TemporaryDirectory() as folder:
        screen("demo --output demo", Path(folder))
        demo = block("The demo: a simulated tactical-grade unit", DEMO, screen(DEMO, Path(folder)))
    sections = [block(title, command, screen(command, DATA)) for title, command in SCREENS]
    return "\n".join([_HEAD, demo, *sections])


_HEAD = """# Screens

What `sigmatau analyze` prints in a terminal of 80 columns, for the demo and for real logs of others. A line on the
record, a row an axis, at most five findings that matter, and what comes next. A terminal with more lines shows the
curves too. `!!` is an error, `!` a warning, `·` a remark; [findings](findings.md) explains each. Made by
`docs/screens.py`.
"""


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
