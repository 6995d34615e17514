"""Live samples: the reader of lines that come in pieces, and the command."""

import io
import json
import os
import re
import signal
import subprocess
import sys
import threading
import time
from importlib import resources
from pathlib import Path

import jsonschema
import numpy as np
import pytest

from conftest import ROOT
from known import interruptible, seed_of
from sigmatau import NoiseModel, analyze, read, simulate
from sigmatau.analysis.live import LiveAnalysis
from sigmatau.cli import main
from sigmatau.cli.watch_screen import screen_lines
from sigmatau.errors import DataError, OptionError
from sigmatau.io.follow import follow
from sigmatau.io.live import Live
from sigmatau.io.read.options import TableOptions
from sigmatau.io.write import write
from sigmatau.plot.terminal import text_plot
from sigmatau.quality.selection.live import LiveStretches

ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT / "python")}


def options(**given):
    defaults = {"rate": None, "unit": {}, "channels": {}, "input": "rate", "scale": {}, "offset": {}}
    return TableOptions(**{**defaults, **given}).checked()


def table(n=300, header="time [s],gyro_x [deg/s],gyro_y [deg/s]", rate=50):
    y = np.random.default_rng(1).standard_normal((n, 2))
    rows = [f"{k / rate:.6f},{a!r},{b!r}" for k, (a, b) in enumerate(y.tolist())]
    return "\n".join([header, *rows, ""]).encode(), y


def pushed(live, text, size):
    pieces = [live.push(text[k : k + size]) for k in range(0, len(text), size)]
    pieces.append(live.push(b"", last=True))
    return np.concatenate([piece for piece in pieces if piece.size])


