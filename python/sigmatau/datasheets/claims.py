"""`Claim`: a number of a datasheet and its possible meanings.

A density may be one-sided (√2 times N) or two-sided (N); an "in-run bias stability" may be the minimum of the Allan
deviation or the coefficient B, 1/0.664 of a plateau. A number whose convention is not stated has two meanings, and a status
is decided only if both agree.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Any, Literal

from sigmatau.errors import OptionError
from sigmatau.noise.terms import TERMS, coefficient_unit, display_units
from sigmatau.units import find

Sided = Literal["one", "two"]
Bias = Literal["minimum", "coefficient"]

MINIMUM = "minimum"  # Name of the minimum of the Allan deviation in `Meaning.of`; other names are those of terms
KEYS = {
    "noise_density": "random_walk",
    "random_walk": "random_walk",
    "bias_instability": "bias_instability",
    "rate_random_walk": "rate_random_walk",
    "quantization": "quantization",
    "rate_ramp": "rate_ramp",
}
"""Keys of a datasheet and their terms."""

QUANTITIES = {"gyro": ("angular_rate", "rad/s"), "accel": ("acceleration", "m/s^2")}  # Quantity and SI unit by sensor


_NUMBER = re.compile(r"\s*[-+]?[\d.]+(?:[eE][-+]?\d+)?\s*")


@dataclass(frozen=True, slots=True, kw_only=True)
class Meaning:
    """An interpretation of a claim."""

    of: str  # A term, or `MINIMUM`: the quantity of the result to compare with
    factor: float  # Multiplies the number of the datasheet for the comparison
    words: str  # ``"one-sided"``; empty if there is only one interpretation


_ONE = Meaning(of="random_walk", factor=math.sqrt(0.5), words="one-sided")
_TWO = Meaning(of="random_walk", factor=1.0, words="two-sided")
_MINIMUM = Meaning(of=MINIMUM, factor=1.0, words="Allan minimum")
_COEFFICIENT = Meaning(of="bias_instability", factor=1.0, words="coefficient B")

_MEANINGS = {
    "noise_density": {"one": (_ONE,), "two": (_TWO,), "unknown": (_ONE, _TWO)},
    "bias_instability": {"minimum": (_MINIMUM,), "coefficient": (_COEFFICIENT,), "unknown": (_MINIMUM, _COEFFICIENT)},
}


def check_meanings(sided: str | None, bias: str | None) -> None:
    """Raise `OptionError` for an invalid convention."""
    if sided not in (None, "one", "two"):
        raise OptionError(f"{{option}} must be 'one' or 'two', not {sided!r}", option="sided")
    if bias not in (None, "minimum", "coefficient"):
        raise OptionError(f"{{option}} must be 'minimum' or 'coefficient', not {bias!r}", option="bias")


@dataclass(frozen=True, slots=True, kw_only=True)
class Claim:
    """Specification of one term of one sensor."""

    sensor: str  # ``"gyro"``, ``"accel"``, or one axis, ``"accel_z"``
    key: str  # One of `KEYS`
    typical: float | None = None  # Numbers of the datasheet in SI; at least one of them. [unit]
    maximum: float | None = None
    typical_text: str = ""  # The same in the unit of the datasheet
    maximum_text: str = ""
    # Noise density: ``"one"``, ``"two"`` (sided) or ``"unknown"``; bias instability: ``"minimum"`` (of the Allan
    # deviation), ``"coefficient"`` (B) or ``"unknown"``; else empty
    convention: str = ""
    note: str = ""  # Conditions, or the reason for the convention

    @property
    def term(self) -> str:
        """The term, a key of `sigmatau.noise.terms.TERMS`."""
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
        """Name: ``"noise density"``, ``"angle random walk"``."""
        return "noise density" if self.key == "noise_density" else TERMS[self.term].label(self.quantity)

    def display(self) -> tuple[str, float]:
        """Display unit, that of the typical value of the datasheet if there is one, and its factor to SI."""
        text = self.typical_text or self.maximum_text
        if text:
            unit = find(_NUMBER.sub("", text, count=1))
            return unit.text, unit.factor
        # A claim made by hand has no texts; accelerometer biases are in µg as in most datasheets.
        units = display_units(self.term, self.quantity, QUANTITIES[self.sensor.partition("_")[0]][1])
        return units[-1] if self.key == "bias_instability" else units[0]

    def meanings(self, *, sided: Sided | None = None, bias: Bias | None = None) -> tuple[Meaning, ...]:
        """The interpretations; two if neither the datasheet nor `sided` or `bias` states the convention."""
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
