"""Reader of results: JSON of any version of sigmatau as an `Analysis`."""

from __future__ import annotations

import contextlib
import functools
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any, NoReturn, TypeVar, cast

import numpy as np

from sigmatau._version import SCHEMA
from sigmatau.analysis import forms
from sigmatau.analysis.failed import FailedAnalysis
from sigmatau.analysis.options import AnalysisOptions, parse_options
from sigmatau.analysis.result import Analysis
from sigmatau.decoding import WrongValueError, decode
from sigmatau.errors import DataError, OptionError
from sigmatau.estimators.allan import Curves, DeviationCurve
from sigmatau.estimators.stability import DynamicAllan
from sigmatau.findings.decoding import decode_finding
from sigmatau.findings.finding import Findings
from sigmatau.findings.reasons import StatedReason
from sigmatau.fitting.fitted_values import FittedTerm, FittedWarmUp
from sigmatau.fitting.mean_stability import MeanStability
from sigmatau.fitting.noise_fit import Fits, NoiseFit
from sigmatau.fitting.read_off import ReadOff, ReadOffCoefficient
from sigmatau.fitting.read_off_regions import Refusal
from sigmatau.fitting.response import FittedFilter
from sigmatau.model.parameters import Covariance
from sigmatau.model.processes import LowPass
from sigmatau.noise.terms import TERMS, coefficient_unit
from sigmatau.quality.selection.rest import Rest
from sigmatau.record.mask import ChannelMask, ExcludedSpan, stretches_of_runs
from sigmatau.record.record import Provenance
from sigmatau.record.streams import RATES

T = TypeVar("T")

_COUNTS, _POINTS = np.empty(0, dtype=np.int64), np.empty(0)  # keys of a curve that are not read
for _column in (_COUNTS, _POINTS):
    _column.setflags(write=False)

_MAX_SAMPLES = 2**53  # largest integer below which all integers are exact in a float
_LARGEST_DEVIATION = 1e150  # its square is a double


def read_analysis(source: str | bytes | Path) -> Analysis:
    """Read the analysis of a file or of JSON. Raises `DataError`, also for a failed analysis."""
    result = read_result(source)
    try:
        return as_analysis(result)
    except DataError as error:
        raise (error if _is_json(source) else error.about(str(source))) from None


def read_result(
    source: str | bytes | Path, *, as_form: type[forms.ResultForm] = forms.ResultForm
) -> Analysis | FailedAnalysis:
    """Read the result of a file or of JSON: text that begins with a brace, or bytes. Raises `DataError`.

    `as_form`: the parts that are read.
    """
    if isinstance(source, bytes) or (isinstance(source, str) and _is_json(source)):
        return result_of_dict(_parsed(source), as_form=as_form)
    path = Path(source)
    try:
        return result_of_dict(_parsed(path.read_bytes()), as_form=as_form)
    except OSError as error:
        raise DataError(error.strerror or str(error)).about(str(path)) from None
    except DataError as error:
        raise error.about(str(path)) from None


def _is_json(source: str | bytes | Path) -> bool:
    return isinstance(source, bytes) or (isinstance(source, str) and source.lstrip("\ufeff \t\r\n")[:1] in ("{", "["))


def _parsed(text: str | bytes) -> object:
    def refuse(word: str) -> NoReturn:
        raise ValueError(f"{word} is not a number of JSON")

    try:
        # orjson is optional, and rejects NaN and other input that programs may write.
        with contextlib.suppress(ImportError, ValueError):
            import orjson

            return orjson.loads(text)
        return json.loads(text.decode("utf-8-sig") if isinstance(text, bytes) else text, parse_constant=refuse)
    except (ValueError, RecursionError) as error:
        raise DataError(f"not JSON: {error}") from None


def result_of_dict(content: object, *, as_form: type[forms.ResultForm] = forms.ResultForm) -> Analysis | FailedAnalysis:
    """Convert parsed JSON to a result. Raises `DataError` with the place of the fault."""
    form = form_of_dict(content, as_form)
    try:
        return _failed(form, form.error) if form.error is not None else _analysis(form)
    except WrongValueError as error:
        raise DataError(f"{_CHANGED}: {error}") from None


_CHANGED = "not a result of sigmatau analyze, or changed"


