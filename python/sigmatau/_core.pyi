# The compiled core as Python sees it; crates/py/src/lib.rs is the other side, mypy.stubtest holds the two together.

from collections.abc import Sequence
from typing import Any, Final, Literal, Self, final

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "MAX_LINES",
    "OUTLIER_ALPHA",
    "Accumulator",
    "ChannelFit",
    "CurveFit",
    "Estimate",
    "FilterEstimate",
    "FittedModel",
    "GaussMarkovEstimate",
    "Generator",
    "Gls",
    "GlsComponents",
    "JointChannelFit",
    "LikelihoodPass",
    "LikelihoodSummary",
    "LineEstimate",
    "MaternEstimate",
    "NonFinite",
    "Parameter",
    "ResonanceEstimate",
    "RunEstimate",
    "SecondModel",
    "TermEstimate",
    "TextError",
    "WarmUpEstimate",
    "all_finite",
    "allan_variances",
    "band_limited_avar",
    "band_limited_psd",
    "bytes_read",
    "covariance_tensors",
    "dataflash_columns",
    "decode_messages",
    "deviation_limits",
    "deviations_of_channels",
    "distribution",
    "distribution_of_shape",
    "fit_curve",
    "fit_jointly",
    "flicker_poles",
    "format_text",
    "from_sides",
    "gauss_markov_avar",
    "gauss_markov_psd",
    "log_contents",
    "log_messages",
    "masked_variances",
    "matern_processes",
    "neighbour_medians",
    "neighbour_scatter",
    "non_negative",
    "outliers",
    "parse_stamp",
    "parse_text",
    "quadratic_edf",
    "read_sentences",
    "read_text",
    "resonance_avar",
    "resonance_folds",
    "resonance_psd",
    "scan_dataflash",
    "scan_ulog",
    "sinusoid_avar",
    "stationary_moments",
    "strides",
    "term_avar",
    "term_psd",
    "theo1_expectation",
    "total_bias",
    "ulog_columns",
    "unpacked",
]

_Floats = NDArray[np.float64]
_Ints = NDArray[np.int64]
_Shape = Literal["butterworth", "smoothing", "running_mean", "two_poles", "running_means", "low_pass", "uneven"]
_Quantity = Literal["sigma", "time", "frequency", "width"]
_Verdict = Literal["adequate", "adequate_with", "widened"]

@final
class LikelihoodPass:
    def __new__(cls, samples: int, tau0: float) -> Self: ...
    @staticmethod
    def masked(
        present: NDArray[np.bool_], tau0: float, taper: float = 0.0, differences: float | None = None
    ) -> LikelihoodPass: ...
    def push(self, rate: _Floats) -> None: ...
    def finish(self) -> LikelihoodSummary: ...

MAX_LINES: Final[int]
OUTLIER_ALPHA: Final[float]

@final
class Estimate:
    def __new__(
        cls,
        value: float,
        low: float | None,
        high: float | None,
    ) -> Self: ...
    @property
    def value(self) -> float: ...
    @property
    def low(self) -> float | None: ...
    @property
    def high(self) -> float | None: ...

@final
class TermEstimate:
    def __new__(
        cls,
        observed: bool,
        value: float | None,
        low: float | None,
        high: float | None,
        upper_limit: float | None,
        p_value: float | None,
        profile: Estimate | None,
    ) -> Self: ...
    @property
    def observed(self) -> bool: ...
    @property
    def value(self) -> float | None: ...
    @property
    def low(self) -> float | None: ...
    @property
    def high(self) -> float | None: ...
    @property
    def upper_limit(self) -> float | None: ...
    @property
    def p_value(self) -> float | None: ...
    @property
    def profile(self) -> Estimate | None: ...

@final
class GaussMarkovEstimate:
    def __new__(
        cls,
        sigma: Estimate,
        time: Estimate,
    ) -> Self: ...
    @property
    def sigma(self) -> Estimate: ...
    @property
    def time(self) -> Estimate: ...

