"""Fit of the covariance matrices of an array, with its coefficients, correlations and Allan covariances."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from sigmatau import NoiseFit
from sigmatau._native.distributions import chi2_above
from sigmatau.arrays import Floats
from sigmatau.frozen import frozen
from sigmatau.lab.arrays.codeviation import AllanCovariance, allan_covariances
from sigmatau.lab.arrays.components import Component, count_observed, densities
from sigmatau.lab.arrays.cosine_bands import gather_bands
from sigmatau.lab.arrays.covariance_fit import CovarianceFit, diagonal_structure, fit_covariance, full_structure
from sigmatau.lab.arrays.intervals import Correlation, Estimate, correlation_estimate, variance_estimate
from sigmatau.lab.arrays.virtual_sensor import mixed_terms
from sigmatau.noise.uncertainty import degrees_of_freedom

_FILTER_SHARE = (
    0.125  # highest frequency as a share of the corner of a filter, which lowers the density there by 1.5 % [1]
)
_RESONANCE_WIDTHS = 16.0  # part left out on each side of a resonance, in half widths, at most an octave [1]
_NOT_NEEDED = 0.05  # p-value above which a component of few channels is left out. [1] Judgement: the usual level
_FALSE_ALARMS = 0.05  # probability that independent sensors are called correlated. [1] Judgement: the usual level


@frozen
class Conditions:
    """Frequencies that a fit leaves out, and the regressors of the mean besides a constant and a ramp.

    Attributes
    ----------
    highest : float or None
        Highest frequency that is used. [Hz]
    lines : tuple of float
        Frequencies of lines. [Hz]
    resonances : tuple of (float, float)
        Bands of frequency that are left out, because a channel has a resonance there. [Hz]
    warm_up : tuple of float
        Time constants of drifts that decay exponentially from the first sample. [s]
    ramp : bool
        Whether a channel has a significant ramp.
    """

    highest: float | None = None
    lines: tuple[float, ...] = ()
    resonances: tuple[tuple[float, float], ...] = ()
    warm_up: tuple[float, ...] = ()
    ramp: bool = False


def find_conditions(fits: Mapping[str, NoiseFit]) -> Conditions:
    """Collect the frequencies to leave out, and the drifts, from the fits of the channels."""
    highest = [fit.highest for fit in fits.values() if fit.highest is not None]
    highest += [
        _FILTER_SHARE * fit.response.corner
        for fit in fits.values()
        if fit.response is not None and fit.response.corner is not None
    ]
    resonances = tuple(
        (
            max(peak.frequency.value - _RESONANCE_WIDTHS * peak.width.value, 0.5 * peak.frequency.value),
            min(peak.frequency.value + _RESONANCE_WIDTHS * peak.width.value, 2.0 * peak.frequency.value),
        )
        for fit in fits.values()
        for peak in fit.resonance
    )
    lines: list[float] = []
    for frequency in sorted(line.frequency.value for fit in fits.values() for line in fit.sinusoid):
        if not lines or frequency > 1.001 * lines[-1]:
            lines.append(frequency)
    warm = sorted({fit.warm_up.time for fit in fits.values() if fit.warm_up is not None})
    ramp = any("rate_ramp" in fit.observed for fit in fits.values())
    return Conditions(
        highest=min(highest, default=None), lines=tuple(lines), resonances=resonances, warm_up=tuple(warm), ramp=ramp
    )


def without_drifts(samples: Floats, tau0: float, conditions: Conditions) -> Floats:
    """Subtract the means, and the lines, drifts and ramps of the fits, by least squares."""
    n = samples.shape[1]
    time = (np.arange(n) + 0.5) * tau0
    curves = [np.ones(n), *(np.exp(-time / each) for each in conditions.warm_up)]
    curves += [time / (n * tau0) - 0.5] if conditions.ramp else []
    for frequency in conditions.lines:
        curves += [np.cos(2 * np.pi * frequency * time), np.sin(2 * np.pi * frequency * time)]
    shape = np.stack(curves, axis=1)
    return np.asarray(samples - (shape @ np.linalg.lstsq(shape, samples.T, rcond=None)[0]).T)


def fit_array(
    samples: Floats,
    tau0: float,
    components: Sequence[Component],
    first: Floats,
    *,
    common: bool,
    conditions: Conditions,
) -> CovarianceFit:
    """Fit the covariance matrices; with `common`, fit independent variances to the differences of the sensors.

    `samples`: shape (n, N); `first`: variances from which the fit starts, shape (n_components, n).
    """
    time = (np.arange(samples.shape[1]) + 0.5) * tau0
    regressors = [np.exp(-time / each) for each in conditions.warm_up]
    bands = gather_bands(
        samples,
        tau0,
        regressors=regressors,
        lines=conditions.lines,
        excluded=conditions.resonances,
        highest=conditions.highest,
    )
    shapes = densities(components, samples.shape[1], tau0)
    n = len(samples)
    if not common:
        return fit_covariance(bands, shapes, full_structure(n), first)
    contrasts = np.vstack([np.ones(n - 1), -np.eye(n - 1)])
    return fit_covariance(bands.combined(contrasts), shapes, diagonal_structure(contrasts), first)


def choose_components(
    samples: Floats,
    tau0: float,
    components: tuple[Component, ...],
    fits: Mapping[str, NoiseFit],
    first: Floats,
    *,
    common: bool,
    conditions: Conditions,
) -> tuple[tuple[Component, ...], Floats, CovarianceFit]:
    """Fit the array, and remove components that it does not need.

    A component is removed if fewer than half of the channels observe it and its likelihood ratio is not significant.
    """

    def fitted(chosen: list[int]) -> CovarianceFit:
        parts = [components[t] for t in chosen]
        return fit_array(samples, tau0, parts, first[chosen], common=common, conditions=conditions)

    chosen = list(range(len(components)))
    fit = fitted(chosen)
    for t, component in enumerate(components):
        if component.name == "random_walk" or 2 * count_observed(component, fits) >= len(fits):
            continue
        fewer = [k for k in chosen if k != t]
        smaller = fitted(fewer)
        gain = 2 * (fit.log_likelihood - smaller.log_likelihood)
        if float(chi2_above(fit.theta.shape[1], max(gain, 0.0))) > _NOT_NEEDED:
            chosen, fit = fewer, smaller
    return tuple(components[t] for t in chosen), first[chosen], fit


def estimate_coefficients(
    names: Sequence[str],
    fit: CovarianceFit,
    components: Sequence[Component],
    widening: float,
    level: float,
    units: Sequence[str],
) -> dict[str, dict[str, Estimate]]:
    """Coefficients with intervals or limits, by component and channel."""
    return {
        component.name: {
            name: variance_estimate(fit, t, i, level=level, widening=widening, unit=units[t])
            for i, name in enumerate(names)
        }
        for t, component in enumerate(components)
    }


def estimate_correlations(
    names: Sequence[str],
    fit: CovarianceFit,
    components: Sequence[Component],
    coefficients: Mapping[str, Mapping[str, Estimate]],
    widening: float,
    level: float,
) -> dict[str, dict[tuple[str, str], Correlation]]:
    """Correlations of all pairs and components; the correction for their number is that of Holm."""
    result: dict[str, dict[tuple[str, str], Correlation]] = {}
    for t, component in enumerate(components):
        observed = [coefficients[component.name][name].observed for name in names]
        result[component.name] = {
            (names[i], names[j]): correlation_estimate(fit, t, i, j, level=level, widening=widening)
            if observed[i] and observed[j]
            else Correlation(value=None, upper_limit=1.0)
            for i, j in combinations(range(len(names)), 2)
        }
    tested = sorted(
        (each.p_value, name, pair)
        for name, pairs in result.items()
        for pair, each in pairs.items()
        if each.p_value is not None
    )
    for k, (p_value, name, pair) in enumerate(tested):
        if p_value > _FALSE_ALARMS / (len(tested) - k):
            break
        result[name][pair] = replace(result[name][pair], correlated=True)
    return result


def measure_covariances(
    names: tuple[str, ...],
    samples: Floats,
    tau0: float,
    m: np.ndarray,
    fit: CovarianceFit,
    components: Sequence[Component],
    level: float,
) -> tuple[AllanCovariance, ...]:
    """Allan covariances of all pairs, with the degrees of freedom of the fitted noise."""
    full = fit.structure.semidefinite
    edf = []
    for i in range(len(names)):
        index = i * (i + 3) // 2 if full else i
        terms = mixed_terms(components, fit.theta[:, index])
        edf.append(degrees_of_freedom(terms, n=samples.shape[1], m=m, tau0=tau0))
    return allan_covariances(names, samples, tau0, m * tau0, np.stack(edf), level=level)
