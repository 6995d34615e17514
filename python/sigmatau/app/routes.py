"""Requests and answers: every path of the server, below its token.

The schema is on the page ``docs/how-to/workbench-api.md``. Worker processes read the logs and make the answers.
"""

from __future__ import annotations

import contextlib
import json
import mimetypes
import threading
from collections.abc import Awaitable, Callable, Iterator, Mapping
from importlib import resources
from importlib.resources.abc import Traversable
from typing import TYPE_CHECKING, Any

from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.responses import Response
from starlette.routing import Route

from sigmatau.app.answers import CallError, error_answer, failed_answer, file_answer, json_answer, missing, text_answer
from sigmatau.app.bodies import number_in, read_body, table_in, text_in, whole_number_in
from sigmatau.app.comparison_routes import comparison_routes
from sigmatau.app.figure_routes import figure_routes
from sigmatau.app.files import Roots, Upload, Uploads
from sigmatau.app.guard import TooLargeError
from sigmatau.app.jobs import Jobs, Result, Results
from sigmatau.app.live_routes import live_routes
from sigmatau.app.workers import Workers

if TYPE_CHECKING:
    from starlette.requests import Request

    from sigmatau.app.recording import Recording

Handler = Callable[["Request"], Awaitable[Response]]

_VIEWERS, _ANALYSES = 2, 2  # number of processes for short requests of the page, and for analyses
_PATIENCE = 300.0  # longest time of a short request [s]
_WIDTH = 1000  # default number of intervals of an envelope


