"""``sigmatau demo``: simulate one of the paper's three units, analyse the file, compare the result with the truth."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from sigmatau.analysis import Analysis, analyze
from sigmatau.cli.options import command_line, say, working, write_json
from sigmatau.errors import DataError
from sigmatau.io.read import read
from sigmatau.io.write import write
from sigmatau.model.noise_model import NoiseModel
from sigmatau.noise.terms import TERMS, display_units
from sigmatau.reporting.report import report
from sigmatau.results import aligned
from sigmatau.simulation.in_memory import simulate

_HOURS = 2.0
# Sampling rate in hertz, and the description of the unit on the screen. The rate of the CIMU follows from the error of
# 0.06 % that the paper states for one sample; the paper states the other two rates.
_UNITS: Mapping[str, tuple[float, str]] = {
    "cimu": (
        200.0,
        "accel_z is left out: the text of the paper that sigmatau was made from has no row of this axis in Table II.",
    ),
    "hg1700": (100.0, ""),
    "motionpak2": (100.0, ""),
}


def demo_command(
    *,
    unit: Literal["cimu", "hg1700", "motionpak2"] = "hg1700",
    output: Annotated[Path, Parameter(name=["--output", "-o"])] = Path("demo"),
    seed: int = 0,
    quiet: Annotated[bool, Parameter(name=["--quiet", "-q"], negative=())] = False,
) -> int:
    """Simulate two hours of a unit of El-Sheimy, Hou & Niu (2008), analyse the log, and compare the result with the truth.

    Parameters
    ----------
    unit
        The unit: cimu, navigation grade, Table II, 200 Hz, five axes; hg1700, tactical grade, Table IV, 100 Hz, six axes; or
        motionpak2, MEMS, Table V, 100 Hz, six axes.
    output
        Directory for the model, the log, the JSON and the report.
    seed
        Seed of the noise.
    quiet
        Print only errors on standard error.
    """
    try:
        output.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise DataError(f"{output}: cannot be created: {error.strerror or error}") from None
    text = resources.files("sigmatau.data").joinpath(f"{unit}.toml").read_text(encoding="utf-8")
    model_file, log = output / f"{unit}.toml", output / "static.csv"
    model_file.write_text(text, encoding="utf-8")
    model = NoiseModel.read(model_file)
    rate, note = _UNITS[unit]
    axes = {5: "five", 6: "six"}[len(model.channels)]
    with working(f"simulating {_HOURS:g} h at {rate:g} Hz, {axes} axes", quiet=quiet):
        record = simulate(model, duration=_HOURS * 3600, rate=rate, rng=seed)
    with working(f"writing {log}", quiet=quiet):
        write(record, log)
    with working(f"reading {log}", quiet=quiet):
        record = read(log)
    with working("computing Allan variances, fitting", quiet=quiet):
        analysis = analyze(record)
    page, result = output / "report.html", output / "result.json"
    with working(f"writing {page}", quiet=quiet):
        report(analysis, page, record=record, command=command_line())
    write_json(analysis.to_dict(), result)
    sys.stdout.write(f"{analysis.overview()}\n\n{_compare_with_truth(analysis, model)}\n")
    if note:
        say(note, quiet=quiet)
    say(f"written: {model_file}, {log}, {result}, {page}", quiet=quiet)
    return 0


def _compare_with_truth(analysis: Analysis, model: NoiseModel) -> str:
    rows = [("", "truth", "95 % interval", "", "read-off error")]
    for channel, truth in model.channels.items():
        fitted, read = analysis.fits[channel], analysis.read_off[channel]
        rows.append((channel, "", "", "", ""))
        for name, value in truth.items():
            factor = display_units(name, fitted.quantity, fitted.rate_unit)[0][1]
            _, interval, unit = fitted.texts(name)[0]
            read_off = f"{100 * (read[name].value / value - 1):+.1f} %" if name in read else "no region"
            rows.append((f"  {TERMS[name].label('signal')}", f"{value / factor:.5g}", interval, unit, read_off))
    return "\n".join(aligned(rows))
