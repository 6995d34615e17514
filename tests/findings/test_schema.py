"""The JSON Schema of a result names the details of every code with their types; ``UPDATE_WORDS=1`` writes them anew."""

import json
import os
import re
import types
import typing
from collections.abc import Mapping
from dataclasses import fields, is_dataclass

import jsonschema
import pytest
from test_words import SUBJECTS, examples

from conftest import ROOT
from sigmatau.findings import details_by_code

FILE = ROOT / "python" / "sigmatau" / "schema" / "result-2.schema.json"
PLAIN = {
    float: {"type": ["number", "null"]},
    int: {"type": "integer"},
    str: {"type": "string"},
    bool: {"type": "boolean"},
}


def schema_of(kind, within=()):
    """The schema of a type of a field: not finite numbers are null."""
    if kind in PLAIN:
        return PLAIN[kind]
    if kind in within:  # a kind that holds others of its kind
        return {"type": "object"}
    if is_dataclass(kind):
        return {"type": "object", "properties": properties(kind, within), "additionalProperties": False}
    origin, of = typing.get_origin(kind), typing.get_args(kind)
    if origin is tuple:
        items = [schema_of(one, within) for one in of if one is not Ellipsis]
        return {"type": "array", "items": items[0] if len(set(map(str, items))) == 1 else {}}
    if origin in (typing.Union, types.UnionType):
        return {"anyOf": [{"type": "null"} if one is type(None) else schema_of(one, within) for one in of]}
    if origin is typing.Literal:
        return {"enum": list(of)}
    assert isinstance(origin, type), kind
    assert issubclass(origin, Mapping), kind
    return {"type": "object"}


def properties(kind, within):
    hints = typing.get_type_hints(kind)
    return {one.name: schema_of(hints[one.name], (*within, kind)) for one in fields(kind)}


def rows():
    return [
        {"if": {"properties": {"code": {"const": code}}}, "then": {"properties": {"details": schema_of(kind)}}}
        for code, kind in sorted(details_by_code().items())
    ]


def test_the_schema_has_the_details_of_every_code():
    if os.environ.get("UPDATE_WORDS"):
        lines = ",\n".join(f"     {json.dumps(row)}" for row in rows())
        text = re.sub(
            r'("allOf": \[\n).*?(\n?    \],)', lambda m: m[1] + lines + "\n    ],", FILE.read_text(), flags=re.S
        )
        FILE.write_text(text)
    schema = json.loads(FILE.read_text())
    jsonschema.Draft202012Validator.check_schema(schema)
    assert schema["properties"]["findings"]["items"]["allOf"] == rows()


@pytest.mark.parametrize("subject", SUBJECTS)
def test_every_example_has_the_published_form(subject):
    form = jsonschema.Draft202012Validator(json.loads(FILE.read_text())["properties"]["findings"]["items"])
    for one in examples(subject):
        content = json.loads(json.dumps(one.to_dict()))
        form.validate(content)
        content["details"] |= {"unknown": 1}
        assert not form.is_valid(content)
