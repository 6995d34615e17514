"""Filters whose innovations are judged: matrices, or a bias filter by its N and K.

With its stationary gain L a filter makes its innovations by a linear system from the noise of the measurement and of the
process. The density of the normalised innovations is the sum of a share of each noise, and is 1 at all frequencies if the
filter is right. A wrong variance multiplies its share alone.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from sigmatau.arrays import Floats, freeze
from sigmatau.errors import OptionError
from sigmatau.frozen import frozen
from sigmatau.statespace.riccati import stationary_covariance

MEASUREMENT = "measurement"
WHITE = "white"
SLOW = "slow"

_AGREEMENT = 1.1  # ratio of the stated S to that of the matrices, above which they are not of one filter
_LEAST_SHARE = 1e-9  # of R in S; a smaller one is not in the innovations
_BISECTIONS = 60  # of R in S, to 1e-15 of the decades above


@frozen(eq=False)
class FilterMatrices:
    """A Kalman filter with constant matrices and one measurement at a time.

    Attributes
    ----------
    F : ndarray, shape (n_states, n_states)
        Transition between two measurements. [of the states]
    H : ndarray, shape (n_states,)
        The measurement. [of the states]
    Q : mapping of str to ndarray, shape (n_states, n_states)
        Covariance that a step adds, by the noise that a factor is sought for: ``{"white": Q1, "slow": Q2}``.
        [of the states]
    R : float
        Variance of the measurement. [square of the measurement]

    Raises
    ------
    OptionError
        For matrices of other shapes, values that are not finite, an R that is not positive, or a Q that is not a
        covariance.

    See Also
    --------
    BiasFilter : an integrated rate and its bias, by N and K.
    tune : takes both.

    Examples
    --------
    >>> import sigmatau as st
    >>> walk = st.FilterMatrices(F=[[1]], H=[1], Q={"process": [[0.01]]}, R=1)
    >>> round(walk.innovation_variance, 3)
    1.105
    """

    F: Floats
    H: Floats
    Q: Mapping[str, Floats]
    R: float

    def __post_init__(self) -> None:
        for name in ("F", "H"):
            object.__setattr__(self, name, _array(getattr(self, name), name))
        freeze(self, "F", dtype=np.float64)
        object.__setattr__(self, "H", self.H.ravel())
        freeze(self, "H", dtype=np.float64)
        n = self.H.size
        if self.F.shape != (n, n):
            raise OptionError(
                f"`F` has the shape {self.F.shape}; with the H of {n} states it must be ({n}, {n})", option="F"
            )
        if not isinstance(self.Q, Mapping) or not self.Q or MEASUREMENT in self.Q:
            raise OptionError(
                '`Q` must be a mapping from names of the process noise, {"white": Q1, "slow": Q2}', option="Q"
            )
        object.__setattr__(self, "Q", {name: _covariance(value, name, n) for name, value in self.Q.items()})
        if not (isinstance(self.R, int | float | np.number) and 0 < self.R < math.inf):
            raise OptionError(f"`R` must be a positive variance, not {self.R!r}", option="R")

    @property
    def covariance(self) -> Floats:
        """Stationary covariance of the state before a measurement, shape (n_states, n_states). [of the states]"""
        return stationary_covariance(
            np.array(self.F), cast(Floats, sum(self.Q.values())), row=np.array(self.H), variance=float(self.R)
        )

    @property
    def innovation_variance(self) -> float:
        """S of the stationary filter. [square of the measurement]"""
        return float(self.H @ self.covariance @ self.H) + float(self.R)

    def matrices(self, *, interval: float, stated: float) -> FilterMatrices:
        """The filter itself, if its S is that of the innovations.

        Parameters
        ----------
        interval : float
            Time between two measurements. [s]
        stated : float
            S that the filter states. [square of the measurement]

        Returns
        -------
        FilterMatrices

        Raises
        ------
        OptionError
            If the S of the filter is not the stated one.
        """
        ratio = stated / self.innovation_variance
        if not 1 / _AGREEMENT < ratio < _AGREEMENT:
            raise OptionError(
                f"the stated S is {ratio:.3g} times that of the filter, {self.innovation_variance:.3g}."
                " Give the matrices of the filter that made these innovations",
                option="filters",
            )
        return self

    def shares(self, frequency: Floats) -> dict[str, Floats]:
        """Shares of each noise in the density of the normalised innovations, whose sum is 1.

        Parameters
        ----------
        frequency : ndarray, shape (n_f,)
            Up to 1/2. [cycles a measurement]

        Returns
        -------
        dict of str to ndarray, shape (n_f,)
            By noise. [1]
        """
        covariance = self.covariance
        total = float(self.H @ covariance @ self.H) + self.R
        gain = self.F @ covariance @ self.H / total
        closed = self.F - np.outer(gain, self.H)
        turn = np.exp(2j * np.pi * frequency)[:, None, None] * np.eye(len(closed)) - closed
        row = np.linalg.solve(turn.transpose(0, 2, 1), self.H[None, :, None].astype(complex))[..., 0]
        shares = {MEASUREMENT: self.R * np.abs(1 - row @ gain) ** 2 / total}
        for name, noise in self.Q.items():
            shares[name] = np.einsum("fi,ij,fj->f", row, noise, row.conj()).real / total
        return shares


@frozen
class BiasFilter:
    """A filter of an integrated rate and the bias of its sensor: an attitude of a gyro, a velocity of an accelerometer.

    Attributes
    ----------
    noise : float
        N of the filter. [rad/s/√Hz or m/s²/√Hz]
    walk : float
        K of its bias. [rad/s²/√Hz or m/s³/√Hz]
    deviation : float or None
        Standard deviation of its measurement. Default: that which makes the stated S. [rad or m/s]

    Raises
    ------
    OptionError
        For numbers that are not positive.

    See Also
    --------
    FilterMatrices : any filter, by its matrices.
    tune : takes both.

    Examples
    --------
    >>> import sigmatau as st
    >>> filter_ = st.BiasFilter(noise=1e-4, walk=1e-5).matrices(interval=0.2, stated=1.5e-8)
    >>> round(filter_.R**0.5, 3)  # of the stated deviation of the innovation
    0.787
    """

    noise: float
    walk: float
    deviation: float | None = None

    def __post_init__(self) -> None:
        for name in ("noise", "walk", "deviation"):
            value = getattr(self, name)
            if name == "deviation" and value is None:
                continue
            if not (isinstance(value, int | float | np.number) and 0 < value < math.inf):
                raise OptionError(f"{{option}} must be a positive number in SI, not {value!r}", option=name)

    def matrices(self, *, interval: float, stated: float) -> FilterMatrices:
        """The matrices, in units of the stated deviation of the innovation.

        Parameters
        ----------
        interval : float
            Time between two measurements. [s]
        stated : float
            S that the filter states. [square of the measurement]

        Returns
        -------
        FilterMatrices
            Units: the stated standard deviation, and that over an interval.

        Raises
        ------
        OptionError
            If N and K alone make a larger S, or the S of the filter is not the stated one.
        """
        white = self.noise**2 * interval / stated
        slow = self.walk**2 * interval**3 / stated

        def made(share: float) -> FilterMatrices:
            return FilterMatrices(
                F=np.array([[1.0, 1.0], [0.0, 1.0]]),
                H=np.array([1.0, 0.0]),
                Q={WHITE: np.diag([white, 0.0]), SLOW: slow * np.array([[1 / 3, 1 / 2], [1 / 2, 1.0]])},
                R=share,
            )

        if self.deviation is not None:
            return made(self.deviation**2 / stated).matrices(interval=interval, stated=1.0)
        if white + slow / 3 >= 1 or made(_LEAST_SHARE).innovation_variance >= 1:
            raise OptionError(
                f"N = {self.noise:.3g} and K = {self.walk:.3g} in SI make a larger S than the stated {stated:.3g}."
                " Check their units, and those of the innovations and the time",
                option="noise",
            )
        low, high = math.log(_LEAST_SHARE), 0.0
        for _ in range(_BISECTIONS):
            middle = (low + high) / 2
            low, high = (middle, high) if made(math.exp(middle)).innovation_variance < 1 else (low, middle)
        return made(math.exp(low))


Filter = FilterMatrices | BiasFilter


def _array(value: ArrayLike, name: str) -> Floats:
    array = np.atleast_1d(np.asarray(value, dtype=np.float64))
    if not np.isfinite(array).all():
        raise OptionError(f"`{name}` has values that are not finite", option=name)
    return array


def _covariance(value: ArrayLike, name: str, n: int) -> Floats:
    """A read-only covariance of n states."""
    array = np.atleast_2d(_array(value, "Q"))
    if array.shape != (n, n):
        raise OptionError(f"`Q` of {name!r} has the shape {array.shape}; it must be ({n}, {n})", option="Q")
    scale = float(np.abs(array).max())
    if not scale or np.abs(array - array.T).max() > 1e-9 * scale or np.linalg.eigvalsh(array).min() < -1e-9 * scale:
        raise OptionError(f"`Q` of {name!r} must be a covariance: symmetric, not negative, not all zero", option="Q")
    array = array.copy()
    array.setflags(write=False)
    return array
