"""Options are declared once: one that is added is an argument, a command-line option, a key of the JSON, and described."""

import inspect
import json
import os
import shutil
import subprocess
import sys
from dataclasses import fields

import numpy as np
import pytest

import sigmatau
from conftest import ROOT
from sigmatau.analysis.options import AnalysisOptions
from sigmatau.errors import OptionError
from sigmatau.io.read.options import ReadOptions, TableOptions
from sigmatau.lab.lots.options import CompareOptions
from sigmatau.options import declared, options_that_differ, stated
from sigmatau.quality.options import InspectOptions

CALLS = {
    sigmatau.analyze: AnalysisOptions,
    sigmatau.read: ReadOptions,
    sigmatau.from_frame: TableOptions,
    sigmatau.inspect: InspectOptions,
    sigmatau.compare_runs: CompareOptions,
}
ADDED = """
    smoothing: float | None = field(
        default=None,
        metadata=option("Method", "Length of the smoothing.", "Default: none.", form="seconds", unit="s", kind="float"),
    )
    stability: bool"""
SCRIPT = """
import inspect, json, sys
import sigmatau
from sigmatau.cli import main
from sigmatau.lab.store.rows import options_key
assert "smoothing" in inspect.signature(sigmatau.analyze).parameters
assert "smoothing : float\\n        Length of the smoothing. Default: none. [s]" in sigmatau.analyze.__doc__
model = sigmatau.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
record = sigmatau.simulate(model, duration=60, rate=20, rng=1)
sigmatau.write(record, "log.csv")
in_python = sigmatau.analyze(record, smoothing=2, method="gls").to_dict()["options"]["analysis"]
assert main(["analyze", "log.csv", "--smoothing", "2s", "--method", "gls", "--json", "r.json", "-q"]) == 0
typed = json.load(open("r.json"))["options"]["analysis"]
assert in_python == typed == {"method": "gls", "smoothing": 2.0}
assert options_key({"analysis": typed}) != options_key({"analysis": {"method": "gls"}})
for command in ("analyze", "fleet"):
    assert main([command, "--help"]) in (0, None)
"""


@pytest.mark.parametrize("call", CALLS, ids=lambda call: call.__name__)
def test_the_signature_is_that_of_the_options(call):
    taken = dict(list(inspect.signature(call).parameters.items())[1:])
    options = CALLS[call]
    assert {name: one.default for name, one in taken.items()} == {one.name: one.default for one in fields(options)}
    assert {one.kind for one in taken.values()} == {inspect.Parameter.KEYWORD_ONLY}
    for name, about in declared(options).items():
        assert f"    {name} : " in call.__doc__
        assert about.text[:60].split(" see ")[0] in " ".join(call.__doc__.split())
    with pytest.raises(TypeError, match="unexpected keyword argument 'colour'"):
        call("log.csv", colour=1)


def test_an_option_that_is_added_is_everywhere(tmp_path):
    shutil.copytree(ROOT / "python" / "sigmatau", tmp_path / "sigmatau", ignore=shutil.ignore_patterns("__pycache__"))
    file = tmp_path / "sigmatau" / "analysis" / "options.py"
    text = file.read_text(encoding="utf-8")
    assert text.count("\n    stability: bool") == 1
    file.write_text(text.replace("\n    stability: bool", ADDED), encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT], cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(tmp_path), "COLUMNS": "80"},
        capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("--smoothing STR") == 2
    assert "Length of the smoothing." in done.stdout


def test_what_a_result_states():
    assert stated(AnalysisOptions()) == {}
    options = AnalysisOptions(taus=(1, 2), terms=("rate_random_walk", "random_walk"), keep=["spikes"], threads=4)
    assert stated(options) == {"taus": [1.0, 2.0], "terms": ["random_walk", "rate_random_walk"], "keep": ["spikes"]}
    assert "threads" in dict(options_that_differ(options))
    reading = ReadOptions(rate={"gyro": 100, "accel": 50}, unit={}, scale={"gyro": 2}, skip=0, max_expansion=5)
    assert stated(reading) == {"rate": {"gyro": 100.0, "accel": 50.0}, "scale": {"gyro": 2.0}}
    numbers = ReadOptions(rate=np.int64(100), skip=np.int32(0), interleaved=np.int64(2))
    assert json.dumps(stated(numbers)) == '{"rate": 100.0, "interleaved": 2}'
    arrays = AnalysisOptions(taus=np.array([1, 2]), method="gls", tau_min=np.float32(0.5))
    assert json.dumps(stated(arrays)) == '{"taus": [1.0, 2.0], "method": "gls", "tau_min": 0.5}'
    assert json.dumps(stated(ReadOptions(input="increments", skip=3))) == '{"input": "increments", "skip": 3}'


def test_choices_are_checked():
    for name, about in declared(AnalysisOptions).items():
        if about.choices:
            with pytest.raises(OptionError, match=f"`{name}` must be one of {', '.join(about.choices)}, not 'x'"):
                AnalysisOptions(**{name: "x"})


def test_a_result_has_its_options():
    model = sigmatau.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    record = sigmatau.simulate(model, duration=60, rate=20, rng=1)
    analysis = sigmatau.analyze(record, method="gls", taus=np.array([0.1, 1.0]), threads=1, notes={"run": "1"})
    assert analysis.options == AnalysisOptions(method="gls", taus=[0.1, 1.0])
    back = sigmatau.Analysis.from_json(analysis.to_json())
    assert back.options == analysis.options
    content = analysis.to_dict()
    assert content["options"]["analysis"] == {"method": "gls", "taus": [0.1, 1.0]}
    content["options"]["analysis"] |= {"of_another_version": 1}
    assert sigmatau.Analysis.from_dict(content).options == analysis.options
    content["options"]["analysis"] |= {"method": "guess"}
    with pytest.raises(sigmatau.DataError, match=r"options\.analysis: `method` must be one of"):
        sigmatau.Analysis.from_dict(content)
