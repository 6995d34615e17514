"""Filters whose innovations are judged: any filter given by its matrices, or a bias filter given by N and K."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from sigmatau.arrays import Floats, freeze
from sigmatau.errors import OptionError
from sigmatau.exporting.tuning.run import Steps
from sigmatau.frozen import frozen
from sigmatau.statespace.riccati import stationary_covariance

WHITE = "white"
SLOW = "slow"

AGREEMENT = 1.1
"""Ratio of the stated S to the S of the matrices above which they belong to different filters."""

_MIN_SHARE = 1e-9  # smallest share of R in S that is visible in the innovations
_BISECTIONS = 60  # bisections of the logarithm of the share of R in S


@frozen(eq=False)
class FilterMatrices:
    """A Kalman filter given by its matrices.

    Matrices with a first axis of `n` belong to each innovation; F and Q lead from it to the next one. Constant F and Q
    are for the median interval, and are repeated over a gap of several intervals.

    Attributes
    ----------
    F : ndarray, shape (n_states, n_states) or (n, n_states, n_states)
        Transition between two measurements. [of the states]
    H : ndarray, shape (n_states,), (n_measurements, n_states) or (n, n_measurements, n_states)
        The measurement matrix H, with one or several rows. [of the states]
    Q : mapping of str to ndarray, shape (n_states, n_states) or (n, n_states, n_states)
        Covariance added by a step, for each noise whose factor is estimated: ``{"white": Q1, "slow": Q2}``. [of the states]
    R : float or ndarray, shape (n_measurements,), optional
        Variance of the measurement. Default: that which results in the stated S, for a filter that adapts R. [square of
        the measurement]

    Raises
    ------
    OptionError
        For matrices of other shapes, values that are not finite, an R that is not positive, or a Q that is not a
        covariance.

    See Also
    --------
    BiasFilter : an integrated rate and its bias, given by N and K.
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
    R: float | Floats | None = None

    def __post_init__(self) -> None:
        for name in ("F", "H"):
            object.__setattr__(self, name, _array(getattr(self, name), name))
        freeze(self, "F", "H", dtype=np.float64)
        n = self.H.shape[-1]
        if self.F.ndim not in (2, 3) or self.F.shape[-2:] != (n, n) or self.H.ndim > 3:
            raise OptionError(
                f"`F` has the shape {self.F.shape}; with the H of {n} states it must be ({n}, {n})", option="F"
            )
        if not isinstance(self.Q, Mapping) or not self.Q or any(name.startswith("measurement") for name in self.Q):
            raise OptionError(
                '`Q` must be a mapping from names of the process noise, {"white": Q1, "slow": Q2}', option="Q"
            )
        object.__setattr__(self, "Q", {name: _covariance(value, name, n) for name, value in self.Q.items()})
        if self.R is not None:
            self._check_measured()

    def _check_measured(self) -> None:
        measured = np.atleast_1d(np.asarray(self.R, dtype=np.float64))
        count = 1 if self.H.ndim == 1 else self.H.shape[-2]
        if measured.shape != (count,):
            raise OptionError(
                f"`R` has the shape {measured.shape}. Give the variance of each of {count} measurements", option="R"
            )
        if not (np.isfinite(measured).all() and (measured > 0).all()):
            raise OptionError(f"`R` must be a positive variance, not {self.R!r}", option="R")

    @property
    def covariance(self) -> Floats:
        """Stationary covariance of the state before a measurement, shape (n_states, n_states). [of the states]

        Raises
        ------
        OptionError
            For matrices that are not constant.
        """
        if not self.is_constant:
            raise OptionError("a stationary filter has constant matrices F, H, Q and R", option="filters")
        steps = self.steps
        total = np.sum([noise[0] for noise in steps.process.values()], axis=0)
        variances = np.atleast_1d(cast(float, self.R))
        return stationary_covariance(np.array(steps.transition[0]), total, rows=steps.rows[0], variances=variances)

    @property
    def innovation_variance(self) -> float:
        """S of the stationary filter with one measurement. [square of the measurement]"""
        row = self.steps.rows[0, 0]
        return float(row @ self.covariance @ row) + float(np.atleast_1d(cast(float, self.R))[0])

    @property
    def steps(self) -> Steps:
        """Matrices with a first axis of steps."""
        rows = np.atleast_2d(self.H)
        return Steps(
            transition=_stack(self.F),
            rows=_stack(rows),
            process={name: _stack(noise) for name, noise in self.Q.items()},
        )

    @property
    def is_constant(self) -> bool:
        """Whether all matrices are constant, and R is known."""
        steps = self.steps
        lengths = {len(values) for values in (steps.transition, steps.rows, *steps.process.values())}
        return lengths == {1} and self.R is not None

    def matrices(self, *, interval: float, stated: float) -> FilterMatrices:
        """Return the filter if its S is that of the innovations.

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
            If the S of the filter differs from the stated S.
        """
        ratio = stated / self.innovation_variance
        if not 1 / AGREEMENT < ratio < AGREEMENT:
            raise OptionError(
                f"the stated S is {ratio:.3g} times that of the filter, {self.innovation_variance:.3g}."
                " Give the matrices of the filter that made these innovations",
                option="filters",
            )
        return self

    def after(self, first: int) -> FilterMatrices:
        """Remove the matrices of the first steps.

        Parameters
        ----------
        first : int
            Steps that are left out.

        Returns
        -------
        FilterMatrices
        """
        F, H, *noises = (
            values[first:] if values.ndim == 3 and len(values) > 1 else values
            for values in (self.F, self.H, *self.Q.values())
        )
        return FilterMatrices(F=F, H=H, Q=dict(zip(self.Q, noises, strict=True)), R=self.R)


