"""Workflows, forms and the citation file have the form that their readers take; the schemas are within check-jsonschema."""

import re
import tomllib

import pytest
from ruamel.yaml import YAML

from conftest import ROOT

FORGE = ROOT / ".github"
WORKFLOWS = sorted((FORGE / "workflows").glob("*.yml"))
FILES = {
    **dict.fromkeys(WORKFLOWS, "vendor.github-workflows"),
    **dict.fromkeys((FORGE / "ISSUE_TEMPLATE").glob("[!c]*.yml"), "vendor.github-issue-forms"),
    FORGE / "ISSUE_TEMPLATE" / "config.yml": "vendor.github-issue-config",
    FORGE / "dependabot.yml": "vendor.dependabot",
    ROOT / "CITATION.cff": "vendor.citation-file-format",
}


def valid(schema, path):
    from check_jsonschema import main as check_jsonschema

    with pytest.raises(SystemExit) as ended:
        check_jsonschema(["--builtin-schema", schema, str(path)])
    return ended.value.code == 0


@pytest.mark.parametrize(("path", "schema"), FILES.items(), ids=[path.name for path in FILES])
def test_form(path, schema):
    assert valid(schema, path)


def test_the_citation_is_of_this_version():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    citation = YAML(typ="safe").load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert str(citation["version"]) == project["version"]
    assert citation["license"] == project["license"].split(" OR ")
    assert citation["authors"] == project["authors"]


def test_a_wrong_workflow_is_found(tmp_path):
    text = WORKFLOWS[0].read_text(encoding="utf-8")
    (tmp_path / "wrong.yml").write_text(text.replace("runs-on:", "run-on:"), encoding="utf-8")
    assert not valid("vendor.github-workflows", tmp_path / "wrong.yml")


@pytest.mark.parametrize("path", WORKFLOWS, ids=[path.name for path in WORKFLOWS])
def test_every_job_has_a_limit_and_no_more_rights_than_it_needs(path):
    assert valid("custom.github-workflows-require-timeout", path)
    workflow = YAML(typ="safe").load(path.read_text(encoding="utf-8"))
    assert workflow["permissions"] == {"contents": "read"}
    extra = {name: job["permissions"] for name, job in workflow["jobs"].items() if "permissions" in job}
    assert extra == ({"publish": {"id-token": "write"}} if path.name == "wheels.yml" else {})


@pytest.mark.parametrize("path", WORKFLOWS, ids=[path.name for path in WORKFLOWS])
def test_every_action_is_pinned_by_commit(path):
    """A tag can be moved to other code; dependabot raises the commit together with the version behind it."""
    actions = re.findall(r"uses: (.*)", path.read_text(encoding="utf-8"))
    for action in actions:
        assert re.fullmatch(r"[\w/-]+@[0-9a-f]{40}  # v\d+\.\d+\.\d+", action), action


@pytest.mark.parametrize("path", WORKFLOWS, ids=[path.name for path in WORKFLOWS])
def test_what_a_workflow_runs_exists(path):
    text = path.read_text(encoding="utf-8")
    targets = re.findall(r"run: make ([a-z-]+)", text)
    made = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), flags=re.MULTILINE))
    if not (ROOT / "docs" / "conf.py").exists():  # a tree without the site
        made.add("docs")
    assert set(targets) <= made
    for named in re.findall(r"\b((?:scripts|tests|requirements)/[\w/.-]+)", text):
        assert (ROOT / named).exists(), named
    steps = re.findall(r'STEPS="([^"]*)"', text)
    known = (ROOT / "scripts" / "test.sh").read_text(encoding="utf-8")
    for step in " ".join(steps).split():
        assert re.search(rf"^    {step}\)", known, flags=re.MULTILINE), step


def test_the_workflows_try_every_python_that_is_stated():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    stated = {word.rpartition(" ")[2] for word in project["classifiers"] if re.search(r":: 3\.\d+$", word)}
    smoke = YAML(typ="safe").load((FORGE / "workflows" / "wheels.yml").read_text(encoding="utf-8"))["jobs"]["smoke"]
    assert set(smoke["strategy"]["matrix"]["python"]) == stated
    assert f">={min(stated, key=lambda version: int(version.partition('.')[2]))}" == project["requires-python"]
