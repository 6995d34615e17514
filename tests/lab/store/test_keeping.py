"""Results without their curves in a store: which they are, what remains of them, and that whoever needs a curve says so."""

import json

import numpy as np
import pytest
import sqlalchemy
from store_results import entry_of, result

import sigmatau as st
from sigmatau.cli import main
from sigmatau.errors import DataError
from sigmatau.lab.store.choosing import Chosen
from sigmatau.lab.store.ingest import Added, add_rows
from sigmatau.lab.store.keeping import lacks_curves, with_chosen_curves
from sigmatau.lab.store.rows import make_rows
from sigmatau.lab.store.store import Store
from sigmatau.lab.store.tables import run


def kinds():
    """Results by kind, and whether they need a look."""
    good = result(1, log="good", path="good.csv")
    partial, constant, moving = (result(k, log=str(k), path=f"{k}.csv") for k in (2, 3, 4))
    partial["channels"]["gyro_y"]["trust"] = "partial"
    constant["findings"] = [
        {"code": "constant_channel", "severity": "error", "channels": ["gyro_z"], "message": "constant"}
    ]
    for channel in moving["channels"].values():
        del channel["fit"], channel["trust"]
    moving["rest"] = {"verdict": "not_at_rest", "spans": []}
    unfitted = result(0, log="thermometer", path="thermometer.csv")
    del unfitted["channels"]["gyro_z"]["fit"], unfitted["channels"]["gyro_z"]["trust"]
    return {
        "good": (good, False), "partial": (partial, True), "constant": (constant, True), "moving": (moving, True),
        "thermometer": (unfitted, False),
    }  # fmt: skip


def add(store, keep):
    rows = [with_chosen_curves(make_rows(entry_of(each, unit=name)), keep) for name, (each, _) in kinds().items()]
    return add_rows(store._engine, rows)


def units_with_curves(store):
    runs = store.runs().columns()
    return {unit for unit, has in zip(runs["unit"], runs["has_curves"], strict=True) if has}


@pytest.mark.parametrize("keep", ["all", "failed", "none"])
def test_chosen_results_keep_their_curves(place, keep):
    expected = {name for name, (_, failed) in kinds().items() if keep == "all" or (keep == "failed" and failed)}
    with Store(place) as store:
        assert add(store, keep) == Added(new=len(kinds()))
        assert units_with_curves(store) == expected
        for row, analysis in store.results():
            whole, _ = kinds()[row["unit"]]
            points = {len(curve.tau) for curve in analysis.curves.values()}
            codes = [finding.code for finding in analysis.findings]
            content = store.content(row["id"])
            if row["unit"] in expected:
                assert 0 not in points
                assert "curves_not_kept" not in codes
                assert content == whole
                continue
            assert points == {0}
            assert codes.count("curves_not_kept") == 1
            for name, channel in content["channels"].items():  # all but the points
                expected_channel = whole["channels"][name]
                assert {**channel, "curve": None} == {**expected_channel, "curve": None}
                assert channel["curve"].keys() == expected_channel["curve"].keys()
                assert channel["curve"]["unit"] == expected_channel["curve"]["unit"]
                assert analysis.curves[name].n == expected_channel["samples"]
                assert 1 / analysis.curves[name].tau0 == expected_channel["sample_rate_hz"]


def test_coefficients_and_repeatability_are_those_with_curves(place, tmp_path):
    with Store(place) as without, Store(tmp_path / "whole.db") as whole:
        add(without, "none")
        add(whole, "all")
        assert without.coefficients().columns() == whole.coefficients().columns()
        assert repr(without.compare()) == repr(whole.compare())


def test_curves_are_added_later_and_stay(place):
    with Store(place) as store:
        add(store, "none")
        count = sum(failed for _, failed in kinds().values())
        assert add(store, "failed") == Added(updated=count, known=len(kinds()) - count)
        assert units_with_curves(store) == {name for name, (_, failed) in kinds().items() if failed}
        assert add(store, "all") == Added(updated=len(kinds()) - count, known=count)
        for row, _ in store.results():
            assert store.content(row["id"]) == kinds()[row["unit"]][0]
        assert add(store, "none") == Added(known=len(kinds()))
        assert len(units_with_curves(store)) == len(kinds())
        assert set(store.runs(Chosen(history=True)).columns()["revision"]) == {1}


