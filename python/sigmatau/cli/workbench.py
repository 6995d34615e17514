"""``sigmatau app``: the workbench in the browser."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from sigmatau.app.server import MAX_UPLOAD, need_libraries, serve
from sigmatau.cli.declared import Flag, Quiet
from sigmatau.cli.options import say
from sigmatau.errors import DataError, OptionError


def app_command(
    *paths: Path,
    port: int = 0,
    no_browser: Annotated[bool, Flag, Parameter(name="--no-browser")] = False,
    max_upload: float = MAX_UPLOAD / 1e9,
    quiet: Quiet = False,
) -> int:
    """Open the workbench in the browser: choose columns, analyse, read off by eye, export.

    It is served on this computer only, to those who have its address, and reads no file but those that are named here, those
    in folders that are named here, and those that are dropped on the page. It ends with Ctrl-C.

    Parameters
    ----------
    paths
        Logs, results, and folders of them. Default: the current folder.
    port
        Number of the port. Default: any that is free.
    no_browser
        Print the address only.
    max_upload
        Largest size in GB of all files that are dropped on the page.
    quiet
        Do not print how to end it.
    """
    if not 0 <= port < 1 << 16:
        raise OptionError(f"--port {port}: must be a number from 0 to 65535", option="port")
    if not 0 < max_upload < 1e6:
        raise OptionError(f"--max-upload {max_upload}: must be a positive number of GB", option="max_upload")
    need_libraries()
    for path in paths:
        if not path.exists():
            raise DataError(f"{path}: there is no such file or folder")

    def ready(address: str) -> None:
        sys.stdout.write(f"{address}\n")
        sys.stdout.flush()
        say("Ctrl-C ends it.", quiet=quiet)
        if not no_browser:
            import webbrowser

            webbrowser.open(address)

    serve(paths or [Path()], port=port, max_upload=int(max_upload * 1e9), ready=ready)
    return 0
