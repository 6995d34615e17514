"""Requests of the live view: serial ports, and the live record."""

from __future__ import annotations

import asyncio
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from starlette.concurrency import run_in_threadpool
from starlette.responses import Response

from sigmatau.app.answers import CallError, json_answer, missing, text_answer
from sigmatau.app.bodies import read_body, refuse_body, table_in, text_in, whole_number_in
from sigmatau.errors import DataError

if TYPE_CHECKING:
    from starlette.requests import Request

    from sigmatau.app.recording import Recording
    from sigmatau.app.routes import Handler, Workbench

_BAUD = 115200  # default speed of a port [bit/s]


def live_routes(workbench: Workbench) -> list[tuple[str, str, Handler]]:
    """Path, method and handler of each request."""
    handlers = _LiveRecord(workbench)
    return [
        ("/api/ports", "GET", handlers.ports),
        ("/api/live", "GET", handlers.state),
        ("/api/live/start", "POST", handlers.start),
        ("/api/live/options", "POST", handlers.change_options),
        ("/api/live/columns", "POST", handlers.columns),
        ("/api/live/stop", "POST", handlers.stop),
    ]


class _LiveRecord:
    """Handlers of the live record. A workbench has at most one at a time, which all pages share."""

    def __init__(self, workbench: Workbench) -> None:
        self._workbench = workbench
        self._starting = asyncio.Lock()

    async def ports(self, request: Request) -> Response:
        """The serial ports of this computer."""
        return text_answer(await self._workbench.ask(None, "ports"))

    async def state(self, request: Request) -> Response:
        """The live record so far."""
        recording = self._workbench.recording
        return json_answer({"state": "none"}) if recording is None else text_answer(recording.content())

    async def start(self, request: Request) -> Response:
        """Record a serial port, or follow a file to which another program writes."""
        body = await read_body(request)
        path, save = text_in(body, "path"), text_in(body, "save")
        if path is not None and not (save is None and body.get("port") is None):
            raise refuse_body("give path, for a file that another program writes, or port and save")
        source = await self._workbench.ask(
            None,
            "live_source",
            port=text_in(body, "port"),
            path=None if path is None else str(self._workbench.roots.find(path)),
            baud=_BAUD if body.get("baud") is None else whole_number_in(body, "baud"),
            save=None if save is None else str(self._workbench.roots.new_file(save)),
            table=table_in(body),
        )
        async with self._starting:
            running = self._workbench.recording
            if running is not None and running.running:
                message = f"{running.source.source} is being recorded; stop it first"
                raise CallError({"message": message, "hint": None, "code": "conflict"})
            self._workbench.recording = recording = await run_in_threadpool(_begin, source)
            if running is not None:
                running.close()
        return text_answer(recording.content(), 202)

    async def change_options(self, request: Request) -> Response:
        """Change the reading options."""
        recording, table = self._recording(), table_in(await read_body(request))
        source = recording.source
        if source.source == "-":
            checked = replace(source, table=table)
        else:
            origin: dict[str, Any] = {"port": source.source} if source.baud is not None else {"path": source.source}
            checked = await self._workbench.ask(
                None,
                "live_source",
                **({"port": None, "path": None} | origin),
                baud=source.baud or _BAUD,
                save=source.save,
                table=table,
            )
        recording.change_options(table, checked.command)
        return json_answer({"options": table})

    async def columns(self, request: Request) -> Response:
        """The columns of the first lines, read with the options of the request."""
        from sigmatau.app.log import LogFile

        recording, table = self._recording(), table_in(await read_body(request))
        log = LogFile(path=recording.first_lines, name=recording.source.source)
        return text_answer(await self._workbench.ask(log.path, "open", log=log, table=table))

    async def stop(self, request: Request) -> Response:
        """End the live record."""
        recording = self._recording()
        return json_answer({"path": await run_in_threadpool(recording.stop)})

    def _recording(self) -> Recording:
        """The live record; raises `CallError` if there is none."""
        if self._workbench.recording is None:
            raise missing("nothing is recorded; choose a serial port first")
        return self._workbench.recording


def _begin(source: Any) -> Recording:  # noqa: ANN401  a LiveSource
    """Begin to record a source; raises `CallError` if it cannot be opened."""
    from sigmatau.app.recording import Recording

    try:
        return Recording(source)
    except DataError as error:
        raise CallError({"message": str(error), "hint": None, "code": "data"}) from None
