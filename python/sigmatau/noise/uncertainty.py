"""Uncertainty of deviations.

References
----------
.. [1] N. El-Sheimy, H. Hou, X. Niu, "Analysis and modeling of inertial sensors using Allan variance,"
   IEEE Trans. Instrum. Meas., vol. 57, no. 1, 2008, :doi:`10.1109/TIM.2007.908635`.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sigmatau._native import kernels
from sigmatau._native.distributions import gamma_quantile
from sigmatau.noise.terms import NOISE, TERMS, avar


def percentage_error(n: int, m: ArrayLike) -> NDArray[np.float64]:
    """The paper's relative standard error of an Allan deviation, δ = 1/√(2(N/n − 1)), eq. (26) of [1]_.

    It counts independent clusters and depends neither on the noise nor on the overlap. Compared with the true error of
    the overlapped deviation it is about right for rate random walk, 20 % too large for white noise and several times
    too large for quantization noise. Its symmetric interval is too short beyond a tenth of the record; see
    ``docs/theory/read-off.md``.

    Parameters
    ----------
    n : int
        Samples in the record (the paper's N).
    m : array_like of int, shape (n_tau,)
        Cluster sizes in samples (the paper's n), below `n`.

    Returns
    -------
    ndarray, shape (n_tau,)
        Relative error of the deviation, one standard error.

    Raises
    ------
    ValueError
        If a cluster size is below 1 or not below `n`.

    See Also
    --------
    degrees_of_freedom : exact, for a given noise.

    References
    ----------
    .. [1] :doi:`10.1109/TIM.2007.908635`

    Examples
    --------
    >>> percentage_error(2000, [10, 500]).round(4)
    array([0.0501, 0.4082])
    """
    sizes = np.atleast_1d(np.asarray(m, dtype=float))
    if sizes.size and not (sizes.min() >= 1 and sizes.max() < n):
        raise ValueError(f"`m` must lie in 1 … {n - 1} (below the {n} samples of the record)")
    return np.asarray(1 / np.sqrt(2 * (n / sizes - 1)))


def avar_covariance(coefficients: Mapping[str, float], *, n: int, m: ArrayLike, tau0: float) -> NDArray[np.float64]:
    """Exact covariance of the overlapped Allan variances of a record with the given noise.

    For Gaussian noise, it is the sum over all lags of the squared covariance of second differences of the phase
    (Isserlis' theorem), with the finite length of the record and its ends included. The flicker part is summed by
    quadrature to 1e-11, all other parts in closed form.

    Parameters
    ----------
    coefficients : mapping of str to float
        Terms as in `sigmatau.noise.terms.TERMS`, in SI; terms that are absent are zero.
    n : int
        Rate samples in the record.
    m : array_like of int, shape (n_tau,)
        Cluster sizes in samples, each at most n/2.
    tau0 : float
        Sample interval. [s]

    Returns
    -------
    ndarray, shape (n_tau, n_tau)
        [(unit of the rate)⁴]

    Raises
    ------
    ValueError
        For an unknown term, a size that leaves no pair, a tau0 that is not positive.

    See Also
    --------
    degrees_of_freedom : degrees of freedom of each variance.

    References
    ----------
    C. A. Greenhall, W. J. Riley, "Uncertainty of stability variances based on finite differences," Proc. 35th PTTI,
    2003, for the single variance; the covariance of two is the same sum over both.

    Examples
    --------
    >>> from sigmatau.noise.uncertainty import avar_covariance
    >>> covariance = avar_covariance({"random_walk": 1.0}, n=1000, m=[1, 10, 100], tau0=1.0)
    >>> covariance.diagonal().round(7)  # variances of the Allan variances of white noise
    array([3.002e-03, 1.369e-04, 1.560e-05])
    """
    unknown = set(coefficients) - {*TERMS}
    if unknown:
        raise ValueError(f"unknown term {min(unknown)!r}; terms: {', '.join(TERMS)}")
    if not all(map(math.isfinite, coefficients.values())):
        raise ValueError(f"coefficients must be finite numbers, got {dict(coefficients)}")
    sizes = np.atleast_1d(np.asarray(m))
    if sizes.ndim != 1 or (sizes != np.rint(sizes)).any():
        raise ValueError("`m` must be a list of whole numbers of samples")
    if sizes.size and (sizes.min() < 1 or sizes.max() > n / 2):
        raise ValueError(f"`m` must lie in 1 … {n // 2} (half of the {n} samples of the record)")
    noise, ramp = _tensors(n, tuple(int(size) for size in sizes), float(tau0))
    theta = np.array([coefficients.get(term, 0.0) ** 2 for term in NOISE])
    drift = coefficients.get("rate_ramp", 0.0) ** 2
    return np.asarray(np.einsum("p,q,pqij->ij", theta, theta, noise) + drift * np.einsum("p,pij->ij", theta, ramp))


def degrees_of_freedom(coefficients: Mapping[str, float], *, n: int, m: ArrayLike, tau0: float) -> NDArray[np.float64]:
    """Equivalent degrees of freedom of each overlapped Allan variance, 2·AVAR²/Var, exact for the given noise.

    They are those of the χ² distribution with the same mean and variance, from which the interval of a deviation
    follows: σ·√(edf/χ²).

    Parameters
    ----------
    coefficients : mapping of str to float
        By term, a key of `sigmatau.noise.terms.TERMS`. [SI]
    n : int
        Samples in the record.
    m : array_like of int, shape (n_tau,)
        Cluster sizes in samples, up to half the record.
    tau0 : float
        Sample interval. [s]

    Returns
    -------
    ndarray, shape (n_tau,)
        Degrees of freedom.

    Raises
    ------
    ValueError
        For an unknown term, a coefficient that is not finite, or a size that is not whole, below 1 or above half the
        record.

    See Also
    --------
    avar_covariance : the covariance of the Allan variances.
    percentage_error : the paper's error, which depends neither on noise nor on overlap.

    References
    ----------
    C. A. Greenhall, W. J. Riley, "Uncertainty of stability variances based on finite differences," Proc. 35th PTTI,
    2003.

    Examples
    --------
    White noise, 1000 samples:

    >>> degrees_of_freedom({"random_walk": 1.0}, n=1000, m=[1, 10, 100], tau0=1.0).round(2)
    array([666.22, 146.07,  12.81])
    """
    sizes = np.atleast_1d(np.asarray(m))
    expected = np.zeros(sizes.shape)
    for term, value in coefficients.items():
        expected += avar(term, value, m=sizes, tau0=tau0)
    variance = np.diag(avar_covariance(coefficients, n=n, m=sizes, tau0=tau0))
    return np.asarray(2 * expected**2 / variance)


def chi2_factors(edf: ArrayLike, *, level: float = 0.95) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Factors on a measured deviation that give the ends of its interval: √(edf/χ²) at (1 ± level)/2.

    The distribution of an Allan variance is approximated by a χ² with the same mean and variance; see
    `degrees_of_freedom`.

    Parameters
    ----------
    edf : array_like, shape (n_tau,)
        Equivalent degrees of freedom, positive.
    level : float
        Probability of the interval.

    Returns
    -------
    low, high : ndarray, shape (n_tau,)
        Factors on the deviation.

    Raises
    ------
    ValueError
        For degrees of freedom that are not positive, a level outside 0 … 1.

    See Also
    --------
    degrees_of_freedom : the degrees of freedom of a curve.

    References
    ----------
    D. A. Howe, D. W. Allan, J. A. Barnes, "Properties of signal sources and measurement methods," Proc. 35th Annual
    Frequency Control Symposium, 1981.

    Examples
    --------
    >>> low, high = chi2_factors([10, 100])
    >>> low.round(3), high.round(3)
    (array([0.699, 0.879]), array([1.755, 1.161]))
    """
    freedom = np.atleast_1d(np.asarray(edf, dtype=float))
    if not (freedom > 0).all():
        raise ValueError(f"`edf` must be positive, got {freedom[~(freedom > 0)][0]}")
    if not 0 < level < 1:
        raise ValueError(f"`level` must lie between 0 and 1, not {level!r}")
    quantiles = [2 * gamma_quantile(freedom / 2, 0.5 + side * level / 2) for side in (1, -1)]
    low, high = (np.sqrt(freedom / quantile) for quantile in quantiles)
    return np.asarray(low), np.asarray(high)


@functools.lru_cache(maxsize=8)
def _tensors(n: int, m: tuple[int, ...], tau0: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Tensors of a grid, cached: they do not depend on the data, so all axes and steps of a fit share them."""
    noise, ramp = kernels.covariance_tensors(n, np.array(m, dtype=np.int64), tau0)
    noise.setflags(write=False)
    ramp.setflags(write=False)
    return noise, ramp
