"""What can be compared, as the page asks for it: runs of a store, datasheets, noise models; and kinds of files."""

import json

import numpy as np
import pytest
from workbench_logs import write_log

import sigmatau as st
from sigmatau.app.kinds import file_kind

pytest.importorskip("sqlalchemy", reason="the store needs it")

pytest_plugins = ["workbench_pages"]  # the fixtures

DATASHEET = """
name = "A1"
maker = "Nobody"
source = "a test"
[gyro]
noise_density = { typical = "5 mdeg/s/sqrt(Hz)", sided = "unknown" }
"""


@pytest.fixture(scope="module")
def stored(folder):
    """A store with two runs of a unit, and one of another."""
    path = folder / "lab.db"
    with st.Store(path) as store:
        for unit, name in (("A1", "march.csv"), ("A1", "april.csv"), ("B1", "b.csv")):
            store.add(st.analyze(write_log(folder / name)), unit=unit)
    return path


def test_kinds(stored, folder):
    contents = {
        "model.toml": '[channels.gyro_x]\nrandom_walk = "0.3 deg/sqrt(h)"\n',
        "datasheet.toml": DATASHEET,
        "session.toml": 'log = "static.csv"\nchannels = { gyro = "1:3" }\n',
        "broken.toml": "log = \n",
        "x.db-journal": "x",
        "notes.md": "x",
    }
    for name, text in contents.items():
        (folder / name).write_text(text, encoding="utf-8")
    kinds = {name: file_kind(folder / name) for name in (*contents, "lab.db", "static.csv")}
    assert kinds == {
        "model.toml": "model",
        "datasheet.toml": "datasheet",
        "session.toml": "session",
        "broken.toml": "session",
        "x.db-journal": None,
        "notes.md": None,
        "lab.db": "store",
        "static.csv": "log",
    }
    assert file_kind(folder) == "folder"


def test_a_store_is_opened(page, stored):
    opened = page.post("api/open", path=str(stored)).json()
    assert (opened["kind"], opened["more"]) == ("store", 0)
    assert [run["unit"] for run in opened["runs"]] == ["A1", "A1", "B1"]
    assert {run["state"] for run in opened["runs"]} == {"fitted"}
    some = page.post("api/runs", path=str(stored), unit="B*").json()
    assert [run["unit"] for run in some["runs"]] == ["B1"]
    assert page.post("api/runs", path=str(stored), unit="C").json()["runs"] == []


def test_a_store_of_a_url(tmp_path):
    """A store is named by its place on the command line; its password is not shown."""
    from workbench_served import Page, serving

    from sigmatau.app.files import Roots
    from sigmatau.app.routes import Workbench

    workbench = Workbench(Roots([], ["postgresql://me:secret@127.0.0.1:1/lab?connect_timeout=2"]), max_upload=10**6)
    try:
        with serving(workbench) as client:
            page = Page(client, tmp_path)
            (entry,) = page.get("api/files").json()["entries"]
            assert (entry["kind"], entry["store"], entry["path"]) == ("store", 0, None)
            assert entry["name"] == "postgresql://me:…@127.0.0.1:1/lab?connect_timeout=2"
            refused = page.post("api/open", store=0)
            assert refused.status_code == 422
            assert "secret" not in refused.text
            assert page.post("api/open", store=1).status_code == 404
            assert page.post("api/open", store="postgresql://me@127.0.0.1/lab").status_code == 404
            assert page.post("api/open", path="postgresql://me@127.0.0.1/lab").status_code == 404
    finally:
        workbench.close()


def test_a_run_against_a_log(page, stored, result):
    """The difference of a stored run and a new log is that of the two results."""
    runs = page.post("api/runs", path=str(stored), unit="A1").json()["runs"]
    run = next(run for run in runs if "march" in run["name"])
    answer = page.post("api/runs/open", path=str(stored), run=run["run"]).json()
    assert answer["name"].startswith("A1 march")
    compared = page.post("api/compare", results=[answer["result"], result]).json()
    walk = next(row for row in compared["differences"] if row["term"] == "random_walk")
    assert walk["low"] <= walk["value"] <= walk["high"]
    assert compared["same_log"] is False
    assert walk["value"] == pytest.approx(walk["second"] - walk["first"])
    # The two have different units: all the same they are one group, with the tables of the paper.
    assert set(compared["table"]["group"]) == {""}
    assert compared["table"]["runs"][compared["table"]["term"].index("random_walk")] == 2
    assert "random walk [deg/√h]" in compared["tables"]
    assert "STD" in compared["tables"]
    for body in ({"run": 999}, {"run": "x"}, {}):
        assert page.post("api/runs/open", path=str(stored), **body).status_code in (400, 422)
    assert page.post("api/runs/open", path="/etc/passwd", run=1).status_code == 404


