"""The command line as a user meets it: output, files, messages, exit codes."""

import importlib.util
import json
import os
import re
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from small_log import run, table

from sigmatau.cli.choosing import Choosing
from sigmatau.cli.options import finding_lines
from sigmatau.cli.settings import AnalysisSettings
from sigmatau.findings.finding import Finding
from sigmatau.findings.reading import Damaged


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
    arguments = AnalysisSettings(tau_min=text, taus=f"0.1,{text}").arguments()
    assert (arguments["tau_min"], arguments["taus"]) == (seconds, [0.1, seconds])
    assert Choosing(step=text).choices().step == seconds


@pytest.mark.parametrize("words", ["", "analyze", "store trend"])
def test_help_as_a_word(words, capsys):
    code, out, err = run("help", *words.split(), capsys=capsys)
    assert (code, out, err) == run(*words.split(), "--help", capsys=capsys)
    assert (code, err) == (0, "")
    assert out.startswith(f"Usage: sigmatau {words}".rstrip()), out


@pytest.mark.parametrize(("option", "after"), [("export --to", ""), ("analyze --export", "=")])
def test_the_shell_completes_targets(option, after, capsys):
    code, out, _ = run("__complete", *option.split(), "ka", capsys=capsys)
    assert code == 0
    assert f"kalibr{after}" in [line.partition("\t")[0] for line in out.splitlines()]


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
