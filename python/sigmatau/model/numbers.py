"""Effect of the errors of a fit on a model: derivatives with respect to parameters of processes, and the interval of
the Allan deviation.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from statistics import NormalDist
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from sigmatau._native import kernels
from sigmatau.arrays import Floats
from sigmatau.model.channel import ChannelModel
from sigmatau.model.parameters import Covariance, Parameter
from sigmatau.model.processes import Sinusoid

T = TypeVar("T")

_MIN_SHARE = 1e-6  # smallest share of the variance that an uncertain phase leaves
# largest relative difference of the variances of model and fit at `tau_min`: MAX_DIFFERENCE of described.rs
_SHAPE_ERROR = 0.02
_MIN_CHANGE = 1e-9  # smallest relative change of a frequency that exceeds rounding

_CHANGE = 1e-3  # relative change of a parameter of a process for its derivative


_DRAWS = 4096  # number of draws of the errors, for the largest deviation of the whole curve


def adev_interval(
    model: ChannelModel, *, m: ArrayLike, tau0: float, level: float = 0.95, simultaneous: bool = True
) -> tuple[Floats, Floats]:
    """Interval of the expected Allan deviation, from the errors of the model's parameters.

    Parameters
    ----------
    model : ChannelModel
        Model from a fit; without a covariance the interval is the value.
    m : array_like of int, shape (n_tau,)
    tau0 : float
        [s]
    level : float
    simultaneous : bool
        Whether `level` is the probability that the whole curve is inside; otherwise it applies to each averaging time.

    Returns
    -------
    low, high : ndarray, shape (n_tau,)
        The interval includes the other explanations of the record (`ChannelModel.alike_from`,
        `ChannelModel.alternatives`); `high` includes the terms that were not observed, at their limits. If the model
        describes the curve only from `tau_min` on, the interval includes its difference from the fit: 2 % of the
        variance at `tau_min`, less at longer times. [unit of the rate]
    """
    avar, parts = model.avar(m=m, tau0=tau0), model.avar_of_parts(m=m, tau0=tau0)
    parameters, covariance = model.covariance.parameters, model.covariance.matrix
    phases = _frequencies_of_lines(model)
    changed = changed_processes(model)
    gradient = np.zeros((len(parameters), len(avar)))
    for k, parameter in enumerate(parameters):
        if parameter in phases:
            continue  # treated below: with a phase uncertain by a turn, the variance is not linear in the frequency
        if parameter in changed:
            change = changed[parameter].avar(m=m, tau0=tau0) - parts[parameter.part]
            gradient[k] = change / difference_step(model, parameter)
        elif parameter.part in model:
            gradient[k] = 2 * parts[parameter.part] / model[parameter.part]
    # Independent errors of the logarithm, shape (parameters, n_tau); scaled, because the parameters differ by orders of
    # magnitude.
    scale = np.sqrt(np.diag(covariance))
    values, vectors = np.linalg.eigh(covariance / np.outer(scale, scale))
    errors = np.sqrt(np.maximum(values, 0.0))[:, None] * (vectors.T @ (gradient * scale[:, None])) / (2 * avar)
    spread = np.sqrt((errors**2).sum(axis=0))
    deviates = _quantile_of_largest(errors / np.where(spread > 0, spread, 1.0), level) if simultaneous else None
    wide = np.exp((deviates or NormalDist().inv_cdf(0.5 + level / 2)) * spread)
    low, high = np.sqrt(avar) / wide, np.sqrt(avar) * wide
    deviate = NormalDist().inv_cdf(0.5 + level / 2)
    for line, error in phases.values():
        smallest, largest = _avar_of_near_frequencies(line, deviate * error, m=m, tau0=tau0)
        plain = kernels.sinusoid_avar(line.amplitude, line.frequency, np.asarray(m), tau0)
        # As shares of the variance, so that the interval stays above 0.
        low = low * np.sqrt(np.maximum(1 - (plain - smallest) / avar, _MIN_SHARE))
        high = high * np.sqrt(1 + (largest - plain) / avar)
    for alternative in explanations(model)[1:]:
        if alternative.covariance.parameters:
            lower, higher = adev_interval(alternative, m=m, tau0=tau0, level=level, simultaneous=simultaneous)
        else:
            # The errors of this model are not known; the relative errors of the fitted model are used.
            alternative_adev = np.sqrt(alternative.avar(m=m, tau0=tau0))
            lower, higher = alternative_adev / wide, alternative_adev * wide
        low, high = np.minimum(low, lower), np.maximum(high, higher)
    absent = {term: limit for term, limit in model.limits.items() if term not in model and limit}
    if absent:
        high = np.sqrt(high**2 + ChannelModel(terms=absent).avar(m=m, tau0=tau0))
    # The fit may have a filter that the model lacks. Its share of the variance falls with the averaging time.
    times = np.asarray(m) * tau0
    shape = _SHAPE_ERROR * np.minimum(1.0, model.tau_min / times) if model.tau_min > tau0 else np.zeros(len(times))
    return low * np.sqrt(1 - shape), high * np.sqrt(1 + shape)


def _frequencies_of_lines(model: ChannelModel) -> dict[Parameter, tuple[Sinusoid, float]]:
    """The lines whose frequency has a known error, and the error [Hz], by the rows of the covariance."""
    lines = {}
    for parameter in model.covariance.parameters:
        if _is_phase(parameter) and parameter.number is not None and parameter.number <= len(model.sinusoid):
            variance = model.covariance.variance_of(parameter) or 0.0
            lines[parameter] = (model.sinusoid[parameter.number - 1], float(np.sqrt(variance)))
    return lines


def _avar_of_near_frequencies(line: Sinusoid, apart: float, *, m: ArrayLike, tau0: float) -> tuple[Floats, Floats]:
    """Smallest and largest Allan variance of a line with a frequency error up to `apart` [Hz]: sin⁴ over a range of
    phases.
    """
    sizes = np.asarray(m, dtype=np.float64)
    middle, half = line.frequency * sizes * tau0, apart * sizes * tau0  # turns of half a cycle
    ends = np.stack([np.sin(np.pi * (middle + side * half)) ** 2 for side in (-1, 1)])
    has_zero = np.floor(middle + half) > np.floor(middle - half)
    has_top = np.floor(middle + half - 0.5) > np.floor(middle - half - 0.5)
    smallest = np.where(has_zero, 0.0, ends.min(axis=0))
    largest = np.where(has_top, 1.0, ends.max(axis=0))
    scale = (line.amplitude / (sizes * np.sin(np.pi * line.frequency * tau0))) ** 2
    return scale * smallest**2, scale * largest**2


def _quantile_of_largest(directions: Floats, level: float) -> float:
    """Quantile of the largest absolute value over the curve of unit normal deviates with these directions."""
    draws = np.random.default_rng(0).standard_normal((_DRAWS, len(directions)))
    return float(np.quantile(np.abs(draws @ directions).max(axis=1), level))


def explanations(model: ChannelModel) -> list[ChannelModel]:
    """The model, and the models that explain its record equally well."""
    bare: dict[str, Any] = {
        "alike_from": None,
        "alternatives": (),
        "intervals": {},
        "covariance": Covariance(),
    }
    alternatives = [
        replace(
            model,
            terms=alternative.terms,
            gauss_markov=alternative.gauss_markov,
            bandwidth=model.bandwidth if "random_walk" in alternative.terms else None,
            **bare,
        )
        for alternative in model.alternatives
    ]
    return [model, *([] if model.alike_from is None else [without_walk(model)]), *alternatives]


def without_walk(model: ChannelModel) -> ChannelModel:
    """The model with the equivalent Gauss-Markov process (`alike_from`) in place of its rate random walk."""
    if model.alike_from is None:
        return model

    def drop_walk(values: Mapping[str, T]) -> dict[str, T]:
        return {term: value for term, value in values.items() if term != "rate_random_walk"}

    return replace(
        model,
        terms=drop_walk(model.terms),
        gauss_markov=(*model.gauss_markov, model.alike_from),
        intervals=drop_walk(model.intervals),
        limits=drop_walk(model.limits),
        alike_from=None,
    )


def changed_processes(model: ChannelModel) -> dict[Parameter, ChannelModel]:
    """The processes of a kind with one parameter increased by `difference_step`, for each parameter with a known
    error.
    """
    parts = model.parts()
    changed = {}
    for parameter in model.covariance.parameters:
        kind, number, quantity = parameter.part, parameter.number, parameter.quantity
        if number is None or quantity is None or not 1 <= number <= len(getattr(model, kind, ())):
            continue
        processes = list(getattr(model, kind))
        process = processes[number - 1]
        processes[number - 1] = replace(
            process, **{quantity: getattr(process, quantity) + difference_step(model, parameter)}
        )
        replaced: dict[str, Any] = {kind: tuple(processes)}
        changed[parameter] = replace(parts[kind], **replaced)
    return changed


def difference_step(model: ChannelModel, parameter: Parameter) -> float:
    """Change of a parameter of a process for a numerical derivative."""
    assert parameter.number is not None
    assert parameter.quantity is not None
    process = getattr(model, parameter.part)[parameter.number - 1]
    if _is_phase(parameter):
        variance = model.covariance.variance_of(parameter) or 0.0
        return float(max(_CHANGE * np.sqrt(variance), _MIN_CHANGE * process.frequency))
    return float(_CHANGE * getattr(process, "width" if parameter.quantity == "frequency" else parameter.quantity))


def _is_phase(parameter: Parameter) -> bool:
    return parameter.part == "sinusoid" and parameter.quantity == "frequency"
