"""Bias as a polynomial of temperature, and its values with intervals."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from sigmatau._native.distributions import normal_quantile
from sigmatau.arrays import Floats
from sigmatau.errors import OptionError
from sigmatau.frozen import frozen
from sigmatau.results import Printed, plain

WORDS = ("constant", "linear", "quadratic", "cubic", "quartic", "quintic")
"""Names of the degrees."""

# Distance outside the observed range that is accepted, as a share of the range. [1] Judgement: a log from -39.9 °C shows
# -40 °C.
_REACH = 0.01


@frozen(eq=False)
class BiasCurve:
    """Values of a bias polynomial.

    Attributes
    ----------
    temperature : ndarray, shape (n,)
        [°C]
    value, low, high : ndarray, shape (n,)
        Bias with its interval at each temperature. [unit]
    """

    temperature: Floats
    value: Floats
    low: Floats
    high: Floats


@frozen(eq=False)
class BiasPolynomial(Printed):
    """Mean of a channel as a polynomial of temperature: Σ c_k·(T - reference)^k.

    Attributes
    ----------
    reference : float
        Temperature at which the constant c_0 is the bias. [°C]
    low, high : float
        Range of the observed temperatures. [°C]
    coefficients : ndarray, shape (degree + 1,)
        c_0, c_1 … [unit/K^k]
    covariance : ndarray, shape (degree + 1, degree + 1)
        Covariance of the coefficients, with allowance for coloured noise. [unit²/K^(j + k)]
    level : float
        Confidence level of intervals.
    unit : str
        SI.

    See Also
    --------
    calibrate_temperature : fits it.

    Examples
    --------
    >>> import numpy as np
    >>> from sigmatau.lab.temperature.polynomial import BiasPolynomial
    >>> line = BiasPolynomial(
    ...     reference=25.0, low=-40.0, high=85.0, coefficients=np.array([1e-4, 2e-6]),
    ...     covariance=np.diag([1e-12, 1e-16]), level=0.95, unit="rad/s",
    ... )
    >>> float(line.values(35.0).value[0]), float(line.about(35.0).coefficients[0])
    (0.00012, 0.00012)
    """

    reference: float
    low: float
    high: float
    coefficients: Floats
    covariance: Floats
    level: float
    unit: str

    @property
    def degree(self) -> int:
        """Degree of the polynomial."""
        return len(self.coefficients) - 1

    @property
    def errors(self) -> Floats:
        """Half widths of the intervals of the coefficients, shape (degree + 1,). [unit/K^k]"""
        return np.asarray(normal_quantile((1 + self.level) / 2) * np.sqrt(np.diag(self.covariance)))

    def values(self, temperature: ArrayLike) -> BiasCurve:
        """Bias with its interval at some temperatures.

        Parameters
        ----------
        temperature : array_like, shape (n,)
            [°C]

        Returns
        -------
        BiasCurve

        Raises
        ------
        OptionError
            For a temperature outside `low` … `high`: the polynomial is not extrapolated.
        """
        t = np.atleast_1d(np.asarray(temperature, dtype=np.float64))
        reach = _REACH * (self.high - self.low)
        outside = t[~((t >= self.low - reach) & (t <= self.high + reach))]
        if len(outside):
            raise OptionError(
                f"{{option}} {outside[0]:g} °C is outside the observed {self.low:.4g} to {self.high:.4g} °C."
                " A polynomial is not extrapolated",
                option="temperature",
            )
        powers = np.vander(t - self.reference, self.degree + 1, increasing=True)
        value = powers @ self.coefficients
        variance = np.einsum("ij,jk,ik->i", powers, self.covariance, powers)
        half = normal_quantile((1 + self.level) / 2) * np.sqrt(np.maximum(variance, 0.0))
        return BiasCurve(temperature=t, value=value, low=value - half, high=value + half)

    def about(self, reference: float) -> BiasPolynomial:
        """The same polynomial about another reference temperature.

        Parameters
        ----------
        reference : float
            [°C]

        Returns
        -------
        BiasPolynomial
        """
        distance, p = reference - self.reference, self.degree + 1
        shift = np.array(
            [[math.comb(k, j) * distance ** (k - j) if k >= j else 0.0 for k in range(p)] for j in range(p)]
        )
        return BiasPolynomial(
            reference=reference,
            low=self.low,
            high=self.high,
            coefficients=shift @ self.coefficients,
            covariance=shift @ self.covariance @ shift.T,
            level=self.level,
            unit=self.unit,
        )

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI."""
        return plain(
            self,
            "degree reference_degc=reference low_degc=low high_degc=high coefficients errors covariance level unit",
        )

    def __repr__(self) -> str:
        terms = [
            f"c{k} = {value:.4g} ± {error:.2g} {self.unit}{_per_kelvin(k)}"
            for k, (value, error) in enumerate(zip(self.coefficients.tolist(), self.errors.tolist(), strict=True))
        ]
        return f"{WORDS[self.degree]} about {self.reference:g} °C: {', '.join(terms)}"


def _per_kelvin(power: int) -> str:
    return "" if power == 0 else "/K" if power == 1 else f"/K^{power}"


def from_scaled(
    coefficients: Floats,
    covariance: Floats,
    *,
    scaled: tuple[float, float],
    low: float,
    high: float,
    reference: float,
    level: float,
    unit: str,
) -> BiasPolynomial:
    """Convert coefficients for a scaled temperature, -1 and 1 at the ends of `scaled`, to a polynomial in kelvin."""
    middle, half = (scaled[0] + scaled[1]) / 2, (scaled[1] - scaled[0]) / 2
    scale = half ** -np.arange(len(coefficients), dtype=np.float64)
    about_middle = BiasPolynomial(
        reference=middle,
        low=low,
        high=high,
        coefficients=coefficients * scale,
        covariance=covariance * np.outer(scale, scale),
        level=level,
        unit=unit,
    )
    return about_middle.about(reference)
