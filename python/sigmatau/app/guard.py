"""Refusal of requests from other hosts and origins, with a wrong token, or with a body that is too large; and the headers of
all answers.
"""

from __future__ import annotations

import hmac
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

from starlette.datastructures import Headers, MutableHeaders

from sigmatau.app.answers import error_answer

if TYPE_CHECKING:
    from starlette.types import ASGIApp, Message, Receive, Scope, Send

MAX_BODY = 1 << 20
"""Largest body of a request that is not an upload. [bytes]"""

HEADERS: Mapping[str, str] = {
    "Content-Security-Policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; connect-src 'self';"
        " font-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    ),
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}
"""Headers of every answer."""

_SAME_SITE = (
    "same-origin",
    "none",
)  # values of Sec-Fetch-Site in requests of the page, and in those that the user types


class Guard:
    """Passes on only requests of the page, after removing the token from the path.

    If the name of another host is resolved to this computer (DNS rebinding), the header Host has that name. A page of
    another site sends its Origin, and does not know the token.
    """

    def __init__(self, app: ASGIApp, *, token: str, hosts: Iterable[str], max_upload: int) -> None:
        self._app = app
        self._token = token.encode()
        self._hosts = frozenset(hosts)
        self._max_upload = max_upload

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        if scope["type"] != "http":  # a web socket
            await send({"type": "websocket.close", "code": 1008})
            return
        send = _with_headers(send)
        headers = Headers(scope=scope)
        refusal = self._refusal(scope, headers)
        if refusal is not None:
            status, message = refusal
            await error_answer(status, message)(scope, receive, send)
            return
        path = str(scope["path"]).removeprefix(f"/{self._token.decode()}")
        limit = self._max_upload if path == "/api/upload" else MAX_BODY
        if _content_length(headers) > limit:
            await error_answer(413, f"the body is larger than {limit} bytes")(scope, receive, send)
            return
        scope = {**scope, "path": path, "raw_path": path.encode(), "root_path": ""}
        await self._app(scope, _bounded(receive, limit), send)

    def _refusal(self, scope: Scope, headers: Headers) -> tuple[int, str] | None:
        """Status and reason if a request is refused; otherwise None."""
        hosts = headers.getlist("host")
        if len(hosts) != 1 or hosts[0] not in self._hosts:
            return 403, "the name of the host is not that of this server"
        origin = headers.get("origin")
        if origin is not None and origin != f"http://{hosts[0]}":
            return 403, "the request comes from another site"
        first, slash, rest = str(scope["path"]).removeprefix("/").partition("/")
        if not (hmac.compare_digest(first.encode(errors="surrogateescape"), self._token) and slash):
            return 404, "no such page; sigmatau app prints its address"
        if rest and headers.get("sec-fetch-site", "none") not in _SAME_SITE:
            return 403, "the request comes from another site"
        return None


class TooLargeError(Exception):
    """A body is larger than its limit."""


def _content_length(headers: Headers) -> int:
    text = headers.get("content-length", "0")
    return int(text) if text.isdecimal() and len(text) < 20 else 0


def _bounded(receive: Receive, limit: int) -> Receive:
    """Limit the size of the body that is read, whatever its header declares; raises `TooLargeError`."""
    size = 0

    async def bounded() -> Message:
        nonlocal size
        message = await receive()
        size += len(message.get("body", b""))
        if size > limit:
            raise TooLargeError(f"the body is larger than {limit} bytes")
        return message

    return bounded


def _with_headers(send: Send) -> Send:
    async def guarded(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            for name, value in HEADERS.items():
                headers[name] = value
        await send(message)

    return guarded