def form_of_dict(content: object, as_form: type[forms.ResultForm]) -> forms.ResultForm:
    """Convert the keys of parsed JSON to types. Raises `DataError` with the place of the fault."""
    if not isinstance(content, Mapping):
        raise DataError(f"a result of sigmatau analyze is an object, not {type(content).__name__}")
    schema, channels = content.get("schema", 1), content.get("channels")
    if type(schema) is int and schema > SCHEMA:
        raise DataError(f"schema {schema} is of a newer version of sigmatau; update sigmatau")
    if not isinstance(channels, Mapping):
        raise DataError("this is not a result of sigmatau analyze: it has no channels")
    try:
        return decode(as_form, content)
    except WrongValueError as error:
        raise DataError(f"{_CHANGED}: {error}") from None


def _failed(form: forms.ResultForm, error: forms.ErrorForm) -> FailedAnalysis:
    stated = {} if form.options is None else {"reading": form.options.reading, "analysis": form.options.analysis}
    return FailedAnalysis(
        path="" if form.source is None else form.source.path or "",
        message=error.message,
        exit_code=error.exit_code,
        notes=form.notes,
        version=form.sigmatau,
        options={part: options for part, options in stated.items() if options},
    )


def as_result(source: object) -> Analysis | FailedAnalysis:
    """Read a result from any of its forms: an analysis, its parsed JSON, or its file. Raises `DataError`."""
    if isinstance(source, Analysis | FailedAnalysis):
        return source
    if isinstance(source, str | Path):
        return read_result(Path(source))
    return result_of_dict(source)


def as_analysis(result: Analysis | FailedAnalysis) -> Analysis:
    """Return the analysis. Raises `DataError` for a failed one."""
    if isinstance(result, FailedAnalysis):
        raise result.error()
    return result


def _analysis(form: forms.ResultForm) -> Analysis:
    source, options = form.source or forms.SourceForm(), form.options or forms.OptionsForm()
    curves: dict[str, DeviationCurve] = {}
    fits: dict[str, NoiseFit] = {}
    read_off: dict[str, ReadOff] = {}
    masks: dict[str, ChannelMask] = {}
    for name, channel in form.channels.items():
        try:
            curve = None if channel.curve is None else _curve(name, channel, channel.curve)
            if curve is not None:
                curves[name] = curve
            if channel.fit is not None:
                fits[name] = _fit(name, channel, channel.fit)
            read_off[name] = _read_off(name, channel)
            if (excluded := channel.excluded or channel.excluded_runs) is not None:
                masks[name] = _mask(name, channel, excluded)
        except WrongValueError as error:
            error.path += [name, "channels"]
            raise
    channels = form.channels
    return Analysis(
        source=_build(
            Provenance,
            source,
            ignored=source.ignored_columns,
            options=options.reading,
            checksum=source.sha256,
            temperature=source.temperature_degc,
        ),
        findings=Findings(map(decode_finding, form.findings)),
        curves=Curves(curves),
        fits=Fits(fits),
        read_off=read_off,
        grids={},
        stability={
            name: _stability(channel.stability)
            for name, channel in form.channels.items()
            if channel.stability is not None
        },
        mean_stability={name: tuple(map(_means, c.mean_stability)) for name, c in channels.items() if c.mean_stability},
        rest=None if form.rest is None else _build(Rest, form.rest),
        masks=masks,
        means={name: channel.mean for name, channel in form.channels.items() if channel.mean is not None},
        options=_options(options.analysis),
        notes=form.notes,
        version=form.sigmatau,
    )


def _options(stated: Mapping[str, Any]) -> AnalysisOptions:
    try:
        return parse_options(stated)
    except (OptionError, TypeError, ValueError) as error:
        raise WrongValueError(f"options.analysis: {error}") from None


def _mask(name: str, channel: forms.ChannelForm, form: forms.ExcludedForm | forms.ExcludedRunsForm) -> ChannelMask:
    spans = [ExcludedSpan(start, stop, reason) for reason, pairs in _stretches(form).items() for start, stop in pairs]
    spans.sort(key=lambda span: span.start)
    edges = [0, *(edge for span in spans for edge in (span.start, span.stop)), form.samples]
    if not 0 <= form.samples < _MAX_SAMPLES or edges != sorted(edges):
        raise WrongValueError("excluded: its spans overlap, or end after the record")
    return ChannelMask(
        channel=name, samples=form.samples, tau0=_interval_of_samples(channel), lead=form.start_s, spans=tuple(spans)
    )


