"""Run of a filter, reconstructed from its matrices and the stated S: the contribution of each noise to its innovations.

With a gain K the error x of the prediction evolves as x' = F·(I − K·H)·x − F·K·v + w, and the innovation is H·x + v, with
the noise v of the measurement and w of the process. A constant gain gives the density of the innovations in closed form.
If S, the interval or the measurements vary, the gain of each step follows from the stated S, and the density is the mean
power of the periodogram, computed by the adjoint recursion.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from sigmatau.arrays import Bools, Floats
from sigmatau.errors import DataError, OptionError
from sigmatau.exporting.tuning.innovations import Innovations
from sigmatau.frozen import frozen

Complex = NDArray[np.complex128]

MEASUREMENT = "measurement"

_PASSES = 3  # number of passes over the run; each starts from the mean covariance of the previous pass
_NEGATIVE_SHARE = 0.01  # largest share of the steps in which S may be below H·P·Hᵀ by rounding
_SMALLEST_R = 1e-9  # smallest ratio of R to S
_LARGEST_SHARE = 0.5  # largest share of H·P·Hᵀ in the first S, if P is a mean over the run
_TINY = 1e-300
_CORRELATION = 0.1  # correlation of the noises of two measurements above which their factors cannot be separated
_CHUNK = 1 << 22  # number of complex values of the adjoint in memory


@frozen(eq=False)
class Steps:
    """Matrices of a filter for each of its measurements, or one set for all.

    Attributes
    ----------
    transition : ndarray, shape (n or 1, n_states, n_states)
        F from this measurement to the next one. [of the states]
    rows : ndarray, shape (n or 1, n_measurements, n_states)
        H. [of the states]
    process : dict of str to ndarray, shape (n or 1, n_states, n_states)
        Q of the same step, by noise. [of the states]
    """

    transition: Floats
    rows: Floats
    process: dict[str, Floats]


@frozen(eq=False)
class FilterRun:
    """Filter during its run.

    Attributes
    ----------
    noises : tuple of str
        Names of the noises of each measurement, then of the process.
    closed : ndarray, shape (n or 1, n_states, n_states)
        F·(I − K·H).
    gain : ndarray, shape (n or 1, n_states, n_measurements)
        F·K; 0 for an absent measurement.
    rows : ndarray, shape (n or 1, n_measurements, n_states)
        H.
    process : ndarray, shape (n_process, n or 1, n_states, n_states)
        Q by noise.
    measured : ndarray, shape (n or 1, n_measurements)
        R; 0 for an absent measurement.
    whitening : ndarray, shape (n or 1, n_measurements, n_measurements)
        Inverse of the Cholesky root of S.
    presence : ndarray, shape (n_measurements,)
        Share of the steps with each measurement.
    """

    noises: tuple[str, ...]
    closed: Floats
    gain: Floats
    rows: Floats
    process: Floats
    measured: Floats
    whitening: Floats
    presence: Floats

    def respond(self, errors: Floats, start: Floats | None = None) -> Floats:
        """Compute the innovations due to errors of the measurement and of the first state.

        Parameters
        ----------
        errors : ndarray, shape (n, n_measurements, k)
            Errors in the unit of the measurement.
        start : ndarray, shape (n_states, k), optional
            Errors of the first state, in the units of the states. Default: 0.

        Returns
        -------
        ndarray, shape (n, n_measurements, k)
            Innovations in the unit of the measurement.
        """
        n = len(errors)
        state = np.zeros((self.closed.shape[1], errors.shape[2])) if start is None else start
        result = np.empty_like(errors)
        steps = zip(*(_repeated(values, n) for values in (self.rows, self.closed, self.gain)), errors, strict=True)
        for k, (rows, closed, gain, error) in enumerate(steps):
            result[k] = error + rows @ state
            state = closed @ state - gain @ error
        return result

    def shares(self, frequency: Floats) -> Complex:
        """Cross-spectral density of the whitened innovations by noise.

        On the diagonal, the sum over the noises is the share of the steps with each measurement.

        Parameters
        ----------
        frequency : ndarray, shape (n_f,)
            Frequencies up to 1/2. [cycles per step]

        Returns
        -------
        ndarray, shape (n_noises, n_f, n_measurements, n_measurements)
        """
        shares = self._constant_shares(frequency) if len(self.closed) == 1 else self._mean_shares(frequency)
        # The start of the run is known on average only, so the sum is scaled: a correct filter is then white.
        root = np.linalg.inv(np.linalg.cholesky(shares.sum(axis=0)))
        root = np.sqrt(self.presence)[:, None] * root
        return np.asarray(root @ shares @ root.conj().swapaxes(-1, -2))

    def _constant_shares(self, frequency: Floats) -> Complex:
        closed, gain, rows, whitening = (values[0] for values in (self.closed, self.gain, self.rows, self.whitening))
        turn = np.exp(2j * np.pi * frequency)[:, None, None] * np.eye(len(closed)) - closed
        path = (whitening @ rows) @ np.linalg.inv(turn)
        by_process = [np.asarray(path @ noise[0] @ path.conj().swapaxes(-1, -2)) for noise in self.process]
        measured = whitening - path @ gain
        by_measurement = [
            variance * column[:, :, None] * column[:, None].conj()
            for variance, column in zip(self.measured[0], np.moveaxis(measured, -1, 0), strict=True)
        ]
        return np.array([*by_measurement, *by_process])

    def _mean_shares(self, frequency: Floats) -> Complex:
        """Mean power at each frequency, by the sensitivity of the sum Σ e^{−iωt}·ε to the state at each step, backwards."""
        n, m, states = len(self.closed), *self.rows.shape[1:]
        process = np.array([_repeated(noise, n) for noise in self.process])
        observed = self.whitening @ _repeated(self.rows, n)
        start = self._start(process)
        shares = np.zeros((len(self.noises), len(frequency), m, m), dtype=complex)
        after = np.zeros((len(frequency), m, states), dtype=complex)
        chunk = max(_CHUNK // after.size, 1)
        for end in range(n, 0, -chunk):
            used = np.arange(max(end - chunk, 0), end)
            phase = np.exp(-2j * np.pi * np.outer(used, frequency))[:, :, None, None]
            outputs = phase * observed[used][:, None]
            sensitivity = np.empty((len(used), *after.shape), dtype=complex)
            for k in range(len(used) - 1, -1, -1):
                sensitivity[k] = after
                after = outputs[k] + after @ self.closed[used[k]]
            direct = phase * self.whitening[used][:, None] - sensitivity @ self.gain[used][:, None]
            for j in range(m):
                column = direct[..., j]
                shares[j] += np.einsum("t,tfi,tfk->fik", self.measured[used, j], column, column.conj(), optimize=True)
            for j, noise in enumerate(process, m):
                weighted = sensitivity @ noise[used][:, None]
                shares[j] += np.einsum("tfis,tfks->fik", weighted, sensitivity.conj(), optimize=True)
        shares += after @ start[:, None] @ after.conj().swapaxes(-1, -2)
        return np.asarray(shares / n)

    def _start(self, process: Floats) -> Floats:
        """Covariance of the first state by noise: the mean over the second half of the run."""
        n = len(self.closed)
        by_measurement = np.einsum("tsm,tm,trm->mtsr", self.gain, self.measured, self.gain)
        added = np.concatenate([by_measurement, process])
        covariance = np.zeros((len(added), *added.shape[2:]))
        total = np.zeros_like(covariance)
        for k in range(n):
            covariance = self.closed[k] @ covariance @ self.closed[k].T + added[:, k]
            if k >= n // 2:
                total += covariance
        return total / (n - n // 2)


def constant_run(matrices: Steps, covariance: Floats, measured: Floats) -> FilterRun:
    """Build the run of a filter with constant matrices and a constant gain.

    Parameters
    ----------
    matrices : Steps
        One set for all measurements.
    covariance : ndarray, shape (n_states, n_states)
        Covariance of the state before a measurement.
    measured : ndarray, shape (n_measurements,)
        R.

    Returns
    -------
    FilterRun
    """
    transition, rows = matrices.transition[0], matrices.rows[0]
    stated = rows @ covariance @ rows.T + np.diag(measured)
    gain = transition @ covariance @ rows.T @ np.linalg.inv(stated)
    return FilterRun(
        noises=(*noise_names((), len(measured)), *matrices.process),
        closed=(transition - gain @ rows)[None],
        gain=gain[None],
        rows=rows[None],
        process=np.array(list(matrices.process.values())),
        measured=measured[None],
        whitening=np.linalg.inv(np.linalg.cholesky(stated))[None],
        presence=np.ones(len(measured)),
    )


def varying_run(matrices: Steps, data: Innovations) -> FilterRun:
    """Build the run of a filter whose gain follows from its matrices and the stated S of each step.

    Parameters
    ----------
    matrices : Steps
    data : Innovations

    Returns
    -------
    FilterRun

    Raises
    ------
    OptionError
        If the S of the matrices is larger than the stated S.
    DataError
        If the noises of simultaneous measurements are correlated.
    """
    n, m = data.columns.shape
    present, stated = data.is_present, np.nan_to_num(data.covariance)
    stated[~(present[:, :, None] & present[:, None, :])] = 0.0
    whitening = data.whitened(np.broadcast_to(np.eye(m), (n, m, m)))
    inverse = whitening.swapaxes(1, 2) @ whitening
    total = np.sum([_repeated(noise, n) for noise in matrices.process.values()], axis=0)
    transition, rows = _repeated(matrices.transition, n), _repeated(matrices.rows, n) * present[:, :, None]
    first = total.mean(axis=0)
    for _ in range(_PASSES):
        share = np.max(np.diagonal(rows[0] @ first @ rows[0].T) / np.maximum(np.diagonal(stated[0]), _TINY))
        first = first * min(_LARGEST_SHARE / max(share, _TINY), 1.0)  # S is small at the beginning
        predicted = np.empty((n, *first.shape))
        covariance = first
        for k in range(n):
            predicted[k] = covariance
            cross = covariance @ rows[k].T
            covariance = transition[k] @ (covariance - cross @ inverse[k] @ cross.T) @ transition[k].T + total[k]
            if not covariance[0, 0] >= 0:
                raise _too_large(stated)
        first = predicted[n // 2 :].mean(axis=0)
    gain = transition @ predicted @ rows.swapaxes(1, 2) @ inverse
    residual = stated - rows @ predicted @ rows.swapaxes(1, 2)
    measured = np.diagonal(residual, axis1=1, axis2=2)
    smallest = _SMALLEST_R * np.diagonal(stated, axis1=1, axis2=2)
    if ((measured < smallest) & present).any(axis=1).mean() > _NEGATIVE_SHARE:
        raise _too_large(stated)
    measured = np.where(present, np.maximum(measured, smallest), 0.0)
    _require_independent(residual, measured, data)
    return FilterRun(
        noises=(*noise_names(data.measurements, m), *matrices.process),
        closed=transition - gain @ rows,
        gain=gain,
        rows=rows,
        process=np.array([_repeated(noise, n) for noise in matrices.process.values()]),
        measured=measured,
        whitening=whitening,
        presence=present.mean(axis=0),
    )


def noise_names(measurements: tuple[str, ...], count: int) -> Iterator[str]:
    """Names of the noises of the measurements: ``"measurement"`` for one, ``"measurement gnss"`` for several."""
    if count == 1:
        yield MEASUREMENT
        return
    yield from (name if name.startswith(MEASUREMENT) else f"{MEASUREMENT} {name}" for name in measurements)


def _repeated(values: Floats, n: int) -> Floats:
    return np.broadcast_to(values, (n, *values.shape[1:]))


def _too_large(stated: Floats) -> OptionError:
    largest = float(np.median(stated[:, 0, 0][stated[:, 0, 0] > 0]))
    return OptionError(
        f"N and K make a larger S than the stated {largest:.3g}."
        " Check their units, and those of the innovations and the time",
        option="filters",
    )


def _require_independent(residual: Floats, measured: Floats, data: Innovations) -> None:
    together: Bools = np.asarray(data.is_present.all(axis=1))
    if data.columns.shape[1] == 1 or not together.any():
        return
    scale = np.sqrt(np.median(measured[together], axis=0))
    correlation = np.median(residual[together], axis=0) / np.outer(scale, scale)
    np.fill_diagonal(correlation, 0.0)
    if np.abs(correlation).max() > _CORRELATION:
        raise DataError(
            "S minus H·P·Hᵀ is not diagonal, so the noises of the measurements are correlated."
            " Check H and N, or give the measurements decorrelated by the Cholesky root of R"
        )
