"""``sigmatau temperature``: noise and bias over temperature, from a ramp, a soak, or runs of units in files or a store."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
from cyclopts import Parameter

from sigmatau.analysis import Analysis, analyze, read_result
from sigmatau.cli import batch
from sigmatau.cli.declared import InMain, InMethod, InOutput, MayBeMinus, Quiet, Show, Texts
from sigmatau.cli.options import (
    check_outputs,
    check_style,
    command_line,
    drawing,
    matched,
    say,
    working,
    write_figure,
    write_result,
)
from sigmatau.cli.reading import ReadingOptions, assign_readings, read_log
from sigmatau.errors import DataError, NotAtRestError, OptionError
from sigmatau.findings.finding import damaged
from sigmatau.io.atomic import atomic
from sigmatau.io.folders import gather, skipped_lines
from sigmatau.lab.lots.reading import gather as gather_results
from sigmatau.lab.lots.reading import natural_order
from sigmatau.lab.pages.temperature_report import temperature_report
from sigmatau.lab.store.naming import Naming, stated_temperature
from sigmatau.lab.temperature.branches import LEAST_RANGE
from sigmatau.lab.temperature.calibrate import calibrate_temperature
from sigmatau.lab.temperature.firmware import AUTOPILOTS
from sigmatau.lab.temperature.matrix import TemperatureMatrix, temperature_matrix
from sigmatau.lab.temperature.over_runs import TemperatureRun, calibrate_over_runs
from sigmatau.lab.temperature.result import TemperatureCalibration
from sigmatau.lab.temperature.text import mean_text
from sigmatau.noise.shown import set_shown
from sigmatau.noise.terms import check_shown
from sigmatau.results import csv_text, noted_unit

if TYPE_CHECKING:
    from sigmatau.record.record import Record

_NOT_AT_REST = 5  # exit code
_UNUSABLE = 1  # exit code if a file was not used

Run = tuple[str, str, float, Analysis]
"""Unit, name, temperature in °C, and result of a run."""


def temperature_command(
    *logs: Annotated[Path, Parameter(negative=())],
    reading: ReadingOptions | None = None,
    axes: Annotated[list[str] | None, Texts, InMethod] = None,
    degree: Annotated[int | None, InMethod] = None,
    reference: Annotated[str | None, MayBeMinus, InMethod] = None,
    level: Annotated[float, InMethod] = 0.95,
    mean: Annotated[str | None, MayBeMinus, InMain] = None,
    temperature_from: Annotated[str | None, InMethod] = None,
    unit_from: Annotated[str | None, InMethod] = None,
    store: Annotated[str | None, InMain] = None,
    serial: Annotated[list[str] | None, Texts, InMain] = None,
    report: Annotated[Path | None, InMain] = None,
    plot: Annotated[Path | None, InMain] = None,
    style: Annotated[Literal["screen", "paper"], InOutput] = "screen",
    json: Annotated[Path | None, MayBeMinus, InMain] = None,
    csv: Annotated[Path | None, InOutput] = None,
    export: Annotated[list[str] | None, Texts, InMain] = None,
    instance: Annotated[int | None, InOutput] = None,
    device_id: Annotated[int | None, InOutput] = None,
    show: Show = None,
    quiet: Quiet = False,
) -> int:
    """Measure noise and bias over temperature: at each temperature, as a polynomial, with hysteresis.

    One log has a thermometer and a ramp or a soak in steps. Several logs or results are runs at one temperature each: of
    one unit they give its polynomial, of several units a matrix unit × temperature. A file that cannot be used is named on
    standard error, the others are used, and the exit code is 1.

    Parameters
    ----------
    logs
        One log of a ramp or a soak; or several logs, or JSON results of analyze, each at one temperature.
    axes
        Channels of a ramp or a soak to use: gyro_x,accel_z, or gyro for all its axes. Default: all.
    degree
        Degree of the polynomial, a number of powers from 1 to 5. Default: at most 3, without the highest coefficients that
        are smaller than their standard errors.
    reference
        Temperature about which the polynomial is written, 25degC. Default: 25 °C if observed, or the middle of the range.
    level
        Confidence level of intervals, 0.5 to 0.999.
    mean
        Print the mean at these temperatures with its interval, in °C with commas between them: -20,25,60. They must be
        inside the observed range. Default: none.
    temperature_from
        Regular expression for the path of a file with its temperature in °C in parentheses, 'T(-?[0-9]+)'. Default: the
        thermometer of a log, or the note "temperature" of a result.
    unit_from
        Regular expression for the path of a file with its serial number in parentheses, '(SN[0-9]+)'. Default: the note
        "serial number"; files without one are of one unit.
    store
        Use the runs of this store that have a temperature: a SQLite file or postgresql://USER@HOST/NAME, see sigmatau
        store.
    serial
        With --store, serial number; A* selects all serial numbers that begin with A. May be repeated.
    report
        Write a report: .html opens offline, .pdf is for printing.
    plot
        Draw means with polynomials and Allan deviations before and after compensation, or the matrix: .png, .svg or .pdf.
    style
        Style of the figure: screen, or paper, for the width of a column or a page of a paper.
    json
        Write the result as JSON, in SI; - writes it to standard output instead of the table.
    csv
        Write one row for each channel, temperature and coefficient as CSV in SI units.
    export
        Write the parameters of an autopilot: px4=FILE (TC_*) or ardupilot=FILE (INS_TCAL*). May be repeated.
    instance
        Number of the sensor in the autopilot (default: 0 of px4, 1 of ardupilot).
    device_id
        Number of the device in px4, which TC_G0_ID and TC_A0_ID name (default 0, to be set in the ground station).
    quiet
        Print only errors on standard error.
    """
    set_shown(show)
    check_style(style, plot)
    if store is not None and logs:
        raise OptionError("give logs or results, or --store, not both", option="store")
    if serial and store is None:
        raise OptionError("--serial needs --store; units of files are named by --unit-from", option="serial")
    if not logs and store is None:
        raise OptionError("name a log with a temperature column, several runs, or --store", option="logs")
    about = stated_temperature(reference)
    asked = _numbers(mean)
    channels = [word.strip() for text in axes or [] for word in text.split(",") if word.strip()] or None
    exports = _exports(export or [])
    if instance is not None and not exports:
        raise OptionError("--instance needs --export px4=FILE or --export ardupilot=FILE", option="instance")
    if device_id is not None and "px4" not in exports:
        raise OptionError("--device-id needs --export px4=FILE", option="device_id")
    places = [] if store is not None else _gather(matched(logs), quiet=quiet)
    named = {f"export {name}": path for name, path in exports.items()}
    check_outputs(places, report=report, plot=plot, json=json, csv=csv, **named)
    code, matrix, result = 0, None, None
    record = None
    if store is None and len(places) == 1 and places[0].suffix.lower() != ".json":
        (log,) = places
        record = read_log(log, assign_readings(reading, places, logs)[log], quiet=quiet)
        code = damaged(record.findings)
        with working("calibrating", quiet=quiet):
            try:
                result = calibrate_temperature(record, channels=channels, degree=degree, reference=about, level=level)
            except NotAtRestError as error:
                say(f"sigmatau: {log}: {error.reason}")
                return _NOT_AT_REST
            except DataError as error:
                raise error.about(str(log)) from None
    else:
        if channels is not None:
            raise OptionError(
                "--axes takes the log of a ramp or a soak. Runs are used with all channels", option="axes"
            )
        if store is not None:
            runs = _stored(store, serial or [])
        else:
            runs, has_problems = _read_runs(places, logs, reading, temperature_from, unit_from, quiet=quiet)
            code = _UNUSABLE if has_problems else 0
        matrix = temperature_matrix([(unit, degrees, run) for unit, _, degrees, run in runs])
        if len({unit for unit, *_ in runs}) == 1:
            try:
                result = calibrate_over_runs(
                    [TemperatureRun(name=name, temperature=degrees, result=run) for _, name, degrees, run in runs],
                    degree=degree, reference=about, level=level, source=store or "runs", unit_name=runs[0][0],
                )  # fmt: skip
            except DataError as error:
                if exports or asked is not None:
                    raise
                say(f"no polynomial: {error}", quiet=quiet)
    shown: TemperatureCalibration | TemperatureMatrix | None = result or matrix
    assert shown is not None
    if result is not None:
        check_shown({name: (channel.quantity, channel.unit) for name, channel in result.items()})
    elif exports or asked is not None:
        raise OptionError(
            "several units have no common polynomial; choose one by --serial or its files", option="serial"
        )
    text = repr(shown)
    if result is not None and asked is not None:
        try:
            text += "\n\n" + mean_text(result, asked)
        except OptionError as error:
            raise error.named("mean") from None
    for target, path in exports.items():
        assert result is not None
        result.export(to=target, path=path, instance=instance, device_id=device_id or 0)
    if plot is not None:
        with drawing(plot, style, quiet=quiet):
            write_figure(shown.plot(), plot)
    if report is not None:
        with working(f"writing {report}", quiet=quiet):
            temperature_report(shown, report, matrix=matrix if result is not None else None, command=command_line())
    if csv is not None:
        with atomic(csv) as temporary:
            temporary.write_text(csv_text(shown.columns()), encoding="utf-8")
    write_result(text, shown.to_dict(), json)
    return code


def _gather(places: Sequence[Path], *, quiet: bool) -> list[Path]:
    """Logs and results. A folder without logs has results."""
    files: list[Path] = []
    for place in places:
        if not place.is_dir():
            files.append(place)
            continue
        try:
            inside, skipped = gather([place])
        except DataError:
            files += gather_results([place], tables=False)
            continue
        files += sorted(inside, key=lambda file: natural_order(str(file)))
        for line in skipped_lines(skipped):
            say(line, quiet=quiet)
    return files


def _numbers(text: str | None) -> np.ndarray | None:
    """Parse ``--mean``."""
    if text is None:
        return None
    try:
        return np.array([float(part) for part in text.split(",")])
    except ValueError:
        raise OptionError(
            f"--mean {text!r:.40}: must be temperatures in °C, such as -20,25,60", option="mean"
        ) from None


def _exports(texts: Sequence[str]) -> dict[str, Path]:
    """Parse ``--export``: files by autopilot."""
    files = {}
    for text in texts:
        target, _, path = text.partition("=")
        if target not in AUTOPILOTS or not path:
            raise OptionError(f"--export {text}: must be px4=FILE or ardupilot=FILE", option="export")
        if target in files:
            raise OptionError(f"--export {target} is given twice", option="export")
        files[target] = Path(path)
    return files


def _stored(place: str, serial: Sequence[str]) -> list[Run]:
    """Runs of a store that have a temperature, in order of time."""
    from sigmatau.cli.store import opened
    from sigmatau.lab.store.choosing import Chosen

    with opened(place) as store:
        runs = [
            (str(row["unit"]), str(row["run"]), float(row["temperature"]), result)
            for row, result in store.results(Chosen(units=tuple(serial)))
            if row["temperature"] is not None and isinstance(result, Analysis)
        ]
    if not runs:
        raise DataError(f"{place}: no run has a temperature. Add runs with sigmatau store add --temperature")
    return runs


def _read_runs(
    places: Sequence[Path],
    given_places: Sequence[Path],
    reading: ReadingOptions | None,
    temperature_from: str | None,
    unit_from: str | None,
    *,
    quiet: bool,
) -> tuple[list[Run], bool]:
    """Analyse logs and read results, each at one temperature, and whether some could not be used."""
    readings = assign_readings(reading, places, given_places)
    runs: list[Run] = []
    problems: list[str] = []
    for place, name in zip(places, batch.names(places), strict=True):
        stated = None if temperature_from is None else float(_in_path(place, temperature_from, "temperature_from"))
        unit = None if unit_from is None else _in_path(place, unit_from, "unit_from")
        try:
            degrees, result = _read_run(place, readings[place], quiet=quiet)
            degrees = stated if stated is not None else degrees
            degrees = Naming(unit="-").entry(result, place).temperature if degrees is None else degrees
            if not result.fits:
                raise DataError(result.reason_without_fits)
            if degrees is None:
                raise DataError(
                    "its temperature is not known. Give --temperature-from, or analyze --note temperature=25degC"
                )
        except DataError as error:
            problems.append(f"{place}: {error.without(str(place))}")
            continue
        runs.append((noted_unit(result.notes) if unit is None else unit, name.removesuffix(".json"), degrees, result))
    if not runs and problems:
        raise DataError(problems[0])
    for problem in problems:
        say(f"sigmatau: not used: {problem}")
    return runs, bool(problems)


def _read_run(place: Path, reading: ReadingOptions, *, quiet: bool) -> tuple[float | None, Analysis]:
    """Mean temperature of the thermometer, if there is one, and result of a log or a file of results."""
    if place.suffix.lower() == ".json":
        result = read_result(place)
        if not isinstance(result, Analysis):
            raise DataError("has no coefficients. Remove it, or analyse its log again")
        return None, result
    record = read_log(place, reading, quiet=quiet)
    degrees = _measured_temperature(record)
    with working(f"analysing {place}", quiet=quiet):
        return degrees, analyze(record)


def _measured_temperature(record: Record) -> float | None:
    """Mean of the thermometer of a log at one temperature; None without a thermometer."""
    stream = next((stream for stream in record.streams if stream.quantity == "temperature"), None)
    if stream is None:
        return None
    values = stream.column(stream.channels[0])
    values = values[np.isfinite(values)]
    if np.ptp(values) >= LEAST_RANGE:
        raise DataError(
            f"its temperature varies by {np.ptp(values):.3g} K; several logs are runs at one temperature each."
            " Give a ramp alone"
        )
    return float(values.mean())


def _in_path(place: Path, expression: str, option: str) -> str:
    """The part of a path that an expression finds."""
    spelled = option.replace("_", "-")
    try:
        match = re.search(expression, str(place.absolute()))
        part = "" if match is None else match[1] or ""
        if option == "temperature_from" and part:
            float(part)
    except (re.error, IndexError, ValueError):
        raise OptionError(f"--{spelled} {expression!r}: must find a value in parentheses", option=option) from None
    if not part:
        raise OptionError(f"{place}: --{spelled} {expression!r} finds nothing in the path", option=option)
    return part
