"""``sigmatau watch``: curve and coefficients of a log while it is written."""

from __future__ import annotations

import shutil
import signal
import sys
import threading
import time
from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from sigmatau.analysis import Analysis, of_curves
from sigmatau.cli.declared import InMain, InOutput, MayBeMinus, Quiet, Show
from sigmatau.cli.options import check_outputs, say, write_figure, write_json
from sigmatau.cli.settings import WatchReading, WatchSettings
from sigmatau.errors import DataError, OptionError, RecordTooShortError
from sigmatau.estimators.accumulator import Accumulator
from sigmatau.findings.finding import Finding, exit_code
from sigmatau.findings.rates import RateMismatch
from sigmatau.findings.reading import SkippedMessages
from sigmatau.findings.stamps import BadStamps, IrregularStamps
from sigmatau.io.live import Live, follow
from sigmatau.io.read.options import ReadOptions
from sigmatau.noise.shown import set_shown
from sigmatau.noise.terms import check_shown
from sigmatau.quality.selection.live import LiveStretches
from sigmatau.quality.selection.time_text import parse_seconds
from sigmatau.record.record import MIN_SAMPLES, Provenance, conversion, stream_name
from sigmatau.record.sampling import Sampling, sampling_text

if TYPE_CHECKING:
    from rich.console import RenderableType

_EQUAL_RATES = 1e-3  # relative difference up to which two rates are taken as equal
_FIRST_FIT = 1000  # number of samples from which on the screen shows a fit


def watch_command(
    source: Annotated[str, Parameter(allow_leading_hyphen=True)] = "-",
    /,
    *,
    reading: WatchReading | None = None,
    every: Annotated[str, MayBeMinus, InOutput] = "2s",
    idle: Annotated[str | None, MayBeMinus, InOutput] = None,
    settings: WatchSettings | None = None,
    plot: Annotated[Path | None, InMain] = None,
    json: Annotated[Path | None, InMain] = None,
    show: Show = None,
    quiet: Quiet = False,
) -> int:
    """Follow a log while it is written: print curve and coefficients of all samples so far.

    A channel needs some megabytes of memory for any length. Clusters of up to 4096 samples are exact; longer clusters use
    every 64th pair or fewer. At the end of the input, or at Ctrl-C, the table of coefficients is printed.

    Parameters
    ----------
    source
        A growing text file; - for standard input.
    every
        Time between updates of the screen, in seconds or with its unit.
    idle
        End after this time without input, in seconds or with its unit, 10min. Default: at the end of the input or at Ctrl-C.
    plot
        Draw the final curves: .png, .svg or .pdf.
    json
        Write the final result as JSON.
    quiet
        Print only the table at the end.
    """
    set_shown(show)
    between, longest = _positive(every, "every"), None if idle is None else _positive(idle, "idle")
    check_outputs([], plot=plot, json=json)
    if source != "-" and not Path(source).is_file():
        what = "is not a regular file" if Path(source).exists() else "there is no such file"
        raise DataError(f"{source}: {what}; - is standard input")
    if source == "-" and (sys.stdin is None or sys.stdin.closed):
        raise DataError("standard input is closed")
    if source == "-" and sys.stdin.isatty():
        raise OptionError("no input is piped in: name a file, or run logger | sigmatau watch", option="source")
    options = ReadOptions(**(reading or WatchReading()).arguments())
    checked = options.checked()
    if options.input == "accumulated":
        raise OptionError("watch reads rates or increments; accumulated values are for a saved log", option="input")
    if options.interleaved not in (None, 1):
        raise OptionError(
            f"watch follows one sensor: {{option}} {options.interleaved} is for a saved log, sigmatau analyze FILE",
            option="interleaved",
        )
    watched = _Watched(source, Live(checked, skip=options.skip), **(settings or WatchSettings()).arguments())
    broken: DataError | None = None
    try:
        if threading.current_thread() is threading.main_thread():
            signal.signal(signal.SIGTERM, _stop)
        with _screen(quiet=quiet) as screen:
            shown = time.monotonic()
            for piece in follow(source, every=between, idle=longest):
                watched.take(piece)
                if screen is not None and time.monotonic() - shown > between:
                    screen.update(watched.draw(), refresh=True)
                    shown = time.monotonic()
    except KeyboardInterrupt:
        pass  # normal end
    except DataError as error:
        if watched.stretches is None or watched.stretches.n < MIN_SAMPLES:
            raise
        broken = error  # the samples received so far are analysed
    if broken is None:
        watched.take(b"", last=True)
    if watched.stretches is not None:
        watched.stretches.finish()
    analysis = watched.analysis()
    for finding in analysis.findings:
        say(str(finding), quiet=quiet)
    if plot is not None:
        write_figure(analysis.plot(), plot)
    if json is not None:
        write_json(analysis.to_dict(), json)
    sys.stdout.write(f"{analysis.summary()}\n")
    sys.stdout.flush()
    whole = "FILE" if source == "-" else source
    say(f"this is a quick look: sigmatau analyze {whole} gives the numbers to use", quiet=quiet)
    if broken is not None:
        raise broken
    return exit_code(analysis.findings)


def _positive(text: str, option: str) -> float:
    time = parse_seconds(text, option=option)
    if not 0 < time < float("inf"):
        raise OptionError(f"--{option} {text}: must be a positive time", option=option)
    return time


def _stop(*_: object) -> None:
    raise KeyboardInterrupt