def _stretches(form: forms.ExcludedForm | forms.ExcludedRunsForm) -> Mapping[str, Sequence[tuple[int, int]]]:
    if isinstance(form, forms.ExcludedForm):
        return form.spans
    try:
        return {reason: stretches_of_runs(text) for reason, text in form.runs.items()}
    except ValueError:
        raise WrongValueError("excluded_runs: its runs are not pairs of whole numbers") from None


def _unit(channel: forms.ChannelForm) -> str:
    """Unit of a channel: that of its curve, or of its mean in a handwritten result without a curve."""
    if channel.curve is not None:
        return channel.curve.unit
    if channel.mean is not None:
        return channel.mean.unit
    raise WrongValueError("curve is missing")


def _interval_of_samples(channel: forms.ChannelForm) -> float:
    """Sample interval whose inverse is the rate. [s]"""
    rate = channel.sample_rate_hz
    if rate is None:
        raise WrongValueError("sample_rate_hz is missing")
    if not RATES[0] <= rate <= RATES[1]:
        raise WrongValueError(f"sample_rate_hz is {rate:g}, not from {RATES[0]:g} to {RATES[1]:g}")
    if not 0 <= channel.samples < _MAX_SAMPLES:
        raise WrongValueError("samples is negative or too large")
    curve = channel.curve
    if curve is not None and curve.m is not None and curve.tau_s is not None and curve.m[:1].any():
        tau0 = float(next(iter(curve.tau_s), math.nan)) / int(curve.m[0])
        if tau0 > 0 and 1 / tau0 == rate:  # 1/(1/τ₀) may differ from τ₀
            return tau0
    return 1 / rate


def _curve(name: str, channel: forms.ChannelForm, form: forms.CurveForm) -> DeviationCurve | None:
    """Convert a curve; None if only its unit is stated. It has no points if a store did not keep them, or if only its unit
    is read.
    """
    tau0 = _interval_of_samples(channel)
    if isinstance(form, forms.CurveUnitForm):
        return _without_points(name, channel, form, tau0)
    if form.adev is None:
        return None
    if form.m is not None:
        m, tau = form.m, np.asarray(form.m * tau0, dtype=np.float64) if form.tau_s is None else form.tau_s
    elif form.tau_s is not None:
        m, tau = np.round(form.tau_s / tau0).astype(np.int64), form.tau_s
    else:
        return None
    columns = (m, form.adev, form.n_pairs, form.edf, form.stride)
    if any(column is not None and column.shape != tau.shape for column in columns):
        raise WrongValueError("curve: its columns have several lengths")
    if not (np.isfinite(tau) & (tau > 0)).all():
        raise WrongValueError("curve: tau_s has a time that is not positive")
    if (form.adev > _LARGEST_DEVIATION).any():
        raise WrongValueError(f"curve: adev has a value beyond {_LARGEST_DEVIATION:g}")
    return _build(
        DeviationCurve,
        form,
        channel=name,
        quantity=channel.quantity,
        m=m,
        tau=tau,
        avar=form.adev**2,
        n_pairs=np.zeros(m.shape, dtype=np.int64) if form.n_pairs is None else form.n_pairs,
        ramp=np.full(m.shape, np.nan),
        n=channel.samples,
        tau0=tau0,
        overlap="full" if form.estimator == "overlapped" else "none",
    )


def _without_points(name: str, channel: forms.ChannelForm, form: forms.CurveForm, tau0: float) -> DeviationCurve:
    """Build a curve without points, if only its unit is read."""
    return _build(
        DeviationCurve, form, channel=name, quantity=channel.quantity, n=channel.samples, tau0=tau0, m=_COUNTS, tau=_POINTS,
        avar=_POINTS, n_pairs=_COUNTS, ramp=_POINTS, overlap="full", missing=0,
    )  # fmt: skip


