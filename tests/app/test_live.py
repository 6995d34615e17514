"""The live view: a simulated serial port, standard input, and what is left when the record ends."""

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from urllib.request import urlopen

import numpy as np
import pytest

pytest.importorskip("starlette")
pytest.importorskip("serial", reason="pyserial reads the port")
pytest.importorskip("pty", reason="no simulated ports")

from page_tabs import command, tabs
from workbench_served import TOKEN, Page, serving

from known import seed_of
from sigmatau.app.files import Roots
from sigmatau.app.log import LiveSource
from sigmatau.app.recording import Recording
from sigmatau.app.routes import Workbench
from sigmatau.errors import DataError

pytest_plugins = ["workbench_pages"]  # the fixtures

TABLE = {"rate": "100", "unit": "gyro=rad/s", "channels": "gyro=1:3"}
WORDS = ["--rate", "100", "--unit", "gyro=rad/s", "--channels", "gyro=1:3"]


def lines(count):
    """What an Arduino prints: three numbers a line."""
    rows = np.random.default_rng(seed_of("live view")).standard_normal((count, 3)) * 1e-3
    return [f"{a:.6f},{b:.6f},{c:.6f}\r\n".encode() for a, b, c in rows]


class Port:
    """A simulated serial port, and the record of what is written to it."""

    def __init__(self, folder):
        import pty
        import tty

        self.master, terminal = pty.openpty()
        tty.setraw(terminal)
        self.name = os.ttyname(terminal)
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
        os.write(self.master, b"1,0.0\r\n")  # a part of a line
        return made

    def write(self, rows):
        for start in range(0, len(rows), 100):
            os.write(self.master, b"".join(rows[start : start + 100]))


@pytest.fixture
def port(tmp_path):
    return Port(tmp_path)


@contextlib.contextmanager
def recorded(port, **changes):
    """A client of a workbench that records the port."""
    workbench = Workbench(Roots([port.saved.parent, port.saved]), max_upload=10**6, recording=port.recording(**changes))
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


def test_from_the_first_samples_to_the_saved_log(port):
    rows = lines(9000)
    with recorded(port) as page:
        assert page.get("api/about").json()["live"] is True
        port.write(rows[:500])
        early = waited(page, lambda state: state.get("wait"))
        assert early["state"] == "recording"
        assert early["wait"].startswith("too short to tell: coefficients in ")
        assert early["overview"] is None
        port.write(rows[500:])
        late = waited(page, lambda state: state["overview"] and "9000 samples" in state["heading"])
        assert [axis["channel"] for axis in late["overview"]["sensors"][0]["axes"]] == ["gyro_x", "gyro_y", "gyro_z"]
        assert late["outlooks"][0]["sensor"] == "gyro"
        assert "angle random walk ±" in late["outlooks"][0]["text"]
        drawn = late["charts"]["channels"]["gyro_x"]
        assert len(drawn["deviation"]["tau"]) > 5
        assert drawn["series"]["bins"] == len(drawn["series"]["low"])
        assert drawn["series"]["duration"] == pytest.approx(90, abs=1)
        assert page.post("api/live/stop").json() == {"path": str(port.saved)}
        assert port.saved.read_bytes() == b"".join(rows)
        ended = page.get("api/live").json()
        assert (ended["state"], ended["error"], ended["options"]) == ("stopped", None, TABLE)
        opened = page.post("api/open", path=str(port.saved), options=TABLE).json()
        assert (opened["rows"], opened["question"]) == (9000, None)


def test_a_log_that_cannot_be_analysed_is_saved(port):
    """The unit is not known: the page says so, and what arrives is kept."""
    rows = lines(600)
    with recorded(port, table={"rate": "100", "channels": "gyro=1:3"}) as page:
        port.write(rows)
        asked = waited(page, lambda state: state["error"])
        assert (asked["state"], asked["error"]["option"]) == ("recording", "unit")
        page.post("api/live/stop")
    assert port.saved.read_bytes() == b"".join(rows)


def test_a_process_that_is_killed(port):
    rows = lines(600)
    with recorded(port) as page:
        port.write(rows)
        waited(page, lambda state: "600 samples" in state.get("heading", ""))
        page.recording._process.kill()
        assert waited(page, lambda state: state["state"] == "failed")["error"]["code"] == "failed"
    assert port.saved.read_bytes() == b"".join(rows)


def test_what_exists_is_not_overwritten(port):
    port.saved.write_text("old")
    with pytest.raises(DataError, match="a record is never overwritten"):
        port.recording()
    assert port.saved.read_text() == "old"


def test_without_a_record(page):
    for answer in (page.get("api/live"), page.post("api/live/stop")):
        assert (answer.status_code, answer.json()["error"]["code"]) == (404, "missing")
    assert page.get("api/about").json()["live"] is False


def test_standard_input(tmp_path):
    """The end of the server ends the record, and the log is complete."""
    saved, rows = tmp_path / "saved.csv", lines(700)
    argv = [sys.executable, "-m", "sigmatau", "app", "-", "--no-browser", "--save", str(saved), *WORDS]
    with subprocess.Popen(argv, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as served:
        address = served.stdout.readline().decode().strip()

        def state():
            with urlopen(f"{address}api/live", timeout=60) as answer:
                return json.load(answer)

        served.stdin.write(b"".join(rows))
        served.stdin.flush()
        while "700 samples" not in state().get("heading", ""):
            time.sleep(0.1)
        shown = state()
        served.send_signal(signal.SIGINT)
        _, messages = served.communicate(timeout=60)
    assert served.returncode == 0
    assert b"Traceback" not in messages
    assert (shown["command"], shown["options"]) == (f"sigmatau watch {' '.join(WORDS)} --save {saved}", TABLE)
    assert saved.read_bytes() == b"".join(rows)


def test_the_page(browser, port):
    rows = lines(9000)
    with recorded(port) as page, tabs(browser, f"{str(page.client.base_url).rstrip('/')}/{TOKEN}/") as open_tab:
        tab = open_tab()
        port.write(rows[:1000])
        tab.locator(".wait", has_text="Too short to tell: coefficients in").wait_for()
        tab.locator("#live-series canvas").first.wait_for()
        port.write(rows[1000:])
        tab.locator("#live-summary table").wait_for()
        tab.locator("#live-deviation canvas").wait_for()
        tab.locator(".outlooks", has_text="gyro: angle random walk ±").wait_for()
        tab.locator(".headline", has_text="9000 samples").wait_for()
        tab.get_by_role("button", name="Stop and open the log").click()
        tab.locator("#analyse:enabled").wait_for()
        assert command(tab, "saved.csv") == f"sigmatau analyze {port.saved} {' '.join(WORDS)}"
        tab.get_by_role("button", name="Live").click()
        tab.locator("#open-saved").wait_for()
        assert tab.locator("#stop-live").count() == 0
