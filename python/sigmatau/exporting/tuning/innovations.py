"""Checked innovations of a filter with their stated covariance, for one measurement or several."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from sigmatau.arrays import Bools, Floats, freeze
from sigmatau.errors import DataError, RecordTooShortError
from sigmatau.frozen import frozen

MIN_COUNT = 100
"""Smallest number of innovations for a test: their mean square then has an error of 14 %."""

_LARGEST = 1e9  # largest innovation in stated standard deviations; larger ones are in another unit
_LARGE_NIS = 9.0  # NIS of a filter whose deviations are all wrong by a factor of 3
_ASYMMETRY = 1e-6  # largest relative asymmetry of a stated covariance that rounding explains


@frozen(eq=False)
class Innovations:
    """Innovations of a filter, each with its variance as stated by the filter.

    Attributes
    ----------
    time : ndarray, shape (n,)
        Times of the measurements, increasing. Several measurements of one filter may have the same time. [s]
    innovation : ndarray, shape (n,) or (n, n_measurements)
        Measurement minus its prediction. NaN where one of several measurements is absent. [rad or m/s, or any unit]
    variance : ndarray, shape (n,), (n, n_measurements) or (n, n_measurements, n_measurements)
        S, the stated variance of the innovation. For several measurements, the full S, or the variances (second shape) of
        measurements that never occur together. [square of that unit]
    rate : ndarray, shape (n,) or (n, n_measurements), optional
        Rate of motion at the time of the measurement: the angular rate for an angle, the acceleration for a velocity. It
        is required to estimate a delay and a scale error. [unit of the innovation per second]
    measurements : tuple of str
        Names of several measurements; empty for one.

    Raises
    ------
    DataError
        For arrays of different lengths, values that are not finite, times that do not increase, a variance that is not
        positive, or innovations that are all equal.
    RecordTooShortError
        For fewer than 100 innovations.

    See Also
    --------
    tune : judges them.

    Examples
    --------
    >>> import numpy as np
    >>> import sigmatau as st
    >>> nu = np.random.default_rng(1).standard_normal(500)
    >>> st.Innovations(time=np.arange(500) / 5, innovation=nu, variance=np.ones(500)).interval
    0.2
    """

    time: Floats
    innovation: Floats
    variance: Floats
    rate: Floats | None = None
    measurements: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        freeze(self, "time", "innovation", "variance", "rate", dtype=np.float64)
        columns = self.innovation.shape[1] if self.innovation.ndim == 2 else 1
        if not self.measurements and columns > 1:
            object.__setattr__(self, "measurements", tuple(f"measurement {k + 1}" for k in range(columns)))
        object.__setattr__(self, "measurements", tuple(self.measurements))
        _check(self)

    @property
    def interval(self) -> float:
        """Median time between two measurements. [s]"""
        return round(float(np.median(np.diff(np.unique(self.time)))), 9)

    @property
    def columns(self) -> Floats:
        """Innovations, shape (n, n_measurements). [rad or m/s, or any unit]"""
        return self.innovation.reshape(len(self.time), -1)

    @property
    def is_present(self) -> Bools:
        """Mask of the measurements that are present, shape (n, n_measurements)."""
        return ~np.isnan(self.columns)

    @property
    def covariance(self) -> Floats:
        """S, shape (n, n_measurements, n_measurements). [square of the unit]"""
        n, m = self.columns.shape
        if self.variance.ndim == 3:
            return self.variance
        return self.variance.reshape(n, m)[:, :, None] * np.eye(m)

    @property
    def normalised(self) -> Floats:
        """Innovations over their stated standard deviations, of the shape of `innovation`. [1]

        Innovations of several measurements are multiplied by the inverse of the Cholesky root of S. They are white with unit
        covariance if the filter is correct; NaN for an absent measurement.
        """
        whitened = self.whitened(self.columns[:, :, None])[:, :, 0]
        return np.where(self.is_present, whitened, np.nan).reshape(self.innovation.shape)

    @property
    def stated(self) -> float:
        """Median of the stated variance of the first measurement. [square of the unit]"""
        return float(np.nanmedian(np.where(self.is_present[:, 0], self.covariance[:, 0, 0], np.nan)))

    @property
    def has_root_of_variance(self) -> bool:
        """Whether `variance` seems to be √S: the innovations divided by it have a variance of 1, unlike those divided by
        its root.
        """
        if self.variance.ndim > 1:
            return False
        nis, squared = (float(np.mean((self.innovation / self.variance**power) ** 2)) for power in (0.5, 1.0))
        return not 1 / _LARGE_NIS < nis < _LARGE_NIS and 0.5 < squared < 2

    def whitened(self, values: Floats) -> Floats:
        """Multiply by the inverse of the Cholesky root of S.

        Parameters
        ----------
        values : ndarray, shape (n, n_measurements, k)
            Values to whiten. [unit of the innovation]

        Returns
        -------
        ndarray, shape (n, n_measurements, k)
            0 where a measurement is absent. [1]
        """
        result = np.zeros(values.shape)
        present, covariance = self.is_present, self.covariance
        for pattern in np.unique(present, axis=0):
            rows = np.flatnonzero((present == pattern).all(axis=1))[:, None]
            places = np.flatnonzero(pattern)
            roots = np.linalg.cholesky(covariance[rows[:, :, None], places[:, None], places])
            result[rows, places] = np.linalg.solve(roots, values[rows, places])
        return result

    def after(self, skip: float) -> Innovations:
        """Remove the innovations of the first time.

        Parameters
        ----------
        skip : float
            Length of the start of the run that is left out. [s]

        Returns
        -------
        Innovations
        """
        used = self.time >= self.time[0] + skip
        return Innovations(
            time=self.time[used],
            innovation=self.innovation[used],
            variance=self.variance[used],
            rate=None if self.rate is None else self.rate[used],
            measurements=self.measurements,
        )


def join_measurements(channels: Mapping[str, Innovations]) -> Innovations:
    """Join the innovations of several channels, which are successive updates of one filter.

    Parameters
    ----------
    channels : mapping of str to Innovations
        Innovations with one measurement each. Updates at the same time are in the order of the channels.

    Returns
    -------
    Innovations
    """
    each = list(channels.values())
    column = np.repeat(np.arange(len(each)), [len(data.time) for data in each])
    time = np.concatenate([data.time for data in each])
    order = np.argsort(time, kind="stable")
    places = (np.arange(len(time)), column[order])
    innovation, variance = np.full((2, len(time), len(each)), np.nan)
    innovation[places] = np.concatenate([data.innovation for data in each])[order]
    variance[places] = np.concatenate([data.variance for data in each])[order]
    rate = None
    if all(data.rate is not None for data in each):
        values = np.concatenate([np.asarray(data.rate) for data in each])[order]
        rate = np.repeat(values[:, None], len(each), axis=1)
    return Innovations(
        time=time[order], innovation=innovation, variance=variance, rate=rate, measurements=tuple(channels)
    )


def _check(data: Innovations) -> None:
    """Raise an error for data that cannot be from a filter."""
    n = data.time.size
    shape = data.innovation.shape
    for name, shapes in (
        ("time", [(n,)]),
        ("innovation", [(n,), (n, len(data.measurements))]),
        ("variance", [shape, (*shape, *shape[1:])]),
        ("rate", [shape]),
    ):
        values: Floats | None = getattr(data, name)
        if values is None:
            continue
        if values.shape not in shapes:
            raise DataError(
                f"`{name}` has the shape {values.shape}, `time` has {data.time.shape}. Give one value a measurement"
            )
        if name in ("time", "rate") or len(shape) == 1:
            wrong = np.flatnonzero(~np.isfinite(values).reshape(n, -1).all(axis=1))
            if wrong.size:
                raise DataError(
                    f"`{name}` has {wrong.size} values that are not finite, the first at index {wrong[0]}."
                    " Remove these rows"
                )
    if n < MIN_COUNT:
        raise RecordTooShortError(
            f"{n} innovations are too few to judge a filter. At least {MIN_COUNT} are needed",
            need=MIN_COUNT,
            got=n,
        )
    steps = np.diff(data.time)
    unsorted = np.flatnonzero(steps < 0 if len(shape) == 2 else steps <= 0)
    if unsorted.size or not steps.any():
        k = int(unsorted[0]) + 1 if unsorted.size else 1
        raise DataError(
            f"`time` does not increase at index {k}: {data.time[k]:.9g} s follows {data.time[k - 1]:.9g} s."
            " Sort the rows and remove repeated ones"
        )
    _check_variance(data)
    values = data.normalised
    if float(np.nanmax(np.abs(values))) > _LARGEST:
        raise DataError(
            f"`innovation` has values beyond {_LARGEST:.0e} stated deviations. Check the units of it and of `variance`"
        )
    if np.nanmax(data.innovation) == np.nanmin(data.innovation):
        raise DataError(
            f"`innovation` is constant, {np.nanmax(data.innovation) + 0.0:g}. Give the innovations of a filter that runs"
        )


def _check_variance(data: Innovations) -> None:
    """Raise an error for an S that cannot be the covariance of the innovations that are present."""
    present, covariance = data.is_present, data.covariance
    empty = np.flatnonzero(~present.any(axis=1))
    if empty.size:
        raise DataError(f"`innovation` has no measurement at index {empty[0]}. Remove this row")
    counts = present.sum(axis=0)
    if counts.min() < MIN_COUNT:
        name = data.measurements[int(counts.argmin())]
        raise RecordTooShortError(
            f"{counts.min()} innovations of {name} are too few. At least {MIN_COUNT} are needed",
            need=MIN_COUNT,
            got=int(counts.min()),
        )
    if data.variance.ndim == 2 and (present.sum(axis=1) > 1).any():
        m = present.shape[1]
        raise DataError(
            f"`variance` has the shape {data.variance.shape}, and several measurements come together."
            f" Give the full S, shape ({len(present)}, {m}, {m})"
        )
    for pattern in np.unique(present, axis=0):
        rows = np.flatnonzero((present == pattern).all(axis=1))
        stated = covariance[np.ix_(rows, np.flatnonzero(pattern), np.flatnonzero(pattern))]
        size = np.abs(stated).max(axis=(1, 2))
        with np.errstate(invalid="ignore"):
            wrong = ~(np.abs(stated - stated.transpose(0, 2, 1)).max(axis=(1, 2)) <= _ASYMMETRY * size)
        wrong[~wrong] = np.linalg.eigvalsh(stated[~wrong])[:, 0] <= 0
        if wrong.any():
            k = int(rows[wrong][0])
            value = f": {stated[wrong][0, 0, 0]:g}" if stated.shape[1] == 1 else ""
            raise DataError(
                f"`variance` is not positive at index {k}{value}. Give the variance S = H·P·Hᵀ + R of each innovation"
            )
