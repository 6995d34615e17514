"""The JSON Schema of a result is that of its types; ``UPDATE_WORDS=1`` writes it anew."""

import importlib
import json
import os
import sys

import jsonschema
import pytest

from conftest import ROOT
from schema_of_types import schema, text
from sigmatau.analysis.json import SCHEMA

FILE = ROOT / "python" / "sigmatau" / "schema" / f"result-{SCHEMA}.schema.json"
FINDINGS = ROOT / "tests" / "findings"
SUBJECTS = sorted(path.stem for path in FINDINGS.glob("examples_*.py"))


def test_the_published_schema_is_that_of_the_types():
    if os.environ.get("UPDATE_WORDS"):
        FILE.write_text(text(schema()) + "\n", encoding="utf-8")
    published = json.loads(FILE.read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator.check_schema(published)
    assert published == schema(), "UPDATE_WORDS=1 .venv/bin/python -m pytest tests/analysis/test_schema.py"


@pytest.mark.parametrize("subject", SUBJECTS)
def test_every_example_of_a_finding_has_the_published_form(subject, monkeypatch):
    monkeypatch.setattr(sys, "path", [str(FINDINGS), *sys.path])
    form = jsonschema.Draft202012Validator(json.loads(FILE.read_text())["properties"]["findings"]["items"])
    for one in importlib.import_module(subject).EXAMPLES:
        content = json.loads(json.dumps(one.to_dict()))
        form.validate(content)
        content["details"] |= {"unknown": 1}
        assert not form.is_valid(content)