class Workbench:
    """The state of a server: files, workers, analyses and results.

    Parameters
    ----------
    roots : Roots
        Files that the page may name by path.
    max_upload : int
        Largest size of all uploaded files together. [bytes]
    recording : Recording, optional
        The live record of the command line.
    """

    def __init__(self, roots: Roots, *, max_upload: int, recording: Recording | None = None) -> None:
        self.roots = roots
        self.recording: Recording | None = recording
        self.uploads: Uploads = Uploads(max_upload)
        self.viewers: Workers = Workers(_VIEWERS, ("about", "open"))
        self.analyses: Workers = Workers(_ANALYSES, ("analyze",))
        self.results: Results = Results()
        self.jobs: Jobs = Jobs(self.analyses, self.results)
        self._about: dict[str, Any] | None = None
        self._files = dict(_static_files())

    def application(self) -> Starlette:
        """The application, to which `Guard` passes requests."""
        routes = [
            ("/", "GET", self.page),
            ("/static/{name:path}", "GET", self.static),
            ("/api/about", "GET", self.about),
            ("/api/files", "GET", self.files),
            ("/api/upload", "POST", self.upload),
            ("/api/upload/{id}", "DELETE", self.remove_upload),
            ("/api/open", "POST", self.open),
            ("/api/envelope", "POST", self.envelope),
            ("/api/config", "POST", self.config),
            ("/api/analyze", "POST", self.analyze),
            ("/api/jobs/{id}", "GET", self.job),
            ("/api/jobs/{id}", "DELETE", self.cancel),
            ("/api/results/{id}", "GET", self.result),
            ("/api/results/{id}/charts", "GET", self.charts),
            ("/api/results/{id}/read-off", "POST", self.read_off),
            ("/api/results/{id}/{name}", "GET", self.download),
            ("/api/export", "POST", self.export),
            *comparison_routes(self),
            *figure_routes(self),
            *live_routes(self),
        ]
        return Starlette(
            routes=[Route(path, _with_error_answers(handler), methods=[method]) for path, method, handler in routes],
            exception_handlers={404: _no_such_path, 405: _no_such_path, Exception: _internal},
        )

    def close(self) -> None:
        """End the live record and the workers, and remove the uploaded files."""
        if self.recording is not None:
            self.recording.close()
        self.viewers.close()
        self.analyses.close()
        self.uploads.close()

    async def page(self, request: Request) -> Response:
        """The page."""
        return Response(self._files["index.html"].read_bytes(), media_type="text/html")

    async def static(self, request: Request) -> Response:
        """A script or a style of the page, including those that it shares with the report."""
        name = request.path_params["name"]
        if name not in self._files:
            raise missing(f"no such file: {name}")
        kind = "text/javascript" if name.endswith(".js") else mimetypes.guess_type(name)[0]
        return Response(self._files[name].read_bytes(), media_type=kind or "application/octet-stream")

    async def about(self, request: Request) -> Response:
        """Version, folders, targets, terms and units."""
        if self._about is None:
            self._about = json.loads(await self.ask(None, "about"))
        facts = {
            "roots": list(map(str, self.roots.places)),
            "max_upload": self.uploads.room(),
            "live": self.recording is not None,
            "folder": None if (folder := self.roots.folder()) is None else str(folder),
        }
        return json_answer(self._about | facts)

    async def files(self, request: Request) -> Response:
        """The files of a folder; without a path, the folders that the command line names."""
        path = request.query_params.get("path")
        if not path:
            places = list(map(str, self.roots.places))
            return text_answer(await self.ask(None, "named", places=places, stores=self.roots.stores))
        folder = self.roots.find(path)
        if not folder.is_dir():
            raise missing(f"{path}: is not a folder")
        parent = self.roots.parent(folder)
        return text_answer(
            await self.ask(None, "files", folder=str(folder), parent=None if parent is None else str(parent))
        )

    async def upload(self, request: Request) -> Response:
        """Save the body as a temporary file."""
        id_, name, path = self.uploads.begin(request.query_params.get("name", ""))
        size, upload = 0, None
        try:
            with path.open("xb") as file:
                async for part in request.stream():
                    self.uploads.receive(id_, len(part))
                    size += len(part)
                    await run_in_threadpool(file.write, part)
            upload = Upload(name=name, path=path, size=size)
        finally:
            self.uploads.end(id_, upload)
            if upload is None:
                path.unlink(missing_ok=True)
        return json_answer({"file": id_, "name": name, "bytes": size})

    async def remove_upload(self, request: Request) -> Response:
        """Remove an uploaded file."""
        self.uploads.remove(request.path_params["id"])
        return json_answer({"removed": True})

    async def open(self, request: Request) -> Response:
        """Open a file: the answer has the columns of a log, the runs of a store, or the identifier of a result."""
        body = await read_body(request)
        threading.Thread(target=self.analyses.warm, daemon=True).start()  # an analysis usually follows
        log = self.find_log(body)
        kind = "store" if body.get("store") is not None else await self.ask(None, "kind", log=log)
        if kind == "result":
            parts = await self.ask(log.path, "read_result", log=log)
            return json_answer({"kind": kind, "result": self.results.add(Result(**parts, name=log.name))})
        if kind == "store":
            return text_answer(await self.ask(log.path, "runs", log=log, unit=None))
        if kind in ("model", "datasheet", "figure"):
            return json_answer({"kind": kind, "source": log.name})
        if kind == "session":
            return text_answer(await self.ask(None, "session", log=log))
        return text_answer(await self.ask(log.path, "open", log=log, table=table_in(body)))

    async def envelope(self, request: Request) -> Response:
        """The envelope of the samples."""
        body = await read_body(request)
        log = self.find_log(body)
        values: dict[str, Any] = {name: number_in(body, name) for name in ("from_s", "to_s")}
        width = whole_number_in({"width": _WIDTH} | body, "width")
        channel = text_in(body, "channel")
        values |= {"log": log, "table": table_in(body), "channel": channel, "width": width}
        return text_answer(await run_in_threadpool(self._envelope, log.path, values))

    def _envelope(self, path: str, values: dict[str, Any]) -> str:
        """The envelope of the samples, from the worker that analysed the log if it is idle."""
        with self.analyses.take_reader(path) as reader:
            drawn = reader and reader.call("envelope", values | {"may_read": False}, patience=_PATIENCE)
        if drawn is None:
            with self.viewers.take(path) as worker:
                drawn = worker.call("envelope", values | {"may_read": True}, patience=_PATIENCE)
        return str(drawn)

    async def config(self, request: Request) -> Response:
        """Convert options to a configuration file, or a configuration file to options."""
        body = await read_body(request)
        table = table_in(body) if "options" in body else None
        toml, log, target = text_in(body, "toml"), text_in(body, "log"), text_in(body, "target")
        choices = table_in(body, "choices")
        return text_answer(
            await self.ask(None, "config", table=table, toml=toml, log_name=log, target=target, choices=choices)
        )

    async def analyze(self, request: Request) -> Response:
        """Start an analysis."""
        body = await read_body(request)
        log = self.find_log(body)
        job = self.jobs.start(log, table_in(body))
        threading.Thread(target=self._release, args=(log.path,), daemon=True).start()
        return json_answer({"job": job.id}, 202)

    def _release(self, path: str) -> None:
        """Release the record of a log that was opened: the worker that analyses it reads its own copy."""
        with self.viewers.take_reader(path) as worker, contextlib.suppress(CallError):
            if worker is not None:
                worker.call("forget", {})

    async def job(self, request: Request) -> Response:
        """State of a running analysis."""
        return json_answer(self.jobs.find(request.path_params["id"]).content())

    async def cancel(self, request: Request) -> Response:
        """Cancel an analysis."""
        job = self.jobs.find(request.path_params["id"])
        job.cancel()
        return json_answer(job.content())

    async def result(self, request: Request) -> Response:
        """A result, with the text that the page shows with it."""
        id_ = request.path_params["id"]
        result = self.results.find(id_)
        return text_answer(f'{{"id": {json.dumps(id_)}, "result": {result.result.strip()}, {result.shown[1:]}')

    async def charts(self, request: Request) -> Response:
        """The charts with densities, time series and maps."""
        result = self.results.find(request.path_params["id"])
        if result.log is None:
            raise CallError({"message": "the result has no samples", "hint": None, "code": "conflict"})
        return text_answer(await run_in_threadpool(self._make_charts, result))

    def _make_charts(self, result: Result) -> str:
        """The charts of a result, which are made at the first request."""
        with result.lock:
            if not result.charts:
                values = {"analysis": result.analysis, "log": result.log, "table": result.table}
                with self.analyses.take(result.log.path) as worker:
                    result.content, result.charts = worker.call("charts", values)
        return result.charts

    async def read_off(self, request: Request) -> Response:
        """Read off a term along a line that the user drew."""
        result = self.results.find(request.path_params["id"])
        body = await read_body(request)
        values = {name: number_in(body, name) for name in ("tau_s", "from_s", "to_s")}
        channel, term = str(body.get("channel")), str(body.get("term"))
        force = body.get("force") is True
        return text_answer(
            await self.ask(
                _key(result), "read_off", analysis=result.analysis, channel=channel, term=term, force=force, **values
            )
        )

    async def download(self, request: Request) -> Response:
        """A file of a result to save."""
        result, name = self.results.find(request.path_params["id"]), request.path_params["name"]
        stem = _stem(result)
        if name == "result.json":
            return file_answer(result.result.encode(errors="backslashreplace"), _json_name(result), "application/json")
        if name == "session.toml" and result.log is not None:
            text = json.loads(result.shown)["toml"]
            return file_answer(text.encode(errors="backslashreplace"), f"{stem}.toml", "application/toml")
        if name in ("report.html", "report.pdf"):
            if result.log is not None:
                await run_in_threadpool(self._make_charts, result)
            form = name.partition(".")[2]
            body = await self.ask(_key(result), "report", analysis=result.analysis, content=result.content, form=form)
            return file_answer(body, f"{stem}.{form}", "text/html" if form == "html" else "application/pdf")
        if name in ("curve.csv", "coefficients.csv"):
            what = name.partition(".")[0]
            body = await self.ask(_key(result), "curve", analysis=result.analysis, what=what)
            return file_answer(body, f"{stem}-{what}.csv", "text/csv")
        if name in ("figure.svg", "figure.png"):
            form = name.partition(".")[2]
            body = await self.ask(_key(result), "figure", analysis=result.analysis, form=form)
            return file_answer(body, f"{stem}.{form}", "image/svg+xml" if form == "svg" else "image/png")
        raise missing(f"a result has no {name}")

    async def export(self, request: Request) -> Response:
        """A preview of the file that an export writes."""
        body = await read_body(request)
        result = self.results.find(body.get("result"))
        target = str(body.get("target"))
        table = table_in(body, "choices")
        rest = None if body.get("inflate") is None else self.results.find(body["inflate"])
        turn_on = None if body.get("turn_on") is None else self.find_log(table_in(body, "turn_on"))
        return text_answer(
            await self.ask(
                _key(result), "export", analysis=result.analysis, target=target, table=table,
                rest=None if rest is None else rest.analysis, rest_name="" if rest is None else _json_name(rest),
                turn_on=turn_on,
            )
        )  # fmt: skip

    def find_log(self, body: Mapping[str, Any]) -> Any:  # noqa: ANN401  a LogFile
        """The log that a body names, by `file` or `path`; or a store of the command line, by `store`."""
        from sigmatau.app.log import LogFile

        if body.get("store") is not None:
            url, name = self.roots.find_store(body["store"])
            return LogFile(path=url, name=name)
        if body.get("file") is not None:
            upload = self.uploads.find(body["file"])
            return LogFile(path=str(upload.path), name=upload.name)
        path = str(self.roots.find(body.get("path")))
        return LogFile(path=path, name=path)

    async def ask(self, key: object, call: str, **values: Any) -> Any:  # noqa: ANN401  what the call returns
        """Run a short call in a worker; a worker that has read `key` is preferred."""

        def work() -> Any:  # noqa: ANN401
            with self.viewers.take(key, sticky=key is not None) as worker:
                return worker.call(call, values, patience=_PATIENCE)

        return await run_in_threadpool(work)


