"""Bodies of requests: JSON objects, and the values in them."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from sigmatau.app.answers import CallError

if TYPE_CHECKING:
    from starlette.requests import Request


def refuse_body(message: str) -> CallError:
    """The error of an invalid body."""
    return CallError({"message": message, "hint": None, "code": "option"})


async def read_body(request: Request) -> dict[str, Any]:
    """The JSON object in the body of a request; raises `CallError` if it is not an object."""
    try:
        body = json.loads(await request.body(), parse_constant=_refuse_constant)
    except (ValueError, RecursionError):
        raise refuse_body("the body is not JSON") from None
    if not isinstance(body, dict):
        raise refuse_body("the body must be an object")
    return body


def _refuse_constant(name: str) -> None:
    raise ValueError(name)


def table_in(body: Mapping[str, Any], key: str = "options") -> dict[str, Any]:
    """The options in a body by name; empty if it has none. Raises `CallError` if they are not an object."""
    options = body.get(key) or {}
    if not isinstance(options, dict):
        raise refuse_body(f"{key} must be an object")
    return options


def number_in(body: Mapping[str, Any], name: str) -> float | None:
    """A number in a body; None if it is absent. Raises `CallError` for a value of another type."""
    value = body.get(name)
    if value is None:
        return None
    if not isinstance(value, int | float) or isinstance(value, bool):
        raise refuse_body(f"{name} must be a number")
    return float(value)


def text_in(body: Mapping[str, Any], name: str) -> str | None:
    """A text in a body; None if it is absent. Raises `CallError` for a value of another type."""
    value = body.get(name)
    if value is not None and not isinstance(value, str):
        raise refuse_body(f"{name} must be a text")
    return value


def whole_number_in(body: Mapping[str, Any], name: str) -> int | None:
    """A whole number in a body; None if it is absent. Raises `CallError` for a value of another type."""
    value = body.get(name)
    if value is not None and (not isinstance(value, int) or isinstance(value, bool)):
        raise refuse_body(f"{name} must be a whole number")
    return value
