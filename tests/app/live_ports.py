"""Simulated serial ports, and workbenches that record them."""

import contextlib
import functools
import os
import time
from unittest.mock import patch

import numpy as np
from workbench_served import Page, serving

from known import seed_of
from sigmatau.app.files import Roots
from sigmatau.app.log import LiveSource
from sigmatau.app.recording import Recording
from sigmatau.app.routes import Workbench
from sigmatau.app.workers import Workers

TABLE = {"rate": "100", "unit": "gyro=rad/s", "channels": "gyro=1:3"}
WORDS = ["--rate", "100", "--unit", "gyro=rad/s", "--channels", "gyro=1:3"]


def lines(count):
    """What an Arduino prints: three numbers a line."""
    rows = np.random.default_rng(seed_of("live view")).standard_normal((count, 3)) * 1e-3
    return [f"{a:.6f},{b:.6f},{c:.6f}\r\n".encode() for a, b, c in rows]


def noise():
    """What arrives at a wrong speed: bytes of any value."""
    return np.random.default_rng(seed_of("wrong speed")).integers(0, 256, 30_000, dtype=np.uint8).tobytes()


class Port:
    """A simulated serial port, and the record of what is written to it."""

    def __init__(self, folder):
        import pty
        import tty

        self.master, self.terminal = pty.openpty()
        tty.setraw(self.terminal)
        self.name = os.ttyname(self.terminal)
        self.saved = folder / "saved.csv"

    def recording(self, **changes):
        stated = {
            "baud": 115200,
            "save": str(self.saved),
            "table": TABLE,
            "at_rest": False,
            "command": "sigmatau watch",
        }
        made = Recording(LiveSource(source=self.name, **(stated | changes)))
        self.begin()
        return made

    def begin(self):
        """What arrives first is a part of a line."""
        os.write(self.master, b"1,0.0\r\n")

    def unplug(self):
        """The device is gone once what it wrote was read."""
        time.sleep(0.5)
        os.close(self.terminal)
        os.close(self.master)

    def write(self, rows):
        for start in range(0, len(rows), 100):
            os.write(self.master, b"".join(rows[start : start + 100]))


class LastingWorkers(Workers):
    """Workers of all workbenches of this process, because each takes a second to start; they end with the process."""

    def close(self):
        """They go on."""


_lasting_workers = functools.cache(LastingWorkers)


@contextlib.contextmanager
def recorded(port, **changes):
    """A client of a workbench that records the port."""
    with served(port, port.recording(**changes)) as page:
        yield page


@contextlib.contextmanager
def served(port, recording=None):
    """A client of a workbench with the folder of the port's log."""
    with patch("sigmatau.app.routes.Workers", _lasting_workers):
        workbench = Workbench(Roots([port.saved.parent, port.saved]), max_upload=10**6, recording=recording)
    try:
        with serving(workbench) as asking:
            page = Page(asking, port.saved)
            page.recording = workbench.recording
            yield page
    finally:
        workbench.close()


def waited(page, is_wanted):
    """The state of the record once it is the wanted one."""
    end = time.monotonic() + 60
    while not is_wanted(state := page.get("api/live").json()):
        assert time.monotonic() < end, state
        time.sleep(0.1)
    return state
