"""``sigmatau demo``: simulate the paper's tactical-grade unit, analyse the file, print what was read beside the truth."""

from __future__ import annotations

import sys
from importlib import resources
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from sigmatau.analysis import Analysis, analyze
from sigmatau.cli.analyze import write_figure, write_json
from sigmatau.cli.options import say, working
from sigmatau.errors import DataError
from sigmatau.io import read
from sigmatau.io.write import write_record
from sigmatau.model import NoiseModel, simulate
from sigmatau.results import value_error_text
from sigmatau.terms import TERMS, display_units

__all__ = ["demo_command"]

_HOURS, _RATE = 2.0, 100.0


def demo_command(
    *,
    output: Annotated[Path, Parameter(name=["--output", "-o"])] = Path("demo"),
    seed: int = 0,
    quiet: Annotated[bool, Parameter(name=["--quiet", "-q"], negative=())] = False,
) -> int:
    """Simulate two hours of a tactical-grade unit, analyse that log, and compare with the truth.

    The unit is the Honeywell HG1700 of El-Sheimy, Hou & Niu (2008), Table IV: 100 Hz, six axes.

    Parameters
    ----------
    output
        Directory for the model, the log, the figure and the JSON.
    seed
        Seed of the noise.
    quiet
        Nothing on standard error but errors.
    """
    try:
        output.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise DataError(f"{output}: cannot be made a directory: {error.strerror or error}") from None
    text = resources.files("sigmatau.data").joinpath("hg1700.toml").read_text(encoding="utf-8")
    model_file, log = output / "hg1700.toml", output / "static.csv"
    model_file.write_text(text, encoding="utf-8")
    model = NoiseModel.read(model_file)
    with working(f"simulating {_HOURS:g} h at {_RATE:g} Hz, six axes", quiet=quiet):
        record = simulate(model, duration=_HOURS * 3600, rate=_RATE, rng=seed)
    with working(f"writing {log}", quiet=quiet):
        write_record(record, log)
    with working(f"reading {log}", quiet=quiet):
        record = read(log)
    with working("computing Allan variances", quiet=quiet):
        analysis = analyze(record)
    figure, result = output / "allan.png", output / "result.json"
    with working(f"drawing {figure}", quiet=quiet):
        write_figure(analysis, figure)
    write_json(analysis, result)
    sys.stdout.write(f"{analysis.summary()}\n\n{_beside_truth(analysis, model)}\n")
    say(f"\nwritten: {model_file}, {log}, {figure}, {result}", quiet=quiet)
    return 0


def _beside_truth(analysis: Analysis, model: NoiseModel) -> str:
    rows = [("", "term", "truth", "read off", "unit", "off by")]
    for channel, truth in model.channels.items():
        result = analysis.read_off[channel]
        for k, (name, value) in enumerate(truth.items()):
            unit, factor = display_units(name, result.quantity, result.rate_unit)[0]
            label = TERMS[name].label(result.quantity)
            if name in result:
                c = result[name]
                read_text = value_error_text(c.value / factor, c.error / factor)
                off = f"{100 * (c.value / value - 1):+.1f} %"
            else:
                read_text, off = "no region", ""
            rows.append((channel if k == 0 else "", label, f"{value / factor:.5g}", read_text, unit, off))
    widths = [max(len(row[k]) for row in rows) for k in range(6)]
    return "\n".join("  ".join(cell.ljust(w) for cell, w in zip(row, widths, strict=True)).rstrip() for row in rows)
