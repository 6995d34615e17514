"""analyze(): the whole way from a record to its coefficients, walked once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from sigmatau._version import __version__
from sigmatau.errors import DataError, OptionError, RecordTooShortError
from sigmatau.estimators.accumulator import accumulate, strided_sizes
from sigmatau.estimators.allan import (
    Counting,
    Curves,
    DeviationCurve,
    Overlap,
    TauGrid,
    allan,
    channel_curve,
    cluster_sizes,
    refuse_missing,
)
from sigmatau.estimators.stability import DynamicAllan, dynamic_allan
from sigmatau.exporting.choices import Choices
from sigmatau.exporting.export import export
from sigmatau.exporting.source import Source
from sigmatau.findings.finding import Finding, by_severity
from sigmatau.fitting.fit import fit
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.fitting.read_off import ReadOff, read_off
from sigmatau.fitting.tables import fit_table, read_off_table
from sigmatau.model.noise_model import NoiseModel
from sigmatau.noise.terms import avar
from sigmatau.quality import curve_checks as curve_findings
from sigmatau.quality.angle_noise import angle_noise, untold
from sigmatau.quality.causes import one_cause
from sigmatau.quality.check import LOOKED_AT, Bandwidth, check, check_fits, with_fits
from sigmatau.quality.restated import past_filter
from sigmatau.quality.samples.resolution import too_coarse
from sigmatau.quality.samples.spikes import mask_spikes
from sigmatau.quality.selection.exclusion import from_the_start
from sigmatau.quality.selection.exclusion import leave_out as leave_out_of
from sigmatau.quality.selection.selection_bias import bias_finding
from sigmatau.quality.selection.window import choose
from sigmatau.record import memory
from sigmatau.record.record import Provenance, Record
from sigmatau.record.streams import Stream, grid_text
from sigmatau.results import Printed

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Analysis", "Long", "Method", "Spikes", "analyze", "of_curves"]

Method = Literal["gls", "read-off"]
Long = Literal["auto", "exact", "strided"]
Spikes = Literal["keep", "mask"]

SCHEMA = 1
"""Version of the JSON form; a JSON Schema of it is in sigmatau/schema."""


# Quantization noise rules if it makes so much of the variance at so many samples; with nothing beside it there is nothing
# to gain.
_AT, _RULES, _LEAST_BESIDE = 8, 0.9, 2

_LEFT_OUT = ("out_of_range", "constant_channel", "too_few_samples")  # findings of channels that have no curve

_TOO_COARSE = "the step of the numbers is too coarse against the noise: what rounding adds is not known"

_LOOKED_AT_BOUNDED = 1 << 20  # samples, of a record that does not fit in memory


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Analysis(Printed):
    """What a record shows.

    Attributes
    ----------
    source : Provenance
    findings : tuple of Finding
        What is wrong with the record, or should be known, before a number is trusted.
    curves : Curves
        Allan deviation by channel; channels that could not be analysed are absent and have a finding.
    fits : mapping of str to NoiseFit
        Coefficients with intervals, by channel; empty if they were only read off.
    read_off : mapping of str to ReadOff
        Coefficients by the paper's method, by channel.
    grids : mapping of str to str
        Samples, rate and length of each channel, in words.
    stability : mapping of str to DynamicAllan
        How the Allan deviation changes over the record, by channel; empty if it was not asked for.
    """

    source: Provenance
    findings: tuple[Finding, ...]
    curves: Curves
    fits: Mapping[str, NoiseFit]
    read_off: Mapping[str, ReadOff]
    grids: Mapping[str, str]
    stability: Mapping[str, DynamicAllan] = field(default_factory=dict)

    def to_dict(self) -> dict[str, Any]:
        """The stable JSON form, schema 1: plain values, no NaN."""
        return {
            "schema": SCHEMA,
            "sigmatau": __version__,
            "source": self.source.to_dict(),
            "findings": [finding.to_dict() for finding in self.findings],
            "channels": {
                channel: {
                    "quantity": curve.quantity,
                    "sample_rate_hz": 1 / curve.tau0,
                    "samples": curve.n,
                    "curve": curve.to_dict(),
                    "read_off": self.read_off[channel].to_dict(),
                    **({"fit": self.fits[channel].to_dict()} if channel in self.fits else {}),
                    **({"stability": self.stability[channel].to_dict()} if channel in self.stability else {}),
                }
                for channel, curve in self.curves.items()
            },
        }

    @property
    def model(self) -> NoiseModel:
        """The noise model of the channels that have one; see `NoiseModel.from_result`. Raises `DataError` if none has."""
        return NoiseModel.from_result(self.to_dict())

    def plot(self) -> Figure:
        """Draw the curves of all channels with their bands and what was fitted or read; one panel a stream."""
        from sigmatau.plot.curves import draw_analysis

        return draw_analysis(self.curves, self.read_off, self.fits)

    def plot_stability(self) -> Figure:
        """Draw how the deviation of each channel changes over the record; it must have been asked for.

        Raises
        ------
        OptionError
            If it was not.
        """
        if not self.stability:
            raise OptionError(
                "no dynamic Allan deviation was asked for: analyze(…, stability=True)", option="stability"
            )
        from sigmatau.plot.stability import draw_all

        return draw_all(self.stability)

    def export(self, *, to: str, path: str | Path | None = None, choices: Choices | None = None) -> str | bytes:
        """Write what was fitted for another program; see `sigmatau.export`.

        The sampling rate is that of the record if `choices` has none.
        """
        return export(self.to_source(), to=to, path=path, choices=choices)

    def to_source(self) -> Source:
        """What an export takes of it: the model, the sampling rates, and what was found of a filter."""
        return Source.of_result(self.to_dict())

    def summary(self) -> str:
        """The grids and the table of coefficients, as the command line prints them."""
        return "\n".join([*self.grids.values(), "", self.coefficients()])

    def coefficients(self) -> str:
        """The table of coefficients."""
        return fit_table(self.fits, self.read_off) if self.fits else read_off_table(self.read_off)

    def __repr__(self) -> str:
        return "\n".join([self.summary(), *map(str, self.findings)])


def analyze(
    record: Record,
    *,
    taus: TauGrid | ArrayLike = "half",
    overlap: Overlap = "full",
    counting: Counting = "standard",
    method: Method = "gls",
    tau_min: float | None = None,
    long: Long = "auto",
    window: str | None = None,
    leave_out: str | Sequence[str] | None = None,
    spikes: Spikes = "keep",
    bandwidth: Bandwidth | None = None,
    stability: bool = False,
    threads: int | None = None,
) -> Analysis:
    """Analyse a static record: Allan curves of every channel, and the coefficients with their intervals.

    Parameters
    ----------
    record : Record
        From `sigmatau.read` or `Record.from_arrays`.
    taus, overlap, counting, threads
        See `sigmatau.allan`.
    method : {"gls", "read-off"}
        Fit the coefficients (`sigmatau.fit`) beside reading them off, or read off only. A fit is always made with
        overlapping clusters on half octaves, whatever the curve has; on eighths of an octave where quantization noise
        rules the short times, because the terms under it are then found with up to a third less variance.
    tau_min : float, optional
        Shortest averaging time of the fits: beyond a filter or a line, as findings advise. Default: found by the misfit. [s]
    long : {"auto", "exact", "strided"}
        Clusters of more than 4096 samples: every pair, or in bounded memory those that begin at every 64th sample or
        less often, see `sigmatau.Accumulator`. "auto" takes every pair if memory is enough, and says so if it is not.
    window : str, optional
        Which part of the record: ``"600s:7800s"`` from its beginning, or ``"most-stable=2h"``, see `sigmatau.window`.
    leave_out : str or sequence of str, optional
        Stretches to take for missing, ``"720s:722s,1080s:1083s"`` from the beginning of the record (of all of it, if there
        is a window too), see `sigmatau.quality.selection.exclusion.leave_out`.
    spikes : {"keep", "mask"}
        Take single samples that no noise makes for missing.
    bandwidth : mapping, optional
        The sensors' own bandwidth, see `sigmatau.check`.
    stability : bool
        Dynamic Allan deviation of every channel too, see `sigmatau.dynamic_allan`.

    Returns
    -------
    Analysis

    Raises
    ------
    DataError
        If the record is too short, no channel is left, or samples are missing where `long` is "strided".
    OptionError
        For times or grids that cannot be.

    Notes
    -----
    A channel that never changes is left out with a finding; the others are analysed. Where samples are missing, the curve is
    that of clusters at least half full; the fit and what is read off take account of it.
    """
    if method not in ("gls", "read-off"):
        raise OptionError(f"{{option}} must be 'gls' or 'read-off', not {method!r}", option="method")
    if not isinstance(record, Record):
        hint = (
            "; curves that are there already go to sigmatau.analysis.of_curves" if isinstance(record, Mapping) else ""
        )
        raise TypeError(f"`record` must be a Record, see sigmatau.read, not a {type(record).__name__}{hint}")
    if tau_min is not None:
        _refuse_time(tau_min, method)
    if long not in get_args(Long):
        raise OptionError(f"{{option}} must be one of {', '.join(get_args(Long))}, not {long!r}", option="long")
    if long == "strided" and (overlap, counting) != ("full", "standard"):
        raise OptionError("{option} 'strided' is for overlapping clusters in the standard counting", option="long")
    if spikes not in get_args(Spikes):
        raise OptionError(f"{{option}} must be one of {', '.join(get_args(Spikes))}, not {spikes!r}", option="spikes")
    findings: list[Finding] = list(record.findings)
    record = from_the_start(record)
    if leave_out is not None:
        record, left = leave_out_of(record, leave_out)
        findings += left
    whole = record
    if window is not None:
        record, chosen = choose(record, window)
        findings += chosen
    if spikes == "mask":
        record, masked = mask_spikes(record)
        findings += masked
    bounded = {stream.name for stream in record.streams if _in_bounded_memory(stream, long, threads)}
    looked_at = _LOOKED_AT_BOUNDED if bounded else LOOKED_AT
    findings += check(record, bandwidth=bandwidth, looked_at=looked_at)
    curves: dict[str, DeviationCurve] = {}
    found: Mapping[str, DeviationCurve]
    fitted_on: dict[str, DeviationCurve] = {}
    for stream in record.streams:
        if stream.quantity == "temperature":  # it says why the sensors drift; its own noise is nobody's question
            continue
        if stream.mask is not None and long == "strided":
            refuse_missing(stream, "bounded memory, `long` 'strided',", instead="take `long` 'exact'")
        if stream.name in bounded:
            if (overlap, counting) != ("full", "standard"):
                raise DataError(f"{stream.name}: there is not enough memory for this choice of overlap and counting")
            found, for_fit = _strided(stream, taus)
            fitted_on |= for_fit
            why = "" if long == "strided" else f"{stream.grid.n} samples do not fit in memory: "
            findings += curve_findings.strided(found, stream.name, why)
        else:
            found, none_left = _curves(stream, taus, overlap, counting, threads)
            findings += none_left
        for channel, curve in found.items():
            if not curve_findings.LEAST < curve.avar.max() < curve_findings.LARGEST and curve.avar.max() > 0:
                findings.append(curve_findings.beyond(curve))
            elif curve.adev.max() > curve_findings.rounding(stream, channel):
                curves[channel] = curve
            else:
                findings.append(curve_findings.constant(stream, channel))
    if not curves:
        reasons = (f"{finding.channel}: {finding.message}" for finding in findings if finding.code in _LEFT_OUT)
        raise DataError("no channel is left to analyse: " + "; ".join(reasons))
    fits: dict[str, NoiseFit] = {}
    if method == "gls":
        doubtful = {finding.channel for finding in findings if too_coarse(finding)}
        for channel, curve in curves.items():

            def again(least: float | None, curve: DeviationCurve = curve) -> NoiseFit:
                on = fitted_on.get(curve.channel)
                return _fit(record, curve, threads, tau_min=least) if on is None else fit(on, tau_min=least)

            fits[channel] = again(tau_min)
            if tau_min is None:
                fits[channel] = past_filter(record.stream_of(channel), fits[channel], findings, again)
            if curve.overlap == "full":
                curves[channel] = replace(curve, edf=fits[channel].degrees_of_freedom(m=curve.m))
            if channel in doubtful:  # a finding says so, and what the curve says of its fit is no other fault
                fits[channel] = fits[channel].doubted(_TOO_COARSE)
            else:
                findings += curve_findings.of_fit(fits[channel], missing=_lost(record, channel))
            if said := angle_noise(record, fits[channel], threads=threads):
                findings.append(said)
        findings = with_fits(record, fits, findings, looked_at=looked_at)
        findings += check_fits(record, fits, looked_at=looked_at, found=findings)
        if window is not None:
            findings += bias_finding(whole, window, fits)
    findings = one_cause(findings, list(curves), max(stream.grid.duration for stream in record.streams))
    maps: dict[str, DynamicAllan] = {}
    for channel in curves if stability else ():
        try:
            maps[channel] = dynamic_allan(record, channel, threads=threads)
        except RecordTooShortError as error:
            findings.append(Finding(code="no_map", severity="info", channel=channel, message=f"no map: {error}"))
    return Analysis(
        source=record.provenance,
        findings=by_severity(findings),
        curves=Curves(curves),
        fits=fits,
        read_off={channel: read_off(curve) for channel, curve in curves.items()},
        grids={stream.name: grid_text(stream) for stream in record.streams},
        stability=maps,
    )


def of_curves(
    curves: Mapping[str, DeviationCurve],
    *,
    source: Provenance = Provenance(),  # noqa: B008  frozen
    findings: Sequence[Finding] = (),
    grids: Mapping[str, str] | None = None,
    method: Method = "gls",
) -> Analysis:
    """Fit and read off overlapped curves that are there already, such as those of an `Accumulator`.

    Raises
    ------
    DataError
        If no curve is above 0.
    """
    said = list(findings)
    kept: dict[str, DeviationCurve] = {}
    fits: dict[str, NoiseFit] = {}
    for channel, curve in curves.items():
        if not curve.adev.max() > 0:
            message = f"every one of {curve.n} samples is the same"
            said.append(Finding(code="constant_channel", severity="error", channel=channel, message=message))
            continue
        kept[channel] = curve
        if method == "gls":
            fits[channel] = fit(curve)
            kept[channel] = replace(curve, edf=fits[channel].degrees_of_freedom(m=curve.m))
            said += curve_findings.of_fit(fits[channel])
        said += filter(None, [untold(curve)])
    if kept:
        said += curve_findings.strided(kept, None)
    if not kept:
        raise DataError("no channel is left to analyse: every one of them never changes")
    return Analysis(
        source=source,
        findings=by_severity(said),
        curves=Curves(kept),
        fits=fits,
        read_off={channel: read_off(curve) for channel, curve in kept.items()},
        grids=dict(grids or {}),
    )


def _curves(
    stream: Stream, taus: TauGrid | ArrayLike, overlap: Overlap, counting: Counting, threads: int | None
) -> tuple[Mapping[str, DeviationCurve], list[Finding]]:
    """The curves, and what is to be said of channels with so many missing samples that there is none."""
    options: dict[str, Any] = {"taus": taus, "overlap": overlap, "counting": counting, "threads": threads}
    if stream.mask is None:
        return allan(Record(streams=(stream,)), **options), []
    found: dict[str, DeviationCurve] = {}
    said = []
    for channel in stream.channels:
        try:
            found.update(allan(Record(streams=(stream.only(channel),)), **options))
        except RecordTooShortError as error:
            said.append(Finding(code="too_few_samples", severity="error", channel=channel, message=str(error)))
    return found, said


def _in_bounded_memory(stream: Stream, long: Long, threads: int | None) -> bool:
    return long == "strided" or (long == "auto" and stream.mask is None and not memory.fits(stream, threads))


def _lost(record: Record, channel: str) -> float:
    """The share of the samples of a channel that is missing."""
    stream = record.stream_of(channel)
    return 0.0 if stream.mask is None else float(stream.mask[:, stream.channels.index(channel)].mean())


def _strided(stream: Stream, taus: TauGrid | ArrayLike) -> tuple[dict[str, DeviationCurve], dict[str, DeviationCurve]]:
    """The curves asked for and those to fit, from one pass over the samples."""
    if isinstance(taus, str) and taus == "all":
        raise OptionError("{option} 'all' needs the whole record in memory; take a grid", option="taus")
    n, tau0 = stream.grid.n, stream.grid.tau0
    wanted = strided_sizes(cluster_sizes(taus, n=n, tau0=tau0))
    half = strided_sizes(cluster_sizes("half", n=n, tau0=tau0))
    curves = accumulate(stream, taus=np.union1d(wanted, half) * tau0)
    only = [{channel: curve.at(sizes) for channel, curve in curves.items()} for sizes in (wanted, half)]
    return only[0], only[1]


def _refuse_time(tau_min: float, method: Method) -> None:
    """Refuse what is no shortest averaging time, or where nothing is fitted."""
    if isinstance(tau_min, bool) or not (isinstance(tau_min, int | float | np.number) and 0 < tau_min < np.inf):
        raise OptionError(f"{{option}} must be a positive number of seconds, not {tau_min!r}", option="tau_min")
    if method != "gls":
        raise OptionError("{option} is of a fit, which method 'read-off' does not make", option="tau_min")


def _fit(record: Record, curve: DeviationCurve, threads: int | None, *, tau_min: float | None) -> NoiseFit:
    """On half octaves with overlap, whatever the curve has; on eighths where quantization rules."""
    half = cluster_sizes("half", n=curve.n - (curve.counting == "paper"), tau0=curve.tau0)
    if curve.overlap != "full" or not np.array_equal(half, curve.m):
        curve = channel_curve(record, curve.channel, taus="half", counting=curve.counting, threads=threads)
    fitted = fit(curve, tau_min=tau_min)
    noise = fitted.observed.get("quantization")
    if noise is None or len(fitted.observed) < _LEAST_BESIDE:
        return fitted
    share = avar("quantization", noise, m=_AT, tau0=curve.tau0) / fitted.avar(m=_AT)
    if float(share[0]) < _RULES:
        return fitted
    eighths = channel_curve(record, curve.channel, taus="eighth", counting=curve.counting, threads=threads)
    return fit(eighths, tau_min=tau_min)
