"""Results of a fit of a curve: names, units and verdicts."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray

from sigmatau._native.gls import CurveFit
from sigmatau.estimators.allan import DeviationCurve
from sigmatau.findings.reasons import Misfit, NoCovariance, Reason, ShortTimesDeviate
from sigmatau.fitting.fitted_values import FittedTerm
from sigmatau.fitting.from_native import fitted_covariance, fitted_terms, typed
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.noise.terms import TERMS, coefficient_unit


def stated(
    curve: DeviationCurve, fit: CurveFit, m: NDArray[np.int64], terms: Collection[str], level: float
) -> NoiseFit:
    """Build the result of a fit: intervals of the observed terms and upper limits of the others, or coefficients that only
    describe the curve.

    `terms`: the terms that were fitted.
    """
    tau_min = int(m[fit.first]) * curve.tau0

    values = dict(fit.model)
    described = {
        name: FittedTerm(
            term=name,
            unit=coefficient_unit(name, curve.quantity, curve.unit),
            observed=None,
            level=level,
            value=values.get(name),
        )
        for name in TERMS
        if name in terms
    }
    return typed(
        NoiseFit,
        fit,
        curve.unit,
        rate_unit=curve.unit,
        channel=curve.channel,
        quantity=curve.quantity,
        n=curve.n,
        tau0=curve.tau0,
        terms=fitted_terms(fit.terms, quantity=curve.quantity, rate_unit=curve.unit, level=level) or described,
        model=values,
        verdict="adequate" if fit.adequate else "descriptive",
        reasons=_reasons(curve, fit, m, tau_min),
        tau_min=tau_min,
        tau_max=int(m[-1]) * curve.tau0,
        p_value=fit.p_value if fit.adequate else None,
        covariance=fitted_covariance(fit),
        level=level,
    )


def _reasons(curve: DeviationCurve, fit: CurveFit, m: NDArray[np.int64], tau_min: float) -> tuple[Reason, ...]:
    """Why short averaging times were left out, or why no model is adequate."""
    if fit.no_covariance:
        return (NoCovariance(),)
    if fit.worst is None:
        return ()
    k, ratio = fit.worst
    if fit.adequate:
        return (ShortTimesDeviate(cluster_size=int(m[k]), ratio=ratio),)
    return (Misfit(p_value=fit.p_value, tau_min=tau_min, tau=float(m[k]) * curve.tau0, ratio=ratio),)


def no_fit(curve: DeviationCurve, level: float, reason: Reason) -> NoiseFit:
    """Build the result for a curve that cannot be fitted."""
    return NoiseFit(
        channel=curve.channel,
        quantity=curve.quantity,
        rate_unit=curve.unit,
        n=curve.n,
        tau0=curve.tau0,
        terms={},
        model={},
        verdict="too_short",
        reasons=(reason,),
        level=level,
    )
