"""The command line as a user meets it: output, files, messages, exit codes."""

import csv
import functools
import gzip
import importlib.util
import json
import os
import re
import subprocess
import sys
from dataclasses import replace
from importlib import resources

import jsonschema
import numpy as np
import pytest

from sigmatau.cli import main
from sigmatau.cli.choosing import Choosing
from sigmatau.cli.options import finding_lines
from sigmatau.cli.settings import Settings
from sigmatau.findings.finding import Finding
from sigmatau.findings.reading import Damaged

HEADER = "gyro_x [deg/s],gyro_y [deg/s],accel_z [g]"


def table(rows=1200, header=HEADER):
    y = np.random.default_rng(9).standard_normal((rows, 3)) * (0.1, 0.1, 0.01)
    return "\n".join([header, *(",".join(f"{v:.6f}" for v in row) for row in y)]) + "\n"


@pytest.fixture
def log(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text(table())
    return path


@pytest.fixture
def one(tmp_path):
    """A log of one channel."""
    path = tmp_path / "one.csv"
    path.write_text("\n".join(line.partition(",")[0] for line in table(rows=1000).splitlines()) + "\n")
    return path


def run(*argv, capsys):
    code = main([str(a) for a in argv])
    out, err = capsys.readouterr()
    return code, out, err


@functools.cache
def published():
    """The schema of the JSON; without the check of itself, which takes a second."""
    text = resources.files("sigmatau").joinpath("schema/result-2.schema.json").read_text()
    return jsonschema.Draft202012Validator(json.loads(text))


class TestAnalyze:
    def test_the_fit_begins_where_it_is_told_to(self, log, capsys):
        code, out, _ = run(
            "analyze", log, "--rate", 100, "--method", "gls", "--tau-min", 0.05, "--json", "-", capsys=capsys
        )
        assert code == 0
        channels = json.loads(out)["channels"]
        assert {channel["fit"]["tau_min_s"] for channel in channels.values()} == {0.06}
        assert {channel["curve"]["tau_s"][0] for channel in channels.values()} == {0.01}

    @pytest.mark.parametrize(
        ("arguments", "message"),
        [
            (["1x"], "--tau-min '1x': '1x' is not a time with a unit; give seconds"),
            (["1000ms"], "--tau-min may be at most 0.32 s here, not 1.0"),
            (["-1"], "--tau-min must be a positive number of seconds, not -1.0"),
            (["nan"], "--tau-min must be a positive number of seconds, not nan"),
            (["1"], "--tau-min may be at most 0.32 s here, not 1.0"),
        ],
    )
    def test_no_fit_begins_there(self, log, arguments, message, capsys):
        code, out, err = run("analyze", log, "--rate", 100, "--method", "gls", "--tau-min", *arguments, capsys=capsys)
        assert (code, out) == (2, "")
        assert message in err

    def test_the_likelihood_has_no_first_averaging_time(self, log, capsys):
        code, out, err = run("analyze", log, "--rate", 100, "--tau-min", 1, capsys=capsys)
        assert (code, out) == (2, "")
        assert "--tau-min needs least squares: --method gls" in err

    def test_table_figure_and_json(self, log, tmp_path, capsys):
        figure, result = tmp_path / "a.png", tmp_path / "r.json"
        code, out, err = run("analyze", log, "--rate", 100, "-v", "--plot", figure, "--json", result, capsys=capsys)
        assert (code, err) == (0, "")
        assert "gyro_x  trust: good; the model fits, p = " in out
        assert "  velocity random walk" in out
        assert "95 % interval" in out
        assert "eq. (26)" in out
        assert figure.read_bytes().startswith(b"\x89PNG")
        content = json.loads(result.read_text())
        assert list(content["channels"]) == ["gyro_x", "gyro_y", "accel_z"]
        assert content["source"]["path"] == str(log)

    def test_read_off_alone(self, log, capsys):
        code, out, _ = run("analyze", log, "--rate", 100, "--method", "read-off", capsys=capsys)
        assert code == 0
        assert "gyro_x  angle random walk" in out
        assert "interval" in out  # "no confidence interval"
        assert "95 %" not in out
        code, out, _ = run("analyze", log, "--rate", 100, "--method", "read-off", "--json", "-", capsys=capsys)
        channel = json.loads(out)["channels"]["gyro_x"]
        assert "fit" not in channel
        assert "edf" not in channel["curve"]
        assert channel["curve"]["interval"] == "eq. (26), one standard error"

    def test_ranges_of_the_read_off(self, log, capsys):
        at = ("--read-off-at", "random_walk=20ms:500ms,gyro_x.random_walk=40ms:500ms")
        code, out, _ = run("analyze", log, "--rate", 100, "--json", "-", *at, capsys=capsys)
        assert code == 0
        read = {channel: one["read_off"]["random_walk"] for channel, one in json.loads(out)["channels"].items()}
        assert {channel: one["tau_s"][0] for channel, one in read.items()} == {
            "gyro_x": 0.04,
            "gyro_y": 0.02,
            "accel_z": 0.02,
        }
        assert {one["range_from"] for one in read.values()} == {"given"}
        _, out, _ = run("analyze", log, "--rate", 100, *at, capsys=capsys)
        for channel, begin in (("gyro_x", "0.04"), ("gyro_y", "0.02"), ("accel_z", "0.02")):
            assert re.search(
                rf"^{channel} read off: \w+ random walk .* \(τ {begin} … 0\.48\s+s,\s+given", out, flags=re.MULTILINE
            )
        assert max(map(len, out.splitlines())) <= 80
        for text, message in (
            ("random_walk=2s", "give the shortest and the longest averaging time"),
            ("random_walk=1:2", "'1' is not a time with a unit"),
            ("random_walk=2s:1s", "random_walk: must be two averaging times in s"),
            ("random_walk=2h:3h", "random_walk: the curve of gyro_x has no averaging time from 7200 s to 10800 s"),
            ("walk=1s:2s", "unknown term 'walk'"),
        ):
            code, out, err = run("analyze", log, "--rate", 100, "--read-off-at", text, capsys=capsys)
            assert (code, out) == (2, "")
            assert err.startswith("sigmatau: --read-off-at ")
            assert message in err

    def test_verbose_is_by_sensor_in_80_columns(self, log, capsys, monkeypatch):
        monkeypatch.setenv("COLUMNS", "80")
        code, out, err = run("analyze", log, "--rate", 100, "-v", "--leave-out", "1s:1.1s", capsys=capsys)
        assert code == 0
        assert max(map(len, [*out.splitlines(), *err.splitlines()])) <= 80
        head, gyro, accel, legend = out.split("\n\n")
        assert head.startswith("log.csv: 3 axes at 100 Hz")
        assert gyro.startswith("gyro: 2 channels")
        assert "velocity" not in gyro
        assert accel.startswith("accel: 1 channel")
        assert "gyro" not in accel
        assert legend.startswith("Fitted: ")
        assert "More: " not in err

    def test_verbose_has_findings_after_the_table_of_their_sensor(self, tmp_path):
        y = np.random.default_rng(4).standard_normal((2000, 2))
        y[:, 1] = np.round(y[:, 1])
        path = tmp_path / "log.csv"
        np.savetxt(path, y, delimiter=",", header="gyro_x [deg/s],accel_x [m/s^2]", comments="")
        command = [sys.executable, "-m", "sigmatau", "analyze", str(path), "--rate", "100", "-v"]
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=True)
        at = {
            text: done.stdout.index(text) for text in ("gyro: 1 channel", "accel: 1 channel", "the resolution", "p: ")
        }
        assert list(at.values()) == sorted(at.values())

    def test_what_comes_next_is_the_last_line(self, log, tmp_path, capsys):
        code, _, err = run("analyze", log, "--rate", 100, "--export", f"kalibr={tmp_path / 'k.yaml'}", capsys=capsys)
        assert code == 0
        last = err.splitlines()[-2:]
        assert last[0].endswith("k.yaml: written for kalibr")
        assert last[1] == "More: -v · report: --report r.html"

    def test_terms_that_may_be_present(self, log, capsys):
        options = ("analyze", log, "--rate", 100, "--json", "-")
        code, out, _ = run(*options, "--terms", "random_walk, rate_random_walk", capsys=capsys)
        assert code == 0
        for channel in json.loads(out)["channels"].values():
            assert {"bias_instability", "quantization"}.isdisjoint(channel["fit"]["terms"])
        code, out, err = run(*options, "--terms", "random_walk,arw", capsys=capsys)
        assert code == 2
        assert "--terms: unknown term 'arw'; it is random_walk here" in err
        code, out, err = run(*options, "--terms", "random_walk", "--method", "read-off", capsys=capsys)
        assert (code, "--terms are of a fit" in err) == (2, True)
        code, out, _ = run("analyze", log, "--rate", 100, "--terms", "random_walk", capsys=capsys)
        assert out.count("not fitted") == 6

    @pytest.mark.parametrize("command", ["analyze", "psd", "deviation"])
    def test_style_of_a_paper(self, log, command, tmp_path, capsys):
        """300 dots an inch instead of 100 to 120, and half the width in inches."""
        from matplotlib.image import imread

        kind = ("--kind", "hadamard") if command == "deviation" else ()
        shapes = []
        for style in ("screen", "paper"):
            path = tmp_path / f"{style}.png"
            options = (command, log, "--rate", 100, *kind, "--plot", path, "--style", style)
            assert run(*options, capsys=capsys)[0] == 0
            shapes.append(imread(path).shape)
        assert shapes[1][1] == pytest.approx(300 / (100 if command == "psd" else 120) * 0.5 * shapes[0][1], abs=2)
        code, _, err = run(command, log, "--rate", 100, *kind, "--style", "paper", capsys=capsys)
        assert (code, err) == (2, "sigmatau: --style paper needs a figure, e.g. --plot p.pdf\n")

    def test_every_kind_of_fit_has_the_published_form(self, tmp_path, capsys):
        """Adequate with a ramp, with a line, widened, too short."""
        schema = published()
        t = np.arange(2**16) / 100
        white = np.random.default_rng(2).standard_normal(2**16)
        cases = {
            "ramp": (white + 1e-2 * t, "adequate"),
            "line": (white + np.sin(2 * np.pi * 23.3 * t), "adequate_with"),
            "lines": (white + 0.3 * np.sin(0.3 * t) + 0.3 * np.sin(2 * t), "widened"),
            "short": (white[:30], "too_short"),
        }
        for name, (y, verdict) in cases.items():
            log = tmp_path / f"{name}.csv"
            np.savetxt(log, y, header="gyro_x [deg/s]", comments="")
            options = ("--rate", 100, "-v", "--at-rest", "--json", tmp_path / "r.json")
            code, out, err = run("analyze", log, *options, capsys=capsys)
            assert code == 0
            text = (tmp_path / "r.json").read_text()
            content = json.loads(text, parse_constant=lambda c: pytest.fail(f"{c} in JSON"))
            schema.validate(content)
            fit = content["channels"]["gyro_x"]["fit"]
            assert fit["verdict"] == verdict, name
            assert bool(fit["terms"]["sinusoid"]) == (name in ("line", "lines"))
            assert ("gyro_x: not" in err) == (verdict == "too_short")
            assert ("the model fits roughly" in out) == (verdict == "widened")
            assert ("no fit: " in out) == (verdict == "too_short")

    def test_json_has_the_published_form(self, log, capsys):
        schema = published()
        code, out, _ = run("analyze", log, "--rate", 100, "--json", "-", "--taus", "quarter", capsys=capsys)
        assert code == 0
        content = json.loads(out, parse_constant=lambda c: pytest.fail(f"{c} in JSON"))
        schema.validate(content)
        gyro = content["channels"]["gyro_x"]
        assert gyro["read_off"]["random_walk"]["unit"] == "rad/sqrt(s)"
        assert gyro["curve"]["tau_s"][0] == 0.01
        assert gyro["curve"]["unit"] == "rad/s"

    def test_a_log_that_fails_leaves_a_result_that_says_so(self, log, tmp_path, capsys):
        """In place of an earlier one; no reader takes it for a result."""
        schema = published()
        result = tmp_path / "r.json"
        assert run("analyze", log, "--rate", 100, "--json", result, capsys=capsys)[0] == 0
        assert json.loads(result.read_text())["channels"]
        for more, code, words in (((), 2, "--rate HZ"), (("--rate", 100, "--window", "9h:10h"), 2, "--window")):
            found, _, err = run("analyze", log, *more, "--json", result, capsys=capsys)
            content = json.loads(result.read_text())
            schema.validate(content)
            assert (found, content["error"]["exit_code"], content["channels"]) == (code, code, {})
            assert words in content["error"]["message"]
            assert content["error"]["message"] in err
        for command in (
            ("export", result, "--to", "kalibr"),
            ("compare", result),
            ("plan", result, "--term", "random_walk"),
            ("predict", result, "--after", "60s"),
        ):
            found, _, err = run(*command, capsys=capsys)
            assert found == 1
            assert "the analysis failed: " in err
        found, out, _ = run("analyze", tmp_path / "none.csv", "--json", "-", capsys=capsys)
        assert (found, json.loads(out)["error"]["exit_code"]) == (1, 1)

    def test_results_of_schema_1_are_read_and_newer_ones_are_not(self, log, tmp_path, capsys):
        result = tmp_path / "r.json"
        assert run("analyze", log, "--rate", 100, "--json", result, capsys=capsys)[0] == 0
        content = json.loads(result.read_text())
        for channel in content["channels"].values():
            del channel["trust"]
        for schema, code in ((1, 0), (3, 1)):
            result.write_text(json.dumps(content | {"schema": schema}))
            found, _, err = run("export", result, "--to", "ieee952", capsys=capsys)
            assert found == code
            assert ("of a newer version of sigmatau" in err) == (code == 1)

    def test_csv(self, log, tmp_path, capsys):
        """Coefficients and curves, as they are in the JSON."""
        files = ("--csv", tmp_path / "r.csv", "--json", tmp_path / "r.json")
        assert run("analyze", log, "--rate", 100, *files, capsys=capsys)[0] == 0
        content = json.loads((tmp_path / "r.json").read_text())["channels"]
        rows = list(csv.DictReader((tmp_path / "r.csv").read_text().splitlines()))
        walk = next(row for row in rows if (row["channel"], row["term"]) == ("gyro_x", "random_walk"))
        fitted = content["gyro_x"]["fit"]["terms"]["random_walk"]
        assert [float(walk[name]) for name in ("value", "low", "high")] == [fitted[n] for n in ("value", "low", "high")]
        assert (walk["unit"], walk["trust"]) == (fitted["unit"], content["gyro_x"]["trust"])
        curves = list(csv.DictReader((tmp_path / "r-curves.csv").read_text().splitlines()))
        assert [float(row["adev"]) for row in curves if row["channel"] == "gyro_x"] == content["gyro_x"]["curve"][
            "adev"
        ]
        assert run("analyze", log, "--rate", 100, "--csv", tmp_path / "r.txt", capsys=capsys)[0] == 2

    def test_every_averaging_time(self, one, tmp_path, capsys):
        """The curve has them all; the fit is that of the default grid, the reading that of eight an octave of them."""
        schema = published()
        figure, result = tmp_path / "all.svg", tmp_path / "all.json"
        command = ["analyze", one, "--rate", 100]
        code, table, _ = run(*command, "-v", "--taus", "all", "--plot", figure, "--json", result, capsys=capsys)
        assert code == 0
        content = json.loads(result.read_text(encoding="utf-8"))
        schema.validate(content)
        default = json.loads(run(*command, "--json", "-", capsys=capsys)[1])
        for name, channel in content["channels"].items():
            curve, samples = channel["curve"], channel["samples"]
            assert curve["m"] == list(range(1, samples // 2 + 1))
            assert {len(curve[key]) for key in ("tau_s", "adev", "low", "high", "edf", "n_pairs")} == {samples // 2}
            assert channel["fit"] == default["channels"][name]["fit"]
        assert "the model fits" in table
        assert figure.stat().st_size < 500_000

    @pytest.mark.parametrize("ending", ["svg", "pdf", "png"])
    def test_figures(self, one, tmp_path, ending, capsys):
        path = tmp_path / f"a.{ending}"
        options = ("--rate", 100, "--method", "read-off", "--plot", path, "-q")
        assert run("analyze", one, *options, capsys=capsys)[0] == 0
        assert path.stat().st_size > 5000

    def test_the_same_result_whatever_the_input_kind(self, tmp_path, capsys):
        y = np.random.default_rng(1).standard_normal(3000)
        forms = {
            "rate": (y, "deg/s"),
            "increments": (y / 50 * 3600, "arcsec"),
            "accumulated": (np.concatenate(([0], np.cumsum(y))) / 50, "deg"),
        }
        tables = []
        for kind, (values, unit) in forms.items():
            path = tmp_path / f"{kind}.txt"
            np.savetxt(path, values, fmt="%.17g")
            code, out, _ = run(
                "analyze", path, "--rate", 50, "--channels", "gyro_x=1", "--unit", f"gyro={unit}", "--input", kind,
                capsys=capsys,
            )  # fmt: skip
            assert code == 0
            tables.append(out)
        assert len({table.partition(": ")[2] for table in tables}) == 1  # but for the names of the logs

    def test_scale_and_offset(self, tmp_path, log, capsys):
        volts = tmp_path / "volts.csv"
        y = np.loadtxt(log, delimiter=",", skiprows=1)[:, 0]
        np.savetxt(volts, 2.5 + y * 0.02, header="gyro_x", comments="", fmt="%.12g")
        args = ["--rate", 100, "--unit", "gyro=deg/s", "--scale", "gyro=50", "--offset", "gyro_x=2.5", "--json", "-"]
        args += ["--method", "read-off"]
        _, out, _ = run("analyze", volts, *args, capsys=capsys)
        _, expected, _ = run("analyze", log, "--rate", 100, "--json", "-", "--method", "read-off", capsys=capsys)
        a, b = (json.loads(t)["channels"]["gyro_x"]["curve"]["adev"] for t in (out, expected))
        assert a == pytest.approx(b, rel=1e-9)  # the twelve digits written

    def test_constant_channel_is_a_finding(self, tmp_path, capsys):
        path = tmp_path / "c.csv"
        rows = table().splitlines()
        path.write_text("\n".join([rows[0], *(f"0.5,{r.split(',', 1)[1]}" for r in rows[1:])]))
        code, out, err = run("analyze", path, "--rate", 100, capsys=capsys)
        assert code == 0
        assert "gyro_x" not in out
        assert "gyro_y" in out
        assert err.startswith("!! gyro x: 1200 samples of")

    def test_an_even_growth_is_a_constant_rate(self, tmp_path, capsys):
        """Accumulated angle of a constant rate: what is left is rounding."""
        path = tmp_path / "c.txt"
        np.savetxt(path, np.cumsum(np.full(20_000, 0.1)), fmt="%.17g")
        args = ["--rate", 10, "--channels", "gyro_x=1", "--unit", "gyro=deg", "--input", "accumulated"]
        code, _, err = run("analyze", path, *args, capsys=capsys)
        assert code == 1
        assert "no channel is left" in err

    def test_only_constant_channels(self, tmp_path, capsys):
        path = tmp_path / "c.csv"
        path.write_text("gyro_x [deg/s]\n" + "1\n" * 50)
        code, out, err = run("analyze", path, "--rate", 100, capsys=capsys)
        assert (code, out) == (1, "")
        assert "no channel is left" in err

    def test_no_imu(self, field_data, capsys):
        code, out, _ = run(
            "analyze", field_data / "phasedat" / "PHASE.DAT", "--channels", "phase=1", "--unit", "phase=s",
            "--input", "accumulated", "--rate", 1, "--taus", "octave", "--json", "-", capsys=capsys,
        )  # fmt: skip
        assert code == 0
        curve = json.loads(out)["channels"]["phase"]["curve"]
        assert f"{curve['adev'][0]:.4e}" == "2.9223e-01"  # Stable32, phase_dat_oadev_octave.txt
        assert curve["n_pairs"][0] == 999


def _gz(text):
    return gzip.compress(text.encode())


ROWS = table().splitlines()
NO_UNITS = table(header="gyro_x,gyro_y,accel_z").encode()


def _with(line, text):
    rows = list(ROWS)
    rows[line] = text
    return "\n".join(rows) + "\n"


# name: (bytes of the file or None for a directory, options, exit code, words that the line must have)
BAD = {
    "empty": (b"", [], 1, ["empty"]),
    "text only": (b"once upon a time\nthere was a gyro\n", [], 1, []),
    "one row": ((ROWS[0] + "\n" + ROWS[1] + "\n").encode(), ["--rate", "100"], 1, ["4"]),
    "three rows": (("\n".join(ROWS[:4]) + "\n").encode(), ["--rate", "100"], 1, ["3", "4"]),
    "short row": (_with(18, "1.0,2.0").encode(), ["--rate", "100"], 1, ["line 19", "2", "3"]),
    "word": (_with(18, "1.0,oops,2.0").encode(), ["--rate", "100"], 1, ["line 19", "oops"]),
    "time backwards": (
        b"time [s],gyro_x [deg/s]\n" + b"".join(b"%.2f,%d\n" % (0.01 * (k if k != 30 else 20), k % 7) for k in range(50)),
        [],
        1,
        ["line 32", "back"],
    ),
    "unknown unit": (NO_UNITS, ["--rate", "100", "--unit", "gyro=furlong,accel=g"], 2, ["furlong"]),
    "no unit": (NO_UNITS, ["--rate", "100"], 2, ["--unit", "gyro"]),
    "no rate": (table().encode(), [], 2, ["--rate"]),
    "wrong column": (table().encode(), ["--rate", "100", "--channels", "gyro_x=omega"], 2, ["omega", "gyro_y"]),
    "directory": (None, ["--rate", "100"], 1, ["directory"]),
    "damaged gzip": (_gz(table(4000))[:-8] + bytes(8), ["--rate", "100"], 1, ["gzip", "compressed"]),
    "one column twice": (table().encode(), ["--rate", "100", "--channels", "gyro_x=1,gyro_y=1"], 2, ["column 1", "twice"]),
    "output no file": (table().encode(), ["--rate", "100", "--plot", "pipe.png"], 1, ["pipe.png", "not a regular file"]),
    "unknown option": (table().encode(), ["--ratte", "100"], 2, ["ratte"]),
    "rate no number": (table().encode(), ["--rate", "fast"], 2, ["fast"]),
    "rate zero": (table().encode(), ["--rate", "0"], 2, ["rate"]),
    "unit without =": (table().encode(), ["--rate", "100", "--unit", "deg/s"], 2, ["--unit"]),
    "taus no number": (table().encode(), ["--rate", "100", "--taus", "often"], 2, ["often"]),
    "tau too long": (table().encode(), ["--rate", "100", "--taus", "100"], 2, ["half the record"]),
    "rate unit for increments": (table().encode(), ["--rate", "100", "--input", "increments"], 2, ["deg/s", "increments"]),
    "figure of unknown kind": (table().encode(), ["--rate", "100", "--plot", "a.bmp"], 2, [".png"]),
    "figure nowhere": (table().encode(), ["--rate", "100", "--plot", "absent/a.png"], 1, ["absent"]),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_bad_input(name, tmp_path, monkeypatch, capsys):
    """One clear line that names the file or option, the documented exit code, and no output but a JSON that says so."""
    content, options, code, words = BAD[name]
    monkeypatch.chdir(tmp_path)
    path = tmp_path / ("log.csv.gz" if name == "damaged gzip" else "log.csv")
    if content is None:
        path.mkdir()
    else:
        path.write_bytes(content)
    outputs = [] if "--plot" in options else ["--plot", "out.png"]
    if name == "output no file":
        os.mkfifo("pipe.png")
    got, out, err = run("analyze", path, *options, *outputs, "--json", "out.json", capsys=capsys)
    assert got == code, err
    assert out == ""
    assert len(err.splitlines()) == 1, err
    assert err.startswith("sigmatau: ")
    assert any(word in err for word in words) if name == "damaged gzip" else all(word in err for word in words), err
    left = {p.name for p in tmp_path.iterdir()} - {"pipe.png", path.name}
    assert left <= {"out.json"}
    if left:  # not for an option that is refused before the log is read
        content = json.loads((tmp_path / "out.json").read_text())
        assert (content["error"]["exit_code"], content["channels"]) == (code, {})


def test_a_log_that_is_cut_off_is_analysed_and_said_so(tmp_path, capsys):
    path = tmp_path / "log.csv.gz"
    path.write_bytes(_gz(table(4000))[:20000])
    code, out, err = run("analyze", path, "--rate", "100", capsys=capsys)
    assert code == 4
    assert "gyro_x" in out
    assert "!! the gzip stream is truncated in line" in err


def test_the_log_is_never_overwritten(log, tmp_path, capsys):
    before = log.read_bytes()
    for option in ("--json", "--plot"):
        name = log if option == "--json" else tmp_path / "log.png"
        if option == "--plot":
            name.hardlink_to(log)
        code, out, err = run("analyze", log, "--rate", 100, option, name, capsys=capsys)
        assert (code, out) == (2, "")
        assert "is the file that is read" in err
    assert log.read_bytes() == before


def test_the_log_is_not_overwritten_by_the_curves_beside_a_csv(tmp_path, capsys):
    log = tmp_path / "run-curves.csv"
    log.write_text(table())
    code, out, err = run("analyze", log, "--rate", 100, "--csv", tmp_path / "run.csv", capsys=capsys)
    assert (code, out) == (2, "")
    assert "run-curves.csv is the file that is read" in err
    assert log.read_text() == table()
    files = ("--csv", tmp_path / "r.csv", "--json", tmp_path / "r-curves.csv")
    code, out, err = run("analyze", log, "--rate", 100, *files, capsys=capsys)
    assert (code, out) == (2, "")
    assert "both name" in err


def test_two_outputs_of_one_name(log, tmp_path, capsys):
    path = tmp_path / "a.png"
    code, _, err = run("analyze", log, "--rate", 100, "--plot", path, "--json", path, capsys=capsys)
    assert code == 2
    assert "both name" in err


def test_scale_as_a_fraction(tmp_path, log, capsys):
    args = ["analyze", log, "--rate", 100, "--method", "read-off", "--json", "-", "--scale"]
    one, other = (
        json.loads(run(*args, f"gyro={s}", capsys=capsys)[1])["channels"]["gyro_x"]["curve"]["adev"]
        for s in ("1/8", "0.125")
    )
    assert one == other
    assert run(*args, "gyro=1/0", capsys=capsys)[0] == 2


def test_full_disk(log):
    with open("/dev/full", "w") as full:  # noqa: PTH123
        done = subprocess.run(
            [sys.executable, "-m", "sigmatau", "analyze", str(log), "--rate", "100", "--method", "read-off"],
            stdout=full, stderr=subprocess.PIPE, text=True, check=False,
        )  # fmt: skip
    assert done.returncode == 1
    assert done.stderr.startswith("sigmatau: standard output cannot be written")
    assert len(done.stderr.splitlines()) == 1


def test_as_a_module_on_a_terminal_without_unicode(one):
    done = subprocess.run(
        [sys.executable, "-m", "sigmatau", "analyze", str(one), "--rate", "100"],
        capture_output=True, text=True, check=True, env={**os.environ, "PYTHONIOENCODING": "ascii"},
    )  # fmt: skip
    assert "random walk" in done.stdout
    assert "deg/sqrt(h)" in done.stdout
    assert done.stderr == "More: -v * report: --report r.html * filter: --export state-space=model.json\n"


class TestSimulate:
    MODEL = '[channels.gyro_x]\nrandom_walk = "0.3 deg/sqrt(h)"\n'

    def test_log(self, tmp_path, capsys):
        (tmp_path / "m.toml").write_text(self.MODEL)
        args = ["simulate", tmp_path / "m.toml", "--hours", 0.1, "--rate", 50, "--seed", 3, "-o"]
        assert run(*args, tmp_path / "a.csv", capsys=capsys)[0] == 0
        code, out, err = run(*args, tmp_path / "b.csv", capsys=capsys)
        assert (code, out) == (0, "")
        assert "18000 samples of 1 channel, seed 3" in err
        assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()
        assert (tmp_path / "a.csv").read_text().splitlines()[0] == "time [s],gyro_x [rad/s]"
        code, out, _ = run("analyze", tmp_path / "a.csv", "--json", "-", capsys=capsys)
        read = json.loads(out)["channels"]["gyro_x"]["read_off"]["random_walk"]
        assert read["value"] == pytest.approx(np.deg2rad(0.3) / 60, rel=0.05)

    @pytest.mark.parametrize(
        ("options", "code"),
        [
            (["--hours", "-1", "--rate", "10", "-o", "a.csv"], 2),
            (["--hours", "1", "--rate", "0", "-o", "a.csv"], 2),
            (["--hours", "1e9", "--rate", "1000", "-o", "a.csv"], 2),
            (["--hours", "1", "--rate", "10", "-o", "a.xlsx"], 2),
            (["--hours", "1", "--rate", "10", "-o", "absent/a.csv"], 1),
            (["--hours", "1", "--rate", "10", "--seed", "-1", "-o", "a.csv"], 2),
            (["--hours", "1", "--rate", "10"], 2),
        ],
    )
    def test_wrong_options(self, tmp_path, monkeypatch, options, code, capsys):
        monkeypatch.chdir(tmp_path)
        (tmp_path / "m.toml").write_text(self.MODEL)
        got, out, err = run("simulate", "m.toml", *options, capsys=capsys)
        assert (got, out) == (code, "")
        assert len(err.splitlines()) == 1
        assert [p.name for p in tmp_path.iterdir()] == ["m.toml"]


@pytest.mark.parametrize(("text", "seconds"), [("0.5", 0.5), ("500ms", 0.5), ("10min", 600.0), ("2 h", 7200.0)])
def test_times_are_seconds_or_have_a_unit(text, seconds):
    arguments = Settings(tau_min=text, taus=f"0.1,{text}").arguments()
    assert (arguments["tau_min"], arguments["taus"]) == (seconds, [0.1, seconds])
    assert Choosing(step=text).choices().step == seconds


@pytest.mark.parametrize(
    "argv", [["--help"], ["analyze", "--help"], ["simulate", "--help"], ["demo", "--help"], ["--version"]]
)
def test_help(argv, capsys):
    code, out, err = run(*argv, capsys=capsys)
    assert (code, err) == (0, "")
    assert "sigmatau" in out


@pytest.mark.parametrize("words", ["", "analyze", "store trend"])
def test_help_as_a_word(words, capsys):
    code, out, err = run("help", *words.split(), capsys=capsys)
    assert (code, out, err) == run(*words.split(), "--help", capsys=capsys)
    assert (code, err) == (0, "")
    assert out.startswith(f"Usage: sigmatau {words}".rstrip())


@pytest.mark.parametrize(("option", "after"), [("export --to", ""), ("analyze --export", "=")])
def test_the_shell_completes_targets(option, after, capsys):
    code, out, _ = run("__complete", *option.split(), "ka", capsys=capsys)
    assert code == 0
    assert f"kalibr{after}" in [line.partition("\t")[0] for line in out.splitlines()]


def test_help_has_examples(capsys):
    assert "--channels time=1,gyro=2:4" in run("analyze", "--help", capsys=capsys)[1]


def test_a_figure_needs_no_backend(one, tmp_path):
    figure = tmp_path / "p.png"
    done = subprocess.run(
        [sys.executable, "-m", "sigmatau", "analyze", one, "--rate", "100", "--method", "read-off", "--plot", figure],
        capture_output=True, text=True, check=False, env={**os.environ, "MPLBACKEND": "not_installed"},
    )  # fmt: skip
    assert (done.returncode, figure.exists()) == (0, True), done.stderr


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        *[(name, "random_walk") for name in ("arw", "VRW", "N", "angle random walk", "noise_density")],
        *[("B", "bias_instability"), ("1/f-noise", "bias_instability"), ("rrw", "rate_random_walk")],
        *[("K", "rate_random_walk"), ("R", "rate_ramp"), ("Q", "quantization (IEEE 952) or random_walk")],
        ("walk", None),
    ],
)
def test_other_names_of_terms(name, meant, tmp_path, capsys):
    model = tmp_path / "m.toml"
    model.write_text(TestSimulate.MODEL)
    code, _, err = run("plan", model, "--term", name, "--rate", 100, "--hours", 1, capsys=capsys)
    assert code == 2
    said = f"it is {meant}" if meant else "terms: quantization, random_walk,"
    assert f"--term: unknown term {name!r}; {said}" in err


@pytest.mark.parametrize(
    ("kind", "said"),
    [
        ("mdev", "write modified"),
        ("hdev", "write hadamard"),
        ("adev", "sigmatau analyze"),
        ("x", "unknown; kinds: mod"),
    ],
)
def test_other_names_of_deviations(kind, said, capsys):
    code, _, err = run("deviation", "a.csv", "--kind", kind, capsys=capsys)
    assert code == 2
    assert f"--kind '{kind}': " in err
    assert said in err


class TestWhatIsTypedInstead:
    @pytest.mark.parametrize(
        ("words", "message"),
        [
            ("lot a.json --datasheet adis16405", "unknown option --datasheet: the specification is --spec"),
            ("compare a.json --spec adis16405", "sigmatau lot RESULTS --spec NAME"),
            ("analyze a.csv -o imu.yaml", "--export TARGET=FILE"),
            ("export a.json vins-mono", "the target is --to vins"),
            ("export a.json --openvins imu.yaml", "unknown option --openvins: the target is --to openvins"),
            ("export a.json b.json", "'b.json' not expected here"),
            ("datasheet", "sigmatau datasheet list, or"),
            ("datasheet adis16405", "sigmatau datasheet show adis16405"),
            ("analyze a.csv --jsn x", "Did you mean --json?"),
            ("predict a.json", "--after is missing; see sigmatau predict --help"),
            ("analyze a.csv --report", "--report needs a value"),
            ("analyze a.csv --rate 100Hz", "--rate '100Hz': must be a number without a unit"),
            ("simulate imu.toml --rate 1 -o a.csv", "simulate: --hours is missing; see sigmatau simulate --help"),
            ("simulate imu.toml --minutes 9 --rate 1 -o a.csv", "unknown option --minutes: the length is --hours"),
            ("psd", "psd: LOG is missing; see sigmatau psd --help"),
        ],
    )
    def test_the_message_has_what_to_type(self, words, message, capsys):
        code, out, err = run(*words.split(), capsys=capsys)
        assert (code, out) == (2, "")
        assert message in err
        assert err.count("\n") == 1

    @pytest.mark.parametrize(
        ("words", "message"),
        [
            (["--plot", "p.png"], "pip install 'sigmatau[plot]'"),
            (["--stability", "p.png"], "pip install 'sigmatau[plot]'"),
            (["--report", "r.pdf"], "pip install 'sigmatau[pdf]'"),
            (["--jobs", "2", "--plot", "plots"], "pip install 'sigmatau[plot]'"),
        ],
    )
    def test_a_missing_library_is_told_before_the_log_is_read(self, words, message, tmp_path, monkeypatch, capsys):
        monkeypatch.chdir(tmp_path)
        (tmp_path / "log.csv").write_text("not a log\n")
        find = importlib.util.find_spec
        monkeypatch.setattr(
            importlib.util, "find_spec", lambda name, *a: None if name in ("matplotlib", "typst") else find(name, *a)
        )
        code, out, err = run("analyze", "log.csv", *words, "--json", "r", capsys=capsys)
        assert (code, out) == (1, "")
        assert message in err
        assert [path.name for path in tmp_path.iterdir()] == ["log.csv"]


def test_findings_of_inspect_are_as_wide_as_the_terminal(tmp_path, monkeypatch, capsys):
    rows = np.c_[np.delete(np.arange(600) / 100, slice(200, 250)), np.random.default_rng(seed=6).standard_normal(550)]
    np.savetxt(tmp_path / "log.csv", rows, delimiter=",", header="time [s],gyro_x [rad/s]", comments="")
    monkeypatch.setenv("COLUMNS", "60")
    piped = run("inspect", tmp_path / "log.csv", capsys=capsys)[1]
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    out = run("inspect", tmp_path / "log.csv", capsys=capsys)[1]
    assert out.split() == piped.split()
    told = out[out.index("warning:") :]
    assert max(map(len, told.splitlines())) <= 60 < max(map(len, piped.splitlines()))


def test_a_gap_of_several_tables_is_one_line():
    gap = Finding(details=Damaged(truncated=True, what="array", kept=600, declared=1000), severity="error")
    assert len(finding_lines([gap, replace(gap)])) == len(finding_lines([gap]))


def test_elements_of_an_array_are_one_line_of_inspect(tmp_path, capsys):
    names = [
        "time [s]",
        *(f"covariance[{k}]" for k in range(9)),
        "gyro_x [rad/s]",
        "a[0]",
        "a[1]",
        "b[0]",
        "b[2]",
        "b[3]",
    ]
    rows = np.random.default_rng(seed=5).standard_normal((300, len(names)))
    rows[:, 0] = np.arange(300) / 100
    np.savetxt(tmp_path / "log.csv", rows, delimiter=",", header=",".join(names), comments="")
    _, out, _ = run("inspect", tmp_path / "log.csv", capsys=capsys)
    listed = [line.split(maxsplit=1) for line in out.splitlines() if re.match(r"\s+\d+(:\d+)? \S", line)]
    assert [number for number, _ in listed[1:]] == ["1", "2:10", "11", "12", "13", "14", "15", "16"]
    assert listed[2][1] == "covariance[0] … [8]"
