"""The page of the JSON of a result, from its JSON Schema."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import sigmatau
from website.rst import escaped, heading

FILE = max((Path(sigmatau.__file__).parent / "schema").glob("result-*.schema.json"))


def page() -> str:
    """All fields with their types and meanings, in reStructuredText."""
    schema = json.loads(FILE.read_text(encoding="utf-8"))
    lines = [
        *heading("JSON of a result", "="),
        "``sigmatau analyze --json`` and `Analysis.to_dict <sigmatau.Analysis.to_dict>` write this form, in SI units.",
        f"``NAME`` stands for the name of a channel, ``[]`` for an item of a list. The schema: :download:`{FILE.name}`.",
        "",
        "Fields in **bold** are always there.",
        "",
    ]
    for name, part in schema["properties"].items():
        lines += [*heading(name, "-"), ".. list-table::", "   :class: fields", "   :widths: 45 55", ""]
        for path, required, meaning in _rows(part, name, schema, required=name in schema["required"]):
            lines += [f"   * - {'**' + path + '**' if required else path}", f"     - {meaning}"]
    return "\n".join(lines) + "\n"


def _resolved(part: dict[str, Any], schema: dict[str, Any]) -> dict[str, Any]:
    if "$ref" not in part:
        return part
    node = schema
    for step in part["$ref"].removeprefix("#/").split("/"):
        node = node[step]
    return _resolved(node, schema) | {key: value for key, value in part.items() if key != "$ref"}


def _rows(
    part: dict[str, Any], path: str, schema: dict[str, Any], *, required: bool
) -> Iterator[tuple[str, bool, str]]:
    part = _resolved(part, schema)
    yield path, required, _meaning(part)
    fields = part.get("properties", {})
    # Details of findings depend on their code; docs/findings.md has them.
    for name, field in fields.items():
        yield from _rows(field, f"{path}.{name}", schema, required=name in part.get("required", ()))
    if isinstance(each := part.get("additionalProperties"), dict) and _resolved(each, schema).get("properties"):
        yield from list(_rows(each, f"{path}.NAME", schema, required=False))[1:]
    if isinstance(each := part.get("items"), dict) and _resolved(each, schema).get("properties"):
        yield from list(_rows(each, f"{path}[]", schema, required=False))[1:]


def _meaning(part: dict[str, Any]) -> str:
    kind = part.get("type")
    if "const" in part:
        words = f"always {json.dumps(part['const'])}"
    elif "enum" in part:
        words = "one of " + ", ".join(f"``{json.dumps(value)}``" for value in part["enum"])
    elif kind == "array" and isinstance(part.get("items"), dict):
        items = part["items"].get("type", "values")
        words = f"list of {items if isinstance(items, str) else ' or '.join(items)}s"
    else:
        words = kind if isinstance(kind, str) else " or ".join(kind or ["any value"])
    about = escaped(part.get("description", ""))
    about = about.replace("see allOf for those of each code", "see :doc:`details`")
    return f"{words}: {about}" if about else words
