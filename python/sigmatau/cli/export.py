"""``sigmatau export``: write the file that a filter reads, from a model or a result."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from sigmatau.analysis.inputs import read_source
from sigmatau.cli.choosing import Choosing, print_findings, targets_for_shell
from sigmatau.cli.datasheet import check_model
from sigmatau.cli.declared import Show
from sigmatau.cli.earlier import expect
from sigmatau.cli.options import check_output, finding_lines, refuse_same, say
from sigmatau.errors import OptionError
from sigmatau.exporting.choices import Choices, not_of_a_log
from sigmatau.exporting.export import Prepared, check_all, check_path, prepare
from sigmatau.exporting.inflation import inflated
from sigmatau.exporting.stated import prepare_stated
from sigmatau.exporting.target import Target
from sigmatau.exporting.targets import NAMES, target
from sigmatau.exporting.turn_on import with_turn_on
from sigmatau.hints import worded
from sigmatau.lab.datasheets.sheet import Datasheet, datasheet
from sigmatau.model.channel import ChannelModel
from sigmatau.noise.shown import set_shown
from sigmatau.noise.terms import check_shown


def export_command(
    source: Path | None = None,
    /,
    *,
    to: Annotated[str | None, Parameter(completer=targets_for_shell)] = None,
    output: Annotated[Path | None, Parameter(name=["--output", "-o"])] = None,
    rate: float | None = None,
    choosing: Choosing | None = None,
    from_datasheet: str | None = None,
    sided: Literal["one", "two"] | None = None,
    inflate: Path | None = None,
    turn_on: Path | None = None,
    list_: Annotated[bool, Parameter(name="--list", negative=())] = False,
    show: Show = None,
    quiet: Annotated[bool, Parameter(name=["--quiet", "-q"], negative=())] = False,
) -> int:
    """Write the noise parameters for another program in its units, with the origin of each number as a comment.

    Parameters
    ----------
    source
        Model file (.toml), JSON of analyze, or YAML of Kalibr or imu_utils.
    to
        The target; see --list.
    output
        File to write (default: standard output).
    rate
        Sampling rate in Hz of the record of a YAML file; required for a result of imu_utils. The rate of the filter is
        --filter-rate.
    from_datasheet
        Instead of a source: typical values of a sensor, by a name of "sigmatau datasheet list" or your file (.toml). If a
        convention is not stated, the one with more noise is used; a rate random walk is matched at --horizon (default 10s).
    sided
        With --from-datasheet: convention of noise densities that the datasheet does not state. Default: two, with a warning.
    inflate
        JSON of the sensor at rest; the source is the JSON of the same sensor with engines or motors on. Writes the numbers
        of the source, with the factors over those at rest as comments; "sigmatau tune --rest" prints the factors.
    turn_on
        Model file (.toml) of "sigmatau compare --model": adds its turn-on biases to the source.
    list_
        List the targets; with a name, --list kalibr, show its options.
    quiet
        Print only errors on standard error.
    """
    set_shown(show)
    if list_ and source is not None:
        sys.stdout.write(_about(target(str(source))))
        return 0
    if list_:
        width = max(map(len, NAMES))
        sys.stdout.write("".join(f"{name:<{width}}  {worded(target(name).summary)}\n" for name in NAMES))
        return 0
    if (source is None) == (from_datasheet is None):
        raise OptionError("give a model file or a result, or --from-datasheet NAME, or --list", option="source")
    if sided is not None and from_datasheet is None:
        raise OptionError("--sided needs --from-datasheet NAME", option="sided")
    if turn_on is not None and source is None:
        raise OptionError("--turn-on needs a source, not --from-datasheet", option="turn_on")
    if inflate is not None and source is not None and to is None:
        raise OptionError(
            f"--to is missing; for the factors alone: sigmatau tune --rest {inflate} {source}", option="to"
        )
    if to is None:
        raise OptionError(f"--to is missing; targets: {', '.join(NAMES)}", option="to")
    wanted = target(to)
    check_output(output, (), "output")
    if source is not None:
        refuse_same(source, output=output)
        check_model(source, "take --from-datasheet {0}")
    choices = (choosing or Choosing()).choices()
    if from_datasheet is not None and rate is not None:
        raise not_of_a_log(rate)
    # The choices are checked before a file is read. Whether a datasheet needs the horizon depends on its values.
    check_all([to], choices if from_datasheet is None else choices.without("horizon"))
    if output is not None:
        check_path(wanted, output)
    expect(output)
    prepared = (
        _prepare_datasheet(from_datasheet, wanted, choices, path=output, sided=sided, quiet=quiet)
        if from_datasheet is not None
        else _prepare_source(
            source, wanted, choices, path=output, rate=rate, inflate=inflate, turn_on=turn_on, quiet=quiet
        )
    )
    content = prepared.content
    print_findings(prepared.findings, quiet=quiet)
    if output is not None:
        prepared.write()
        say(f"{output}: written for {to}", quiet=quiet)
    elif isinstance(content, str):
        sys.stdout.write(content)
    return 0


def _prepare_source(
    source: Path | None,
    wanted: Target,
    choices: Choices,
    *,
    path: Path | None,
    rate: float | None,
    inflate: Path | None,
    turn_on: Path | None,
    quiet: bool,
) -> Prepared:
    assert source is not None
    read = read_source(source, rate=rate)
    _check_shown(read.model.channels)
    if turn_on is not None:
        read = with_turn_on(read, turn_on)
    for line in finding_lines(read.findings):
        say(line, quiet=quiet)
    if inflate is not None:
        read, doubt = inflated(read, read_source(inflate), name=inflate.name)
        if doubt:
            say(f"warning: {doubt}", quiet=quiet)
    return prepare(read, to=wanted.name, path=path, choices=choices)


def _prepare_datasheet(
    name: str,
    wanted: Target,
    choices: Choices,
    *,
    path: Path | None,
    sided: Literal["one", "two"] | None,
    quiet: bool,
) -> Prepared:
    """Prepare the file for stated values. If a convention is not stated, the interpretation with more noise is used."""
    sheet = datasheet(name)
    if sided is None and not _states_sides(sheet):
        say(
            f"warning: {sheet.name}: the datasheet does not state whether its noise density is one-sided or two-sided;"
            " two-sided is taken, √2 times the noise. Most datasheets are one-sided: --sided one",
            quiet=quiet,
        )
    sided = sided or "two"
    origins = (
        f"from the datasheet of {sheet.name} ({sheet.maker}); {sheet.source}",
        *sheet.origins(sided=sided, bias="minimum"),
    )
    model = sheet.model(sided=sided, bias="minimum")
    _check_shown(model.channels)
    return prepare_stated(model, to=wanted.name, path=path, choices=choices, origins=origins)


def _check_shown(channels: Mapping[str, ChannelModel]) -> None:
    """Raise `OptionError` for a unit of ``--show`` that fits no channel."""
    check_shown({name: (model.quantity, model.unit) for name, model in channels.items()})


def _states_sides(sheet: Datasheet) -> bool:
    """Whether the conventions of the model's noise densities are stated."""
    try:
        sheet.model(bias="minimum")
    except OptionError:
        return False
    return True


def _name_option(target: Target, key: str) -> str:
    """``form=channels (or joint, third-state)``."""
    default = target.names[key]
    further = ", ".join(value for value in target.name_values.get(key, ()) if value != default)
    return f"{key}={default}" + f" (or {further})" * bool(further)


def _about(target: Target) -> str:
    """Options of a target, except --rate-random-walk and --random-walk."""
    axes = "worst, mean, each" if target.per_axis else "worst, mean"
    rows = {
        "file": ", ".join([target.ending, *(e for e in target.binary if e != target.ending)]),
        "--filter-rate": "required, unless the source is a result" if target.needs_rate else "not needed",
        "--step": "step of the filter" if target.has_step else "none",
        "--horizon": "time after which the error is stated correctly; default 60s"
        if target.has_walk
        else ("supported, also " if target.has_horizon else "only ") + "with --rate-random-walk SENSOR=horizon",
        "--axes": "none: every axis separately" if target.every_axis else axes,
        "--name": ", ".join(_name_option(target, key) for key in target.names) or "none",
    }
    return "".join(
        [f"{target.name}: {worded(target.summary)}\n", *(f"  {key:<13} {text}\n" for key, text in rows.items())]
    )
