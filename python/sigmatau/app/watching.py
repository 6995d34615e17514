"""The process of a live record: it reads, saves and analyses the samples, and sends its state every second."""

from __future__ import annotations

import json
import re
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, suppress
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sigmatau.analysis.live import LiveAnalysis
from sigmatau.app.calls import Progress, error_content, number, reading_options
from sigmatau.app.log import LiveSource
from sigmatau.errors import DataError, OptionError, RecordTooShortError
from sigmatau.findings.rest import TooShortToTell
from sigmatau.hints import as_options, speaking
from sigmatau.io.follow import follow, serial_ports
from sigmatau.io.live import Live
from sigmatau.io.read.options import ReadOptions, check_live_options
from sigmatau.process import end_with_parent, keep_freed
from sigmatau.reporting.charts import collect_charts, collect_sensors, digits
from sigmatau.reporting.content import dominant_coefficients, finding_text, level_text
from sigmatau.results import plain_value, printable
from sigmatau.typed.config import check_names, live_command

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

    from sigmatau.analysis import Analysis

_PORT = re.compile(r"/dev/(?!.*\.\.)[\w./-]+|COM\d{1,3}")
_INTERVAL = 1.0  # shortest time between two states [s]
_LARGEST_SHARE = 0.25  # largest share of the time that states may take, because reading and saving come first [1]
_WAIT = 0.2  # longest wait for data, after which a stop is noticed [s]
_SILENT = 5.0  # time without a line after which a port is reported [s]
_PIECE = 1 << 20  # size of the pieces in which a log is read again [bytes]
_FIRST_LINES = 1 << 18  # largest size of the file with the first lines [bytes]
_LONGEST_LINE = 300  # largest length of the last line that is shown [characters]
_REMAINDER = 0.3  # time after a stop during which received data are still read [s]


def listed_ports(*, progress: Progress) -> str:
    """The serial ports of this computer, as JSON."""
    return json.dumps({"ports": [{"name": name, "text": printable(text)} for name, text in serial_ports()]})


def check_source(
    *, port: str | None, path: str | None, baud: int, save: str | None, table: Mapping[str, Any], progress: Progress
) -> LiveSource:
    """Check the source that a page names, a serial port or a file to which another program writes; raises `OptionError`."""
    check_names(table)
    check_live_options(ReadOptions(**reading_options(table)), command="the live view")
    if baud < 1:
        raise OptionError(f"{{option}} {baud}: must be a positive number of bits per second", option="baud")
    if path is not None:
        command = live_command(path, table, baud=None, save=None)
        return LiveSource(source=path, baud=None, save=None, table=table, at_rest=False, command=command)
    if port is None or not _PORT.fullmatch(port):
        raise OptionError(f"{port!r} is not a serial port; give its name, e.g. /dev/ttyUSB0 or COM3", option="serial")
    command = live_command(port, table, baud=baud, save=save)
    return LiveSource(source=port, baud=baud, save=save, table=table, at_rest=False, command=command)


def record(states: Connection, live_source: LiveSource, first_lines: str) -> None:
    """Record until a stop is received, the input ends, or the parent process ends. `first_lines`: path of a new file."""
    signal.signal(
        signal.SIGINT, signal.SIG_IGN
    )  # Ctrl-C reaches all processes of the terminal; the server ends this one
    keep_freed()  # before the first thread, so that all threads share one heap
    end_with_parent()
    if live_source.source == "-":
        sys.stdin = open(0, closefd=False)  # noqa: SIM115  multiprocessing replaced it by the null device
    stop = threading.Event()
    with speaking(as_options):
        recorder = _Recorder(live_source, states.send, _Lines(Path(first_lines)))
        threading.Thread(target=_wait_for_messages, args=(states, recorder, stop), daemon=True).start()
        state, error = "stopped", None
        try:
            for piece in recorder.pieces(stop):
                recorder.take(piece)
            state = "stopped" if stop.is_set() else "ended"
        except (DataError, ImportError) as failure:
            state, error = "failed", failure
        recorder.finish(state, error)


