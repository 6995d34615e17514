"""Live samples: the reader of lines that come in pieces, and the command."""

import json
import signal
import subprocess
import sys
import time
from importlib import resources
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from watched_logs import ENVIRONMENT, moving_rows, options, write_log

from known import interruptible, seed_of
from sigmatau import analyze, read
from sigmatau.cli import main
from sigmatau.errors import DataError, OptionError
from sigmatau.io import follow as follow_module
from sigmatau.io.follow import follow
from sigmatau.io.live import Live
from sigmatau.quality.selection.live import LiveStretches


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
            (b"", {"rate": 5}, "no line has arrived"),
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

    def test_a_file_is_read_before_it_is_idle(self, tmp_path, monkeypatch):
        """The thread that reads may begin later than the idle time."""
        read = follow_module._File.read

        def late(file):
            time.sleep(0.05)
            return read(file)

        monkeypatch.setattr(follow_module._File, "read", late)
        (tmp_path / "a.csv").write_bytes(b"a\n1\n")
        assert b"".join(follow(str(tmp_path / "a.csv"), every=0.01, idle=1e-3)) == b"a\n1\n"

    def test_no_file(self, tmp_path):
        with pytest.raises(DataError, match="cannot be read"):
            list(follow(str(tmp_path / "none"), every=0.05))


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    return write_log(tmp_path_factory.mktemp("watch") / "log.csv")


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
        assert "60000 samples" in " ".join(out.split())

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

    def test_a_file_that_is_replaced(self, tmp_path):
        """A logger that begins a new file renames the old one."""
        text, _ = table(3000)
        path = tmp_path / "log.csv"
        path.write_bytes(text)
        run = self.started(str(path))
        wait_until_read(run, path)
        path.rename(tmp_path / "log.csv.1")
        path.write_bytes(text)
        out, err = run.communicate(timeout=120)
        assert run.returncode == 1
        assert "was replaced by a new file. Start again to follow the new one" in " ".join(err.split())
        assert "3000 samples" in " ".join(out.split())  # the line may break after the path

    def test_an_empty_file(self, tmp_path):
        path = tmp_path / "log.csv"
        path.touch()
        run = self.started(str(path), "--idle", "0.5")
        _, err = run.communicate(timeout=120)
        assert run.returncode == 1
        assert "is empty: no line has arrived" in " ".join(err.split())

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

    def watch(self, folder, moving, capsys, *more):
        path = folder / "log.csv"
        header = "gyro_x [deg/s],gyro_y [deg/s],gyro_z [deg/s]"
        np.savetxt(path, moving_rows(moving), delimiter=",", header=header, comments="", fmt="%.6f")
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

    def test_pieces_make_no_difference(self):
        x = moving_rows(lambda t: (t > 70) & (t < 75))
        found = []
        for size in (1, 997, len(x)):
            some = LiveStretches(
                ("gyro_x", "gyro_y", "gyro_z"), rate=100, unit={"gyro": "deg/s"}, input="rate", assumed=False
            )
            for start in range(0, len(x), size):
                some.push(x[start : start + size])
            some.finish()
            found.append((some.rest(), some.sums.start, some.sums.n, some.sums.snapshot()["gyro_y"].adev.tolist()))
        assert found[0] == found[1] == found[2]
        assert (found[0][1], found[0][2]) == (0, 6000)
