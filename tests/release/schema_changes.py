"""Changes of a JSON Schema that break a program written for the frozen one, or refuse a file written before."""

from collections.abc import Iterator
from typing import Any

# Parts with named members: a member may be added, but not removed.
NAMED = ("properties", "$defs")
# Descriptions, and parts that are compared by separate rules.
FREE = {"$schema", "$id", "title", "description", "properties", "$defs", "required", "type", "enum", "allOf", "anyOf"}


def breaking(frozen: Any, now: Any, place: str = "") -> Iterator[str]:
    """Forbidden changes in a newer schema of the same number, each with its place."""
    if isinstance(frozen, bool) or isinstance(now, bool):
        if frozen != now:
            yield f"{place}: {frozen} became {now}"
        return
    if _types(frozen) != _types(now):
        yield f"{place}: type {_types(frozen)} became {_types(now)}"
    for part in NAMED:
        old, new = frozen.get(part, {}), now.get(part, {})
        for name, schema in old.items():
            if name not in new:
                yield f"{place}/{name}: removed"
            else:
                yield from breaking(schema, new[name], f"{place}/{name}")
    # A program relies on required keys. An older file has no new ones.
    if set(frozen.get("required", ())) != set(now.get("required", ())):
        yield f"{place}: required {sorted(frozen.get('required', ()))} became {sorted(now.get('required', ()))}"
    if missing := [value for value in frozen.get("enum", ()) if value not in now.get("enum", ())]:
        yield f"{place}: values {missing} removed"
    yield from _alternatives(frozen.get("anyOf"), now.get("anyOf"), place)
    yield from _codes(frozen.get("allOf", []), now.get("allOf", []), place)
    for key in sorted((frozen.keys() | now.keys()) - FREE):
        old, new = frozen.get(key), now.get(key)
        if isinstance(old, dict) and isinstance(new, dict):
            yield from breaking(old, new, f"{place}/{key}")
        elif old != new:
            yield f"{place}: {key} {old!r} became {new!r}"


def _types(schema: dict[str, Any]) -> list[str]:
    types = schema.get("type", [])
    return sorted([types] if isinstance(types, str) else types)


def _alternatives(frozen: Any, now: Any, place: str) -> Iterator[str]:
    """An object of another kind may be added, such as the details of a finding; a number must not become a text."""
    if (frozen is None) != (now is None):
        yield f"{place}: alternatives {'added' if frozen is None else 'removed'}"
        return
    for number, old in enumerate(frozen or ()):
        if all(list(breaking(old, new)) for new in now):
            yield f"{place}: alternative {number} removed or changed"
    unchanged = [new for new in now or () if any(not list(breaking(old, new)) for old in frozen)]
    if any(new not in unchanged and _types(new) != ["object"] for new in now or ()):
        yield f"{place}: alternatives added"


def _codes(frozen: Any, now: Any, place: str) -> Iterator[str]:
    """Conditions, one for each code of a finding: codes may be added."""
    new = {str(condition["if"]): condition["then"] for condition in now}
    for condition in frozen:
        code = condition["if"]["properties"]["code"]["const"]
        if str(condition["if"]) not in new:
            yield f"{place}/{code}: removed"
        else:
            old, then = (each["properties"]["details"] for each in (condition["then"], new[str(condition["if"])]))
            if "anyOf" in then and "anyOf" not in old:  # a second kind of this code
                old = {"anyOf": [old]}
            yield from breaking(old, then, f"{place}/{code}")


def opened(schema: Any) -> Any:
    """The schema for a reader, in which unknown names and values are not an error."""
    if isinstance(schema, list):
        return [opened(item) for item in schema]
    if not isinstance(schema, dict):
        return schema
    content = {key: value for key, value in schema.items() if not (key == "additionalProperties" and value is False)}
    return {key: opened(value) for key, value in content.items() if key != "enum"}
