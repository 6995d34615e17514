"""``sigmatau analyze``: a log in; the coefficients, the figure and the JSON out."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from sigmatau.analysis import Analysis, analyze
from sigmatau.cli.options import (
    averaging_times,
    check_output,
    key_numbers,
    key_values,
    refuse_same,
    say,
    working,
)
from sigmatau.io import read
from sigmatau.io.write import atomic

__all__ = ["FIGURE_ENDINGS", "analyze_command", "write_figure", "write_json"]

FIGURE_ENDINGS = (".png", ".svg", ".pdf")


def analyze_command(
    log: Path,
    /,
    *,
    rate: float | None = None,
    unit: Annotated[list[str] | None, Parameter(negative=())] = None,
    topic: Annotated[list[str] | None, Parameter(negative=())] = None,
    layout: str | None = None,
    channels: Annotated[list[str] | None, Parameter(negative=())] = None,
    input: Literal["rate", "increments", "accumulated"] = "rate",  # noqa: A002  the option's name
    scale: Annotated[list[str] | None, Parameter(negative=())] = None,
    offset: Annotated[list[str] | None, Parameter(negative=())] = None,
    method: Literal["gls", "read-off"] = "gls",
    taus: str = "half",
    overlap: Literal["full", "none"] = "full",
    counting: Literal["standard", "paper"] = "standard",
    long: Literal["auto", "exact", "strided"] = "auto",
    plot: Path | None = None,
    json: Annotated[Path | None, Parameter(allow_leading_hyphen=True)] = None,
    threads: int | None = None,
    quiet: Annotated[bool, Parameter(name=["--quiet", "-q"], negative=())] = False,
) -> int:
    """Analyse a log of a sensor at rest: Allan deviation of every axis, and the noise coefficients that it shows.

    Parameters
    ----------
    log
        A table in text (any delimiter, header or none, gzip or not), .npy or .npz.
    rate
        Sampling rate in Hz; without it the log's time column gives it.
    unit
        Unit of a sensor, a channel or the time: gyro=deg/s, accel_x=g, time=ns. Asked for where the log does not say.
    topic
        Which topic, message or variable of a log that holds several: one, or one for each sensor.
    layout
        Fields of a row of a raw binary file, e.g. "<u4 time[us],3f4 gyro[rad/s],3f4 accel[m/s^2]"; 4x passes bytes over.
    channels
        Which column is what, by name or number from 1: gyro_x=wx, time=1, gyro=2:4. Any other name is a signal of its own.
    input
        What the columns hold: rates, increments per sample, or accumulated angle and velocity.
    scale
        Counts or volts to the unit, gyro=1/131: value = (reading - offset) × scale.
    offset
        Reading at zero, in counts or volts: gyro=2048.
    method
        Fit the coefficients, with intervals (gls), or only read them off as the paper does (read-off).
    taus
        Averaging times of the curve: octave, half, quarter or eighth octaves, all, or a list in seconds: 0.1,1,10.
    overlap
        Average all clusters (full), or only those that share no sample (none).
    counting
        N+1-2n terms (standard), or the N-2n of the paper's eq. (6) on N rates (paper).
    long
        Clusters of more than 4096 samples: every pair (exact), or in bounded memory those that begin at every 64th sample or
        less often (strided); auto does that, and says so, if the record does not fit in memory.
    plot
        Draw all axes: .png, .svg or .pdf.
    json
        Write the result; - for standard output, in place of the table.
    threads
        Default: all cores. The result does not depend on it.
    quiet
        Nothing on standard error but errors.
    """
    as_text = json is not None and str(json) == "-"
    check_output(plot, FIGURE_ENDINGS, "plot")
    check_output(None if as_text else json, (), "json")
    refuse_same(log, plot=plot, json=None if as_text else json)
    averaging = averaging_times(taus)
    with working(f"reading {log}", quiet=quiet):
        record = read(
            log,
            rate=rate,
            unit=key_values(unit or [], "unit", "gyro=deg/s"),
            topic=topic,
            layout=layout,
            channels=key_values(channels or [], "channels", "gyro_x=wx"),
            input=input,
            scale=key_numbers(scale or [], "scale", "gyro=0.01"),
            offset=key_numbers(offset or [], "offset", "gyro=2048"),
        )
    with working("computing Allan variances, fitting", quiet=quiet):
        analysis = analyze(
            record, taus=averaging, overlap=overlap, counting=counting, method=method, long=long, threads=threads
        )
    for finding in analysis.findings:
        say(str(finding), quiet=quiet)
    if plot is not None:
        with working(f"drawing {plot}", quiet=quiet):
            write_figure(analysis, plot)
    if as_text:
        sys.stdout.write(_json_text(analysis))
        return 0
    if json is not None:
        write_json(analysis, json)
    sys.stdout.write(f"{analysis.summary()}\n")
    return 0


def write_figure(analysis: Analysis, path: Path) -> None:
    """Draw and write, or leave no file."""
    from sigmatau.plot.curves import save

    figure = analysis.plot()
    with atomic(path) as temporary:
        save(figure, str(temporary))


def write_json(analysis: Analysis, path: Path) -> None:
    """Write the stable JSON form, or leave no file."""
    text = _json_text(analysis)
    with atomic(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def _json_text(analysis: Analysis) -> str:
    return json.dumps(analysis.to_dict(), indent=1, allow_nan=False, ensure_ascii=False) + "\n"
