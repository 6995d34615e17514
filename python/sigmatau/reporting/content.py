"""Content of a report: the texts of an analysis, and the numbers of its charts."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from datetime import UTC, datetime
from typing import Any

from sigmatau._version import __version__
from sigmatau.analysis import Analysis
from sigmatau.digits import round_to_error, two_digits
from sigmatau.errors import DataError, OptionError
from sigmatau.estimators.allan import DeviationCurve, allan
from sigmatau.exporting.export import prepare
from sigmatau.exporting.targets import NAMES
from sigmatau.findings.finding import Finding, Words
from sigmatau.findings.phrases import short_axes
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.fitting.overview import Overview, dominant_terms, main_coefficients
from sigmatau.fitting.read_off import ReadOffCoefficient
from sigmatau.frozen import frozen
from sigmatau.noise.terms import TERMS, display_units
from sigmatau.quality.selection.exclusion import from_the_start
from sigmatau.record.mask import only_used
from sigmatau.record.record import QUANTITIES, Record, TemperatureRange
from sigmatau.record.sampling import sampling_text
from sigmatau.record.streams import Stream
from sigmatau.reporting.certificate import Certificate
from sigmatau.reporting.charts import LONGEST, collect_charts
from sigmatau.results import duration_text, noted_unit, printable, seconds

_LARGEST_FILE = 20_000  # longest file for a filter that is shown [characters]
# targets that approximate flicker noise by states, which takes as long as the rest of a report
_SLOW = ("state-space",)
_MAX_SPANS = 20  # largest number of spans of a finding that are listed
_SAME_AVAR = 1e-6  # relative difference of Allan variances of the same samples, summed in another order


@frozen
class Coefficients:
    """The table of one channel."""

    channel: str
    verdict: str  # verdict on the fit or the read-off, with its p-value
    trust: str  # "good", "partial", "poor"; empty without a fit
    rows: tuple[tuple[str, str, str, str], ...]  # term, value or limit, interval or reason, unit
    notes: tuple[str, ...]


@frozen
class FindingText:
    """One finding in words."""

    severity: str
    axes: str
    message: str
    action: str
    where: str  # stretches of the record


@frozen
class FilterFile:
    """The values for one filter or simulator."""

    target: str
    text: str


@frozen
class Content:
    """A report without its form."""

    title: str  # the unit, if a note names it, or the file
    file_name: str
    headline: str
    verdict: str  # of the record: "at_rest" …
    date: str
    made_by: str
    notes: tuple[tuple[str, str], ...]  # of the user: serial number, operator …
    overview: Overview | None  # the dominant coefficients; None without a fit
    findings: tuple[FindingText, ...]
    coefficients: tuple[Coefficients, ...]
    legend: str  # explanation of the numbers
    level: str  # confidence level of the intervals, "95 %"; empty without a fit
    done: tuple[tuple[str, str], ...]
    files: tuple[FilterFile, ...]
    no_files: str  # why there are no files
    charts: Mapping[str, Any]  # plain values, see `sigmatau.reporting.charts`
    recorded: str = ""  # start of the record by the clock of the log; empty if it has no date
    certificate: Certificate | None = None  # page 1, which a laboratory signs


def collect_content(
    analysis: Analysis,
    record: Record | None,
    *,
    notes: Mapping[str, str] | None = None,
    command: str | None = None,
    date: datetime | None = None,
    targets: Iterable[str] | None = None,
    certificate: Certificate | None = None,
) -> Content:
    """Collect the content of a report.

    Parameters
    ----------
    analysis : Analysis
    record : Record or None
        As it was given to the analysis; without it the report has no densities, no time series and no map.
    notes : mapping of str to str, optional
        Information about the record from the user, by name.
    command : str, optional
        The command line that made the report.
    date : datetime, optional
        Of the report. Default: now.
    targets : iterable of str, optional
        Filters and simulators whose files it has. Default: all for which the result suffices.
    certificate : Certificate, optional
        Page 1.
    """
    moment = datetime.now(tz=UTC) if date is None else date
    used = None
    if record is not None and analysis.curves.keys() <= analysis.masks.keys():
        record = _as_analysed(record)
        used = _used_record(analysis, record)
    files, no_files = filter_files(analysis, targets)
    return Content(
        title=printable(noted_unit(notes or {}) or (_file_name(analysis) if certificate is None else certificate.item)),
        file_name=printable(_file_name(analysis)),
        headline=analysis.headline(name=False, rest=False),
        verdict=_verdict(analysis),
        date=moment.strftime("%Y-%m-%d %H:%M UTC" if moment.tzinfo is UTC else "%Y-%m-%d %H:%M"),
        made_by=f"sigmatau {__version__}",
        notes=tuple((printable(str(key)), printable(str(text))) for key, text in (notes or {}).items()),
        overview=dominant_coefficients(analysis),
        findings=tuple(finding_text(finding) for finding in analysis.findings),
        coefficients=tuple(_coefficients(analysis, channel) for channel in analysis.curves),
        legend=analysis.legend(),
        level=level_text(analysis),
        done=tuple((name, printable(text)) for name, text in _done(analysis, command) if text),
        files=files,
        no_files=no_files,
        charts=collect_charts(analysis, record, used),
        recorded=(analysis.source.started or "").replace("T", " "),
        certificate=certificate,
    )


def _as_analysed(record: Record) -> Record:
    """Shift the times of the streams of a record to those of the analysis."""
    if not isinstance(record, Record):
        raise TypeError(f"`record` must be a Record, as it was given to analyze, not a {type(record).__name__}")
    return from_the_start(record)


def _used_record(analysis: Analysis, record: Record) -> Record:
    """The part of a record that was analysed. Raises `OptionError` if its channels, rate or samples are not those of the
    curves.
    """
    if lacking := [channel for channel in analysis.curves if channel not in record.channels]:
        raise OptionError(f"{{option}} has no channel {lacking[0]!r}, which was analysed", option="record")
    used = only_used(record, {channel: analysis.masks[channel] for channel in analysis.curves})
    for stream in used.streams:
        curves = [analysis.curves[channel] for channel in stream.channels]
        same = math.isclose(curves[0].tau0, stream.grid.tau0, rel_tol=1e-9)
        # Clusters of several samples at the ends of a record may be half full, and are cut here.
        if same and all(curve.stride is None and (curve.m[0] == 1 or not curve.missing) for curve in curves):
            same = all(_is_same_curve(used, stream, curve) for curve in curves)
        if not same:
            raise OptionError("{option} is not the record of the analysis", option="record")
    return used


def _is_same_curve(used: Record, stream: Stream, curve: DeviationCurve) -> bool:
    """Whether a channel has the deviation of a curve at its shortest averaging time, which distinguishes records."""
    alone = replace(used, streams=(stream.only(curve.channel),))  # one channel at a time needs less memory
    again = allan(alone, taus=[curve.tau[0]], overlap=curve.overlap, counting=curve.counting)
    return math.isclose(again[curve.channel].avar[0], curve.avar[0], rel_tol=_SAME_AVAR)


def _file_name(analysis: Analysis) -> str:
    path = analysis.source.path
    return "Record in memory" if path is None else path.replace("\\", "/").rstrip("/").rpartition("/")[2] or path


def dominant_coefficients(analysis: Analysis) -> Overview | None:
    """The main coefficients, and those that dominate a curve; None without a fit."""
    fits = analysis.fits
    return main_coefficients(fits, analysis.findings, terms=dominant_terms(fits)) if fits else None


def _verdict(analysis: Analysis) -> str:
    inertial = any(curve.quantity in QUANTITIES for curve in analysis.curves.values())
    if analysis.rest is None or not inertial:
        return ""
    return "assumed" if not analysis.rest.is_usable and analysis.fits else analysis.rest.verdict


def finding_text(finding: Finding, words: Words | None = None) -> FindingText:
    """A finding in words: those of files, or others."""
    spans = [f"{seconds(a)} s" if a == b else f"{seconds(a)}–{seconds(b)} s" for a, b in finding.spans[:_MAX_SPANS]]
    hidden = len(finding.spans) + finding.more_spans - _MAX_SPANS
    message, action = finding.words_of_files() if words is None else words
    return FindingText(
        severity=finding.severity,
        axes=printable(": ".join(filter(None, (finding.topic, short_axes(finding.channels))))),
        message=printable(message),
        action=printable(action),
        where=", ".join(spans) + (f" and {hidden} more" if hidden > 0 else ""),
    )


def _coefficients(analysis: Analysis, channel: str) -> Coefficients:
    name = printable(channel)
    fitted = analysis.fits.get(channel)
    if fitted is not None:
        reason = [fitted.reason] if fitted.reason and fitted.is_fitted else []
        return Coefficients(
            channel=name,
            verdict=fitted.headline(),
            trust=str(fitted.trust),
            rows=tuple(fitted_rows(fitted)),
            notes=tuple(map(printable, [*reason, *fitted.notes()])),
        )
    rows = []
    read: Mapping[str, ReadOffCoefficient] = analysis.read_off.get(channel, {})
    quantity, rate_unit = analysis.curves[channel].quantity, analysis.curves[channel].unit
    for term, coefficient in read.items():
        text, factor = display_units(term, quantity, rate_unit, [coefficient.value])[-1]
        number = round_to_error(coefficient.value / factor, error=coefficient.error / factor)
        rows.append((TERMS[term].label(quantity), number.value, f"{number.error_text} (1 σ)", text))
    verdict = "read off the curve, as in the paper" if read else "no coefficients"
    return Coefficients(channel=name, verdict=verdict, trust="", rows=tuple(rows), notes=())


def fitted_rows(fitted: NoiseFit) -> list[tuple[str, str, str, str]]:
    """Label, value, interval and unit of each term; the reason in place of the interval of a term that was not observed."""
    rows = []
    for name, term in fitted.items():
        value, interval, unit = fitted.texts(name)[-1]
        if term.value is None:
            interval = fitted.why_not(name) if fitted.has_limits else ""
        rows.append((TERMS[name].label(fitted.quantity), value or "–", interval, unit if value else ""))
    return rows


def _done(analysis: Analysis, command: str | None) -> list[tuple[str, str]]:
    """Processing steps: names and texts. Empty texts are left out."""
    import platform

    import numpy as np

    source = analysis.source
    fits = list(analysis.fits.values())
    methods = dict.fromkeys(fitted.method for fitted in fits) or ({"read-off": None} if analysis.read_off else {})
    return [
        ("File", source.path or ""),
        ("SHA-256", source.sha256 or ""),
        ("Format", source.format),
        ("Recorded from", f"{source.started.replace('T', ' ')}, by the clock of the log" if source.started else ""),
        ("Temperature", _temperature_text(source.temperature)),
        ("Rows", str(source.rows) if source.rows else ""),
        ("Topics", ", ".join(source.topics)),
        ("Conversions", "; ".join(source.conversions)),
        ("Columns not used", ", ".join(source.ignored)),
        *((f"Samples, {name}", sampling_text(sampling)) for name, sampling in analysis.grids.items()),
        *(_analysed(analysis)),
        ("Curves", _curves_text(analysis)),
        ("Densities, stability", _cut_text(analysis)),
        ("Coefficients", ", ".join(_METHODS.get(fitted, fitted) for fitted in methods)),
        ("Confidence level", level_text(analysis)),
        ("Command", command or ""),
        ("Versions", f"sigmatau {__version__}, Python {platform.python_version()}, NumPy {np.__version__}"),
    ]


def _temperature_text(temperature: TemperatureRange | None) -> str:
    """The temperature by the thermometer of the log; empty without one."""
    if temperature is None:
        return ""
    return f"{temperature.mean:.1f} °C, {temperature.low:.1f} to {temperature.high:.1f} °C, by the log"


def level_text(analysis: Analysis) -> str:
    """The confidence level of the coefficients; empty without a fit."""
    return next((f"{100 * fitted.level:g} %" for fitted in analysis.fits.values()), "")


_METHODS = {
    "likelihood": "maximum likelihood of the spectrum; lines and filters that were found are in the model",
    "gls": "generalised least squares on the Allan variances",
    "read-off": "read off the curve, as in the paper",
}


def _analysed(analysis: Analysis) -> list[tuple[str, str]]:
    """The part of the record that was analysed, and how much of it is missing or left out; one row per sensor."""
    groups: dict[tuple[str, ...], list[str]] = {}
    for channel, spans in analysis.used.items():
        first, last = float(spans[0, 0]), float(spans[-1, 1])
        lost = 1 - float((spans[:, 1] - spans[:, 0]).sum()) / max(last - first, 1e-300)
        text = f"{seconds(first)} s to {seconds(last)} s ({duration_text(last - first)})"
        text += f", {two_digits(100 * lost)} % of it missing or left out" if lost > 1e-9 else ""
        groups.setdefault((text,), []).append(channel)
    return [("Analysed", f"{text}: {short_axes(channels)}") for (text,), channels in groups.items()]


def _cut_text(analysis: Analysis) -> str:
    """Which part densities and maps are computed from, if not from all; empty without them."""
    longest = max((curve.n * curve.tau0 for curve in analysis.curves.values() if curve.n > LONGEST), default=0.0)
    if not longest:
        return ""
    tau0 = next(curve.tau0 for curve in analysis.curves.values() if curve.n > LONGEST)
    return f"of the first {duration_text(LONGEST * tau0)} of {duration_text(longest)}"


def _curves_text(analysis: Analysis) -> str:
    curves = list(analysis.curves.values())
    overlap = "overlapping" if curves[0].overlap == "full" else "disjoint"
    counting = "" if curves[0].counting == "standard" else ", N−2n terms as in the paper's eq. (6)"
    return f"Allan deviation of {overlap} clusters{counting}; intervals: {curves[0].interval_text}"


def filter_files(analysis: Analysis, targets: Iterable[str] | None = None) -> tuple[tuple[FilterFile, ...], str]:
    """Files for filters and simulators that need no further choice, and why there are none."""
    if not analysis.fits:
        return (), "There are no coefficients to write."
    files, refused = [], ""
    try:
        source = analysis.to_source()
    except DataError as error:
        return (), f"No filter values: {error}."
    for name in (name for name in NAMES if name not in _SLOW) if targets is None else targets:
        try:
            text = prepare(source, to=name).content
        except (DataError, OptionError) as error:
            refused = refused or f"No filter values: {error}."
            continue
        if isinstance(text, str) and len(text) <= _LARGEST_FILE:
            files.append(FilterFile(target=name, text=text))
    return tuple(files), "" if files else refused
