"""Reduction of a fit that does not describe the record to the values that remain valid."""

from __future__ import annotations

import math
from statistics import NormalDist

from sigmatau.fitting.adjustment import Adjustment, Change, Ends
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.model.parameters import Parameter, Quantity


def misfit(fitted: NoiseFit) -> Adjustment | None:
    """If p < 1e-6, keep only the interval of an observed random walk. Other terms then have neither a value nor a limit.

    White noise dominates most of the band, and its interval allows for the misfit there. After a filter, only a few
    frequencies determine its density, so its interval then includes the largest discrepancy at any of these. The other
    terms belong to a wrong model, which only describes the curve.
    """
    if not fitted.is_misfit:
        return None
    factor, changes = _factor_after_filter(fitted), []
    for name, term in fitted.terms.items():
        before, parameter = Ends.of(term), Parameter(name)
        if name != "random_walk" or not term.observed:
            changes.append(Change.limiting(parameter, term))
        elif before.low is not None and before.high is not None:
            after = Ends(before.low / factor, before.high * factor, before.upper_limit)
            changes.append(Change(parameter, "widen", before, after, factor))
    numbers: tuple[tuple[str, tuple[Quantity, ...]], ...] = (
        ("gauss_markov", ("sigma", "time")),
        ("resonance", ("sigma", "frequency", "width")),
        ("sinusoid", ("amplitude", "frequency")),
    )
    line_parameters = {parameter for parameter in fitted.covariance.parameters if parameter.part == "sinusoid"}
    changes += [
        Change.limiting(Parameter(kind, k, number), getattr(process, number))
        for kind, quantities in numbers
        for k, process in enumerate(getattr(fitted, kind), 1)
        for number in quantities
        if kind != "sinusoid" or Parameter(kind, k, number) in line_parameters
    ]
    return Adjustment(
        cause="misfit",
        findings=("widened",),
        changes=tuple(changes),
        without=("alike_from", "alike_sigma", "second", "unclear"),
    )


def _factor_after_filter(fitted: NoiseFit) -> float:
    """Factor by which the random walk may lie outside its interval."""
    if fitted.response is None:
        return 1.0
    largest = max((deviation for _, deviation in fitted.discrepancy), default=0.0)
    # half, because the factor applies to N and not to the density N²
    return math.exp(NormalDist().inv_cdf(0.5 + fitted.level / 2) * largest / 2)
