"""``sigmatau deviation``: table, figure and JSON of a deviation other than Allan's."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from sigmatau._version import __version__
from sigmatau.analysis.options import AnalysisOptions
from sigmatau.cli.declared import DeclaredOptions, InMain, InMethod, InOutput, MayBeMinus, Quiet, Show, typed_options
from sigmatau.cli.options import (
    check_outputs,
    check_style,
    drawing,
    say,
    with_noise,
    working,
    write_figure,
    write_result,
)
from sigmatau.cli.reading import ReadingOptions, read_log
from sigmatau.estimators.deviation import Deviations, deviation
from sigmatau.estimators.deviation_kinds import Kind, estimator
from sigmatau.estimators.noise_identification import identify_noise
from sigmatau.findings.finding import damaged
from sigmatau.fitting.tables import deviation_table
from sigmatau.noise.shown import set_shown
from sigmatau.noise.terms import check_shown
from sigmatau.record.record import channel_quantities


@typed_options(AnalysisOptions, only=("taus", "threads"))
class DeviationSettings(DeclaredOptions):
    """Options of an analysis that apply to deviations other than Allan's."""


def deviation_command(
    log: Path,
    /,
    *,
    kind: Annotated[Kind, InMain],
    reading: ReadingOptions | None = None,
    settings: DeviationSettings | None = None,
    overlap: Annotated[Literal["full", "none"] | None, InMethod] = None,
    noise: Annotated[str | None, InMethod] = None,
    plot: Annotated[Path | None, InMain] = None,
    style: Annotated[Literal["screen", "paper"], InOutput] = "screen",
    json: Annotated[Path | None, MayBeMinus, InMain] = None,
    show: Show = None,
    quiet: Quiet = False,
) -> int:
    """Compute a deviation other than Allan's for every axis of a log of a sensor at rest.

    Parameters
    ----------
    log
        A log of any supported format, see sigmatau inspect.
    kind
        The estimator. time, time_total, mtie and tie_rms have units of angle and velocity. theo1 takes minutes for 1e6
        samples, modified_total, time_total and hadamard_total an hour; theobr and theoh take up to 50000 samples.
    overlap
        For the Hadamard deviation: all terms (full, the default), or disjoint clusters only (none).
    noise
        Noise term assumed for 95 % intervals: quantization, random_walk, bias_instability or rate_random_walk; or
        identified, the type of the noise at each averaging time by its lag-1 autocorrelation. Default: no intervals.
    plot
        Draw all axes: .png, .svg or .pdf.
    style
        Style of figures: screen, or paper, for the width of a column or a page of a paper.
    json
        Write the result as JSON, in SI; - writes it to standard output instead of the table.
    quiet
        Print only errors on standard error.
    """
    set_shown(show)
    check_style(style, plot)
    check_outputs([log], plot=plot, json=json)
    how = (settings or DeviationSettings()).arguments()
    record = read_log(log, reading, quiet=quiet)
    check_shown(channel_quantities(record), ["quantization" if estimator(kind).has_phase_unit else "bias_instability"])
    for finding in record.findings:
        say(str(finding), quiet=quiet)
    with working(f"computing {kind}", quiet=quiet) as done:
        deviations = deviation(record, kind=kind, overlap=overlap, progress=done, **how)
    names = with_noise({name: deviations[name].deviation for name in deviations}, "deviation", quiet=quiet)
    deviations = Deviations({name: deviations[name] for name in names})
    types = identify_noise(record) if noise == "identified" else None
    assumed = noise if types is None else types
    table = deviation_table(deviations, noise=assumed)
    if plot is not None:
        with drawing(plot, style, quiet=quiet):
            write_figure(deviations.plot(noise=assumed), plot)
    result: dict[str, object] = {"sigmatau": __version__, "noise": noise, "channels": deviations.to_dict(noise=assumed)}
    if types is not None:
        result["identified"] = types.to_dict()
    write_result(table, result, json)
    return damaged(record.findings)
