"""The stationary covariance of a Kalman filter with constant matrices.

References
----------
E. K. Chu, H.-Y. Fan, W.-W. Lin, "A structure-preserving doubling algorithm for continuous-time algebraic Riccati equations,"
Linear Algebra Appl. 396, 2005: the doubling that solves the Riccati equation.
"""

from __future__ import annotations

import numpy as np

from sigmatau.arrays import Floats

# largest number of doublings, which converge quadratically once the time constant of the filter is covered
_DOUBLINGS = 60
_TOLERANCE = 1e-13  # relative tolerance of both covariances, before and after a measurement


def stationary_covariance(transition: Floats, noise: Floats, *, rows: Floats, variances: Floats) -> Floats:
    """Solve the Riccati equation for the covariance of the state before a measurement.

    Parameters
    ----------
    transition, noise : ndarray, shape (n_states, n_states)
        F and Q of a step.
    rows : ndarray, shape (n_measurements, n_states)
        H of the measurements.
    variances : ndarray, shape (n_measurements,)
        R of the measurements.

    Returns
    -------
    ndarray, shape (n_states, n_states)
    """
    n = len(transition)
    a, g, h = transition.T, (rows.T / variances) @ rows, noise
    for _ in range(_DOUBLINGS):
        solved = np.linalg.solve(np.eye(n) + g @ h, np.hstack((a, g)))
        wa, wg = solved[:, :n], solved[:, n:]
        added = a.T @ h @ wa
        a, g, h = a @ wa, g + a @ wg @ a.T, h + (added + added.T) / 2
        measured = np.all(np.diag(rows @ added @ rows.T) <= _TOLERANCE * np.diag(rows @ h @ rows.T))
        if measured and np.abs(added).max() <= _TOLERANCE * np.abs(h).max():
            break
    return h
