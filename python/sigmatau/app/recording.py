"""The live record of a workbench: the process that records, and the last state that it sent."""

from __future__ import annotations

import contextlib
import json
import threading
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from sigmatau.errors import DataError
from sigmatau.process import uninterrupted

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

    from sigmatau.app.log import LiveSource

_START = 60.0  # longest time in which the process opens the source [s]
_END = 5.0  # time after which a process that does not stop is killed [s]
_ENDED: dict[str, Any] = {
    "message": "the process that records ended unexpectedly; the saved log has the samples up to its end",
    "hint": None,
    "code": "failed",
}


class Recording:
    """A live record, from the first data until it is stopped.

    Parameters
    ----------
    live_source : LiveSource

    Raises
    ------
    DataError
        If the source cannot be read, or the log cannot be saved.
    """

    def __init__(self, live_source: LiveSource) -> None:
        import multiprocessing

        self.source = live_source
        self._stopping = False
        self._folder = TemporaryDirectory(prefix="sigmatau-live-")
        context = multiprocessing.get_context("spawn")
        self._states, remote = context.Pipe()
        self._process = context.Process(target=_record, args=(remote, live_source, self.first_lines), daemon=True)
        with uninterrupted():
            self._process.start()
        remote.close()
        self._state: tuple[str, dict[str, Any] | None, str] = ("waiting", None, "{}")
        first = self._first_state()
        if first[0] == "failed":
            self.close()
            raise DataError(str((first[1] or _ENDED)["message"]))
        self._state = first
        self._receiver = threading.Thread(target=self._receive, daemon=True)
        self._receiver.start()

    @property
    def first_lines(self) -> str:
        """The temporary file with the first lines, from which columns and units are chosen."""
        return str(Path(self._folder.name) / "first-lines.csv")

    def _first_state(self) -> tuple[str, dict[str, Any] | None, str]:
        try:
            if self._states.poll(_START):
                return self._states.recv()  # type: ignore[no-any-return]
        except (EOFError, OSError):
            pass
        return "failed", _ENDED, "{}"

    def _receive(self) -> None:
        while True:
            try:
                self._state = self._states.recv()
            except (EOFError, OSError):
                break
        state, _, content = self._state
        if state == "recording":
            self._state = ("stopped", None, content) if self._stopping else ("failed", _ENDED, content)

    def content(self) -> str:
        """The state as JSON."""
        state, error, content = self._state
        shown = {
            "state": state,
            "error": error,
            "path": self.source.log,
            "options": dict(self.source.table),
            "command": self.source.command,
        }
        separator = "" if content == "{}" else ", "
        return f"{json.dumps(shown, allow_nan=False, default=str)[:-1]}{separator}{content[1:]}"

    def stop(self) -> str | None:
        """End the record and return the path of its log; None if it was not saved."""
        self._end()
        self._receiver.join(_END)
        return self.source.log

    def change_options(self, table: Mapping[str, Any], command: str) -> None:
        """Analyse with other reading options; the saved log is read again."""
        self.source = replace(self.source, table=table, command=command)
        with contextlib.suppress(OSError):
            self._states.send(dict(table))

    @property
    def running(self) -> bool:
        """Whether the record has not ended."""
        return self._state[0] == "recording"

    def close(self) -> None:
        """End the record, and remove its temporary file."""
        self._end()
        self._folder.cleanup()

    def _end(self) -> None:
        """Ask the process to end, and kill it if it does not."""
        self._stopping = True
        with contextlib.suppress(OSError):
            self._states.send("stop")
        self._process.join(_END)
        self._process.kill()


def _record(states: Connection, live_source: LiveSource, first_lines: str) -> None:
    """Record in this process. The import is here because the server does not need the packages that analyse."""
    from sigmatau.app.watching import record

    record(states, live_source, first_lines)
