"""The conda recipe has the numbers of the package; `make wheel` reads and renders it by rattler-build."""

import re
import tomllib

import pytest
from ruamel.yaml import YAML

from conftest import ROOT

RECIPE = ROOT / "packaging" / "conda" / "recipe.yaml"
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
# Names on conda-forge that are not those of the Python package.
NAMES = {"matplotlib": "matplotlib-base", "npTDMS": "nptdms", "SQLAlchemy": "sqlalchemy"}
NOT_THERE = {"mat-io", "typst", "psycopg[binary]"}  # not packaged by conda-forge, or under another form


@pytest.fixture(scope="module")
def recipe():
    return YAML(typ="safe").load(RECIPE.read_text(encoding="utf-8"))


def conda(requirement):
    name, bound = re.fullmatch(r"([\w.\[\]-]+?)(>=.*)", requirement).groups()
    return None if name in NOT_THERE else f"{NAMES.get(name, name)} {bound}"


def test_version_and_requirements_are_those_of_the_package(recipe):
    assert recipe["context"]["version"] == PROJECT["version"]
    assert f">={recipe['context']['python_min']}" == PROJECT["requires-python"]
    assert set(recipe["requirements"]["run"]) == {"python", *map(conda, PROJECT["dependencies"])}
    extras = {conda(one) for extra in PROJECT["optional-dependencies"].values() for one in extra} - {None}
    assert set(recipe["requirements"]["run_constraints"]) == extras
    build = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["build-system"]["requires"]
    assert {one.replace(">=", " >=", 1) for one in build} <= set(recipe["requirements"]["host"])


def test_what_the_recipe_names_is_in_the_source_distribution(recipe):
    named = [*recipe["about"]["license_file"], *recipe["tests"][1]["files"]["source"]]
    maturin = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["maturin"]
    included = [entry["path"] for entry in maturin["include"]]
    for path in named:
        assert (ROOT / path).is_file(), path
        assert any(re.fullmatch(pattern.replace("*", ".*"), path) for pattern in included), path
    assert recipe["about"]["license"] == PROJECT["license"]
