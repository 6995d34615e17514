"""Files of results into a store: names, damage, several processes."""

import json
import os
import subprocess
import sys
import time
from dataclasses import replace
from datetime import datetime
from pathlib import Path

import pytest
from store_results import result

from sigmatau.analysis.reading import result_of_dict
from sigmatau.errors import DataError, OptionError
from sigmatau.lab.lots.reading import gather
from sigmatau.lab.store.from_files import add_files
from sigmatau.lab.store.ingest import Added
from sigmatau.lab.store.naming import Naming, UnknownUnitError, stated_temperature
from sigmatau.lab.store.store import Store


def write(path, one):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(one))
    return path


def folder_of(tmp_path, count=6):
    for k in range(count):
        write(
            tmp_path / "results" / f"SN{k % 3}" / f"day{k}.json",
            result(k, log=str(k), path=f"logs/SN{k % 3}/2026-05-0{k % 9 + 1}.csv"),
        )
    return tmp_path / "results"


DAMAGE = {
    "empty": b"",
    "cut": b'{"schema": 2, "channels": {',
    "no object": b"[1, 2]",
    "other JSON": b'{"channels": {}}',
    "no result": b'{"channels": {"gyro_x": 1}, "source": {}}',
    "not a number": b'{"channels": {"gyro_x": {"samples": NaN}}, "source": {}}',
    "binary": bytes(range(256)),
    "newer": b'{"schema": 99, "source": {}, "channels": {}}',
}


@pytest.mark.parametrize("jobs", [1, 2])
def test_damaged_files_are_named_and_the_others_added(place, tmp_path, monkeypatch, jobs):
    monkeypatch.setattr("sigmatau.lab.store.from_files._FILES_OF_ONE_PROCESS", 0)
    monkeypatch.setattr("sigmatau.lab.store.from_files.BATCH", 4)
    folder = folder_of(tmp_path)
    for name, content in DAMAGE.items():
        (folder / f"{name}.json").write_bytes(content)
    counts = []
    with Store(place) as store:
        naming = Naming(unit_from="log-folder")
        found = add_files(store._engine, gather([folder]), naming, jobs=jobs, done=counts.append)
        assert found.added == Added(new=6)
        assert {problem.file.stem for problem in found.problems} == set(DAMAGE)
        assert store.units().columns()["unit"] == ["SN0", "SN1", "SN2"]
    assert counts[-1] == 6 + len(DAMAGE)


def noted(**notes):
    one = result(0, path="logs/SN7/night_20260501_233000.csv")
    return result_of_dict(one | {"notes": {key.replace("_", " "): text for key, text in notes.items()}})


def day(number, *time):
    return datetime(2026, 5, number, *time)  # noqa: DTZ001  UTC


FILE = Path("/data/results/A9/one.json")


@pytest.mark.parametrize(("naming", "notes", "unit"), [
    (Naming(), {"serial_number": "A1"}, "A1"),
    (Naming(), {"Unit": "A1"}, "A1"),
    (Naming(unit="B"), {"serial_number": "A1"}, "B"),
    (Naming(folders=True), {}, "A9"),
    (Naming(folders=True), {"serial_number": "A1"}, "A1"),
    (Naming(unit_from="folder"), {"serial_number": "A1"}, "A9"),
    (Naming(unit_from="log-folder"), {}, "SN7"),
    (Naming(unit_from=r"SN(\d+)"), {}, "7"),
])  # fmt: skip
def test_unit(naming, notes, unit):
    assert naming.entry(noted(**notes), FILE).unit == unit


def test_unit_that_nothing_names():
    with pytest.raises(UnknownUnitError, match="give `unit=NAME`"):
        Naming().entry(noted(), FILE)
    with pytest.raises(UnknownUnitError, match=r"SN7.*: `unit_from` 'X.*' finds no unit in the path of the log"):
        Naming(unit_from=r"X(\d+)").entry(noted(), FILE)


@pytest.mark.parametrize(("naming", "notes", "recorded"), [
    (Naming(unit="A"), {}, None),
    (Naming(unit="A"), {"date": "2026-05-01"}, day(1)),
    (Naming(unit="A", date="2026-05-02T12:00"), {"date": "day 3"}, day(2, 12)),
    (Naming(unit="A", date="name"), {}, day(1, 23, 30)),
])  # fmt: skip
def test_date(naming, notes, recorded):
    assert naming.entry(noted(**notes), FILE).recorded == recorded


