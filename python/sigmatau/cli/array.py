"""``sigmatau array``: several sensors of one axis, their covariance, and the virtual sensor that they make."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from sigmatau.cli.choosing import Choosing, Exports, print_findings
from sigmatau.cli.declared import InMain, InMethod, InOutput, MayBeMinus, Quiet, Show, Texts
from sigmatau.cli.options import (
    check_output,
    check_outputs,
    check_style,
    drawing,
    matched,
    say,
    working,
    write_figure,
    write_result,
)
from sigmatau.cli.outputs import NOT_AT_REST
from sigmatau.cli.reading import ReadingOptions, assign_readings, read_log
from sigmatau.errors import DataError, NotAtRestError, OptionError
from sigmatau.exporting.export import prepare
from sigmatau.findings.finding import damaged
from sigmatau.io.atomic import atomic
from sigmatau.io.write import RECORD_ENDINGS
from sigmatau.lab.arrays.analyze import analyze_array
from sigmatau.lab.arrays.result import ArrayAnalysis
from sigmatau.model.file import value_in_si
from sigmatau.model.noise_model import NoiseModel
from sigmatau.noise.shown import set_shown
from sigmatau.noise.terms import NOISE, check_shown
from sigmatau.results import csv_text


def array_command(
    *logs: Path,
    reading: ReadingOptions | None = None,
    axes: Annotated[list[str] | None, Texts, InMain] = None,
    invert: Annotated[list[str] | None, Texts, InMethod] = None,
    target: Annotated[str, InMain] = "random_walk",
    common: Annotated[bool, Parameter(negative=()), InMain] = False,
    virtual: Annotated[str | None, InOutput] = None,
    plot: Annotated[Path | None, InMain] = None,
    style: Annotated[Literal["screen", "paper"], InOutput] = "screen",
    json: Annotated[Path | None, MayBeMinus, InMain] = None,
    csv: Annotated[Path | None, InOutput] = None,
    write: Annotated[Path | None, InMain] = None,
    export: Annotated[list[str] | None, Texts, InMain] = None,
    export_sensors: Annotated[list[str] | None, Texts, InOutput] = None,
    choosing: Choosing | None = None,
    show: Show = None,
    quiet: Quiet = False,
) -> int:
    """Combine several sensors of one axis, at rest and sampled together: correlation of their noise, optimal weights, and
    the noise of the virtual sensor that they make.

    Parameters
    ----------
    logs
        A log of all sensors; or several logs with the same clock, one sensor each.
    axes
        Channels of the sensors: gyro_1,gyro_2,gyro_3; of several logs the one channel, gyro_x. Default: all channels.
    invert
        Channels whose sign is changed, because their sensors are mounted the other way around. Default: none.
    target
        What the weights minimise: random_walk, bias_instability, rate_random_walk, or the Allan deviation at an averaging
        time, e.g. 100s.
    common
        Eliminate a disturbance that all sensors have in common, such as the motion of a table (N-cornered hat). Needs three
        sensors with independent noise.
    virtual
        Channel of the virtual sensor, e.g. gyro_x. Default: the axis of the channels, or gyro_virtual.
    plot
        Draw the deviations of the sensors and the virtual sensor, and the correlations: .png, .svg or .pdf.
    style
        Style of figures: screen, or paper, for the width of a column or a page of a paper.
    json
        Write all numbers as JSON in SI units; - writes it to standard output instead of the table.
    csv
        Write one row for each coefficient, correlation, weight and Allan covariance as CSV in SI units.
    write
        Write the samples of the virtual sensor as a log: .csv, .npy, .parquet …
    export
        Write the noise model of the virtual sensor for a program, TARGET=FILE; see "sigmatau export --list". Default: none.
    export_sensors
        Write the noise model of all sensors with their correlations, TARGET=FILE, for targets that take them: state-space
        with --name form=joint, or model. Default: none.
    quiet
        Print only errors on standard error.
    """
    set_shown(show)
    if not logs:
        raise OptionError("name a log of all sensors, or several logs of one sensor each", option="logs")
    check_style(style, plot)
    minimised = _target(target)
    places = matched(logs)
    made = Exports.parse(export or [], choosing if export else None, method="likelihood")
    sensors = Exports.parse(export_sensors or [], choosing if not export else None, method="likelihood")
    named = {f"export {key}": path for key, path in made.files.items()}
    named |= {f"export-sensors {key}": path for key, path in sensors.files.items()}
    check_outputs(places, plot=plot, json=json, csv=csv, write=write, **named)
    check_output(write, RECORD_ENDINGS, "write")
    readings = assign_readings(reading, places, list(logs))
    records = [read_log(log, readings[log], quiet=quiet) for log in places]
    for finding in dict.fromkeys(finding for record in records for finding in record.findings):
        say(str(finding), quiet=quiet)
    try:
        with working("fitting the covariance of the sensors", quiet=quiet):
            result = analyze_array(
                records[0] if len(records) == 1 else records,
                axes=_words(axes),
                invert=_words(invert) or (),
                target=minimised,
                common=common,
                name=virtual,
            )
    except OptionError as error:
        raise error.named("virtual" if error.option == "name" else error.option or "") from None
    except NotAtRestError as error:
        say(f"sigmatau: {error}")
        return NOT_AT_REST
    check_shown(dict.fromkeys(result.names, (result.quantity, result.unit)))
    for finding in result.analysis.findings:
        if finding.severity != "info":
            say(str(finding), quiet=quiet)
    if csv is not None:
        with atomic(csv) as temporary:
            temporary.write_text(csv_text(result.columns()), encoding="utf-8")
    if write is not None:
        result.write_fused(write)
    if plot is not None:
        with drawing(plot, style, quiet=quiet):
            write_figure(result.plot(style=style), plot)
    write_result(repr(result), result.to_dict() if json is not None else None, json)
    _export(result, made, sensors, quiet=quiet)
    return max(damaged(record.findings) for record in records)


def _words(texts: Sequence[str] | None) -> list[str] | None:
    return None if texts is None else [word.strip() for text in texts for word in text.split(",") if word.strip()]


def _target(text: str) -> str | float:
    """A term, or an averaging time in s."""
    word = text.replace("-", "_")
    if word in NOISE:
        return word
    try:
        return value_in_si(text, "s", "--target")
    except ValueError:
        raise OptionError(
            f"--target {text!r}: must be {', '.join(NOISE)} or an averaging time, e.g. 100s", option="target"
        ) from None


def _export(result: ArrayAnalysis, made: Exports, sensors: Exports, *, quiet: bool) -> None:
    """Write the models of the virtual sensor and of all sensors."""
    if made.files and result.virtual is None:
        raise DataError(f"--export: there is no virtual sensor: {result.no_weights}")
    models: Mapping[int, NoiseModel | None] = {
        0: None if result.virtual is None or not made.files else result.virtual.model,
        1: result.model if sensors.files else None,
    }
    for number, exports in enumerate((made, sensors)):
        model = models[number]
        for key, path in exports.files.items():
            if model is None:
                continue
            file = prepare(model, to=key, path=path, choices=exports.choices)
            print_findings(file.findings, quiet=quiet)
            file.write()
            say(f"{path}: written for {key}", quiet=quiet)
