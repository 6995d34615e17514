"""Convert fits of the compiled core, which has no units, to the types of the package. Fields have the same names in both."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import fields
from typing import Any, TypeVar

import numpy as np

from sigmatau._native.gls import CurveFit
from sigmatau._native.likelihood import (
    ChannelFit,
    Estimate,
    GaussMarkovEstimate,
    LineEstimate,
    ResonanceEstimate,
    TermEstimate,
    WarmUpEstimate,
)
from sigmatau.fitting.fitted_values import (
    FittedGaussMarkov,
    FittedResonance,
    FittedSinusoid,
    FittedTerm,
    FittedWarmUp,
    Interval,
)
from sigmatau.model.parameters import Covariance, Parameter
from sigmatau.noise.terms import coefficient_units

_T = TypeVar("_T")

_TYPES: dict[type, type] = {
    GaussMarkovEstimate: FittedGaussMarkov,
    LineEstimate: FittedSinusoid,
    ResonanceEstimate: FittedResonance,
    WarmUpEstimate: FittedWarmUp,
}
"""Type of the package for each type of the core."""

_ABSENT = object()


def typed(kind: type[_T], native: object, rate_unit: str, /, **stated: object) -> _T:
    """Build a value of the package from one of the core.

    Parameters
    ----------
    kind : type
        A dataclass. Fields that are not in `stated` are filled from the attributes of `native` with the same name, if it
        has them.
    native : object
        The value of the core.
    rate_unit : str
        Unit of the intervals; a field may name another unit in its metadata.
    **stated
        Values of fields that are not taken from `native`.
    """
    for each in fields(kind):  # type: ignore[arg-type]
        if each.name not in stated and (value := getattr(native, each.name, _ABSENT)) is not _ABSENT:
            stated[each.name] = _converted(value, each.metadata.get("unit", rate_unit), rate_unit)
    return kind(**stated)


def _converted(value: Any, unit: str, rate_unit: str) -> object:  # noqa: ANN401  any value of the core
    if isinstance(value, list):
        return tuple(_converted(each, unit, rate_unit) for each in value)
    if isinstance(value, Estimate):
        return interval_with_unit(value, unit)
    kind = _TYPES.get(type(value))
    return value if kind is None else typed(kind, value, rate_unit)


def interval_with_unit(estimate: Estimate, unit: str) -> Interval:
    """Attach a unit to an estimate of the core."""
    return Interval(value=estimate.value, low=estimate.low, high=estimate.high, unit=unit)


def fitted_covariance(fit: ChannelFit | CurveFit) -> Covariance:
    """The covariance of a fit."""
    rows = tuple(typed(Parameter, row, "") for row in fit.parameters)
    return Covariance(parameters=rows, matrix=np.array(fit.covariance).reshape((len(rows),) * 2))


def fitted_terms(
    terms: Iterable[tuple[str, TermEstimate]], *, quantity: str, rate_unit: str, level: float
) -> dict[str, FittedTerm]:
    """Convert the terms of a fit, with their units."""
    units = coefficient_units(quantity, rate_unit)
    return {
        name: typed(
            FittedTerm,
            term,
            rate_unit,
            term=name,
            unit=units[name],
            level=level,
        )
        for name, term in terms
    }