@pytest.mark.parametrize(("name", "recorded"), [
    ("20260503_4512.csv", day(3)),  # a serial number
    ("2026-05-03-99-99 SN7.csv", day(3)),
    ("2026_05_03_12_30_05.csv", day(3, 12, 30, 5)),
])  # fmt: skip
def test_date_in_the_name(name, recorded):
    one = noted()
    one = replace(one, source=replace(one.source, path=f"2025-01-01/{name}"))
    assert Naming(unit="A", date="name").entry(one, FILE).recorded == recorded


@pytest.mark.parametrize(
    ("text", "degrees"), [("25", 25.0), ("-40.5 °C", -40.5), ("298.15 K", 25.0), ("20 degC", 20.0)]
)
def test_temperature(text, degrees):
    assert Naming(unit="A").entry(noted(temperature=text), FILE).temperature == pytest.approx(degrees, abs=1e-12)
    assert Naming(unit="A", temperature=5.0).entry(noted(temperature=text), FILE).temperature == 5.0
    assert stated_temperature(text) == pytest.approx(degrees, abs=1e-12)


def test_temperature_of_an_option():
    assert stated_temperature(None) is None
    assert stated_temperature("-40degC") == -40.0
    with pytest.raises(OptionError, match="'85F' is not a temperature like 25degC"):
        stated_temperature("85F")


@pytest.mark.parametrize(("naming", "notes", "told"), [
    (Naming(unit="A"), {"date": "day 3"}, "'day 3' is not a date"),
    (Naming(unit="A"), {"temperature": "warm"}, "'warm' is not a temperature"),
    (Naming(unit="A"), {"temperature": "-999 degC"}, "below absolute zero"),
    (Naming(unit="A"), {"temperature": "-3 K"}, "below absolute zero"),
    (Naming(unit="A", date="name"), {"path": "x"}, "no date in the name"),
])  # fmt: skip
def test_notes_that_cannot_be_read(naming, notes, told):
    one = noted(**notes)
    if "path" in notes:
        one = replace(one, source=replace(one.source, path="x1234567890.csv"))
    with pytest.raises(DataError, match=told):
        naming.entry(one, FILE)


@pytest.mark.parametrize(("naming", "option"), [
    (Naming(unit="A", unit_from="folder"), "unit_from"),
    (Naming(unit=" "), "unit"),
    (Naming(unit_from="(["), "unit_from"),
    (Naming(unit_from="SN"), "unit_from"),
    (Naming(date="yesterday"), "date"),
])  # fmt: skip
def test_wrong_options(naming, option):
    with pytest.raises(OptionError) as caught:
        naming.check()
    assert caught.value.option == option


KILLS = """
import os, signal, sys, time
from pathlib import Path
import sigmatau.lab.store.from_files as module
from sigmatau.lab.store.naming import Naming
from sigmatau.lab.store.store import Store

class Deadly(Naming):
    def entry(self, result, file, *, content):
        if sys.argv[2] == "reader":
            os.kill(os.getpid(), signal.SIGKILL)
        Path("readers").open("a").write(f"{os.getpid()}\\n")
        time.sleep(60)

if __name__ == "__main__":
    module._FILES_OF_ONE_PROCESS, module.BATCH = 0, 2
    with Store("x.db") as store:
        try:
            store.add_files(sorted(Path(sys.argv[1]).glob("**/*.json")), Deadly(unit="A"), jobs=2)
        except module.DataError as error:
            sys.exit(str(error))
"""


@pytest.mark.parametrize("who", ["reader", "client"])
def test_killed_processes(tmp_path, who):
    """Of a reader that is killed a sentence tells; the readers end with a client that is killed."""
    (tmp_path / "kills.py").write_text(KILLS)
    process = subprocess.Popen(
        [sys.executable, "kills.py", str(folder_of(tmp_path)), who], cwd=tmp_path, stderr=subprocess.PIPE, text=True,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
    )  # fmt: skip
    if who == "client":
        readers = tmp_path / "readers"
        until = time.monotonic() + 60
        while not readers.exists() or not (pids := readers.read_text().split()):
            assert time.monotonic() < until
            time.sleep(0.05)
        process.kill()
        while any(Path(f"/proc/{pid}").exists() and " Z " not in Path(f"/proc/{pid}/stat").read_text() for pid in pids):
            assert time.monotonic() < until, "a reader is still there"
            time.sleep(0.05)
    _, err = process.communicate(timeout=60)
    assert ("add the others with `jobs=1`" in err) == (who == "reader"), err
    assert "Traceback" not in err
