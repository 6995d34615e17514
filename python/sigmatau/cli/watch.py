"""``sigmatau watch``: live samples in; curve and coefficients on the screen, again and again."""

from __future__ import annotations

import shutil
import signal
import sys
import threading
import time
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from sigmatau.analysis import Analysis, of_curves
from sigmatau.cli.analyze import FIGURE_ENDINGS, write_figure, write_json
from sigmatau.cli.options import check_output, key_numbers, key_values, say
from sigmatau.errors import DataError, OptionError, RecordTooShortError
from sigmatau.estimators.accumulator import Accumulator
from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.live import LinesLost
from sigmatau.io.live import Live, follow
from sigmatau.io.read.options import Options
from sigmatau.record.record import MIN_SAMPLES, Provenance

if TYPE_CHECKING:
    from rich.console import RenderableType

__all__ = ["watch_command"]

_AGREE = 1e-3  # relative difference of two rates that are the same
_FIRST = 1000  # samples before anything is fitted


def watch_command(
    source: Annotated[str, Parameter(allow_leading_hyphen=True)] = "-",
    /,
    *,
    rate: float | None = None,
    unit: Annotated[list[str] | None, Parameter(negative=())] = None,
    channels: Annotated[list[str] | None, Parameter(negative=())] = None,
    input: Literal["rate", "increments"] = "rate",  # noqa: A002  the option's name
    scale: Annotated[list[str] | None, Parameter(negative=())] = None,
    offset: Annotated[list[str] | None, Parameter(negative=())] = None,
    every: float = 2.0,
    idle: float | None = None,
    plot: Path | None = None,
    json: Path | None = None,
    quiet: Annotated[bool, Parameter(name=["--quiet", "-q"], negative=())] = False,
) -> int:
    """Follow a sensor at rest while it is logged: curve and coefficients of all samples so far, again and again.

    Memory stays at some megabytes a channel however long it runs. Clusters of up to 4096 samples are exact; longer ones
    begin at every 64th sample or less often. Ends with the input, or at Ctrl-C, and prints the table of coefficients.

    Parameters
    ----------
    source
        A text file that grows; - for standard input.
    rate
        Sampling rate in Hz; without it the time stamps of the first lines give it.
    unit
        Unit of a sensor, a channel or the time: gyro=deg/s, accel_x=g, time=ns. Asked for where the input does not say.
    channels
        Which column is what, by name or number from 1: gyro_x=wx, time=1, gyro=2:4.
    input
        What the columns hold: rates, or increments per sample.
    scale
        Counts or volts to the unit, gyro=1/131: value = (reading - offset) × scale.
    offset
        Reading at zero, in counts or volts: gyro=2048.
    every
        Seconds between two screens.
    idle
        End when nothing has come for so many seconds; without it, only at the end of the input or at Ctrl-C.
    plot
        Draw the last curves: .png, .svg or .pdf.
    json
        Write the last result.
    quiet
        No screen; only the table at the end.
    """
    for option, seconds in (("every", every), ("idle", idle)):
        if seconds is not None and not 0 < seconds < float("inf"):
            raise OptionError(f"--{option} {seconds}: want a positive number of seconds", option=option)
    check_output(plot, FIGURE_ENDINGS, "plot")
    check_output(json, (), "json")
    if source != "-" and not Path(source).is_file():
        what = "is no regular file" if Path(source).exists() else "there is no such file"
        raise DataError(f"{source}: {what}; - is standard input")
    if source == "-" and (sys.stdin is None or sys.stdin.closed):
        raise DataError("standard input is closed")
    if source == "-" and sys.stdin.isatty():
        raise OptionError("nothing is piped in: name a file, or say logger | sigmatau watch", option="source")
    options = Options.check(
        rate=rate,
        unit=key_values(unit or [], "unit", "gyro=deg/s"),
        channels=key_values(channels or [], "channels", "gyro_x=wx"),
        input=input,
        scale=key_numbers(scale or [], "scale", "gyro=0.01"),
        offset=key_numbers(offset or [], "offset", "gyro=2048"),
    )
    watched = _Watched(source, Live(options))
    broken: DataError | None = None
    try:
        if threading.current_thread() is threading.main_thread():
            signal.signal(signal.SIGTERM, _stop)
        with _screen(quiet=quiet) as screen:
            shown = time.monotonic()
            for piece in follow(source, every=every, idle=idle):
                watched.take(piece)
                if screen is not None and time.monotonic() - shown > every:
                    screen.update(watched.draw(), refresh=True)
                    shown = time.monotonic()
    except KeyboardInterrupt:
        pass  # which is how one stops watching
    except OptionError as error:
        raise OptionError(f"{watched.name}: {error}", option=error.option) from None
    except DataError as error:
        if watched.sums is None or watched.sums.n < MIN_SAMPLES:
            raise
        broken = error  # what has come until then is not lost
    if broken is None:
        watched.take(b"", last=True)
    analysis = watched.analysis()
    for finding in analysis.findings:
        say(str(finding), quiet=quiet)
    if plot is not None:
        write_figure(analysis, plot)
    if json is not None:
        write_json(analysis, json)
    sys.stdout.write(f"{analysis.summary()}\n")
    if broken is not None:
        raise broken
    return 0