def _stem(result: Result) -> str:
    """The name of the log without folders and endings."""
    return result.name.replace("\\", "/").rpartition("/")[2].partition(".")[0] or "result"


def _json_name(result: Result) -> str:
    return f"{_stem(result)}.json"


def _key(result: Result) -> object:
    return None if result.log is None else result.log.path


def _with_error_answers(handler: Handler) -> Handler:
    """Wrap a handler, so that its errors become answers."""

    async def answer(request: Request) -> Response:
        try:
            return await handler(request)
        except CallError as error:
            return failed_answer(error)
        except TooLargeError as error:
            return error_answer(413, str(error))

    return answer


async def _no_such_path(request: Request, error: Exception) -> Response:
    return error_answer(404, "no such path")


async def _internal(request: Request, error: Exception) -> Response:
    return error_answer(500, f"internal error: {error!r}")


def _static_files() -> Iterator[tuple[str, Traversable]]:
    """Files of the page by name, after those of the charts of reports, so that a file of the page replaces a shared one."""
    for package, folder in (("sigmatau.reporting", "assets"), ("sigmatau.app", "page")):
        yield from _files_below(resources.files(package).joinpath(folder), "")


def _files_below(folder: Traversable, prefix: str) -> Iterator[tuple[str, Traversable]]:
    for entry in folder.iterdir():
        if entry.is_dir():
            yield from _files_below(entry, f"{prefix}{entry.name}/")
        else:
            yield f"{prefix}{entry.name}", entry
