"""The server of the workbench, which only this computer can reach, at an address that cannot be guessed."""

from __future__ import annotations

import importlib.util
import secrets
import socket
import threading
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from sigmatau.errors import DataError

if TYPE_CHECKING:
    from starlette.types import ASGIApp

    from sigmatau.app.files import Roots
    from sigmatau.app.recording import Recording
    from sigmatau.app.routes import Workbench

MAX_UPLOAD = 4_000_000_000
"""Default of the largest size of all uploaded files together. [bytes]"""

_HOST = "127.0.0.1"
_NEEDS = "the workbench needs starlette and uvicorn: pip install 'sigmatau[app]'"


def need_libraries() -> None:
    """Raise `ImportError` if a package of the server is missing; the message has the command that installs it."""
    if any(importlib.util.find_spec(name) is None for name in ("starlette", "uvicorn")):
        raise ImportError(_NEEDS)


def guarded(workbench: Workbench, *, token: str, port: int) -> ASGIApp:
    """The application of a workbench, wrapped by its guard."""
    from sigmatau.app.guard import Guard

    hosts = (f"{_HOST}:{port}", f"localhost:{port}")
    return Guard(workbench.application(), token=token, hosts=hosts, max_upload=workbench.uploads.limit)


def serve(
    places: Iterable[Path],
    *,
    stores: Sequence[str] = (),
    port: int = 0,
    max_upload: int = MAX_UPLOAD,
    recording: Recording | None = None,
    ready: Callable[[str], None],
) -> None:
    """Serve the workbench until Ctrl-C.

    Parameters
    ----------
    places : iterable of Path
        Folders and files that the page may read.
    stores : sequence of str
        URLs of stores on PostgreSQL that the page may read.
    port : int
        Port; 0 for any free port.
    max_upload : int
        Largest size of all uploaded files together. [bytes]
    recording : Recording, optional
        A live record that the page shows.
    ready : callable
        Called with the address of the page when the socket listens, so that the browser starts during the imports.

    Raises
    ------
    DataError
        If the port is not available.
    ImportError
        Without starlette or uvicorn.
    """
    need_libraries()
    from sigmatau.app.files import Roots

    with _open_socket(port) as listener:
        token = secrets.token_urlsafe(24)
        try:
            ready(f"http://{_HOST}:{listener.getsockname()[1]}/{token}/")
            _run(listener, token, Roots(places, stores), max_upload=max_upload, recording=recording)
        except KeyboardInterrupt as interruption:
            if type(interruption) is not KeyboardInterrupt:  # terminated
                raise


def _run(listener: socket.socket, token: str, roots: Roots, *, max_upload: int, recording: Recording | None) -> None:
    """Answer requests at a socket until the server is stopped."""
    import uvicorn

    from sigmatau.app.routes import Workbench

    workbench = Workbench(roots, max_upload=max_upload, recording=recording)
    threading.Thread(target=workbench.viewers.warm, daemon=True).start()
    config = uvicorn.Config(
        guarded(workbench, token=token, port=listener.getsockname()[1]), log_level="critical", access_log=False,
        lifespan="off", ws="none", server_header=False, proxy_headers=False, timeout_graceful_shutdown=1,
    )  # fmt: skip
    try:
        uvicorn.Server(config).run(sockets=[listener])
    finally:
        workbench.close()


def _open_socket(port: int) -> socket.socket:
    listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        listener.bind((_HOST, port))
    except (OSError, OverflowError) as error:
        listener.close()
        reason = error.strerror if isinstance(error, OSError) else None
        raise DataError(f"port {port} is not available: {reason or error}; choose another --port") from None
    listener.listen(128)
    return listener
