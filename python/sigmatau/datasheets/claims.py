"""One number of a datasheet, and what it may mean.

A density may be one-sided (√2 above N) or two-sided (N), an "in-run bias stability" the minimum of the Allan deviation or
the coefficient B, which is 1/0.664 of a plateau. What a sheet leaves open stays open here: such a number has two meanings,
and a verdict counts only if it is the same by both.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Any, Literal

from sigmatau.errors import OptionError
from sigmatau.noise.terms import TERMS, coefficient_unit, display_units
from sigmatau.units import find

__all__ = ["KEYS", "MINIMUM", "QUANTITIES", "Bias", "Claim", "Meaning", "Sided", "check_meanings"]

Sided = Literal["one", "two"]
Bias = Literal["minimum", "coefficient"]

MINIMUM = "minimum"
"""What is compared when a sheet states the minimum of the Allan deviation; every other such name is that of a term."""

KEYS = {
    "noise_density": "random_walk",
    "random_walk": "random_walk",
    "bias_instability": "bias_instability",
    "rate_random_walk": "rate_random_walk",
    "quantization": "quantization",
    "rate_ramp": "rate_ramp",
}
"""Keys of a sheet, with the term that each is about."""

QUANTITIES = {"gyro": ("angular_rate", "rad/s"), "accel": ("acceleration", "m/s^2")}
"""What each sensor measures, and its SI unit."""


_NUMBER = re.compile(r"\s*[-+]?[\d.]+(?:[eE][-+]?\d+)?\s*")


@dataclass(frozen=True, slots=True, kw_only=True)
class Meaning:
    """One way to understand a claim.

    Attributes
    ----------
    of : str
        A term, or `MINIMUM`: what of a result is compared.
    factor : float
        By which the sheet's number is multiplied to be comparable.
    words : str
        ``"one-sided"``; empty where there is only one way.
    """

    of: str
    factor: float
    words: str


_ONE = Meaning(of="random_walk", factor=math.sqrt(0.5), words="one-sided")
_TWO = Meaning(of="random_walk", factor=1.0, words="two-sided")
_MINIMUM = Meaning(of=MINIMUM, factor=1.0, words="Allan minimum")
_COEFFICIENT = Meaning(of="bias_instability", factor=1.0, words="coefficient B")

_MEANINGS = {
    "noise_density": {"one": (_ONE,), "two": (_TWO,), "unknown": (_ONE, _TWO)},
    "bias_instability": {
        "minimum": (_MINIMUM,),
        "coefficient": (_COEFFICIENT,),
        "unknown": (_MINIMUM, _COEFFICIENT),
    },
}


def check_meanings(sided: str | None, bias: str | None) -> None:
    """Raise `OptionError` unless both are what a sheet may leave open, or None."""
    if sided not in (None, "one", "two"):
        raise OptionError(f"{{option}} must be 'one' or 'two', not {sided!r}", option="sided")
    if bias not in (None, "minimum", "coefficient"):
        raise OptionError(f"{{option}} must be 'minimum' or 'coefficient', not {bias!r}", option="bias")


@dataclass(frozen=True, slots=True, kw_only=True)
class Claim:
    """What a sheet states of one term of one sensor.

    Attributes
    ----------
    sensor : str
        ``"gyro"``, ``"accel"``, or one axis, ``"accel_z"``.
    key : str
        One of `KEYS`.
    typical, maximum : float or None
        The sheet's numbers as they stand there, in SI; at least one of them. [unit]
    typical_text, maximum_text : str
        The same in the sheet's own unit.
    convention : str
        Of a noise density ``"one"``, ``"two"`` (sided) or ``"unknown"``; of a bias instability ``"minimum"`` (of the Allan
        deviation), ``"coefficient"`` (B) or ``"unknown"``; else empty.
    note : str
        Under which conditions, or why the convention is what it is.
    """

    sensor: str
    key: str
    typical: float | None = None
    maximum: float | None = None
    typical_text: str = ""
    maximum_text: str = ""
    convention: str = ""
    note: str = ""

    @property
    def term(self) -> str:
        """The term it is about, a key of `sigmatau.noise.terms.TERMS`."""
        return KEYS[self.key]

    @property
    def quantity(self) -> str:
        """``"angular_rate"`` or ``"acceleration"``."""
        return QUANTITIES[self.sensor.partition("_")[0]][0]

    @property
    def unit(self) -> str:
        """SI unit of `typical` and `maximum`."""
        return coefficient_unit(self.term, *QUANTITIES[self.sensor.partition("_")[0]])

    @property
    def label(self) -> str:
        """What it is called: ``"noise density"``, ``"angle random walk"``."""
        return "noise density" if self.key == "noise_density" else TERMS[self.term].label(self.quantity)

    def display(self) -> tuple[str, float]:
        """The unit in which it is printed, that of the sheet's typical value if there is one, and one such unit in SI."""
        text = self.typical_text or self.maximum_text
        if text:
            unit = find(_NUMBER.sub("", text, count=1))
            return unit.text, unit.factor
        # Without texts, as when a claim was made by hand; accelerometers' biases are in µg as in most sheets.
        units = display_units(self.term, self.quantity, QUANTITIES[self.sensor.partition("_")[0]][1])
        return units[-1] if self.key == "bias_instability" else units[0]

    def meanings(self, *, sided: Sided | None = None, bias: Bias | None = None) -> tuple[Meaning, ...]:
        """The ways to understand it; two where the sheet leaves it open and neither `sided` nor `bias` closes it."""
        if self.key not in _MEANINGS:
            return (Meaning(of=self.term, factor=1.0, words=""),)
        chosen = sided if self.key == "noise_density" else bias
        convention = chosen if self.convention == "unknown" and chosen is not None else self.convention
        return _MEANINGS[self.key][convention]

    def to_dict(self) -> dict[str, Any]:
        known = {"typical": self.typical, "maximum": self.maximum}
        return {
            "sensor": self.sensor,
            "key": self.key,
            "term": self.term,
            "unit": self.unit,
            **{name: value for name, value in known.items() if value is not None},
            **({"convention": self.convention} if self.convention else {}),
            **({"note": self.note} if self.note else {}),
        }
