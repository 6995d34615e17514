"""The live view: a simulated serial port, standard input, and what is left when the record ends."""

import json
import signal
import subprocess
import sys
import time
from urllib.request import urlopen

import pytest

pytest.importorskip("starlette")
pytest.importorskip("serial", reason="pyserial reads the port")
pytest.importorskip("pty", reason="no simulated ports")

from live_ports import TABLE, WORDS, lines, noise, recorded, served, waited

from sigmatau.errors import DataError

pytest_plugins = ["workbench_pages"]  # the fixtures


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


def test_a_stop_within_a_line_leaves_whole_lines(port):
    rows = lines(600)
    with recorded(port) as page:
        port.write([*rows, b"0.001,-"])
        waited(page, lambda state: "600 samples" in state["heading"])
        page.post("api/live/stop")
        assert port.saved.read_bytes() == b"".join(rows)
        assert page.get("api/live").json()["error"] is None


def test_a_silent_port_is_named(port):
    """The first line ends the message, and is not lost."""
    with recorded(port) as page:
        silent = waited(page, lambda state: state["error"])
        assert silent["state"] == "recording"
        words = "no line has arrived. Check the port, the baud rate and the cable"
        assert silent["error"]["message"] == f"{port.name}: {words}"
        port.write(lines(300))
        late = waited(page, lambda state: "300 samples" in state["heading"])
        assert late["error"] is None


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
    assert page.get("api/live").json() == {"state": "none"}
    for answer in (page.post("api/live/stop"), page.post("api/live/options", options=TABLE)):
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


def start(page, **body):
    return page.post("api/live/start", **body)


def test_a_port_is_chosen(port):
    """A page starts a record, one at a time; another page sees it; options may be stated later."""
    rows = lines(3000)
    with served(port) as page:
        assert isinstance(page.get("api/ports").json()["ports"], list)
        assert page.get("api/about").json()["folder"] == str(port.saved.parent)
        began = start(page, port=port.name, baud=57600, save="chosen.csv", options={"rate": "100"})
        assert (began.status_code, began.json()["state"]) == (202, "recording")
        assert start(page, port=port.name).status_code == 409
        port.begin()
        port.write(rows)
        asked = waited(page, lambda state: state["error"])
        assert "--" not in asked["error"]["message"]
        assert page.post("api/live/options", options={"rate": "none"}).status_code == 400
        assert page.post("api/live/options", options=TABLE).json() == {"options": TABLE}
        whole = waited(page, lambda state: "3000 samples" in state.get("heading", ""))
        assert (whole["error"], whole["options"]) == (None, TABLE)
        assert f"--serial {port.name} --baud 57600" in whole["command"]
        saved = port.saved.with_name("chosen.csv")
        assert page.post("api/live/stop").json() == {"path": str(saved)}
        assert saved.read_bytes() == b"".join(rows)
        again = start(page, port=port.name, save="chosen.csv")
        assert (again.status_code, "never overwritten" in again.json()["error"]["message"]) == (422, True)
        assert start(page, port=port.name, save="again.csv", options=TABLE).status_code == 202


@pytest.mark.parametrize(
    ("body", "status"),
    [
        ({"port": "/etc/passwd"}, 400),
        ({"port": "/dev/../etc/passwd"}, 400),
        ({"port": "socket://example.org:80"}, 400),
        ({"port": "/dev/nothing"}, 422),
        ({}, 400),
        ({"port": "/dev/nothing", "baud": 0}, 400),
        ({"port": "/dev/nothing", "baud": "fast"}, 400),
        ({"port": "/dev/nothing", "save": "../x.csv"}, 400),
        ({"port": "/dev/nothing", "save": "/tmp/x.csv"}, 400),
        ({"port": "/dev/nothing", "save": ".x"}, 400),
        ({"port": "/dev/nothing", "save": ""}, 400),
        ({"port": "/dev/nothing", "save": "lab.db-wal"}, 400),
        ({"port": "/dev/nothing", "save": "\ud800.csv"}, 400),
        ({"port": "/dev/nothing", "baud": None}, 422),
        ({"path": "static.csv", "save": "x.csv"}, 400),
        ({"path": "static.csv", "port": "/dev/nothing"}, 400),
        ({"port": "/dev/nothing", "options": {"input": "accumulated"}}, 400),
        ({"port": "/dev/nothing", "options": {"nothing": 1}}, 400),
        ({"path": "/etc/passwd"}, 404),
    ],
)
def test_refused_sources(page, body, status):
    answer = start(page, **body)
    assert answer.status_code == status, answer.json()
    assert "--" not in answer.json()["error"]["message"]
    assert page.get("api/live").json() == {"state": "none"}


def test_a_file_that_grows_is_not_changed(port):
    log, rows = port.saved.with_name("growing.csv"), lines(2500)
    log.write_bytes(b"".join(rows[:1000]))
    with served(port) as page:
        assert start(page, path=str(log), options=TABLE).status_code == 202
        waited(page, lambda state: "1000 samples" in state.get("heading", ""))
        with log.open("ab") as file:
            file.write(b"".join(rows[1000:]))
        state = waited(page, lambda state: "2500 samples" in state.get("heading", ""))
        assert state["path"] == str(log)
        assert page.post("api/live/stop").json() == {"path": str(log)}
    assert log.read_bytes() == b"".join(rows)


def test_a_port_that_is_lost(port):
    rows = lines(500)
    with recorded(port) as page:
        port.write(rows)
        waited(page, lambda state: "500 samples" in state.get("heading", ""))
        port.unplug()
        failed = waited(page, lambda state: state["state"] == "failed")
        assert "the serial port is gone" in failed["error"]["message"]
    assert port.saved.read_bytes() == b"".join(rows)


def test_lines_that_are_no_text(port):
    """What arrives is saved; the page says what to check."""
    with recorded(port) as page:
        port.write([noise()])
        shown = waited(page, lambda state: state["error"])
        assert shown["state"] == "recording"
        assert "Check the baud rate" in shown["error"]["message"]


def test_bytes_without_an_end_of_a_line(port):
    with served(port) as page:
        assert start(page, port=port.name, save="chosen.csv").status_code == 202
        port.write([b"\x80" * 170] * 100)  # more than may come before the first line
        failed = waited(page, lambda state: state["error"])
        assert failed["state"] == "failed"
        assert "Check the baud rate" in failed["error"]["message"]