def _wait_for_messages(states: Connection, recorder: _Recorder, stop: threading.Event) -> None:
    """Receive new reading options, until a message of another kind ends the record."""
    with suppress(EOFError, OSError):
        while isinstance(message := states.recv(), Mapping):
            recorder.table = message
    stop.set()


class _UnsavedError(DataError):
    """An error of the analysis that ends a record which is not saved; the recorder has already stored its content."""


class _Lines:
    """Writes the first lines to a file, and remembers the last one.

    Attributes
    ----------
    size : int
        Size of the file. [bytes]
    last : str
        The last complete line, cut to a largest length.
    """

    def __init__(self, path: Path) -> None:
        path.touch()
        self.size, self.last = 0, ""
        self._path, self._rest = path, b""

    def take(self, piece: bytes) -> None:
        """Take a piece of the input. A line that is longer than the largest size of the file is cut."""
        whole, end, rest = piece.rpartition(b"\n")
        if not end:
            self._rest = (self._rest + piece)[-_FIRST_LINES:]
            return
        lines, self._rest = self._rest + whole + end, rest[-_FIRST_LINES:]
        self.last = printable(lines[:-1].rpartition(b"\n")[2][:_LONGEST_LINE].decode(errors="replace").strip())
        if self.size < _FIRST_LINES:
            with self._path.open("ab") as file:
                self.size += file.write(lines[: lines.rfind(b"\n", 0, _FIRST_LINES) + 1])


class _Recorder:
    """Analyses the pieces of the input, and sends a state at regular intervals."""

    def __init__(self, live_source: LiveSource, send: Callable[[tuple[str, Any, str]], None], lines: _Lines) -> None:
        self._source, self._send, self._lines = live_source, send, lines
        self.table: Mapping[str, Any] | None = None  # received reading options that are not used yet
        self._live = _live_analysis(live_source)
        self._error: dict[str, Any] | None = None
        self._taken = 0  # size of the pieces so far [bytes]
        self._began = time.monotonic()
        self._due = 0.0

    def pieces(self, stop: threading.Event) -> Iterator[bytes]:
        """Yield the pieces of the input; after a stop, those that have already arrived."""
        source = self._source
        save = None if source.save is None else Path(source.save)
        stop_time: float | None = None
        with closing(follow(source.source, every=_WAIT, baud=source.baud, save=save)) as pieces:  # type: ignore[type-var]
            for piece in pieces:
                if stop.is_set():
                    stop_time = stop_time or time.monotonic()
                    if time.monotonic() - stop_time > _REMAINDER or not piece:
                        return
                    self._due = time.monotonic() + _INTERVAL
                yield piece

    def take(self, piece: bytes) -> None:
        """Take a piece of the input. `follow` has saved it, whether or not it can be analysed."""
        self._taken += len(piece)
        self._lines.take(piece)
        if self.table is not None:
            self._begin_again(self.table)
        elif self._error is None:
            self._analyse(piece)
        began = time.monotonic()
        if began >= self._due:
            self.send("recording")
            now = time.monotonic()
            self._due = now + max(_INTERVAL, (now - began) / _LARGEST_SHARE)

    def _analyse(self, piece: bytes) -> None:
        """Analyse a piece. An error ends a record that is not saved."""
        try:
            self._live.take(piece)
        except (DataError, OptionError) as error:
            self._error = error_content(error)
            if self._source.baud is not None and isinstance(error, DataError) and not self._live.live.channels:
                self._error["message"] += ". Check the baud rate, and that the device prints lines of numbers"
            is_question = isinstance(error, OptionError)
            if self._source.save is None and not (is_question and self._source.log is not None):
                raise _UnsavedError(self._error["message"]) from None

    def _begin_again(self, table: Mapping[str, Any]) -> None:
        """Analyse the log so far with other options; without a log, only the samples that arrive from now on."""
        self.table, self._error = None, None
        self._source = replace(self._source, table=table)
        self._live, self._due = _live_analysis(self._source), 0.0
        if self._source.log is None:
            return
        remaining = self._taken
        try:
            with Path(self._source.log).open("rb") as log:
                while remaining and self._error is None and (piece := log.read(min(remaining, _PIECE))):
                    remaining -= len(piece)
                    self._analyse(piece)
        except OSError as error:
            self._error = error_content(DataError(f"{self._source.log}: cannot be read: {error.strerror or error}"))

    def finish(self, state: str, error: DataError | ImportError | None) -> None:
        """Analyse the remaining samples, and send the last state."""
        if isinstance(error, ImportError):
            self._error = {"message": str(error), "hint": None, "code": "data"}
        elif error is not None and not isinstance(error, _UnsavedError):
            self._error = error_content(error)
        if self.table is not None:
            self._begin_again(self.table)
        self._error = self._error or self._silence()
        if self._error is None:
            try:
                self._live.take(b"", last=True)
            except (DataError, OptionError) as short:
                self._error = error_content(short)
        self._live.finish()
        self.send(state)

    def send(self, state: str) -> None:
        """Send the state: its name, the error or None, and the content as JSON."""
        shown = {"first_bytes": self._lines.size, "last_line": self._lines.last, **content(self._live)}
        self._send((state, self._error or self._silence(), json.dumps(shown, allow_nan=False)))

    def _silence(self) -> dict[str, Any] | None:
        """The error of a port that has sent nothing yet; otherwise None."""
        if self._taken or self._source.baud is None or time.monotonic() - self._began < _SILENT:
            return None
        what = f"{self._source.source}: no line has arrived. Check the port, the baud rate and the cable"
        return error_content(DataError(what))


