"""The screen of live samples, its curves in dots, and a serial port."""

import io
import os
import re
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
from watched_logs import ENVIRONMENT, moving_rows, options, write_log

from known import seed_of
from sigmatau import analyze, read
from sigmatau.analysis.live import LiveAnalysis
from sigmatau.cli import main
from sigmatau.cli.watch_screen import screen_lines
from sigmatau.io.live import Live
from sigmatau.plot.terminal import text_plot


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    return write_log(tmp_path_factory.mktemp("watch") / "log.csv")


def test_the_screen(log):
    """Heading, the coefficients of all axes, what more samples would show, curves if there is room."""
    watched = LiveAnalysis("log", Live(options()))
    assert screen_lines(watched, width=80, height=24) == ["log: waiting for the first lines", ""]
    text = log.read_bytes()
    watched.take(text[: len(text) // 20])
    assert screen_lines(watched, width=80, height=24)[1].startswith("too short to tell: coefficients in 29")
    watched.take(text[len(text) // 20 :])
    small, large = (screen_lines(watched, width=100, height=height) for height in (24, 60))
    assert "60000 samples at 100 Hz" in small[0]
    assert [line.split()[0] for line in small if re.match("(gyro|accel)_", line)] == list(watched.live.channels)
    assert re.search(r"^gyro: angle random walk ± \d(\.\d+)? %, enough", "\n".join(small), re.MULTILINE)
    assert len(small) <= 22
    for words in ("σ(τ) [deg/h]", "σ(τ) [µg]", "└─"):
        assert words in "\n".join(large)


def test_a_line_into_a_pipe(log, capsys):
    argv = ["watch", str(log), "--idle", "0.5", "--every", "0.1"]
    assert main(argv) == 0
    said = capsys.readouterr().err
    assert re.search(
        r"^.*60000 samples at 100 Hz.*; gyro: angle random walk ± .* %, enough; .*accel:", said, re.MULTILINE
    )
    assert main([*argv, "-q"]) == 0
    assert "enough" not in capsys.readouterr().err


def test_the_screen_says_that_the_sensor_moves():
    watched = LiveAnalysis("log", Live(options(rate=100.0, unit={"gyro": "deg/s"}, channels={"gyro": "1:3"})))
    text = io.StringIO()
    np.savetxt(text, moving_rows(lambda t: t > 60), delimiter=",", fmt="%.6f")
    lines = text.getvalue().encode().splitlines(keepends=True)
    watched.take(b"".join(lines[:7000]))
    assert "random walk" in "\n".join(screen_lines(watched, width=80, height=24))
    watched.take(b"".join(lines[7000:]))
    assert "moving now" in screen_lines(watched, width=80, height=24)[0]


@pytest.mark.skipif(sys.platform == "win32", reason="no pseudoterminals")
class TestSerialPort:
    COLUMNS = ("--rate", "100", "--channels", "gyro=1:3", "--unit", "gyro=rad/s")

    @staticmethod
    def port():
        import pty
        import tty

        master, terminal = pty.openpty()
        tty.setraw(terminal)
        return master, os.ttyname(terminal)

    def watched(self, saved, lines):
        """Exit code of a process that watches a port into which lines go, and its outputs."""
        pytest.importorskip("serial", reason="pyserial reads the port")
        master, name = self.port()
        argv = [sys.executable, "-m", "sigmatau", "watch", "--serial", name, *self.COLUMNS]
        argv += ["--idle", "1", "--save", str(saved)]
        with subprocess.Popen(argv, stdout=-1, stderr=-1, env=ENVIRONMENT, text=True) as process:
            os.write(master, b"1,0.0")
            while not saved.exists():  # it is made when the port is open
                time.sleep(0.05)
            for start in range(0, len(lines), 100):
                os.write(master, b"".join(lines[start : start + 100]))
                time.sleep(0.005)
            out, said = process.communicate(timeout=60)
        return process.returncode, out, said

    def test_a_log_is_saved_and_analysed(self, tmp_path):
        """An Arduino without a header: parts of lines at the beginning and at the end are left out."""
        rng = np.random.default_rng(seed_of("serial port"))
        y = rng.standard_normal((7000, 3)) * 1e-3
        lines = [f"{a:.6f},{b:.6f},{c:.6f}\r\n".encode() for a, b, c in y]
        saved = tmp_path / "saved.csv"
        code, out, said = self.watched(saved, [b"3,0.1\r\n", *lines, b"0.001,-"])
        assert code == 0, said
        assert "7000 samples at 100 Hz (given), 70 s" in out
        assert f"quick look: sigmatau analyze {saved}" in said
        assert saved.read_bytes() == b"".join(lines)
        result = analyze(read(saved, rate=100, channels={"gyro": "1:3"}, unit={"gyro": "rad/s"}))
        walk = result["gyro_x"]["random_walk"]
        assert walk.low <= 1e-4 <= walk.high

    def test_a_saved_log_is_not_overwritten(self, tmp_path, capsys):
        master, name = self.port()
        (tmp_path / "old.csv").write_text("old")
        assert main(["watch", "--serial", name, *self.COLUMNS, "--save", str(tmp_path / "old.csv")]) == 1
        assert "old.csv: exists, and a record is never overwritten" in capsys.readouterr().err
        os.close(master)
        assert (tmp_path / "old.csv").read_text() == "old"

    def test_a_port_that_is_unplugged(self, tmp_path, capsys):
        master, name = self.port()
        closing = threading.Timer(1.0, os.close, (master,))
        closing.start()
        assert main(["watch", "--serial", name, *self.COLUMNS]) == 1
        assert f"{name}: the serial port is gone" in capsys.readouterr().err

    def test_without_pyserial(self, monkeypatch, capsys):
        monkeypatch.setitem(sys.modules, "serial", None)
        assert main(["watch", "--serial", "/dev/none"]) == 1
        assert "pip install 'sigmatau[serial]'" in capsys.readouterr().err


def test_curves_fall_where_they_should(log):
    curves = {"gyro_x": analyze(read(log), method="read-off").curves["gyro_x"]}
    lines = text_plot(curves, width=60, height=20)
    assert len(lines) == 20
    assert all(len(line) <= 60 for line in lines)
    rows = [[k for k, dot in enumerate(line) if "\u2800" < dot <= "\u28ff"] for line in lines[1:-2]]
    # White noise falls: the dots of lower rows lie further right.
    columns = [row[0] for row in rows if row]
    assert columns[0] == lines[1].index("│") + 1
    assert columns == sorted(columns)
    assert lines[0].endswith("gyro x")
