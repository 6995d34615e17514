"""Densities for eq. (11): sampled ones and functions, checked and two-sided."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sigmatau.arrays import Floats
from sigmatau.errors import DataError
from sigmatau.model.density_pieces import Between, Pieces
from sigmatau.model.transform import Density, integrate_density

_LARGEST_DENSITY = 1e250  # its integrals are doubles [unit²/Hz]
_HERMITIAN = 1e-9  # largest relative difference of two elements that counts as rounding


class SampledDensity:
    """A sampled density, two-sided and checked."""

    def __init__(self, frequency: ArrayLike, density: ArrayLike, factor: float, between: Between) -> None:
        f = rising_frequencies(frequency)
        values = np.asarray(density)
        if values.dtype.kind not in "fiuc":
            raise DataError(f"`density` must have numbers, not {values.dtype}")
        if (
            values.shape[:1] != f.shape
            or values.ndim not in (1, 3)
            or (values.ndim == 3 and values.shape[1] != values.shape[2])
        ):
            raise DataError(
                f"`density` has the shape {values.shape}; want ({len(f)},) as `frequency`, or ({len(f)}, n, n) for"
                " n channels"
            )
        check_density(values, f)
        self.density: Floats = np.asarray(values.real, dtype=np.float64) * factor
        self.f_min: float = float(f[0])
        self.f_max: float = float(f[-1])
        self.pieces: Pieces = Pieces(f, self.density, between)

    def edge(self, end: int) -> Floats:
        """Densities of the channels at the lower (0) or upper (1) end of the band."""
        return np.atleast_1d(channel_densities(self.density)[-end])

    def avar(self, times: Floats, _: float, tau0: float | None) -> Floats:
        return np.array([self.pieces.integral(time, tau0) for time in times.tolist()])


class FunctionDensity:
    """A density that is a function of the frequency."""

    def __init__(self, frequency: ArrayLike, density: Density, factor: float) -> None:
        band = np.asarray(frequency)
        if band.shape != (2,) or band.dtype.kind not in "fiu" or not 0 <= band[0] < band[1]:
            raise DataError(
                f"`frequency` must be the two ends of the band of the function, e.g. (0, inf), not {frequency!r}"
            )
        self.f_min: float = float(band[0])
        self.f_max: float = float(band[1])
        self.function: Density = density
        self.factor: float = factor
        inside = self.f_min + 1 if math.isinf(self.f_max) else (self.f_min + self.f_max) / 2
        shape = np.shape(density(np.array([inside, inside])))
        self.channels: int = shape[1] if len(shape) == 3 and shape[1] == shape[2] else 0

    def values(self, f: Floats) -> NDArray[Any]:
        """Two-sided density or matrix, checked."""
        values = np.asarray(self.function(f))
        if values.dtype.kind not in "fiuc":
            raise DataError(f"`density` must return numbers, not {values.dtype}")
        if self.channels and values.shape != (len(f), self.channels, self.channels):
            raise DataError(
                f"`density` returned the shape {values.shape} for {len(f)} frequencies; it must return a matrix for each"
            )
        if self.channels:
            check_density(values, f)
        return np.asarray(values.real * self.factor)

    def edge(self, end: int) -> Floats:
        """Densities of the channels at an end of the band; 0 at an infinite end."""
        f = (self.f_min, self.f_max)[end]
        if f == 0 or math.isinf(f):
            return np.zeros(max(self.channels, 1))
        values = self.values(np.array([f]))
        return np.atleast_1d(channel_densities(values)[0] if self.channels else np.broadcast_to(values, (1,))[0])

    def avar(self, times: Floats, f_max: float, tau0: float | None) -> Floats:
        def integrated(function: Density) -> Floats:
            top = None if math.isinf(f_max) else f_max
            return integrate_density(function, times, tau0=tau0, f_min=self.f_min, f_max=top)

        if not self.channels:
            return integrated(self.values)
        result = np.zeros((len(times), self.channels, self.channels))
        for i in range(self.channels):
            for j in (i, *range(i)):
                # The density of the sum of two channels is not negative; a cross-density can be.
                both = integrated(partial(self._sum_density, np.unique([i, j])))
                result[:, i, j] = result[:, j, i] = both if i == j else (both - result[:, i, i] - result[:, j, j]) / 2
        return result

    def _sum_density(self, channels: NDArray[np.intp], f: Floats) -> Floats:
        """The density of the sum of some channels."""
        return np.asarray(self.values(f)[:, channels][:, :, channels].sum(axis=(1, 2)).clip(min=0.0))


def channel_densities(values: NDArray[Any]) -> NDArray[Any]:
    """Densities of the channels: the diagonals of matrices, or the values of a single channel."""
    return np.asarray(values if values.ndim == 1 else np.einsum("kii->ki", values))


def rising_frequencies(frequency: ArrayLike) -> Floats:
    """Frequencies as an array; raises `DataError` unless they are positive and rise."""
    f = np.asarray(frequency)
    if f.ndim != 1 or f.dtype.kind not in "fiu" or len(f) < 2:
        raise DataError(
            f"`frequency` must be two or more numbers of Hz, shape (n_f,), not {f.dtype} of shape {f.shape}"
        )
    f = f.astype(np.float64)
    wrong = np.flatnonzero(~(np.isfinite(f) & (f > 0)))
    if len(wrong):
        advice = "; leave out the density at 0 Hz" if f[wrong[0]] == 0 else ""
        raise DataError(f"`frequency` must be above 0 Hz, but is {f[wrong[0]]:g} at index {wrong[0]}{advice}")
    fall = np.flatnonzero(np.diff(f) <= 0)
    if len(fall):
        k = int(fall[0])
        raise DataError(
            f"`frequency` must rise, but is {f[k + 1]:g} Hz at index {k + 1} after {f[k]:g} Hz; sort both arrays by it"
        )
    return f


def check_density(values: NDArray[Any], f: Floats) -> None:
    """Raise `DataError` for a density that is negative or not finite, or a matrix that is not Hermitian and positive."""
    flat = values.reshape(len(f), -1)
    wrong = np.flatnonzero(~np.isfinite(flat).all(axis=1))
    if len(wrong):
        raise DataError(
            f"`density` is not finite at index {wrong[0]} ({f[wrong[0]]:g} Hz); leave out these frequencies"
        )
    wrong = np.flatnonzero((np.abs(flat) > _LARGEST_DENSITY).any(axis=1))
    if len(wrong):
        raise DataError(
            f"`density` is beyond {_LARGEST_DENSITY:g} at index {wrong[0]} ({f[wrong[0]]:g} Hz); leave out these frequencies"
        )
    if values.ndim == 1:
        if np.iscomplexobj(values) and values.imag.any():
            raise DataError(
                "`density` of one channel must be real; a cross-density is an element of a matrix (n_f, n, n)"
            )
        wrong = np.flatnonzero(values.real < 0)
        if len(wrong):
            k = int(wrong[0])
            raise DataError(
                f"`density` is {values.real[k]:g} at index {k} ({f[k]:g} Hz), but cannot be negative; give it in unit²/Hz,"
                " not in dB"
            )
        return
    size = np.abs(flat).max(axis=1)
    not_hermitian = np.abs(values - values.conj().swapaxes(1, 2)).max(axis=(1, 2)) > _HERMITIAN * size
    not_positive = np.linalg.eigvalsh(values)[:, 0] < -_HERMITIAN * size
    for bad, what in (
        (not_hermitian, "not Hermitian"),
        (not_positive, "not positive: a coherence is above 1, or a density negative"),
    ):
        wrong = np.flatnonzero(bad)
        if len(wrong):
            raise DataError(f"the matrix of `density` at index {wrong[0]} ({f[wrong[0]]:g} Hz) is {what}")
