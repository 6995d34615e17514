"""`Doubt`: the reason why a claim cannot be decided, or a restriction of a measured value, as data and in words."""

from __future__ import annotations

from typing import Literal

from sigmatau.frozen import frozen
from sigmatau.model import NOT_ADEQUATE, ONLY_LIMITS

DoubtKind = Literal[
    "not_in_result", "no_means", "no_interval", "processes", "no_bias_instability", "terms_at_limit", "not_adequate",
    "only_limits", "convention", "convention_of_typical",
]  # fmt: skip

_PROCESSES = "a Gauss-Markov process, a resonance or a sinusoid"
_BOUND = "so this is a lower bound"
_WORDS: dict[DoubtKind, str] = {
    "not_in_result": "not in the result",
    "no_means": "the result has no standard deviation of {average:g} s means",
    "no_interval": f"{_PROCESSES} without an interval determines the minimum",
    "processes": f"{_PROCESSES} adds to the minimum, {_BOUND}",
    "no_bias_instability": f"bias instability is not in the result, {_BOUND}",
    "terms_at_limit": "the upper end allows for {terms} at the limit",
    "not_adequate": NOT_ADEQUATE,
    "only_limits": ONLY_LIMITS,
    "convention": "the datasheet does not state the convention: {conventions}",
    "convention_of_typical": "the datasheet does not state the convention: {conventions}; a typical value fails no unit",
}


@frozen
class Doubt:
    """Reason why a claim cannot be decided, or a restriction of a measured value.

    Attributes
    ----------
    kind : str
        ``"not_in_result"``, ``"convention"`` …
    average : float
        For ``"no_means"``, the averaging time. [s]
    terms : tuple of str
        For ``"terms_at_limit"``, the terms that were not observed.
    conventions : tuple of str
        For ``"convention"``, the possible conventions.
    """

    kind: DoubtKind
    average: float = 0.0
    terms: tuple[str, ...] = ()
    conventions: tuple[str, ...] = ()

    @property
    def of_model(self) -> bool:
        """Whether no model fits the channel, so that no claim about it can be decided."""
        return self.kind in ("not_adequate", "only_limits")

    @property
    def words(self) -> str:
        """Text of the doubt."""
        terms = " and ".join(self.terms).replace("_", " ")
        return _WORDS[self.kind].format(average=self.average, terms=terms, conventions=" or ".join(self.conventions))
