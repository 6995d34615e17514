"""Compiled numerics, with their errors. Conversions and checks are in `sigmatau._native.arguments`.

Arrays are contiguous float64, both as arguments and as results.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sigmatau import _core
from sigmatau._native.arguments import (
    check_counting,
    check_overlap,
    check_threads,
    contiguous,
    non_finite,
    whole_sizes,
)
from sigmatau.errors import OptionError, RecordTooShortError


class RunningSums:
    """Running sums of one channel; see `sigmatau.estimators.accumulator.Accumulator`.

    Parameters
    ----------
    m : ndarray of int
        Cluster sizes; if `strided`, multiples of their strides.
    strided : bool
        Whether memory is bounded: clusters of more than 4096 samples then begin at some of the samples only.
    start : int
        Index in the record of the first sample.
    name : str
        Name of the channel, for errors.
    """

    __slots__ = ("_made", "_sums", "name")

    def __init__(self, m: NDArray[np.int64], *, strided: bool, start: int, name: str) -> None:
        self.name = name
        self._made = (np.ascontiguousarray(m, dtype=np.int64), strided, start)
        self._sums = _core.Accumulator(*self._made)

    def __getstate__(self) -> tuple[object, ...]:
        return self.name, self._made, self._sums.state()

    def __setstate__(self, state: tuple[str, tuple[NDArray[np.int64], bool, int], NDArray[np.uint64]]) -> None:
        self.name, self._made, sums = state
        self._sums = _core.Accumulator.restored(*self._made, sums)

    @property
    def samples(self) -> int:
        """Samples received."""
        return self._sums.samples

    def push(self, rate: NDArray[np.float64]) -> None:
        """Add samples, which must all be finite."""
        self._sums.push(rate)

    @staticmethod
    def first_unusable(rate: NDArray[np.float64]) -> int | None:
        """Index of the first sample that is not finite or larger than 1e130, if there is one."""
        return _core.Accumulator.first_unusable(rate)

    def merge(self, later: RunningSums) -> None:
        """Add the sums of the accumulator of the next stretch; raises ValueError for any other stretch."""
        self._sums.merge(later._sums)

    def copy(self) -> RunningSums:
        """An accumulator with the same sums."""
        twin = object.__new__(RunningSums)
        twin.name, twin._made, twin._sums = self.name, self._made, self._sums.copy()
        return twin

    def snapshot(
        self,
    ) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]:
        """Cluster sizes, variances, ramps per sample, pairs and strides, for the sizes with at least one pair."""
        return self._sums.snapshot()


def strides(m: ArrayLike) -> NDArray[np.int64]:
    """Distance between the starts of the clusters of each size, in bounded memory."""
    return _core.strides(whole_sizes(m))


def all_finite(arrays: Sequence[NDArray[np.float64]]) -> list[bool]:
    """For each array, whether all numbers are known to be finite; False if the array is not contiguous."""
    flat = [a.reshape(-1) for a in arrays if a.flags.c_contiguous]
    finite = iter(_core.all_finite(flat))
    return [bool(a.flags.c_contiguous and next(finite)) for a in arrays]


def allan_variances(
    columns: Sequence[ArrayLike],
    m: NDArray[np.int64],
    *,
    overlap: str,
    counting: str,
    threads: int | None,
    names: Sequence[str],
) -> tuple[list[NDArray[np.float64]], list[NDArray[np.float64]], NDArray[np.int64]]:
    """Allan variances of several channels of one length; see `sigmatau.estimators.allan.allan`.

    Returns
    -------
    variances : list of ndarray, shape (n_tau,)
        By channel.
    ramps : list of ndarray, shape (n_tau,)
        Change of the rate per sample, by channel: mean of all overlapping second differences of the phase, over m².
    pairs : ndarray of int, shape (n_tau,)
    """
    check_overlap(overlap)
    check_counting(counting)
    check_threads(threads)
    arrays = contiguous(columns, names)
    sizes = np.ascontiguousarray(m, dtype=np.int64)
    n = len(arrays[0])
    least_pairs = 1 if counting == "standard" or overlap == "none" else 2
    if sizes.size == 0 or sizes.min() < 1 or n + 1 - 2 * int(sizes.max()) < least_pairs:
        sizes = sizes[(sizes >= 1) & (n + 1 - 2 * sizes >= least_pairs)]
        raise RecordTooShortError(
            f"{n} samples do not make two clusters of {int(m.max()) if m.size else 0}", need=2 * int(m.max()), got=n
        )
    try:
        variances, ramps, pairs = _core.allan_variances(
            arrays, sizes, overlap == "full", counting == "paper", threads or 0
        )
    except _core.NonFinite as error:
        raise non_finite(error, arrays, names) from None
    return variances, ramps, pairs


def masked_variances(
    column: ArrayLike, m: NDArray[np.int64], *, overlap: str, counting: str, threads: int | None, name: str
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int64]]:
    """Allan variances, ramps per sample and pairs of one channel whose missing samples are NaN; see
    `sigmatau.allan`.

    A size without a pair of clusters at least half full has 0 pairs, and NaN.
    """
    check_overlap(overlap)
    check_counting(counting)
    check_threads(threads)
    (array,) = contiguous([column], [name])
    sizes = np.ascontiguousarray(m, dtype=np.int64)
    try:
        return _core.masked_variances(array, sizes, overlap == "full", counting == "paper", threads or 0)
    except _core.NonFinite as error:
        raise non_finite(error, [array], [name]) from None


def deviation_limits(kind: str, n: int) -> tuple[int, int, int]:
    """Smallest and largest cluster size of an estimator, and the smallest number of samples that it accepts."""
    return _core.deviation_limits(kind, n)


def deviations(
    kind: str,
    columns: Sequence[ArrayLike],
    m: NDArray[np.int64],
    *,
    overlap: str,
    threads: int | None,
    names: Sequence[str],
) -> tuple[list[NDArray[np.float64]], NDArray[np.int64]]:
    """Deviations of several channels of one length, and how many terms each averages; see `sigmatau.deviation`.

    Deviations in the unit of the phase are returned as rate times samples.
    """
    check_overlap(overlap)
    check_threads(threads)
    arrays = contiguous(columns, names)
    sizes = np.ascontiguousarray(m, dtype=np.int64)
    try:
        return _core.deviations_of_channels(kind, arrays, sizes, overlap == "full", threads or 0)
    except _core.NonFinite as error:
        raise non_finite(error, arrays, names) from None


def stationary_moments(
    kind: str, *, overlap: str, n: int, m: ArrayLike, coefficients: Mapping[str, float], tau0: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Expected variances and degrees of freedom of ``"allan"``, ``"modified"`` or ``"hadamard"`` variances."""
    return _core.stationary_moments(kind, overlap == "full", n, whole_sizes(m), dict(coefficients), tau0)


