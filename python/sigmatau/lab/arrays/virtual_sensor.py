"""Virtual sensor: weighted mean of an array, its predicted noise, and the comparison with the fused log."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from sigmatau import ChannelModel, GaussMarkov, NoiseModel
from sigmatau._native.distributions import gamma_quantile, normal_quantile
from sigmatau.arrays import Bools, Floats, freeze
from sigmatau.frozen import frozen
from sigmatau.lab.arrays.codeviation import allan_variances
from sigmatau.lab.arrays.components import Component, component_model
from sigmatau.lab.arrays.covariance_fit import CovarianceFit
from sigmatau.lab.arrays.intervals import Estimate, satterthwaite, variance_interval
from sigmatau.lab.arrays.weights import Weights
from sigmatau.noise.uncertainty import degrees_of_freedom
from sigmatau.results import plain

# Degrees of freedom below which a coefficient of the virtual sensor is stated as a limit. Judgement: its standard error is
# then larger than 0.7 of its square.
_OBSERVED = 4.0
_FLOOR_OF_PROCESS = 0.93  # bias instability with the maximum of a Gauss-Markov process of σ = 1: 0.618/0.664 [1]


@frozen(eq=False)
class PredictedDeviation:
    """Predicted Allan deviation of a weighted mean, and the measured one.

    Attributes
    ----------
    tau : ndarray, shape (n_tau,)
        [s]
    adev : ndarray, shape (n_tau,)
        Predicted. [unit]
    low, high : ndarray, shape (n_tau,)
        Band that contains the measured deviation at all averaging times together with 95 % probability. [unit]
    measured : ndarray, shape (n_tau,)
        Deviation of the fused samples. [unit]
    """

    tau: Floats
    adev: Floats
    low: Floats
    high: Floats
    measured: Floats

    def __post_init__(self) -> None:
        freeze(self, "tau", "adev", "low", "high", "measured")

    @property
    def inside(self) -> Bools:
        """Averaging times at which the measured deviation is in the band; shape (n_tau,)."""
        return np.asarray((self.low <= self.measured) & (self.measured <= self.high))

    @property
    def agrees(self) -> bool:
        """Whether the measured deviation is in the band at all averaging times."""
        return bool(self.inside.all())

    def to_dict(self) -> dict[str, object]:
        """Plain columns in SI."""
        return plain(self, "tau_s=tau adev low high measured agrees")


def mixed_terms(components: Sequence[Component], variances: Sequence[float] | Floats) -> dict[str, float]:
    """Coefficients of the terms of a mixture, for degrees of freedom; a process counts as bias instability."""
    squares: dict[str, float] = {}
    for component, variance in zip(components, variances, strict=True):
        if variance > 0:
            name = component.name if component.time is None else "bias_instability"
            factor = 1.0 if component.time is None else _FLOOR_OF_PROCESS**2
            squares[name] = squares.get(name, 0.0) + factor * float(variance)
    return {name: math.sqrt(square) for name, square in squares.items()}


def unit_variances(components: Sequence[Component], m: np.ndarray, tau0: float) -> Floats:
    """Allan variances of the components with unit coefficients, shape (n_components, n_tau)."""
    return np.stack(
        [component_model(component, 1.0, quantity="signal", unit="1").avar(m=m, tau0=tau0) for component in components]
    )


def predict_deviation(
    fit: CovarianceFit,
    components: Sequence[Component],
    w: Floats,
    samples: Floats,
    tau0: float,
    m: np.ndarray,
    *,
    factors: Floats,
    widening: float,
    level: float,
) -> PredictedDeviation:
    """Predict the Allan deviation of w'x at cluster sizes, and measure it.

    `factors`: factor on the variance of each component for the error of the weights.
    """
    slopes = np.einsum("i,pij,j->p", w, fit.structure.elements, w)
    variances = factors * (fit.theta @ slopes)
    shares = unit_variances(components, m, tau0)
    expected = variances @ shares
    gradient = np.einsum("tm,t,p->mtp", shares, factors, slopes).reshape(len(m), -1)
    error = widening * np.sqrt(np.einsum("ma,ab,mb->m", gradient, fit.covariance, gradient)) / expected
    edf = degrees_of_freedom(mixed_terms(components, variances), n=samples.shape[1], m=m, tau0=tau0)
    single = level ** (1 / len(m))
    z = float(normal_quantile(0.5 + single / 2)) * error
    lowest, highest = (np.log(gamma_quantile(edf / 2, 0.5 + side * single / 2) / (edf / 2)) for side in (-1, 1))
    return PredictedDeviation(
        tau=m * tau0,
        adev=np.sqrt(expected),
        low=np.sqrt(expected * np.exp(-np.sqrt(lowest**2 + z**2))),
        high=np.sqrt(expected * np.exp(np.sqrt(highest**2 + z**2))),
        measured=np.sqrt(allan_variances((w @ samples)[None, :], tau0, m * tau0)[0]),
    )


@frozen(eq=False)
class VirtualSensor:
    """The weighted mean of an array.

    Attributes
    ----------
    channel : str
        Name of its channel in models and files.
    quantity, unit : str
    target : str
        What its weights minimise: a term, or ``"deviation at 100 s"``.
    weights : Weights
    coefficients : mapping of str to Estimate
        By component.
    components : tuple of Component
    curve : PredictedDeviation
        Predicted and measured deviation of the log from which the weights were estimated.
    second_half : PredictedDeviation or None
        Deviation of the second half of the log, predicted from the first half alone; None if a half is too short.
    equal : ndarray, shape (n_tau,)
        Predicted deviation of the equal-weight mean, at the averaging times of `curve`. [unit]
    sensors : ndarray, shape (n, n_tau)
        Measured deviations of the sensors. [unit]
    rate : float
        [Hz]
    duration : float
        [s]
    adequate : bool
        Whether the model of the array fits.
    """

    channel: str
    quantity: str
    unit: str
    target: str
    weights: Weights
    coefficients: Mapping[str, Estimate]
    components: tuple[Component, ...]
    curve: PredictedDeviation
    second_half: PredictedDeviation | None
    equal: Floats
    sensors: Floats
    rate: float
    duration: float
    adequate: bool

    @property
    def model(self) -> NoiseModel:
        """Noise model of the virtual sensor, for filters, simulations and exports."""
        return NoiseModel(channels={self.channel: self._channel_model()})

    def _channel_model(self) -> ChannelModel:
        observed = {name: each for name, each in self.coefficients.items() if each.value is not None}
        times = {component.name: component.time for component in self.components}
        terms = {name: each for name, each in observed.items() if times[name] is None}
        return ChannelModel(
            terms={name: float(each.value or 0.0) for name, each in terms.items()},
            gauss_markov=tuple(
                GaussMarkov(sigma=float(each.value or 0.0), time=float(times[name] or 0.0))
                for name, each in observed.items()
                if times[name] is not None
            ),
            quantity=self.quantity,
            unit=self.unit,
            intervals={
                name: (each.low, each.high)
                for name, each in terms.items()
                if each.low is not None and each.high is not None
            },
            limits={
                name: each.upper_limit
                for name, each in self.coefficients.items()
                if times[name] is None and each.upper_limit is not None
            },
            rate=self.rate,
            duration=self.duration,
            adequate=self.adequate,
        )

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI."""
        return plain(self, "channel target") | {
            "weights": self.weights.to_dict(),
            "coefficients": {name: each.to_dict() for name, each in self.coefficients.items()},
            "curve": self.curve.to_dict() | {"equal_weights": self.equal.tolist(), "sensors": self.sensors.tolist()},
            "second_half": None if self.second_half is None else self.second_half.to_dict(),
            "model": self.model.to_dict(),
        }


def combined_coefficients(
    fit: CovarianceFit,
    components: Sequence[Component],
    w: Floats,
    factors: Floats,
    *,
    level: float,
    widening: float,
    units: Sequence[str],
) -> dict[str, Estimate]:
    """Coefficients √(w'·C_t·w) of a weighted mean, with intervals by χ²; limits of those that are not significant."""
    slopes = np.einsum("i,pij,j->p", w, fit.structure.elements, w)
    result = {}
    for t, component in enumerate(components):
        variance = float(factors[t] * (fit.theta[t] @ slopes))
        error = float(factors[t]) * widening * math.sqrt(max(float(slopes @ fit.component_covariance(t) @ slopes), 0.0))
        nu = satterthwaite(variance, error)
        if nu < _OBSERVED:
            limit = math.sqrt(variance + float(normal_quantile(level)) * error)
            result[component.name] = Estimate(value=None, upper_limit=limit, unit=units[t])
            continue
        low, high = variance_interval(variance, nu, level)
        result[component.name] = Estimate(
            value=math.sqrt(variance), low=math.sqrt(low), high=math.sqrt(high), unit=units[t]
        )
    return result