@final
class ResonanceEstimate:
    def __new__(
        cls,
        sigma: Estimate,
        frequency: Estimate,
        width: Estimate,
    ) -> Self: ...
    @property
    def sigma(self) -> Estimate: ...
    @property
    def frequency(self) -> Estimate: ...
    @property
    def width(self) -> Estimate: ...

@final
class LineEstimate:
    def __new__(
        cls,
        amplitude: Estimate,
        frequency: Estimate,
    ) -> Self: ...
    @property
    def amplitude(self) -> Estimate: ...
    @property
    def frequency(self) -> Estimate: ...

@final
class WarmUpEstimate:
    def __new__(
        cls,
        amplitude: Estimate,
        time: float,
    ) -> Self: ...
    @property
    def amplitude(self) -> Estimate: ...
    @property
    def time(self) -> float: ...

@final
class MaternEstimate:
    def __new__(
        cls,
        observed: bool,
        sigma: Estimate,
        upper_limit: float | None,
        time: Estimate,
        smoothness: Estimate,
        terms: list[tuple[str, float]],
        gauss_markov: float,
        gain: float,
        p_value: float,
    ) -> Self: ...
    @property
    def observed(self) -> bool: ...
    @property
    def sigma(self) -> Estimate: ...
    @property
    def upper_limit(self) -> float | None: ...
    @property
    def time(self) -> Estimate: ...
    @property
    def smoothness(self) -> Estimate: ...
    @property
    def terms(self) -> list[tuple[str, float]]: ...
    @property
    def gauss_markov(self) -> float: ...
    @property
    def gain(self) -> float: ...
    @property
    def p_value(self) -> float: ...

@final
class FilterEstimate:
    def __new__(
        cls,
        coefficients: list[float],
        tau0: float,
        interval: float,
        shape: _Shape,
        order: int | None,
        corner: float | None,
        low: float | None,
        high: float | None,
        low_pass: tuple[int, float] | None,
        known_to: float | None,
        damping: float | None,
        analog: bool,
        of_white: bool,
    ) -> Self: ...
    @property
    def coefficients(self) -> list[float]: ...
    @property
    def tau0(self) -> float: ...
    @property
    def interval(self) -> float: ...
    @property
    def shape(self) -> _Shape: ...
    @property
    def order(self) -> int | None: ...
    @property
    def corner(self) -> float | None: ...
    @property
    def low(self) -> float | None: ...
    @property
    def high(self) -> float | None: ...
    @property
    def low_pass(self) -> tuple[int, float] | None: ...
    @property
    def known_to(self) -> float | None: ...
    @property
    def damping(self) -> float | None: ...
    @property
    def analog(self) -> bool: ...
    @property
    def of_white(self) -> bool: ...

@final
class SecondModel:
    def __new__(
        cls,
        terms: list[tuple[str, float]],
        gauss_markov: list[tuple[float, float]],
        warm_up: float | None,
        exponent: float | None,
        filter: float | None,  # noqa: A002
    ) -> Self: ...
    @property
    def terms(self) -> list[tuple[str, float]]: ...
    @property
    def gauss_markov(self) -> list[tuple[float, float]]: ...
    @property
    def warm_up(self) -> float | None: ...
    @property
    def exponent(self) -> float | None: ...
    @property
    def filter(self) -> float | None: ...

@final
class Parameter:
    def __new__(cls, part: str, number: int | None, quantity: _Quantity | None) -> Self: ...
    @property
    def part(self) -> str: ...
    @property
    def number(self) -> int | None: ...
    @property
    def quantity(self) -> _Quantity | None: ...

