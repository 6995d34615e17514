"""Noise components of an array: the terms and processes that the fits of its channels observed, and their densities."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import lru_cache

import numpy as np

from sigmatau import ChannelModel, GaussMarkov, NoiseFit
from sigmatau.arrays import Floats
from sigmatau.frozen import frozen
from sigmatau.noise.terms import NOISE, TERMS, coefficient_unit

# Ratio of correlation times below which Gauss-Markov processes of two channels count as one component. [1] Judgement: fits
# determine a correlation time to about this factor.
_SAME_TIME = 3.0
# Number of frequencies at which the effect of the ends of the record on flicker noise is integrated. Derived: above, its
# alternating part is below 1e-6 of the density.
_INTEGRATED = 16


@frozen
class Component:
    """A term, or a Gauss-Markov process of one correlation time.

    Attributes
    ----------
    name : str
        Key of `sigmatau.noise.terms.TERMS`, or ``"gauss_markov_1"`` …
    time : float or None
        Correlation time of a process. [s]
    """

    name: str
    time: float | None = None

    def label(self, quantity: str) -> str:
        """Name of the component for a kind of sensor.

        Parameters
        ----------
        quantity : str
            ``"angular_rate"``, ``"acceleration"`` or ``"signal"``.

        Returns
        -------
        str
        """
        if self.time is None:
            return TERMS[self.name].label(quantity)
        return f"Gauss-Markov, {self.time:.3g} s"


def component_model(component: Component, variance: float, *, quantity: str, unit: str) -> ChannelModel:
    """Build the model of a channel that has this component alone; `variance` is the square of its coefficient."""
    size = math.sqrt(variance)
    if component.time is None:
        return ChannelModel(terms={component.name: size}, quantity=quantity, unit=unit)
    process = GaussMarkov(sigma=size, time=component.time)
    return ChannelModel(terms={}, gauss_markov=(process,), quantity=quantity, unit=unit)


def component_unit(component: Component, quantity: str, unit: str) -> str:
    """SI unit of the coefficient of a component."""
    return unit if component.time is not None else coefficient_unit(component.name, quantity, unit)


def observed_components(fits: Mapping[str, NoiseFit]) -> tuple[Component, ...]:
    """Components that at least one of the fits observes, in the order of their slopes.

    Processes with similar times are combined. If a fit has terms of which one is present, but none is significant alone,
    the first of them is added, unless another fit observes one of them.
    """
    terms = {name for fit in fits.values() for name in fit.observed if name in NOISE}
    for fit in fits.values():
        unclear = [name for name in fit.unclear if name in NOISE]
        if unclear and not terms & {*unclear}:
            terms.add(unclear[0])
    times = sorted(process.time.value for fit in fits.values() for process in fit.gauss_markov)
    groups: list[list[float]] = []
    for time in times:
        if groups and time < _SAME_TIME * groups[-1][0]:
            groups[-1].append(time)
        else:
            groups.append([time])
    processes = [
        Component(name=f"gauss_markov_{k}", time=math.exp(float(np.mean(np.log(group)))))
        for k, group in enumerate(groups, 1)
    ]
    terms.add("random_walk")
    return (*(Component(name=name) for name in NOISE if name in terms), *processes)


def first_values(components: Sequence[Component], fits: Mapping[str, NoiseFit]) -> Floats:
    """Squares of the coefficients of the fits, shape (n_components, n_channels); a small value if a fit has none."""
    values = np.zeros((len(components), len(fits)))
    for t, component in enumerate(components):
        for i, fit in enumerate(fits.values()):
            values[t, i] = _fitted(component, fit) ** 2
    positive = np.where(values > 0, values, np.inf).min(axis=1, keepdims=True)
    return np.where(values > 0, values, 0.1 * np.where(np.isfinite(positive), positive, 1e-30))


def count_observed(component: Component, fits: Mapping[str, NoiseFit]) -> int:
    """Number of fits that observe a component."""
    if component.time is None:
        return sum(component.name in fit.observed for fit in fits.values())
    return sum(_fitted(component, fit) > 0 for fit in fits.values())


def _fitted(component: Component, fit: NoiseFit) -> float:
    if component.time is None:
        return abs(fit.model.get(component.name, 0.0))
    ratios = {abs(math.log(p.time.value / component.time)): p.sigma.value for p in fit.gauss_markov}
    nearest = min(ratios, default=math.inf)
    return ratios[nearest] if nearest < math.log(_SAME_TIME) else 0.0


def densities(components: Sequence[Component], samples: int, tau0: float) -> Floats:
    """Expected squares of the cosine transform for unit coefficients, shape (n_components, samples).

    They are exact for quantization noise, white noise and a rate random walk. For flicker noise and Gauss-Markov processes
    they include the effect of the ends of the record on the variance at each frequency; the small correlation of different
    frequencies is neglected.
    """
    return np.stack([_density(component.name, component.time, samples, tau0) for component in components])


@lru_cache(maxsize=16)
def _density(name: str, time: float | None, samples: int, tau0: float) -> Floats:
    k = np.arange(1, samples)
    frequency = k / (2 * samples * tau0)
    component = Component(name=name, time=time)
    density = component_model(component, 1.0, quantity="signal", unit="1").psd(frequency, tau0=tau0) / tau0
    if time is not None:
        a, length, omega = 1 / time, samples * tau0, 2 * np.pi * frequency
        ends = 1 - np.where(k % 2 == 0, 1.0, -1.0) * math.exp(-a * length)
        density = density * (1 - 2 * a * ends / (length * (a**2 + omega**2)))
    elif name == "quantization":  # exact: summation by parts, with the first and the last angle
        half = np.pi * k / (2 * samples)
        density = 4 * (np.sin(half) ** 2 + np.cos(half) ** 2 / samples) / tau0**2
    elif name == "bias_instability":
        density = density * _ends_of_flicker(k)
    result = np.concatenate([[0.0], density])
    result.setflags(write=False)
    return np.asarray(result)


def _ends_of_flicker(k: np.ndarray) -> Floats:
    """Ratio of the variance of the transform of flicker noise to its density.

    Flicker noise is a mixture of Gauss-Markov processes of all correlation times. The mean of the first part of their
    formula in `_density` is 1 − 2/(π²k); that of the second part is integrated numerically.
    """
    grid = np.geomspace(1e-6, 50.0, 4000)
    second = np.zeros(len(k))
    for number in k[k <= _INTEGRATED]:
        omega = np.pi * number
        integrand = 4 * grid * np.exp(-grid) / (grid**2 + omega**2) ** 2
        second[number - 1] = np.trapezoid(integrand, grid) * omega / np.pi
    sign = np.where(k % 2 == 0, 1.0, -1.0)
    return np.asarray(1 - 2 / (np.pi**2 * k) + sign * second)