def _fit(name: str, channel: forms.ChannelForm, form: forms.FitForm) -> NoiseFit:
    unit, tau0 = _unit(channel), _interval_of_samples(channel)
    terms = {}
    for term in TERMS:
        stated: forms.TermForm | None = getattr(form.terms, term)
        if stated is not None:
            terms[term] = _term(term, stated, stated.unit or coefficient_unit(term, channel.quantity, unit))
    reasons = form.reasons
    if reasons is None:
        reasons = (StatedReason(text=form.reason),) if form.reason else ()
    return _build(
        NoiseFit,
        form,
        channel=name,
        quantity=channel.quantity,
        rate_unit=unit,
        n=channel.samples,
        tau0=tau0,
        terms=terms,
        gauss_markov=form.terms.gauss_markov,
        sinusoid=form.terms.sinusoid,
        resonance=form.terms.resonance,
        response=None if form.filter is None else _filter(form.filter, tau0, channel.sample_rate_hz),
        warm_up=None if form.warm_up is None else _build(FittedWarmUp, form.warm_up),
        model={term: value for term, value in form.model.items() if term in TERMS},
        reasons=reasons,
        covariance=Covariance() if form.covariance is None else _covariance(form.covariance),
        level=next((term.level for term in terms.values()), 0.95),
        trust=channel.trust,
    )


def _term(name: str, form: forms.TermForm, unit: str) -> FittedTerm:
    if not 0 < form.level < 1:
        raise WrongValueError(f"fit.terms.{name}.level is {form.level:g}, not between 0 and 1")
    return _build(FittedTerm, form, term=name, unit=unit)


def _filter(form: forms.FilterForm, tau0: float, rate: float | None) -> FittedFilter:
    like = form.low_pass
    try:
        low_pass = None if like is None else LowPass(order=like.order, corner=like.corner_hz, rate=rate)
    except DataError as error:
        raise WrongValueError(f"fit.filter.low_pass: {error.message}") from None
    return _build(
        FittedFilter, form, tau0=tau0, interval=tau0 if form.interval_s is None else form.interval_s, low_pass=low_pass
    )


def _covariance(form: forms.CovarianceForm) -> Covariance:
    size = len(form.terms)
    if len(form.matrix) != size or any(len(row) != size for row in form.matrix):
        raise WrongValueError(f"fit.covariance: the matrix is not {size} by {size}")
    return Covariance.of(form.terms, form.matrix)


def _read_off(name: str, channel: forms.ChannelForm) -> ReadOff:
    coefficients = {
        term: _build(
            ReadOffCoefficient,
            form,
            term=term,
            tau_min=form.tau_s[0],
            tau_max=form.tau_s[1],
            percentage=form.error / form.value if form.value else math.nan,
        )
        for term, form in channel.read_off.items()
        if term in TERMS
    }
    unit = _unit(channel) if channel.curve is not None or channel.mean is not None else ""
    refused = tuple(
        _build(Refusal, form, tau_min=form.tau_s[0], tau_max=form.tau_s[1], by_hand=True)
        for form in channel.refused_lines
        if form.term in TERMS
    )
    return ReadOff(name, channel.quantity, unit, coefficients, refused)


def _means(form: forms.MeansForm) -> MeanStability:
    if not (0 < form.level < 1 and form.value >= 0 and form.average_s > 0):
        raise WrongValueError("mean_stability: not a standard deviation of means")
    return _build(MeanStability, form)


def _stability(form: forms.StabilityForm) -> DynamicAllan:
    empty = np.full(len(form.tau_s), np.nan)
    rows = [empty if row is None else row for row in form.adev]
    if len(rows) != len(form.time_s) or any(len(row) != len(empty) for row in rows):
        raise WrongValueError("stability: adev is not a row of tau_s for each time")
    return _build(
        DynamicAllan,
        form,
        times=form.time_s,
        adev=np.array(rows, dtype=np.float64).reshape(len(rows), len(empty)),
        n=form.samples_in_window,
    )


@functools.cache
def _shared(cls: type, form: type) -> dict[str, str]:
    """Pair fields of a class with the keys of a form that have the same name, with or without a unit."""
    keys = {field.name.removesuffix("_s").removesuffix("_hz"): field.name for field in fields(form)}
    keys |= {field.name: field.name for field in fields(form)}
    return {field.name: keys[field.name] for field in fields(cls) if field.init and field.name in keys}


def _build(cls: type[T], form: Any, **values: Any) -> T:  # noqa: ANN401  a form, and fields of any type
    """Build an object from a form and further values, which are not in the form or differ in type."""
    shared = _shared(cast("Any", cls), cast("Any", type(form)))
    return cls(**{name: getattr(form, key) for name, key in shared.items() if name not in values}, **values)
