"""The commands of a store, from files of results to tables."""

import csv
import json
import sys
from datetime import UTC, datetime

import pytest

from conftest import ROOT
from sigmatau.cli import main
from sigmatau.lab.store.store import Store

sys.path.insert(0, str(ROOT / "tests" / "lab" / "store"))
from store_results import entry_of, result


@pytest.fixture
def lab(tmp_path, monkeypatch):
    """A folder of results of three units, two days each, of which one failed, and a store of them."""
    monkeypatch.chdir(tmp_path)
    for unit in range(3):
        folder = tmp_path / "results" / f"A{unit}"
        folder.mkdir(parents=True)
        for day in range(2):
            one = result(2 * unit + day, log=f"{unit} {day}", path=f"logs/A{unit}/2026-0{unit + 1}-1{day}.csv")
            (folder / f"day{day}.json").write_text(json.dumps(one))
    assert main(["store", "add", "results", "--store", "lab.db", "--date", "name", "--model", "tactical", "-q"]) == 0
    return tmp_path


def run(capsys, *argv):
    code = main(["store", *argv])
    out, err = capsys.readouterr()
    return code, out, err


def test_add_says_what_it_did(lab, capsys):
    assert run(capsys, "add", "results", "--store", "lab.db", "--date", "name") == (0, "", "0 new, 6 already there\n")
    (lab / "log.csv").write_text("gyro_x,gyro_y\n1,2\n")
    assert (
        "log.csv: not JSON, which sigmatau analyze --json writes"
        in run(capsys, "add", "log.csv", "--store", "lab.db")[2]
    )
    (lab / "results" / "cut.json").write_text('{"chan')
    code, out, err = run(capsys, "add", "results", "--store", "lab.db", "--date", "name")
    assert (code, out) == (1, "")
    first, last = err.splitlines()
    assert first.startswith("sigmatau: results/cut.json: not JSON: ")
    assert last == "0 new, 6 already there, 1 not added"


def test_unit_is_not_guessed(lab, capsys):
    code, _, err = run(capsys, "add", "results/A1/day1.json", "--store", "other.db")
    assert code == 2
    assert "its unit is not known; give --unit NAME" in err
    assert run(capsys, "add", "results/A1/day1.json", "--store", "other.db", "--unit", "A1")[0] == 0


def test_lists(lab, capsys):
    code, out, _ = run(capsys, "list", "--store", "lab.db")
    assert code == 0
    assert [line.split()[:3] for line in out.splitlines()[1:]] == [[f"A{k}", "tactical", "2"] for k in range(3)]
    _, out, _ = run(capsys, "list", "runs", "--store", "lab.db", "--unit", "A*", "--since", "2026-02-01", "--json")
    assert json.loads(out)["recorded"][0] == "2026-02-10T00:00:00Z"
    assert json.loads(out)["unit"] == ["A1", "A1", "A2", "A2"]
    assert run(capsys, "list", "--store", "lab.db", "--unit", "B")[1:] == ("", "no units of this kind in the store\n")


def test_an_empty_store_says_how_to_fill_it(lab, capsys):
    Store("empty.db").close()
    assert run(capsys, "list", "--store", "empty.db")[1:] == (
        "",
        "no units in the store; sigmatau store add adds results\n",
    )


def test_store_of_the_environment(lab, capsys, monkeypatch):
    monkeypatch.setenv("SIGMATAU_STORE", str(lab / "lab.db"))
    assert run(capsys, "list")[0] == 0
    monkeypatch.delenv("SIGMATAU_STORE")
    code, _, err = run(capsys, "list")
    assert code == 2
    assert "$SIGMATAU_STORE" in err
    assert main(["fleet", "analyze", "logs"]) == 2
    assert capsys.readouterr().err == err  # the same words


def test_show_has_every_interval(lab, capsys):
    code, out, _ = run(capsys, "show", "A2", "--store", "lab.db", "--json", "shown.json")
    assert code == 0
    assert out.startswith("A2: 2026-03-11.csv, tactical, 2026-03-11 00:00 UTC, 40 s\n")
    for line in out.splitlines()[2:]:
        assert "[" in line or "below" in line, line
    assert json.loads((lab / "shown.json").read_text()) == json.loads(
        (lab / "results" / "A2" / "day1.json").read_text()
    )
    code, out, _ = run(capsys, "show", "A2", "--store", "lab.db", "--run", "2026-03-10.csv")
    assert "2026-03-10 00:00 UTC" in out


