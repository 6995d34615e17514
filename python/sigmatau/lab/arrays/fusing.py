"""The virtual sensor of a fitted array: target, weights, predicted noise, and a check by the second half of the record."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from sigmatau.arrays import Floats
from sigmatau.errors import OptionError
from sigmatau.frozen import frozen
from sigmatau.lab.arrays.array_fit import Conditions, fit_array
from sigmatau.lab.arrays.codeviation import allan_variances
from sigmatau.lab.arrays.components import Component
from sigmatau.lab.arrays.covariance_fit import CovarianceFit, diagonal_structure
from sigmatau.lab.arrays.virtual_sensor import (
    PredictedDeviation,
    VirtualSensor,
    combined_coefficients,
    predict_deviation,
    unit_variances,
)
from sigmatau.lab.arrays.weights import estimate_weights
from sigmatau.results import seconds

_LEAST_HALF = 2048  # smallest number of samples of half a record for the check


def _amounts(target: str | float, components: Sequence[Component], tau0: float, samples: int) -> tuple[Floats, str]:
    """Factors of the components whose sum the weights minimise, and the target in words."""
    if isinstance(target, str):
        amounts = np.array([float(component.name == target) for component in components])
        if not amounts.any():
            observed = ", ".join(c.name for c in components if c.time is None)
            raise OptionError(f"{{option}} {target}: no sensor shows it; observed: {observed}", option="target")
        return amounts, target
    m = round(target / tau0)
    if not 1 <= m <= samples // 2:
        raise OptionError(
            f"{{option}} {target:g} s: must be {tau0:g} to {samples // 2 * tau0:g} s for this record", option="target"
        )
    return unit_variances(components, np.array([m]), tau0)[:, 0], f"deviation at {seconds(m * tau0)} s"


@frozen(eq=False)
class FittedArray:
    """A fitted array.

    Attributes
    ----------
    samples : ndarray, shape (n, N)
        Samples without means, lines and drifts. [unit]
    tau0 : float
        [s]
    components : tuple of Component
    first : ndarray, shape (n_components, n)
        Variances from which a fit starts.
    conditions : Conditions
    fit : CovarianceFit
    widening : float
        Factor on standard errors.
    level : float
    common : bool
    """

    samples: Floats
    tau0: float
    components: tuple[Component, ...]
    first: Floats
    conditions: Conditions
    fit: CovarianceFit
    widening: float
    level: float
    common: bool

    @property
    def cluster_sizes(self) -> np.ndarray:
        """Averaging times in octaves up to a quarter of the record, except those of left-out frequencies. [samples]"""
        m = 2 ** np.arange(int(np.log2(self.samples.shape[1] // 4)) + 1)
        highest = self.conditions.highest
        return m if highest is None else m[m * self.tau0 > 0.5 / highest]


def make_virtual(
    array: FittedArray, target: str | float, *, channel: str, quantity: str, unit: str, units: Sequence[str]
) -> VirtualSensor | None:
    """Estimate the weights for a target, predict the noise, and compare it with the samples.

    None if the record determines the covariance of the target too weakly. Raises `OptionError` for a term that no sensor
    shows, or an averaging time outside the record.
    """
    components, tau0, level, widening = array.components, array.tau0, array.level, array.widening
    amounts, words = _amounts(target, components, tau0, array.samples.shape[1])
    weights = estimate_weights(array.fit, amounts, level=level, widening=widening)
    if weights is None:
        return None
    w, m = weights.vector, array.cluster_sizes
    matrices = _sensor_fit(array.fit)
    curve = predict_deviation(
        matrices, components, w, array.samples, tau0, m, factors=weights.factors, widening=widening, level=level
    )
    squares = np.mean(matrices.matrices, axis=(1, 2))  # variances of the components in the equal-weight mean
    return VirtualSensor(
        channel=channel,
        quantity=quantity,
        unit=unit,
        target=words,
        weights=weights,
        coefficients=combined_coefficients(
            matrices, components, w, weights.factors, level=level, widening=widening, units=units
        ),
        components=components,
        curve=curve,
        second_half=None if array.common else _second_half(array, amounts),
        equal=np.sqrt(squares @ unit_variances(components, m, tau0)),
        sensors=np.sqrt(allan_variances(array.samples, tau0, m * tau0)),
        rate=1 / tau0,
        duration=array.samples.shape[1] * tau0,
        adequate=widening == 1,
    )


def _second_half(array: FittedArray, amounts: Floats) -> PredictedDeviation | None:
    """Compare the second half of the record with the prediction from the first; None if a half is too short."""
    middle = array.samples.shape[1] // 2
    if middle < _LEAST_HALF:
        return None
    fit = fit_array(
        array.samples[:, :middle],
        array.tau0,
        array.components,
        array.first,
        common=False,
        conditions=array.conditions,
    )
    weights = estimate_weights(fit, amounts, level=array.level, widening=array.widening)
    if weights is None:
        return None
    m = array.cluster_sizes
    return predict_deviation(
        fit,
        array.components,
        weights.vector,
        array.samples[:, middle:],
        array.tau0,
        m[m <= middle // 4],
        factors=weights.factors,
        widening=array.widening,
        level=array.level,
    )


def _sensor_fit(fit: CovarianceFit) -> CovarianceFit:
    """Replace the structure of contrasts in a fit by that of the sensors, whose variances it has."""
    if fit.structure.semidefinite:
        return fit
    return replace(fit, structure=diagonal_structure(np.eye(len(fit.structure.elements))))
