"""Answers of the server: JSON text of a worker, errors of one form, and files."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from starlette.responses import Response

STATUS: Mapping[str, int] = {"option": 400, "data": 422, "missing": 404, "conflict": 409, "size": 413, "failed": 500}
"""Status of an answer by the code of its error."""


class CallError(Exception):
    """A failed call, with the content that the page shows.

    Attributes
    ----------
    content : dict
        ``message``, ``code`` (a key of `STATUS`), ``hint`` or None, and further facts.
    """

    def __init__(self, content: Mapping[str, Any]) -> None:
        super().__init__(content["message"])
        self.content: dict[str, Any] = dict(content)


def missing(what: str) -> CallError:
    """The error of a request for something that does not exist; `what` is its message."""
    return CallError({"message": what, "hint": None, "code": "missing"})


def json_answer(content: object, status: int = 200) -> Response:
    """Plain values as JSON."""
    return text_answer(json.dumps(content, allow_nan=False, ensure_ascii=False), status=status)


def text_answer(text: str, status: int = 200) -> Response:
    """Text that is JSON."""
    body = text.encode(errors="backslashreplace")
    return Response(body, status_code=status, media_type="application/json")


def error_answer(status: int, message: str, **fields: object) -> Response:
    """An error of the server itself, which no call raised."""
    code = next((code for code, number in STATUS.items() if number == status), "refused")
    return json_answer({"error": {"message": message, "hint": None, "code": code, **fields}}, status)


def failed_answer(error: CallError) -> Response:
    """The error of a call."""
    return json_answer({"error": error.content}, STATUS[error.content["code"]])


def file_answer(body: bytes, name: str, media: str) -> Response:
    """A file to save."""
    safe = "".join(c if c.isascii() and (c.isalnum() or c in "._-") else "_" for c in name)
    return Response(body, media_type=media, headers={"Content-Disposition": f'attachment; filename="{safe}"'})