def test_trend(lab, capsys):
    code, out, _ = run(capsys, "trend", "--store", "lab.db", "--channel", "gyro_x", "--json", "trend.json")
    assert code == 0
    assert [line.split()[0] for line in out.splitlines()[2:5]] == ["2026-01", "2026-02", "2026-03"]
    told = json.loads((lab / "trend.json").read_text())
    assert told["term"] == "random_walk"
    assert [one["units"] for one in told["channels"]["gyro_x"]["periods"]] == [1, 1, 1]


def test_two_outputs_of_a_trend_in_one_file_are_refused(lab, capsys):
    code, _, err = run(capsys, "trend", "--store", "lab.db", "--report", "t.html", "--json", "t.html")
    assert code == 2
    assert "name two files" in err
    assert not (lab / "t.html").exists()


def test_exports_are_the_table(lab, capsys):
    import pyarrow.parquet as parquet

    assert run(capsys, "export", "--store", "lab.db", "-o", "c.parquet")[2] == "written: c.parquet (108 rows)\n"
    assert run(capsys, "export", "--store", "lab.db", "-o", "c.csv")[0] == 0
    table = parquet.read_table(lab / "c.parquet").to_pylist()
    with (lab / "c.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(table)
    for row, one in zip(rows, table, strict=True):
        assert row["unit"] == one["unit"]
        assert datetime.fromisoformat(row["recorded"]) == one["recorded"].astimezone(UTC)
        for key in ("value", "low", "high", "upper_limit"):
            assert (float(row[key]) if row[key] else None) == one[key]
    first = json.loads((lab / "results" / "A0" / "day0.json").read_text())
    shown = first["channels"]["gyro_x"]["fit"]["terms"]["random_walk"]
    assert any(one["value"] == shown["value"] and one["low"] == shown["low"] for one in table)


@pytest.mark.parametrize("what", ["coefficients", "runs", "units"])
def test_types_of_columns_do_not_depend_on_their_values(lab, capsys, what):
    import pyarrow.parquet as parquet

    with Store("other.db") as store:  # with a model, a time and a temperature
        store.add(entry_of(result(0), unit="A", model="m", recorded=datetime(2026, 1, 1), temperature=25.0))  # noqa: DTZ001
    with Store("empty.db") as store:
        store.add(entry_of(result(0), unit="A"))
    for name in ("other", "empty"):
        found = run(capsys, "export", "--store", f"{name}.db", "-o", f"{name}.parquet", "--what", what)
        assert found[0] == 0, found
    assert parquet.read_schema(lab / "other.parquet").equals(parquet.read_schema(lab / "empty.parquet"))


@pytest.mark.parametrize(("argv", "code", "told"), [
    (["add", "--store", "x.db"], 2, "no results; give JSON files"),
    (["add", "results", "--store", "x.db", "--jobs", "0"], 2, "--jobs 0"),
    (["add", "results", "--store", "x.db", "--unit-from", "SN"], 2, "with a group"),
    (["add", "nothing.json", "--store", "x.db", "--unit", "A"], 1, "nothing.json: No such file"),
    (["list", "--store", "none.db"], 1, "none.db: there is no such store; sigmatau store add"),
    (["list", "--store", "mysql://a:secret@host/x"], 2, "mysql is not supported"),
    (["list", "--store", "lab.db", "--since", "monday"], 2, "--since monday"),
    (["show", "B", "--store", "lab.db"], 1, "no unit 'B'"),
    (["show", "A1", "--store", "lab.db", "--run", "x"], 1, "no run 'x'; its runs: 2026-02-10.csv"),
    (["trend", "--store", "lab.db", "--term", "walk"], 2, "--term: unknown term 'walk'; terms: quantization"),
    (["trend", "--store", "lab.db", "--level", "95"], 2, "--level must be between 0 and 1"),
    (["trend", "--store", "lab.db", "--channel", "gyrox"], 1, "no trend of random_walk: no selected run has it in gyrox"),
    (["export", "--store", "lab.db", "-o", "c.xlsx"], 2, "must end in .parquet, .csv"),
    (["export", "--store", "lab.db", "-o", "c.csv", "--unit", "B"], 1, "nothing is written"),
    (["export", "--store", "lab.db", "-o", "c.csv", "--what", "runs", "--term", "mean"], 2, "--term selects"),
])  # fmt: skip
def test_errors_are_one_line(lab, capsys, argv, code, told):
    found = run(capsys, *argv)
    assert found[0] == code
    errors = [line for line in found[2].splitlines() if line.startswith("sigmatau: ")]
    assert len(errors) == 1
    assert told in errors[0]
    assert "secret" not in errors[0]
    assert not (lab / "c.csv").exists()
    assert not (lab / "x.db").exists()


@pytest.mark.parametrize(("module", "place", "extra"), [
    ("sqlalchemy", "lab.db", "store"),
    ("orjson", "lab.db", "store"),
    ("psycopg", "postgresql://me@127.0.0.1:1/x", "postgresql"),
])  # fmt: skip
def test_without_the_libraries(lab, capsys, monkeypatch, module, place, extra):
    monkeypatch.setitem(sys.modules, module, None)
    code, _, err = run(capsys, "list", "--store", place)
    assert code == 1
    assert f"pip install 'sigmatau[{extra}]'" in err


def test_compare_and_lot_read_the_store(lab, capsys):
    assert main(["compare", "--store", "lab.db", "--unit", "A1", "--table"]) == 0
    assert "2026-02-10.csv" in capsys.readouterr().out
    assert main(["compare", "results", "--store", "lab.db"]) == 2
    assert "not both" in capsys.readouterr().err
    assert main(["lot", "--store", "lab.db", "--serial", "A*", "--json", "--expect", "4"]) == 4
    told = json.loads(capsys.readouterr().out)
    assert [unit["name"] for unit in told["units"]][:3] == ["A0", "A1", "A2"]
    assert main(["lot", "--store", "lab.db", "--serial", "B"]) == 1


def test_runs_at_a_temperature(lab, capsys):
    """Runs at -40, 25 and 70 °C, always in this order, look like ageing unless one temperature is chosen."""
    degrees = (-40.0, 25.0, 70.0)
    with Store("hot.db") as store:
        for k in range(9):
            one = result(k, log=f"t{k}", path=f"{k}.csv")
            store.add(
                entry_of(
                    one,
                    unit=f"A{k // 3}",
                    recorded=datetime(2026, 1, 1 + k, tzinfo=UTC),
                    temperature=degrees[k % 3],
                )
            )
    for given, count in (("-45:-35", 3), ("20:70", 6), ("70:70", 3), ("71:90", 0), ("25", 3), ("298K", 3), ("24", 0)):
        listed = run(capsys, "list", "runs", "--store", "hot.db", "--temperature", given, "--json")[1]
        assert len(json.loads(listed)["unit"]) == count
    assert run(capsys, "trend", "--store", "hot.db", "--temperature", "20:30")[0] == 0
    assert main(["compare", "--store", "hot.db", "--temperature", "20:30", "--json", "-"]) == 0
    assert {one["name"] for one in json.loads(capsys.readouterr().out)["runs"]} == {"1.csv", "4.csv", "7.csv"}
    assert main(["lot", "--store", "hot.db", "--temperature", "-45:-35", "--json"]) == 4
    assert len(json.loads(capsys.readouterr().out)["units"]) == 3
    assert main(["lot", "--store", "hot.db", "--temperature", "60"]) == 1
    (lab / "warm.json").write_text(json.dumps(result(9, log="warm", path="warm.csv")))
    argv = ["add", "warm.json", "--store", "hot.db", "--unit", "A0", "--temperature"]
    for stated, given in (("85degC", "358.15K"), ("-40", "-40")):  # the second one is stated of a run that is there
        assert run(capsys, *argv, stated)[0] == 0
        listed = run(capsys, "list", "runs", "--store", "hot.db", "--temperature", given, "--json")[1]
        assert "warm.csv" in json.loads(listed)["run"]
    assert "lower temperature first" in run(capsys, "list", "--store", "hot.db", "--temperature", "30:20")[2]
    assert "outside" in run(capsys, "list", "--store", "hot.db", "--temperature", "9999")[2]
    for wrong in ("20:30:40", "20:", "hot", "85F"):
        assert run(capsys, "list", "--store", "hot.db", "--temperature", wrong)[::2] == (
            2, f"sigmatau: --temperature {wrong}: must be a temperature, 85degC, or a range, 20:30\n",
        )  # fmt: skip
    for command in ("compare", "lot"):
        assert main([command, "results", "--temperature", "20:30"]) == 2
        assert "--temperature needs --store" in capsys.readouterr().err


def test_lot_takes_the_latest_even_if_it_failed(lab, capsys):
    from sigmatau.analysis import FailedAnalysis

    later = FailedAnalysis(path="logs/A1/2026-06-01.csv", message="no columns", exit_code=1).to_dict()
    (lab / "later.json").write_text(json.dumps(later))
    argv = ["add", "later.json", "--store", "lab.db", "--unit", "A1", "--date", "2026-06-01"]
    assert run(capsys, *argv)[0] == 0
    assert main(["lot", "--store", "lab.db", "--json"]) == 4
    told = {unit["name"]: unit["state"] for unit in json.loads(capsys.readouterr().out)["units"]}
    assert "read" in told["A1"]


def test_options_make_a_run(tmp_path, monkeypatch, capsys):
    """The JSON says what options made it, and the store takes another window of the same log for another run."""
    import jsonschema
    import numpy as np

    import sigmatau

    monkeypatch.chdir(tmp_path)
    rates = np.random.default_rng(5).standard_normal((3000, 2))
    np.savetxt("log.csv", rates, delimiter=",", header="gyro_x,gyro_y", comments="")
    reading = ["--rate", "100", "--unit", "gyro=deg/s", "-q", "--note", "serial number=A1"]
    told = {}
    more = {
        "whole": [],
        "again": ["--threads", "1"],
        "part": ["--window", "0s:20s", "--terms", "random_walk", "--keep", "spikes"],
    }
    for name, options in more.items():
        assert main(["analyze", "log.csv", "--json", f"{name}.json", *reading, *options]) == 0
        told[name] = json.loads((tmp_path / f"{name}.json").read_text())
        schema = ROOT / "python" / "sigmatau" / "schema" / "result-2.schema.json"
        jsonschema.validate(told[name], json.loads(schema.read_text()))
    assert (
        told["whole"]["options"] == told["again"]["options"] == {"reading": {"rate": 100.0, "unit": {"gyro": "deg/s"}}}
    )
    assert told["part"]["options"]["analysis"] == {"window": "0s:20s", "terms": ["random_walk"], "keep": ["spikes"]}
    for name, new in (("whole", "1 new"), ("again", "0 new, 1 already there"), ("part", "1 new")):
        capsys.readouterr()
        assert run(capsys, "add", f"{name}.json", "--store", "x.db")[2] == f"{new}\n"
    record = sigmatau.read("log.csv", rate=100, unit={"gyro": "deg/s"})
    with sigmatau.Store("x.db") as store:
        again = store.add(sigmatau.analyze(record, notes={"serial number": "A1"}))
    assert (again.new, again.known) == (0, 1)  # from Python it is the same run


@pytest.mark.skipif(sys.platform != "linux", reason="names of files are text there")
def test_a_name_that_is_not_utf_8(tmp_path, monkeypatch, capsys):
    """As a folder from an old Windows computer has it: neither this log nor those after it are lost."""
    import os

    import numpy as np

    monkeypatch.chdir(tmp_path)
    rates = np.random.default_rng(6).standard_normal((3000, 2))
    for name in (b"a pr\xfcfling.csv", b"b.csv"):
        np.savetxt(os.fsdecode(name), rates, delimiter=",", header="gyro_x,gyro_y", comments="")
    given = ["--rate", "100", "--unit", "gyro=deg/s", "-q"]
    assert main(["analyze", os.fsdecode(b"a pr\xfcfling.csv"), "b.csv", "--json", "results", *given]) == 0
    assert len([*(tmp_path / "results").iterdir()]) == 2
    capsys.readouterr()
    assert run(capsys, "add", "results", "--store", "x.db", "--unit-from", r"(\w)[^/]*\.csv") == (0, "", "2 new\n")
    with Store("x.db") as store:
        paths = {result.source.path for _, result in store.results()}
    assert {os.fsencode(path) for path in paths} == {b"a pr\xfcfling.csv", b"b.csv"}
