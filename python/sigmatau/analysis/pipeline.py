"""Analysis of a record: curves, fits and findings of all channels."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, ParamSpec, get_args

import numpy as np
from numpy.typing import ArrayLike

from sigmatau.analysis.result import WITHOUT_CURVE, Analysis
from sigmatau.errors import DataError, OptionError, RecordTooShortError
from sigmatau.estimators.allan import Counting, Curves, DeviationCurve, Overlap, kept_freedom
from sigmatau.estimators.deviation_kinds import TauGrid
from sigmatau.findings.finding import Finding, ranked
from sigmatau.findings.kinds.fit import ConstantChannel, NoMap
from sigmatau.findings.kinds.values import CoarseResolution, ImplausibleUnit
from sigmatau.findings.wording import words
from sigmatau.fitting.arguments import wanted_terms
from sigmatau.fitting.channel import fit_channel
from sigmatau.fitting.fit import fit
from sigmatau.fitting.mean_stability import MeanStability, mean_stability
from sigmatau.fitting.noise_fit import Fits, NoiseFit
from sigmatau.fitting.read_off_at import ReadOffAt
from sigmatau.fitting.read_off_lines import Span
from sigmatau.fitting.rounding import allowing_for_rounding
from sigmatau.noise.terms import TERMS
from sigmatau.quality import curve_checks
from sigmatau.quality.check import LOOKED_AT, LOOKED_AT_BOUNDED, Bandwidth, check_fits, examine
from sigmatau.quality.curves import curves_of
from sigmatau.quality.facts import facts_kept, in_threads
from sigmatau.quality.fit_findings import fit_findings, without_consequences
from sigmatau.quality.means import ChannelMean, channel_mean
from sigmatau.quality.samples.resolution import rounded
from sigmatau.quality.selection.exclusion import causes_to_keep, from_the_start
from sigmatau.quality.selection.exclusion import leave_out as leave_out_of
from sigmatau.quality.selection.rest import at_rest_only
from sigmatau.quality.selection.rest import rest as rest_of
from sigmatau.quality.selection.window import choose
from sigmatau.record import memory
from sigmatau.record.on_disk import loaded
from sigmatau.record.record import Provenance, Record
from sigmatau.record.streams import Stream, grid_text
from sigmatau.record.used import used_spans
from sigmatau.results import ByChannel, plain

if TYPE_CHECKING:
    from sigmatau.estimators.stability import DynamicAllan

P = ParamSpec("P")
Method = Literal["likelihood", "gls", "read-off"]
Long = Literal["auto", "exact", "strided"]


def _bounded_if_memory_lacks(function: Callable[P, Analysis]) -> Callable[P, Analysis]:
    """The analysis again in bounded memory, if `long` is "auto" and the memory does not suffice after all."""

    @functools.wraps(function)
    def call(*args: P.args, **options: P.kwargs) -> Analysis:
        try:
            return function(*args, **options)
        except MemoryError:
            record = args[0] if args else options["record"]
            whole = isinstance(record, Record) and all(stream.mask is None for stream in record.streams)
            if options.get("long", "auto") != "auto" or not whole:
                raise
        options["long"] = "strided"
        return function(*args, **options)

    return call


@_bounded_if_memory_lacks
@facts_kept()
def analyze(
    record: Record | object,
    *,
    taus: TauGrid | ArrayLike = "half",
    overlap: Overlap = "full",
    counting: Counting = "standard",
    method: Method = "likelihood",
    terms: Sequence[str] | None = None,
    tau_min: float | None = None,
    read_off_at: Mapping[str, Span] | None = None,
    long: Long = "auto",
    window: str | None = None,
    leave_out: str | Sequence[str] | None = None,
    keep: str | Sequence[str] = (),
    bandwidth: Bandwidth | None = None,
    at_rest: bool = False,
    stability: bool = False,
    notes: Mapping[str, str] | None = None,
    threads: int | None = None,
) -> Analysis:
    """Analyse a static record: Allan deviation and noise coefficients with intervals of every channel.

    Parameters
    ----------
    record : Record, str, Path or data frame
        A record from `sigmatau.read` or `Record.from_arrays`; or the path of a log that `sigmatau.read` reads without
        other arguments; or a data frame that `sigmatau.from_frame` accepts without other arguments.
    taus, overlap, counting
        See `sigmatau.allan`.
    method : {"likelihood", "gls", "read-off"}
        Method of the fit: maximum likelihood of the spectrum, with the filters, lines and processes that were found in the
        model; generalised least squares on the Allan variances (`sigmatau.fit`); or no fit. Coefficients are always read off
        the curve too.
        Channels with very few samples are fitted by least squares, which always uses overlapping clusters on half
        octaves, for any grid of the curve.
    terms : sequence of str, optional
        Terms that may be present, keys of `sigmatau.noise.terms.TERMS`. Default: all. A term that is left out is
        assumed to be absent; if it is present, the others are wrong.
    tau_min : float, optional
        Shortest averaging time of least squares. Default: found from the goodness of fit. [s]
    read_off_at : mapping of str to tuple of float, optional
        Averaging times between which lines are read off, by term, or by channel or sensor and term: ``{"random_walk": (1,
        10), "gyro_x.quantization": (0.01, 2)}``. Default: by the rules of `sigmatau.read_off`. [s]
    long : {"auto", "exact", "strided"}
        For clusters of more than 4096 samples: use every pair ("exact"), or in bounded memory only pairs that begin at
        every 64th sample or less often ("strided"), see `sigmatau.Accumulator`. "auto" is exact if the record fits in
        memory; otherwise it is strided, with a finding.
    window : str, optional
        Part of the record to analyse: ``"600s:7800s"`` from its beginning, or ``"most-stable=2h"``, see
        `sigmatau.quality.selection.window`.
    leave_out : str or sequence of str, optional
        Stretches to treat as missing, ``"720s:722s,1080s:1083s"`` from the beginning of the whole record, see
        `sigmatau.quality.selection.exclusion.leave_out`.
    keep : str or sequence of str
        Disturbances that are not left out: ``"dropouts"``, ``"saturation"``, ``"stuck"``, ``"interpolated"``, ``"copies"``,
        ``"start"``, ``"shocks"``, ``"spikes"``, or ``"all"``. Default: all are treated as missing, with a finding.
    bandwidth : mapping, optional
        The sensors' own bandwidth, see `sigmatau.check`.
    at_rest : bool
        Whether to analyse motion as noise. Otherwise a record that is not at rest has no coefficients, and a record
        that is partly at rest is cut to its part at rest, with a finding.
    stability : bool
        Whether to compute the dynamic Allan deviation of every channel, see `sigmatau.dynamic_allan`.
    notes : mapping of str to str, optional
        Information about the record for the result: ``{"serial number": "A123", "run": "day 1"}``. `compare_runs`
        groups results by these notes.
    threads
        See `sigmatau.allan`.

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
    fit_channel : a model of your own choice for one channel.
    fit_jointly : several runs together.

    Notes
    -----
    A channel that never changes is left out with a finding; the others are analysed. With missing samples, the curve
    uses clusters that are at least half complete. The fit accounts for missing samples. If more than 1 % are missing,
    nothing is read off.

    Examples
    --------
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    >>> analysis = st.analyze(st.simulate(model, duration=600, rate=10, rng=1))
    >>> walk = analysis["gyro_x"]["random_walk"]
    >>> walk.low < 1e-4 < walk.high
    True
    """
    if method not in get_args(Method):
        raise OptionError(f"{{option}} must be one of {', '.join(get_args(Method))}, not {method!r}", option="method")
    record = _record_of(record)
    wanted = None if terms is None else _terms_of(terms, method)
    if tau_min is not None:
        _refuse_time(tau_min, method)
    if long not in get_args(Long):
        raise OptionError(f"{{option}} must be one of {', '.join(get_args(Long))}, not {long!r}", option="long")
    if long == "strided" and (overlap, counting) != ("full", "standard"):
        raise OptionError("{option} 'strided' is for overlapping clusters in the standard counting", option="long")
    kept = causes_to_keep(keep)
    options = stated_settings(
        taus=taus, overlap=overlap, counting=counting, method=method, terms=wanted, tau_min=tau_min, long=long,
        window=window, leave_out=leave_out, keep=keep, bandwidth=bandwidth, at_rest=at_rest, read_off_at=read_off_at,
    )  # fmt: skip
    lines = ReadOffAt(read_off_at)
    lines.check(channel for stream in record.streams for channel in stream.channels)
    findings: list[Finding] = list(record.findings)
    record = from_the_start(record)
    if leave_out is not None:
        record, left = leave_out_of(record, leave_out)
        findings += left
    if window is not None:
        record, chosen = choose(record, window)
        findings += chosen
    if long != "strided":
        record = replace(record, streams=loaded(record.streams, threads))
    resting = rest_of(record, threads=threads)
    record, told = at_rest_only(record, resting, assumed=at_rest)
    findings += told
    moving = not resting.is_usable and not at_rest
    bounded = {stream.name for stream in record.streams if _in_bounded_memory(stream, long, threads)}
    looked_at = LOOKED_AT_BOUNDED if bounded else LOOKED_AT
    if not moving or resting.unit_in_doubt:
        cleaned, checks = examine(
            record, bandwidth=bandwidth, looked_at=looked_at, keep=kept, untouched=bounded, threads=threads
        )
        record = record if moving else cleaned
        findings += [finding for finding in checks if not moving or _doubts_unit(finding)]
    curves, fitted_on, without_curve = curves_of(
        record, taus=taus, overlap=overlap, counting=counting, long=long, bounded=bounded, threads=threads
    )
    findings += without_curve
    if not curves:
        lost = [finding for finding in findings if finding.code in WITHOUT_CURVE]
        reasons = (f"{', '.join(finding.channels)}: {words(finding).message}" for finding in lost)
        raise DataError("no channel is left to analyse: " + "; ".join(reasons))
    fits: dict[str, NoiseFit] = {}
    if method != "read-off" and not moving:
        coarse = {finding.channel: finding.details for finding in findings if rounded(finding)}
        fitted_on = curves | fitted_on

        def fitted(channel: str) -> tuple[NoiseFit, NoiseFit, DeviationCurve]:
            curve, on = curves[channel], fitted_on[channel]
            found = fit_channel(
                record, channel, method=method, curve=on, tau_min=tau_min, terms=wanted, threads=threads
            )
            if curve.overlap == "full":
                curve = _with_freedom(curve, found)
            final = found
            if isinstance(steps := coarse.get(channel), CoarseResolution):
                final = allowing_for_rounding(found, step=steps.step, noise=steps.noise)
            return found, final, curve

        for channel, (found, final, curve) in in_threads(fitted, tuple(curves), threads).items():
            fits[channel], curves[channel] = final, curve
            start = record.stream_of(channel).grid.lead
            findings += fit_findings(found, start=start, missing=_lost(record, channel), beside=findings)
        of_fits = check_fits(record, fits, looked_at=looked_at, found=findings, threads=threads)
        findings = [*without_consequences(findings, fits), *of_fits]
    means: Mapping[str, tuple[MeanStability, ...]] = {}
    if not moving:
        means = in_threads(
            lambda name: mean_stability(record.stream_of(name), name, fits.get(name)), tuple(curves), threads
        )
    maps: Mapping[str, DynamicAllan] = {}
    if stability:
        maps, without_map = _maps(record, tuple(curves), threads)
        findings += without_map
    return Analysis(
        source=record.provenance,
        findings=ranked(findings),
        curves=Curves(curves),
        fits=Fits(fits),
        read_off=ByChannel(
            {} if moving else {channel: lines.read(curve, fits.get(channel)) for channel, curve in curves.items()}
        ),
        grids={stream.name: grid_text(stream) for stream in record.streams},
        stability=ByChannel(maps),
        mean_stability={channel: found for channel, found in means.items() if found},
        rest=resting,
        rate_source=record.streams[0].grid.source,
        used={channel: used_spans(record, channel) for channel in curves},
        means={} if moving else _means(record, tuple(curves), fits),
        options=options,
        notes={str(name): str(text) for name, text in (notes or {}).items()},
    )


def stated_settings(**options: Any) -> dict[str, Any]:  # noqa: ANN401  of any kind
    """The options that are not the default, as plain values."""
    return plain(None, **{name: value for name, value in options.items() if not _is_default(name, value)})


_DEFAULTS = {"taus": "half", "overlap": "full", "counting": "standard", "method": "likelihood", "long": "auto"}


def _is_default(name: str, value: object) -> bool:
    if value is None or value is False:
        return True
    if isinstance(value, str):
        return value == _DEFAULTS.get(name, "")
    return isinstance(value, Sequence | Mapping) and not value


def _means(record: Record, channels: Sequence[str], fits: Mapping[str, NoiseFit]) -> dict[str, ChannelMean]:
    found = {name: channel_mean(record.stream_of(name), name, fits.get(name)) for name in channels}
    return {name: mean for name, mean in found.items() if mean is not None}


def of_curves(
    curves: Mapping[str, DeviationCurve],
    *,
    source: Provenance = Provenance(),  # noqa: B008  frozen
    findings: Sequence[Finding] = (),
    grids: Mapping[str, str] | None = None,
    method: Method = "gls",
    fitted_on: Mapping[str, DeviationCurve] | None = None,
) -> Analysis:
    """Analyse existing overlapped curves, such as those of an `Accumulator`.

    `fitted_on`: by channel, the curve that is fitted in place of the one that is shown.

    Raises
    ------
    DataError
        If all curves are 0.
    """
    found = list(findings)
    kept: dict[str, DeviationCurve] = {}
    fits: dict[str, NoiseFit] = {}
    for channel, curve in curves.items():
        if not curve.adev.max() > 0:
            constant = ConstantChannel(samples=curve.n)
            found.append(Finding(details=constant, severity="error", channels=(channel,)))
            continue
        kept[channel] = curve
        if method != "read-off":
            fits[channel] = fit((fitted_on or {}).get(channel, curve))
            kept[channel] = _with_freedom(curve, fits[channel])
            found += fit_findings(fits[channel])
    if kept:
        found += curve_checks.strided(kept)
    if not kept:
        raise DataError("no channel is left to analyse: all channels are constant")
    return Analysis(
        source=source,
        findings=ranked(found),
        curves=Curves(kept),
        fits=Fits(fits),
        read_off={channel: ReadOffAt(None).read(curve, fits.get(channel)) for channel, curve in kept.items()},
        grids=dict(grids or {}),
    )


def _doubts_unit(finding: Finding) -> bool:
    """Whether a finding says that a unit is wrong, and not that the file states it."""
    return isinstance(finding.details, ImplausibleUnit) and not finding.details.by_file


def _with_freedom(curve: DeviationCurve, fitted: NoiseFit) -> DeviationCurve:
    """The curve with degrees of freedom by the model; with missing samples in proportion to the pairs that are left."""
    edf = fitted.degrees_of_freedom(m=curve.m)
    return replace(curve, edf=None if edf is None else kept_freedom(curve, edf))


def _record_of(given: object) -> Record:
    """The record of a path or a data frame; raises `TypeError` for what is none."""
    if isinstance(given, Record):
        return given
    if isinstance(given, str | Path):
        from sigmatau.io.read import read

        return read(given)
    if isinstance(given, Curves) or not (hasattr(given, "columns") or isinstance(given, Mapping)):
        more = "; curves that are there already go to sigmatau.analysis.of_curves" if isinstance(given, Curves) else ""
        more = (
            "; an array has channels: sigmatau.Record.from_arrays(rate=100, gyro=x)" if hasattr(given, "ndim") else more
        )
        raise TypeError(
            f"`record` must be a Record, see sigmatau.read, a path or a data frame, not a {type(given).__name__}{more}"
        )
    from sigmatau.io.read.frame import from_frame

    return from_frame(given)


def _maps(
    record: Record, channels: Sequence[str], threads: int | None
) -> tuple[dict[str, DynamicAllan], list[Finding]]:
    """The dynamic Allan deviations, and findings of channels that are too short for one."""
    from sigmatau.estimators.stability import dynamic_allan

    maps: dict[str, DynamicAllan] = {}
    without_map = []
    for channel in channels:
        try:
            maps[channel] = dynamic_allan(record, channel, threads=threads)
        except RecordTooShortError as error:
            no_map = NoMap(samples=error.got, needed=error.need)
            without_map.append(Finding(details=no_map, severity="info", channels=(channel,)))
    return maps, without_map


def _in_bounded_memory(stream: Stream, long: Long, threads: int | None) -> bool:
    return long == "strided" or (long == "auto" and stream.mask is None and not memory.fits(stream, threads))


def _lost(record: Record, channel: str) -> float:
    """Share of missing samples of a channel."""
    stream = record.stream_of(channel)
    return 0.0 if stream.mask is None else float(stream.mask[:, stream.channels.index(channel)].mean())


def _terms_of(terms: object, method: Method) -> list[str]:
    """Check the terms of the fits."""
    if method == "read-off":
        raise OptionError("{option} are of a fit: nothing is fitted if coefficients are read off", option="terms")
    wanted = wanted_terms(terms)
    return [name for name in TERMS if name in wanted]


def _refuse_time(tau_min: float, method: Method) -> None:
    """Check the shortest averaging time of a fit."""
    if isinstance(tau_min, bool) or not (isinstance(tau_min, int | float | np.number) and 0 < tau_min < np.inf):
        raise OptionError(f"{{option}} must be a positive number of seconds, not {tau_min!r}", option="tau_min")
    if method != "gls":
        raise OptionError("{option} needs least squares: --method gls", option="tau_min")
