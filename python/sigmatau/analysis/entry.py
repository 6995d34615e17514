"""Public functions of this package: `analyze` for a record, and `of_curves` for existing curves."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from sigmatau.analysis import pipeline
from sigmatau.analysis.options import AnalysisOptions, Method
from sigmatau.analysis.result import Analysis
from sigmatau.analysis.stages import add_degrees_of_freedom, read_off_curves
from sigmatau.errors import DataError
from sigmatau.estimators.allan import Curves, DeviationCurve
from sigmatau.findings.curves import ConstantChannel
from sigmatau.findings.finding import Finding, ranked
from sigmatau.fitting.fit import fit
from sigmatau.fitting.noise_fit import Fits, NoiseFit
from sigmatau.fitting.read_off_at import ReadOffAt
from sigmatau.options import keywords_of
from sigmatau.quality.curves import strided
from sigmatau.quality.fit_findings import fit_findings
from sigmatau.record.record import Provenance, Record
from sigmatau.record.sampling import Sampling


@keywords_of(AnalysisOptions)
def analyze(record: Record | object, options: AnalysisOptions) -> Analysis:
    """Analyse a static record: Allan deviation and noise coefficients with intervals of every channel.

    Parameters
    ----------
    record : Record, str, Path or data frame
        A record from `sigmatau.read` or `Record.from_arrays`; or the path of a log that `sigmatau.read` reads without
        other arguments; or a data frame that `sigmatau.from_frame` accepts without other arguments.

    Returns
    -------
    Analysis

    Raises
    ------
    DataError
        If no channel can be analysed, or if samples are missing and `long` is "strided".
    OptionError
        For invalid options.

    See Also
    --------
    read : the record of a file.
    fit_channel : fits a model that you choose to one channel.
    fit_jointly : fits several runs together.

    Notes
    -----
    A channel that never changes is left out with a finding; the others are analysed. With missing samples, the curve uses
    clusters that are at least half complete. The fit accounts for missing samples. If more than 1 % are missing, no
    coefficient is read off.

    Examples
    --------
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    >>> analysis = st.analyze(st.simulate(model, duration=600, rate=10, rng=1))
    >>> walk = analysis["gyro_x"]["random_walk"]
    >>> walk.low < 1e-4 < walk.high
    True
    """
    return pipeline.run(record, options)


def analyze_in_stages(record: Record, options: AnalysisOptions, *, begin: Callable[[str], None]) -> Analysis:
    """Analyse a record like `analyze`, for callers that show the progress.

    Parameters
    ----------
    record : Record
    options : AnalysisOptions
    begin : callable
        Called with the name of each stage before the stage starts, in the order of `STAGE_NAMES`.

    See Also
    --------
    analyze : describes the result and the errors.
    """
    return pipeline.run(record, options, begin=begin)


STAGE_NAMES = tuple(stage.__name__ for stage in pipeline.STAGES)
"""Names of the stages of an analysis."""


def of_curves(
    curves: Mapping[str, DeviationCurve],
    *,
    source: Provenance = Provenance(),  # noqa: B008  frozen
    findings: Sequence[Finding] = (),
    grids: Mapping[str, Sampling] | None = None,
    method: Method = "gls",
    fitted_on: Mapping[str, DeviationCurve] | None = None,
) -> Analysis:
    """Analyse existing overlapped curves, such as those of an `Accumulator`.

    `fitted_on` maps channels to curves that are fitted in place of those in `curves`.

    Raises
    ------
    DataError
        If all curves are 0.
    """
    all_findings, usable = list(findings), dict[str, DeviationCurve]()
    fits: dict[str, NoiseFit] = {}
    for channel, curve in curves.items():
        if not curve.adev.max() > 0:
            constant = ConstantChannel(samples=curve.n)
            all_findings.append(Finding(details=constant, severity="error", channels=(channel,)))
            continue
        usable[channel] = curve
        if method != "read-off":
            fits[channel] = fit((fitted_on or {}).get(channel, curve))
            usable[channel] = add_degrees_of_freedom(curve, fits[channel])
            all_findings += fit_findings(fits[channel])
    if not usable:
        raise DataError("no channel is left to analyse: all channels are constant")
    return Analysis(
        source=source,
        findings=ranked([*all_findings, *strided(usable)]),
        curves=Curves(usable),
        fits=Fits(fits),
        read_off=read_off_curves(usable, fits, ReadOffAt(None)),
        grids=dict(grids or {}),
    )
