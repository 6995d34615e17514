"""The process that records and analyses live samples: it reads, saves, and sends its state every second."""

from __future__ import annotations

import json
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import closing, suppress
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sigmatau.analysis.live import LiveAnalysis
from sigmatau.app.calls import error_content, number, reading_options
from sigmatau.app.log import LiveSource
from sigmatau.errors import DataError, OptionError, RecordTooShortError
from sigmatau.findings.rest import TooShortToTell
from sigmatau.hints import as_options, speaking
from sigmatau.io.follow import follow
from sigmatau.io.live import Live
from sigmatau.io.read.options import ReadOptions
from sigmatau.process import end_with_parent, keep_freed
from sigmatau.reporting.charts import collect_charts, collect_sensors, digits
from sigmatau.reporting.content import dominant_coefficients, finding_text, level_text
from sigmatau.results import plain_value, printable

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

    from sigmatau.analysis import Analysis

_EVERY = 1.0  # shortest time between two states [s]
_LARGEST_SHARE = 0.25  # of the time that is used for states; reading and saving come first [1]
_WAIT = 0.2  # the longest wait for data before a stop is noticed [s]
_REMAINDER = 0.3  # time after a stop in which what has already arrived is read [s]


def record(states: Connection, live_source: LiveSource) -> None:
    """Record until a stop is received, the input ends, or the parent process ends."""
    signal.signal(
        signal.SIGINT, signal.SIG_IGN
    )  # Ctrl-C reaches all processes of the terminal; the server ends this one
    end_with_parent()
    keep_freed()
    if live_source.source == "-":
        sys.stdin = open(0, closefd=False)  # noqa: SIM115  multiprocessing has put the null device in its place
    stop = threading.Event()
    threading.Thread(target=_wait_for_stop, args=(states, stop), daemon=True).start()
    with speaking(as_options):
        recorder = _Recorder(live_source, states.send)
        state, error = "stopped", None
        try:
            for piece in recorder.pieces(stop):
                recorder.take(piece)
            state = "stopped" if stop.is_set() else "ended"
        except (DataError, ImportError) as failure:
            state, error = "failed", failure
        recorder.finish(state, error)


def _wait_for_stop(states: Connection, stop: threading.Event) -> None:
    with suppress(EOFError, OSError):
        states.recv()
    stop.set()


class _Recorder:
    """Takes the pieces, and sends a state when it is time to."""

    def __init__(self, live_source: LiveSource, send: Callable[[tuple[str, Any, str]], None]) -> None:
        reading = ReadOptions(**reading_options(live_source.table))
        self._source, self._send = live_source, send
        self._live = LiveAnalysis(
            live_source.source, Live(reading.checked(), skip=reading.skip), at_rest=live_source.at_rest
        )
        self._error: dict[str, Any] | None = None
        self._due = 0.0

    def pieces(self, stop: threading.Event) -> Iterator[bytes]:
        """What arrives; after a stop what has already arrived."""
        place = self._source
        save = None if place.save is None else Path(place.save)
        stop_time: float | None = None
        with closing(follow(place.source, every=_WAIT, baud=place.baud, save=save)) as pieces:  # type: ignore[type-var]
            for piece in pieces:
                if stop.is_set():
                    stop_time = stop_time or time.monotonic()
                    if time.monotonic() - stop_time > _REMAINDER or not piece:
                        return
                    self._due = time.monotonic() + _EVERY
                yield piece

    def take(self, piece: bytes) -> None:
        """Take a piece. Lines that cannot be analysed are saved all the same."""
        if self._error is None:
            try:
                self._live.take(piece)
            except (DataError, OptionError) as error:
                if self._source.save is None:
                    self._error = error_content(error)
                    raise DataError(self._error["message"]) from None
                self._error = error_content(error)
        began = time.monotonic()
        if began >= self._due:
            self.send("recording")
            now = time.monotonic()
            self._due = now + max(_EVERY, (now - began) / _LARGEST_SHARE)

    def finish(self, state: str, error: DataError | ImportError | None) -> None:
        """Use all samples, and send the last state."""
        if isinstance(error, ImportError):
            self._error = {"message": str(error), "hint": None, "code": "data"}
        elif error is not None:
            self._error = self._error or error_content(error)
        if self._error is None:
            try:
                self._live.take(b"", last=True)
            except (DataError, OptionError) as short:
                self._error = error_content(short)
        self._live.finish()
        self.send(state)

    def send(self, state: str) -> None:
        """Send the state: its name, the error or None, and the content as JSON."""
        self._send((state, self._error, json.dumps(content(self._live), allow_nan=False)))


def content(live: LiveAnalysis) -> dict[str, Any]:
    """What the page shows of the samples so far."""
    analysis: Analysis | None
    try:
        analysis = live.analysis()
    except RecordTooShortError:
        analysis = None
    findings = [  # `wait` says when the record is long enough
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