def _live_analysis(live_source: LiveSource) -> LiveAnalysis:
    """The analysis of a source from its beginning."""
    reading = ReadOptions(**reading_options(live_source.table))
    return LiveAnalysis(live_source.source, Live(reading.checked(), skip=reading.skip), at_rest=live_source.at_rest)


def content(live: LiveAnalysis) -> dict[str, Any]:
    """Coefficients, findings and charts of the samples so far, for the page."""
    analysis: Analysis | None
    try:
        analysis = live.analysis()
    except RecordTooShortError:
        analysis = None
    findings = [  # `wait` states when the record is long enough
        finding
        for finding in (live.findings() if analysis is None else analysis.findings)
        if not isinstance(finding.details, TooShortToTell)
    ]
    outlooks = [] if analysis is None else live.outlooks(analysis)
    return {
        "heading": printable(live.heading()),
        "wait": live.wait(),
        "outlooks": [{"sensor": printable(sensor), "text": text} for sensor, text in outlooks],
        "overview": None if analysis is None else plain_value(dominant_coefficients(analysis)),
        "level": "" if analysis is None else level_text(analysis),
        "findings": [asdict(finding_text(finding)) for finding in findings],
        "charts": _charts(live, analysis),
    }


def _charts(live: LiveAnalysis, analysis: Analysis | None) -> dict[str, Any]:
    """The last minutes of each channel, and the curves so far, as the charts of a report."""
    recent = live.recent()
    curves = {} if analysis is None else collect_charts(analysis, None, None)["channels"]
    channels = {
        name: {
            "series": {
                "start": number(picture.start, 9),
                "from": number(picture.start, 9),
                "duration": number(picture.duration, 9),
                "bins": len(picture.low),
                "low": digits(picture.low),
                "high": digits(picture.high),
                "outside": [],
            },
            **curves.get(name, {}),
        }
        for name, picture in recent.items()
    }
    return {"sensors": collect_sensors(recent), "channels": channels}
