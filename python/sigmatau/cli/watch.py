"""``sigmatau watch``: curve and coefficients of a log while it is written."""

from __future__ import annotations

import signal
import sys
import threading
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from sigmatau.analysis.live import LiveAnalysis
from sigmatau.analysis.options import AnalysisOptions
from sigmatau.cli.declared import DeclaredOptions, InMain, InOutput, MayBeMinus, Quiet, Show, typed_options
from sigmatau.cli.live_source import check_standard_input, live_source
from sigmatau.cli.options import check_outputs, say, write_figure, write_json
from sigmatau.cli.watch_screen import progress
from sigmatau.cli.words import check_place
from sigmatau.errors import DataError, OptionError
from sigmatau.findings.finding import exit_code
from sigmatau.io.follow import BAUD, follow
from sigmatau.io.live import Live
from sigmatau.io.read.options import ReadOptions, check_live_options
from sigmatau.noise.shown import set_shown
from sigmatau.quality.selection.time_text import parse_seconds
from sigmatau.record.record import MIN_SAMPLES


@typed_options(AnalysisOptions, only=("at_rest",))
class WatchSettings(DeclaredOptions):
    """Options of an analysis that apply to live samples."""


@typed_options(ReadOptions, only=("rate", "unit", "channels", "input", "scale", "offset", "skip", "interleaved"))
class WatchReading(DeclaredOptions):
    """Options of reading live lines of text."""


def watch_command(
    source: Annotated[str, Parameter(allow_leading_hyphen=True)] = "-",
    /,
    *,
    serial: Annotated[str | None, InMain] = None,
    baud: Annotated[int | None, InMain] = None,
    reading: WatchReading | None = None,
    every: Annotated[str | None, MayBeMinus, InOutput] = None,
    idle: Annotated[str | None, MayBeMinus, InOutput] = None,
    settings: WatchSettings | None = None,
    save: Annotated[Path | None, InMain] = None,
    plot: Annotated[Path | None, InMain] = None,
    json: Annotated[Path | None, InMain] = None,
    show: Show = None,
    quiet: Quiet = False,
) -> int:
    """Follow a log while it is written: print curve and coefficients of all samples so far.

    A channel needs a few megabytes of memory for any length. Clusters of up to 4096 samples are exact; longer clusters
    use every 64th pair or fewer. At the end of the input, or at Ctrl-C, the table of coefficients is printed.

    Parameters
    ----------
    source
        A growing text file; - for standard input.
    serial
        Read a serial port in place of a file: /dev/ttyUSB0, COM3. Needs pyserial.
    baud
        Speed of the serial port, number of bits per second. Default: 115200.
    every
        Time between updates, in seconds or with its unit. Default: 2s on a terminal, 1min in a pipe or a file.
    idle
        End after this time without input, in seconds or with its unit, 10min. Default: at the end of the input or at Ctrl-C.
    save
        Write the received bytes to this new file, a log for sigmatau analyze.
    plot
        Draw the final curves: .png, .svg or .pdf.
    json
        Write the final result as JSON.
    quiet
        Print only the table at the end.
    """
    set_shown(show)
    between = None if every is None else _positive(every, "every")
    longest = None if idle is None else _positive(idle, "idle")
    check_outputs([], plot=plot, json=json)
    check_place(source, command="watch")
    source = live_source(source, serial=serial, baud=baud, save=save)
    if serial is None and source != "-" and not Path(source).is_file():
        what = "is not a regular file" if Path(source).exists() else "there is no such file"
        raise DataError(f"{source}: {what}; - is standard input")
    if source == "-":
        check_standard_input("name a file, or run logger | sigmatau watch")
    options = ReadOptions(**(reading or WatchReading()).arguments())
    checked = check_live_options(options, command="watch")
    watched = LiveAnalysis(source, Live(checked, skip=options.skip), **(settings or WatchSettings()).arguments())
    broken: DataError | None = None
    try:
        if threading.current_thread() is threading.main_thread():
            signal.signal(signal.SIGTERM, _stop)
        with progress(watched, every=between, quiet=quiet) as shown:
            speed = None if serial is None else BAUD if baud is None else baud
            for piece in follow(source, every=shown.every, idle=longest, baud=speed, save=save):
                watched.take(piece)
                shown.update()
    except KeyboardInterrupt:
        pass  # normal end
    except DataError as error:
        if watched.stretches is None or watched.stretches.n < MIN_SAMPLES:
            raise
        broken = error  # the samples received so far are analysed
    if broken is None:
        watched.take(b"", last=True)
    watched.finish()
    analysis = watched.analysis()
    for finding in analysis.findings:
        say(str(finding), quiet=quiet)
    if plot is not None:
        write_figure(analysis.plot(), plot)
    if json is not None:
        write_json(analysis.to_dict(), json)
    sys.stdout.write(f"{analysis.summary()}\n")
    sys.stdout.flush()
    whole = save or ("FILE" if source == "-" or serial is not None else source)
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