def quadratic_edf(
    kind: str, *, n: int, m: ArrayLike, coefficients: Mapping[str, float], tau0: float
) -> NDArray[np.float64]:
    """Degrees of freedom of an estimator without stationary terms, such as ``"total"``."""
    try:
        return _core.quadratic_edf(kind, n, whole_sizes(m), dict(coefficients), tau0)
    except ValueError as error:
        if "quantization" in str(error):
            raise OptionError(
                f"the degrees of freedom of {kind!r} are not known beyond 48 samples of averaging where quantization"
                " noise exceeds 1 % of the variance: leave it out of {option}, or take the modified or the Hadamard"
                " deviation",
                option="noise",
            ) from None
        raise


def theo1_expectation(m: ArrayLike, coefficients: Mapping[str, float], tau0: float) -> NDArray[np.float64]:
    """Expected Theo1 variances at the even sizes `m`."""
    return _core.theo1_expectation(whole_sizes(m), dict(coefficients), tau0)


def total_bias(kind: str, m: ArrayLike, coefficients: Mapping[str, float], tau0: float) -> NDArray[np.float64]:
    """Expected ``"modified_total"`` variances over modified ones, or ``"hadamard_total"`` over Hadamard variances."""
    return _core.total_bias(kind, whole_sizes(m), dict(coefficients), tau0)


def term_avar(
    term: str,
    coefficient: float,
    m: ArrayLike,
    tau0: float,
    *,
    cutoff: float | None = None,
    averaged: bool = False,
) -> NDArray[np.float64]:
    """Expected Allan variance of one term; see `sigmatau.noise.terms.avar`."""
    return _core.term_avar(term, coefficient, whole_sizes(m), tau0, cutoff, averaged)


def term_psd(term: str, coefficient: float, f: NDArray[np.float64], tau0: float | None) -> NDArray[np.float64]:
    """Two-sided power spectral density of one term; see `sigmatau.noise.terms.psd`."""
    return _core.term_psd(term, coefficient, np.ascontiguousarray(f, dtype=np.float64), tau0)


