"""``sigmatau tune``: find the wrong noise of a filter and its factor from the innovations."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Literal

from sigmatau._version import __version__
from sigmatau.analysis.inputs import read_source
from sigmatau.cli.datasheet import check_model
from sigmatau.cli.declared import InMain, InMethod, InOutput, MayBeMinus, Quiet, Show, Texts
from sigmatau.cli.options import (
    check_outputs,
    check_style,
    drawing,
    say,
    working,
    write_figure,
    write_result,
)
from sigmatau.errors import OptionError
from sigmatau.exporting.choices import KINDS, Choices
from sigmatau.exporting.inflation import Cause, Inflation, inflation
from sigmatau.exporting.tuning.filters import BiasFilter
from sigmatau.exporting.tuning.innovations import Innovations, join_measurements
from sigmatau.exporting.tuning.result import Tunings
from sigmatau.exporting.tuning.table import read_innovations
from sigmatau.exporting.tuning.tune import tune
from sigmatau.exporting.values import Numbers
from sigmatau.model.file import has_unit, value_in_si
from sigmatau.noise.shown import set_shown
from sigmatau.noise.terms import check_shown
from sigmatau.quality.selection.time_text import parse_seconds
from sigmatau.record.record import stream_name
from sigmatau.typed.pairs import key_values

_UNITS = {"noise": ("rad/sqrt(s)", "m/s/sqrt(s)"), "walk": ("rad/s/sqrt(s)", "m/s^2/sqrt(s)")}
_EXAMPLES = {"noise": 'gyro="0.3 deg/sqrt(h)"', "walk": 'gyro="20 deg/h/sqrt(h)"'}


def tune_command(
    innovations: Path | None = None,
    /,
    *,
    noise: Annotated[list[str] | None, Texts, InMain] = None,
    walk: Annotated[list[str] | None, Texts, InMain] = None,
    model: Annotated[Path | None, InMain] = None,
    rest: Annotated[Path | None, InMain] = None,
    joint: Annotated[str | None, InMain] = None,
    columns: Annotated[list[str] | None, Texts, InMethod] = None,
    time: Annotated[str | None, InMethod] = None,
    skip: Annotated[str | None, InMethod] = None,
    plot: Annotated[Path | None, InMain] = None,
    style: Annotated[Literal["screen", "paper"], InOutput] = "screen",
    json: Annotated[Path | None, MayBeMinus, InMain] = None,
    show: Show = None,
    quiet: Quiet = False,
) -> int:
    """Find the wrong noise of a filter, and its factor, from the innovations.

    Other filters: sigmatau.tune in Python, with matrices.

    Parameters
    ----------
    innovations
        Table with a header: time, innovation and its stated variance S = H·P·Hᵀ + R, in SI or with units in the header.
        Several channels are pairs of columns with the same ending: nu_gyro_x,S_gyro_x. A column rate_gyro_x is the rate
        of motion at the same time, from which a delay and a scale error are estimated. With --rest, the JSON of analyze
        --at-rest for a log with engines or motors on.
    noise
        N of the filter by sensor or channel, with its unit: gyro="0.3 deg/sqrt(h)". The filter estimates an attitude with
        the bias of a gyro, or a velocity with that of an accelerometer; its measurement noise follows from N, K and S.
        Default: unknown; then only the NIS and the whiteness are judged.
    walk
        K of the filter: gyro="20 deg/h/sqrt(h)". Required with --noise.
    model
        Model file (.toml), JSON of analyze, or YAML of Kalibr or imu_utils, instead of --noise and --walk: N and K as
        export writes them for a filter.
    rest
        Without innovations: model file or JSON of analyze of the sensor at rest. Prints the factor of each coefficient
        with running motors, its cause, and the command that writes the file with the factors.
    joint
        Channels that are measurements of one filter: gnss,camera. Each has a separate factor; N and K are common.
        Default: each channel is a filter with one measurement.
    columns
        Columns of innovation, variance and rate of motion by channel, by name or number: gyro_x=nu:S or gyro_x=nu:S:rate.
        Default: recognised by their names.
    time
        Column of the time, by name or number. Default: recognised by its name.
    skip
        Time at the beginning that is left out because the filter converges: 30s. Default: none.
    plot
        Draw the Allan deviation of the normalised innovations: .png, .svg or .pdf.
    style
        Style of figures: screen, or paper, for the width of a column or a page of a paper.
    json
        Write the result as JSON, in SI; - writes it to standard output instead of the table.
    show
        With --rest: units of the printed coefficients, deg/h,mdps/rtHz. Default: those of the field.
    quiet
        Print only errors on standard error.
    """
    check_style(style, plot)
    if innovations is None:
        raise OptionError(
            "give the table of innovations: sigmatau tune innovations.csv"
            if rest is None
            else f"--rest compares two records. Add that with running motors: sigmatau tune --rest {rest} running.json",
            option="innovations",
        )
    check_outputs([innovations], plot=plot, json=json)
    if rest is not None:
        set_shown(show)
        stated = {
            "noise": noise,
            "walk": walk,
            "model": model,
            "joint": joint,
            "columns": columns,
            "time": time,
            "skip": skip,
            "plot": plot,
        }
        return _inflate(rest, innovations, json, {name for name, value in stated.items() if value}, quiet=quiet)
    if innovations.suffix.lower() in (".json", ".toml"):
        raise OptionError(
            f"{innovations} is not a table of innovations. For factors of running motors give the sensor at rest,"
            " --rest rest.json",
            option="rest",
        )
    if show is not None:
        raise OptionError("--show is for the coefficients of --rest; innovations have no unit", option="show")
    data = read_innovations(innovations, columns=key_values(columns or [], "columns", "gyro_x=nu:S") or None, time=time)
    if joint is not None:
        data = _joined(data, joint)
    filters = _filters(data, noise or [], walk or [], model)
    after = 0.0 if skip is None else parse_seconds(skip, option="skip")
    with working("comparing noises", quiet=quiet):
        result = tune(data, filters=filters, skip=after)
    if plot is not None:
        with drawing(plot, style, quiet=quiet):
            write_figure(result.plot(), plot)
    write_result(repr(result), {"sigmatau": __version__, "channels": result.to_dict()}, json)
    if model is not None:
        for line in _exports(result, model):
            say(line, quiet=quiet)
    return 0


def _joined(data: Mapping[str, Innovations], joint: str) -> dict[str, Innovations]:
    """Join the channels of one filter, with the name in the option."""
    names = [name.strip() for name in joint.split(",")]
    for name in names:
        if name not in data:
            raise OptionError(f"--joint {name}: the innovations are of {', '.join(data)}", option="joint")
    if len({*names}) < 2:
        raise OptionError("--joint needs two channels, --joint gnss,camera", option="joint")
    separate = {name: each for name, each in data.items() if name not in names}
    return {"+".join(names): join_measurements({name: data[name] for name in names}), **separate}


def _filters(
    data: Mapping[str, Innovations], noise: Sequence[str], walk: Sequence[str], model: Path | None
) -> dict[str, BiasFilter] | None:
    """Build the filter of each channel; None if no filter is stated."""
    if model is not None:
        if noise or walk:
            raise OptionError("--model has N and K. Give either it, or --noise and --walk", option="model")
        return _filters_of_model(data, model)
    if not noise and not walk:
        return None
    stated = {
        option: _values(data, key_values(texts, option, _EXAMPLES[option]), option)
        for option, texts in (("noise", noise), ("walk", walk))
    }
    filters = {}
    for channel in data:
        absent = [option for option, values in stated.items() if channel not in values]
        if len(absent) == 2:
            continue
        if absent:
            raise OptionError(
                f"--{absent[0]}: N and K of the filter of {channel} are both needed. Add --{absent[0]}"
                f" {_EXAMPLES[absent[0]].replace('gyro', channel)}",
                option=absent[0],
            )
        filters[channel] = BiasFilter(noise=stated["noise"][channel], walk=stated["walk"][channel])
    return filters


def _values(data: Mapping[str, Innovations], texts: Mapping[str, str], option: str) -> dict[str, float]:
    """Parse values to SI by channel. The name of a sensor sets the value of all its channels."""
    values: dict[str, float] = {}
    for key, text in texts.items():
        named = [channel for channel in data if key in (channel, stream_name(channel))]
        if not named and key in KINDS:
            named = [channel for channel in data if len(data) == 1 and stream_name(channel) not in KINDS]
        if not named:
            action = "Use one of these names"
            if key in KINDS and not any(stream_name(channel) in KINDS for channel in data):
                action = f"Join those of one filter, --joint {','.join(data)}, or use their names"
            raise OptionError(f"--{option} {key}: the innovations are of {', '.join(data)}. {action}", option=option)
        gyro, accel = _UNITS[option]
        value = value_in_si(text, accel if has_unit(text, accel) else gyro, f"--{option} {key}")
        for channel in named:
            if channel not in values or key == channel:
                values[channel] = value
    return values


def _filters_of_model(data: Mapping[str, Innovations], model: Path) -> dict[str, BiasFilter]:
    """N and K as an export would write them for a filter."""
    check_model(model)
    numbers = Numbers(read_source(model), Choices(), pair=True)
    sensors = [sensor for sensor in KINDS if numbers.has(sensor)]
    filters = {}
    for channel in data:
        sensor = stream_name(channel)
        if sensor not in KINDS and len(sensors) == 1:
            (sensor,) = sensors
        if sensor not in sensors:
            kinds = " and ".join(KINDS[each] for each in sensors) or "no inertial sensor"
            raise OptionError(
                f"--model: {model} has {kinds}, and {channel} is not a channel of them."
                " Name it, --columns gyro_x=INNOVATION:S",
                option="model",
            )
        pair = BiasFilter(noise=numbers.noise(sensor).value, walk=numbers.walk(sensor).value)
        if numbers.missing:
            raise OptionError(f"--model: {next(iter(numbers.missing.values()))}", option="model")
        filters[channel] = pair
    return filters


def _inflate(rest: Path, running: Path, json: Path | None, unused: Iterable[str], *, quiet: bool) -> int:
    """Print the factors of a running sensor relative to rest."""
    for option in unused:
        raise OptionError(
            f"--{option} applies to innovations, and --rest compares two records. Give one of them", option=option
        )
    for place in (rest, running):
        if place.suffix.lower() not in (".json", ".toml", ".yaml", ".yml"):
            at_rest = " --at-rest" if place == running else ""
            raise OptionError(
                f"{place} is not a result. Analyse the log first:"
                f" sigmatau analyze {place}{at_rest} --json {place.stem}.json",
                option="rest",
            )
    check_model(rest)
    factors = inflation(read_source(rest), read_source(running))
    check_shown({name: (model.quantity, model.unit) for name, model in factors.rest.items()})
    write_result(repr(factors), {"sigmatau": __version__, **factors.to_dict()}, json)
    line = _export_line(rest, factors)
    if line:
        say(line, quiet=quiet)
    return 0


def _export_line(rest: Path, factors: Inflation) -> str:
    """Command that writes the file of the sensor at rest with these factors; empty without factors."""
    causes: tuple[tuple[str, Cause], ...] = (("noise-factor", "white vibration"), ("walk-factor", "slow noise"))
    options = [
        f"--{option} {','.join(f'{sensor}={value:.3g}' for sensor, value in by_sensor.items())}"
        for option, cause in causes
        if (by_sensor := factors.largest_by_sensor(cause))
    ]
    return f"a file with these factors: sigmatau export {rest} --to TARGET {' '.join(options)}" if options else ""


def _exports(result: Tunings, model: Path) -> list[str]:
    """Command that writes a file with the largest factors of the channels, by sensor."""
    options = []
    for option, name in (("noise-factor", "white"), ("walk-factor", "slow")):
        largest: dict[str, float] = {}
        for channel, judged in result.items():
            sensor = stream_name(channel)
            for factor in judged.causes if judged.verdict == "wrong" and judged.common_factor is None else ():
                if factor.noise == name:
                    largest[sensor] = max(largest.get(sensor, 0.0), factor.value)
        if largest:
            by_sensor = set(largest) <= set(KINDS)
            texts = [f"{sensor}={value:.3g}" if by_sensor else f"{value:.3g}" for sensor, value in largest.items()]
            options.append(f"--{option} {','.join(texts) if by_sensor else max(texts, key=float)}")
    if not options:
        return []
    return [f"a file with these factors: sigmatau export {model} --to TARGET {' '.join(options)}"]
