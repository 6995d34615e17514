"""The benchmark's own code: it runs from end to end on tiny records, and its pages say what was measured."""

import json
import re
import subprocess
import sys

import pytest
from benches import curves, instructions, kernels, text
from benches.measure import status_bytes, turns

from conftest import ROOT


def test_turns():
    order = []
    calls = {name: lambda name=name: order.append(name) for name in "ab"}
    medians = turns(calls, 3, fewer={"a": 1})
    assert "".join(order) == "abbb"
    assert set(medians) == {"a", "b"}
    assert min(medians.values()) > 0


def test_memory_of_this_process():
    assert 0 < status_bytes("VmRSS") <= status_bytes("VmHWM")
    with pytest.raises(RuntimeError, match="VmNone"):
        status_bytes("VmNone")


def test_gates_are_honest():
    assert text.at_least("a", 15.0, 15).passed
    assert not text.at_least("a", 14.99, 15).passed
    assert not text.at_most("a", 8.01, 8, "ns").passed
    assert text.gates([text.at_most("a", 8.04, 8, "ns")])[0] == "- a: target ≤ 8 ns, measured 8.04 ns: **not reached**"


@pytest.mark.parametrize(
    ("value", "expected"), [(12.3456, "12.3 s"), (0.0999, "99.9 ms"), (1.2e-4, "120 µs"), (1.0, "1.00 s")]
)
def test_seconds(value, expected):
    assert text.seconds(value) == expected


def test_probes():
    assert kernels.parse("roof 70.5 ps\nread_memory 15 GB/s\n") == {"roof": 70.5, "read_memory": 15.0}


def test_every_counted_work_has_its_limit():
    stored = json.loads(instructions.STORED.read_text(encoding="utf-8"))
    assert set(stored) == set(instructions.LESS)
    assert set(json.loads(instructions.STORED_JOB.read_text(encoding="utf-8"))) == {"python", "numpy", "instructions"}
    works = (ROOT / "crates" / "formats" / "examples" / "instructions.rs").read_text(encoding="utf-8")
    (listed,) = re.findall(r'const WORKS: &str = "(.*)";', works)
    assert set(listed.split(", ")) == set(instructions.LESS) | {"nothing"}


def test_the_power_of_a_cost_is_its_largest_slope():
    rows = [{"number": n, "cpu": cpu} for n, cpu in [(0, 1.0), (1, 1.0), (10, 1.0), (100, 100.0), (1000, 1000.0)]]
    assert curves.largest_power(rows) == pytest.approx(2.0)
    measured = dict.fromkeys(curves.TITLES, rows)
    lines, gates = curves.write(measured)
    assert len(gates) == len(curves.TITLES)
    assert not any(gate.passed for gate in gates)
    assert sum("1.00 s | 1.00 s | 1.00 s | 100 s | 1000 s | **2.00**" in line for line in lines) == len(measured)


def test_growth(tmp_path):
    from benches import growth

    command = [sys.executable, "-m", "benches.growth", "ours", "1000000", "0"]
    assert int(subprocess.run(command, cwd=ROOT, check=True, capture_output=True).stdout) > 8e6  # the phase
    row = {
        "samples": 1000,
        "taus": 9,
        "seconds": dict.fromkeys(growth.PARTIES, 0.1),
        "memory": dict.fromkeys(growth.PARTIES, 10**6),
    }
    measured = {"lengths": [row, row | {"samples": 10_000}], "counts": [row, row | {"taus": 30}]}
    lines, gates = growth.write(measured)
    assert not gates
    assert sum(line.startswith(f"| {text.number(1000)} ") for line in lines) == 1
    growth.draw(measured, tmp_path)
    assert all((tmp_path / f"performance-{name}.svg").stat().st_size > 1000 for name in ("samples", "taus"))


def test_a_run_from_end_to_end(tmp_path, monkeypatch):
    from benches import run

    # All that needs no compiler, but growth, which starts 36 processes, and the job, whose log is long at any scale.
    parts = ["peers", "processes", "stream", "simulation", "curves", "fits", "checks"]
    command = ["run", "--rounds", "1", "--scale", "0.001", "--only", *parts]
    folders = ["--cache", str(tmp_path)]  # the page of docs is not replaced by one that is not whole
    monkeypatch.chdir(ROOT)
    monkeypatch.setattr(sys, "argv", [*command, *folders])
    run.main()
    page = (tmp_path / "performance.md").read_text(encoding="utf-8")
    for figure in re.findall(r"\]\((figures/.*?)\)", page):
        assert (tmp_path / figure).stat().st_size > 1000
    assert page.count("not reached") + page.count("| reached |") >= 10
    monkeypatch.setattr(sys, "argv", ["run", "--redraw", *folders])
    run.main()
    assert (tmp_path / "performance.md").read_text(encoding="utf-8") == page