class TestLines:
    @pytest.mark.parametrize("size", [1, 7, 1000, 10**6])
    def test_pieces_make_no_difference(self, size):
        text, y = table()
        live = Live(options())
        assert pushed(live, text, size).tolist() == y.tolist()
        assert live.channels == ("gyro_x", "gyro_y")
        assert (live.rate, live.unit["gyro_x"]) == (pytest.approx(50), "deg/s")
        assert live.rate_by_stamps() == pytest.approx(50)
        assert (live.lines, live.lost) == (300, 0)

    @pytest.mark.parametrize("size", [11, 10**6])
    def test_bad_lines_are_left_out_and_counted(self, size):
        text, y = table()
        lines = text.splitlines(keepends=True)
        lines[100] = b"1.98,0.3,\xff\x00garbage\n"
        lines[101] = b"2.0,1\n"
        lines[250] = b"nan,nan,nan\n"
        live = Live(options())
        got = pushed(live, b"".join(lines), size)
        assert got.tolist() == np.delete(y, [99, 100, 249], axis=0).tolist()
        assert (live.lines, live.lost) == (297, 3)
        assert live.lost_example

    @pytest.mark.parametrize("size", [11, 3000, 10**6])
    @pytest.mark.parametrize("garbled", [b"x,1,2\n", b"0.48,1e200,2\n", b"0.48,nan,2\n"])
    def test_a_lost_line_does_not_change_the_rate(self, size, garbled):
        text, y = table()
        lines = text.splitlines(keepends=True)
        lines[25] = garbled
        live = Live(options())
        assert pushed(live, b"".join(lines), size).tolist() == np.delete(y, 24, axis=0).tolist()
        assert (live.lost, live.leaps) == (1, 0)
        assert live.rate == pytest.approx(50)
        assert live.rate_by_stamps() == pytest.approx(50)

    def test_gaps_and_leaps_back_are_counted(self):
        text, _ = table()
        lines = text.splitlines(keepends=True)
        later = [b"%.2f,1,2\n" % (k / 50 + shift) for k, shift in ((300, 5.0), (301, 5.0), (302, -3.0), (303, -3.0))]
        live = Live(options())
        pushed(live, b"".join(lines + later), 100)
        assert live.leaps == 2
        assert live.rate_by_stamps() == pytest.approx(50)

    @pytest.mark.parametrize("data", [b"\x93NUMPY\x01\x00" + b"a,b\n" * 100, bytes(range(256)) * 40 + b"\n" * 60])
    def test_binary_data(self, data):
        with pytest.raises(DataError, match="binary data"):
            Live(options(rate=1)).push(data, last=True)

    @pytest.mark.parametrize("labels", [("0", "1"), ("Gyro", "Accel"), ("left", "left", "right")])
    @pytest.mark.parametrize("size", [11, 10**6])
    def test_rows_of_several_sensors_are_refused(self, labels, size):
        rows = (f"{k / 100:.2f},{labels[k % len(labels)]},{(k * 7 % 13) / 9},{(k * 5 % 11) / 9}" for k in range(600))
        text = "\n".join(["time [s],sensor_id,gyro_x [deg/s],gyro_y [deg/s]", *rows, ""]).encode()
        with pytest.raises(DataError, match=rf"column 2 'sensor_id' has {labels[0]} and {labels[-1]}.*one sensor only"):
            pushed(Live(options()), text, size)

    @pytest.mark.parametrize("size", [1000, 10**6])
    @pytest.mark.parametrize("rows", [600, 9000])
    def test_sensors_in_turn_are_asked_for(self, rows, size):
        rng = np.random.default_rng(seed_of("watched in turn"))
        samples = rng.normal(size=(rows, 3)) + np.resize([[0, 5, -4], [7, 0, 4]], (rows, 3))
        lines = [f"{k / 100:.2f},{x:.4f},{y:.4f},{z:.4f}" for k, (x, y, z) in enumerate(samples.tolist())]
        text = "\n".join(["time [s],gyro_x [deg/s],gyro_y [deg/s],gyro_z [deg/s]", *lines, ""]).encode()
        with pytest.raises(OptionError, match=r"rows of 2 interleaved sensors.*column .gyro_z.*sigmatau analyze FILE"):
            pushed(Live(options()), text, size)
        assert len(pushed(Live(options(interleaved=1)), text, size)) == rows

    @pytest.mark.parametrize("size", [11, 3000, 10**6])
    def test_lines_that_were_written_twice_are_skipped(self, size):
        text, y = table()
        header, *rows = text.splitlines(keepends=True)
        live = Live(options())
        assert (
            pushed(live, b"".join([header, *(row * (1 + k % 2) for k, row in enumerate(rows))]), size).tolist()
            == y.tolist()
        )
        assert (live.lines, live.repeated) == (300, 150)
        assert live.rate == pytest.approx(50)
        assert live.rate_by_stamps() == pytest.approx(50)

    def test_samples_within_a_second_are_not_repeats(self):
        rows = (f"{k // 10},{k % 3},{k % 2}" for k in range(300))
        text = "\n".join(["time [s],gyro_x [deg/s],gyro_y [deg/s]", *rows, ""]).encode()
        live = Live(options())
        assert len(pushed(live, text, 1000)) == 300
        assert live.repeated == 0

    def test_clock_times_ask_for_the_rate(self):
        rows = (f"10:00:{k // 50:02d}.{k % 50 * 2:02d},{k % 7},{k % 5}" for k in range(300))
        text = "\n".join(["Time,gyro_x [deg/s],gyro_y [deg/s]", *rows, ""]).encode()
        with pytest.raises(OptionError, match=r"column 'Time' has dates or clock times.*give `rate=HZ`"):
            pushed(Live(options()), text, 1000)
        live = Live(options(rate=50))
        assert (len(pushed(live, text, 1000)), live.rate) == (300, 50)

    def test_scales_and_offsets(self):
        text, y = table(header="t,a,b")
        live = Live(
            options(
                rate=10,
                channels={"gyro_x": "a", "accel_z": "b"},
                unit={"gyro": "deg/s", "accel": "g"},
                scale={"gyro": 0.5},
                offset={"accel_z": 3},
            )
        )
        got = pushed(live, text, 333)
        assert got == pytest.approx(np.column_stack([y[:, 0] * 0.5, y[:, 1] - 3]), rel=1e-15)
        assert live.rate == 10

    @pytest.mark.parametrize(
        ("text", "given", "words"),
        [
            (b"1,2\n3,4\n", {}, r"the values do not show which columns belong to which sensor"),
            (b"gyro_x\n1\n2\n3\n", {"rate": 5}, "unit"),
            (b"gyro_x [deg/s]\n1\n2\n3\n", {}, "`rate=HZ`"),
            (b"hello\nworld\n", {"rate": 5}, "no line of numbers"),
            (b"", {"rate": 5}, "only blank lines"),
        ],
    )
    def test_what_is_missing_is_asked_for(self, text, given, words):
        live = Live(options(**given))
        with pytest.raises((DataError, OptionError), match=words):
            pushed(live, text, 100)


