"""Terms that a record did not show: what a model that has to hold all noise assumes of them.

A fit gives an upper limit L for such a term. The three policies:

- ``"upper-limit"``: the coefficient is L, so that variances are too large in most cases;
- ``"mean"``: the coefficient is L/√3, the root of the mean of its square if every value from 0 to L is as probable;
- ``"absent"``: the term is 0, so that variances are too small if it exists.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Literal, get_args

from sigmatau.errors import OptionError
from sigmatau.model.channel import ChannelModel
from sigmatau.noise.terms import TERMS

Unobserved = Literal["upper-limit", "mean", "absent"]

_FACTORS = {"upper-limit": 1.0, "mean": 1 / math.sqrt(3), "absent": 0.0}  # of the limit


def include_unobserved(model: ChannelModel, policy: Unobserved) -> ChannelModel:
    """The model with the terms that have a limit only, as the policy assumes them."""
    terms = assume_terms(model, policy)
    return model if terms == model.terms else replace(model, terms=terms)


def assume_terms(model: ChannelModel, policy: Unobserved) -> Mapping[str, float]:
    """Coefficients of a model with those that have a limit only; raises `OptionError` for an unknown policy. [SI]"""
    if policy not in _FACTORS:
        raise OptionError(
            f"{{option}} must be {', '.join(map(repr, get_args(Unobserved)))}, not {policy!r}", option="unobserved"
        )
    assumed = {term: _FACTORS[policy] * limit for term, limit in model.limits.items() if term not in model.terms}
    terms = {**model.terms, **assumed}
    # In the order of the terms, as in every other model.
    return {term: terms[term] for term in TERMS if terms.get(term)}
