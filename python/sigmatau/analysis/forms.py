"""The JSON form of a result as types: names and units of its keys, and what an older version or a hand may leave out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from sigmatau.findings.decoding import FindingForm
from sigmatau.findings.finding import Span
from sigmatau.findings.reasons import Reason
from sigmatau.findings.rest import Motion
from sigmatau.fitting.noise_fit import GaussMarkov, Interval, Resonance, Sinusoid, Trust, Verdict
from sigmatau.fitting.read_off import Source as RangeSource
from sigmatau.fitting.response import Shape
from sigmatau.frozen import frozen
from sigmatau.quality.means import ChannelMean
from sigmatau.quality.selection.rest import Verdict as RestVerdict

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@frozen
class SourceForm:
    """Origin of the record."""

    path: str | None = None
    format: str = "array"
    topics: tuple[str, ...] = ()
    sha256: str | None = None
    rows: int = 0
    conversions: tuple[str, ...] = ()
    ignored_columns: tuple[str, ...] = ()


@frozen
class OptionsForm:
    """Options of reading and of the analysis that are not the default."""

    reading: Mapping[str, Any] = field(default_factory=dict)
    analysis: Mapping[str, Any] = field(default_factory=dict)


@frozen
class RestForm:
    """Whether the sensor was at rest."""

    verdict: RestVerdict
    still_s: tuple[Span, ...] = ()
    motion: Motion | None = None
    shortest_s: float = 0.0


@frozen
class ErrorForm:
    """Why an analysis failed."""

    message: str = ""
    exit_code: int = 1

    @property
    def stated_text(self) -> str:
        """Why, in words."""
        return self.message


@frozen
class TermForm:
    """One of the five terms of a fit."""

    observed: bool | None = None
    level: float = 0.95
    unit: str = ""
    value: float | None = None
    low: float | None = None
    high: float | None = None
    upper_limit: float | None = None
    p_value: float | None = None


@frozen
class TermsForm:
    """What a fit has: the five terms, and processes."""

    quantization: TermForm | None = None
    random_walk: TermForm | None = None
    bias_instability: TermForm | None = None
    rate_random_walk: TermForm | None = None
    rate_ramp: TermForm | None = None
    gauss_markov: tuple[GaussMarkov, ...] = ()
    sinusoid: tuple[Sinusoid, ...] = ()
    resonance: tuple[Resonance, ...] = ()


@frozen
class CovarianceForm:
    """Names and covariance of coefficients."""

    terms: tuple[str, ...] = ()
    matrix: tuple[Floats, ...] = ()


@frozen
class LowPassForm:
    """A filter in its place in a noise model."""

    order: int
    corner_hz: float


@frozen
class FilterForm:
    """The filter of a fit."""

    shape: Shape
    order: int | None = None
    corner_hz: float | None = None
    low_hz: float | None = None
    high_hz: float | None = None
    coefficients: tuple[float, ...] = ()
    interval_s: float | None = None
    known_to_hz: float | None = None
    low_pass: LowPassForm | None = None


@frozen
class WarmUpForm:
    """A decaying drift."""

    amplitude: Interval
    time_s: float


@frozen
class FitForm:
    """The fit of a channel; `reasons` are in words alone (`reason`) in results before 0.2."""

    method: str = "gls"
    verdict: Verdict
    reason: str = ""
    reasons: tuple[Reason, ...] | None = None
    tau_min_s: float | None = None
    tau_max_s: float | None = None
    p_value: float | None = None
    model: Mapping[str, float]
    unclear: tuple[str, ...] = ()
    filter: FilterForm | None = None
    warm_up: WarmUpForm | None = None
    regressors: Mapping[str, Interval] = field(default_factory=dict)
    highest_hz: float | None = None
    alike_from_s: float | None = None
    alike_sigma: float | None = None
    discrepancy: tuple[tuple[float, float], ...] = ()
    terms: TermsForm
    covariance: CovarianceForm | None = None
    runs_s: tuple[float, ...] = ()


@frozen
class CoefficientForm:
    """A coefficient that was read off."""

    value: float
    error: float
    unit: str
    tau_s: Span
    slope: float | None = None
    range_from: RangeSource = "rules"


@frozen
class CurveForm:
    """An Allan deviation curve, whose intervals follow from `edf`; by hand, its unit at least."""

    m: Ints | None = None
    tau_s: Floats | None = None
    adev: Floats | None = None
    n_pairs: Ints | None = None
    counting: Literal["standard", "paper"] = "standard"
    unit: str
    edf: Floats | None = None
    stride: Ints | None = None
    missing: int = 0
    estimator: Literal["overlapped", "non-overlapped"] = "overlapped"


@frozen
class MeansForm:
    """Standard deviation of the means of an averaging time."""

    average_s: float
    means: int = 0
    value: float
    low: float | None = None
    high: float | None = None
    edf: float | None = None
    level: float
    unit: str = ""


@frozen
class StabilityForm:
    """A dynamic Allan deviation; null for a window without one."""

    channel: str
    quantity: str
    unit: str
    window_s: float
    step_s: float
    samples_in_window: int
    time_s: Floats
    tau_s: Floats
    adev: tuple[Floats | None, ...]


@frozen
class ExcludedForm:
    """Samples that were not used, by reason: the first of each stretch, and the one after the last."""

    samples: int
    start_s: float
    spans: Mapping[str, tuple[tuple[int, int], ...]]


@frozen
class ChannelForm:
    """What a channel has."""

    quantity: str
    sample_rate_hz: float | None = None
    samples: int = 0
    excluded: ExcludedForm | None = None
    mean: ChannelMean | None = None
    curve: CurveForm | None = None
    read_off: Mapping[str, CoefficientForm] = field(default_factory=dict)
    fit: FitForm | None = None
    trust: Trust | None = None
    mean_stability: tuple[MeansForm, ...] = ()
    stability: StabilityForm | None = None


@frozen
class ResultForm:
    """A result."""

    schema: int = 1
    sigmatau: str = ""
    source: SourceForm | None = None
    options: OptionsForm | None = None
    notes: Mapping[str, str] = field(default_factory=dict)
    rest: RestForm | None = None
    error: ErrorForm | None = None
    findings: tuple[FindingForm, ...] = ()
    channels: Mapping[str, ChannelForm]


@frozen
class CurveUnitForm(CurveForm):
    """The unit of a curve alone."""

    m: None = field(default=None, init=False)
    tau_s: None = field(default=None, init=False)
    adev: None = field(default=None, init=False)
    n_pairs: None = field(default=None, init=False)
    edf: None = field(default=None, init=False)
    stride: None = field(default=None, init=False)


@frozen
class BriefChannelForm(ChannelForm):
    """A channel without its curves, which are most of a result."""

    curve: CurveUnitForm | None = None
    read_off: Mapping[str, CoefficientForm] = field(default_factory=dict, init=False)
    stability: None = field(default=None, init=False)


@frozen
class BriefResultForm(ResultForm):
    """A result without its curves: thousands are read to compare coefficients."""

    channels: Mapping[str, BriefChannelForm]
