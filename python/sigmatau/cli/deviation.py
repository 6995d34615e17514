"""``sigmatau deviation``: table, figure and JSON of another deviation than Allan's."""

from __future__ import annotations

import json as json_module
import sys
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter

from sigmatau._version import __version__
from sigmatau.cli.analyze import FIGURE_ENDINGS
from sigmatau.cli.options import Reading, averaging_times, check_output, read_log, refuse_same, say, working
from sigmatau.estimators.deviation import Deviations, deviation
from sigmatau.estimators.deviation_kinds import Kind
from sigmatau.findings.finding import damaged
from sigmatau.fitting.tables import deviation_table
from sigmatau.io.write import atomic


def deviation_command(
    log: Path,
    /,
    *,
    kind: Kind,
    reading: Reading | None = None,
    taus: str = "half",
    overlap: Literal["full", "none"] | None = None,
    noise: str | None = None,
    plot: Path | None = None,
    json: Annotated[Path | None, Parameter(allow_leading_hyphen=True)] = None,
    threads: int | None = None,
    quiet: Annotated[bool, Parameter(name=["--quiet", "-q"], negative=())] = False,
) -> int:
    """Compute another deviation than Allan's for every axis of a log of a sensor at rest.

    Parameters
    ----------
    log
        A log of any supported format, see sigmatau inspect.
    kind
        The estimator. time, mtie and tie_rms have units of angle and velocity. theo1 takes minutes for 1e6 samples.
    taus
        Averaging times: octave, half, quarter, eighth (of an octave), or a list in seconds, 0.1,1,10.
    overlap
        For the Hadamard deviation: all terms (full), or disjoint clusters only (none).
    noise
        Noise term assumed for 95 % intervals: quantization, random_walk, bias_instability or rate_random_walk. Default: no
        intervals.
    plot
        Draw all axes: .png, .svg or .pdf.
    json
        Write the result as JSON; - writes it to standard output instead of the table.
    threads
        Number of threads (default: all cores). The result does not depend on it.
    quiet
        Print only errors on standard error.
    """
    as_text = json is not None and str(json) == "-"
    check_output(plot, FIGURE_ENDINGS, "plot")
    check_output(None if as_text else json, (), "json")
    refuse_same(log, plot=plot, json=None if as_text else json)
    averaging: Any = averaging_times(taus)
    record = read_log(log, reading, quiet=quiet)
    for finding in record.findings:
        say(str(finding), quiet=quiet)
    with working(f"computing {kind}", quiet=quiet) as done:
        found = deviation(record, kind=kind, taus=averaging, overlap=overlap, threads=threads, progress=done)
        table = deviation_table(found, noise=noise)
    text = _json_text(found, noise=noise)
    if plot is not None:
        with working(f"drawing {plot}", quiet=quiet):
            _write_figure(found, plot, noise=noise)
    if as_text:
        sys.stdout.write(text)
        return damaged(record.findings)
    if json is not None:
        with atomic(json) as temporary:
            temporary.write_text(text, encoding="utf-8")
    sys.stdout.write(f"{table}\n")
    return damaged(record.findings)


def _json_text(found: Deviations, *, noise: str | None) -> str:
    result = {"sigmatau": __version__, "noise": noise, "channels": found.to_dict(noise=noise)}
    return json_module.dumps(result, indent=1, allow_nan=False, ensure_ascii=False) + "\n"


def _write_figure(found: Deviations, path: Path, *, noise: str | None) -> None:
    from sigmatau.plot.curves import save

    figure = found.plot(noise=noise)
    with atomic(path) as temporary:
        save(figure, str(temporary))
