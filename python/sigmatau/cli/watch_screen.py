"""Display of ``sigmatau watch`` while samples arrive: a screen of the terminal, or one line per minute in a pipe."""

from __future__ import annotations

import shutil
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from textwrap import wrap
from typing import Any

from sigmatau.analysis import Analysis
from sigmatau.analysis.live import LiveAnalysis
from sigmatau.errors import DataError
from sigmatau.fitting.overview import overview

_EVERY = {True: 2.0, False: 60.0}  # time between updates of a screen, and between lines [s]
_MIN_LINES = 10  # smallest number of lines of a curve


class Progress:
    """Updates at intervals; none if `quiet` and without a screen."""

    def __init__(self, live: LiveAnalysis, screen: Any, *, every: float, quiet: bool) -> None:  # noqa: ANN401  of rich
        self.live = live
        self.every = every
        self._screen = screen
        self._quiet = quiet
        self._last = time.monotonic()

    def update(self) -> None:
        """Show the samples so far, if an update is due."""
        if self._quiet or time.monotonic() - self._last < self.every:
            return
        if self._screen is None:
            sys.stderr.write(f"{progress_line(self.live)}\n")
            sys.stderr.flush()
        else:
            from rich.text import Text

            size = shutil.get_terminal_size()
            lines = screen_lines(self.live, width=size.columns, height=size.lines)
            self._screen.update(Text("\n".join(lines), no_wrap=True, overflow="ellipsis"), refresh=True)
        self._last = time.monotonic()


@contextmanager
def progress(live: LiveAnalysis, *, every: float | None, quiet: bool) -> Iterator[Progress]:
    """Show a screen if standard output is a terminal, otherwise lines on standard error."""
    on_screen = not quiet and sys.stdout is not None and sys.stdout.isatty()
    every = _EVERY[on_screen] if every is None else every
    if not on_screen:
        yield Progress(live, None, every=every, quiet=quiet or sys.stderr is None)
        return
    from rich.console import Console
    from rich.live import Live as Screen

    with Screen(console=Console(), auto_refresh=False, screen=True) as screen:
        yield Progress(live, screen, every=every, quiet=False)


def progress_line(live: LiveAnalysis) -> str:
    """Describe the samples so far in one line."""
    try:
        analysis = live.analysis()
    except DataError:
        return "; ".join(filter(None, [live.heading(), live.wait()]))
    outlooks = [f"{sensor}: {text}" for sensor, text in live.outlooks(analysis)] or [live.wait()]
    return "; ".join(filter(None, [live.heading(), *outlooks]))


def screen_lines(live: LiveAnalysis, *, width: int, height: int) -> list[str]:
    """Heading, coefficients of all axes, gain of more samples, findings, and curves if there is room."""
    lines = [live.heading()]
    try:
        analysis = live.analysis()
    except DataError:
        return [*lines, live.wait()]
    if analysis.fits:
        lines += ["", *overview(analysis.fits, analysis.findings, width=width).split("\n"), ""]
    outlooks = [f"{sensor}: {text}" for sensor, text in live.outlooks(analysis)] or [live.wait()]
    lines += [part for text in outlooks for part in wrap(text, width, subsequent_indent="  ")]
    lines += [str(finding) for finding in analysis.findings]
    room = max(height - 2, 2)
    panels = _panels(analysis)
    each = (room - len(lines)) // max(len(panels), 1)
    if each >= _MIN_LINES:
        from sigmatau.plot.terminal import text_plot

        lines += [line for panel in panels for line in text_plot(panel, width=width, height=min(each - 2, 20))]
    if len(lines) > room:
        lines = [*lines[: room - 1], f"… {len(lines) - room + 1} more lines; Ctrl-C ends and prints the whole table"]
    return lines


def _panels(analysis: Analysis) -> list[dict[str, Any]]:
    panels: dict[tuple[str, str], dict[str, Any]] = {}
    for channel, curve in analysis.curves.items():
        panels.setdefault((curve.quantity, curve.unit), {})[channel] = curve
    return list(panels.values())
