"""A Matérn process in place of all slow noise, as fitted, and the test of the Gauss-Markov process."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field

from sigmatau.digits import round_to_error, two_digits
from sigmatau.errors import DataError
from sigmatau.fitting.fitted_values import MIN_P_VALUE, Interval
from sigmatau.frozen import frozen
from sigmatau.model.matern import SMOOTHNESS, Matern
from sigmatau.results import Plain, duration_text

_AT_LIMIT = 0.005  # distance of an end of the smoothness from its range below which the record does not limit it


@frozen
class FittedMatern(Plain):
    """A model with one Matérn process in place of bias instability, rate random walk and Gauss-Markov processes.

    The other parts are those of the fit, estimated again. Its intervals are those of the profile of the likelihood.

    Attributes
    ----------
    observed : bool
        Whether the record shows slow noise. Without, only `upper_limit` is of use.
    sigma : Interval
        Standard deviation. Without an upper end if `time` lacks an end: it grows with the time. [unit of the rate]
    upper_limit : float or None
        Upper limit of the standard deviation, over all correlation times and slopes. [unit of the rate]
    time : Interval
        Correlation time. An end that reaches its limit, 20 samples or a quarter of the record, is None. [s]
    smoothness : Interval
        ν, from 0.02 to 1/2. Without ends if `time` has no lower one. [1]
    terms : mapping of str to float
        Coefficients of the terms beside the process. [SI]
    gauss_markov_p_value : float
        P-value of the Gauss-Markov process, ν = 1/2: the likelihood ratio at the end of the range, 0.56 of a chi-squared law
        with one degree of freedom, see docs/theory/matern.md. [1]
    gain : float
        Akaike's criterion of the fit minus that of this model: positive if this model explains the record better. [1]
    p_value : float
        P-value of the goodness of fit. [1]
    """

    observed: bool
    sigma: Interval
    upper_limit: float | None
    time: Interval = field(metadata={"unit": "s"})
    smoothness: Interval = field(metadata={"unit": "1"})
    terms: Mapping[str, float]
    gauss_markov_p_value: float
    gain: float
    p_value: float

    @property
    def slope_observed(self) -> bool:
        """Whether the interval of the smoothness is narrower than its range."""
        return self.observed and not (self._is_range_end(0) and self._is_range_end(1))

    def to_process(self) -> Matern:
        """The process for a `ChannelModel`.

        Returns
        -------
        Matern

        Raises
        ------
        DataError
            If the record does not show it.
        """
        if not self.observed:
            raise DataError("the record does not show a Matérn process; it has an upper limit, not a value")
        return Matern(sigma=self.sigma.value, time=self.time.value, smoothness=self.smoothness.value)

    def text(self, factor: float, unit: str) -> str:
        """The process in words.

        Parameters
        ----------
        factor : float
            Size of the unit of the standard deviation. [unit of the rate]
        unit : str
            Its symbol.

        Returns
        -------
        str
        """
        if not self.observed:
            limit = "" if self.upper_limit is None else f": below {two_digits(self.upper_limit / factor)} {unit}"
            return f"no Matérn process seen{limit}"
        fit = ""
        if self.p_value < MIN_P_VALUE:
            fit = f"; this model does not describe the record, p = {two_digits(self.p_value)}"
        return (
            f"Matérn process of {self._sigma_text(factor, unit)}, correlation time {self._time_text()},"
            f" smoothness {self._smoothness_text()};"
            f" Gauss-Markov process: p = {two_digits(self.gauss_markov_p_value)}{fit}"
        )

    def _sigma_text(self, factor: float, unit: str) -> str:
        if self.sigma.high is None:
            return f"at least {two_digits((self.sigma.low or 0.0) / factor)} {unit}"
        return round_to_error(self.sigma.value, self.sigma.low, self.sigma.high, size=factor).with_unit(unit)

    def _time_text(self) -> str:
        low, high = self.time.low, self.time.high
        if low is None:
            return "not determined" if high is None else f"below {duration_text(high)}"
        return (
            f"at least {duration_text(low)}"
            if high is None
            else round_to_error(self.time.value, low, high).with_unit("s")
        )

    def _smoothness_text(self) -> str:
        ends = self.smoothness.low, self.smoothness.high
        if not self.slope_observed or ends[0] is None or ends[1] is None:
            return "not determined"
        if self._is_range_end(0):
            return f"below {two_digits(ends[1])}"
        if self._is_range_end(1):
            return f"above {two_digits(ends[0])}"
        return round_to_error(self.smoothness.value, *ends).text

    def _is_range_end(self, end: int) -> bool:
        """Whether the lower (0) or upper (1) end of the smoothness is that of its range."""
        value = (self.smoothness.low, self.smoothness.high)[end]
        return value is None or abs(value - SMOOTHNESS[end]) < _AT_LIMIT