def gauss_markov_avar(
    sigma: float, time: float, m: ArrayLike, tau0: float, *, averaged: bool = False
) -> NDArray[np.float64]:
    """Expected Allan variance of a first-order Gauss-Markov process, sampled or averaged over each sample."""
    return _core.gauss_markov_avar(sigma, time, whole_sizes(m), tau0, averaged)


def matern_processes(smoothness: float, time: float, step: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The Matérn process of unit variance as a sum of Gauss-Markov processes: variances and correlation times in samples.

    `time` is in samples too; the error of the sum is e^(−2π²/step).
    """
    return _core.matern_processes(smoothness, time, step)


def sinusoid_avar(amplitude: float, frequency: float, m: ArrayLike, tau0: float) -> NDArray[np.float64]:
    """Expected Allan variance of a sampled sinusoid of random phase."""
    return _core.sinusoid_avar(amplitude, frequency, whole_sizes(m), tau0)


def band_limited_avar(random_walk: float, shape: str, corner: float, m: ArrayLike, tau0: float) -> NDArray[np.float64]:
    """Expected Allan variance of sampled white noise after a low-pass filter.

    `shape` is ``"butterworth1"`` (or ``"first_order"``) … ``"butterworth9"``, or ``"brick_wall"``; `corner` in Hz.
    """
    return _core.band_limited_avar(random_walk, shape, corner, whole_sizes(m), tau0)


def gauss_markov_psd(sigma: float, time: float, f: NDArray[np.float64], tau0: float | None) -> NDArray[np.float64]:
    """Two-sided density of a first-order Gauss-Markov process, sampled if `tau0` is given."""
    return _core.gauss_markov_psd(sigma, time, np.ascontiguousarray(f, dtype=np.float64), tau0)


def resonance_avar(
    sigma: float, frequency: float, width: float, m: NDArray[np.int64], tau0: float, *, folded: bool = True
) -> NDArray[np.float64]:
    """Allan variances of a sampled resonance.

    Without `folded`, the part that sampling folds from above half the rate is omitted, as in a fit of the spectrum.
    """
    sizes = np.ascontiguousarray(m, dtype=np.int64)
    return _core.resonance_avar(sigma, frequency, width, sizes, tau0, folded)


def resonance_psd(sigma: float, frequency: float, width: float, f: NDArray[np.float64]) -> NDArray[np.float64]:
    """Two-sided density of a resonance: 0 at the frequency 0."""
    return _core.resonance_psd(sigma, frequency, width, np.ascontiguousarray(f, dtype=np.float64))


def resonance_folds(sigma: float, frequency: float, width: float, tau0: float, *, random_walk: float) -> bool:
    """Whether sampling folds a resonance into the white noise at low frequencies, which a fit of the spectrum does not show.
    A model without the resonance then describes longer averaging times better.
    """
    return _core.resonance_folds(sigma, frequency, width, tau0, random_walk)


def band_limited_psd(
    random_walk: float, order: int, corner: float, f: NDArray[np.float64], tau0: float | None
) -> NDArray[np.float64]:
    """Two-sided density of white noise after a Butterworth filter, folded by sampling if `tau0` is given."""
    return _core.band_limited_psd(random_walk, order, corner, np.ascontiguousarray(f, dtype=np.float64), tau0)


def covariance_tensors(
    n: int, m: NDArray[np.int64], tau0: float, *, correlation_times: Sequence[float] = ()
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Tensors from which the covariance of overlapped Allan variances is computed; see
    `sigmatau.noise.uncertainty.avar_covariance`.

    Returns
    -------
    noise : ndarray, shape (n_terms, n_terms, n_tau, n_tau)
        Contracted with the squared coefficients twice; terms in the order quantization, random walk, bias instability,
        rate random walk, then a Gauss-Markov process, given by its variance, for each of the `correlation_times`. [s]
    ramp : ndarray, shape (n_terms, n_tau, n_tau)
        Contracted with the squared coefficients once, times the ramp squared.
    """
    times = [float(time) for time in correlation_times]
    noise, ramp = _core.covariance_tensors(n, np.ascontiguousarray(m, dtype=np.int64), tau0, times)
    k, terms = len(m), 4 + len(times)
    return noise.reshape(terms, terms, k, k), ramp.reshape(terms, k, k)
