"""Terms that a record did not show, and policies for models that must include all noise.

A fit gives an upper limit L for such a term. The three policies:

- ``"upper-limit"``: the coefficient is L, so that variances are too large in most cases;
- ``"mean"``: the coefficient is L/√3, its root mean square if every value from 0 to L is equally probable;
- ``"absent"``: the term is 0, so that variances are too small if it exists.

The policies apply to terms that accumulate in the integral of the rate. Quantization does not, and is treated as absent.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Literal, get_args

from sigmatau.errors import OptionError
from sigmatau.noise.terms import TERMS

if TYPE_CHECKING:
    from sigmatau.model.channel import ChannelModel
    from sigmatau.model.noise_model import NoiseModel

Unobserved = Literal["upper-limit", "mean", "absent"]

_ACCUMULATING = tuple(term for term in TERMS if term != "quantization")
_TEXTS = {
    "upper-limit": "included at the upper limit",
    "mean": "included with the mean variance, 1/sqrt(3) of the upper limit",
    "absent": "absent",
}
_FACTORS = {"upper-limit": 1.0, "mean": 1 / math.sqrt(3), "absent": 0.0}  # factors on the limit


def check_policy(policy: Unobserved) -> Unobserved:
    """The policy; raises `OptionError` for an unknown one."""
    if policy not in _FACTORS:
        raise OptionError(
            f"{{option}} must be {', '.join(map(repr, get_args(Unobserved)))}, not {policy!r}", option="unobserved"
        )
    return policy


def find_unobserved(model: ChannelModel) -> tuple[str, ...]:
    """The terms of a channel that have only an upper limit."""
    return tuple(term for term in _ACCUMULATING if term in model.limits and term not in model.terms)


def unobserved_text(terms: Sequence[str], policy: Unobserved) -> str:
    """Assumptions about terms that were not observed, for a result or a file."""
    labels = ", ".join(TERMS[term].label("signal") for term in terms)
    return f"not observed: {labels}; {_TEXTS[policy]}"


def unobserved_texts(model: NoiseModel, policy: Unobserved) -> tuple[str, ...]:
    """Assumptions about terms that were not observed: a line for each channel with such terms."""
    lacking = {name: find_unobserved(channel) for name, channel in model.channels.items()}
    return tuple(f"{name}: {unobserved_text(terms, policy)}" for name, terms in lacking.items() if terms)


def include_in_all(model: NoiseModel, policy: Unobserved) -> NoiseModel:
    """The model with all terms that have only a limit included according to the policy."""
    if policy == "absent":
        return model
    channels = {name: include_unobserved(channel, policy) for name, channel in model.channels.items()}
    return replace(model, channels=channels)


def include_unobserved(model: ChannelModel, policy: Unobserved) -> ChannelModel:
    """The model of a channel with the terms that have only a limit included according to the policy."""
    terms = assume_terms(model, policy)
    return model if terms == model.terms else replace(model, terms=terms)


def assume_terms(model: ChannelModel, policy: Unobserved) -> Mapping[str, float]:
    """Coefficients of a model, including those with only a limit; raises `OptionError` for an unknown policy. [SI]"""
    factor = _FACTORS[check_policy(policy)]
    assumed = {term: factor * model.limits[term] for term in find_unobserved(model)}
    terms = {**model.terms, **assumed}
    # In the order of the terms, as in every other model.
    return {term: terms[term] for term in TERMS if terms.get(term)}
