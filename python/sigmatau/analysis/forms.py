"""JSON form of a result as types: names and units of its keys, and keys that an older or handwritten result may lack."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field
from typing import Any, Literal

from sigmatau._version import SCHEMA
from sigmatau.arrays import Floats, Ints
from sigmatau.decoding import key
from sigmatau.findings.decoding import FindingForm
from sigmatau.findings.finding import Span
from sigmatau.findings.reasons import Reason
from sigmatau.findings.rest import Motion
from sigmatau.fitting.adjustment import Adjustment, Verdict
from sigmatau.fitting.fitted_matern import FittedMatern
from sigmatau.fitting.fitted_noise import Trust
from sigmatau.fitting.fitted_values import FittedGaussMarkov, FittedResonance, FittedSinusoid, Interval, SecondModel
from sigmatau.fitting.read_off import Source as RangeSource
from sigmatau.fitting.response import Shape
from sigmatau.frozen import frozen
from sigmatau.hints import Hint, command
from sigmatau.quality.means import ChannelMean
from sigmatau.quality.selection.rest import Verdict as RestVerdict
from sigmatau.record.record import TemperatureRange


@frozen
class SourceForm:
    """Origin of the record."""

    path: str | None = key(default=None, always=True, null=True)
    format: str = key(default="array")
    topics: tuple[str, ...] = key(default=())
    sha256: str | None = key(default=None, null=True, pattern="^[0-9a-f]{64}$")
    rows: int = key(default=0, minimum=0)
    conversions: tuple[str, ...] = key(default=())
    ignored_columns: tuple[str, ...] = key(default=())
    started: str | None = key(
        "time of the first sample by the clock of the log, ISO 8601; UTC if its stamps count from 1970",
        default=None,
        pattern=r"^\d{4}-\d{2}-\d{2}T\d{2}:\d{2}:\d{2}$",
    )
    temperature_degc: TemperatureRange | None = key("temperature by a thermometer of the log", default=None)


@frozen
class OptionsForm:
    """Options that affect the numbers and differ from the default, by the names of sigmatau.read and sigmatau.analyze."""

    reading: Mapping[str, Any] = key(factory=dict)
    analysis: Mapping[str, Any] = key(factory=dict)


@frozen
class RestForm:
    """Whether the sensor was at rest."""

    verdict: RestVerdict
    still_s: tuple[Span, ...] = key("parts at rest, from the beginning of the log", default=(), always=True)
    motion: Motion | None = key(
        "the strongest motion, in SI: varying means over tau, or a mean rate", default=None, always=True, null=True
    )
    shortest_s: float = key(
        "of a record that is too short to tell: shortest record that the test of rest can judge",
        default=0.0,
        exclusiveMinimum=0,
    )


@frozen
class ErrorForm:
    """Why an analysis failed."""

    message: str = key(default="", always=True)
    exit_code: int = key(default=1, always=True, enum=[1, 2])


@frozen
class TermForm:
    """One of the five terms of a fit."""

    observed: bool | None = key(
        "whether the term is observed; null if there is no adequate model", default=None, always=True, null=True
    )
    level: float = key(default=0.95, always=True, exclusiveMinimum=0, exclusiveMaximum=1)
    unit: str = key("SI", default="", always=True)
    value: float | None = key("value of an observed term; a ramp has a sign", default=None)
    low: float | None = key(default=None)
    high: float | None = key(default=None)
    upper_limit: float | None = key("upper limit of a term that is not observed", default=None, minimum=0)
    p_value: float | None = key(
        "probability of such a large estimate without the term", default=None, minimum=0, maximum=1
    )
    reason: str | None = key("reason why the term is not observed", read=False)
    tau_s: Span | None = key(
        "for an observed term: averaging times at which it makes half of the variance or more; null if other noise hides it",
        read=False,
        null=True,
        exclusiveMinimum=0,
    )


@frozen
class TermsForm:
    """The terms and processes of a fit."""

    quantization: TermForm | None = key(default=None)
    random_walk: TermForm | None = key(default=None)
    bias_instability: TermForm | None = key(default=None)
    rate_random_walk: TermForm | None = key(default=None)
    rate_ramp: TermForm | None = key(default=None)
    gauss_markov: tuple[FittedGaussMarkov, ...] = key(default=())
    sinusoid: tuple[FittedSinusoid, ...] = key(default=())
    resonance: tuple[FittedResonance, ...] = key(default=())


@frozen
class CovarianceForm:
    """Names and covariance of coefficients."""

    terms: tuple[str, ...] = key(default=(), always=True)
    matrix: tuple[Floats, ...] = key(default=(), always=True, type="number")


@frozen
class LowPassForm:
    """A filter as part of a noise model."""

    order: int = key(minimum=1)
    corner_hz: float = key(exclusiveMinimum=0)


@frozen
class FilterForm:
    """The filter of a fit."""

    shape: Shape
    order: int | None = key(default=None, always=True, null=True)
    corner_hz: float | None = key(default=None, always=True, null=True)
    low_hz: float | None = key(default=None, always=True, null=True)
    high_hz: float | None = key(default=None, always=True, null=True)
    coefficients: tuple[float, ...] = key(default=(), always=True)
    interval_s: float | None = key(default=None, always=True, exclusiveMinimum=0)
    known_to_hz: float | None = key(
        "frequency up to which the coefficients describe the filter; 0 for a filter of known shape",
        default=None,
    )
    damping: float | None = key("of two poles", default=None)
    analog: bool = key("whether a Butterworth filter is in front of the sampler", default=False)
    of_white: bool = key("whether it acts on the random walk alone", default=False)
    low_pass: LowPassForm | None = key(
        "Butterworth filter before the sampler that replaces the filter in a noise model",
        default=None,
        always=True,
        null=True,
    )


@frozen
class WarmUpForm:
    """A decaying drift."""

    amplitude: Interval
    time_s: float = key(exclusiveMinimum=0)


@frozen
class FitForm:
    """The fit of a channel. In results before 0.2 its `reasons` are only given in words (`reason`)."""

    method: str = key(default="gls", always=True, enum=["likelihood", "gls"])
    verdict: Verdict = key(
        "adequate_with: the model fits together with filters, lines or processes; widened: the model does not fit exactly,"
        " and the intervals are wider; disturbed: vibration has most of the power, and all terms are upper limits;"
        " descriptive: values without intervals"
    )
    reason: str = key(
        "reason why times were left out, or why there is no adequate model or no fit", default="", always=True
    )
    reasons: tuple[Reason, ...] | None = key("the same as data", default=None)
    tau_min_s: float | None = key(default=None, always=True, null=True, exclusiveMinimum=0)
    tau_max_s: float | None = key(default=None, always=True, null=True, exclusiveMinimum=0)
    p_value: float | None = key(
        "p-value of the goodness of fit", default=None, always=True, null=True, minimum=0, maximum=1
    )
    model: Mapping[str, float] = key("coefficients in SI that together describe the curve")
    unclear: tuple[str, ...] = key(
        "terms that are not significant beside each other, although the model does not fit without them",
        default=(),
        always=True,
    )
    filter: FilterForm | None = key(
        "filter of all noise except quantization: ln |H|² = Σ a_k (cos 2πk f Δ − 1), Δ: interval_s",
        default=None,
        null=True,
    )
    warm_up: WarmUpForm | None = key(default=None, null=True)
    regressors: Mapping[str, Interval] = key(
        "coefficients of the regressors of the mean, such as the temperature", factory=dict
    )
    highest_hz: float | None = key("frequency from which the spectrum was left out", default=None, null=True)
    alike_from_s: float | None = key(
        "a Gauss-Markov process of this or a longer time explains the rate random walk as well", default=None, null=True
    )
    alike_sigma: float | None = key(
        "standard deviation of the process of this time", default=None, null=True, exclusiveMinimum=0
    )
    second: tuple[SecondModel, ...] = key(
        "other models that explain the record as well, with the same lines and resonances: coefficients in SI, and standard"
        " deviation and correlation time of each Gauss-Markov process",
        default=(),
    )
    matern: FittedMatern | None = key("a model with one Matérn process in place of all slow noise", default=None)
    discrepancy: tuple[tuple[float, float], ...] = key(
        "discrepancy that widened intervals allow for: frequency in Hz, standard deviation of the logarithm of the density",
        default=(),
    )
    terms: TermsForm
    covariance: CovarianceForm | None = key(default=None, always=True)
    runs_s: tuple[float, ...] = key("lengths of the runs of a joint fit", default=(), exclusiveMinimum=0)
    adjustments: tuple[Adjustment, ...] = key(
        "what checks of the record changed in the intervals of the fit, in the order in which they were applied",
        default=(),
    )


@frozen
class CoefficientForm:
    """A coefficient that was read off."""

    value: float = key(exclusiveMinimum=0)
    error: float = key("one standard error by eq. (26) at the longest tau of the region", minimum=0)
    unit: str = key("SI")
    tau_s: Span = key(exclusiveMinimum=0)
    slope: float | None = key(
        "slope of the curve in the range; null for one point", default=None, always=True, null=True
    )
    range_from: RangeSource = key(
        "origin of the range: the rules of the read-off, given by hand, or the range in which the fitted term is most of"
        " the variance",
        default="rules",
    )
    slope_error: float | None = key(
        "standard error of the slope by eq. (26); null for one point", default=None, null=True
    )
    forced: bool = key("the line is drawn although the curve has another slope", default=False)


@frozen
class RefusedLineForm:
    """A line in a given range that was refused."""

    term: str
    tau_s: Span = key(exclusiveMinimum=0)
    slope: float | None = key(
        "slope of the curve in the range; null for one point", default=None, always=True, null=True
    )
    slope_error: float | None = key("standard error of the slope by eq. (26)", default=None, always=True, null=True)
    reason: str


@frozen
class CurveForm:
    """An Allan deviation curve, whose intervals follow from `edf`. A handwritten one needs at least its unit."""

    m: Ints | None = key(default=None, always=True)
    tau_s: Floats | None = key(default=None, always=True)
    adev: Floats | None = key(default=None, always=True)
    low: Floats | None = key(read=False, always=True)
    high: Floats | None = key(read=False, always=True)
    interval: str | None = key("meaning of low and high", read=False, always=True)
    n_pairs: Ints | None = key(default=None, always=True)
    counting: Literal["standard", "paper"] = key(default="standard", always=True)
    unit: str = key("unit of adev, low and high; SI")
    edf: Floats | None = key("equivalent degrees of freedom for the fitted noise", default=None)
    stride: Ints | None = key("distance between the starts of clusters in samples; 1 if absent", default=None)
    missing: int = key("missing samples", default=0, minimum=1)
    estimator: Literal["overlapped", "non-overlapped"] = key(default="overlapped", always=True)


@frozen
class MeansForm:
    """Standard deviation of the means of an averaging time."""

    average_s: float = key(exclusiveMinimum=0)
    means: int = key(default=0, always=True, minimum=2)
    value: float = key(minimum=0)
    low: float | None = key(default=None, minimum=0)
    high: float | None = key(default=None, minimum=0)
    edf: float | None = key(
        "equivalent degrees of freedom of the variance for the fitted noise", default=None, exclusiveMinimum=0
    )
    level: float = key(exclusiveMinimum=0, exclusiveMaximum=1)
    unit: str = key("SI", default="", always=True)


@frozen
class StabilityForm:
    """A dynamic Allan deviation; null for a window without one."""

    channel: str
    quantity: str
    unit: str = key("unit of adev; SI")
    window_s: float = key(exclusiveMinimum=0)
    step_s: float = key(exclusiveMinimum=0)
    samples_in_window: int = key(minimum=4)
    estimator: Literal["overlapped"] | None = key(read=False, always=True)
    time_s: Floats = key("middle of each window", type="number")
    tau_s: Floats = key(exclusiveMinimum=0)
    adev: tuple[Floats | None, ...] = key("one row per window; null if samples are missing", minimum=0)


@frozen
class ExcludedForm:
    """Samples that were not used, by reason: the first sample of each stretch, and the sample after its last."""

    samples: int = key("samples of the channel in the record", minimum=4)
    start_s: float = key("time of the first sample from the beginning of the record")
    spans: Mapping[str, tuple[tuple[int, int], ...]] = key(
        "for each reason (missing, window, or the code of a finding) first sample of each stretch, and the one after the"
        " last",
        minimum=0,
    )


@frozen
class ExcludedRunsForm:
    """Samples that were not used, in very many stretches."""

    samples: int = key("samples of the channel in the record", minimum=4)
    start_s: float = key("time of the first sample from the beginning of the record")
    runs: Mapping[str, str] = key(
        "for each reason numbers of samples before each stretch (from the one before it) and in it, by turns, separated by"
        ' spaces: "100 10 4890 1" for the samples 100 to 109 and 5000'
    )


@frozen
class SpreadForm:
    """Variation of a coefficient from run to run."""

    relative: float = key(minimum=0)
    p_value: float = key(minimum=0, maximum=1)


@frozen
class RunForm:
    """A run of a joint fit."""

    name: str
    belongs: bool = key("whether the run agrees with the model of the others: p_value of at least 0.01")
    p_value: float = key("corrected for the number of runs and tests", minimum=0, maximum=1)
    cause: str = key("largest difference of the run: a term, or all for the shape of the spectrum")
    factor: float | None = key("coefficient of the cause divided by that of the other runs", null=True)
    values: Mapping[str, Interval] = key("coefficients that differ from run to run")
    own: Mapping[str, Interval] = key("common coefficients, fitted to this run alone")
    duration_s: float = key(exclusiveMinimum=0)


@frozen
class JointForm:
    """Additional values of a joint fit."""

    common: tuple[str, ...] = key("terms that are the same in all runs")
    spreads: Mapping[str, SpreadForm] = key(
        "for the other terms: relative standard deviation over runs, p-value of no spread"
    )
    homogeneity: Mapping[str, float] = key(
        "p-value of equal coefficients in all runs, for the common terms that the runs show", minimum=0, maximum=1
    )
    outliers: tuple[str, ...] = key("outlying runs, the worst first")
    runs: tuple[RunForm, ...]


@frozen
class ChannelForm:
    """The results of a channel."""

    quantity: str = key(enum=["angular_rate", "acceleration", "temperature", "signal"])
    sample_rate_hz: float | None = key(default=None, always=True, exclusiveMinimum=0)
    samples: int = key(default=0, always=True, minimum=4)
    excluded: ExcludedForm | None = key(
        "samples of the record that were not used; with more than 1000 stretches excluded_runs has them", default=None
    )
    excluded_runs: ExcludedRunsForm | None = key("excluded, of more than 1000 stretches", default=None)
    mean: ChannelMean | None = key(
        "mean of the analysed samples; error: standard error by noise that averages out, null if the bias wanders",
        default=None,
    )
    curve: CurveForm | None = key(default=None, always=True)
    read_off: Mapping[str, CoefficientForm] = key(factory=dict, always=True)
    refused_lines: tuple[RefusedLineForm, ...] = key(
        f"lines in ranges given by hand ({Hint('read_off_at')}) that were refused, as their slope is not that of the curve",
        default=(),
    )
    fit: FitForm | None = key(default=None)
    trust: Trust | None = key("trust in the coefficients of the fit", default=None)
    mean_stability: tuple[MeansForm, ...] = key(
        "standard deviations (ddof = 1) of the means of consecutive stretches; low and high hold for the expected value at"
        " this length of the record",
        default=(),
    )
    joint: JointForm | None = key(
        f"differences between the runs of a joint fit ({command('analyze', Hint('joint'))})", read=False
    )
    stability: StabilityForm | None = key("dynamic Allan deviation, if requested", default=None)


@frozen
class ResultForm:
    """A result."""

    schema: int = key(default=1, always=True, const=SCHEMA)
    sigmatau: str = key("version of the package that wrote the file", default="", always=True)
    source: SourceForm | None = key(default=None, always=True)
    options: OptionsForm | None = key(
        "options that affect the numbers and are not the default, by the names of sigmatau.read and sigmatau.analyze",
        default=None,
    )
    notes: Mapping[str, str] = key(
        "information about the record from the user: serial number, run, temperature; compare groups results by it",
        factory=dict,
    )
    rest: RestForm | None = key(
        "whether the sensor is at rest; if not, or if the record is too short to tell, no channel has coefficients, unless"
        " the option at_rest was given",
        default=None,
    )
    error: ErrorForm | None = key("reason of a failed analysis, which has no findings and no channels", default=None)
    findings: tuple[FindingForm, ...] = key(default=(), always=True)
    channels: Mapping[str, ChannelForm]


@frozen
class CurveUnitForm(CurveForm):
    """Only the unit of a curve."""

    m: None = field(default=None, init=False)
    tau_s: None = field(default=None, init=False)
    adev: None = field(default=None, init=False)
    n_pairs: None = field(default=None, init=False)
    edf: None = field(default=None, init=False)
    stride: None = field(default=None, init=False)


@frozen
class BriefFitForm(FitForm):
    """The coefficients, lines and filter of a fit."""

    reasons: tuple[Reason, ...] | None = field(default=None, init=False)
    unclear: tuple[str, ...] = field(default=(), init=False)
    warm_up: None = field(default=None, init=False)
    regressors: Mapping[str, Interval] = field(default_factory=dict, init=False)
    discrepancy: tuple[tuple[float, float], ...] = field(default=(), init=False)
    covariance: None = field(default=None, init=False)
    runs_s: tuple[float, ...] = field(default=(), init=False)
    adjustments: tuple[Adjustment, ...] = field(default=(), init=False)


@frozen
class BriefChannelForm(ChannelForm):
    """A channel without its curves, the largest part of a result, and without rarely used parts."""

    excluded: None = field(default=None, init=False)
    excluded_runs: None = field(default=None, init=False)
    curve: CurveUnitForm | None = None
    read_off: Mapping[str, CoefficientForm] = field(default_factory=dict, init=False)
    refused_lines: tuple[RefusedLineForm, ...] = field(default=(), init=False)
    fit: BriefFitForm | None = None
    mean_stability: tuple[MeansForm, ...] = field(default=(), init=False)
    stability: None = field(default=None, init=False)


@frozen
class BriefResultForm(ResultForm):
    """A result without its curves, to add thousands of results to a store."""

    channels: Mapping[str, BriefChannelForm]


@frozen
class CoefficientsChannelForm(BriefChannelForm):
    """Coefficients of a channel, including read-offs."""

    read_off: Mapping[str, CoefficientForm] = field(default_factory=dict)


@frozen
class CoefficientsForm(BriefResultForm):
    """A result without curves and findings, to compare the coefficients of thousands of results."""

    channels: Mapping[str, CoefficientsChannelForm]
    findings: tuple[FindingForm, ...] = field(default=(), init=False)