@frozen
class BiasFilter:
    """A filter of an integrated rate and the bias of its sensor: an attitude of a gyro, a velocity of an accelerometer.

    Its attitude or velocity is measured by one sensor, or by several.

    Attributes
    ----------
    noise : float
        N of the filter. [rad/s/√Hz or m/s²/√Hz]
    walk : float
        K of its bias. [rad/s²/√Hz or m/s³/√Hz]
    deviation : float or None
        Standard deviation of its measurement. Default: that which results in the stated S. [rad or m/s]

    Raises
    ------
    OptionError
        For numbers that are not positive.

    See Also
    --------
    FilterMatrices : any filter, given by its matrices.
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
        """Build the matrices, in units of the stated deviation of the innovation.

        Parameters
        ----------
        interval : float
            Time between two measurements. [s]
        stated : float
            S that the filter states. [square of the measurement]

        Returns
        -------
        FilterMatrices
            The units are the stated standard deviation, and that per interval.

        Raises
        ------
        OptionError
            If S is too small for N and K, or the S of the filter differs from the stated S.
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
        if white + slow / 3 >= 1 or made(_MIN_SHARE).innovation_variance >= 1:
            raise OptionError(
                f"N = {self.noise:.3g} and K = {self.walk:.3g} in SI make a larger S than the stated {stated:.3g}."
                " Check their units, and those of the innovations and the time",
                option="noise",
            )
        low, high = math.log(_MIN_SHARE), 0.0
        for _ in range(_BISECTIONS):
            middle = (low + high) / 2
            low, high = (middle, high) if made(math.exp(middle)).innovation_variance < 1 else (low, middle)
        return made(math.exp(low))


Filter = FilterMatrices | BiasFilter


def _stack(array: Floats) -> Floats:
    return array if array.ndim == 3 else array[None]


def _array(value: ArrayLike, name: str) -> Floats:
    array = np.atleast_1d(np.asarray(value, dtype=np.float64))
    if not np.isfinite(array).all():
        raise OptionError(f"`{name}` has values that are not finite", option=name)
    return array


def _covariance(value: ArrayLike, name: str, n: int) -> Floats:
    """Read-only covariance of n states, constant or for each step."""
    array = np.atleast_2d(_array(value, "Q"))
    if array.ndim > 3 or array.shape[-2:] != (n, n):
        raise OptionError(f"`Q` of {name!r} has the shape {array.shape}; it must be ({n}, {n})", option="Q")
    scale = float(np.abs(array).max())
    asymmetry = np.abs(array - array.swapaxes(-1, -2)).max()
    if not scale or asymmetry > 1e-9 * scale or np.linalg.eigvalsh(array).min() < -1e-9 * scale:
        raise OptionError(f"`Q` of {name!r} must be a covariance: symmetric, not negative, not all zero", option="Q")
    array = array.copy()
    array.setflags(write=False)
    return array