@final
class ChannelFit:
    def __new__(
        cls,
        terms: list[tuple[str, TermEstimate]],
        model: list[tuple[str, float]],
        unclear: list[str],
        gauss_markov: list[GaussMarkovEstimate],
        resonance: list[ResonanceEstimate],
        sinusoid: list[LineEstimate],
        response: FilterEstimate | None,
        warm_up: WarmUpEstimate | None,
        regressors: list[Estimate],
        highest: float | None,
        alike_from: float | None,
        alike_sigma: float | None,
        matern: MaternEstimate | None,
        second: list[SecondModel],
        discrepancy: list[tuple[float, float]],
        verdict: _Verdict,
        worst_band: tuple[float, float] | None,
        tau_min: float,
        tau_max: float,
        p_value: float,
        parameters: list[Parameter],
        covariance: list[float],
        levels: list[tuple[int, float, float]],
        left_out: list[tuple[float, float]],
        resonances: list[tuple[float, float, float]],
    ) -> Self: ...
    @property
    def terms(self) -> list[tuple[str, TermEstimate]]: ...
    @property
    def model(self) -> list[tuple[str, float]]: ...
    @property
    def unclear(self) -> list[str]: ...
    @property
    def gauss_markov(self) -> list[GaussMarkovEstimate]: ...
    @property
    def resonance(self) -> list[ResonanceEstimate]: ...
    @property
    def sinusoid(self) -> list[LineEstimate]: ...
    @property
    def response(self) -> FilterEstimate | None: ...
    @property
    def warm_up(self) -> WarmUpEstimate | None: ...
    @property
    def regressors(self) -> list[Estimate]: ...
    @property
    def highest(self) -> float | None: ...
    @property
    def alike_from(self) -> float | None: ...
    @property
    def alike_sigma(self) -> float | None: ...
    @property
    def matern(self) -> MaternEstimate | None: ...
    @property
    def second(self) -> list[SecondModel]: ...
    @property
    def discrepancy(self) -> list[tuple[float, float]]: ...
    @property
    def verdict(self) -> _Verdict: ...
    @property
    def worst_band(self) -> tuple[float, float] | None: ...
    @property
    def tau_min(self) -> float: ...
    @property
    def tau_max(self) -> float: ...
    @property
    def p_value(self) -> float: ...
    @property
    def parameters(self) -> list[Parameter]: ...
    @property
    def covariance(self) -> list[float]: ...
    @property
    def levels(self) -> list[tuple[int, float, float]]: ...
    @property
    def left_out(self) -> list[tuple[float, float]]: ...
    @property
    def resonances(self) -> list[tuple[float, float, float]]: ...

@final
class RunEstimate:
    def __new__(
        cls,
        values: list[tuple[str, Estimate]],
        own: list[tuple[str, Estimate]],
        p_value: float,
        cause: str,
        factor: float | None,
    ) -> Self: ...
    @property
    def values(self) -> list[tuple[str, Estimate]]: ...
    @property
    def own(self) -> list[tuple[str, Estimate]]: ...
    @property
    def p_value(self) -> float: ...
    @property
    def cause(self) -> str: ...
    @property
    def factor(self) -> float | None: ...

@final
class JointChannelFit:
    def __new__(
        cls,
        fit: ChannelFit,
        common: list[str],
        spreads: list[tuple[str, tuple[float, float]]],
        homogeneity: list[tuple[str, float]],
        runs: list[RunEstimate],
    ) -> Self: ...
    @property
    def fit(self) -> ChannelFit: ...
    @property
    def common(self) -> list[str]: ...
    @property
    def spreads(self) -> list[tuple[str, tuple[float, float]]]: ...
    @property
    def homogeneity(self) -> list[tuple[str, float]]: ...
    @property
    def runs(self) -> list[RunEstimate]: ...

@final
class FittedModel:
    def __new__(
        cls,
        tau0: float,
        samples: int,
        terms: Sequence[tuple[str, float]],
        gauss_markov: Sequence[tuple[float, float]],
        resonance: Sequence[tuple[float, float, float]],
        sinusoid: Sequence[tuple[float, float]],
        filter: FilterEstimate | None = None,  # noqa: A002
        highest: float | None = None,
        warm_up: tuple[float, float] | None = None,
    ) -> Self: ...
    def avar(self, m: _Ints) -> _Floats: ...
    def psd(self, f: _Floats) -> _Floats: ...
    def psd_before_filter(self, f: _Floats) -> _Floats: ...
    def degrees_of_freedom(self, m: _Ints) -> _Floats | None: ...
    def line_ranges(self, terms: Sequence[tuple[str, float]], start: float) -> list[tuple[float, float] | None]: ...

