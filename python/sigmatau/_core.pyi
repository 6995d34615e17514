# The compiled core as Python sees it; crates/py/src/lib.rs is the other side, mypy.stubtest holds the two together.

from typing import Any, Self, final

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "Accumulator",
    "Factor",
    "Generator",
    "LikelihoodPass",
    "LikelihoodSummary",
    "NonFinite",
    "TextError",
    "all_finite",
    "allan_variance_variances",
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
    "flicker_poles",
    "format_text",
    "from_sides",
    "gauss_markov_avar",
    "gauss_markov_psd",
    "log_contents",
    "log_messages",
    "masked_variances",
    "neighbour_medians",
    "neighbour_scatter",
    "outliers",
    "parse_text",
    "quadratic_edf",
    "read_sentences",
    "read_text",
    "scan_dataflash",
    "scan_ulog",
    "sinusoid_avar",
    "stationary_moments",
    "strides",
    "term_avar",
    "term_psd",
    "theo1_expectation",
    "ulog_columns",
    "unpacked",
    "write_text",
]

_Floats = NDArray[np.float64]
_Ints = NDArray[np.int64]

@final
class LikelihoodPass:
    def __new__(cls, samples: int, tau0: float) -> Self: ...
    @staticmethod
    def masked(present: NDArray[np.bool_], tau0: float, taper: float) -> LikelihoodPass: ...
    def push(self, rate: _Floats) -> None: ...
    def finish(self) -> LikelihoodSummary: ...

@final
class LikelihoodSummary:
    @property
    def samples(self) -> int: ...
    @property
    def centres(self) -> _Floats: ...
    @property
    def periodogram(self) -> tuple[_Floats, _Floats]: ...
    def run_taper(self) -> float: ...
    def analyse(
        self,
        terms: list[bool],
        filter: bool,  # noqa: A002
        processes: bool,
        resonances: bool,
        lines: bool,
        drifts: bool,
        times: list[float],
        regressors: list[_Floats],
        level: float,
    ) -> dict[str, Any]: ...

@final
class Accumulator:
    def __new__(cls, m: _Ints, strided: bool, start: int) -> Self: ...
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
class Factor:
    def __new__(cls, covariance: _Floats, order: int) -> Self: ...
    def whiten(self, columns: _Floats) -> _Floats: ...
    def unwhiten(self, weights: _Floats) -> _Floats: ...

class NonFinite(ValueError): ...
class TextError(ValueError): ...

def all_finite(columns: list[_Floats]) -> list[bool]: ...
def allan_variances(
    columns: list[_Floats], m: _Ints, overlapped: bool, paper: bool, threads: int
) -> tuple[list[_Floats], list[_Floats], _Ints]: ...
def allan_variance_variances(
    n: int, m: _Ints, theta: list[float], correlation_times: list[float], ramp: float
) -> _Floats: ...
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
def from_sides(x: _Floats, at: _Ints, side: int) -> _Floats: ...
def neighbour_medians(x: _Floats, side: int, least: int) -> _Floats: ...
def neighbour_scatter(x: _Floats, at: _Ints, quantile: list[float]) -> _Floats: ...
def outliers(x: _Floats, limits: list[float], side: int, quantile: list[float]) -> _Ints: ...
def quadratic_edf(kind: str, samples: int, m: _Ints, coefficients: list[float], tau0: float) -> _Floats: ...
def stationary_moments(
    kind: str, overlapped: bool, samples: int, m: _Ints, coefficients: list[float], tau0: float
) -> tuple[_Floats, _Floats]: ...
def theo1_expectation(m: _Ints, coefficients: list[float], tau0: float) -> _Floats: ...
def term_avar(
    term: str, coefficient: float, m: _Ints, tau0: float, cutoff: float | None, averaged: bool
) -> _Floats: ...
def term_psd(term: str, coefficient: float, f: _Floats, tau0: float | None) -> _Floats: ...
def gauss_markov_avar(sigma: float, time: float, m: _Ints, tau0: float, averaged: bool) -> _Floats: ...
def sinusoid_avar(amplitude: float, frequency: float, m: _Ints, tau0: float) -> _Floats: ...
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
    writing: tuple[str, bool, int | None, bool, int],
) -> tuple[list[_Floats], _Ints | None, tuple[int, int, int, int, list[tuple[int, str]]], bool]: ...
def parse_text(
    lines: bytes,
    delimiter: str | None,
    comment: list[str],
    skip_lines: int,
    columns: int,
    wanted: list[int],
    exact: int | None,
    writing: tuple[str, bool, int | None, bool, int],
) -> tuple[list[_Floats], _Ints | None, tuple[int, int, int, int, list[tuple[int, str]]], bool]: ...
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
def format_text(header: str | None, delimiter: str, columns: list[_Floats]) -> bytes: ...
def write_text(path: str, header: str | None, delimiter: str, columns: list[_Floats], gzip: bool) -> None: ...

_Steps = list[tuple[str, int, int]]
_Decoded = tuple[list[_Floats], _Ints | None, int]
_End = tuple[str, int, str]

def log_contents(path: str, bag: bool) -> tuple[list[tuple[str, int, str, str, bytes, str, int]], bool, _End]: ...
def log_messages(
    path: str,
    bag: bool,
    channels: list[int],
    steps: _Steps,
    cdr: bool,
    wanted: list[int],
    exact: int | None,
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
