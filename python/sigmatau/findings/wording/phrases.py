"""Phrases that the words of findings share: names of axes, times, shares, factors."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from sigmatau.noise.terms import TERMS
from sigmatau.results import seconds

__all__ = ["Words", "axes_text", "clock", "factor_text", "factors_text", "largest_factor_text", "percent"]


class Words(NamedTuple):
    """What a finding says.

    Attributes
    ----------
    message : str
        One sentence without a full stop: what was found, where, what it changes.
    action : str
        One sentence without a full stop: what to do; empty if there is nothing to do.
    """

    message: str
    action: str = ""


def axes_text(channels: Sequence[str]) -> str:
    """``"gyro_x, gyro_y and gyro_z"``."""
    return channels[0] if len(channels) == 1 else f"{', '.join(channels[:-1])} and {channels[-1]}"


def clock(time: float) -> str:
    """A time from the beginning of the record: ``"12.34 s"``, ``"2400 s"``."""
    return f"{time:.4g} s" if time < 1000 else f"{time:.0f} s"


def percent(share: float) -> str:
    """A share with two digits: ``"3.8 %"``, ``"42 %"``."""
    return f"{100 * share:.2g} %" if share < 0.995 else f"{100 * share:.0f} %"


def factor_text(term: str, factor: float, *, quantity: str = "") -> str:
    """A factor on a coefficient: ``"random walk 3.8 % larger"``, ``"random walk 4.1 times larger"``."""
    label = TERMS[term].label(quantity) if term in TERMS else term
    off = abs(factor - 1)
    if not math.isfinite(factor):
        return f"{label} unknown"
    if off < 0.2:
        return f"{label} {100 * off:.2g} % {'larger' if factor > 1 else 'smaller'}"
    if factor > 1:
        return f"{label} {factor:.3g} times as large"
    return f"{label} {1 / factor:.3g} times smaller" if factor > 0 else f"{label} hidden"


def factors_text(factors: Sequence[tuple[str, float]], *, quantity: str = "", tau: float | None = None) -> str:
    """Factors on several coefficients, joined; with the averaging time at which they hold, if there is one."""
    said = " and ".join(factor_text(term, factor, quantity=quantity) for term, factor in factors)
    return f"{said} at τ = {seconds(tau)} s" if said and tau is not None else said


def largest_factor_text(factors: Sequence[tuple[str, float]], *, quantity: str = "", channel: str = "") -> str:
    """The factor farthest from 1, with the channel that it is of, if one is named; empty without factors."""
    if not factors:
        return ""
    term, factor = max(factors, key=lambda one: abs(math.log(one[1])) if 0 < one[1] < math.inf else math.inf)
    said = "no coefficient changed" if abs(factor - 1) < 5e-4 else factor_text(term, factor, quantity=quantity)
    return f"{said} on {channel}" if channel else said