def _stop(*_: object) -> None:
    raise KeyboardInterrupt


class _Watched:
    """What has come so far."""

    def __init__(self, source: str, live: Live) -> None:
        self.name = "standard input" if source == "-" else source
        self.live = live
        self.sums: Accumulator | None = None

    def take(self, piece: bytes, *, last: bool = False) -> None:
        try:
            samples = self.live.push(piece, last=last)
        except DataError as error:
            if str(error).startswith(self.name):
                raise
            place = "" if str(error).startswith(",") else ": "
            raise DataError(f"{self.name}{place}{error}") from None
        if self.live.channels and self.sums is None:
            stated = {c: u for c, u in self.live.unit.items() if c in self.live.channels}
            kind: Any = self.live.options.input
            self.sums = Accumulator(*self.live.channels, rate=self.live.rate, unit=stated, input=kind, long="strided")
        if self.sums is not None and len(samples):
            self.sums.push(samples)

    def _set_rate(self) -> None:
        """By all the stamps so far, which say it better than the first ones did. Increments were divided already."""
        measured = self.live.rate_by_stamps()
        if self.sums is not None and measured and self.live.options.rate is None and self.live.options.input == "rate":
            self.sums.tau0 = 1 / measured
            self.live.rate = measured

    def analysis(self) -> Analysis:
        if self.sums is None or self.sums.n < MIN_SAMPLES:
            n = 0 if self.sums is None else self.sums.n
            raise RecordTooShortError(
                f"{self.name}: {n} samples came; at least {MIN_SAMPLES} are needed", need=MIN_SAMPLES, got=n
            )
        self._set_rate()
        return of_curves(
            self.sums.snapshot(),
            source=Provenance(path=self.name, format="live", rows=self.sums.n),
            findings=self.findings(),
            grids={"": self.heading()},
        )

    def heading(self) -> str:
        if self.sums is None:
            return f"{self.name}: waiting for the first lines"
        seconds = self.sums.n * self.sums.tau0
        length = f"{seconds / 3600:.4g} h" if seconds >= 3600 else f"{seconds:.4g} s"
        return (
            f"{self.name}: {len(self.live.channels)} channels, {self.sums.n} samples at {self.live.rate:.6g} Hz"
            f" ({self.live.source_of_rate}), {length}"
        )

    def findings(self) -> list[Finding]:
        found = []
        if self.live.lost:
            lost = LinesLost(lines=self.live.lost, last=self.live.lost_example)
            found.append(Finding(details=lost, severity="warning"))
        if self.live.leaps:
            found.append(
                Finding(
                    code="irregular_stamps",
                    severity="warning",
                    message=f"{self.live.leaps} of the intervals between stamps are negative or longer than 20 samples",
                    effect="samples behind are taken to follow at once; if samples were lost, they bend the curve",
                )
            )
        measured = self.live.rate_by_stamps()
        if measured is not None and abs(measured / self.live.rate - 1) > _AGREE:
            found.append(
                Finding(
                    code="rate_mismatch",
                    severity="warning",
                    message=f"{measured:.6g} Hz by the stamps so far, {self.live.rate:.6g} Hz is used",
                    effect="every averaging time is off by the same factor, and every coefficient with it",
                )
            )
        return found

    def draw(self) -> RenderableType:
        """The screen: heading, curves, coefficients, as far as there are any."""
        from rich.text import Text

        if self.sums is None or self.sums.n < _FIRST:
            return Text(self.heading())
        try:
            analysis = self.analysis()
        except DataError as error:
            return Text(f"{self.heading()}\n{error}")
        size = shutil.get_terminal_size()
        panels = _panels(analysis)
        table = analysis.coefficients().split("\n\n")[0]  # without the legend, which never changes
        height = max((size.lines - table.count("\n") - 6) // max(len(panels), 1), 10)
        from sigmatau.plot.terminal import text_plot

        plots = [line for panel in panels for line in text_plot(panel, width=size.columns, height=min(height, 20))]
        remarks = [str(finding) for finding in analysis.findings]
        lines = [self.heading(), *plots, *table.split("\n"), *remarks]
        room = max(size.lines - 1, 2)
        if len(lines) > room:
            more = len(lines) - room + 1
            lines = [
                *lines[: room - 1],
                f"… {more} lines more than this window holds; Ctrl-C ends, and prints the whole table",
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
