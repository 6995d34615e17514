"""The floor of a fit: what is stated of a record that no model describes."""

from __future__ import annotations

import math
from dataclasses import replace
from statistics import NormalDist

from sigmatau.fitting.fitted_values import FittedTerm, Interval
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.model.parameters import Parameter

_WALK = "random_walk"
_WALK_PARAMETER = Parameter(_WALK)


def without_unknown_terms(fitted: NoiseFit) -> NoiseFit:
    """The fit with the interval of an observed random walk alone if p < 1e-6; any other term has no value and no limit.

    White noise dominates most of the band, and its interval allows for the misfit there. Behind a filter its density is that
    of a few frequencies: its interval then holds the largest discrepancy at any of them. The other terms are values of a
    wrong model, which stays as the description of the curve.
    """
    if not fitted.is_misfit:
        return fitted
    terms = {
        name: _walk(term, fitted) if name == _WALK and term.observed else _unknown(term)
        for name, term in fitted.terms.items()
    }
    observed = _WALK in terms and terms[_WALK].observed
    of_walk = fitted.covariance.select(lambda each: each if observed and each == _WALK_PARAMETER else None)
    return replace(
        fitted,
        terms=terms,
        gauss_markov=tuple(replace(one, sigma=_bare(one.sigma), time=_bare(one.time)) for one in fitted.gauss_markov),
        resonance=tuple(
            replace(one, sigma=_bare(one.sigma), frequency=_bare(one.frequency), width=_bare(one.width))
            for one in fitted.resonance
        ),
        alike_from=None,
        alike_sigma=None,
        second=(),
        unclear=(),
        covariance=replace(of_walk, matrix=of_walk.matrix * _behind_filter(fitted) ** 2),
    )


def _walk(term: FittedTerm, fitted: NoiseFit) -> FittedTerm:
    if term.low is None or term.high is None:
        return term
    factor = _behind_filter(fitted)
    return replace(term, low=term.low / factor, high=term.high * factor)


def _behind_filter(fitted: NoiseFit) -> float:
    """Factor by which the random walk may be larger or smaller than in its interval."""
    if fitted.response is None:
        return 1.0
    largest = max((deviation for _, deviation in fitted.discrepancy), default=0.0)
    return math.exp(NormalDist().inv_cdf(0.5 + fitted.level / 2) * largest / 2)  # half: of N, not of the density N²


def _unknown(term: FittedTerm) -> FittedTerm:
    return FittedTerm(term=term.term, unit=term.unit, observed=False, level=term.level)


def _bare(interval: Interval) -> Interval:
    return replace(interval, low=None, high=None)
