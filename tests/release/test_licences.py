"""THIRD_PARTY_LICENSES and the bill of materials name what is shipped, and the distributions carry them."""

import os
import re
import shutil
import subprocess
import tomllib

import pytest
from scripts_of import script

from conftest import ROOT

licences = script("licences")
PAGE = (ROOT / "THIRD_PARTY_LICENSES").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def graph():
    if shutil.which("cargo") is None:
        assert not os.environ.get("CI"), "cargo is not on the path, and CI must not skip the test of the licences"
        pytest.skip("no cargo on the path")
    return licences.metadata()


def test_the_file_is_what_the_script_writes(graph):
    assert licences.render(graph) == PAGE, "run scripts/licences.py"


def test_every_crate_of_the_extension_is_named_with_its_version(graph):
    """Without the script's own reading of the graph: what cargo says is linked into the extension of this platform."""
    command = "cargo tree --locked --edges normal,no-proc-macro --package sigmatau-py --prefix none --format {p}"
    tree = subprocess.run(command.split(), cwd=ROOT, capture_output=True, text=True, check=True).stdout
    crates = {tuple(line.split()[:2]) for line in tree.splitlines() if line and "(/" not in line}
    assert len(crates) > 40
    listed = {tuple(line.split()[:2]) for line in PAGE.partition("-----")[0].splitlines()}
    assert {(name, version.removeprefix("v")) for name, version in crates} <= listed


def test_a_crate_without_a_known_licence_stops_the_script():
    with pytest.raises(SystemExit, match=r"no rule for the licence .GPL-3\.0-only."):
        licences.chosen({"name": "copyleft", "license": "GPL-3.0-only"})


def test_the_distributions_carry_the_texts():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert project["license-files"] == ["LICENSE-MIT", "LICENSE-APACHE", "THIRD_PARTY_LICENSES"]
    for name in project["license-files"]:
        assert (ROOT / name).stat().st_size > 1000


def test_the_bill_of_materials(graph):
    bill = licences.bill_of_materials(graph)
    listed = {tuple(line.split()[:2]) for line in PAGE.partition("-----")[0].splitlines()}
    assert {(row["name"], row["version"]) for row in bill["components"]} <= listed
    assert all(re.fullmatch(r"[0-9a-f]{64}", row["hashes"][0]["content"]) for row in bill["components"])
    references = {row["bom-ref"] for row in bill["components"]} | {bill["metadata"]["component"]["bom-ref"]}
    assert {row["ref"] for row in bill["dependencies"]} == references
    edges = {row["ref"]: row["dependsOn"] for row in bill["dependencies"]}
    reached, todo = set(), [bill["metadata"]["component"]["bom-ref"]]
    while todo:
        reference = todo.pop()
        reached.add(reference)
        todo += [target for target in edges[reference] if target not in reached]
    assert reached == references, "a component on which nothing depends"
    assert str(ROOT) not in str(bill)
