"""The JSON Schema of a result, from the types of its JSON form, of the details of findings, and of the options."""

import json
import types
import typing
from collections.abc import Mapping
from dataclasses import MISSING, fields, is_dataclass

import numpy as np

from sigmatau._version import SCHEMA
from sigmatau.analysis.forms import CoefficientForm, ResultForm, TermForm
from sigmatau.analysis.options import AnalysisOptions
from sigmatau.decoding import Key
from sigmatau.findings import details_by_code
from sigmatau.fitting.fitted_values import Interval
from sigmatau.hints import as_arguments, worded
from sigmatau.io.read.options import ReadOptions
from sigmatau.noise.terms import TERMS
from sigmatau.options import declared

PLAIN = {float: "number", int: "integer", str: "string", bool: "boolean"}
NAMED = {Interval: "interval", TermForm: "fitted", CoefficientForm: "coefficient"}
ARRAYS = {
    np.int64: ("counts", {"type": "integer", "minimum": 1}),
    np.float64: ("numbers", {"type": "number", "minimum": 0}),
}
NO_KEY = Key(about="", always=True, null=False, bounds={})


def schema_of(kind, bounds, *, details=False, within=()):
    """The schema of a type. `details`: whether it is for details of a finding, in which numbers that are not finite are
    null.
    """
    if kind is typing.Any:
        return {}
    if kind in PLAIN:
        if "enum" in bounds or "const" in bounds:
            return dict(bounds)
        return {"type": ["number", "null"] if details and kind is float else PLAIN[kind], **bounds}
    if kind in within:  # a recursive type
        return {"type": "object"}
    if is_dataclass(kind):
        if kind in NAMED and not details:
            return {"$ref": f"#/$defs/{NAMED[kind]}"}
        return schema_of_dataclass(kind, details=details, within=(*within, kind))
    origin, arguments = typing.get_origin(kind), typing.get_args(kind)
    inside = {"details": details, "within": within}
    if origin is tuple:
        if arguments[-1] is Ellipsis or details:
            items = [schema_of(argument, bounds, **inside) for argument in arguments if argument is not Ellipsis]
            alike = items[0] if len(set(map(str, items))) == 1 else {}
            optional = not details and type(None) in typing.get_args(arguments[0])
            return {"type": "array", "items": nullable(alike) if optional else alike}
        return {
            "type": "array",
            "items": schema_of(arguments[0], bounds, **inside),
            "minItems": len(arguments),
            "maxItems": len(arguments),
        }
    if origin in (typing.Union, types.UnionType):
        some = [argument for argument in arguments if argument is not type(None)]
        if details or len(some) > 1:
            inside["details"] = True  # kinds of reasons, as in findings
            return {
                "anyOf": [
                    {"type": "null"} if argument is type(None) else schema_of(argument, bounds, **inside)
                    for argument in arguments
                ]
            }
        return schema_of(some[0], bounds, **inside)
    if origin is typing.Literal:
        return {"enum": list(arguments)}
    if origin is np.ndarray:
        name, item = ARRAYS[typing.get_args(arguments[1])[0]]
        return (
            {"$ref": f"#/$defs/{name}"} if not bounds else {"type": "array", "items": {"type": item["type"], **bounds}}
        )
    assert issubclass(origin, Mapping), kind
    if details or arguments[1] is typing.Any:
        return {"type": "object"}
    if arguments[1] is CoefficientForm:
        each = schema_of(arguments[1], bounds, **inside)
        return {"type": "object", "additionalProperties": False, "properties": dict.fromkeys(TERMS, each)}
    return {"type": "object", "additionalProperties": schema_of(arguments[1], bounds, **inside)}


def schema_of_dataclass(kind, *, details, within):
    hints, properties, required = typing.get_type_hints(kind), {}, []
    for each in fields(kind):
        if not details and Key not in each.metadata and each.default is not MISSING:
            continue  # keys of earlier versions
        key = each.metadata.get(Key, NO_KEY)
        schema = schema_of(hints[each.name], key.bounds, details=details, within=within)
        optional = Key not in each.metadata and type(None) in typing.get_args(hints[each.name])
        if not details and (key.null or optional):
            schema = nullable(schema)
        properties[each.name] = schema | (
            {"description": worded(key.about, as_arguments)} if key.about and not details else {}
        )
        if key.always:
            required.append(each.name)
    return {
        "type": "object",
        "additionalProperties": False,
        **({} if details or not required else {"required": required}),
        "properties": properties,
    }


def nullable(schema):
    if "additionalProperties" in schema and "properties" not in schema:  # values of a mapping
        return schema | {"additionalProperties": nullable(schema["additionalProperties"])}
    if "enum" in schema:
        return schema | {"enum": [*schema["enum"], None]}
    return schema | {"type": [schema["type"], "null"]}


def schema_of_options(options):
    """The options in a result, with their choices."""
    type_by_form = {"flag": "boolean", "count": "integer", "number": "number", "seconds": "number"}
    properties = {}
    for name, about in declared(options).items():
        if about.matters:
            kind = {"enum": list(about.choices)} if about.choices else {}
            if about.form in type_by_form and not about.choices:
                kind = {"type": type_by_form[about.form]}
            properties[name] = kind | {
                "description": worded(" ".join(filter(None, (about.text, about.otherwise))), as_arguments)
            }
    return properties


def schema():
    """The schema of a result of this version."""
    whole = schema_of(ResultForm, {})
    finding = whole["properties"]["findings"]["items"]
    finding["allOf"] = [
        {
            "if": {"properties": {"code": {"const": code}}},
            "then": {"properties": {"details": schema_of(kind, {}, details=True)}},
        }
        for code, kind in sorted(details_by_code().items())
    ]
    parts = whole["properties"]["options"]["properties"]
    parts["reading"]["properties"], parts["analysis"]["properties"] = (
        schema_of_options(ReadOptions),
        schema_of_options(AnalysisOptions),
    )
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": f"Result of sigmatau analyze, schema {SCHEMA}",
        **whole,
        "$defs": {
            **{name: {"type": "array", "minItems": 1, "items": items} for name, items in ARRAYS.values()},
            **{name: schema_of_dataclass(kind, details=False, within=(kind,)) for kind, name in NAMED.items()},
        },
    }


def text(value, indent=0):
    """Format JSON with one line for each short part and for each code of a finding."""
    flat = json.dumps(value, ensure_ascii=False)
    if len(flat) <= 100 or not isinstance(value, dict | list) or (isinstance(value, dict) and "if" in value):
        return flat
    if isinstance(value, dict):
        parts = [f"{json.dumps(name)}: {text(each, indent + 1)}" for name, each in value.items()]
    else:
        parts = [text(each, indent + 1) for each in value]
    opening, closing = "{}" if isinstance(value, dict) else "[]"
    lines = ",\n".join(" " * (indent + 1) + part for part in parts)
    return f"{opening}\n{lines}\n{' ' * indent}{closing}"