@final
class LikelihoodSummary:
    @property
    def duration(self) -> float: ...
    @property
    def centres(self) -> _Floats: ...
    @property
    def floor(self) -> float: ...
    @property
    def spacing(self) -> float: ...
    def is_same(self, other: LikelihoodSummary) -> bool: ...
    def weighting(self) -> tuple[float, float | None]: ...
    def fit(
        self,
        *,
        samples: int | None = None,
        terms: Sequence[str] | None = None,
        filter: bool = True,  # noqa: A002
        processes: bool = True,
        resonances: bool = True,
        lines: bool = True,
        drifts: bool = True,
        times: Sequence[float] = ...,
        matern: bool = False,
        regressors: Sequence[_Floats] = ...,
        level: float = 0.95,
        most_quantization: float = ...,
    ) -> ChannelFit: ...

def fit_jointly(
    runs: Sequence[tuple[LikelihoodSummary, Sequence[_Floats], int, Sequence[LineEstimate]]],
    *,
    terms: Sequence[str],
    common: Sequence[str],
    processes: bool = True,
    drifts: bool = True,
    times: Sequence[float] = ...,
    level: float = 0.95,
) -> JointChannelFit: ...

@final
class Accumulator:
    def __new__(cls, m: _Ints, strided: bool, start: int) -> Self: ...
    @staticmethod
    def restored(m: _Ints, strided: bool, start: int, state: NDArray[np.uint64]) -> Accumulator: ...
    def state(self) -> NDArray[np.uint64]: ...
    @property
    def start(self) -> int: ...
    @property
    def samples(self) -> int: ...
    def push(self, rate: _Floats) -> None: ...
    @staticmethod
    def first_unusable(rate: _Floats) -> int | None: ...
    def merge(self, later: Accumulator) -> None: ...
    def copy(self) -> Accumulator: ...
    def snapshot(self) -> tuple[_Ints, _Floats, _Floats, _Ints, _Ints]: ...

@final
class GlsComponents:
    def __new__(cls, n: int, m: _Ints, correlation_time: float | None, frequency: float | None) -> Self: ...
    def design(self) -> _Floats: ...
    def slopes(self) -> _Floats: ...
    def spectra(self) -> _Floats: ...
    def modes(self) -> _Floats: ...
    def degrees_of_freedom(self, theta: list[float], ramp: float) -> _Floats: ...
    def detectable(self, term: int, others: list[float], level: float, power: float) -> float: ...
    def least_ramp(self, theta: list[float], level: float, power: float) -> float: ...

@final
class Gls:
    def __new__(cls, parts: GlsComponents, avar: _Floats, candidates: list[int]) -> Self: ...
    @property
    def avar(self) -> _Floats: ...
    def expected(self, theta: list[float]) -> _Floats: ...
    def covariance(self, theta: list[float]) -> _Floats: ...
    def fit(self, active: list[int] | None, start: list[float] | None) -> list[float]: ...
    def covariance_of_theta(self, theta: list[float], active: list[int]) -> _Floats: ...
    def score(self, term: int, trial: float) -> tuple[float, float, float, _Floats]: ...
    def evidence(self, term: int, theta: list[float], level: float) -> tuple[float, float, float]: ...
    def p_value(self, theta: list[float]) -> float: ...
    def deviance(self, theta: list[float]) -> float: ...
    def ramp_weights(self, theta: list[float]) -> _Floats: ...
    def without_ramp(self, weights: _Floats, ramps: _Floats) -> Gls: ...

class NonFinite(ValueError): ...
class TextError(ValueError): ...

