"""The JSON of a result stays readable: by programs written for the frozen schema, and by sigmatau whatever version wrote it.

tests/release/frozen has a copy of each published schema, and results that older versions wrote. A schema that breaks its
copy needs a new number: copy it here under this number, and go on reading the old one. Additions are frozen at a release, by
``UPDATE_FROZEN=1``. No version that writes schema 1 was released: its result was made by hand from one of schema 2.
"""

import copy
import json
import os
import shutil

import jsonschema
import pytest
from schema_changes import breaking, opened

import sigmatau as st
from conftest import ROOT
from known import seed_of
from sigmatau._version import SCHEMA
from sigmatau.cli import main

FROZEN = ROOT / "tests" / "release" / "frozen"
NEWEST = ROOT / "python" / "sigmatau" / "schema" / f"result-{SCHEMA}.schema.json"
OLD = sorted(FROZEN.glob("result-*-by-*.json"))


def load(path):
    return json.loads(path.read_text(encoding="utf-8"))


def number_of(path):
    return int(path.name.removeprefix("result-")[0])


def test_the_published_schema_is_compatible_with_its_frozen_copy():
    copied = FROZEN / NEWEST.name
    assert copied.exists(), f"freeze the schema: copy {NEWEST.name} to tests/release/frozen"
    assert list(breaking(load(copied), load(NEWEST))) == []
    if os.environ.get("UPDATE_FROZEN"):
        shutil.copy(NEWEST, copied)


def test_every_schema_that_is_read_is_frozen_and_has_a_result():
    frozen = {number_of(path) for path in FROZEN.glob("*.schema.json")}
    assert frozen == set(range(1, SCHEMA + 1))
    assert {number_of(path) for path in OLD} == frozen


def part(schema, *names):
    for name in names:
        schema = schema[name]
    return schema


def terms(schema):
    return part(schema, "properties", "channels", "additionalProperties", "properties")


BREAKS = {
    "a field is removed": lambda s: terms(s).pop("samples"),
    "a field has another type": lambda s: terms(s)["samples"].update(type="string"),
    "a field may be null": lambda s: terms(s)["sample_rate_hz"].update(type=["number", "null"]),
    "a field may be missing": lambda s: s["required"].remove("findings"),
    "a new field is required": lambda s: s["required"].append("notes"),
    "a value is removed": lambda s: part(s, "properties", "rest", "properties", "verdict")["enum"].remove("at_rest"),
    "a code is removed": lambda s: part(s, "properties", "findings", "items")["allOf"].pop(0),
    "a detail is removed": lambda s: part(s, "properties", "findings", "items")["allOf"][0]["then"]["properties"][
        "details"
    ]["properties"].pop("rate"),
    "a pattern changes": lambda s: part(s, "properties", "source", "properties", "sha256").update(pattern="^.*$"),
    "a number is bounded": lambda s: terms(s)["sample_rate_hz"].update(maximum=1e6),
    "the number changes": lambda s: part(s, "properties", "schema").update(const=99),
}


@pytest.mark.parametrize("change", BREAKS)
def test_a_change_that_breaks_is_found(change):
    schema = load(FROZEN / NEWEST.name)
    changed = copy.deepcopy(schema)
    BREAKS[change](changed)
    assert changed != schema
    assert len(list(breaking(schema, changed))) == 1


def test_additions_are_allowed():
    schema = load(FROZEN / NEWEST.name)
    changed = copy.deepcopy(schema)
    terms(changed)["humidity"] = {"type": "number"}
    part(changed, "properties", "rest", "properties", "verdict")["enum"].append("swimming")
    new = {"type": "object", "properties": {"depth": {"type": "number"}}, "additionalProperties": False}
    code = {"if": {"properties": {"code": {"const": "wet"}}}, "then": {"properties": {"details": new}}}
    rows = part(changed, "properties", "findings", "items")["allOf"]
    rows.append(code)
    details = rows[0]["then"]["properties"]
    details["details"] = {"anyOf": [details["details"], new]}
    terms(changed)["samples"]["description"] = "other words"
    assert list(breaking(schema, changed)) == []


@pytest.mark.parametrize("path", OLD, ids=lambda path: path.stem)
def test_old_results_are_of_their_schema(path):
    jsonschema.validate(load(path), load(FROZEN / f"result-{number_of(path)}.schema.json"))
    if number_of(path) == SCHEMA:
        jsonschema.validate(load(path), load(NEWEST))


def test_new_results_suit_a_program_that_knows_the_frozen_schema():
    model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-3, "rate_random_walk": 1e-5}})
    simulated = st.simulate(model, duration=600, rate=10, rng=seed_of("a new result"))
    samples = simulated.stream_of("gyro_x").column("gyro_x").copy()
    samples[2000] += 0.5  # a finding with details
    record = st.Record.from_arrays(rate=10, gyro=samples, unit={"gyro": "rad/s"})
    form = jsonschema.Draft202012Validator(opened(load(FROZEN / NEWEST.name)))
    for method in ("likelihood", "gls", "read-off"):
        result = json.loads(json.dumps(st.analyze(record, method=method).to_dict()))
        form.validate(result)
        next(iter(result["channels"].values()))["samples"] = "6000"
        assert not form.is_valid(result)


@pytest.mark.parametrize("path", OLD, ids=lambda path: path.stem)
def test_old_results_are_read_by_every_command_that_reads_results(path, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    shutil.copy(path, "old.json")
    result = load(path)
    written = {
        name: channel["fit"]["terms"]["random_walk"]["value"]
        for name, channel in result["channels"].items()
        if channel["fit"]["terms"]["random_walk"]["observed"]
    }
    assert written
    another = copy.deepcopy(result)
    for channel in another["channels"].values():  # of another run of the unit
        walk = channel["fit"]["terms"]["random_walk"]
        walk.update({name: walk[name] * 1.001 for name in ("value", "low", "high") if name in walk})
    (tmp_path / "another.json").write_text(json.dumps(another), encoding="utf-8")
    for name, value in written.items():
        assert st.Analysis.from_json("old.json").model[name]["random_walk"] == value
    for command in (
        "export old.json --to gtsam -o gtsam.json",
        "plan old.json --term bias_instability --hours 12",
        "predict old.json --after 60s --calibration 60s",
        "compare old.json another.json",
        "store add old.json --store lab.db --unit A1 --date 2026-05-01",
        "store show A1 --store lab.db",
    ):
        assert main(command.split()) == 0, f"{command}: {capsys.readouterr().err}"
