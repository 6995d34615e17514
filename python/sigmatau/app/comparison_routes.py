"""Requests of the comparison step: several results, runs of a store, and curves of datasheets and models."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from starlette.responses import Response

from sigmatau.app.answers import json_answer, text_answer
from sigmatau.app.bodies import read_body, refuse_body, text_in, whole_number_in
from sigmatau.app.jobs import Result

if TYPE_CHECKING:
    from starlette.requests import Request

    from sigmatau.app.routes import Handler, Workbench

_MOST_COMPARED = 64  # largest number of results in a comparison


def comparison_routes(workbench: Workbench) -> list[tuple[str, str, Handler]]:
    """Path, method and handler of each request."""
    handlers = _Comparisons(workbench)
    return [
        ("/api/compare", "POST", handlers.compare),
        ("/api/runs", "POST", handlers.runs),
        ("/api/runs/open", "POST", handlers.open_run),
        ("/api/datasheets", "GET", handlers.datasheets),
        ("/api/specification", "POST", handlers.specification),
    ]


class _Comparisons:
    """Handlers that compare the files and results of a workbench."""

    def __init__(self, workbench: Workbench) -> None:
        self._workbench = workbench

    async def compare(self, request: Request) -> Response:
        """Compare several results."""
        ids = (await read_body(request)).get("results")
        if not isinstance(ids, list) or not 2 <= len(ids) <= _MOST_COMPARED:
            raise refuse_body("results must be the identifiers of two or more results")
        results = [await self._result(id_) for id_ in ids]
        sources = [(each.name, json.loads(each.shown)["command"]) for each in results]
        analyses = [each.analysis for each in results]
        return text_answer(await self._workbench.ask(None, "compare", analyses=analyses, sources=sources))

    async def _result(self, named: object) -> Result:
        """A result by its identifier, or by the path of its file."""
        if not isinstance(named, dict):
            return self._workbench.results.find(named)
        log = self._workbench.find_log(named)
        return Result(**await self._workbench.ask(log.path, "read_result", log=log), name=log.name)

    async def runs(self, request: Request) -> Response:
        """The runs of a store: of all units, or of units whose names match a pattern."""
        body = await read_body(request)
        log = self._workbench.find_log(body)
        return text_answer(await self._workbench.ask(log.path, "runs", log=log, unit=text_in(body, "unit")))

    async def open_run(self, request: Request) -> Response:
        """Open the result of a run of a store; the answer has its identifier."""
        body = await read_body(request)
        log, run = self._workbench.find_log(body), whole_number_in(body, "run")
        if run is None:
            raise refuse_body("run must be the number of a run")
        parts: dict[str, Any] = await self._workbench.ask(log.path, "stored_run", log=log, run=run)
        return json_answer({"result": self._workbench.results.add(Result(**parts)), "name": parts["name"]})

    async def datasheets(self, request: Request) -> Response:
        """The datasheets of the library."""
        return text_answer(await self._workbench.ask(None, "datasheets"))

    async def specification(self, request: Request) -> Response:
        """The curves of a datasheet of the library, or of the file of a datasheet or a model."""
        body = await read_body(request)
        log = None if body.get("name") is not None else self._workbench.find_log(body)
        values = {name: text_in(body, name) for name in ("name", "use", "sided", "bias")}
        return text_answer(await self._workbench.ask(None, "specification", log=log, **values))