def all_finite(columns: list[_Floats]) -> list[bool]: ...
def allan_variances(
    columns: list[_Floats], m: _Ints, overlapped: bool, paper: bool, threads: int
) -> tuple[list[_Floats], list[_Floats], _Ints]: ...
def covariance_tensors(n: int, m: _Ints, tau0: float, correlation_times: list[float]) -> tuple[_Floats, _Floats]: ...
def deviation_limits(kind: str, samples: int) -> tuple[int, int, int]: ...
def deviations_of_channels(
    kind: str, columns: list[_Floats], m: _Ints, overlapped: bool, threads: int
) -> tuple[list[_Floats], _Ints]: ...
def distribution(name: str, x: _Floats) -> _Floats: ...
def distribution_of_shape(name: str, shape: _Floats, x: _Floats) -> _Floats: ...
def masked_variances(
    column: _Floats, m: _Ints, overlapped: bool, paper: bool, threads: int
) -> tuple[_Floats, _Floats, _Ints]: ...

@final
class CurveFit:
    def __new__(
        cls,
        adequate: bool,
        first: int,
        p_value: float | None,
        no_covariance: bool,
        terms: list[tuple[str, TermEstimate]],
        model: list[tuple[str, float]],
        unclear: list[str],
        gauss_markov: list[GaussMarkovEstimate],
        parameters: list[Parameter],
        covariance: list[float],
        worst: tuple[int, float] | None,
    ) -> Self: ...
    @property
    def adequate(self) -> bool: ...
    @property
    def first(self) -> int: ...
    @property
    def p_value(self) -> float | None: ...
    @property
    def no_covariance(self) -> bool: ...
    @property
    def terms(self) -> list[tuple[str, TermEstimate]]: ...
    @property
    def model(self) -> list[tuple[str, float]]: ...
    @property
    def unclear(self) -> list[str]: ...
    @property
    def gauss_markov(self) -> list[GaussMarkovEstimate]: ...
    @property
    def parameters(self) -> list[Parameter]: ...
    @property
    def covariance(self) -> list[float]: ...
    @property
    def worst(self) -> tuple[int, float] | None: ...

def fit_curve(
    n: int,
    m: _Ints,
    avar: _Floats,
    ramps: _Floats,
    *,
    tau0: float,
    scale: float,
    terms: Sequence[str],
    first: int | None,
    level: float,
    digitising: _Floats | None,
) -> CurveFit: ...
def from_sides(x: _Floats, at: _Ints, side: int) -> _Floats: ...
def neighbour_medians(x: _Floats, side: int, least: int) -> _Floats: ...
def neighbour_scatter(x: _Floats, at: _Ints, quantile: list[float]) -> _Floats: ...
def non_negative(columns: _Floats, target: _Floats) -> _Floats: ...
def outliers(x: _Floats, limits: list[float], side: int, quantile: list[float]) -> _Ints: ...
def quadratic_edf(kind: str, samples: int, m: _Ints, coefficients: dict[str, float], tau0: float) -> _Floats: ...
def stationary_moments(
    kind: str, overlapped: bool, samples: int, m: _Ints, coefficients: dict[str, float], tau0: float
) -> tuple[_Floats, _Floats]: ...
def theo1_expectation(m: _Ints, coefficients: dict[str, float], tau0: float) -> _Floats: ...
def total_bias(kind: str, m: _Ints, coefficients: dict[str, float], tau0: float) -> _Floats: ...
def term_avar(
    term: str, coefficient: float, m: _Ints, tau0: float, cutoff: float | None, averaged: bool
) -> _Floats: ...
def term_psd(term: str, coefficient: float, f: _Floats, tau0: float | None) -> _Floats: ...
def gauss_markov_avar(sigma: float, time: float, m: _Ints, tau0: float, averaged: bool) -> _Floats: ...
def resonance_avar(sigma: float, frequency: float, width: float, m: _Ints, tau0: float, folded: bool) -> _Floats: ...
def resonance_folds(sigma: float, frequency: float, width: float, tau0: float, random_walk: float) -> bool: ...
def resonance_psd(sigma: float, frequency: float, width: float, f: _Floats) -> _Floats: ...
def sinusoid_avar(amplitude: float, frequency: float, m: _Ints, tau0: float) -> _Floats: ...
def matern_processes(smoothness: float, time: float, step: float) -> tuple[_Floats, _Floats]: ...
def gauss_markov_psd(sigma: float, time: float, f: _Floats, tau0: float | None) -> _Floats: ...
def band_limited_psd(random_walk: float, order: int, corner: float, f: _Floats, tau0: float | None) -> _Floats: ...
def band_limited_avar(random_walk: float, shape: str, corner: float, m: _Ints, tau0: float) -> _Floats: ...
def strides(m: _Ints) -> _Ints: ...