class TestFollow:
    def test_a_file_that_grows(self, tmp_path):
        log = tmp_path / "log"
        log.write_bytes(b"one ")
        with log.open("ab", buffering=0) as writer:
            got = b""
            for piece in follow(str(log), every=0.05, idle=0.5):
                got += piece
                if piece and got == b"one ":
                    writer.write(b"two")
        assert got == b"one two"

    def test_no_file(self, tmp_path):
        with pytest.raises(DataError, match="cannot be read"):
            list(follow(str(tmp_path / "none"), every=0.05))


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    model = NoiseModel(
        channels={"gyro_x": {"random_walk": 1e-4, "rate_random_walk": 1e-6}, "accel_x": {"random_walk": 1e-3}}
    )
    path = tmp_path_factory.mktemp("watch") / "log.csv"
    write(simulate(model, duration=1500, rate=100, rng=1), path)
    return path


def wait_until_read(run, path):
    """Until a process has read a file to its end and sleeps; however busy the machine is."""
    quiet, used = 0, None
    for _ in range(2400):
        time.sleep(0.05)
        assert run.poll() is None, run.communicate()
        fields = Path(f"/proc/{run.pid}/stat").read_text().rpartition(")")[2].split()
        before, used = used, (fields[11], fields[12])
        quiet = quiet + 1 if fields[0] == "S" and used == before and at_end(run.pid, path) else 0
        if quiet == 6:
            return
    raise AssertionError(f"{path} was not read")


def at_end(pid, path):
    for link in Path(f"/proc/{pid}/fd").iterdir():
        try:
            if link.resolve() == path:
                position = Path(f"/proc/{pid}/fdinfo/{link.name}").read_text().split()[1]
                return int(position) == path.stat().st_size
        except OSError:
            continue
    return False


