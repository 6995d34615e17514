"""``sigmatau app``: the workbench in the browser."""

from __future__ import annotations

import os
import sys
from contextlib import closing, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from sigmatau.app.log import LiveSource
from sigmatau.app.server import MAX_UPLOAD, need_libraries, serve
from sigmatau.cli.declared import Flag, InMain, Quiet
from sigmatau.cli.live_source import check_standard_input, live_source
from sigmatau.cli.options import say
from sigmatau.cli.watch import WatchReading, WatchSettings
from sigmatau.cli.words import check_place
from sigmatau.errors import DataError, OptionError
from sigmatau.io.follow import BAUD
from sigmatau.io.read.options import ReadOptions, check_live_options

if TYPE_CHECKING:
    from sigmatau.app.recording import Recording

_STANDARD_INPUT = "-"
_POSTGRESQL = ("postgresql://", "postgres://", "postgresql+psycopg://")


def app_command(
    *paths: Annotated[str, Parameter(allow_leading_hyphen=True)],
    serial: Annotated[str | None, InMain] = None,
    baud: Annotated[int | None, InMain] = None,
    save: Annotated[Path | None, InMain] = None,
    reading: WatchReading | None = None,
    settings: WatchSettings | None = None,
    port: int = 0,
    no_browser: Annotated[bool, Flag, Parameter(name="--no-browser")] = False,
    max_upload: float = MAX_UPLOAD / 1e9,
    quiet: Quiet = False,
) -> int:
    """Open the workbench in the browser: choose columns, analyse, read off by eye, export.

    It is served on this computer only, to users who have its address. It reads only files and folders that are named
    here, and files that are dropped on the page. Ctrl-C ends it. A serial port is chosen on the page, or by --serial; -
    reads standard input.

    Parameters
    ----------
    paths
        Logs, results, stores, and folders of them; a store on PostgreSQL by its URL; - for live samples on standard
        input. Default: the current folder.
    serial
        Show the samples of a serial port while they arrive: /dev/ttyUSB0, COM3. Needs pyserial.
    baud
        Speed of the serial port, number of bits per second. Default: 115200.
    save
        Write the live samples to this new file, a log for the analysis.
    port
        Number of the port. Default: any free port.
    no_browser
        Print the address only.
    max_upload
        Largest size in GB of all files that are dropped on the page.
    quiet
        Do not print how to end the workbench.
    """
    if not 0 <= port < 1 << 16:
        raise OptionError(f"--port {port}: must be a number from 0 to 65535", option="port")
    if not 0 < max_upload < 1e6:
        raise OptionError(f"--max-upload {max_upload}: must be a positive number of GB", option="max_upload")
    need_libraries()
    stores = [path for path in paths if "://" in path]
    for store in stores:
        if not store.startswith(_POSTGRESQL):
            scheme = store.partition("://")[0]
            raise OptionError(
                f"{scheme}:// is not a store; give postgresql://USER@HOST/NAME, or a file", option="paths"
            )
    places = [Path(path) for path in paths if path != _STANDARD_INPUT and path not in stores]
    for place in places:
        check_place(str(place), command="app")
        if not place.exists():
            raise DataError(f"{place}: there is no such file or folder")
    live = _live(
        "-" if _STANDARD_INPUT in paths else None,
        serial,
        baud,
        save,
        reading or WatchReading(),
        settings or WatchSettings(),
    )
    recording = None if live is None else _begin_recording(live)

    def ready(address: str) -> None:
        sys.stdout.write(f"{address}\n")
        sys.stdout.flush()
        say("Ctrl-C ends it.", quiet=quiet)
        if not no_browser:
            import webbrowser

            webbrowser.open(address)

    with nullcontext() if recording is None else closing(recording):
        if not places and not stores:
            places = [Path()]
        if live is not None and live.save is not None:
            places.append(Path(live.save))
        serve(places, stores=stores, port=port, max_upload=int(max_upload * 1e9), recording=recording, ready=ready)
    return 0


def _live(
    piped: str | None,
    serial: str | None,
    baud: int | None,
    save: Path | None,
    reading: WatchReading,
    settings: WatchSettings,
) -> LiveSource | None:
    """Build the live source; None without a source."""
    table, at_rest = reading.table(), bool(settings.arguments().get("at_rest"))
    if piped is None and serial is None:
        stated = {"baud": baud, "save": save, **table, "at_rest": at_rest or None}
        for name, value in stated.items():
            if value is not None:
                raise OptionError(
                    "{option} is for live samples: give --serial PORT too, or - for standard input", option=name
                )
        return None
    if piped is not None and serial is not None:
        raise OptionError("{option} is read in place of standard input; leave out -", option="serial")
    from sigmatau.typed.config import live_command

    source = live_source("-", serial=serial, baud=baud, save=save)
    if source == "-":
        if os.name == "nt":
            raise OptionError("- is not read by the workbench on Windows: sigmatau watch reads it", option="paths")
        check_standard_input("give --serial PORT, or run logger | sigmatau app -")
    check_live_options(ReadOptions(**reading.arguments()), command="the live view")
    speed = None if serial is None else BAUD if baud is None else baud
    saved = None if save is None else str(save.resolve())
    command = live_command(source, table, baud=speed, save=None if save is None else str(save))
    return LiveSource(source=source, baud=speed, save=saved, table=table, at_rest=at_rest, command=command)


def _begin_recording(live: LiveSource) -> Recording:
    """A record that has begun; only its process reads the standard input."""
    from sigmatau.app.recording import Recording

    recording = Recording(live)
    if live.source == "-":
        null = os.open(os.devnull, os.O_RDONLY)
        os.dup2(null, 0)  # the writing program ends when the record is stopped
        os.close(null)
    return recording