@final
class Generator:
    def __new__(cls, n: int, tau0: float, seed: int) -> Self: ...
    def add_term(self, term: str, value: float, channel: int, poles: bool) -> None: ...
    def add_filtered(
        self, scale: float, transition: list[float], noise: list[float], start: list[float], channel: int
    ) -> None: ...
    def add_gauss_markov(self, sigma: float, time: float, index: int, channel: int) -> None: ...
    def add_sinusoid(self, amplitude: float, frequency: float, index: int, channel: int) -> None: ...
    def fill(self, rate: _Floats) -> None: ...

def flicker_poles(n: int) -> tuple[_Floats, _Floats]: ...
def read_sentences(
    path: str, name: str, fields: int, wanted: list[int], most: int
) -> tuple[list[_Floats], int, int, list[tuple[int, str]], tuple[int, tuple[int, int], str], bool]: ...
def read_text(
    path: str,
    delimiter: str | None,
    comment: list[str],
    skip_lines: int,
    columns: int,
    wanted: list[int],
    exact: int | None,
    writing: tuple[str, bool, int | None, str | None, bool, int, tuple[int, str] | None],
) -> tuple[list[_Floats], _Ints | None, tuple[int, int, list[tuple[int, str]]], bool]: ...
def parse_text(
    lines: bytes,
    delimiter: str | None,
    comment: list[str],
    skip_lines: int,
    columns: int,
    wanted: list[int],
    exact: int | None,
    writing: tuple[str, bool, int | None, str | None, bool, int, tuple[int, str] | None],
) -> tuple[list[_Floats], _Ints | None, tuple[int, int, list[tuple[int, str]]], bool]: ...
def parse_stamp(text: str, order: str) -> tuple[Literal["date", "day", "clock", "minutes"], int, bool] | None: ...
def scan_dataflash(path: str) -> dict[str, Any]: ...
def dataflash_columns(
    path: str,
    end: int,
    kind: int,
    instance: tuple[int, int] | None,
    rows: int,
    size: int,
    fields: list[tuple[int, int]],
) -> list[NDArray[np.uint8]]: ...
def bytes_read() -> int: ...
def scan_ulog(path: str) -> dict[str, Any]: ...
def ulog_columns(
    path: str, end: int, number: int, rows: int, size: int, fields: list[tuple[int, int]]
) -> list[NDArray[np.uint8]]: ...
def unpacked(data: bytes) -> bytes | None: ...
def format_text(delimiter: str, columns: list[_Floats]) -> bytes: ...

_Steps = list[tuple[str, int, int]]
_Decoded = tuple[list[_Floats], _Ints | None, int]
_End = tuple[str, int, str]

def log_contents(
    path: str, bag: bool, most: int
) -> tuple[list[tuple[str, int, str, str, bytes, str, int]], bool, _End]: ...
def log_messages(
    path: str,
    bag: bool,
    channels: list[int],
    steps: _Steps,
    cdr: bool,
    wanted: list[int],
    exact: int | None,
    most: int,
) -> tuple[_Decoded, _End]: ...
def decode_messages(
    data: bytes,
    ends: _Ints,
    log_times: _Ints,
    steps: _Steps,
    cdr: bool,
    wanted: list[int],
    exact: int | None,
) -> _Decoded: ...