def test_a_copy_of_a_result_is_named(page, result):
    compared = page.post("api/compare", results=[result, page.analysed(options={"terms": ["random_walk"]})]).json()
    assert any("of the same log" in line for line in compared["unused"])
    assert compared["same_log"] is True


def test_the_curve_of_a_model(page, folder):
    file = folder / "walk.toml"
    file.write_text('[channels.gyro_x]\nrandom_walk = "0.3 deg/sqrt(h)"\n', encoding="utf-8")
    assert page.post("api/open", path=str(file)).json()["kind"] == "model"
    answer = page.post("api/specification", path=str(file)).json()
    assert answer["name"] == "walk"
    curve = answer["charts"]["channels"]["gyro_x"]["deviation"]
    walk = 0.3 * np.pi / 180 / 60
    np.testing.assert_allclose(curve["adev"], walk / np.sqrt(curve["tau"]), rtol=1e-3)  # times are whole samples


def test_the_curve_of_a_datasheet(page, folder):
    listed = page.get("api/datasheets").json()["datasheets"]
    assert {"adis16405", "icm42688p"} <= {sheet["name"] for sheet in listed}
    answer = page.post("api/specification", name="adis16405", sided="one", bias="minimum").json()
    assert set(answer["charts"]["channels"]) >= {"gyro_x", "accel_z"}
    assert answer["origins"]
    file = folder / "sheet.toml"
    file.write_text(DATASHEET, encoding="utf-8")
    assert page.post("api/open", path=str(file)).json()["kind"] == "datasheet"
    asked = page.post("api/specification", path=str(file))
    assert asked.status_code == 400
    assert "“Noise densities” one or two" in asked.json()["error"]["message"]
    curves = [
        page.post("api/specification", path=str(file), sided=sided).json()["charts"]["channels"]["gyro_x"]["deviation"]
        for sided in ("one", "two")
    ]
    np.testing.assert_allclose(np.array(curves[1]["adev"]) / curves[0]["adev"], np.sqrt(2), rtol=1e-4)
    for body in ({"name": "nothing"}, {"name": "cimu", "use": "best"}, {"name": 3}, {"name": str(file)}):
        assert page.post("api/specification", **body).status_code == 400


def test_the_size_of_a_bag_is_that_of_its_files(page, folder):
    place = folder / "recorded"
    place.mkdir()
    (place / "recorded_0.db3").write_bytes(b"x" * 5000)
    about = "rosbag2_bagfile_information:\n  relative_file_paths:\n    - recorded_0.db3\n"
    (place / "metadata.yaml").write_text(about, encoding="utf-8")
    entries = page.get("api/files", params={"path": str(folder)}).json()["entries"]
    entry = next(entry for entry in entries if entry["name"] == "recorded")
    assert (entry["kind"], entry["bytes"]) == ("log", 5000 + len(about))


def test_a_session_is_opened(page, folder):
    file = folder / "again.toml"
    file.write_text('log = "static.csv"\nwindow = "0s:20s"\n', encoding="utf-8")
    assert page.post("api/open", path=str(file)).json() == {
        "kind": "session", "options": {"window": "0s:20s"}, "log": "static.csv", "target": None, "choices": {},
    }  # fmt: skip
    file.write_text('log = "static.csv"\n', encoding="utf-8-sig")  # Windows editors write a byte order mark
    assert page.post("api/open", path=str(file)).json()["log"] == "static.csv"
    file.write_text('window = "0s:20s"\n', encoding="utf-8")
    refused = page.post("api/open", path=str(file))
    assert refused.status_code == 400
    assert "names no log" in refused.json()["error"]["message"]
    file.write_text("log = \n", encoding="utf-8")
    assert "not TOML" in page.post("api/open", path=str(file)).json()["error"]["message"]
    entries = page.get("api/files", params={"path": str(folder)}).json()["entries"]
    assert {entry["name"]: entry["kind"] for entry in entries}["again.toml"] == "session"
    json.dumps(entries)


def test_a_run_without_curves_is_named(page, folder, result):
    """Its coefficients are compared; the page says why it has no curve."""
    from sigmatau.lab.store.ingest import add_rows
    from sigmatau.lab.store.keeping import with_chosen_curves
    from sigmatau.lab.store.rows import Entry, make_rows

    path = folder / "small.db"
    with st.Store(path) as store:
        analysis = st.analyze(write_log(folder / "may.csv"))
        add_rows(store._engine, [with_chosen_curves(make_rows(Entry(result=analysis, unit="A1")), "none")])
    (run,) = page.post("api/runs", path=str(path)).json()["runs"]
    answer = page.post("api/runs/open", path=str(path), run=run["run"]).json()
    compared = page.post("api/compare", results=[answer["result"], result]).json()
    assert "no curve of A1 may.csv: its Allan deviations were not kept in the store" in compared["unused"]
    assert {row["term"] for row in compared["differences"]} >= {"random_walk"}
