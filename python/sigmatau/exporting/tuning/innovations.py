"""Innovations of a filter with their stated variance: one channel, checked."""

from __future__ import annotations

import numpy as np

from sigmatau.arrays import Floats, freeze
from sigmatau.errors import DataError, RecordTooShortError
from sigmatau.frozen import frozen

FEWEST = 100
"""Innovations below which nothing is tested: their mean square has an error of 14 %."""

_LARGEST = 1e9  # stated standard deviations; a larger innovation is in another unit


@frozen(eq=False)
class Innovations:
    """Innovations of a measurement channel of a filter, each with the variance that the filter states.

    Attributes
    ----------
    time : ndarray, shape (n,)
        Times of the measurements, increasing. [s]
    innovation : ndarray, shape (n,)
        Measurement minus its prediction. [rad or m/s, or any unit]
    variance : ndarray, shape (n,)
        S, the stated variance of the innovation. [square of that unit]

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

    def __post_init__(self) -> None:
        freeze(self, "time", "innovation", "variance", dtype=np.float64)
        _check(self)

    @property
    def interval(self) -> float:
        """Median time between two measurements. [s]"""
        return round(float(np.median(np.diff(self.time))), 9)

    @property
    def normalised(self) -> Floats:
        """Innovations over their stated standard deviations, shape (n,): white, variance 1 if the filter is right. [1]"""
        return self.innovation / np.sqrt(self.variance)

    @property
    def stated(self) -> float:
        """Median of the stated variance. [square of the unit]"""
        return float(np.median(self.variance))

    def after(self, skip: float) -> Innovations:
        """The innovations without those of the first time.

        Parameters
        ----------
        skip : float
            Time from the first innovation that is left out. [s]

        Returns
        -------
        Innovations
        """
        used = self.time >= self.time[0] + skip
        return Innovations(time=self.time[used], innovation=self.innovation[used], variance=self.variance[used])


def _check(data: Innovations) -> None:
    """Refuse data that no filter writes."""
    n = data.time.size
    for name in ("time", "innovation", "variance"):
        values: Floats = getattr(data, name)
        if values.ndim != 1 or values.size != n:
            raise DataError(
                f"`{name}` has the shape {values.shape}, `time` has {data.time.shape}. Give one value a measurement"
            )
        wrong = np.flatnonzero(~np.isfinite(values))
        if wrong.size:
            raise DataError(
                f"`{name}` has {wrong.size} values that are not finite, the first at index {wrong[0]}. Remove these rows"
            )
    if n < FEWEST:
        raise RecordTooShortError(
            f"{n} innovations are too few to judge a filter. At least {FEWEST} are needed", need=FEWEST, got=n
        )
    unsorted = np.flatnonzero(np.diff(data.time) <= 0)
    if unsorted.size:
        k = int(unsorted[0]) + 1
        raise DataError(
            f"`time` does not increase at index {k}: {data.time[k]:.9g} s follows {data.time[k - 1]:.9g} s."
            " Sort the rows and remove repeated ones"
        )
    wrong = np.flatnonzero(data.variance <= 0)
    if wrong.size:
        raise DataError(
            f"`variance` is not positive at index {wrong[0]}: {data.variance[wrong[0]]:g}."
            " Give the variance S = H·P·Hᵀ + R of each innovation"
        )
    if float(np.abs(data.normalised).max()) > _LARGEST:
        raise DataError(
            f"`innovation` has values beyond {_LARGEST:.0e} stated deviations. Check the units of it and of `variance`"
        )
    if np.ptp(data.innovation) == 0:
        raise DataError(
            f"`innovation` is constant, {data.innovation[0] + 0.0:g}. Give the innovations of a filter that runs"
        )
