"""Requests of the step in which the curves of a figure are clicked."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from starlette.responses import Response

from sigmatau.app.answers import text_answer
from sigmatau.app.bodies import read_body, whole_number_in

if TYPE_CHECKING:
    from starlette.requests import Request

    from sigmatau.app.routes import Handler, Workbench


def figure_routes(workbench: Workbench) -> list[tuple[str, str, Handler]]:
    """Path, method and handler of each request."""
    handlers = _Figures(workbench)
    return [
        ("/api/figure", "POST", handlers.facts),
        ("/api/figure/picture", "POST", handlers.picture),
        ("/api/figure/curves", "POST", handlers.curves),
    ]


class _Figures:
    """Handlers of a figure."""

    def __init__(self, workbench: Workbench) -> None:
        self._workbench = workbench

    async def _ask(self, request: Request, call: str) -> Any:  # noqa: ANN401  what the call returns
        body = await read_body(request)
        log = self._workbench.find_log(body)
        return await self._workbench.ask(None, call, log=log, page=whole_number_in(body, "page"))

    async def facts(self, request: Request) -> Response:
        """Form, size and lines of a figure."""
        return text_answer(await self._ask(request, "figure_facts"))

    async def picture(self, request: Request) -> Response:
        """The picture of a figure."""
        body, media = await self._ask(request, "picture")
        return Response(body, media_type=media)

    async def curves(self, request: Request) -> Response:
        """Coefficients of clicked curves."""
        return text_answer(await self._workbench.ask(None, "clicked_curves", clicks=await read_body(request)))
