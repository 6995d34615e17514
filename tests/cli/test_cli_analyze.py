"""`sigmatau analyze` as a user meets it: output, files and messages."""

import csv
import json
import re
import subprocess
import sys

import numpy as np
import pytest
from small_log import published, run, table

from sigmatau import Analysis


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

    @pytest.mark.parametrize("method", ["read-off", "likelihood"])
    def test_a_line_of_another_slope_is_refused_or_forced(self, log, method, capsys):
        options = ("analyze", log, "--rate", 100, "--method", method, "--read-off-at", "gyro_x.rate_ramp=20ms:500ms")
        code, out, err = run(*options, capsys=capsys)
        assert code == 0
        refusal = r"reach\s+the\s+curve\s+there,\s+which\s+has\s+the\s+slope\s+-0\.[45]\d+\s+±\s+0\.\d+,\s+not\s+\+1"
        assert re.search(refusal, out + err)
        assert "--force draws a refused line" in err
        _, out, err = run(*options, "--json", "-", capsys=capsys)
        assert re.search(refusal, err)
        channel = json.loads(out)["channels"]["gyro_x"]
        plain = channel["read_off"]
        assert list(plain) == ["random_walk"]
        (line,) = channel["refused_lines"]
        assert line["term"] == "rate_ramp"
        assert abs(line["slope"] + 0.5) < 4 * line["slope_error"]
        assert Analysis.from_json(out).to_dict()["channels"]["gyro_x"]["refused_lines"] == [line]
        _, out, err = run(*options, "--force", "--json", "-", capsys=capsys)
        assert "refused_lines" not in json.loads(out)["channels"]["gyro_x"]
        forced = json.loads(out)["channels"]["gyro_x"]["read_off"]
        assert forced["rate_ramp"]["forced"] is True
        assert forced["random_walk"] == plain["random_walk"]
        assert "--force" not in err

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
        assert (code, "--terms apply to fitted coefficients" in err) == (2, True)
        code, out, _ = run("analyze", log, "--rate", 100, "--terms", "random_walk", capsys=capsys)
        assert out.count("not fitted") == 6

    @pytest.mark.parametrize("command", ["analyze", "psd", "deviation"])
    def test_style_of_a_paper(self, log, command, tmp_path, capsys):
        """300 dots an inch instead of 120, and half the width in inches."""
        from matplotlib.image import imread

        kind = ("--kind", "hadamard") if command == "deviation" else ()
        shapes = []
        for style in ("screen", "paper"):
            path = tmp_path / f"{style}.png"
            options = (command, log, "--rate", 100, *kind, "--plot", path, "--style", style)
            assert run(*options, capsys=capsys)[0] == 0
            shapes.append(imread(path).shape)
        assert shapes[1][1] == pytest.approx(300 / 120 * 0.5 * shapes[0][1], abs=2)
        code, _, err = run(command, log, "--rate", 100, *kind, "--style", "paper", capsys=capsys)
        assert (code, err) == (2, "sigmatau: --style paper needs a figure, e.g. --plot p.pdf\n")

    def test_every_kind_of_fit_has_the_published_form(self, tmp_path, capsys):
        """Adequate with a ramp, with lines, widened beside a band that lacks power, too short."""
        schema = published()
        t = np.arange(2**16) / 100
        white = np.random.default_rng(2).standard_normal(2**16)
        spectrum, frequency = np.fft.rfft(white), np.fft.rfftfreq(2**16, 0.01)
        spectrum[(frequency > 0.5) & (frequency < 0.9)] *= 0.75
        cases = {
            "ramp": (white + 1e-2 * t, "adequate"),
            "line": (white + np.sin(2 * np.pi * 23.3 * t), "adequate_with"),
            "lines": (white + 0.3 * np.sin(0.3 * t) + 0.3 * np.sin(2 * t), "adequate_with"),
            "notch": (np.fft.irfft(spectrum), "widened"),
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

    def test_no_imu(self, field_data, capsys):
        code, out, _ = run(
            "analyze", field_data / "phasedat" / "PHASE.DAT", "--channels", "phase=1", "--unit", "phase=s",
            "--input", "accumulated", "--rate", 1, "--taus", "octave", "--json", "-", capsys=capsys,
        )  # fmt: skip
        assert code == 0
        curve = json.loads(out)["channels"]["phase"]["curve"]
        assert f"{curve['adev'][0]:.4e}" == "2.9223e-01"  # Stable32, phase_dat_oadev_octave.txt
        assert curve["n_pairs"][0] == 999