class _Watched:
    """The samples received so far."""

    def __init__(self, source: str, live: Live, *, at_rest: bool = False) -> None:
        self.name = "standard input" if source == "-" else source
        self.live = live
        self.at_rest = at_rest
        self.stretches: LiveStretches | None = None

    def take(self, piece: bytes, *, last: bool = False) -> None:
        try:
            samples = self.live.push(piece, last=last)
        except (DataError, OptionError) as error:
            raise error.about(self.name) from None
        if self.live.channels and self.stretches is None:
            stated = {c: u for c, u in self.live.unit.items() if c in self.live.channels}
            kind: Any = self.live.options.input
            check_shown({c: conversion(c, stated, kind)[:2] for c in self.live.channels})
            self.stretches = LiveStretches(
                self.live.channels, rate=self.live.rate, unit=stated, input=kind, assumed=self.at_rest
            )
        if self.stretches is not None and len(samples):
            self.stretches.push(samples)

    def _with_rate(self, sums: Accumulator) -> Accumulator:
        """Replace the rate of the first stamps by that of all stamps so far. Increments have already been divided by the
        first rate.
        """
        measured = self.live.rate_by_stamps()
        if measured and self.live.options.rate is None and self.live.options.input == "rate":
            sums.tau0 = 1 / measured
            self.live.rate = measured
        return sums

    def analysis(self) -> Analysis:
        n = 0 if self.stretches is None else self.stretches.n
        if self.stretches is None or self.stretches.sums.n < MIN_SAMPLES:
            raise RecordTooShortError(
                f"{self.name}: has {n} samples; at least {MIN_SAMPLES} are needed", need=MIN_SAMPLES, got=n
            )
        resting = self.stretches.rest()
        moving = not resting.is_usable and not self.at_rest
        channels = list(self.live.channels)
        streams = dict.fromkeys(map(stream_name, channels))
        analysed = of_curves(
            self._with_rate(self.stretches.sums).snapshot(),
            source=Provenance(path=self.name, format="live", rows=n),
            findings=self.findings(),
            grids={name: self._sampling([c for c in channels if stream_name(c) == name]) for name in streams},
            method="read-off" if moving else "gls",
        )
        return replace(analysed, read_off={} if moving else analysed.read_off, rest=resting)

    def heading(self) -> str:
        if self.stretches is None:
            return f"{self.name}: waiting for the first lines"
        moving = ", moving now" if self.stretches.moving else ""
        return f"{self.name}: {sampling_text(self._sampling(self.live.channels))}{moving}"

    def _sampling(self, channels: Sequence[str]) -> Sampling:
        n = 0 if self.stretches is None else self.stretches.n
        return Sampling(channels=tuple(channels), n=n, rate=self.live.rate, source=self.live.source_of_rate)

    def findings(self) -> list[Finding]:
        findings = [] if self.stretches is None else self.stretches.findings()
        if self.live.lost:
            lost = SkippedMessages(count=self.live.lost, unit="lines", example=self.live.lost_example)
            findings.append(Finding(details=lost, severity="warning"))
        if self.live.repeated:
            total = self.live.lines + self.live.repeated
            repeated = BadStamps(what="repeated", rows=total, place="the beginning of the input")
            findings.append(Finding(details=repeated, severity="warning", size=self.live.repeated))
        if self.live.leaps:
            findings.append(
                Finding(details=IrregularStamps(interval=1 / self.live.rate, leaps=self.live.leaps), severity="warning")
            )
        if (change := self.live.rate_change()) is not None:
            findings.append(change)
        measured = self.live.rate_by_stamps()
        if measured is not None and abs(measured / self.live.rate - 1) > _EQUAL_RATES:
            findings.append(Finding(details=RateMismatch(used=self.live.rate, other=measured), severity="warning"))
        return findings

    def draw(self) -> RenderableType:
        """The screen: heading, curves and coefficients, as far as they exist."""
        from rich.text import Text

        if self.stretches is None or self.stretches.sums.n < _FIRST_FIT:
            return Text(self.heading())
        try:
            analysis = self.analysis()
        except DataError as error:
            return Text(f"{self.heading()}\n{error}")
        size = shutil.get_terminal_size()
        panels = _panels(analysis)
        table = analysis.coefficients()
        height = max((size.lines - table.count("\n") - 6) // max(len(panels), 1), 10)
        from sigmatau.plot.terminal import text_plot

        plots = [line for panel in panels for line in text_plot(panel, width=size.columns, height=min(height, 20))]
        remarks = [str(finding) for finding in analysis.findings]
        lines = [self.heading(), *plots, *table.split("\n"), *remarks]
        room = max(size.lines - 1, 2)
        if len(lines) > room:
            hidden = len(lines) - room + 1
            lines = [
                *lines[: room - 1],
                f"… {hidden} more lines than the window; Ctrl-C ends and prints the whole table",
            ]
        return Text("\n".join(lines), no_wrap=True, overflow="ellipsis")


def _panels(analysis: Analysis) -> list[dict[str, Any]]:
    panels: dict[tuple[str, str], dict[str, Any]] = {}
    for channel, curve in analysis.curves.items():
        panels.setdefault((curve.quantity, curve.unit), {})[channel] = curve
    return list(panels.values())


def _screen(*, quiet: bool) -> Any:  # noqa: ANN401  a Live, or a context without one
    if quiet or sys.stdout is None or not sys.stdout.isatty():
        return nullcontext()
    from rich.console import Console
    from rich.live import Live as Screen

    return Screen(console=Console(), auto_refresh=False, screen=True)
