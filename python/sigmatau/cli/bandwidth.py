"""``sigmatau bandwidth``: filter, noise without aliasing and best rate of a sensor, from logs at several sampling rates."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from sigmatau._version import __version__
from sigmatau.cli.declared import InMain, InMethod, InOutput, MayBeMinus, Quiet, Show, Texts
from sigmatau.cli.options import check_outputs, check_style, drawing, matched, say, working, write_figure, write_result
from sigmatau.cli.reading import ReadingOptions, assign_readings, read_log
from sigmatau.errors import OptionError
from sigmatau.findings.finding import damaged
from sigmatau.fitting.bandwidth import bandwidth
from sigmatau.fitting.sensor_bandwidth import Bandwidths
from sigmatau.io.folders import gather, is_log, skipped_lines
from sigmatau.noise.shown import set_shown
from sigmatau.noise.terms import check_shown
from sigmatau.record.record import Record, channel_quantities, stream_name

_RATE_IN_NAME = re.compile(r"(?<![0-9.])([0-9]+(?:\.[0-9]+)?) ?(k?)hz(?![a-z])", re.IGNORECASE)
_UNKNOWN = 1  # exit code if no log shows the bandwidth of any channel


def bandwidth_command(
    *logs: Annotated[Path, Parameter(required=True, negative=())],
    reading: ReadingOptions | None = None,
    axes: Annotated[list[str] | None, Texts, InMethod] = None,
    tolerance: Annotated[float, InMethod] = 0.02,
    plot: Annotated[Path | None, InMain] = None,
    style: Annotated[Literal["screen", "paper"], InOutput] = "screen",
    json: Annotated[Path | None, MayBeMinus, InMain] = None,
    show: Show = None,
    quiet: Quiet = False,
) -> int:
    """Find the bandwidth and filter of a sensor, its noise without aliasing, and the rate to sample at.

    Parameters
    ----------
    logs
        Logs of one sensor at rest, at one or several sampling rates, recorded without an anti-alias filter. The rate of a
        log without time stamps or --rate is read from its name: 10Hz.csv, run_2kHz.txt.
    axes
        Channels to use: gyro_x,accel_z, or gyro for all its axes. Default: all but temperatures.
    tolerance
        Excess of the random walk by aliasing that is allowed at the recommended rate, as a ratio: 0.02 is 2 %.
    plot
        Draw Allan deviations and random walks at all rates, for the first channel: .png, .svg or .pdf.
    style
        Style of figures: screen, or paper, for the width of a column or a page of a paper.
    json
        Write the result as JSON, in SI; - writes it to standard output instead of the table.
    quiet
        Print only errors on standard error.
    """
    set_shown(show)
    check_style(style, plot)
    places, skipped = gather(matched(logs, keep=is_log, quiet=quiet))
    check_outputs(places, plot=plot, json=json)
    for line in skipped_lines(skipped):
        say(line, quiet=quiet)
    readings = assign_readings(reading, places, logs)
    records = {_name(log, places): _read(log, readings[log], quiet=quiet) for log in places}
    for name, record in records.items():
        check_shown(channel_quantities(record), ["random_walk", *(["bias_instability"] if plot is not None else [])])
        for finding in record.findings:
            say(f"{name}: {finding}", quiet=quiet)
    with working("comparing filters", quiet=quiet):
        result = bandwidth(records, channels=_channels(records, axes), tolerance=tolerance)
    if plot is not None:
        with drawing(plot, style, quiet=quiet):
            write_figure(result.plot(), plot)
    write_result(repr(result), {"sigmatau": __version__, "channels": result.to_dict()}, json)
    return _exit_code(result) or max(damaged(record.findings) for record in records.values())


def _name(log: Path, logs: list[Path]) -> str:
    """The name of a log without its folder, unless another log has the same name."""
    return log.name if sum(each.name == log.name for each in logs) == 1 else str(log)


def _read(log: Path, reading: ReadingOptions, *, quiet: bool) -> Record:
    """Read a record. If the log has no sampling rate, the rate in its name is used."""
    try:
        return read_log(log, reading, quiet=quiet)
    except OptionError as error:
        stated = _RATE_IN_NAME.findall(log.name)
        if error.option != "rate" or reading.rate or len(stated) != 1:
            raise
    ((number, kilo),) = stated
    rate = float(number) * (1000 if kilo else 1)
    record = read_log(log, reading.at_rate([f"{rate:.12g}"]), quiet=quiet)
    say(f"{log}: no time stamps; sampling rate {rate:g} Hz by its name", quiet=quiet)
    return record


def _channels(records: dict[str, Record], axes: list[str] | None) -> list[str] | None:
    """Select the channels of ``--axes``."""
    if axes is None:
        return None
    available = dict.fromkeys(channel for record in records.values() for channel in record.channels)
    chosen: list[str] = []
    for name in (name.strip() for text in axes for name in text.split(",")):
        matching = [channel for channel in available if name in (channel, stream_name(channel))]
        if not matching:
            raise OptionError(f"--axes {name}: the logs have {', '.join(available)}", option="axes")
        chosen += (channel for channel in matching if channel not in chosen)
    return chosen


def _exit_code(bandwidths: Bandwidths) -> int:
    return _UNKNOWN if all(each.verdict == "rate too low" for each in bandwidths.values()) else 0