class TestCommand:
    def test_standard_input_gives_what_analyze_gives(self, log, tmp_path):
        result = tmp_path / "last.json"
        with log.open("rb") as lines:
            done = subprocess.run(
                [sys.executable, "-m", "sigmatau", "watch", "--json", str(result)],
                stdin=lines,
                capture_output=True,
                text=True,
                env=ENVIRONMENT,
                check=True,
            )
        assert "angle random walk" in done.stdout
        written = json.loads(result.read_text())
        schema = json.loads(resources.files("sigmatau").joinpath("schema/result-2.schema.json").read_text())
        jsonschema.Draft202012Validator(schema).validate(written)
        expected = analyze(read(log), long="strided").to_dict()
        for channel, found in written["channels"].items():
            curve, other = found["curve"], expected["channels"][channel]["curve"]
            assert curve["adev"] == pytest.approx(other["adev"], rel=1e-9)
            assert curve["stride"] == other["stride"]
            terms = expected["channels"][channel]["fit"]["terms"]
            assert found["fit"]["terms"]["random_walk"]["value"] == pytest.approx(
                terms["random_walk"]["value"], rel=1e-3
            )

    def test_interrupt_ends_it_with_the_table(self, log):
        run = subprocess.Popen(
            [sys.executable, "-m", "sigmatau", "watch", str(log)],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=ENVIRONMENT,
            preexec_fn=interruptible,
        )
        wait_until_read(run, log)
        run.send_signal(signal.SIGINT)
        out, err = run.communicate(timeout=120)
        assert run.returncode == 0, err
        assert "150000 samples" in " ".join(out.split())

    def test_lost_lines_and_wrong_rate_are_said(self, log, tmp_path):
        lines = log.read_bytes().splitlines(keepends=True)
        lines[500] = b"#\x00,oops,1\n"
        lines[501] = b"x,y,z\n"
        bad = tmp_path / "bad.csv"
        bad.write_bytes(b"".join(lines))
        argv = [
            "watch",
            str(bad),
            "--rate",
            "99",
            "--idle",
            "300ms",
            "--every",
            "100ms",
            "--json",
            str(tmp_path / "r.json"),
        ]
        assert main(argv) == 0
        found = {one["code"]: one for one in json.loads((tmp_path / "r.json").read_text())["findings"]}
        lost = found["skipped_messages"]["details"]
        assert (lost["count"], lost["unit"], lost["example"]) == (1, "lines", "x")
        details = found["rate_mismatch"]["details"]
        assert (details["used"], details["other"]) == pytest.approx((99, 100), rel=1e-6)

    @pytest.mark.parametrize(
        ("argv", "code", "words"),
        [
            (["watch", "no-such-file"], 1, "no such file"),
            (["watch", "LOG", "--every", "0"], 2, "--every"),
            (["watch", "LOG", "--idle", "-1"], 2, "--idle"),
            (["watch", "LOG", "--idle", "1x"], 2, "--idle '1x'"),
            (["watch", "LOG", "--input", "accumulated"], 2, "accumulated"),
            (["watch", "LOG", "--idle", "0.2", "--every", "0.1", "--unit", "gyro=parsec"], 2, "parsec"),
            (["watch", "LOG", "--plot", "figure.doc"], 2, ".png"),
            (["watch", "LOG", "--interleaved", "2"], 2, "--interleaved 2 is for a saved log"),
            (["watch", "LOG", "--serial", "/dev/none"], 2, "--serial is read in place of a file"),
            (["watch", "LOG", "--save", "new.csv"], 2, "LOG is a log already"),
            (["watch", "--baud", "9600"], 2, "give --serial PORT too"),
            (["watch", "--serial", "/dev/none", "--baud", "0"], 2, "--baud 0: must be a positive number"),
            (
                ["watch", "--serial", "/dev/none"],
                1,
                "/dev/none: the serial port cannot be opened: No such file",
            ),
        ],
    )
    def test_refusals(self, log, argv, code, words, capsys):
        assert main([str(log) if word == "LOG" else word for word in argv]) == code
        assert words.replace("LOG", str(log)) in capsys.readouterr().err

    def test_the_screen(self, log):
        """Heading, the coefficients of all axes, what more samples would show, curves if there is room."""
        watched = LiveAnalysis("log", Live(options()))
        assert screen_lines(watched, width=80, height=24) == ["log: waiting for the first lines", ""]
        text = log.read_bytes()
        watched.take(text[: len(text) // 50])
        assert screen_lines(watched, width=80, height=24)[1].startswith("too short to tell: coefficients in 29")
        watched.take(text[len(text) // 50 :])
        small, large = (screen_lines(watched, width=100, height=height) for height in (24, 60))
        assert "150000 samples at 100 Hz" in small[0]
        assert [line.split()[0] for line in small if re.match("(gyro|accel)_", line)] == list(watched.live.channels)
        assert re.search(r"^gyro: angle random walk ± 0\.\d+ %, enough", "\n".join(small), re.MULTILINE)
        assert len(small) <= 22
        for words in ("σ(τ) [deg/h]", "σ(τ) [µg]", "└─"):
            assert words in "\n".join(large)

    def test_a_line_into_a_pipe(self, log, capsys):
        argv = ["watch", str(log), "--idle", "0.5", "--every", "0.1"]
        assert main(argv) == 0
        said = capsys.readouterr().err
        assert re.search(
            r"^.*150000 samples at 100 Hz.*; gyro: angle random walk ± .* %, enough; .*accel:", said, re.MULTILINE
        )
        assert main([*argv, "-q"]) == 0
        assert "enough" not in capsys.readouterr().err


@pytest.mark.skipif(sys.platform == "win32", reason="no pseudoterminals")
class TestSerialPort:
    COLUMNS = ("--rate", "100", "--channels", "gyro=1:3", "--unit", "gyro=rad/s")

    @staticmethod
    def port():
        import pty
        import tty

        near, far = pty.openpty()
        tty.setraw(far)
        return near, os.ttyname(far)

    def watched(self, saved, lines):
        """Exit code of a process that watches a port into which lines go, and its outputs."""
        pytest.importorskip("serial", reason="pyserial reads the port")
        near, name = self.port()
        argv = [sys.executable, "-m", "sigmatau", "watch", "--serial", name, *self.COLUMNS]
        argv += ["--idle", "1", "--save", str(saved)]
        with subprocess.Popen(argv, stdout=-1, stderr=-1, env=ENVIRONMENT, text=True) as process:
            os.write(near, b"1,0.0")
            while not saved.exists():  # it is made when the port is open
                time.sleep(0.05)
            for start in range(0, len(lines), 100):
                os.write(near, b"".join(lines[start : start + 100]))
                time.sleep(0.005)
            out, said = process.communicate(timeout=60)
        return process.returncode, out, said

    def test_a_log_is_saved_and_analysed(self, tmp_path):
        """An Arduino without a header: the part of a line at the beginning is left out."""
        rng = np.random.default_rng(seed_of("serial port"))
        y = rng.standard_normal((7000, 3)) * 1e-3
        lines = [f"{a:.6f},{b:.6f},{c:.6f}\r\n".encode() for a, b, c in y]
        saved = tmp_path / "saved.csv"
        code, out, said = self.watched(saved, [b"3,0.1\r\n", *lines])
        assert code == 0, said
        assert "7000 samples at 100 Hz (given), 70 s" in out
        assert f"quick look: sigmatau analyze {saved}" in said
        assert saved.read_bytes() == b"".join(lines)
        result = analyze(read(saved, rate=100, channels={"gyro": "1:3"}, unit={"gyro": "rad/s"}))
        walk = result["gyro_x"]["random_walk"]
        assert walk.low <= 1e-4 <= walk.high

    def test_a_saved_log_is_not_overwritten(self, tmp_path, capsys):
        near, name = self.port()
        (tmp_path / "old.csv").write_text("old")
        assert main(["watch", "--serial", name, *self.COLUMNS, "--save", str(tmp_path / "old.csv")]) == 1
        assert "old.csv: exists, and a record is never overwritten" in capsys.readouterr().err
        os.close(near)
        assert (tmp_path / "old.csv").read_text() == "old"

    def test_a_port_that_is_unplugged(self, tmp_path, capsys):
        near, name = self.port()
        closing = threading.Timer(1.0, os.close, (near,))
        closing.start()
        assert main(["watch", "--serial", name, *self.COLUMNS]) == 1
        assert f"{name}: the serial port cannot be read any more" in capsys.readouterr().err

    def test_without_pyserial(self, monkeypatch, capsys):
        monkeypatch.setitem(sys.modules, "serial", None)
        assert main(["watch", "--serial", "/dev/none"]) == 1
        assert "pip install 'sigmatau[serial]'" in capsys.readouterr().err


class TestTextPlot:
    def test_curves_fall_where_they_should(self, log):
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


class TestEnds:
    """However it ends, what has come is not lost."""

    def started(self, *argv, **given):
        return subprocess.Popen(
            [sys.executable, "-m", "sigmatau", "watch", *argv],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=ENVIRONMENT,
            **given,
        )

    def test_terminated(self, tmp_path):
        text, _ = table(3000)
        path = tmp_path / "log.csv"
        path.write_bytes(text)
        run = self.started(str(path))
        wait_until_read(run, path)
        run.terminate()
        out, err = run.communicate(timeout=120)
        assert run.returncode == 0, err
        assert "3000 samples" in " ".join(out.split())  # the line may break after the path

    def test_a_file_that_becomes_shorter(self, tmp_path):
        text, _ = table(3000)
        path = tmp_path / "log.csv"
        path.write_bytes(text)
        run = self.started(str(path), "--json", str(tmp_path / "r.json"))
        wait_until_read(run, path)
        path.write_bytes(text[:1000])
        out, err = run.communicate(timeout=120)
        assert run.returncode == 1
        assert "has become shorter" in err
        assert "3000 samples" in " ".join(out.split())  # the line may break after the path
        assert (tmp_path / "r.json").exists()

    def test_closed_standard_input(self):
        done = subprocess.run(
            f"{sys.executable} -m sigmatau watch <&-", shell=True, capture_output=True, text=True, env=ENVIRONMENT
        )
        assert (done.returncode, done.stderr) == (1, "sigmatau: standard input is closed\n")

    def test_too_few(self, capsys, tmp_path):
        path = tmp_path / "few.csv"
        path.write_text("gyro_x [deg/s]\n1\n2\n")
        assert main(["watch", str(path), "--rate", "1", "--idle", "0.2"]) == 1
        assert "at least 4 are needed" in capsys.readouterr().err


class TestMotion:
    """No coefficients of a sensor that moves."""

    N, RATE = 12_000, 100

    def rows(self, moving):
        """Two minutes of gyros; they are turned by hand where `moving`."""
        rng = np.random.default_rng(seed_of("watched motion"))
        t = np.arange(self.N) / self.RATE
        x = 0.05 * rng.standard_normal((self.N, 3))
        x[:, 0] += np.where(moving(t), 40 * np.sin(2 * np.pi * 0.4 * t), 0.0)
        return x

    def watch(self, folder, moving, capsys, *more):
        path = folder / "log.csv"
        header = "gyro_x [deg/s],gyro_y [deg/s],gyro_z [deg/s]"
        np.savetxt(path, self.rows(moving), delimiter=",", header=header, comments="", fmt="%.6f")
        result = folder / "w.json"
        code = main(["watch", str(path), "--rate", "100", "--idle", "0.1", "--json", str(result), *more])
        return code, capsys.readouterr(), json.loads(result.read_text())

    def test_not_at_rest(self, tmp_path, capsys):
        code, said, result = self.watch(tmp_path, lambda t: t >= 0, capsys)
        assert code == 5
        assert "not at rest: no coefficients" in said.out
        assert "not at rest: gyro_x changes by" in said.err
        assert result["rest"]["verdict"] == "not_at_rest"
        assert all("fit" not in one for one in result["channels"].values())
        code, said, _ = self.watch(tmp_path, lambda t: t >= 0, capsys, "--at-rest")
        assert (code, "analysed as noise" in said.err, "angle random walk" in said.out) == (0, True, True)
        assert said.err.endswith(f"quick look: sigmatau analyze {tmp_path / 'log.csv'} gives the numbers to use\n")

    def test_the_longest_stretch_at_rest_is_analysed(self, tmp_path, capsys):
        """Motion from 20 s to 40 s; the rest is as in a log that begins later."""
        code, said, result = self.watch(tmp_path, lambda t: (t > 20) & (t < 40), capsys)
        assert code == 0
        assert "analysed from 60 s to 120 s" in said.err
        walk = result["channels"]["gyro_x"]["fit"]["terms"]["random_walk"]
        assert walk["low"] <= np.deg2rad(0.05) / 10 <= walk["high"]

    def test_the_screen_says_so(self):
        watched = LiveAnalysis("log", Live(options(rate=100.0, unit={"gyro": "deg/s"}, channels={"gyro": "1:3"})))
        text = io.StringIO()
        np.savetxt(text, self.rows(lambda t: t > 60), delimiter=",", fmt="%.6f")
        lines = text.getvalue().encode().splitlines(keepends=True)
        watched.take(b"".join(lines[:7000]))
        assert "random walk" in "\n".join(screen_lines(watched, width=80, height=24))
        watched.take(b"".join(lines[7000:]))
        assert "moving now" in screen_lines(watched, width=80, height=24)[0]

    def test_pieces_make_no_difference(self):
        x = self.rows(lambda t: (t > 70) & (t < 75))
        found = []
        for size in (1, 997, self.N):
            some = LiveStretches(
                ("gyro_x", "gyro_y", "gyro_z"), rate=100, unit={"gyro": "deg/s"}, input="rate", assumed=False
            )
            for start in range(0, self.N, size):
                some.push(x[start : start + size])
            some.finish()
            found.append((some.rest(), some.sums.start, some.sums.n, some.sums.snapshot()["gyro_y"].adev.tolist()))
        assert found[0] == found[1] == found[2]
        assert (found[0][1], found[0][2]) == (0, 6000)