@pytest.mark.parametrize("keep", ["all", "failed", "none"])
def test_the_condition_in_sql_is_that_of_results(place, keep):
    expected = {name for name, (_, failed) in kinds().items() if keep == "all" or (keep == "failed" and failed)}
    with Store(place) as store:
        add(store, "none")
        runs = store.runs().columns()
        names = dict(zip(runs["id"], runs["unit"], strict=True))
        with store._engine.connect() as connection:
            lacking = connection.scalars(sqlalchemy.select(run.c.id).where(lacks_curves(keep)))
            assert {names[key] for key in lacking} == expected


def test_whoever_draws_a_curve_says_that_it_was_not_kept(tmp_path):
    with Store(tmp_path / "lab.db") as store:
        add(store, "none")
        _, analysis = store.latest("good")
    for draw in (analysis.plot, analysis.curves["gyro_x"].plot, lambda: st.plot_overlay({"a": analysis.curves})):
        with pytest.raises(DataError, match=r"gyro_x was not kept in the store\. Analyse the log again"):
            draw()
    st.report(analysis, tmp_path / "good.html")
    assert "were not kept in the store" in (tmp_path / "good.html").read_text()
    st.report(analysis, tmp_path / "good.pdf")
    assert (tmp_path / "good.pdf").read_bytes().startswith(b"%PDF")


@pytest.fixture
def results(tmp_path):
    """JSON files of five units, one with a scale of its own."""
    folder = tmp_path / "results"
    folder.mkdir()
    for k in range(5):
        rng = np.random.default_rng([k, 29])
        record = st.Record.from_arrays(
            rate=100, gyro=(57.3 if k == 4 else 1) * 1e-4 * rng.standard_normal((4000, 3)), unit={"gyro": "rad/s"}
        )
        notes = {"serial number": f"SN{k}", "date": f"2026-05-0{k + 1}"}
        (folder / f"SN{k}.json").write_text(json.dumps(st.analyze(record, notes=notes).to_dict()))
    return folder


def test_commands_work_without_curves_and_say_what_is_missing(tmp_path, results, capsys):
    place = str(tmp_path / "lab.db")
    assert main(["store", "add", str(results), "--store", place, "--keep-curves", "none"]) == 0
    for command in (["compare"], ["store", "trend"], ["store", "list", "runs"], ["store", "show", "SN2"]):
        assert main([*command, "--store", place]) == 0, command
    pages = [str(tmp_path / f"lot.{ending}") for ending in ("html", "pdf", "json", "csv")]
    capsys.readouterr()
    assert main(["lot", "--store", place, *(word for page in pages for word in ("-o", page))]) == 4
    out = " ".join(capsys.readouterr().out.split())
    said = "Curves are not compared: the Allan deviations of 5 of 5 units were not kept in the store"
    assert said in out
    assert said in (tmp_path / "lot.html").read_text()
    assert "the data are those of" not in out
    exported = tmp_path / "SN2.json"
    assert main(["store", "show", "SN2", "--store", place, "--json", str(exported)]) == 0
    assert main(["export", str(exported), "--to", "matlab", "-o", str(tmp_path / "imu.m")]) == 0


def test_a_lot_is_not_compared_with_the_curves_of_its_failed_units(tmp_path, results, capsys):
    """The kept curves of failed units would be the band of the lot."""
    for k in (0, 1, 2):  # the others are good
        content = json.loads((results / f"SN{k}.json").read_text())
        for channel in content["channels"].values():
            channel["trust"] = "partial"
        (results / f"SN{k}.json").write_text(json.dumps(content))
    place = str(tmp_path / "lab.db")
    assert main(["store", "add", str(results), "--store", place, "--keep-curves", "failed"]) == 0
    capsys.readouterr()
    assert main(["lot", "--store", place]) == 4
    assert "the Allan deviations of 2 of 5 units" in " ".join(capsys.readouterr().out.split())
    with Store(place) as store:
        lot = st.judge_lot(store.units_latest())
    assert all(len(band.tau) == 0 for band in lot.bands)


def test_one_log_under_two_names_is_found_without_curves(tmp_path):
    with Store(tmp_path / "lab.db") as store:
        same = [
            with_chosen_curves(make_rows(entry_of(result(1, log="same"), unit=name)), "none") for name in ("A", "B")
        ]
        add_rows(store._engine, [*same, with_chosen_curves(make_rows(entry_of(result(2), unit="C")), "none")])
        lot = st.judge_lot(store.units_latest())
    named = {unit.name for unit in lot.units if any(remark.code == "same_data" for remark in unit.remarks)}
    assert named == {"A", "B"}
